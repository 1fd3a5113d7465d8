// plumb bake: what irradiance probes know of a scene before there is light in it, in one file.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>

#include "core/error.h"
#include "gi/frame/probe_bake.h"
#include "gi/frame/settings.h"
#include "gi/probes/debug_layers.h"
#include "gi/probes/memory.h"
#include "gi/probes/sky_probe.h"
#include "gi/probes/static_scene.h"
#include "io/file.h"
#include "io/image_file.h"
#include "tools/plumb/bake_sh.h"
#include "tools/plumb/cli.h"
#include "tools/plumb/graph_page.h"
#include "tools/shared/bake_file.h"
#include "tools/shared/bake_progress.h"
#include "tools/shared/bake_textures.h"
#include "tools/shared/file_store.h"
#include "tools/shared/output_place.h"
#include "tools/shared/outputs.h"
#include "tools/shared/probe_bake.h"
#include "tools/shared/process_memory.h"
#include "tools/shared/progress.h"
#include "tools/shared/reports.h"
#include "tools/shared/scene_command.h"
#include "tools/shared/table.h"

namespace plumb::cli {

namespace {

struct BakeOptions {
    SceneOptions scene;
    Common common;
    std::string file, part, verified, layers, textures, html, store;
    bool join = false, resume = false, no_cache = false, with_alpha = false;
    double memory_gb = 0;
    ShOptions sh;
};

int number_of(const std::string& text, const std::string& name, const std::string& expected) {
    const bool digits = !text.empty() && text.size() < 8 && text.find_first_not_of("0123456789") == std::string::npos;
    if (!digits) throw InputError(fmt::format("{} {}: expected {}", name, io::printable(text), expected));
    return std::stoi(text);
}
int number_of_environment(const char* name, int otherwise) {
    const char* text = std::getenv(name);
    return text ? number_of(text, name, "a whole number") : otherwise;
}

// What a launcher of many processes tells each: its rank, from 0, and how many there are. An element of an array of SLURM has a
// rank of its own job as well: the array's counts.
probes::Part part_of_launcher() {
    if (std::getenv("SLURM_ARRAY_TASK_ID") && std::getenv("SLURM_ARRAY_TASK_COUNT")) {
        const int first = number_of_environment("SLURM_ARRAY_TASK_MIN", 0), step = number_of_environment("SLURM_ARRAY_TASK_STEP", 1);
        return {(number_of_environment("SLURM_ARRAY_TASK_ID", 0) - first) / std::max(1, step),
                number_of_environment("SLURM_ARRAY_TASK_COUNT", 1)};
    }
    static const char* const names[][2] = {{"OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"},
                                           {"PMI_RANK", "PMI_SIZE"},
                                           {"SLURM_PROCID", "SLURM_NTASKS"}};
    for (const auto& [rank, size] : names)
        if (std::getenv(rank) && std::getenv(size)) return {number_of_environment(rank, 0), number_of_environment(size, 1)};
    throw InputError("--part launcher: no launcher tells a rank (SLURM_ARRAY_TASK_ID, OMPI_COMM_WORLD_RANK, PMI_RANK, SLURM_PROCID)");
}

probes::Part part_of(const std::string& text) {
    if (text.empty()) return {};
    if (text == "launcher") return part_of_launcher();
    const std::size_t slash = text.find('/');
    if (slash == std::string::npos) throw InputError("--part " + io::printable(text) + ": expected I/N, 2/4 say, or 'launcher'");
    const std::string expected = "I/N, 2/4 say, or 'launcher'";
    return {number_of(text.substr(0, slash), "--part", expected) - 1, number_of(text.substr(slash + 1), "--part", expected)};
}

std::uint8_t byte_of(float x) { return std::uint8_t(255 * std::clamp(x, 0.0f, 1.0f) + 0.5f); }

std::vector<probes::DebugLayer> layers_of(const probes::BakeGraph& graph, const Scene& scene, const RunOptions& options) {
    probes::DebugView view;
    view.size = scene.frame_size;
    view.view = make_view(scene.camera, double(view.size.x) / view.size.y);
    return probes::debug_layers(graph.bake(), graph.surfaces(), view, options);
}

void write_layers(const std::vector<probes::DebugLayer>& layers, Outputs& outputs) {
    std::string legend;
    for (const probes::DebugLayer& layer : layers) {
        const Image4& p = layer.picture;
        std::vector<std::uint8_t> rgb;
        for (const glm::vec4& t : p.texels)
            for (int c = 0; c < 3; ++c) rgb.push_back(byte_of(t[c]));
        outputs.write(layer.name + ".png", [&](const std::string& path) { io::write_png(path, p.width, p.height, rgb.data()); });
        legend += fmt::format("{}.png: {}: {}\n", layer.name, layer.node, layer.meaning);
    }
    outputs.write("README.txt", [&](const std::string& path) { io::write_text(path, legend); });
}

std::string page_of(const std::string& title, const std::vector<graph::NodeRun>& runs,
                    const std::vector<probes::DebugLayer>& layers) {
    std::vector<GraphNode> nodes;
    for (const graph::NodeRun& run : runs) {
        GraphNode n;
        n.plan.name = n.plan.label = run.label;
        n.run = run;
        for (const probes::DebugLayer& layer : layers)
            if (step_of(run.label) == layer.node && (&run == &runs.back() || step_of((&run)[1].label) != layer.node))
                n.figures.push_back({layer.picture, layer.name + ": " + layer.meaning});
        nodes.push_back(std::move(n));
    }
    for (const GraphNode& reader : nodes)
        for (const std::string& read : reader.run.reads)
            for (GraphNode& n : nodes)
                if (n.run.label == read) n.read_until = reader.run.label;
    return graph_page("plumb bake, " + title, nodes);
}

// Rows of a table: blocks of a step are summed up.
std::string report_text(const std::vector<graph::NodeRun>& runs) {
    std::vector<std::vector<std::string>> rows;
    for (std::size_t i = 0; i < runs.size();) {
        const std::string step = step_of(runs[i].label);
        double ms = 0;
        std::size_t bytes = 0, first = i, kept = 0;
        for (; i < runs.size() && step_of(runs[i].label) == step; ++i)
            ms += runs[i].ms, bytes += runs[i].bytes, kept += runs[i].kept ? 1 : 0;
        const std::string came = is_block(runs[first].label) ? fmt::format("{} blocks, {} of them kept", i - first, kept)
                                                             : runs[first].reason;
        rows.push_back({step, milliseconds_text(ms), megabytes_text(bytes), came});
    }
    return format_table({{"step"}, {"ms", Align::right}, {"MB", Align::right}, {"what came of it"}}, rows);
}

// `memory` was made before the scene was read.
Json report_json(const probes::BakeGraph& graph, const std::vector<graph::NodeRun>& runs, bool whole, const MemoryPeak& memory) {
    const probes::Bake& b = graph.bake();
    const probes::RayCounts counts = b.counts();
    Json json = {{"version", 1},
                 {"receivers", b.receivers.count()},
                 {"moved", b.shifted},
                 {"receivers_without_probe", b.supports.unsupported},
                 {"probes", probes::standing_probes(b.placement.probes)},
                 {"probe_radius_m", b.radius.radius_m},
                 {"lightmap", {b.atlas.size.x, b.atlas.size.y}},
                 {"clusters", b.clusters.clusters.size()},
                 {"rays", {{"traced", counts.traced}, {"escaped", counts.escaped}, {"to_backs", counts.back}, {"unseen", counts.unseen}}},
                 {"seconds_of_rays", graph.seconds_of_rays()},
                 {"bytes_needed", graph.bytes()},
                 {"peak_bytes", memory.peak_bytes().value_or(0)}};
    if (whole) json["black_receivers"] = black_receivers(b);
    json["steps"] = stage_runs_json(runs);
    return json;
}

// Reads all of a file, and lists what it holds.
int verify(const BakeOptions& given) {
    if (!given.file.empty() || !given.part.empty() || !given.layers.empty() || !given.textures.empty() || !given.html.empty() ||
        !given.scene.sets.empty() || !given.sh.file.empty())
        throw InputError("bake: --verify reads a file and bakes nothing: not with other options");
    const Scene scene = load(given.scene);
    const io::DescribedFile file = io::read_described(given.verified, bake_kind);
    io::require_scene(file, probes::scene_hash(scene), scene.name);
    check_bake(file);
    check_sky(file, scene);
    std::vector<std::vector<std::string>> rows;
    Json arrays = Json::array();
    for (std::size_t i = 0; i < file.arrays.arrays.size(); ++i) {
        const Array& a = file.arrays.arrays[i];
        const io::Description& d = file.descriptions[i];
        rows.push_back({a.name, dtype_name(a.dtype), shape_text(a.shape), d.unit, d.meaning});
        arrays.push_back({{"name", a.name}, {"type", dtype_name(a.dtype)}, {"shape", a.shape}, {"unit", d.unit}, {"meaning", d.meaning}});
    }
    if (given.common.json)
        std::fputs(json_text({{"version", 1}, {"file_version", file.version}, {"arrays", arrays}}).c_str(), stdout);
    else
        std::fputs(format_table({{"array"}, {"type"}, {"shape"}, {"unit"}, {"meaning"}}, rows).c_str(), stdout);
    return success;
}

// What options ask for must be possible before anything is computed.
void check_options(const BakeOptions& given) {
    if (given.part.empty() == given.file.empty())
        throw InputError(given.file.empty() ? "bake: expected -o FILE, or --part I/N"
                                            : "bake: a part writes no file: expected -o FILE or --part, not both");
    if (given.join && !given.part.empty()) throw InputError("bake: expected --join or --part, not both");
    if (given.no_cache && (given.join || given.resume || !given.part.empty()))
        throw InputError("bake: --join, --resume and --part go through the store: not with --no-cache");
    if (!given.part.empty() && (!given.layers.empty() || !given.textures.empty() || !given.html.empty() || given.with_alpha))
        throw InputError("bake: a part has no clusters: --debug-layers, --textures, --html and --with-alpha are for the whole");
    check_sh(given.sh, !given.part.empty());
    namespace fs = std::filesystem;
    std::set<std::string> names;
    for (const std::string& file : {given.file, given.html, given.sh.file}) {
        if (file.empty()) continue;
        const std::string parent = io::folder_of(file);
        std::error_code error;
        if (fs::is_directory(file, error)) throw InputError(io::shown(file), "", "is a folder");
        if (!parent.empty() && !fs::is_directory(parent, error))
            throw InputError(io::shown(file), "", "cannot be written: there is no folder of that name");
        if (fs::equivalent(file, given.scene.file, error)) throw InputError(io::shown(file), "", "is the scene");
        if (!names.insert(fs::weakly_canonical(file, error).string()).second)
            throw InputError(io::shown(file), "", "is asked for twice");
        require_place(file);
    }
    for (const std::string& folder : {given.layers, given.textures})
        if (!folder.empty()) Outputs{folder};  // made, and removed
}

// A part is nothing but what it leaves in the store; one that was named has to be there.
void check_store(const std::string& folder) {
    io::make_folder(folder);
    const std::string probe = folder + "/part.writable";
    io::write_text(probe, "");
    std::filesystem::remove(probe);
}

std::string share_text(std::uint64_t part, std::uint64_t whole) {
    return fmt::format("{:.1f} %", whole > 0 ? 100 * double(part) / double(whole) : 0.0);
}

// What its user has to know of it.
std::vector<std::string> remarks(const probes::Bake& b) {
    const probes::RayCounts counts = b.counts();
    const std::uint64_t rays = std::uint64_t(b.receivers.count()) * std::uint64_t(b.transport.rays);
    std::vector<std::string> lines = {fmt::format("of receivers' rays {} escaped, {} met backs, {} what no probe sees",
                                                  share_text(counts.escaped, rays), share_text(counts.back, rays),
                                                  share_text(counts.unseen, rays))};
    const int black = probes::black_receivers(b);
    if (black > 0)
        lines.push_back(fmt::format("{} of {} receivers stay black: no probe sees what they see{}", black, b.receivers.count(),
                                    20 * black > b.receivers.count() && counts.unseen > 0 ? "; more probes (probes.count) may" : ""));
    return lines;
}

int bake(const BakeOptions& given) {
    if (!given.verified.empty()) return verify(given);
    const RunOptions options = given.common.run_options();
    const probes::Part part = part_of(given.part);
    check_options(given);
    require_baked(given.scene.sets, {"probes"}, "plumb bake");
    const MemoryPeak memory_taken;
    const Scene scene = load(given.scene);
    const frame::Settings settings = settings_of(scene, given.scene);
    check_sh_degree(given.sh, settings.probes.degree);
    const std::uint64_t memory = given.memory_gb > 0 ? std::uint64_t(given.memory_gb * 1e9) : memory_there();
    probes::BakeGraph graph(scene, frame::bake_params(scene, settings), part, memory);
    std::unique_ptr<FileStore> store;
    const std::string folder = given.no_cache ? "" : given.store.empty() ? cache_folder() : given.store;
    if (!folder.empty()) {
        store = std::make_unique<FileStore>(folder, "bake", FileStore::Limits{.max_bytes = std::uint64_t(16) << 30, .made = "baked"});
        store->pin();
        if (!given.part.empty() || !given.store.empty()) check_store(folder);
    }
    if (!given.common.json)
        graph.when_sized([&](std::uint64_t bytes) {
            const probes::Bake& b = graph.bake();
            fmt::print("{} receivers, {} probes, at most {:.1f} million rays; at most {} of memory\n", b.receivers.count(),
                       probes::standing_probes(b.placement.probes),
                       double(b.receivers.count()) * b.transport.rays * (1 + b.supports.overlaps) / 1e6, probes::size_text(bytes));
            std::fflush(stdout);
        });
    graph::RunWith with;
    with.options = options, with.store = store.get();
    std::vector<graph::NodeRun> runs;
    {
        BakeProgress progress(graph);
        with.progress = progress.callback();
        runs = run_bake(graph, scene, with);
    }
    if (!given.part.empty() && !store->notes().empty()) throw InputError("--part " + given.part + ": " + store->notes().front());
    std::vector<std::string> written;
    if (!given.file.empty())
        io::write_described(given.file, bake_file(graph.bake(), scene.name, given.with_alpha)), written.push_back(given.file);
    const std::vector<probes::DebugLayer> layers =
        given.layers.empty() && given.html.empty() ? std::vector<probes::DebugLayer>{} : layers_of(graph, scene, options);
    if (!given.layers.empty()) {
        Outputs outputs(given.layers);
        write_layers(layers, outputs);
        outputs.commit();
        written.push_back(given.layers);
    }
    if (!given.textures.empty()) {
        Outputs outputs(given.textures);
        write_textures(graph.bake(), outputs);
        outputs.commit();
        written.push_back(given.textures);
    }
    if (!given.html.empty()) io::write_text(given.html, page_of(scene.name, runs, layers)), written.push_back(given.html);
    write_sh(given.sh, graph.bake(), scene, options);
    if (!given.sh.file.empty()) written.push_back(given.sh.file);
    if (given.common.json) {
        std::fputs(json_text(report_json(graph, runs, given.part.empty(), memory_taken)).c_str(), stdout);
        return success;
    }
    print_notes(scene);
    std::fputs(report_text(runs).c_str(), stdout);
    const auto kept = std::count_if(runs.begin(), runs.end(), [](const graph::NodeRun& r) { return r.kept && is_block(r.label); });
    const auto blocks = std::count_if(runs.begin(), runs.end(), [](const graph::NodeRun& r) { return is_block(r.label); });
    if (given.part.empty())
        for (const std::string& line : remarks(graph.bake())) fmt::print("{}\n", line);
    if (given.resume && kept == 0) fmt::print("note: nothing of this bake was kept: it was begun anew\n");
    if (given.join && kept < blocks)
        fmt::print("note: {} of {} blocks were not in the store (parts that have not run, other settings, another build of plumb), "
                   "and were made here\n", blocks - kept, blocks);
    if (store)
        for (const std::string& note : store->notes()) fmt::print("note: {}\n", note);
    for (const std::string& path : written) fmt::print("wrote {}\n", io::shown(path));
    return success;
}

}  // namespace

void add_bake(CLI::App& program, Action& action) {
    auto given = std::make_shared<BakeOptions>();
    CLI::App* command = program.add_subcommand("bake", "compute what irradiance probes know of a scene, into one file");
    command->add_option("scene", given->scene.file, "the scene: .toml, or a bare .obj, .gltf or .glb")->required()->type_name("SCENE");
    command->add_option("-o,--output", given->file, "the bake")->check(some_word())->type_name("FILE");
    command->add_option("--set", given->scene.sets, "probes.key=value in place of the scene file's; may be repeated")
        ->allow_extra_args(false)
        ->type_name("T.K=V");
    command->add_option("--part", given->part, "compute part I of N into the store, and no file; or 'launcher': as its rank says")
        ->check(some_word())
        ->type_name("I/N");
    command->add_flag("--join", given->join, "make the file of parts in the store; what is missing is made here");
    command->add_flag("--resume", given->resume, "go on with a bake that was stopped (the store is read anyway); says where there is none");
    command->add_option("--store", given->store, "folder of what is kept; the user's cache otherwise")->check(some_word())->type_name("DIR");
    command->add_flag("--no-cache", given->no_cache, "compute even what is kept, and keep nothing");
    command->add_option("--verify", given->verified, "bake nothing; list what the file holds, if it is whole and of this scene")
        ->check(some_word())
        ->type_name("FILE");
    command->add_flag("--with-alpha", given->with_alpha, "also write the transport as it is before it is compressed");
    command->add_option("--debug-layers", given->layers, "a picture of every step")->check(some_word())->type_name("DIR");
    command->add_option("--textures", given->textures, "the data textures of a GPU, raw and as .npy")->check(some_word())->type_name("DIR");
    command->add_option("--html", given->html, "a page that draws the steps; a click on one shows what it made")->type_name("FILE");
    add_sh_options(*command, given->sh);
    command->add_option("--memory", given->memory_gb, "GB that it may need; what the system has otherwise")
        ->check(number_within(1e-6, 1e6))
        ->type_name("GB");
    add_common(*command, given->common);
    command->footer(
        "What takes long is kept in the store block by block: a bake that was stopped goes on where it was. Parts may run on\n"
        "several machines that share a folder, and the file has the same bytes:\n"
        "  mpirun -np 4 plumb bake box.toml --part launcher --store shared\n"
        "  plumb bake box.toml --join --store shared -o box.bake");
    command->callback([given, &action] { action = [=] { return bake(*given); }; });
}

}  // namespace plumb::cli
