// What relight rays bring, in closed form: lookups of the lightmap's levels, the three kinds of feedback, what is refused.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/probes/radiance.h"

namespace {

using namespace plumb;
using namespace plumb::probes;

constexpr float not_a_number = std::numeric_limits<float>::quiet_NaN();

// Texels a side of a level, and the first of its rows, by the definition: ceil(T / 2^k), two rows apart.
int side_of(int side, int level) { return (side + (1 << level) - 1) >> level; }
int first_of(int side, int level) {
    int first = 0;
    for (int k = 0; k < level; ++k) first += side_of(side, k) + 2;
    return first;
}

// A strip whose texels show value(x 2^k, y 2^k, k); what belongs to no level is no number.
template <class Value>
Image4 strip(int side, int levels, Value value) {
    Image4 image(side, first_of(side, levels - 1) + side_of(side, levels - 1), glm::vec4(not_a_number));
    for (int k = 0; k < levels; ++k)
        for (int y = 0; y < side_of(side, k); ++y)
            for (int x = 0; x < side_of(side, k); ++x)
                image(x, first_of(side, k) + y) = glm::vec4(value(x << k, y << k, k), 1);
    return image;
}

glm::vec3 looked_up(const Image4& image, int levels, glm::vec2 uv, int level) {
    NoTap tap;
    return lightmap_at<float>({&image.texels[0].x, image.width, levels}, uv, level, tap);
}

// Rays that end on one lightmap, all alike but for what a test changes.
struct Rays {
    int probes, rays;
    Buffer<glm::vec4> surface, emitted, direct, place;
    Image4 lightmap{1, 1, glm::vec4(0, 0, 0, 1)};
    RadianceInputs in;

    Rays(int p, int r) : probes(p), rays(r) {
        const std::size_t n = std::size_t(p) * std::size_t(r);
        surface.assign(n, {0.5f, 0.25f, 0.75f, 1}), emitted.assign(n, glm::vec4(0)), direct.assign(n, glm::vec4(0));
        place.assign(n, {0.5f, 0.5f, 0, 0});
    }
    Buffer<glm::vec4> brought(const RunOptions& options = {}) {
        in.probes = probes, in.rays = rays, in.side = lightmap.width;
        in.surface = &surface, in.emitted = &emitted, in.direct = &direct, in.place = &place, in.lightmap = &lightmap;
        Buffer<glm::vec4> f;
        run(in, options, f);
        return f;
    }
};

bool same(const glm::vec3& a, const glm::vec3& b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

}  // namespace

TEST_CASE("lightmap: levels lie below each other, two empty rows apart", "[probes][lightmap][analytic]") {
    // 13 -> 7 -> 4 -> 2 texels a side: 13 + 2 + 7 + 2 + 4 + 2 + 2 rows.
    CHECK(lightmap_rows(13, 1) == 13);
    CHECK(lightmap_rows(13, 4) == 32);
    for (const int side : {1, 2, 13, 16, 309, 4095})
        for (int levels = 1; levels <= most_levels; ++levels) {
            CHECK(lightmap_rows(side, levels) == first_of(side, levels - 1) + side_of(side, levels - 1));
            for (int k = 0; k < levels; ++k) {
                const LightmapLevel<float> level = lightmap_level<float>(side, levels, k);
                CAPTURE(side, levels, k);
                CHECK((level.first == first_of(side, k) && level.side == side_of(side, k) && level.scale == std::ldexp(1.0f, -k)));
            }
        }
}

TEST_CASE("lightmap: a lookup at a texel's centre returns the texel, of every level", "[probes][lightmap][analytic]") {
    // (x + 1/2) / 16 is exact, and so are differences of whole numbers.
    const Image4 image = strip(16, 4, [](int x, int y, int k) { return glm::vec3(x, y, 100 * k + 7); });
    for (int k = 0; k < 4; ++k)
        for (int y = 0; y < side_of(16, k); ++y)
            for (int x = 0; x < side_of(16, k); ++x) {
                const glm::vec2 centre = (glm::vec2(x << k, y << k) + 0.5f) / 16.0f;
                CHECK(same(looked_up(image, 4, centre, k), glm::vec3(x << k, y << k, 100 * k + 7)));
            }
}

TEST_CASE("lightmap: between two texels it is their mean, between four the mean of these", "[probes][lightmap][analytic]") {
    const Image4 image = strip(8, 2, [](int x, int y, int k) { return glm::vec3(x * x, y * y * y, x * y + k); });
    for (int k = 0; k < 2; ++k) {
        const int side = side_of(8, k), first = first_of(8, k);
        for (int y = 0; y + 1 < side; ++y)
            for (int x = 0; x + 1 < side; ++x) {
                const auto at = [&](float dx, float dy) {
                    return looked_up(image, 2, (glm::vec2(float(x << k), float(y << k)) + 0.5f + glm::vec2(dx, dy) * float(1 << k)) / 8.0f, k);
                };
                const glm::vec3 a(image(x, first + y)), b(image(x + 1, first + y)), c(image(x, first + y + 1)), d(image(x + 1, first + y + 1));
                CHECK(same(at(0.5f, 0), (a + b) * 0.5f));
                CHECK(same(at(0, 0.5f), (a + c) * 0.5f));
                CHECK(same(at(0.5f, 0.5f), ((a + b) * 0.5f + (c + d) * 0.5f) * 0.5f));
                CHECK(same(at(0.25f, 0), a + 0.25f * (b - a)));
            }
    }
}

TEST_CASE("lightmap: what is linear over the atlas is itself at every level: no level is shifted", "[probes][lightmap][analytic]") {
    for (const int side : {13, 16, 309}) {
        const Image4 image = strip(side, 4, [](int x, int y, int) { return glm::vec3(3 * x + 1, 5 * y - 2, 2 * x - y); });
        for (int k = 0; k < 4; ++k) {
            const float most = float((side_of(side, k) - 1) << k);
            for (int i = 0; i <= 20; ++i) {
                const glm::vec2 t(most * float(i) / 20, most * float(7 * i % 21) / 20), uv = (t + 0.5f) / float(side);
                const glm::vec3 got = looked_up(image, 4, uv, k);
                CAPTURE(side, k, i);
                // uv in 24 bits: a texel's place to side 2^-23, times a slope of 5.
                const float slack = 1e-6f * float(side) * 5;
                CHECK(std::fabs(got.x - (3 * t.x + 1)) <= slack);
                CHECK(std::fabs(got.y - (5 * t.y - 2)) <= slack);
                CHECK(std::fabs(got.z - (2 * t.x - t.y)) <= slack);
            }
        }
    }
}

TEST_CASE("lightmap: beyond the edge lies the edge; rows between levels are never read", "[probes][lightmap][analytic]") {
    for (const int side : {1, 2, 5, 13, 16}) {
        const Image4 image = strip(side, 4, [](int x, int y, int k) { return glm::vec3(x, y, k); });
        for (int k = 0; k < 4; ++k) {
            const float last = float((side_of(side, k) - 1) << k);
            CHECK(same(looked_up(image, 4, {0, 0}, k), glm::vec3(0, 0, k)));
            CHECK(same(looked_up(image, 4, {-3, -1e30f}, k), glm::vec3(0, 0, k)));
            CHECK(same(looked_up(image, 4, {7, 1e30f}, k), glm::vec3(last, last, k)));
            for (int i = 0; i <= 40; ++i)
                for (int j = 0; j <= 40; ++j) {
                    const glm::vec3 got = looked_up(image, 4, glm::vec2(float(i), float(j)) / 40.0f, k);
                    REQUIRE((got.x >= 0 && got.x <= last && got.y >= 0 && got.y <= last && got.z == float(k)));
                }
        }
        // Of a level that there is not, the nearest.
        CHECK(same(looked_up(image, 4, {0, 0}, 9), glm::vec3(0, 0, 3)));
        CHECK(same(looked_up(image, 4, {0, 0}, -9), glm::vec3(0)));
    }
}

TEST_CASE("probes.radiance: feedback corrected and as published", "[probes][radiance][analytic]") {
    Rays r(1, 1);
    r.emitted[0] = {1, 2, 3, 0}, r.direct[0] = glm::vec4(glm::vec3(float(host::pi)), 0);
    r.lightmap(0, 0) = glm::vec4(glm::vec3(2 * float(host::pi)), 1);
    const glm::dvec3 rho(0.5, 0.25, 0.75), emitted(1, 2, 3);
    const auto is = [&](Feedback feedback, const glm::dvec3& expected) {
        r.in.feedback = feedback;
        const glm::vec4 f = r.brought()[0];
        for (int c = 0; c < 3; ++c) CHECK(f[c] == Approx(expected[c]).epsilon(1e-6));
        CHECK(f.w == 0);
    };
    // rho / pi (pi + 2 pi) = 3 rho.
    is(Feedback::corrected, emitted + 3.0 * rho);
    // Direct light goes by rho / pi, the lightmap by the constant, 0.19 of the thesis; or by rho.
    is(Feedback::constant, emitted + rho + 0.19 * 2 * host::pi);
    is(Feedback::material, emitted + rho + 2 * host::pi * rho);
    r.in.constant = 0.06f;
    is(Feedback::constant, emitted + rho + 0.06 * 2 * host::pi);
}

TEST_CASE("probes.radiance: between surfaces that send f all around, corrected feedback is 1 / (1 - rho), the published ones are not",
          "[probes][radiance][analytic]") {
    // Each sees irradiance pi f. f = e + share pi f has the solution e / (1 - pi share), where pi share < 1.
    const auto after = [](Feedback feedback, int rounds) {
        Rays r(1, 1);
        r.surface[0] = {0.5f, 0.5f, 0.5f, 1}, r.emitted[0] = {1, 1, 1, 0}, r.in.feedback = feedback;
        float f = 0;
        for (int round = 0; round < rounds; ++round) {
            r.lightmap(0, 0) = glm::vec4(glm::vec3(float(host::pi) * f), 1);
            f = r.brought()[0].x;
        }
        return f;
    };
    CHECK(after(Feedback::corrected, 60) == Approx(2).epsilon(1e-6));
    CHECK(after(Feedback::constant, 60) == Approx(1 / (1 - 0.19 * host::pi)).epsilon(1e-6));
    // rho pi = 1.57: it grows without end, by that factor a round.
    CHECK(after(Feedback::material, 31) / after(Feedback::material, 30) == Approx(0.5 * host::pi).epsilon(1e-5));
}

TEST_CASE("probes.radiance: where nothing reflects only emission counts, whatever the rest holds", "[probes][radiance][analytic]") {
    Rays r(3, 37);
    r.lightmap(0, 0) = glm::vec4(not_a_number);
    for (std::size_t i = 0; i < r.surface.size(); ++i) {
        r.surface[i] = {not_a_number, 1, 2, 0}, r.direct[i] = {5, not_a_number, 7, 1};
        r.emitted[i] = {0.1f * float(i), 1e30f, -0.0f, 9};
        r.place[i] = {not_a_number, 3, 0, 0};
    }
    const Buffer<glm::vec4> f = r.brought();
    for (std::size_t i = 0; i < f.size(); ++i) CHECK((same(glm::vec3(f[i]), glm::vec3(r.emitted[i])) && f[i].w == 0));
}

TEST_CASE("probes.radiance: a surface of no reflectance, and a black lightmap", "[probes][radiance][analytic]") {
    Rays r(2, 5);
    r.surface.assign(10, {0, 0, 0, 1}), r.direct.assign(10, glm::vec4(3)), r.emitted.assign(10, glm::vec4(0.25f));
    r.lightmap(0, 0) = glm::vec4(8, 8, 8, 1);
    for (const glm::vec4& f : r.brought()) CHECK(same(glm::vec3(f), glm::vec3(0.25f)));
    r.surface.assign(10, {1, 1, 1, 1}), r.lightmap(0, 0) = glm::vec4(0);
    for (const glm::vec4& f : r.brought()) CHECK(f.x == Approx(0.25 + 3 / host::pi).epsilon(1e-6));
}

TEST_CASE("probes.radiance: each ray looks up its own place and level", "[probes][radiance][analytic]") {
    // rho = pi: f is the irradiance, to rounding.
    Rays r(3, 29);
    r.lightmap = strip(16, 3, [](int x, int y, int k) { return glm::vec3(x, y, k); });
    r.in.levels = 3;
    for (int i = 0; i < 87; ++i) {
        const int k = i % 3, x = i % side_of(16, k), y = 5 * i % side_of(16, k);
        r.surface[std::size_t(i)] = {host::pi, host::pi, host::pi, 1};
        r.place[std::size_t(i)] = glm::vec4((glm::vec2(x << k, y << k) + 0.5f) / 16.0f, k, 0);
    }
    const Buffer<glm::vec4> f = r.brought();
    for (int i = 0; i < 87; ++i) {
        const int k = i % 3, x = i % side_of(16, k), y = 5 * i % side_of(16, k);
        CAPTURE(i);
        CHECK(f[std::size_t(i)].x == Approx(x << k).epsilon(1e-6));
        CHECK(f[std::size_t(i)].y == Approx(y << k).epsilon(1e-6));
        CHECK(f[std::size_t(i)].z == Approx(k).epsilon(1e-6));
    }
}

TEST_CASE("probes.radiance: what is no number shows or is refused, wherever it stands", "[probes][radiance]") {
    for (const int where : {0, 1, 2, 3, 4, 5})
        for (int c = 0; c < 3; ++c) {
            Rays r(2, 21);
            r.lightmap = strip(4, 1, [](int, int, int) { return glm::vec3(1); });
            Buffer<glm::vec4>* list[] = {&r.surface, &r.emitted, &r.direct};
            if (where < 3) (*list[where])[17][c] = not_a_number;
            if (where == 3) r.place[17].x = not_a_number;
            if (where == 4) r.place[17].y = not_a_number;
            if (where == 5)
                for (glm::vec4& t : r.lightmap.texels) t[c] = not_a_number;
            const Buffer<glm::vec4> f = r.brought();
            CAPTURE(where, c);
            CHECK(std::isnan(f[17][c]));
            if (where < 5) CHECK((std::isfinite(f[16].x) && std::isfinite(f[18].x)));
        }
    for (const float w : {not_a_number, 0.5f, -1.0f, 2.0f}) {
        Rays r(2, 21);
        r.surface[17].w = w;
        CHECK_THROWS_AS(r.brought(), InputError);
    }
    for (const float z : {not_a_number, 0.5f, -1.0f, 2.0f, 1e30f}) {
        Rays r(2, 21);
        r.in.levels = 2, r.lightmap = strip(4, 2, [](int, int, int) { return glm::vec3(1); });
        r.place[17].z = 1;
        CHECK_NOTHROW(r.brought());
        r.place[17].z = z;
        CHECK_THROWS_AS(r.brought(), InputError);
    }
}

TEST_CASE("probes.radiance: the same bits for every instruction set and thread count, and as one item", "[probes][radiance][bits]") {
    Rays r(19, 37);
    r.lightmap = strip(13, 3, [](int x, int y, int k) { return glm::vec3(0.1f * float(x), 0.3f * float(y), 0.7f * float(k + 1)); });
    r.in.levels = 3;
    for (std::size_t i = 0; i < r.place.size(); ++i) {
        const float t = float(i) * 0.6180339f;
        r.place[i] = {t - std::floor(t), 1.1f * (t * t - std::floor(t * t)), float(i % 3), 0};
        r.surface[i] = {0.3f, t - std::floor(t), 0.9f, i % 5 ? 1 : 0}, r.direct[i] = {1.7f, 0.1f, t, 0}, r.emitted[i] = {t, 0, 0.01f, 0};
    }
    const Buffer<glm::vec4> expected = r.brought();
    const StageData data = data_of(r.in);
    RadianceView v{uniforms_of<RadianceUniforms>(data), &r.surface[0].x, &r.emitted[0].x, &r.direct[0].x, &r.place[0].x,
                   &r.lightmap.texels[0].x, nullptr};
    NoTap tap;
    for (int p = 0; p < r.probes; ++p)
        for (int k = 0; k < r.rays; ++k) {
            const vec4<float> one = RadianceKernel::item<float>(v, k, p, tap);
            REQUIRE(same(glm::vec3(one), glm::vec3(expected[std::size_t(p * r.rays + k)])));
        }
    for (const Isa isa : supported_isas())
        for (const int threads : {1, 2, 3}) {
            RunOptions options;
            options.isa = isa, options.threads = threads;
            CHECK(r.brought(options) == expected);
        }
}

TEST_CASE("probes.radiance: refuses in one line what does not fit", "[probes][radiance]") {
    const auto refused = [](auto change) {
        Rays r(2, 3);
        CHECK_NOTHROW(r.brought());
        change(r);
        std::string message;
        try {
            r.brought();
        } catch (const InputError& e) {
            message = e.what();
        }
        CAPTURE(message);
        CHECK(message.starts_with("probes.radiance: "));
        CHECK(message.find('\n') == std::string::npos);
    };
    refused([](Rays& r) { r.surface.pop_back(); });
    refused([](Rays& r) { r.place.emplace_back(0); });
    refused([](Rays& r) { r.probes = 0; });
    refused([](Rays& r) { r.in.levels = 0; });
    refused([](Rays& r) { r.in.levels = 2; });  // the strip has one
    refused([](Rays& r) { r.in.levels = 5; });
    refused([](Rays& r) { r.in.constant = -0.1f; });
    refused([](Rays& r) { r.in.constant = not_a_number; });
    refused([](Rays& r) { r.in.feedback = Feedback(3); });
    refused([](Rays& r) { r.lightmap = Image4(2, 1); });
}
