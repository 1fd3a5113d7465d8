// plumb render --truth and the method reference: layers, numbers, bits, and references that are kept.
#include <signal.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <map>

#include "core/isa.h"
#include "io/image_file.h"
#include "tests/program/program.h"

using namespace plumb;
using namespace plumb::program;
using Catch::Matchers::Contains;

namespace {

Json run_json(const std::string& out) { return Json::parse(read(out + "/run.json")); }

std::map<std::string, std::string> pictures(const std::string& folder) {
    std::map<std::string, std::string> bytes;
    for (const std::string& name : files_in(folder))
        if (name != "run.json") bytes[name] = read(folder + "/" + name);
    return bytes;
}

std::vector<float> layer(const std::string& out, const std::string& name) {
    return io::select_layer(io::read_picture(out + "/small.exr"), name, name).data;
}

double mean(const std::vector<float>& values) {
    double sum = 0;
    for (float v : values) sum += v;
    return sum / double(values.size());
}

const Words estimate_keys = {"mode",      "kind", "samples",         "rounds", "rays", "relative_error",
                             "nonfinite", "ms",   "rays_per_second", "cached"};
const Words comparison_keys = {"mean_error", "rmse", "rel_mse",           "psnr",
                               "noise",      "bias", "share_above_noise", "below_noise"};

Words joined(Words a, const Words& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

// Emission makes the surfaces of the box lamps, too.
void let_glow(const std::string& scene) {
    write(scene, read(scene) + "[[material]]\nname = \"red\"\nemission = [3, 0.5, 0.25]\n");
}

}  // namespace

TEST_CASE("truth: stands beside the method's layers, with its error and how far they are from it", "[program][contract]") {
    const std::string folder = fresh_folder("truth"), scene = small_scene(folder), out = folder + "/out";
    set_cache(folder + "/cache");
    const Result r = render(scene, out, {"--truth", "--spp", "32"});
    CHECK(files_in(out) == Words{"run.json", "small.exr", "small.png", "small.rsm.key.exr", "small.rsm.sun.exr",
                                 "small.truth.png"});
    CHECK_THAT(r.out, Contains("against its truth") && Contains("truth.indirect: one_bounce, 32 samples"));

    const Words names = io::layer_names(io::read_picture(out + "/small.exr"));
    for (const char* name : {"truth", "truth.direct", "truth.indirect"}) {
        CHECK(std::count(names.begin(), names.end(), name) == 1);
        CHECK(std::count(names.begin(), names.end(), std::string(name) + ".error") == 1);
        for (float error : layer(out, std::string(name) + ".error")) REQUIRE(error >= 0);
    }

    const Json truth = run_json(out)["truth"];
    CHECK(keys(truth) == joined(joined(estimate_keys, comparison_keys), {"own_transport", "notes"}));
    CHECK(truth["mode"] == "all");
    CHECK(truth["kind"] == "native");
    CHECK(truth["samples"] == 32);
    CHECK(truth["nonfinite"] == 0);
    CHECK(truth["cached"] == false);
    CHECK(truth["notes"].empty());
    CHECK(keys(truth["own_transport"]) == Words{"direct", "indirect"});
    // The box has a ceiling lamp that emits; the method knows the lights of the scene alone.
    for (const Json& own : truth["own_transport"])
        CHECK(keys(own) == joined(joined(estimate_keys, {"without"}), comparison_keys));
    CHECK(truth["own_transport"]["direct"]["mode"] == "direct");
    CHECK(truth["own_transport"]["indirect"]["mode"] == "one_bounce");

    // The numbers follow from the layers.
    const std::map<std::string, Json> comparisons = {{"", truth},
                                                     {"direct", truth["own_transport"]["direct"]},
                                                     {"indirect", truth["own_transport"]["indirect"]}};
    for (const auto& [name, json] : comparisons) {
        CAPTURE(name);
        const std::string of = name.empty() ? "truth" : "truth." + name;
        const auto a = layer(out, name), b = layer(out, of), error = layer(out, of + ".error");
        double squares = 0, variances = 0, differences = 0;
        int above = 0;
        for (std::size_t i = 0; i < a.size(); i += 3) {
            bool far = false;
            for (std::size_t k = i; k < i + 3; ++k) {
                const double d = double(a[k]) - b[k];
                squares += d * d;
                differences += d;
                variances += double(error[k]) * error[k];
                far |= std::abs(d) > 3 * double(error[k]) + 1e-5 * std::abs(double(b[k]));
            }
            above += far;
        }
        const double n = double(a.size());
        CHECK(json["rmse"].get<double>() == Approx(std::sqrt(squares / n)).epsilon(1e-9));
        CHECK(json["noise"].get<double>() == Approx(std::sqrt(variances / n)).epsilon(1e-9));
        CHECK(json["bias"].get<double>() == Approx(differences / n).epsilon(1e-9));
        CHECK(json["share_above_noise"].get<double>() == Approx(3 * above / n).epsilon(1e-9));
        CHECK(json["below_noise"] == (squares <= variances));
    }

    // Both count the same light: the direct light agrees but for the edges of shadows, which maps of 48 texels blur.
    CHECK(mean(layer(out, "direct")) == Approx(mean(layer(out, "truth.direct"))).epsilon(0.03));
    // One bounce is a part of all light.
    CHECK(mean(layer(out, "truth")) > mean(layer(out, "")));
}

TEST_CASE("truth: a picture that knows its own error is held against the truth with it", "[program][contract]") {
    const std::string folder = fresh_folder("truth_own_error"), scene = small_scene(folder), out = folder + "/out";
    render(scene, out, {"--truth", "--spp", "256", "--no-cache", "--set", "rsm.gather=all_rays", "--set",
                        "rsm.max_rays=1"});
    const Json truth = run_json(out)["truth"];
    const auto own = layer(out, "indirect.error"), albedo = layer(out, "albedo");
    // Of color it is albedo / pi times that of indirect.
    for (const bool color : {false, true}) {
        const std::string of = color ? "truth" : "truth.indirect";
        const auto error = layer(out, of + ".error");
        double variances = 0;
        for (std::size_t i = 0; i < own.size(); ++i) {
            const double e = color ? double(own[i]) * albedo[i] / 3.14159265358979 : own[i];
            variances += double(error[i]) * error[i] + e * e;
        }
        const Json& json = color ? truth : truth["own_transport"]["indirect"];
        CHECK(json["noise"].get<double>() == Approx(std::sqrt(variances / double(own.size()))).epsilon(1e-6));
    }
}

TEST_CASE("truth: of the method direct there is no indirect one", "[program][contract]") {
    const std::string folder = fresh_folder("truth_direct"), scene = small_scene(folder), out = folder + "/out";
    render(scene, out, {"--truth", "--method", "direct", "--spp", "4", "--no-cache"});
    CHECK(keys(run_json(out)["truth"]["own_transport"]) == Words{"direct"});
    const Words names = io::layer_names(io::read_picture(out + "/small.exr"));
    CHECK(std::count(names.begin(), names.end(), "truth.indirect") == 0);
}

TEST_CASE("truth: the method's own transport is the lamps' light alone", "[program]") {
    const std::string folder = fresh_folder("truth_own"), scene = small_scene(folder);
    const Words options = {"--truth", "--spp", "4", "--rays", "exact", "--no-cache"};
    render(scene, folder + "/dark", options);
    let_glow(scene);
    render(scene, folder + "/glowing", options);
    // What glows is not taken for a lamp: the same bits as without it.
    for (const char* name : {"truth.direct", "truth.direct.error", "truth.indirect", "truth.indirect.error"}) {
        CAPTURE(name);
        CHECK(layer(folder + "/dark", name) == layer(folder + "/glowing", name));
    }
    CHECK(mean(layer(folder + "/glowing", "truth")) > 1.05 * mean(layer(folder + "/dark", "truth")));
    const Json truth = run_json(folder + "/glowing")["truth"];
    CHECK_FALSE(truth.contains("without"));
    for (const Json& own : truth["own_transport"]) CHECK(own["without"] == Json{"emission"});
}

TEST_CASE("truth: exact rays give the same files by every instruction set and thread count", "[program]") {
    const std::string folder = fresh_folder("truth_bits"), scene = small_scene(folder, "[31, 23]");
    let_glow(scene);
    for (const Words& method : {Words{"--truth"}, Words{"--method", "reference"}}) {
        std::map<std::string, std::string> expected;
        for (Isa isa : supported_isas()) {
            for (const char* threads : {"1", "2", "3"}) {
                INFO(isa_name(isa) << ", " << threads << " threads, " << method.back());
                render(scene, folder + "/out", joined(method, {"--spp", "4", "--rays", "exact", "--no-cache", "--isa",
                                                               isa_name(isa), "--threads", threads}));
                if (expected.empty()) expected = pictures(folder + "/out");
                CHECK(pictures(folder + "/out") == expected);
                const Json json = run_json(folder + "/out");
                CHECK(json["truth"]["kind"] == "exact");
                CHECK(json["truth"]["cached"] == false);
                CHECK(json["kernels"][method.size() == 1 ? "truth.indirect" : "reference"] == isa_name(isa));
            }
        }
        // Another seed is another picture.
        write(scene, "seed = 4\n" + read(scene).substr(std::string("seed = 3\n").size()));
        render(scene, folder + "/out", joined(method, {"--spp", "4", "--rays", "exact", "--no-cache"}));
        CHECK(pictures(folder + "/out").at("small.exr") != expected.at("small.exr"));
        write(scene, "seed = 3\n" + read(scene).substr(std::string("seed = 4\n").size()));
        std::filesystem::remove_all(folder + "/out");
    }
}

TEST_CASE("reference: as a method the picture itself is traced, and no maps are drawn", "[program]") {
    const std::string folder = fresh_folder("reference"), scene = small_scene(folder), out = folder + "/out";
    const Words options = {"--method", "reference", "--spp", "4", "--rays", "exact", "--no-cache"};
    const Result r = render(scene, out, options);
    CHECK(files_in(out) == Words{"run.json", "small.exr", "small.png"});
    CHECK_THAT(r.out, Contains("left out: paths are traced instead"));
    Words names = io::layer_names(io::read_picture(out + "/small.exr"));
    std::sort(names.begin(), names.end());
    CHECK(names == Words{"", "albedo", "depth", "emission", "id", "normal", "position", "truth.error", "zbuffer"});
    CHECK(keys(run_json(out)["truth"]) == joined(estimate_keys, {"notes"}));

    // The picture is the truth of --truth, to the bit; running all stages changes nothing.
    render(scene, folder + "/beside", {"--truth", "--spp", "4", "--rays", "exact", "--no-cache"});
    CHECK(layer(out, "") == layer(folder + "/beside", "truth"));
    CHECK(read(out + "/small.png") == read(folder + "/beside/small.truth.png"));
    render(scene, folder + "/all", joined(options, {"--no-pruning"}));
    CHECK(layer(out, "") == layer(folder + "/all", ""));
    CHECK(read(out + "/small.png") == read(folder + "/all/small.png"));

    // The scene file chooses it as well.
    write(scene, read(scene) + "[render]\nmethod = \"reference\"\n[reference]\nsamples = 4\nrays = \"exact\"\n");
    render(scene, folder + "/file", {"--no-cache"});
    CHECK(read(out + "/small.exr") == read(folder + "/file/small.exr"));
}

TEST_CASE("reference: an empty scene is the environment", "[program]") {
    const std::string folder = fresh_folder("reference_empty"), scene = folder + "/small.toml";
    write(scene, "[frame]\nsize = [8, 8]\n[environment]\nradiance = [1, 2, 3]\n");
    render(scene, folder + "/out", {"--method", "reference", "--spp", "2", "--no-cache"});
    const std::vector<float> color = layer(folder + "/out", "");
    for (std::size_t i = 0; i < color.size(); ++i) REQUIRE(color[i] == float(1 + i % 3));
    for (float error : layer(folder + "/out", "truth.error")) REQUIRE(error == 0);
}

TEST_CASE("reference: until an error is reached", "[program]") {
    const std::string folder = fresh_folder("until_error"), scene = small_scene(folder, "[31, 23]");
    render(scene, folder + "/out", {"--method", "reference", "--until-error", "0.05", "--no-cache"});
    const Json truth = run_json(folder + "/out")["truth"];
    CHECK(truth["relative_error"].get<double>() <= 0.05);
    CHECK(truth["relative_error"].get<double>() > 0);
}

TEST_CASE("truth: plan lists what render traces", "[program][contract]") {
    const std::string folder = fresh_folder("truth_plan"), scene = small_scene(folder, "[31, 23]");
    for (const Words& method : {Words{"--truth"}, Words{"--method", "reference"}}) {
        const Words options = joined(method, {"--spp", "2"});
        const Result r = run(joined({"plan", scene, "--json"}, options));
        REQUIRE(r.exit == 0);
        render(scene, folder + "/out", joined(options, {"--no-cache"}));
        const Json stages = Json::parse(r.out)["stages"], ran = run_json(folder + "/out")["stages"];
        REQUIRE(stages.size() == ran.size());
        int traced = 0;
        for (std::size_t i = 0; i < stages.size(); ++i) {
            for (const char* key : {"name", "needed", "reason"}) CHECK(stages[i][key] == ran[i][key]);
            if (stages[i]["work_unit"] != "paths") continue;
            ++traced;
            CHECK(stages[i]["work"] == 2 * 31 * 23);
            CHECK(stages[i]["expected_ms"].get<double>() > 0);
        }
        CHECK(traced == (method.size() == 1 ? 3 : 1));
    }
}

TEST_CASE("truth: --dump binds the ports of what was traced", "[program]") {
    const std::string folder = fresh_folder("truth_dump"), scene = small_scene(folder, "[31, 23]");
    let_glow(scene);
    const Json infos = Json::parse(run({"stages", "--json"}).out);
    const auto info = std::find_if(infos.begin(), infos.end(), [](const Json& s) { return s["name"] == "reference"; });
    REQUIRE(info != infos.end());
    for (const Words& method : {Words{"--truth"}, Words{"--method", "reference"}}) {
        render(scene, folder + "/out", joined(method, {"--spp", "2", "--no-cache", "--dump"}));
        int traced = 0;
        const Json dump = Json::parse(read(folder + "/out/dump/dump.json"));
        for (const Json& s : dump["stages"]) {
            if (s["stage"] != "reference") continue;
            ++traced;
            CAPTURE(s);
            const bool points = s["layer"] == "truth.direct" || s["layer"] == "truth.indirect";
            for (const char* kind : {"inputs", "outputs"}) {
                CHECK(s[kind].size() == (*info)[kind].size());
                for (const Json& port : (*info)[kind]) {
                    const std::string name = port["name"];
                    REQUIRE(s[kind].contains(name));
                    const Json& file = s[kind][name];
                    if (!points && (name == "position" || name == "normal")) {
                        CHECK(file.is_null());
                        continue;
                    }
                    CHECK(std::filesystem::file_size(folder + "/out/dump/" + file.get<std::string>()) > 64);
                }
            }
        }
        CHECK(traced == (method.size() == 1 ? 3 : 1));
        std::filesystem::remove_all(folder + "/out");
    }
}

TEST_CASE("cache: a kept reference says so and gives the same files", "[program]") {
    const std::string folder = fresh_folder("cache"), scene = small_scene(folder, "[31, 23]"), kept = folder + "/kept";
    set_cache(kept);
    const Words options = {"--truth", "--spp", "4"};
    render(scene, folder + "/a", options);
    REQUIRE(files_in(kept).size() == 3);
    const Result r = render(scene, folder + "/b", options);
    CHECK_THAT(r.out, Contains("kept from before"));
    CHECK(pictures(folder + "/a") == pictures(folder + "/b"));
    Json a = run_json(folder + "/a")["truth"], b = run_json(folder + "/b")["truth"];
    CHECK(b["cached"] == true);
    for (const Json& own : b["own_transport"]) CHECK(own["cached"] == true);
    // All else is what it was, the time included.
    for (Json* json : {&a, &b}) {
        json->erase("cached");
        for (Json& own : (*json)["own_transport"]) own.erase("cached");
    }
    CHECK(a == b);

    // Neither reads nor writes.
    render(scene, folder + "/c", joined(options, {"--no-cache"}));
    CHECK(run_json(folder + "/c")["truth"]["cached"] == false);
    set_cache(folder + "/other");
    render(scene, folder + "/c", joined(options, {"--no-cache"}));
    CHECK_FALSE(std::filesystem::exists(folder + "/other"));
    set_cache(kept);

    // What changes the bits is traced, what does not is not.
    auto cached = [&](const Words& more) {
        render(scene, folder + "/c", joined(options, more));
        return run_json(folder + "/c")["truth"]["cached"].get<bool>();
    };
    CHECK(cached({"--threads", "1"}));
    CHECK(cached({"--set", "tonemap.exposure=2"}));
    CHECK_FALSE(cached({"--rays", "exact"}));
    CHECK(cached({"--rays", "exact", "--isa", "scalar"}));
    CHECK_FALSE(cached({"--set", "reference.max_bounces=1"}));
    write(scene, read(scene) + "[[material]]\nname = \"red\"\nreflectance = [0.5, 0.1, 0.1]\n");
    CHECK_FALSE(cached({}));
}

TEST_CASE("cache: a file that is broken is never believed, and renewed", "[program]") {
    const std::string folder = fresh_folder("cache_broken"), scene = small_scene(folder, "[31, 23]"),
                      kept = folder + "/kept", out = folder + "/out";
    set_cache(kept);
    const Words options = {"--method", "reference", "--spp", "4"};
    render(scene, out, options);
    const auto expected = pictures(out);
    REQUIRE(files_in(kept).size() == 1);
    const std::string path = kept + "/" + files_in(kept)[0], good = read(path);

    // A whole file of the same size, kept for another seed.
    set_cache(folder + "/another");
    write(scene, "seed = 4\n" + read(scene).substr(std::string("seed = 3\n").size()));
    render(scene, folder + "/another_out", options);
    write(scene, "seed = 3\n" + read(scene).substr(std::string("seed = 4\n").size()));
    const std::string other = read(folder + "/another/" + files_in(folder + "/another").at(0));
    REQUIRE(other.size() == good.size());
    set_cache(kept);

    auto flipped = [&](std::size_t at) {
        std::string bytes = good;
        bytes[at] = char(bytes[at] ^ 1);
        return bytes;
    };
    const std::map<std::string, std::string> broken = {
        {"empty", ""},
        {"cut in the header", good.substr(0, 20)},
        {"cut in the middle", good.substr(0, good.size() / 2)},
        {"cut by one byte", good.substr(0, good.size() - 1)},
        {"longer by one byte", good + "x"},
        {"a byte of the magic", flipped(0)},
        {"a byte of the header", flipped(40)},
        {"a byte of the picture", flipped(good.size() / 2)},
        {"the last byte", flipped(good.size() - 1)},
        {"no bundle", std::string(good.size(), 'x')},
        {"another key", other},
    };
    for (const auto& [what, bytes] : broken) {
        CAPTURE(what);
        write(path, bytes);
        const Result r = render(scene, out, options);
        CHECK_THAT(r.out, Contains("note: " + path) && Contains("traced anew"));
        CHECK(pictures(out) == expected);
        const Json truth = run_json(out)["truth"];
        CHECK(truth["cached"] == false);
        CHECK(truth["notes"].size() == 1);
        CHECK(files_in(kept).size() == 1);
        // Renewed: the next run believes it.
        render(scene, out, options);
        CHECK(run_json(out)["truth"]["cached"] == true);
        CHECK(pictures(out) == expected);
    }
}

TEST_CASE("cache: a folder that cannot be written is a note, not an error", "[program]") {
    const std::string folder = fresh_folder("cache_unwritable"), scene = small_scene(folder, "[31, 23]");
    write(folder + "/file", "mine");
    for (const std::string& place : {folder + "/file", folder + "/file/below", std::string("/proc/nothing")}) {
        CAPTURE(place);
        set_cache(place);
        const Result r = render(scene, folder + "/out", {"--method", "reference", "--spp", "2"});
        CHECK_THAT(r.out, Contains("the reference is not kept"));
    }
    CHECK(read(folder + "/file") == "mine");
}

TEST_CASE("truth: --json prints one object, with the notes in it", "[program][contract]") {
    const std::string folder = fresh_folder("truth_json"), scene = small_scene(folder, "[31, 23]");
    set_cache("/proc/nothing");
    const Result r = render(scene, folder + "/out", {"--truth", "--spp", "2", "--json"});
    const Json json = Json::parse(r.out);
    CHECK(r.out == read(folder + "/out/run.json"));
    CHECK(json["truth"]["notes"].size() == 3);
}

TEST_CASE("truth: Ctrl-C leaves nothing behind, neither pictures nor references", "[program]") {
    const std::string folder = fresh_folder("truth_interrupted"), scene = small_scene(folder);
    set_cache(folder + "/kept");
    const Words before = files_in(folder);
    const Result r = run_and_signal({"render", scene, "-o", folder + "/out", "--method", "reference", "--spp", "65536"},
                                    SIGINT, folder + "/out", ".plumb-");
    CHECK(r.exit == 130);
    CHECK(r.err.empty());
    CHECK(files_in(folder) == before);
}

TEST_CASE("truth: the bar shows samples", "[program]") {
    const std::string folder = fresh_folder("truth_bar"), scene = small_scene(folder);
    const Result r = run_on_terminal({"render", scene, "-o", folder + "/out", "--truth", "--spp", "64", "--no-cache"});
    if (r.exit == no_terminal) {
        WARN("no pseudo-terminal here: the progress bar is not tested");
        return;
    }
    CHECK(r.exit == 0);
    CHECK_THAT(r.out, Contains("truth.direct ") && Contains("/64"));
}
