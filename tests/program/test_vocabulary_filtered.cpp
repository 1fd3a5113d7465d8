// plumb validate: what a shader does with a texel of the light's map once its sampler has read it.
#include "io/npy.h"
#include "tests/program/samplers.h"

using namespace plumb;
using namespace plumb::program;
using Catch::Matchers::Contains;

namespace {

// What a shader does with what its samplers give, and which samples it skips.
struct Reading {
    bool unit = false;
    float along = 0;
    bool skips = false;
};

void shade(const Exported& e, const Sampler& s, const Reading& reading, float shift = 0) {
    gather(e, [&](int x, int y) { return Point{xyz(e.position, pixel(x, y)), xyz(e.normal, pixel(x, y))}; },
           [&](int, int, std::size_t k, float u, float v) -> std::optional<Sample> {
               const float x = u + e.positions[2 * k] + shift, y = v + e.positions[2 * k + 1] + shift;
               if (reading.skips && (x < 0 || x > map_side || y < 0 || y > map_side)) return {};
               glm::vec3 n = s(e.map_normal, x, y);
               const float length = std::sqrt(glm::dot(n, n));
               if (reading.unit && length > 0) n = n / length;
               return Sample{s(e.map_position, x, y) + n * reading.along, n, s(e.flux, x, y), e.weights[k]};
           },
           e.weights.size());
}

void set_uniform(std::string& manifest, const std::string& name, const std::vector<float>& values) {
    manifest = without(manifest, {name});
    const std::string table = "[stage.uniforms]\n";
    manifest.insert(manifest.find(table) + table.size(), fmt::format("\"{}\" = [{}]\n", name, fmt::join(values, ", ")));
}

// Points whose projections lie at a texel's centre, and so do all samples; light from a plane above them.
void lie_on_centres(Exported& e, std::string& manifest) {
    for (std::size_t i = 0; i < e.position.size() / 4; ++i) {
        const float values[8] = {0.5f, 0.5f, 0.001f * float(i % 97), 1, 0, 0, 1, 1};
        std::copy_n(values, 4, &e.position[4 * i]), std::copy_n(values + 4, 4, &e.normal[4 * i]);
    }
    for (std::size_t i = 0; i < e.map_position.size() / 4; ++i) {
        const float x = float(i % map_side), y = float(i / map_side);
        const float values[8] = {0.02f * x, 0.03f * y, 2 + 0.1f * float((i * 7) % 5), 1, 0.6f, 0, -0.8f, 1};
        std::copy_n(values, 4, &e.map_position[4 * i]), std::copy_n(values + 4, 4, &e.map_normal[4 * i]);
    }
    for (float& p : e.positions) p = std::round(p);
    light_all_over(e);
    write_words(e.stage + "/in/position.bin", e.position), write_words(e.stage + "/in/normal.bin", e.normal);
    write_words(e.stage + "/in/positions.bin", e.positions);
    e.row_x = {0.7f, 0, 0, 20.15f}, e.row_y = {0, 0.7f, 0, 20.15f}, e.row_w = {0, 0, 0, 1};  // 20.5, but for roundings
    set_uniform(manifest, "map.to_texel_x", e.row_x), set_uniform(manifest, "map.to_texel_y", e.row_y);
    set_uniform(manifest, "map.to_texel_w", e.row_w);
    manifest.erase(manifest.find("[export]"), manifest.find("[[stage]]") - manifest.find("[export]"));
}

}  // namespace

TEST_CASE("validate: a filter decides nothing at a texel's centre", "[program][vocabulary]") {
    Exported e("vocabulary_centres", "key", true);
    std::string manifest = e.manifest;
    lie_on_centres(e, manifest);
    const Sampler s{true, "edge"};
    // A device may be on this side or that, and blends other texels there, to the same.
    for (const float shift : {0.0f, 4e-6f, -4e-6f}) {
        CAPTURE(shift);
        shade(e, s, {}, shift);
        with_words(e, manifest, s.words());
        const Json stage = e.judged(0, "0");
        CHECK(stage["counts"]["wrong"] == 0);
        CHECK(stage["counts"]["ambiguous"] == 0);
        CHECK(stage["nonzero"]["pixels"] > 1000);
    }
    // A third of a texel aside is more than any filter's fractions grant.
    shade(e, s, {}, 0.3f);
    CHECK(e.judged(1, "0")["counts"]["wrong"] > 1000);
}

TEST_CASE("validate: samplers that keep 8 bits of what they blend", "[program][vocabulary]") {
    Exported e("vocabulary_8_bits", "key", true);
    light_all_over(e);
    std::vector<std::uint8_t> codes;
    for (std::size_t i = 0; i < e.flux.size(); ++i) {
        codes.push_back(std::uint8_t(std::lround(255 * std::min(1.0f, 20 * e.flux[i]))));
        e.flux[i] = float(codes.back()) / 255;
    }
    write_words(e.folder + "/flux8.raw", codes);
    const Sampler s{true, "edge"};
    const std::string manifest = e.manifest;
    const auto judged = [&](const Sampler& flux, float times, int exit) {
        gather(e, [&](int x, int y) { return Point{xyz(e.position, pixel(x, y)), xyz(e.normal, pixel(x, y))}; },
               [&](int, int, std::size_t k, float u, float v) -> std::optional<Sample> {
                   const float x = u + e.positions[2 * k], y = v + e.positions[2 * k + 1];
                   return Sample{s(e.map_position, x, y), s(e.map_normal, x, y), flux(e.flux, x, y) * times, e.weights[k]};
               },
               e.weights.size());
        with_words(e, manifest, s.words());
        e.replace_input("rsm_flux", "file = \"flux8.raw\"\nvk_format = \"R8G8B8A8_UNORM\"\nwidth = 48\nheight = 48\n" + s.words());
        return e.judged(exit, "0.05");
    };
    CHECK(judged(s, 1, 0)["counts"]["wrong"] == 0);
    // Fractions of 8 bits, and each blend cut off to a code: as lavapipe has it.
    CHECK(judged({true, "edge", {}, 8, 1.0f / 255}, 1, 0)["counts"]["wrong"] == 0);
    // Codes of 6 bits no device has; and a tenth more is told.
    CHECK(judged({true, "edge", {}, 8, 1.0f / 63}, 1, 1)["counts"]["wrong"] > 100);
    CHECK(judged({true, "edge", {}, 8, 1.0f / 255}, 1.1f, 1)["counts"]["wrong"] > 100);
}

TEST_CASE("validate: normals made unit once filtered, positions moved along them, samples skipped", "[program][vocabulary]") {
    Exported e("vocabulary_filtered", "key", true);
    light_all_over(e);
    const std::string manifest = e.manifest;
    const Sampler s{true, "edge"};
    const auto with = [&](bool unit, float along, bool skips) {
        e.manifest = manifest;
        const auto input = [&](const std::string& name, const std::string& more) {
            e.replace_input(name, "file = \"" + name + ".bin\"\nvk_format = \"R32G32B32A32_SFLOAT\"\nwidth = 48\nheight = 48\n" +
                                      s.words() + more);
        };
        input("rsm_position", along != 0 ? fmt::format("along_normal = {}\n", along) : "");
        input("rsm_normal", unit ? "normalized = true\n" : "");
        input("rsm_flux", "");
        std::vector<double> rows;
        for (std::size_t k = 0; k < e.weights.size(); ++k)
            for (const float v : {e.positions[2 * k], e.positions[2 * k + 1], e.weights[k]}) rows.push_back(double(v));
        io::write_npy(e.folder + "/pattern.npy", DType::f64, {std::int64_t(e.weights.size()), 3}, rows.data());
        for (const char* input : {"positions", "weights"}) {
            const std::size_t at = e.manifest.find(fmt::format("[stage.input.{}]", input));
            e.manifest.erase(at, e.manifest.find("\n[", at) + 1 - at);
        }
        e.manifest = without(e.manifest, {"samples", "rotations", "reach"});
        e.manifest += std::string("[stage.input.pattern]\nfile = \"pattern.npy\"\n") + (skips ? "beyond = \"skip\"\n" : "");
    };
    const std::vector<Reading> all = {{}, {true}, {false, -0.0625f}, {true, 0.125f}, {false, 0, true}, {true, -0.0625f, true}};
    for (const Reading& shader : all)
        for (const Reading& said : all) {
            CAPTURE(shader.unit, shader.along, shader.skips, said.unit, said.along, said.skips);
            shade(e, s, shader);
            with(said.unit, said.along, said.skips);
            if (&shader == &said)
                CHECK(e.judged(0, "0.05")["counts"]["wrong"] == 0);
            else
                CHECK(e.judged(1, "0.05")["counts"]["wrong"] > 20);
        }
}

TEST_CASE("validate: what a shader forgets to do with what it has filtered is named", "[program][vocabulary]") {
    Exported e("vocabulary_forgotten", "key", true);
    light_all_over(e);
    const std::string manifest = e.manifest;
    const Sampler s{true, "edge"};
    const auto cause = [&](const Reading& shader, const Sampler& read) {
        shade(e, read, shader);
        with_words(e, manifest, s.words());
        e.replace_input("rsm_position", "file = \"rsm_position.bin\"\nvk_format = \"R32G32B32A32_SFLOAT\"\nwidth = 48\nheight = 48\n"
                                        "along_normal = -0.125\n" + s.words());
        e.replace_input("rsm_normal", "file = \"rsm_normal.bin\"\nvk_format = \"R32G32B32A32_SFLOAT\"\nwidth = 48\nheight = 48\n"
                                      "normalized = true\n" + s.words());
        write(e.folder + "/manifest.toml", e.manifest);
        const Result r = run({"validate", e.folder + "/manifest.toml", "--json"});
        REQUIRE(r.exit == 1);
        return Json::parse(r.out)["stages"][0]["diagnosis"]["causes"][0]["with"].get<std::string>();
    };
    CHECK(cause({true, 0}, s) == "rsm_position not moved along its normal");
    CHECK(cause({true, 0.125f}, s) == "rsm_position moved along its normal the other way");
    CHECK(cause({false, -0.125f}, s) == "rsm_normal not made unit once it is filtered");
    CHECK(cause({true, -0.125f}, {false, "edge"}) == "the map read at the nearest texel");
    CHECK(cause({true, -0.125f}, {true, "wrap"}) == "beyond the map the map again");
}

TEST_CASE("validate: where words for what was read do not stand", "[program][vocabulary]") {
    Exported e("vocabulary_filtered_refused");
    const std::string manifest = e.manifest;
    const auto with = [&](const std::string& input, const std::string& lines) {
        const std::string mark = "[stage.input." + input + "]\n";
        e.manifest = replaced(manifest, mark, mark + lines);
        return e.refused();
    };
    CHECK_THAT(with("rsm_normal", "along_normal = 1\n"), Contains("input.rsm_normal: along_normal: expected it of rsm_position"));
    CHECK_THAT(with("rsm_position", "along_normal = 1e30\n"), Contains("along_normal"));
    e.manifest = manifest + "[stage.input.pattern]\nfile = \"pattern.npy\"\nbeyond = \"clamp\"\n";
    CHECK_THAT(e.refused(), Contains("expected read, skip"));
}
