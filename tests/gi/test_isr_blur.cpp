// The blur of ISR's coarse result against closed forms.
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/gi/isr_filter_scenes.h"

using namespace plumb;
using namespace plumb::isr;

TEST_CASE("isr.blur: a constant stays what it is, and no surface is nothing and open", "[isr][ISR 4.2][analytic]") {
    const glm::vec4 value(0.3f, 7.7f, 1e-3f, 0.6f);
    for (glm::ivec2 size : sizes)
        for (Blur kind : blurs)
            for (Direction direction : directions)
                for (int radius : {1, 4, 32}) {
                    CAPTURE(size.x, size.y, int(kind), int(direction), radius);
                    const Image4 surface = rough(size), lit(size.x, size.y, value);
                    const Image4 got = blurred(with(kind, Variant::corrected, radius, 3), lit, surface, direction);
                    const Image4 all = blurred(with(kind, Variant::published, radius, 3), lit, surface, direction);
                    // n products and sums above and below, and a quotient, round once each.
                    const double allowed = 2 * (2 * radius + 2) * 0x1p-24;
                    for (int y = 0; y < size.y; ++y)
                        for (int x = 0; x < size.x; ++x)
                            for (int c = 0; c < 4; ++c) {
                                if (covered(surface, x, y))
                                    CHECK(off(got(x, y)[c], value[c]) <= allowed);
                                else
                                    CHECK(got(x, y)[c] == nothing[c]);
                                // As printed, what has no surface is blurred as well.
                                if (kind == Blur::gaussian) CHECK(off(all(x, y)[c], value[c]) <= allowed);
                            }
                }
}

TEST_CASE("isr.blur: one bright pixel spreads by the Gaussian, and nothing is lost", "[isr][ISR 4.2][analytic]") {
    const glm::ivec2 size(41, 41);
    for (Blur kind : {Blur::gaussian, Blur::edge_aware})
        for (Variant variant : {Variant::corrected, Variant::published})
            for (int radius : {1, 4, 10}) {  // 10: no window that sees it reaches the border
                CAPTURE(int(kind), int(variant), radius);
                const IsrParams params = with(kind, variant, radius, 2.5f);
                Image4 lit(size.x, size.y, glm::vec4(0));
                lit(20, 20) = {1, 2, 4, 0.5f};
                const Image4 across = blurred(params, lit, wall(size), Direction::horizontal);
                const Image4 got = blurred(params, across, wall(size), Direction::vertical);
                glm::dvec4 sum(0);
                for (int y = 0; y < size.y; ++y)
                    for (int x = 0; x < size.x; ++x) {
                        const double g = gaussian(x - 20, radius, 2.5) * gaussian(y - 20, radius, 2.5);
                        for (int c = 0; c < 4; ++c)
                            CHECK(got(x, y)[c] == Approx(g * lit(20, 20)[c]).epsilon(1e-6).margin(1e-30));
                        const double along = y == 20 ? gaussian(x - 20, radius, 2.5) : 0;
                        CHECK(across(x, y).x == Approx(along).margin(1e-30).epsilon(1e-6));
                        sum += glm::dvec4(got(x, y));
                    }
                for (int c = 0; c < 4; ++c) CHECK(sum[c] == Approx(lit(20, 20)[c]).epsilon(1e-6));
            }
}

TEST_CASE("isr.blur: beyond the border there is nothing; as printed, the border's pixel", "[isr][ISR 4.2][analytic]") {
    const glm::ivec2 size(9, 9);
    Image4 lit(9, 9, glm::vec4(0));
    for (int i = 0; i < 9; ++i) lit(0, i) = lit(i, 0) = {1, 1, 1, 1};
    double inside = 0, before = 0;
    for (int d = 0; d <= 4; ++d) inside += gaussian(d, 4, 2), before += gaussian(-d, 4, 2);
    for (Direction direction : directions) {
        // At 0, one of the pixels from 0 to 4 is bright; at 2, that at distance 2.
        auto at = [&](const Image4& image, int i) {
            return direction == Direction::horizontal ? image(i, 5).x : image(5, i).x;
        };
        const Image4 got = blurred(with(Blur::gaussian), lit, wall(size), direction);
        CHECK(at(got, 0) == Approx(gaussian(0, 4, 2) / inside).epsilon(1e-6));
        CHECK(at(got, 2) == Approx(gaussian(2, 4, 2) / (inside + gaussian(1, 4, 2) + gaussian(2, 4, 2))).epsilon(1e-6));
        const Image4 printed = blurred(with(Blur::gaussian, Variant::published), lit, wall(size), direction);
        CHECK(at(printed, 0) == Approx(before).epsilon(1e-6));
        CHECK(at(printed, 2) == Approx(before - gaussian(0, 4, 2) - gaussian(1, 4, 2)).epsilon(1e-6));
    }
}

TEST_CASE("isr.blur: what has no surface neither gives nor takes", "[isr][ISR 4.2][analytic]") {
    const glm::ivec2 size(20, 20);
    Image4 surface = wall(size), lit(size.x, size.y, {1, 1, 1, 0.25f});
    for (int y = 0; y < size.y; ++y)
        for (int x = 10; x < size.x; ++x) surface(x, y) = glm::vec4(0), lit(x, y) = {1e6f, 1e6f, 1e6f, 1};
    for (Blur kind : {Blur::gaussian, Blur::edge_aware}) {
        const Image4 got = blurred(with(kind), lit, surface, Direction::horizontal);
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) {
                if (x >= 10) CHECK(got(x, y) == nothing);
                if (x < 10) CHECK(off(got(x, y).x, 1) <= 20 * 0x1p-24);
                if (x < 10) CHECK(off(got(x, y).w, 0.25) <= 20 * 0x1p-24);
            }
    }
    // As printed it does: at 9 all but its own half is background's.
    const double beside = (1 - gaussian(0, 4, 2)) / 2;
    const Image4 printed = blurred(with(Blur::gaussian, Variant::published), lit, surface, Direction::horizontal);
    CHECK(printed(9, 5).x == Approx(1 - beside + 1e6 * beside).epsilon(1e-6));
    CHECK(printed(9, 5).w == Approx(0.25 * (1 - beside) + beside).epsilon(1e-6));
}

TEST_CASE("isr.blur: edge_aware stops at edges of depth and of normal, gaussian does not", "[isr][analytic]") {
    const glm::ivec2 size(16, 3);
    for (bool turned : {false, true}) {
        Image4 surface = wall(size), lit(size.x, size.y, {1, 1, 1, 1});
        for (int y = 0; y < size.y; ++y)
            for (int x = 8; x < size.x; ++x) {
                surface(x, y) = turned ? glm::vec4(1, 0, 0, 2) : glm::vec4(0, 0, 1, 2.2f);  // 10 % further away
                lit(x, y) = {100, 100, 100, 0};
            }
        const Image4 got = blurred(with(Blur::edge_aware), lit, surface, Direction::horizontal);
        for (int x = 0; x < size.x; ++x) CHECK(off(got(x, 1).x, x < 8 ? 1 : 100) <= 20 * 0x1p-24);
        const double beside = (1 - gaussian(0, 4, 2)) / 2;
        CHECK(blurred(with(Blur::gaussian), lit, surface, Direction::horizontal)(7, 1).x ==
              Approx(1 - beside + 100 * beside).epsilon(1e-6));
    }
    // Between: z = 2 and 2.02 are q = 1/2 apart, the normals 60 degrees: (1 - 1/4) / 2 of the Gaussian's weight.
    Image4 surface(2, 1), lit(2, 1);
    surface(0, 0) = {0, 0, 1, 2}, surface(1, 0) = {0, float(std::sqrt(0.75)), 0.5f, 2.02f};
    lit(0, 0) = {1, 1, 1, 1}, lit(1, 0) = {3, 3, 3, 0};
    const double w0 = gaussian(0, 4, 2), w1 = gaussian(1, 4, 2) * (1 - 0.25) * 0.5;
    CHECK(blurred(with(Blur::edge_aware), lit, surface, Direction::horizontal)(0, 0).x ==
          Approx((w0 + 3 * w1) / (w0 + w1)).epsilon(6e-6));  // 2.02 in float: q is off by 6e-6
}

TEST_CASE("isr.blur: a slanted plane is no edge, and one beside it is", "[isr][analytic]") {
    const glm::ivec2 size(48, 48);
    const CoarseCamera camera = eye(size);
    const glm::dvec3 normals[] = {{0, 1, 0}, {0.8, 0, 0.6}, {0, -0.995, std::sqrt(1 - 0.995 * 0.995)}};
    // The depth at which (x, y) sees the plane n . X = -h; 0 where it does not, or at a cosine of less than a hundredth.
    auto seen = [&](const glm::dvec3& n, double h, int x, int y) {
        const glm::dvec3 ray = camera.f_o + double(x) * camera.f_u + double(y) * camera.f_v;
        const double facing = -dot(n, ray);
        return facing > 0.01 * length(ray) ? h / facing : 0;
    };
    for (const glm::dvec3& n : normals)
        for (Direction direction : directions) {
            CAPTURE(n.x, n.y, n.z, int(direction));
            Image4 plane(size.x, size.y), lit(size.x, size.y, nothing), step = plane;
            int pixels = 0;
            double most_slope = 0;
            for (int y = 0; y < size.y; ++y)
                for (int x = 0; x < size.x; ++x) {
                    const double z = seen(n, 2, x, y);
                    if (z == 0) continue;
                    ++pixels;
                    plane(x, y) = glm::vec4(glm::vec3(n), float(z));
                    lit(x, y) = {noise(x, y, 1), 3 * noise(x, y, 2), noise(x, y, 3), noise(x, y, 8)};
                    const double beside = seen(n, 2, x, y + 1);
                    if (beside > 0) most_slope = std::max(most_slope, std::abs(beside / z - 1));
                    // From x = 24 on as much below the plane as four hundredths of the depth, bright.
                    step(x, y) = glm::vec4(glm::vec3(n), float(x < 24 ? z : z * (1 + 0.04 * z / 2)));
                }
            CHECK(pixels > 500);
            if (n.x == 0) CHECK(most_slope > 0.04);  // the depth of a row is two edges away from that of the row before
            // What stops at edges sees none: it is the Gaussian. Positions of the plane are rounded: q is off by 2^-23 / 0.02.
            const Image4 edges = blurred(with(Blur::edge_aware), lit, plane, direction);
            const Image4 smooth = blurred(with(Blur::gaussian), lit, plane, direction);
            for (int y = 0; y < size.y; ++y)
                for (int x = 0; x < size.x; ++x)
                    for (int c = 0; c < 4; ++c) CHECK(edges(x, y)[c] == Approx(smooth(x, y)[c]).epsilon(2e-6));
            if (direction == Direction::vertical) continue;
            Image4 halves(size.x, size.y, nothing);
            for (int y = 0; y < size.y; ++y)
                for (int x = 0; x < size.x; ++x)
                    if (step(x, y).w > 0) halves(x, y) = glm::vec4(x < 24 ? 1 : 100);
            const Image4 kept = blurred(with(Blur::edge_aware), halves, step, direction);
            for (int y = 0; y < size.y; ++y)
                for (int x = 0; x < 24; ++x)
                    if (step(x, y).w > 0) CHECK(off(kept(x, y).x, 1) <= 20 * 0x1p-24);
        }
}
