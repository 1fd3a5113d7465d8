// One list of fields serves the command line, scene files, std140 blocks, `plumb stages` and validation.
#include <catch2/catch.hpp>
#include <cstring>

#include "core/error.h"
#include "core/fields.h"
#include "core/nearest_known.h"
#include "core/stage.h"

using namespace plumb;

namespace {

enum class Kind : int { one, two };

struct Params {
    int count = 4;
    float radius = 0.5f;
    glm::vec3 colour{1, 2, 3};
    bool on = true;
    Kind kind = Kind::two;
    std::string file;
};

std::vector<Field> fields(Params& p) {
    return {
        {"count", &p.count, "", "how many", 1, 100},
        {"radius", &p.radius, "m", "how far", 0, 2},
        {"colour", &p.colour, "", "which", 0, 10},
        {"on", &p.on, "", "whether"},
        {"kind", as_int(p.kind), "", "which of two", 0, 1, {"one", "two"}},
        {"file", &p.file, "", "from where"},
    };
}

// The message of the error that f throws.
template <class Body>
std::string message(Body f) {
    try {
        f();
    } catch (const InputError& e) {
        return e.what();
    }
    return "no error";
}

void set(Params& p, const std::string& name, const FieldValue& value) {
    std::vector<Field> list = fields(p);
    set_field(find_field(list, name, "scene.toml: line 7"), value, "scene.toml: line 7");
}

}  // namespace

TEST_CASE("fields: values are set by name and checked against type and range", "[fields]") {
    Params p;
    set(p, "count", 7.0);
    set(p, "radius", 1.25);
    set(p, "colour", glm::vec3(3, 4, 5));
    set(p, "on", false);
    set(p, "kind", std::string("one"));
    set(p, "file", std::string("a.npy"));
    CHECK(p.count == 7);
    CHECK(p.radius == 1.25f);
    CHECK(p.colour == glm::vec3(3, 4, 5));
    CHECK_FALSE(p.on);
    CHECK(p.kind == Kind::one);
    CHECK(p.file == "a.npy");

    const double nan = std::numeric_limits<double>::quiet_NaN();
    CHECK(message([&] { set(p, "count", 7.5); }) == "scene.toml: line 7: count = 7.5: expected 1 to 100");
    CHECK(message([&] { set(p, "count", 0.0); }) == "scene.toml: line 7: count = 0: expected 1 to 100");
    CHECK(message([&] { set(p, "radius", 2.5); }) == "scene.toml: line 7: radius = 2.5: expected 0 to 2 m");
    CHECK(message([&] { set(p, "radius", nan); }) == "scene.toml: line 7: radius = nan: expected 0 to 2 m");
    CHECK(message([&] { set(p, "radius", std::string("far")); }) ==
          "scene.toml: line 7: radius = \"far\": expected 0 to 2 m");
    CHECK(message([&] { set(p, "on", 1.0); }) == "scene.toml: line 7: on = 1: expected true or false");
    CHECK(message([&] { set(p, "kind", std::string("three")); }) ==
          "scene.toml: line 7: kind = \"three\": expected one of one, two");
    CHECK(message([&] { set(p, "colour", glm::vec3(1, 11, 1)); }) ==
          "scene.toml: line 7: colour = [1, 11, 1]: expected 0 to 10");
    CHECK(message([&] { set(p, "raduis", 1.0); }) ==
          "scene.toml: line 7: unknown key 'raduis'; the nearest known one is 'radius'");
    CHECK(p.count == 7);
    CHECK(p.radius == 1.25f);
}

TEST_CASE("fields: validation names stage, field, value and range", "[fields]") {
    Params p;
    validate_fields("stage", fields(p));
    p.radius = std::numeric_limits<float>::quiet_NaN();
    CHECK(message([&] { validate_fields("stage", fields(p)); }) == "stage: radius = nan: expected 0 to 2 m");
    p.radius = std::numeric_limits<float>::infinity();
    CHECK(message([&] { validate_fields("stage", fields(p)); }) == "stage: radius = inf: expected 0 to 2 m");
    p.radius = 1;
    p.kind = Kind(2);
    CHECK(message([&] { validate_fields("stage", fields(p)); }) == "stage: kind = 2: expected one of one, two");
}

TEST_CASE("fields: std140 aligns a vec3 to 16 bytes and packs a scalar behind it", "[fields][std140]") {
    // OpenGL 4.6 specification, 7.6.2.2: scalars 4, vec3 16 with size 12; the block ends on a multiple of 16.
    Params p;
    const std::vector<int> offsets = std140_offsets(fields(p));
    CHECK(offsets == std::vector<int>{0, 4, 16, 28, 32, 48});
    const std::vector<unsigned char> block = std140_block(fields(p));
    REQUIRE(block.size() == 48);
    float colour[3];
    std::memcpy(colour, block.data() + 16, 12);
    CHECK(colour[2] == 3);
    std::uint32_t on, kind;
    std::memcpy(&on, block.data() + 28, 4);
    std::memcpy(&kind, block.data() + 32, 4);
    CHECK(on == 1);
    CHECK(kind == 1);
}

TEST_CASE("fields: the nearest name has the smallest edit distance", "[fields]") {
    CHECK(nearest_name("sampels", {"radius", "samples", "seed"}) == "samples");
    CHECK(nearest_name("x", {}) == "");
    // Damerau: an exchange of neighbours is one edit, as a character put in is; so the exchange is not two behind one.
    CHECK(nearest_name("rms", {"rmxx", "rsm"}) == "rsm");
    CHECK(nearest_name("RSM", {"rs", "rsm"}) == "rsm");
}

TEST_CASE("fields: the nearest known one is named where it is near, else what there is", "[fields]") {
    const auto near = [](const std::string& name) { return "; the nearest known one is '" + name + "'"; };
    CHECK(nearest_known("sampels", {"radius", "samples", "seed"}) == near("samples"));
    CHECK(nearest_known("nosuch", {"rsm", "isr"}) == "; known: rsm, isr");
    CHECK(nearest_known("x", {}) == "");
    CHECK(nearest_known("", {"rsm"}) == "; known: rsm");

    // At most a third of the longer name, and 1 in names of two characters; a name of one has nothing that is kept.
    CHECK(nearest_known("abcdef", {"abxxef"}) == near("abxxef"));
    CHECK(nearest_known("abcdef", {"axxxef"}) == "; known: axxxef");
    CHECK(nearest_known("abcde", {"axxde"}) == "; known: axxde");
    CHECK(nearest_known("ab", {"ax"}) == near("ax"));
    CHECK(nearest_known("a", {"b"}) == "; known: b");
    CHECK(nearest_known("ROUGHNESS", {"roughness"}) == near("roughness"));

    // One begins with the other; of those the nearest. A single character begins too much.
    CHECK(nearest_known("rsm", {"shadow", "rsm.disc_continuous", "rsm.disc"}) == near("rsm.disc"));
    CHECK(nearest_known("rsm.disc.key", {"rsm", "gbuffer"}) == near("rsm"));
    CHECK(nearest_known("r", {"radius", "gbuffer"}) == "; known: radius, gbuffer");

    CHECK(nearest_known("wite", {"white"}, "\"\"") == "; the nearest known one is \"white\"");
    CHECK(nearest_known("rms", {"rsm"}, "[]") == "; the nearest known one is [rsm]");
}

TEST_CASE("fields: a list of known names says each once, the nearest dozen, and how many more", "[fields]") {
    CHECK(nearest_known("qqqq", {"b", "a", "b", "", "two words"}) == "; known: b, a, \"\", \"two words\"");
    std::vector<std::string> names;
    for (char c = 'a'; c <= 'l'; ++c) names.push_back(std::string(9, c));
    CHECK_THAT(nearest_known("qqqq", names), Catch::EndsWith(", kkkkkkkkk, lllllllll"));
    names.push_back("qq......");
    names.push_back(std::string(9, 'm'));
    const std::string text = nearest_known("qqqq", names);
    CHECK_THAT(text, Catch::StartsWith("; known: qq......, aaaaaaaaa, ") &&
                         Catch::EndsWith(", kkkkkkkkk and 2 more"));
    CHECK(nearest_known("q", {std::string(61, 'a')}) == "; known: " + std::string(60, 'a') + "...");
}

TEST_CASE("stage: parameters are described with default and range", "[fields][stage]") {
    Params p;
    const std::vector<ParamInfo> rows = describe(fields(p));
    CHECK(rows[0].default_value == "4");
    CHECK(rows[0].range == "1..100");
    CHECK(rows[4].default_value == "\"two\"");
    CHECK(rows[4].range == "one | two");
    CHECK(rows[4].type == "choice");
}
