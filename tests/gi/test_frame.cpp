// The plan leaves out what cannot change the picture, and nothing else.
#include <catch2/catch.hpp>
#include <cstring>
#include <fstream>
#include <sstream>

#include "core/error.h"
#include "gi/frame/frame.h"

using namespace plumb;

namespace {

// A quad from three corners; counter-clockwise seen from its front.
void add_quad(Mesh& mesh, glm::vec3 a, glm::vec3 b, glm::vec3 d, int material) {
    const glm::vec3 u = b - a, v = d - a;
    const glm::vec3 n(u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x);
    const unsigned first = unsigned(mesh.vertices.size());
    for (glm::vec3 p : {a, b, b + v, d}) mesh.vertices.push_back({p, 0, normalize3<float>(n), 0});
    mesh.triangles.push_back(glm::uvec3(first, first + 1, first + 2));
    mesh.triangles.push_back(glm::uvec3(first, first + 2, first + 3));
    mesh.material.insert(mesh.material.end(), 2, material);
}

// A floor, a red wall, a small block, a spot above and a sun.
Scene small_scene() {
    Scene s;
    s.name = "small";
    s.materials.resize(2);
    s.materials[0].reflectance = {0.7f, 0.7f, 0.7f};
    s.materials[1].reflectance = {0.6f, 0.1f, 0.1f};
    s.materials[1].emission = {0.1f, 0, 0};
    Mesh room;
    add_quad(room, {-1, 0, 1}, {1, 0, 1}, {-1, 0, -1}, 0);
    add_quad(room, {-1, 0, -1}, {1, 0, -1}, {-1, 2, -1}, 1);
    add_quad(room, {-0.3f, 0.5f, 0.3f}, {0.3f, 0.5f, 0.3f}, {-0.3f, 0.5f, -0.3f}, 0);
    s.meshes.push_back(room);
    Light spot;
    spot.name = "key";
    spot.position = {0, 1.9f, 0.2f};
    spot.intensity = glm::vec3(10);
    spot.rsm_size = 32;
    Light sun = spot;
    sun.name = "sun";
    sun.type = LightType::directional;
    sun.direction = normalize3<float>(glm::vec3(0.3f, -1, -0.4f));
    sun.intensity = glm::vec3(2);
    s.lights = {spot, sun};
    s.camera.position = {0, 1, 3.4};
    s.camera.look_at = {0, 0.8, 0};
    s.frame_size = {24, 18};
    return s;
}

frame::Frame render(const Scene& scene, frame::Settings settings) {
    return frame::execute(scene, settings, frame::plan(scene, settings), {});
}

void require_equal(const Image4& a, const Image4& b) {
    REQUIRE(a.size() == b.size());
    CHECK(std::memcmp(a.data(), b.data(), a.size() * sizeof(glm::vec4)) == 0);
}

// Renders with and without pruning, requires the same picture, and returns how many stages were left out.
int left_out(const Scene& scene) {
    frame::Settings settings = frame::settings_of(scene);
    settings.layout = raster::Layout::isr;  // its buffers are of several formats
    settings.rsm.gather = rsm::Gather::disc, settings.rsm.samples = 16, settings.indirect.blur = filter::Blur::none;
    const frame::Frame pruned = render(scene, settings);
    settings.pruning = false;
    const frame::Frame whole = render(scene, settings);
    require_equal(pruned.radiance, whole.radiance);
    require_equal(pruned.display, whole.display);
    require_equal(pruned.gbuffer.position, whole.gbuffer.position);
    require_equal(pruned.gbuffer.normal, whole.gbuffer.normal);
    require_equal(pruned.gbuffer.albedo, whole.gbuffer.albedo);
    require_equal(pruned.gbuffer.emission, whole.gbuffer.emission);
    int n = 0;
    for (const frame::StageRun& s : pruned.stages) n += !s.needed;
    for (const frame::StageRun& s : whole.stages) CHECK(s.needed);
    return n;
}

}  // namespace

TEST_CASE("frame: leaving out changes no bit, and each rule fires", "[frame][pruning]") {
    Scene scene = small_scene();
    SECTION("everything is needed") { CHECK(left_out(scene) == 0); }
    SECTION("a light is off") {
        scene.lights[0].on = false;
        CHECK(left_out(scene) == 3);
    }
    SECTION("a light is black") {
        scene.lights[1].intensity = glm::vec3(0);
        CHECK(left_out(scene) == 3);
    }
    SECTION("everything lies behind the light") {
        scene.lights[0].position = {0, 5, 0};
        scene.lights[0].direction = {0, 1, 0};
        CHECK(left_out(scene) == 3);
    }
    SECTION("nothing reflects") {
        for (Material& m : scene.materials) m.reflectance = glm::vec3(0);
        CHECK(left_out(scene) == 2);
    }
    SECTION("there is no light") {
        scene.lights.clear();
        CHECK(left_out(scene) == 1);
    }
    SECTION("the scene is empty") {
        scene.meshes.clear();
        scene.environment.radiance = {1, 2, 3};
        CHECK(left_out(scene) == 8);
    }
}

TEST_CASE("frame: colours that no material has are not computed, and the plan says so", "[frame][pruning]") {
    Scene scene = small_scene();
    auto wants = [&](bool pruning) {
        frame::Settings settings = frame::settings_of(scene);
        settings.pruning = pruning, settings.indirect.blur = filter::Blur::none;
        return frame::plan(scene, settings);
    };
    CHECK(wants(true).gbuffer.emission);
    CHECK(wants(true).stages[0].reason == "every later stage reads it");

    // A material that no triangle has does not count.
    scene.materials[1].emission = glm::vec3(0);
    scene.materials.push_back(scene.materials[0]);
    scene.materials.back().emission = glm::vec3(1);
    CHECK_FALSE(wants(true).gbuffer.emission);
    CHECK(wants(true).gbuffer.albedo);
    CHECK(wants(true).stages[0].reason == "every later stage reads it; no emission: nothing emits");
    CHECK(wants(false).gbuffer.emission);
    CHECK(left_out(scene) == 0);

    for (Material& m : scene.materials) m.reflectance = glm::vec3(0);
    CHECK_FALSE(wants(true).gbuffer.albedo);
    CHECK(wants(false).gbuffer.albedo);
    CHECK(left_out(scene) == 2);
}

TEST_CASE("frame: a spot that just grazes a mesh is not left out", "[frame][pruning]") {
    Scene scene = small_scene();
    scene.lights.resize(1);
    scene.lights[0].position = {0, 1.99f, -0.995f};
    scene.lights[0].direction = {0, 1, 0};
    CHECK(left_out(scene) == 0);
    // In the middle it is within the bounds, and its cone goes up between the wall and nothing.
    scene.lights[0].position = {0, 1.9f, 0};
    CHECK(left_out(scene) == 4);
    // Positions that are rebuilt from a depth of 16 bits lie up to 7 mm off, and direct light without a light is left out,
    // too.
    scene.lights[0].position = {0, 2.1f, -0.995f};
    CHECK(left_out(scene) == 4);
}

// 2^28 texels are one map of 16384 a side, and 6 * 6688^2 = 268,376,064 are 59,392 fewer: a map of 243 a side (59,049)
// still fits, one of 244 (59,536) does not.
TEST_CASE("frame: the plan bounds the texels of all reflective shadow maps", "[frame][extreme]") {
    Scene scene = small_scene();
    frame::Settings settings;
    scene.lights[0].rsm_size = 16384;
    scene.lights[1].on = false;
    CHECK_NOTHROW(frame::plan(scene, settings));  // what is left out takes no memory
    scene.lights[1].on = true;
    CHECK_THROWS_AS(frame::plan(scene, settings), InputError);
    CHECK_THROWS_WITH(frame::plan(scene, settings),
                      scene.name + ": light \"sun\": rsm_size = 32: 268436480 texels in all reflective shadow maps up to "
                                   "this light: expected at most 268435456");
    scene.lights[1].on = false;
    settings.pruning = false;
    CHECK_THROWS_AS(frame::plan(scene, settings), InputError);

    // The six faces of a point light count.
    settings.pruning = true;
    scene.lights[1].on = true;
    scene.lights[0].type = LightType::point;
    scene.lights[0].rsm_size = 6688;
    scene.lights[1].rsm_size = 243;
    CHECK_NOTHROW(frame::plan(scene, settings));
    scene.lights[1].rsm_size = 244;
    CHECK_THROWS_AS(frame::plan(scene, settings), InputError);
    scene.lights[0].rsm_size = 16384;
    CHECK_THROWS_WITH(frame::plan(scene, settings),
                      scene.name + ": light \"key\": rsm_size = 16384, 6 faces: 1610612736 texels in all reflective "
                                   "shadow maps up to this light: expected at most 268435456");
}

TEST_CASE("frame: the picture is rho / pi (direct + indirect) + M / pi", "[frame]") {
    const Scene scene = small_scene();
    frame::Settings settings = frame::settings_of(scene);
    settings.rsm.gather = rsm::Gather::all;
    const frame::Frame f = render(scene, settings);
    int lit = 0;
    for (std::size_t i = 0; i < f.radiance.size(); ++i) {
        const glm::vec4 rho = f.gbuffer.albedo.texels[i], m = f.gbuffer.emission.texels[i];
        const double e = double(f.direct.texels[i].x) + f.indirect.texels[i].x;
        CHECK(f.radiance.texels[i].x == Approx((rho.x * e + m.x) / 3.141592653589793).epsilon(1e-6).margin(1e-9));
        lit += f.indirect.texels[i].x > 0;
    }
    CHECK(lit > int(f.radiance.size()) / 4);
}

TEST_CASE("frame: every stage of the plan can be explained, and its last values are the picture's", "[frame][explain]") {
    const Scene scene = small_scene();
    frame::Settings settings = frame::settings_of(scene);
    settings.rsm.gather = rsm::Gather::disc, settings.rsm.samples = 16, settings.indirect.blur = filter::Blur::none;
    const frame::Plan plan = frame::plan(scene, settings);
    const frame::Frame f = frame::execute(scene, settings, plan, {});
    const glm::ivec2 pixel(12, 14);
    const std::vector<frame::Explanation> all = frame::explain(scene, settings, plan, f, "", -1, pixel);
    REQUIRE(all.size() == 8);  // gbuffer; shadow and gather of two lights; direct, compose, tonemap
    auto last = [&](const char* label) {
        for (const frame::Explanation& e : all)
            if (e.stage == label) return e.values.back().value;
        return std::vector<double>{};
    };
    for (int c = 0; c < 3; ++c) {
        CHECK(float(last("direct")[c]) == f.direct(12, 14)[c]);
        CHECK(float(last("compose")[c]) == f.radiance(12, 14)[c]);
        CHECK(float(last("tonemap")[c]) == f.display(12, 14)[c]);
        CHECK(float(last("rsm.disc (key)")[c]) + float(last("rsm.disc (sun)")[c]) == f.indirect(12, 14)[c]);
    }
    CHECK(float(last("shadow (key)")[0]) == f.visibility[14 * 24 + 12]);

    CHECK_THROWS_WITH(frame::explain(scene, settings, plan, f, "rsm.dsic", -1, pixel),
                      "explain: unknown stage 'rsm.dsic'; the nearest known one is 'rsm.disc'");
    CHECK_THROWS_WITH(frame::explain(scene, settings, plan, f, "compose", -1, {24, 0}),
                      "explain: pixel 24,0 is outside of compose, which is 24 x 18");
    CHECK_THROWS_AS(frame::explain(scene, settings, plan, f, "rsm.all", -1, pixel), InputError);
    CHECK_THROWS_WITH(frame::explain(scene, settings, plan, f, "hemicube", -1, pixel),
                      "explain: the stage hemicube is not part of a frame: no method runs it");
}

TEST_CASE("frame: every stage has a twin or says why not, a source, inputs, outputs and a method's README",
          "[frame][stages]") {
    int without = 0;
    for (const StageInfo& stage : frame::all_stages()) {
        CAPTURE(stage.name);
        CHECK_FALSE(stage.source.empty());
        CHECK_FALSE(stage.inputs.empty());
        CHECK_FALSE(stage.outputs.empty());
        CHECK((stage.budget.c <= 16 || !stage.budget.reason.empty()));
        for (const ParamInfo& p : stage.params) CHECK_FALSE(p.meaning.empty());
        if (stage.twin.empty()) {
            CHECK(stage.source.find("without a twin") != std::string::npos);
            ++without;
            continue;
        }
        const std::string twin = std::string(PLUMB_SOURCE_DIR) + "/" + stage.twin;
        CHECK(std::ifstream(twin).good());
        CHECK(std::ifstream(twin.substr(0, twin.rfind('/')) + "/README.md").good());
    }
    CHECK(without == 21);  // rsm.all_rays, reference, eight steps of a bake, five of its run time, two of indirect shadows, four of radiosity
}

TEST_CASE("frame: settings come from the scene file, and errors name the place", "[frame][settings]") {
    Scene scene = small_scene();
    scene.settings = {{"rsm", "samples", 25.0, "small.toml: line 3"}, {"tonemap", "exposure", 4.0, "small.toml: line 5"}};
    const frame::Settings settings = frame::settings_of(scene);
    CHECK(settings.rsm.samples == 25);
    CHECK(settings.tonemap.exposure == 4);
    scene.settings.push_back({"rsm", "sampels", 25.0, "small.toml: line 9"});
    CHECK_THROWS_WITH(frame::settings_of(scene),
                      "small.toml: line 9: unknown key 'sampels'; the nearest known one is 'samples'");
    scene.settings.clear();
    scene.method = "isx";
    CHECK_THROWS_WITH(frame::settings_of(scene), "small: [render]: method = \"isx\": expected one of direct, rsm, isr, probes, radiosity, zbuffer, reference");
}

TEST_CASE("frame: every stage tells which instruction set its kernels were chosen from", "[frame][bits]") {
    const Scene scene = small_scene();
    const frame::Settings settings = frame::settings_of(scene);
    for (Isa isa : supported_isas()) {
        RunOptions options;
        options.isa = isa;
        for (const frame::StageRun& s : frame::execute(scene, settings, frame::plan(scene, settings), options).stages)
            CHECK(s.isa == isa);
    }
}

TEST_CASE("frame: all_rays takes its own stage, no more light than rsm.all, and says what it asked", "[frame][all_rays]") {
    Scene scene = small_scene();
    frame::Settings settings = frame::settings_of(scene);
    settings.rsm.gather = rsm::Gather::all;
    const frame::Frame without = render(scene, settings);
    CHECK(without.indirect_error.empty());
    settings.rsm.gather = rsm::Gather::all_rays;
    const frame::Plan plan = frame::plan(scene, settings);
    const frame::Frame f = frame::execute(scene, settings, plan, {});

    // The block hides a part of the light of the wall and the floor, and adds none.
    double sum = 0, sum_without = 0;
    for (std::size_t i = 0; i < f.indirect.size(); ++i) {
        const float e = f.indirect.texels[i].x, open = without.indirect.texels[i].x;
        CHECK(e <= open);
        sum += e, sum_without += open;
    }
    CHECK(sum > 0.3 * sum_without);
    CHECK(sum < 0.98 * sum_without);
    REQUIRE(f.indirect_error.size() == f.indirect.size());
    for (const glm::vec4& e : f.indirect_error.texels) CHECK(e == glm::vec4(0));
    auto reason = [](const auto& stages, const char* label) {
        for (const auto& s : stages)
            if (s.label == label) return s.reason;
        return std::string();
    };
    CHECK(reason(plan.stages, "rsm.all_rays (key)") == "indirect light of this light");
    CHECK(reason(f.stages, "rsm.all_rays (key)").find("indirect light of this light; all ") == 0);

    // The picture is the same on every instruction set and thread count.
    for (Isa isa : supported_isas())
        for (int threads : {1, 3}) {
            RunOptions options;
            options.isa = isa, options.threads = threads;
            require_equal(frame::execute(scene, settings, plan, options).indirect, f.indirect);
        }

    // A pixel of every light is explained, and adds up.
    const glm::ivec2 pixel(12, 14);
    glm::vec3 explained(0);
    for (int light : {0, 1}) {
        const auto values = frame::explain(scene, settings, plan, f, "rsm.all_rays", light, pixel).at(0).values;
        for (int c = 0; c < 3; ++c) explained[c] += float(values.back().value.at(std::size_t(c)));
    }
    for (int c = 0; c < 3; ++c) CHECK(explained[c] == f.indirect(12, 14)[c]);
}

TEST_CASE("frame: where all_rays would take too long it asks a subset, and its error is that of both lights",
          "[frame][all_rays]") {
    Scene scene = small_scene();
    scene.settings = {{"rsm", "gather", std::string("all_rays"), "small.toml: line 3"}};
    const frame::Settings whole = frame::settings_of(scene);
    CHECK(whole.rsm.rays == Rays::exact);
    scene.settings.push_back({"rsm", "max_rays", 24.0 * 18 * 64, "small.toml: line 4"});
    const frame::Settings settings = frame::settings_of(scene);
    const frame::Plan plan = frame::plan(scene, settings);
    const frame::Frame truth = render(scene, whole), f = frame::execute(scene, settings, plan, {});
    int stages = 0;
    for (const frame::PlannedStage& s : plan.stages)
        if (s.name == "rsm.all_rays") {
            CHECK(s.reason == "indirect light of this light; subset of at least 64 of 1024 texels a pixel");
            CHECK(s.work == 24 * 18 * 64);
            ++stages;
        }
    CHECK(stages == 2);
    for (const frame::StageRun& s : f.stages)
        if (s.label == "rsm.all_rays (key)") {
            // Some pixels see nothing, so that the others may ask more.
            CHECK(s.reason.find("; subset of ") != std::string::npos);
            CHECK(s.reason.find(" lit texels a pixel, ") != std::string::npos);
        }

    int within_1 = 0, within_3 = 0, n = 0;
    for (std::size_t i = 0; i < f.indirect.size(); ++i) {
        const float error = f.indirect_error.texels[i].x;
        if (error == 0) continue;
        const double z = std::abs(double(f.indirect.texels[i].x) - truth.indirect.texels[i].x) / error;
        within_1 += z < 1, within_3 += z < 3, ++n;
    }
    CHECK(n > 100);
    CHECK(double(within_1) / n == Approx(0.68).margin(0.1));
    CHECK(double(within_3) / n > 0.96);
}
