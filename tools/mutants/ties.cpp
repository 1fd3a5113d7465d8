#include "tools/mutants/ties.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "gi/parity/stages.h"

namespace plumb::mutants {
namespace {

const std::vector<double>* find_value(const std::vector<TapValue>& values, const std::string& name) {
    for (const TapValue& v : values)
        if (v.name == name) return &v.value;
    return nullptr;
}

// How far a point is from a tie.
double beside_texel(const std::vector<TapValue>& values) {
    const std::vector<double>* texel = find_value(values, "projection");
    return texel ? (*texel)[0] - std::floor((*texel)[0] + 0.5) : 0;
}
double beside_depth(const std::vector<TapValue>& values) {
    const std::vector<double>*depth = find_value(values, "d_p"), *map = find_value(values, "d_map"),
                    *bias = find_value(values, "bias");
    return depth && map && bias && (*map)[0] > 0 ? (*depth)[0] - ((*map)[0] + (*bias)[0]) : 0;
}

// Of the first sample that the map has.
double beside_slot(const std::vector<TapValue>& values, double edge) {
    bool inside = false, found = false;
    double height = 0;
    for (const TapValue& v : values) {
        if (v.name == "inside") inside = v.value[0] != 0;
        if (v.name == "dz" && inside) height = v.value[0] * std::abs(v.value[0]), found = true;
        if (v.name == "d2" && found) return v.value[0] > 0 ? height / v.value[0] - edge : 0;
    }
    return 0;
}

// Moves the point along `way` to where f is 0, by the secant's rule; back to where it was if it does not get there.
void solve(float* point, const glm::dvec3& way, const std::function<double()>& f) {
    const glm::dvec3 start(point[0], point[1], point[2]);
    const auto at = [&](double t) {
        for (int i = 0; i < 3; ++i) point[i] = float(start[i] + t * way[i]);
        return f();
    };
    double t0 = 0, f0 = at(t0), t1 = 1e-3;
    if (f0 == 0) return;
    for (int i = 0; i < 8; ++i) {
        const double f1 = at(t1), slope = (f1 - f0) / (t1 - t0);
        if (f1 == 0 || slope == 0) break;
        t0 = t1, f0 = f1, t1 -= f1 / slope;
    }
    if (!(std::abs(f()) < 1e-5)) at(0);
}

}  // namespace

void plant_ties(StageData& data) {
    const StageBinding& binding = parity::find_binding(data.stage, "plumb_mutants");
    const std::unique_ptr<BoundStage> stage = binding.bind(data);
    float* positions = nullptr;
    for (Array& array : data.inputs.arrays)
        if (array.name == "position") positions = reinterpret_cast<float*>(array.bytes.data());
    auto has = [&](const char* member) {
        return std::any_of(binding.uniforms.begin(), binding.uniforms.end(),
                           [&](const UniformMember& m) { return m.name == member; });
    };
    // A depth to compare with; slots between edges.
    const bool shadow = has("perspective"), paths = has("axis") && find(data.inputs, "edges");
    glm::dvec3 eye(0), forward(0), axis(0);
    double edge = 0;
    if (paths) {
        const std::vector<double> a = uniform_value(binding, data, "axis");
        axis = {a[0], a[1], a[2]};
        // Above elevation 0 and next to it: where walls see a floor, and a floor sees walls.
        const Array& edges = at(data.inputs, "edges");
        edge = reinterpret_cast<const float*>(edges.bytes.data())[edges.bytes.size() / 8];
    }
    bool perspective = false;
    if (shadow) {
        const std::vector<double> e = uniform_value(binding, data, "eye"), a = uniform_value(binding, data, "forward");
        eye = {e[0], e[1], e[2]}, forward = {a[0], a[1], a[2]};
        perspective = uniform_value(binding, data, "perspective")[0] > 0;
    }
    for (int y = 0; y < data.size.y; ++y)
        for (int x = 0; x < data.size.x; ++x) {
            float* point = positions + 4 * (y * data.size.x + x);
            const glm::dvec3 p(point[0], point[1], point[2]);
            const int which = (x + 2 * y) % 4;
            if (which == 0)
                solve(point, {0.8, 0.1, 0.6}, [&] { return beside_texel(stage->explain({x, y})); });
            if (which == 1 && shadow)
                solve(point, perspective ? p - eye : forward, [&] { return beside_depth(stage->explain({x, y})); });
            // Fewer: a surface along a path ties in many samples, more than whose outcomes can be told apart.
            if (which == 1 && y % 4 == 0 && paths)
                solve(point, axis, [&] { return beside_slot(stage->explain({x, y}), edge); });
        }
}

}  // namespace plumb::mutants
