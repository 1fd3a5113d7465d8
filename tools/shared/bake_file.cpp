#include "tools/shared/bake_file.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <tuple>
#include <type_traits>

#include "core/error.h"
#include "io/file.h"

namespace plumb::cli {

namespace {

using io::Description;
using Axes = std::vector<std::string>;

class Writer {
  public:
    explicit Writer(io::DescribedFile& file) : file_(file) {}

    // One number, or one vector, an element of `axis`.
    template <class List>
    void list(const std::string& name, const List& values, const std::string& axis, const std::string& unit,
              const std::string& meaning) {
        array(name, values, {std::int64_t(values.size())}, {axis}, unit, meaning);
    }
    // The same of several axes.
    template <class List>
    void array(const std::string& name, const List& values, Shape shape, Axes axes, const std::string& unit,
               const std::string& meaning) {
        using T = typename List::value_type;
        if constexpr (std::is_arithmetic_v<T>) {
            add(name, shape, values.data(), Description{unit, meaning, axes});
        } else {
            using Component = typename T::value_type;
            shape.push_back(T::length()), axes.push_back("component");
            const Component* data = values.empty() ? nullptr : &values[0].x;
            add(name, shape, data, Description{unit, meaning, axes});
        }
    }
    // The same of a large list that outlives the file: not copied.
    template <class List>
    void lent_array(const std::string& name, const List& values, const Shape& shape, const Axes& axes, const std::string& unit,
                    const std::string& meaning) {
        lends_ = true;
        array(name, values, shape, axes, unit, meaning);
        lends_ = false;
    }
    void fact(const std::string& name, io::Fact value) { file_.facts.push_back({name, std::move(value)}); }

  private:
    template <class T>
    void add(const std::string& name, const Shape& shape, const T* data, Description description) {
        if (!lends_) {
            io::add(file_, name, shape, data, std::move(description));
        } else {
            lend(file_.arrays, name, shape, data);
            file_.descriptions.push_back(std::move(description));
        }
    }

    io::DescribedFile& file_;
    bool lends_ = false;
};

io::Fact fact_of(const Field& field) {
    if (!field.choices.empty()) return value_text(field);
    if (const auto* i = std::get_if<int*>(&field.value)) return std::int64_t(**i);
    if (const auto* f = std::get_if<float*>(&field.value)) return double(**f);
    if (const auto* b = std::get_if<bool*>(&field.value)) return std::int64_t(**b ? 1 : 0);
    return value_text(field);
}

constexpr const char* escape_names[] = {"nothing", "same_direction", "visible_probes", "all_probes", "sky"};

void add_facts(Writer& w, const probes::Bake& b, const std::string& scene) {
    w.fact("scene_name", io::stem_of(scene));
    w.fact("lightmap_size", std::int64_t(b.atlas.size.x));
    w.fact("texels_per_m", b.atlas.texels_per_m);
    w.fact("probe_radius_m", b.radius.radius_m);
    w.fact("coefficients", std::int64_t(b.coefficients()));
    w.fact("escape", std::string(escape_names[int(b.transport.escape)]));
    const probes::RayCounts counts = b.counts();
    for (const auto& [name, n] : {std::pair("rays_traced", counts.traced), std::pair("rays_escaped", counts.escaped),
                                  std::pair("rays_to_backs", counts.back), std::pair("rays_unseen", counts.unseen)})
        w.fact(name, std::int64_t(n));
    probes::BakeParams params = b.params;
    for (const Field& f : fields(params)) w.fact("probes." + f.name, fact_of(f));
}

void add_atlas(Writer& w, const probes::Bake& b) {
    const probes::Atlas& a = b.atlas;
    std::vector<glm::vec2> corners;
    for (const glm::uvec3& t : a.geometry.triangles)
        for (const unsigned v : {t.x, t.y, t.z}) corners.push_back(a.uv[v]);
    w.array("corner_uv", corners, {std::int64_t(a.geometry.triangles.size()), 3}, {"triangle", "corner"}, "",
            "lightmap coordinate of each triangle's corners; (0, 0) is the top left corner of the first texel");
    w.list("triangle_chart", a.chart, "triangle", "", "index of the chart; -1: no area");
    std::vector<glm::ivec4> rectangles;
    std::vector<std::int32_t> objects, own;
    for (const probes::Chart& c : a.charts)
        rectangles.push_back({c.origin, c.size}), objects.push_back(c.object), own.push_back(c.own_uv);
    w.list("chart_rectangle", rectangles, "chart", "texels", "x, y, width, height on the lightmap");
    w.list("chart_object", objects, "chart", "", "index of the mesh");
    w.list("chart_own_uv", own, "chart", "", "1: the mesh's own texture coordinates");
}

void add_receivers(Writer& w, const probes::Bake& b) {
    const probes::Receivers& r = b.receivers;
    const std::int64_t n = r.count(), slots = b.supports.overlaps;
    w.lent_array("receiver_position", r.position, {n}, {"receiver"}, "m", "from where it looks, world; w 0");
    w.lent_array("receiver_normal", r.normal, {n}, {"receiver"}, "", "unit, world; w 0");
    w.lent_array("receiver_shift", r.shift, {n}, {"receiver"}, "m", "by how much it was moved; w: 1 where it was");
    w.list("receiver_texel", r.texel, "receiver", "texels", "column and row of the lightmap");
    w.list("receiver_material", r.material, "receiver", "", "index of the material");
    w.list("receiver_triangle", r.triangle, "receiver", "", "index of the triangle, as the scene's meshes in a row have them");
    w.list("receiver_border", r.border, "receiver", "", "neighbours to extend into: 1 left, 2 right, 4 up, 8 down");
    w.lent_array("receiver_probe", b.supports.probe, {n, slots}, {"receiver", "slot"}, "", "supporting probes, nearest first; -1: none");
    w.lent_array("receiver_weight", b.supports.weight, {n, slots}, {"receiver", "slot"}, "", "w(distance / radius) of each; 0: none");
    std::vector<float> told;
    for (int i = 0; i < b.receivers.count(); ++i) told.push_back(told_share(b, i));
    w.list("receiver_told", told, "receiver", "", "share of what it sees that probes tell it; 0: it stays black");
    w.lent_array("receiver_u", b.flat.u, {n, b.flat.singular_values}, {"receiver", "singular value"}, "", "row of U");
    w.list("receiver_cluster", b.flat.cluster_of, "receiver", "", "index of the cluster; -1: no probe supports it");
}

void add_probes(Writer& w, const probes::Bake& b) {
    const probes::RelightHits& h = b.relight;
    w.list("probe_position", b.placement.probes, "probe", "m", "world; w 0; the sky is the last, 1e18 m away, where escape is sky");
    w.list("relight_direction", b.relight_directions, "ray", "", "unit, of each probe's rays; w 0");
    // Of all rays, and of the first half, quarter, eighth.
    Buffer<float> weights;
    std::int64_t halvings = 0;
    for (int n = h.rays; halvings < 4 && n >= 1; n /= 2, ++halvings) {
        const Buffer<float> of_prefix = probes::relight_weights(b.relight_directions, n);
        weights.insert(weights.end(), of_prefix.begin(), of_prefix.end());
        weights.resize(std::size_t(halvings + 1) * std::size_t(h.rays), 0);
    }
    w.array("relight_weight", weights, {halvings, h.rays}, {"halving", "ray"}, "sr",
            "weights of all rays; of the first half; quarter; eighth: lambda_ij = sum of weight f Y_j");
    w.lent_array("relight_harmonic", b.harmonics, {h.rays, b.coefficients()}, {"ray", "coefficient"}, "1/sqrt(sr)",
            "Y_j in the direction of each ray, j = l (l + 1) + m");
    w.lent_array("relight_material", h.material, {h.probes, h.rays}, {"probe", "ray"}, "",
            "index of the material that the ray met; -1: nothing; -2: the back of a surface");
    w.lent_array("relight_triangle", h.triangle, {h.probes, h.rays}, {"probe", "ray"}, "", "index of the triangle; -1: none");
    w.lent_array("relight_uv", h.uv, {h.probes, h.rays}, {"probe", "ray"}, "", "lightmap coordinate of what the ray met");
    w.lent_array("relight_position", h.position, {h.probes, h.rays}, {"probe", "ray"}, "m",
            "what the ray met, world, w 1; or its direction, w 0");
}

// of: "" for receivers of surfaces, "spatial_" for those in the air.
void add_clusters(Writer& w, const probes::FlatClusters& f, int coefficients, const std::string& of) {
    const std::int64_t n = f.count();
    w.list(of + "cluster_first_receiver", f.first_receiver, "cluster, and the end", "", "index into cluster_receiver");
    w.list(of + "cluster_receiver", f.receivers, "receiver of a cluster", "", "receivers, cluster by cluster");
    w.list(of + "cluster_first_probe", f.first_probe, "cluster, and the end", "", "index into cluster_probe");
    w.list(of + "cluster_probe", f.probes, "probe of a cluster", "", "probes that support the cluster, in the order of its columns");
    w.list(of + "cluster_rank", f.rank, "cluster", "", "singular values kept: rows of its matrix");
    std::vector<std::int32_t> first_number = {0};
    for (int c = 0; c < f.count(); ++c) {
        const std::int64_t probes_of = f.first_probe[std::size_t(c) + 1] - f.first_probe[std::size_t(c)];
        const std::int64_t end = first_number.back() + f.rank[std::size_t(c)] * probes_of * coefficients;
        if (end > std::numeric_limits<std::int32_t>::max()) throw InputError("bake: matrices of more than 2^31 numbers");
        first_number.push_back(std::int32_t(end));
    }
    w.list(of + "cluster_first_number", first_number, "cluster, and the end", "", "index into cluster_matrix");
    w.lent_array(of + "cluster_matrix", f.sigma_vt, {std::int64_t(f.sigma_vt.size())}, {"number"}, "sr", "Sigma V^T of each cluster, [rank][probes][coefficient], one after the other");
    w.list(of + "cluster_first_value", f.first_value, "cluster, and the end", "", "index into cluster_singular_value");
    w.list(of + "cluster_singular_value", f.spectrum, "singular value", "sr", "all of each cluster, descending");
    w.array(of + "cluster_box", f.box, {n, 2, 3}, {"cluster", "corner", "component"}, "m", "low and high corner of its receivers");
    w.array(of + "cluster_error", f.errors, {n, 2}, {"cluster", "measure"}, "", "1 - sqrt(kept / all singular values); Frobenius, relative");
}

void add_spatial(Writer& w, const probes::Bake& b) {
    const probes::Spatial& s = b.spatial;
    if (s.empty()) return;
    const std::int64_t places = s.grid.places(), slots = s.supports.overlaps;
    const auto of_places = [&](const auto& list, std::int64_t each) {
        return std::remove_cvref_t<decltype(list)>(list.begin(), list.begin() + places * each);
    };
    w.array("spatial_count", std::vector<glm::ivec3>{s.grid.count}, {1}, {"grid"}, "", "places along x, y and z; x fastest");
    w.array("spatial_box", std::vector<glm::vec3>{s.grid.origin, s.grid.spacing}, {2}, {"origin, spacing"}, "m",
            "place (x, y, z) of the grid is at origin + (x, y, z) spacing");
    w.list("spatial_position", of_places(s.receivers.position, 1), "place", "m", "from where it looks, world; w 0");
    w.list("spatial_shift", of_places(s.receivers.shift, 1), "place", "m", "by how much it was moved off the grid; w: 1 where it was");
    w.array("spatial_probe", of_places(s.supports.probe, slots), {places, slots}, {"place", "slot"}, "",
            "supporting probes, nearest first; -1: none");
    w.array("spatial_support", of_places(s.supports.weight, slots), {places, slots}, {"place", "slot"}, "", "w(distance / radius) of each; 0: none");
    w.lent_array("spatial_u", s.flat.u, {probes::spatial_directions * places, s.flat.singular_values},
                 {"direction +x -x +y -y +z -z, place", "singular value"}, "", "row of U");
    w.list("spatial_cluster", s.flat.cluster_of, "direction, place", "", "index of the cluster; -1: no probe supports it");
    add_clusters(w, s.flat, b.coefficients(), "spatial_");
}

}  // namespace

io::DescribedFile bake_file(const probes::Bake& b, const std::string& scene, bool with_alpha) {
    io::DescribedFile file;
    file.kind = bake_kind.name, file.version = bake_kind.newest;
    io::add_scene(file, b.scene_hash);
    Writer w(file);
    add_facts(w, b, scene);
    add_atlas(w, b);
    add_receivers(w, b);
    add_probes(w, b);
    add_clusters(w, b.flat, b.coefficients(), "");
    add_spatial(w, b);
    if (with_alpha)
        w.lent_array("receiver_alpha", b.alpha, {b.receivers.count(), b.supports.overlaps, b.coefficients()},
                {"receiver", "slot", "coefficient"}, "sr", "alpha_ij of the supporting probe, not truncated");
    return file;
}

namespace {

// of: as add_clusters() has it; receiver: what their lists' names begin with.
probes::FlatClusters clusters_in(const io::DescribedFile& file, const std::string& of, const std::string& receiver) {
    const auto list = [&](const std::string& name, auto type) {
        using T = decltype(type);
        const auto values = io::elements<T>(file, name, {any_extent});
        return std::vector<T>(values.begin(), values.end());
    };
    probes::FlatClusters f;
    const Array& u = array_of(file, receiver + "_u", DType::f32, {any_extent, any_extent});
    f.singular_values = int(u.shape[1]);
    const auto us = elements<float>(u, u.shape);
    f.u.assign(us.begin(), us.end());
    f.first_receiver = list(of + "cluster_first_receiver", std::int32_t()), f.receivers = list(of + "cluster_receiver", std::int32_t());
    f.first_probe = list(of + "cluster_first_probe", std::int32_t()), f.probes = list(of + "cluster_probe", std::int32_t());
    f.rank = list(of + "cluster_rank", std::int32_t()), f.first_value = list(of + "cluster_first_value", std::int32_t());
    const auto matrices = list(of + "cluster_matrix", float());
    f.sigma_vt.assign(matrices.begin(), matrices.end());
    f.spectrum = list(of + "cluster_singular_value", double());
    f.cluster_of = list(receiver + "_cluster", std::int32_t());
    const auto boxes = io::elements<float>(file, of + "cluster_box", {f.count(), 2, 3});
    f.box.assign(boxes.begin(), boxes.end());
    const auto errors = io::elements<double>(file, of + "cluster_error", {f.count(), 2});
    f.errors.assign(errors.begin(), errors.end());
    for (const std::int32_t r : f.rank) f.first_row.push_back(f.first_row.back() + r);
    return f;
}

void check_clusters(const io::DescribedFile& file, const probes::FlatClusters& f, std::int64_t coefficients, std::int64_t receivers) {
    try {
        if (std::int64_t(f.cluster_of.size()) != receivers) throw InputError("clusters of another number of receivers");
        probes::clusters_of(f, int(coefficients));
    } catch (const InputError& e) {
        throw InputError(file.path + ": " + e.what());
    }
}

}  // namespace

probes::FlatClusters flat_clusters_of(const io::DescribedFile& file) { return clusters_in(file, "", "receiver"); }

bool has_spatial(const io::DescribedFile& file) { return find(file.arrays, "spatial_count") != nullptr; }

probes::Spatial spatial_of(const io::DescribedFile& file) {
    probes::Spatial s;
    if (!has_spatial(file)) return s;
    const auto wrong = [&](const char* name, const char* cause) { return InputError(io::shown(file.path), name, cause); };
    const auto count = io::elements<std::int32_t>(file, "spatial_count", {1, 3});
    std::int64_t places = 1;
    for (const std::int32_t n : count) {
        if (n < 1 || n > 1 << 24 || places * n > 1 << 24) throw wrong("spatial_count", "expected 1 to 2^24 places");
        places *= n;
    }
    const auto box = io::elements<float>(file, "spatial_box", {2, 3});
    for (std::size_t i = 0; i < 6; ++i)
        if (!std::isfinite(box[i]) || (i >= 3 && !(box[i] > 0))) throw wrong("spatial_box", "expected finite numbers, spacings above 0");
    s.grid = {{count[0], count[1], count[2]}, {box[0], box[1], box[2]}, {box[3], box[4], box[5]}};
    const auto repeated = [&](auto& to, auto from, std::size_t width) {
        using T = typename std::remove_reference_t<decltype(to)>::value_type;
        to.resize(std::size_t(probes::spatial_directions) * from.size() / width);
        for (std::size_t d = 0; d < probes::spatial_directions && !from.empty(); ++d)
            std::memcpy(static_cast<void*>(to.data() + d * from.size() / width), from.data(), from.size() / width * sizeof(T));
    };
    repeated(s.receivers.position, io::elements<float>(file, "spatial_position", {places, 4}), 4);
    repeated(s.receivers.shift, io::elements<float>(file, "spatial_shift", {places, 4}), 4);
    for (int d = 0; d < probes::spatial_directions; ++d)
        s.receivers.normal.insert(s.receivers.normal.end(), std::size_t(places), glm::vec4(probes::spatial_direction(d), 0));
    for (std::int64_t i = 0; i < places; ++i) s.shifted += s.receivers.shift[std::size_t(i)].w == 1 ? 1 : 0;
    const Array& probe = array_of(file, "spatial_probe", DType::i32, {places, any_extent});
    s.supports.overlaps = int(probe.shape[1]);
    repeated(s.supports.probe, elements<std::int32_t>(probe, probe.shape), 1);
    repeated(s.supports.weight, io::elements<float>(file, "spatial_support", probe.shape), 1);
    s.flat = clusters_in(file, "spatial_", "spatial");
    return s;
}

void check_bake(const io::DescribedFile& file) {
    const auto rows_of = [&](const char* name, DType dtype, Shape shape) { return array_of(file, name, dtype, shape).shape[0]; };
    const std::int64_t receivers = rows_of("receiver_position", DType::f32, {any_extent, 4});
    for (const auto& [name, dtype, width] : std::vector<std::tuple<const char*, DType, std::int64_t>>{
             {"receiver_normal", DType::f32, 4}, {"receiver_shift", DType::f32, 4}, {"receiver_texel", DType::i32, 2}})
        array_of(file, name, dtype, {receivers, width});
    for (const auto& [name, dtype] : std::vector<std::pair<const char*, DType>>{
             {"receiver_material", DType::i32}, {"receiver_triangle", DType::i32}, {"receiver_border", DType::u32},
             {"receiver_cluster", DType::i32}, {"receiver_told", DType::f32}})
        array_of(file, name, dtype, {receivers});
    const std::int64_t slots = array_of(file, "receiver_probe", DType::i32, {receivers, any_extent}).shape[1];
    array_of(file, "receiver_weight", DType::f32, {receivers, slots});
    const std::int64_t triangles = rows_of("corner_uv", DType::f32, {any_extent, 3, 2});
    array_of(file, "triangle_chart", DType::i32, {triangles});
    const std::int64_t rays = rows_of("relight_direction", DType::f32, {any_extent, 4});
    const std::int64_t probes = rows_of("probe_position", DType::f32, {any_extent, 4});
    const std::int64_t coefficients = io::integer_fact(file, "coefficients");
    array_of(file, "relight_weight", DType::f32, {any_extent, rays});
    array_of(file, "relight_harmonic", DType::f32, {rays, coefficients});
    for (const char* name : {"relight_material", "relight_triangle"}) array_of(file, name, DType::i32, {probes, rays});
    array_of(file, "relight_uv", DType::f32, {probes, rays, 2});
    array_of(file, "relight_position", DType::f32, {probes, rays, 4});
    const std::int64_t charts = rows_of("chart_rectangle", DType::i32, {any_extent, 4});
    const auto within = [&](const char* name, Shape shape, std::int64_t least, std::int64_t end, const char* what) {
        for (const std::int32_t i : io::elements<std::int32_t>(file, name, shape))
            if (i < least || i >= end) throw InputError(io::shown(file.path), name, std::string(what) + " is out of range");
    };
    within("receiver_probe", {receivers, slots}, -1, probes, "a probe");
    within("cluster_probe", {any_extent}, 0, probes, "a probe");
    within("receiver_triangle", {receivers}, 0, triangles, "a triangle");
    within("relight_triangle", {probes, rays}, -1, triangles, "a triangle");
    within("triangle_chart", {triangles}, -1, charts, "a chart");

    check_clusters(file, flat_clusters_of(file), coefficients, receivers);
    if (!has_spatial(file)) return;
    within("spatial_probe", {any_extent, any_extent}, -1, probes, "a probe");
    within("spatial_cluster_probe", {any_extent}, 0, probes, "a probe");
    const probes::FlatClusters air = clusters_in(file, "spatial_", "spatial");
    check_clusters(file, air, coefficients, array_of(file, "spatial_u", DType::f32, {any_extent, any_extent}).shape[0]);
    const probes::Spatial s = spatial_of(file);
    if (air.cluster_of.size() != s.receivers.position.size())
        throw InputError(io::shown(file.path), "spatial_cluster", "expected six receivers a place");
}

void check_sky(const io::DescribedFile& file, const Scene& scene) {
    if (io::text_fact(file, "probes.escapes") != "automatic") return;
    const char* asked = escape_names[int(probes::transport_params({}, probes::sends_light(scene.environment)).escape)];
    const std::string& has = io::text_fact(file, "escape");
    if (has != asked)
        throw InputError(file.path, "", fmt::format("was baked with escapes = {}, and this scene's sky asks for {}", has, asked));
}

}  // namespace plumb::cli
