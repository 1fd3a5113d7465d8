// The coefficients of receivers against closed forms, and the two stages against plain loops in double.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/hash.h"
#include "core/host_math.h"
#include "core/sh.h"
#include "gi/lend.h"
#include "gi/probes/coefficients.h"
#include "gi/probes/share.h"
#include "gi/probes/transport.h"
#include "gi/reference/ray_query.h"
#include "raster/surfaces.h"

namespace {

using namespace plumb;
using namespace plumb::probes;

// Triangles of one material, and rays at them.
struct World {
    Scene scene;
    Geometry geometry;
    raster::Surfaces surfaces;
    std::unique_ptr<RayQuery> query;

    explicit World(const Mesh& mesh) {
        scene.materials.resize(1);
        scene.meshes = {mesh};
        scene.meshes[0].material.assign(mesh.triangles.size(), 0);
        geometry = flatten(scene);
        surfaces = raster::prepare(scene, geometry);
        query = reference::build_ray_query(geometry, surfaces, Rays::exact);
    }
    TransportScene transport(const Buffer<glm::vec4>& probes, const TransportParams& params) const {
        TransportScene s;
        s.surfaces = raster::surface_args(geometry, surfaces, View{});
        s.query = query.get();
        s.offset = offset_of(extent_of(geometry));
        s.probes = &probes;
        s.directions = receiver_directions(params.rays, params.distribution);
        s.factors = ray_factors(s.directions, params.distribution);
        return s;
    }
};

void add_quad(Mesh& mesh, glm::vec3 a, glm::vec3 b, glm::vec3 c, glm::vec3 d) {
    const auto first = std::uint32_t(mesh.vertices.size());
    const glm::vec3 n = glm::normalize(glm::cross(b - a, c - a));
    for (const glm::vec3& p : {a, b, c, d}) mesh.vertices.push_back({p, 0, n, 0});
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.triangles.push_back({first, first + 2, first + 3});
}

// A cube around the origin, its fronts inwards.
Mesh room(float half) {
    Mesh mesh;
    for (int axis = 0; axis < 3; ++axis)
        for (const float side : {-1.0f, 1.0f}) {
            glm::vec3 n(0), u(0), v(0);
            n[axis] = side * half, u[(axis + 1) % 3] = half, v[(axis + 2) % 3] = side * half;
            // (-u) x (-v) points against n.
            add_quad(mesh, n - u - v, n - u + v, n + u + v, n + u - v);
        }
    return mesh;
}

Receivers receivers_at(const std::vector<std::pair<glm::vec3, glm::vec3>>& points) {
    Receivers r;
    for (const auto& [p, n] : points) r.position.push_back(glm::vec4(p, 0)), r.normal.push_back(glm::vec4(n, 0));
    return r;
}

// Each of the probes supports every receiver, with these weights.
Supports supported_by(const std::vector<float>& weights, int receivers) {
    Supports s;
    s.overlaps = int(weights.size());
    for (int i = 0; i < receivers; ++i)
        for (std::size_t k = 0; k < weights.size(); ++k) s.probe.push_back(int(k)), s.weight.push_back(weights[k]);
    return s;
}

Buffer<float> coefficients(const World& world, const Receivers& receivers, const Supports& supports,
                           const Buffer<glm::vec4>& probes, const TransportParams& params, RayCounts* counts = nullptr,
                           const RunOptions& options = {}) {
    const TransportScene scene = world.transport(probes, params);
    const TracedBlock block = trace_block(scene, params, receivers, supports, 0, receivers.count(), options);
    Buffer<float> alpha(std::size_t(receivers.count()) * std::size_t(supports.overlaps) * std::size_t(sh::count(params.degree)));
    block_coefficients(block, params, options, alpha.data());
    if (counts) *counts = block.counts;
    return alpha;
}

}  // namespace

TEST_CASE("probes: the room's fronts point inwards", "[probes]") {
    const World world(room(2));
    for (const Vertex& v : world.geometry.vertices) CHECK(glm::dot(v.position, v.normal) < 0);
}

TEST_CASE("probes: constant radiance gives pi L, wherever receiver and probes are", "[probes][analytic][IPR 5]") {
    // f = L everywhere: lambda_i0 = L sqrt(4 pi), the others 0; sum_i K_i Y_0 = Y_0 for each ray that a probe sees. The room
    // is convex: all probes see all of it. So E = sqrt(4 pi) sum_i alpha_i0 = sum_k f_k L = pi L, to rounding.
    const World world(room(2));
    const Receivers receivers = receivers_at({{{0.3f, -2, 0.1f}, {0, 1, 0}}, {{-2, 1.9f, -1.9f}, {1, 0, 0}},
                                              {{1, 1, 2}, {0, 0, -1}}, {{0, 0, 0}, glm::normalize(glm::vec3(1, -2, 0.5f))}});
    const Buffer<glm::vec4> probes = {{0, 0, 0, 0}, {1.5f, -1, 0.2f, 0}, {-1.9f, 1.9f, 1.9f, 0}};
    TransportParams params;
    RayCounts counts;
    const Buffer<float> alpha =
        coefficients(world, receivers, supported_by({1, 0.25f, 0.01f}, receivers.count()), probes, params, &counts);
    CHECK(counts.escaped == 0);
    CHECK(counts.back == 0);
    CHECK(counts.unseen == 0);
    CHECK(counts.traced == 4 * 512 * (1 + 3));
    for (int i = 0; i < receivers.count(); ++i) {
        double e = 0;
        for (int s = 0; s < 3; ++s) e += std::sqrt(4 * host::pi) * double(alpha[std::size_t(i * 3 + s) * 64]);
        CHECK(e == Approx(host::pi).epsilon(512 * 0x1p-24));  // a rounding a ray
        // A third of the weight is not a third of the light: the shares are those of the weights.
        CHECK(alpha[std::size_t(i * 3 + 1) * 64] == Approx(0.25 * double(alpha[std::size_t(i * 3) * 64])).epsilon(512 * 0x1p-23));
    }
}

TEST_CASE("probes: under an open sky alpha is the clamped cosine's A_l Y_lm(n)", "[probes][analytic]") {
    // The second solution of IPR 5.1.3.1, one probe above a floor: Psi is the ray's direction, so alpha_lm is the integral of
    // cos(theta) Y_lm over the hemisphere (Ramamoorthi and Hanrahan 2001).
    Mesh floor;
    add_quad(floor, {-9, 0, -9}, {-9, 0, 9}, {9, 0, 9}, {9, 0, -9});
    const World world(floor);
    REQUIRE(world.geometry.vertices[0].normal.y == 1);
    const Buffer<glm::vec4> probes = {{0, 5, 0, 0}};
    const glm::vec3 n(0, 1, 0);
    const Receivers receivers = receivers_at({{{0.5f, 0, 0.25f}, n}});
    TransportParams params;
    params.escape = Escape::same_direction;
    const sh::Values y = sh::basis(glm::dvec3(n));
    for (const Distribution distribution : {Distribution::cosine, Distribution::uniform}) {
        params.distribution = distribution;
        double before = 1;
        for (const int rays : {64, 512, 4096}) {
            params.rays = rays;
            const Buffer<float> alpha = coefficients(world, receivers, supported_by({0.7f}, 1), probes, params);
            double worst = 0;
            for (int l = 0; l <= 7; ++l)
                for (int m = -l; m <= l; ++m) {
                    const int j = sh::index(l, m);
                    worst = std::max(worst, std::fabs(double(alpha[std::size_t(j)]) -
                                                      sh::clamped_cosine()[std::size_t(l)] * y[std::size_t(j)]));
                }
            // Eight times as many rays: a set of low discrepancy errs less by more than sqrt(8) = 2.8.
            CHECK(worst < before / 3);
            before = worst;
        }
        CHECK(before < 2e-3);
    }
    // The first solution: nothing.
    params.escape = Escape::nothing;
    for (const float a : coefficients(world, receivers, supported_by({1}, 1), probes, params)) CHECK(a == 0);
}

TEST_CASE("probes: the four solutions for rays that meet nothing", "[probes][IPR 5.1.3.1]") {
    // A floor and a wall above it, from y = 2 to 3; probe 0 above the floor, probe 1 behind a screen that hides it from the
    // receiver, but from no part of the upper sky.
    Mesh mesh;
    add_quad(mesh, {-9, 0, -9}, {-9, 0, 9}, {9, 0, 9}, {9, 0, -9});
    add_quad(mesh, {1, 0, -9}, {1, 0, 9}, {1, 2, 9}, {1, 2, -9});
    const World world(mesh);
    const Buffer<glm::vec4> probes = {{-1, 1, 0, 0}, {2, 0.5f, 0, 0}};
    const Receivers receivers = receivers_at({{{0, 0, 0}, {0, 1, 0}}});
    TransportParams params;
    auto shares = [&](Escape escape) {
        params.escape = escape;
        const Buffer<float> alpha = coefficients(world, receivers, supported_by({1, 1}, 1), probes, params);
        return glm::dvec2(alpha[0], alpha[64]) * std::sqrt(4 * host::pi);
    };
    const glm::dvec2 nothing = shares(Escape::nothing), same = shares(Escape::same_direction),
                     visible = shares(Escape::visible_probes), all = shares(Escape::all_probes);
    CHECK(nothing.y == 0);             // it sees neither side that the receiver sees
    CHECK(same.x > nothing.x + 0.5);
    CHECK(same.y > 0.5);               // it sees most of the same sky
    CHECK(visible.y == 0);             // the screen hides it from the receiver
    CHECK(visible.x > same.x);
    CHECK(all.x + all.y == Approx(visible.x).epsilon(1e-5));  // what escapes counts once, whoever it is divided among
    CHECK(all.y > same.y);
}

TEST_CASE("probes: no light leaks through a closed wall, from whichever side a probe looks", "[probes]") {
    // Two rooms that share a wall of no thickness, its two sides separate quads: nothing that a receiver in one sees is seen
    // by a probe in the other.
    Mesh mesh = room(1);
    Mesh other = room(1);
    for (Vertex& v : other.vertices) v.position.x += 2;
    const auto first = std::uint32_t(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
    for (const glm::uvec3& t : other.triangles) mesh.triangles.push_back(t + first);
    const World world(mesh);
    const Buffer<glm::vec4> probes = {{0.9f, 0, 0, 0}, {1.1f, 0, 0, 0}};
    const Receivers receivers = receivers_at({{{1, 0.1f, 0.1f}, {-1, 0, 0}}, {{1, 0.1f, 0.1f}, {1, 0, 0}}, {{0, -1, 0}, {0, 1, 0}}});
    RayCounts counts;
    const TransportParams params;
    const Buffer<float> alpha = coefficients(world, receivers, supported_by({1, 1}, 3), probes, params, &counts);
    const double full = std::sqrt(host::pi) / 2;  // pi Y_0
    const int own[3] = {0, 1, 0};
    for (int i = 0; i < 3; ++i) {
        CHECK(alpha[std::size_t(i * 2 + own[i]) * 64] == Approx(full).epsilon(1e-5));
        for (int j = 0; j < 64; ++j) CHECK(alpha[std::size_t(i * 2 + 1 - own[i]) * 64 + std::size_t(j)] == 0);
    }
    CHECK(counts.unseen == 0);
}

TEST_CASE("probes: the back of a surface is black, and is counted", "[probes]") {
    Mesh roof;  // its front is up: from below its back is seen
    add_quad(roof, {-50, 1, -50}, {-50, 1, 50}, {50, 1, 50}, {50, 1, -50});
    const World world(roof);
    const Buffer<glm::vec4> probes = {{0, 0.5f, 0, 0}};
    const Receivers receivers = receivers_at({{{0, 0, 0}, {0, 1, 0}}});
    RayCounts counts;
    TransportParams params;
    for (const float a : coefficients(world, receivers, supported_by({1}, 1), probes, params, &counts)) CHECK(a == 0);
    CHECK(counts.back > 500);
    CHECK(counts.back + counts.escaped == 512);
}

namespace {

// Random inputs of both stages, with every kind of ray among them.
struct Random {
    int receivers = 37, rays = 131, slots = 10;  // a whole part of the sum, and three more
    Buffer<glm::vec4> supporting, seen;
    std::vector<std::int32_t> visible;
    Buffer<float> lengths, factors, shares;

    Random() {
        std::int32_t draw = 0;
        const auto random = [&] { return float(unit_float<double>(pixel_hash<std::int32_t>(draw++, 1, 2, 3).x)); };
        for (int i = 0; i < slots * receivers; ++i)
            supporting.push_back({4 * random() - 2, 4 * random() - 2, 4 * random() - 2, i % 7 == 3 ? 0 : random()});
        for (int i = 0; i < rays * receivers; ++i) {
            const glm::vec3 d(random() - 0.5f, random() - 0.5f, random() - 0.5f);
            seen.push_back(i % 5 == 0 ? glm::vec4(glm::normalize(d), 0) : glm::vec4(9.0f * d, 1));
            visible.push_back(i % 11 == 0 ? 0 : std::int32_t(1024 * random()));
            lengths.push_back(i % 5 == 0 ? escaped_length : 3 * random());
        }
        for (int k = 0; k < rays; ++k) factors.push_back(random());
        ShareInputs in{receivers, rays, slots, false, supporting.data(), factors.data(), visible.data(), lengths.data()};
        shares.resize(seen.size());
        run(stage<ShareKernel>(), data_of(in), {}, shares.data());
    }
    double share(int k, int i) const {
        double sum = 0;
        const std::size_t at = std::size_t(k * receivers + i);
        for (int s = 0; s < slots; ++s)
            if (visible[at] >> s & 1) sum += double(supporting[std::size_t(s * receivers + i)].w);
        return sum > 0 ? double(factors[std::size_t(k)]) / sum : 0;
    }
};

}  // namespace

TEST_CASE("probes: shares against the sum as it is written, and W(x) of the published variant", "[probes][IPR 5.1.3.2]") {
    const Random r;
    for (int k = 0; k < r.rays; ++k)
        for (int i = 0; i < r.receivers; ++i)
            CHECK(r.shares[std::size_t(k * r.receivers + i)] == Approx(r.share(k, i)).epsilon(2e-6).margin(1e-9));
    ShareInputs in{r.receivers, r.rays, r.slots, true, r.supporting.data(), r.factors.data(), r.visible.data(),
                   r.lengths.data()};
    Buffer<float> published(r.shares.size());
    run(stage<ShareKernel>(), data_of(in), {}, published.data());
    for (std::size_t i = 0; i < published.size(); ++i) {
        const double x = r.lengths[i], w = 1 - 1 / (2 * host::pi * x * x + 1);
        CHECK(published[i] == Approx(w * double(r.shares[i])).epsilon(1e-6).margin(1e-30));
    }
    // Of short rays W(x) is 2 pi x^2: as it is printed a float has no digit of it below 0.1 mm.
    Random near = r;
    for (std::size_t i = 0; i < near.lengths.size(); ++i) near.lengths[i] = 1e-7f * float(1 + i % 1000);
    in.lengths = near.lengths.data();
    run(stage<ShareKernel>(), data_of(in), {}, published.data());
    for (std::size_t i = 0; i < published.size(); ++i) {
        const double t = 2 * host::pi * double(near.lengths[i]) * double(near.lengths[i]);
        CHECK(published[i] == Approx(t / (1 + t) * double(r.shares[i])).epsilon(1e-6).margin(1e-30));
    }
}

TEST_CASE("probes: weights, factors, lengths and coordinates that no bake has are refused by name", "[probes][malformed]") {
    const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
    const auto refused = [](const StageBinding& binding, const StageData& data) {
        try {
            (void)binding.bind(data);
        } catch (const InputError& e) {
            return std::string(e.what());
        }
        return std::string();
    };
    const auto of_share = [&](auto change) {
        Random r;
        change(r);
        return refused(stage<ShareKernel>(), data_of(ShareInputs{r.receivers, r.rays, r.slots, false, r.supporting.data(),
                                                                 r.factors.data(), r.visible.data(), r.lengths.data()}));
    };
    const std::vector<std::int32_t> rows = coefficient_rows(10, 7);
    const auto of_coefficients = [&](auto change) {
        Random r;
        change(r);
        return refused(stage<CoefficientsKernel>(),
                       data_of(CoefficientsInputs{r.receivers, r.rays, r.slots, 7, rows.data(), r.supporting.data(), r.seen.data(),
                                                  r.visible.data(), r.shares.data()}));
    };
    CHECK(of_share([](Random&) {}) == "");
    CHECK(of_coefficients([](Random&) {}) == "");
    for (const float w : {nan, infinity, -0.5f, 1e-40f, 1.01f}) {
        CAPTURE(w);
        CHECK_THAT(of_share([&](Random& r) { r.supporting[2].w = w; }),
                   Catch::Contains("probes.share: supporting: number 11 is ") && Catch::Contains("2^-64"));
    }
    CHECK(of_share([](Random& r) { r.supporting[2].w = 0x1p-48f; }) == "");
    CHECK(of_share([&](Random& r) { r.supporting[2].x = nan; }) == "");  // is not read
    for (const float f : {nan, -0.1f, 13.0f}) CHECK_THAT(of_share([&](Random& r) { r.factors[3] = f; }), Catch::Contains("factors: number 3 "));
    for (const float x : {nan, -1.0f, 2e16f, infinity}) CHECK_THAT(of_share([&](Random& r) { r.lengths[5] = x; }), Catch::Contains("lengths: number 5 "));
    for (const float x : {nan, infinity, 2e18f, -2e18f}) {
        CAPTURE(x);
        CHECK_THAT(of_coefficients([&](Random& r) { r.seen[2].y = x; }), Catch::Contains("probes.coefficients: seen: number 9 is "));
        CHECK_THAT(of_coefficients([&](Random& r) { r.supporting[2].x = x; }), Catch::Contains("supporting: number 8 "));
    }
    CHECK_THAT(of_coefficients([&](Random& r) { r.shares[7] = infinity; }), Catch::Contains("shares: number 7 "));
}

TEST_CASE("probes: coefficients against the sum as it is written, one at a time and all at once", "[probes][IPR 9]") {
    const Random r;
    for (const int degree : {0, 1, 4, 7}) {
        const std::vector<std::int32_t> rows = coefficient_rows(r.slots, degree);
        CoefficientsInputs in{r.receivers, r.rays, r.slots, degree, rows.data(), r.supporting.data(), r.seen.data(),
                              r.visible.data(), r.shares.data()};
        const StageData data = data_of(in);
        Buffer<float> alpha(std::size_t(data.size.x) * std::size_t(data.size.y));
        run(stage<CoefficientsKernel>(), data, {}, alpha.data());
        const int count = sh::count(degree);
        double worst = 0;
        for (int i = 0; i < r.receivers; ++i)
            for (int s = 0; s < r.slots; ++s) {
                const glm::dvec4 probe(r.supporting[std::size_t(s * r.receivers + i)]);
                std::vector<double> sums(std::size_t(count), 0.0);
                for (int k = 0; k < r.rays; ++k) {
                    const std::size_t at = std::size_t(k * r.receivers + i);
                    if (!(r.visible[at] >> s & 1)) continue;
                    const glm::dvec4 seen(r.seen[at]);
                    const glm::dvec3 psi = glm::normalize(glm::dvec3(seen) - seen.w * glm::dvec3(probe));
                    const sh::Values y = sh::basis(psi, degree);
                    for (int j = 0; j < count; ++j) sums[std::size_t(j)] += r.share(k, i) * probe.w * y[std::size_t(j)];
                }
                for (int j = 0; j < count; ++j)
                    worst = std::max(worst, std::fabs(double(alpha[std::size_t((s * count + j) * r.receivers + i)]) -
                                                      sums[std::size_t(j)]));
            }
        CHECK(worst < 2e-6 * (degree + 1));
        // explain() walks one item: the same bits.
        for (const glm::ivec2 item : {glm::ivec2(0, 0), glm::ivec2(36, data.size.y - 1), glm::ivec2(17, data.size.y / 2)}) {
            const std::vector<TapValue> taps = explain(stage<CoefficientsKernel>(), data, item);
            REQUIRE(taps.back().name == "alpha");
            CHECK(taps.back().value[0] == double(alpha[std::size_t(item.y * r.receivers + item.x)]));
        }
    }
}

TEST_CASE("probes: rows in another order are computed one by one, to the same bits", "[probes]") {
    const Random r;
    const std::vector<std::int32_t> rows = coefficient_rows(r.slots, 7);
    CoefficientsInputs in{r.receivers, r.rays, r.slots, 7, rows.data(), r.supporting.data(), r.seen.data(), r.visible.data(),
                          r.shares.data()};
    Buffer<float> alpha(640 * std::size_t(r.receivers)), turned(alpha.size());
    run(stage<CoefficientsKernel>(), data_of(in), {}, alpha.data());
    std::vector<std::int32_t> reversed;
    for (int row = 639; row >= 0; --row)
        for (int c = 0; c < 4; ++c) reversed.push_back(rows[std::size_t(row * 4 + c)]);
    in.rows = reversed.data();
    run(stage<CoefficientsKernel>(), data_of(in), {}, turned.data());
    bool equal = true;
    for (int row = 0; row < 640; ++row)
        for (int i = 0; i < r.receivers; ++i)
            equal = equal && alpha[std::size_t(row * r.receivers + i)] == turned[std::size_t((639 - row) * r.receivers + i)];
    CHECK(equal);
}

TEST_CASE("probes: the same bits for every instruction set and number of threads", "[probes][bits]") {
    const World world(room(2));
    const Receivers receivers = receivers_at(std::vector<std::pair<glm::vec3, glm::vec3>>(
        23, {{0.3f, -2, 0.1f}, {0, 1, 0}}));
    const Buffer<glm::vec4> probes = {{0, 0, 0, 0}, {1.5f, -1, 0.2f, 0}};
    TransportParams params;
    params.rays = 64;
    RunOptions one;
    one.threads = 1, one.isa = Isa::scalar;
    const Buffer<float> truth = coefficients(world, receivers, supported_by({1, 0.5f}, 23), probes, params, nullptr, one);
    for (const Isa isa : supported_isas()) {
        RunOptions options;
        options.isa = isa, options.threads = 3;
        CHECK(coefficients(world, receivers, supported_by({1, 0.5f}, 23), probes, params, nullptr, options) == truth);
    }
}
