// The method radiosity as its user meets it: what plan says, what run.json holds, rows that are kept, damaged and refused.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>

#include "tests/program/program.h"

using namespace plumb::program;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

// 1,135 elements, with hemicubes of few texels.
Words of_radiosity(const std::string& command, const std::string& scene, const Words& more = {}) {
    Words words = {command, scene, "--method", "radiosity", "--size", "40x30", "--set", "radiosity.edge=0.3", "--set", "radiosity.refine=0", "--set", "radiosity.size=10"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
}
Json rendered(const std::string& scene, const std::string& out, const Words& more = {}) {
    Words words = of_radiosity("render", scene, {"-o", out});
    words.insert(words.end(), more.begin(), more.end());
    const Result r = run(words);
    INFO(r.out << r.err);
    REQUIRE(r.exit == 0);
    REQUIRE(r.err.empty());
    return Json::parse(read(out + "/run.json"));
}
std::string refused(const Words& words) {
    const Result r = run(words);
    CAPTURE(words, r.out, r.err);
    CHECK(r.exit == 2);
    CHECK(r.out.empty());
    CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
    return r.err;
}
Json stage(const Json& run, const std::string& name) {
    for (const Json& s : run["stages"])
        if (s["name"] == name) return s;
    return nullptr;
}
std::string picture(const std::string& folder) { return read(folder + "/small.exr"); }
Words kept_rows(const std::string& cache) {
    Words all;
    for (const std::string& file : files_in(cache))
        if (fs::path(file).extension() == ".rows") all.push_back(cache + "/" + file);
    return all;
}
std::string with_other(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    REQUIRE(at != std::string::npos);
    return text.replace(at, from.size(), to);
}

}  // namespace

TEST_CASE("plan: the method radiosity says its elements, the memory of its rows, the solver and why", "[program][radiosity]") {
    const std::string folder = fresh_folder("plan_radiosity"), scene = small_scene(folder);
    set_cache(folder + "/cache");
    const Result plan = run(of_radiosity("plan", scene));
    CAPTURE(plan.out, plan.err);
    REQUIRE(plan.exit == 0);
    CHECK_THAT(plan.out, Contains("elements of") && Contains("MB") && Contains("solver bicgstab: radius 0.") && Contains("passes would take"));
    const Result json_plan = run(of_radiosity("plan", scene, {"--json"}));
    const Json json = Json::parse(json_plan.out)["radiosity"];
    CHECK(keys(json) == Words{"elements", "triangles", "mesh_seconds", "rows", "solver", "reason", "products", "seconds"});
    CHECK(json["elements"].get<int>() > 500);
    CHECK(json["mesh_seconds"].get<double>() > 0);
    CHECK(json["rows"]["in_memory"] == true);
    CHECK(json["rows"]["most_bytes"].get<double>() > json["rows"]["expected_bytes"].get<double>());
    // What is asked for, and what would be recommended.
    CHECK_THAT(run(of_radiosity("plan", scene, {"--set", "radiosity.solver=passes"})).out, Contains("solver passes: solver = passes; recommended is bicgstab"));
    CHECK_FALSE(run(of_radiosity("plan", scene, {"--method", "direct"})).out.find("solver") != std::string::npos);
    CHECK_FALSE(fs::exists(folder + "/cache"));
    // The frame does what was said.
    CHECK(rendered(scene, folder + "/a")["radiosity"]["solution"]["solver"] == json["solver"]);
}

TEST_CASE("render: the method radiosity says in run.json how it was solved and where all power goes", "[program][radiosity][contract]") {
    const std::string folder = fresh_folder("render_radiosity"), scene = small_scene(folder);
    set_cache(folder + "/cache");
    const Json json = rendered(scene, folder + "/a")["radiosity"];
    CHECK(keys(json) == Words{"elements", "triangles", "offset_m", "nearer", "without_normal", "rows", "solution", "energy"});
    const Json& s = json["solution"];
    CHECK(keys(s) == Words{"solver", "reason", "products", "radius", "residual", "row_residual", "error", "tolerance", "converged", "why", "curve"});
    CHECK(s["converged"] == true);
    CHECK(s["error"].get<double>() <= s["tolerance"].get<double>());
    CHECK(s["curve"].size() > 2);
    CHECK(s["curve"].back()["error"].get<double>() <= s["curve"].front()["error"].get<double>());
    const Json& e = json["energy"];
    const auto watts = [&](const char* name) { return e[name].get<double>(); };
    const double sent = watts("emitted") + watts("incident");
    CHECK(sent > 0);
    CHECK(std::abs(sent - watts("absorbed") - watts("escaped") - watts("not_arrived") - watts("not_reciprocal") - watts("unsolved")) < 1e-9 * sent);
    CHECK(std::abs(watts("unsolved")) < 1e-3 * sent);
    CHECK(e["row_sums"]["largest"].get<double>() <= 1 + 1e-5);
    CHECK(e["reciprocity"]["pairs"].get<double>() > 0);
    const Result text = run(of_radiosity("render", scene, {"-o", folder + "/b"}));
    CHECK_THAT(text.out, Contains("products with all rows") && Contains("converged") && Contains("W emitted and") && Contains("W absorbed"));
    CHECK_FALSE(rendered(scene, folder + "/c", {"--set", "radiosity.audit=false"})["radiosity"].contains("energy"));
    // n passes as published.
    const Json passes = rendered(scene, folder + "/d", {"--set", "radiosity.tolerance=0", "--set", "radiosity.passes=4"})["radiosity"]["solution"];
    CHECK(passes["solver"] == "passes");
    CHECK(passes["products"] == 4);
    CHECK(passes["curve"].size() == 4);
    CHECK(passes["converged"] == false);
    CHECK(picture(folder + "/d") != picture(folder + "/a"));
}

TEST_CASE("render: rows of the method radiosity are kept between runs, and made again where they are damaged", "[program][radiosity][store]") {
    const std::string folder = fresh_folder("radiosity_rows"), scene = small_scene(folder), cache = folder + "/cache";
    set_cache(cache);
    const Json first = rendered(scene, folder + "/a");
    const int files = first["radiosity"]["rows"]["files"];
    CHECK(files >= 3);
    CHECK(first["radiosity"]["rows"]["found"] == 0);
    CHECK(stage(first, "radiosity.rows")["kept"] == false);
    const Words kept = kept_rows(cache);
    CHECK(int(kept.size()) == files);
    const auto found = [&](const std::string& out, const Words& more = {}) { return rendered(scene, out, more)["radiosity"]["rows"]["found"].get<int>(); };

    // The same, by another instruction set and thread, and without a store: the same picture.
    const Json again = rendered(scene, folder + "/b", {"--threads", "1", "--isa", "scalar"});
    CHECK(again["radiosity"]["rows"]["found"] == files);
    CHECK(stage(again, "radiosity.rows")["kept"] == true);
    CHECK(picture(folder + "/b") == picture(folder + "/a"));
    CHECK(found(folder + "/c", {"--no-cache"}) == 0);
    CHECK(picture(folder + "/c") == picture(folder + "/a"));
    // In little memory: most of them are read for each product.
    const Json little = rendered(scene, folder + "/d", {"--set", "radiosity.memory_mb=3"});
    CHECK(little["radiosity"]["rows"]["in_memory_bytes"].get<double>() < little["radiosity"]["rows"]["bytes"].get<double>());
    CHECK_THAT(stage(little, "radiosity.rows")["reason"].get<std::string>(), Contains("read from disk for each product"));
    CHECK(picture(folder + "/d") == picture(folder + "/a"));

    // Another camera, light and reflectance need no other rows; another mesh does.
    const std::string toml = read(scene), mtl = read(folder + "/cornell.mtl");
    write(scene, with_other(with_other(toml, "intensity = [10, 10, 10]", "intensity = [3, 5, 7]"), "0.995, 3.934", "0.9, 3.5"));
    CHECK(found(folder + "/e") == files);
    CHECK(picture(folder + "/e") != picture(folder + "/a"));
    write(scene, toml);
    write(folder + "/cornell.mtl", with_other(mtl, "Kd 0.", "Kd 0.1"));
    CHECK(found(folder + "/e") == files);
    CHECK(picture(folder + "/e") != picture(folder + "/a"));
    write(folder + "/cornell.mtl", mtl);
    CHECK(kept_rows(cache).size() == kept.size());
    CHECK(found(folder + "/e", {"--set", "radiosity.size=8"}) == 0);
    CHECK(found(folder + "/e", {"--set", "radiosity.split=false"}) == 0);

    // A byte that was changed, a file that was cut, an empty one: noticed, said, made again.
    for (const int damage : {0, 1, 2}) {
        CAPTURE(damage);
        std::string bytes = read(kept[1]);
        if (damage == 0) bytes[bytes.size() / 2] ^= 4;
        if (damage == 1) bytes.resize(bytes.size() / 2);
        if (damage == 2) bytes.clear();
        const std::string whole = read(kept[1]);
        write(kept[1], bytes);
        const Result r = run(of_radiosity("render", scene, {"-o", folder + "/f"}));
        CAPTURE(r.out, r.err);
        CHECK(r.exit == 0);
        CHECK_THAT(r.err, Contains(kept[1]) && Contains("computed anew"));
        CHECK(Json::parse(read(folder + "/f/run.json"))["radiosity"]["rows"]["found"] == files - 1);
        CHECK(picture(folder + "/f") == picture(folder + "/a"));
        CHECK(read(kept[1]) == whole);
        CHECK(found(folder + "/f") == files);
    }
}

TEST_CASE("render: what the method radiosity cannot serve is one line with the number", "[program][radiosity][refusals]") {
    const std::string folder = fresh_folder("radiosity_refusals"), scene = small_scene(folder), out = folder + "/out";
    set_cache(folder + "/cache");
    const auto asks = [&](const std::string& command, const Words& sets, Words more = {}) {
        for (const std::string& set : sets) more.insert(more.end(), {"--set", set});
        if (command == "render") more.insert(more.end(), {"-o", out});
        return refused(of_radiosity(command, scene, more));
    };
    for (const char* command : {"plan", "render"}) {
        CHECK_THAT(asks(command, {"radiosity.memory_mb=1"}), Contains("small.toml: radiosity:") && Contains("elements are read at a time") && Contains("expected memory_mb = "));
        CHECK_THAT(asks(command, {"radiosity.memory_mb=0"}), Contains("memory_mb = 0"));
        CHECK_THAT(asks(command, {"radiosity.solver=jacobi"}), Contains("auto, passes, shooting, gauss_seidel, bicgstab, conjugate_gradients, direct"));
        CHECK_THAT(asks(command, {"radiosity.tolerance=nan"}), Contains("tolerance = nan"));
        CHECK_THAT(asks(command, {"radiosity.tolerance=-1"}), Contains("tolerance = -1"));
        CHECK_THAT(asks(command, {"radiosity.passes=0"}), Contains("passes = 0"));
    }
    CHECK_THAT(asks("render", {"radiosity.memory_mb=3"}, {"--no-cache"}), Contains("without a cache") && Contains("expected memory_mb = "));
    CHECK_THAT(asks("render", {"radiosity.solver=passes", "radiosity.passes=2"}),
               Contains("small.toml: radiosity: passes: not converged after 2 products") && Contains("tolerance = 0.0001"));
    CHECK_THAT(asks("render", {"radiosity.solver=direct", "radiosity.memory_mb=3"}), Contains("small.toml: radiosity: direct:") && Contains("GB"));
    // What meshes are refined by is solved as it may, however the picture is.
    CHECK_THAT(asks("render", {"radiosity.refine=1", "radiosity.solver=passes", "radiosity.passes=2"}),
               Contains("small.toml: radiosity: passes: not converged after 2 products") && Contains("tolerance = 0.0001"));
    CHECK_FALSE(fs::exists(out));
}
