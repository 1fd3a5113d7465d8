#include "gi/probes/kept_steps.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"

namespace plumb::probes {

namespace {

// What an element of a list consists of.
template <class T>
struct Parts {
    using Number = T;
    static constexpr std::int64_t count = 1;
};
template <int n, class T, glm::qualifier q>
struct Parts<glm::vec<n, T, q>> {
    using Number = T;
    static constexpr std::int64_t count = n;
};
template <>
struct Parts<Vertex> {
    using Number = float;
    static constexpr std::int64_t count = sizeof(Vertex) / sizeof(float);
};
template <>
struct Parts<Chart> {
    using Number = std::int32_t;
    static constexpr std::int64_t count = sizeof(Chart) / sizeof(std::int32_t);
};
static_assert(sizeof(Chart) == 6 * sizeof(std::int32_t));  // no padding
// Counts, as their low and high half.
template <>
struct Parts<std::int64_t> {
    using Number = std::uint32_t;
    static constexpr std::int64_t count = 2;
};
template <>
struct Parts<std::uint64_t> : Parts<std::int64_t> {};

class Lender {
  public:
    template <class T>
    void array(const std::string& name, const T* data, std::size_t n) {
        using P = Parts<T>;
        lend(bundle, name, {std::int64_t(n), P::count}, reinterpret_cast<const typename P::Number*>(data));
    }
    template <class List>
    void list(const std::string& name, const List& values) {
        array(name, values.data(), values.size());
    }
    template <class T>
    void one(const std::string& name, const T& value) {
        array(name, &value, 1);
    }
    Bundle bundle;
};

class Taker {
  public:
    explicit Taker(const Bundle& kept) : kept_(kept) {}
    template <class T>
    void array(const std::string& name, T* data, std::size_t n) {
        using P = Parts<T>;
        const auto from = elements<typename P::Number>(kept_, name, {std::int64_t(n), P::count});
        if (n) std::memcpy(static_cast<void*>(data), from.data(), from.size_bytes());
    }
    template <class List>
    void list(const std::string& name, List& values) {
        const Array& from = at(kept_, name);
        if (from.shape.empty()) throw InputError(name + ": a number, expected a list");
        values.resize(std::size_t(from.shape[0]));
        array(name, values.data(), values.size());
    }
    template <class T>
    void one(const std::string& name, T& value) {
        array(name, &value, 1);
    }

  private:
    const Bundle& kept_;
};

void expect(bool fits, const char* what) {
    if (!fits) throw InputError(fmt::format("{} do not fit each other", what));
}

// Each step's arrays are named once, here, for both ways.
template <class A, class Way>
void each_of_atlas(A& a, Way& way) {
    way.list("vertices", a.geometry.vertices), way.list("tangents", a.geometry.tangents);
    way.list("triangles", a.geometry.triangles), way.list("material", a.geometry.material);
    way.list("object", a.geometry.object);
    way.list("uv", a.uv), way.list("chart", a.chart), way.list("charts", a.charts);
    way.one("size", a.size), way.one("texels_per_m", a.texels_per_m);
    auto& s = a.summary;
    way.one("used", s.used), way.one("meshes_kept", s.meshes_kept), way.one("meshes_cut", s.meshes_cut);
    way.one("degenerate", s.degenerate), way.one("stretched", s.stretched), way.one("overlapping", s.overlapping);
    way.one("layouts_split", s.layouts_split), way.one("mirrored_islands", s.mirrored_islands);
    way.one("overlaps_cut", s.overlaps_cut), way.one("triangles_without_area", s.triangles_without_area);
    way.one("charts_without_texel", s.charts_without_texel);
}

template <class R, class Moved, class Way>
void each_of_receivers(R& r, Moved& moved, Way& way) {
    way.list("position", r.position), way.list("normal", r.normal), way.list("shift", r.shift);
    way.list("texel", r.texel), way.list("material", r.material), way.list("triangle", r.triangle);
    way.list("border", r.border);
    way.one("size", r.size), way.one("moved", moved);
}

template <class P, class Radius, class Way>
void each_of_placement(P& p, Radius& r, Way& way) {
    way.list("candidates", p.candidates), way.list("probes", p.probes), way.list("candidate", p.candidate);
    way.one("wanted", p.wanted), way.one("rho", p.rho_m), way.one("cell", p.cell_m);
    way.one("kernel_radius", p.kernel_radius_m), way.one("halvings", p.halvings);
    way.one("in_surface", p.in_surface), way.one("beyond", p.beyond), way.one("behind", p.behind);
    way.one("without_normal", p.without_normal), way.one("inside", p.inside);
    way.one("radius", r.radius_m), way.one("mean", r.mean_m), way.one("covering", r.covering_m);
    way.one("largest", r.largest_m), way.one("sampled", r.sampled);
}

template <class S, class Way>
void each_of_supports(S& s, Way& way) {
    way.one("overlaps", s.overlaps), way.list("probe", s.probe), way.list("weight", s.weight);
    way.one("unsupported", s.unsupported), way.one("incomplete", s.incomplete);
}

template <class S, class Way>
void each_of_spatial(S& s, Way& way) {
    way.one("count", s.grid.count), way.one("origin", s.grid.origin), way.one("spacing", s.grid.spacing);
    way.list("position", s.receivers.position), way.list("normal", s.receivers.normal), way.list("shift", s.receivers.shift);
    way.one("shifted", s.shifted), way.one("radius", s.radius);
    each_of_supports(s.supports, way);
}

template <class B, class Way>
void each_of_rays(B& b, Way& way) {
    way.list("directions", b.relight_directions), way.list("weights", b.relight_weights), way.list("harmonics", b.harmonics);
}

template <class Hits, class Way>
void each_of_hits(Hits& h, int first, int count, Way& way) {
    const std::size_t from = std::size_t(first) * std::size_t(h.rays), n = std::size_t(count) * std::size_t(h.rays);
    way.array("material", h.material.data() + from, n), way.array("triangle", h.triangle.data() + from, n);
    way.array("uv", h.uv.data() + from, n), way.array("position", h.position.data() + from, n);
}

template <class Counts, class Way>
void each_of_counts(Counts& c, Way& way) {
    way.one("traced", c.traced), way.one("escaped", c.escaped), way.one("back", c.back), way.one("unseen", c.unseen);
}

}  // namespace

Bundle lent(const Atlas& atlas) {
    Lender way;
    each_of_atlas(atlas, way);
    return way.bundle;
}
void take(const Bundle& kept, Atlas& atlas) {
    Taker way(kept);
    each_of_atlas(atlas, way);
    const std::size_t triangles = atlas.geometry.triangles.size();
    expect(atlas.uv.size() == atlas.geometry.vertices.size() && atlas.chart.size() == triangles &&
               atlas.geometry.material.size() == triangles && atlas.geometry.object.size() == triangles,
           "vertices, triangles and their coordinates");
}

Bundle lent(const Receivers& receivers, const int& moved) {
    Lender way;
    each_of_receivers(receivers, moved, way);
    return way.bundle;
}
void take(const Bundle& kept, Receivers& receivers, int& moved) {
    Taker way(kept);
    each_of_receivers(receivers, moved, way);
    const std::size_t n = receivers.position.size();
    expect(receivers.normal.size() == n && receivers.shift.size() == n && receivers.texel.size() == n &&
               receivers.material.size() == n && receivers.triangle.size() == n && receivers.border.size() == n,
           "receivers");
}

Bundle lent(const Placement& placement, const ProbeRadius& radius) {
    Lender way;
    each_of_placement(placement, radius, way);
    return way.bundle;
}
void take(const Bundle& kept, Placement& placement, ProbeRadius& radius) {
    Taker way(kept);
    each_of_placement(placement, radius, way);
    expect(placement.candidate.size() == placement.probes.size(), "probes and candidates");
}

Bundle lent(const Supports& supports) {
    Lender way;
    each_of_supports(supports, way);
    return way.bundle;
}
void take(const Bundle& kept, Supports& supports) {
    Taker way(kept);
    each_of_supports(supports, way);
    expect(supports.overlaps > 0 && supports.probe.size() == supports.weight.size() &&
               supports.probe.size() % std::size_t(supports.overlaps) == 0,
           "probes of receivers and their weights");
}

Bundle lent(const Spatial& spatial) {
    Lender way;
    each_of_spatial(spatial, way);
    return way.bundle;
}
void take(const Bundle& kept, Spatial& spatial) {
    Taker way(kept);
    each_of_spatial(spatial, way);
    const Receivers& r = spatial.receivers;
    const std::size_t n = r.position.size(), slots = std::size_t(std::max(0, spatial.supports.overlaps));
    expect(n > 0 && n == std::size_t(spatial_directions) * std::size_t(spatial.grid.places()) && r.normal.size() == n && r.shift.size() == n &&
               spatial.supports.probe.size() == n * slots && spatial.supports.weight.size() == n * slots,
           "spatial receivers");
}

Bundle lent_rays(const Bake& bake) {
    Lender way;
    each_of_rays(bake, way);
    return way.bundle;
}
void take_rays(const Bundle& kept, Bake& bake) {
    Taker way(kept);
    each_of_rays(bake, way);
    const std::size_t rays = std::size_t(bake.params.relight_rays);
    expect(bake.relight_directions.size() == rays && bake.relight_weights.size() == rays &&
               bake.harmonics.size() == rays * std::size_t(bake.coefficients()),
           "directions and their weights");
}

Bundle lent(const RelightHits& hits, int first, int count) {
    Lender way;
    each_of_hits(hits, first, count, way);
    return way.bundle;
}
void take(const Bundle& kept, RelightHits& hits, int first, int count) {
    Taker way(kept);
    each_of_hits(hits, first, count, way);
}

Bundle lent(const float* alpha, std::int64_t receivers, std::int64_t row, const RayCounts& counts) {
    Lender way;
    lend(way.bundle, "alpha", {receivers, row}, alpha);
    each_of_counts(counts, way);
    return way.bundle;
}
void take(const Bundle& kept, float* alpha, std::int64_t receivers, std::int64_t row, RayCounts& counts) {
    const auto values = elements<float>(kept, "alpha", {receivers, row});
    Taker way(kept);
    each_of_counts(counts, way);
    std::copy(values.begin(), values.end(), alpha);
}

}  // namespace plumb::probes
