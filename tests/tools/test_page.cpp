#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <limits>

#include "io/image_file.h"
#include "tools/page/embedded.h"
#include "tools/page/markup.h"
#include "tools/page/page.h"

using namespace plumb;
using namespace plumb::page;

namespace {

constexpr double no_number = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

// A name that ends every context it might be put into, with a letter of two bytes and one that is no UTF-8.
const std::string hostile = "</script><script>alert('&\"')</script><!-- \xc3\xa4 \xff";

std::size_t count(std::string_view text, std::string_view part) {
    std::size_t n = 0;
    for (std::size_t at = text.find(part); at != text.npos; at = text.find(part, at + part.size())) ++n;
    return n;
}

// Pages are too long for messages.
bool has(std::string_view text, std::string_view part) { return count(text, part) > 0; }

std::string between(const std::string& text, const std::string& from, const std::string& to) {
    const std::size_t begin = text.find(from);
    REQUIRE(begin != text.npos);
    return text.substr(begin + from.size(), text.find(to, begin + from.size()) - begin - from.size());
}

// What the page's script reads.
Json data_of(const std::string& html) { return Json::parse(between(html, "id=\"data\">", "</script>")); }

// RFC 4648.
std::vector<unsigned char> decoded(const std::string& text) {
    const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::vector<unsigned char> bytes;
    std::uint32_t bits = 0;
    int held = 0;
    for (const char c : text.substr(0, text.find('='))) {
        bits = bits << 6 | std::uint32_t(digits.find(c));
        if ((held += 6) >= 8) bytes.push_back((unsigned char)(bits >> (held -= 8) & 255u));
    }
    return bytes;
}

Image<std::uint32_t> texels_of(const std::string& uri) {
    const std::string start = "data:image/png;base64,";
    REQUIRE(uri.substr(0, start.size()) == start);
    return io::decode_texture("picture", decoded(uri.substr(start.size()))).texels;
}

// Every texel its own colour.
Image<std::uint32_t> colors(int width, int height) {
    Image<std::uint32_t> image(width, height);
    for (std::size_t i = 0; i < image.size(); ++i)
        image.texels[i] = 0xff000000u | std::uint32_t(i) * 2654435u % 0x1000000u;
    return image;
}

// A chart with all that may be in one: 0, NaN, infinity, a level, a front, hundreds of points.
Page all_of_it() {
    Page page(hostile);
    page.heading("Table", "table");
    page.table({{{"name"}, {"ms", true}}, {{"b"}, {"9", true}}, {{"a"}, {"10", true}}, {{"c"}, {"undefined", true}}});
    const int a = page.picture(colors(5, 3), hostile), b = page.picture(colors(4, 4), "b"),
              c = page.picture(colors(3, 3), "c");
    page.figure(b);
    Chart chart{hostile, "ms", "RMSE"};
    chart.lines = {{hostile, {{1, 0.1, {{"settings", hostile}}, {a, b, c}, "point=0"}, {10, 0, {}, {a}, "point=1"}}},
                   {"left out", {{1, no_number}, {2, infinity}, {-3, 1}, {3, 0.5}}, Line::points},
                   {"front", {{1, 0.1}, {10, 0.01}}, Line::dashed},
                   {"noise", {{1, 0.02}}, Line::level}};
    page.chart(chart);
    Chart many{"many", "x", "y", false, true};
    many.lines = {{"hundreds", {}}};
    for (int i = 0; i < 400; ++i) many.lines[0].points.push_back({double(i), std::exp2(-i * 0.1), {}, {}});
    page.chart(many);
    page.chart({"nothing", "x", "y"});
    page.figure(b, {{4, 4}, {0, 0, 4, 4}, 64, "<circle data-key=\"one\" cx=\"2\" cy=\"2\" r=\"1\"/>"});
    page.raw("<details data-key=\"one\"><summary>one</summary>more</details>\n");
    return page;
}

}  // namespace

TEST_CASE("page: markup escapes what means something, and only that", "[tools][page]") {
    CHECK(escaped("a<b>&\"'") == "a&lt;b&gt;&amp;&quot;&#39;");
    CHECK(escaped("\xc3\xa4\n") == "\xc3\xa4\n");
    CHECK(escaped("\xff\x01") == "??");
    // RFC 4648, section 10.
    CHECK(base64({}) == "");
    CHECK(base64({'f'}) == "Zg==");
    CHECK(base64({'f', 'o'}) == "Zm8=");
    CHECK(base64({'f', 'o', 'o'}) == "Zm9v");
    CHECK(base64({'f', 'o', 'o', 'b', 'a', 'r'}) == "Zm9vYmFy");
}

TEST_CASE("page: no text leaves its place", "[tools][page]") {
    Page page = all_of_it();
    page.heading(hostile, hostile);
    page.paragraph(hostile);
    page.table({{{hostile}}, {{hostile, false, 0.5, hostile, "#" + hostile}}}, hostile);
    const std::string html = page.html();
    CHECK(count(html, "<script>alert") == 0);
    CHECK(count(html, "<!--") == 0);
    CHECK(count(html, "&lt;/script&gt;&lt;script&gt;alert(&#39;&amp;&quot;&#39;)") > 5);
    // Of ours: data, Chart.js's terms, Chart.js and the page's own script.
    CHECK(count(html, "<script") == 4);
    CHECK(count(html, "</script") == 4);
    // Names arrive whole; JSON has a character of its own for what is no UTF-8.
    const std::string shown = hostile.substr(0, hostile.size() - 1) + "\xef\xbf\xbd";
    CHECK(data_of(html)["charts"][0]["title"] == shown);
    CHECK(data_of(html)["charts"][0]["lines"][0]["name"] == shown);
    CHECK(data_of(html)["charts"][0]["lines"][0]["points"][0]["values"][0][1] == shown);
}

TEST_CASE("page: nothing is loaded from anywhere", "[tools][page]") {
    const std::string html = all_of_it().html();
    CHECK(has(html, "content=\"default-src 'none'; img-src data:;"));
    for (const char* reference : {"src=\"http", "src=\"//", "href=\"http", "href=\"//", "@import", "url(", "<link"})
        CHECK(!has(html, reference));
    // Addresses stand in Chart.js and its terms alone, which nobody follows.
    CHECK(count(html, "://") == count(chart_js, "://") + count(chart_licence, "://"));
    CHECK(has(html, "Permission is hereby granted"));
    CHECK(has(html, "Chart.js v3"));
    // A page without a chart does not carry Chart.js; without a table no script at all.
    Page plain("plain"), table("table");
    plain.paragraph("text");
    table.table({{{"a"}}, {{"b"}}});
    CHECK(count(plain.html(), "<script") == 0);
    CHECK(count(table.html(), "<script") == 1);
    CHECK(count(table.html(), "://") == 0);
}

TEST_CASE("page: what a chart cannot show is null and counted, and 0 is kept", "[tools][page]") {
    const std::string html = all_of_it().html();
    const Json lines = data_of(html)["charts"][0]["lines"];
    CHECK(lines[0]["points"][1]["y"] == 0);
    CHECK(lines[1]["points"][0] ==
          Json({{"x", 1.0}, {"y", nullptr}, {"values", Json::array()}, {"pictures", Json::array()}, {"id", ""}}));
    CHECK(lines[1]["points"][1]["y"].is_null());
    CHECK(lines[1]["points"][2]["x"].is_null());
    CHECK(lines[1]["points"][3]["y"] == 0.5);
    CHECK(lines[2]["line"] == "dashed");
    CHECK(lines[3]["line"] == "level");
    CHECK(has(html, "1 of the points is 0"));
    CHECK(has(html, "3 of the points are left out"));
    // On a linear axis negative values and 0 have their place; what is no number has none.
    Page page("linear");
    page.chart({"t", "x", "y", false, false, {{"line", {{-1, -2}, {0, 0}, {1, no_number}}}}});
    const std::string linear = page.html();
    CHECK(data_of(linear)["charts"][0]["lines"][0]["points"][0]["y"] == -2);
    CHECK(!has(linear, "logarithmic axis: on"));
    CHECK(has(linear, "1 of the points is left out"));
    // All 400 points are there.
    CHECK(data_of(html)["charts"][1]["lines"][0]["points"].size() == 400);
}

TEST_CASE("page: pictures arrive texel by texel, and equal ones once", "[tools][page]") {
    Page page("pictures");
    const Image<std::uint32_t> image = colors(7, 5);
    CHECK(page.picture(image, "first") == 0);
    CHECK(page.picture(image, "the same with another caption") == 1);
    CHECK(page.picture(colors(5, 7), "another") == 2);
    page.figure(2);
    page.chart({"t", "x", "y", true, true, {{"line", {{1, 1, {}, {0, 1, 2}, "point=0"}}}}});
    const std::string html = page.html();
    const Json data = data_of(html);
    REQUIRE(data["files"].size() == 2);
    CHECK(count(html, "data:image/png;base64,") == 2);
    CHECK(data["pictures"][0]["file"] == data["pictures"][1]["file"]);
    CHECK(data["pictures"][1]["caption"] == "the same with another caption");
    CHECK(texels_of(data["files"][0]).texels == image.texels);
    // The figure holds the other, and the script finds it there.
    CHECK(data["files"][1].is_null());
    CHECK(texels_of(between(html, "<img id=\"file1\" alt=\"another\" width=\"256\" src=\"", "\"")).texels ==
          colors(5, 7).texels);
}

TEST_CASE("page: floats become the nearest byte, and what is no number 0", "[tools][page]") {
    Image4 image(4, 1);
    image.texels = {{0, 0.5f, 1, 0}, {-1, 2, float(no_number), 1}, {0.5f / 255, 1.49f / 255, 254.6f / 255, 0}, {}};
    Page page("bytes");
    page.picture(image, "p");
    page.chart({"t", "x", "y"});
    // 0.5 * 255 + 0.5 = 128; 0.5 and 1.49 of a step round to 1; red is lowest.
    CHECK(texels_of(data_of(page.html())["files"][0]).texels ==
          Buffer<std::uint32_t>{0xffff8000u, 0xff00ff00u, 0xffff0101u, 0xff000000u});
}

TEST_CASE("page: a table's cells have heat, hints, links and an order", "[tools][page]") {
    Page page("table");
    page.table({{{"stage"}, {"error", true, -1, "of what"}},
                {{"good"}, {"0", true, 0}},
                {{"between"}, {"1", true, 0.5, "why", "#there", 7}},
                {{"bad"}, {"2", true, 1}},
                {{"worse"}, {"3", true, 40}},
                {{"unknown"}, {"NaN", true, no_number}},
                {{"none"}, {"5", true}},
                {{"<label>", false, -1, "", "", no_number, "doubt"}, {"6", true}}},
               "caption");
    const std::string html = page.html();
    CHECK(has(html, "<caption>caption</caption>"));
    CHECK(has(html, "<th scope=\"col\" data-number title=\"of what\"><button type=\"button\">error</button></th>"));
    // The ends and the middle of the scale of page.cpp; beyond its end the end.
    CHECK(has(html, "style=\"background:rgb(166,219,181)\" data-number>0</td>"));
    CHECK(has(html,
              "style=\"background:rgb(250,236,178)\" data-number title=\"why\" data-order=\"7\"><a "
              "href=\"#there\">1</a></td>"));
    CHECK(has(html, "style=\"background:rgb(226,114,91)\" data-number>2</td>"));
    CHECK(has(html, "style=\"background:rgb(226,114,91)\" data-number>3</td>"));
    CHECK(has(html, "<td class=\"nan\" data-number>NaN</td>"));
    CHECK(has(html, "<td data-number>5</td>"));
    CHECK(has(html, "<td><span class=\"badge doubt\">&lt;label&gt;</span></td>"));
}

TEST_CASE("page: a figure has marks over it in its texels, and a file of several figures is held once", "[tools][page]") {
    Page page("overlay");
    const Image<std::uint32_t> image = colors(7, 5);
    const int first = page.picture(image, hostile), second = page.picture(image, "again");
    page.figure(first, {{14, 10}, {-1, 0, 15, 10}, 300, "<circle r=\"1\"/>"});
    page.figure(second, {{7, 5}, {0, 0, 7, 5}, 512, ""});
    page.figure(page.picture(colors(3, 3), "other"), {{3, 3}, {0, 0, 3, 3}, 64, ""});
    const std::string html = page.html();
    CHECK(count(html, "data:image/png;base64,") == 2);
    CHECK(has(html, "viewBox=\"-1 0 15 10\" width=\"300\" height=\"200\""));
    const std::string held = between(html, "<g transform=\"scale(14 10)\"><image id=\"drawn0\" width=\"1\" height=\"1\" "
                                           "preserveAspectRatio=\"none\" href=\"", "\"/></g>\n<circle r=\"1\"/></svg>");
    CHECK(texels_of(held).texels == image.texels);
    CHECK(has(html, "<g transform=\"scale(7 5)\"><use href=\"#drawn0\"/></g>"));
    CHECK(has(html, "<image id=\"drawn1\""));
    CHECK(count(html, "<script>alert") == 0);
    CHECK(count(html, "://") == 0);
    // A row has the key of its first cell, escaped.
    page.table({{{"sample"}}, {{"0", true, -1, "", "", no_number, "", "a\"b"}}, {{"1"}}});
    CHECK(has(page.html(), "<tr data-key=\"a&quot;b\"><td"));
    CHECK(has(page.html(), "<tr><td>1</td>"));
}

// For page_in_browser.sh, which looks at it.
TEST_CASE("page: a file for a browser", "[.][page_file]") {
    std::ofstream file(PLUMB_BINARY_DIR "/page_in_browser.html", std::ios::binary);
    file << all_of_it().html();
    REQUIRE(file.flush());
}
