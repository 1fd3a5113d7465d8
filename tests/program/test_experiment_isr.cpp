// plumb experiment isr, small: files, that CSV, JSON and page hold the same numbers, that it goes on, what is refused.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <map>
#include <sstream>

#include "tests/program/program.h"

using namespace plumb::program;
using Catch::Matchers::Contains;

namespace {

std::string small_list(const std::string& folder) {
    small_scene(folder);
    write(folder + "/two_simple.toml",
          "[[camera]]\nscene = \"small.toml\"\nname = \"front\"\nposition = [0, 0.995, 3.934]\n"
          "look_at = [0, 0.995, 0]\nfov_y_deg = 39.3077\n"
          "[[camera]]\nscene = \"small.toml\"\nname = \"inside\"\nposition = [0.5, 1.2, 0.8]\n"
          "look_at = [-0.5, 0.5, -0.5]\nfov_y_deg = 60\n");
    return folder + "/two_simple.toml";
}
Result experiment(const std::string& list, const std::string& out, Words more = {}) {
    Words words = {"experiment",     "isr",         "--list",          list,        "-o", out,         "--size",
                   "32x24",          "--time-size", "64x48",           "--samples", "16", "--repeats", "1",
                   "--beyond-views", "1",           "--turning-views", "1"};
    words.insert(words.end(), more.begin(), more.end());
    return run(words);
}

}  // namespace

TEST_CASE("experiment isr: the same numbers in CSV, JSON and page, and a second run measures none",
          "[program][contract]") {
    const std::string folder = fresh_folder("experiment_isr"), list = small_list(folder), out = folder + "/out";
    const Result r = experiment(list, out);
    INFO(r.err << r.out);
    REQUIRE(r.exit == 0);
    CHECK(r.err.empty());
    for (const char* file : {"isr.csv", "isr.json", "isr.html"}) CHECK(std::filesystem::exists(out + "/" + file));
    const Json json = Json::parse(read(out + "/isr.json"));
    const std::string html = read(out + "/isr.html"), csv = read(out + "/isr.csv");

    std::map<std::string, int> tables;
    std::map<std::string, double> numbers;
    for (const Json& n : json["numbers"]) {
        ++tables[n["table"]];
        if (n["value"].is_null()) continue;
        const std::string key = n["table"].get<std::string>() + "/" + n["scene"].get<std::string>() + "/" +
                                n["row"].get<std::string>() + "/" + n["quantity"].get<std::string>();
        CHECK(numbers.count(key) == 0);  // each once
        numbers[key] = n["value"];
    }
    CHECK(std::count(csv.begin(), csv.end(), '\n') == std::ptrdiff_t(json["numbers"].size() + 1));
    CHECK(tables["summary"] == 10 * 19);  // all and one list, five settings
    CHECK(tables["reach"] == 2);
    CHECK(tables["5.7"] == 4 * 4);
    CHECK(tables["views"] == 2 * (12 + 5 * 7));

    // The gain is what the errors say, and the mean that of the views.
    double sum = 0;
    for (const char* view : {"two_simple_front", "two_simple_inside"}) {
        const std::string at = std::string("views/two_simple/") + view + "/";
        const double before = numbers.at(at + "mean error of DL"),
                     after = numbers.at(at + "mean error of ISR, corrected");
        CHECK(numbers.at(at + "gain, corrected") == Approx(100 * (before - after) / before).epsilon(1e-9));
        CHECK(numbers.at(at + "mean error of ISR, best") <= 1);
        sum += numbers.at(at + "gain, corrected");
    }
    CHECK(numbers.at("summary/all/corrected, ambient = environment/gain, mean") == Approx(sum / 2).epsilon(1e-9));

    // Figure 5.7's samples reach the same share of the height as the views', at twice the size.
    CHECK(numbers.at("reach//views, 32 x 24/reach, over the height") == 125);
    CHECK(numbers.at("5.7/two_simple_front/80 samples/reach, over the height") == 125);
    CHECK(numbers.at("5.7/two_simple_front/24 samples/reach, over the height") == 125);
    CHECK(numbers.count("5.7/two_simple_front/direct light/reach, over the height") == 0);
    CHECK_THAT(html, Contains("4 rings of growing radius, out to 125.0 %"));

    // View dependency: sums over sums of what was kept, no means of ratios. At this size ISR alone reaches nothing.
    const std::string turned =
        numbers.count("turning/two_simple_inside/ISR/mean") ? "two_simple_inside" : "two_simple_front";
    const Json kept = Json::parse(read(out + "/results/turning_" + turned + ".json"))["value"];
    const Json &truth = kept[1], &irradiance = kept[3][1][4];
    double found = 0, truths = 0;
    for (std::size_t p = 0; p < irradiance.size(); ++p)
        for (const Json& e : irradiance[p])
            if (!e.is_null()) found += e.get<double>(), truths += truth[p].get<double>();
    CHECK(found > 0);
    CHECK(numbers.at("turning/" + turned + "/guard band of 64/mean") == Approx(100 * found / truths));

    // The thesis' figures stand beside ours.
    CHECK_THAT(html, Contains("99.05") && Contains("0.8867") && Contains("14.69") && Contains("5.88"));
    CHECK(html.find("src=\"http") == std::string::npos);
    for (const char* id : {"summary", "times", "figures", "cases", "modes", "pov", "beyond", "turning", "views", "how"})
        CHECK_THAT(html, Contains("id=\"" + std::string(id) + "\""));

    // Everything is kept: what is measured again would differ in its times.
    REQUIRE(experiment(list, out).exit == 0);
    CHECK(Json::parse(read(out + "/isr.json"))["numbers"] == json["numbers"]);
    // One result lost: one view is measured again, to the same picture.
    std::filesystem::remove(out + "/results/view_two_simple_front.json");
    REQUIRE(experiment(list, out).exit == 0);
    const Json again = Json::parse(read(out + "/isr.json"));
    for (const Json& n : again["numbers"])
        if (n["table"] == "views" && n["quantity"] == "mean error of ISR, best" && n["row"] == "two_simple_front")
            CHECK(n["value"] == numbers.at("views/two_simple/two_simple_front/mean error of ISR, best"));
}

TEST_CASE("experiment isr: the thesis' pairing, reading by reading, goes on where it was", "[program][povray]") {
    if (std::system("command -v povray > /dev/null 2>&1") != 0) {
        std::cout << "SKIPPED: no povray here (Debian's package povray; tools/install-deps)\n";
        return;
    }
    const std::string folder = fresh_folder("experiment_isr_pairing"), list = small_list(folder), out = folder + "/out";
    const Words words = {"experiment", "isr", "--list", list, "-o", out, "--size", "24x18", "--samples", "16", "--pairing", "pov"};
    const Result r = run(words);
    INFO(r.err << r.out);
    REQUIRE(r.exit == 0);
    CHECK_THAT(r.out, Contains("2 of the lists' 2 views"));
    const Json json = Json::parse(read(out + "/pairing.json"));
    CHECK(json["views"] == 2);
    CHECK(json["left_out"].empty());
    std::map<std::string, double> numbers;
    for (const Json& n : json["numbers"])
        if (n["table"] == "pairing" && !n["value"].is_null())
            numbers[n["scene"].get<std::string>() + "/" + n["row"].get<std::string>() + "/" + n["quantity"].get<std::string>()] = n["value"];
    const std::string at = "POV-Ray, table 1, sRGB/", bytes = "POV-Ray, table 1, sRGB, 8 bits/";
    // Ties are not worse, and in bytes there are more of them.
    for (const char* row : {"as printed", "2 pi / N left out", "2 pi / N for the area", "corrected"}) {
        CAPTURE(row);
        CHECK(numbers.at(at + row + "/pixels not worse") >= numbers.at(at + row + "/pixels better"));
        CHECK(numbers.at(bytes + row + "/pixels better") <= numbers.at(at + row + "/pixels better"));
        CHECK(numbers.at(at + row + "/views not worse") >= numbers.at(at + row + "/views better"));
    }
    // Neither coefficient, no gain; the factor takes most of the light.
    CHECK(numbers.at(at + "2 pi / N left out/gain, mean") > numbers.at(at + "as printed/gain, mean"));
    CHECK(numbers.at(at + "without k_isr/gain, largest") <= 0.5);
    CHECK_THAT(read(out + "/pairing.html"), Contains("5.88") && Contains("99.05") && Contains("occlusion added"));

    // POV-Ray's pictures and the results are kept.
    std::filesystem::remove(out + "/results/pairing_two_simple_front.json");
    REQUIRE(run(words).exit == 0);
    CHECK(Json::parse(read(out + "/pairing.json"))["numbers"] == json["numbers"]);
}

TEST_CASE("experiment isr: what is refused", "[program]") {
    const std::string folder = fresh_folder("experiment_isr_refused"), list = small_list(folder), out = folder + "/out";
    CHECK(run({"experiment", "isr", "-o", out}).exit == 2);
    CHECK(experiment(folder + "/none.toml", out).exit == 2);
    CHECK(experiment(list, out, {"--size", "8x8"}).exit == 2);
    CHECK(experiment(list, out, {"--pairing", "mental ray"}).exit == 2);
    CHECK(experiment(list, out, {"--list", list}).exit == 2);
    CHECK_FALSE(std::filesystem::exists(out));
}
