// plumb experiment ipr: tables 5.4 to 5.11 of the thesis.
#include <algorithm>

#include "core/error.h"
#include "gi/probes/directions.h"
#include "tools/experiments/ipr_lod.h"

namespace plumb::cli {

const std::vector<LodTable>& thesis_lod_tables() {
    static const std::vector<LodTable> all = {
        {"5.5", "Open Hall, camera 1",
         {{"NO LOD", 512026, 1.99, 1.0, 1.0}, {"S0", 275190, 1.50, 1.33, 0.995}, {"S1", 158371, 1.35, 1.47, 0.991}, {"S2", 158371, 1.23, 1.62, 0.984}}},
        {"5.6", "Open Hall, camera 2",
         {{"NO LOD", 512026, 1.99, 1.0, 1.0}, {"S0", 135452, 1.25, 1.60, 0.998}, {"S1", 99744, 1.24, 1.60, 0.993}, {"S2", 99744, 1.15, 1.73, 0.989}}},
        {"5.7", "Open Hall, camera 3",
         {{"NO LOD", 512026, 1.99, 1.0, 1.0}, {"S0", 217911, 1.43, 1.39, 0.998}, {"S1", 126279, 1.27, 1.57, 0.996}, {"S2", 126279, 1.16, 1.72, 0.994}}},
        {"5.8", "Cornell box, one level for all",
         {{"LOD 0", 67682, 0.92, 1.0, {}}, {"LOD 1", 16857, 0.44, 2.10, {}}, {"LOD 2", 4210, 0.24, 3.83, {}}, {"LOD 3", 1073, 0.17, 5.41, {}}}},
        {"5.9", "Large Cornell box, 342 009 receivers, one degree for all",
         {{"SH 0", 0, 1.42, 1.06, {}}, {"SH 1", 0, 1.42, 1.06, {}}, {"SH 2", 0, 1.43, 1.05, {}}, {"SH 3", 0, 1.43, 1.05, {}},
          {"SH 4", 0, 1.43, 1.05, {}}, {"SH 5", 0, 1.43, 1.05, {}}, {"SH 6", 0, 1.46, 1.02, {}}, {"SH 7", 0, 1.50, 1.0, {}}}},
        {"figure 5.32", "of 335 015 receivers; no times", {{"NO LOD", 335015, 0, 1, {}}, {"no zones", 229076, 0, 1, {}}, {"zones", 105259, 0, 1, {}}}},
    };
    return all;
}

namespace {

using Degrees = std::array<int, 4>;
using Distances = std::array<float, 3>;

// by_level: fewer rays in coarser levels.
LodSetup setup(const std::string& name, const Degrees& degrees, const Distances& distances, bool by_level) {
    LodSetup s{name, {}};
    probes::LodParams& p = s.params;
    p.levels = 4;
    p.distance_1 = distances[0], p.distance_2 = distances[1], p.distance_3 = distances[2];
    p.degree_0 = degrees[0], p.degree_1 = degrees[1], p.degree_2 = degrees[2], p.degree_3 = degrees[3];
    std::array<int, 4> rays{512, 512, 512, 512};
    for (std::size_t k = 1; by_level && k < 4; ++k) {
        rays[k] = 512 >> k;
        while (probes::exact_degree(rays[k]) < degrees[k]) rays[k] *= 2;
    }
    p.rays_0 = rays[0], p.rays_1 = rays[1], p.rays_2 = rays[2], p.rays_3 = rays[3];
    return s;
}
LodSetup with_zones(LodSetup s) {
    s.params.zones = true;
    return s;
}
LodSetup with_borders(LodSetup s, LodBorders borders) {
    s.borders = borders;
    return s;
}

constexpr Degrees full = {7, 7, 7, 7}, automatic = {-1, -1, -1, -1};
constexpr Distances usual = {20, 50, 100};  // D0, and the GUI's default (appendix A)
constexpr Distances middle = {14, 24, 46};  // D1: level 0 is still seen

// Of all levels the same rays; degrees are the largest that they sample without aliasing.
LodSetup rays_setup(int rays) {
    LodSetup s{"R " + std::to_string(rays), {}};
    s.params.rays_0 = rays;
    return s;
}

std::vector<LodSetup> all_setups() {
    std::vector<LodSetup> all = {{"NO LOD", {}},
                                 with_zones(setup("S0", {7, 6, 4, 3}, usual, true)),
                                 with_zones(setup("S1", {7, 7, 6, 5}, {11, 30, 60}, true)),
                                 with_zones(setup("S2", {4, 4, 4, 3}, {11, 30, 60}, true)),
                                 setup("D0", full, usual, false),
                                 setup("D1", full, middle, false),
                                 setup("D2", full, {0, 12, 30.5f}, false),
                                 setup("SD0", {7, 5, 3, 2}, usual, false),
                                 setup("SD1", {4, 3, 2, 0}, usual, false),
                                 setup("SD2", {7, 2, 0, 0}, usual, false),
                                 setup("no zones", full, usual, false),
                                 with_zones(setup("zones", full, usual, false)),
                                 setup("borders: all", full, middle, false),
                                 with_borders(setup("borders: level 0", full, middle, false), LodBorders::finest),
                                 with_borders(setup("borders: none", full, middle, false), LodBorders::none)};
    const float never = 1e6f;
    for (int k = 0; k < 4; ++k)
        all.push_back(setup("LOD " + std::to_string(k), full, {k > 0 ? 0 : never, k > 1 ? 0 : never, k > 2 ? 0 : never}, false));
    for (int degree = 0; degree <= 7; ++degree) {
        LodSetup one{"SH " + std::to_string(degree), {}};
        one.params.degree_0 = degree;
        all.push_back(one);
    }
    for (const int rays : {512, 256, 128, 64}) all.push_back(rays_setup(rays));
    LodSetup adaptive = setup("R adaptive", automatic, usual, false);
    adaptive.params.rays_1 = 256, adaptive.params.rays_2 = 128, adaptive.params.rays_3 = 64;
    all.push_back(adaptive);
    return all;
}

}  // namespace

LodSetup lod_setup(const std::string& name, double scale) {
    static const std::vector<LodSetup> all = all_setups();
    const auto found = std::find_if(all.begin(), all.end(), [&](const LodSetup& s) { return s.name == name; });
    if (found == all.end()) throw InputError("level of detail: no setup \"" + name + "\": expected one of IPR tables 5.4 to 5.11, figures 5.31 to 5.33");
    LodSetup setup = *found;
    for (float* distance : {&setup.params.distance_1, &setup.params.distance_2, &setup.params.distance_3})
        if (*distance > 0 && *distance < 1e5f) *distance = float(scale * double(*distance));
    return setup;
}

std::vector<LodSetup> lod_setups(const std::vector<std::string>& names, double scale) {
    std::vector<LodSetup> all;
    for (const std::string& name : names) all.push_back(lod_setup(name, scale));
    return all;
}

}  // namespace plumb::cli
