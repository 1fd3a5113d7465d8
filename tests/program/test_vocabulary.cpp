// plumb validate: inputs in the words of real engines.
#include "tests/program/vocabulary.h"

using namespace plumb;
using namespace plumb::program;
using Catch::Matchers::Contains;

namespace {

// A view that stands anywhere: turned about two axes, then moved.
glm::dmat4 world_to_view() {
    const double a = 0.7, b = -0.3;
    const glm::dmat4 yaw(std::cos(a), 0, -std::sin(a), 0, 0, 1, 0, 0, std::sin(a), 0, std::cos(a), 0, 0, 0, 0, 1);
    const glm::dmat4 pitch(1, 0, 0, 0, 0, std::cos(b), std::sin(b), 0, 0, -std::sin(b), std::cos(b), 0, 0, 0, 0, 1);
    glm::dmat4 move(1);
    move[3] = glm::dvec4(-0.4, -0.9, -3.9, 1);
    return pitch * yaw * move;
}

}  // namespace

TEST_CASE("validate: normals of 8 bits, renormalised by the shader or not", "[program][vocabulary]") {
    Exported e("vocabulary_normals");
    std::vector<std::uint8_t> codes;
    for (std::size_t i = 0; i < std::size_t(width * height); ++i)
        for (int c = 0; c < 3; ++c)
            codes.push_back(std::uint8_t(std::lround(255.0 * (0.5 * double(e.normal[4 * i + std::size_t(c)]) + 0.5))));
    write_words(e.folder + "/normals.raw", codes);
    const std::string eight = "file = \"normals.raw\"\nvk_format = \"R8G8B8_UNORM\"\nencoding = \"biased\"\n";
    auto decoded = [&](int x, int y) {
        glm::vec3 n;
        for (int c = 0; c < 3; ++c) n[c] = float(codes[3 * pixel(x, y) + std::size_t(c)]) * (1.0f / 255.0f) * 2.0f - 1.0f;
        return n;
    };
    auto unit = [&](int x, int y) {
        const glm::vec3 n = decoded(x, y);
        return n * (1.0f / std::sqrt(glm::dot(n, n)));
    };
    const std::string manifest = e.manifest;
    auto shade = [&](auto normal_of, const std::string& lines) {
        gather(e, [&](int x, int y) { return Point{xyz(e.position, pixel(x, y)), normal_of(x, y)}; });
        e.manifest = manifest;
        e.replace_input("normal", eight + lines);
    };
    shade(unit, "normalized = true\n");
    CHECK(e.judged(0)["counts"]["wrong"] == 0);
    shade(decoded, "");
    CHECK(e.judged(0)["counts"]["wrong"] == 0);
    // One said to be the other is told.
    shade(unit, "");
    CHECK(e.judged(1)["wrong"] > 0.1);
    shade(decoded, "normalized = true\n");
    CHECK(e.judged(1)["wrong"] > 0.1);
    // A bug of a thousandth is not hidden by the bound.
    shade([&](int x, int y) { return unit(x, y) * 1.001f; }, "normalized = true\n");
    CHECK(e.judged(1)["wrong"] > 0.5);
}

TEST_CASE("validate: normals that are longer than their format allows are noted", "[program][vocabulary]") {
    Exported e("vocabulary_lengths");
    gather(e, [&](int x, int y) { return Point{xyz(e.position, pixel(x, y)), xyz(e.normal, pixel(x, y))}; });
    CHECK(e.judged(0)["notes"].empty());
    std::vector<float> normals = e.normal;
    std::size_t seen = 0;
    for (std::size_t i = 0; i < normals.size() / 4; ++i) {
        seen += normals[4 * i + 3] > 0;
        for (std::size_t c = 0; c < 3; ++c) normals[4 * i + c] *= 0.75f;
    }
    write_words(e.folder + "/short.bin", normals);
    const std::string lines = "file = \"short.bin\"\nvk_format = \"R32G32B32A32_SFLOAT\"\n";
    e.replace_input("normal", lines);
    const std::string note = fmt::format("normal: at {} of 2623 texels the length differs from 1 by more than the format "
                                         "allows: 0.75 to 0.75", seen);
    CHECK(e.judged(1)["notes"] == Json({note + "; normalized = true where the shader makes it unit"}));
    e.replace_input("normal", lines + "normalized = true\n");
    CHECK(e.judged(0)["notes"] == Json({note}));
}

TEST_CASE("validate: positions and normals in view space", "[program][vocabulary]") {
    Exported e("vocabulary_view");
    const glm::dmat4 to_view = world_to_view(), to_world = glm::inverse(to_view);
    std::vector<float> positions, normals;
    for (std::size_t i = 0; i < std::size_t(width * height); ++i) {
        const glm::dvec4 x = to_view * glm::dvec4(glm::dvec3(xyz(e.position, i)), 1);
        const glm::dvec4 n = to_view * glm::dvec4(glm::dvec3(xyz(e.normal, i)), 0);
        for (int c = 0; c < 3; ++c) positions.push_back(float(x[c])), normals.push_back(float(n[c]));
    }
    write_words(e.folder + "/x.raw", positions), write_words(e.folder + "/n.raw", normals);
    const glm::mat4 m = rounded(to_world);
    auto three = [](const std::vector<float>& v, std::size_t i) { return glm::vec3(v[3 * i], v[3 * i + 1], v[3 * i + 2]); };
    gather(e, [&](int x, int y) {
        return Point{times(m, three(positions, pixel(x, y)), 1), times(m, three(normals, pixel(x, y)), 0)};
    });
    const std::string manifest = e.manifest, format = "vk_format = \"R32G32B32_SFLOAT\"\n";
    auto with = [&](const glm::dmat4& matrix, const std::string& order) {
        const std::string line = "matrix = { " + order + " = " + list(matrix, order == "rows") + " }\n";
        e.manifest = manifest;
        e.replace_input("position", "file = \"x.raw\"\n" + format + line);
        e.replace_input("normal", "file = \"n.raw\"\n" + format + line);
    };
    for (const char* order : {"rows", "columns"}) {
        INFO(order);
        with(to_world, order);
        CHECK(e.judged(0)["counts"]["wrong"] == 0);
    }
    // Transposed it is no such matrix; the wrong way around it is another.
    with(glm::transpose(to_world), "rows");
    CHECK_THAT(e.refused(), Contains("input.normal") && Contains("last row is 0 0 0 1"));
    with(to_view, "rows");
    CHECK(e.judged(1)["wrong"] > 0.1);

    // A space that is scaled: normals take the inverse transpose and keep their length, points the matrix.
    const glm::dmat4 twice = to_world * glm::dmat4(glm::dvec4(2, 0, 0, 0), glm::dvec4(0, 2, 0, 0), glm::dvec4(0, 0, 2, 0),
                                                   glm::dvec4(0, 0, 0, 1));
    for (float& v : positions) v *= 0.5f;
    write_words(e.folder + "/x.raw", positions);
    with(twice, "columns");
    CHECK(e.judged(0)["counts"]["wrong"] == 0);

    e.manifest = manifest;
    e.replace_input("normal", "file = \"n.raw\"\n" + format + "matrix = { rows = [1,0,0,0, 0,1,0,0, 0,0,0,0, 0,0,0,1] }\n");
    CHECK_THAT(e.refused(), Contains("input.normal") && Contains("has an inverse"));
    e.manifest = manifest;
    e.replace_input("weights", "file = \"x.raw\"\nvk_format = \"R32_SFLOAT\"\nwidth = 37\nheight = 1\ntrailing = true\nnormalized = true\n");
    CHECK_THAT(e.refused(), Contains("input.weights") && Contains("of images of floats"));
    e.manifest = manifest;
    e.replace_input("position", "file = \"x.raw\"\n" + format + "normalized = true\n");
    CHECK_THAT(e.refused(), Contains("input.position") && Contains("of normals alone"));
}
TEST_CASE("validate: flux as attenuation times albedo", "[program][vocabulary]") {
    Exported e("vocabulary_factor");
    std::vector<float> attenuation;
    std::vector<std::uint8_t> albedo;
    for (std::size_t i = 0; i < e.flux.size() / 4; ++i) {
        attenuation.push_back(0.25f + 0.5f * float(i % 7));
        for (int c = 0; c < 4; ++c) albedo.push_back(std::uint8_t((37 * i + 90 * std::size_t(c)) % 256));
        for (int c = 0; c < 3; ++c)
            e.flux[4 * i + std::size_t(c)] = (float(albedo[4 * i + std::size_t(c)]) / 255.0f) * attenuation[i] * 0.001f;
    }
    write_words(e.folder + "/attenuation.raw", attenuation), write_words(e.folder + "/albedo.raw", albedo);
    gather(e, [&](int x, int y) { return Point{xyz(e.position, pixel(x, y)), xyz(e.normal, pixel(x, y))}; });
    const std::string manifest = e.manifest, sides = "width = 48\nheight = 48\n";
    const std::string image = "file = \"attenuation.raw\"\nvk_format = \"R32_SFLOAT\"\n" + sides;
    auto with = [&](const std::string& lines) { e.manifest = manifest, e.replace_input("rsm_flux", lines); };
    const std::string of_albedo = "{ file = \"albedo.raw\", vk_format = \"R8G8B8A8_UNORM\" }";
    const std::string of_attenuation = "{ file = \"attenuation.raw\", vk_format = \"R32_SFLOAT\" }";
    const std::string base = "file = \"albedo.raw\"\nvk_format = \"R8G8B8A8_UNORM\"\n" + sides;
    // An image of one channel multiplies all three.
    with(base + "factor = " + of_attenuation + "\nscale = 0.001\n");
    CHECK(e.judged(0)["counts"]["wrong"] == 0);
    with(base + "factor = [" + of_attenuation + ", " + of_attenuation + "]\nscale = [0.001, 0.001, 0.001]\n");
    CHECK(e.judged(1)["wrong"] > 0.1);
    with(base + "factor = " + of_attenuation + "\n");
    CHECK(e.judged(1)["wrong"] > 0.1);
    with(base + "factor = " + of_albedo + "\nscale = 0.001\n");
    CHECK(e.judged(1)["wrong"] > 0.1);
    // The other way around the first has too few channels for a flux.
    with(image + "channels = \"xxx\"\nfactor = " + of_albedo + "\nscale = 0.001\n");
    CHECK(e.judged(0)["counts"]["wrong"] == 0);
    with(base + "factor = \"none.png\"\n");
    CHECK_THAT(e.refused(), Contains("none.png"));
    with(base + "factor = { file = \"albedo.raw\", vk_format = \"R8G8B8A8_UNORM\", width = 24, height = 96 }\n");
    CHECK_THAT(e.refused(), Contains("albedo.raw") && Contains("expected an image of 48 x 48 floats"));
}

TEST_CASE("validate: a fourth component out of another file", "[program][vocabulary]") {
    // Depth and coverage of their own, as most engines have them.
    const std::string folder = fresh_folder("vocabulary_w"), scene = small_scene(folder);
    REQUIRE(run({"export", scene, "--stage", "shadow", "--light", "key", "-o", folder}).exit == 0);
    write_expected(folder);
    const std::string stage = folder + "/shadow.key", manifest = read(folder + "/manifest.toml");
    const auto map = words_of<float>(stage + "/in/map_position.bin");
    constexpr double far = 8;
    std::vector<float> codes;
    for (std::size_t i = 0; i < map.size() / 4; ++i) codes.push_back(float(double(map[4 * i + 3]) / far));
    write_words(folder + "/codes.raw", codes);
    auto counts = [&](const std::string& lines, int exit) {
        const std::size_t at = manifest.find("[stage.input.map_position]"), end = manifest.find("\n[", at);
        write(folder + "/manifest.toml", manifest.substr(0, at) + "[stage.input.map_position]\n" + lines + manifest.substr(end + 1));
        const Result r = run({"validate", folder + "/manifest.toml", "--json"});
        INFO(r.out << r.err);
        REQUIRE(r.exit == exit);
        return r.exit == 2 ? Json(r.err) : Json::parse(r.out)["stages"][0]["counts"]["wrong"];
    };
    const std::string sides = "width = 48\nheight = 48\n";
    const std::string linear = "encoding = \"linear_depth\"\nnear_far = [0, 8]\n";
    const std::string alone = "file = \"codes.raw\"\nvk_format = \"R32_SFLOAT\"\n" + sides;
    CHECK(counts(alone + "channels = \"000x\"\n" + linear, 0) == 0);
    CHECK(counts(alone + "channels = \"000x\"\nencoding = \"linear_depth\"\nnear_far = [0, 7]\n", 1) > 50);
    const std::string beside = "file = \"shadow.key/in/map_position.bin\"\nvk_format = \"R32G32B32A32_SFLOAT\"\n" + sides + "channels = \"xyz\"\n";
    CHECK(counts(beside + "[stage.input.map_position.w]\nfile = \"codes.raw\"\nvk_format = \"R32_SFLOAT\"\n" + linear, 0) == 0);
    CHECK(counts(beside + "[stage.input.map_position.w]\nfile = \"codes.raw\"\nvk_format = \"R32_SFLOAT\"\n", 1) > 50);
    CHECK_THAT(counts(beside + "[stage.input.map_position.w]\nfile = \"shadow.key/in/map_position.bin\"\nvk_format = "
                               "\"R32G32B32A32_SFLOAT\"\n", 2).get<std::string>(),
               Contains("has more than one channel"));
    CHECK_THAT(counts(beside + "[stage.input.map_position.w]\nfile = \"codes.raw\"\nvk_format = \"R32_SFLOAT\"\nwidth = 24\n"
                               "height = 96\n", 2).get<std::string>(),
               Contains("w: ") && Contains("expected an image of 48 x 48 floats"));
}

TEST_CASE("validate: an input that may be missing", "[program][vocabulary]") {
    const std::string folder = fresh_folder("vocabulary_optional"), scene = small_scene(folder);
    write(scene, read(scene) + "[ao]\nmethod = \"ssao\"\n");
    REQUIRE(run({"export", scene, "--stage", "screen.ssao", "-o", folder}).exit == 0);
    write_expected(folder);
    std::string manifest = read(folder + "/manifest.toml");
    const std::size_t at = manifest.find("[stage.input.before]");
    REQUIRE(at != std::string::npos);
    manifest.erase(at, manifest.find("\n[", at) + 1 - at);
    write(folder + "/manifest.toml", manifest);
    const Result r = run({"validate", folder + "/manifest.toml", "--json"});
    INFO(r.out << r.err);
    CHECK(r.exit == 0);
    const Json stage = Json::parse(r.out)["stages"][0];
    CHECK(stage["counts"]["equal"] == stage["pixels"]);
    CHECK(stage["notes"] == Json({"before: was not dumped; it is 0 everywhere"}));
}

TEST_CASE("validate: colours that the shader decodes from sRGB, and what that may err by", "[program][vocabulary]") {
    const std::string folder = fresh_folder("vocabulary_srgb"), scene = small_scene(folder);
    REQUIRE(run({"export", scene, "--stage", "compose", "-o", folder}).exit == 0);
    const std::string manifest = read(folder + "/manifest.toml"), in = folder + "/compose/in/";
    auto image = [&](const std::string& name) { return words_of<float>(in + name + ".bin"); };
    const auto normal = image("normal"), direct = image("direct"), emission = image("emission");
    const auto indirect = image("indirect");
    std::vector<std::uint8_t> codes;
    for (std::size_t i = 0; i < normal.size(); ++i) codes.push_back(std::uint8_t((i * 37 + i / 4) % 256));
    write_words(folder + "/albedo.raw", codes);
    const std::size_t at = manifest.find("[stage.input.albedo]"), end = manifest.find("\n[", at);
    const std::string format = "[stage.input.albedo]\nfile = \"albedo.raw\"\nvk_format = \"R8G8B8A8_UNORM\"\n";
    // ISO C's pow in float, off by a share of `off`.
    auto wrong = [&](double off, const std::string& encoding) {
        std::vector<float> out(normal.size(), 0.0f);
        for (std::size_t i = 0; i < normal.size() / 4; ++i)
            for (std::size_t c = 0; c < 3 && normal[4 * i + 3] > 0; ++c) {
                const float code = float(codes[4 * i + c]) * (1.0f / 255.0f);
                float albedo = code <= 0.04045f ? code / 12.92f : std::pow((code + 0.055f) / 1.055f, 2.4f);
                albedo *= float(1 + off);
                const std::size_t k = 4 * i + c;
                out[k] = emission[k] * 0.318309886f + albedo * ((direct[k] + indirect[k]) * 0.318309886f);
            }
        write_words(folder + "/compose/out/radiance.bin", out);
        write(folder + "/manifest.toml", manifest.substr(0, at) + format + encoding + manifest.substr(end + 1) +
                                             "channels = \"xyz\"\n[stage.coverage]\nfile = \"compose/in/normal.bin\"\nvk_format = "
                                             "\"R32G32B32A32_SFLOAT\"\nchannels = \"w\"\n");
        const Result r = run({"validate", folder + "/manifest.toml", "--json", "--no-diagnosis"});
        INFO(r.out << r.err);
        REQUIRE(r.exit < 2);
        return Json::parse(r.out)["stages"][0]["wrong"].get<double>();
    };
    CHECK(wrong(0, "encoding = \"srgb\"\n") == 0);
    // A few units in the last place are a device's right, a hundred are not; nor is another curve.
    CHECK(wrong(4e-7, "encoding = \"srgb\"\n") == 0);
    CHECK(wrong(1e-5, "encoding = \"srgb\"\n") > 0.3);
    CHECK(wrong(0, "") > 0.5);
}
