// plumb render --frames: numbered pictures, each the same as one rendered alone; what was reused, and what that saved.
#include <signal.h>
#include <sys/resource.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fmt/format.h>

#include "io/image_file.h"
#include "tests/program/program.h"

using namespace plumb;
using namespace plumb::program;
using Catch::Matchers::Contains;

namespace {

const std::string moving_camera = R"(
[[keyframe]]
frame = 0
camera = { position = [0, 0.995, 3.934], look_at = [0, 0.995, 0] }
[[keyframe]]
frame = 4
camera = { position = [0.4, 1.2, 3.6], look_at = [0, 0.9, 0] }
)";
const std::string moving_light = R"(
[[keyframe]]
frame = 0
light.key.position = [0, 1.97, 0]
[[keyframe]]
frame = 4
light.key.position = [0.3, 1.8, 0.2]
light.lamp.on = true
)";
const std::string moving_mesh = R"(
[[keyframe]]
frame = 0
mesh.box.translate = [0, 0, 0]
[[keyframe]]
frame = 4
mesh.box = { translate = [0.1, 0.05, 0], rotate_deg = [20, 0, 0] }
)";

// The small Cornell box with another mesh, "box", and keyframes.
std::string moving_scene(const std::string& folder, const std::string& keyframes) {
    const std::string scene = small_scene(folder, "[30, 22]");
    write(folder + "/box.obj", "v -0.3 0.2 0.9\nv 0.3 0.2 0.9\nv 0 0.7 0.9\nf 1 2 3\n");
    write(scene, read(scene) + "[[mesh]]\nname = \"box\"\nfile = \"box.obj\"\n" + keyframes);
    return scene;
}

// Each frame's files are those of a run that renders it alone.
void check_against_single(const std::string& scene, const std::string& folder, int first, int count,
                          const Words& more = {}) {
    Words words = {"--frames", std::to_string(count), "--first", std::to_string(first)};
    words.insert(words.end(), more.begin(), more.end());
    render(scene, folder + "/all", words);
    for (int f = first; f < first + count; ++f) {
        CAPTURE(f);
        const std::string out = folder + "/one" + std::to_string(f);
        Words single = {"--first", std::to_string(f)};
        single.insert(single.end(), more.begin(), more.end());
        render(scene, out, single);
        int files = 0;
        for (const std::string& name : files_in(out)) {
            if (name == "run.json") continue;
            CAPTURE(name);
            const std::string number = ".000" + std::to_string(f);
            CHECK(read(out + "/" + name) == read(folder + "/all/small" + number + name.substr(5)));
            ++files;
        }
        CHECK(files >= 3);
    }
}

Words kept_in(const Json& frame) {
    Words names;
    for (const Json& s : frame["stages"])
        if (s["kept"]) names.push_back(s["name"]);
    return names;
}

}  // namespace

TEST_CASE("frames: each is the file of a run that renders it alone", "[program][frames]") {
    const struct {
        const char* name;
        const std::string& keyframes;
    } cases[] = {{"camera", moving_camera}, {"light", moving_light}, {"mesh", moving_mesh}};
    for (const auto& [name, keyframes] : cases) {
        CAPTURE(name);
        const std::string folder = fresh_folder(std::string("frames_") + name);
        check_against_single(moving_scene(folder, keyframes), folder, 2, 3);
    }
    const std::string small = fresh_folder("frames_size"), scene = moving_scene(small, moving_mesh);
    check_against_single(scene, small, 0, 2, {"--size", "17x23"});
    const compare::Picture picture = io::read_picture(small + "/all/small.0001.exr");
    CHECK(picture.width == 17);
    CHECK(picture.height == 23);
    const std::string folder = fresh_folder("frames_truth");
    check_against_single(moving_scene(folder, moving_light), folder, 0, 2,
                         {"--truth", "--spp", "16", "--rays", "exact", "--no-cache"});
}

TEST_CASE("frames: run.json and the text say what each reused", "[program][frames][contract]") {
    const std::string folder = fresh_folder("frames_json"), scene = moving_scene(folder, moving_camera);
    const Result text = render(scene, folder + "/out", {"--frames", "3"});
    CHECK(files_in(folder + "/out") ==
          Words{"run.json", "small.0000.exr", "small.0000.png", "small.0000.rsm.key.exr", "small.0000.rsm.sun.exr",
                "small.0001.exr", "small.0001.png", "small.0001.rsm.key.exr", "small.0001.rsm.sun.exr",
                "small.0002.exr", "small.0002.png", "small.0002.rsm.key.exr", "small.0002.rsm.sun.exr"});
    CHECK_THAT(text.out, Contains("rsm (key), rsm (sun)"));
    CHECK_THAT(text.out, Contains("kept 4 of 30 stages, "));
    CHECK_THAT(text.out, Contains("wrote " + folder + "/out/small.0002.png"));

    const Json json = Json::parse(read(folder + "/out/run.json"));
    CHECK(keys(json) == Words{"version", "scene", "settings", "isa", "threads", "frames", "needed_stages", "kept_stages", "read_ms",
                              "render_ms", "write_ms", "total_ms", "saved_ms", "peak_bytes"});
    REQUIRE(json["frames"].size() == 3);
    double render_ms = 0, write_ms = 0;
    for (int f = 0; f < 3; ++f) {
        const Json& frame = json["frames"][std::size_t(f)];
        CHECK(keys(frame) == Words{"frame", "stages", "lights", "total_ms", "write_ms", "saved_ms"});
        CHECK(frame["write_ms"].get<double>() > 0);
        render_ms += frame["total_ms"].get<double>(), write_ms += frame["write_ms"].get<double>();
        CHECK(frame["frame"] == f);
        CHECK(kept_in(frame) == (f == 0 ? Words{} : Words{"rsm (key)", "rsm (sun)"}));
        for (const Json& light : frame["lights"]) {
            CHECK(light["kept"] == (light["on"] && f > 0 ? 1 : 0));
            CHECK((light["saved_ms"].get<double>() > 0) == (light["on"] && f > 0));
        }
        for (const Json& s : frame["stages"]) {
            CHECK(keys(s) == Words{"name", "needed", "kept", "reason", "rule", "ms", "saved_ms", "parts", "bytes", "reads", "key"});
            if (!s["kept"]) continue;
            CHECK(s["reason"] == "kept: nothing that it reads has changed");
            CHECK(s["saved_ms"].get<double>() > s["ms"].get<double>());
        }
    }
    CHECK(json["render_ms"].get<double>() == Approx(render_ms));
    CHECK(json["write_ms"].get<double>() == Approx(write_ms));
    CHECK(json["read_ms"].get<double>() > 0);
    CHECK(json["total_ms"].get<double>() > json["read_ms"].get<double>() + render_ms);
    CHECK(json["kept_stages"] == 4);
    CHECK(json["needed_stages"] == 30);

    const Result printed = render(scene, folder + "/json", {"--frames", "2", "--first", "4", "--json"});
    CHECK(Json::parse(printed.out)["frames"][0]["frame"] == 4);
    CHECK(printed.out == read(folder + "/json/run.json"));
    // Behind the last keyframe nothing moves any more.
    CHECK(kept_in(Json::parse(printed.out)["frames"][1]).size() == 10);
}

TEST_CASE("frames: without keyframes all is kept, and said", "[program][frames]") {
    const std::string folder = fresh_folder("frames_still"), scene = small_scene(folder, "[20, 16]");
    const Result r = render(scene, folder + "/out", {"--frames", "2"});
    CHECK_THAT(r.out, Contains("note: no [[keyframe]] in the file: nothing moves, and every frame is the same"));
    CHECK_THAT(r.out, Contains("everything"));
    CHECK(read(folder + "/out/small.0000.exr") == read(folder + "/out/small.0001.exr"));
}

TEST_CASE("frames: of light that is reused a layer has how many frames it is the mean of", "[program][frames][reuse]") {
    const std::string out = fresh_folder("frames_reused"), scene = std::string(PLUMB_SOURCE_DIR) + "/data/scenes/cornell/cornell_reuse.toml";
    render(scene, out, {"--size", "24x24", "--frames", "3"});
    for (int f = 0; f < 3; ++f) {
        const std::string file = fmt::format("{}/cornell_reuse.{:04}.gathered.exr", out, f);
        const compare::Picture picture = io::read_picture(file);
        CAPTURE(f);
        int seen = 0;
        for (const float frames : io::select_layer(picture, "frames", file).data) {
            if (frames > 0) CHECK(frames == Approx(f + 1).epsilon(1e-3));
            seen += frames > 0;
        }
        CHECK(seen > 24 * 24 / 2);
        for (const float ghost : io::select_layer(picture, "ghost", file).data) CHECK(ghost >= 0);
    }
}

TEST_CASE("frames: references of each frame are kept in the cache", "[program][frames]") {
    const std::string folder = fresh_folder("frames_cache"), scene = moving_scene(folder, moving_light);
    set_cache(folder + "/cache");
    const Words words = {"--frames", "2", "--truth", "--spp", "16", "--json"};
    const Json first = Json::parse(render(scene, folder + "/a", words).out);
    const Json again = Json::parse(render(scene, folder + "/b", words).out);
    for (std::size_t f : {0, 1}) {
        CHECK_FALSE(first["frames"][f]["truth"]["cached"]);
        CHECK(again["frames"][f]["truth"]["cached"]);
    }
    CHECK(read(folder + "/a/small.0001.exr") == read(folder + "/b/small.0001.exr"));
}

TEST_CASE("frames: a later frame that does not fit leaves one line and no file", "[program][frames][robustness]") {
    const std::string folder = fresh_folder("frames_full");
    // Turns to the box from where nothing is: that frame's layers are constant, and its maps are not drawn.
    const std::string scene = moving_scene(folder, "[[keyframe]]\nframe = 0\ncamera.look_at = [0, 0.995, 9]\n"
                                                   "[[keyframe]]\nframe = 1\ncamera.look_at = [0, 0.995, 0]\n");
    const Words words = {"render", scene, "-o", folder + "/out", "--frames", "2", "--size", "300x200"};
    REQUIRE(run(words).exit == 0);
    const auto size = [&](const char* name) { return std::filesystem::file_size(folder + "/out/" + name); };
    const auto largest_of_first = std::max(size("small.0000.exr"), size("small.0000.png"));
    REQUIRE(size("small.0001.exr") > 2 * largest_of_first);
    std::filesystem::remove_all(folder + "/out");

    // The program inherits both: a file that grows beyond the limit is an error of write(), as a full disk is.
    rlimit before;
    REQUIRE(getrlimit(RLIMIT_FSIZE, &before) == 0);
    signal(SIGXFSZ, SIG_IGN);
    const rlimit small{largest_of_first + 1000, before.rlim_max};
    REQUIRE(setrlimit(RLIMIT_FSIZE, &small) == 0);
    const Result r = run(words);
    setrlimit(RLIMIT_FSIZE, &before);
    signal(SIGXFSZ, SIG_DFL);
    CHECK(r.exit == 2);
    CHECK(r.err == "plumb: " + folder + "/out/small.0001.exr: cannot be written: File too large\n");
    CHECK(r.out.empty());
    CHECK_FALSE(std::filesystem::exists(folder + "/out"));
}

TEST_CASE("frames: what cannot be is one line, and nothing is written", "[program][frames][robustness]") {
    const std::string folder = fresh_folder("frames_bad");
    // Half-way, the camera stands where it looks.
    const std::string scene = moving_scene(folder, "[[keyframe]]\nframe = 0\ncamera.position = [0, 0.995, 4]\n"
                                                   "[[keyframe]]\nframe = 4\ncamera.position = [0, 0.995, -4]\n");
    const struct {
        Words words;
        std::string error;
    } cases[] = {
        {{"--frames", "4"}, "plumb: " + scene + ": frame 2: camera: look_at = [0, 0.995, 0]: must be finite and away from position\n"},
        {{"--first", "2"}, "plumb: " + scene + ": frame 2: camera: look_at = [0, 0.995, 0]: must be finite and away from position\n"},
        {{"--frames", "2", "--dump"}, "plumb: --dump: dumps one frame: expected no --frames beside it\n"},
        {{"--frames", "0"}, "plumb: --frames: 0: expected 1 to 100000\n"},
        {{"--frames", "nan"}, "plumb: --frames: nan: expected 1 to 100000\n"},
        {{"--first", "-1"}, "plumb: --first: -1: expected 0 to 1000000\n"},
    };
    for (const auto& [words, error] : cases) {
        Words all = {"render", scene, "-o", folder + "/out"};
        all.insert(all.end(), words.begin(), words.end());
        const Result r = run(all);
        CAPTURE(words);
        CHECK(r.exit == 2);
        CHECK(r.err == error);
        CHECK(r.out.empty());
        CHECK_FALSE(std::filesystem::exists(folder + "/out"));
    }
}
