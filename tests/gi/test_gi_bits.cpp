// The promise of equal bits: every kernel of gi/, by every instruction set and number of threads, from the same inputs.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/hash.h"
#include "gi/compose/compose.h"
#include "gi/direct/direct.h"
#include "raster/light_view.h"
#include "rsm_scenes.h"

using namespace plumb;
using namespace plumb::test;

namespace {

float noise(int x, int y, int channel) {
    return unit_float<float>(pixel_hash<std::int32_t>(x, y, channel, 7).x);
}

Image4 noise_image(int width, int height, int channel, float low, float high) {
    Image4 image(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < 4; ++c) image(x, y)[c] = low + (high - low) * noise(x, y, 4 * channel + c);
    return image;
}

Image4 noise_normals(int width, int height, int channel) {
    Image4 image = noise_image(width, height, channel, -1, 1);
    for (glm::vec4& n : image.texels) n = glm::vec4(normalize3<float>(glm::vec3(n)), 1);
    return image;
}

// A bumpy map that shines on noisy points in front of it.
raster::Rsm noise_map(int size, bool half) {
    raster::Rsm map = plane_map(size, [](double x, double y) { return 1 + x * y; });
    map.half = half;
    map.position = noise_image(size, size, 20, -1, 1);
    for (std::size_t i = 0; i < map.records.size(); i += record_stride)
        for (int c = 0; c < 7; ++c) map.records[i + c] += 0.2f * noise(int(i), c, 3) - 0.1f;
    // Every seventh texel has no surface.
    for (std::size_t i = 0; i < map.records.size(); i += 7 * record_stride)
        for (int c = 0; c < 16; ++c) map.records[i + c] = 0;
    // Half records: the same numbers after rounding to half, which truncating the significand to 10 bits does here.
    map.half_records.resize(map.records.size());
    for (std::size_t i = 0; i < map.records.size(); ++i) {
        std::uint32_t bits;
        std::memcpy(&bits, &map.records[i], 4);
        const int exponent = int(bits >> 23 & 255) - 112;
        const std::uint32_t sign = bits >> 16 & 0x8000;
        map.half_records[i].bits = std::uint16_t(exponent <= 0 ? sign : sign | exponent << 10 | (bits >> 13 & 1023));
    }
    return map;
}

// The gathers that a picture depends on, in each branch that their kernels have.
std::vector<rsm::GatherParams> gathers() {
    using enum rsm::Visibility;
    rsm::GatherParams disc, all, paths;
    disc.gather = rsm::Gather::disc;
    disc.samples = 50, disc.turn = rsm::Turn::hash, all.gather = rsm::Gather::all;
    paths.gather = rsm::Gather::paths, paths.directions = 7, paths.steps = 6;
    std::vector<rsm::GatherParams> kinds = {disc, all};
    disc.turn = rsm::Turn::tile, kinds.push_back(disc);
    for (auto [visibility, slots] :
         {std::pair{none, 5}, {algorithm_2, 2}, {algorithm_3, 9}, {algorithm_6, 5}, {algorithm_6, 32}}) {
        paths.visibility = visibility, paths.slots = slots;
        paths.turn = slots == 9 ? rsm::Turn::tile : rsm::Turn::hash;
        paths.slot_edges = slots == 32 ? rsm::SlotEdges::solid_angle : rsm::SlotEdges::angle;
        kinds.push_back(paths);
    }
    for (const rsm::GatherParams& whole : std::vector(kinds)) {
        if (whole.gather == rsm::Gather::all) continue;
        kinds.push_back(whole);
        kinds.back().texels = rsm::Texels::continuous;
    }
    for (const rsm::GatherParams& point : std::vector(kinds)) {
        if (point.gather == rsm::Gather::all) continue;
        kinds.push_back(point);
        kinds.back().sample_area = rsm::SampleArea::texels;
    }
    for (const float thickness : {0.1f, 1e9f}) {
        kinds.push_back(paths);
        kinds.back().thickness = thickness;
    }
    return kinds;
}

// Calls f for all instruction sets of this machine by 1, 2 and 3 threads.
template <class Body>
void for_all_options(Body f) {
    for (Isa isa : supported_isas())
        for (int threads : {1, 2, 3}) {
            CAPTURE(isa_name(isa), threads);
            RunOptions options;
            options.isa = isa;
            options.threads = threads;
            f(options);
        }
}

template <class Run>
void require_same_bits(Run run) {
    Image4 first;
    RunOptions scalar;
    scalar.isa = Isa::scalar;
    scalar.threads = 1;
    run(scalar, first);
    for_all_options([&](const RunOptions& options) {
        Image4 image;
        run(options, image);
        REQUIRE(image.size() == first.size());
        CHECK(std::memcmp(image.data(), first.data(), first.size() * sizeof(glm::vec4)) == 0);
    });
}

const glm::ivec2 sizes[] = {{1, 1}, {3, 2}, {17, 5}, {64, 33}};

}  // namespace

TEST_CASE("rsm: the same bits for every instruction set and thread count", "[rsm][bits]") {
    for (glm::ivec2 size : sizes)
        for (bool half : {false, true})
            for (const rsm::GatherParams& params : gathers()) {
                CAPTURE(size.x, size.y, half, int(params.gather), int(params.visibility), params.slots);
                const raster::Rsm map = noise_map(24, half);
                Points points(size.x, size.y);
                points.position = noise_image(size.x, size.y, 0, -1.5f, 1.5f);
                points.normal = noise_normals(size.x, size.y, 1);
                const rsm::Pattern pattern = rsm::pattern_of(params, map.size, 1);
                require_same_bits([&](const RunOptions& options, Image4& out) {
                    out = gather(params, points, map, &pattern, options);
                });
            }
}

TEST_CASE("rsm: a map of halves and the same map widened give the same bits", "[rsm][bits]") {
    const raster::Rsm halves = noise_map(24, true);
    raster::Rsm floats = halves;
    floats.half = false;
    for (std::size_t i = 0; i < floats.records.size(); ++i) floats.records[i] = half_to_float(floats.half_records[i]);
    Points points(40, 9);
    points.position = noise_image(40, 9, 0, -1.5f, 1.5f);
    points.normal = noise_normals(40, 9, 1);
    for (const rsm::GatherParams& params : gathers()) {
        const rsm::Pattern pattern = rsm::pattern_of(params, 24, 1);
        const Image4 from_halves = gather(params, points, halves, &pattern);
        const Image4 from_floats = gather(params, points, floats, &pattern);
        CHECK(std::memcmp(from_halves.data(), from_floats.data(), from_floats.size() * sizeof(glm::vec4)) == 0);
        CHECK(std::any_of(from_floats.texels.begin(), from_floats.texels.end(),
                          [](const glm::vec4& e) { return e.x > 0; }));
    }
}

// A sample outside the map is texel 0 with the weight 0: packets that leave such samples out must not do so where that is no 0.
TEST_CASE("rsm: an infinite flux in texel 0 reaches every point with a sample outside the map", "[rsm][bits][extreme]") {
    raster::Rsm map = noise_map(24, false);
    set_texel(map, 0, 0, {-0.9f, 0.9f, 0}, {0, 0, 1}, glm::vec3(std::numeric_limits<float>::infinity()));
    Points points(33, 9);
    points.position = noise_image(33, 9, 0, -1.5f, 1.5f);
    points.normal = noise_normals(33, 9, 1);
    for (const rsm::GatherParams& params : gathers()) {
        if (params.gather == rsm::Gather::all) continue;
        CAPTURE(int(params.gather), int(params.texels), int(params.visibility));
        const rsm::Pattern pattern = rsm::pattern_of(params, map.size, 1);
        const auto run = [&](const RunOptions& options, Image4& out) {
            out = gather(params, points, map, &pattern, options);
        };
        require_same_bits(run);
        Image4 image;
        run({}, image);
        int nan = 0;
        for (int x = 0; x < 33; ++x) {
            const auto in = rsm::GatherInputs{&points.position, &points.normal, &map, &pattern, 1};
            const float one = float(rsm::explain(params, in, {x, 4}).back().value[0]);
            CHECK(std::isnan(one) == std::isnan(image(x, 4).x));
            nan += std::isnan(one);
        }
        CHECK(nan > 0);
        CHECK(nan < 33);
    }
}

TEST_CASE("rsm: float stays within its budget of double", "[rsm][budget]") {
    const raster::Rsm map = noise_map(24, false);
    Points points(32, 8);
    points.position = noise_image(32, 8, 0, -1.5f, 1.5f);
    points.normal = noise_normals(32, 8, 1);
    for (const rsm::GatherParams& params : gathers()) {
        const rsm::Pattern pattern = rsm::pattern_of(params, map.size, 1);
        const Image4 got = gather(params, points, map, &pattern);
        Image<glm::dvec4> exact;
        const rsm::GatherInputs in{&points.position, &points.normal, &map, &pattern, 1};
        run_double(rsm::stage_of(params), rsm::data_of(params, in), {}, exact);
        double scale = 0;
        for (const glm::dvec4& e : exact.texels) scale = std::max(scale, e.x);
        REQUIRE(scale > 0);
        for (std::size_t i = 0; i < got.size(); ++i) {
            // All terms are positive; each carries under 16 roundings, and cosines near 0 lose relative to the largest.
            const double error = std::abs(got.texels[i].x - exact.texels[i].x);
            CHECK(error <= 16 * 0x1p-24 * std::max(exact.texels[i].x, 0.05 * scale));
        }
    }
}

TEST_CASE("direct: the same bits for every instruction set and thread count", "[direct][bits]") {
    for (glm::ivec2 size : sizes) {
        CAPTURE(size.x, size.y);
        const Image4 position = noise_image(size.x, size.y, 0, -2, 2), normal = noise_normals(size.x, size.y, 1);
        std::vector<Light> lights(3);
        lights[0].position = {0.1f, 3, 0.2f};
        lights[1].type = LightType::directional;
        lights[1].direction = {0.6f, -0.8f, 0};
        lights[2].position = {-1, 1, 1};
        lights[2].direction = {0.6f, -0.8f, 0};
        const Image4 visible = noise_image(size.x, size.y, 9, 0, 1);
        Buffer<float> visibility;
        for (int l = 0; l < 3; ++l)
            for (const glm::vec4& v : visible.texels) visibility.push_back(v[l] < 0.5f ? 0.0f : 1.0f);
        for (auto variant : {direct::DirectVariant::corrected, direct::DirectVariant::published})
            for (bool density : {false, true})
                require_same_bits([&](const RunOptions& options, Image4& out) {
                    direct::run(direct::DirectParams{variant},
                                direct::DirectInputs{&position, &normal, &lights, &visibility, nullptr, density}, options, out);
                });
    }
}

TEST_CASE("shadow: the same bits for every instruction set and thread count", "[shadow][bits]") {
    for (glm::ivec2 size : sizes) {
        CAPTURE(size.x, size.y);
        const Image4 position = noise_image(size.x, size.y, 0, -1, 1), normal = noise_normals(size.x, size.y, 1);
        const raster::Rsm map = noise_map(24, false);
        require_same_bits([&](const RunOptions& options, Image4& out) {
            Buffer<float> visibility(std::size_t(size.x) * size.y, -1.0f);
            direct::run(direct::ShadowParams{.mode = direct::ShadowMode::hard, .test = direct::ShadowTest::depth}, {&position, &normal, {&map, 1}}, options, visibility.data());
            out = Image4(size.x, size.y);
            for (std::size_t i = 0; i < out.size(); ++i) {
                REQUIRE((visibility[i] == 0 || visibility[i] == 1));
                out.texels[i].x = visibility[i];
            }
        });
    }
}

// Terraces, so that in a packet some pixels go on as their neighbours do and some do not, and some ask for that and some do not.
TEST_CASE("shadow by planes of a picture: the same bits for every instruction set and thread count", "[shadow][bits]") {
    for (glm::ivec2 size : sizes) {
        Image4 position(size.x, size.y);
        const Image4 normal = noise_normals(size.x, size.y, 1);
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x)
                position(x, y) = glm::vec4(2 * (x + 0.5f) / float(size.x) - 1, 0.2f * float((x / 5 + y / 3) % 4) - 0.3f, 2 * (y + 0.5f) / float(size.y) - 1, 0);
        raster::Rsm map = noise_map(24, false);
        map.normal = noise_normals(24, 24, 2);
        for (const bool picture : {false, true})
            for (const direct::ShadowMode mode : {direct::ShadowMode::hard, direct::ShadowMode::density, direct::ShadowMode::pcf})
                for (const direct::ShadowTest test : {direct::ShadowTest::plane, direct::ShadowTest::planes}) {
                    CAPTURE(size.x, size.y, picture, int(mode), int(test));
                    require_same_bits([&](const RunOptions& options, Image4& out) {
                        Buffer<float> visibility(std::size_t(size.x) * size.y, -1.0f);
                        direct::run(direct::ShadowParams{.mode = mode, .test = test},
                                    {&position, &normal, {&map, 1}, nullptr, {}, 0x1p-22f, picture}, options, visibility.data());
                        out = Image4(size.x, size.y);
                        for (std::size_t i = 0; i < out.size(); ++i) {
                            REQUIRE((visibility[i] >= 0 && visibility[i] <= 1));
                            out.texels[i].x = visibility[i];
                        }
                    });
                }
    }
}

TEST_CASE("compose, tonemap: the same bits for every instruction set and thread count", "[compose][bits]") {
    for (glm::ivec2 size : sizes) {
        CAPTURE(size.x, size.y);
        std::vector<Image4> images;
        for (int i = 0; i < 5; ++i) images.push_back(noise_image(size.x, size.y, i, i == 0 ? -1 : 0, 1));
        const compose::ComposeInputs in{&images[0], &images[1], &images[2], &images[3], &images[4], glm::vec3(0.1f)};
        for (const glm::vec3 shadow_color : {glm::vec3(0), glm::vec3(0.25f, 0, 3)})
            require_same_bits([&](const RunOptions& options, Image4& out) {
                compose::run(compose::ComposeParams{shadow_color}, in, options, out);
            });
        for (auto op : {compose::Operator::clamp, compose::Operator::exposure, compose::Operator::reinhard,
                        compose::Operator::filmic})
            for (const auto& params : {compose::TonemapParams{op, 3}, compose::TonemapParams{op, 3, 0.5f, 2.1f, 1.58f}})
                require_same_bits([&](const RunOptions& options, Image4& out) {
                    compose::run(params, compose::TonemapInputs{&images[3]}, options, out);
                });
    }
}

TEST_CASE("a NaN is stored as 7fc00000, whatever its sign and payload were", "[bits]") {
    Image4 radiance(17, 2, glm::vec4(1));
    const std::uint32_t patterns[] = {0x7fc00000, 0xffc00000, 0x7f800001, 0xffffffff};
    for (int i = 0; i < 4; ++i) std::memcpy(&radiance(3 * i, i % 2).y, &patterns[i], 4);
    const Image4 one(17, 2, glm::vec4(1)), zero(17, 2);
    for_all_options([&](const RunOptions& options) {
        Image4 out;
        compose::run(compose::ComposeParams{}, compose::ComposeInputs{&one, &one, &zero, &radiance, &zero, glm::vec3(0)}, options, out);
        for (int i = 0; i < 4; ++i) {
            std::uint32_t bits;
            std::memcpy(&bits, &out(3 * i, i % 2).y, 4);
            CHECK(bits == 0x7fc00000);
        }
    });
}

TEST_CASE("explain: the last value of a gather is the picture's", "[rsm][explain]") {
    const raster::Rsm map = noise_map(24, false);
    Points points(8, 4);
    points.position = noise_image(8, 4, 0, -1.5f, 1.5f);
    points.normal = noise_normals(8, 4, 1);
    for (const rsm::GatherParams& params : gathers()) {
        CAPTURE(int(params.gather), int(params.visibility));
        const rsm::Pattern pattern = rsm::pattern_of(params, map.size, 1);
        const rsm::GatherInputs in{&points.position, &points.normal, &map, &pattern, 1};
        Image4 image;
        rsm::run(params, in, {}, image);
        const std::vector<TapValue> values = rsm::explain(params, in, {5, 2});
        REQUIRE(values.back().name == "irradiance");
        for (int c = 0; c < 3; ++c) CHECK(float(values.back().value[c]) == image(5, 2)[c]);
        // Every sample is told, and the contributions add up: sum of flux * form * weight * visibility, over pi.
        double sum = 0, flux = 0, form = 0, weight = 1, visibility = 1;
        int samples = 0;
        for (const TapValue& v : values) {
            if (v.sample < 0) continue;
            samples = std::max(samples, v.sample + 1);
            if (v.name == "flux") flux = v.value[0];
            if (v.name == "weight") weight = v.value[0];
            if (v.name == "visibility") visibility = v.value[0];
            if (v.name == "form") form = v.value[0], sum += flux * form * weight * visibility;
        }
        CHECK(samples == (params.gather == rsm::Gather::all ? 24 * 24 : rsm::sample_count(params)));
        CHECK(sum / 3.14159265358979 == Approx(image(5, 2).x).epsilon(1e-5));
    }
}
