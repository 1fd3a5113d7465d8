// plumb render and plan: which files come out, that nothing moves a bit of them, and that nothing is left behind.
#include <signal.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <map>

#include "core/isa.h"
#include "io/image_file.h"
#include "io/npy.h"
#include "tests/program/program.h"

using namespace plumb;
using namespace plumb::program;

namespace {

// The pictures of a folder, by name.
std::map<std::string, std::string> pictures(const std::string& folder) {
    std::map<std::string, std::string> bytes;
    for (const std::string& name : files_in(folder))
        if (name != "run.json") bytes[name] = read(folder + "/" + name);
    return bytes;
}

const Words all_files = {"run.json", "small.exr", "small.png", "small.rsm.key.exr", "small.rsm.sun.exr"};

}  // namespace

TEST_CASE("render: writes the contract's files, layers and keys", "[program][contract]") {
    const std::string folder = fresh_folder("render"), scene = small_scene(folder), out = folder + "/a/b";
    const Result r = render(scene, out);
    CHECK(files_in(out) == all_files);
    for (const std::string& file : all_files) CHECK_THAT(r.out, Catch::Matchers::Contains("wrote " + out + "/" + file));
    CHECK_THAT(r.out, Catch::Matchers::Contains("left out: the light is off"));

    const compare::Picture picture = io::read_picture(out + "/small.exr");
    CHECK(picture.width == 61);
    CHECK(picture.height == 43);
    Words layers = io::layer_names(picture);
    std::sort(layers.begin(), layers.end());
    CHECK(layers == Words{"", "albedo", "depth", "direct", "emission", "id", "indirect", "normal", "position",
                          "shadow.key", "shadow.sun", "zbuffer"});
    const compare::Picture map = io::read_picture(out + "/small.rsm.sun.exr");
    CHECK(map.width == 32);
    layers = io::layer_names(map);
    std::sort(layers.begin(), layers.end());
    CHECK(layers == Words{"rsm.sun.depth", "rsm.sun.flux", "rsm.sun.normal", "rsm.sun.position"});

    const Json json = Json::parse(read(out + "/run.json"));
    CHECK(keys(json) == Words{"version", "scene", "notes", "settings", "isa", "kernels", "threads", "stages", "read_ms", "render_ms", "write_ms",
                              "total_ms", "peak_bytes", "lights"});
    for (const char* key : {"read_ms", "render_ms", "write_ms"}) CHECK(json[key].get<double>() > 0);
    CHECK(json["total_ms"].get<double>() >=
          json["read_ms"].get<double>() + json["render_ms"].get<double>() + json["write_ms"].get<double>());
    for (const char* row : {"read scene", "write files"}) CHECK_THAT(r.out, Catch::Matchers::Contains(row));
    CHECK(json["isa"] == isa_name(best_isa()));
    CHECK(json["settings"]["rsm"]["samples"] == 37);
    int left_out = 0;
    for (const Json& s : json["stages"]) {
        CHECK(keys(s) == Words{"name", "needed", "kept", "reason", "rule", "ms", "saved_ms", "parts", "bytes", "reads"});
        CHECK_FALSE(s["kept"]);
        if (!s["needed"]) ++left_out;
    }
    CHECK(left_out == 3);  // rsm, shadow and gather of the lamp that is off
    CHECK(json["kernels"].size() == json["stages"].size() - 3);
    // Map, shadow and gather are a light's own; what they took adds up.
    REQUIRE(json["lights"].size() == 3);
    for (const Json& light : json["lights"]) {
        CAPTURE(light["name"]);
        REQUIRE(keys(light) == Words{"name", "on", "ms", "saved_ms", "ran", "kept", "bytes"});
        double ms = 0, bytes = 0;
        for (const Json& s : json["stages"]) {
            const std::string name = s["name"];
            if (!s["needed"] || !name.ends_with("(" + light["name"].get<std::string>() + ")")) continue;
            ms += s["ms"].get<double>(), bytes += s["bytes"].get<double>();
        }
        CHECK(light["on"] == (light["name"] != "lamp"));
        CHECK(light["ran"] == (light["on"] ? 3 : 0));
        CHECK(light["kept"] == 0);
        CHECK(light["ms"].get<double>() == Approx(ms).margin(1e-12));
        CHECK(light["bytes"] == bytes);
    }
    CHECK(json["peak_bytes"].get<double>() > 1e6);
}

TEST_CASE("render: a light is switched by its number or its name", "[program][LRA 8]") {
    const std::string folder = fresh_folder("switched"), scene = small_scene(folder);
    const auto lit = [&](const Words& more) {
        const std::string out = fresh_folder("switched_out");
        render(scene, out, more);
        Words on;
        const Json json = Json::parse(read(out + "/run.json"));
        for (const Json& light : json["lights"])
            if (light["on"]) on.push_back(light["name"]);
        return on;
    };
    CHECK(lit({}) == Words{"key", "sun"});
    CHECK(lit({"--set", "light.1.on=false"}) == Words{"sun"});
    CHECK(lit({"--set", "light.3.on=true"}) == Words{"key", "sun", "lamp"});
    CHECK(lit({"--set", "light.lamp.on=true", "--set", "light.2.on=false"}) == Words{"key", "lamp"});
    // As if the file said so: the same picture.
    render(scene, folder + "/set", {"--set", "light.2.on=false"});
    std::string text = read(scene);
    text.insert(text.find('\n', text.find("name = \"sun\"")) + 1, "on = false\n");
    write(scene, text);
    render(scene, folder + "/file");
    CHECK(read(folder + "/set/small.exr") == read(folder + "/file/small.exr"));
    // A keyframe says nothing of a light that is switched.
    write(scene, text + "[[keyframe]]\nframe = 0\nlight.key.on = false\n");
    CHECK(lit({}) == Words{});
    CHECK(lit({"--set", "light.key.on=true"}) == Words{"key"});
}

TEST_CASE("render: the ten views of LRA are layers, those of maps one of each light that is on", "[program][contract][LRA 8]") {
    const std::string out = fresh_folder("lra_views"), scene = std::string(PLUMB_SOURCE_DIR) + "/data/scenes/cornell/lra.toml";
    render(scene, out, {"--size", "40x40", "--set", "light.3.on=false", "--set", "light.4.on=true", "--set", "indirect.blur=none"});
    const std::map<std::string, Words> views = {{"lra.exr", {"", "position", "normal", "albedo", "depth", "ao", "reflection"}},
                                                {"lra.rsm.sun.exr", {"rsm.sun.position", "rsm.sun.normal", "rsm.sun.flux", "rsm.sun.depth"}},
                                                {"lra.rsm.key.exr", {"rsm.key.position", "rsm.key.normal", "rsm.key.flux", "rsm.key.depth"}},
                                                {"lra.rsm.low.exr", {"rsm.low.position", "rsm.low.normal", "rsm.low.flux", "rsm.low.depth"}}};
    Words files = {"lra.png", "run.json"};
    for (const auto& [file, layers] : views) {
        files.push_back(file);
        const compare::Picture picture = io::read_picture(out + "/" + file);
        for (const std::string& layer : layers) {
            CAPTURE(file, layer);
            const auto values = io::select_layer(picture, layer, file).data;
            std::size_t seen = 0;
            for (const float v : values) seen += v != 0 && std::isfinite(v);
            CHECK(seen > values.size() / 20);
        }
    }
    std::sort(files.begin(), files.end());
    CHECK(files_in(out) == files);  // of lights that are off there is none
}

TEST_CASE("render: color is recomposed from the other layers, to the bit", "[program][contract]") {
    const std::string folder = fresh_folder("recompose"), scene = small_scene(folder);
    write(scene, read(scene) + "[[material]]\nname = \"red\"\nemission = [3, 0.5, 0.25]\n");
    for (const char* layout : {"fp32", "rgba16f"}) {
        INFO(layout);
        render(scene, folder + "/out", {"--set", std::string("render.layout=") + layout});
        const compare::Picture picture = io::read_picture(folder + "/out/small.exr");
        auto layer = [&](const char* name) { return io::select_layer(picture, name, "small.exr").data; };
        const auto color = layer(""), albedo = layer("albedo"), direct = layer("direct"), indirect = layer("indirect"),
                   emission = layer("emission"), id = layer("id");
        int glowing = 0, bounced = 0;
        for (std::size_t i = 0; i < color.size(); ++i) {
            if (id[i / 3 * 2] < 0) continue;
            // L = (rho (E_direct + E_indirect) + M) / pi, rounded as the stage compose rounds.
            REQUIRE(color[i] == (albedo[i] * (direct[i] + indirect[i]) + emission[i]) * 0.318309886f);
            glowing += emission[i] > 0;
            bounced += albedo[i] * indirect[i] > 0;
        }
        CHECK(glowing > 100);
        CHECK(bounced > 1000);
    }
}

TEST_CASE("render: the layer depth is linear eye depth, zbuffer the depth buffer", "[program][contract]") {
    const std::string folder = fresh_folder("depth_layers"), scene = small_scene(folder);
    render(scene, folder + "/out");
    const compare::Picture picture = io::read_picture(folder + "/out/small.exr");
    CHECK(io::select_layer(picture, "depth", "").channels == Words{"Z"});
    CHECK(io::select_layer(picture, "zbuffer", "").channels == Words{"Z"});
    const auto depth = io::select_layer(picture, "depth", "").data,
               zbuffer = io::select_layer(picture, "zbuffer", "").data,
               position = io::select_layer(picture, "position", "").data, id = io::select_layer(picture, "id", "").data;
    int seen = 0;
    for (std::size_t i = 0; i < depth.size(); ++i) {
        if (id[2 * i] < 0) {
            CHECK(depth[i] == 0);
            CHECK(zbuffer[i] == 1);
            continue;
        }
        ++seen;
        // The camera is at z = 3.934 m and looks along -z; near 0.1 m, far 100 m: z/w = far (d - near) / (d (far -
        // near)).
        const double d = 3.934 - double(position[3 * i + 2]);
        CHECK(depth[i] == Approx(d).epsilon(1e-6));
        CHECK(zbuffer[i] == Approx(100 * (d - 0.1) / (d * 99.9)).epsilon(1e-6));
    }
    CHECK(seen > 1000);

    // explain's depth is that of the layer.
    const Json e = Json::parse(run({"explain", scene, "--stage", "gbuffer", "--pixel", "30,21", "--json"}).out);
    int found = 0;
    for (const Json& v : e["values"]) {
        if (v["name"] != "depth") continue;
        ++found;
        CHECK(v["value"].get<float>() == depth[21 * 61 + 30]);
    }
    CHECK(found == 1);
}

TEST_CASE("render: --json prints run.json and nothing else", "[program][contract]") {
    const std::string folder = fresh_folder("render_json"), scene = small_scene(folder);
    const Result r = render(scene, folder + "/out", {"--json"});
    CHECK(r.out == read(folder + "/out/run.json"));
    CHECK_NOTHROW(Json::parse(r.out));
}

TEST_CASE("render: the same files by every instruction set and number of threads, and a second time", "[program]") {
    const std::string folder = fresh_folder("same_files"), scene = small_scene(folder), out = folder + "/out";
    render(scene, out);
    const auto reference = pictures(out);
    REQUIRE(reference.size() == 4);
    render(scene, out);
    CHECK(pictures(out) == reference);
    for (const char* layout : {"fp32", "rgba16f"}) {
        const std::string set = std::string("render.layout=") + layout;
        render(scene, folder + "/layout", {"--set", set});
        const auto expected = pictures(folder + "/layout");
        CHECK((expected == reference) == (layout == std::string("fp32")));
        for (Isa isa : supported_isas()) {
            for (const char* threads : {"1", "2", "3"}) {
                INFO(isa_name(isa) << ", " << threads << " threads, " << layout);
                render(scene, out, {"--isa", isa_name(isa), "--threads", threads, "--set", set});
                CHECK(pictures(out) == expected);
                const Json json = Json::parse(read(out + "/run.json"));
                CHECK(json["isa"] == isa_name(isa));
                CHECK(json["kernels"]["rsm.disc (key)"] == isa_name(isa));
                CHECK(json["threads"] == std::stoi(threads));
            }
        }
    }
    // A setting that changes the picture does change the files.
    render(scene, out, {"--set", "rsm.samples=36"});
    CHECK(pictures(out).at("small.exr") != reference.at("small.exr"));
    CHECK(pictures(out).at("small.rsm.key.exr") == reference.at("small.rsm.key.exr"));
}

TEST_CASE("render: leaving stages out changes no bit of the picture", "[program]") {
    const std::string folder = fresh_folder("pruning"), scene = small_scene(folder);
    render(scene, folder + "/pruned");
    render(scene, folder + "/all", {"--no-pruning"});
    CHECK(read(folder + "/pruned/small.png") == read(folder + "/all/small.png"));
    // All layers but the shadow of the lamp that is off, which was not drawn.
    const compare::Picture a = io::read_picture(folder + "/pruned/small.exr"),
                           b = io::read_picture(folder + "/all/small.exr");
    CHECK(io::layer_names(b).size() == io::layer_names(a).size() + 1);
    for (const std::string& layer : io::layer_names(a)) {
        INFO(layer);
        CHECK(compare::compare(io::select_layer(a, layer, "a"), io::select_layer(b, layer, "b")).equal);
    }
    CHECK(std::filesystem::exists(folder + "/all/small.rsm.lamp.exr"));
    const Json json = Json::parse(read(folder + "/all/run.json"));
    REQUIRE(json["stages"].size() > 9);
    for (const Json& s : json["stages"]) CHECK(s["needed"] == true);
}

TEST_CASE("render: direct alone has no indirect light", "[program]") {
    const std::string folder = fresh_folder("direct"), scene = small_scene(folder);
    render(scene, folder + "/out", {"--method", "direct"});
    const compare::Picture picture = io::read_picture(folder + "/out/small.exr");
    for (float v : io::select_layer(picture, "indirect", "").data) REQUIRE(v == 0);
    float brightest = 0;
    for (float v : io::select_layer(picture, "direct", "").data) brightest = std::max(brightest, v);
    CHECK(brightest > 1);
}

TEST_CASE("size: render, export, explain and plan take it in place of the scene's own", "[program][contract]") {
    const std::string folder = fresh_folder("size"), scene = small_scene(folder);
    const Words size = {"--size", "31x17"};
    const auto with_size = [&](Words words) {
        words.insert(words.end(), size.begin(), size.end());
        return words;
    };
    render(scene, folder + "/option", size);
    const Json planned = Json::parse(run(with_size({"plan", scene, "--json"})).out);
    const Words exported = {"export", scene, "--stage", "compose", "-o", folder + "/export", "--json"};
    REQUIRE(run(with_size(exported)).exit == 0);
    const std::string manifest = read(folder + "/export/manifest.toml");
    const Words explain = {"explain", scene, "--pixel", "30,16", "--json"};
    const std::string explained = run(with_size(explain)).out;
    CHECK(run(with_size({"explain", scene, "--pixel", "31,16"})).err ==
          "plumb: --pixel 31,16: outside of the picture, which is 31 x 17\n");

    // The same size in the scene file makes the same files and says the same.
    small_scene(folder, "[31, 17]");
    render(scene, folder + "/file");
    CHECK(pictures(folder + "/option") == pictures(folder + "/file"));
    CHECK(planned == Json::parse(run({"plan", scene, "--json"}).out));
    REQUIRE(run(exported).exit == 0);
    CHECK(manifest == read(folder + "/export/manifest.toml"));
    CHECK_THAT(manifest, Catch::Matchers::Contains("size = [31, 17]"));
    CHECK(explained == run(explain).out);
    CHECK(Json::parse(explained)["stages"].size() > 5);
}

TEST_CASE("render: replaces its files and keeps others; leaves nothing of its own after an error", "[program]") {
    const std::string folder = fresh_folder("overwrite"), scene = small_scene(folder), out = folder + "/out";
    std::filesystem::create_directories(out);
    write(out + "/small.exr", "old");
    write(out + "/notes.txt", "mine");
    render(scene, out);
    CHECK(read(out + "/notes.txt") == "mine");
    CHECK(read(out + "/small.exr").size() > 1000);
    CHECK(files_in(out).size() == all_files.size() + 1);

    // The second picture cannot be put in place: the first is not replaced either.
    std::filesystem::remove(out + "/small.png");
    std::filesystem::create_directories(out + "/small.png");
    write(out + "/small.exr", "old");
    CHECK(run({"render", scene, "-o", out}).exit == 2);
    CHECK(read(out + "/small.exr") == "old");
    CHECK(files_in(out).size() == all_files.size());
}

TEST_CASE("render: Ctrl-C and SIGTERM leave nothing behind, exit code 130", "[program]") {
    const std::string folder = fresh_folder("interrupted"), scene = small_scene(folder, "[4000, 3000]");
    const Words before = files_in(folder);
    for (int signal : {SIGINT, SIGTERM}) {
        const std::string out = folder + "/out";
        const Result r =
            run_and_signal({"render", scene, "-o", out, "--set", "rsm.gather=all"}, signal, out, ".plumb-");
        CHECK(r.exit == 130);
        CHECK(r.out.empty());
        CHECK(r.err.empty());
        CHECK(files_in(folder) == before);
        CHECK_FALSE(std::filesystem::exists(out));
    }
    // A folder that was there stays, with what is in it.
    std::filesystem::create_directories(folder + "/out");
    write(folder + "/out/notes.txt", "mine");
    const Result r = run_and_signal({"render", scene, "-o", folder + "/out", "--set", "rsm.gather=all"}, SIGINT,
                                    folder + "/out", ".plumb-");
    CHECK(r.exit == 130);
    CHECK(files_in(folder + "/out") == Words{"notes.txt"});
}

TEST_CASE("render: --dump binds every port of every stage to a file", "[program]") {
    const std::string folder = fresh_folder("dump"), scene = small_scene(folder), out = folder + "/out";
    render(scene, out, {"--dump"});
    const Json dump = Json::parse(read(out + "/dump/dump.json"));
    const Json stages = Json::parse(run({"stages", "--json"}).out);
    REQUIRE(dump["stages"].size() == 1 + 2 * 3 + 3);  // gbuffer; rsm, shadow, gather of two lights; the last three
    for (const Json& s : dump["stages"]) {
        INFO(s["stage"]);
        for (const Json& info : stages) {
            if (info["name"] != s["stage"]) continue;
            for (const char* kind : {"inputs", "outputs"}) {
                CHECK(s[kind].size() == info[kind].size());
                for (const Json& port : info[kind]) {
                    INFO(port["name"]);
                    REQUIRE(s[kind].contains(port["name"]));
                    const Json& files = s[kind][port["name"].get<std::string>()];
                    for (const Json& file : files.is_array() ? files : Json::array({files}))
                        CHECK(std::filesystem::file_size(out + "/dump/" + file.get<std::string>()) > 64);
                }
            }
        }
    }
    // The two gathers add up to the frame's indirect light.
    const auto key = io::read_picture(out + "/dump/rsm.disc.key.irradiance.exr");
    const auto sun = io::read_picture(out + "/dump/rsm.disc.sun.irradiance.exr");
    const auto sum = io::read_picture(out + "/dump/indirect.irradiance.exr");
    REQUIRE(key.channels == Words{"R", "G", "B", "A"});
    for (std::size_t i = 0; i < sum.data.size(); ++i) REQUIRE(sum.data[i] == key.data[i] + sun.data[i]);
    CHECK(io::read_npy(out + "/dump/rsm.disc.key.offsets.npy").shape == Shape{37, 64});
    const Array records = io::read_npy(out + "/dump/rsm.sun.records.npy");
    CHECK(records.dtype == DType::f32);
    CHECK(records.shape == Shape{32, 32, 16});
}

TEST_CASE("render: a bar on a terminal, nothing elsewhere", "[program]") {
    const std::string folder = fresh_folder("bar"), scene = small_scene(folder);
    const Result r = run_on_terminal({"render", scene, "-o", folder + "/out"});
    if (r.exit == no_terminal) {
        WARN("no pseudo-terminal here: the progress bar is not tested");
        return;
    }
    CHECK(r.exit == 0);
    CHECK_THAT(r.out, Catch::Matchers::Contains("rsm.disc (key)") && Catch::Matchers::Contains("%"));
    CHECK_THAT(r.out, Catch::Matchers::Contains("\r\033[K"));
    // What comes before the first stage and after the last one is named, too; all of it is wiped before anything is told.
    const std::size_t reading = r.out.find("reading "), preparing = r.out.find("preparing the scene"),
                      stage = r.out.find("gbuffer"), writing = r.out.find("writing pictures"), told = r.out.find("read scene");
    CHECK(reading < preparing);
    CHECK(preparing < stage);
    CHECK(stage < writing);
    CHECK(writing < told);
    CHECK(told != std::string::npos);
    CHECK(r.out.substr(writing, told - writing).find("\r\033[K") != std::string::npos);
}

TEST_CASE("render: what is done is said before it is begun, so that a large scene says it at once", "[program]") {
    const std::string folder = fresh_folder("status");
    write(folder + "/cut.obj", "v 0 0 0\nf 1 2");
    const Result r = run_on_terminal({"render", folder + "/cut.obj", "-o", folder + "/out"});
    if (r.exit == no_terminal) {
        WARN("no pseudo-terminal here: the status line is not tested");
        return;
    }
    // Also where reading fails: the line is there first, and is gone before the error.
    CHECK(r.exit == 2);
    CHECK(r.out.find('\r') == 0);
    const std::size_t read = r.out.find("cut.obj"), wiped = r.out.find("\r\033[K"), error = r.out.find("plumb: ");
    CHECK(read < wiped);
    CHECK(wiped < error);
    CHECK(error != std::string::npos);
}

TEST_CASE("plan: says what render would do, and renders nothing", "[program][contract]") {
    const std::string folder = fresh_folder("plan"), scene = small_scene(folder);
    const Words before = files_in(folder);
    const Result text = run({"plan", scene}, folder), r = run({"plan", scene, "--json"}, folder);
    CHECK(text.exit == 0);
    CHECK(r.exit == 0);
    CHECK(files_in(folder) == before);
    CHECK_THAT(text.out, Catch::Matchers::Contains("left out: the light is off"));
    const Json json = Json::parse(r.out);
    render(scene, folder + "/out");
    const Json run_json = Json::parse(read(folder + "/out/run.json"));
    REQUIRE(json["stages"].size() == run_json["stages"].size());
    for (std::size_t i = 0; i < json["stages"].size(); ++i)
        for (const char* key : {"name", "needed", "reason"})
            CHECK(json["stages"][i][key] == run_json["stages"][i][key]);
}
