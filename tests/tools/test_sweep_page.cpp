// The page of a sweep: two charts a scene with every point, its pictures behind it, and one table.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "tools/plumb/sweep_page.h"

using namespace plumb;
using namespace plumb::cli;

namespace {

constexpr double undefined = std::numeric_limits<double>::quiet_NaN();
constexpr int width = 6, height = 4;

SweepPoint point(const std::string& scene, const std::string& curve, frame::Method base, double ms, double rmse) {
    SweepPoint p;
    p.scene = scene, p.method = curve, p.base = base;
    p.settings = base == frame::Method::direct ? "" : fmt::format("rsm.samples = {}", int(ms));
    p.frame_ms = {ms, ms, ms, ms, ms};
    // A path traced point's own noise comes on top of its truth's.
    const bool traced = base == frame::Method::reference;
    p.full = {rmse, rmse * rmse, 0, traced ? 7e-3 : 1e-3, rmse <= 1e-3, 1e-3};
    p.own = {rmse / 4, rmse * rmse / 16, 0, traced ? 7e-3 : 2e-3, rmse / 4 <= 2e-3, traced ? 1e-3 : 2e-3};
    summarise(p, {ms / 2, ms / 2, ms / 2, ms / 2, ms / 2});
    return p;
}

// Two scenes; in the first a curve whose second point has no error that is a number.
Sweep two_scenes() {
    using enum frame::Method;
    Sweep s;
    s.isa = "avx2", s.processor = "a <processor>", s.threads = 2, s.runs = 5, s.memory = "resident";
    s.scenes = {{"a.toml", width, height, 1, 2, 256, 0.01}, {"b<i>.toml", width, height, 3, 4, 64, 0.02}};
    s.points = {point("a.toml", "direct", direct, 2, 0.5), point("a.toml", "rsm.disc", rsm, 10, 0.1),
                point("a.toml", "rsm.disc", rsm, 20, undefined), point("a.toml", "rsm.disc", rsm, 40, 5e-4),
                point("b<i>.toml", "direct", direct, 3, 0)};
    mark_pareto(s.points);
    s.left_out = {{"b<i>.toml", "rsm.disc", "rsm.samples = 9", "refused: <b>"}};
    return s;
}

Rgb8 plain(int value) { return Rgb8(std::size_t(width * height * 3), (unsigned char)value); }

SweepPictures pictures_of(const Sweep& sweep) {
    SweepPictures pictures;
    for (std::size_t s = 0; s < sweep.scenes.size(); ++s) {
        ScenePictures& scene = pictures.scenes.emplace_back();
        scene.truth = plain(200 + int(s));
        for (const frame::MethodInfo& m : frame::methods()) scene.own[m.method] = plain(210 + int(m.method));
    }
    for (std::size_t i = 0; i < sweep.points.size(); ++i)
        pictures.points.push_back({plain(int(i)), plain(50 + int(i)), plain(100 + int(i))});
    return pictures;
}

std::string between(const std::string& text, const std::string& from, const std::string& to) {
    const std::size_t begin = text.find(from);
    REQUIRE(begin != text.npos);
    return text.substr(begin + from.size(), text.find(to, begin + from.size()) - begin - from.size());
}
std::size_t count(const std::string& text, const std::string& part) {
    std::size_t n = 0;
    for (std::size_t at = text.find(part); at != text.npos; at = text.find(part, at + part.size())) ++n;
    return n;
}
Json data_of(const std::string& html) { return Json::parse(between(html, "id=\"data\">", "</script>")); }

const Json& line_of(const Json& chart, const std::string& name) {
    for (const Json& line : chart["lines"])
        if (line["name"].get<std::string>().rfind(name, 0) == 0) return line;
    FAIL("no line " << name);
    return chart;
}

}  // namespace

TEST_CASE("sweep page: two charts a scene hold every point under its curve", "[sweep][page]") {
    const Sweep sweep = two_scenes();
    const std::string html = sweep_html(sweep, nullptr, "plumb sweep a.toml");
    const Json data = data_of(html);
    REQUIRE(data["charts"].size() == 4);
    CHECK(data["pictures"].empty());
    const Json &full = data["charts"][0], &own = data["charts"][1];
    for (const Json& chart : data["charts"]) {
        CHECK(chart["log_x"] == true);
        CHECK(chart["log_y"] == true);
    }
    const Json& disc = line_of(full, "rsm.disc")["points"];
    REQUIRE(disc.size() == 3);
    CHECK(disc[0]["x"] == 10);
    CHECK(disc[0]["y"] == 0.1);
    CHECK(disc[0]["id"] == "point=1");
    CHECK(disc[1]["y"].is_null());  // what is no number is no point, but its values are there
    CHECK(disc[1]["values"].size() > 4);
    // Against their own transport: the time of the method's own stages.
    CHECK(line_of(own, "rsm.disc")["points"][0]["x"] == 5);
    CHECK(line_of(own, "rsm.disc")["points"][0]["y"] == 0.025);
    CHECK(line_of(data["charts"][2], "direct")["points"][0]["y"] == 0);
    // The front, from left to right: direct, and both points of the disc that have an error.
    const Json& front = line_of(full, "Pareto front");
    REQUIRE(front["points"].size() == 3);
    CHECK(front["points"][0]["x"] == 2);
    CHECK(front["points"][2]["x"] == 40);
}

TEST_CASE("sweep page: the noise that is drawn is the truths', without that of the pictures", "[sweep][page]") {
    Sweep sweep = two_scenes();
    sweep.points.insert(sweep.points.begin(), point("a.toml", "reference", frame::Method::reference, 80, 0.02));
    sweep.points.insert(sweep.points.begin() + 1, point("a.toml", "reference", frame::Method::reference, 90, 0.01));
    const Json data = data_of(sweep_html(sweep, nullptr, "plumb sweep a.toml"));
    auto levels = [&](const Json& chart) {
        std::vector<std::pair<std::string, double>> found;
        for (const Json& line : chart["lines"])
            if (line["line"] == "level") found.push_back({line["name"], line["points"][0]["y"]});
        return found;
    };
    using Levels = std::vector<std::pair<std::string, double>>;
    CHECK(levels(data["charts"][0]) == Levels{{"standard error of the truth, 0.001 (dotted)", 1e-3}});
    // Each method is held against its own truth; reference against full global illumination.
    CHECK(levels(data["charts"][1]) == Levels{{"standard error of reference's own truth, 0.001 (dotted)", 1e-3},
                                              {"standard error of direct's own truth, 0.002 (dotted)", 2e-3},
                                              {"standard error of rsm's own truth, 0.002 (dotted)", 2e-3}});
    // A noise that is no number is no line.
    for (SweepPoint& p : sweep.points) p.full.truth_error = undefined;
    CHECK(levels(data_of(sweep_html(sweep, nullptr, "plumb sweep"))["charts"][0]).empty());
}

TEST_CASE("sweep page: a table a scene, all that was left out, and how it was measured", "[sweep][page]") {
    const Sweep sweep = two_scenes();
    const std::string html = sweep_html(sweep, nullptr, "plumb sweep 'b<i>.toml' -o out");
    CHECK(count(html, "<table>") == 3);
    for (std::size_t i = 0; i < sweep.points.size(); ++i)
        CHECK(count(html, fmt::format("href=\"#point={}\"", i)) == 1);
    CHECK(count(html, ">undefined<") == 3);  // rmse and relative mse against full, rmse against its own
    CHECK(count(html, "5e-04 ≤ σ") + count(html, "0.0005 ≤ σ") == 1);
    CHECK(count(html, "●") == 4);
    CHECK(count(html, ">1.5<") == 1);  // ms: half of the 3 of the second scene's only point
    CHECK(count(html, "rsm.samples = 9") == 1);
    CHECK(count(html, "refused: &lt;b&gt;") == 1);
    CHECK(count(html, "plumb sweep &#39;b&lt;i&gt;.toml&#39; -o out") == 1);
    CHECK(count(html, "a &lt;processor&gt;, instruction set avx2, 2 threads") == 1);
    const std::string json = between(html, "id=\"data\">", "</script>");
    for (const char* word : {"NaN", "nan", "Infinity", "<"}) CHECK(count(json, word) == 0);
}

TEST_CASE("sweep page: behind a point lie its picture, the difference and the truth", "[sweep][page]") {
    const Sweep sweep = two_scenes();
    const SweepPictures pictures = pictures_of(sweep);
    const Json data = data_of(sweep_html(sweep, &pictures, "plumb sweep"));
    // A truth and one of each method's own a scene; three a point.
    CHECK(data["pictures"].size() == 2 * (1 + frame::methods().size()) + 3 * sweep.points.size());
    for (const int chart : {0, 1}) {
        const Json& shown = line_of(data["charts"][std::size_t(chart)], "rsm.disc")["points"][2]["pictures"];
        REQUIRE(shown.size() == 3);
        auto caption = [&](std::size_t i) {
            return data["pictures"][shown[i].get<std::size_t>()]["caption"].get<std::string>();
        };
        CHECK(caption(0) == "rsm.disc, rsm.samples = 40");
        CHECK(caption(1).rfind(chart == 0 ? "Picture minus truth" : "Picture minus own truth", 0) == 0);
        CHECK(caption(2) == (chart == 0 ? "Truth: full global illumination, path traced"
                                        : "Truth of rsm's own transport, path traced"));
        for (const Json& picture : shown) CHECK(data["pictures"][picture.get<std::size_t>()]["width"] == width);
    }
    // A picture of another size than its scene's is no picture of it.
    SweepPictures wrong = pictures;
    wrong.points[2].color.pop_back();
    CHECK_THROWS_AS(sweep_html(sweep, &wrong, "plumb sweep"), std::logic_error);
}
