// The filters of indirect light against closed forms: what they keep, where their pixels lie, what they do not cross.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "core/bounded.h"
#include "core/error.h"
#include "core/hash.h"
#include "gi/filter/filter.h"
#include "gi/filter/filter.h"

using namespace plumb;
using namespace plumb::filter;

namespace {

const glm::ivec2 sizes[] = {{1, 1}, {2, 1}, {3, 2}, {5, 5}, {17, 6}, {33, 40}, {64, 35}};

// A wall that faces the camera, a pixel an millimetre: position (x, y, 0) mm, normal +z, 2 m away.
struct Wall {
    Image4 position, normal;
    explicit Wall(glm::ivec2 size) : position(size.x, size.y), normal(size.x, size.y, glm::vec4(0, 0, 1, 1)) {
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) position(x, y) = glm::vec4(0.001f * float(x), 0.001f * float(y), 0, 2);
    }
};

float noise(int x, int y, int channel) { return unit_float<float>(pixel_hash<std::int32_t>(x, y, channel, 7).x); }

// Every pixel somewhere else: positions, depths and normals of noise, some without a surface.
struct Noise {
    Image4 position, normal, irradiance;
    explicit Noise(glm::ivec2 size)
        : position(size.x, size.y), normal(size.x, size.y), irradiance(size.x, size.y) {
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) {
                const float z = 2 + 0.05f * noise(x, y, 0);
                irradiance(x, y) = {noise(x, y, 1), 3 * noise(x, y, 2), noise(x, y, 3), z};
                if (noise(x, y, 4) < 0.1f) continue;
                position(x, y) = {0.01f * float(x), 0.01f * float(y), z, z};
                const glm::vec3 bump(noise(x, y, 5) - 0.5f, noise(x, y, 6) - 0.5f, 0.7f);
                normal(x, y) = glm::vec4(glm::normalize(bump), 1);
            }
    }
};

Image4 constant(glm::ivec2 size, glm::vec4 value) { return Image4(size.x, size.y, value); }

Image4 reduced(const Image4& image) {
    Image4 out;
    run(FilterParams{}, ReduceInputs{&image}, {}, out);
    return out;
}

Image4 upsampled(const FilterParams& params, const Image4& coarse, const Image4& position, const Image4& normal,
                 const RunOptions& options = {}) {
    const Image4 x = reduced(position), n = reduced(normal);
    Image4 out;
    run(params, UpsampleInputs{&coarse, &x, &n, &position, &normal}, options, out);
    return out;
}

Image4 blurred(FilterParams params, Blur blur, const Image4& irradiance, const Image4& position, const Image4& normal,
               const RunOptions& options = {}) {
    params.blur = blur;
    Image4 out;
    run_blur(params, {&irradiance, &position, &normal}, options, out);
    return out;
}

FilterParams mode(Upsample upsample, Similarity similarity = Similarity::plane) {
    FilterParams params;
    params.upsample = upsample, params.similarity = similarity;
    return params;
}

bool same_bits(const Image4& a, const Image4& b) {
    return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(glm::vec4)) == 0;
}

// |a - b| / b, and infinity where either is no number.
double off(double a, double b) {
    const double d = std::abs(a - b) / std::abs(b);
    return d == d ? d : INFINITY;
}

}  // namespace

TEST_CASE("filter.reduce: the lower right pixel of every 2 x 2, within the image", "[filter][analytic]") {
    for (glm::ivec2 size : sizes) {
        CAPTURE(size.x, size.y);
        Image4 image(size.x, size.y);
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) image(x, y) = {x, y, x + 100 * y, 7};
        const Image4 got = reduced(image);
        REQUIRE(got.width == (size.x + 1) / 2);
        REQUIRE(got.height == (size.y + 1) / 2);
        for (int y = 0; y < got.height; ++y)
            for (int x = 0; x < got.width; ++x)
                CHECK(got(x, y) == image(std::min(2 * x + 1, size.x - 1), std::min(2 * y + 1, size.y - 1)));
    }
}

TEST_CASE("filters: a constant stays what it is", "[filter][analytic]") {
    for (glm::ivec2 size : sizes) {
        CAPTURE(size.x, size.y);
        const Noise room(size);
        const glm::vec3 value(0.3f, 7.7f, 1e-3f);
        // Each of n products and sums rounds once, and so does the quotient.
        auto require_constant = [&](const Image4& got, double allowed) {
            for (std::size_t i = 0; i < got.size(); ++i) {
                const bool surface = room.normal.texels[i].w > 0;
                for (int c = 0; c < 3; ++c) {
                    CAPTURE(i, c);
                    CHECK((surface ? off(got.texels[i][c], value[c]) : std::abs(double(got.texels[i][c]))) <= allowed);
                }
            }
        };
        for (Similarity similarity : {Similarity::plane, Similarity::depth}) {
            FilterParams params = mode(Upsample::bilateral, similarity);
            params.sigma_depth = 0.01f;
            Image4 image = constant(size, glm::vec4(value, 0));
            for (std::size_t i = 0; i < image.size(); ++i) image.texels[i].w = room.position.texels[i].w;
            require_constant(blurred(params, Blur::full, image, room.position, room.normal), 2 * 289 * 0x1p-24);
            require_constant(blurred(params, Blur::separable, image, room.position, room.normal), 4 * 17 * 0x1p-24);

            // A coarse pixel without a surface gathers nothing; who has no other neighbour stays dark.
            const Image4 coarse = reduced(image), n = reduced(room.normal);
            const Image4 got = upsampled(params, coarse, room.position, room.normal);
            for (int y = 0; y < size.y; ++y)
                for (int x = 0; x < size.x; ++x) {
                    const bool pick = x % 2 == 1 && y % 2 == 1;
                    if (room.normal(x, y).w > 0 && (pick || got(x, y).x != 0))
                        for (int c = 0; c < 3; ++c) CHECK(off(got(x, y)[c], value[c]) <= 8 * 0x1p-24);
                    CHECK(got(x, y).w == room.position(x, y).w);
                }
        }
    }
}

TEST_CASE("filter.upsample: a linear ramp on a plane comes back between the picks", "[filter][analytic]") {
    for (glm::ivec2 size : sizes) {
        CAPTURE(size.x, size.y);
        const Wall wall(size);
        auto ramp = [](int x, int y) { return float(3 + 2 * x + 5 * y); };
        Image4 image(size.x, size.y);
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) image(x, y) = glm::vec4(glm::vec3(ramp(x, y)), 2);
        const Image4 coarse = reduced(image);
        for (Upsample kind : {Upsample::bilinear, Upsample::bilateral}) {
            const Image4 got = upsampled(mode(kind), coarse, wall.position, wall.normal);
            for (int y = 0; y < size.y; ++y)
                for (int x = 0; x < size.x; ++x) {
                    // Before the first pick the ramp is continued by its end.
                    const int from_x = std::max(x, std::min(1, size.x - 1)), from_y = std::max(y, std::min(1, size.y - 1));
                    CHECK(got(x, y).x == ramp(from_x, from_y));
                }
        }
        // The GPU's own filter moves it by half a pixel.
        if (size.x % 2 || size.y % 2 || size.x < 8) continue;
        const Image4 got = upsampled(mode(Upsample::published), coarse, wall.position, wall.normal);
        CHECK(got(4, 3).x == ramp(4, 3) + 0.5f * (2 + 5));
    }
}

TEST_CASE("filter.upsample: edges of depth and of normal are not crossed", "[filter][analytic]") {
    const glm::ivec2 size(16, 8);
    for (Similarity similarity : {Similarity::plane, Similarity::depth})
        for (bool turned : {false, true}) {
            CAPTURE(int(similarity), turned);
            Wall wall(size);
            Image4 image = constant(size, {1, 1, 1, 2});
            for (int y = 0; y < size.y; ++y)
                for (int x = 8; x < size.x; ++x) {
                    if (turned)
                        wall.normal(x, y) = {1, 0, 0, 1};
                    else
                        wall.position(x, y).z = -1, wall.position(x, y).w = image(x, y).w = 3;
                    image(x, y).x = 100;
                }
            const Image4 got = upsampled(mode(Upsample::bilateral, similarity), reduced(image), wall.position, wall.normal);
            for (int y = 0; y < size.y; ++y)
                for (int x = 0; x < size.x; ++x) CHECK(off(got(x, y).x, x < 8 ? 1 : 100) <= 0x1p-22);
            CHECK(upsampled(mode(Upsample::bilinear), reduced(image), wall.position, wall.normal)(8, 3).x == 50.5f);
            const Image4 smooth = blurred(mode(Upsample::bilateral, similarity), Blur::full, image, wall.position,
                                          wall.normal);
            for (int y = 0; y < size.y; ++y)
                for (int x = 0; x < size.x; ++x) CHECK(off(smooth(x, y).x, x < 8 ? 1 : 100) <= 2 * 289 * 0x1p-24);
        }
}

TEST_CASE("filter.upsample: where no weight is left, the surface that is nearest in depth", "[filter][analytic]") {
    // The pixel (2, 2) lies between four picks, all of other surfaces: depths 4, 5, 3 and none, for a pixel at 2.
    Wall wall({4, 4});
    const float depths[] = {4, 5, 3, 0};
    Image4 coarse(2, 2);
    for (int k = 0; k < 4; ++k) {
        const int x = 2 * (k % 2) + 1, y = 2 * (k / 2) + 1;
        wall.position(x, y) = {0, 0, depths[k], depths[k]};
        if (k == 3) wall.position(x, y) = wall.normal(x, y) = glm::vec4(0);
        coarse(k % 2, k / 2) = glm::vec4(glm::vec3(k < 3 ? float(10 + k) : 99), depths[k]);
    }
    CHECK(upsampled({}, coarse, wall.position, wall.normal)(2, 2) == glm::vec4(12, 12, 12, 2));
    CHECK(upsampled({}, coarse, wall.position, wall.normal)(3, 3) == glm::vec4(0));
}

TEST_CASE("filter.blur: one bright pixel spreads by the Gaussian, and nothing is lost", "[filter][analytic]") {
    const glm::ivec2 size(41, 41);
    const Wall wall(size);
    Image4 image = constant(size, {0, 0, 0, 2});
    image(20, 20) = {1, 2, 4, 2};
    FilterParams params;
    params.sigma_distance = 3;
    double total = 0;
    for (int dy = -8; dy <= 8; ++dy)
        for (int dx = -8; dx <= 8; ++dx) total += std::exp(-(dx * dx + dy * dy) / 18.0);
    for (Blur kind : {Blur::full, Blur::separable}) {
        CAPTURE(int(kind));
        const Image4 got = blurred(params, kind, image, wall.position, wall.normal);
        glm::dvec3 sum(0);
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) {
                const int dx = x - 20, dy = y - 20;
                const bool within = std::abs(dx) <= 8 && std::abs(dy) <= 8;
                const double expected = within ? std::exp(-(dx * dx + dy * dy) / 18.0) / total : 0;
                for (int c = 0; c < 3; ++c)
                    CHECK(got(x, y)[c] == Approx(expected * (1 << c)).epsilon(1e-5).margin(1e-12));
                sum += glm::dvec3(got(x, y));
            }
        for (int c = 0; c < 3; ++c) CHECK(sum[c] == Approx(1 << c).epsilon(1e-5));
    }
}

TEST_CASE("filter.blur: a slanted plane is no edge for the plane's distance", "[filter][analytic]") {
    const glm::ivec2 size(40, 20);
    Wall floor(size);
    Image4 image = constant(size, {0, 0, 0, 0});
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            const float z = 2 + 0.02f * float(x);  // a percent of the depth a pixel
            floor.position(x, y).z = z, floor.position(x, y).w = image(x, y).w = z;
            floor.normal(x, y) = glm::vec4(glm::normalize(glm::vec3(-20, 0, 1)), 1);  // across (1, 0, 20)
        }
    image(20, 10) = {1, 1, 1, image(20, 10).w};
    const FilterParams depth = mode(Upsample::bilateral, Similarity::depth);
    CHECK(blurred({}, Blur::full, image, floor.position, floor.normal)(26, 10).x > 1e-4);
    CHECK(blurred(depth, Blur::full, image, floor.position, floor.normal)(26, 10).x == 0);
}

TEST_CASE("filter.blur: the separable form is the full one where nothing but the distance weighs", "[filter][analytic]") {
    const glm::ivec2 size(50, 37);
    const Wall wall(size);
    Image4 image = Noise(size).irradiance;
    for (glm::vec4& e : image.texels) e.w = 2;
    for (int kernel : {1, 3, 17, 33}) {
        FilterParams params;
        params.kernel = kernel;
        const Image4 full = blurred(params, Blur::full, image, wall.position, wall.normal);
        const Image4 separable = blurred(params, Blur::separable, image, wall.position, wall.normal);
        for (std::size_t i = 0; i < full.size(); ++i)
            for (int c = 0; c < 3; ++c) CHECK(off(separable.texels[i][c], full.texels[i][c]) <= 1e-5);
        if (kernel == 1) CHECK(same_bits(full, image));
    }
}

TEST_CASE("filter.blur: what has no surface neither gives nor takes", "[filter][analytic]") {
    const glm::ivec2 size(20, 20);
    Wall wall(size);
    Image4 image = constant(size, {1, 1, 1, 2});
    for (int y = 0; y < size.y; ++y)
        for (int x = 10; x < size.x; ++x) {
            wall.position(x, y) = wall.normal(x, y) = glm::vec4(0);
            image(x, y) = {1e6f, 1e6f, 1e6f, 0};
        }
    for (Similarity similarity : {Similarity::plane, Similarity::depth}) {
        const Image4 got = blurred(mode(Upsample::bilateral, similarity), Blur::full, image, wall.position, wall.normal);
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) {
                if (x < 10)
                    CHECK(off(got(x, y).x, 1) <= 2 * 289 * 0x1p-24);
                else
                    CHECK(got(x, y) == glm::vec4(0));
            }
    }
}

TEST_CASE("filters: the same bits for every instruction set and thread count", "[filter][bits]") {
    for (glm::ivec2 size : sizes) {
        const Noise room(size);
        const Image4 coarse = reduced(room.irradiance);
        for (Similarity similarity : {Similarity::plane, Similarity::depth})
            for (int kernel : {5, 17, 33}) {
                FilterParams params = mode(Upsample::bilateral, similarity);
                params.kernel = kernel;
                RunOptions scalar;
                scalar.isa = Isa::scalar, scalar.threads = 1;
                Image4 small, first_small;
                run(FilterParams{}, ReduceInputs{&room.irradiance}, scalar, first_small);
                const Image4 up = upsampled(params, coarse, room.position, room.normal, scalar);
                const Image4 full = blurred(params, Blur::full, room.irradiance, room.position, room.normal, scalar);
                const Image4 separable =
                    blurred(params, Blur::separable, room.irradiance, room.position, room.normal, scalar);
                for (Isa isa : supported_isas())
                    for (int threads : {1, 2, 3}) {
                        CAPTURE(size.x, size.y, int(similarity), kernel, isa_name(isa), threads);
                        RunOptions options;
                        options.isa = isa, options.threads = threads;
                        run(FilterParams{}, ReduceInputs{&room.irradiance}, options, small);
                        CHECK(same_bits(small, first_small));
                        CHECK(same_bits(upsampled(params, coarse, room.position, room.normal, options), up));
                        CHECK(same_bits(blurred(params, Blur::full, room.irradiance, room.position, room.normal, options),
                                        full));
                        CHECK(same_bits(
                            blurred(params, Blur::separable, room.irradiance, room.position, room.normal, options),
                            separable));
                    }
                // The kernel on the images as they are bound, which the twin mirrors.
                const StageData data = data_of(params, BlurInputs{&room.irradiance, &room.position, &room.normal});
                Bundle outputs;
                const auto stage = plumb::stage<BlurKernel>().bind(data);
                stage->run(scalar, {}, outputs);
                CHECK(std::memcmp(outputs.arrays[0].bytes.data(), full.data(), outputs.arrays[0].bytes.size()) == 0);
                DecisionTape tape;
                for (int y = 0; y < size.y; ++y)
                    for (int x = 0; x < size.x; x += 2) {
                        std::vector<Followed> one;
                        tape.record();
                        stage->follow({x, y}, tape, one);
                        for (int c = 0; c < 4; ++c) CHECK(one[std::size_t(c)].value == full(x, y)[c]);
                    }
            }
    }
}

TEST_CASE("filters: float stays within its budget of double", "[filter][budget]") {
    const glm::ivec2 size(33, 40);
    const Noise room(size);
    const Image4 coarse = reduced(room.irradiance), x = reduced(room.position), n = reduced(room.normal);
    for (Similarity similarity : {Similarity::plane, Similarity::depth}) {
        FilterParams params = mode(Upsample::bilateral, similarity);
        params.sigma_depth = 0.05f;
        const StageData datas[] = {
            data_of(params, UpsampleInputs{&coarse, &x, &n, &room.position, &room.normal}),
            data_of(params, BlurInputs{&room.irradiance, &room.position, &room.normal})};
        const StageBinding* bindings[] = {&stage<UpsampleKernel>(), &stage<BlurKernel>()};
        for (int s = 0; s < 2; ++s) {
            const auto stage = bindings[s]->bind(datas[s]);
            DecisionTape tape;
            for (int py = 0; py < size.y; ++py)
                for (int px = 0; px < size.x; ++px) {
                    CAPTURE(s, px, py);
                    std::vector<Followed> one;
                    tape.record();
                    stage->follow({px, py}, tape, one);
                    // A weight is a difference from 1, and so is as wrong as 1: a mean by small weights is worth less.
                    double total = 1;
                    for (const TapValue& v : stage->explain({px, py}))
                        if (v.name == "total" && v.value[0] > 0) total = std::min(1.0, v.value[0]);
                    for (int c = 0; c < 4; ++c) {
                        const double error = std::abs(one[std::size_t(c)].value - one[std::size_t(c)].exact);
                        CHECK(error <= 16 * 0x1p-24 * std::max(1.0, std::abs(one[std::size_t(c)].exact)) / total);
                    }
                }
        }
    }
}

TEST_CASE("filters: bad input is refused in one line", "[filter]") {
    const Wall wall({4, 4});
    const Image4 image = constant({4, 4}, glm::vec4(1)), half = constant({2, 2}, glm::vec4(1));
    Image4 out;
    FilterParams params;
    params.kernel = 4;
    CHECK_THROWS_WITH(run(params, BlurInputs{&image, &wall.position, &wall.normal}, {}, out),
                      "filter.blur: kernel = 4: expected an odd number");
    params.kernel = 35;
    CHECK_THROWS_AS(run(params, BlurInputs{&image, &wall.position, &wall.normal}, {}, out), InputError);
    CHECK_THROWS_WITH(run(FilterParams{}, BlurInputs{&image, &wall.position, &half}, {}, out),
                      "filter.blur: input \"normal\" is [2, 2, 4]: expected [4, 4, 4]");
    CHECK_THROWS_WITH(run(FilterParams{}, UpsampleInputs{&image, &half, &half, &wall.position, &wall.normal}, {}, out),
                      "filter.upsample: input \"coarse_irradiance\" is 4 x 4: expected 2 x 2, half of the outputs, rounded up");
    CHECK_THROWS_WITH(run(FilterParams{}, UpsampleInputs{&half, &half, nullptr, &wall.position, &wall.normal}, {}, out),
                      "filter.upsample: coarse_normal must be bound");
}
