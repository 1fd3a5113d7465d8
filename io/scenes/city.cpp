// A historic city by a river, after the diorama of Rome that LRA 7.1 measures with (2 million vertices, 4 million
// triangles): about 600 m x 600 m of streets, a square with a domed church, an amphitheatre, a hill with pines.
//
// The default camera looks over the roofs to dome and amphitheatre. Over the river: position (-139, 3, 150), look at
// (-128, 7, 60), fov 55; on the square: position (55, 1.8, -12), look at (55, 16, -110).
#include <algorithm>

#include "core/host_math.h"
#include "io/scenes/city_parts.h"
#include "io/scenes/generate.h"

namespace plumb::io::scenes {
namespace {

using namespace town;

// Trees and lamps for about a sixth of the triangles.
void greenery(Builder& b, const Palette& p, const Grade& grade, const Plan& plan) {
    const double lamps = grade.count(20, 160);
    b.object("lamps");
    for (const glm::dvec2& at : plan.lamps) street_lamp(b, p, at, lamps);
    const std::size_t count = plan.trees.size() + plan.pines.size();
    const double each = std::clamp(0.16 * grade.triangles / double(std::max<std::size_t>(1, count)), 20.0, 3000.0);
    b.object("trees");
    std::uint32_t seed = 1000;
    for (const glm::dvec2& at : plan.trees) tree(b, p, TreeKind::broad, at, each, ++seed);
    b.object("pines");
    for (const glm::dvec2& at : plan.pines) {
        ++seed;
        tree(b, p, seed % 4 == 0 ? TreeKind::cypress : TreeKind::pine, at, each, seed);
    }
}

// Houses share what is left by the size of their fronts; what one leaves over goes to the next.
void houses(Builder& b, const Palette& p, const Grade& grade, const Plan& plan) {
    const auto weight = [](const Lot& lot) {
        const glm::dvec2 front = lot.ring[1] - lot.ring[0];
        return 30 + std::sqrt(glm::dot(front, front)) * lot.eaves;
    };
    double open = 0;
    for (const Lot& lot : plan.lots) open += weight(lot);
    std::size_t number = 0;
    for (const Lot& lot : plan.lots) {
        if (number++ % 64 == 0) b.object("houses " + std::to_string(number / 64));
        const double rest = grade.triangles - double(b.triangles()), share = weight(lot);
        house(b, p, lot, std::max(0.0, rest * share / open));
        open -= share;
    }
}

}  // namespace

Scene city(const GenerateOptions& options) {
    Grade grade;
    grade.triangles = double(options.triangles > 0 ? options.triangles : 4'000'000);
    grade.fine = std::clamp(host::log(grade.triangles / 1000) / host::log(10), 0.0, 4.0);
    Builder b("city");
    const Palette p = make_palette(b);
    const Plan plan = make_plan(grade, options.seed);
    b.object("ground");
    ground(b, p, grade);
    pavements(b, p, grade, plan.blocks);
    b.object("bridges");
    bridges(b, p, grade);
    b.object("amphitheatre");
    amphitheatre(b, p, grade);
    b.object("church");
    domed_church(b, p, grade);
    b.object("colonnade");
    colonnade(b, p, grade);
    greenery(b, p, grade, plan);
    houses(b, p, grade, plan);

    Scene scene = b.take();
    scene.camera = {{-135, 88, 262}, {72, 4, 0}, {0, 1, 0}, 42, 0.5, 1200};
    Light sun;
    sun.name = "sun", sun.type = LightType::directional, sun.rsm_size = 2048;  // 0.4 m a texel
    sun.direction = {0.8f, -0.6f, 0};
    sun.intensity = {5.2f, 4.7f, 3.9f};
    // Stands for the sky, whose light no method gathers: weak, blue, from above and behind the default camera.
    Light sky = sun;
    sky.name = "sky", sky.direction = {-0.36f, -0.8f, -0.48f}, sky.intensity = {0.9f, 1.05f, 1.3f};
    scene.lights = {sun, sky};
    scene.environment.radiance = {0.42f, 0.58f, 0.85f};
    scene.frame_size = {1920, 1080};
    // A disc of 60 m: what lies farther away lights nothing that one would see.
    const std::string place = "city";
    scene.settings = {{"rsm", "radius", 0.08, place}, {"rsm", "samples", 400.0, place},
                      {"rsm", "min_distance", 2.0, place},
                      {"tonemap", "operator", std::string("filmic"), place},
                      {"tonemap", "exposure", 1.5, place}};
    scene.seed = options.seed;
    return scene;
}

}  // namespace plumb::io::scenes
