// plumb lightmap: files, bits, a map's check, refusals.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>

#include "core/isa.h"
#include "io/image_file.h"
#include "tests/program/program.h"

using namespace plumb;
using namespace plumb::program;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

const Words few = {"--samples", "64", "--set", "probes.lightmap_size=64"};

Words lightmap(const std::string& scene, Words more, const Words& settings = few) {
    Words all = {"lightmap", scene};
    all.insert(all.end(), more.begin(), more.end());
    all.insert(all.end(), settings.begin(), settings.end());
    return all;
}

Result succeed(const Words& words) {
    const Result r = run(words);
    CAPTURE(r.err, r.out);
    REQUIRE(r.exit == 0);
    REQUIRE(r.err.empty());
    return r;
}

std::string refused(const Words& words) {
    const Result r = run(words);
    INFO(r.out << r.err);
    CHECK(r.exit == 2);
    CHECK(r.out.empty());
    CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
    return r.err;
}

// The same scene with other random numbers.
std::string reseeded(const std::string& scene) {
    const std::string other = scene.substr(0, scene.size() - 5) + "_seed.toml";
    std::string text = read(scene);
    const std::size_t at = text.find("seed = ");
    if (at == std::string::npos)
        text = "seed = 77\n" + text;
    else
        text.replace(at, text.find('\n', at) - at, "seed = 77");
    write(other, text);
    return other;
}

std::string base64(const std::string& bytes) {
    const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t bits = 0;
        for (std::size_t k = 0; k < 3; ++k) bits = bits << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
        for (std::size_t k = 0; k < 4; ++k) out += i + k > bytes.size() ? '=' : digits[bits >> (18 - 6 * k) & 63];
    }
    return out;
}

// A floor "floor" and a wall "wall" of 2 m x 2 m that meet along an edge, of one buffer. First coordinates: both the whole
// square. Second, where `second` says: the floor on the left half, the wall on the right one, with a gap.
std::string corner_scene(const std::string& folder, bool second, const std::string& name = "corner") {
    const std::vector<float> floor_positions = {0, 0, 0, 0, 0, 2, 2, 0, 2, 2, 0, 0}, wall_positions = {0, 0, 0, 2, 0, 0, 2, 2, 0, 0, 2, 0},
                             up = {0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0}, front = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1},
                             first = {0, 0, 0, 1, 1, 1, 1, 0}, left = {0.05f, 0.05f, 0.05f, 0.45f, 0.45f, 0.45f, 0.45f, 0.05f},
                             right = {0.55f, 0.45f, 0.95f, 0.45f, 0.95f, 0.05f, 0.55f, 0.05f};
    std::string bytes;
    Json views = Json::array(), accessors = Json::array();
    const auto add = [&](const void* data, std::size_t size, int component, const char* type, int count) {
        views.push_back({{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", size}});
        accessors.push_back({{"bufferView", int(views.size()) - 1}, {"componentType", component}, {"type", type}, {"count", count}});
        bytes.append(static_cast<const char*>(data), size);
        return int(accessors.size()) - 1;
    };
    const auto floats = [&](const std::vector<float>& v, const char* type) { return add(v.data(), 4 * v.size(), 5126, type, 4); };
    const std::vector<std::uint32_t> corners = {0, 1, 2, 0, 2, 3};
    const int indices = add(corners.data(), 24, 5125, "SCALAR", 6);
    Json meshes = Json::array(), nodes = Json::array();
    const auto mesh = [&](const char* its_name, const std::vector<float>& p, const std::vector<float>& n, const std::vector<float>& uv) {
        Json attributes = {{"POSITION", floats(p, "VEC3")}, {"NORMAL", floats(n, "VEC3")}, {"TEXCOORD_0", floats(first, "VEC2")}};
        if (second) attributes["TEXCOORD_1"] = floats(uv, "VEC2");
        meshes.push_back({{"name", its_name}, {"primitives", {{{"attributes", attributes}, {"indices", indices}}}}});
        nodes.push_back({{"mesh", int(meshes.size()) - 1}, {"name", its_name}});
    };
    mesh("floor", floor_positions, up, left), mesh("wall", wall_positions, front, right);
    const Json gltf = {{"asset", {{"version", "2.0"}}}, {"meshes", meshes}, {"nodes", nodes}, {"bufferViews", views}, {"accessors", accessors},
                       {"buffers", {{{"byteLength", bytes.size()}, {"uri", "data:application/octet-stream;base64," + base64(bytes)}}}}};
    write(folder + "/" + name + ".gltf", gltf.dump());
    write(folder + "/" + name + ".toml", "[[mesh]]\nfile = \"" + name + ".gltf\"\n[[light]]\nname = \"lamp\"\ntype = \"point\"\n"
                                         "position = [1.3, 1.1, 1.2]\nintensity = [4, 4, 4]\n");
    return folder + "/" + name + ".toml";
}

const Words own = {"--samples", "16", "--part", "direct"};  // of one lamp: no noise

compare::Picture picture_of(const std::string& file) { return io::read_picture(file); }

}  // namespace

TEST_CASE("lightmap: the same bytes for every instruction set and number of threads, with unit and error", "[program][bits]") {
    const std::string folder = fresh_folder("lightmap"), scene = small_scene(folder);
    const Result first = succeed(lightmap(scene, {"-o", folder + "/a.exr", "--error", folder + "/e.exr", "--threads", "1", "--isa", "scalar"}));
    CHECK_THAT(first.out, Contains("W/m2") && Contains("64 x 64 texels") && Contains("64 paths a receiver"));
    for (const Isa isa : supported_isas()) {
        succeed(lightmap(scene, {"-o", folder + "/b.exr", "--error", folder + "/f.exr", "--isa", isa_name(isa), "--threads", "3"}));
        CHECK(read(folder + "/b.exr") == read(folder + "/a.exr"));
        CHECK(read(folder + "/f.exr") == read(folder + "/e.exr"));
    }
    CHECK_THAT(read(folder + "/a.exr").substr(0, 2000), Contains("unit") && Contains("W/m2") && Contains("irradiance"));
    const compare::Picture map = picture_of(folder + "/a.exr"), error = picture_of(folder + "/e.exr");
    CHECK(map.channels == std::vector<std::string>{"R", "G", "B"});
    CHECK((map.width == 64 && map.height == 64));
    CHECK(std::count_if(map.data.begin(), map.data.end(), [](float v) { return v > 0; }) > 3000);
    CHECK(std::count_if(error.data.begin(), error.data.end(), [](float v) { return v > 0; }) > 3000);
    // The parts add up, within what their errors say of the mean.
    const auto mean = [&](const char* part) {
        return Json::parse(succeed(lightmap(scene, {"-o", folder + "/p.exr", "--part", part, "--json"})).out)["mean"][0].get<double>();
    };
    const double all = mean("all");
    CHECK(mean("direct") + mean("indirect") == Approx(all).epsilon(0.02));
    CHECK(mean("one_bounce") < mean("indirect"));
    const Json fine = Json::parse(succeed({"lightmap", scene, "-o", folder + "/u.exr", "--set", "probes.lightmap_size=32", "--until-error", "0.05", "--json"}).out);
    CHECK(fine["relative_error"].get<double>() <= 0.0502);
    CHECK(fine["samples"].get<int>() % 128 == 0);
    CHECK(fine["unit"] == "W/m2");
}

TEST_CASE("lightmap: a map that it made passes its own check, with other random numbers", "[program]") {
    const std::string folder = fresh_folder("lightmap_own"), scene = small_scene(folder), other = reseeded(scene);
    succeed(lightmap(scene, {"-o", folder + "/a.exr", "--error", folder + "/e.exr"}));
    const Words bounds = {"--uv", "atlas", "--check", folder + "/a.exr", "--map-error", folder + "/e.exr", "--max-leaks", "0", "--max-seam", "0.05",
                          "--max-error", "0.05", "-o", folder + "/report", "--html", folder + "/report.html"};
    const Result text = succeed(lightmap(other, bounds));
    CHECK_THAT(text.out, Contains("agree: within the bounds") && Contains("0 of ") && Contains("standard error"));
    for (const char* name : {"error.png", "error.scene.png", "seams.png", "leaks.png", "truth.png", "map.png", "check.exr", "README.txt"})
        CHECK(fs::exists(folder + "/report/" + name));
    CHECK_THAT(read(folder + "/report.html"), Contains("seams") && Contains("data:image/png"));
    CHECK(io::layer_names(picture_of(folder + "/report/check.exr")) == std::vector<std::string>{"difference", "error", "map", "truth"});
    Words words = lightmap(other, bounds);
    words.push_back("--json");
    const Json json = Json::parse(succeed(words).out);
    CHECK(json["agree"] == true);
    CHECK(json["leaks"]["texels"] == 0);
    CHECK(json["seams"]["off"] == 0);
    CHECK(json["charts"]["off"].empty());
    CHECK(json["told"]["share"].get<double>() < 0.01);
    // Its own seed draws other numbers for the check: noise is never held against itself.
    const Json own = Json::parse(succeed(lightmap(scene, {"--uv", "atlas", "--check", folder + "/a.exr", "--json"})).out);
    CHECK(own["errors"]["bias"].get<double>() != 0);
    // Few paths tell nothing of a right map, and call it neither right nor wrong; a wrong one they still tell.
    for (const char* samples : {"2", "3", "4", "8", "16"}) {
        const Words few_paths = {"--samples", samples, "--set", "probes.lightmap_size=64"};
        const Words asked = {"--uv", "atlas", "--check", folder + "/a.exr", "--map-error", folder + "/e.exr", "--max-error", "0.02", "--max-leaks", "0"};
        const Result r = run(lightmap(other, asked, few_paths));
        CAPTURE(samples, r.out);
        CHECK(r.exit == 1);
        CHECK_THAT(r.out, Contains("\ncannot tell: ") && !Contains("disagree"));
    }
    const Result wrong = run(lightmap(other, {"--uv", "atlas", "--check", folder + "/a.exr", "--scale", "0.1", "--max-error", "0.05"},
                                      {"--samples", "16", "--set", "probes.lightmap_size=64"}));
    CHECK_THAT(wrong.out, Contains("disagree: relative RMS error"));
    // Held against a tenth of its light it fails, and the better scale is told.
    const Result dim = run(lightmap(other, {"--uv", "atlas", "--check", folder + "/a.exr", "--scale", "0.1", "--max-error", "0.05"}));
    CHECK(dim.exit == 1);
    CHECK_THAT(dim.out, Contains("disagree: relative RMS error") && Contains("another --scale"));
    CHECK(run(lightmap(other, {"--uv", "atlas", "--check", folder + "/a.exr", "--scale", "0.1"})).exit == 0);
}

TEST_CASE("lightmap: the second set of coordinates is where a user's map lies", "[program]") {
    const std::string folder = fresh_folder("lightmap_second"), scene = corner_scene(folder, true), other = reseeded(scene);
    succeed(lightmap(scene, {"--uv", "1", "--size", "40x40", "-o", folder + "/a.exr"}, own));
    const Json clean = Json::parse(succeed(lightmap(other, {"--check", folder + "/a.exr", "--max-seam", "0.1", "--max-leaks", "0", "--json"}, own)).out);
    CHECK(clean["uv"] == "1");
    CHECK(clean["charts"]["count"] == 2);
    CHECK(clean["seams"]["edges"] == 1);
    // The floor's half is the left one; a tenth brighter it is named, by its mesh.
    compare::Picture map = picture_of(folder + "/a.exr");
    for (int y = 0; y < 40; ++y)
        for (int x = 0; x < 20; ++x)
            for (int c = 0; c < 3; ++c) map.data[std::size_t(3 * (40 * y + x) + c)] *= 1.1f;
    write_exr(folder + "/b.exr", map);
    const Json planted = Json::parse(succeed(lightmap(other, {"--check", folder + "/b.exr", "--json"}, own)).out);
    REQUIRE(planted["charts"]["off"].size() == 1);
    CHECK(planted["charts"]["off"][0]["mesh"] == "floor");
    CHECK(planted["charts"]["off"][0]["bias"].get<double>() == Approx(0.1).margin(0.01));
    // The edge is along x at the origin.
    REQUIRE(planted["seams"]["worst"].size() == 1);
    CHECK(planted["seams"]["worst"][0]["excess"].get<double>() > 0.05);
    CHECK(planted["seams"]["worst"][0]["excess"].get<double>() < 0.15);
    CHECK(planted["seams"]["worst"][0]["a"]["position"][1] == 0);
    CHECK(planted["seams"]["worst"][0]["a"]["position"][2] == 0);
    // One mesh alone, in the first set.
    succeed(lightmap(scene, {"--uv", "0", "--mesh", "wall", "--size", "16x16", "-o", folder + "/wall.exr"}, own));
    const Json wall = Json::parse(succeed(lightmap(other, {"--uv", "0", "--mesh", "wall", "--check", folder + "/wall.exr", "--json"}, own)).out);
    CHECK(wall["errors"]["receivers"].get<int>() + wall["inside"]["receivers"].get<int>() == 256);
}

TEST_CASE("lightmap: wrong usage and maps that cannot be checked are one line", "[program]") {
    const std::string folder = fresh_folder("lightmap_usage"), scene = corner_scene(folder, true), single = corner_scene(folder, false, "single");
    succeed(lightmap(scene, {"--uv", "1", "--size", "24x24", "-o", folder + "/a.exr"}, own));
    const std::string map = folder + "/a.exr";
    const auto check = [&](const std::string& of, const std::string& file, Words more = {}) {
        more.insert(more.begin(), {"--check", file});
        return refused(lightmap(of, more, own));
    };
    CHECK_THAT(refused({"lightmap", scene}), Contains("-o FILE.exr"));
    CHECK_THAT(refused({"lightmap", scene, "-o", folder + "/x.png"}), Contains(".exr"));
    CHECK_THAT(refused({"lightmap", scene, "-o", folder + "/none/x.exr"}), Contains("no folder"));
    CHECK_THAT(refused({"lightmap", scene, "-o", folder + "/x.exr", "--error", folder + "/x.exr"}), Contains("twice"));
    CHECK_THAT(refused({"lightmap", scene, "-o", folder + "/x.exr", "--part", "some"}), Contains("--part some"));
    CHECK_THAT(refused({"lightmap", scene, "-o", folder + "/x.exr", "--samples", "0"}), Contains("samples"));
    CHECK_THAT(refused({"lightmap", scene, "-o", folder + "/x.exr", "--uv", "1"}), Contains("--size"));
    CHECK_THAT(refused({"lightmap", scene, "-o", folder + "/x.exr", "--size", "16x16"}), Contains("lightmap_size"));
    CHECK_THAT(refused({"lightmap", scene, "-o", folder + "/x.exr", "--html", folder + "/x.html"}), Contains("--check"));
    CHECK_THAT(refused({"lightmap", scene, "-o", folder + "/x.exr", "--max-leaks", "0"}), Contains("--check"));
    CHECK_THAT(refused({"lightmap", scene, "-o", folder + "/x.exr", "--set", "probes.lightmap_siz=9"}), Contains("'lightmap_size'"));
    // Coordinates.
    CHECK_THAT(check(single, map, {"--uv", "1"}), Contains("\"floor\" has no second set"));
    CHECK_THAT(check(single, map), Contains("\"floor\" and mesh \"wall\"") && Contains("overlap"));
    CHECK_THAT(check(scene, map, {"--mesh", "flor", "--uv", "0"}), Contains("; the nearest known one is \"floor\""));
    CHECK_THAT(check(scene, map, {"--uv", "2"}), Contains("--uv"));
    CHECK_THAT(check(scene, map, {"--uv", "atlas", "--set", "probes.lightmap_size=64"}), Contains("24 x 24") && Contains("64 x 64"));
    // Files.
    CHECK_THAT(check(scene, folder + "/none.exr"), Contains("none.exr"));
    CHECK_THAT(check(scene, scene), Contains("corner.toml"));
    CHECK_THAT(check(scene, map, {"--layer", "light"}), Contains("light"));
    CHECK_THAT(check(scene, map, {"--scale", "0"}), Contains("--scale 0"));
    CHECK_THAT(check(scene, map, {"--scale", "two"}), Contains("--scale two"));
    CHECK_THAT(check(scene, map, {"--error", folder + "/e.exr"}), Contains("--error"));
    CHECK_THAT(check(scene, map, {"-o", map}), Contains("is a file"));
    CHECK_THAT(check(scene, map, {"--html", map}), Contains("is read here"));
    compare::Picture wrong = picture_of(map);
    wrong.data[3 * (24 * 5 + 2) + 1] = std::nanf("");
    write_exr(folder + "/nan.exr", wrong);
    CHECK_THAT(check(scene, folder + "/nan.exr"), Contains("nan.exr") && Contains("texel 2,5") && Contains("in G"));
    compare::Picture wide{{"R", "G", "B"}, 48, 12, std::vector<float>(48 * 12 * 3, 1.0f)};
    write_exr(folder + "/wide.exr", wide);
    CHECK_THAT(check(scene, folder + "/wide.exr"), Contains("wide.exr") && Contains("48 x 12") && Contains("aspect"));
    CHECK_THAT(check(scene, map, {"--map-error", folder + "/wide.exr"}), Contains("wide.exr") && Contains("24 x 24"));
    compare::Picture two{{"R", "G"}, 24, 24, std::vector<float>(24 * 24 * 2, 1.0f)};
    write_exr(folder + "/two.exr", two);
    CHECK_THAT(check(scene, folder + "/two.exr"), Contains("channels"));
    CHECK_FALSE(fs::exists(folder + "/x.exr"));
    CHECK_FALSE(fs::exists(folder + "/e.exr"));
}
