// plumb validate: shaders in the words of real engines. A gather that is written here once more, in float and in another
// order, takes normals of 8 bits, positions in view space, positions out of a depth buffer; each of them is right, and none
// of its pixels may be called wrong.
#include <fmt/format.h>

#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <glm/glm.hpp>
#include <sstream>

#include "core/formats.h"
#include "io/npy.h"
#include "tests/program/exported.h"

using namespace plumb;
using namespace plumb::program;
using Catch::Matchers::Contains;

namespace {

constexpr int width = 61, height = 43, map_side = 48;

template <class T>
std::vector<T> words_of(const std::string& path) {
    const std::string bytes = read(path);
    std::vector<T> values(bytes.size() / sizeof(T));
    std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
    return values;
}
template <class T>
void write_words(const std::string& path, const std::vector<T>& values) {
    write(path, std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)));
}

// The numbers of a uniform of a manifest.
std::vector<float> uniform_of(const std::string& manifest, const std::string& name) {
    std::size_t at = manifest.find("\n\"" + name + "\" = ");
    if (at == std::string::npos) at = manifest.find("\n" + name + " = ");
    if (at == std::string::npos) throw std::runtime_error("no uniform " + name);
    std::string text = manifest.substr(manifest.find('=', at) + 1);
    text = text.substr(0, text.find('\n'));
    for (char& c : text)
        if (c == '[' || c == ']' || c == ',') c = ' ';
    std::istringstream in(text);
    std::vector<float> values;
    for (float v; in >> v;) values.push_back(v);
    return values;
}
// The manifest without the lines of those uniforms.
std::string without(std::string manifest, const Words& names) {
    for (const std::string& name : names) {
        std::size_t at = manifest.find("\n\"" + name + "\" = ");
        if (at == std::string::npos) at = manifest.find("\n" + name + " = ");
        if (at == std::string::npos) throw std::runtime_error("no uniform " + name);
        manifest.erase(at + 1, manifest.find('\n', at + 1) - at);
    }
    return manifest;
}

// An export of rsm.disc with one rotation: what the gather below reads, and the manifest to change.
struct Exported {
    std::string folder, stage, manifest;
    std::vector<float> position, normal, map_position, map_normal, flux, weights;
    std::vector<std::int32_t> offsets;
    std::vector<float> row_x, row_y, row_w;
    float scale = 0, least = 0;

    explicit Exported(const std::string& name, const std::string& light = "key") : folder(fresh_folder(name)) {
        const Result r = run({"export", small_scene(folder), "--stage", "rsm.disc", "--light", light, "--set",
                              "rsm.rotations=1", "-o", folder});
        if (r.exit != 0) throw std::runtime_error(r.err);
        stage = folder + "/rsm.disc." + light;
        manifest = read(folder + "/manifest.toml");
        position = words_of<float>(stage + "/in/position.bin"), normal = words_of<float>(stage + "/in/normal.bin");
        map_position = words_of<float>(stage + "/in/rsm_position.bin");
        map_normal = words_of<float>(stage + "/in/rsm_normal.bin"), flux = words_of<float>(stage + "/in/rsm_flux.bin");
        offsets = words_of<std::int32_t>(stage + "/in/offsets.bin"), weights = words_of<float>(stage + "/in/weights.bin");
        row_x = uniform("map.to_texel_x"), row_y = uniform("map.to_texel_y"), row_w = uniform("map.to_texel_w");
        scale = uniform("scale").at(0), least = uniform("least_distance2").at(0);
    }

    std::vector<float> uniform(const std::string& name) const { return uniform_of(manifest, name); }

    // The manifest with that in place of an input's table.
    void replace_input(const std::string& input, const std::string& lines) {
        const std::size_t at = manifest.find("[stage.input." + input + "]"), end = manifest.find("\n[", at);
        if (at == std::string::npos) throw std::runtime_error("no input " + input);
        manifest = manifest.substr(0, at) + "[stage.input." + input + "]\n" + lines + manifest.substr(end + 1);
    }
    // [export] would call changed inputs stale; files of one's own are none of the export's.
    Json judged(int exit) const {
        write(folder + "/manifest.toml", manifest);
        const Result r = run({"validate", folder + "/manifest.toml", "--json"});
        INFO(r.out << r.err);
        REQUIRE(r.exit == exit);
        return Json::parse(r.out)["stages"][0];
    }
    std::string refused() const {
        write(folder + "/manifest.toml", manifest);
        const Result r = run({"validate", folder + "/manifest.toml"});
        INFO(r.out << r.err);
        CHECK(r.exit == 2);
        CHECK(r.out.empty());
        CHECK(std::count(r.err.begin(), r.err.end(), '\n') == 1);
        return r.err;
    }
};

struct Point {
    glm::vec3 x, n;
};
using PointOf = std::function<Point(int px, int py)>;
glm::vec3 xyz(const std::vector<float>& texels, std::size_t i) {
    return {texels[4 * i], texels[4 * i + 1], texels[4 * i + 2]};
}

// VRSM (3.2) as a shader has it that nobody here wrote: unit directions in place of d / d^4, samples last to first.
void gather(const Exported& e, const PointOf& point_of) {
    std::vector<float> out(4 * std::size_t(width) * height, 0.0f);
    for (int py = 0; py < height; ++py)
        for (int px = 0; px < width; ++px) {
            const Point p = point_of(px, py);
            const auto row = [&](const std::vector<float>& r) { return r[3] + glm::dot(glm::vec3(r[0], r[1], r[2]), p.x); };
            const float w = 1.0f / std::max(row(e.row_w), 1e-6f);
            const int cx = int(std::floor(std::clamp(row(e.row_x) * w, -1e6f, 1e6f)));
            const int cy = int(std::floor(std::clamp(row(e.row_y) * w, -1e6f, 1e6f)));
            glm::vec3 sum(0);
            for (int k = int(e.weights.size()); k-- > 0;) {
                const int x = cx + std::int16_t(e.offsets[std::size_t(k)] & 0xffff), y = cy + (e.offsets[std::size_t(k)] >> 16);
                if (x < 0 || y < 0 || x >= map_side || y >= map_side) continue;
                const std::size_t texel = std::size_t(y) * map_side + std::size_t(x);
                const glm::vec3 d = xyz(e.map_position, texel) - p.x;
                const float d2 = std::max(glm::dot(d, d), e.least), length = std::sqrt(d2);
                const float cos_x = std::max(0.0f, glm::dot(p.n, d) / length);
                const float cos_p = std::max(0.0f, -glm::dot(xyz(e.map_normal, texel), d) / length);
                sum += xyz(e.flux, texel) * (e.scale * cos_x * cos_p * e.weights[std::size_t(k)] / d2);
            }
            for (int c = 0; c < 3; ++c) out[4 * (std::size_t(py) * width + std::size_t(px)) + std::size_t(c)] = sum[c];
        }
    write_words(e.stage + "/out/irradiance.bin", out);
}
std::size_t pixel(int x, int y) { return std::size_t(y) * width + std::size_t(x); }

std::string list(const glm::dmat4& m, bool by_rows) {
    std::string text;
    for (int i = 0; i < 16; ++i) {
        const double v = by_rows ? m[i % 4][i / 4] : m[i / 4][i % 4];
        text += (text.empty() ? "[" : ", ") + fmt::format("{}", double(float(v)));
    }
    return text + "]";
}
glm::vec3 times(const glm::mat4& m, const glm::vec3& v, float w) { return glm::vec3(m * glm::vec4(v, w)); }

// A view that stands anywhere: turned about two axes, then moved.
glm::dmat4 world_to_view() {
    const double a = 0.7, b = -0.3;
    const glm::dmat4 yaw(std::cos(a), 0, -std::sin(a), 0, 0, 1, 0, 0, std::sin(a), 0, std::cos(a), 0, 0, 0, 0, 1);
    const glm::dmat4 pitch(1, 0, 0, 0, 0, std::cos(b), std::sin(b), 0, 0, -std::sin(b), std::cos(b), 0, 0, 0, 0, 1);
    glm::dmat4 move(1);
    move[3] = glm::dvec4(-0.4, -0.9, -3.9, 1);
    return pitch * yaw * move;
}
glm::mat4 rounded(const glm::dmat4& m) { return glm::mat4(m); }

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

namespace {

// The four habits of clip space.
struct Clip {
    bool below_zero, reversed, y_up, left_handed;
};
glm::dmat4 projection(const Clip& clip, double near, double far) {
    // Of a viewer that looks along -z; along +z where it is left-handed.
    const double f = 2.8, a = double(width) / height, toward = clip.left_handed ? 1 : -1;
    const double low = clip.below_zero ? -1 : 0, at_near = clip.reversed ? 1 : low, at_far = clip.reversed ? low : 1;
    // z_clip = p d + q with p + q / n = z at the near plane, p + q / f = z at the far one; d is the distance.
    const double q = (at_near - at_far) / (1 / near - 1 / far), p = at_near - q / near;
    glm::dmat4 m(0);
    m[0][0] = f / a, m[1][1] = clip.y_up ? f : -f, m[2][2] = toward * p, m[3][2] = q, m[2][3] = toward;
    return m;
}

}  // namespace

TEST_CASE("validate: positions out of a depth buffer", "[program][vocabulary]") {
    for (const Clip& clip : {Clip{false, false, false, false}, Clip{true, false, true, false}, Clip{false, true, false, true},
                             Clip{false, true, true, false}}) {
        CAPTURE(clip.below_zero, clip.reversed, clip.y_up, clip.left_handed);
        Exported e("vocabulary_depth");
        // Seen from where the scene's camera stands, with its angle: positions are about those of the scene.
        glm::dmat4 view(1);
        view[3] = glm::dvec4(0, -0.995, -3.934, 1);
        if (clip.left_handed)
            for (int c = 0; c < 4; ++c) view[c][2] = -view[c][2];
        const glm::dmat4 clip_of = projection(clip, 0.1, 50) * view, to_world = glm::inverse(clip_of);
        const glm::mat4 m = rounded(to_world);
        std::vector<float> depth;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                // Nothing is there where nothing was drawn.
                const double d = 3.934 - double(e.position[4 * pixel(x, y) + 2]);
                const glm::dmat4 p = projection(clip, 0.1, 50);
                const double z = p[2][2] * p[2][3] + p[3][2] / d;
                const bool seen = e.normal[4 * pixel(x, y) + 3] > 0;
                depth.push_back(!seen ? (clip.reversed ? 0.0f : 1.0f) : float(clip.below_zero ? 0.5 * z + 0.5 : z));
            }
        depth[pixel(30, 20)] = clip.reversed ? 0.0f : 1.0f;  // nothing there
        write_words(e.folder + "/depth.raw", depth);
        gather(e, [&](int x, int y) {
            const float d = depth[pixel(x, y)];
            if (d == (clip.reversed ? 0.0f : 1.0f)) return Point{glm::vec3(0), xyz(e.normal, pixel(x, y))};
            const glm::vec2 uv((float(x) + 0.5f) * (1.0f / width), (float(y) + 0.5f) * (1.0f / height));
            const float down = uv.y * 2.0f - 1.0f;
            const glm::vec4 h = m * glm::vec4(uv.x * 2.0f - 1.0f, clip.y_up ? -down : down,
                                              clip.below_zero ? 2.0f * d - 1.0f : d, 1.0f);
            return Point{glm::vec3(h) / h.w, xyz(e.normal, pixel(x, y))};
        });
        const std::string manifest = e.manifest;
        auto with = [&](const glm::dmat4& matrix, const std::string& more) {
            e.manifest = manifest;
            e.replace_input("position", "file = \"depth.raw\"\nvk_format = \"D32_SFLOAT\"\n[stage.input.position.from_depth]\n"
                                        "inverse_view_proj = { columns = " + list(matrix, false) + " }\n" + more);
        };
        const std::string right = std::string(clip.below_zero ? "clip_depth = [-1, 1]\n" : "") +
                                  (clip.reversed ? "reversed_z = true\n" : "") + (clip.y_up ? "y = \"up\"\n" : "");
        with(to_world, right);
        const Json stage = e.judged(0);
        CHECK(stage["counts"]["wrong"] == 0);
        CHECK(stage["counts"]["equal"].get<int>() + stage["counts"]["within_bound"].get<int>() > 2600);
        // Each habit mistaken is told.
        with(to_world, clip.below_zero ? replaced(right, "clip_depth = [-1, 1]\n", "") : right + "clip_depth = [-1, 1]\n");
        CHECK(e.judged(1)["wrong"] > 0.1);
        with(to_world, clip.y_up ? replaced(right, "y = \"up\"\n", "") : right + "y = \"up\"\n");
        CHECK(e.judged(1)["wrong"] > 0.1);
        with(clip_of, right);
        CHECK(e.judged(1)["wrong"] > 0.1);
    }
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

namespace {

using Row = std::array<double, 4>;
std::string rows_of(const std::vector<Row>& rows) {
    std::string text;
    for (const Row& row : rows)
        for (const double v : row) text += (text.empty() ? "rows = [" : ", ") + fmt::format("{}", v);
    return text + "]\n";
}
// The row of clip space that a row in texels came from.
Row clip_row(const std::vector<float>& texels, const std::vector<float>& w, int side, bool negated = false) {
    Row row;
    for (std::size_t c = 0; c < 4; ++c) row[c] = (2.0 * double(texels[c]) / side - double(w[c])) * (negated ? -1 : 1);
    return row;
}

}  // namespace

TEST_CASE("validate: a light's matrix instead of rows in texels, and what is harmless", "[program][vocabulary]") {
    Exported e("vocabulary_matrix");
    write_expected(e.folder);
    const Words rows = {"map.to_texel_x", "map.to_texel_y", "map.to_texel_w", "map.size"};
    const Words harmless = {"map.least_w", "map.low", "map.high", "seed", "least_distance2"};
    const Row w{double(e.row_w[0]), double(e.row_w[1]), double(e.row_w[2]), double(e.row_w[3])};
    // Any z will do where rays meet in the eye.
    const Row z{0.5 * w[0], 0.5 * w[1], 0.5 * w[2], 0.5 * w[3] - 0.01};
    const std::string bare = without(without(e.manifest, rows), harmless);
    auto with = [&](const std::string& lines) {
        const std::size_t at = bare.find("[stage.input.");
        e.manifest = bare.substr(0, at) + lines + bare.substr(at);
    };
    for (const bool up : {false, true}) {
        with("[stage.light_view_proj]\n" +
             rows_of({clip_row(e.row_x, e.row_w, map_side), clip_row(e.row_y, e.row_w, map_side, up), z, w}) +
             (up ? "y = \"up\"\nclip_depth = [-1, 1]\n" : ""));
        const Json stage = e.judged(0);
        CHECK(stage["counts"]["wrong"] == 0);
        CHECK_THAT(stage["notes"].at(0), Contains("taken as harmless: ") && Contains("map.least_w = 1e-06") &&
                                             Contains("map.low = -1048576") && Contains("least_distance2 = 1e-37") &&
                                             Contains("seed = 0"));
    }
    with("[stage.light_view_proj]\n" +
         rows_of({clip_row(e.row_x, e.row_w, map_side), clip_row(e.row_y, e.row_w, map_side), z, w}) + "y = \"up\"\n");
    CHECK(e.judged(1)["wrong"] > 0.1);
    // Nothing gives the rows, or both do; a matrix that is none; a view that the block has not.
    e.manifest = bare;
    CHECK_THAT(e.refused(), Contains("missing: map.to_texel_x, map.to_texel_y, map.to_texel_w, map.size;"));
    const std::string matrix = rows_of({clip_row(e.row_x, e.row_w, map_side), clip_row(e.row_y, e.row_w, map_side), z, w});
    with("\"map.to_texel_w\" = [0, 0, 0, 1]\n[stage.light_view_proj]\n" + matrix);
    CHECK_THAT(e.refused(), Contains("gives map.to_texel_w, which [stage.uniforms] gives, too"));
    with("[stage.light_view_proj]\n" + rows_of({z, z, z, w}));
    CHECK_THAT(e.refused(), Contains("is no view"));
    with("[stage.view_proj.view]\n" + matrix);
    CHECK_THAT(e.refused(), Contains("has no view \"view\""));
    with("[stage.light_view_proj]\n" + matrix + "[stage.view_proj.map]\n" + matrix);
    CHECK_THAT(e.refused(), Contains("is given twice"));
    with("[stage.light_view_proj]\nrows = [1]\n");
    CHECK_THAT(e.refused(), Contains("light_view_proj of stage 1 (rsm.disc): rows") && Contains("expected 16 numbers, 1 given"));
    // Where pixels have rotations, the seed matters.
    with("[stage.light_view_proj]\n" + matrix);
    e.manifest = replaced(e.manifest, "rotations = 1\n", "rotations = 2\n");
    CHECK_THAT(e.refused(), Contains("missing: seed;"));
}

TEST_CASE("validate: shadow tests by a light's matrix", "[program][vocabulary]") {
    for (const std::string light : {"key", "sun"}) {
        INFO(light);
        const std::string folder = fresh_folder("vocabulary_shadow");
        REQUIRE(run({"export", small_scene(folder), "--stage", "shadow", "--light", light, "-o", folder}).exit == 0);
        write_expected(folder);
        const std::string manifest = read(folder + "/manifest.toml");
        const int side = int(uniform_of(manifest, "map.size").at(0));
        const auto x = uniform_of(manifest, "map.to_texel_x"), y = uniform_of(manifest, "map.to_texel_y");
        const auto w = uniform_of(manifest, "map.to_texel_w"), eye = uniform_of(manifest, "eye");
        const auto forward = uniform_of(manifest, "forward");
        const std::string bare = without(manifest, {"map.to_texel_x", "map.to_texel_y", "map.to_texel_w", "map.size", "eye",
                                                    "forward", "perspective", "footprint_scale", "footprint_base"});
        for (const int habit : {0, 1, 2}) {
            CAPTURE(habit);
            // Depth over 9 m: 0 to 1, 1 to 0, -1 to 1.
            const double scale = habit == 0 ? 1 / 9.0 : habit == 1 ? -1 / 9.0 : 2 / 9.0, at_eye = habit == 2 ? -1 : habit;
            Row z{scale * double(forward[0]), scale * double(forward[1]), scale * double(forward[2]), at_eye};
            for (std::size_t c = 0; c < 3; ++c) z[3] -= z[c] * double(eye[c]);
            const Row row_w{double(w[0]), double(w[1]), double(w[2]), double(w[3])};
            const std::size_t at = bare.find("[stage.input.");
            const std::string lines = "[stage.light_view_proj]\n" +
                                      rows_of({clip_row(x, w, side), clip_row(y, w, side, habit == 2), z, row_w});
            auto counts = [&](const std::string& more, int exit) {
                write(folder + "/manifest.toml", bare.substr(0, at) + lines + more + bare.substr(at));
                const Result r = run({"validate", folder + "/manifest.toml", "--json"});
                INFO(r.out << r.err);
                REQUIRE(r.exit == exit);
                return Json::parse(r.out)["stages"][0];
            };
            const std::string right = habit == 1 ? "reversed_z = true\n" : habit == 2 ? "clip_depth = [-1, 1]\ny = \"up\"\n" : "";
            const Json stage = counts(right, 0);
            CHECK(stage["counts"]["wrong"] == 0);
            CHECK(stage["counts"]["equal"] == width * height);
            if (habit == 2) CHECK(counts("clip_depth = [-1, 1]\n", 1)["wrong"] > 0.01);
            // Of parallel rays the depth has to grow away from the light.
            if (habit == 1 && light == "sun") CHECK(counts("", 1)["wrong"] > 0.01);
        }
    }
}

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
