#include "tools/shared/probe_bake.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "core/error.h"
#include "gi/frame/probe_bake.h"
#include "gi/probes/static_scene.h"
#include "io/file.h"
#include "tools/shared/bake_file.h"
#include "tools/shared/bake_progress.h"
#include "tools/shared/file_store.h"
#include "tools/shared/options.h"
#include "tools/shared/process_memory.h"

namespace plumb::cli {

namespace {

template <class List>
void take(const io::DescribedFile& file, const char* name, Shape shape, List& to) {
    using T = typename List::value_type;
    if constexpr (std::is_arithmetic_v<T>) {
        const auto from = io::elements<T>(file, name, shape);
        to.assign(from.begin(), from.end());
    } else {
        using Component = typename T::value_type;
        shape.push_back(T::length());
        const auto from = io::elements<Component>(file, name, shape);
        to.resize(from.size() / std::size_t(T::length()));
        if (!to.empty()) std::memcpy(&to[0].x, from.data(), from.size_bytes());
    }
}

// Corners have vertices of their own: charts end anywhere.
void take_atlas(const io::DescribedFile& file, const Scene& scene, probes::Atlas& a) {
    const Geometry whole = probes::flatten_static(scene);
    Buffer<glm::vec2> uv;
    take(file, "corner_uv", {std::int64_t(whole.triangles.size()), 3}, uv);
    a.uv.assign(uv.begin(), uv.end());
    a.geometry.material = whole.material, a.geometry.object = whole.object;
    for (const glm::uvec3& t : whole.triangles) {
        const unsigned first = unsigned(a.geometry.vertices.size());
        for (const unsigned v : {t.x, t.y, t.z}) {
            a.geometry.vertices.push_back(whole.vertices[v]);
            if (!whole.tangents.empty()) a.geometry.tangents.push_back(whole.tangents[v]);
        }
        a.geometry.triangles.emplace_back(first, first + 1, first + 2);
    }
    take(file, "triangle_chart", {std::int64_t(whole.triangles.size())}, a.chart);
    a.size = glm::ivec2(int(io::integer_fact(file, "lightmap_size")));
    a.texels_per_m = io::number_fact(file, "texels_per_m");
}

void take_receivers(const io::DescribedFile& file, probes::Bake& b) {
    probes::Receivers& r = b.receivers;
    take(file, "receiver_position", {any_extent}, r.position);
    const std::int64_t n = r.count();
    take(file, "receiver_normal", {n}, r.normal), take(file, "receiver_shift", {n}, r.shift);
    take(file, "receiver_texel", {n}, r.texel), take(file, "receiver_material", {n}, r.material);
    take(file, "receiver_triangle", {n}, r.triangle), take(file, "receiver_border", {n}, r.border);
    r.size = b.atlas.size;
    b.supports.overlaps = int(array_of(file, "receiver_probe", DType::i32, {n, any_extent}).shape[1]);
    take(file, "receiver_probe", {n, b.supports.overlaps}, b.supports.probe);
    take(file, "receiver_weight", {n, b.supports.overlaps}, b.supports.weight);
    for (const glm::vec4& s : r.shift) b.shifted += s.w > 0 ? 1 : 0;
}

void take_probes(const io::DescribedFile& file, probes::Bake& b) {
    take(file, "probe_position", {any_extent}, b.placement.probes);
    take(file, "relight_direction", {any_extent}, b.relight_directions);
    probes::RelightHits& h = b.relight;
    h.probes = int(b.placement.probes.size()), h.rays = int(b.relight_directions.size());
    take(file, "relight_weight", {any_extent, h.rays}, b.relight_weights);
    b.relight_weights.resize(std::size_t(h.rays));  // of all rays
    take(file, "relight_harmonic", {h.rays, b.coefficients()}, b.harmonics);
    take(file, "relight_material", {h.probes, h.rays}, h.material), take(file, "relight_triangle", {h.probes, h.rays}, h.triangle);
    take(file, "relight_uv", {h.probes, h.rays}, h.uv), take(file, "relight_position", {h.probes, h.rays}, h.position);
    b.radius.radius_m = io::number_fact(file, "probe_radius_m");
}

// A word as a scene file writes it.
std::string without_quotes(const std::string& text) {
    const bool quoted = text.size() >= 2 && text.front() == '"' && text.back() == '"';
    return quoted ? text.substr(1, text.size() - 2) : text;
}

// The parameters it was baked with.
void take_params(const io::DescribedFile& file, probes::BakeParams& params) {
    for (Field& field : fields(params))
        for (const io::NamedFact& fact : file.facts) {
            if (fact.name != "probes." + field.name) continue;
            FieldValue value = 0.0;
            if (const auto* i = std::get_if<std::int64_t>(&fact.value))
                value = std::get_if<bool*>(&field.value) ? FieldValue(*i != 0) : FieldValue(double(*i));
            else if (const auto* d = std::get_if<double>(&fact.value))
                value = *d;
            else
                value = without_quotes(std::get<std::string>(fact.value));
            set_field(field, value, file.path + ": " + fact.name);
        }
}

// Beside the scene, where its own words mean it.
std::string path_of(const std::string& file, const Scene& scene) {
    namespace fs = std::filesystem;
    std::error_code error;
    if (fs::path(file).is_absolute() || fs::exists(file, error)) return file;
    const std::string beside = (fs::path(io::folder_of(scene.name)) / file).string();
    return fs::exists(beside, error) ? beside : file;
}

}  // namespace

std::shared_ptr<const probes::Bake> read_bake(const std::string& path, const Scene& scene) {
    const io::DescribedFile file = io::read_described(path, bake_kind);
    const std::uint64_t hash = probes::scene_hash(scene);
    io::require_scene(file, hash, scene.name);
    check_bake(file);
    check_sky(file, scene);
    auto bake = std::make_shared<probes::Bake>();
    take_params(file, bake->params);
    if (bake->coefficients() != int(io::integer_fact(file, "coefficients")))
        throw InputError(path, "coefficients", "are not those of probes.degree");
    bake->transport = probes::transport_params(bake->params, probes::sends_light(scene.environment));
    bake->scene_hash = hash;
    take_atlas(file, scene, bake->atlas);
    take_receivers(file, *bake);
    take_probes(file, *bake);
    bake->flat = flat_clusters_of(file);
    bake->spatial = spatial_of(file);
    return bake;
}

void require_baked(const std::vector<std::string>& sets, const std::vector<std::string>& tables, const std::string& command) {
    probes::RunParams run;
    const std::vector<Field> later = probes::fields(run);
    for (const std::string& text : sets) {
        const Assignment a = parse_assignment(text);
        if (!std::count(tables.begin(), tables.end(), a.table))
            throw InputError(fmt::format("{}: {} does not read the table [{}]: expected [{}]", a.place, command, io::printable(a.table),
                                         fmt::join(tables, "] or [")));
        const auto of_frames = std::find_if(later.begin(), later.end(), [&](const Field& f) { return f.name == a.key; });
        if (a.table == "probes" && of_frames != later.end())
            throw InputError(fmt::format("{}: {} does not read it: it is of frames that read a bake (plumb render)", a.place, command));
    }
}

std::vector<graph::NodeRun> run_bake(const probes::BakeGraph& graph, const Scene& scene, const graph::RunWith& with) {
    try {
        return graph::run(graph.nodes(), with);
    } catch (const InputError& error) {
        throw InputError(fmt::format("{}: {}", io::shown(scene.name), error.what()));
    }
}

std::shared_ptr<const probes::Bake> make_bake(const Scene& scene, const probes::BakeParams& params, const BakeWith& with) {
    probes::BakeGraph graph(scene, params, {}, memory_there());
    std::unique_ptr<FileStore> store;
    if (!with.store.empty()) {
        store = std::make_unique<FileStore>(with.store, "bake", FileStore::Limits{.max_bytes = std::uint64_t(16) << 30, .made = "baked"});
        store->pin();
    }
    graph::RunWith run;
    run.options = with.options, run.store = store.get();
    {
        std::unique_ptr<BakeProgress> progress;
        if (with.progress) progress = std::make_unique<BakeProgress>(graph), run.progress = progress->callback();
        run_bake(graph, scene, run);
    }
    auto bake = std::make_shared<probes::Bake>(graph.release());
    if (!with.with_alpha) bake->alpha = {};
    return bake;
}

Scene drawn(Scene scene, const frame::Settings& settings, const RunOptions& options) {
    if (settings.method != frame::Method::radiosity) return scene;
    return radiosity::drawn_by_radiosity(scene, settings.radiosity, options);
}

void add_bake(const Scene& scene, frame::Settings& settings, const BakeWith& with) {
    if (settings.method != frame::Method::probes || settings.bake) return;
    settings.bake = settings.probe_run.file.empty() ? make_bake(scene, frame::bake_params(scene, settings), with)
                                                    : read_bake(path_of(settings.probe_run.file, scene), scene);
}

}  // namespace plumb::cli
