// How ISR's coarse result reaches every pixel, against closed forms: upsampling and composition; and what these and the blur
// have in common.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "core/decision_tape.h"
#include "core/error.h"
#include "gi/compose/compose.h"
#include "gi/isr/isr.h"
#include "tests/gi/isr_filter_scenes.h"

using namespace plumb;
using namespace plumb::isr;

namespace {

constexpr double pi = 3.14159265358979323846;

}  // namespace

TEST_CASE("isr.upsample: (27) and (28) on numbers", "[isr][ISR (27)][ISR (28)][analytic]") {
    const float depths[] = {2, 2.2f, 3, 1.5f};
    const glm::vec4 values[] = {{1, 10, 0, 0.25f}, {2, 20, 0, 0.5f}, {3, 30, 1, 0.75f}, {4, 40, 0, 1}};
    for (int hole = -1; hole < 4; ++hole)
        for (Variant variant : {Variant::corrected, Variant::published})
            for (Upsample kind : {Upsample::bilateral, Upsample::bilinear})
                for (float epsilon : {1e-3f, 0.5f}) {
                    Image4 lit(2, 2), surface(2, 2);
                    for (int k = 0; k < 4; ++k) {
                        lit(k & 1, k >> 1) = k == hole ? nothing : values[k];
                        if (k != hole) surface(k & 1, k >> 1) = {0, 0, 1, depths[k]};
                    }
                    const Image4 got = upsampled(with(kind, variant, epsilon), lit, surface, wall({4, 4}));
                    for (int y : {1, 2})
                        for (int x : {1, 2}) {
                            CAPTURE(hole, int(variant), int(kind), epsilon, x, y);
                            double total = 0;
                            glm::dvec4 sum(0);
                            for (int k = 0; k < 4; ++k) {
                                // The coarse pixels' centres are at 1 and 3, the pixel's at x + 1/2.
                                const double u = (x + 0.5 - 1) / 2, v = (y + 0.5 - 1) / 2;
                                double w = (k & 1 ? u : 1 - u) * (k >> 1 ? v : 1 - v);
                                const double z = k == hole ? 0 : double(depths[k]);
                                const double scale = variant == Variant::published ? 10 : 2;
                                if (kind == Upsample::bilateral) w /= double(epsilon) + std::abs(2 - z) / scale;
                                if (k == hole && variant == Variant::corrected) w = 0;
                                total += w, sum += w * glm::dvec4(lit(k & 1, k >> 1));
                            }
                            for (int c = 0; c < 4; ++c)
                                CHECK(got(x, y)[c] == Approx(sum[c] / total).epsilon(2e-6).margin(1e-30));
                        }
                }
}

TEST_CASE("isr.upsample: a linear ramp comes back within the outermost centres", "[isr][ISR 4.5][analytic]") {
    for (glm::ivec2 size : sizes) {
        const glm::ivec2 coarse = coarse_size(size);
        Image4 lit(coarse.x, coarse.y);
        for (int y = 0; y < coarse.y; ++y)
            for (int x = 0; x < coarse.x; ++x) lit(x, y) = glm::vec4(glm::vec3(float(8 * x + 16 * y)), 0.5f);
        // Binary fractions: exact. Before the first centre and after the last the ramp is continued by its end.
        const Image4 got = upsampled(with(Upsample::bilinear), lit, wall(coarse), wall(size));
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) {
                CAPTURE(size.x, size.y, x, y);
                const float u = std::clamp((float(x) - 0.5f) / 2, 0.0f, float(coarse.x - 1));
                const float v = std::clamp((float(y) - 0.5f) / 2, 0.0f, float(coarse.y - 1));
                CHECK(got(x, y) == glm::vec4(glm::vec3(8 * u + 16 * v), 0.5f));
            }
    }
}

TEST_CASE("isr.upsample: a constant stays what it is; no surface is nothing and open", "[isr][ISR 4.5][analytic]") {
    const glm::vec4 value(0.3f, 7.7f, 1e-3f, 0.6f);
    for (glm::ivec2 size : sizes)
        for (Upsample kind : {Upsample::bilateral, Upsample::bilinear})
            for (Variant variant : {Variant::corrected, Variant::published}) {
                CAPTURE(size.x, size.y, int(kind), int(variant));
                const glm::ivec2 coarse = coarse_size(size);
                const Image4 surface = rough(coarse), full = rough(size), lit(coarse.x, coarse.y, value);
                const Image4 got = upsampled(with(kind, variant), lit, surface, full);
                for (int y = 0; y < size.y; ++y)
                    for (int x = 0; x < size.x; ++x) {
                        bool any = variant == Variant::published;  // as printed, background counts
                        for (int dy : {(y - 1) >> 1, (y + 1) >> 1})
                            for (int dx : {(x - 1) >> 1, (x + 1) >> 1})
                                any |= covered(surface, std::clamp(dx, 0, coarse.x - 1),
                                               std::clamp(dy, 0, coarse.y - 1));
                        // Four quotients and products, three sums above and below.
                        for (int c = 0; c < 4; ++c) {
                            if (any && covered(full, x, y))
                                CHECK(off(got(x, y)[c], value[c]) <= 12 * 0x1p-24);
                            else
                                CHECK(got(x, y)[c] == nothing[c]);
                        }
                    }
            }
}

TEST_CASE("isr.upsample: bilateral keeps the sides of a depth edge apart", "[isr][ISR (27)][analytic]") {
    // Two walls, at 2 and 4 m, meet between the full pixels 6 and 7, within a coarse pixel that is of the far wall.
    const glm::ivec2 size(16, 8), coarse(8, 4);
    Image4 full = wall(size), surface = wall(coarse), lit(8, 4, {1, 1, 1, 1});
    for (int y = 0; y < 8; ++y)
        for (int x = 6; x < 16; ++x) full(x, y).w = 4;
    for (int y = 0; y < 4; ++y)
        for (int x = 3; x < 8; ++x) surface(x, y).w = 4, lit(x, y) = {101, 101, 101, 0};
    for (float epsilon : {1e-4f, 1e-2f}) {
        const Image4 got = upsampled(with(Upsample::bilateral, Variant::corrected, epsilon), lit, surface, full);
        for (int y = 0; y < 8; ++y)
            for (int x = 0; x < 16; ++x) {
                // At most 3/4 of the shares lie beyond the edge, at least 1/4 on this side:
                // 3 epsilon / (epsilon + d), d the difference in depth, 1 of the near wall's and 1/2 of the far one's.
                const double d = x < 6 ? 1 : 0.5, bound = 100 * 3 * double(epsilon) / (double(epsilon) + d);
                CHECK(std::abs(got(x, y).x - (x < 6 ? 1 : 101)) <= bound + 101 * 12 * 0x1p-24);
                CHECK(std::abs(got(x, y).w - (x < 6 ? 1 : 0)) <= bound / 100 + 12 * 0x1p-24);
            }
    }
    const Image4 across = upsampled(with(Upsample::bilinear), lit, surface, full);
    CHECK(across(5, 3).x == 26);
    CHECK(across(6, 3).x == 76);
}

TEST_CASE("isr.upsample: where no weight is left, bilinear of what has a surface", "[isr][ISR 4.5][analytic]") {
    // A quotient of depths of 1e60 overflows: w^z is 0.
    Image4 lit(2, 2, {5, 5, 5, 0}), surface = wall({2, 2}, 1e30f), full = wall({4, 4}, 1e-30f);
    lit(1, 0) = {9, 9, 9, 1};
    CHECK(upsampled(with(Upsample::bilateral), lit, surface, full)(1, 1) ==
          glm::vec4(glm::vec3(5 + 4 * 0.25f * 0.75f), 0.25f * 0.75f));
    surface(0, 0) = glm::vec4(0);
    CHECK(upsampled(with(Upsample::bilateral), lit, surface, full)(1, 1).x ==
          Approx((9 * 0.1875 + 5 * 0.25) / 0.4375).epsilon(1e-6));
    CHECK(upsampled(with(Upsample::bilateral), lit, Image4(2, 2), full)(1, 1) == nothing);
    CHECK(upsampled(with(Upsample::bilinear), lit, Image4(2, 2), full)(1, 1) == nothing);
}

TEST_CASE("isr.upsample: clip depth is compared as linear depth", "[isr][ISR 4.7][analytic]") {
    const double near = 0.1;
    for (double far : {10.0, 1e4, double(INFINITY)})
        for (float z : {0.11f, 1.0f, 9.5f}) {
            CAPTURE(far, z);
            const double clip = (1 / near - 1 / double(z)) / (1 / near - 1 / far);
            const Image4 lit(1, 1, {1, 1, 1, 1}), surface(1, 1, glm::vec4(0, 0, 1, float(clip))), full = wall({1, 1});
            IsrParams params = with(Upsample::bilateral);
            params.position = Position::inverse_matrix;
            bool seen = false;
            for (const TapValue& v : explain(params, UpsampleInputs{&lit, &surface, &full, &full, near, far}, {0, 0}))
                if (v.name == "z_i") {
                    seen = true;
                    // 1 / z is the difference of numbers as large as 1 / near, of which four round.
                    CHECK(off(v.value[0], double(z)) <= 4 * 0x1p-24 * double(z) / near + 2 * 0x1p-24);
                }
            CHECK(seen);
        }
}

namespace {

struct Pixel {
    Image4 normal{1, 1, glm::vec4(0, 0, 1, 1)}, albedo{1, 1, {0.5f, 0.25f, 0.8f, 0}}, emission{1, 1, {1, 2, 3, 0}},
        direct{1, 1, {4, 5, 6, 0}}, indirect{1, 1, {2, 0.5f, 1, 0.3f}};
    glm::vec3 environment{0.1f, 0.2f, 0.3f};

    ComposeInputs inputs() const { return {&normal, &albedo, &emission, &direct, &indirect, environment}; }
    glm::vec4 of(const IsrParams& params) const {
        Image4 out;
        run(params, inputs(), {}, out);
        return out(0, 0);
    }
};

}  // namespace

TEST_CASE("isr.compose: (29) by hand, corrected and as printed", "[isr][ISR (29)][analytic]") {
    const Pixel p;
    for (float k_ssao : {0.0f, 0.5f, 1.0f})
        for (float k_isr : {0.0f, 0.5f, 1.0f})
            for (Ambient ambient : {Ambient::none, Ambient::environment}) {
                CAPTURE(k_ssao, k_isr, int(ambient));
                IsrParams params;
                params.k_ssao = k_ssao, params.k_isr = k_isr, params.ambient = ambient;
                IsrParams printed = params;
                printed.variant = Variant::published, printed.light_unit = 2.5f;
                const double open = double(p.indirect(0, 0).w);
                const double passes = std::clamp(open + 1 - double(k_ssao), 0.0, 1.0);
                for (int c = 0; c < 3; ++c) {
                    const double rho = p.albedo(0, 0)[c], direct = p.direct(0, 0)[c], e = p.indirect(0, 0)[c];
                    const double sky = ambient == Ambient::environment ? pi * double(p.environment[c]) : 0;
                    const double m = p.emission(0, 0)[c];
                    CHECK(p.of(params)[c] ==
                          Approx((rho * (direct * passes + double(k_isr) * e + open * sky) + m) / pi).epsilon(1e-6));
                    CHECK(p.of(printed)[c] ==
                          Approx(rho * direct / pi * passes + 2.5 * double(k_isr) * e + m / pi).epsilon(1e-6));
                }
                CHECK(p.of(params).w == 0);
            }
    // Without a unit that is given a colour of 1 stands for what a white surface sends here: the luminance of E over pi.
    IsrParams scaled;
    scaled.variant = Variant::published;
    const glm::vec4 e = p.direct(0, 0);
    scaled.light_unit = float((0.27 * double(e.x) + 0.67 * double(e.y) + 0.06 * double(e.z)) / pi);
    const glm::vec4 given = p.of(scaled);
    scaled.light_unit = 0;
    CHECK(p.of(scaled) == given);
    // (29) with the occlusion of (26) itself: more of it brightens.
    scaled.ssao_term = SsaoTerm::occlusion, scaled.k_ssao = 0.5f, scaled.k_isr = 0;
    for (float open : {0.25f, 0.75f, 1.0f}) {
        Pixel q;
        q.indirect(0, 0).w = open;
        const double passes = std::min(1.0, 1 - double(open) + 0.5);
        for (int c = 0; c < 3; ++c)
            CHECK(q.of(scaled)[c] == Approx((double(q.albedo(0, 0)[c]) * double(q.direct(0, 0)[c]) * passes + double(q.emission(0, 0)[c])) / pi).epsilon(1e-6));
    }
    Pixel dark;
    dark.direct(0, 0) = glm::vec4(0);
    scaled.k_isr = 1;
    for (int c = 0; c < 3; ++c) CHECK(dark.of(scaled)[c] == Approx(double(dark.emission(0, 0)[c]) / pi).epsilon(1e-6));
    Pixel sky;
    sky.normal(0, 0) = glm::vec4(0);
    CHECK(sky.of({}) == glm::vec4(sky.environment, 0));
}

TEST_CASE("isr.compose: what it leaves alone, to the bit", "[isr][ISR (29)][bits]") {
    Pixel p;
    auto composed = [&](const Image4& indirect, glm::vec3 environment) {
        Image4 out;
        compose::run(compose::ComposeParams{},
                     compose::ComposeInputs{&p.normal, &p.albedo, &p.emission, &p.direct, &indirect, environment}, {}, out);
        return out(0, 0);
    };
    // k_isr = 0 and no ambient light: direct light alone, in both variants.
    IsrParams none;
    none.k_isr = 0, none.ambient = Ambient::none;
    p.indirect(0, 0) = {3e38f, 1, 2, 0.7f};
    CHECK(p.of(none) == composed(Image4(1, 1, glm::vec4(0)), p.environment));
    none.variant = Variant::published;
    CHECK(p.of(none) == composed(Image4(1, 1, glm::vec4(0)), p.environment));

    // k_ssao = 0: accessibility darkens no direct light.
    IsrParams direct;
    direct.ambient = Ambient::none;
    p.indirect(0, 0) = {2, 0.5f, 1, 1};
    const glm::vec4 open = p.of(direct);
    for (float a : {0.0f, 1e-30f, 0.3f, 0.99999f}) {
        p.indirect(0, 0).w = a;
        CHECK(p.of(direct) == open);
    }
    direct.k_ssao = 0.5f;
    p.indirect(0, 0).w = 0.3f;
    CHECK(p.of(direct).x < open.x);

    // Nothing is lost, and nothing made: open, under a black sky, it is (rho (E_direct + E) + M) / pi.
    p.environment = glm::vec3(0), p.indirect(0, 0).w = 1;
    CHECK(p.of({}) == composed(p.indirect, glm::vec3(0)));
}

TEST_CASE("isr filters: the same bits for every instruction set, thread count and with tiles", "[isr][bits]") {
    for (glm::ivec2 size : sizes) {
        const glm::ivec2 coarse = coarse_size(size);
        Image4 surface = rough(coarse), full = rough(size);
        // The first squares of 16 x 16 see nothing.
        raster::Covered coarse_tiles(coarse, 1), tiles(size, 1);
        if (size.x > 32)
            for (int y = 0; y < size.y; ++y)
                for (int x = 0; x < size.x; ++x) {
                    if (x < 16 && y < 16) full(x, y) = glm::vec4(0), tiles.any[0] = 0;
                    if (x < 16 && y < 16 && x < coarse.x && y < coarse.y)
                        surface(x, y) = glm::vec4(0), coarse_tiles.any[0] = 0;
                }
        const Image4 lit = lit_of(surface), rho(size.x, size.y, {0.5f, 0.3f, 0.2f, 0});
        RunOptions scalar;
        scalar.isa = Isa::scalar, scalar.threads = 1;
        for (Variant variant : {Variant::corrected, Variant::published})
            for (int radius : {1, 4, 32})
                for (Blur kind : blurs) {
                    IsrParams params = with(kind, variant, radius);
                    params.upsample = kind == Blur::none ? Upsample::bilinear : Upsample::bilateral;
                    params.k_ssao = 0.5f;
                    Image4 across[2], up = upsampled(params, lit, surface, full, scalar), composed, radiance;
                    for (int d : {0, 1}) across[d] = blurred(params, lit, surface, directions[d], scalar);
                    const ComposeInputs shown{&full, &rho, &rho, &rho, &up, {1, 2, 3}};
                    run(params, shown, scalar, composed);
                    for (Isa isa : supported_isas())
                        for (int threads : {1, 3}) {
                            CAPTURE(size.x, size.y, int(variant), radius, int(kind), isa_name(isa), threads);
                            RunOptions options;
                            options.isa = isa, options.threads = threads;
                            for (int d : {0, 1}) {
                                CHECK(same_bits(blurred(params, lit, surface, directions[d], options), across[d]));
                                CHECK(same_bits(blurred(params, lit, surface, directions[d], options, &coarse_tiles),
                                                across[d]));
                            }
                            CHECK(same_bits(upsampled(params, lit, surface, full, options), up));
                            CHECK(same_bits(upsampled(params, lit, surface, full, options, &tiles), up));
                            run(params, shown, options, radiance);
                            CHECK(same_bits(radiance, composed));
                        }
                }
    }
}

TEST_CASE("isr filters: what an image held before, or that it is an input, changes nothing", "[isr][bits]") {
    const glm::ivec2 size(40, 36), coarse = coarse_size(size);
    Image4 surface = rough(coarse), full = rough(size);
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 16; ++x) surface(x, y) = full(x, y) = glm::vec4(0);
    const Image4 lit = lit_of(surface);
    raster::Covered coarse_tiles(coarse, 1), tiles(size, 1);
    coarse_tiles.any[0] = tiles.any[0] = 0;
    for (Variant variant : {Variant::corrected, Variant::published}) {
        const IsrParams params = with(Blur::gaussian, variant);
        const Image4 smooth = blurred(params, lit, surface, Direction::vertical);
        Image4 again = lit;
        run(params, BlurInputs{&again, &surface, {}, Direction::vertical, &coarse_tiles}, {}, again);
        CHECK(same_bits(again, smooth));
        again = Image4(coarse.x, coarse.y, glm::vec4(NAN));
        run(params, BlurInputs{&lit, &surface, {}, Direction::vertical, &coarse_tiles}, {}, again);
        CHECK(same_bits(again, smooth));

        const Image4 up = upsampled(params, lit, surface, full);
        again = Image4(size.x, size.y, glm::vec4(NAN));
        run(params, UpsampleInputs{&lit, &surface, &full, &full, 0.1, 10, &tiles}, {}, again);
        CHECK(same_bits(again, up));
        again = lit;
        run(params, UpsampleInputs{&again, &surface, &full, &full, 0.1, 10, &tiles}, {}, again);
        CHECK(same_bits(again, up));
        if (variant == Variant::corrected) CHECK(again(3, 3) == nothing);
    }
}

TEST_CASE("isr filters: explain() ends with what run() makes, and so does what is bound by name", "[isr][explain]") {
    const glm::ivec2 size(33, 21), coarse = coarse_size(size);
    const Image4 surface = rough(coarse), full = rough(size), lit = lit_of(surface), rho(33, 21, {0.5f, 0.3f, 0.2f, 0});
    // The last value by that name.
    auto last = [](const std::vector<TapValue>& values, const char* name) {
        std::vector<double> found;
        for (const TapValue& v : values)
            if (v.name == name && v.sample == -1) found = v.value;
        return found;
    };
    auto is = [](const std::vector<double>& a, const glm::vec4& b) {
        return a.size() == 3 && a[0] == b.x && a[1] == b.y && a[2] == b.z;
    };
    auto bound_is = [](const StageBinding& binding, const StageData& data, const Image4& expected) {
        Bundle outputs;
        binding.bind(data)->run({}, {}, outputs);
        const auto& bytes = outputs.arrays.at(0).bytes;
        return bytes.size() == expected.size() * 16 && std::memcmp(bytes.data(), expected.data(), bytes.size()) == 0;
    };
    for (Variant variant : {Variant::corrected, Variant::published})
        for (Blur kind : blurs) {
            CAPTURE(int(variant), int(kind));
            IsrParams params = with(kind, variant);
            params.upsample = kind == Blur::none ? Upsample::bilinear : Upsample::bilateral;
            const UpsampleInputs up{&lit, &surface, &full, &full, 0.1, 10};
            Image4 upsampled_image, radiance;
            run(params, up, {}, upsampled_image);
            const ComposeInputs shown{&full, &rho, &rho, &rho, &upsampled_image, {1, 2, 3}};
            run(params, shown, {}, radiance);
            CHECK(bound_is(stage<UpsampleKernel>(), data_of(params, up), upsampled_image));
            CHECK(bound_is(stage<ComposeKernel>(), data_of(params, shown), radiance));
            for (Direction direction : directions) {
                const BlurInputs in{&lit, &surface, eye(coarse), direction};
                const Image4 got = blurred(params, lit, surface, direction);
                CHECK(bound_is(stage<BlurKernel>(), data_of(params, in), got));
                for (int y = 0; y < coarse.y; ++y)
                    for (int x = 0; x < coarse.x; ++x) {
                        const auto values = explain(params, in, {x, y});
                        CHECK(is(last(values, "irradiance"), got(x, y)));
                        CHECK(values.back().name == "accessibility");
                        CHECK(values.back().value.at(0) == got(x, y).w);
                    }
            }
            for (int y = 0; y < size.y; ++y)
                for (int x = 0; x < size.x; ++x) {
                    const auto values = explain(params, up, {x, y});
                    CHECK(is(last(values, "irradiance"), upsampled_image(x, y)));
                    CHECK(values.back().value.at(0) == upsampled_image(x, y).w);
                    double sum = 0;
                    for (const TapValue& v : values) sum += v.name == "w" ? v.value[0] : 0;
                    if (upsampled_image(x, y) != nothing) CHECK(sum == Approx(1).epsilon(1e-6));  // (28)
                    CHECK(is(explain(params, shown, {x, y}).back().value, radiance(x, y)));
                }
        }
}

TEST_CASE("isr filters: float stays within its budget of double", "[isr][budget]") {
    const glm::ivec2 size(33, 40), coarse = coarse_size(size);
    const Image4 surface = rough(coarse), full = rough(size), lit = lit_of(surface);
    for (Variant variant : {Variant::corrected, Variant::published})
        for (Blur kind : {Blur::gaussian, Blur::edge_aware}) {
            const IsrParams params = with(kind, variant);
            const StageData datas[] = {data_of(params, UpsampleInputs{&lit, &surface, &full, &full, 0.1, 10}),
                                       data_of(params, BlurInputs{&lit, &surface, eye(coarse), Direction::vertical})};
            const StageBinding* bindings[] = {&stage<UpsampleKernel>(), &stage<BlurKernel>()};
            for (int s = 0; s < 2; ++s) {
                const auto stage = bindings[s]->bind(datas[s]);
                DecisionTape tape;
                for (int py = 0; py < datas[s].size.y; ++py)
                    for (int px = 0; px < datas[s].size.x; ++px) {
                        CAPTURE(int(variant), int(kind), s, px, py);
                        std::vector<Followed> one;
                        tape.record();
                        stage->follow({px, py}, tape, one);
                        // A weight of edge_aware is a difference from 1: a mean by small weights is worth less.
                        double total = 1;
                        for (const TapValue& v : stage->explain({px, py}))
                            if (v.name == "total" && v.value[0] > 0) total = std::min(1.0, v.value[0]);
                        for (const Followed& v : one)
                            CHECK(std::abs(v.value - v.exact) <=
                                  16 * 0x1p-24 * std::max(1.0, std::abs(v.exact)) / total);
                    }
            }
        }
}

TEST_CASE("isr filters: no NaN at the limits of what they are given", "[isr][extremes]") {
    const glm::ivec2 size(12, 6), coarse(6, 3);
    const float most = 1e30f;
    for (float depth : {1e-30f, 1e-6f, 1e15f})
        for (float other : {1e-30f, 1e-3f, 1e15f})
            for (float epsilon : {1.1e-9f, 1e9f})
                for (float sigma : {1.1e-3f, 1e6f})
                    for (Variant variant : {Variant::corrected, Variant::published})
                        for (Blur kind : blurs) {
                            CAPTURE(depth, other, epsilon, sigma, int(variant), int(kind));
                            IsrParams params = with(kind, variant, 32, sigma);
                            params.epsilon = epsilon;
                            Image4 surface = wall(coarse, depth), full = wall(size, depth);
                            Image4 lit(6, 3, {most, 0, 1e-40f, 0});
                            for (int y = 0; y < 3; ++y) surface(3, y).w = other, lit(3, y) = {0, most, 1, 1};
                            for (int y = 0; y < 6; ++y) full(6, y).w = other, full(9, y) = glm::vec4(0);
                            const Image4 smooth = blurred(params, lit, surface, Direction::horizontal);
                            const Image4 up = upsampled(params, smooth, surface, full);
                            for (const Image4* image : {&smooth, &up})
                                for (const glm::vec4& v : image->texels)
                                    for (int c = 0; c < 4; ++c)
                                        CHECK((v[c] >= 0 && v[c] <= (c < 3 ? most : 1) * 1.00001f));
                        }
}

TEST_CASE("isr filters: bad input is refused in one line", "[isr]") {
    const Image4 full = wall({4, 4}), half = wall({2, 2});
    Image4 out(1, 1, glm::vec4(7));
    IsrParams params;
    CHECK_THROWS_WITH(run(params, BlurInputs{&full, &half, eye({4, 4})}, {}, out),
                      "isr.blur: input \"surface\" is [2, 2, 4]: expected [4, 4, 4]");
    CHECK_THROWS_WITH(run(params, BlurInputs{&full, nullptr}, {}, out), "isr.blur: surface must be bound");
    CHECK_THROWS_WITH(run(params, UpsampleInputs{&full, &half, &full, &full}, {}, out),
                      "isr.upsample: input \"lit\" is 4 x 4: expected 2 x 2, half of the outputs, rounded up");
    CHECK_THROWS_WITH(run(params, ComposeInputs{&full, &full, &half, &full, &full, {}}, {}, out),
                      "isr.compose: input \"emission\" is [2, 2, 4]: expected [4, 4, 4]");
    CHECK_THROWS_WITH(run(params, ComposeInputs{}, {}, out), "isr.compose: normal must be bound");
    CHECK_THROWS_WITH(run(params, UpsampleInputs{&half, &half, nullptr, &full}, {}, out),
                      "isr.upsample: position must be bound");
    CHECK_THROWS_WITH(run(params, BlurInputs{&full, &full}, {}, out),
                      "isr.blur: camera must be bound: blur = edge_aware measures distances from planes");
    const raster::Covered tiles({64, 64}, 1);
    CHECK_THROWS_WITH(run(params, BlurInputs{&full, &full, eye({4, 4}), Direction::vertical, &tiles}, {}, out),
                      "isr.blur: tiles are of another size");
    params.variant = Variant::published;
    CHECK_THROWS_WITH(run(params, UpsampleInputs{&half, &half, &full, &full, 0.1, INFINITY}, {}, out),
                      "isr.upsample: far = inf: expected a finite far plane above 0 m, since variant = published "
                      "compares depths as shares of it (ISR (27))");
    params = {};
    params.position = Position::inverse_matrix;
    CHECK_THROWS_WITH(run(params, UpsampleInputs{&half, &half, &full, &full, 0, 10}, {}, out),
                      "isr.upsample: near = 0, far = 10: expected 0 < near < far");
    params.blur = Blur::edge_aware;
    CHECK_THROWS_AS(run(params, BlurInputs{&full, &full, eye({4, 4})}, {}, out), InputError);
    params = {};
    params.blur_radius = 33;
    CHECK_THROWS_AS(run(params, BlurInputs{&full, &full, eye({4, 4})}, {}, out), InputError);
    CHECK(out(0, 0).x == 7);  // nothing half written
}
