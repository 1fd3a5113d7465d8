// The data textures of a bake in files, one by one: as arrays of a described file, and as a GPU's raw images.
#include <catch2/catch.hpp>
#include <cstring>

#include "gi/probes/textures.h"
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
        const std::string raw = folder + "/" + info.name + ".raw";
        io::write_file(raw, {{reinterpret_cast<const char*>(array.bytes.data()), array.bytes.size()}});
        io::DumpSpec spec;
        spec.file = raw, spec.vk_format = info.vk_format;
        spec.width = int(array.shape[1]), spec.height = int(array.shape[0]);
        const Array dump = io::read_dump(spec).array;
        const std::size_t texels = std::size_t(array.shape[0] * array.shape[1]), n = std::size_t(array.shape[2]);
        REQUIRE(dump.dtype == info.dtype);
        REQUIRE(std::size_t(dump.shape[0] * dump.shape[1]) == texels);
        const std::size_t channels = std::size_t(dump.shape[2]);
        std::size_t differ = 0;
        for (std::size_t i = 0; i < texels; ++i)
            differ += std::memcmp(dump.bytes.data() + 4 * channels * i, array.bytes.data() + 4 * n * i, 4 * n) != 0;
        CHECK(differ == 0);
    }
    const Bundle all = io::read_described(path, {"probe textures"}).arrays;
    CHECK(content_hash(all_textures(arrays_of(all), layout)) == content_hash(file.arrays));
    CHECK(arrays_of(all).receivers[2].texel == glm::ivec2(2, 5));
}
