// Wrong inputs of the method probes: each is one line that names the place and the cause, exit code 2, and nothing is written.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>

#include "tests/program/bake_runs.h"

using namespace plumb::program;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

struct Wrong {
    Words sets;           // key=value
    std::string contains;  // of the line
};

Words words_of(const std::string& command, const std::string& scene, const Words& sets, const Words& more) {
    Words words = {command, scene};
    if (command != "bake") words.insert(words.end(), {"--method", "probes", "--size", "32x24"});
    words.insert(words.end(), few.begin(), few.end());
    for (const std::string& set : sets) words.insert(words.end(), {"--set", set});
    words.insert(words.end(), more.begin(), more.end());
    return words;
}

void refused(const Words& words, const std::string& contains) {
    CAPTURE(words);
    const Result r = run(words);
    CAPTURE(r.out, r.err);
    CHECK(r.exit == 2);
    CHECK(r.out.empty());
    CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
    CHECK_THAT(r.err, Contains(contains));
}

}  // namespace

TEST_CASE("probes: what no frame can have is told before a bake is made, by every command", "[program][probes][refusals]") {
    const std::string folder = fresh_folder("probes_refusals"), scene = scene_in(folder), out = folder + "/out";
    set_cache(folder + "/cache");
    write(folder + "/empty.bake", "");
    const Words before = files_in(folder);
    const std::vector<Wrong> wrong = {
        {{"probes.lop=1"}, "nearest known one is 'loop'"},
        {{"lod.levles=2"}, "nearest known one is 'levels'"},
        {{"probes.tolerance=nan"}, "tolerance = nan"},
        {{"probes.reflection=inf"}, "reflection = inf"},
        {{"probes.reflection=-0.5"}, "reflection = -0.5"},
        {{"probes.rounds=0"}, "rounds = 0"},
        {{"probes.loop=pipeline"}, "expected one of converged, pipelined"},
        {{"probes.window=cosine"}, "none, hann, lanczos"},
        {{"lod.levels=0"}, "levels = 0"},
        {{"lod.levels=5"}, "levels = 5"},
        {{"lod.levels=1.5"}, "levels = 1.5"},
        {{"lod.levels=2", "lod.distance_1=nan"}, "distance_1 = nan"},
        {{"lod.levels=4", "lod.distance_1=10", "lod.distance_2=5"}, "box.toml: lod: distance_2 = 5 m"},
        {{"lod.levels=2", "lod.degree_0=2", "lod.degree_1=5"}, "box.toml: lod: degree_1 = 5"},
        {{"lod.levels=2", "lod.rays_1=7"}, "box.toml: lod: rays_1 = 7"},
        {{"lod.levels=2", "lod.rays_0=1024"}, "box.toml: lod: rays_0 = 1024: the bake has 32"},
        {{"lod.levels=2", "lod.zones=true", "lod.front_angle=120", "lod.side_angle=60"}, "box.toml: lod: side_angle"},
        {{"probes.spatial_receivers=1e12"}, "spatial_receivers"},
        {{"probes.spatial_receivers=-3"}, "spatial_receivers = -3"},
        {{"probes.lightmap_size=20000"}, "lightmap_size = 20000"},
        {{"probes.lightmap_size=-1"}, "lightmap_size = -1"},
        {{"probes.lightmap_size=0", "probes.receivers_per_m2=1e12"}, "box.toml: atlas: 24 m2"},
        {{"probes.count=-1"}, "count = -1"},
        {{"probes.degree=8"}, "degree = 8"},
        {{"probes.overlaps=0"}, "overlaps = 0"},
        {{"probes.file=" + folder + "/none.bake"}, "none.bake"},
        {{"probes.file=" + folder}, "not a regular file"},
        {{"probes.file=" + scene}, "box.toml"},
        {{"probes.file=" + folder + "/empty.bake"}, "empty.bake: byte 0: is empty"},
    };
    for (const Wrong& w : wrong) {
        refused(words_of("plan", scene, w.sets, {}), w.contains);
        refused(words_of("render", scene, w.sets, {"-o", out}), w.contains);
    }
    // The other commands read the same words by the same functions: a few of each kind.
    for (const std::size_t i : {std::size_t(2), std::size_t(9), std::size_t(15), std::size_t(25)}) {
        refused(words_of("export", scene, wrong[i].sets, {"--stage", "probes.lookup", "-o", out}), wrong[i].contains);
        refused(words_of("explain", scene, wrong[i].sets, {"--stage", "probes.lookup", "--pixel", "1,1"}), wrong[i].contains);
    }
    // A stage that is not there, or has nothing to show.
    refused(words_of("explain", scene, {}, {"--stage", "probes.lokup", "--pixel", "1,1"}), "'probes.lookup'");
    refused(words_of("explain", scene, {}, {"--stage", "probes.lookup", "--pixel", "32,0"}), "outside of the picture");
    refused(words_of("export", scene, {}, {"--stage", "probes.lokup", "-o", out}), "\"probes.lookup\"");
    refused(words_of("export", scene, {}, {"--stage", "probes.rounds", "-o", out}), "has no twin");
    CHECK(files_in(folder) == before);  // no bake was begun for any of them
}

TEST_CASE("probes: what only a bake or a run can tell names the scene", "[program][probes][refusals]") {
    const std::string folder = fresh_folder("probes_refusals_late"), scene = scene_in(folder), out = folder + "/out";
    set_cache(folder + "/cache");
    refused(words_of("render", scene, {"probes.lightmap_size=1"}, {"-o", out}), "box.toml: atlas: a lightmap of 1 x 1");
    refused(words_of("bake", scene, {"probes.lightmap_size=1"}, {"-o", folder + "/x.bake"}), "box.toml: atlas: a lightmap of 1 x 1");
    refused(words_of("render", scene, {"probes.feedback=constant", "probes.reflection=3"}, {"-o", out}), "box.toml: probes: after");
    refused(words_of("explain", scene, {}, {"--stage", "probes.rounds", "--pixel", "0,0"}), "a step of the host");
    // Coefficients are no pixels: as many as there are may be asked for, whatever the size of the picture.
    const Result far = run(words_of("explain", scene, {}, {"--stage", "probes.lambda", "--pixel", "63,4"}));
    CAPTURE(far.err);
    CHECK(far.exit == 0);
    refused(words_of("explain", scene, {}, {"--stage", "probes.lambda", "--pixel", "64,4"}), "probes.lambda, which is 64 x 5");
    CHECK_FALSE(fs::exists(out));
    CHECK_FALSE(fs::exists(folder + "/x.bake"));
}
