// Method radiosity as its user meets it: meshes with colours, and one row of form factors explained.
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>

#include "io/gltf.h"
#include "io/obj.h"
#include "tests/program/program.h"

using namespace plumb;
using namespace plumb::program;
using Catch::Matchers::Contains;

namespace {

const Words method = {"--method", "radiosity", "--set", "radiosity.size=16", "--set", "radiosity.edge=0.4"};

Words with(Words words, const Words& more) {
    words.insert(words.end(), method.begin(), method.end());
    words.insert(words.end(), more.begin(), more.end());
    return words;
}

// The last value of that name.
std::vector<double> value(const Json& explanation, const std::string& name) {
    std::vector<double> found;
    for (const Json& v : explanation["values"])
        if (v["name"] == name) found = v["value"].is_array() ? v["value"].get<std::vector<double>>() : std::vector<double>{v["value"].get<double>()};
    REQUIRE_FALSE(found.empty());
    return found;
}

Json explained(const std::string& scene, const char* stage, const char* item) {
    const Result r = run(with({"explain", scene, "--stage", stage, "--item", item, "--json"}, {}));
    INFO(r.err);
    REQUIRE(r.exit == 0);
    return Json::parse(r.out);
}

}  // namespace

TEST_CASE("render --mesh: GLB and OBJ hold the elements' triangles", "[program][radiosity]") {
    const std::string folder = fresh_folder("radiosity_mesh"), scene = small_scene(folder);
    std::size_t triangles = 0;
    for (const char* name : {"a.glb", "a.obj"}) {
        const std::string file = folder + "/" + name;
        const Result r = render(scene, folder + "/out", with({}, {"--mesh", file}));
        CHECK_THAT(r.out, Contains("wrote " + file));
        std::size_t count = 0;
        if (std::string(name) == "a.glb")
            for (const Mesh& m : io::read_gltf(file).meshes) count += m.triangles.size();
        else
            count = io::read_obj(file).mesh.triangles.size();
        CHECK(count > 500);
        CHECK((triangles == 0 || triangles == count));
        triangles = count;
        const std::string bytes = read(file);
        render(scene, folder + "/out", with({}, {"--mesh", file}));
        CHECK(read(file) == bytes);
    }
    // With an element a triangle each has three vertices of its own.
    const std::string file = folder + "/t.glb";
    render(scene, folder + "/out", with({}, {"--set", "radiosity.elements=triangles", "--mesh", file}));
    std::size_t count = 0, vertices = 0;
    for (const Mesh& m : io::read_gltf(file).meshes) count += m.triangles.size(), vertices += m.vertices.size();
    CHECK(vertices == 3 * count);
}

TEST_CASE("render --mesh: what could not be written is refused before anything is rendered", "[program][radiosity][bad input]") {
    const std::string folder = fresh_folder("radiosity_mesh_bad"), scene = small_scene(folder);
    const Words before = files_in(folder);
    const auto refused = [&](const Words& more, const char* text) {
        const Result r = run(with({"render", scene, "-o", folder + "/out"}, more));
        INFO(r.err);
        CHECK(r.exit == 2);
        CHECK_THAT(r.err, Contains(text));
        CHECK(files_in(folder) == before);
    };
    refused({"--mesh", folder + "/a.ply"}, "a.ply: expected a name that ends in .glb or .obj");
    refused({"--mesh", folder + "/none/a.glb"}, "none/a.glb");
    refused({"--mesh", folder + "/a.glb", "--frames", "2"}, "expected no --frames");
    write(folder + "/dark.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    write(folder + "/dark.toml", "[frame]\nsize = [8, 8]\n[camera]\nposition = [0, 0, 3]\nlook_at = [0, 0, 0]\n[[mesh]]\nfile = \"dark.obj\"\n"
                                 "[[light]]\nname = \"bulb\"\ntype = \"point\"\nposition = [0, 0, 1]\nintensity = [1, 1, 1]\non = false\n");
    const Words made = files_in(folder);
    const Result dark = run(with({"render", folder + "/dark.toml", "-o", folder + "/out"}, {"--mesh", folder + "/a.glb"}));
    CHECK(dark.exit == 2);
    CHECK_THAT(dark.err, Contains("there is no mesh"));
    CHECK(files_in(folder) == made);
    const Result r = run({"render", scene, "--method", "rsm", "-o", folder + "/out", "--mesh", folder + "/a.glb"});
    CHECK(r.exit == 2);
    CHECK_THAT(r.err, Contains("--mesh: of method radiosity alone"));
    CHECK(files_in(folder) == made);
}

TEST_CASE("explain: a row of form factors adds up to its element's irradiance", "[program][radiosity]") {
    const std::string folder = fresh_folder("explain_row"), scene = small_scene(folder);
    for (const char* item : {"0", "7", "150"}) {
        const Json row = explained(scene, "radiosity.rows", item), gather = explained(scene, "radiosity.gather", item);
        CAPTURE(item);
        double texels = 0, share = 0;
        for (const char* kind : {"front", "back", "escaped"}) texels += value(row, kind).at(0), share += value(row, kind).at(1);
        CHECK(texels == 3 * 16 * 16);
        CHECK(share == Approx(1).epsilon(1e-9));
        CHECK(value(row, "row_sum").at(0) == Approx(value(row, "front").at(1)).epsilon(1e-5));
        double faces = 0;
        std::vector<double> brought(3, 0.0);
        for (const char* face : {"top", "side_u", "side_-u", "side_t", "side_-t"}) {
            const std::vector<double> v = value(row, face);
            faces += v.at(0);
            for (std::size_t c = 0; c < 3; ++c) brought[c] += v.at(c + 1);
        }
        CHECK(faces == Approx(1).epsilon(1e-9));
        std::vector<double> elements = value(row, "rest");
        for (const Json& v : row["values"])
            if (v["name"] == "brings")
                for (std::size_t c = 0; c < 3; ++c) elements[c] += v["value"][c].get<double>();
        const std::vector<double> own = value(row, "H0"), h = value(row, "irradiance"), by_texels = value(row, "by_texels");
        for (std::size_t c = 0; c < 3; ++c) {
            CHECK(h[c] > 0);
            CHECK(own[c] + elements[c] == Approx(h[c]).epsilon(1e-9));
            CHECK(own[c] + brought[c] == Approx(by_texels[c]).epsilon(1e-9));
            CHECK(by_texels[c] == Approx(h[c]).epsilon(1e-3));  // halves keep 11 bits
            CHECK(value(gather, "irradiance").at(c) == Approx(h[c]).epsilon(1e-5));
        }
    }
}

TEST_CASE("explain: a row's hemicube is shown as four pictures", "[program][radiosity]") {
    const std::string folder = fresh_folder("explain_row_page"), scene = small_scene(folder), page = folder + "/row.html";
    const Result r = run(with({"explain", scene, "--stage", "radiosity.rows", "--item", "40"}, {"--html", page}));
    INFO(r.err);
    CHECK(r.exit == 0);
    const std::string html = read(page);
    for (const char* part : {"radiosity.rows, item 40", "that each texel sees, the top in the middle", "all add up to 1", "weight times radiosity"})
        CHECK_THAT(html, Contains(part));
    CHECK(html.find("the picture that this leads to") == std::string::npos);  // an item is at no place of it
    CHECK(html.find("0 black, 1 white: 0 to 0.") == std::string::npos);       // nothing would be seen of texels' weights
    const auto refused = [&](const Words& more, const char* text) {
        const Result bad = run(with({"explain", scene}, more));
        INFO(bad.err);
        CHECK(bad.exit == 2);
        CHECK_THAT(bad.err, Contains(text));
    };
    refused({"--stage", "radiosity.rows", "--item", "100000000"}, "outside of radiosity.rows");
    refused({"--stage", "radiosity.rows", "--item", "-1"}, "--item");
    refused({"--item", "3"}, "--item: expected --stage");
    refused({"--stage", "radiosity.rows"}, "expected --pixel X,Y, or --item N");
    refused({"--stage", "radiosity.solve", "--item", "3"}, "without items");
}
