// The method probes as its user meets it: a bake that is made and kept, one that is read, plan, explain, export and validate.
#include <catch2/catch.hpp>
#include <filesystem>

#include "tests/program/bake_runs.h"

using namespace plumb::program;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

Words with(Words words, const Words& more) {
    words.insert(words.end(), more.begin(), more.end());
    return words;
}
Words of_probes(const std::string& command, const std::string& scene, const Words& more = {}) {
    return with(with({command, scene, "--method", "probes", "--size", "48x36"}, few), more);
}
std::string picture(const std::string& folder) { return read(folder + "/box.exr"); }

std::string complains(const Words& words) {
    const Result r = run(words);
    CAPTURE(r.out, r.err);
    CHECK(r.exit == 2);
    CHECK(r.out.empty());
    CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
    return r.err;
}

}  // namespace

TEST_CASE("render: the method probes bakes where there is no bake, keeps it, and reads a file", "[program][probes]") {
    const std::string folder = fresh_folder("render_probes"), scene = scene_in(folder);
    set_cache(folder + "/cache");
    const Result plan = run(of_probes("plan", scene));
    CHECK(plan.exit == 0);
    CHECK_THAT(plan.out, Contains("without a bake one is made and kept: about") && Contains("probes.lookup"));
    CHECK_FALSE(fs::exists(folder + "/cache"));

    const Result made = run(of_probes("render", scene, {"-o", folder + "/a"}));
    CAPTURE(made.out, made.err);
    REQUIRE(made.exit == 0);
    CHECK_THAT(made.out, Contains("receivers, 5 probes") && Contains("rounds, gain"));
    CHECK(files_in(folder + "/cache").size() > 5);
    const std::string a = picture(folder + "/a");
    // From the store, from a file, on one thread: the same picture.
    succeed(of_probes("render", scene, {"-o", folder + "/b", "--threads", "1", "--isa", "scalar"}));
    CHECK(picture(folder + "/b") == a);
    succeed(baked(scene, folder + "/box.bake"));
    succeed(of_probes("render", scene, {"-o", folder + "/c", "--set", "probes.file=" + folder + "/box.bake"}));
    CHECK(picture(folder + "/c") == a);
    // With light that is reflected, and not without.
    succeed({"render", scene, "--method", "direct", "--size", "48x36", "-o", folder + "/direct"});
    CHECK(picture(folder + "/direct") != a);

    CHECK_THAT(complains(of_probes("render", scene, {"-o", folder + "/d", "--set", "probes.file=" + folder + "/none.bake"})), Contains("none.bake"));
    const std::string bytes = read(folder + "/box.bake");
    write(folder + "/cut.bake", bytes.substr(0, bytes.size() / 2));
    CHECK_THAT(complains(of_probes("render", scene, {"-o", folder + "/d", "--set", "probes.file=" + folder + "/cut.bake"})), Contains("cut.bake"));
    REQUIRE(run({"make-scene", "shapes", "-o", folder + "/shapes"}).exit == 0);
    CHECK_THAT(complains(of_probes("render", folder + "/shapes/shapes.toml", {"-o", folder + "/d", "--set", "probes.file=" + folder + "/box.bake"})),
               Contains("box.bake") && Contains("another scene"));
    CHECK_THAT(complains(of_probes("render", scene, {"-o", folder + "/d", "--set", "probes.loop=convergd"})), Contains("converged, pipelined"));
    CHECK_THAT(complains(of_probes("render", scene, {"-o", folder + "/d", "--set", "lod.levels=5"})), Contains("levels"));
    CHECK_THAT(complains(of_probes("render", scene, {"-o", folder + "/d", "--set", "probes.feedback=constant", "--set", "probes.reflection=2"})),
               Contains("light still grows"));
    CHECK_FALSE(fs::exists(folder + "/d"));
}

TEST_CASE("export: passes of the method probes, which validate as equal and not where one number is wrong", "[program][probes]") {
    const std::string folder = fresh_folder("export_probes"), scene = scene_in(folder);
    set_cache(folder + "/cache");
    for (const std::string stage : {"probes.radiance", "probes.lambda", "probes.basis", "probes.irradiance", "probes.lightmap", "probes.lightmap_uv",
                                    "probes.lookup"}) {
        CAPTURE(stage);
        const std::string to = folder + "/" + stage;
        succeed(of_probes("export", scene, {"--stage", stage, "-o", to}));
        CHECK(run({"validate", to + "/manifest.toml"}).exit == 1);  // nothing was written
        const fs::path pass = to + "/" + stage;
        REQUIRE(fs::exists(pass / "expected"));
        fs::copy(pass / "expected", pass / "out", fs::copy_options::overwrite_existing | fs::copy_options::recursive);
        const Result right = run({"validate", to + "/manifest.toml"});
        CAPTURE(right.out, right.err);
        CHECK(right.exit == 0);
        for (const auto& file : fs::directory_iterator(pass / "out")) {
            std::string bytes = read(file.path().string());
            // The first number that is not 0 gets another exponent.
            std::size_t at = 0;
            while (at + 4 < bytes.size() && bytes.substr(at, 4) == std::string(4, '\0')) at += 4;
            bytes[at + 3] = char(bytes[at + 3] ^ 1);
            write(file.path().string(), bytes);
            break;
        }
        CHECK(run({"validate", to + "/manifest.toml"}).exit == 1);
    }
    const Result explained = run(of_probes("explain", scene, {"--stage", "probes.lookup", "--pixel", "20,20"}));
    CAPTURE(explained.out, explained.err);
    CHECK(explained.exit == 0);
    CHECK_THAT(explained.out, Contains("lightmap_place") && Contains("irradiance"));
}
