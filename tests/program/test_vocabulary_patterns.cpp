// plumb validate: patterns, samplers of the map, and a manifest to start from.
#include "tests/program/vocabulary.h"

#include "io/npy.h"

using namespace plumb;
using namespace plumb::program;
using Catch::Matchers::Contains;

TEST_CASE("validate: patterns on the unit disc, weights of any kind", "[program][vocabulary]") {
    const std::string folder = fresh_folder("vocabulary_pattern"), scene = small_scene(folder);
    REQUIRE(run({"export", scene, "--stage", "rsm.disc_continuous", "--light", "key", "--set", "rsm.rotations=1", "--set",
                 "rsm.texels=continuous", "-o", folder}).exit == 0);
    write_expected(folder);
    const std::string stage = folder + "/rsm.disc_continuous.key";
    const auto positions = words_of<float>(stage + "/in/positions.bin"), weights = words_of<float>(stage + "/in/weights.bin");
    const std::int64_t n = std::int64_t(weights.size());
    std::vector<double> disc, rows;
    for (std::size_t k = 0; k < weights.size(); ++k) {
        for (std::size_t c = 0; c < 2; ++c) {
            disc.push_back(double(positions[2 * k + c]) / 16);  // a power of two: exact
            rows.push_back(double(positions[2 * k + c]) / map_side);
        }
        rows.push_back(double(weights[k]) / 4);
    }
    std::string bare = without(read(folder + "/manifest.toml"), {"samples", "rotations", "reach"});
    for (const char* input : {"positions", "weights"}) {
        const std::size_t at = bare.find(std::string("[stage.input.") + input + "]");
        bare.erase(at, bare.find("\n[", at) + 1 - at);
    }
    auto judged = [&](const std::string& lines) {
        write(folder + "/manifest.toml", bare + lines);
        return run({"validate", folder + "/manifest.toml", "--json"});
    };
    auto wrong = [&](const std::string& lines) {
        const Result r = judged(lines);
        INFO(r.out << r.err);
        REQUIRE(r.exit < 2);
        return Json::parse(r.out)["stages"][0]["counts"]["wrong"].get<int>();
    };
    io::write_npy(folder + "/disc.npy", DType::f64, {n, 2}, disc.data());
    io::write_npy(folder + "/weights.npy", DType::f32, {n}, weights.data());
    io::write_npy(folder + "/rows.npy", DType::f64, {n, 3}, rows.data());
    const std::string two = "[stage.input.weights]\nfile = \"weights.npy\"\n[stage.input.pattern]\nfile = \"disc.npy\"\n";
    const std::string three = "[stage.input.pattern]\nfile = \"rows.npy\"\n";
    CHECK(wrong(two + "radius = 16\n") == 0);
    CHECK(wrong(two + "radius = 15\n") > 100);
    CHECK(wrong(three + "unit = \"map\"\nweight_scale = 4\n") == 0);
    // Weights as any type of array holds them: of these one is right.
    const std::vector<double> in_double(weights.begin(), weights.end());
    io::write_npy(folder + "/weights.npy", DType::f64, {n, 1}, in_double.data());
    CHECK(wrong(two + "radius = 16\n") == 0);
    const std::vector<std::uint8_t> ones(weights.size(), 1);
    const std::vector<float> even(weights.size(), weights[0]);
    io::write_npy(folder + "/weights.npy", DType::f32, {n}, even.data());
    auto worst = [&](const std::string& lines) { return Json::parse(judged(lines).out)["stages"][0]["worst_pixels"].dump(); };
    CHECK(wrong(two + "radius = 16\n") > 100);
    const std::string as_even = worst(two + "radius = 16\n");
    io::write_npy(folder + "/weights.npy", DType::u8, {n}, ones.data());
    CHECK(worst(two + fmt::format("radius = 16\nweight_scale = {}\n", in_double[0])) == as_even);
    CHECK(worst(two + "radius = 16\n") != as_even);
    io::write_npy(folder + "/weights.npy", DType::u8, {n - 1}, ones.data());
    CHECK_THAT(judged(two + "radius = 16\n").err, Contains("there is no input \"weights\" of "));
    io::write_npy(folder + "/weights.npy", DType::f32, {n}, weights.data());
    CHECK(wrong(three + "unit = \"map\"\n") > 100);
    CHECK(wrong(three + "unit = \"map\"\nradius = 0.5\nweight_scale = 4\n") > 100);
    for (const auto& [lines, message] : std::vector<std::pair<std::string, std::string>>{
             {two + "unit = \"metres\"\n", "expected texels, map"},
             {two + "radius = -1\n", "radius = -1"},
             {"[stage.input.position2]\nfile = \"disc.npy\"\nradius = 16\n", "unknown key 'radius'"}}) {
        const Result r = judged(lines);
        CHECK(r.exit == 2);
        CHECK_THAT(r.err, Contains(message));
    }
    // Whole texels are another stage's.
    write(folder + "/manifest.toml", replaced(bare + two + "radius = 16\n", "\"rsm.disc_continuous\"", "\"rsm.disc\""));
    CHECK_THAT(run({"validate", folder + "/manifest.toml"}).err,
               Contains("expected whole texels") && Contains("stage = \"rsm.disc_continuous\""));
}

TEST_CASE("validate: a manifest to start from, of files as an engine has them", "[program][vocabulary]") {
    Exported e("vocabulary_init");
    write_expected(e.folder);
    const std::string mine = fresh_folder("vocabulary_init_mine");
    auto three = [](const std::vector<float>& texels) {
        std::string bytes;
        for (std::size_t i = 0; i < texels.size() / 4; ++i)
            for (std::size_t c = 0; c < 3; ++c) {
                const Half half = float_to_half(texels[4 * i + c]);
                bytes.append(reinterpret_cast<const char*>(&half), 2);
            }
        return bytes;
    };
    std::string codes, depth;
    for (std::size_t i = 0; i < e.normal.size() / 4; ++i) {
        for (std::size_t c = 0; c < 3; ++c) codes += char(std::lround(255 * (0.5 * double(e.normal[4 * i + c]) + 0.5)));
        const float d = e.normal[4 * i + 3] > 0 ? 0.5f : 1.0f;
        depth.append(reinterpret_cast<const char*>(&d), 4);
    }
    write(mine + "/WorldPos.raw", three(e.position));
    write(mine + "/Normals.raw", codes);
    write(mine + "/Depth.raw", depth);
    write(mine + "/RSM_Position.raw", three(e.map_position));
    write(mine + "/RSM_Normal.raw", three(e.map_normal));
    write(mine + "/RSM_Flux.raw", three(e.flux));
    write(mine + "/shot.jpg", "x");
    const compare::Picture picture{{"R", "G", "B"}, width, height, std::vector<float>(3 * std::size_t(width) * height, 0.5f)};
    write_exr(mine + "/Irradiance.exr", picture);
    std::vector<float> rows;
    for (int k = 0; k < 8; ++k) rows.insert(rows.end(), {0.5f * float(k), -1.5f, 1});
    io::write_npy(mine + "/pattern.npy", DType::f32, {8, 3}, rows.data());

    const Result r = run({"validate", "--init", mine, "--json"});
    INFO(r.out << r.err);
    REQUIRE(r.exit == 0);
    const Json report = Json::parse(r.out);
    CHECK(report["unused"] == Json({"shot.jpg"}));
    const std::string text = read(mine + "/manifest.toml");
    INFO(text);
    CHECK_THAT(text, Contains("stage = \"rsm.disc_continuous\"") && Contains("[stage.input.pattern]") &&
                         Contains("# not used: shot.jpg: .jpg is not read; expected .exr"));
    const std::size_t normal = text.find("[stage.input.normal]"), map = text.find("[stage.input.rsm_flux]");
    CHECK_THAT(text.substr(normal, 120), Contains("R8G8B8_UNORM") && Contains("encoding = \"biased\""));
    CHECK_THAT(text.substr(map, 120), Contains("R16G16B16_SFLOAT") && Contains("width = 48"));
    CHECK_THAT(text.substr(text.find("[stage.coverage]")), Contains("Depth.raw") && Contains("below = 1"));
    CHECK_THAT(text, Contains("[stage.uniforms]") && Contains("\"map.size\" = 48") && Contains("\"map.least_w\" = 1e-06  # m: ") &&
                         Contains("# scale = ?  # of the sum: 1 / pi") && Contains("# [stage.light_view_proj]"));
    // What is left to fill in is named, and nothing else is wrong with it.
    CHECK_THAT(run({"validate", mine + "/manifest.toml"}).err,
               Contains("missing: map.to_texel_x, map.to_texel_y, map.to_texel_w, scale;"));
    std::string filled = replaced(text, "# scale = ?", "scale = 0.31830987");
    const Row w{double(e.row_w[0]), double(e.row_w[1]), double(e.row_w[2]), double(e.row_w[3])};
    filled.insert(filled.find("\n[stage.input.") + 1, "[stage.light_view_proj]\n" + rows_of({clip_row(e.row_x, e.row_w, map_side),
                                                            clip_row(e.row_y, e.row_w, map_side), w, w}));
    write(mine + "/manifest.toml", filled);
    const Result judged = run({"validate", mine + "/manifest.toml"});
    INFO(judged.out << judged.err);
    CHECK(judged.exit == 1);

    // Why a file is refused.
    const std::string odd = fresh_folder("vocabulary_init_odd");
    write_exr(odd + "/irradiance.exr", picture);
    write(odd + "/normal.raw", std::string(5000, 'x'));
    write(odd + "/position.raw", "");
    const Result refused = run({"validate", "--init", odd});
    INFO(refused.out << refused.err);
    CHECK(refused.exit == 0);
    CHECK_THAT(refused.out, Contains("normal.raw has 5000 bytes, 1.906 for each of 61 x 43 texels") &&
                                Contains("position.raw is empty"));
}
