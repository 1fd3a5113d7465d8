#include "gi/probes/lod.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/probes/directions.h"

namespace plumb::probes {

namespace {

constexpr int n = most_levels;

std::array<float, 3> distances(const LodParams& p) { return {p.distance_1, p.distance_2, p.distance_3}; }
std::array<int, n> degrees(const LodParams& p) { return {p.degree_0, p.degree_1, p.degree_2, p.degree_3}; }
std::array<int, n> rays(const LodParams& p) { return {p.rays_0, p.rays_1, p.rays_2, p.rays_3}; }

[[noreturn]] void refuse(const std::string& what) { throw InputError("lod: " + what); }

bool power_of_two(int x) { return x > 0 && (x & (x - 1)) == 0; }

// The largest degree up to which harmonics are orthonormal on so many rays: products of two are integrated exactly.
int unaliased_degree(int rays) { return exact_degree(rays) / 2; }

void take_distances(const LodParams& p, double diagonal_m, Lod& lod) {
    float last = 0, shifted_last = 0;
    for (int k = 0; k + 1 < n; ++k) {
        if (k + 1 < lod.levels) {
            const float own = distances(p)[std::size_t(k)], automatic = float(std::max(diagonal_m / 4 * (1 << k), 2.0 * double(last)));
            if (own >= 0 && own < last)
                refuse(fmt::format("distance_{} = {:g} m is less than {:g} m of the level before: expected ascending distances", k + 1, own, last));
            last = own >= 0 ? own : automatic;
        }
        // Levels that there are not begin where the last one does: level_of() ends at `levels`.
        const float shifted = std::max(last - p.fragment_shift, 0.0f);
        lod.rule.distances[k] = last, lod.fragment_distances[k] = shifted;
        lod.rule.widths[k] = k + 1 < lod.levels ? p.smoothing * (shifted - shifted_last) : 0;
        lod.rule.margins[k] = float(1 << std::min(k, std::max(lod.levels - 2, 0)));
        shifted_last = shifted;
    }
}

int take_rays(const LodParams& p, int level, int relight_rays, int before) {
    const int asked = rays(p)[std::size_t(level)];
    if (asked > relight_rays)
        refuse(fmt::format("rays_{} = {}: the bake has {} relight rays a probe", level, asked, relight_rays));
    // Halves down to 64, of which the bake has whole prefixes where it has a power of two.
    const int half = before <= 64 ? before : 1 << (std::bit_width(unsigned(before - 1)) - 1);
    const int taken = asked > 0 ? asked : level == 0 ? relight_rays : std::max(half, std::min(before, 64));
    if (taken > before) refuse(fmt::format("rays_{} = {}: the level before has {}: expected no more", level, taken, before));
    return taken;
}

// all: the bake's rays, of which its degree is.
int take_degree(const LodParams& p, int level, int rays, int all, int before, std::vector<std::string>& notes) {
    const int asked = degrees(p)[std::size_t(level)];
    if (asked < 0) return rays == all ? before : std::min(before, unaliased_degree(rays));
    if (asked > exact_degree(rays))
        refuse(fmt::format("degree_{} = {}: the weights of {} rays integrate harmonics up to degree {}", level, asked, rays, exact_degree(rays)));
    if (asked > before)
        notes.push_back(fmt::format("degree_{} = {}: cut to {}, which {} has", level, asked, before, level == 0 ? "the bake" : "the level before"));
    if (std::min(asked, before) > unaliased_degree(rays))
        notes.push_back(fmt::format("degree_{} = {}: on {} rays harmonics above degree {} are not orthogonal", level, std::min(asked, before), rays,
                                    unaliased_degree(rays)));
    return std::min(asked, before);
}

void take_zones(const LodParams& p, LevelRule& rule) {
    if (!p.zones) return;
    const auto angle = [](float degrees) { return double(degrees) * host::pi / 180; };
    rule.zones = glm::vec4(float(host::cos(angle(p.front_angle))), float(host::sin(angle(p.front_angle))),
                           float(host::cos(angle(p.side_angle))), float(host::sin(angle(p.side_angle))));
    rule.scales = glm::vec4(1, p.side_scale, p.behind_scale, 0);
}

}  // namespace

std::vector<Field> fields(LodParams& p) {
    const std::string distance = "from the eye where this level begins (IPR table 5.10: 20, 50, 100); -1: a quarter of the scene's diagonal, "
                                 "twice as far for each level";
    const std::string degree = "of the harmonics in this level (IPR table 5.11); -1: the largest that its rays sample without aliasing";
    const std::string rays = "relight rays of a probe in this level: the first ones (figure 5.31: 512, 256, 128, 64); 0: all, then half of the "
                             "level's before, at least 64";
    // `plumb sweep` draws a curve over the number of levels, and further ones of what each may leave out more.
    using enum SweepRange::Role;
    const auto swept = [](SweepRange::Role role, std::vector<double> values) { return SweepRange{role, std::move(values), "", ""}; };
    std::vector<Field> all = {
        {"levels", &p.levels, "", "levels of detail (IPR 4.2); 1: none", 1, n, {}, true, swept(along, {1, 2, 3, 4})},
        {"distance_1", &p.distance_1, "m", distance, -1, 1e6, {}},
        {"distance_2", &p.distance_2, "m", distance, -1, 1e6, {}},
        {"distance_3", &p.distance_3, "m", distance, -1, 1e6, {}},
        {"degree_0", &p.degree_0, "", degree, -1, 7, {}, true, swept(curves, {4})},
        {"degree_1", &p.degree_1, "", degree, -1, 7, {}},
        {"degree_2", &p.degree_2, "", degree, -1, 7, {}},
        {"degree_3", &p.degree_3, "", degree, -1, 7, {}},
        {"rays_0", &p.rays_0, "", rays, 0, 32768, {}},
        {"rays_1", &p.rays_1, "", rays, 0, 32768, {}},
        {"rays_2", &p.rays_2, "", rays, 0, 32768, {}},
        {"rays_3", &p.rays_3, "", rays, 0, 32768, {}},
        {"hit_level", as_int(p.hit_level), "", "level in which relight rays look up the lightmap (IPR 4.2.1): of the place where they end, or the "
         "last, which is faster", -unbounded, unbounded, {"own", "coarsest"}, true, swept(curves, {1})},
        {"probe_level", as_int(p.probe_level), "", "from where a probe's level is measured (IPR figures 4.4 to 4.7): its centre, nearer by its "
         "radius, or as fine as the clusters that read it", -unbounded, unbounded, {"centre", "radius", "clusters"}},
        {"zones", &p.zones, "", "distances count for more beside and behind the viewer (IPR figure 4.8)", -unbounded, unbounded, {}, true, swept(curves, {1})},
        {"front_angle", &p.front_angle, "degrees", "from the view direction, within which distances count as they are", 1, 179, {}},
        {"side_angle", &p.side_angle, "degrees", "from the view direction, beyond which lies the zone behind", 1, 179, {}},
        {"side_scale", &p.side_scale, "", "of distances between both angles", 1, 1e6, {}},
        {"behind_scale", &p.behind_scale, "", "of distances behind", 1, 1e6, {}},
        {"smoothing", &p.smoothing, "", "share of a level's depth over which fragments change to the next (IPR 4.2.4); 0: a sharp edge", 0, 1, {}},
        {"fragment_shift", &p.fragment_shift, "m", "by which fragments take a coarser level before it is computed alone (IPR 4.2.4)", 0, 1e6, {}},
    };
    for (Field& f : all) f.uniform = false;
    return all;
}

void validate(const LodParams& params) {
    LodParams p = params;
    validate_fields("lod", fields(p));
    float last = 0;
    int degree = 7;
    for (int k = 0; k < p.levels; ++k) {
        if (const int r = rays(p)[std::size_t(k)]; r != 0 && !(power_of_two(r) && r >= 32))
            refuse(fmt::format("rays_{} = {}: expected 0, or a power of two of 32 or more: such prefixes are uniform", k, r));
        if (const int d = degrees(p)[std::size_t(k)]; d >= 0) {
            if (d > degree) refuse(fmt::format("degree_{} = {}: a level before has {}: expected no more", k, d, degree));
            degree = d;
        }
        if (k == 0) continue;
        if (const float d = distances(p)[std::size_t(k) - 1]; d >= 0) {
            if (d < last) refuse(fmt::format("distance_{} = {:g} m: a level before has {:g} m: expected ascending distances", k, d, last));
            last = d;
        } else if (d != -1)
            refuse(fmt::format("distance_{} = {:g} m: expected 0 m or more, or -1", k, d));
    }
    if (p.zones && p.side_angle < p.front_angle) refuse(fmt::format("side_angle = {:g} is less than front_angle = {:g}", p.side_angle, p.front_angle));
    if (p.zones && p.behind_scale < p.side_scale) refuse(fmt::format("behind_scale = {:g} is less than side_scale = {:g}", p.behind_scale, p.side_scale));
}

Lod lod_of(const LodParams& p, double diagonal_m, int degree, int relight_rays, int gap) {
    validate(p);
    if (!(diagonal_m > 0 && std::isfinite(diagonal_m))) refuse("the scene has no extent");
    Lod lod;
    lod.levels = p.levels, lod.rule.levels = p.levels;
    lod.hit_level = p.hit_level, lod.probe_level = p.probe_level;
    take_distances(p, diagonal_m, lod);
    take_zones(p, lod.rule);
    for (std::size_t k = 0; k < std::size_t(n); ++k) {
        const std::size_t before = k == 0 ? 0 : k - 1;
        if (int(k) >= p.levels) {
            lod.rays[k] = lod.rays[before], lod.degree[k] = lod.degree[before];
        } else {
            lod.rays[k] = take_rays(p, int(k), relight_rays, k == 0 ? relight_rays : lod.rays[before]);
            lod.degree[k] = take_degree(p, int(k), lod.rays[k], relight_rays, k == 0 ? degree : lod.degree[before], lod.notes);
        }
        lod.coefficients[k] = (lod.degree[k] + 1) * (lod.degree[k] + 1);
    }
    if (const int apart = lookup_reach << (p.levels - 1); p.levels > 1 && gap < apart)
        lod.notes.push_back(fmt::format("gap = {}: level {} mixes charts that lie less than {} texels apart; bake with gap = {}", gap, p.levels - 1,
                                        apart, apart));
    return lod;
}

LevelRule rule_at(const Lod& lod, const glm::vec3& eye, const glm::vec3& forward) {
    const glm::dvec3 f(forward);
    const double length = std::sqrt(glm::dot(f, f));
    if (!(length > 0 && std::isfinite(length))) refuse("the view has no direction");
    LevelRule rule = lod.rule;
    rule.eye = glm::vec4(eye, 0), rule.forward = glm::vec4(glm::vec3(f / length), 0);
    return rule;
}

LevelRule fragment_rule_at(const Lod& lod, const glm::vec3& eye, const glm::vec3& forward) {
    LevelRule rule = rule_at(lod, eye, forward);
    rule.distances = lod.fragment_distances;
    return rule;
}

}  // namespace plumb::probes
