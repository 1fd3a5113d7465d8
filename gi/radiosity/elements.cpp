#include "gi/radiosity/elements.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "core/error.h"
#include "core/host_math.h"
#include "core/parallel.h"
#include "gi/probes/receivers.h"
#include "gi/radiosity/corner_groups.h"
#include "gi/radiosity/surface_means.h"
#include "gi/reference/ray_query.h"

namespace plumb::radiosity {
namespace {

using probes::next_half_edge;
using probes::SurfaceMesh;
using Point = glm::dvec3;

constexpr std::uint32_t none = 0xffffffff;
constexpr double shortest_mean = 1e-6;    // of directions, below which they cancel each other
constexpr double sharpest_corner = 0.25;  // sine of half of the angle down to which elements keep the offset from both edges
constexpr float nearest_part = 1 / 32.f;  // of the offset: nearer surfaces are taken for the element's own
constexpr std::size_t most_triangles = 700'000'000;  // three elements each are numbered by an int

double length(const Point& v) { return std::sqrt(glm::dot(v, v)); }
glm::vec4 rounded(const Point& p, double w = 0) { return {float(p.x), float(p.y), float(p.z), float(w)}; }

void check(const ElementParams& p) {
    if (!(p.crease_deg >= 0 && p.crease_deg <= 180))
        throw InputError(fmt::format("radiosity: crease_deg = {}: expected 0 to 180", p.crease_deg));
    if (!(p.offset >= 0 && p.offset <= 0.1))
        throw InputError(fmt::format("radiosity: offset = {}: expected 0 to 0.1 of the scene's diagonal", p.offset));
}

void check(const Geometry& g) {
    if (g.triangles.empty()) throw InputError("radiosity: the scene has no triangles");
    if (g.triangles.size() > most_triangles)
        throw InputError(fmt::format("radiosity: {} triangles: expected at most {}", g.triangles.size(), most_triangles));
    for (std::size_t t = 0; t < g.triangles.size(); ++t)
        for (int k = 0; k < 3; ++k) {
            const glm::vec3& p = g.vertices[g.triangles[t][k]].position;
            if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z))
                throw InputError(fmt::format("radiosity: triangle {}: a position is not finite", t));
        }
}

// What a corner brings to its element.
struct CornerShape {
    double angle = 0;  // rad
    Point into{0};     // integral of the unit directions into the triangle over that angle: of a plane fan they add up to
                       // 2 sin(angle / 2) along the bisector of the whole
};

CornerShape shape_of(const SurfaceMesh& m, std::size_t t, int k) {
    const Point p = m.position(t, k), a = m.position(t, (k + 1) % 3) - p, b = m.position(t, (k + 2) % 3) - p;
    return {host::atan2(length(glm::cross(a, b)), glm::dot(a, b)), glm::cross(b / length(b) - a / length(a), m.normal[t])};
}

// Sums over the triangles of an element.
struct Sums {
    std::uint32_t corner = none;  // the first
    double area = 0;
    Point normal{0}, into{0}, reflectance{0}, exitance{0};
    double room = 1e300;  // m: half of the least height over an edge where the patch ends, seen from the element
    bool border = false;
};

class Maker {
  public:
    Maker(const Scene& scene, const ElementParams& params, const RunOptions& options)
        : scene_(scene), params_(params), options_(options) {
        out_.kind = params.kind;
        out_.geometry = flatten(scene);
        check(out_.geometry);
        surfaces_ = raster::prepare(scene, out_.geometry);
        const bool vertices = params.kind == Kind::vertices;
        mesh_ = probes::surface_mesh(out_.geometry, 0, 0, out_.geometry.triangles.size(), vertices);
        means_ = corner_means(scene, out_.geometry, surfaces_, options);
        leave_out_holes();
        set_offset();
    }

    Elements vertices() {
        const Geometry& g = out_.geometry;
        groups_ = params_.of_file ? corners_by_vertex(g, mesh_)
                  : params_.split ? corner_groups(g, mesh_, params_.crease_deg)
                                  : corners_by_position(mesh_);
        number_groups();
        number_flat_corners();
        sum_corners();
        resize(sums_.size());
        for (std::size_t i = 0; i < sums_.size(); ++i) place_vertex(i);
        lift();
        return std::move(out_);
    }

    Elements triangles() {
        const std::size_t count = mesh_.count;
        resize(count);
        out_.of.resize(count);
        for (std::size_t t = 0; t < count; ++t) place_triangle(t);
        lift();
        return std::move(out_);
    }

  private:
    // Of a triangle that an alpha mask leaves nothing of no hemicube sees anything: its corners become one.
    void leave_out_holes() {
        for (std::size_t t = 0; t < out_.geometry.triangles.size(); ++t) {
            if (means_[3 * t].share > 0 || means_[3 * t + 1].share > 0 || means_[3 * t + 2].share > 0) continue;
            glm::uvec3& corners = out_.geometry.triangles[t];
            corners = glm::uvec3(corners.x);
        }
    }

    void set_offset() {
        glm::vec3 low, high;
        bounds(out_.geometry, low, high);
        float extent = 0;
        for (int c = 0; c < 3; ++c) extent = std::max({extent, std::fabs(low[c]), std::fabs(high[c])});
        out_.offset_m = std::max(params_.offset * length(Point(high) - Point(low)), double(probes::offset_of(extent)));
    }

    void resize(std::size_t count) {
        for (Buffer<glm::vec4>* b : {&out_.position, &out_.normal, &out_.eye, &out_.reflectance, &out_.exitance})
            b->assign(count, glm::vec4(0));
        out_.area.assign(count, 0);
        foot_.resize(count);
    }

    std::uint32_t& element_at(std::uint32_t corner) { return out_.of[corner / 3][int(corner % 3)]; }

    // Elements in the order in which their first corners come.
    void number_groups() {
        out_.of.assign(mesh_.count, glm::uvec3(none));
        for (std::uint32_t c = 0; c < 3 * mesh_.count; ++c) {
            if (!(mesh_.area[c / 3] > 0)) continue;
            const std::uint32_t first = groups_.group[c];
            if (first == c) element_at(c) = new_element(c);
            element_at(c) = element_at(first);
        }
    }
    std::uint32_t new_element(std::uint32_t corner) {
        sums_.emplace_back().corner = corner;
        return std::uint32_t(sums_.size() - 1);
    }

    // Corners of triangles without area take the light of another element there, of the same material if there is one: drawn,
    // such a triangle may yet cover a pixel.
    void number_flat_corners() {
        std::vector<std::uint32_t> flat;
        for (std::uint32_t c = 0; c < 3 * mesh_.count; ++c)
            if (!(mesh_.area[c / 3] > 0)) flat.push_back(c);
        if (flat.empty()) return;
        std::vector<std::uint32_t> last(mesh_.points, none), before(sums_.size(), none);
        const auto add = [&](std::uint32_t e) {
            std::uint32_t& at = last[mesh_.point[sums_[e].corner]];
            before[e] = at, at = e;
        };
        for (std::uint32_t e = 0; e < before.size(); ++e) add(e);
        for (std::uint32_t c : flat) {
            std::uint32_t best = none;
            int best_rank = -1;
            for (std::uint32_t e = last[mesh_.point[c]]; e != none; e = before[e])
                if (const int rank = kinship(c, sums_[e].corner); rank >= best_rank) best = e, best_rank = rank;
            element_at(c) = best;
            if (best != none) continue;
            element_at(c) = new_element(c);
            before.push_back(none);
            add(element_at(c));
        }
    }
    int kinship(std::uint32_t a, std::uint32_t b) const {
        const Geometry& g = out_.geometry;
        return 2 * (g.material[a / 3] == g.material[b / 3]) + (g.object[a / 3] == g.object[b / 3]);
    }

    void sum_corners() {
        std::vector<CornerShape> shapes(3 * mesh_.count);
        parallel_bands(int(mesh_.count), 1024, options_, [&](int first, int last) {
            for (std::size_t t = std::size_t(first); t < std::size_t(last); ++t)
                for (int k = 0; k < 3 && mesh_.area[t] > 0; ++k) shapes[3 * t + std::size_t(k)] = shape_of(mesh_, t, k);
        });
        for (std::uint32_t c = 0; c < 3 * mesh_.count; ++c) {
            const std::size_t t = c / 3;
            if (!(mesh_.area[t] > 0)) continue;
            Sums& s = sums_[element_at(c)];
            const double area = mesh_.area[t] * means_[c].share;
            s.area += area;
            s.reflectance += area * means_[c].reflectance, s.exitance += area * means_[c].exitance;
            s.normal += shapes[c].angle * mesh_.normal[t], s.into += shapes[c].into;
            const std::uint32_t next = next_half_edge(c), previous = next_half_edge(next);
            s.border = s.border || !groups_.goes_on[c] || !groups_.goes_on[previous];
            if (!groups_.goes_on[next]) s.room = std::min(s.room, height(t, int(c % 3)) / 2);
        }
    }
    // Of a corner over the edge opposite.
    double height(std::size_t t, int k) const {
        return 2 * mesh_.area[t] / length(mesh_.position(t, (k + 1) % 3) - mesh_.position(t, (k + 2) % 3));
    }

    void place_vertex(std::size_t i) {
        const Sums& s = sums_[i];
        const Point p = mesh_.position(s.corner / 3, int(s.corner % 3));
        out_.position[i] = rounded(p), out_.eye[i] = rounded(p);
        foot_[i] = p;
        out_.area[i] = s.area;
        const CornerMean& own = means_[s.corner];
        out_.reflectance[i] = rounded(s.area > 0 ? s.reflectance / s.area : own.reflectance);
        out_.exitance[i] = rounded(s.area > 0 ? s.exitance / s.area : own.exitance);
        if (!(mesh_.area[s.corner / 3] > 0)) {
            ++out_.without_normal;
            return;
        }
        const Point normal = normal_of(s);
        out_.normal[i] = rounded(normal);
        if (!params_.inset || !s.border) return;
        const Point along = s.into - glm::dot(s.into, normal) * normal;
        const double sine = length(along) / 2;
        if (!(sine > shortest_mean)) return;
        const double by = std::min(out_.offset_m / std::max(sine, sharpest_corner), s.room);
        foot_[i] = p + along * (by / (2 * sine));
        ++out_.inset;
    }

    // Normals that cancel each other, as at the ends of a spindle, leave that of the first triangle.
    Point normal_of(const Sums& s) const {
        const Point given(mesh_.corner(s.corner).normal), mean = params_.of_file && length(given) > shortest_mean ? given : s.normal;
        return length(mean) > shortest_mean ? mean / length(mean) : mesh_.normal[s.corner / 3];
    }

    void place_triangle(std::size_t t) {
        out_.of[t] = glm::uvec3(std::uint32_t(t));
        foot_[t] = (mesh_.position(t, 0) + mesh_.position(t, 1) + mesh_.position(t, 2)) / 3.0;
        out_.position[t] = out_.eye[t] = rounded(foot_[t]);
        out_.normal[t] = rounded(mesh_.normal[t]);
        out_.without_normal += !(mesh_.area[t] > 0);
        double share = 0;
        Point reflectance(0), exitance(0);
        for (std::size_t c = 3 * t; c < 3 * t + 3; ++c) {
            share += means_[c].share;
            reflectance += means_[c].share * means_[c].reflectance, exitance += means_[c].share * means_[c].exitance;
        }
        out_.area[t] = mesh_.area[t] * share;
        if (!(share > 0)) return;
        out_.reflectance[t] = rounded(reflectance / share), out_.exitance[t] = rounded(exitance / share);
    }

    // Puts eyes off the surface, and half way to what is nearer than twice the offset.
    void lift() {
        const auto query = reference::build_ray_query(out_.geometry, surfaces_, Rays::exact);
        std::atomic<std::int64_t> nearer{0};
        parallel_bands(out_.count(), 256, options_, [&](int first, int last) {
            for (int i = first; i < last; i += 8) nearer += lift_packet(*query, i, std::min(i + 8, last));
        });
        out_.nearer = nearer;
    }
    int lift_packet(const RayQuery& query, int first, int last) {
        RayPacket<8> rays{};
        alignas(32) std::int32_t active[8] = {};
        const float far = float(2 * out_.offset_m);
        for (int i = first; i < last; ++i) {
            const int k = i - first;
            const glm::vec4& n = out_.normal[std::size_t(i)];
            const glm::vec3 foot(foot_[std::size_t(i)]);
            if (n.x == 0 && n.y == 0 && n.z == 0) continue;
            active[k] = -1;
            rays.origin_x[k] = foot.x, rays.origin_y[k] = foot.y, rays.origin_z[k] = foot.z;
            rays.direction_x[k] = n.x, rays.direction_y[k] = n.y, rays.direction_z[k] = n.z;
            rays.t_near[k] = far / 2 * nearest_part, rays.t_far[k] = far;
        }
        query.nearest(active, rays);
        int nearer = 0;
        for (int i = first; i < last; ++i) {
            const int k = i - first;
            if (!active[k]) continue;
            const bool met = rays.triangle[k] != no_hit;
            nearer += met;
            const double height = met ? double(rays.t_far[k]) / 2 : out_.offset_m;
            out_.eye[std::size_t(i)] = rounded(foot_[std::size_t(i)] + height * Point(out_.normal[std::size_t(i)]), height);
        }
        return nearer;
    }

    const Scene& scene_;
    const ElementParams& params_;
    const RunOptions& options_;
    Elements out_;
    raster::Surfaces surfaces_;
    SurfaceMesh mesh_;
    std::vector<CornerMean> means_;  // [corner]
    CornerGroups groups_;
    std::vector<Sums> sums_;   // [element]
    std::vector<Point> foot_;  // [element]: m, below its eye
};

// Whether something emits, and has at most that share of the scene's area.
bool emits_from_little(const Elements& e, double share) {
    double emitting = 0, all = 0;
    for (std::size_t i = 0; i < e.area.size(); ++i) {
        all += e.area[i];
        if (e.exitance[i].x > 0 || e.exitance[i].y > 0 || e.exitance[i].z > 0) emitting += e.area[i];
    }
    return emitting > 0 && emitting <= share * all;
}

}  // namespace

Elements elements_of(const Scene& scene, const ElementParams& params, const RunOptions& options) {
    check(params);
    Maker maker(scene, params, options);
    Elements e = params.kind == Kind::vertices ? maker.vertices() : maker.triangles();
    if (emits_from_little(e, params.small_emitters)) {
        e.lamp_exitance = std::move(e.exitance);
        e.exitance.assign(e.lamp_exitance.size(), glm::vec4(0));
    }
    return e;
}

}  // namespace plumb::radiosity
