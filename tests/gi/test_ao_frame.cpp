// Ambient occlusion in a frame: off, from the camera, from lights of all kinds, its truth, and what may not change.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>

#include "core/error.h"
#include "gi/frame/kept.h"
#include "gi/frame/kept_memory.h"
#include "tests/gi/keys_of.h"
#include "tests/gi/open_room.h"

using namespace plumb;
using test::has;
using test::render;
using test::same;

namespace {

using screen::AoMethod;
using screen::AoViews;

Scene room() { return test::open_room(); }

frame::Settings occluding(AoViews views = AoViews::lights) {
    frame::Settings settings;
    settings.method = frame::Method::direct;
    settings.ao.method = AoMethod::ssao, settings.ao.views = views, settings.ao.samples = 32;
    settings.ao.ambient = glm::vec3(1);
    return settings;
}

// The mean difference to the truth of the layer ao, over the pixels that see a surface.
double error_of(const frame::Frame& f) {
    const Image4& truth = frame::find_traced(f, "truth.ao")->estimate.mean;
    double sum = 0;
    int count = 0;
    for (std::size_t i = 0; i < truth.size(); ++i)
        if (f.ao.open.texels[i].w > 0) sum += std::abs(double(f.ao.open.texels[i].x) - truth.texels[i].x), ++count;
    return sum / count;
}

}  // namespace

TEST_CASE("ao: off, a frame has no stage of it; on, ambient light is the open share of it", "[frame][ao]") {
    const Scene scene = room();
    frame::Settings settings = occluding();
    settings.ao.method = AoMethod::off;
    CHECK_FALSE(has(frame::plan(scene, settings), "screen.blur"));
    const frame::Frame off = render(scene, settings);
    CHECK((off.ao.views.empty() && off.ao.open.empty() && off.ao.lit.empty()));

    const frame::Frame on = render(scene, occluding());
    CHECK(same(off.direct, on.direct));
    for (int i = 0; i < int(on.radiance.size()); ++i) {
        const float open = on.ao.open.texels[std::size_t(i)].x;
        CHECK((open >= 0 && open <= 1));
        // rho (E_direct + o E_ambient) / pi
        const double more = double(on.radiance.texels[std::size_t(i)].x) - off.radiance.texels[std::size_t(i)].x;
        CHECK(more == Approx(0.7 * double(open) / 3.14159265358979).margin(1e-5));
    }
    // The floor at the foot of the block's front is darker than the floor before it.
    const auto mean_open = [&](float from, float to) {
        double sum = 0;
        int count = 0;
        for (std::size_t i = 0; i < on.ao.open.size(); ++i) {
            const glm::vec4& p = on.gbuffer.position.texels[i];
            if (on.gbuffer.normal.texels[i].y < 0.9f || p.y > 0.1f || std::abs(p.x) > 0.2f || p.z < from || p.z > to) continue;
            sum += on.ao.open.texels[i].x, ++count;
        }
        REQUIRE(count > 0);
        return sum / count;
    };
    CHECK(mean_open(0.3f, 0.42f) < mean_open(0.7f, 1) - 0.1);
}

TEST_CASE("ao: every map of every light that shines is a view; those that see nothing change no bit", "[frame][ao]") {
    Scene scene = room();
    const frame::Settings settings = occluding();
    const frame::Plan plan = frame::plan(scene, settings);
    for (const char* label : {"screen.ssao", "screen.ssao (key)", "screen.ssao (bulb, px)", "screen.ssao (bulb, nz)",
                              "screen.ssao (sun)", "screen.blur", "screen.occlude"})
        CHECK(has(plan, label));
    const frame::Frame f = render(scene, settings);
    CHECK(f.ao.views.size() == 9);
    for (std::size_t i = 0; i < f.ao.open.size(); ++i) {
        // Weights only grow, and the camera's own share stays beside them.
        for (std::size_t v = 1; v < f.ao.views.size(); ++v) {
            CHECK(f.ao.views[v].texels[i].y >= f.ao.views[v - 1].texels[i].y);
            CHECK(f.ao.views[v].texels[i].z == f.ao.views[0].texels[i].z);
        }
    }
    // A lamp that is off or black is no view; one that misses is, and its node is left out.
    scene.lights[0].on = false, scene.lights[2].intensity = glm::vec3(0);
    CHECK_FALSE(has(frame::plan(scene, settings), "screen.ssao (key)"));
    CHECK_FALSE(has(frame::plan(scene, settings), "screen.ssao (sun)"));
    const frame::Frame two = render(scene, settings);
    scene.lights.push_back(moving::spot("away", {0, 5, 0}, {0, 1, 0}, 3));
    const frame::Frame away = render(scene, settings);
    CHECK(same(two.ao.open, away.ao.open));
    frame::Settings whole = settings;
    whole.pruning = false;
    CHECK(same(two.ao.open, render(scene, whole).ao.open));
    const auto left = std::find_if(away.stages.begin(), away.stages.end(),
                                   [](const frame::StageRun& s) { return s.label == "screen.ssao (away)"; });
    REQUIRE(left != away.stages.end());
    CHECK_FALSE(left->needed);
    CHECK(left->rule == "light-misses");
}

TEST_CASE("ao: of lights at rest nothing is sampled again, and every frame has the bits of a fresh one", "[frame][frames][ao][LRA 4.4]") {
    Scene scene = room();
    frame::Settings settings = occluding();
    frame::KeptStages kept;
    const auto next = [&](const char* what) {
        CAPTURE(what);
        const frame::Frame& f = frame::execute(scene, settings, frame::plan(scene, settings), {}, kept);
        const frame::Frame fresh = render(scene, settings);
        REQUIRE(f.ao.views.size() == fresh.ao.views.size());
        for (std::size_t v = 0; v < f.ao.views.size(); ++v) CHECK(same(f.ao.views[v], fresh.ao.views[v]));
        CHECK(same(f.ao.open, fresh.ao.open));
        CHECK(same(f.radiance, fresh.radiance));
    };
    next("the first");
    scene.lights[0].position.x += 0.2f;
    next("the first light moves");
    scene.lights[1].position.y -= 0.1f;
    next("a point light moves");
    scene.lights[2].direction = {0.2f, -0.5f, -1};
    next("the sun moves");
    scene.camera.position.x += 0.1;
    next("the camera moves");
    scene.meshes[0].transform[3].y += 0.05;
    next("the room moves");
    settings.ao.radius = 0.4f;
    next("another radius");
    scene.lights[0].on = false;
    next("a light less");
    settings.ao.views = AoViews::camera;
    next("the camera alone");
    scene.lights[0].on = true, settings.ao.views = AoViews::lights, scene.frame_size = {40, 48};
    next("all again, another size");

    // The share of the sun is what is added where a light before it moves: one that is spoiled shows, until the sun moves.
    std::vector<frame::AoShare>& shares = kept.memory().ao_shares;
    REQUIRE(shares.size() == kept.memory().frame.ao.views.size());
    for (glm::vec4& share : shares.back().sum.texels) share.x += 1;
    scene.lights[0].position.x -= 0.1f;
    const frame::Frame fresh = render(scene, settings);
    CHECK_FALSE(same(frame::execute(scene, settings, frame::plan(scene, settings), {}, kept).ao.open, fresh.ao.open));
    scene.lights[2].direction = {0.1f, -0.5f, -1};
    next("the sun moves, and is sampled again");
}

TEST_CASE("ao: more views bring it nearer to the rays' truth, whose bits are the same everywhere", "[frame][ao][truth]") {
    Scene scene = room();
    scene.frame_size = {32, 26};
    scene.lights.erase(scene.lights.begin() + 2);
    frame::Settings settings = occluding(AoViews::camera);
    settings.truth = true, settings.reference.samples = 64, settings.reference.rounds = 4;
    settings.reference.rays = Rays::exact;
    const frame::Frame one = render(scene, settings);
    settings.ao.views = AoViews::lights;
    const frame::Frame all = render(scene, settings);
    const Image4& truth = frame::find_traced(one, "truth.ao")->estimate.mean;
    CHECK(same(truth, frame::find_traced(all, "truth.ao")->estimate.mean));
    CHECK(error_of(one) < 0.2);
    settings.ao.method = AoMethod::horizon, settings.ao.views = AoViews::camera;
    const frame::Frame horizon = render(scene, settings);
    // Horizons integrate what the rays do; half balls do not.
    CHECK(error_of(horizon) < error_of(one));
    for (const Isa isa : supported_isas()) {
        RunOptions options;
        options.isa = isa, options.threads = isa == Isa::scalar ? 1 : 3;
        const frame::Frame other = render(scene, settings, options);
        CHECK(same(other.ao.open, horizon.ao.open));
        CHECK(same(frame::find_traced(other, "truth.ao")->estimate.mean, truth));
    }
    // The radius is the rays' length.
    settings.ao.radius = 0.1f;
    CHECK_FALSE(same(frame::find_traced(render(scene, settings), "truth.ao")->estimate.mean, truth));
}

TEST_CASE("ao: a lamp that moves runs its own view again, and what is after it", "[frame][ao][keys]") {
    Scene scene = room();
    const frame::Settings settings = occluding();
    const test::Ran before(scene, settings);
    scene.lights[1].position.x += 0.1f;
    const test::Ran after(scene, settings);
    for (std::size_t i = 0; i < before.plan.stages.size(); ++i) {
        const std::string& label = before.plan.stages[i].label;
        CAPTURE(label);
        const bool of_key = label == "screen.ssao" || label == "screen.ssao (key)" || label == "gbuffer";
        const bool of_bulb = label.starts_with("screen.ssao (bulb") || label == "screen.blur" || label == "screen.occlude";
        if (of_key) CHECK(before.keys[i] == after.keys[i]);
        if (of_bulb) CHECK_FALSE(before.keys[i] == after.keys[i]);
    }
}

TEST_CASE("ao: every parameter that changes a stage's result changes its key", "[frame][ao][keys]") {
    Scene scene = room();
    scene.frame_size = {16, 12};
    frame::Settings before = occluding();
    const test::Ran old(scene, before);
    int changed = 0;
    for (std::size_t i = 0; i < screen::fields(before.ao).size(); ++i) {
        frame::Settings after = before;
        Field field = screen::fields(after.ao)[i];
        CAPTURE(field.name);
        if (field.name == "method" || field.name == "views") continue;  // of another plan
        if (auto* p = std::get_if<int*>(&field.value)) **p = field.choices.empty() ? 2 * **p : (**p + 1) % int(field.choices.size());
        if (auto* p = std::get_if<float*>(&field.value)) **p *= 0.75f;
        if (auto* p = std::get_if<glm::vec3*>(&field.value)) **p *= 0.75f;
        const test::Ran now(scene, after);
        REQUIRE(old.plan.stages.size() == now.plan.stages.size());
        for (std::size_t s = 0; s < old.plan.stages.size(); ++s) {
            const std::string& label = old.plan.stages[s].label;
            CAPTURE(label);
            if (old.keys[s] == now.keys[s])
                CHECK(test::same_bytes(old.outputs.at(label), now.outputs.at(label)));
            else
                CHECK((label.starts_with("screen.") || label == "compose" || label == "tonemap"));
            changed += !(old.keys[s] == now.keys[s]);
        }
        if (field.name == "ambient") CHECK(old.keys[old.keys.size() - 4] == now.keys[now.keys.size() - 4]);  // screen.blur
    }
    CHECK(changed > 40);
}

TEST_CASE("ao: its stages are explained, and end with what the picture holds", "[frame][ao][explain]") {
    const Scene scene = room();
    for (const AoMethod method : {AoMethod::ssao, AoMethod::horizon}) {
        frame::Settings settings = occluding(method == AoMethod::ssao ? AoViews::lights : AoViews::camera);
        settings.ao.method = method;
        const frame::Plan plan = frame::plan(scene, settings);
        const frame::Frame f = frame::execute(scene, settings, plan, {});
        const glm::ivec2 pixel(20, 30);
        const auto last = [&](const char* stage) { return frame::explain(scene, settings, plan, f, stage, 2, pixel).back().values.back(); };
        CHECK(float(last("screen.blur").value[0]) == f.ao.open(20, 30).x);
        CHECK(float(last("screen.occlude").value[0]) == f.ao.lit(20, 30).x);
        if (method == AoMethod::horizon) CHECK(float(last("screen.horizon").value[0]) == f.ao.views[0](20, 30).z);
        if (method == AoMethod::ssao) CHECK(float(last("screen.ssao").value[1]) == f.ao.views.back()(20, 30).y);
    }
}

TEST_CASE("ao: what a plan refuses", "[frame][ao][input]") {
    frame::Settings settings = occluding();
    settings.ao.method = AoMethod::horizon;
    CHECK_THROWS_WITH(frame::plan(room(), settings), Catch::Contains("views = lights with method = horizon"));
    // The picture of the method reference is path traced: nothing is occluded again.
    settings.method = frame::Method::reference;
    CHECK_FALSE(has(frame::plan(room(), settings), "screen.horizon"));
}
