// plumb validate, where it says `wrong`: the cause in its text, its JSON and its page.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>

#include "tests/program/exported.h"

using namespace plumb;
using namespace plumb::program;
using Catch::Matchers::Contains;

namespace {

namespace fs = std::filesystem;

// A copy of an export with right answers, to change.
std::string dumps(const std::string& name) {
    static const std::string exported = export_all("diagnosis_exported");
    const std::string folder = fresh_folder(name);
    fs::copy(exported, folder, fs::copy_options::recursive);
    return folder;
}

// Every word of a raw file, times something.
void scale(const std::string& file, float by) {
    const std::size_t n = read(file).size() / 4;
    std::string bytes = read(file);
    for (std::size_t i = 0; i < n; ++i) {
        const float value = word<float>(bytes, i) * by;
        std::memcpy(bytes.data() + 4 * i, &value, 4);
    }
    write(file, bytes);
}

Json diagnosis_of(const std::string& folder, const std::string& label, int exit, const Words& more = {}) {
    Words words = {"validate", folder + "/manifest.toml", "--json"};
    words.insert(words.end(), more.begin(), more.end());
    const Result r = run(words);
    INFO(r.out << r.err);
    REQUIRE(r.exit == exit);
    return stage_of(Json::parse(r.out), label)["diagnosis"];
}

Words causes_of(const Json& diagnosis) {
    Words all;
    for (const Json& cause : diagnosis["causes"]) all.push_back(cause["with"]);
    return all;
}

}  // namespace

TEST_CASE("diagnosis: named in text, JSON and the page, and for no stage that agrees", "[program]") {
    const std::string folder = dumps("diagnosis_pi");
    scale(folder + "/rsm.disc.key/out/irradiance.bin", 3.14159265f);

    Json all = Json::parse(run({"validate", folder + "/manifest.toml", "--json"}).out);
    for (const Json& stage : all["stages"]) {
        INFO(stage["name"]);
        CHECK(stage["diagnosis"].is_null() == (stage["name"] != "rsm.disc (key)"));
    }
    const Json d = stage_of(all, "rsm.disc (key)")["diagnosis"];
    CHECK(keys(d) == Words{"tried", "ms", "causes", "wrong", "low", "high", "ratios", "largest", "places", "clusters",
                           "unexpected", "unexpected_largest"});
    CHECK(d["tried"] > 200);
    REQUIRE(d["causes"].size() >= 1);
    CHECK(d["causes"][0]["with"] == "irradiance times pi");
    CHECK(d["causes"][0]["agree"] == d["causes"][0]["pixels"]);
    CHECK(d["causes"][0]["without"] < d["causes"][0]["pixels"]);
    CHECK(d["ratios"][0]["quartiles"][1] == Approx(3.14159265));
    CHECK(d["ratios"][0]["constant"] == true);

    const std::string out = fresh_folder("diagnosis_pi_out");
    const Result text = run({"validate", folder + "/manifest.toml", "--html", out + "/report.html"});
    CHECK_THAT(text.out, Contains("with irradiance times pi, 100 % of the pixels agree") &&
                             Contains("got / expected") && Contains("largest errors"));
    CHECK_THAT(read(out + "/report.html"), Contains("<h3>Diagnosis</h3>") && Contains("irradiance times pi"));

    // Not where it is not wanted.
    CHECK(diagnosis_of(folder, "rsm.disc (key)", 1, {"--no-diagnosis"}).is_null());
    CHECK_THAT(run({"validate", folder + "/manifest.toml", "--no-diagnosis"}).out, !Contains("Diagnosis"));
}

TEST_CASE("diagnosis: a manifest that describes the dump otherwise", "[program]") {
    const std::string folder = dumps("diagnosis_manifest"), manifest = folder + "/manifest.toml";
    const std::string whole = only_stage(read(manifest), "compose"), file = "file = \"compose/out/radiance.bin\"\n";
    write(manifest, replaced(whole, file, file + "channels = \"zyx\"\n"));
    CHECK(causes_of(diagnosis_of(folder, "compose", 1)).at(0) == "radiance with x and z swapped");
    write(manifest, replaced(whole, file, file + "flip_y = true\n"));
    CHECK(causes_of(diagnosis_of(folder, "compose", 1)).at(0) == "the result flipped in y");
}

TEST_CASE("diagnosis: the input of another frame, where the manifest has it", "[program]") {
    // The frame before had no sun, and its dumps stand in the manifest, too. This frame's tone mapping read that one's
    // picture.
    const std::string folder = dumps("diagnosis_frames"), manifest = folder + "/manifest.toml";
    const std::string before = export_all("diagnosis_before", {"--set", "light.sun.on=false"});
    fs::copy(before + "/tonemap", folder + "/before", fs::copy_options::recursive);
    const std::string now = only_stage(read(manifest), "tonemap");
    std::string other = now.substr(now.find("[[stage]]"));
    other = replaced(other, "label = \"tonemap\"", "label = \"tonemap before\"");
    for (std::size_t at; (at = other.find("\"tonemap/")) != std::string::npos;) other.replace(at, 9, "\"before/");
    std::string head = now.substr(0, now.find("[[stage]]"));
    head.erase(std::min(head.find("[export"), head.size()));
    write(manifest, head + now.substr(now.find("[[stage]]")) + other);
    write(folder + "/tonemap/out/display.bin", read(folder + "/before/out/display.bin"));

    const Json d = diagnosis_of(folder, "tonemap", 1);
    REQUIRE(!causes_of(d).empty());
    CHECK_THAT(causes_of(d).at(0), Contains("radiance of tonemap before: ") && Contains("before/in/radiance.bin"));
    CHECK(d["causes"][0]["agree"] == d["causes"][0]["pixels"]);
    CHECK(diagnosis_of(folder, "tonemap before", 1).is_null());
}

TEST_CASE("diagnosis: the pixel that is explained expects more than 0, and its largest samples come first", "[program]") {
    const std::string folder = dumps("diagnosis_explained"), manifest = folder + "/manifest.toml";
    const std::string file = "file = \"rsm.disc.key/out/irradiance.bin\"\n";
    write(manifest, replaced(only_stage(read(manifest), "rsm.disc (key)"), file, file + "flip_y = true\n"));
    const Json stage = stage_of(Json::parse(run({"validate", manifest, "--json"}).out), "rsm.disc (key)");
    const Json& d = stage["diagnosis"];
    CHECK(d["unexpected"] > 0);
    const auto first = std::find_if(d["largest"].begin(), d["largest"].end(), [](const Json& e) { return e["expected"] != 0; });
    REQUIRE(first != d["largest"].end());
    CHECK(stage["explain"]["pixel"] == (*first)["pixel"]);

    // JSON has the kernel's order; text the order of what each sample adds.
    const std::string text = run({"validate", manifest}).out;
    const std::size_t at = text.find("explain: rsm.disc (key) at ");
    REQUIRE(at != std::string::npos);
    CHECK_THAT(text.substr(at), !Contains("     0  texel"));
}
