// Maps of radiance: [environment] file.
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "files.h"
#include "io/image_file.h"
#include "io/scene_file.h"

using namespace plumb;
using namespace plumb::io;

namespace {

// A 16 x 8 sky whose texel (x, y) is (x, y, x y) / 7 W/(m2 sr).
std::vector<float> sky() {
    std::vector<float> values;
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 16; ++x)
            for (int n : {x, y, x * y}) values.push_back(float(n) / 7);
    return values;
}

std::string floats(const std::vector<float>& values) {
    return std::string(reinterpret_cast<const char*>(values.data()), values.size() * 4);
}

struct Skies {
    Folder folder;
    Skies() { folder.put("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"); }
    std::string put_exr(const std::string& name, int width, int height, const std::vector<std::string>& components,
                        const std::vector<float>& values) const {
        write_exr(folder / name, width, height, {{"color", components, values.data(), int(components.size())}});
        return folder / name;
    }
    Scene load(const std::string& environment) const {
        return load_scene(folder.put("s.toml", "[[mesh]]\nfile = \"m.obj\"\n[environment]\n" + environment), {});
    }
    std::string error(const std::string& environment) const {
        return error_of([&] { load(environment); });
    }
};

}  // namespace

TEST_CASE("environment: an EXR arrives bit for bit, its top row first, and its factor is 1", "[io]") {
    const Skies skies;
    const std::vector<float> values = sky();
    skies.put_exr("sky.exr", 16, 8, {"R", "G", "B"}, values);
    const Scene s = skies.load("file = \"sky.exr\"\n");
    CHECK(s.environment.radiance == glm::vec3(1));
    REQUIRE((s.environment.map.width == 16 && s.environment.map.height == 8));
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 16; ++x) {
            const float* v = values.data() + 3 * (16 * y + x);
            CHECK(s.environment.map(x, y) == glm::vec4(v[0], v[1], v[2], 0));
        }
    for (const std::string& note : s.notes) CHECK_THAT(note, !Catch::Contains("stretched"));
    // The factor stays a factor: the map keeps its values.
    const Scene twice = skies.load("file = \"sky.exr\"\nradiance = [2, 0, 0.5]\n");
    CHECK(twice.environment.radiance == glm::vec3(2, 0, 0.5f));
    CHECK(twice.environment.map(15, 7) == s.environment.map(15, 7));
}

TEST_CASE("environment: PFM, HDR, grey, alpha and layers", "[io]") {
    const Skies skies;
    // PFM's first row is the lowest.
    skies.folder.put("sky.pfm", "PF\n1 2\n-1\n" + floats({4, 5, 6, 1, 2, 3}));
    const Image4 pfm = skies.load("file = \"sky.pfm\"\n").environment.map;
    CHECK(pfm(0, 0) == glm::vec4(1, 2, 3, 0));
    CHECK(pfm(0, 1) == glm::vec4(4, 5, 6, 0));
    skies.folder.put("grey.pfm", "Pf\n2 1\n-1\n" + floats({0.1f, 7}));
    CHECK(skies.load("file = \"grey.pfm\"\n").environment.map(1, 0) == glm::vec4(7, 7, 7, 0));
    // RGBE holds a mantissa of 8 bits for the largest: eighths of 1 are exact (Ward 1991).
    const std::string hdr = skies.folder / "sky.hdr";
    const std::vector<float> eighths = {1, 0.5f, 0.125f, 64, 32, 0};
    const auto output = OIIO::ImageOutput::create(hdr);
    REQUIRE(output);
    REQUIRE(output->open(hdr, OIIO::ImageSpec(2, 1, 3, OIIO::TypeDesc::FLOAT)));
    REQUIRE(output->write_image(OIIO::TypeDesc::FLOAT, eighths.data()));
    REQUIRE(output->close());
    const Image4 read = skies.load("file = \"sky.hdr\"\n").environment.map;
    CHECK(read(0, 0) == glm::vec4(1, 0.5f, 0.125f, 0));
    CHECK(read(1, 0) == glm::vec4(64, 32, 0, 0));
    // Alpha is left aside, whatever it holds; so are the other layers of a rendered picture.
    skies.put_exr("rgba.exr", 1, 1, {"R", "G", "B", "A"}, {1, 2, 3, NAN});
    CHECK(skies.load("file = \"rgba.exr\"\n").environment.map(0, 0) == glm::vec4(1, 2, 3, 0));
    const float colour[] = {1, 2, 3, 0}, normal[] = {-1, NAN, 0};
    write_exr(skies.folder / "layers.exr", 1, 1,
              {{"color", {"R", "G", "B"}, colour}, {"normal", {"X", "Y", "Z"}, normal}});
    CHECK(skies.load("file = \"layers.exr\"\n").environment.map(0, 0) == glm::vec4(1, 2, 3, 0));
}

TEST_CASE("environment: a map of another shape is stretched, and its size is said", "[io]") {
    const Skies skies;
    skies.put_exr("square.exr", 3, 3, {"Y"}, std::vector<float>(9, 1.0f));
    const Scene s = skies.load("file = \"square.exr\"\n");
    bool said = false;
    for (const std::string& note : s.notes)
        said |= note == "the sky \"square.exr\" has 3 x 3 texels, not 2 : 1: it is stretched";
    CHECK(said);
}

TEST_CASE("environment: the filter of a map is nearest unless it is asked for, and is said", "[io]") {
    const Skies skies;
    skies.put_exr("sky.exr", 16, 8, {"R", "G", "B"}, sky());
    const auto says = [](const Scene& s, const std::string& text) {
        return std::count(s.notes.begin(), s.notes.end(), "the sky's 16 x 8 texels are " + text) == 1;
    };
    const Scene plain = skies.load("file = \"sky.exr\"\n"), nearest = skies.load("file = \"sky.exr\"\nfilter = \"nearest\"\n"),
                bilinear = skies.load("file = \"sky.exr\"\nfilter = \"bilinear\"\n");
    CHECK(plain.environment.filter == Filter::nearest);
    CHECK(nearest.environment.filter == Filter::nearest);
    CHECK(bilinear.environment.filter == Filter::bilinear);
    CHECK(says(plain, "patches of constant radiance; [environment] filter = \"bilinear\" interpolates"));
    CHECK(says(bilinear, "interpolated"));
    require_message(skies.error("file = \"sky.exr\"\nfilter = \"linear\"\n"), {"s.toml: line 5: [environment] filter"});
    require_message(skies.error("radiance = 1\nfilter = \"nearest\"\n"),
                    {"s.toml: line 5: [environment] filter", "stands without a file"});
}

TEST_CASE("environment: what is no radiance is refused with its pixel", "[io][robustness]") {
    const Skies skies;
    const float inf = std::numeric_limits<float>::infinity();
    const std::vector<std::pair<float, std::string>> bad = {
        {NAN, "nan"}, {-NAN, "-nan"}, {inf, "inf"}, {-inf, "-inf"}, {-1e-30f, "-1e-30"}};
    for (const auto& [value, text] : bad) {
        std::vector<float> values = sky();
        values[3 * (16 * 5 + 9) + 1] = value;  // green of column 9, row 5
        skies.put_exr("sky.exr", 16, 8, {"R", "G", "B"}, values);
        require_message(skies.error("file = \"sky.exr\"\n"),
                        {"s.toml: line 4: [environment] file = \"sky.exr\": ",
                         "sky.exr: pixel 9,5: G = " + text + "; a radiance is finite and not negative"});
    }
    // The product is one too.
    skies.put_exr("sky.exr", 1, 1, {"Y"}, {1e30f});
    require_message(skies.error("file = \"sky.exr\"\nradiance = [0, 1e9, 0]\n"),
                    {"s.toml: line 5: [environment] radiance = an array of 3: times 1e+30 of the map is not finite"});
    CHECK(skies.error("file = \"sky.exr\"\nradiance = 1e8\n") == "");
}

TEST_CASE("environment: files that are no maps are refused with one line", "[io][robustness]") {
    const Skies skies;
    require_message(skies.error("file = \"\"\n"), {"s.toml: line 4: [environment] file = \"\": "});
    require_message(skies.error("file = \"none.exr\"\n"), {"line 4: ", "none.exr: cannot be read: No such file"});
    require_message(skies.error("file = \"m.obj\"\n"), {"m.obj: holds no radiance by its name; expected .exr, .hdr"});
    skies.folder.put("text.exr", "not a picture");
    require_message(skies.error("file = \"text.exr\"\n"), {"text.exr: byte 0: does not begin as a .exr file does"});
    skies.put_exr("xyz.exr", 1, 1, {"X", "Y", "Z"}, {1, 2, 3});
    require_message(skies.error("file = \"xyz.exr\"\n"), {"xyz.exr: header: has no channel R; expected R, G and B"});
    const float value = 1;
    write_exr(skies.folder / "layer.exr", 1, 1, {{"normal", {"X"}, &value, 1}});
    require_message(skies.error("file = \"layer.exr\"\n"), {"layer.exr: has no layer \"\"; known: normal"});

    // A part of a larger picture would be stretched over all directions, a shifted one would turn.
    for (const glm::ivec4& whole : {glm::ivec4(0, 0, 3, 1), glm::ivec4(-1, 0, 2, 1), glm::ivec4(0, 0, 2, 2),
                                    glm::ivec4(0, -1, 2, 1)}) {
        OIIO::ImageSpec part(2, 1, 1, OIIO::TypeDesc::FLOAT);
        part.full_x = whole.x, part.full_y = whole.y, part.full_width = whole.z, part.full_height = whole.w;
        const std::string path = skies.folder / "part.exr";
        const std::vector<float> values(2, 1.0f);
        const auto output = OIIO::ImageOutput::create(path);
        REQUIRE(output);
        REQUIRE(output->open(path, part));
        REQUIRE(output->write_image(OIIO::TypeDesc::FLOAT, values.data()));
        REQUIRE(output->close());
        require_message(skies.error("file = \"part.exr\"\n"), {"part.exr: header: only a part of the picture"});
    }
}

TEST_CASE("environment: a huge map is refused from its header, before memory is taken", "[io][robustness]") {
    const Skies skies;
    // 2^27 texels are the limit. What is at it is asked next whether the file can hold it.
    skies.folder.put("huge.pfm", "Pf\n16384 8193\n-1\n");
    require_message(skies.error("file = \"huge.pfm\"\n"),
                    {"huge.pfm: header: 16384 x 8193 pixels; the limit here is 134217728"});
    skies.folder.put("huge.pfm", "Pf\n16384 8192\n-1\n");
    require_message(skies.error("file = \"huge.pfm\"\n"),
                    {"huge.pfm: header: declares 16384 x 8192 pixels of 1 channels, which", "cannot hold"});
}

TEST_CASE("environment: cut off or changed at any byte, a map loads or is refused", "[io][robustness]") {
    const Skies skies;
    const std::vector<float> values = sky();
    const auto bytes = read_bytes(skies.put_exr("sky.exr", 4, 2, {"R", "G", "B"}, values));
    const std::string content(bytes.begin(), bytes.end());
    load_damaged(skies.folder, "sky.exr", content, [](const std::string& path) {
        for (const glm::vec4& texel : read_radiance_map(path).texels)
            REQUIRE((texel.x >= 0 && texel.x <= std::numeric_limits<float>::max()));
    });
}
