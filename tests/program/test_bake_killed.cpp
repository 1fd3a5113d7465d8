// plumb bake, killed: nothing half written has a file's name, and what is started again makes the same bytes.
#include <signal.h>

#include <catch2/catch.hpp>
#include <filesystem>

#include "core/hash.h"
#include "tests/program/bake_runs.h"
#include "tests/program/run_until.h"

using namespace plumb;
using namespace plumb::program;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

// Of the k-th kill, in [0, 1).
double random_share(int k) { return double(unit_float<double>(pixel_hash<std::int32_t>(k, 1, 2, 3).x)); }

// Whole files of the store: a run that was killed leaves hidden parts of others beside them.
int kept_in(const std::string& store) {
    int n = 0;
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(store, error)) n += entry.path().filename().string()[0] == '.' ? 0 : 1;
    return n;
}
bool is_being_written(const std::string& folder) {
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
        const std::string name = entry.path().filename().string();
        if (name.starts_with(".x.bake.")) return true;
    }
    return false;
}

// Where a bake spends its time, as its own report says: s. Each step is a file of the store.
struct Times {
    double until_blocks = 0, block = 0, clusters = 0;
    int first_block = 0, blocks = 0;
    int steps() const { return first_block + blocks; }  // before the clusters
};
Times times_of(const std::string& scene, const std::string& folder) {
    const Result r = run(baked(scene, folder + "/timed.bake", {"--no-cache", "--json", "--with-alpha"}));
    REQUIRE(r.exit == 0);
    Times t;
    const Json report = Json::parse(r.out);
    for (const Json& step : report["steps"]) {
        const std::string name = step.at("name");
        const double s = step.at("ms").get<double>() / 1000;
        if (name.starts_with("probes.coefficients")) {
            t.block += s, ++t.blocks;
        } else {
            (name == "probes.clusters" ? t.clusters : t.until_blocks) += s;
            t.first_block += name == "probes.clusters" ? 0 : 1;
        }
    }
    REQUIRE(t.blocks >= 3);
    t.block /= t.blocks;
    return t;
}

// What a run was doing when it was killed, by what it has left.
enum Phase { before_blocks, among_blocks, among_clusters, in_writing, had_ended };
Phase phase_of(const Result& r, const std::string& store, const Times& times) {
    const int kept = kept_in(store);
    if (r.exit == 0) return had_ended;
    REQUIRE(r.exit == 128 + SIGKILL);
    return kept < times.first_block ? before_blocks
           : kept < times.steps()   ? among_blocks
           : kept == times.steps()  ? among_clusters
                                    : in_writing;
}

}  // namespace

TEST_CASE("bake: killed at 20 random moments, from its start to the writing of its file, and resumed: the same bytes", "[program]") {
    const std::string folder = fresh_folder("bake_killed"), scene = scene_in(folder);
    set_cache(folder + "/cache");
    succeed(baked(scene, folder + "/whole.bake", {"--no-cache", "--with-alpha"}));
    const std::string whole = read(folder + "/whole.bake");
    const Times times = times_of(scene, folder);
    int of_phase[5] = {};
    for (int k = 0; k < 20; ++k) {
        const std::string out = folder + "/" + std::to_string(k), store = out + "/store";
        fs::create_directories(store);
        const Words bake = baked(scene, out + "/x.bake", {"--store", store, "--with-alpha"});
        // A quarter in each phase, at a random moment of it.
        const double share = random_share(k);
        const int wanted = k % 4, block = int(share * (times.blocks - 1));
        const auto reached = [&] {
            return wanted == among_blocks     ? kept_in(store) >= times.first_block + block
                   : wanted == among_clusters ? kept_in(store) == times.steps()
                                              : kept_in(store) > times.steps() && is_being_written(out);
        };
        const double within = random_share(100 + k);
        const double seconds = wanted == before_blocks    ? share * times.until_blocks
                               : wanted == among_blocks   ? within * times.block
                               : wanted == among_clusters ? share * times.clusters
                                                          : 0;
        const Result killed = wanted == before_blocks ? run_and_kill(bake, seconds) : run_and_kill(bake, seconds, reached);
        const Phase phase = phase_of(killed, store, times);
        ++of_phase[phase];
        CAPTURE(k, wanted, phase);
        // Under its name there is nothing, or all of it.
        for (const std::string& name : files_in(out)) {
            CAPTURE(name);
            CHECK((name == "x.bake" || name.starts_with(".x.bake.") || name.starts_with("store/")));
        }
        if (fs::exists(out + "/x.bake")) CHECK(read(out + "/x.bake") == whole);
        const int kept = kept_in(store);
        Words again = bake;
        again.insert(again.end(), {"--resume", "--json"});
        const Result resumed = run(again);
        REQUIRE(resumed.exit == 0);
        CHECK(resumed.err.empty());
        CHECK(read(out + "/x.bake") == whole);
        // What the killed run had half written is gone, here and in the store.
        for (const std::string& name : files_in(out)) CHECK_THAT(name, !Contains(".part"));
        // What was kept is believed.
        const Json report = Json::parse(resumed.out);
        int found = 0;
        for (const Json& step : report["steps"]) found += step["kept"] == true ? 1 : 0;
        CHECK(found == kept);
        fs::remove_all(out);
    }
    CAPTURE(of_phase[before_blocks], of_phase[among_blocks], of_phase[among_clusters], of_phase[in_writing], of_phase[had_ended]);
    CHECK(of_phase[before_blocks] >= 2);
    CHECK(of_phase[among_blocks] >= 3);
    CHECK(of_phase[among_clusters] >= 2);
    CHECK(of_phase[in_writing] >= 3);
}

TEST_CASE("bake: what is kept is not made twice, and Ctrl-C leaves nothing", "[program]") {
    const std::string folder = fresh_folder("bake_interrupted"), scene = scene_in(folder);
    set_cache(folder + "/cache");
    succeed(baked(scene, folder + "/whole.bake", {"--store", folder + "/store"}));
    const std::string whole = read(folder + "/whole.bake");
    const Result again = run(baked(scene, folder + "/x.bake", {"--resume", "--store", folder + "/store", "--json"}));
    REQUIRE(again.exit == 0);
    const Json report = Json::parse(again.out);
    CHECK(report["steps"].size() > 8);
    for (const Json& step : report["steps"]) CHECK(step["kept"] == true);
    // No file, or all of it where the signal came late.
    fs::remove(folder + "/x.bake"), fs::remove_all(folder + "/store"), fs::create_directories(folder + "/store");
    const Result interrupted = run_and_signal(baked(scene, folder + "/x.bake", {"--store", folder + "/store"}), SIGINT, folder + "/store", "");
    CHECK(interrupted.exit == 130);
    if (fs::exists(folder + "/x.bake")) CHECK(read(folder + "/x.bake") == whole);
    for (const std::string& name : files_in(folder)) CHECK((name == "x.bake" || name.find("x.bake") == std::string::npos));
}

TEST_CASE("bake: what a killed run of another machine left of its file goes a day later", "[program]") {
    const std::string folder = fresh_folder("bake_left_over"), scene = scene_in(folder);
    set_cache(folder + "/cache");
    const std::string old = folder + "/.x.bake.123-0.part", fresh = folder + "/.x.bake.124-0.part", other = folder + "/.y.bake.123-0.part";
    for (const std::string& part : {old, fresh, other}) write(part, "half");  // which machine's it is, no name says
    for (const std::string& part : {old, other}) fs::last_write_time(part, fs::file_time_type::clock::now() - std::chrono::hours(25));
    succeed(baked(scene, folder + "/x.bake", {"--no-cache"}));
    CHECK_FALSE(fs::exists(old));
    CHECK(fs::exists(fresh));  // another run may be writing it
    CHECK(fs::exists(other));
}
