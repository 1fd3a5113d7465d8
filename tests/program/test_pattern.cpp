// A sample pattern of a user's own: the default pattern as a file gives the default picture to the bit, and bad files are
// refused before anything is written.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>
#include <filesystem>

#include "io/npy.h"
#include "tests/program/program.h"

using namespace plumb;
using namespace plumb::program;
using Catch::Matchers::Contains;

namespace {

template <class T>
T word(const std::string& bytes, std::size_t i) {
    T value;
    REQUIRE(bytes.size() >= (i + 1) * sizeof value);
    std::memcpy(&value, bytes.data() + i * sizeof value, sizeof value);
    return value;
}

// Both lights that shine have maps of 48 texels, so that one pattern serves them.
std::string scene_of(const std::string& folder) {
    const std::string scene = small_scene(folder);
    std::string text = read(scene);
    const std::string sun = "rsm_size = 32";
    text.replace(text.find(sun), sun.size(), "rsm_size = 48");
    write(scene, text);
    return scene;
}

// The pattern that a stage reads of its parameters, as rows: from what is exported for a device.
std::vector<float> exported_rows(const std::string& scene, const std::string& folder, const std::string& stage,
                                 const Words& sets) {
    Words words = {"export", scene, "--stage", stage, "--light", "key", "-o", folder};
    words.insert(words.end(), sets.begin(), sets.end());
    REQUIRE(run(words).exit == 0);
    const std::string offsets = read(folder + "/" + stage + ".key/in/offsets.bin");
    const std::string weights = read(folder + "/" + stage + ".key/in/weights.bin");
    std::vector<float> rows;
    for (std::size_t k = 0; k < weights.size() / 4; ++k) {
        rows.push_back(float(word<std::int16_t>(offsets, 2 * k)));
        rows.push_back(float(word<std::int16_t>(offsets, 2 * k + 1)));
        rows.push_back(word<float>(weights, k));
    }
    return rows;
}

void write_rows(const std::string& path, const std::vector<float>& rows) {
    io::write_npy(path, DType::f32, {std::int64_t(rows.size() / 3), 3}, rows.data());
}

std::string picture(const std::string& scene, const std::string& out, const Words& more) {
    render(scene, out, more);
    return read(out + "/small.exr");
}

}  // namespace

TEST_CASE("pattern: the default pattern as a file gives the same picture to the bit", "[program][pattern]") {
    const std::string folder = fresh_folder("pattern"), scene = scene_of(folder), text = read(scene);
    for (const std::string gather : {"disc", "paths"}) {
        INFO(gather);
        const Words sets = {"--set", "rsm.gather=" + gather, "--set", "rsm.rotations=1"};
        std::vector<float> rows = exported_rows(scene, folder + "/" + gather, "rsm." + gather, sets);
        REQUIRE(rows.size() == 3 * (gather == "disc" ? 37 : 150));
        write_rows(folder + "/mine.npy", rows);
        const std::string expected = picture(scene, folder + "/a", sets);

        // Named by the scene file beside it, or on the command line from where the user is.
        write(scene, text + "pattern = \"mine.npy\"\n");
        CHECK(picture(scene, folder + "/b", sets) == expected);
        write(scene, text);
        Words named = sets;
        named.insert(named.end(), {"--set", "rsm.pattern=" + folder + "/mine.npy"});
        CHECK(picture(scene, folder + "/c", named) == expected);
        const Json json = Json::parse(read(folder + "/c/run.json"));
        CHECK(json["settings"]["rsm"].contains("pattern_hash"));

        // One sample elsewhere, not one of the nearest, which weigh little, is another picture, and other settings, though the name is the same.
        rows[3 * 9] += 5;
        write_rows(folder + "/mine.npy", rows);
        CHECK(picture(scene, folder + "/d", named) != expected);
        CHECK(Json::parse(read(folder + "/d/run.json"))["settings"]["rsm"]["pattern_hash"] !=
              json["settings"]["rsm"]["pattern_hash"]);
    }
}

TEST_CASE("pattern: half a texel counts with continuous texels, and any number of samples is a disc's",
          "[program][pattern]") {
    const std::string folder = fresh_folder("pattern_continuous"), scene = scene_of(folder);
    std::vector<float> rows;
    for (int k = 0; k < 11; ++k) rows.insert(rows.end(), {float(k) - 5, 2 * float(k % 3) - 2, 20});
    write_rows(folder + "/mine.npy", rows);
    const Words whole = {"--set", "rsm.pattern=" + folder + "/mine.npy"};
    Words continuous = whole;
    continuous.insert(continuous.end(), {"--set", "rsm.texels=continuous"});
    const std::string a = picture(scene, folder + "/a", whole), b = picture(scene, folder + "/b", continuous);
    CHECK(a != b);
    CHECK_THAT(read(folder + "/b/run.json"), Contains("rsm.disc_continuous (key)"));
    for (std::size_t i = 0; i < rows.size(); i += 3) rows[i] += 0.25f;
    write_rows(folder + "/mine.npy", rows);
    // 64 rotations round 0.25 away or up for whole texels; each position moves for continuous ones.
    CHECK(picture(scene, folder + "/c", continuous) != b);
    const Words one = {"--set", "rsm.pattern=" + folder + "/mine.npy", "--set", "rsm.rotations=1"};
    const std::string moved = picture(scene, folder + "/d", one);
    for (std::size_t i = 0; i < rows.size(); i += 3) rows[i] -= 0.25f;
    write_rows(folder + "/mine.npy", rows);
    CHECK(picture(scene, folder + "/e", one) == moved);
}

TEST_CASE("pattern: a bad file ends the program before anything is written", "[program][pattern][errors]") {
    const std::string folder = fresh_folder("pattern_bad"), scene = scene_of(folder), text = read(scene);
    write(scene, text + "pattern = \"mine.npy\"\n");
    const std::string file = folder + "/mine.npy";
    auto refused = [&](const Words& more) {
        Words words = {"render", scene, "-o", folder + "/out"};
        words.insert(words.end(), more.begin(), more.end());
        const Result r = run(words);
        CHECK(r.exit == 2);
        CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
        CHECK_FALSE(std::filesystem::exists(folder + "/out"));
        return r.err;
    };
    CHECK_THAT(refused({}), Contains(file) && Contains("small.toml"));
    write_rows(file, {0, 1, 2, 3, 4, 5});
    CHECK_THAT(refused({"--set", "rsm.gather=paths"}), Contains(file) && Contains("has 2 samples") && Contains("10 x steps = 15"));
    write_rows(file, {0, 1, -2});
    CHECK_THAT(refused({}), Contains(file) && Contains("row 0: the weight is -2"));
    const float pairs[] = {1, 2, 3, 4};
    io::write_npy(file, DType::f32, {2, 2}, pairs);
    CHECK_THAT(refused({}), Contains(file) && Contains("[2, 2]: expected [N, 3]"));
    write_rows(file, {0, 1, 2});
    CHECK_THAT(refused({"--set", "rsm.pattern=" + folder + "/none.npy"}),
               Contains("none.npy") && Contains("--set rsm.pattern"));
}

TEST_CASE("pattern: what lies between texels is exported for continuous ones alone, as validate takes it", "[program][pattern][errors]") {
    const std::string folder = fresh_folder("pattern_between"), scene = scene_of(folder), file = folder + "/mine.npy";
    write_rows(file, {3, 1, 20, -2, 0.5f, 20});
    const Words words = {"export", scene, "--light", "key", "--set", "rsm.pattern=" + file, "--set", "rsm.rotations=1"};
    auto exported = [&](const Words& more) {
        Words all = words;
        all.insert(all.end(), more.begin(), more.end());
        return run(all);
    };
    const std::string line = "row 1: 0.5: expected whole texels of at most 32767\n";
    for (const char* stage : {"rsm.disc", "all"}) {
        const Result r = exported({"--stage", stage, "-o", folder + "/whole"});
        CHECK(r.exit == 2);
        CHECK(r.err == "plumb: " + file + ": " + line);
        CHECK_FALSE(std::filesystem::exists(folder + "/whole"));
    }
    CHECK(exported({"--stage", "gbuffer", "-o", folder + "/gbuffer"}).exit == 0);  // reads no pattern
    CHECK(exported({"--stage", "rsm.disc_continuous", "-o", folder + "/between"}).exit == 0);
    CHECK(word<float>(read(folder + "/between/rsm.disc_continuous.key/in/positions.bin"), 3) == 0.5f);

    // The same words where a manifest has the file.
    write_rows(file, {3, 1, 20, -2, 1, 20});
    REQUIRE(exported({"--stage", "rsm.disc", "-o", folder + "/out"}).exit == 0);
    write_rows(file, {3, 1, 20, -2, 0.5f, 20});
    write(folder + "/out/manifest.toml", read(folder + "/out/manifest.toml") + "[stage.input.pattern]\nfile = \"../mine.npy\"\n");
    const Result r = run({"validate", folder + "/out/manifest.toml"});
    CHECK(r.exit == 2);
    CHECK_THAT(r.err, Catch::Contains(": " + line.substr(0, line.find('\n'))) && Catch::Contains("stage = \"rsm.disc_continuous\""));
}
