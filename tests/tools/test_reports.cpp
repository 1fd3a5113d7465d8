#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cstdlib>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>

#include "gi/parity/stages.h"
#include "gi/uniform_words.h"
#include "io/file.h"
#include "tools/shared/progress.h"
#include "tools/shared/reports.h"
#include "tools/shared/table.h"

using namespace plumb;
using namespace plumb::cli;

namespace {

std::vector<std::string> keys(const Json& object) {
    std::vector<std::string> names;
    for (const auto& item : object.items()) names.push_back(item.key());
    return names;
}

using Words = std::vector<std::string>;

}  // namespace

TEST_CASE("table: columns are aligned and no line ends in a space", "[tools]") {
    CHECK(format_table({{"stage"}, {"ms", Align::right}, {"why"}}, {{"a", "1.5", "x"}, {"longer", "12.5", ""}}) ==
          "stage     ms  why\n"
          "a        1.5  x\n"
          "longer  12.5\n");
    CHECK(format_table({{""}, {""}}, {{"a", "b"}}, 2) == "  a  b\n");
    // A letter of two bytes takes one column.
    CHECK(format_table({{""}, {""}}, {{"\xc3\xa4", "b"}, {"cc", "d"}}) == "\xc3\xa4   b\ncc  d\n");
}

TEST_CASE("table: every float comes back from its text", "[tools]") {
    // 9 digits identify a binary32 (IEEE 754-2008, 5.12.2).
    for (float v : {0.1f, 1.0f / 3, 16777215.0f, 1.17549435e-38f, 1e-45f, 3.40282347e38f, -0.3f})
        CHECK(std::strtof(exact_text(v).c_str(), nullptr) == v);
    CHECK(exact_text({1, 0.5}) == "1  0.5");
}

TEST_CASE("reports: compare's JSON has the contract's keys, and null for what is no number", "[tools][contract]") {
    compare::Picture a{{"R", "G", "B"}, 2, 1, {1, 2, 3, 4, 5, 6}}, b = a;
    const Json equal = compare_json(compare::compare(a, b));
    CHECK(keys(equal) == Words{"mean_error", "rmse", "rel_mse", "psnr", "ssim", "flip", "pearson", "max_ulp",
                               "differing", "pixels", "nonfinite", "equal"});
    CHECK(equal["psnr"].is_null());  // infinite
    CHECK(equal["ssim"].is_null());  // undefined below 11 x 11 pixels
    CHECK(equal["equal"] == true);
    CHECK(equal["mean_error"] == 0);
    CHECK(equal["pixels"] == 2);

    b.data[3] = 5;
    const Json different = compare_json(compare::compare(a, b));
    CHECK(different["mean_error"].get<double>() == Approx(1.0 / 6));
    CHECK(different["differing"] == 0.5);
    CHECK(different["equal"] == false);

    b.data[3] = std::numeric_limits<float>::quiet_NaN();
    const Json nan = compare_json(compare::compare(a, b));
    CHECK(nan["mean_error"].is_null());
    CHECK(nan["nonfinite"] == 1);
    CHECK(nan["equal"] == false);
}

TEST_CASE("reports: run.json has the contract's keys and the kernels that ran", "[tools][contract]") {
    Scene scene;
    scene.name = "box";
    RunOptions options;
    options.isa = Isa::sse;
    options.threads = 3;
    std::vector<frame::StageRun> stages(2);
    stages[0].label = "gbuffer", stages[0].reason = "every later stage reads it", stages[0].isa = Isa::sse;
    stages[0].ms = 1.5, stages[0].bytes = 64;
    stages[0].parts = {{"no-emission", "no emission: nothing emits", 0.5}};
    stages[1].label = "rsm (key)", stages[1].needed = false, stages[1].isa = Isa::sse;
    stages[1].reason = "the light is off", stages[1].rule = "light-off", stages[1].saved_ms = 12;
    const Json json = run_json({scene, frame::Settings{}, options, stages, {1, 2.5, 3, 7}, 4096});
    CHECK(keys(json) == Words{"version", "scene", "notes", "settings", "isa", "kernels", "threads", "stages", "read_ms", "render_ms", "write_ms",
                              "total_ms", "peak_bytes"});
    CHECK(Json{json["read_ms"], json["render_ms"], json["write_ms"], json["total_ms"]} == Json{1.0, 2.5, 3.0, 7.0});
    const std::string text = run_text({scene, frame::Settings{}, options, stages, {1, 2.5, 3, 7}, 4096});
    CHECK(text.find("read scene   1.0") != std::string::npos);
    CHECK(text.find("write files  3.0") != std::string::npos);
    CHECK(text.find("1024 x 1024 pixels in 7.0 ms: 1.0 reading, 2.5 rendering, 3.0 writing; by sse on 3 threads") !=
          std::string::npos);
    CHECK(keys(json["stages"][0]) ==
          Words{"name", "needed", "kept", "reason", "rule", "ms", "saved_ms", "parts", "bytes", "reads"});
    CHECK(json["stages"][0]["parts"].dump() ==
          R"([{"rule":"no-emission","reason":"no emission: nothing emits","saved_ms":0.5}])");
    CHECK(json["stages"][1]["rule"] == "light-off");
    CHECK(json["stages"][1]["saved_ms"] == 12);
    CHECK(json["isa"] == "sse");
    CHECK(json["threads"] == 3);
    // A stage that was left out ran no kernel.
    CHECK(json["kernels"] == Json{{"gbuffer", "sse"}});
    CHECK(json["settings"]["rsm"]["radius"].dump() == "0.3");
    CHECK(json["settings"]["rsm"]["gather"] == "paths");
}

TEST_CASE("reports: explain's JSON names a sample only where there is one", "[tools][contract]") {
    frame::Explanation e{"rsm.disc (key)", {3, 4}, {{"n", -1, {0, 1, 0}, ""}, {"form", 7, {0.1f}, "VRSM (3.2)"}}};
    const Json json = explain_json(e);
    CHECK(keys(json) == Words{"stage", "pixel", "values"});
    CHECK(json["pixel"] == Json{3, 4});
    CHECK(keys(json["values"][0]) == Words{"name", "value", "equation"});
    CHECK(keys(json["values"][1]) == Words{"name", "sample", "value", "equation"});
    CHECK(json["values"][0]["value"] == Json{0, 1, 0});
    CHECK(json["values"][1]["value"].get<double>() == double(0.1f));
    CHECK(explain_text(e) ==
          "rsm.disc (key) at 3,4\n"
          "sample  name  value              equation\n"
          "        n     0            1  0\n"
          "     7  form  0.100000001        VRSM (3.2)\n");
}

TEST_CASE("reports: stages' JSON has the contract's keys", "[tools][contract]") {
    const Json json = stages_json(frame::all_stages());
    REQUIRE(json.size() >= 8);
    for (const Json& s : json) {
        CHECK(keys(s) == Words{"name", "source", "inputs", "outputs", "params", "uniforms", "twin", "budget"});
        CHECK_FALSE(s["inputs"].empty());
        CHECK_FALSE(s["outputs"].empty());
    }
}

TEST_CASE("reports: every uniform of every stage says what it means", "[tools][contract]") {
    std::size_t count = 0;
    for (const Json& s : stages_json(frame::all_stages()))
        for (const Json& u : s["uniforms"]) {
            INFO(s["name"] << " " << u["name"]);
            CHECK(keys(u) == Words{"name", "type", "unit", "meaning", "harmless"});
            CHECK_FALSE(u["meaning"] == "");
            ++count;
        }
    CHECK(count > 500);
    const std::string text = stages_text(frame::all_stages());
    CHECK_THAT(text, Catch::Matchers::Contains("uniforms, in the order of the block") &&
                         Catch::Matchers::Contains("floor of |x - x_p|^2"));
}

TEST_CASE("reports: READMEs explain the uniforms in the same words", "[tools][readme]") {
    auto text_of = [](const std::string& path) { return io::read_text(PLUMB_SOURCE_DIR "/" + path, std::size_t(1) << 24); };
    auto cell = [](std::string text) {
        for (std::size_t at = 0; (at = text.find('|', at)) != text.npos; at += 2) text.insert(at, 1, '\\');
        return text;
    };
    const std::string shared = text_of("gi/README.md");
    std::map<std::string, std::string> readmes;
    for (const StageBinding& binding : parity::bindings()) {
        std::string& own = readmes[binding.twin.substr(0, binding.twin.rfind('/'))];
        if (own.empty()) own = text_of(binding.twin.substr(0, binding.twin.rfind('/')) + "/README.md");
        for (const UniformMember& m : binding.uniforms) {
            INFO(binding.info.name << " " << m.name);
            const UniformWords* words = words_of(binding, m.name);
            REQUIRE(words);
            const std::string row = fmt::format(" | {} | {} | {} |\n", words->unit, cell(words->meaning), cell(words->harmless));
            const std::string name = "| `" + words->member + "` |";
            auto has = [&](const std::string& text) {
                for (std::size_t at = 0; (at = text.find(name, at)) != text.npos; ++at)
                    if (text.substr(at, text.find('\n', at) + 1 - at).ends_with(row)) return true;
                return false;
            };
            CHECK((has(own) || has(shared)));
        }
    }
}

TEST_CASE("reports: a name that is no UTF-8 is still JSON", "[tools]") {
    const std::string text = json_text({{"scene", "\xff.toml"}});
    CHECK_NOTHROW(Json::parse(text));
}

TEST_CASE("progress: a line says stage, share and time left, and fits the terminal", "[tools]") {
    const std::string line = progress_line("rsm.disc (key)", 0.43, 2.1, 100);
    CHECK(line.find("rsm.disc (key)") == 0);
    CHECK(line.find(" 43 %  3 s left") != std::string::npos);
    CHECK(progress_line("a", 0.5, -1, 100).find("left") == std::string::npos);
    CHECK(progress_line("a", 0.5, 125, 100).find("2:05 min left") != std::string::npos);
    CHECK(progress_line("a", 0.5, 3725, 100).find("1:02 h left") != std::string::npos);
    for (int width : {1, 20, 40, 60, 80, 200})
        CHECK(int(progress_line("a stage of a very long name", 1.5, 1e4, width).size()) < width);
    // What is done beside stages: the end of a long name stays.
    CHECK(status_text("reading city.toml", 80) == "reading city.toml");
    CHECK(status_text("reading a/very/long/way/to/city.toml", 16) == "...to/city.toml");
}
