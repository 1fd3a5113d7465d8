// Scenes that are small, large, far away or deep.
#include <fmt/format.h>

#include <limits>

#include "gi/stability/cases_parts.h"

namespace plumb::stability {

namespace {

Case scaled(double by) {
    return {"scale " + power_text(by), "scale",
            fmt::format("the room is {:g} m wide, irradiance and the bias in texels stay", 2 * by),
            [=] {
                Scene s = room();
                scale(s, by);
                return s;
            },
            [=](frame::Settings& settings) { settings.shadow.bias *= float(by); }};
}

Case moved(double by) {
    return {"offset " + power_text(by), "offset",
            fmt::format("the room lies {:g} m from the origin along every axis", by), [=] {
                Scene s = room();
                move(s, glm::dvec3(by));
                return s;
            }};
}

// The room on a plain that reaches to the far end, and the near end as close as is asked.
Case deep(const std::string& name, const std::string& meaning, double near, double far, bool reversed_z) {
    return {name, "near and far", meaning, [=] {
                Scene s = room();
                s.meshes.push_back(plain(4e3, -0.0625, tiles));
                s.camera.near = near, s.camera.far = far, s.camera.reversed_z = reversed_z;
                return s;
            }};
}

}  // namespace

std::vector<Case> extent_cases() {
    const double infinity = std::numeric_limits<double>::infinity();
    std::vector<Case> list;
    for (const double by : {1e-4, 1e-2, 1e2, 1e4, 1e6}) list.push_back(scaled(by));
    for (const double by : {1e3, 1e4, 1e5, 1e6, 1e7}) list.push_back(moved(by));
    list.push_back(deep("far/near 1e7", "near 1 mm, far 10 km", 1e-3, 1e4, false));
    list.push_back(deep("far/near 1e7, reversed z", "the same, depth 1 at the near end", 1e-3, 1e4, true));
    list.push_back(deep("far infinite", "near 1 mm, no far end", 1e-3, infinity, false));
    list.push_back(deep("far infinite, reversed z", "the same, depth 1 at the near end", 1e-3, infinity, true));
    return list;
}

}  // namespace plumb::stability
