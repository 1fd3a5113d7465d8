// plumb export.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>

#include "tests/program/exported.h"
#include "tests/program/run_until.h"

using namespace plumb::program;
using Catch::Matchers::Contains;
using Catch::Matchers::Equals;

namespace {

// Every verdict of a manifest, which has to be a success.
Json validated(const std::string& folder) {
    const Result r = run({"validate", folder + "/manifest.toml", "--json"});
    INFO(r.out << r.err);
    REQUIRE(r.exit == 0);
    return Json::parse(r.out);
}

void check_all_equal(const Json& report, std::size_t stages) {
    CHECK(report["verdict"] == "equal");
    CHECK(report["stages"].size() == stages);
    for (const Json& stage : report["stages"]) {
        INFO(stage.dump(2));
        CHECK(stage["verdict"] == "equal");
        CHECK(stage["equal"] == 1.0);
        CHECK(stage["pixels"] > 0);
        CHECK(stage["counts"]["equal"] == stage["pixels"]);
    }
}

}  // namespace

TEST_CASE("export: every dispatch of a frame, which validates as equal", "[program]") {
    // Lights "key" and "sun" take rsm, shadow and rsm.disc each; "lamp" is off.
    const std::string folder = export_all("export_all");
    const Json report = validated(folder);
    check_all_equal(report, 1 + 3 * 2 + 3);
    Words names;
    for (const Json& stage : report["stages"]) names.push_back(stage["id"]);
    CHECK(names == Words{"gbuffer", "rsm.key", "shadow.key", "rsm.disc.key", "rsm.sun", "shadow.sun", "rsm.disc.sun",
                         "direct", "compose", "tonemap"});

    // What lies in the files is what a GPU binds: 61 x 43 pixels of 16 bytes, maps of 48 x 48.
    using std::filesystem::file_size;
    CHECK(file_size(folder + "/compose/out/radiance.bin") == 61 * 43 * 16);
    CHECK(file_size(folder + "/compose/expected/radiance.bin") == 61 * 43 * 16);
    CHECK(file_size(folder + "/rsm.disc.key/in/rsm_flux.bin") == 48 * 48 * 16);
    CHECK(file_size(folder + "/rsm.disc.key/block.bin") == 128);
    CHECK(file_size(folder + "/gbuffer/out/id.bin") == 61 * 43 * 8);
    const std::string block = read(folder + "/compose/block.bin");
    CHECK(word<std::int32_t>(block, 5) == 61);  // ComposeUniforms: vec4, float, width
    CHECK(word<std::int32_t>(block, 6) == 43);

    // The same bytes are one file: the position that all of them read.
    CHECK(std::filesystem::exists(folder + "/shadow.key/in/position.bin"));
    CHECK_FALSE(std::filesystem::exists(folder + "/rsm.disc.key/in/position.bin"));
    CHECK_THAT(read(folder + "/manifest.toml"), Contains("rotations = 64") && Contains("vk_format = \"R32_SINT\""));
    const std::string readme = read(folder + "/README.txt");
    CHECK_THAT(readme, Contains("Dispatch 8 x 6 x 1 groups") && Contains("gi/rsm/gather.comp"));
}

TEST_CASE("export: of any layout, and of point lights", "[program]") {
    SECTION("stored as halves") { check_all_equal(validated(export_all("export_half", {"--set", "render.layout=rgba16f"})), 10); }
    SECTION("gathered from every texel") { check_all_equal(validated(export_all("export_gather", {"--set", "rsm.gather=all"})), 10); }
    SECTION("a point light, by its faces") {
        const std::string folder = fresh_folder("export_point"), scene = small_scene(folder);
        write(scene, replaced(read(scene), "type = \"spot\"\nposition = [0, 1.97, 0]\ndirection = [0, -1, 0]\ncone_deg = [55, 60]",
                              "type = \"point\"\nposition = [0, 1, 0]"));
        REQUIRE(run({"export", scene, "--stage", "all", "-o", folder + "/dumps"}).exit == 0);
        write_expected(folder + "/dumps");
        check_all_equal(validated(folder + "/dumps"), 1 + 3 * 6 + 3 + 3);
        REQUIRE(run({"export", scene, "--stage", "rsm.disc", "--light", "key", "--face", "ny", "-o", folder + "/one"}).exit == 0);
        write_expected(folder + "/one");
        const Json one = validated(folder + "/one");
        check_all_equal(one, 1);
        CHECK(one["stages"][0]["id"] == "rsm.disc.key.ny");
    }
    SECTION("reversed z") {
        const std::string folder = fresh_folder("export_reversed"), scene = small_scene(folder);
        write(scene, "reversed_z = true\n" + read(scene));
        REQUIRE(run({"export", scene, "--stage", "gbuffer", "-o", folder + "/dumps"}).exit == 0);
        CHECK_THAT(read(folder + "/dumps/README.txt"), Contains("depth test greater"));
        write_expected(folder + "/dumps");
        check_all_equal(validated(folder + "/dumps"), 1);
    }
}

TEST_CASE("export: one stage, one light", "[program]") {
    const std::string folder = fresh_folder("export_one"), scene = small_scene(folder);
    const Result r = run({"export", scene, "--stage", "rsm.disc", "--light", "sun", "-o", folder + "/sun", "--json"});
    REQUIRE(r.exit == 0);
    CHECK(Json::parse(r.out)["stages"] == 1);
    write_expected(folder + "/sun");
    check_all_equal(validated(folder + "/sun"), 1);

    // What the scene's method does not run is run all the same when it is asked for by name.
    REQUIRE(run({"export", scene, "--stage", "rsm.all", "--light", "sun", "-o", folder + "/all"}).exit == 0);
    write_expected(folder + "/all");
    check_all_equal(validated(folder + "/all"), 1);
}

TEST_CASE("export: a setting of the command line is never replaced so that a stage runs; one of the scene is, with a note",
          "[program][errors]") {
    const std::string folder = fresh_folder("export_settings"), scene = small_scene(folder);
    auto refused = [&](const std::string& stage, const Words& more) {
        Words words = {"export", scene, "--stage", stage, "-o", folder + "/out"};
        words.insert(words.end(), more.begin(), more.end());
        const Result r = run(words);
        CHECK(r.exit == 2);
        CHECK_FALSE(std::filesystem::exists(folder + "/out"));
        return r.err;
    };
    CHECK_THAT(refused("rsm.disc", {"--set", "rsm.texels=continuous"}),
               Equals("plumb: --stage rsm.disc: runs with rsm.texels = \"whole\", not with --set rsm.texels=continuous; "
                      "with it rsm.disc_continuous runs\n"));
    CHECK_THAT(refused("rsm.disc", {"--set", "rsm.gather=paths"}),
               Equals("plumb: --stage rsm.disc: runs with rsm.gather = \"disc\", not with --set rsm.gather=paths; "
                      "with it rsm.paths runs\n"));
    CHECK_THAT(refused("rsm.disc", {"--method", "direct"}),
               Equals("plumb: --stage rsm.disc: runs with render.method = rsm, not with --method direct\n"));

    // The stage of these settings, and the scene's own that give way.
    CHECK(run({"export", scene, "--stage", "rsm.disc_continuous", "--set", "rsm.texels=continuous", "-o", folder + "/a"}).exit == 0);
    write(scene, read(scene) + "texels = \"continuous\"\n");
    const Result whole = run({"export", scene, "--stage", "rsm.disc", "-o", folder + "/b"});
    REQUIRE(whole.exit == 0);
    CHECK_THAT(whole.out, Contains("note: rsm.disc: runs with rsm.texels = \"whole\", in place of the scene's \"continuous\"\n"));
    const Result json = run({"export", scene, "--stage", "rsm.disc", "-o", folder + "/b", "--json"});
    CHECK_THAT(Json::parse(json.out)["notes"].dump(), Contains("in place of the scene's"));
}

#ifndef PLUMB_SANITIZED
TEST_CASE("export and validate: what does not fit into memory is refused before work begins", "[program][errors][memory]") {
    const std::string folder = fresh_folder("export_memory"), scene = small_scene(folder);
    const std::uint64_t limit = 6000000000;
    auto refused = [&](const Words& words, const std::string& what) {
        const Result r = run_within(words, limit);
        CHECK(r.exit == 2);
        CHECK(r.out.empty());
        CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
        CHECK_THAT(r.err, Contains(what + " needs about ") && Contains(" GB of memory; there are 5.") && Contains(" GB: expected"));
    };
    for (const char* stage : {"all", "rsm.disc"})
        refused({"export", scene, "--stage", stage, "--size", "16384x16384", "-o", folder + "/large"}, "export of 16384 x 16384 pixels");
    CHECK_FALSE(std::filesystem::exists(folder + "/large"));
    // What fits is written within the same limit, and says nothing.
    const Result small = run_within({"export", scene, "--stage", "all", "-o", folder + "/dumps"}, limit);
    CHECK(small.exit == 0);
    CHECK(small.err.empty());

    // A manifest whose pictures are said to be as large: no file of it is looked at.
    const std::string file = folder + "/dumps/manifest.toml";
    CHECK(run_within({"validate", file}, limit).exit == 1);
    std::string text = read(file);
    for (const auto& [from, to] : {std::pair("width = 61\n", "width = 16384\n"), std::pair("height = 43\n", "height = 16384\n"),
                                   std::pair("size = [61, 43]", "size = [16384, 16384]")})
        while (text.find(from) != std::string::npos) text = replaced(text, from, to);
    write(file, text);
    refused({"validate", file}, "validate " + file);
}
#endif

TEST_CASE("export: the twins' own outputs of every stage hold up", "[program][vulkan]") {
    const std::string folder = fresh_folder("export_device"), scene = small_scene(folder);
    const Result r = run({"export", scene, "--stage", "all", "--device", "llvmpipe", "-o", folder + "/dumps"});
    if (r.exit == 2) {
        WARN("no round trip: " << r.err);
        return;
    }
    REQUIRE(r.exit == 0);
    const std::string manifest = read(folder + "/dumps/manifest.toml");
    CHECK_THAT(manifest, Contains("llvmpipe"));
    // As Vulkan allows: nothing is wrong; compute stages are equal.
    const Json ideal = validated(folder + "/dumps");
    CHECK(ideal["stages"].size() == 10);
    for (const Json& stage : ideal["stages"]) {
        INFO(stage.dump(2));
        CHECK(stage["wrong"] == 0);
        const std::string name = stage["stage"];
        if (name != "gbuffer" && name != "rsm") CHECK(stage["verdict"] == "equal");
    }
}

TEST_CASE("export --choices: validate follows what the twin chose", "[program][vulkan]") {
    const std::string folder = fresh_folder("export_choices"), scene = small_scene(folder);
    const Result r = run({"export", scene, "--stage", "rsm.disc", "--light", "key", "--device", "llvmpipe", "--choices",
                          "-o", folder + "/dumps"});
    if (r.exit == 2) {
        WARN("no round trip: " << r.err);
        return;
    }
    REQUIRE(r.exit == 0);
    CHECK_THAT(read(folder + "/dumps/manifest.toml"), Contains("[stage.choices]") && Contains("R32G32_SINT"));
    // Of lavapipe 22.3 the profile is known; of any other the limit is.
    CHECK_THAT(read(folder + "/dumps/manifest.toml"),
               Contains("profile = \"lavapipe-22.3-") || Contains("subpixel_bits = "));
    CHECK(validated(folder + "/dumps")["stages"][0]["verdict"] == "equal");

    // Another rounding of the same sum is legal, but not from another texel.
    const std::string values = folder + "/dumps/rsm.disc.key/out/irradiance.bin";
    const std::string choices = folder + "/dumps/rsm.disc.key/out/choices.bin";
    const std::size_t pixel = 33 * 61 + 40;
    const float ours = word<float>(read(values), 4 * pixel);
    REQUIRE(ours > 0);
    set_word(values, 4 * pixel, std::nextafter(ours, 1e9f));
    CHECK(validated(folder + "/dumps")["stages"][0]["counts"]["within_bound"] == 1);
    set_word(choices, 2 * pixel, word<std::int32_t>(read(choices), 2 * pixel) + 1);
    const Result wrong = run({"validate", folder + "/dumps/manifest.toml", "--json"});
    CHECK(wrong.exit == 1);
    CHECK(Json::parse(wrong.out)["stages"][0]["counts"]["wrong"] == 1);
}

namespace {

Words exported_stages(const std::string& folder) {
    const Json report = Json::parse(run({"validate", folder + "/manifest.toml", "--json"}).out);
    Words names;
    for (const Json& stage : report["stages"]) names.push_back(stage["id"]);
    return names;
}

std::string head_of(const std::string& manifest) { return manifest.substr(0, manifest.find("[export.files]")); }

}  // namespace

TEST_CASE("export: stage by stage into one folder is one manifest", "[program]") {
    const std::string folder = fresh_folder("export_merged"), scene = small_scene(folder), to = folder + "/dumps";
    REQUIRE(run({"export", scene, "--stage", "gbuffer", "-o", to}).exit == 0);
    const std::string id = head_of(read(to + "/manifest.toml"));
    write_expected(to);
    // What a renderer has written to the other stages stays; another method's gather is run where it is asked for.
    const Result second = run({"export", scene, "--stage", "rsm.disc", "-o", to});
    CHECK(second.exit == 0);
    CHECK_THAT(second.out, Contains("beside them, of the earlier export of the same scene and settings: gbuffer"));
    REQUIRE(run({"export", scene, "--stage", "rsm.all", "--light", "sun", "-o", to}).exit == 0);
    CHECK(head_of(read(to + "/manifest.toml")) == id);
    CHECK(exported_stages(to) == Words{"gbuffer", "rsm.disc.key", "rsm.disc.sun", "rsm.all.sun"});
    const Json before = Json::parse(run({"validate", to + "/manifest.toml", "--json"}).out);
    CHECK(stage_of(before, "gbuffer")["verdict"] == "equal");
    CHECK(stage_of(before, "rsm.disc (sun)")["unwritten"] == 61 * 43);
    write_expected(to);
    check_all_equal(validated(to), 4);
    const std::string readme = read(to + "/README.txt");
    for (const char* label : {"gbuffer", "rsm.disc (key)", "rsm.disc (sun)", "rsm.all (sun)"})
        CHECK_THAT(readme, Contains(std::string("\n\n\n") + label + "\n---"));
    CHECK_THAT(readme, Contains("gi/rsm/gather.comp") && Contains("colour target"));

    // Once more: in its place, and filled anew.
    REQUIRE(run({"export", scene, "--stage", "gbuffer", "-o", to}).exit == 0);
    CHECK(exported_stages(to).size() == 4);
    const Json again = Json::parse(run({"validate", to + "/manifest.toml", "--json"}).out);
    CHECK(stage_of(again, "gbuffer")["unwritten"] == 61 * 43);
    CHECK(stage_of(again, "rsm.all (sun)")["verdict"] == "equal");
}

TEST_CASE("export: of another scene it takes the place of what was there", "[program]") {
    const std::string folder = fresh_folder("export_replaced"), scene = small_scene(folder), to = folder + "/dumps";
    REQUIRE(run({"export", scene, "--stage", "all", "-o", to}).exit == 0);
    write_expected(to);
    write(to + "/gbuffer/mine.txt", "hers");
    write(to + "/mine.bin", "hers");
    const std::string changed = to + "/direct/in/visibility.bin";
    write(changed, "hers");
    write(scene, replaced(read(scene), "intensity = [10, 10, 10]", "intensity = [10, 10, 9]"));
    const Result r = run({"export", scene, "--stage", "tonemap", "-o", to});
    INFO(r.out << r.err);
    CHECK(r.exit == 0);
    CHECK_THAT(r.out, Contains("replaced: what was there is of another scene, other settings, another device or program; gone: "
                               "gbuffer, rsm (key)") &&
                          Contains("kept: " + changed + ": has changed since it was exported"));
    CHECK(files_in(to) == Words{"README.txt", "direct/in/visibility.bin", "gbuffer/mine.txt", "manifest.toml", "mine.bin",
                                "tonemap/block.bin", "tonemap/expected/display.bin", "tonemap/in/radiance.bin",
                                "tonemap/out/display.bin"});
    CHECK(exported_stages(to) == Words{"tonemap"});
    // Other settings are another export, too.
    CHECK_THAT(run({"export", scene, "--stage", "gbuffer", "--set", "tonemap.exposure=2", "-o", to}).out,
               Contains("gone: tonemap"));
    CHECK_FALSE(std::filesystem::exists(to + "/tonemap"));
}

TEST_CASE("export: a manifest that no export wrote is not written over", "[program]") {
    const std::string folder = fresh_folder("export_kept"), scene = small_scene(folder), to = folder + "/dumps";
    const std::string mine = "[[stage]]\nstage = \"tonemap\"\n[stage.output.display]\nfile = \"mine.exr\"\n";
    std::filesystem::create_directories(to);
    write(to + "/manifest.toml", mine);
    auto refused = [&] {
        const Result r = run({"export", scene, "--stage", "tonemap", "-o", to});
        CHECK(r.exit == 2);
        CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
        CHECK(files_in(to) == Words{"manifest.toml"});
        return r.err;
    };
    CHECK_THAT(refused(), Contains("manifest.toml") && Contains("is there already"));
    CHECK(read(to + "/manifest.toml") == mine);
    // One that leads out of its folder is none.
    const std::string outside = folder + "/outside.bin";
    write(outside, "hers");
    write(to + "/manifest.toml", "[export]\nid = \"0123456789abcdef\"\n[export.files]\n\"../outside.bin\" = "
                                 "\"0123456789abcdef\"\n" + mine);
    CHECK_THAT(refused(), Contains("../outside.bin"));
    CHECK(read(outside) == "hers");
}

TEST_CASE("export: what cannot be exported", "[program]") {
    const std::string folder = fresh_folder("export_bad"), scene = small_scene(folder), to = folder + "/dumps";
    auto refused = [&](const Words& more) {
        Words words = {"export", scene, "-o", to};
        words.insert(words.end(), more.begin(), more.end());
        const Result r = run(words);
        INFO(r.out << r.err);
        CHECK(r.exit == 2);
        CHECK(r.out.empty());
        CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
        CHECK_FALSE(std::filesystem::exists(to));
        return r.err;
    };
    CHECK_THAT(refused({"--stage", "rsm.disk"}), Contains("rsm.disk") && Contains("rsm.disc"));
    CHECK_THAT(refused({"--stage", "reference"}), Contains("reference"));
    CHECK_THAT(refused({"--stage", "rsm", "--face", "px"}), Contains("--face px") && Contains("point light"));
    CHECK_THAT(refused({"--stage", "rsm", "--profile", ""}), Contains("--profile"));
    CHECK_THAT(refused({"--stage", "rsm", "--light", "kee"}), Contains("kee") && Contains("key"));
    CHECK_THAT(refused({"--stage", "shadow", "--light", "lamp"}), Contains("left out"));
    CHECK_THAT(refused({"--stage", "gbuffer", "--profile", "ideel"}), Contains("--profile") && Contains("ideal"));
    CHECK_THAT(refused({"--stage", "tonemap", "--device", "no such device"}), Contains("--device no such device"));
    CHECK_THAT(refused({"--stage", "tonemap", "--choices"}), Contains("--choices: expected --device"));
    CHECK_THAT(refused({}), Contains("--stage"));
    write(folder + "/file", "");
    CHECK(run({"export", scene, "--stage", "gbuffer", "-o", folder + "/file"}).exit == 2);
}
