// Frames that reuse what did not change: the same bits as fresh ones, whatever moves and whatever is kept.
#include <catch2/catch.hpp>
#include <random>

#include "core/error.h"
#include "core/hash.h"
#include "gi/frame/kept.h"
#include "gi/frame/probe_bake.h"
#include "gi/frame/kept_memory.h"
#include "tests/gi/moving_scene.h"

using namespace plumb;
using moving::differences;

namespace {

using Labels = std::vector<std::string>;

frame::Settings settings_for(rsm::Gather gather) {
    frame::Settings settings;
    settings.rsm.gather = gather;
    settings.rsm.samples = 16, settings.rsm.directions = 4, settings.rsm.steps = 4;
    settings.indirect.blur = filter::Blur::none;
    settings.reference.samples = 2, settings.reference.rounds = 2, settings.reference.rays = Rays::exact;
    return settings;
}

frame::Frame fresh(const Scene& scene, const frame::Settings& settings) {
    return frame::execute(scene, settings, frame::plan(scene, settings), {});
}

Labels kept_in(const frame::Frame& f) {
    Labels labels;
    for (const frame::StageRun& s : f.stages)
        if (s.kept) labels.push_back(s.label);
    return labels;
}

// Renders ten frames, each of which must be a fresh one to the bit; returns what each of them kept.
std::vector<Labels> run(const Scene& scene, const frame::Settings& settings) {
    frame::KeptStages kept;
    std::vector<Labels> labels;
    for (int f = 0; f < 10; ++f) {
        CAPTURE(f);
        const Scene now = scene_at(scene, f);
        const frame::Frame& frame = frame::execute(now, settings, frame::plan(now, settings), {}, kept);
        REQUIRE(differences(frame, fresh(now, settings), now.frame_size) == Labels{});
        labels.push_back(kept_in(frame));
    }
    CHECK(labels[0].empty());
    return labels;
}

void check_every_later(const std::vector<Labels>& labels, const Labels& expected) {
    for (std::size_t f = 1; f < labels.size(); ++f) CHECK(labels[f] == expected);
}

}  // namespace

TEST_CASE("frames: where nothing moves everything is kept, and nothing is copied", "[frame][frames]") {
    const Scene scene = moving::scene();
    frame::Settings settings = settings_for(rsm::Gather::disc);
    settings.truth = true;
    const frame::Plan plan = frame::plan(scene, settings);
    frame::KeptStages kept;
    const frame::Frame& first = frame::execute(scene, settings, plan, {}, kept);
    const glm::vec4 *position = first.gbuffer.position.data(), *flux = first.rsms[0][0].flux.data();
    const glm::vec4 *indirect = first.indirect.data(), *truth = first.traced[0].estimate.mean.data();
    const std::vector<frame::StageRun> made = first.stages;
    const frame::Frame& second = frame::execute(scene, settings, plan, {}, kept);
    CHECK(second.gbuffer.position.data() == position);
    CHECK(second.rsms[0][0].flux.data() == flux);
    CHECK(second.indirect.data() == indirect);
    CHECK(second.traced[0].estimate.mean.data() == truth);
    CHECK(differences(second, fresh(scene, settings), scene.frame_size) == Labels{});
    REQUIRE(second.stages.size() == plan.stages.size());
    for (std::size_t i = 0; i < made.size(); ++i) {
        const frame::StageRun& s = second.stages[i];
        CHECK_FALSE(made[i].kept);
        CHECK(s.kept);
        CHECK(s.reason == "kept: nothing that it reads has changed");
        CHECK(s.saved_ms == made[i].ms);
        CHECK(s.bytes == made[i].bytes);
        CHECK(s.isa == made[i].isa);
    }
    // A third frame still knows what making it took.
    const std::vector<frame::StageRun> third = frame::execute(scene, settings, plan, {}, kept).stages;
    for (std::size_t i = 0; i < made.size(); ++i) CHECK(third[i].saved_ms == made[i].ms);
}

TEST_CASE("frames: a moving camera keeps the lights' maps", "[frame][frames]") {
    Scene scene = moving::scene();
    moving::move_camera(scene);
    for (auto gather : {rsm::Gather::disc, rsm::Gather::paths, rsm::Gather::all, rsm::Gather::all_rays}) {
        const std::vector<Labels> labels = run(scene, settings_for(gather));
        check_every_later(labels, {"rsm (key)", "rsm (sun)", "rsm (bulb)"});
    }
}

TEST_CASE("frames: a moving light keeps the G-buffer and all of the other lights", "[frame][frames]") {
    Scene scene = moving::scene();
    moving::move_light(scene, 0);
    for (auto gather : {rsm::Gather::disc, rsm::Gather::paths, rsm::Gather::all_rays}) {
        const std::string name = rsm::stage_name(gather);
        check_every_later(run(scene, settings_for(gather)),
                          {"gbuffer", "rsm (sun)", "shadow (sun)", name + " (sun)", "rsm (bulb)", "shadow (bulb)",
                           name + " (bulb)"});
    }
}

TEST_CASE("frames: a moving object changes what any stage sees", "[frame][frames]") {
    Scene scene = moving::scene();
    moving::move_block(scene);
    for (auto gather : {rsm::Gather::disc, rsm::Gather::paths, rsm::Gather::all_rays})
        check_every_later(run(scene, settings_for(gather)), {});
}

TEST_CASE("frames: a light that goes out and comes back", "[frame][frames]") {
    Scene scene = moving::scene();
    moving::switch_light(scene, 0);
    for (bool pruning : {true, false}) {
        frame::Settings settings = settings_for(rsm::Gather::disc);
        settings.pruning = pruning;
        const std::vector<Labels> labels = run(scene, settings);
        const Labels others = {"gbuffer",    "rsm (sun)",     "shadow (sun)",   "rsm.disc (sun)",
                               "rsm (bulb)", "shadow (bulb)", "rsm.disc (bulb)"};
        for (std::size_t f : {3, 6}) CHECK(labels[f] == others);
        // Between the switches nothing changes; a light that is left out has nothing to keep.
        for (std::size_t f : {1, 2, 7, 8, 9}) CHECK(labels[f].size() == 13);
        for (std::size_t f : {4, 5}) CHECK(labels[f].size() == (pruning ? 10 : 13));
    }
}

TEST_CASE("frames: everything at once, by every method, layout and gather", "[frame][frames]") {
    Scene scene = moving::scene();
    moving::move_camera(scene), moving::move_light(scene, 0), moving::switch_light(scene, 2), moving::move_block(scene);
    for (bool pruning : {true, false})
        for (auto method : {frame::Method::direct, frame::Method::rsm, frame::Method::isr, frame::Method::zbuffer, frame::Method::reference}) {
            frame::Settings settings = settings_for(rsm::Gather::disc);
            settings.method = method, settings.pruning = pruning;
            settings.truth = method != frame::Method::reference;
            run(scene, settings);
        }
    for (auto gather : {rsm::Gather::paths, rsm::Gather::all, rsm::Gather::all_rays})
        for (const char* layout : {"rgba16f", "lra"}) {
            frame::Settings settings = settings_for(gather);
            settings.layout = frame::parse_layout(layout, "test");
            settings.rsm.max_rays = 20 * 14 * 64;  // all_rays: a subset, with an error
            run(scene, settings);
        }
}

TEST_CASE("frames: other materials keep the levels of textures, other textures do not", "[frame][frames]") {
    Scene scene = moving::scene();
    scene.textures.push_back(scene.textures[0]);  // no material has it
    for (Texture& texture : scene.textures) texture.mips = true;
    const frame::Settings settings = settings_for(rsm::Gather::disc);
    frame::KeptStages kept;
    frame::execute(scene, settings, frame::plan(scene, settings), {}, kept);
    // Marks its smallest level: one that is made anew has no mark.
    auto& last = kept.memory().world.surfaces.texels.back();
    const auto made = last;
    REQUIRE(kept.memory().world.surfaces.any_levels);
    last ^= 0x010101;
    const auto check_next = [&](std::int32_t expected) {
        const frame::Frame& frame = frame::execute(scene, settings, frame::plan(scene, settings), {}, kept);
        CHECK(differences(frame, fresh(scene, settings), scene.frame_size) == Labels{});
        CHECK(kept.memory().world.surfaces.texels.back() == expected);
    };
    scene.materials[1].emission.x += 1;
    check_next(made ^ 0x010101);
    scene.materials[0].reflectance.y = 0.25f;
    check_next(made ^ 0x010101);
    scene.textures[0].texels(0, 0) ^= 0x808080;
    check_next(made);
}

namespace {

// Bakes by what they depend on here.
std::map<std::string, std::shared_ptr<const probes::Bake>> bakes;

std::shared_ptr<const probes::Bake> bake_of(const Scene& scene, frame::Settings settings) {
    std::shared_ptr<const probes::Bake>& bake = bakes[scene.materials[0].normal_texture < 0 ? "plain" : "bumps"];
    if (bake) return bake;
    settings.probes.lightmap_size = 32, settings.probes.receiver_rays = 8, settings.probes.test_rays = 0;
    settings.probes.placement.count = 4, settings.probes.relight_rays = 64;
    frame::add_bake(scene, settings);
    return bake = settings.bake;
}

}  // namespace

TEST_CASE("frames: any sequence of changes gives the bits of a fresh frame", "[frame][frames]") {
    std::mt19937 random(7);
    const auto pick = [&](int n) { return int(random() % unsigned(n)); };
    for (int sequence = 0; sequence < 4; ++sequence) {
        Scene scene = moving::scene();
        bakes.clear();
        frame::Settings settings = settings_for(rsm::Gather::disc);
        frame::KeptStages kept;
        int reused = 0;
        for (int f = 0; f < 30; ++f) {
            const int change = pick(16);
            CAPTURE(sequence, f, change);
            const int light = pick(int(scene.lights.size()));
            const float step = 0.05f * float(1 + pick(4));
            if (change == 0) scene.camera.position.x += step;
            if (change == 1) scene.lights[std::size_t(light)].position.x += step;
            if (change == 2) scene.lights[std::size_t(light)].on = !scene.lights[std::size_t(light)].on;
            if (change == 3) scene.meshes[1].transform[3].y += step;
            if (change == 4) settings.pruning = !settings.pruning;
            if (change == 5) settings.tonemap.exposure += step;
            if (change == 6) settings.method = frame::Method(pick(5));
            if (change == 7) settings.truth = !settings.truth;
            if (change == 8) settings.rsm.gather = rsm::Gather(pick(3));
            if (change == 9) std::swap(scene.frame_size.x, scene.frame_size.y);
            if (change == 10) scene.lights.push_back(moving::spot("more", {-0.5f, 1.5f, step}, {0, -1, step}, 3));
            if (change == 11 && scene.lights.size() > 2) scene.lights.erase(scene.lights.begin() + light);
            if (change == 12) scene.materials[1].emission.x += step;
            if (change == 13) scene.lights[std::size_t(light)].type = LightType(pick(3));
            if (change == 14) scene.meshes[0].share = scene.meshes[0].share == 0 ? 1 : 0;
            if (change == 15) scene.materials[0].normal_texture = scene.materials[0].normal_texture < 0 ? 1 : -1;
            if (settings.method == frame::Method::reference) settings.truth = false;
            // A bake of the static meshes as they are now.
            settings.bake = nullptr;
            if (change == 3 || change == 14) bakes.clear();
            if (settings.method == frame::Method::probes) settings.bake = bake_of(scene, settings);
            const frame::Frame& frame = frame::execute(scene, settings, frame::plan(scene, settings), {}, kept);
            REQUIRE(differences(frame, fresh(scene, settings), scene.frame_size) == Labels{});
            reused += int(kept_in(frame).size());
        }
        CHECK(reused > 60);  // of about 300 stages: kept ones are what this is about
    }
}

TEST_CASE("frames: kept or not, a stage tells the same that it reads, and nothing of what was left out", "[frame][frames]") {
    Scene scene = moving::scene();
    scene.lights[2].on = false;
    for (const frame::Method method : {frame::Method::rsm, frame::Method::isr}) {
        frame::Settings settings = settings_for(rsm::Gather::disc);
        settings.method = method;
        const frame::Plan plan = frame::plan(scene, settings);
        frame::KeptStages kept;
        const frame::Frame plain = frame::execute(scene, settings, plan, {});
        const frame::Frame& keyed = frame::execute(scene, settings, plan, {}, kept);
        for (std::size_t i = 0; i < plan.stages.size(); ++i) {
            CAPTURE(plan.stages[i].label);
            CHECK(plain.stages[i].reads == keyed.stages[i].reads);
            CHECK(plain.stages[i].key == 0);
            CHECK(keyed.stages[i].key != 0);
            if (plan.stages[i].label == "compose")
                CHECK(plain.stages[i].reads == Labels{"direct", "gbuffer", "rsm.disc (key)", "rsm.disc (sun)"});
        }
    }
}

TEST_CASE("frames: filters, visibility and gathers in turns keep what they may, and no more", "[frame][frames]") {
    const Scene scene = moving::scene();
    frame::KeptStages kept;
    for (std::uint32_t i = 0; i < 60; ++i) {
        CAPTURE(i);
        frame::Settings settings = settings_for(rsm::Gather::paths);
        settings.rsm.gather = i % 7 == 0 ? rsm::Gather::disc : i % 11 == 0 ? rsm::Gather::all_rays : rsm::Gather::paths;
        settings.rsm.visibility = rsm::Visibility(pcg(std::int32_t(i)) & 3);
        settings.rsm.slots = i % 5 + 2;
        const bool filters = settings.rsm.gather != rsm::Gather::all_rays;
        settings.indirect.resolution = filter::Resolution(filters && (i / 3) % 2);
        settings.indirect.blur = filter::Blur(1 + (filters ? (i / 2) % 3 : 0));
        if (i % 13 == 12) settings.method = frame::Method::isr;
        const frame::Frame& frame = frame::execute(scene, settings, frame::plan(scene, settings), {}, kept);
        REQUIRE(differences(frame, fresh(scene, settings), scene.frame_size) == Labels{});
    }
}

TEST_CASE("frames: a stage whose key does not change when it should is seen in the picture", "[frame][frames]") {
    Scene scene = moving::scene();
    moving::move_camera(scene), moving::move_light(scene, 0), moving::move_light(scene, 1), moving::move_light(scene, 2),
        moving::move_block(scene);
    frame::Settings settings = settings_for(rsm::Gather::disc);
    settings.truth = true;
    const std::size_t stages = frame::plan(scene, settings).stages.size();
    REQUIRE(stages == 16);  // 3 a light, and gbuffer, direct, compose, tonemap, three layers of truth
    for (std::size_t broken = 0; broken < stages; ++broken) {
        const std::string id = graph::id_of(frame::plan(scene, settings).stages[broken]);
        frame::KeptStages kept(
            [&](const graph::Node& node, graph::Key key) { return graph::id_of(node.plan) == id ? 1 : key; });
        Labels wrong;
        for (int f : {0, 9}) {
            const Scene now = scene_at(scene, f);
            const frame::Plan plan = frame::plan(now, settings);
            const frame::Frame& frame = frame::execute(now, settings, plan, {}, kept);
            wrong = differences(frame, fresh(now, settings), now.frame_size);
            CAPTURE(plan.stages[broken].label);
            CHECK(wrong.empty() == (f == 0));
        }
    }
}

TEST_CASE("frames: after an exception nothing is kept", "[frame][frames]") {
    const Scene scene = moving::scene();
    const frame::Settings settings = settings_for(rsm::Gather::disc);
    const frame::Plan plan = frame::plan(scene, settings);
    frame::KeptStages kept;
    frame::execute(scene, settings, plan, {}, kept);
    Scene broken = scene;
    broken.lights[1].rsm_size = 0;
    CHECK_THROWS_AS(frame::execute(broken, settings, plan, {}, kept), InputError);
    const frame::Frame& after = frame::execute(scene, settings, plan, {}, kept);
    CHECK(kept_in(after).empty());
    CHECK(differences(after, fresh(scene, settings), scene.frame_size) == Labels{});
}
