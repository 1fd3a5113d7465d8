// plumb bake: what cannot be baked or written is one line, and nothing half written is left.
#include <catch2/catch.hpp>
#include <filesystem>
#include <set>

#include "io/bundle_file.h"
#include "io/described_file.h"
#include "tests/program/bake_runs.h"
#include "tests/program/run_until.h"

using namespace plumb;
using namespace plumb::program;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

std::string one_line(const Result& r) {
    CAPTURE(r.out, r.err);
    CHECK(r.exit == 2);
    CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
    return r.err;
}
std::string complains(const Words& words) { return one_line(run(words)); }

}  // namespace

TEST_CASE("bake: numbers that no key of [probes] can have are refused by name, and nothing is written", "[program][refusals]") {
    const std::string folder = fresh_folder("bake_numbers"), scene = small_scene(folder);
    set_cache(folder + "/cache");
    const Words before = files_in(folder);
    // Every key, from what the program itself lists.
    const Result listed = run({"stages", "--json"});
    REQUIRE(listed.exit == 0);
    std::set<std::string> keys;
    const Json stages = Json::parse(listed.out);
    for (const Json& stage : stages)
        if (stage["name"].get<std::string>().starts_with("probes."))
            for (const Json& param : stage["params"]) keys.insert(param["name"]);
    CHECK(keys.size() >= 20);
    const auto refused = [&](const std::string& key, const std::string& value) {
        CAPTURE(key, value);
        const std::string line = complains({"bake", scene, "-o", folder + "/x.bake", "--no-cache", "--set", "probes." + key + "=" + value});
        CHECK_THAT(line, Contains(key));
    };
    for (const std::string& key : keys) refused(key, "nan");
    // What each may be is asked of all of them without the program (tests/gi/test_probes_bake_parameters.cpp).
    for (const char* value : {"0", "-1", "1e9", "1e99", "0.5", "inf", "\"a word\"", "[1, 2]", "true", ""}) refused("receiver_rays", value);
    for (const char* value : {"0", "-1", "1e9", "1e99", "inf", "\"a word\""}) refused("receivers_per_m2", value);
    // The same in a scene's file: with its line.
    write(folder + "/bad.toml", read(scene) + "[probes]\nreceiver_rays = 0\n");
    CHECK_THAT(complains({"bake", folder + "/bad.toml", "-o", folder + "/x.bake", "--no-cache"}), Contains("bad.toml") && Contains("receiver_rays") && Contains("line"));
    fs::remove(folder + "/bad.toml");
    CHECK(files_in(folder) == before);
}

TEST_CASE("bake: scenes without surfaces, or of nothing but backs", "[program][refusals]") {
    const std::string folder = fresh_folder("bake_nothing");
    set_cache(folder + "/cache");
    // Points in a row, whichever way they are written.
    write(folder + "/line.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    CHECK_THAT(complains(baked(folder + "/line.obj", folder + "/x.bake", {"--no-cache"})), Contains("line.obj") && Contains("no surfaces"));
    write(folder + "/empty.toml", "[frame]\nsize = [8, 8]\n");
    CHECK_THAT(complains(baked(folder + "/empty.toml", folder + "/x.bake", {"--no-cache"})), Contains("empty.toml"));
    CHECK_FALSE(fs::exists(folder + "/x.bake"));
    // Two sheets back to back: each sees the sky, or, without one, nothing; a bake says so.
    write(folder + "/sheets.obj", "v 0 0 0\nv 1 0 0\nv 0 0 1\nv 1 0 1\nf 1 2 4 3\nf 1 3 4 2\n");
    const Result r = run(baked(folder + "/sheets.obj", folder + "/x.bake", {"--no-cache"}));
    CAPTURE(r.out, r.err);
    CHECK(r.exit == 0);
    CHECK(r.err.empty());
    CHECK_THAT(r.out, Contains("stay black"));
    CHECK(run({"bake", folder + "/sheets.obj", "--verify", folder + "/x.bake"}).exit == 0);
}

TEST_CASE("bake: files that are no bakes are refused for what they are", "[program][refusals][malformed]") {
    const std::string folder = fresh_folder("bake_foreign"), scene = small_scene(folder);
    set_cache(folder + "/cache");
    succeed(baked(scene, folder + "/a.bake", {"--no-cache", "--textures", folder + "/textures", "--set", "probes.degree=0"}));
    const auto verify = [&](const std::string& file) {
        const std::string line = complains({"bake", scene, "--verify", file});
        CHECK_THAT(line, Contains(fs::path(file).filename().string()));
        return line;
    };
    write(folder + "/empty", "");
    CHECK_THAT(verify(folder + "/empty"), Contains("empty"));
    write(folder + "/zeros", std::string(4096, '\0'));
    verify(folder + "/zeros");
    write(folder + "/text", "a bake");
    verify(folder + "/text");
    verify(scene);
    verify(folder);
    verify("/dev/null");
    for (const std::string& name : files_in(folder + "/textures"))
        if (name.ends_with(".npy")) verify(folder + "/textures/" + name);
    io::write_bundle(folder + "/a.bundle", {});
    CHECK_THAT(verify(folder + "/a.bundle"), Contains("is a bundle; expected a file of kind \"probe bake\""));
    io::DescribedFile other = io::read_described(folder + "/a.bake", {"probe bake", 1, 1});
    other.kind = "probe textures";
    io::write_described(folder + "/other_kind", other);
    CHECK_THAT(verify(folder + "/other_kind"), Contains("is a file of kind \"probe textures\""));
    other.kind = "probe bake", other.version = 2;
    io::write_described(folder + "/other_version", other);
    CHECK_THAT(verify(folder + "/other_version"), Contains("version 2 of \"probe bake\"; this program reads 1"));
    // A block of the store is none either.
    succeed(baked(scene, folder + "/b.bake", {"--store", folder + "/store"}));
    for (const std::string& name : files_in(folder + "/store")) verify(folder + "/store/" + name);
}

TEST_CASE("bake: a place that cannot be written to is told before anything is computed", "[program][refusals]") {
    const std::string folder = fresh_folder("bake_unwritable"), scene = small_scene(folder);
    set_cache(folder + "/cache");
    write(folder + "/file", "");
    fs::create_directories(folder + "/store");
    const auto refused = [&](const std::string& file, const Words& more = {}) {
        Words words = baked(scene, file, {"--store", folder + "/store"});
        words.insert(words.end(), more.begin(), more.end());
        const Result r = run(words);
        CHECK(r.out.empty());  // not even what it will take
        CHECK(files_in(folder + "/store").empty());
        return one_line(r);
    };
    CHECK_THAT(refused("/proc/x.bake"), Contains("/proc/x.bake: cannot be written"));
    CHECK_THAT(refused(folder + "/file/x.bake"), Contains("cannot be written"));
    CHECK_THAT(refused(folder + "/" + std::string(300, 'x')), Contains("cannot be written"));
    CHECK_THAT(refused(folder + "/" + std::string(250, 'x')), Contains("cannot be written"));
    CHECK_THAT(refused(folder + "/x.bake", {"--html", "/proc/x.html"}), Contains("/proc/x.html: cannot be written"));
    CHECK_THAT(refused(folder), Contains("is a folder"));
    for (const char* option : {"--textures", "--debug-layers"}) {
        CHECK_THAT(refused(folder + "/x.bake", {option, "/proc/none"}), Contains("/proc/none"));
        CHECK_THAT(refused(folder + "/x.bake", {option, folder + "/file"}), Contains("/file"));
    }
    CHECK_FALSE(fs::exists(folder + "/x.bake"));
    for (const std::string& name : files_in(folder)) CHECK(name.find("xxx") == std::string::npos);
    // A device takes it as it comes, or says why not.
    const Result full = run(baked(scene, "/dev/full", {"--no-cache"}));
    CHECK_THAT(one_line(full), Contains("/dev/full: cannot be written: No space left on device"));
    CHECK(run(baked(scene, "/dev/null", {"--no-cache"})).exit == 0);
}

TEST_CASE("bake: a disk that is full leaves the old file and no other", "[program][refusals]") {
    const std::string folder = fresh_folder("bake_full"), scene = scene_in(folder);
    set_cache(folder + "/cache");
    succeed(baked(scene, folder + "/x.bake", {"--no-cache", "--set", "probes.degree=0"}));
    const std::string old = read(folder + "/x.bake");
    const Words before = files_in(folder);
    // Of a store what fits is kept, and whole; nothing is there in part.
    const auto check_store = [&](const std::string& store) {
        for (const std::string& name : files_in(store)) {
            CAPTURE(name);
            CHECK(name[0] != '.');
            CHECK(fs::file_size(store + "/" + name) <= 200000);
        }
    };
    for (const Words& more : {Words{"--no-cache"}, Words{"--store", folder + "/store"}}) {
        const Result r = run_on_full_disk(baked(scene, folder + "/x.bake", more), 200000);
        CHECK_THAT(one_line(r), Contains("x.bake: cannot be written: File too large"));
        CHECK(read(folder + "/x.bake") == old);
        Words there = files_in(folder);
        std::erase_if(there, [](const std::string& name) { return name.starts_with("store/"); });
        CHECK(there == before);
    }
    check_store(folder + "/store");
    // A part is nothing but its blocks.
    Words part = {"bake", scene, "--part", "1/2", "--store", folder + "/parts"};
    part.insert(part.end(), few.begin(), few.end());
    CHECK_THAT(one_line(run_on_full_disk(part, 200000)), Contains("--part 1/2: ") && Contains("File too large"));
    check_store(folder + "/parts");
    // With room again both go on.
    succeed(baked(scene, folder + "/whole.bake", {"--no-cache"}));
    for (const char* store : {"/store", "/parts"}) {
        const Result r = run(baked(scene, folder + "/y.bake", {"--store", folder + store}));
        CHECK(r.exit == 0);
        CHECK_THAT(r.out, !Contains("anew"));
        CHECK(read(folder + "/y.bake") == read(folder + "/whole.bake"));
    }
}
