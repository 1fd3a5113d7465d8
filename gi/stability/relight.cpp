#include "gi/stability/relight.h"

#include <array>
#include <cmath>
#include <limits>

#include "core/hash.h"
#include "core/host_math.h"
#include "core/sh.h"
#include "gi/lend.h"
#include "gi/probes/directions.h"
#include "gi/probes/lambda.h"
#include "gi/probes/radiance.h"

namespace plumb::stability {

namespace {

using Points = Buffer<glm::vec4>;

constexpr const char* group = "probes";

// Numbers of [0, 1).
float noise(int i, int channel) { return unit_float<float>(pixel_hash<std::int32_t>(i, channel, 6, 7).x); }

template <class Kernel>
StageData own(StageData data, const std::string& name) {
    data = owned(stage<Kernel>(), data);
    data.label = data.stage + " (" + name + ")";
    return data;
}

// ---- Radiance --------------------------------------------------------------------------------------------------------

struct Brought {
    int probes = 1, rays = 32, levels = 1;
    probes::Feedback feedback = probes::Feedback::corrected;
    Points surface, emitted, direct, place;
    Image4 lightmap;

    Brought(int of_probes, int of_rays, int side, int of_levels) : probes(of_probes), rays(of_rays), levels(of_levels) {
        for (int i = 0; i < probes * rays; ++i) {
            surface.push_back({noise(i, 1), noise(i, 2), noise(i, 3), i % 7 == 2 ? 0 : 1});
            emitted.push_back({noise(i, 4), noise(i, 5), noise(i, 6), 0});
            direct.push_back({3 * noise(i, 7), noise(i, 8), noise(i, 9), 0});
            place.push_back({noise(i, 10), noise(i, 11), float(i % levels), 0});
        }
        set_lightmap(side, 0.5f, 2);
    }
    void set_lightmap(int side, float low, float high) {
        lightmap = Image4(side, probes::lightmap_rows(side, levels));
        for (std::size_t i = 0; i < lightmap.size(); ++i)
            for (int c = 0; c < 3; ++c) lightmap.texels[i][c] = low + (high - low) * noise(int(i), 20 + c);
    }
    probes::RadianceInputs inputs() const {
        probes::RadianceInputs in;
        in.probes = probes, in.rays = rays, in.side = lightmap.width, in.levels = levels, in.feedback = feedback;
        in.surface = &surface, in.emitted = &emitted, in.direct = &direct, in.place = &place, in.lightmap = &lightmap;
        return in;
    }
};

BakeCase brought(const std::string& name, const std::string& meaning, void (*change)(Brought&), int side = 16, int levels = 1) {
    return {name, group, meaning, [=] {
                Brought b(2, 32, side, levels);
                change(b);
                std::vector<StageData> all;
                for (const probes::Feedback f : {probes::Feedback::corrected, probes::Feedback::constant, probes::Feedback::material}) {
                    b.feedback = f;
                    all.push_back(own<probes::RadianceKernel>(probes::data_of(b.inputs()), name));
                }
                return all;
            }};
}

// Places `off` texels behind centres of level 0.
void put_places(Brought& b, float off) {
    const float side = float(b.lightmap.width);
    for (std::size_t i = 0; i < b.place.size(); ++i) {
        const float x = std::floor(side * noise(int(i), 12)), y = std::floor(side * noise(int(i), 13));
        b.place[i].x = (x + 0.5f + off) / side, b.place[i].y = (y + 0.5f + off) / side;
    }
}
void scale(Points& list, float by) {
    for (glm::vec4& v : list) v = glm::vec4(glm::vec3(v) * by, v.w);
}

void add_radiance(std::vector<BakeCase>& out) {
    out.push_back(brought("lookups at centres of texels", "of four levels: the texel itself", [](Brought& b) { put_places(b, 0); }, 16, 4));
    out.push_back(brought("lookups between texels", "half a texel from each", [](Brought& b) { put_places(b, 0.5f); }));
    out.push_back(brought("lookups an ULP from centres", "a share of 1e-6", [](Brought& b) { put_places(b, 1e-6f); }));
    out.push_back(brought("lookups beyond the lightmap", "its edge", [](Brought& b) {
        for (glm::vec4& p : b.place) p.x = 4 * p.x - 2, p.y = 1e20f * (p.y - 0.5f);
    }));
    out.push_back(brought("a lightmap of one texel", "every lookup is that texel", [](Brought&) {}, 1, 4));
    out.push_back(brought("a lightmap of 4096 texels", "places to 2^-24 of it", [](Brought&) {}, 4096));
    out.push_back(brought("texels apart by 1e14", "beside each other", [](Brought& b) {
        for (std::size_t i = 0; i < b.lightmap.size(); i += 3) b.lightmap.texels[i] *= 1e14f;
    }));
    out.push_back(brought("a dark lightmap", "denormal irradiance", [](Brought& b) { b.set_lightmap(16, 1e-40f, 2e-40f); }));
    out.push_back(brought("light of 1e30 W/m2", "as much as a float holds, squared not", [](Brought& b) {
        b.set_lightmap(16, 1e30f, 2e30f), scale(b.direct, 1e30f), scale(b.emitted, 1e30f);
    }));
    out.push_back(brought("a gain of almost 1", "reflectance 1 - 2^-24, and nothing else", [](Brought& b) {
        for (glm::vec4& s : b.surface) s = {0x1.fffffep-1f, 0x1.fffffep-1f, 0x1.fffffep-1f, 1};
        scale(b.direct, 0), scale(b.emitted, 0);
    }));
    out.push_back(brought("rays that end nowhere", "emission alone counts", [](Brought& b) {
        for (glm::vec4& s : b.surface) s.w = 0;
    }));
    out.push_back(brought("rays at a level that there is not", "refused", [](Brought& b) { b.place[5].z = 1; }));
    out.push_back(brought("rays that half reflect", "refused: a surface does or does not", [](Brought& b) { b.surface[9].w = 0.5f; }));
}

// ---- Coefficients of probes ------------------------------------------------------------------------------------------

// Probes of one level after the other.
struct Summed {
    int probes, rays, degree, levels = 1;
    Points radiance;
    Buffer<float> harmonics, weights;
    std::vector<std::int32_t> level;
    std::array<int, probes::most_lambda_levels> level_rays{}, coefficients{};

    Summed(int of_probes, int of_rays, int of_degree, const std::vector<int>& of_levels)
        : probes(of_probes), rays(of_rays), degree(of_degree), levels(int(of_levels.size())) {
        const Points directions = probes::relight_directions(rays);
        harmonics = probes::harmonics_of(directions, degree), weights = probes::level_weights(directions, of_levels);
        for (int i = 0; i < probes * rays; ++i) radiance.push_back({noise(i, 31), 5 * noise(i, 32), noise(i, 33), 0});
        for (int i = 0; i < probes; ++i) level.push_back(i % levels);
        for (int k = 0; k < levels; ++k)
            level_rays[std::size_t(k)] = of_levels[std::size_t(k)], coefficients[std::size_t(k)] = sh::count(std::max(degree - k, 0));
    }
    probes::LambdaInputs inputs() const {
        probes::LambdaInputs in;
        in.probes = probes, in.rays = rays, in.coefficients = sh::count(degree), in.levels = levels;
        in.level_rays = level_rays, in.level_coefficients = coefficients;
        in.radiance = &radiance, in.harmonics = &harmonics, in.weights = &weights, in.probe_level = &level;
        return in;
    }
};

BakeCase summed(const std::string& name, const std::string& meaning, void (*change)(Summed&), int rays = 64, int degree = 7,
                const std::vector<int>& levels = {}) {
    return {name, group, meaning, [=] {
                Summed s(2, rays, degree, levels.empty() ? std::vector<int>{rays} : levels);
                change(s);
                return std::vector{own<probes::LambdaKernel>(probes::data_of(s.inputs()), name)};
            }};
}

void add_lambda(std::vector<BakeCase>& out) {
    out.push_back(summed("a probe under a constant sky", "all coefficients but the first cancel", [](Summed& s) {
        s.radiance.assign(s.radiance.size(), glm::vec4(3));
    }, 512));
    out.push_back(summed("a probe of one ray", "one term", [](Summed&) {}, 1));
    out.push_back(summed("a probe of degree 0", "one coefficient", [](Summed&) {}, 64, 0));
    out.push_back(summed("a probe of 32767 rays", "all alike: 256 parts", [](Summed& s) {
        s.radiance.assign(s.radiance.size(), glm::vec4(0.1f)), s.weights.assign(s.weights.size(), 4e-4f);
    }, 32767, 0, {32767}));
    out.push_back(summed("rays apart by 1e14", "lamps beside walls in the dark", [](Summed& s) {
        for (std::size_t i = 0; i < s.radiance.size(); i += 9) s.radiance[i] *= 1e14f;
    }));
    out.push_back(summed("a probe in the dark", "denormal radiance", [](Summed& s) { scale(s.radiance, 1e-40f); }));
    out.push_back(summed("a probe that is black", "nothing to sum", [](Summed& s) { scale(s.radiance, 0); }));
    out.push_back(summed("radiance of 1e30", "as much as a float holds, squared not", [](Summed& s) { scale(s.radiance, 1e30f); }));
    out.push_back(summed("probes of two levels", "one of 64 rays to degree 7, one of 9 to degree 6", [](Summed&) {}, 64, 7, {64, 9}));
    out.push_back(summed("a probe of a level that there is not", "refused", [](Summed& s) { s.level[1] = 1; }));
}

}  // namespace

std::vector<BakeCase> relight_cases() {
    std::vector<BakeCase> list;
    add_radiance(list), add_lambda(list);
    return list;
}

std::vector<StageData> relight_data(const Scene& scene, const probes::BakeGraph& graph, const RunOptions& options) {
    const probes::Bake& bake = graph.bake();
    const int rays = 130, probes = int(bake.placement.probes.size());
    const Points directions = probes::relight_directions(rays);
    const probes::RelightHits hits =
        probes::relight_rays(bake.atlas, raster::surface_args(bake.atlas.geometry, graph.surfaces(), View{}), graph.query(),
                             bake.placement.probes, directions, options);
    Brought b(probes, rays, bake.atlas.size.x, 2);
    for (std::size_t i = 0; i < b.surface.size(); ++i) {
        const std::int32_t material = hits.material[i];
        const bool front = material >= 0;
        const Material* m = front ? &scene.materials[std::size_t(material)] : nullptr;
        b.surface[i] = front ? glm::vec4(m->reflectance, 1) : glm::vec4(0);
        b.emitted[i] = front ? glm::vec4(m->emission / float(host::pi), 0) : glm::vec4(0);
        b.direct[i] = glm::vec4(1, 1, 1, 0);
        b.place[i] = glm::vec4(hits.uv[i], float(i % 2), 0);
    }
    Summed s(probes, rays, bake.params.degree, {rays, 64});
    run(b.inputs(), options, s.radiance);
    return {own<probes::RadianceKernel>(probes::data_of(b.inputs()), "relight"),
            own<probes::LambdaKernel>(probes::data_of(s.inputs()), "relight")};
}

}  // namespace plumb::stability
