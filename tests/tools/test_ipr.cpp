// plumb experiment ipr: rows of a small room, a planted error, and what is judged.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/error.h"
#include "tests/gi/probe_bakes.h"
#include "tools/experiments/ipr.h"

using namespace plumb;
using namespace plumb::cli;
using namespace plumb::test;

namespace {

struct Room {
    Scene scene = furnished(2);
    frame::Settings settings;
    IprRequest request;
    RunOptions options;

    Room() {
        Light lamp;
        lamp.type = LightType::point, lamp.position = {1, 1.5f, 0.5f}, lamp.intensity = {10, 8, 6}, lamp.rsm_size = 64;
        scene.lights = {lamp};
        for (Material& m : scene.materials) m.reflectance = glm::vec3(0.7f);
        scene.camera.position = {-1.8, 0.5, -1.8}, scene.camera.look_at = {1, -0.5, 1}, scene.camera.fov_y_deg = 60, scene.camera.near = 0.01;
        settings = frame::settings_of(scene);
        settings.probes = small();
        settings.probes.placement.count = 16, settings.probes.placement.overlaps = 3;
        request.quick = true, request.samples = 8192, request.receivers = 128, request.updates = 2, request.size = {48, 32};
    }
};

IprVariant variant(const Room& room, const std::string& name) {
    IprVariant v;
    v.name = name, v.bake = room.settings.probes;
    return v;
}

}  // namespace

TEST_CASE("experiment ipr: an update whose reflectance is off by 10 % shows in the error", "[experiment][probes]") {
    const Room room;
    IprBench bench(room.scene, room.settings, room.request, room.options);
    const IprRow right = bench.row(variant(room, "right"));
    IprVariant more = variant(room, "planted"), less = more;
    more.reflectance = 1.1f, less.reflectance = 0.9f;
    const IprRow brighter = bench.row(more), darker = bench.row(less);
    CAPTURE(right.at_receivers.mean, right.at_receivers.bias, brighter.at_receivers.bias, darker.at_receivers.bias, right.at_receivers.noise);
    CHECK(std::fabs(right.at_receivers.bias) < 0.05);
    // Indirect light of a room of reflectance rho is about E rho / (1 - rho): 10 % more or less of rho = 0.7 are 43 % and -27 %.
    CHECK(brighter.at_receivers.bias - right.at_receivers.bias == Approx(1.1 * 0.3 / 0.23 - 1).margin(0.08));
    CHECK(darker.at_receivers.bias - right.at_receivers.bias == Approx(0.9 * 0.3 / 0.37 - 1).margin(0.08));
    CHECK(brighter.at_receivers.mean > 2 * right.at_receivers.mean);
    CHECK(darker.at_receivers.mean > 2 * right.at_receivers.mean);
    // The picture is not of that light: it is not judged.
    CHECK_FALSE(brighter.at_pixels);
    REQUIRE(right.at_pixels);
    CHECK(right.at_pixels->mean < 0.3);
}

TEST_CASE("experiment ipr: bytes of an update, times and convergence of a row", "[experiment][probes]") {
    const Room room;
    IprBench bench(room.scene, room.settings, room.request, room.options);
    const IprRow r = bench.row(variant(room, "row"));
    const probes::Bake& b = bench.bake(room.settings.probes);
    // 4 S J K C of matrices, of each cluster as many singular values as it has; U, a row a receiver; 16 bytes of each coefficient, of each
    // singular value of each cluster, receiver and texel.
    std::size_t matrix = 0;
    for (const probes::Cluster& c : b.clusters.clusters) matrix += std::size_t(c.rank) * c.probes.size() * std::size_t(b.coefficients());
    const std::size_t values = std::size_t(b.flat.singular_values), n = std::size_t(b.receivers.count());
    CHECK(r.bytes == 4 * (matrix + values * n) + 16 * (std::size_t(r.probes) * std::size_t(b.coefficients()) + values * std::size_t(r.clusters) + n +
                                                       std::size_t(r.lightmap) * std::size_t(r.lightmap)));
    CHECK(r.receivers == b.receivers.count());
    CHECK(r.ms.size() == 2);
    CHECK(r.median_ms() > 0);
    CHECK(r.rounds.find("gain") != std::string::npos);
    REQUIRE(r.ssim_truth);
    CHECK(*r.ssim_truth > 0.8);
    CHECK(*r.ssim_truth < 1);
    std::vector<IprRow> rows = {r};
    against(r, rows);
    CHECK(*rows[0].ssim == Approx(1));
    // Light that grows has a reason in place of numbers.
    IprVariant grows = variant(room, "grows");
    grows.run.feedback = probes::Feedback::material;
    CHECK(bench.row(grows).refused.find("light still grows") != std::string::npos);
    // Where nothing shines there is nothing to be held against.
    Scene dark = room.scene;
    dark.lights.clear();
    IprBench nothing(dark, room.settings, room.request, room.options);
    CHECK_THROWS_AS(nothing.row(variant(room, "dark")), InputError);
}

TEST_CASE("experiment ipr: small emissive quads lose no more through clusters than in un-truncated transport", "[experiment][probes]") {
    const Scene scene = ipr_quad_room();
    const Room room;
    IprBench bench(scene, frame::settings_of(scene), room.request, room.options);
    probes::BakeParams params = small();
    params.placement.count = 16, params.placement.overlaps = 3, params.relight_rays = 512;
    const IprQuads q = bench.quads(params);
    CAPTURE(q.hits, q.chain.rms, q.whole.rms, q.chain.noise);
    CHECK(q.hits > 3);
    CHECK(q.hits < 14);
    CHECK(q.whole.rms > 0.01);
    CHECK(q.ratio() <= most_quad_ratio);
    CHECK(q.ratio() > 1 / most_quad_ratio);
}

TEST_CASE("experiment ipr: errors as they are defined", "[experiment]") {
    compare::Plane truth(4, 1), own(4, 1), error(4, 1);
    truth.texels = {1, 2, 3, 2}, own.texels = {1.5, 2, 2, 2}, error.texels = {0.1, 0.1, 0.1, 0.1};
    const IprErrors e = ipr_errors(own, truth, error);
    CHECK(e.truth == Approx(2));
    CHECK(e.mean == Approx(1.5 / 4 / 2));
    CHECK(e.bias == Approx(-0.5 / 4 / 2));
    CHECK(e.rms == Approx(std::sqrt(1.25 / 4 - 0.01) / 2));
    CHECK(e.noise == Approx(0.05));
    // Where as much noise is taken out as there is error, the bias stays.
    error.texels = {5, 5, 5, 5};
    CHECK(ipr_errors(own, truth, error).rms == Approx(0.5 / 4 / 2));
    own.texels[0] = std::nan("");
    CHECK_THROWS_AS(ipr_errors(own, truth, error), InputError);
    std::fill(truth.texels.begin(), truth.texels.end(), 0.0);
    own.texels[0] = 0;
    CHECK_THROWS_AS(ipr_errors(own, truth, error), InputError);
}

TEST_CASE("experiment ipr: the limit is what lowers the error most", "[experiment]") {
    IprTable table;
    const auto add = [&](const std::string& name, double mean) {
        IprRow r;
        r.name = name, r.at_receivers.mean = mean;
        table.rows.push_back(r);
    };
    add("default", 0.04), add("probes", 0.02), add("degree", 0.05);
    const IprGoal g = goal_of("cornell", table);
    CHECK(g.most == 0.03);
    CHECK(g.reached == 0.04);
    CHECK(g.limit == "probes");
    CHECK(g.lowered == Approx(0.5));
    CHECK(goal_of("hall", table).most == 0.06);
    CHECK(goal_of("other", table).most == 0);
}
