// plumb experiment ipr: pictures and sheets.
#include <algorithm>
#include <catch2/catch.hpp>

#include "core/camera.h"
#include "core/hash.h"
#include "tools/experiments/ipr_pictures.h"
#include "tools/experiments/ipr_sheet.h"

using namespace plumb;
using namespace plumb::cli;

namespace {

Image4 noise(int width, int height, std::uint32_t seed) {
    Image4 image(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const auto h = pixel_hash<std::int32_t>(x, y, 1, int(seed));
            image(x, y) = {unit_float<float>(h.x), unit_float<float>(h.y), 0.5f, 1};
        }
    return image;
}

}  // namespace

TEST_CASE("experiment ipr: the mean of the SSIM picture over whole windows is the SSIM", "[experiment]") {
    const Image4 a = noise(40, 30, 1), other = noise(40, 30, 2);
    Image4 b = a;  // no window of it has an index below 0, where the picture would end
    for (int y = 10; y < 20; ++y)
        for (int x = 5; x < 30; ++x) b(x, y) = glm::mix(a(x, y), other(x, y), 0.3f);
    const Image4 map = ssim_map(a, b);
    double sum = 0;
    for (int y = 5; y < 25; ++y)
        for (int x = 5; x < 35; ++x) sum += double(map(x, y).x);
    CHECK(sum / (20 * 30) == Approx(*ssim_of(a, b)).margin(1e-6));
    CHECK(*ssim_of(a, b) < 0.99);
    CHECK(*ssim_of(a, a) == 1);
    CHECK(ssim_map(noise(8, 8, 1), noise(8, 8, 1)).empty());
}

TEST_CASE("experiment ipr: balls lie where points are seen, and behind what is nearer", "[experiment]") {
    Camera camera;
    camera.position = {0, 0, 5}, camera.look_at = {0, 0, 0};
    const View view = make_view(camera, 1);
    Image4 picture(65, 65, glm::vec4(0)), seen(65, 65, glm::vec4(0, 0, 0, 4.5f));
    draw_balls(picture, seen, view, {{0, 0, 2}}, 0.2, {1, 0, 0});
    CHECK(picture(32, 32).x > 0.9f);
    CHECK(picture(0, 0) == glm::vec4(0));
    Image4 hidden(65, 65, glm::vec4(0));
    draw_balls(hidden, seen, view, {{0, 0, -2}, {0, 0, 9}}, 0.2, {1, 0, 0});  // behind the surface; behind the eye
    CHECK(std::all_of(hidden.texels.begin(), hidden.texels.end(), [](const glm::vec4& c) { return c == glm::vec4(0); }));
    // Up is up.
    Image4 upper(65, 65, glm::vec4(0));
    draw_balls(upper, seen, view, {{0, 0.5, 2}}, 0.05, {1, 0, 0});
    int row = -1;
    for (int y = 0; y < 65 && row < 0; ++y)
        if (upper(32, y).x > 0) row = y;
    CHECK((row >= 0 && row < 32));
}

TEST_CASE("experiment ipr: a sheet is the same in text, JSON, CSV and page", "[experiment]") {
    IprSheet sheet{"table 1", "of nothing", "notes", {{"places"}, {"ms", 3}}, {}, {"a line"}, {}};
    IprErrors e;
    e.mean = 0.125, e.bias = -0.0625, e.rms = 0.25, e.noise = 0.5;
    add_error_heads(sheet.heads, "pixels");
    IprSheetRow row{"one, two", "of", {8.0, std::nullopt}, {{"picture", Image4(4, 4, glm::vec4(1))}}};
    add_error_values(row.values, e);
    sheet.rows.push_back(row);
    row.values = {9.0, 0.5}, row.name = "none";
    add_error_values(row.values, std::nullopt);
    sheet.rows.push_back(row);
    const std::string text = sheet_text(sheet), csv = sheet_csv("scene", sheet);
    for (const char* part : {"table 1: of nothing (notes)", "12.50", "-6.25", "25.00", "0.500", "a line", "pixels: bias %"}) CHECK(text.find(part) != std::string::npos);
    CHECK(sheet_json(sheet)["rows"][0]["pixels: rms %"] == 25);
    CHECK(sheet_json(sheet)["rows"][0]["ms"].is_null());
    CHECK(csv.find("scene,table 1,one; two,of,places,8\n") != std::string::npos);
    CHECK(std::count(csv.begin(), csv.end(), '\n') == 5 + 2);
    page::Page page("page");
    show_sheet(page, "scene", sheet);
    CHECK(page.html().find("one, two: picture") != std::string::npos);
}
