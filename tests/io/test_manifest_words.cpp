// Manifests: words for a shader's samplers, patterns and matrices, and for components out of several files.
#include <catch2/catch.hpp>

#include "core/error.h"
#include "io/manifest.h"
#include "files.h"

using namespace plumb;
using namespace plumb::io;
using Catch::Matchers::Contains;

namespace {

Manifest read_input(const Folder& folder, const std::string& input, const std::string& lines) {
    return read_manifest(folder.put("m.toml", "[[stage]]\nstage = \"direct\"\nsize = [4, 2]\n[stage.output.irradiance]\nfile = "
                                              "\"a.exr\"\n[stage.input." + input + "]\nfile = \"n.exr\"\n" + lines));
}

}  // namespace

TEST_CASE("manifest: samplers, patterns, a fourth component, and a matrix to invert", "[io][manifest]") {
    const Folder folder;
    const auto spec_of = [&](const std::string& input, const std::string& lines) {
        const Manifest m = read_input(folder, input, lines);
        // Written and read back it is the same.
        const std::string text = manifest_text(m);
        INFO(text);
        CHECK(manifest_text(read_manifest(folder.put("back.toml", text))) == text);
        return read_manifest(folder / "back.toml").stages.at(0).inputs.at(input);
    };
    const DumpSpec none = spec_of("rsm_flux", "");
    CHECK_FALSE(none.sampler);
    CHECK(none.w.empty());
    const DumpSpec edge = spec_of("rsm_flux", "filter = \"linear\"\naddress = \"edge\"\n");
    REQUIRE(edge.sampler);
    CHECK(edge.sampler->linear);
    CHECK(edge.sampler->address == SamplerSpec::edge);
    const DumpSpec border = spec_of("rsm_flux", "border = [1, 2, 3, 4]\n");
    CHECK_FALSE(border.sampler->linear);
    CHECK(border.sampler->address == SamplerSpec::border);
    CHECK(border.sampler->colour == std::array<double, 4>{1, 2, 3, 4});
    CHECK(spec_of("rsm_flux", "address = \"wrap\"\n").sampler->address == SamplerSpec::wrap);

    CHECK(spec_of("rsm_position", "along_normal = -0.25\n").along_normal == -0.25);
    CHECK(spec_of("pattern", "beyond = \"skip\"\n").skips_beyond);
    CHECK_FALSE(spec_of("pattern", "beyond = \"read\"\n").skips_beyond);

    const DumpSpec pattern = spec_of("pattern", "y = \"up\"\ntile = [4, 2]\nunit = \"map\"\n");
    CHECK(pattern.y_up);
    CHECK(pattern.tile == std::array{4, 2});
    CHECK(spec_of("pattern", "").tile == std::array{0, 0});

    const DumpSpec with = spec_of("position", "vk_format = \"R32G32B32_SFLOAT\"\nwidth = 5\nheight = 3\n[stage.input.position.w]\n"
                                              "file = \"depth.raw\"\nvk_format = \"D16_UNORM\"\nencoding = \"depth\"\nnear_far = [1, 2]\n");
    REQUIRE(with.w.size() == 1);
    CHECK(with.w[0].width == 5);
    CHECK(with.w[0].height == 3);
    CHECK(with.w[0].encoding == "depth");

    const MatrixRows twice = {2, 0, 0, 1, 0, 4, 0, 0, 0, 0, 8, 0, 0, 0, 0, 1}, half = {0.5, 0, 0, -0.5, 0, 0.25, 0, 0,
                                                                                         0, 0, 0.125, 0, 0, 0, 0, 1};
    const DumpSpec depth = spec_of("position", "from_depth = { view_proj = { rows = [2,0,0,1, 0,4,0,0, 0,0,8,0, 0,0,0,1] } }\n");
    CHECK(depth.from_depth->forward);
    CHECK(depth.from_depth->matrix == twice);
    CHECK(inverse_of(twice) == half);

    const std::string rows = "{ rows = [2,0,0,1, 0,4,0,0, 0,0,8,0, 0,0,0,1] }";
    const std::vector<std::array<std::string, 3>> faults = {
        {"position", "from_depth = { view_proj = { rows = [1,0,0,0, 0,0,0,0, 0,0,1,0, 0,0,0,1] } }\n", "has no inverse"},
        {"position", "from_depth = { view_proj = " + rows + ", inverse_view_proj = " + rows + " }\n", "not both"},
        {"rsm_flux", "filter = \"cubic\"\n", "expected nearest, linear"},
        {"rsm_flux", "border = [1, 2]\n", "expected four numbers"},
        {"position", "w = [\"a.exr\", \"b.exr\"]\n", "expected one image"},
        {"position", "tile = [4, 4]\n", "unknown key 'tile'"},
        {"pattern", "tile = [4]\n", "expected [width, height] in pixels, each 1 to 256"},
        {"pattern", "y = \"left\"\n", "expected down, up"},
        {"pattern", "filter = \"linear\"\n", "unknown key 'filter'"},
        {"rsm_position", "along_normal = \"n\"\n", "along_normal"},
        {"position", "clamp = [0, 1]\n", "unknown key 'clamp'"},
        {"pattern", "beyond = \"wrap\"\n", "expected read, skip"}};
    for (const auto& [input, lines, message] : faults) {
        INFO(lines);
        CHECK_THROWS_WITH(read_input(folder, input, lines), Contains(message) && Contains("m.toml: line "));
    }
}

TEST_CASE("manifest: what a shader does with a result before it writes it", "[io][manifest]") {
    const Folder folder;
    const auto spec_of = [&](const std::string& lines) {
        const Manifest m = read_manifest(folder.put("m.toml", "[[stage]]\nstage = \"direct\"\nsize = [4, 2]\n[stage.output.irradiance]\n"
                                                              "file = \"a.exr\"\n" + lines));
        const std::string text = manifest_text(m);
        INFO(text);
        CHECK(manifest_text(read_manifest(folder.put("back.toml", text))) == text);
        return read_manifest(folder / "back.toml").stages.at(0).outputs.at("irradiance");
    };
    CHECK(spec_of("").clamp.empty());
    const DumpSpec all = spec_of("scale = [1, 2, 3]\nclamp = [0, 1]\nfactor = [\"b.exr\", { file = \"c.raw\", vk_format = \"R8_UNORM\" }]\n");
    CHECK(all.scale == std::vector<double>{1, 2, 3});
    CHECK(all.clamp == std::vector<double>{0, 1});
    REQUIRE(all.factors.size() == 2);
    CHECK(all.factors[1].vk_format == "R8_UNORM");
    for (const char* lines : {"clamp = 1\n", "clamp = [1, 1]\n", "clamp = [0, 1, 2]\n", "scale = [1, 2]\n", "factor = []\n"})
        CHECK_THROWS_WITH(spec_of(lines), Contains("expected"));
}
