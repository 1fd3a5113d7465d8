// Whole bakes at the ends of what parameters may be, and one line for what is beyond.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/error.h"
#include "probe_bakes.h"

using namespace plumb;
using namespace plumb::probes;
using namespace plumb::test;

namespace {

std::string refusal(const Scene& scene, const BakeParams& params) {
    try {
        BakeGraph graph(scene, params);
        run_all(graph);
    } catch (const InputError& e) {
        return e.what();
    }
    return "";
}

}  // namespace

TEST_CASE("bake: constant radiance gives pi L whatever rays, degrees, overlaps and singular values are", "[probes][analytic]") {
    // In a closed convex room to rounding, un-truncated and by clusters; 64 relight rays integrate degree 4 exactly, so degree 7
    // has 128 or more.
    const Scene scene = empty_room();
    const auto with = [](const std::function<void(BakeParams&)>& change) {
        BakeParams p = small();
        p.receivers_per_m2 = 4;
        change(p);
        return p;
    };
    const std::vector<std::pair<const char*, BakeParams>> cases = {
        {"256 rays", with([](BakeParams& p) { p.receiver_rays = 256; })},
        {"1024 rays", with([](BakeParams& p) { p.receiver_rays = 1024; })},
        {"one ray", with([](BakeParams& p) { p.receiver_rays = 1; })},
        {"degree 0", with([](BakeParams& p) { p.degree = 0; })},
        {"degree 0, one relight ray", with([](BakeParams& p) { p.degree = 0, p.relight_rays = 1; })},
        {"degree 3", with([](BakeParams& p) { p.degree = 3; })},
        {"1024 relight rays", with([](BakeParams& p) { p.relight_rays = 1024; })},
        {"one overlap", with([](BakeParams& p) { p.placement.overlaps = 1; })},
        {"16 overlaps of 40 probes", with([](BakeParams& p) { p.placement.overlaps = 16, p.placement.count = 40; })},
        {"16 overlaps of one probe", with([](BakeParams& p) { p.placement.overlaps = 16, p.placement.count = 1; })},
        {"4 singular values", with([](BakeParams& p) { p.singular_values = 4; })},
        {"64 singular values", with([](BakeParams& p) { p.singular_values = 64; })},
        {"clusters of one receiver", with([](BakeParams& p) { p.cluster_receivers = 2; })},
        {"clusters of 4095", with([](BakeParams& p) { p.cluster_receivers = 4096, p.by_size_only = true; })},
        {"threshold 0", with([](BakeParams& p) { p.threshold = 0; })},
        {"threshold 1", with([](BakeParams& p) { p.threshold = 1; })},
        {"no gap", with([](BakeParams& p) { p.gap = 0; })},
        {"no test rays", with([](BakeParams& p) { p.test_rays = 0; })},
    };
    for (const auto& [name, params] : cases) {
        BakeGraph graph(scene, params);
        run_all(graph);
        const Bake& b = graph.bake();
        CAPTURE(name, b.receivers.count());
        check_sound(b);
        CHECK(b.supports.unsupported == 0);
        CHECK(b.counts().traced > 0);
        CHECK(b.clusters.singular_values == params.singular_values);
        for (const Cluster& c : b.clusters.clusters) {
            CHECK(c.rank <= params.singular_values);
            CHECK(int(c.receivers.size()) < params.cluster_receivers);
        }
        const auto lambda = lambda_of(b, [](std::size_t) { return 1.0; });
        const auto whole = whole_irradiance(b, lambda), clustered = clustered_irradiance(b, lambda);
        double worst = 0, lost = 0, allowed = 0;
        for (std::size_t i = 0; i < whole.size(); ++i) {
            worst = std::max(worst, std::fabs(whole[i].x / host::pi - 1));
            lost = std::max(lost, std::fabs(clustered[i].x - whole[i].x));
        }
        for (const Cluster& c : b.clusters.clusters) {
            double squares = 0;
            for (const double s : c.spectrum) squares += s * s;
            allowed = std::max(allowed, c.error_frobenius * std::sqrt(squares * 4 * host::pi * double(c.probes.size())));
        }
        CAPTURE(worst, lost, allowed);
        CHECK(worst < 6e-8 * (params.receiver_rays + 200));
        CHECK(lost <= allowed + 2e-5);
        if (name == std::string("64 singular values") || name == std::string("degree 0")) CHECK(lost < 1e-3);
    }
}

TEST_CASE("bake: every parameter beyond its range is refused before anything is computed, and named", "[probes][refusals]") {
    const Scene scene = empty_room();
    BakeParams defaults;
    const std::size_t count = fields(defaults).size();
    CHECK(count >= 26);
    int tried = 0;
    for (std::size_t k = 0; k < count; ++k) {
        const auto refused = [&](double value) {
            BakeParams params = small();
            Field field = fields(params)[k];
            if (auto p = std::get_if<int*>(&field.value)) **p = int(value);
            if (auto p = std::get_if<float*>(&field.value)) **p = float(value);
            const std::string message = refusal(scene, params);
            CAPTURE(field.name, value, message);
            CHECK(message.starts_with("probes: " + field.name + " = "));
            CHECK(message.find('\n') == std::string::npos);
            ++tried;
        };
        const Field field = fields(defaults)[k];
        if (std::holds_alternative<bool*>(field.value)) continue;
        if (!field.choices.empty()) {
            refused(-1), refused(double(field.choices.size())), refused(1e9);
        } else if (std::holds_alternative<int*>(field.value)) {
            for (const double value : {field.min - 1, field.max + 1, -1e9, 1e9}) refused(value);
        } else {
            const double infinite = std::numeric_limits<double>::infinity();
            // Floats next to the range's ends.
            for (const double value : {std::nan(""), infinite, -infinite, double(std::nextafterf(float(field.min), -1e30f)),
                                       double(std::nextafterf(float(field.max), 1e38f)), -1.0, 1e30})
                refused(value);
        }
    }
    CHECK(tried > 80);
    // What the task of a bake is often asked with.
    BakeParams params = small();
    params.placement.overlaps = 32;
    CHECK_THAT(refusal(scene, params), Catch::Matchers::Contains("overlaps = 32: expected 1 to 16"));
    params = small(), params.singular_values = 1;
    CHECK_THAT(refusal(scene, params), Catch::Matchers::Contains("singular_values = 1: expected 4 to 64"));
}

TEST_CASE("bake: scenes that nothing can be baked of are refused in one line", "[probes][refusals]") {
    const auto line = [](const Scene& scene, const BakeParams& params = small()) {
        const std::string message = refusal(scene, params);
        CHECK(message.find('\n') == std::string::npos);
        return message;
    };
    using Catch::Matchers::Contains;
    CHECK_THAT(line(Scene{}), Contains("surface"));
    Scene meshes = scene_of({});
    CHECK_THAT(line(meshes), Contains("surface"));
    Mesh flat;
    for (int k = 0; k < 3; ++k) flat.vertices.push_back({{1, 2, 3}, 0, {0, 1, 0}, 0});
    flat.triangles.push_back({0, 1, 2});
    CHECK_THAT(line(scene_of(flat)), Contains("surface"));
    flat.vertices[1].position = {2, 2, 3}, flat.vertices[2].position = {3, 2, 3};
    CHECK_THAT(line(scene_of(flat)), Contains("surface"));
    for (const float value : {std::nanf(""), std::numeric_limits<float>::infinity()}) {
        Scene scene = empty_room();
        scene.meshes[0].vertices[3].position.y = value;
        CHECK_THAT(line(scene), Contains("finite"));
    }
    // Sheets back to back, with no room between: each is seen from its own side alone.
    Mesh sheets;
    add_quad(sheets, {-1, 0, -1}, {-1, 0, 1}, {1, 0, -1}, 0);
    add_quad(sheets, {-1, 0, -1}, {1, 0, -1}, {-1, 0, 1}, 0);
    CHECK(line(scene_of(sheets)) == "");
    // A box inside out has its surfaces back to back with everything: only backs are seen from without, only fronts from within.
    Mesh room;
    add_box(room, glm::vec3(-1), glm::vec3(1), 0, true);
    CHECK(line(scene_of(room)) == "");
    // A chart has a receiver even where it takes less than half a texel, but not where it takes less than a hundredth.
    BakeParams params = small();
    params.receivers_per_m2 = 0.01f;
    CHECK(line(empty_room(), params) == "");
    params.receivers_per_m2 = 1e-6f;
    CHECK_THAT(line(empty_room(), params), Contains("no surface covers a texel"));
    params = small(), params.lightmap_size = 1;
    CHECK_THAT(line(empty_room(), params), Contains("lightmap of 1 x 1 texels: expected room for 6 charts"));
}
