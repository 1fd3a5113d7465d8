#include "gi/stability/reuse.h"

#include "core/camera.h"
#include "gi/lend.h"
#include "gi/screen/screen.h"

namespace plumb::stability {

namespace {

constexpr int side = 24;

// A plane through `at`, seen from two places.
struct Pair {
    glm::dvec3 at{0}, normal{0, 0, 1};
    glm::dvec3 now{0, 0, 2}, then{0.1, 0.05, 2};   // cameras, from `at`
    glm::dvec3 look{0, 0, 0}, looked{0, 0, 0};     // what they look at
    double light = 1;                              // W/m2
    double far = 1e9;
};

struct Points {
    Image4 position{side, side}, normal{side, side};
    View view;
};

Points seen(const Pair& p, const glm::dvec3& from, const glm::dvec3& towards) {
    Camera camera;
    camera.position = p.at + from, camera.look_at = p.at + towards;
    camera.fov_y_deg = 40, camera.near = 1e-3 * glm::length(from), camera.far = p.far;
    Points out;
    out.view = make_view(camera, 1);
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            const Ray ray = ray_through_pixel(camera, {side, side}, {x, y});
            const double t = glm::dot(p.normal, p.at - ray.origin) / glm::dot(p.normal, ray.direction);
            if (!(t > 0) || t > 1e7 * glm::length(from)) continue;
            const glm::dvec3 hit = ray.origin + ray.direction * t;
            out.position(x, y) = glm::vec4(glm::vec3(hit), float(linear_depth(camera, hit)));
            out.normal(x, y) = glm::vec4(glm::vec3(p.normal), 1);
        }
    return out;
}

BakeCase of_pair(const std::string& name, const std::string& meaning, const Pair& pair) {
    return {"reuse, " + name, "reuse", meaning, [=] {
                const Points now = seen(pair, pair.now, pair.look), then = seen(pair, pair.then, pair.looked);
                Image4 light(side, side);
                screen::LastFrame last{light, light, then.position, then.normal, then.view, {side, side}};
                for (int i = 0; i < side * side; ++i) {
                    const auto k = std::size_t(i);
                    light.texels[k] = glm::vec4(glm::vec3(pair.light * (1 + i % 7), pair.light, pair.light * (i % 3)), 0);
                    last.irradiance.texels[k] = light.texels[k] * 0.75f;
                    last.age.texels[k] = {float(1 + i % 5), 1, 0, glm::length(glm::vec3(then.normal.texels[k])) > 0 ? 1.0f : 0.0f};
                }
                screen::ReuseParams params;
                params.frames = 16;
                StageData data = owned(stage<screen::ReuseKernel>(),
                                       screen::data_of(params, screen::ReuseInputs{&light, &now.position, &now.normal, now.view, &last, {}}));
                data.label = data.stage + " (reuse, " + name + ")";
                return std::vector{data};
            }};
}

}  // namespace

void add_reuse_cases(std::vector<BakeCase>& cases) {
    Pair still;
    still.then = still.now;
    cases.push_back(of_pair("a still camera", "each pixel's centre is where it was", still));
    cases.push_back(of_pair("from aside", "a camera that has moved by a twentieth of its distance", {}));
    Pair grazing;
    grazing.now = {2, 0, 0.01}, grazing.then = {2.02, 0, 0.012};
    cases.push_back(of_pair("grazing", "a plane that is seen under a third of a degree", grazing));
    Pair behind;
    behind.then = {0, 0, -0.5}, behind.looked = {0, 0, -3};
    cases.push_back(of_pair("behind", "all of it lay behind the last camera", behind));
    Pair edge;
    edge.then = {0, 0, 0.5}, edge.looked = {2, 0, 0.5};
    cases.push_back(of_pair("at the eye's side", "half of it lay behind the last camera, some at its depth 0", edge));
    Pair away;
    away.at = {1e6, -3e5, 2e6};
    cases.push_back(of_pair("1e6 m away", "from the origin, where a float's step is 0.06 m", away));
    Pair small;
    small.now *= 1e-4, small.then *= 1e-4;
    cases.push_back(of_pair("0.2 mm", "before the camera", small));
    Pair dim, bright;
    dim.light = 1e-30, bright.light = 1e30;
    cases.push_back(of_pair("1e-30 W/m2", "light that hardly is", dim));
    cases.push_back(of_pair("1e30 W/m2", "light beyond any lamp's", bright));
}

}  // namespace plumb::stability
