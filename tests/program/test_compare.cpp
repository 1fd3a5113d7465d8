// plumb compare: planted errors, verdicts, exit codes, JSON.
#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <limits>

#include "io/image_file.h"
#include "tests/program/program.h"

using namespace plumb;
using namespace plumb::program;
using Catch::Matchers::Contains;

namespace {

constexpr int width = 40, height = 30;

// A smooth picture without equal neighbours, all values in 0.1..0.9.
compare::Picture smooth() {
    compare::Picture p{{"R", "G", "B"}, width, height, {}};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            for (int c = 0; c < 3; ++c)
                p.data.push_back(0.1f + 0.7f * float(x) / width + 0.05f * float(y) / height + 0.02f * float(c));
    return p;
}

struct Pair {
    std::string folder, a, b;
    compare::Picture picture = smooth();

    explicit Pair(const std::string& name) : folder(fresh_folder(name)), a(folder + "/a.exr"), b(folder + "/b.exr") {
        write_exr(b, picture);
    }
    float& at(int x, int y, int c) { return picture.data[(y * width + x) * 3 + c]; }
    Result compare(Words more = {}) {
        write_exr(a, picture);
        more.insert(more.begin(), {"compare", a, b});
        return run(more);
    }
    Json json() {
        const Result r = compare({"--json"});
        INFO(r.out << r.err);
        CHECK(r.err.empty());
        return Json::parse(r.out);
    }
};

}  // namespace

TEST_CASE("compare: equal files are equal, and JSON has the contract's keys", "[program][contract]") {
    Pair p("compare_equal");
    const Result r = p.compare({"--max-error", "0", "--max-ulp", "0", "--max-differing", "0"});
    CHECK(r.exit == 0);
    CHECK_THAT(r.out, Contains("equal, to the bit"));
    const Json json = p.json();
    Words keys;
    for (const auto& item : json.items()) keys.push_back(item.key());
    CHECK(keys == Words{"mean_error", "rmse", "rel_mse", "psnr", "ssim", "flip", "pearson", "max_ulp", "differing",
                        "pixels", "nonfinite", "equal"});
    CHECK(json["psnr"].is_null());
    CHECK(json["ssim"] == 1);
    CHECK(json["flip"] == 0);
    CHECK(json["pixels"] == width * height);
    CHECK(json["equal"] == true);
}

TEST_CASE("compare: one pixel off by one ULP is seen, and where", "[program]") {
    Pair p("compare_ulp");
    p.at(17, 23, 1) = std::nextafter(p.at(17, 23, 1), 2.0f);
    const Json json = p.json();
    CHECK(json["max_ulp"] == 1);
    CHECK(json["differing"].get<double>() == Approx(1.0 / (width * height)));
    CHECK(json["equal"] == false);
    CHECK(p.compare().exit == 0);
    CHECK_THAT(p.compare().out, Contains("pixel 17,23 G"));
    CHECK(p.compare({"--max-ulp", "1"}).exit == 0);
    CHECK(p.compare({"--max-ulp", "0"}).exit == 1);
    CHECK(p.compare({"--max-differing", "0.001"}).exit == 0);
    CHECK(p.compare({"--max-differing", "0.0001"}).exit == 1);
    CHECK(p.compare({"--max-error", "0"}).exit == 1);
    CHECK_THAT(p.compare({"--max-error", "0"}).out, Contains("disagree: mean error"));
}

TEST_CASE("compare: shifted by a pixel, channels swapped, a gradient, one large error", "[program]") {
    const compare::Picture original = smooth();
    SECTION("shifted") {
        Pair p("compare_shift");
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                for (int c = 0; c < 3; ++c) p.at(x, y, c) = original.data[(y * width + std::max(x - 1, 0)) * 3 + c];
        // All columns but the first differ by 0.7 / width.
        CHECK(p.json()["differing"].get<double>() == Approx(double(width - 1) / width));
        CHECK(p.json()["mean_error"].get<double>() == Approx(0.7 / width * (width - 1) / width).epsilon(1e-4));
        CHECK(p.compare({"--max-error", "0.01"}).exit == 1);
    }
    SECTION("swapped") {
        Pair p("compare_swap");
        for (std::size_t i = 0; i < p.picture.data.size(); i += 3) std::swap(p.picture.data[i], p.picture.data[i + 2]);
        CHECK(p.json()["mean_error"].get<double>() == Approx(2 * 0.04 / 3).epsilon(1e-4));
        CHECK(p.json()["flip"].get<double>() > 0.01);
        CHECK(p.compare({"--max-error", "0.02"}).exit == 1);
    }
    SECTION("gradient") {
        Pair p("compare_gradient");
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) p.at(x, y, 0) += 0.01f * float(x) / (width - 1);
        CHECK(p.json()["mean_error"].get<double>() == Approx(0.005 / 3).epsilon(1e-3));
        CHECK_THAT(p.compare().out, Contains("pixel 39,"));
    }
    SECTION("one large error") {
        Pair p("compare_large");
        p.at(3, 4, 2) += 1000;
        CHECK(p.json()["mean_error"].get<double>() == Approx(1000.0 / (3 * width * height)).epsilon(1e-4));
        CHECK_THAT(p.compare().out, Contains("pixel 3,4 B"));
        CHECK(p.compare({"--max-error", "0.2"}).exit == 1);
    }
}

TEST_CASE("compare: NaN and infinity disagree, whatever the bounds", "[program]") {
    for (float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        Pair p("compare_nan");
        p.at(5, 6, 0) = bad;
        const Words generous = {"--max-error", "1e30", "--max-ulp", "4294967295", "--max-differing", "1"};
        CHECK(p.compare().exit == 1);
        CHECK(p.compare(generous).exit == 1);
        CHECK_THAT(p.compare().out, Contains("(5, 6).R"));
        CHECK(p.json()["nonfinite"] == 1);
        CHECK(p.json()["mean_error"].is_null());
        // On both sides.
        write_exr(p.b, p.picture);
        CHECK(p.compare(generous).exit == 1);
        CHECK(p.json()["equal"] == false);
    }
}

TEST_CASE("compare: other sizes, other channels, and files that are no pictures", "[program]") {
    Pair p("compare_mismatch");
    const std::string c = p.folder + "/c.exr";
    write_exr(c, {{"R", "G", "B"}, 2, 1, {1, 2, 3, 4, 5, 6}});
    Result r = run({"compare", p.b, c});
    CHECK(r.exit == 1);
    CHECK_THAT(r.out, Contains("disagree: sizes differ: A is 40 x 30, B is 2 x 1"));
    CHECK(run({"compare", p.b, c, "--max-differing", "1", "--json"}).exit == 1);
    const std::string grey = p.folder + "/grey.exr";
    write_exr(grey, {{"Y"}, 2, 1, {1, 2}});
    r = run({"compare", c, grey});
    CHECK(r.exit == 1);
    CHECK_THAT(r.out, Contains("disagree: channels differ"));

    // A difference picture of what cannot be compared is not written.
    CHECK(run({"compare", p.b, c, "-o", p.folder + "/d.exr"}).exit == 1);
    CHECK_FALSE(std::filesystem::exists(p.folder + "/d.exr"));

    write(p.folder + "/text.exr", "no picture");
    write(p.folder + "/cut.exr", read(p.b).substr(0, 400));
    for (const std::string& bad : {p.folder + "/text.exr", p.folder + "/cut.exr", p.folder + "/none.exr", p.folder}) {
        r = run({"compare", p.b, bad});
        INFO(r.err);
        CHECK(r.exit == 2);
        CHECK(r.err.find("plumb: " + bad) == 0);
        CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
    }
    CHECK(run({"compare", p.b, p.b, "--max-error", "-1"}).exit == 2);
    CHECK(run({"compare", p.b, p.b, "--max-error", "nan"}).exit == 2);
    CHECK(run({"compare", p.b, p.b, "--max-differing", "2"}).exit == 2);
    CHECK(run({"compare", p.b, p.b, "--max-ulp", "-1"}).exit == 2);
}

TEST_CASE("compare: the difference picture holds |A - B|", "[program]") {
    Pair p("compare_difference");
    p.at(7, 8, 1) += 0.25f;
    const float expected = std::abs(p.at(7, 8, 1) - smooth().data[(8 * width + 7) * 3 + 1]);
    CHECK(p.compare({"-o", p.folder + "/d.exr"}).exit == 0);
    const compare::Picture d = io::read_picture(p.folder + "/d.exr");
    CHECK(d.channels == Words{"R", "G", "B"});
    for (std::size_t i = 0; i < d.data.size(); ++i)
        REQUIRE(d.data[i] == (i == std::size_t((8 * width + 7) * 3 + 1) ? expected : 0.0f));
    CHECK(p.compare({"-o", p.folder + "/d.png"}).exit == 0);
    const compare::Picture png = io::read_picture(p.folder + "/d.png");
    CHECK(png.data[(8 * width + 7) * 3 + 1] == 64.0f / 255);  // round(0.25 * 255)
    CHECK(png.data[0] == 0);
    CHECK(files_in(p.folder) == Words{"a.exr", "b.exr", "d.exr", "d.png"});

    // The negative is 1 minus that: 1 where nothing differs.
    CHECK(p.compare({"-o", p.folder + "/n.exr", "--negative"}).exit == 0);
    const compare::Picture n = io::read_picture(p.folder + "/n.exr");
    REQUIRE(n.data.size() == d.data.size());
    for (std::size_t i = 0; i < d.data.size(); ++i) REQUIRE(n.data[i] == 1 - d.data[i]);
    const Result alone = p.compare({"--negative"});
    CHECK(alone.exit == 2);
    CHECK_THAT(alone.err, Contains("--negative: expected -o"));
}

TEST_CASE("compare: the signed error is blue where A is darker, red where it is brighter, else white", "[program]") {
    Pair p("compare_signed");
    // By half of what is there and more: full colour, (0.10, 0.28, 0.75) and (0.78, 0.09, 0.11) of 255.
    for (int c = 0; c < 3; ++c) p.at(5, 6, c) *= 0.25f, p.at(7, 8, c) *= 4;
    const std::string png = p.folder + "/signed.png";
    const Result r = p.compare({"--signed-error", png});
    CHECK(r.exit == 0);
    CHECK_THAT(r.out, Contains("wrote " + png));
    const compare::Picture picture = io::read_picture(png);
    REQUIRE((picture.width == width && picture.height == height));
    auto bytes = [&](int x, int y) {
        std::vector<int> rgb;
        for (int c = 0; c < 3; ++c)
            rgb.push_back(int(std::lround(255 * picture.data[std::size_t(y * width + x) * picture.channels.size() + c])));
        return rgb;
    };
    CHECK(bytes(5, 6) == std::vector<int>{26, 71, 191});
    CHECK(bytes(7, 8) == std::vector<int>{199, 23, 28});
    CHECK(bytes(6, 7) == std::vector<int>{255, 255, 255});
    const Result bad = p.compare({"--signed-error", p.folder + "/signed.exr"});
    CHECK(bad.exit == 2);
    CHECK_THAT(bad.err, Contains("expected a name that ends in .png"));
    CHECK_FALSE(std::filesystem::exists(p.folder + "/signed.exr"));
}

TEST_CASE("compare: a rendered file by layers", "[program]") {
    const std::string folder = fresh_folder("compare_layers"), scene = small_scene(folder);
    REQUIRE(run({"render", scene, "-o", folder + "/a"}).exit == 0);
    REQUIRE(run({"render", scene, "-o", folder + "/b", "--set", "rsm.samples=5"}).exit == 0);
    const std::string a = folder + "/a/small.exr", b = folder + "/b/small.exr";
    const Result r = run({"compare", a, b});
    CHECK(r.exit == 0);
    for (const char* layer : {"color", "indirect", "albedo", "shadow.key"}) CHECK_THAT(r.out, Contains(layer));
    CHECK(run({"compare", a, b, "--layer", "direct", "--max-ulp", "0"}).exit == 0);
    CHECK(run({"compare", a, b, "--layer", "indirect", "--max-ulp", "0"}).exit == 1);
    CHECK(run({"compare", a, b, "--layer", "color", "--max-ulp", "0"}).exit == 1);
    CHECK(run({"compare", a, b, "--layer", "colour"}).exit == 2);
    // The figures of the whole file are those of its color; every layer has its own.
    const Json whole = Json::parse(run({"compare", a, b, "--json"}).out),
               color = Json::parse(run({"compare", a, b, "--json", "--layer", "color"}).out);
    CHECK(whole["flip"].get<double>() > 0);
    CHECK(color["mean_error"].get<double>() > 0);
    for (const std::string& key : keys(color)) CHECK(whole[key] == color[key]);
    CHECK(whole["layers"].size() == 12);
    for (const Json& layer : whole["layers"]) {
        const std::string name = layer["layer"];
        INFO(name);
        const Json alone = Json::parse(run({"compare", a, b, "--json", "--layer", name}).out);
        for (const std::string& key : keys(alone))
            if (layer[key] != alone[key]) CHECK(layer[key].is_null());  // SSIM and FLIP of a lone channel
    }
    // The difference has the same layers.
    REQUIRE(run({"compare", a, b, "-o", folder + "/d.exr"}).exit == 0);
    CHECK(io::read_picture(folder + "/d.exr").channels == io::read_picture(a).channels);
    REQUIRE(run({"compare", a, b, "-o", folder + "/d.png"}).exit == 0);

    const Result png = run({"compare", folder + "/a/small.png", folder + "/b/small.png"});
    CHECK(png.exit == 0);
    CHECK(run({"compare", a, folder + "/b/small.png"}).exit == 2);
}

namespace {

struct PlantedLayer {
    std::string name;
    Words components;
    float value;  // of every pixel, of A and B; color is smooth()
};

// Files of layers whose differences are known: `plant` changes A.
struct Layered {
    std::string folder, a, b;
    std::vector<PlantedLayer> layers;
    std::vector<std::vector<float>> data;

    Layered(const std::string& name, std::vector<PlantedLayer> wanted)
        : folder(fresh_folder(name)), a(folder + "/a.exr"), b(folder + "/b.exr"), layers(std::move(wanted)) {
        for (const PlantedLayer& l : layers)
            data.push_back(l.name == "color" ? smooth().data
                                             : std::vector<float>(width * height * l.components.size(), l.value));
        write_to(b);
    }
    void write_to(const std::string& path) const {
        std::vector<io::Layer> all;
        for (std::size_t i = 0; i < layers.size(); ++i)
            all.push_back({layers[i].name, layers[i].components, data[i].data(), int(layers[i].components.size())});
        io::write_exr(path, width, height, all);
    }
    Result compare(Words more = {}) const {
        write_to(a);
        more.insert(more.begin(), {"compare", a, b});
        return run(more);
    }
    Json json() const { return Json::parse(compare({"--json"}).out); }
};

const std::vector<PlantedLayer> usual = {
    {"color", {"R", "G", "B"}, 0}, {"depth", {"Y"}, 100}, {"id", {"Y"}, 7}, {"position", {"X", "Y", "Z"}, -3}};

Json layer_of(const Json& json, const std::string& name) {
    for (const Json& layer : json.at("layers"))
        if (layer.at("layer") == name) return layer;
    return nullptr;
}

}  // namespace

TEST_CASE("compare: of several layers the figures are those of color, and no layer's difference is hidden",
          "[program][contract]") {
    Layered f("compare_headline", usual);
    CHECK(f.json()["equal"] == true);
    CHECK_THAT(f.compare().out, Contains("equal, to the bit"));
    f.data[1][5] = 104;   // 4 m of one pixel
    f.data[2][70] = 8;    // another triangle
    const Json json = f.json();
    for (const char* zero : {"mean_error", "rmse", "rel_mse", "flip", "max_ulp", "differing"}) CHECK(json[zero] == 0);
    CHECK(json["psnr"].is_null());
    CHECK(json["equal"] == false);
    CHECK(json["layer"] == "color");
    CHECK(layer_of(json, "color")["equal"] == true);
    CHECK(layer_of(json, "position")["equal"] == true);
    CHECK(layer_of(json, "depth")["mean_error"].get<double>() == Approx(4.0 / (width * height)));
    CHECK(layer_of(json, "depth")["flip"].is_null());
    CHECK(layer_of(json, "depth")["max_ulp"] == std::bit_cast<std::uint32_t>(104.0f) - std::bit_cast<std::uint32_t>(100.0f));
    CHECK(layer_of(json, "id")["differing"].get<double>() == Approx(1.0 / (width * height)));
    CHECK(keys(layer_of(json, "id")) == Words{"layer", "mean_error", "rmse", "rel_mse", "psnr", "ssim", "flip", "pearson",
                                              "max_ulp", "differing", "pixels", "nonfinite", "equal"});
    const Result plain = f.compare();
    CHECK(plain.exit == 0);
    CHECK_THAT(plain.out, Contains("they differ; no bound was given; beside color differ: depth, id"));
    CHECK_THAT(plain.out, Contains("of the layer color"));

    // Metres do not count against a bound on radiance; floats, pixels and exactness count everywhere.
    const Result bounded = f.compare({"--max-error", "1e-6"});
    CHECK(bounded.exit == 0);
    CHECK_THAT(bounded.out, Contains("agree: within the bounds; beside color differ: depth, id"));
    for (const Words& bound : {Words{"--max-error", "0"}, Words{"--max-ulp", "0"}, Words{"--max-differing", "0"}}) {
        const Result r = f.compare(bound);
        CHECK(r.exit == 1);
        CHECK_THAT(r.out, Contains("disagree: layer depth: "));
    }
    CHECK(f.compare({"--max-ulp", "0", "--json"}).exit == 1);
    CHECK(f.compare({"--max-ulp", "0", "--layer", "color"}).exit == 0);
    CHECK(f.compare({"--max-error", "1e-6", "--layer", "depth"}).exit == 1);

    // The headline's own reason comes first.
    f.data[0][0] += 0.5f;
    CHECK_THAT(f.compare({"--max-error", "1e-6"}).out, Contains("disagree: mean error"));
    CHECK(f.json()["mean_error"].get<double>() == Approx(0.5 / (3 * width * height)).epsilon(1e-5));
}

TEST_CASE("compare: a NaN in any layer disagrees, whatever the bounds", "[program]") {
    Layered f("compare_layer_nan", usual);
    f.data[3][4] = std::numeric_limits<float>::quiet_NaN();
    const Result r = f.compare({"--max-error", "1e30", "--max-ulp", "4294967295", "--max-differing", "1"});
    CHECK(r.exit == 1);
    CHECK_THAT(r.out, Contains("disagree: 1 pixel holds NaN or Inf; first: A(1, 0).position.Y"));
    const Json json = f.json();
    CHECK(json["nonfinite"] == 1);
    CHECK(json["equal"] == false);
    CHECK(json["mean_error"] == 0);
    CHECK(layer_of(json, "position")["mean_error"].is_null());
    CHECK(layer_of(json, "depth")["nonfinite"] == 0);
    f.write_to(f.b);  // on both sides
    CHECK(f.compare().exit == 1);
}

TEST_CASE("compare: a layer that one file lacks, and one of another name, disagree", "[program]") {
    Layered whole("compare_layer_lacks", usual);
    for (const auto& layers : {std::vector<PlantedLayer>(usual.begin(), usual.end() - 1),
                               std::vector<PlantedLayer>{usual[0], usual[1], {"ids", {"Y"}, 7}, usual[3]}}) {
        const Layered other("compare_layer_other", layers);
        for (const auto& [a, b] : {std::pair(whole.b, other.b), std::pair(other.b, whole.b)}) {
            const Result r = run({"compare", a, b, "--max-error", "1e30"});
            CHECK(r.exit == 1);
            CHECK_THAT(r.out, Contains("disagree: channels differ"));
            const Json json = Json::parse(run({"compare", a, b, "--json"}).out);
            CHECK(json["mean_error"].is_null());
            CHECK(json["equal"] == false);
        }
        CHECK(run({"compare", whole.b, other.b, "--layer", "color", "--max-ulp", "0"}).exit == 0);
    }
}

TEST_CASE("compare: without color the first layer of R, G and B is the headline, and it is said", "[program]") {
    Layered f("compare_no_color", {{"depth", {"Y"}, 9}, {"direct", {"R", "G", "B"}, 0.5f}, {"indirect", {"R", "G", "B"}, 0.25f}});
    f.data[0][3] = 10;
    f.data[2][0] = 0.5f;
    const Result r = f.compare();
    CHECK_THAT(r.out, Contains("of the layer direct"));
    CHECK(f.json()["layer"] == "direct");
    CHECK(f.json()["mean_error"] == 0);
    CHECK(layer_of(f.json(), "indirect")["mean_error"].get<double>() == Approx(0.25 / (3 * width * height)));
    CHECK(layer_of(f.json(), "indirect")["flip"].get<double>() > 0);
    CHECK(f.compare({"-o", f.folder + "/d.png"}).exit == 0);

    // None of R, G and B: the first of the file.
    Layered grey("compare_no_rgb", {{"depth", {"Y"}, 9}, {"id", {"Y"}, 1}});
    grey.data[1][0] = 2;
    CHECK(grey.json()["layer"] == "depth");
    CHECK(grey.compare({"--max-differing", "0"}).exit == 1);
    CHECK(grey.compare().exit == 0);
}
