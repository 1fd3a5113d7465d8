// The data textures of a bake in files, one by one: as arrays of a described file, and as a GPU's raw images.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "core/error.h"
#include "gi/probes/directions.h"
#include "gi/probes/lambda.h"
#include "gi/probes/texture_rays.h"
#include "io/described_file.h"
#include "io/file.h"
#include "io/manifest.h"

using namespace plumb;
using namespace plumb::probes;

namespace {

BakeArrays sample() {
    BakeArrays a;
    a.rays = 2, a.coefficients = 1, a.singular_values = 2;
    a.probes = {{1, 2, 3}};
    a.relight = {{4, {0.25f, 0.5f}, {7, 8, 9}}, {-1, {0.75f, 1}, {0, 0, 0}}};
    a.sh = {0.5f, 0.25f};
    a.clusters = {{{0}, 1, {0.125f}, {0, 0, 0}, {1, 1, 1}}};
    for (int i = 0; i < 3; ++i) a.receivers.push_back({{float(i), 1, 2}, {i, 5}, i, 15, i == 2 ? -1 : 0});
    a.u = {1, 2, 3, 4, 5, 6};
    return a;
}

// Written as an image's bytes, and read back as a dump of a GPU's image.
Array dumped(const std::string& folder, const TextureInfo& info, const Array& array) {
    const std::string raw = folder + "/" + info.name + ".raw";
    io::write_file(raw, {{reinterpret_cast<const char*>(array.bytes.data()), array.bytes.size()}});
    io::DumpSpec spec;
    spec.file = raw, spec.vk_format = info.vk_format;
    spec.width = int(array.shape[1]), spec.height = int(array.shape[0]);
    const Array dump = io::read_dump(spec).array;
    REQUIRE((dump.dtype == info.dtype && dump.shape[0] == array.shape[0] && dump.shape[1] == array.shape[1]));
    const std::size_t texels = std::size_t(array.shape[0] * array.shape[1]), n = std::size_t(array.shape[2]), channels = std::size_t(dump.shape[2]);
    Bundle one;
    Array& back = add(one, info.name, dump.dtype, array.shape);
    for (std::size_t i = 0; i < texels; ++i)
        std::memcpy(back.bytes.data() + 4 * n * i, dump.bytes.data() + 4 * channels * i, 4 * n);
    return std::move(one.arrays[0]);
}

}  // namespace

TEST_CASE("probe textures: in files, one by one", "[probes][io]") {
    const std::string folder = PLUMB_BINARY_DIR "/probe_textures", path = folder + "/textures.bake";
    io::make_folder(folder);
    const TextureLayout layout{.clusters_in_row = 128, .receivers_in_row = 2};
    io::DescribedFile file;
    file.kind = "probe textures";
    file.arrays = all_textures(sample(), layout);
    for (const TextureInfo& info : textures())
        file.descriptions.push_back({info.unit, info.meaning, {"row", "column", "channel"}});
    io::write_described(path, file);

    io::MappedFile mapped(path, {"probe textures"});
    for (const TextureInfo& info : textures()) {
        CAPTURE(info.name);
        const Array array = mapped.array(info.name);
        CHECK(content_hash(array) == content_hash(texture(info.name, sample(), layout)));

        // Its bytes are those of an image of its format: read as such a dump, they are its values.
        CHECK(content_hash(dumped(folder, info, array)) == content_hash(array));
    }
    const Bundle all = io::read_described(path, {"probe textures"}).arrays;
    CHECK(content_hash(all_textures(arrays_of(all), layout)) == content_hash(file.arrays));
    CHECK(arrays_of(all).receivers[2].texel == glm::ivec2(2, 5));
}

// What probes.lambda reads: harmonics and weights follow from the dumped texture, or it is refused.
TEST_CASE("probe textures: lambda from dumped files, and from none with one number changed", "[probes][io][lambda]") {
    const std::string folder = PLUMB_BINARY_DIR "/probe_textures_lambda";
    io::make_folder(folder);
    const int rays = 32, coefficients = 9;
    const Buffer<glm::vec4> directions = relight_directions(rays);
    const Buffer<float> harmonics = harmonics_of(directions, 2), weights = level_weights(directions, {rays});
    BakeArrays a = sample();
    a.rays = rays, a.coefficients = coefficients;
    a.sh.assign(harmonics.begin(), harmonics.end());
    a.relight.assign(std::size_t(rays), {0, {0.5f, 0.25f}, {1, 2, 3}});
    a.clusters[0].sigma_vt.assign(std::size_t(coefficients), 0.5f);
    const auto lambda = [&](const Buffer<float>& table, const Buffer<float>& of_rays) {
        Buffer<glm::vec4> radiance, out;
        for (int r = 0; r < rays; ++r) radiance.emplace_back(float(r), 1 / float(r + 1), 3, 0);
        const std::vector<std::int32_t> level = {0};
        LambdaInputs in;
        in.probes = 1, in.rays = rays, in.coefficients = coefficients, in.level_rays = {rays}, in.level_coefficients = {coefficients};
        in.radiance = &radiance, in.harmonics = &table, in.weights = &of_rays, in.probe_level = &level;
        probes::run(in, {}, out);
        return out;
    };
    Bundle dumps;
    for (const TextureInfo& info : textures()) dumps.arrays.push_back(dumped(folder, info, texture(info.name, a)));
    const RayTables tables = ray_tables(arrays_of(dumps), {rays});
    const Buffer<glm::vec4> expected = lambda(harmonics, weights), got = lambda(tables.harmonics, tables.weights);
    REQUIRE(got.size() == expected.size());
    CHECK(std::memcmp(got.data(), expected.data(), got.size() * sizeof got[0]) == 0);
    // Of equal weights: 4 pi / 32 times 0 + 1 + ... + 31 times Y_0.
    CHECK(expected[0].x == Approx(4 * 3.14159 / 32 * 496 * 0.28209).epsilon(0.1));

    // Coefficient 3 of ray 7 lies at texel 7, 3.
    Array& table = *std::find_if(dumps.arrays.begin(), dumps.arrays.end(), [](const Array& t) { return t.name == "spherical_harmonics"; });
    float* number = reinterpret_cast<float*>(table.bytes.data()) + 3 * rays + 7;
    CHECK(*number == harmonics[7 * 9 + 3]);
    *number = std::nextafter(*number, 2.0f);
    CHECK_THROWS_WITH(ray_tables(arrays_of(dumps), {rays}), Catch::StartsWith("spherical_harmonics: texel 7, 3 is"));
}
