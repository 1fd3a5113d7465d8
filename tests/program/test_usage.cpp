// Wrong usage and bad input: exit code 2, one line on standard error that names what is wrong, nothing else, no file.
#include <catch2/catch.hpp>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>

#include "tests/program/exported.h"

using namespace plumb::program;

namespace {

// The one line, without "plumb: ".
std::string refused(const std::vector<std::string>& arguments, const std::string& folder = ".") {
    const Result r = run(arguments, folder);
    INFO(r.out << r.err);
    CHECK(r.exit == 2);
    CHECK(r.out.empty());
    REQUIRE(r.err.find("plumb: ") == 0);
    CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
    CHECK(r.err.back() == '\n');
    return r.err.substr(7, r.err.size() - 8);
}

using Catch::Matchers::Contains;
using Catch::Matchers::Equals;
using Catch::Matchers::StartsWith;

}  // namespace

TEST_CASE("usage: commands", "[program]") {
    CHECK_THAT(refused({}), Contains("--help"));
    CHECK_THAT(refused({"rendr"}), Equals("unknown command 'rendr'; the nearest known one is 'render'"));
    CHECK_THAT(refused({"experiment", "closed-form"}),
               Equals("unknown experiment 'closed-form'; the nearest known one is 'closed-forms'"));
    CHECK_THAT(refused({"experiment", "closed-forms", "--thread", "2"}),
               Equals("closed-forms: unknown option '--thread'; the nearest known one is '--threads'"));
    CHECK_THAT(refused({"experiment"}), Contains("subcommand"));
    CHECK_THAT(refused({"--verson"}), Equals("unknown option '--verson'; the nearest known one is '--version'"));

    const Result help = run({"--help"});
    CHECK(help.exit == 0);
    CHECK(help.err.empty());
    for (const char* command : {"render", "plan", "compare", "explain", "validate", "export", "stages", "make-scene",
                                "experiment", "stability", "Examples:"})
        CHECK_THAT(help.out, Contains(command));
    const Result version = run({"--version"});
    CHECK(version.exit == 0);
    CHECK_THAT(version.out, StartsWith("plumb 0."));
    for (const char* command : {"render", "plan", "compare", "explain", "validate", "export", "stages", "make-scene"}) {
        const Result r = run({command, "--help"});
        CHECK(r.exit == 0);
        CHECK_THAT(r.out, Contains("--threads") && Contains("--isa"));
    }
}

TEST_CASE("usage: every command takes --json, --threads and --isa", "[program][contract]") {
    const std::string folder = fresh_folder("common_options"), scene = small_scene(folder);
    REQUIRE(run({"render", scene, "-o", folder + "/a"}).exit == 0);
    const std::string picture = folder + "/a/small.exr";
    REQUIRE(run({"export", scene, "--stage", "tonemap", "-o", folder + "/d"}).exit == 0);
    write_expected(folder + "/d");
    const std::string views = folder + "/views.toml";
    REQUIRE(run({"cameras", scene, "--frames", "0:0:1", "-o", views}).exit == 0);
    const std::map<std::string, std::vector<std::string>> uses = {
        {"cameras", {scene, "--frames", "0:0:1", "-o", folder + "/h.toml"}},
        {"batch", {views, "-o", folder + "/i", "--steps", "gather", "--size", "32x24"}},
        {"render", {scene, "-o", folder + "/b"}}, {"plan", {scene}}, {"graph", {scene}},
        {"bake", {scene, "-o", folder + "/a.bake", "--set", "probes.receiver_rays=8", "--set", "probes.relight_rays=8"}},
        {"lightmap", {scene, "-o", folder + "/a.exr", "--samples", "4", "--set", "probes.lightmap_size=48"}}, {"compare", {picture, picture}},
        {"explain", {scene, "--pixel", "30,21"}}, {"stages", {}},    {"make-scene", {"cornell", "-o", folder + "/c"}},
        {"experiment", {"closed-forms", "--error", "0.05", "--only", "eighth"}},
        {"export", {scene, "--stage", "tonemap", "-o", folder + "/e"}},
        {"validate", {folder + "/d/manifest.toml"}}, {"devices", {}}, {"probe-device", {}},
        {"sweep", {scene, "-o", folder + "/f", "--method", "direct", "--spp", "4"}},
        {"stability", {"--stage", "tonemap", "--case", "room"}},
        {"formfactor", {"0,0,0;0,0,1;1,0,1;1,0,0", "0,1,0;1,1,0;1,1,1;0,1,1", "--rays", "64", "--size", "8"}},
        {"pov", {scene, "-o", folder + "/g.pov"}}};
    // Of these there may be no Vulkan, or no device.
    const std::set<std::string> on_a_device = {"devices", "probe-device"}, lists = {"stages", "devices"};

    // The commands are those of the help, so that one to come is held to the same.
    std::istringstream help(run({"--help"}).out);
    std::string line;
    while (std::getline(help, line) && line.rfind("Subcommands:", 0) != 0) {
    }
    std::size_t commands = 0;
    while (std::getline(help, line) && line.rfind("  ", 0) == 0) {
        std::istringstream words(line);
        std::string command;
        words >> command;
        // What a long description goes on with stands further to the right.
        if (line[2] == ' ') continue;
        INFO(command);
        REQUIRE(uses.count(command) == 1);
        std::vector<std::string> arguments = uses.at(command);
        arguments.insert(arguments.begin(), command);
        arguments.insert(arguments.end(), {"--json", "--threads", "2", "--isa", "scalar"});
        const Result r = run(arguments);
        INFO(r.out << r.err);
        ++commands;
        if (on_a_device.count(command) && r.exit == 2) continue;
        CHECK(r.exit == 0);
        CHECK(r.err.empty());
        const auto json = nlohmann::ordered_json::parse(r.out);  // throws where anything else is printed
        CHECK(json.is_object() == !lists.count(command));
    }
    CHECK(commands == uses.size());
}

TEST_CASE("usage: options and arguments", "[program]") {
    CHECK_THAT(refused({"render"}), Contains("scene"));
    CHECK_THAT(refused({"render", "a.toml", "--thread", "2"}),
               Equals("render: unknown option '--thread'; the nearest known one is '--threads'"));
    CHECK_THAT(refused({"render", "a.toml", "--noprunning=1"}), Contains("nearest known one is '--no-pruning'"));
    CHECK_THAT(refused({"render", "a.toml", "b.toml"}), Equals("render: unexpected argument 'b.toml'"));
    CHECK_THAT(refused({"render", "a.toml", "-o"}), Contains("-o"));
    for (const char* threads : {"0", "-1", "1025", "two", "1.5", ""})
        CHECK_THAT(refused({"stages", "--threads", threads}), Contains("--threads"));
    CHECK_THAT(refused({"stages", "--isa", "neon"}), Equals("--isa neon: expected auto, scalar, sse, avx2 or avx512"));
    CHECK_THAT(refused({"compare", "a.exr"}), Contains("b"));
    CHECK_THAT(refused({"compare", "a.exr", "b.exr", "--max-error", "few"}), Contains("--max-error"));
    CHECK_THAT(refused({"compare", "a.exr", "b.exr", "-o", "c.gif"}), Contains(".exr or .png"));
    CHECK_THAT(refused({"make-scene", "cornel"}), Contains("cornell"));
    CHECK_THAT(refused({"make-scene", "cornell", "--triangles", "9"}), Contains("no adjustable count"));
}

TEST_CASE("usage: experiments", "[program]") {
    const std::string folder = fresh_folder("bad_experiments"), scene = small_scene(folder, "[16, 12]");
    for (const char* error : {"nan", "-nan", "0", "0.009", "10.1", "inf", "few", ""})
        CHECK_THAT(refused({"experiment", "closed-forms", "--only", "eighth", "--error", error}),
                   Equals("--error: " + std::string(error) + ": expected 0.01 to 10"));
    auto one_bounce = [&](std::vector<std::string> more) {
        more.insert(more.begin(), {"experiment", "one-bounce", scene, "--width", "8", "--paths", "16"});
        return refused(more);
    };
    for (const char* texels : {"nan", "-1", "1001", "far"})
        CHECK_THAT(one_bounce({"--clear", texels}), Equals("--clear: " + std::string(texels) + ": expected 0 to 1000"));
    for (const char* sizes : {"32", "32,32", "32,16", "16,32,32"})
        CHECK_THAT(one_bounce({"--sizes", sizes}), Equals("--sizes: expected at least two, each larger than the one before"));
    // Every point of the box is nearer to what lights it than 1000 texels of a small map; in the dark nothing is lit.
    CHECK_THAT(one_bounce({"--sizes", "8,16", "--clear", "1000"}),
               Equals("--clear 1000: no point is so far from what lights it"));
    write(scene, read(scene).substr(0, read(scene).find("[[light]]")));
    CHECK_THAT(one_bounce({"--sizes", "8,16"}), Equals("one-bounce: no light reaches any point that is compared"));

    const Result help = run({"experiment", "--help"});
    CHECK(help.exit == 0);
    CHECK_THAT(help.out, Contains("Experiments:") && Contains("plumb experiment closed-forms") &&
                             Contains("plumb experiment one-bounce") && !Contains("make-scene"));
}

TEST_CASE("usage: scenes that cannot be read", "[program]") {
    const std::string folder = fresh_folder("bad_scenes");
    const std::string missing = folder + "/missing.toml", text = folder + "/text.toml", empty = folder + "/empty.toml";
    write(text, "seed = = 1\n");
    write(empty, "");
    write(folder + "/scene.xyz", "seed = 1\n");
    for (const char* command : {"render", "plan", "explain"}) {
        std::vector<std::string> more = {"--set", "rsm.samples=1"};
        if (command == std::string("explain")) more = {"--pixel", "0,0"};
        auto with = [&](const std::string& file) {
            std::vector<std::string> arguments = {command, file};
            arguments.insert(arguments.end(), more.begin(), more.end());
            return arguments;
        };
        CHECK_THAT(refused(with(missing), folder), StartsWith(missing + ": "));
        CHECK_THAT(refused(with(folder), folder), StartsWith(folder));
        CHECK_THAT(refused(with(text), folder), StartsWith(text + ": ") && Contains("line 1"));
        CHECK_THAT(refused(with(folder + "/scene.xyz"), folder), Contains("scene.xyz"));
    }
    // Not even the folder for the pictures was made.
    CHECK(files_in(folder) == std::vector<std::string>{"empty.toml", "scene.xyz", "text.toml"});
    CHECK_FALSE(std::filesystem::exists(folder + "/out"));
}

TEST_CASE("usage: sizes that no picture has", "[program][robustness]") {
    const std::string folder = fresh_folder("bad_sizes"), scene = small_scene(folder);
    const Words before = files_in(folder);
    const std::vector<Words> commands = {{"render", scene, "-o", folder + "/out"},
                                         {"render", scene, "-o", folder + "/out", "--frames", "2"},
                                         {"export", scene, "-o", folder + "/out", "--stage", "gbuffer"},
                                         {"explain", scene, "--pixel", "0,0"},
                                         {"plan", scene},
                                         {"sweep", scene, "-o", folder + "/out"},
                                         {"pov", scene, "-o", folder + "/out.pov"}};
    for (Words command : commands) {
        command.push_back("--size");
        command.emplace_back();
        CAPTURE(command);
        for (const char* size : {"0x5", "5x0", "-5x5", "5x-5", "5", "x", "5x", "x5", "5x5x5", "5,5", "5.5x5", "+5x5", " 5x5",
                                 "0x10x10", "32768x1", "1x32768", "99999999999x1", "wide"}) {
            command.back() = size;
            CHECK_THAT(refused(command), Equals(std::string("--size ") + size + ": expected WxH in pixels, both 1 to 32767"));
        }
        command.back() = "32767x32767";
        CHECK_THAT(refused(command), Equals("--size 32767x32767: more than 2^28 pixels"));
        command.back() = "";
        CHECK_THAT(refused(command), Equals("--size: expected a value"));
    }
    CHECK(files_in(folder) == before);
    const std::string views = folder + "/views.toml";
    REQUIRE(run({"cameras", scene, "--frames", "0:0:1", "-o", views}).exit == 0);
    CHECK_THAT(refused({"batch", views, "-o", folder + "/out", "--size", "15x20"}),
               Equals("--size 15x20: expected WxH in pixels, both 16 to 32767"));
    CHECK_FALSE(std::filesystem::exists(folder + "/out"));
}

TEST_CASE("usage: settings, stages, pixels and lights that do not exist", "[program]") {
    const std::string folder = fresh_folder("bad_settings"), scene = small_scene(folder), out = folder + "/pictures";
    auto render = [&](std::vector<std::string> more) {
        more.insert(more.begin(), {"render", scene, "-o", out});
        return refused(more);
    };
    CHECK_THAT(render({"--method", "rms"}), Contains("--method") && Contains("direct, rsm, isr, probes, radiosity, zbuffer, reference"));
    CHECK_THAT(render({"--set", "rsm.sample=3"}),
               Equals("--set rsm.sample: unknown key 'sample'; the nearest known one is 'samples'"));
    CHECK_THAT(render({"--set", "rms.samples=3"}), Contains("nearest known one is [rsm]"));
    CHECK_THAT(render({"--set", "frame.size=3"}), Contains("[frame] is set in the scene file alone"));
    CHECK_THAT(render({"--set", "light.4.on=false"}), Equals("--set light.4.on: expected 1 to 3, or a name"));
    CHECK_THAT(render({"--set", "light.0.on=false"}), Equals("--set light.0.on: expected 1 to 3, or a name"));
    CHECK_THAT(render({"--set", "light.ley.on=false"}), Equals("--set light.ley.on: unknown light; the nearest known one is 'key'"));
    for (const char* text : {"light.1.on=1", "light.1.off=true", "light.on=true", "light.1.intensity=1,1,1"})
        CHECK_THAT(render({"--set", text}), Contains("expected light.N.on=true or false"));
    CHECK_THAT(refused({"experiment", "vrsm", "--scene", scene, "-o", out, "--set", "light.1.on=false"}), Contains("this command does not switch lights"));
    CHECK_THAT(render({"--set", "rsm.samples=0"}), Equals("--set rsm.samples: samples = 0: expected 1 to 65536"));
    CHECK_THAT(render({"--set", "rsm.samples"}), Contains("expected table.key=value"));
    CHECK_THAT(render({"--set", "rsm.rotations=3"}), Contains("power of two"));
    CHECK_THAT(render({"--set", "layout.normal=rgba16f"}),
               Equals("--set layout.normal: layout \"fp32\" is a preset: [layout] is for [render] layout = \"custom\""));
    CHECK_THAT(render({"--set", "layout.albedo=rgba8", "--set", "render.layout=isr", "--set", "layout.depth=r16f"}),
               Contains("--set layout.depth: layout \"isr\" is a preset"));
    CHECK_THAT(render({"--set", "render.layout=custom", "--set", "layout.normal=r32f"}),
               StartsWith("--set: [layout] normal = \"r32f\" cannot hold it"));
    for (const std::vector<std::string>& words :
         {std::vector<std::string>{"--spp", "4"}, {"--until-error", "0.1"}, {"--rays", "exact"}})
        CHECK_THAT(render(words), Equals(words[0] + ": nothing is path traced: expected --truth or --method reference"));
    CHECK_THAT(render({"--truth", "--spp", "0"}), StartsWith("--spp: samples = 0: expected"));
    CHECK_THAT(render({"--truth", "--spp", "many"}), StartsWith("--spp: samples"));
    CHECK_THAT(render({"--truth", "--until-error", "0"}), Equals("--until-error 0: expected above 0"));
    CHECK_THAT(render({"--truth", "--until-error", "-1"}), StartsWith("--until-error: until_error = -1: expected"));
    CHECK_THAT(render({"--truth", "--until-error", "nan"}), StartsWith("--until-error: until_error = nan: expected"));
    CHECK_THAT(render({"--truth", "--spp", "4", "--until-error", "0.1"}),
               Equals("--until-error: --spp is given, too: expected one of them"));
    for (const char* option : {"--spp", "--until-error", "--rays", "--method"})
        CHECK_THAT(render({"--truth", option, ""}), Equals(std::string(option) + ": expected a value"));
    CHECK_THAT(render({"--truth", "--rays", "fast"}), StartsWith("--rays: rays = \"fast\": expected one of exact, native"));
    CHECK_THAT(render({"--truth", "--method", "reference"}), StartsWith("--truth: the method reference is the truth"));
    CHECK_THAT(render({"--truth", "--set", "reference.mode=indirect"}), StartsWith("--truth: reference.mode: expected"));
    CHECK_THAT(render({"--set", "reference.sample=3"}),
               Equals("--set reference.sample: unknown key 'sample'; the nearest known one is 'samples'"));
    CHECK_FALSE(std::filesystem::exists(out));

    auto explain = [&](std::vector<std::string> more) {
        more.insert(more.begin(), {"explain", scene});
        return refused(more);
    };
    CHECK_THAT(explain({"--stage", "direct"}), Contains("--pixel"));
    CHECK_THAT(explain({"--stage", "dirct", "--pixel", "0,0"}),
               Equals("--stage dirct: unknown stage; the nearest known one is 'direct'"));
    for (const std::string pass : {"hemicube", "texture_space"})
        CHECK_THAT(explain({"--stage", pass, "--pixel", "0,0"}),
                   Equals("--stage " + pass + ": the stage is not part of a frame: no method runs it"));
    CHECK_THAT(explain({"--stage", "reference", "--pixel", "0,0"}),
               Equals("--stage reference: it is a mean over paths; it has no values to list"));
    CHECK_THAT(explain({"--stage", "direct", "--pixel", "0,0", "--method", "reference"}),
               Contains("paths are traced instead"));
    CHECK_THAT(explain({"--stage", "direct", "--pixel", "1"}), Contains("expected X,Y"));
    CHECK_THAT(explain({"--stage", "direct", "--pixel", "-1,0"}), Contains("expected X,Y"));
    CHECK_THAT(explain({"--stage", "direct", "--pixel", "61,0"}), Contains("61 x 43"));
    CHECK_THAT(explain({"--stage", "direct", "--pixel", "0,43"}), Contains("61 x 43"));
    CHECK_THAT(explain({"--stage", "rsm", "--pixel", "48,0"}), Contains("48 x 48"));
    CHECK_THAT(explain({"--stage", "rsm.disc", "--pixel", "0,0", "--light", "kex"}), Contains("'key'"));
    CHECK_THAT(explain({"--stage", "rsm.disc", "--pixel", "0,0", "--light", "lamp"}), Contains("the light is off"));
    CHECK_THAT(explain({"--stage", "rsm.all", "--pixel", "0,0"}), Contains("rsm.all"));
}

TEST_CASE("usage: places that cannot be written", "[program]") {
    const std::string folder = fresh_folder("bad_places"), scene = small_scene(folder);
    write(folder + "/file", "kept");
    CHECK_THAT(refused({"render", scene, "-o", folder + "/file"}), StartsWith(folder + "/file: "));
    CHECK_THAT(refused({"render", scene, "-o", folder + "/file/below"}), StartsWith(folder + "/file"));
    CHECK_THAT(refused({"render", scene, "-o", "/proc/pictures"}), StartsWith("/proc/pictures: "));
    CHECK_THAT(refused({"make-scene", "cornell", "-o", folder + "/file"}), StartsWith(folder + "/file"));
    CHECK(read(folder + "/file") == "kept");

    // A folder that has the name of a file to come.
    const std::vector<std::string> before = files_in(folder);
    std::filesystem::create_directories(folder + "/out/run.json");
    CHECK_THAT(refused({"render", scene, "-o", folder + "/out"}), StartsWith(folder + "/out/run.json: "));
    CHECK(files_in(folder) == before);

    const Result full = run({"compare", scene, scene});
    CHECK(full.exit == 2);
    CHECK_THAT(full.err, Contains("small.toml"));
}
