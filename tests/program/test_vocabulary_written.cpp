// plumb validate: what a shader does with its result before it writes it.
#include "tests/program/vocabulary.h"

using namespace plumb;
using namespace plumb::program;
using Catch::Matchers::Contains;

namespace {

// A result that is multiplied, by three numbers and a number a pixel, and held to a range.
struct Written {
    glm::vec3 scale{1};
    bool albedo = false, sky = false;
    float highest = 0;  // 0: none
};

struct Shaded {
    Exported e{"vocabulary_written"};
    std::string manifest = e.manifest;
    std::vector<float> irradiance;
    std::vector<std::uint8_t> albedo;
    std::vector<float> sky;

    Shaded() {
        gather(e, [&](int x, int y) { return Point{xyz(e.position, pixel(x, y)), xyz(e.normal, pixel(x, y))}; });
        irradiance = words_of<float>(e.stage + "/out/irradiance.bin");
        for (int i = 0; i < width * height; ++i) {
            for (int c = 0; c < 4; ++c) albedo.push_back(std::uint8_t(60 + (i * 13 + c * 50) % 190));
            sky.push_back(0.25f + 0.01f * float(i % 60));
        }
        write_words(e.folder + "/albedo.raw", albedo), write_words(e.folder + "/sky.raw", sky);
    }
    void write(const Written& w) const {
        std::vector<float> out = irradiance;
        for (std::size_t i = 0; i < out.size(); ++i) {
            const std::size_t c = i % 4;
            if (c == 3) continue;
            // In another order than the manifest has it.
            float factor = w.scale[int(c)];
            if (w.sky) factor *= sky[i / 4];
            if (w.albedo) factor *= float(albedo[i]) * (1.0f / 255.0f);
            out[i] = factor * out[i];
            if (w.highest > 0) out[i] = std::min(out[i], w.highest);
        }
        write_words(e.stage + "/out/irradiance.bin", out);
    }
    void say(const Written& w) {
        std::string lines;
        if (w.scale != glm::vec3(1)) lines += fmt::format("scale = [{}, {}, {}]\n", w.scale.x, w.scale.y, w.scale.z);
        if (w.highest > 0) lines += fmt::format("clamp = [0, {}]\n", w.highest);
        const std::string albedo = "{ file = \"albedo.raw\", vk_format = \"R8G8B8A8_UNORM\" }",
                          sky = "{ file = \"sky.raw\", vk_format = \"R32_SFLOAT\" }";
        if (w.albedo && w.sky) lines += "factor = [" + albedo + ", " + sky + "]\n";
        if (w.albedo != w.sky) lines += "factor = " + (w.albedo ? albedo : sky) + "\n";
        const std::string mark = "[stage.output.irradiance]\n";
        e.manifest = replaced(manifest, mark, mark + lines);
    }
};

}  // namespace

TEST_CASE("validate: results times numbers and images, and clamped", "[program][vocabulary]") {
    Shaded s;
    const float most = *std::max_element(s.irradiance.begin(), s.irradiance.end());
    const std::vector<Written> all = {{}, {glm::vec3(0.5f, 2, 0.75f)}, {glm::vec3(1), true}, {glm::vec3(1), false, true},
                                      {glm::vec3(3), true, true}, {glm::vec3(1), false, false, most / 4},
                                      {glm::vec3(2), true, false, most / 4}};
    for (std::size_t i = 0; i < all.size(); ++i)
        for (std::size_t j = 0; j < all.size(); ++j) {
            CAPTURE(i, j);
            s.write(all[i]), s.say(all[j]);
            const Json stage = s.e.judged(i == j ? 0 : 1);
            if (i == j)
                CHECK(stage["counts"]["wrong"] == 0);
            else
                CHECK(stage["counts"]["wrong"] > 20);
            CHECK(stage["nonzero"]["pixels"] > 1000);
        }
}

TEST_CASE("validate: a factor that a shader forgets is named", "[program][vocabulary]") {
    Shaded s;
    s.write({}), s.say({glm::vec3(1), true});
    write(s.e.folder + "/manifest.toml", s.e.manifest);
    const Result r = run({"validate", s.e.folder + "/manifest.toml", "--json"});
    REQUIRE(r.exit == 1);
    const Json stage = Json::parse(r.out)["stages"][0];
    CHECK(stage["diagnosis"]["causes"][0]["with"] == "irradiance divided by irradiance.factor");
    CHECK(stage["diagnosis"]["causes"][0]["agree"] > 0.99);
}

TEST_CASE("validate: where words for what is written do not stand", "[program][vocabulary]") {
    Shaded s;
    const auto with = [&](const std::string& lines) {
        const std::string mark = "[stage.output.irradiance]\n";
        s.e.manifest = replaced(s.manifest, mark, mark + lines);
        return s.e.refused();
    };
    CHECK_THAT(with("clamp = [1, 0]\n"), Contains("clamp") && Contains("expected [lowest, highest]"));
    CHECK_THAT(with("clamp = 1\n"), Contains("expected [lowest, highest]"));
    CHECK_THAT(with("scale = [1, 2]\n"), Contains("expected a number, or one for each of x, y, z"));
    CHECK_THAT(with("normalized = true\n"), Contains("normalized"));
    CHECK_THAT(with("factor = { file = \"sky.raw\", vk_format = \"R32_SFLOAT\", width = 5, height = 5 }\n"),
               Contains("sky.raw") && Contains("output.irradiance"));
    CHECK_THAT(with("factor = \"nosuch.exr\"\n"), Contains("nosuch.exr"));
}
