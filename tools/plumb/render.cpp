// plumb render: a scene goes in; pictures, times and memory come out.
#include <fmt/format.h>
#include <sys/resource.h>

#include <chrono>
#include <memory>
#include <optional>
#include <nlohmann/json.hpp>

#include "core/animation.h"
#include "core/error.h"
#include "gi/frame/kept.h"
#include "io/file.h"
#include "tools/plumb/cli.h"
#include "tools/plumb/coloured_meshes.h"
#include "tools/plumb/frames.h"
#include "tools/plumb/pictures.h"
#include "tools/plumb/sweep_choose.h"
#include "tools/shared/file_store.h"
#include "tools/shared/light_costs.h"
#include "tools/shared/output_place.h"
#include "tools/shared/outputs.h"
#include "tools/shared/probe_bake.h"
#include "tools/shared/progress.h"
#include "tools/shared/radiosity_report.h"
#include "tools/shared/reference_files.h"
#include "tools/shared/reports.h"
#include "tools/shared/scene_command.h"
#include "tools/shared/truth.h"

namespace plumb::cli {

namespace {

// scene_at(), whose errors then name the file.
Scene posed(Scene scene, double frame) {
    const std::string name = scene.name;
    try {
        return scene_at(std::move(scene), frame);
    } catch (const InputError& e) {
        throw InputError(name + ": " + e.what());
    }
}

struct RenderOptions {
    SceneOptions scene;
    Common common;
    std::string folder = "out", budget, mesh;
    bool dump = false;
    int frames = 0;  // 0: one picture, without a number
    int first = 0;
};

std::size_t peak_bytes() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return std::size_t(usage.ru_maxrss) * 1024;
}

using Clock = std::chrono::steady_clock;
double ms_since(Clock::time_point start) {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

// What is rendered, how, and where to.
struct Job {
    const RenderOptions& given;
    Clock::time_point start;
    RunTimes times;
    Scene scene;
    frame::Settings settings;
    Json chosen;  // what a budget chose, or null
    Outputs outputs;
};

void warn(const frame::Frame& frame) {
    for (const std::string& warning : truth_warnings(frame)) std::fprintf(stderr, "plumb: %s\n", warning.c_str());
}

// What is wrong with kept rows, since `told`.
void warn(const FileStore* rows, std::size_t& told) {
    for (; rows && told < rows->notes().size(); ++told) std::fprintf(stderr, "plumb: %s\n", rows->notes()[told].c_str());
}

// The committed files, a line each; those of a dump in one.
std::string files_text(const Outputs& outputs, const std::string& folder) {
    std::string text;
    std::size_t dumped = 0;
    for (const std::string& file : outputs.files()) {
        if (file.find("/dump/") == std::string::npos && file.rfind("dump/", 0) != 0)
            text += "wrote " + file + "\n";
        else
            ++dumped;
    }
    if (dumped > 0) text += fmt::format("wrote {} files that stages read and write: {}/dump\n", dumped, folder);
    return text;
}

// Throws InputError for a mesh that could not be written, before anything is rendered.
void check_mesh(const RenderOptions& given, const frame::Settings& settings) {
    if (given.mesh.empty()) return;
    io::require_coloured_name(given.mesh);
    if (settings.method != frame::Method::radiosity)
        throw InputError(fmt::format("--mesh: of method radiosity alone: method {} has no colours of vertices", frame::method_name(settings.method)));
    if (given.frames > 0) throw InputError("--mesh: one mesh of one frame: expected no --frames beside it");
    require_place(given.mesh);
}

// Writes run.json, and lets all files appear; returns its text.
std::string finish(Job& job, Json json) {
    if (!job.chosen.is_null()) json["chosen"] = job.chosen;
    const std::string text = json_text(json);
    job.outputs.write("run.json", [&](const std::string& path) { io::write_text(path, text); });
    job.outputs.commit();
    return text;
}

int render_one(Job& job) {
    const RenderOptions& given = job.given;
    const Scene& scene = job.scene;
    const frame::Settings& settings = job.settings;
    const RunOptions options = given.common.run_options();
    const Clock::time_point start = Clock::now();
    const frame::Plan plan = [&] {
        const StatusLine status("planning");
        return frame::plan(scene, settings);
    }();
    if (!given.common.json) print_notes(scene);

    // Render.
    const std::string cache = given.scene.no_cache ? "" : cache_folder();
    ReferenceFiles kept(cache);
    const std::unique_ptr<FileStore> rows_kept = row_files(settings, given.scene.no_cache);
    const frame::Frame frame = [&] {
        ProgressBar bar(plan);
        return frame::execute(scene, settings, plan, options, bar.callback(), {cache.empty() ? nullptr : &kept, rows_kept.get()});
    }();
    job.times.render_ms = ms_since(start);
    if (!given.mesh.empty() && frame.radiosity.irradiance.empty())
        throw InputError("--mesh: nothing sends light, so that nothing was solved: there is no mesh");
    const std::vector<TruthRow> rows = [&] {
        const StatusLine status("comparing");
        return compare_layers(frame, given.common.threads);
    }();
    Json truth = frame.traced.empty() ? Json(nullptr) : truth_json(frame, rows, kept.notes());
    const std::optional<frame::MirrorClasses> mirrors = mirror_classes(scene, settings, frame, options);
    if (mirrors) truth["mirrors"] = mirror_json(*mirrors);
    const Json solved = radiosity_json(frame, settings, options, rows_kept.get());

    // Write.
    std::optional<StatusLine> status("writing pictures");
    const Clock::time_point writing = Clock::now();
    write_pictures(scene, plan, frame, picture_name(scene), job.outputs, mirrors ? &*mirrors : nullptr);
    if (given.dump) write_dump(scene, settings, plan, frame, options, job.outputs);
    if (!given.mesh.empty()) io::write_coloured(given.mesh, coloured_meshes(scene, frame), mesh_scale(settings));
    status.reset();
    job.times.write_ms = ms_since(writing);
    job.times.total_ms = ms_since(job.start);
    const RunReport report{scene, settings, options, frame.stages, job.times, peak_bytes(), truth, solved};
    Json run = run_json(report);
    run["lights"] = light_costs_json(scene, plan, frame.stages);
    const std::string json = finish(job, std::move(run));

    // Tell.
    warn(frame);
    std::size_t told = 0;
    warn(rows_kept.get(), told);
    if (given.common.json) {
        std::fputs(json.c_str(), stdout);
        return success;
    }
    std::string text = run_text(report) + radiosity_text(solved) + "\n";
    if (!frame.traced.empty()) text += truth_text(frame, rows, kept.notes()) + (mirrors ? mirror_text(*mirrors) : "") + "\n";
    if (!given.mesh.empty()) text += "wrote " + given.mesh + "\n";
    std::fputs((text + files_text(job.outputs, given.folder)).c_str(), stdout);
    return success;
}

// One frame after the other, each reusing what the one before has made. Files appear when all are there.
int render_frames(Job& job) {
    const RenderOptions& given = job.given;
    Scene& scene = job.scene;
    const frame::Settings& settings = job.settings;
    const RunOptions options = given.common.run_options();
    if (!is_animated(scene))
        scene.notes.push_back("no [[keyframe]] in the file: nothing moves, and every frame is the same");
    if (!given.common.json) print_notes(scene);
    const std::string cache = given.scene.no_cache ? "" : cache_folder();
    ReferenceFiles references(cache);
    const std::unique_ptr<FileStore> rows_kept = row_files(settings, given.scene.no_cache);
    std::size_t told = 0;
    frame::KeptStages kept;
    std::vector<FrameRun> runs;
    for (int f = given.first; f < given.first + given.frames; ++f) {
        const Clock::time_point start = Clock::now();
        scene = posed(std::move(scene), f);
        const frame::Plan plan = frame::plan(scene, settings);
        const frame::Frame& frame = [&]() -> const frame::Frame& {
            ProgressBar bar(plan);
            return frame::execute(scene, settings, plan, options, kept, bar.callback(),
                                  {cache.empty() ? nullptr : &references, rows_kept.get()});
        }();
        FrameRun& run = runs.emplace_back(FrameRun{f, frame.stages, ms_since(start)});
        if (!frame.traced.empty())
            run.truth = truth_json(frame, compare_layers(frame, given.common.threads), references.notes());
        const std::optional<frame::MirrorClasses> mirrors = mirror_classes(scene, settings, frame, options);
        if (mirrors) run.truth["mirrors"] = mirror_json(*mirrors);
        run.radiosity = radiosity_json(frame, settings, options, rows_kept.get());
        run.lights = light_costs_json(scene, plan, frame.stages);
        const StatusLine status(fmt::format("writing the pictures of frame {}", f));
        const Clock::time_point writing = Clock::now();
        write_pictures(scene, plan, frame, frame_name(picture_name(scene), f), job.outputs, mirrors ? &*mirrors : nullptr);
        run.write_ms = ms_since(writing);
        job.times.render_ms += run.ms, job.times.write_ms += run.write_ms;
        warn(frame);
        warn(rows_kept.get(), told);
    }
    job.times.total_ms = ms_since(job.start);
    const FramesReport report{scene, settings, options, runs, job.times, peak_bytes()};
    const std::string json = finish(job, frames_json(report));
    std::fputs(given.common.json ? json.c_str()
                                 : (frames_text(report) + "\n" + files_text(job.outputs, given.folder)).c_str(),
               stdout);
    return success;
}

// Throws InputError that names the first frame which cannot be rendered.
void check_frames(const RenderOptions& given, Scene scene, const frame::Settings& settings) {
    const int last = given.frames > 0 && is_animated(scene) ? given.first + given.frames - 1 : given.first;
    for (int f = given.first; f <= last; ++f) {
        scene = posed(std::move(scene), f);
        try {
            frame::plan(scene, settings);
        } catch (const InputError& error) {
            throw InputError(last > given.first ? fmt::format("frame {}: {}", f, error.what()) : error.what());
        }
    }
}

// Lets --budget choose the settings, and says which.
void choose(Job& job) {
    const RenderOptions& given = job.given;
    const double budget_ms = parse_milliseconds("--budget", given.budget);
    const Choice choice = [&] {
        const StatusLine status("measuring settings, for --budget");
        return choose_by_budget(job.scene, given.scene, job.settings, budget_ms, given.common.run_options());
    }();
    job.settings = choice.settings, job.chosen = choice.json;
    const std::string place =
        given.frames > 1 ? fmt::format("measured on frame {}, for all {} frames\n", given.first, given.frames) : "";
    if (!given.common.json) std::fputs((place + choice.text).c_str(), stdout);
    if (!choice.fits) std::fputs(choice.warning.c_str(), stderr);
    if (given.frames > 0) check_frames(given, job.scene, job.settings);
}

int render(const RenderOptions& given) {
    if (given.frames > 0 && given.dump) throw InputError("--dump: dumps one frame: expected no --frames beside it");
    const Clock::time_point start = Clock::now();
    Scene scene = posed(load(given.scene), given.first);
    const double read_ms = ms_since(start);
    frame::Settings settings = settings_of(scene, given.scene);
    note_idle(given.scene, settings, scene);
    if (frame::reuses_light(settings) && given.frames <= 1)
        scene.notes.push_back("reuse.frames: changes nothing of the first frame, which has none before it: give --frames N");
    // All that can be wrong is found before anything is measured or rendered.
    {
        const StatusLine status("planning");
        check_frames(given, scene, settings);
        check_mesh(given, settings);
    }
    Job job{given, start, {read_ms}, std::move(scene), std::move(settings), nullptr, Outputs(given.folder)};
    if (!given.budget.empty()) choose(job);
    note_lobes(job.settings, job.scene);
    if (job.settings.method == frame::Method::radiosity || job.settings.method == frame::Method::probes) {
        const StatusLine status(job.settings.method == frame::Method::probes ? "baking probes, or reading what is kept"
                                                                             : "cutting the scene into elements");
        job.scene = drawn(std::move(job.scene), job.settings, given.common.run_options());
        add_bake(job.scene, job.settings,
                 {given.common.run_options(), given.scene.no_cache ? "" : cache_folder(), !given.common.json});
    }
    return given.frames > 0 ? render_frames(job) : render_one(job);
}

}  // namespace

void add_render(CLI::App& program, Action& action) {
    auto given = std::make_shared<RenderOptions>();
    CLI::App* command = program.add_subcommand("render", "render a scene: EXR with a layer a buffer, PNG, run.json");
    add_scene_options(*command, given->scene);
    add_size_option(*command, given->scene);
    command->add_option("-o,--output", given->folder, "folder for what is written; \"out\" otherwise")
        ->type_name("DIR");
    command->add_flag("--dump", given->dump, "also write every stage's inputs and outputs, to DIR/dump");
    command->add_option("--mesh", given->mesh,
                        "also write the elements of method radiosity as a mesh with colours of vertices: FILE.glb, FILE.obj")
        ->check(some_word())
        ->type_name("FILE");
    command->add_option("--frames", given->frames, "that many frames of a scene with keyframes: <scene>.0000.png, ...")
        ->check(number_within(1, 100000))
        ->type_name("N");
    command->add_option("--first", given->first, "the first of them, or the one that is rendered; 0 otherwise")
        ->check(number_within(0, 1000000))
        ->type_name("F");
    command->add_option("--budget", given->budget,
                        "sweep the method's settings, and render with the least error within this time: 100ms")
        ->check(some_word())
        ->type_name("TIME");
    add_truth_options(*command, given->scene);
    command->add_flag("--no-cache", given->scene.no_cache, "trace even what is kept, and keep nothing");
    add_common(*command, given->common);
    command->footer(
        "Files: <scene>.exr (32-bit float; layers color, direct, indirect, albedo, emission, position, normal,\n"
        "depth: linear, in metres; zbuffer: the depth buffer, z/w; id, shadow.<light>), <scene>.rsm.<light>.exr\n"
        "(rsm.<light>.position, normal, flux, depth: its size is its own; of a point light rsm.<light>.px.position and\n"
        "so on: px, nx, py, ny, pz, nz, but for faces that can see nothing), <scene>.png (tone mapped), run.json (time\n"
        "and memory by stage). On a surface, color = (albedo (direct + indirect) + emission) / pi, with [reflect] plus the layer reflection; of the method probes\n"
        "highlights are added, the layer glossy, and with probes.layers the layers diffuse, normals and specular are\n"
        "written (of a reflectance of 1), each as <scene>.<layer>.png, too. Equal pictures are equal files.\n"
        "Times in run.json are wall time: read_ms of reading the scene, render_ms of planning and all stages, write_ms of\n"
        "writing all files but run.json, total_ms of everything, with what --budget and comparing with the truth take.\n"
        "\"lights\" has what each light's own stages took, and bytes of what they made.\n"
        "--truth adds the layers truth (outgoing radiance, all light), truth.direct and for rsm truth.indirect\n"
        "(irradiance, the lamps' light alone, as the method counts it), each with a layer .error, its standard error,\n"
        "<scene>.truth.png, and in run.json how far color, direct and indirect are from them. The method reference\n"
        "writes its color, truth.error and no direct and indirect.\n"
        "--frames reuses, frame by frame, what every stage made from what did not change: the maps of lights at rest,\n"
        "the G-buffer of a camera at rest, and so on. The pictures are those of N runs with --first F, bit for bit.\n"
        "run.json has \"frames\" in place of \"stages\", each with its stages, what was kept and what that saved, its\n"
        "total_ms without writing it, and write_ms.\n"
        "--mesh: what leaves each element, W/m2, times tonemap.exposure / pi, linear; GLB also holds it, and irradiance, in W/m2\n"
        "(io/README.md). Lamps' light is that at the elements, not the shadow maps' of the picture.\n"
        "What was path traced is kept in $PLUMB_CACHE, else $XDG_CACHE_HOME/plumbline, else ~/.cache/plumbline, at\n"
        "most 4 GiB, those used last; the same scene and settings take it from there. Beside it lie bakes of probes and\n"
        "rows of radiosity, at most 16 GiB each, and the 256 sweeps that --budget used last. --budget: see plumb sweep;\n"
        "run.json says what was \"chosen\". Where no setting fits, the fastest is rendered, and a warning says so.\n"
        "Of the method radiosity run.json says under \"radiosity\" how it was solved, with its curve, and where all power goes.");
    command->callback([given, &action] { action = [=] { return render(*given); }; });
}

}  // namespace plumb::cli
