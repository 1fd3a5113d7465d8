// plumb explain and stages.
#include <catch2/catch.hpp>
#include <filesystem>
#include <sstream>

#include "io/image_file.h"
#include "tests/program/program.h"

using namespace plumb;
using namespace plumb::program;
using Catch::Matchers::Contains;

namespace {

// The values of that name, in order.
std::vector<Json> named(const Json& explanation, const std::string& name) {
    std::vector<Json> values;
    for (const Json& v : explanation["values"])
        if (v["name"] == name) values.push_back(v);
    return values;
}

int count(const std::string& text, const std::string& part) {
    int n = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
    return n;
}

}  // namespace

TEST_CASE("explain: every stage of a pixel ends with what the picture holds", "[program]") {
    const std::string folder = fresh_folder("explain"), scene = small_scene(folder);
    for (const char* layout : {"render.layout=fp32", "render.layout=rgba16f"}) {
        for (const char* pixel : {"30,21", "0,0", "60,42", "12,30", "45,35"}) {
            const Result r = run({"explain", scene, "--pixel", pixel, "--set", layout});
            INFO(r.out << r.err);
            CHECK(r.exit == 0);
            CHECK(r.err.empty());
            CHECK(count(r.out, ": equal\n") >= 7);  // two shadows, two gathers, direct, compose, tonemap
            CHECK(count(r.out, "NOT EQUAL") == 0);
        }
    }
    for (const char* texel : {"0,0", "24,24", "47,47"}) {
        const Result r = run({"explain", scene, "--stage", "rsm", "--pixel", texel});
        CHECK(r.exit == 0);
        CHECK(count(r.out, "NOT EQUAL") == 0);
    }
    CHECK(count(run({"explain", scene, "--stage", "rsm", "--pixel", "24,24"}).out, ": equal\n") == 4);
}

TEST_CASE("explain: a filter's check says what it holds against the picture", "[program]") {
    const std::string folder = fresh_folder("explain_filter_check"), scene = small_scene(folder);
    auto explain = [&](const char* stage) {
        return run({"explain", scene, "--stage", stage, "--pixel", "20,15", "--set", "indirect.resolution=half",
                    "--set", "indirect.blur=full", "--set", "render.layout=vrsm"});
    };
    const Result reduce = explain("filter.reduce"), blur = explain("filter.blur");
    CHECK(reduce.exit == 0);
    CHECK(blur.exit == 0);
    for (const char* part : {"check: reduced position: ", "check: reduced normal: "})
        CHECK_THAT(reduce.out, Contains(part));
    CHECK_THAT(reduce.out, !Contains("check: irradiance: "));
    CHECK_THAT(blur.out, Contains("check: irradiance: "));
}

TEST_CASE("explain: what any layout rounds is held against the rounded value", "[program][layout]") {
    const std::string folder = fresh_folder("explain_layouts"), scene = small_scene(folder);
    write(scene, read(scene) + "[[material]]\nname = \"red\"\nemission = [3, 0.5, 0.25]\n");
    const std::vector<Words> layouts = {
        {"render.layout=isr"},
        {"render.layout=lra"},
        {"render.layout=vrsm"},
        // Formats that the kernels round and that are rounded after them; the order of what is set does not matter.
        {"layout.normal=octahedral8", "layout.albedo=rgbe", "layout.emission=r11g11b10f", "layout.position=rgba16f",
         "render.layout=custom", "layout.rsm_flux=rgbe", "layout.rsm_normal=r10g10b10a2", "layout.rsm_depth=r16f"},
    };
    for (const Words& sets : layouts) {
        auto explain = [&](Words arguments) {
            arguments.insert(arguments.begin(), {"explain", scene});
            for (const std::string& set : sets) arguments.insert(arguments.end(), {"--set", set});
            const Result r = run(arguments);
            INFO(sets[0] << "\n" << r.out << r.err);
            CHECK(r.exit == 0);
            CHECK(count(r.out, "NOT EQUAL") == 0);
            return r.out;
        };
        for (const char* pixel : {"30,21", "14,20", "12,30"})
            CHECK(count(explain({"--pixel", pixel}), ": equal\n") >= 12);
        CHECK(count(explain({"--stage", "rsm", "--light", "key", "--pixel", "20,31"}), ": equal\n") == 4);

        // The rounded values are others than the kernel's.
        const Json e = Json::parse(explain({"--stage", "gbuffer", "--pixel", "12,30", "--json"}));
        auto value = [&](const char* name) { return named(e, name).back()["value"]; };
        CHECK(value("stored_position") != value("position"));
        CHECK(value("stored_albedo") != value("albedo"));
    }
}

TEST_CASE("explain: the samples of the gather add up to its irradiance", "[program][VRSM (3.2)]") {
    const std::string folder = fresh_folder("explain_sum"), scene = small_scene(folder);
    REQUIRE(run({"render", scene, "-o", folder}).exit == 0);
    const compare::Picture indirect = io::select_layer(io::read_picture(folder + "/small.exr"), "indirect", "");
    double total[3] = {};
    for (const char* light : {"key", "sun"}) {
        const Result r = run({"explain", scene, "--stage", "rsm.disc", "--pixel", "40,33", "--light", light, "--json"});
        REQUIRE(r.exit == 0);
        const Json e = Json::parse(r.out);
        CHECK(keys(e) == Words{"stage", "pixel", "values"});
        CHECK(e["stage"] == std::string("rsm.disc (") + light + ")");
        CHECK(e["pixel"] == Json{40, 33});
        // E = 1/pi sum of weight Phi_p form, over all 37 samples.
        const auto weight = named(e, "weight"), flux = named(e, "flux"), form = named(e, "form");
        REQUIRE(weight.size() == 37);
        REQUIRE(flux.size() == 37);
        REQUIRE(form.size() == 37);
        const Json irradiance = named(e, "irradiance").at(0)["value"];
        for (int c = 0; c < 3; ++c) {
            double sum = 0;
            for (int k = 0; k < 37; ++k) {
                CHECK(weight[k]["sample"] == k);
                sum += weight[k]["value"].get<double>() * flux[k]["value"][c].get<double>() *
                       form[k]["value"].get<double>();
            }
            CHECK(irradiance[c].get<double>() == Approx(sum / 3.14159265358979).epsilon(1e-5));
            total[c] += irradiance[c].get<double>();
        }
    }
    CHECK(total[0] > 0);
    for (int c = 0; c < 3; ++c) CHECK(indirect.data[(33 * 61 + 40) * 3 + c] == Approx(total[c]).epsilon(1e-6));
}

TEST_CASE("explain: JSON has the contract's keys, text has the same numbers", "[program][contract]") {
    const std::string folder = fresh_folder("explain_json"), scene = small_scene(folder);
    const Result r = run({"explain", scene, "--pixel", "30,21", "--json"});
    REQUIRE(r.exit == 0);
    CHECK(r.err.empty());
    const Json all = Json::parse(r.out);
    REQUIRE(keys(all) == Words{"pixel", "stages"});
    CHECK(all["pixel"] == Json{30, 21});
    Words stages;
    for (const Json& e : all["stages"]) {
        CHECK(keys(e) == Words{"stage", "pixel", "values"});
        CHECK(e["pixel"] == all["pixel"]);
        for (const Json& v : e["values"])
            CHECK(keys(v) == (v.contains("sample") ? Words{"name", "sample", "value", "equation"}
                                                   : Words{"name", "value", "equation"}));
        stages.push_back(e["stage"]);
    }
    CHECK(stages == Words{"gbuffer", "shadow (key)", "rsm.disc (key)", "shadow (sun)", "rsm.disc (sun)", "direct",
                          "compose", "tonemap"});

    // One stage alone is its object, and its numbers are those of the text, to the float.
    const Json one = Json::parse(run({"explain", scene, "--stage", "compose", "--pixel", "30,21", "--json"}).out);
    REQUIRE(one.is_object());
    CHECK(one == all["stages"][6]);
    const std::string text = run({"explain", scene, "--stage", "compose", "--pixel", "30,21"}).out;
    const Json radiance = named(one, "radiance").at(0)["value"];
    const std::size_t line = text.find("\nradiance");
    REQUIRE(line != std::string::npos);
    std::istringstream words(text.substr(line));
    std::string name, v[3];
    words >> name >> v[0] >> v[1] >> v[2];
    for (int c = 0; c < 3; ++c) CHECK(std::stof(v[c]) == radiance[c].get<float>());
}

namespace {

// What a page needs is inside of it: no address, no file, and one script, its own.
void check_self_contained(const std::string& html) {
    for (const char* part : {"://", "src=\"/", "@import", "url(", "<link"}) CHECK(count(html, part) == 0);
    CHECK(count(html, "<script") == 1);
    CHECK(count(html, "data:image/png;base64,") > 0);
    CHECK_THAT(html, Contains("default-src 'none'"));
}

}  // namespace

TEST_CASE("explain --html: every stage of a frame has its buffers, its values and its check on the page", "[program]") {
    const std::string folder = fresh_folder("explain_html"), scene = small_scene(folder);
    const std::string file = folder + "/page.html";
    const Json stages = Json::parse(run({"explain", scene, "--pixel", "40,33", "--json"}).out)["stages"];
    REQUIRE(stages.size() >= 8);
    const Result whole = run({"explain", scene, "--pixel", "40,33", "--html", file});
    REQUIRE(whole.exit == 0);
    CHECK(whole.err.empty());
    CHECK(whole.out == run({"explain", scene, "--pixel", "40,33"}).out);
    const std::string page = read(file);
    check_self_contained(page);
    CHECK(count(page, "NOT EQUAL") == 0);
    CHECK(count(page, ": equal") >= 7);
    // Equal pages of equal runs.
    REQUIRE(run({"explain", scene, "--pixel", "40,33", "--html", file, "--threads", "1"}).exit == 0);
    CHECK(read(file) == page);

    for (const Json& e : stages) {
        const std::string label = e["stage"], name = label.substr(0, label.find(' '));
        INFO(label);
        CHECK(count(page, "<h2 id=\"stage" ) == int(stages.size()));
        CHECK_THAT(page, Contains(">" + label + " at 40,33<"));
        // The stage alone, of its light.
        Words words = {"explain", scene, "--stage", name, "--pixel", "40,33", "--html", file};
        if (label != name) {
            const std::string light = label.substr(label.find('(') + 1);
            words.insert(words.end(), {"--light", light.substr(0, light.size() - 1)});
        }
        REQUIRE(run(words).exit == 0);
        const std::string one = read(file);
        check_self_contained(one);
        for (const Json& v : e["values"]) {
            const std::string tap = "<td>" + v["name"].get<std::string>() + "</td>";
            CHECK(count(one, tap) > 0);
        }
    }
    REQUIRE(run({"explain", scene, "--stage", "rsm", "--pixel", "20,31", "--html", file}).exit == 0);
    CHECK_THAT(read(file), Contains("class=\"seen\"") && Contains("flux (W)"));
}

TEST_CASE("explain --html: a gather's samples lie on the light's map, and are rows of a table", "[program][VRSM (3.2)]") {
    const std::string folder = fresh_folder("explain_html_gather"), scene = small_scene(folder);
    const std::string file = folder + "/page.html";
    const Result r = run({"explain", scene, "--stage", "rsm.disc", "--light", "key", "--pixel", "40,33", "--html", file});
    REQUIRE(r.exit == 0);
    const std::string page = read(file);
    // 37 samples: a row each, and a mark on each of the map's three pictures at least.
    CHECK(count(page, "<tr data-key=") == 37);
    CHECK(count(page, "<circle") >= 3 * 37);
    CHECK(count(page, "<details data-key=") == 37);
    for (const char* part : {"rsm_flux (W)", "rsm_position (m)", "rsm_normal", "48 x 48", "percentile", "weights (texels)",
                             "check: irradiance, the sum of 2 lights: "})
        CHECK_THAT(page, Contains(part));
    // The text has the same samples, with what each brings, and their sum.
    CHECK_THAT(r.out, Contains("what each sample brings, largest first: weight visibility flux form (VRSM (3.2))\nsample  texel  inside"));
    const std::size_t sum = r.out.find("\ntogether: ");
    REQUIRE(sum != std::string::npos);
    std::istringstream words(r.out.substr(sum + 11));
    const Json e = Json::parse(run({"explain", scene, "--stage", "rsm.disc", "--light", "key", "--pixel", "40,33",
                                    "--json"}).out);
    for (int c = 0; c < 3; ++c) {
        double together = 0;
        words >> together;
        CHECK(together == Approx(named(e, "sum").back()["value"][c].get<double>()).epsilon(1e-4));
    }
    // The whole map: more texels than marks can show, so that what each brings is a picture.
    std::string text = read(scene);
    text.replace(text.find("rsm_size = 48"), 13, "rsm_size = 96");
    write(scene, text);
    REQUIRE(run({"explain", scene, "--stage", "rsm.all", "--light", "key", "--set", "rsm.gather=all", "--pixel", "40,33",
                 "--html", file}).exit == 0);
    CHECK_THAT(read(file), Contains("contribution (W/m2)") && Contains("The 1000 of 9216 samples that bring most"));
}

TEST_CASE("explain --html: what cannot be written is one line, and a device stays one", "[program]") {
    const std::string folder = fresh_folder("explain_html_refused"), scene = small_scene(folder);
    for (const std::string& file : {folder + "/none/page.html", folder}) {
        const Result r = run({"explain", scene, "--stage", "compose", "--pixel", "1,1", "--html", file});
        CHECK(r.exit == 2);
        CHECK(r.out.empty());
        CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
        CHECK_THAT(r.err, Contains(file));
    }
    const Words before = files_in(folder);
    const Result outside = run({"explain", scene, "--pixel", "1000,1", "--html", folder + "/page.html"});
    CHECK(outside.exit == 2);
    CHECK(files_in(folder) == before);
    CHECK(run({"explain", scene, "--stage", "compose", "--pixel", "1,1", "--html", "/dev/null"}).exit == 0);
    CHECK(std::filesystem::is_character_file("/dev/null"));
}

TEST_CASE("stages: text and JSON name every stage, its ports and its twin", "[program][contract]") {
    const Result json = run({"stages", "--json"}), text = run({"stages"});
    CHECK(json.exit == 0);
    CHECK(text.exit == 0);
    const Json stages = Json::parse(json.out);
    for (const char* name : {"gbuffer", "rsm", "shadow", "direct", "rsm.disc", "rsm.all", "rsm.all_rays", "compose", "tonemap",
                             "hemicube", "texture_space"}) {
        CHECK_THAT(text.out, Contains(std::string(name) + "\n"));
        CHECK(std::count_if(stages.begin(), stages.end(), [&](const Json& s) { return s["name"] == name; }) == 1);
    }
    for (const Json& s : stages) {
        CHECK(keys(s) == Words{"name", "source", "inputs", "outputs", "params", "uniforms", "twin", "budget"});
        for (const Json& p : s["params"]) {
            CHECK(keys(p) == Words{"name", "type", "default", "range", "unit", "meaning"});
            CHECK_THAT(text.out, Contains(p["meaning"].get<std::string>()));
            if (p["type"] == "string") CHECK(p["range"] == "");
        }
    }
}

TEST_CASE("make-scene: writes the same scene every time, and plan accepts it", "[program]") {
    const std::string folder = fresh_folder("make_scene");
    const Result r = run({"make-scene", "cornell", "-o", folder + "/a"});
    CHECK(r.exit == 0);
    CHECK_THAT(r.out, Contains(folder + "/a/cornell.toml"));
    REQUIRE(run({"make-scene", "cornell", "-o", folder + "/b"}).exit == 0);
    CHECK(files_in(folder + "/a") == Words{"cornell.mtl", "cornell.obj", "cornell.toml"});
    for (const std::string& name : files_in(folder + "/a"))
        CHECK(read(folder + "/a/" + name) == read(folder + "/b/" + name));
    CHECK(run({"plan", folder + "/a/cornell.toml"}).exit == 0);

    // In JSON: the file that render takes, all files, and what is in them.
    const Result json = run({"make-scene", "cornell", "-o", folder + "/a", "--json"});
    CHECK(json.exit == 0);
    CHECK(json.err.empty());
    const Json written = Json::parse(json.out);
    CHECK(keys(written) ==
          Words{"scene", "files", "meshes", "triangles", "vertices", "materials", "textures", "lights"});
    CHECK(written["scene"] == folder + "/a/cornell.toml");
    CHECK(written["files"] == Json{folder + "/a/cornell.mtl", folder + "/a/cornell.obj", folder + "/a/cornell.toml"});
    CHECK(written["triangles"] == 38);
    CHECK(written["lights"] == 1);
}
