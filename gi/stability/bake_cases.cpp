// Data of a bake's stages that no scene has.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/hash.h"
#include "core/sh.h"
#include "gi/lend.h"
#include "gi/probes/coefficients.h"
#include "gi/probes/density.h"
#include "gi/probes/directions.h"
#include "gi/probes/level.h"
#include "gi/probes/share.h"
#include "gi/probes/supports.h"
#include "gi/stability/bake.h"
#include "gi/stability/radiosity.h"
#include "gi/stability/reuse.h"
#include "gi/stability/relight.h"

namespace plumb::stability {

namespace {

using Points = Buffer<glm::vec4>;

constexpr const char* group = "probes";

// Numbers of [0, 1).
float noise(int i, int channel) { return unit_float<float>(pixel_hash<std::int32_t>(i, channel, 5, 7).x); }

Points scattered(int n, float size, int seed) {
    Points p;
    for (int i = 0; i < n; ++i) p.push_back({size * noise(i, seed), size * noise(i, seed + 1), size * noise(i, seed + 2), 0});
    return p;
}

template <class Kernel>
StageData own(StageData data, const std::string& name) {
    data = owned(stage<Kernel>(), data);
    data.label = data.stage + " (" + name + ")";
    return data;
}

// ---- Candidates and supports
// -----------------------------------------------------------------------------------------

BakeCase candidates(const std::string& name, const std::string& meaning, const Points& positions, float radius) {
    return {name, group, meaning, [=] {
                return std::vector{own<probes::DensityKernel>(probes::data_of(probes::DensityInputs{&positions, radius}), name)};
            }};
}

BakeCase supports(const std::string& name, const std::string& meaning, const Points& receivers, const Points& all, float radius,
                  int overlaps = 10) {
    return {name, group, meaning, [=] {
                probes::SupportsInputs in;
                in.receivers = &receivers, in.probes = &all, in.radius = radius, in.overlaps = overlaps;
                return std::vector{own<probes::SupportsKernel>(probes::data_of(in, 0, int(receivers.size())), name)};
            }};
}

// The float `steps` after x.
float stepped(float x, int steps) { return number<float>::from_bits(number<float>::bits(x) + steps); }

// Along an axis, at distances about 0.7 that differ by an ULP.
Points near_the_radius() {
    Points p = {{0, 0, 0, 0}};
    for (int k = -8; k <= 8; ++k) p.push_back({stepped(0.7f, k), 0, 0, 0});
    return p;
}

Points coplanar(int side, float z) {
    Points p;
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) p.push_back({0.25f * float(x), 0.25f * float(y), z, 0});
    return p;
}

// Corners of a cube and of an octahedron in it, as far from its middle.
Points around(const glm::vec3& middle) {
    Points p;
    for (int i = 0; i < 8; ++i) p.push_back({middle + glm::vec3(i & 1 ? 3 : -3, i & 2 ? 3 : -3, i & 4 ? 3 : -3), 0});
    for (int i = 0; i < 6; ++i) {
        glm::vec3 d(0);
        d[i / 2] = i % 2 ? 5.19615242f : -5.19615242f;
        p.push_back({middle + d, 0});
    }
    return p;
}

void add_candidates(std::vector<BakeCase>& out) {
    out.push_back(candidates("candidate alone", "one candidate: nothing lies around it", {{1, 2, 3, 0}}, 1));
    out.push_back(candidates("candidates in one place", "40 of them: each counts whole", Points(40, glm::vec4(0.3f, 0.2f, 0.1f, 0)), 1));
    out.push_back(candidates("candidates at the radius", "distances within 8 ULP of the kernel's radius", near_the_radius(), 0.7f));
    out.push_back(candidates("4096 candidates in reach", "a sum of 4096 weights", scattered(4096, 1, 10), 2));
    out.push_back(candidates("candidates 1e-14 apart", "as is the kernel's radius", scattered(64, 2e-14f, 20), 1e-14f));
    out.push_back(candidates("candidates 1e14 apart", "as is the kernel's radius", scattered(64, 2e14f, 20), 1e14f));
    out.push_back(candidates("candidates 3e38 apart", "whose squared distances overflow: they weigh nothing",
                             {{3e38f, 0, 0, 0}, {-3e38f, 0, 0, 0}, {0, 3e38f, -3e38f, 0}, {0, 0, 0, 0}, {0.5f, 0, 0, 0}}, 1));
    out.push_back(candidates("denormal candidates", "coordinates of 1e-40", scattered(16, 1e-40f, 20), 1));
    out.push_back(candidates("radius of 1e-20", "squares of such distances are denormal: refused", scattered(16, 1e-20f, 20), 1e-20f));
}

void add_supports(std::vector<BakeCase>& out) {
    const Points in_room = scattered(40, 4, 30), probes = scattered(12, 4, 40);
    out.push_back(supports("one receiver, one probe", "the least bake there is", {{0.25f, 0.5f, 0.75f, 0}}, {{1, 1, 1, 0}}, 2));
    out.push_back(supports("receivers on probes", "each lies where a probe is", probes, probes, 2));
    out.push_back(supports("receivers at the radius", "distances within 8 ULP of the probes' radius", near_the_radius(), {{0, 0, 0, 0}}, 0.7f));
    out.push_back(supports("probes equally far", "14 probes as far from a receiver, of which 10 are asked for",
                           {{0.1f, 0.2f, 0.3f, 0}, {0, 0, 0, 0}}, around({0.1f, 0.2f, 0.3f}), 8));
    out.push_back(supports("coplanar receivers", "receivers and probes in one plane, on grids", coplanar(8, 2), coplanar(4, 2), 0.6f));
    out.push_back(supports("fewer probes than slots", "two probes, 16 slots", in_room, {probes[0], probes[1]}, 3, 16));
    out.push_back(supports("probes far away", "1e30 m: no receiver has any", in_room, {{1e30f, 0, 0, 0}, {0, -1e30f, 0, 0}}, 2));
    Points close = in_room, close_probes = probes, wide = in_room, wide_probes = probes;
    for (Points* p : {&close, &close_probes})
        for (glm::vec4& x : *p) x *= 1e-14f;
    for (Points* p : {&wide, &wide_probes})
        for (glm::vec4& x : *p) x *= 1e14f;
    out.push_back(supports("probes 1e-14 m apart", "as is their radius", close, close_probes, 2e-14f));
    out.push_back(supports("probes 1e14 m apart", "as is their radius", wide, wide_probes, 2e14f));
    out.push_back(supports("denormal receivers", "coordinates of 1e-40", scattered(16, 1e-40f, 20), probes, 2));
}

// ---- Levels of detail
// -----------------------------------------------------------------------------------------------

BakeCase levels(const std::string& name, const std::string& meaning, const Points& low, const Points& high, float distance) {
    return {name, group, meaning, [=] {
                probes::LevelRule rule;
                rule.levels = 4, rule.forward = {0, 0, 1, 0}, rule.margins = {1, 2, 4, 0};
                rule.distances = {distance, 2 * distance, 4 * distance, 0};
                rule.zones = {0.5f, 0.8660254f, -0.5f, 0.8660254f}, rule.scales = {1, 2, 4, 0};
                return std::vector{own<probes::LevelKernel>(probes::data_of(probes::LevelInputs{&low, &high, rule}), name)};
            }};
}

Points times(Points points, float factor) {
    for (glm::vec4& p : points) p *= factor;
    return points;
}

void add_levels(std::vector<BakeCase>& out) {
    const Points boxes = scattered(64, 8, 60);
    Points high = boxes;
    for (glm::vec4& p : high) p += glm::vec4(1, 1, 1, 0);
    Points margins = boxes;
    for (glm::vec4& p : margins) p.w = 2;
    out.push_back(levels("viewer in the box", "a box around the eye, and one that touches it", {{-1, -1, -1, 0}, {0, -1, -1, 0}},
                         {{1, 1, 1, 0}, {1, 1, 1, 0}}, 2));
    out.push_back(levels("boxes at a level's distance", "distances within 8 ULP of it", near_the_radius(), near_the_radius(), 0.7f));
    out.push_back(levels("boxes within their margin", "nearer than margins reach: distances are 0", margins, high, 2));
    out.push_back(levels("boxes 1e-14 m apart", "as are levels", times(boxes, 1e-14f), times(high, 1e-14f), 2e-14f));
    out.push_back(levels("boxes 1e14 m apart", "as are levels", times(boxes, 1e14f), times(high, 1e14f), 2e14f));
    out.push_back(levels("a box at the apex of the zones", "a point where the eye is: its direction is none", {{0, 0, 0, 0}}, {{0, 0, 0, 0}}, 1));
}

// ---- Rays
// ------------------------------------------------------------------------------------------------------------

// What rays of receivers met, as both stages are given it: probe i of a receiver at `probe(i)`, of weight `weight`.
struct RayData {
    int receivers = 1, rays = 32, slots = 1;
    Points supporting, seen;
    std::vector<std::int32_t> visible;
    Buffer<float> lengths, factors, shares;

    RayData(int n, int rays_of_each, int slots_of_each) : receivers(n), rays(rays_of_each), slots(slots_of_each) {
        const std::size_t pairs = std::size_t(rays) * std::size_t(receivers);
        for (int i = 0; i < slots * receivers; ++i)
            supporting.push_back({noise(i, 50) - 0.5f, noise(i, 51) - 0.5f, noise(i, 52) - 0.5f, 0.25f + 0.5f * noise(i, 53)});
        const Points directions = probes::relight_directions(rays);
        for (int k = 0; k < rays; ++k)
            for (int i = 0; i < receivers; ++i) seen.push_back(glm::vec4(2.0f * glm::vec3(directions[std::size_t(k)]), 1));
        for (std::size_t i = 0; i < pairs; ++i) lengths.push_back(0.5f + noise(int(i), 54));
        visible.assign(pairs, (1 << slots) - 1);
        factors.assign(std::size_t(rays), 3.14159265f / float(rays));
        shares.assign(pairs, 3.14159265f / float(rays));
    }
};

StageData share_data(const RayData& r, bool published, const std::string& name) {
    return own<probes::ShareKernel>(probes::data_of(probes::ShareInputs{r.receivers, r.rays, r.slots, published, r.supporting.data(),
                                                                        r.factors.data(), r.visible.data(), r.lengths.data()}),
                                    name);
}
StageData coefficients_data(const RayData& r, int degree, const std::string& name) {
    const std::vector<std::int32_t> rows = probes::coefficient_rows(r.slots, degree);
    return own<probes::CoefficientsKernel>(
        probes::data_of(probes::CoefficientsInputs{r.receivers, r.rays, r.slots, degree, rows.data(), r.supporting.data(), r.seen.data(),
                                                   r.visible.data(), r.shares.data()}),
        name);
}

using Change = void (*)(RayData&);

BakeCase shares(const std::string& name, const std::string& meaning, Change change) {
    return {name, group, meaning, [=] {
                RayData r(8, 32, 3);
                change(r);
                return std::vector{share_data(r, false, name), share_data(r, true, name)};
            }};
}
BakeCase coefficients(const std::string& name, const std::string& meaning, Change change, int rays = 32, int receivers = 4,
                      int degree = 7) {
    return {name, group, meaning, [=] {
                RayData r(receivers, rays, 1);
                change(r);
                return std::vector{coefficients_data(r, degree, name)};
            }};
}

void put_lengths(RayData& r, float length) { std::fill(r.lengths.begin(), r.lengths.end(), length); }
void put_weights(RayData& r, float weight) {
    for (glm::vec4& s : r.supporting) s.w = weight;
}
// What is seen lies that far from the probe, in the direction that it has now.
void put_distances(RayData& r, float distance) {
    for (std::size_t i = 0; i < r.seen.size(); ++i) {
        const glm::vec3 d = glm::vec3(r.seen[i]) * 0.5f, probe(r.supporting[i % std::size_t(r.receivers)]);
        r.seen[i] = glm::vec4(probe + distance * d, 1);
    }
}
// The probe at the origin: directions are what is seen.
void put_directions(RayData& r, glm::vec3 (*direction)(int)) {
    for (glm::vec4& s : r.supporting) s = {0, 0, 0, s.w};
    for (std::size_t i = 0; i < r.seen.size(); ++i) r.seen[i] = glm::vec4(direction(int(i)), 1);
}

glm::vec3 near_a_pole(int i) {
    constexpr float off[] = {0, 1e-20f, 1e-10f, 1e-7f, 3e-4f, 1e-2f};
    const float z = i % 2 ? -2.0f : 2.0f;
    return {off[i / 2 % 6] * (noise(i, 60) - 0.5f), off[i / 12 % 6] * (noise(i, 61) - 0.5f), z};
}
// Zeros of Legendre's polynomials of degree 1, 2, 3 and 7 in z, and of sines and cosines of m phi around it.
glm::vec3 on_nodes(int i) {
    constexpr float z[] = {0, 0.577350269f, -0.577350269f, 0.774596669f, 0.405845151f, -0.949107912f};
    constexpr glm::vec2 around[] = {{1, 0}, {0, 1}, {1, 1}, {-1, 1}, {1, 0.414213562f}, {1, 0.577350269f}};
    const float height = z[i % 6];
    return {glm::normalize(around[i / 6 % 6]) * std::sqrt(1 - height * height), height};
}

void add_shares(std::vector<BakeCase>& out) {
    out.push_back(shares("probes that see nothing", "receivers whose rays no probe follows: black", [](RayData& r) {
        std::fill(r.visible.begin(), r.visible.end(), 0);
    }));
    out.push_back(shares("weights of 1e-14", "probes at the very end of their radius", [](RayData& r) { put_weights(r, 0x1.8p-47f); }));
    out.push_back(shares("weights apart by 1e14", "one probe at the end of its radius, the others near", [](RayData& r) {
        for (std::size_t i = 0; i < r.supporting.size(); i += 2) r.supporting[i].w = 0x1.8p-47f;
    }));
    out.push_back(shares("denormal weights", "no probe has such: refused", [](RayData& r) { put_weights(r, 1e-40f); }));
    out.push_back(shares("weights that are no numbers", "refused", [](RayData& r) {
        put_weights(r, std::numeric_limits<float>::quiet_NaN());
    }));
    out.push_back(shares("hits 0 m away", "rays that end where they begin", [](RayData& r) { put_lengths(r, 0); }));
    out.push_back(shares("hits 1e-5 m away", "W(x) of 6e-10, in the published weighting", [](RayData& r) { put_lengths(r, 1e-5f); }));
    out.push_back(shares("hits 1e15 m away", "as far as rays that meet nothing", [](RayData& r) { put_lengths(r, 1e15f); }));
    out.push_back(shares("hits infinitely far", "refused: a ray that meets nothing has 1e15 m", [](RayData& r) {
        put_lengths(r, std::numeric_limits<float>::infinity());
    }));
    out.push_back(shares("rays that weigh nothing", "along the surface: factors of 0, 1e-40 and 1e-30", [](RayData& r) {
        constexpr float f[] = {0, 1e-40f, 1e-30f};
        for (std::size_t k = 0; k < r.factors.size(); ++k) r.factors[k] = f[k % 3];
    }));
}

void add_coefficients(std::vector<BakeCase>& out) {
    out.push_back(coefficients("harmonics at the poles", "directions within 1e-2 of z, and z itself, to degree 7",
                               [](RayData& r) { put_directions(r, near_a_pole); }));
    out.push_back(coefficients("harmonics on their nodes", "directions where one of them is 0",
                               [](RayData& r) { put_directions(r, on_nodes); }));
    out.push_back(coefficients("degree 0", "one coefficient a probe", [](RayData&) {}, 32, 16, 0));
    out.push_back(coefficients("2048 rays", "sums of as many terms, of which the first are equal", [](RayData&) {}, 2048, 1));
    out.push_back(coefficients("32767 rays", "as many as a receiver may have, all alike", [](RayData&) {}, 32767, 1, 0));
    out.push_back(coefficients("hits on a probe", "what is seen lies where the probe is: no direction", [](RayData& r) {
        put_distances(r, 0);
    }));
    out.push_back(coefficients("hits 1e-7 m from a probe", "an ULP or two of its coordinates", [](RayData& r) { put_distances(r, 1e-7f); }));
    out.push_back(coefficients("hits 1e-20 m from a probe", "less than the least distance", [](RayData& r) {
        put_weights(r, 1);
        for (glm::vec4& s : r.supporting) s = {0, 0, 0, s.w};
        put_distances(r, 1e-20f);
    }));
    out.push_back(coefficients("hits 2^59 m from a probe", "as far as scenes reach", [](RayData& r) { put_distances(r, 0x1p59f); }));
    out.push_back(coefficients("hits 2^61 m from a probe", "refused: squares leave a float's range", [](RayData& r) {
        put_distances(r, 0x1p61f);
    }));
    out.push_back(coefficients("a hit that is no number", "refused", [](RayData& r) {
        r.seen[3].y = std::numeric_limits<float>::quiet_NaN();
    }));
    out.push_back(coefficients("shares of 1e14", "times weights of 1e-14", [](RayData& r) {
        put_weights(r, 0x1.8p-47f);
        for (float& s : r.shares) s /= 0x1.8p-47f;
    }));
}

}  // namespace

const std::vector<BakeCase>& bake_cases() {
    static const std::vector<BakeCase> all = [] {
        std::vector<BakeCase> list;
        add_candidates(list), add_supports(list), add_levels(list), add_shares(list), add_coefficients(list);
        for (BakeCase& c : relight_cases()) list.push_back(std::move(c));
        add_update_cases(list), add_radiosity_cases(list), add_reuse_cases(list);
        return list;
    }();
    return all;
}

}  // namespace plumb::stability
