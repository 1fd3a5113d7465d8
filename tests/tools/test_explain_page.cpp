// plumb explain --html: samples from values, buffers as pictures, marks over them, and the page of a stage that is made
// up here, since the page knows no stage.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "tools/plumb/explain_marks.h"
#include "tools/plumb/explain_page.h"
#include "tools/plumb/explain_pictures.h"

using namespace plumb;
using namespace plumb::cli;

namespace {

constexpr double no_number = std::numeric_limits<double>::quiet_NaN();
const std::string hostile = "</svg><script>alert('&\"')</script>";

std::size_t count(const std::string& text, const std::string& part) {
    std::size_t n = 0;
    for (std::size_t at = text.find(part); at != text.npos; at = text.find(part, at + part.size())) ++n;
    return n;
}
bool has(const std::string& text, const std::string& part) { return count(text, part) > 0; }

// Three samples: one that brings light, one that is hidden, one outside of the map.
std::vector<TapValue> gather_values() {
    std::vector<TapValue> v = {{"x", -1, {1, 2, 3}, "world, m"}, {"projection", -1, {5.25, 6.5}, "texels"}};
    auto sample = [&](int k, std::vector<double> texel, double inside, double visibility, double weight, double sum) {
        v.push_back({"texel", k, texel, "LRA 4.3.3"});
        v.push_back({"inside", k, {inside}, ""});
        v.push_back({"flux", k, {4, 2, 1}, "Phi_p, W"});
        v.push_back({"weight", k, {weight}, "texels"});
        v.push_back({"slot", k, {double(k)}, "VRSM Algorithm 3"});
        v.push_back({"visibility", k, {visibility}, "VRSM Algorithm 5"});
        v.push_back({"form", k, {0.5}, "VRSM (3.2)"});
        v.push_back({"sum", k, {sum * 4, sum * 2, sum}, "sum so far"});
    };
    sample(0, {3, 4}, 1, 1, 3, 1.5);
    sample(1, {7, 4}, 1, 0, 3, 1.5);
    sample(2, {-2, 9}, 0, 1, 0, 1.5);
    v.push_back({"irradiance", -1, {6, 3, 1.5}, "E"});
    return v;
}

template <class Value>
Array& add_image(Bundle& bundle, const std::string& name, int w, int h, Value value) {
    Image4 image(w, h);
    for (int y = 0; y < h; ++y)
        for (int x = 0; x < w; ++x) image(x, y) = value(x, y);
    return add(bundle, name, image);
}

}  // namespace

TEST_CASE("explain samples: what a gather's sample brings is weight visibility flux form", "[tools][explain]") {
    const std::vector<TapValue> values = gather_values();
    const Samples s = samples_of(values, {});
    REQUIRE(s.all.size() == 3);
    CHECK(s.gathers);
    CHECK(s.all[0].contribution == std::vector<double>{6, 3, 1.5});  // 3 . 1 . (4, 2, 1) . 0.5
    CHECK(s.all[1].contribution == std::vector<double>{0, 0, 0});
    CHECK(s.all[1].hidden());
    CHECK_FALSE(s.all[2].inside);
    CHECK(*s.all[2].texel == glm::dvec2(-2, 9));
    CHECK(s.all[0].sum == std::vector<double>{6, 3, 1.5});
    CHECK(s.together == std::vector<double>{6, 3, 1.5});
    CHECK(s.most == Approx(0.2126 * 6 + 0.7152 * 3 + 0.0722 * 1.5));
    CHECK(s.total() == s.most);
    CHECK_FALSE(s.all[0].path.has_value());

    const SampleTable table = sample_table(s, values, every_sample(s));
    CHECK(table.head == std::vector<std::string>{"sample", "texel", "inside", "slot", "visibility", "weight", "form",
                                                 "contribution", "sum"});
    CHECK(table.rows[0] == std::vector<std::string>{"0", "3,4", "1", "0", "1", "3", "0.5", "6 3 1.5", "6 3 1.5"});
    CHECK(table.rows[2][2] == "0");
    CHECK(table.rows[2][6] == "-");  // of texel 0, not of this sample
    // With paths of two steps, the second sample is the first path's second.
    const Samples paths = samples_of(values, {.steps = 2});
    CHECK(*paths.all[1].path == 0);
    CHECK(*paths.all[1].step == 1);
    CHECK(*paths.all[2].path == 1);
    const std::string text = samples_text(values, {.steps = 2});
    CHECK(has(text, "path  step  texel"));
    CHECK(has(text, "2 of 3 samples bring 0\ntogether: 6  3  1.5\n"));
    CHECK(count(text, "\n") == 5);  // a caption, the head, the one that brings something
    CHECK(samples_text({{"x", -1, {1}, ""}}, {}).empty());
}

TEST_CASE("explain samples: those that bring most come first, what is no number before all", "[tools][explain]") {
    std::vector<TapValue> values = {{"x", -1, {1}, ""}};
    const double brought[] = {0, 2, -8, 2, no_number, 4};
    for (int k = 0; k < 6; ++k) {
        values.push_back({"flux", k, {brought[k], 0, 0}, ""});
        values.push_back({"form", k, {1}, ""});
    }
    values.push_back({"between", -1, {1}, ""});
    for (int k = 6; k < 8; ++k) values.push_back({"flux", k, {double(k), 0, 0}, ""}), values.push_back({"form", k, {1}, ""});
    const Samples s = samples_of(values, {});
    CHECK(by_contribution(s, 0, s.all.size()) == std::vector<std::size_t>{4, 2, 7, 6, 5, 1, 3, 0});
    CHECK(end_of_run(s, 0) == 6);
    CHECK(end_of_run(s, 6) == 8);
    CHECK(nothing_brought(s) == "1 of 8 samples brings 0");

    // Values of one kind stay where they are, those of a sample together.
    const std::vector<TapValue> ordered = by_contribution(values);
    REQUIRE(ordered.size() == values.size());
    std::vector<int> samples;
    for (const TapValue& v : ordered) samples.push_back(v.sample);
    CHECK(samples == std::vector<int>{-1, 4, 4, 2, 2, 5, 5, 1, 1, 3, 3, 0, 0, -1, 7, 7, 6, 6});
    CHECK(ordered[1].name == "flux");
    CHECK(ordered[2].name == "form");

    // Where nobody knows what a sample brings, nothing moves and nothing is said.
    const std::vector<TapValue> steps = {{"depth", 0, {1}, ""}, {"depth", 1, {2}, ""}};
    CHECK(nothing_brought(samples_of(steps, {})).empty());
    CHECK(by_contribution(steps)[0].sample == 0);
    CHECK(samples_text(steps, {}).empty());
    // Of a filter, whose table is the listing itself, how many bring nothing; where none does, no table but the sum.
    CHECK(samples_text({{"weight", 0, {0}, ""}, {"weight", 1, {2}, ""}}, {}) == "samples: what brings most comes first; 1 of 2 samples brings 0\n");
    CHECK(samples_text({{"flux", 0, {0, 0, 0}, ""}, {"form", 0, {1}, ""}}, {}) == "1 of 1 samples brings 0\ntogether: 0  0  0\n");
}

TEST_CASE("explain samples: a texel may be an index, or the sample itself", "[tools][explain]") {
    const std::vector<TapValue> by_index = {{"texel", 0, {9}, ""}, {"x_p", 1, {0, 0, 0}, ""}};
    const Samples s = samples_of(by_index, {.map_width = 4});
    CHECK(*s.all[0].texel == glm::dvec2(1, 2));
    CHECK(*s.all[1].texel == glm::dvec2(1, 0));
    CHECK_FALSE(samples_of(by_index, {}).all[0].texel.has_value());
    // Of a window of 3 x 5 around (10, 20) the eighth is its middle, the last its lower right.
    const std::vector<TapValue> window = {{"weight", 7, {0.5}, ""}, {"irradiance_i", 14, {1, 2, 4}, ""}, {"weight", 14, {2}, ""}};
    const Samples taps = samples_of(window, {.radius = {1, 2}, .pixel = {10, 20}});
    CHECK(*taps.all[0].texel == glm::dvec2(10, 20));
    CHECK(*taps.all[1].texel == glm::dvec2(11, 22));
    CHECK(taps.all[0].contribution == std::vector<double>{0.5});
    CHECK(taps.all[1].contribution == std::vector<double>{2, 4, 8});
}

TEST_CASE("explain samples: without flux, the step of what runs along", "[tools][explain]") {
    const std::vector<TapValue> counts = {{"count", 0, {1}, ""}, {"count", 1, {1}, ""}, {"count", 2, {2}, ""}};
    const Samples lit = samples_of(counts, {});
    CHECK_FALSE(lit.gathers);
    CHECK(lit.all[0].contribution == std::vector<double>{1});
    CHECK(lit.all[1].contribution == std::vector<double>{0});
    CHECK(lit.all[2].contribution == std::vector<double>{1});
    CHECK(samples_of({{"E", 0, {1, 2, 3}, ""}}, {}).all[0].contribution == std::vector<double>{1, 2, 3});
    CHECK(samples_of({{"w", 0, {1}, ""}}, {}).all[0].contribution.empty());
    // What is no number is no light, and hides none.
    const Samples odd = samples_of({{"E", 0, {no_number, 0, 0}, ""}, {"E", 1, {1, 1, 1}, ""}}, {});
    CHECK(odd.all[0].brought() == 0);
    CHECK(odd.most == Approx(1));
}

TEST_CASE("explain pictures: each kind of buffer has its own way into colours", "[tools][explain]") {
    Bundle b;
    auto colour = [](const SlotPicture& p, int x, int y) { return p.texels(x, y); };
    const Array& n = add_image(b, "normal", 2, 1, [](int x, int) { return glm::vec4(x ? 1 : 0, x ? 0 : -1, 0, 1); });
    const SlotPicture normal = slot_picture({.name = "rsm_normal", .meaning = "unit normal"}, n, 0);
    CHECK(colour(normal, 0, 0) == 0xff800080u);  // (0, -1, 0)
    CHECK(colour(normal, 1, 0) == 0xff8080ffu);  // (1, 0, 0)
    CHECK(has(normal.mapping, "0.5 + 0.5 n"));
    CHECK(normal.name == "rsm_normal: unit normal");

    const Array& p = add_image(b, "position", 3, 1, [](int x, int) { return glm::vec4(x * 10.0f, -x, x, 0); });
    const SlotPicture position = slot_picture({.name = "position", .unit = "m"}, p, 0);
    CHECK(colour(position, 0, 0) == 0xff00ff00u);  // 0 stands for nothing, and is held to what is there
    CHECK(colour(position, 1, 0) == 0xff00ff00u);  // least x, largest y, least z
    CHECK(colour(position, 2, 0) == 0xffff00ffu);
    CHECK(has(position.mapping, "10 to 20; -2 to -1; 1 to 2"));

    const Array& d = add_image(b, "map", 3, 1, [](int x, int) { return glm::vec4(9, 9, 9, x == 2 ? 0 : 2 + 2 * x); });
    const SlotPicture depth = slot_picture({.name = "map_position", .unit = "m", .meaning = "w: linear depth"}, d, 0);
    CHECK(colour(depth, 0, 0) == 0xff000000u);
    CHECK(colour(depth, 1, 0) == 0xffffffffu);
    CHECK(has(depth.mapping, "2 to 4"));

    // 200 texels of 1 and one of 1000: the 99th percentile is 1. sRGB of 0.5 is 188 (IEC 61966-2-1).
    const Array& f = add_image(b, "flux", 202, 1, [](int x, int) {
        return glm::vec4(x == 0 ? 1000.0f : x == 1 ? 0.5f : 1.0f, x == 1 ? 0.5f : 1.0f, x == 1 ? 0.5f : 1.0f, 0);
    });
    const SlotPicture flux = slot_picture({.name = "rsm_flux", .unit = "W"}, f, 0);
    CHECK(colour(flux, 0, 0) == 0xffffffffu);
    CHECK(colour(flux, 1, 0) == 0xffbcbcbcu);
    CHECK(has(flux.mapping, "white is 1,"));
    CHECK(has(flux.mapping, "0.5 to 1000"));

    // Light that carries its depth in w (VRSM fig. 4.4) is shown as light.
    const SlotPicture light = slot_picture({.name = "irradiance", .unit = "W/m2", .meaning = "w: linear depth, m"}, f, 0);
    CHECK(light.texels.texels == flux.texels.texels);
    CHECK(light.mapping == flux.mapping);

    const Array& odd = add_image(b, "odd", 2, 1, [](int x, int) { return glm::vec4(x ? float(no_number) : 1.0f); });
    const SlotPicture not_a_number = slot_picture({.name = "radiance", .unit = "W/(m2 sr)"}, odd, 0);
    CHECK(colour(not_a_number, 1, 0) == 0xffff00ffu);
    CHECK(has(not_a_number.mapping, "3 not finite, magenta"));

    const float shares[] = {0, 1, 0.5f, 0.25f};
    const Array& v = add(b, "visibility", {2, 1, 2}, shares);
    const Slot layers{.name = "visibility", .kind = SlotKind::image_array, .channels = 1};
    CHECK(layers_of(layers, v) == 2);
    CHECK(layer_size(layers, v) == glm::ivec2(2, 1));
    CHECK(colour(slot_picture(layers, v, 1), 0, 0) == 0xff808080u);
    CHECK(colour(slot_picture(layers, v, 0), 1, 0) == 0xffffffffu);

    const std::int32_t ids[] = {-1, 7};
    const Slot id{.name = "id", .dtype = DType::i32, .channels = 1};
    const SlotPicture indices = slot_picture(id, add(b, "id", {1, 2}, ids), 0);
    CHECK(colour(indices, 0, 0) == 0xff000000u);
    CHECK(colour(indices, 1, 0) != 0xff000000u);
    CHECK(layers_of({.name = "weights", .kind = SlotKind::buffer}, v) == 0);
    CHECK(buffer_text({.name = "weights", .kind = SlotKind::buffer, .unit = "texels", .meaning = "of a sample"}, v) ==
          "weights (texels): [2, 1, 2] f32, 0 to 1; of a sample");
}

TEST_CASE("explain pictures: made smaller they are means, a part of them is as it was", "[tools][explain]") {
    Image<std::uint32_t> image(3, 2, 0xff000000u);
    image(0, 0) = 0xff0000ffu, image(2, 1) = 0xff00ff00u;
    CHECK(reduction(image, 3) == 1);
    CHECK(reduction(image, 2) == 2);
    const Image<std::uint32_t> half = reduced(image, 2);
    REQUIRE(half.size() == 2);
    CHECK(half(0, 0) == 0xff000040u);  // 255 / 4, rounded
    CHECK(half(1, 0) == 0xff008000u);  // of the two that are there
    const Image<std::uint32_t> part = crop(image, {2, 1}, {2, 2});
    CHECK(part(0, 0) == 0xff00ff00u);
    CHECK(part(1, 1) == 0xff000000u);
}

TEST_CASE("explain marks: area goes by what a sample brought", "[tools][explain]") {
    std::vector<TapValue> values;
    for (int k = 0; k < 3; ++k) {
        values.push_back({"texel", k, {double(10 * k), 5}, ""});
        values.push_back({"E", k, {k == 0 ? 1.0 : k == 1 ? 0.25 : 0.0}, ""});
    }
    const std::string marks = sample_marks(samples_of(values, {}), "7.", {2});
    CHECK(has(marks, "<circle class=\"mark\" data-key=\"7.0\" cx=\"0.5\" cy=\"5.5\" r=\"28\">"));   // 14 px of 2 texels
    CHECK(has(marks, "<circle class=\"mark\" data-key=\"7.1\" cx=\"10.5\" cy=\"5.5\" r=\"14\">"));  // a quarter of it
    CHECK(has(marks, "<circle class=\"none\" data-key=\"7.2\" cx=\"20.5\" cy=\"5.5\" r=\"4\">"));
    CHECK(has(marks, "80 % of the sum"));
    // Large ones lie below small ones, grey ones below all.
    CHECK(marks.find("7.2") < marks.find("7.0"));
    CHECK(marks.find("7.0") < marks.find("7.1"));
    // What is outside of the map is grey, whatever it claims; a hidden sample says so.
    const std::string gather = sample_marks(samples_of(gather_values(), {}), "", {1});
    CHECK(count(gather, "class=\"none\"") == 2);
    CHECK(has(gather, "sample 1: texel 7, 4, hidden"));
    CHECK(has(gather, "sample 2: texel -2, 9, outside"));
    const auto extent = extent_of(samples_of(gather_values(), {}), glm::dvec2(5, 20));
    REQUIRE(extent.has_value());
    CHECK(extent->low == glm::dvec2(-2, 4));
    CHECK(extent->high == glm::dvec2(8, 20));
}

TEST_CASE("explain marks: a triangle is cut behind the eye", "[tools][explain]") {
    const glm::dvec4 whole[] = {{-1, -1, 0, 1}, {1, -1, 0, 1}, {-1, 1, 0, 1}};
    CHECK(triangle_mark(whole, {100, 50}) == "<path class=\"seen\" d=\"M0 0L100 0L0 50z\"/>\n");
    // One corner behind: the cut has two corners more than are left of it, far outside.
    const glm::dvec4 cut[] = {{0, 0, 0, 1}, {1, 0, 0, 1}, {0, 1, 0, -1}};
    CHECK(count(triangle_mark(cut, {100, 100}), "L") == 3);
    const glm::dvec4 behind[] = {{0, 0, 0, -1}, {1, 0, 0, -1}, {0, 1, 0, -1}};
    CHECK(triangle_mark(behind, {100, 100}).empty());
    const glm::dvec4 odd[] = {{no_number, 0, 0, 1}, {1, 0, 0, 1}, {0, 1, 0, 1}};
    CHECK(triangle_mark(odd, {100, 100}).empty());
}

TEST_CASE("explain page: pictures, marks and numbers of a stage that nobody knows", "[tools][explain]") {
    StageBinding binding;
    binding.info.name = "new";
    binding.inputs = {{.name = "position", .unit = "m", .meaning = hostile},
                      {.name = "map_flux", .frame = false, .unit = "W"},
                      {.name = "weights", .kind = SlotKind::buffer, .channels = 1, .frame = false}};
    binding.uniforms = {{"steps", "int", 0}};
    binding.uniform_bytes = 4;
    StageData data;
    data.stage = "new", data.size = {61, 43};
    const std::int32_t steps = 2;
    data.uniforms = uniform_block(steps);
    add_image(data.inputs, "position", 61, 43, [](int x, int y) { return glm::vec4(x, y, 1, 1); });
    add_image(data.inputs, "map_flux", 16, 16, [](int x, int y) { return glm::vec4(x, y, 1, 0); });
    const float weights[] = {1, 2, 3};
    add(data.inputs, "weights", {3}, weights);
    CHECK(sample_shape(&binding, &data, {}).steps == 2);
    CHECK(sample_shape(&binding, &data, {}).map_width == 16);
    CHECK(sample_shape(nullptr, nullptr, {}).steps == 0);

    ExplainedStage stage;
    stage.label = "new (" + hostile + ")", stage.source = hostile, stage.pixel = {30, 21};
    stage.binding = &binding, stage.data = &data;
    stage.notes = {"check: irradiance: equal"};
    for (const TapValue& v : gather_values()) stage.values.lines.push_back({v.name, v.sample, v.equation, v.value, {}, false});
    ExplainPage page("plumb explain");
    page.picture(Image4(61, 43, glm::vec4(0.5f)), {30, 21});
    page.add(stage);
    stage.device = "a device";
    stage.values.lines[5].theirs = std::vector<double>{2};
    stage.values.lines[5].compared = true, stage.values.lines[5].same = false;
    stage.values.parts_at = 5;
    page.add(stage);
    const std::string html = page.html();

    CHECK_FALSE(has(html, "<script>alert"));
    CHECK_FALSE(has(html, "://"));
    CHECK(count(html, "<script") == 1);
    for (const TapValue& v : gather_values()) CHECK(has(html, "<td>" + v.name + "</td>"));
    for (const char* part : {"map_flux (W)", "16 x 16", "weights: [3] f32, 1 to 3", "check: irradiance: equal",
                             "33 x 33 texels around 30,21", "here they part"})
        CHECK(has(html, part));
    // A mark on the map, a row and a list of each sample of both sections, under one key.
    for (const char* key : {"0.0", "0.1", "0.2", "1.2"}) {
        CHECK(count(html, "<circle class=\"mark\" data-key=\"" + std::string(key) + "\"") +
                  count(html, "<circle class=\"none\" data-key=\"" + std::string(key) + "\"") == 1);
        CHECK(count(html, "<tr data-key=\"" + std::string(key) + "\"") == 1);
        CHECK(count(html, "<details data-key=\"" + std::string(key) + "\"") == 1);
    }
    // The list in which they part is open. Pictures of both sections are held once.
    CHECK(count(html, " open><summary>sample 0") == 1);
    CHECK(count(html, "<use href=\"#drawn") >= 3);
    // The whole map is shown beyond its border, a tenth of it at most, and is 512 px wide itself.
    CHECK(has(html, "viewBox=\"-1.6 0 17.6 16\" width=\"563\""));
}

TEST_CASE("explain page: of many samples those that bring most, and a picture of all", "[tools][explain]") {
    StageBinding binding;
    binding.inputs = {{.name = "map_flux", .frame = false, .unit = "W"}};
    StageData data;
    data.stage = "many", data.size = {8, 8};
    add_image(data.inputs, "map_flux", 80, 80, [](int x, int) { return glm::vec4(float(x)); });
    ExplainedStage stage;
    stage.label = "many", stage.binding = &binding, stage.data = &data;
    for (int k = 0; k < 6400; ++k) {
        stage.values.lines.push_back({"flux", k, "", std::vector<double>{double(k), 0, 0}, {}, false});
        stage.values.lines.push_back({"form", k, "", std::vector<double>{1}, {}, false});
    }
    ExplainPage page("many");
    page.add(stage);
    const std::string html = page.html();
    CHECK_FALSE(has(html, "<circle"));
    CHECK(count(html, "<tr data-key=") == most_rows);
    CHECK(count(html, "<details") == most_rows);
    CHECK_FALSE(has(html, "data-key=\"0.5399\""));
    CHECK(has(html, "data-key=\"0.5400\""));  // 6400 - 1000: contributions grow with k
    CHECK(has(html, "The 1000 of 6400 samples that bring most; --json lists all. Largest first. 1 of 6400 samples brings 0."));
    // The largest first, in the table and in the list.
    for (const char* kind : {"<tr data-key=\"0.", "<details data-key=\"0."}) {
        const std::size_t first = html.find(kind);
        REQUIRE(first != std::string::npos);
        CHECK(html.substr(first + std::string(kind).size(), 5) == "6399\"");
    }
    CHECK(has(html, "contribution (W/m2): of each texel"));
}
