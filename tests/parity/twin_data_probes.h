// Data for the stages of a bake of probes, and of a volume of DDGI's.
#pragma once

#include <vector>

#include "core/sh.h"
#include "gi/ddgi/blend.h"
#include "gi/ddgi/sample.h"
#include "gi/probes/lightmap_uv.h"
#include "gi/probes/lookup.h"
#include "gi/probes/coefficients.h"
#include "gi/probes/density.h"
#include "gi/probes/indirect_shadow.h"
#include "gi/probes/level.h"
#include "gi/probes/relief.h"
#include "gi/probes/share.h"
#include "gi/probes/supports.h"
#include "gi/probes/update.h"
#include "gi/probes/volume.h"
#include "tests/parity/twin_data_parts.h"
#include "tests/parity/update_data.h"

namespace plumb::test {

// ---- Probes ----------------------------------------------------------------------------------------------------------

inline Buffer<glm::vec4> scattered(int n, std::uint32_t seed) {
    Buffer<glm::vec4> list;
    for (int i = 0; i < n; ++i) list.push_back({noise(i, 0, 0, seed), noise(i, 1, 0, seed), noise(i, 2, 0, seed), 0});
    return list;
}
// The last items of the domain are none, and one more lies behind the list.
inline StageData density_case(glm::ivec2 size, float radius, const std::string& id) {
    const int n = size.x * size.y - 5;
    const Buffer<glm::vec4> positions = scattered(n + 1, 81);
    StageData d = begin_data<probes::DensityKernel>(size, probes::DensityUniforms{size.x, size.y, n, 1 / radius});
    lend(d.inputs, "positions", {n + 1, 4}, &positions[0].x);
    return named(owned_data(d), id);
}
// The last probe lies behind the list; every third receiver is a little farther than the radius from one.
inline StageData supports_case(glm::ivec2 size, float radius, int overlaps, const std::string& id) {
    const int n = 40;
    Buffer<glm::vec4> receivers = scattered(size.y, 82), all = scattered(n + 1, 83);
    for (std::size_t i = 0; i < receivers.size(); i += 3)
        receivers[i] = all[i % n] + glm::vec4(1.002f * radius, 0, 0, 0);
    StageData d = owned_data(probes::data_of({&receivers, &all, radius, std::min(size.x, overlaps)}, 0, size.y));
    const double probes = n;
    set_uniform(parity::find_binding(d.stage, "test"), d, "probes", {&probes, 1}, "test");
    return named(d, id);
}

inline probes::LevelUniforms level_uniforms(glm::ivec2 size, int count, int levels, const glm::vec3& distances) {
    return {size.x, size.y, count, levels, {0.25f, -0.5f, 0.75f, 0}, {0.48f, 0.6f, -0.64f, 0}, {0.5f, 0.8660254f, -0.25f, 0.96824584f},
            {1, 1.5f, 3, 0}, {distances.x, distances.y, distances.z, 0}, {1.125f, 2, 4, 0}};
}
inline StageData level_data(const probes::LevelUniforms& u, const Buffer<glm::vec4>& low, const Buffer<glm::vec4>& high, const std::string& id) {
    StageData d = begin_data<probes::LevelKernel>({u.width, u.height}, u);
    lend(d.inputs, "low", {std::int64_t(low.size()), 4}, &low[0].x);
    lend(d.inputs, "high", {std::int64_t(high.size()), 4}, &high[0].x);
    return named(owned_data(d), id);
}

// Boxes and points around an eye, near and far, before it and behind; every seventh holds it. One more lies behind the list.
inline StageData level_case(glm::ivec2 size, int levels, const glm::vec3& distances, const std::string& id) {
    const int n = size.x * size.y - 5;
    Buffer<glm::vec4> low = scattered(n + 1, 86), high = low;
    for (int i = 0; i <= n; ++i) {
        glm::vec4 &a = low[std::size_t(i)], &b = high[std::size_t(i)];
        a = 16.0f * (a - 0.5f), a.w = i % 3 == 0 ? 0 : 0.5f * noise(i, 3, 0, 86);
        for (int c = 0; c < 3; ++c) b[c] = a[c] + (i % 2 == 0 ? 3 * noise(i, c, 1, 86) : 0);
        if (i % 7 == 0)
            for (int c = 0; c < 3; ++c) a[c] = -a[c] < 0 ? -a[c] : a[c], b[c] = -a[c] + 1;
        b.w = 0;
    }
    return level_data(level_uniforms(size, n, levels, distances), low, high, id);
}

// Boxes whose level is another where they lie half a hundredth nearer or farther, are so much smaller or larger, or their margin is;
// and points and grown boxes beyond a cone by half of what is left for rounding, or by nine tenths (level_kernel.h).
inline StageData level_edges_case(glm::ivec2 size, const std::string& id) {
    const int n = size.x * size.y;
    const probes::LevelUniforms u = level_uniforms(size, n, 4, {2.5f, 5, 9});
    const glm::vec3 eye(u.eye[0], u.eye[1], u.eye[2]), forward(u.forward[0], u.forward[1], u.forward[2]);
    const auto level_of = [&](const glm::vec4& low, const glm::vec4& high) {
        probes::LevelView view{u, &low.x, &high.x, nullptr};
        view.u.count = 1;
        NoTap tap;
        return probes::level_of_box<float>(view, 0, 0, tap).level;
    };
    // About a point, all but the margin; the margin by a factor of its own.
    const auto scaled = [](const glm::vec4& x, const glm::vec3& about, float factor, float margin) {
        return glm::vec4(about + factor * (glm::vec3(x) - about), x.w * margin);
    };
    Buffer<glm::vec4> low, high;
    for (int i = 0; int(low.size()) < n; ++i) {
        const int kind = int(low.size()) % 8;
        const glm::vec3 towards = normalize3<float>(glm::vec3(noise(i, 0, 2, 86), noise(i, 1, 2, 86), noise(i, 2, 2, 86)) - 0.5f);
        glm::vec4 a, b;
        if (kind < 2) {
            // The angle of a cone and half of 1e-5, towards any side; distances of all levels.
            const float* cone = u.zones + 2 * (i % 2);
            const glm::vec3 across = normalize3<float>(towards - glm::dot(towards, forward) * forward);
            const double c = cone[0], s = cone[1], more = 0.5e-5;
            const glm::dvec3 v = (0.8 + 5.0 * double(noise(i, 3, 2, 86))) * ((c - s * more) * glm::dvec3(forward) + (s + c * more) * glm::dvec3(across));
            a = b = glm::vec4(eye + glm::vec3(v), 0);
            if (kind == 1) {
                // Grown to where the cone's distance is its radius and a part of what is left.
                const glm::dvec3 w = glm::dvec3(a) - glm::dvec3(eye);
                const double turned = 0.02 + 0.3 * double(noise(i, 4, 2, 86));
                const glm::dvec3 t = glm::length(w) * ((c - s * turned) * glm::dvec3(forward) + (s + c * turned) * glm::dvec3(across));
                a = b = glm::vec4(eye + glm::vec3(t), 0);
                const glm::dvec3 from = glm::dvec3(a) - glm::dvec3(eye);
                const double along = glm::dot(from, glm::dvec3(forward)), aside = glm::length(from - along * glm::dvec3(forward));
                const double beyond = aside * c - along * s;
                const double part = i % 4 < 2 ? 0.5e-5 : 0.9e-5;
                a.w = float((beyond - part * glm::length(from)) / (1 + part) / double(u.margins[2]));
            }
        } else {
            a = b = glm::vec4(eye + (0.3f + 14 * noise(i, 3, 2, 86)) * towards, kind % 2 == 0 ? 0 : 0.5f * noise(i, 4, 2, 86));
            if (kind >= 4)
                for (int c = 0; c < 3; ++c) b[c] += (c == i % 3 ? 4.0f : 0.5f) * noise(i, 5 + c, 2, 86);
            const float least = 0.995f, most = 1.005f;
            const glm::vec3 middle = 0.5f * (glm::vec3(a) + glm::vec3(b));
            const bool by_distance = level_of(scaled(a, eye, least, 1), scaled(b, eye, least, 1)) != level_of(scaled(a, eye, most, 1), scaled(b, eye, most, 1));
            const bool by_size = level_of(scaled(a, middle, least, 1), scaled(b, middle, least, 1)) != level_of(scaled(a, middle, most, 1), scaled(b, middle, most, 1));
            const bool by_margin = level_of(scaled(a, eye, 1, least), b) != level_of(scaled(a, eye, 1, most), b);
            if (kind < 6 ? !by_distance : kind == 6 ? !by_size : !by_margin) continue;
        }
        b.w = 0;
        low.push_back(a), high.push_back(b);
    }
    return level_data(u, low, high, id);
}

// What receivers' rays met: points, directions of those that met nothing, what no probe sees; a probe without weight.
struct RayInputs {
    int rays, slots = 3;
    Buffer<glm::vec4> supporting, seen;
    std::vector<std::int32_t> visible;
    Buffer<float> lengths, weights;

    RayInputs(int receivers, int rays_of_each) : rays(rays_of_each) {
        supporting = scattered(slots * receivers, 84), seen = scattered(rays * receivers, 85);
        for (std::size_t i = 0; i < supporting.size(); ++i) supporting[i].w = i % 7 == 3 ? 0 : noise(int(i), 3, 0, 84);
        for (std::size_t i = 0; i < seen.size(); ++i) {
            const bool escaped = i % 5 == 0;
            const glm::vec3 d = 2.0f * glm::vec3(seen[i]) - 1.0f;
            seen[i] = escaped ? glm::vec4(normalize3<float>(d), 0) : glm::vec4(5.0f * d, 1);
            visible.push_back(i % 11 == 0 ? 0 : std::int32_t(8 * noise(int(i), 4, 0, 85)));
            lengths.push_back(escaped ? 1e15f : 4 * noise(int(i), 5, 0, 85));
            weights.push_back(0.01f + noise(int(i), 6, 0, 85));
        }
    }
};
inline StageData share_case(glm::ivec2 size, bool published, const std::string& id) {
    const RayInputs r(size.x, size.y);
    probes::ShareInputs in{size.x, size.y, r.slots, published, r.supporting.data(), r.weights.data(), r.visible.data(),
                           r.lengths.data()};
    return named(owned_data(probes::data_of(in)), id);
}
// size.y rows, of all degrees; of few receivers, for there are many rays: a whole part of the sum, and three more.
inline StageData coefficients_case(glm::ivec2 size, const std::string& id) {
    size.x = std::min(size.x, 5);
    const RayInputs r(size.x, 131);
    const std::vector<std::int32_t> all = probes::coefficient_rows(r.slots, 7);
    std::vector<std::int32_t> rows;
    for (int y = 0; y < size.y; ++y)
        for (int c = 0; c < 4; ++c) rows.push_back(all[std::size_t((17 * y % (64 * r.slots)) * 4 + c)]);
    StageData d = begin_data<probes::CoefficientsKernel>(size, probes::CoefficientsUniforms{size.x, size.y, r.rays, r.slots});
    const std::int64_t receivers = size.x;
    lend(d.inputs, "rows", {size.y, 4}, rows.data());
    lend(d.inputs, "recurrence", {sh::recurrence_size}, sh::recurrence().data());
    lend(d.inputs, "supporting", {r.slots * receivers, 4}, &r.supporting[0].x);
    lend(d.inputs, "seen", {r.rays * receivers, 4}, &r.seen[0].x);
    lend(d.inputs, "visible", {r.rays * receivers}, r.visible.data());
    lend(d.inputs, "shares", {r.rays * receivers}, r.weights.data());
    return named(owned_data(d), id);
}

// A cluster a row, of all ranks and of 0 to 6 of 9 probes, matrices and probes in another order than the clusters'; of each level of
// detail, and of one that is none.
inline StageData basis_case(glm::ivec2 size, const std::string& id) {
    size.x = std::min(size.x, probes::most_singular_values);
    std::vector<MadeCluster> kinds;
    for (int c = 0; c < size.y; ++c) kinds.push_back({1, (c + 2) % 7, (5 * c + 3) % (size.x + 1)});
    probes::ClusterData d = probes::cluster_data(made_clusters(kinds, 9, 10, size.x, 0, 86), size.y, 10);
    std::reverse(d.clusters.begin(), d.clusters.end());
    std::vector<std::int32_t> level;
    for (int c = 0; c < size.y; ++c) level.push_back((c + 1) % 6 - 1);
    const Buffer<glm::vec4> lambda = made_lambda(9, 10, 87);
    probes::BasisInputs in;
    in.clusters = &d, in.cluster_level = level.data(), in.lambda = lambda.data(), in.probes = 9, in.coefficients = {10, 7, 4, 1};
    return named(owned_data(probes::data_of(in)), id);
}
// Places of four clusters, of ranks from 0 on, of none and of two that are not there; the last items of the domain are no places.
inline StageData irradiance_case(glm::ivec2 size, const std::string& id) {
    const int n = size.x * size.y - 5, kept = 6, clusters = 4;
    const std::vector<glm::ivec4> table = {{0, 0, 0, 6}, {0, 0, 0, 4}, {0, 0, 0, 0}, {0, 0, 0, 1}};
    const std::vector<std::int32_t> cluster_level = {0, 2, 1, 1};
    std::vector<std::int32_t> cluster, level;
    Buffer<float> u;
    for (int i = 0; i < n; ++i) {
        cluster.push_back(int(8 * noise(i, 0, 0, 88)) - 2), level.push_back(int(4 * noise(i, 1, 0, 88)));
        if (cluster.back() == -2) cluster.back() = 0;
    }
    for (int k = 0; k < kept * n; ++k) u.push_back(2 * noise(k, 2, 0, 88) - 1);
    const Buffer<glm::vec4> basis = made_lambda(clusters, kept, 89);
    StageData d = begin_data<probes::IrradianceKernel>(size, probes::IrradianceUniforms{size.x, size.y, n, clusters, kept, {}});
    lend(d.inputs, "clusters", {clusters, 4}, &table[0].x);
    lend(d.inputs, "cluster_level", {clusters}, cluster_level.data());
    lend(d.inputs, "cluster", {n}, cluster.data());
    lend(d.inputs, "receiver_level", {n}, level.data());
    lend(d.inputs, "transport", {kept, n}, u.data());
    lend(d.inputs, "basis", {clusters * kept, 4}, &basis[0].x);
    return named(owned_data(d), id);
}
// Receivers in patches up to the edges, with both rings; texels of nothing, one of a place that is not there, and rings that nothing
// lies beside. The first place is many texels'; all around lie rings, and behind the list receivers that none of them has beside it.
inline StageData lightmap_case(glm::ivec2 size, const std::string& id) {
    const int side = std::max(size.x, size.y);
    const std::vector<glm::ivec2> texels = made_texels(side, 0.3f, 90);
    std::vector<std::int32_t> place_of;
    for (std::size_t i = 0; i < texels.size(); ++i) place_of.push_back(std::int32_t((i * 7919 + 1) % texels.size()));
    const Image<std::int32_t> all = probes::lightmap_cover(texels, place_of, side, 1);
    Image<std::int32_t> cover(size.x, size.y);
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            const float odd = noise(x, y, 0, 91);
            cover(x, y) = odd < 0.01f ? int(texels.size()) : odd < 0.03f ? -2 : odd < 0.05f ? -3 : odd < 0.06f ? -4 : all(x, y);
            const bool edge = x == 0 || y == 0 || x == size.x - 1 || y == size.y - 1;
            if (odd > 0.9f) cover(x, y) = 0;
            if (edge && odd < 0.7f) cover(x, y) = odd < 0.35f ? -2 : -3;
        }
    std::vector<std::int32_t> list(cover.texels.begin(), cover.texels.end());
    for (int k = 0; k <= size.x; ++k) list.push_back(1);
    // A value more than there are places: what reads it, reads beyond.
    Buffer<glm::vec4> irradiance = made_lambda(int(texels.size()) + 1, 1, 92);
    irradiance.back() = glm::vec4(1e4f);
    StageData d = begin_data<probes::LightmapKernel>(size, probes::LightmapUniforms{size.x, size.y, int(texels.size()), 0});
    lend(d.inputs, "cover", {std::int64_t(list.size())}, list.data());
    lend(d.inputs, "irradiance", {std::int64_t(irradiance.size()), 4}, &irradiance[0].x);
    return named(owned_data(d), id);
}
// Points within the grid, beyond it, a kilometre away, and none; a third of them has a lightmap. Some irradiance is negative, or none: in the
// last layer all of its red.
inline StageData volume_case(glm::ivec2 size, probes::VolumeForm form, bool everywhere, const std::string& id) {
    const Points p = room(size, 86);
    Image4 uv(size.x, size.y);
    for (int i = 0; i < size.x * size.y; ++i) uv.texels[std::size_t(i)] = i % 3 == 1 ? glm::vec4(i % 2 == 0 ? 0.0f : 0.25f, -1, 0, 0) : glm::vec4(-1, 0.5f, 0, 0);
    Buffer<glm::vec4> irradiance = scattered(3 * 2 * 4 * 6, 87);
    for (std::size_t i = 0; i < irradiance.size(); i += 7) irradiance[i] *= i % 2 == 0 ? 0.0f : -0.1f;
    for (std::size_t i = 3 * 2 * 3 * 6; i < irradiance.size(); ++i) irradiance[i].x = -0.1f - irradiance[i].x;
    probes::VolumeInputs in;
    in.grid = {{3, 2, 4}, {-1.5f, -0.3f, -2.6f}, {1.3f, 1.1f, 0.9f}};
    in.form = form, in.everywhere = everywhere, in.irradiance = &irradiance;
    in.position = &p.position, in.normal = &p.normal, in.lightmap_uv = &uv;
    return named(owned_data(probes::data_of(in)), id);
}

// Pixels on triangles all over, or a little off, some beside theirs; one triangle has no area, one moves, and some pixels see nothing.
// Levels of detail, blended; the viewer looks aslant, so that all zones are met.
inline StageData lightmap_uv_case(glm::ivec2 size, int levels, const std::string& id) {
    constexpr int charted_count = 13;
    probes::ChartedTriangles charted;
    const Buffer<glm::vec4> corners = scattered(3 * charted_count, 98), others = scattered(charted_count, 99);
    for (int t = 0; t < charted_count; ++t) {
        for (int k = 0; k < 3; ++k) {
            const glm::vec4& c = corners[std::size_t(3 * t + (t == 7 ? 0 : k))];
            charted.corners.emplace_back(6.0f * glm::vec3(c) - 3.0f, noise(t, k, 5, 98));
        }
        charted.corners.push_back(others[std::size_t(t)]);
    }
    for (int t = 0; t < charted_count + 2; ++t) charted.charted_of.push_back(t == 4 ? -1 : (5 * t + 2) % (charted_count + 1));
    Image4 position(size.x, size.y);
    Image<glm::ivec2> found(size.x, size.y);
    for (int i = 0; i < size.x * size.y; ++i) {
        const int triangle = i % 17 == 3 ? -1 : i % 19 == 5 ? charted_count + 4 : i % (charted_count + 2);
        found.texels[std::size_t(i)] = {i % 3, triangle};
        const int of = triangle < 0 ? 0 : charted.charted_of[std::size_t(std::min(triangle, charted_count + 1))] % charted_count;
        const glm::vec4* c = &charted.corners[std::size_t(4 * std::max(0, of))];
        const float b = 1.3f * noise(i, 0, 0, 98) - 0.1f, g = (1.2f - b) * noise(i, 1, 0, 98) - 0.1f;
        const glm::vec3 off(noise(i, 2, 0, 98), noise(i, 3, 0, 98), noise(i, 4, 0, 98));
        position.texels[std::size_t(i)] = glm::vec4(glm::vec3(c[0]) + b * glm::vec3(c[1] - c[0]) + g * glm::vec3(c[2] - c[0]) + 0.05f * off, 1);
    }
    probes::LevelRule rule;
    rule.levels = levels, rule.eye = {0.3f, -0.4f, 0.5f, 0}, rule.forward = {0.48f, 0.6f, -0.64f, 0};
    rule.zones = {0.5f, 0.8660254f, -0.5f, 0.8660254f}, rule.scales = {1, 1.5f, 2.25f, 0};
    rule.distances = {1.7f, 3.1f, 5.3f, 0}, rule.widths = {0.5f, 0.8f, 1.1f, 0};
    return named(owned_data(data_of(probes::LightmapUvInputs{&position, &found, &charted, rule})), id);
}
// All over a lightmap of three levels and beyond its edges; levels in between, below the first and above the last.
inline StageData lookup_case(glm::ivec2 size, int side, const std::string& id) {
    const Image4 lightmap = noise_image({side, probes::lightmap_rows(side, 3)}, 95, 0, 3);
    Image4 uv = noise_image(size, 96, -0.1f, 1.1f);
    const Image4 level = noise_image(size, 97, -0.5f, 3.5f);
    for (int i = 0; i < size.x * size.y; ++i) {
        glm::vec4& t = uv.texels[std::size_t(i)];
        t.z = i % 4 == 0 ? float(i % 3) : level.texels[std::size_t(i)].x, t.w = i % 7 == 5 ? 0 : 1;
    }
    return named(owned_data(data_of(probes::LookupInputs{&uv, &lightmap, 3})), id);
}

// Some pixels are the volume's own, some in the dark, some lit from behind; exponents are 0 to 200.
inline StageData relief_case(glm::ivec2 size, bool maps, bool highlights, bool lamps, const std::string& id) {
    const Points p = room(size, 88);
    const Image4 irradiance = noise_image(size, 89, 0, 3), from_light = noise_image(size, 90, 0, 3), mapped = noise_image(size, 71, 0, 3);
    Image4 plain = noise_image(size, 72, 0, 2), light = noise_image(size, 73, -1, 1), specular = noise_image(size, 74, 0, 1);
    for (int i = 0; i < size.x * size.y; ++i) {
        const std::size_t k = std::size_t(i);
        plain.texels[k] = i % 5 == 1 ? glm::vec4(0, 0, 0, 1) : glm::vec4(glm::vec3(plain.texels[k]), i % 3 == 0 ? 0 : 1);
        light.texels[k] = glm::vec4(normalize3<float>(glm::vec3(light.texels[k]) + glm::vec3(p.normal.texels[k])), 1);
        specular.texels[k].w = i % 7 == 0 ? 0 : i % 7 == 1 ? 200 * specular.texels[k].w : 9 * specular.texels[k].w;
    }
    probes::ReliefInputs in;
    in.maps = maps, in.highlights = highlights, in.most = 3, in.eye = {0.5f, 1.5f, 0.7f};
    in.position = &p.position, in.normal = &p.normal, in.irradiance = &irradiance, in.mapped = &mapped, in.plain = &plain;
    in.light = &light, in.from_light = &from_light, in.specular = &specular;
    std::vector<Light> lights = {make_light(LightType::spot, 16), make_light(LightType::directional, 16), make_light(LightType::point, 16)};
    lights[2].radius = 3.5f;  // ends in the room
    Buffer<float> visibility(lights.size() * std::size_t(size.x) * std::size_t(size.y));
    for (std::size_t i = 0; i < visibility.size(); ++i) visibility[i] = noise(int(i), 0, 0, 75);
    if (lamps) in.lights = &lights, in.visibility = &visibility;
    return named(owned_data(probes::data_of(in)), id);
}

// Spheres above, below and across the horizon of most points, some around them; a few of an object's own, one of no radius. The last lies
// behind the list.
inline StageData indirect_shadow_case(glm::ivec2 size, bool directional, const std::string& id) {
    const int count = 7;
    const Points p = room(size, 61);
    const Image4 irradiance = noise_image(size, 62, 0, 3);
    Image<glm::ivec2> found(size.x, size.y);
    for (int i = 0; i < size.x * size.y; ++i) found.texels[std::size_t(i)] = {i % 5 - 1, i};
    const Buffer<glm::vec4> at = scattered(count + 1, 63), light = scattered(6 * (count + 1), 64);
    probes::ShadowSpheres spheres;
    for (int i = 0; i <= count; ++i) {
        const glm::vec3 of(p.position.texels[std::size_t((97 * i + 31) % (size.x * size.y))]);
        const float radius = i == 3 ? 0 : 0.2f + 0.7f * noise(i, 3, 0, 63);
        spheres.rows.push_back(glm::vec4(i % 2 == 0 ? of + 0.3f * glm::vec3(at[std::size_t(i)]) : 3.0f * glm::vec3(at[std::size_t(i)]) - 1.5f, radius));
        for (int k = 0; k < 6; ++k) {
            const glm::vec4& l = light[std::size_t(6 * i + k)];
            spheres.rows.push_back((k < 3 ? 1.0f : 0.3f) * glm::vec4(1.2f * glm::vec3(l) - 0.6f, 0.5f * noise(i, k, 4, 64)));
        }
        spheres.owner.push_back({i % 3, i % 3 + i % 2});
    }
    probes::IndirectShadowInputs in;
    in.position = &p.position, in.normal = &p.normal, in.irradiance = &irradiance, in.id = &found, in.spheres = &spheres, in.directional = directional;
    StageData d = owned_data(probes::data_of(in));
    const double known = count;
    set_uniform(parity::find_binding(d.stage, "test"), d, "spheres", {&known, 1}, "test");
    return named(d, id);
}

// ---- DDGI ------------------------------------------------------------------------------------------------------------

// Tiles of half a row; the last tile has no probe, and the atlas ends within tiles.
inline StageData ddgi_blend_case(glm::ivec2 size, int side, bool moments, float hysteresis, const std::string& id) {
    const int columns = std::max(1, size.x / (side + 2) - 1), rows = (size.y + side + 1) / (side + 2), rays = 13;
    Buffer<glm::vec4> directions = scattered(rays, 91);
    for (glm::vec4& d : directions) d = glm::vec4(normalize3<float>(2.0f * glm::vec3(d) - 1.0f), 0);
    const Image4 previous = noise_image(size, 92, 0, 3);
    const Image4 hits = noise_image({rays, std::max(1, columns * rows - 1)}, 93, 0, 4);
    ddgi::BlendInputs in;
    in.side = side, in.columns = columns, in.moments = moments, in.sharpness = moments ? 50 : 1, in.hysteresis = hysteresis;
    in.scale = moments ? 1.0f : 3.14159265f, in.farthest = 3;
    in.directions = &directions, in.hits = &hits, in.previous = &previous;
    return named(owned_data(ddgi::data_of(in)), id);
}
inline StageData ddgi_border_case(glm::ivec2 size, int side, const std::string& id) {
    const Image4 atlas = noise_image(size, 94, -1, 1);
    return named(owned_data(ddgi::data_of(ddgi::BorderInputs{side, &atlas})), id);
}
// Points within the grid, beyond it, a kilometre away, and none.
inline StageData ddgi_sample_case(glm::ivec2 size, bool by_eye, const ddgi::Weighing& weighing, const std::string& id) {
    const Points p = room(size, 95);
    ddgi::SampleInputs in;
    in.grid = {{3, 2, 2}, {-1.5f, -0.3f, -2.6f}, {1.3f, 1.1f, 0.9f}};
    in.weighing = weighing, in.side = 6, in.depth_side = 8;
    Image4 view = noise_image(size, 96, -1, 1);
    for (glm::vec4& v : view.texels) v = glm::vec4(normalize3<float>(glm::vec3(v)), 0);
    const Image4 irradiance = noise_image(in.grid.atlas_size(in.side), 97, 0, 9);
    Image4 moments = noise_image(in.grid.atlas_size(in.depth_side), 98, 0, 1);
    for (glm::vec4& m : moments.texels) {
        const float mean = 0.3f + 2 * m.x;
        m = glm::vec4(mean, mean * mean + 0.4f * m.y, 0, 0);
    }
    in.position = &p.position, in.normal = &p.normal, in.view = by_eye ? nullptr : &view, in.eye = {1, 2, 3};
    in.irradiance = &irradiance, in.moments = &moments;
    return named(owned_data(ddgi::data_of(in)), id);
}

inline std::vector<StageData> probe_cases(glm::ivec2 size) {
    return {
        density_case(size, 0.3f, "probes.density"),
        supports_case(size, 0.4f, 15, "probes.supports"),  // most receivers have fewer
        supports_case(size, 2, 16, "probes.supports.all"),  // every probe is in reach
        level_case(size, 4, {2.5f, 5, 9}, "probes.level"),
        level_case(size, 2, {2.5f, 5, 9}, "probes.level.two"),
        level_case(size, 4, {0, 5, 9}, "probes.level.first_at_0"),  // below 0 it would be none
        level_case(size, 4, {0, 0, 9}, "probes.level.second_at_0"),
        level_case(size, 4, {0, 0, 0}, "probes.level.third_at_0"),
        level_edges_case(size, "probes.level.edges"),
        share_case(size, false, "probes.share"),
        share_case(size, true, "probes.share.published"),
        coefficients_case(size, "probes.coefficients"),
        basis_case(size, "probes.basis"),
        irradiance_case(size, "probes.irradiance"),
        lightmap_case(size, "probes.lightmap"),
        lightmap_uv_case(size, 4, "probes.lightmap_uv"),
        lightmap_uv_case(size, 2, "probes.lightmap_uv.two_levels"),
        lookup_case(size, 13, "probes.lookup"),
        lookup_case(size, 12, "probes.lookup.even"),  // levels of a side of 12 have 6 and 3
        volume_case(size, probes::VolumeForm::cube, false, "probes.volume.cube"),
        volume_case(size, probes::VolumeForm::linear, true, "probes.volume"),
        volume_case(size, probes::VolumeForm::angles, false, "probes.volume.angles"),
        indirect_shadow_case(size, true, "probes.indirect_shadow"),
        indirect_shadow_case(size, false, "probes.indirect_shadow.uniform"),
        relief_case(size, true, true, true, "probes.relief"),
        relief_case(size, true, true, false, "probes.relief.dark"),
        relief_case(size, false, false, true, "probes.relief.flat"),
        ddgi_blend_case(size, 4, false, 0.25f, "ddgi.blend"),
        ddgi_blend_case(size, 6, true, 0, "ddgi.blend.moments"),
        ddgi_border_case(size, 5, "ddgi.border"),
        ddgi_sample_case(size, false, {.normal_bias = 0.05f, .view_bias = 0.2f, .scale = 1.5f}, "ddgi.sample"),
        ddgi_sample_case(size, true, {.wrapped = false, .root = true, .view_bias = 0.1f}, "ddgi.sample.root"),
        ddgi_sample_case(size, true, {.visibility = false}, "ddgi.sample.blind"),
    };
}

}  // namespace plumb::test
