// The filters of indirect light in a frame: which of them run, what they leave as it was, and that keeping, leaving out
// and explaining fit what ran.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "core/error.h"
#include "gi/frame/filters.h"
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

namespace {

frame::Settings settings_of(filter::Resolution resolution, filter::Blur blur,
                            rsm::Gather gather = rsm::Gather::all) {
    frame::Settings settings;
    settings.rsm.gather = gather, settings.rsm.samples = 16;
    settings.indirect.resolution = resolution, settings.indirect.blur = blur;
    return settings;
}

const filter::Resolution resolutions[] = {filter::Resolution::full, filter::Resolution::half};
const filter::Blur blurs[] = {filter::Blur::none, filter::Blur::full, filter::Blur::separable};

}  // namespace

TEST_CASE("filters: a plan has those that the settings ask for, before and after the gathers", "[frame][filter]") {
    const Scene scene = moving::scene();
    using R = filter::Resolution;
    using B = filter::Blur;
    auto labels = [&](R resolution, B blur) {
        return labels_of(frame::plan(scene, settings_of(resolution, blur)), "filter.");
    };
    CHECK(labels(R::full, B::none) == Labels{});
    // What samples a map leaves grain; what asks all of it does not, and shared frames take it away themselves.
    const auto by_default = [&](rsm::Gather gather, int frames) {
        frame::Settings settings = settings_of(R::full, filter::FilterParams().blur, gather);
        settings.reuse.frames = frames;
        return labels_of(frame::plan(scene, settings), "filter.");
    };
    const Labels separable = {"filter.blur (horizontal)", "filter.blur (vertical)"};
    CHECK(by_default(rsm::Gather::disc, screen::ReuseParams().frames) == separable);
    CHECK(by_default(rsm::Gather::paths, screen::ReuseParams().frames) == separable);
    CHECK(by_default(rsm::Gather::all, screen::ReuseParams().frames) == Labels{});
    CHECK(by_default(rsm::Gather::all_rays, screen::ReuseParams().frames) == Labels{});
    CHECK(by_default(rsm::Gather::disc, 20) == Labels{});
    CHECK(labels(R::full, B::full) == Labels{"filter.blur"});
    CHECK(labels(R::half, B::none) ==
          Labels{"filter.reduce (position)", "filter.reduce (normal)", "filter.upsample"});
    CHECK(labels(R::half, B::separable) == Labels{"filter.reduce (position)", "filter.reduce (normal)",
                                                  "filter.upsample", "filter.blur (horizontal)",
                                                  "filter.blur (vertical)"});
    const frame::Plan plan = frame::plan(scene, settings_of(R::half, B::full));
    CHECK(plan.stages[0].name == "gbuffer");
    CHECK(plan.stages[1].label == "filter.reduce (position)");
    const Labels all = labels_of(plan, "");
    const auto at = [&](const std::string& label) { return std::find(all.begin(), all.end(), label) - all.begin(); };
    CHECK(at("rsm.all (bulb)") < at("filter.upsample"));
    CHECK(at("filter.upsample") < at("filter.blur"));
    CHECK(at("filter.blur") < at("compose"));

    frame::Settings direct = settings_of(R::half, B::full);
    direct.method = frame::Method::direct;
    CHECK(labels_of(frame::plan(scene, direct), "filter.") == Labels{});
}

TEST_CASE("filters: a blur of one pixel changes no light, and its depth goes along", "[frame][filter]") {
    const Scene scene = moving::scene();
    frame::Settings settings = settings_of(filter::Resolution::full, filter::Blur::full);
    settings.indirect.kernel = 1;
    const frame::Frame plain = render(scene, settings_of(filter::Resolution::full, filter::Blur::none));
    const frame::Frame blurred = render(scene, settings);
    CHECK(same_bits(blurred.radiance, plain.radiance));
    CHECK(plain.gathered.empty());
    for (std::size_t i = 0; i < plain.indirect.size(); ++i)
        CHECK(blurred.indirect.texels[i] == glm::vec4(glm::vec3(plain.indirect.texels[i]),
                                                      plain.gbuffer.position.texels[i].w));
}

TEST_CASE("filters: half resolution is close to full", "[frame][filter]") {
    Scene scene = moving::scene();
    scene.frame_size = {193, 128};
    scene.materials[0].normal_texture = -1;
    scene.meshes.pop_back();  // holes between picks
    auto settings_for = [](filter::Resolution resolution) {
        frame::Settings settings = settings_of(resolution, filter::Blur::none);
        settings.rsm.min_distance = 0.2f;  // without peaks where points touch texels
        return settings;
    };
    const frame::Frame full = render(scene, settings_for(filter::Resolution::full));
    // The error that one pixel in ten exceeds; the others are where light ends at a corner, between two picks.
    auto error = [&](filter::Upsample upsample) {
        frame::Settings settings = settings_for(filter::Resolution::half);
        settings.indirect.upsample = upsample;
        const frame::Frame half = render(scene, settings);
        CHECK(half.gathered.width == 97);
        CHECK(half.gathered.height == 64);
        std::vector<double> errors;
        for (std::size_t i = 0; i < full.indirect.size(); ++i) {
            const double a = half.indirect.texels[i].x, b = full.indirect.texels[i].x;
            if (b > 0) errors.push_back(std::abs(a - b) / b);
        }
        std::sort(errors.begin(), errors.end());
        return errors.at(errors.size() * 9 / 10);
    };
    const double bilateral = error(filter::Upsample::bilateral), bilinear = error(filter::Upsample::bilinear),
                 published = error(filter::Upsample::published);
    CAPTURE(bilateral, bilinear, published);
    CHECK(bilateral < 0.05);
    CHECK(bilateral < bilinear);
    CHECK(bilinear < published);
}

TEST_CASE("filters: frames that are kept are fresh ones to the bit", "[frame][frames][filter]") {
    for (int moved = 0; moved < 4; ++moved)
        for (filter::Resolution resolution : resolutions)
            for (filter::Blur blur : blurs) {
                CAPTURE(moved, int(resolution), int(blur));
                Scene scene = moving::scene();
                if (moved == 1) moving::move_camera(scene);
                if (moved == 2) moving::switch_light(scene, 0);
                if (moved == 3) moving::move_block(scene);
                frame::KeptStages kept;
                for (int f = 0; f < 8; ++f) {
                    const Scene now = scene_at(scene, f);
                    // Every third frame is filtered otherwise.
                    frame::Settings settings = settings_of(resolution, blur, rsm::Gather::disc);
                    if (f % 3 == 2) settings.indirect = {};
                    const frame::Frame& got = frame::execute(now, settings, frame::plan(now, settings), {}, kept);
                    const frame::Frame fresh = render(now, settings);
                    CHECK(moving::differences(got, fresh, now.frame_size) == Labels{});
                    CHECK(same_bits(got.indirect, fresh.indirect));
                    if (moved == 0 && f == 1)
                        for (const frame::StageRun& s : got.stages) CHECK(s.kept);
                }
            }
}

TEST_CASE("filters: they are left out where no gather runs", "[frame][pruning][filter]") {
    Scene scene = moving::scene();
    for (Light& light : scene.lights) light.on = false;
    frame::Settings settings = settings_of(filter::Resolution::half, filter::Blur::separable);
    const frame::Frame pruned = render(scene, settings);
    for (const frame::StageRun& s : pruned.stages)
        if (s.label.rfind("filter.", 0) == 0) CHECK(s.rule == "no-gather");
    settings.pruning = false;
    CHECK(same_bits(pruned.indirect, render(scene, settings).indirect));
}

TEST_CASE("filters: a truth is not filtered", "[frame][refusals][filter]") {
    const Scene scene = moving::scene();
    CHECK_THROWS_WITH(
        frame::plan(scene, settings_of(filter::Resolution::half, filter::Blur::none, rsm::Gather::all_rays)),
        "moving: [indirect] resolution = half: rsm.all_rays is a truth with a standard error of its own, which no filter "
        "keeps: expected resolution = full and blur = none");
    CHECK_THROWS_AS(
        frame::plan(scene, settings_of(filter::Resolution::full, filter::Blur::full, rsm::Gather::all_rays)),
        InputError);
    CHECK_NOTHROW(
        frame::plan(scene, settings_of(filter::Resolution::full, filter::Blur::none, rsm::Gather::all_rays)));
}

TEST_CASE("filters: explain and the frame's data tell what the frame has", "[frame][explain][filter]") {
    const Scene scene = moving::scene();
    const frame::Settings settings = settings_of(filter::Resolution::half, filter::Blur::separable, rsm::Gather::disc);
    const frame::Plan plan = frame::plan(scene, settings);
    const frame::Frame f = frame::execute(scene, settings, plan, {});
    const glm::ivec2 pixel(9, 10);
    auto last = [&](const frame::Explanation& e) {
        const std::vector<double>& v = e.values.back().value;
        return glm::vec3(v.at(0), v.at(1), v.at(2));
    };
    const std::vector<frame::Explanation> blur = frame::explain(scene, settings, plan, f, "filter.blur", -1, pixel);
    REQUIRE(blur.size() == 2);
    CHECK(last(blur[0]) == glm::vec3(f.blurred_across(9, 10)));
    CHECK(last(blur[1]) == glm::vec3(f.indirect(9, 10)));
    const auto up = frame::explain(scene, settings, plan, f, "filter.upsample", -1, pixel);
    CHECK(last(up.at(0)) == glm::vec3(f.upsampled(9, 10)));
    CHECK_THROWS_AS(frame::explain(scene, settings, plan, f, "rsm.disc", -1, {15, 3}), InputError);
    CHECK(frame::explain(scene, settings, plan, f, "", -1, {19, 13}).size() > 8);

    std::map<std::string, const Image4*> expected = {
        {"filter.reduce.position", &f.half_position}, {"filter.reduce.normal", &f.half_normal},
        {"filter.upsample", &f.upsampled},            {"filter.blur.horizontal", &f.blurred_across},
        {"filter.blur.vertical", &f.indirect}};
    for (const StageData& data : parity::frame_data(scene, settings, plan, f)) {
        if (!expected.contains(data.id)) continue;
        CAPTURE(data.id);
        const Image4& image = *expected.at(data.id);
        Bundle outputs;
        parity::find_binding(data.stage, data.label).bind(data)->run({}, {}, outputs);
        CHECK(std::memcmp(outputs.arrays.at(0).bytes.data(), image.data(), outputs.arrays.at(0).bytes.size()) == 0);
        expected.erase(data.id);
    }
    CHECK(expected.empty());
}

TEST_CASE("filters: a parameter changes the keys of the stages whose result it changes, and of none that cannot read it",
          "[frame][frames][keys][filter]") {
    const Scene scene = moving::scene();
    const frame::Settings before = settings_of(filter::Resolution::half, filter::Blur::separable, rsm::Gather::disc);
    const test::Ran old(scene, before);
    const Labels filters = {"filter.upsample", "filter.blur (horizontal)", "filter.blur (vertical)"};
    frame::Settings counted = before;
    for (std::size_t i = 0; i < filter::fields(counted.indirect).size(); ++i) {
        frame::Settings after = before;
        Field field = filter::fields(after.indirect)[i];
        CAPTURE(field.name);
        if (int** p = std::get_if<int*>(&field.value)) **p = field.choices.empty() ? 5 : **p == 0 ? 1 : 0;
        if (field.name == "blur") after.indirect.blur = filter::Blur::full;  // automatic is separable here
        if (float** p = std::get_if<float*>(&field.value)) **p *= 0.5f;
        const test::Ran now(scene, after);
        int changed = 0;
        for (std::size_t i = 0; i < now.plan.stages.size(); ++i) {
            const std::string& label = now.plan.stages[i].label;
            CAPTURE(label);
            const bool gather = label.rfind("rsm.disc", 0) == 0;
            const bool reads = std::count(filters.begin(), filters.end(), label) > 0 || label == "compose" ||
                               label == "tonemap" || (gather && field.name == "resolution");
            for (std::size_t k = 0; k < old.plan.stages.size(); ++k) {
                if (old.plan.stages[k].label != label) continue;
                const bool same = old.keys[k] == now.keys[i];
                if (same) CHECK(test::same_bytes(old.outputs.at(label), now.outputs.at(label)));
                CHECK((same || reads));
                changed += !same;
            }
        }
        CHECK(changed >= 2);
    }
}
