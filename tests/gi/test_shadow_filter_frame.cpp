// The filter of shadows in a frame: where it runs, what it leaves as it was, and that keeping, leaving out and explaining
// fit what ran.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>

#include "gi/direct/direct.h"
#include "gi/direct/visibility_filter.h"
#include "gi/frame/idle_settings.h"
#include "gi/frame/kept.h"
#include "gi/parity/side_by_side.h"
#include "gi/parity/stages.h"
#include "tests/gi/frame_bits.h"
#include "tests/gi/keys_of.h"
#include "tests/gi/moving_scene.h"

using namespace plumb;
using test::labels_of;
using test::Labels;
using test::render;
using test::same_bits;
using direct::VisibilityFilter;

namespace {

frame::Settings settings_of(VisibilityFilter filter, frame::Method method = frame::Method::direct) {
    frame::Settings settings;
    settings.method = method, settings.rsm.samples = 9;
    settings.shadow.mode = direct::ShadowMode::hard, settings.shadow.test = direct::ShadowTest::depth;
    settings.shadow.filter = filter, settings.shadow.filter_radius = 2, settings.shadow.filter_sigma = 1;
    return settings;
}

const VisibilityFilter filters[] = {VisibilityFilter::none, VisibilityFilter::gaussian, VisibilityFilter::edge_aware};

}  // namespace

TEST_CASE("shadow.filter: without it no bit changes and no plan has it", "[frame][shadow][filter]") {
    CHECK(direct::ShadowParams().filter == VisibilityFilter::none);
    const Scene scene = moving::scene();
    for (const frame::Method method : {frame::Method::direct, frame::Method::rsm, frame::Method::isr, frame::Method::zbuffer}) {
        const frame::Settings plain = settings_of(VisibilityFilter::none, method);
        frame::Settings other = plain;
        other.shadow.filter_radius = 7, other.shadow.filter_sigma = 3, other.shadow.filter_sigma_depth = 0.5f;
        other.shadow.filter_sigma_normal = 1;
        CAPTURE(frame::method_name(method));
        const frame::Plan plan = frame::plan(scene, other);
        CHECK(labels_of(plan, "shadow.filter") == Labels{});
        const frame::Frame f = render(scene, other);
        CHECK(moving::differences(render(scene, plain), f, scene.frame_size) == Labels{});
        CHECK(f.visibility_filtered.empty());
        CHECK(test::keys_of(scene, plain) == test::keys_of(scene, other));
        CHECK(frame::idle(plain, scene, "shadow", "filter_radius") ==
              (method == frame::Method::zbuffer ? "nothing casts shadows" : "shadow.filter is none"));
    }
}

TEST_CASE("shadow.filter: a plan runs it for each light, between its shadow and direct light", "[frame][shadow][filter]") {
    const Scene scene = moving::scene();
    for (const frame::Method method : {frame::Method::direct, frame::Method::rsm, frame::Method::isr}) {
        const frame::Plan plan = frame::plan(scene, settings_of(VisibilityFilter::gaussian, method));
        CHECK(labels_of(plan, "shadow.filter") ==
              Labels{"shadow.filter (key, horizontal)", "shadow.filter (key, vertical)", "shadow.filter (sun, horizontal)",
                     "shadow.filter (sun, vertical)", "shadow.filter (bulb, horizontal)", "shadow.filter (bulb, vertical)"});
        const Labels all = labels_of(plan, "");
        const auto at = [&](const std::string& label) { return std::find(all.begin(), all.end(), label) - all.begin(); };
        CHECK(at("shadow (sun)") < at("shadow.filter (sun, horizontal)"));
        CHECK(at("shadow.filter (sun, vertical)") < at("direct"));
    }
    CHECK(labels_of(frame::plan(scene, settings_of(VisibilityFilter::gaussian, frame::Method::zbuffer)), "shadow.") == Labels{});
    frame::Settings dark = settings_of(VisibilityFilter::gaussian, frame::Method::isr);
    dark.isr.mode = isr::Mode::f3;
    CHECK(labels_of(frame::plan(scene, dark), "shadow") == Labels{});
    CHECK_NOTHROW(render(scene, dark));
}

TEST_CASE("shadow.filter: direct light is that of filtered shadows, which every layout stores as it stores shadows",
          "[frame][shadow][filter]") {
    const Scene scene = moving::scene();
    const std::size_t pixels = std::size_t(scene.frame_size.x) * std::size_t(scene.frame_size.y);
    for (const VisibilityFilter filter : {VisibilityFilter::gaussian, VisibilityFilter::edge_aware})
        for (const raster::Layout& layout : raster::layouts()) {
            CAPTURE(int(filter), layout.name);
            frame::Settings settings = settings_of(filter), plain = settings_of(VisibilityFilter::none);
            settings.layout = plain.layout = layout;
            const frame::Frame f = render(scene, settings), sharp = render(scene, plain);
            CHECK(f.visibility == sharp.visibility);
            CHECK_FALSE(f.visibility_filtered == f.visibility);
            CHECK(&frame::shadows_of(f) == &f.visibility_filtered);
            CHECK(&frame::shadows_of(sharp) == &sharp.visibility);
            Buffer<float> expected(f.visibility.size());
            for (std::size_t l = 0; l < scene.lights.size(); ++l) {
                direct::VisibilityFilterInputs in{f.visibility.data() + l * pixels, &f.gbuffer.position, &f.gbuffer.normal};
                Buffer<float> across(pixels);
                for (const direct::Direction d : {direct::Direction::horizontal, direct::Direction::vertical}) {
                    float* out = d == direct::Direction::horizontal ? across.data() : expected.data() + l * pixels;
                    in.direction = d;
                    run(stage<direct::VisibilityFilterKernel>(), data_of(settings.shadow, in), {}, out);
                    raster::quantise(layout.visibility, out, scene.frame_size, 1);
                    in.visibility = across.data();
                }
            }
            CHECK(f.visibility_filtered == expected);
            Image4 light;
            const direct::DirectInputs in{&f.gbuffer.position, &f.gbuffer.normal, &scene.lights, &expected};
            direct::run(settings.direct, in, {}, light);
            CHECK(same_bits(f.direct, light));
            CHECK_FALSE(same_bits(f.direct, sharp.direct));
        }
}

TEST_CASE("shadow.filter: frames that are kept are fresh ones to the bit", "[frame][frames][shadow][filter]") {
    for (int moved = 0; moved < 4; ++moved) {
        Scene scene = moving::scene();
        if (moved == 1) moving::move_camera(scene);
        if (moved == 2) moving::switch_light(scene, 0);
        if (moved == 3) moving::move_block(scene);
        frame::KeptStages kept;
        for (int f = 0; f < 9; ++f) {
            CAPTURE(moved, f);
            // Every frame is filtered otherwise, but for pairs.
            const frame::Settings settings = settings_of(filters[f / 2 % 3]);
            const Scene now = scene_at(scene, f);
            const frame::Frame& got = frame::execute(now, settings, frame::plan(now, settings), {}, kept);
            CHECK(moving::differences(got, render(now, settings), now.frame_size) == Labels{});
            for (const frame::StageRun& s : got.stages) {
                if (moved == 0 && f % 2 == 1) CHECK(s.kept);
                // Shadows themselves do not know of it.
                if (moved == 0 && f > 0 && s.label.rfind("shadow (", 0) == 0) CHECK(s.kept);
            }
        }
    }
}

TEST_CASE("shadow.filter: it is left out with the shadow of its light, and changes nothing by it",
          "[frame][pruning][shadow][filter]") {
    Scene scene = moving::scene();
    scene.lights[0].on = false, scene.lights[1].intensity = glm::vec3(0);
    for (const VisibilityFilter filter : filters) {
        frame::Settings settings = settings_of(filter);
        const frame::Frame pruned = render(scene, settings);
        int left_out = 0;
        for (const frame::StageRun& s : pruned.stages)
            if (s.label.rfind("shadow.filter", 0) == 0) {
                const bool bulb = s.label.find("bulb") != std::string::npos;
                CHECK(s.needed == bulb);
                left_out += !s.needed;
                if (!bulb) CHECK(s.rule == (s.label.find("key") != std::string::npos ? "light-off" : "light-black"));
            }
        CHECK(left_out == (filter == VisibilityFilter::none ? 0 : 4));
        settings.pruning = false;
        const frame::Frame whole = render(scene, settings);
        CHECK(same_bits(pruned.radiance, whole.radiance));
        CHECK(same_bits(pruned.direct, whole.direct));
    }
}

TEST_CASE("shadow.filter: explain and the frame's data tell what the frame has", "[frame][explain][shadow][filter]") {
    const Scene scene = moving::scene();
    frame::Settings settings = settings_of(VisibilityFilter::edge_aware);
    settings.layout = raster::parse_layout("rgba16f", "test");
    const frame::Plan plan = frame::plan(scene, settings);
    const frame::Frame f = frame::execute(scene, settings, plan, {});
    const std::size_t pixels = std::size_t(scene.frame_size.x) * std::size_t(scene.frame_size.y);
    const std::size_t pixel = std::size_t(10 * scene.frame_size.x + 9);
    for (int light = 0; light < int(scene.lights.size()); ++light) {
        const auto told = frame::explain(scene, settings, plan, f, "shadow.filter", light, {9, 10});
        REQUIRE(told.size() == 2);
        const Buffer<float>* const made[] = {&f.visibility_across, &f.visibility_filtered};
        for (int pass = 0; pass < 2; ++pass)
            CHECK(float(told[std::size_t(pass)].values.back().value.at(0)) ==
                  made[pass]->data()[std::size_t(light) * pixels + pixel]);
    }
    int seen = 0;
    for (const StageData& data : parity::frame_data(scene, settings, plan, f)) {
        if (data.stage != "shadow.filter") continue;
        ++seen;
        CHECK((data.id.ends_with(".key") || data.id.ends_with(".sun") || data.id.ends_with(".bulb")));
        CHECK((data.id.starts_with("shadow.filter.horizontal.") || data.id.starts_with("shadow.filter.vertical.")));
    }
    CHECK(seen == 6);
}

TEST_CASE("shadow.filter: a parameter changes the keys of the filter and of what reads it, and of nothing before",
          "[frame][frames][keys][shadow][filter]") {
    const Scene scene = moving::scene();
    const frame::Settings before = settings_of(VisibilityFilter::edge_aware);
    const test::Ran old(scene, before);
    for (const std::string name : {"filter_radius", "filter_sigma", "filter_sigma_depth", "filter_sigma_normal"}) {
        frame::Settings after = before;
        for (Field& field : direct::fields(after.shadow)) {
            if (field.name != name) continue;
            if (int** p = std::get_if<int*>(&field.value)) **p += 1;
            if (float** p = std::get_if<float*>(&field.value)) **p *= 0.5f;
        }
        const test::Ran now(scene, after);
        REQUIRE(now.plan.stages.size() == old.plan.stages.size());
        for (std::size_t i = 0; i < now.keys.size(); ++i) {
            const std::string& label = now.plan.stages[i].label;
            CAPTURE(name, label);
            const bool reads = label.rfind("shadow.filter", 0) == 0 || label == "direct" || label == "compose" ||
                               label == "tonemap";
            CHECK((old.keys[i] != now.keys[i]) == reads);
        }
    }
}
