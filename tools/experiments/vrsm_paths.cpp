// Paths for figures 3.3 and 3.4 of VRSM: what the kernel says of its samples, by Algorithms 2 and 6.
#include <algorithm>
#include <cmath>
#include <limits>

#include "core/host_math.h"
#include "tools/experiments/vrsm.h"

namespace plumb::cli {

namespace {

using rsm::Visibility;

double dot(const glm::dvec3& a, const glm::dvec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
glm::dvec3 vec(const std::vector<double>& v) { return {v.at(0), v.at(1), v.at(2)}; }

// Across the axis that points to the light, and along it.
glm::dvec2 seen_from_light(const glm::dvec3& d, const glm::dvec3& axis) {
    const double height = dot(d, axis);
    const glm::dvec3 across = d - axis * height;
    return {std::sqrt(dot(across, across)), height};
}

// A sample as explain() lists it.
struct Told {
    bool inside = false, seen = true;
    int slot = 0;
    glm::dvec3 x_p{0}, n_p{0};
    glm::ivec2 texel{0};
};
struct ToldPoint {
    glm::dvec3 x{0};
    glm::ivec2 centre{0};
    bool sighted = false;
    std::vector<Told> samples;
};

ToldPoint told(const rsm::GatherParams& params, const rsm::GatherInputs& in, glm::ivec2 pixel) {
    ToldPoint point;
    point.samples.resize(std::size_t(rsm::sample_count(params)));
    for (const TapValue& v : rsm::explain(params, in, pixel)) {
        if (v.sample < 0) {
            if (v.name == "x") point.x = vec(v.value);
            if (v.name == "projection") point.centre = {int(std::floor(v.value[0])), int(std::floor(v.value[1]))};
            if (v.name == "sight") point.sighted = v.value[0] == 1;
            continue;
        }
        Told& s = point.samples.at(std::size_t(v.sample));
        if (v.name == "texel") s.texel = {int(v.value[0]), int(v.value[1])};
        if (v.name == "inside") s.inside = v.value[0] != 0;
        if (v.name == "x_p") s.x_p = vec(v.value);
        if (v.name == "n_p") s.n_p = vec(v.value);
        if (v.name == "slot") s.slot = int(v.value[0]);
        if (v.name == "visibility") s.seen = v.value[0] != 0;
    }
    return point;
}

// The map's surface along the line from the point's texel to the last sample's, a texel a step.
std::vector<glm::dvec2> surface_along(const ToldPoint& point, const glm::ivec2& last, const raster::Rsm& map,
                                      const glm::dvec3& axis) {
    const glm::ivec2 way = last - point.centre;
    const int steps = std::max({std::abs(way.x), std::abs(way.y), 1});
    std::vector<glm::dvec2> surface;
    for (int i = 0; i <= steps; ++i) {
        const int x = point.centre.x + int(std::lround(double(way.x) * i / steps)),
                  y = point.centre.y + int(std::lround(double(way.y) * i / steps));
        const bool inside = x >= 0 && y >= 0 && x < map.size && y < map.size;
        const glm::vec4 at = inside ? map.position(x, y) : glm::vec4(0);
        surface.push_back(at.w > 0 ? seen_from_light(glm::dvec3(glm::vec3(at)) - point.x, axis)
                                   : glm::dvec2(std::numeric_limits<double>::quiet_NaN()));
    }
    return surface;
}

VrsmPath path_of(const rsm::GatherParams& params, const ToldPoint& second, const ToldPoint& sixth, int path, glm::ivec2 pixel,
                 const raster::Rsm& map, const glm::dvec3& axis) {
    VrsmPath p;
    p.pixel = pixel, p.path = path;
    glm::ivec2 last = sixth.centre;
    for (int step = 0; step < params.steps; ++step) {
        const std::size_t k = std::size_t(path * params.steps + step);
        const Told& s = sixth.samples[k];
        if (!s.inside || s.n_p == glm::dvec3(0)) continue;
        p.samples.push_back({seen_from_light(s.x_p - sixth.x, axis), s.slot, second.samples[k].seen, s.seen});
        last = s.texel;
    }
    p.surface = surface_along(sixth, last, map, axis);
    for (const float edge : rsm::slot_edges(params)) {
        const double s = std::copysign(std::sqrt(std::abs(double(edge))), double(edge));
        p.edges.push_back(host::atan2(s, std::sqrt(std::max(1 - s * s, 0.0))));
    }
    return p;
}

const raster::Rsm* first_map(const frame::Frame& f) {
    for (const std::vector<raster::Rsm>& light : f.rsms)
        for (const raster::Rsm& map : light)
            if (map.size > 0 && !map.position.empty() && (!map.records.empty() || !map.half_records.empty())) return &map;
    return nullptr;
}

}  // namespace

void vrsm_paths(const VrsmSubject& subject, const RunOptions& options, frame::KeptStages& kept, VrsmScene& scene) {
    frame::Settings settings = vrsm_settings(subject, false, Visibility::algorithm_6, 5);
    settings.indirect.blur = filter::Blur::none;
    const frame::Frame& f = frame::execute(subject.scene, settings, frame::plan(subject.scene, settings), options, kept);
    const raster::Rsm* map = first_map(f);
    if (!map) return;
    rsm::GatherParams sixth = settings.rsm, second = settings.rsm;
    second.visibility = Visibility::algorithm_2;
    const rsm::Pattern pattern = rsm::pattern_of(sixth, map->size, settings.seed);
    const rsm::GatherInputs in{&f.gbuffer.position, &f.gbuffer.normal, map, &pattern, settings.seed};
    const glm::dvec3 axis = -map->view.forward;
    const int width = f.gbuffer.normal.width, height = f.gbuffer.normal.height;
    // Of paths on which all samples lie on a surface: the most that Algorithm 6 hides, and the most that Algorithm 2 alone does.
    int most_hidden = 0, most_alone = 0;
    for (int j = 0; j < 24; ++j)
        for (int i = 0; i < 24; ++i) {
            const glm::ivec2 pixel((2 * i + 1) * width / 48, (2 * j + 1) * height / 48);
            if (f.gbuffer.normal(pixel.x, pixel.y).w == 0) continue;
            const ToldPoint by_2 = told(second, in, pixel), by_6 = told(sixth, in, pixel);
            if (!by_6.sighted) continue;
            for (int path = 0; path < sixth.directions; ++path) {
                int hidden = 0, alone = 0, on_surface = 0;
                for (int step = 0; step < sixth.steps; ++step) {
                    const std::size_t k = std::size_t(path * sixth.steps + step);
                    on_surface += by_6.samples[k].inside && by_6.samples[k].n_p != glm::dvec3(0);
                    hidden += !by_6.samples[k].seen, alone += by_6.samples[k].seen && !by_2.samples[k].seen;
                }
                if (on_surface < sixth.steps) continue;
                if (hidden > most_hidden)
                    most_hidden = hidden, scene.hidden = path_of(sixth, by_2, by_6, path, pixel, *map, axis);
                if (hidden == 0 && alone > most_alone)
                    most_alone = alone, scene.neighbours = path_of(sixth, by_2, by_6, path, pixel, *map, axis);
            }
        }
}

}  // namespace plumb::cli
