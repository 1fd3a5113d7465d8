// Manifests: every key read from TOML and JSON, written and read back, and what is wrong named in one line.
#include <cmath>
#include <limits>

#include "core/hash.h"
#include "files.h"
#include "io/manifest.h"

using namespace plumb;
using namespace plumb::io;

namespace {

const std::string full_toml = R"(device = "A GPU, driver 1.2"
profile = "lavapipe-22.3-fma"
max_ambiguous = 0.01
scene = "scenes/cornell.toml"

[export]
id = "0123456789abcdef"
[export.files]
"a/block.bin" = "00112233445566ff"
"a/out/irradiance.bin" = "ff00112233445566"

[[stage]]
stage = "rsm.disc"
label = "my gather"
form = "bounce 2"
light = "key"
face = "px"
size = [64, 32]
block = "a/block.bin"
[stage.params]
samples = 400
radius = 0.25
variant = "published"
visibility = true
direction = [0, 1, 0.5]
[stage.uniforms]
intensity = [1, 2.5, 3]
count = 400
flag = true
map.to_texel_x = 0.5
"map.to_texel_y" = -0.5
[stage.input.position]
file = "position.raw"
vk_format = "VK_FORMAT_R16G16B16A16_SFLOAT"
width = 64
height = 32
row_pitch = 768
offset = 128
trailing = true
channels = "xyz"
flip_y = true
[stage.input.normal]
file = "gbuffer.exr"
layer = "normal"
channels = "xy"
encoding = "octahedral"
[stage.input.depth]
file = "depth.raw"
vk_format = "D32_SFLOAT"
encoding = "reversed_depth"
near_far = [0.1, inf]
[stage.input.offsets]
file = "offsets.raw"
vk_format = "R32G32_SFLOAT"
count = 100000
[stage.output.irradiance]
file = "out.exr"
expected = "expected.bin"
filling = "ffe1a2b3"
[stage.choices]
file = "choices.npy"
[stage.coverage]
file = "stencil.raw"
vk_format = "R8_UINT"
above = 2
below = 8

[[stage]]
stage = "tonemap"
[stage.uniforms]
file = "block.bin"
[stage.output.display]
file = "display.raw"
vk_format = "R8G8B8A8_UNORM"
width = 16
height = 8
)";

const std::string full_json = R"({
"device": "A GPU, driver 1.2", "profile": "lavapipe-22.3-fma", "max_ambiguous": 0.01, "scene": "scenes/cornell.toml",
"export": {"id": "0123456789abcdef",
           "files": {"a/block.bin": "00112233445566ff", "a/out/irradiance.bin": "ff00112233445566"}},
"stage": [{
  "stage": "rsm.disc", "label": "my gather", "form": "bounce 2", "light": "key", "face": "px", "size": [64, 32],
  "block": "a/block.bin",
  "params": {"samples": 400, "radius": 0.25, "variant": "published", "visibility": true, "direction": [0, 1, 0.5]},
  "uniforms": {"intensity": [1, 2.5, 3], "count": 400, "flag": true, "map": {"to_texel_x": 0.5, "to_texel_y": -0.5}},
  "input": {
    "position": {"file": "position.raw", "vk_format": "R16G16B16A16_SFLOAT", "width": 64, "height": 32,
                 "row_pitch": 768, "offset": 128, "trailing": true, "channels": "xyz", "flip_y": true},
    "normal": {"file": "gbuffer.exr", "layer": "normal", "channels": "xy", "encoding": "octahedral"},
    "depth": {"file": "depth.raw", "vk_format": "D32_SFLOAT", "encoding": "reversed_depth", "near_far": [0.1, "inf"]},
    "offsets": {"file": "offsets.raw", "vk_format": "R32G32_SFLOAT", "count": 100000}},
  "output": {"irradiance": {"file": "out.exr", "expected": "expected.bin", "filling": "ffe1a2b3"}},
  "choices": {"file": "choices.npy"},
  "coverage": {"file": "stencil.raw", "vk_format": "R8_UINT", "above": 2, "below": 8}
}, {
  "stage": "tonemap", "uniforms": {"file": "block.bin"},
  "output": {"display": {"file": "display.raw", "vk_format": "R8G8B8A8_UNORM", "width": 16, "height": 8}}
}]})";

// The shortest manifest, with lines before the stage, of the stage, and of its output.
std::string small(const std::string& top, const std::string& stage = "", const std::string& output = "") {
    return top + "[[stage]]\nstage = \"direct\"\nsize = [4, 2]\n" + stage +
           "[stage.output.irradiance]\nfile = \"a.exr\"\n" + output;
}
// The same with an output of its own words.
std::string of_output(const std::string& output) {
    return "[[stage]]\nstage = \"direct\"\nsize = [4, 2]\n[stage.output.irradiance]\n" + output;
}

void require_equal(const DumpSpec& a, const DumpSpec& b) {
    CHECK(a.file == b.file);
    CHECK(a.vk_format == b.vk_format);
    CHECK(a.width == b.width);
    CHECK(a.height == b.height);
    CHECK(a.count == b.count);
    CHECK(a.row_pitch == b.row_pitch);
    CHECK(a.offset == b.offset);
    CHECK(a.trailing == b.trailing);
    CHECK(a.layer == b.layer);
    CHECK(a.channels == b.channels);
    CHECK(a.encoding == b.encoding);
    CHECK(a.flip_y == b.flip_y);
    CHECK(a.near_far == b.near_far);
    CHECK(a.expected == b.expected);
    CHECK(a.filling == b.filling);
}

void require_equal(const std::map<std::string, DumpSpec>& a, const std::map<std::string, DumpSpec>& b) {
    REQUIRE(a.size() == b.size());
    for (const auto& [name, spec] : a) {
        CAPTURE(name);
        REQUIRE(b.count(name) == 1);
        require_equal(spec, b.at(name));
    }
}

// All but the places.
void require_equal(const Manifest& a, const Manifest& b) {
    CHECK(a.device == b.device);
    CHECK(a.profile == b.profile);
    CHECK(a.subpixel_bits == b.subpixel_bits);
    CHECK(a.max_ambiguous == b.max_ambiguous);
    CHECK(a.scene == b.scene);
    CHECK(a.exported.id == b.exported.id);
    CHECK(a.exported.files == b.exported.files);
    REQUIRE(a.stages.size() == b.stages.size());
    for (std::size_t i = 0; i < a.stages.size(); ++i) {
        const ManifestStage &s = a.stages[i], &t = b.stages[i];
        CHECK(s.stage == t.stage);
        CHECK(s.label == t.label);
        CHECK(s.form == t.form);
        CHECK(s.light == t.light);
        CHECK(s.face == t.face);
        CHECK(s.width == t.width);
        CHECK(s.height == t.height);
        CHECK(s.uniforms == t.uniforms);
        CHECK(s.uniforms_file == t.uniforms_file);
        CHECK(s.block == t.block);
        CHECK(s.params == t.params);
        require_equal(s.inputs, t.inputs);
        require_equal(s.outputs, t.outputs);
        require_equal(s.choices, t.choices);
        require_equal(s.coverage.dump, t.coverage.dump);
        CHECK(s.coverage.above == t.coverage.above);
        CHECK(s.coverage.below == t.coverage.below);
    }
}

// Choices of one generated manifest.
struct Dice {
    std::int32_t state;
    std::uint32_t roll(std::uint32_t n) { return std::uint32_t(state = pcg(state)) % n; }
    template <class T>
    T of(std::initializer_list<T> values) {
        return values.begin()[roll(std::uint32_t(values.size()))];
    }
};

}  // namespace

TEST_CASE("manifest: every key of TOML arrives", "[io][manifest]") {
    const Folder folder;
    const Manifest m = read_manifest(folder.put("m.toml", full_toml));
    CHECK(m.file == folder / "m.toml");
    CHECK(m.device == "A GPU, driver 1.2");
    CHECK(m.profile == "lavapipe-22.3-fma");
    CHECK(m.max_ambiguous == 0.01);
    CHECK(m.scene == folder / "scenes/cornell.toml");
    CHECK(m.exported.id == "0123456789abcdef");
    CHECK(m.exported.files == std::map<std::string, std::string>{{"a/block.bin", "00112233445566ff"},
                                                                 {"a/out/irradiance.bin", "ff00112233445566"}});
    REQUIRE(m.stages.size() == 2);

    const ManifestStage& s = m.stages[0];
    CHECK(s.place == folder / "m.toml" + ": stage 1 (rsm.disc)");
    CHECK(s.stage == "rsm.disc");
    CHECK(s.label == "my gather");
    CHECK(s.form == "bounce 2");
    CHECK(s.light == "key");
    CHECK(s.face == "px");
    CHECK(s.width == 64);
    CHECK(s.height == 32);
    CHECK(s.params == std::map<std::string, std::vector<std::string>>{{"samples", {"400"}},
                                                                      {"radius", {"0.25"}},
                                                                      {"variant", {"published"}},
                                                                      {"visibility", {"true"}},
                                                                      {"direction", {"0", "1", "0.5"}}});
    CHECK(s.uniforms == std::map<std::string, std::vector<double>>{{"intensity", {1, 2.5, 3}},
                                                                   {"count", {400}},
                                                                   {"flag", {1}},
                                                                   {"map.to_texel_x", {0.5}},
                                                                   {"map.to_texel_y", {-0.5}}});
    CHECK(s.uniforms_file.empty());
    REQUIRE(s.inputs.size() == 4);

    const DumpSpec& position = s.inputs.at("position");
    CHECK(position.file == folder / "position.raw");
    CHECK(position.place == folder / "m.toml" + ": line 32: input.position of stage 1 (rsm.disc)");
    CHECK(position.vk_format == "R16G16B16A16_SFLOAT");
    CHECK(position.width == 64);
    CHECK(position.height == 32);
    CHECK(position.row_pitch == 768);
    CHECK(position.offset == 128);
    CHECK(position.trailing);
    CHECK(position.channels == "xyz");
    CHECK(position.encoding == "plain");
    CHECK(position.flip_y);
    CHECK(s.inputs.at("normal").layer == "normal");
    CHECK(s.inputs.at("normal").encoding == "octahedral");
    CHECK(s.inputs.at("normal").width == 0);
    CHECK_FALSE(s.inputs.at("normal").flip_y);
    // A raw image without sides has its stage's.
    CHECK(s.inputs.at("depth").width == 64);
    CHECK(s.inputs.at("depth").height == 32);
    CHECK(s.inputs.at("depth").near_far == std::vector<double>{0.1, std::numeric_limits<double>::infinity()});
    CHECK(s.inputs.at("offsets").count == 100000);
    CHECK(s.inputs.at("offsets").width == 0);
    CHECK(s.outputs.at("irradiance").width == 64);
    CHECK(s.outputs.at("irradiance").expected == folder / "expected.bin");
    CHECK(s.outputs.at("irradiance").filling == 0xffe1a2b3u);
    CHECK(s.block == folder / "a/block.bin");
    CHECK(s.choices.file == folder / "choices.npy");
    CHECK(s.coverage.dump.file == folder / "stencil.raw");
    CHECK(s.coverage.dump.width == 64);
    CHECK(s.coverage.above == 2);
    CHECK(s.coverage.below == 8);

    // A stage without a size has its output's.
    CHECK(m.stages[1].uniforms_file == folder / "block.bin");
    CHECK(m.stages[1].width == 16);
    CHECK(m.stages[1].height == 8);
    CHECK(m.stages[1].choices.file.empty());
}

TEST_CASE("manifest: JSON of the same structure is the same manifest", "[io][manifest]") {
    const Folder folder;
    const Manifest toml = read_manifest(folder.put("m.toml", full_toml));
    const Manifest json = read_manifest(folder.put("m.json", full_json));
    require_equal(toml, json);
    CHECK(json.stages[0].inputs.at("depth").place ==
          folder / "m.json" + ": /stage/0/input/depth: input.depth of stage 1 (rsm.disc)");
}

TEST_CASE("manifest: what is left out has its default", "[io][manifest]") {
    const Folder folder;
    const Manifest m = read_manifest(folder.put("m", small("")));  // any name but .json is TOML
    CHECK(m.device == "");
    CHECK(m.profile == "ideal");
    CHECK(m.subpixel_bits == 0);
    CHECK(m.stages.at(0).coverage.dump.file.empty());
    CHECK(m.max_ambiguous == 0.005);
    CHECK(m.scene.empty());
    CHECK(m.stages.at(0).inputs.empty());
    CHECK(m.exported.id == "");
    CHECK_FALSE(m.stages.at(0).outputs.at("irradiance").filling);
    CHECK(m.stages.at(0).outputs.at("irradiance").expected.empty());
    // The same stage may come twice: two frames, two of its dispatches.
    CHECK(read_manifest(folder.put("m", small("") + small(""))).stages.size() == 2);
}

TEST_CASE("manifest: coverage is above 0, or above and below what is said", "[io][manifest]") {
    const Folder folder;
    const auto limits = [&](const std::string& lines) {
        const std::string text = small("") + "[stage.coverage]\nfile = \"a.exr\"\n" + lines;
        const CoverageSpec coverage = read_manifest(folder.put("m.toml", text)).stages.at(0).coverage;
        return std::pair(coverage.above, coverage.below);
    };
    constexpr double inf = std::numeric_limits<double>::infinity();
    CHECK(limits("") == std::pair(0.0, inf));
    CHECK(limits("above = -1\n") == std::pair(-1.0, inf));
    // Of a depth buffer that was cleared to 1, which covers what lies at 0, too.
    CHECK(limits("below = 1\n") == std::pair(-inf, 1.0));
    CHECK(limits("above = 0\nbelow = 1\n") == std::pair(0.0, 1.0));
    require_message(error_of([&] { limits("above = 1\nbelow = 1\n"); }), {"coverage", "below = 1", "more than above"});
}

TEST_CASE("manifest: what an export wrote is named inside of its folder, with hashes", "[io][manifest]") {
    const Folder folder;
    const auto refused = [&](const std::string& lines, const std::string& output, std::initializer_list<const char*> words) {
        const std::string text = small(lines.empty() ? "" : "[export]\n" + lines, "", output);
        const std::string error = error_of([&] { read_manifest(folder.put("m.toml", text)); });
        for (const char* word : words) CHECK_THAT(error, Catch::Contains(word));
    };
    const std::string id = "id = \"0123456789abcdef\"\n";
    refused("files = {}\n", "", {"id", "16 hexadecimal digits"});
    refused("id = \"0123456789ABCDEF\"\n", "", {"id", "16 hexadecimal digits"});
    refused(id + "fils = {}\n", "", {"fils", "files"});
    for (const char* name : {"../a.bin", "/etc/a.bin", "a/../../b.bin", "", ".."})
        refused(id + "files = { \"" + name + "\" = \"0123456789abcdef\" }\n", "", {"in the folder of the manifest"});
    refused(id + "files = { a = \"0123\" }\n", "", {"a = ", "hash"});
    for (const char* word : {"ffe1a2b", "7fc00000", "ffe00000", "ffffffff", "ffe1a2b3f", "gfe1a2b3"})
        refused("", "filling = \"" + std::string(word) + "\"\n", {"filling", "ffe00001 to fffffffe"});
    // Of outputs alone.
    const std::string input = small("") + "[stage.input.x]\nfile = \"b.exr\"\nfilling = \"ffe1a2b3\"\n";
    CHECK_THAT(error_of([&] { read_manifest(folder.put("m.toml", input)); }), Catch::Contains("filling"));
}

TEST_CASE("manifest: an absolute name stays, a relative one is seen from the manifest", "[io][manifest]") {
    const Folder folder;
    const std::string text = of_output("file = \"/dumps/a.exr\"\n[stage.input.x]\nfile = \"../b.exr\"\n");
    const Manifest m = read_manifest(folder.put("m.toml", text));
    CHECK(m.stages[0].outputs.at("irradiance").file == "/dumps/a.exr");
    CHECK(m.stages[0].inputs.at("x").file == folder / "../b.exr");
    const std::string written = manifest_text(m);
    CHECK_THAT(written, Catch::Contains("\"/dumps/a.exr\""));
}

TEST_CASE("manifest: the text of a manifest reads back as it was", "[io][manifest]") {
    const Folder folder;
    const Manifest first = read_manifest(folder.put("m.toml", full_toml));
    require_equal(first, read_manifest(folder.put("n.toml", manifest_text(first))));
}

TEST_CASE("manifest: generated manifests come back from their text", "[io][manifest][property]") {
    const Folder folder;
    const std::initializer_list<std::string> names = {
        "a",         "rsm.key.position",     "two words", "quote\"d",    "back\\slash",
        "tab\there", "\xc3\xa4\xe2\x82\xac", "=",         "line\nbreak", "1"};
    const std::initializer_list<double> numbers = {0.0,
                                                   -0.0,
                                                   1,
                                                   -3,
                                                   0.1,
                                                   1e-300,
                                                   1.7976931348623157e308,
                                                   4294967295.0,
                                                   9007199254740993.0,
                                                   1e15,
                                                   1e16,
                                                   123456789012345678.0,
                                                   5e-324};
    const std::initializer_list<std::string> words = {
        "disc", "400",  "0.25", "true",     "1e3", "007",   "+1",    "inf",
        "nan",  "0x10", "-0.5", "quote\"d", "",    "1_000", "false", "99999999999999999999"};
    for (std::int32_t seed = 0; seed < 400; ++seed) {
        Dice dice{seed * 7919 + 1};
        Manifest m;
        m.file = folder / "g.toml";
        const auto file = [&] {
            return std::filesystem::path(dice.roll(3) ? folder / dice.of(names) : "/elsewhere/" + dice.of(names));
        };
        const auto spec = [&](bool is_output, const ManifestStage& stage) {
            DumpSpec d;
            d.file = file();
            if (is_output) d.width = stage.width, d.height = stage.height;
            if (dice.roll(2)) {
                d.vk_format =
                    dice.of<std::string>({"R32G32B32A32_SFLOAT", "R16G16B16A16_SNORM", "A2B10G10R10_UNORM_PACK32"});
                if (!is_output && dice.roll(3) == 0)
                    d.count = 1 + int(dice.roll(1000000));
                else
                    d.width = stage.width, d.height = stage.height,
                    d.row_pitch = dice.roll(2) ? 16 * d.width + int(dice.roll(99)) : 0;
                if (dice.roll(2)) d.offset = dice.of<std::int64_t>({1, 4096, std::int64_t(1) << 62});
                d.trailing = dice.roll(2);
            } else if (dice.roll(3) == 0) {
                d.layer = dice.of(names);
            }
            if (d.count == 0) d.flip_y = dice.roll(2);
            if (dice.roll(4) == 0) {
                d.encoding = dice.of<std::string>({"depth", "reversed_depth", "depth_gl"});
                d.near_far = {0.1, dice.of<double>({100, std::numeric_limits<double>::infinity()})};
            } else if (dice.roll(3) == 0) {
                d.encoding = "octahedral_unorm", d.channels = dice.of<std::string>({"", "xy", "ba"});
            } else {
                d.channels = dice.of<std::string>({"", "xyz", "w", "bgr", "xy0", "xy_1"});
            }
            return d;
        };
        m.device = dice.of(names);
        m.profile = dice.of(names);
        if (dice.roll(3) == 0) m.profile = "ideal", m.subpixel_bits = int(dice.roll(17));
        m.max_ambiguous = dice.of<double>({0, 1, 0.005, 1e-9});
        if (dice.roll(2)) m.scene = file();
        for (std::uint32_t i = 0; i < 1 + dice.roll(3); ++i) {
            ManifestStage stage;
            stage.stage = dice.of(names);
            if (dice.roll(2)) stage.label = dice.of(names), stage.light = dice.of(names), stage.face = "nz";
            if (dice.roll(2)) stage.form = dice.of(names);
            stage.width = 1 + int(dice.roll(32767)), stage.height = 1 + int(dice.roll(32767));
            for (std::uint32_t k = dice.roll(4); k > 0; --k)
                for (std::uint32_t n = 1 + dice.roll(4); n > 0; --n)
                    stage.params[dice.of(names)].push_back(dice.of(words));
            for (auto& [key, values] : stage.params) values.resize(std::min<std::size_t>(values.size(), 16));
            if (dice.roll(3) == 0)
                stage.uniforms_file = file();
            else
                for (std::uint32_t k = dice.roll(4); k > 0; --k)
                    stage.uniforms[dice.of(names)] = {dice.of(numbers), dice.of(numbers)};
            for (std::uint32_t k = dice.roll(4); k > 0; --k) stage.inputs[dice.of(names)] = spec(false, stage);
            for (std::uint32_t k = 1 + dice.roll(2); k > 0; --k) stage.outputs[dice.of(names)] = spec(true, stage);
            if (dice.roll(2)) stage.choices.file = file();
            if (dice.roll(2)) stage.coverage.dump = spec(false, stage);
            if (dice.roll(2) && !stage.coverage.dump.file.empty()) {
                stage.coverage.above = dice.of<double>({0, -1, 0.5, 7});
                if (dice.roll(2)) stage.coverage.below = dice.of<double>({8, 1e9});
            }
            m.stages.push_back(stage);
        }
        const std::string text = manifest_text(m);
        INFO(text);
        const Manifest back = read_manifest(folder.put("g.toml", text));
        require_equal(m, back);
        REQUIRE(manifest_text(back) == text);
    }
}

TEST_CASE("manifest: what is wrong is named in one line", "[io][manifest][robustness]") {
    const Folder folder;
    const std::string raw = "file = \"a.raw\"\nvk_format = \"R32_SFLOAT\"\n";
    const std::vector<std::pair<std::string, std::vector<std::string>>> cases = {
        {"", {"names no stage", "[[stage]]"}},
        {"device = 3\n", {"line 1", "device = 3", "expected a string"}},
        {"device = \n", {"line 1"}},
        {small("subpixel_bits = 17\n"), {"subpixel_bits = 17", "expected 1 to 16"}},
        {small("profile = \"swiftshader\"\nsubpixel_bits = 4\n"), {"subpixel_bits = 4", "swiftshader", "its own"}},
        // A typo is named before what is missing because of it.
        {"[[stage]]\nstage = \"direct\"\nsise = [4, 2]\n[stage.output.a]\nfile = \"a\"\nvk_format = \"R8_UNORM\"\n",
         {"line 3", "'sise'", "'size'"}},
        {"[[stage]]\nstag = \"direct\"\n", {"'stag'", "'stage'"}},
        {small("", "", "abov = 1\n"), {"'abov'"}},
        {"[[stage]\n", {"line 1"}},
        {"stage = 1\n", {"line 1", "stage = 1", "[[stage]]"}},
        {"[stage]\nstage = \"direct\"\n", {"line 1", "list of tables"}},
        {"stage = [1]\n", {"list of tables"}},
        {"stage = []\n", {"names no stage"}},
        {small("profil = \"ideal\"\n"), {"line 1", "unknown key 'profil'", "'profile'"}},
        {small("profile = \"\"\n"), {"line 1", "profile = \"\"", "not empty"}},
        {small("max_ambiguous = 1.5\n"), {"line 1", "max_ambiguous = 1.5", "0 to 1"}},
        {small("max_ambiguous = nan\n"), {"line 1", "0 to 1"}},
        {small("max_ambiguous = -inf\n"), {"line 1", "0 to 1"}},
        {small("scene = \"\"\n"), {"line 1", "scene", "not empty"}},
        {small("scene = 2020-01-01\n"), {"line 1", "scene", "expected a string"}},
        {"[[stage]]\n[stage.output.x]\nfile = \"a\"\n", {"line 1", "stage 1", "stage: is missing"}},
        {"[[stage]]\nstage = \"\"\n", {"line 2", "stage 1", "not empty"}},
        {"[[stage]]\nstage = \"direct\"\n", {"stage 1 (direct)", "output", "at least one"}},
        {"[[stage]]\nstage = \"direct\"\n[stage.output]\n", {"line 3", "stage 1 (direct)", "output", "at least one"}},
        {small("", "sise = [4, 2]\n"), {"line 4", "stage 1 (direct)", "unknown key 'sise'", "'size'"}},
        {small("", "face = \"up\"\n"), {"line 4", "face = \"up\"", "px, nx, py"}},
        {small("", "light = 1\n"), {"line 4", "light = 1", "expected a string"}},
        {small("", "output = 1\n"), {"line 6"}},
        {"[[stage]]\nstage = \"direct\"\nsize = 4\n", {"line 3", "size = 4", "[width, height]", "32767"}},
        {"[[stage]]\nstage = \"direct\"\nsize = [4]\n", {"line 3", "size = a list of 1", "[width, height]"}},
        {"[[stage]]\nstage = \"direct\"\nsize = [0, 2]\n", {"line 3", "size", "1 to 32767"}},
        {"[[stage]]\nstage = \"direct\"\nsize = [4, 32768]\n", {"line 3", "size", "1 to 32767"}},
        {"[[stage]]\nstage = \"direct\"\nsize = [4.5, 2]\n", {"line 3", "size", "1 to 32767"}},
        {"[[stage]]\nstage = \"direct\"\nsize = [9999999999999999999, 2]\n", {"line 3"}},
        {small("", "params = 3\n"), {"line 4", "params = 3", "expected a table"}},
        {small("", "[stage.params]\nsamples = []\n"), {"line 5", "params of stage 1 (direct)", "samples", "1 to 16"}},
        {small("", "[stage.params]\nsamples = [nan]\n"), {"line 5", "samples", "finite"}},
        {small("", "[stage.params]\nsamples = {a = 1}\n"), {"line 5", "samples = a table", "expected a number"}},
        {small("", "[stage.uniforms]\nradius = inf\n"),
         {"line 5", "uniforms of stage 1 (direct)", "radius = inf", "finite"}},
        {small("", "[stage.uniforms]\nradius = \"1\"\n"), {"line 5", "radius = \"1\"", "expected a finite number"}},
        {small("", "[stage.uniforms]\nradius = []\n"), {"line 5", "radius", "1 to 16 numbers"}},
        {small("", "[stage.uniforms]\nm.x = 1\n\"m.x\" = 2\n"), {"m.x", "given twice"}},
        {small("", "[stage.uniforms]\nfile = \"b.bin\"\nradius = 1\n"), {"line 5", "file = \"b.bin\"", "whole block"}},
        {small("", "[stage.uniforms]\nfile = \"\"\n"), {"line 5", "file = \"\"", "not empty"}},
        {small("", "[stage.input]\nposition = \"a.exr\"\n"),
         {"line 5", "input of stage 1 (direct)", "position = \"a.exr\"", "expected a table"}},
        {small("", "[stage.input.position]\nlayer = \"p\"\n"),
         {"line 4", "input.position of stage 1 (direct)", "file: is missing"}},
        {small("", "[stage.choices]\nfil = \"p\"\n"), {"line 5", "choices of stage 1 (direct)", "'fil'"}},
        {of_output("file = \"\"\n"), {"line 5", "output.irradiance of stage 1 (direct)", "file = \"\"", "not empty"}},
        {of_output("file = \"a.exr\"\nlayr = \"x\"\n"), {"line 6", "unknown key 'layr'", "'layer'"}},
        {of_output("file = \"a.exr\"\nfile = \"b.exr\"\n"), {"line 6"}},
        {small("") + "[stage.output.irradiance]\nfile = \"b.exr\"\n", {"line 6"}},  // two outputs of one name
        {of_output("file = \"a.raw\"\nvk_format = \"R32_FLOAT\"\n"),
         {"line 6", "vk_format = \"R32_FLOAT\"", "nearest", "'R32_SFLOAT'"}},
        {of_output("file = \"a.raw\"\nvk_format = \"VK_FORMAT_BC1_RGB_UNORM_BLOCK\"\n"), {"line 6", "unknown format"}},
        {of_output(raw + "width = 0\nheight = 2\n"), {"line 7", "width = 0", "1 to 32767"}},
        {of_output(raw + "width = 32768\nheight = 2\n"), {"line 7", "width = 32768", "1 to 32767"}},
        {of_output(raw + "width = 4\n"), {"height: is missing"}},
        {of_output(raw + "width = 5\nheight = 2\n"), {"line 7", "width = 5", "5 x 2", "4 x 2"}},
        {of_output(raw + "row_pitch = 15\n"), {"line 7", "row_pitch = 15", "4 texels of R32_SFLOAT take 16 bytes"}},
        {of_output(raw + "row_pitch = -16\n"), {"line 7", "row_pitch = -16"}},
        {of_output(raw + "row_pitch = 1.5\n"), {"line 7", "row_pitch = 1.5", "expected an integer"}},
        {of_output(raw + "offset = -1\n"), {"line 7", "offset = -1"}},
        {of_output(raw + "offset = 1e300\n"), {"line 7", "offset", "expected an integer"}},
        {of_output(raw + "trailing = 1\n"), {"line 7", "trailing = 1", "true or false"}},
        {of_output(raw + "layer = \"a\"\n"), {"line 7", "layer = \"a\"", "raw files have none"}},
        {of_output(raw + "flip_y = \"yes\"\n"), {"line 7", "flip_y = \"yes\"", "true or false"}},
        {of_output(raw + "channels = \"xy\"\n"), {"line 7", "channels = \"xy\"", "R32_SFLOAT has 1 channel"}},
        {of_output(raw + "channels = \"\"\n"), {"line 7", "channels", "not empty"}},
        {of_output(raw + "channels = \"xq\"\n"), {"line 7", "channels = \"xq\"", "x y z w"}},
        {of_output(raw + "channels = \"xxxxx\"\n"), {"line 7", "channels", "1 to 4"}},
        {of_output(raw + "channels = \"__\"\n"), {"line 7", "channels", "no component"}},
        {of_output(raw + "encoding = \"octahedrl\"\n"),
         {"line 7", "encoding = \"octahedrl\"", "nearest", "'octahedral'"}},
        {of_output(raw + "encoding = \"integer\"\n"), {"line 7", "encoding", "does not hold integers"}},
        {of_output(raw + "encoding = \"depth\"\n"), {"near_far: is missing", "depth needs [near, far]"}},
        {of_output(raw + "near_far = [1, 2]\n"), {"line 7", "near_far", "without an encoding of depth"}},
        {of_output(raw + "encoding = \"depth\"\nnear_far = [2, 1]\n"), {"line 8", "near_far", "0 < near < far"}},
        {of_output(raw + "encoding = \"depth\"\nnear_far = [0, 1]\n"), {"line 8", "near_far", "0 < near < far"}},
        {of_output(raw + "encoding = \"depth\"\nnear_far = [1]\n"), {"line 8", "near_far", "[near, far]"}},
        {of_output(raw + "encoding = \"depth\"\nnear_far = [nan, 1]\n"), {"line 8", "near_far", "0 < near < far"}},
        {of_output(raw + "encoding = \"depth\"\nnear_far = \"far\"\n"),
         {"line 8", "near_far = \"far\"", "[near, far]"}},
        {of_output("file = \"a.raw\"\nvk_format = \"R8G8B8A8_SRGB\"\nencoding = \"srgb\"\n"),
         {"line 7", "decoded already"}},
        {of_output("file = \"a.raw\"\nvk_format = \"R32G32_UINT\"\nencoding = \"octahedral\"\n"),
         {"line 7", "integers"}},
        {of_output("file = \"a.raw\"\nvk_format = \"R8G8B8A8_UNORM\"\nencoding = \"octahedral\"\nchannels = \"xyz\"\n"),
         {"line 8", "expected 2"}},
        {of_output("file = \"a.raw\"\nvk_format = \"R8G8B8A8_UNORM\"\nencoding = \"octahedral\"\nchannels = \"x0\"\n"),
         {"line 8", "own channels"}},
        {of_output("file = \"a.exr\"\nrow_pitch = 64\n"), {"line 6", "row_pitch = 64", "only raw files"}},
        {of_output("file = \"a.exr\"\noffset = 64\n"), {"line 6", "offset = 64", "only raw files"}},
        {small("", "[stage.input.x]\n" + raw + "count = 8\nwidth = 4\nheight = 2\n"),
         {"line 7", "count = 8", "buffer"}},
        {"[[stage]]\nstage = \"direct\"\n[stage.output.x]\n" + raw, {"width: expected at least 1", "both sides"}},
        {std::string("\xff\xfe\0a", 4), {"line 1"}},
        {"device = \"\xff\"\n", {"line 1"}},
        {"a = " + std::string(100000, '['), {"nested deeper"}},
        {std::string(100, '\n') + "x" + std::string(50, '.') + "y = 1\n", {}},
    };
    for (const auto& [text, parts] : cases) {
        CAPTURE(text.substr(0, 300));
        std::vector<std::string> all = parts;
        all.push_back(folder / "bad.toml");
        const std::string path = folder.put("bad.toml", text);
        require_message(error_of([&] { read_manifest(path); }), all);
    }
    CHECK(cases.size() >= 60);
}

TEST_CASE("manifest: JSON that is wrong is named by its place", "[io][manifest][robustness]") {
    const Folder folder;
    const auto stage = [](const std::string& keys) { return "{\"stage\": [{\"stage\": \"direct\", " + keys + "}]}"; };
    const std::vector<std::pair<std::string, std::vector<std::string>>> cases = {
        {"", {}},
        {"[]", {"expected an object"}},
        {"3", {"expected an object"}},
        {"{\"stage\": [", {"byte"}},
        {"{\"stage\": [], \"stage\": []}", {"\"stage\" twice"}},
        {"{\"stage\": {}}", {"/stage", "list of tables"}},
        {"{\"device\": null, \"stage\": []}", {"/device", "expected a string"}},
        {"{\"devise\": \"\", \"stage\": []}", {"/devise", "unknown key 'devise'", "'device'"}},
        {"{\"stage\": " + std::string(100000, '['), {"nested deeper"}},
        {stage("\"output\": {\"a\": {\"file\": \"x\"}, \"a\": {\"file\": \"y\"}}"), {"\"a\" twice"}},
        {stage("\"output\": {\"a\": {\"file\": 3}}"), {"/stage/0/output/a/file", "file = 3", "expected a string"}},
        {stage("\"output\": {\"a\": []}"), {"/stage/0/output/a", "expected a table"}},
        {stage("\"output\": {\"\": {\"file\": \"x\"}}"), {"/stage/0/output", "expected a table"}},
        {stage("\"size\": [1e99, 1]"), {"/stage/0/size", "1 to 32767"}},
        {stage("\"uniforms\": {\"a\": 1e999}"), {"1e999"}},
        {stage("\"uniforms\": {\"a\": null}"), {"/stage/0/uniforms/a", "expected a finite number"}},
    };
    for (const auto& [text, parts] : cases) {
        CAPTURE(text.substr(0, 300));
        std::vector<std::string> all = parts;
        all.push_back(folder / "bad.json");
        const std::string path = folder.put("bad.json", text);
        require_message(error_of([&] { read_manifest(path); }), all);
    }
}

TEST_CASE("manifest: missing files and folders are named", "[io][manifest][robustness]") {
    const Folder folder;
    require_message(error_of([&] { read_manifest(folder / "none.toml"); }), {"none.toml", "cannot be read"});
    std::filesystem::create_directory(folder / "sub.toml");
    require_message(error_of([&] { read_manifest(folder / "sub.toml"); }), {"sub.toml", "not a regular file"});
    require_message(error_of([&] { read_manifest(std::string("a\0b", 3)); }), {"NUL"});
}

TEST_CASE("manifest: damaged text is refused or read, never worse", "[io][manifest][robustness]") {
    const Folder folder;
    load_damaged(folder, "d.toml", full_toml, [](const std::string& path) { read_manifest(path); });
    load_damaged(folder, "d.json", full_json, [](const std::string& path) { read_manifest(path); });
}

TEST_CASE("manifest: what an input goes through once it is decoded", "[io][manifest]") {
    const Folder folder;
    const auto input = [&](const std::string& lines) {
        return read_manifest(folder.put("m.toml", small("") + "[stage.input.normal]\nfile = \"n.exr\"\n" + lines));
    };
    const std::string rows = "[[1, 2, 3, 4], [5, 6, 7, 8], [9, 10, 11, 12], [13, 14, 15, 16]]";
    const std::string columns = "[1, 5, 9, 13, 2, 6, 10, 14, 3, 7, 11, 15, 4, 8, 12, 16]";
    const MatrixRows numbers = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16};
    const std::string lines = "normalized = true\nscale = 2\nmatrix = { columns = " + columns +
                              ", of = \"directions\" }\nfactor = \"a.png\"\n" +
                              "from_depth = { inverse_view_proj = { rows = " + rows +
                              " }, clip_depth = [-1, 1], reversed_z = true, y = \"up\" }\n";
    const Manifest m = input(lines);
    const DumpSpec& spec = m.stages.at(0).inputs.at("normal");
    CHECK(spec.normalized);
    CHECK(spec.scale == std::vector<double>{2});
    REQUIRE(spec.matrix);
    CHECK(spec.matrix->rows == numbers);
    CHECK(spec.matrix->of == "directions");
    REQUIRE(spec.from_depth);
    CHECK(spec.from_depth->matrix == numbers);
    CHECK(spec.from_depth->below_zero);
    CHECK(spec.from_depth->reversed_z);
    CHECK(spec.from_depth->y_up);
    REQUIRE(spec.factors.size() == 1);
    CHECK(spec.factors[0].file == folder / "a.png");
    // Written and read back it is the same; left out it is nothing.
    const std::string text = manifest_text(m);
    CHECK(manifest_text(read_manifest(folder.put("m.toml", text))) == text);
    CHECK_THAT(text, Catch::Matchers::Contains("[[stage.input.normal.factor]]") &&
                         Catch::Matchers::Contains("of = \"directions\"") && Catch::Matchers::Contains("y = \"up\""));
    const Manifest without = input("");
    const DumpSpec& plain = without.stages.at(0).inputs.at("normal");
    CHECK_FALSE((plain.normalized || plain.matrix || plain.from_depth));
    CHECK((plain.scale.empty() && plain.factors.empty()));
    // Factors of one's own format are as large as what they multiply.
    const Manifest two = input("vk_format = \"R8G8B8_UNORM\"\nwidth = 5\nheight = 7\nscale = [1, 2, 3]\n"
                               "factor = [{ file = \"a.raw\", vk_format = \"R8_UNORM\" }, \"b.png\"]\n");
    const DumpSpec& many = two.stages.at(0).inputs.at("normal");
    REQUIRE(many.factors.size() == 2);
    CHECK(many.factors[0].width == 5);
    CHECK(many.factors[0].height == 7);
    CHECK(many.scale == std::vector<double>{1, 2, 3});

    const std::vector<std::pair<std::string, std::string>> faults = {
        {"normalized = 1\n", "normalized = 1: expected true or false"},
        {"matrix = { rows = [1, 2, 3] }\n", "rows = a list of 3: expected 16 numbers, 3 given"},
        {"matrix = {}\n", "rows: expected 16 numbers row by row as rows, or column by column as columns"},
        {"matrix = { rows = " + columns + ", columns = " + columns + " }\n", "one of both"},
        {"matrix = { rows = " + columns + ", of = \"colours\" }\n", "expected points, normals, directions"},
        {"matrix = { rows = " + columns + ", of = \"\" }\n", "expected points, normals, directions"},
        {"matrix = [1, 0]\n", "expected a table"},
        {"scale = [1, 2]\n", "scale = a list of 2: expected a number, or one for each of x, y, z"},
        {"scale = \"2\"\n", "expected finite numbers"},
        {"scale = inf\n", "expected finite numbers"},
        {"factor = 2\n", "factor = 2: expected the name of a file, or a table with the key \"file\""},
        {"factor = []\n", "factor = a list of 0: expected at least one"},
        {"factor = { file = \"a.png\", normalized = true }\n", "unknown key 'normalized'"},
        {"from_depth = {}\n", "inverse_view_proj: is missing"},
        {"from_depth = { inverse_view_proj = { rows = " + rows + " }, clip_depth = [0, 2] }\n", "expected [0, 1] or [-1, 1]"},
        {"from_depth = { inverse_view_proj = { rows = " + rows + " }, y = \"left\" }\n", "expected down, up"},
        {"from_depth = { inverse_view_proj = { rows = " + rows + " } }\nencoding = \"depth\"\nnear_far = [1, 2]\n",
         "from_depth = a table: takes the depth buffer as it is; expected the encoding plain, not depth"},
        {"normalized = true\nvk_format = \"R32_SFLOAT\"\ncount = 4\n", "are of images of floats"},
    };
    for (const auto& [fault, message] : faults) {
        INFO(fault);
        CHECK_THROWS_WITH(input(fault), Catch::Matchers::Contains(message) && Catch::Matchers::Contains("m.toml: line ") &&
                                            Catch::Matchers::Contains("input.normal of stage 1"));
    }
    // An output is judged as it was stored.
    CHECK_THROWS_WITH(read_manifest(folder.put("m.toml", small("", "", "normalized = true\n"))),
                      Catch::Matchers::Contains("unknown key 'normalized'"));
}
