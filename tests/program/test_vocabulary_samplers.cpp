// plumb validate: a light's map that a shader reads through samplers, and patterns that differ over a tile of pixels.
#include <set>

#include "io/npy.h"
#include "tests/program/samplers.h"

using namespace plumb;
using namespace plumb::program;
using Catch::Matchers::Contains;

TEST_CASE("validate: maps that are read through samplers", "[program][vocabulary]") {
    Exported e("vocabulary_samplers", "key", true);
    light_all_over(e);
    const std::string manifest = e.manifest;
    // A border that sends light, from a place in the room.
    const std::vector<Sampler> all = {{false, "border"}, {false, "edge"}, {false, "wrap"}, {true, "border"},
                                      {true, "edge"}, {true, "wrap"}, {false, "border", {0.1f, 0.5f, 0.2f, 0}}};
    for (std::size_t i = 0; i < all.size(); ++i) {
        CAPTURE(all[i].words());
        shade(e, all[i]);
        with_words(e, manifest, all[i].words());
        // Points behind the light's plane are 2^20 texels away, where floats lie an eighth apart: which texel they fall into is
        // undecided in a tenth of the pixels. Between two texels of an edge or a border there is nothing to decide.
        const bool undecided = all[i].address == "wrap" || (!all[i].linear && all[i].address == "edge") || all[i].border != glm::vec4(0);
        const Json stage = e.judged(0, undecided ? "0.3" : "0.005");
        CHECK(stage["counts"]["wrong"] == 0);
        CHECK(stage["nonzero"]["pixels"] > 1000);
        // What is said of another sampler is told.
        for (std::size_t j = 0; j < all.size(); ++j) {
            if (i == j) continue;
            CAPTURE(all[j].words());
            with_words(e, manifest, all[j].words());
            CHECK(e.judged(1)["counts"]["wrong"] > 20);
        }
    }
    // A border of nothing is what a manifest without these words means.
    shade(e, all[0]);
    with_words(e, manifest, "");
    CHECK(e.judged(0)["counts"]["wrong"] == 0);
    // Fractions of 8 bits are a device's right, of 5 they are not.
    for (const int bits : {8, 5}) {
        shade(e, {true, "edge", {}, bits});
        with_words(e, manifest, all[4].words());
        CHECK((e.judged(bits == 8 ? 0 : 1, "0.3")["counts"]["wrong"] == 0) == (bits == 8));
    }
}

TEST_CASE("validate: where samplers do not stand", "[program][vocabulary]") {
    Exported e("vocabulary_samplers_refused");
    write_expected(e.folder);
    const std::string manifest = e.manifest;
    auto with = [&](const std::string& input, const std::string& lines) {
        e.manifest = manifest;
        const std::string mark = "[stage.input." + input + "]\n";
        e.manifest = replaced(manifest, mark, mark + lines);
        return e.refused();
    };
    CHECK_THAT(with("rsm_flux", "filter = \"linear\"\n"), Contains("samples lie on texels") && Contains("stage = \"rsm.disc_continuous\""));
    CHECK_THAT(with("normal", "address = \"edge\"\n"), Contains("input.normal") && Contains("of the light's map"));
    CHECK_THAT(with("rsm_flux", "address = \"mirror\"\n"), Contains("expected border, edge, wrap"));
    CHECK_THAT(with("rsm_flux", "address = \"edge\"\nborder = [0, 0, 0, 1]\n"), Contains("beside address = \"border\""));
    CHECK_THAT(with("rsm_flux", "border = [0, 0]\n"), Contains("expected four numbers"));
    // Of whole texels the address may be said.
    e.manifest = replaced(manifest, "[stage.input.rsm_flux]\n", "[stage.input.rsm_flux]\naddress = \"border\"\n");
    CHECK(e.judged(0)["counts"]["wrong"] == 0);
    // Under a map with light up to its edge the two have different results.
    light_all_over(e);
    std::set<std::string> expected;
    for (const char* address : {"border", "edge", "wrap"}) {
        with_words(e, manifest, fmt::format("address = \"{}\"\n", address));
        expected.insert(e.judged(1)["worst_pixels"].dump());
    }
    CHECK(expected.size() == 3);
}

TEST_CASE("validate: a pattern for each pixel of a tile, with y up", "[program][vocabulary]") {
    for (const bool continuous : {false, true}) {
        CAPTURE(continuous);
        Exported e("vocabulary_tile", "key", continuous);
        constexpr int wide = 4, high = 2, samples = 12;
        std::vector<double> rows;  // [high][wide][samples][3], y up
        for (int tile = 0; tile < wide * high; ++tile)
            for (int k = 0; k < samples; ++k) {
                const double angle = 2.4 * k + 0.7 * tile, r = 1.5 * k + 0.25;
                double x = r * std::cos(angle), y = r * std::sin(angle);
                if (!continuous) x = std::round(x), y = std::round(y);
                rows.insert(rows.end(), {double(float(x)), double(float(y)), 40.0 + 5 * tile + k});
            }
        auto sample = [&](int turn) {
            return [&e, &rows, turn, continuous](int px, int py, std::size_t k, float u, float v) -> std::optional<Sample> {
                const int tile = (py % high) * wide + (px + turn) % wide;
                const double* row = &rows[3 * (std::size_t(tile) * samples + k)];
                const float x = (continuous ? u : std::floor(u)) + float(row[0]), y = (continuous ? v : std::floor(v)) - float(row[1]);
                if (!(x >= 0 && y >= 0 && x < map_side && y < map_side)) return {};
                const std::size_t i = std::size_t(y) * map_side + std::size_t(x);
                return Sample{xyz(e.map_position, i), xyz(e.map_normal, i), xyz(e.flux, i), float(row[2])};
            };
        };
        auto shade_turned = [&](int turn) {
            gather(e, [&](int x, int y) { return Point{xyz(e.position, pixel(x, y)), xyz(e.normal, pixel(x, y))}; }, sample(turn), samples);
        };
        io::write_npy(e.folder + "/tile.npy", DType::f64, {high, wide, samples, 3}, rows.data());
        io::write_npy(e.folder + "/list.npy", DType::f64, {high * wide, samples, 3}, rows.data());
        std::string bare = without(e.manifest, {"samples", "rotations", "reach"});
        for (const std::string& input : {std::string(continuous ? "positions" : "offsets"), std::string("weights")}) {
            const std::size_t at = bare.find("[stage.input." + input + "]");
            bare.erase(at, bare.find("\n[", at) + 1 - at);
        }
        auto with = [&](const std::string& lines) { e.manifest = bare + "[stage.input.pattern]\n" + lines; };
        shade_turned(0);
        for (const char* file : {"tile.npy", "list.npy"}) {
            with(std::string("file = \"") + file + "\"\ny = \"up\"\ntile = [4, 2]\n");
            CHECK(e.judged(0)["counts"]["wrong"] == 0);
        }
        with("file = \"tile.npy\"\ntile = [4, 2]\n");
        CHECK(e.judged(1)["wrong"] > 0.1);
        with("file = \"list.npy\"\ny = \"up\"\ntile = [2, 4]\n");
        CHECK(e.judged(1)["wrong"] > 0.1);
        // The next column of the tile is another pattern.
        shade_turned(1);
        with("file = \"tile.npy\"\ny = \"up\"\ntile = [4, 2]\n");
        CHECK(e.judged(1)["wrong"] > 0.1);
        with("file = \"tile.npy\"\ntile = [3, 2]\n");
        CHECK_THAT(e.refused(), Contains("expected [6, N, 2] or [6, N, 3]"));
        with("file = \"tile.npy\"\ntile = [0, 2]\n");
        CHECK_THAT(e.refused(), Contains("expected [width, height] in pixels"));
        with("file = \"tile.npy\"\n");
        CHECK_THAT(e.refused(), Contains("expected [N, 2]"));
    }
}
