// A gather that is written here once more, in float and in another order, with inputs as real engines have them: right
// shaders, for tests of a manifest's words. None of their pixels may be called wrong.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <glm/glm.hpp>
#include <optional>
#include <sstream>

#include "core/formats.h"
#include "tests/program/exported.h"

namespace plumb::program {

inline constexpr int width = 61, height = 43, map_side = 48;

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
inline std::vector<float> uniform_of(const std::string& manifest, const std::string& name) {
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
inline std::string without(std::string manifest, const Words& names) {
    for (const std::string& name : names) {
        std::size_t at = manifest.find("\n\"" + name + "\" = ");
        if (at == std::string::npos) at = manifest.find("\n" + name + " = ");
        if (at == std::string::npos) throw std::runtime_error("no uniform " + name);
        manifest.erase(at + 1, manifest.find('\n', at + 1) - at);
    }
    return manifest;
}

// An export of rsm.disc, or of rsm.disc_continuous, with one rotation: what the gather below reads, and the manifest to
// change.
struct Exported {
    std::string folder, stage, manifest;
    std::vector<float> position, normal, map_position, map_normal, flux, weights, positions;
    std::vector<std::int32_t> offsets;
    std::vector<float> row_x, row_y, row_w;
    float scale = 0, least = 0;

    explicit Exported(const std::string& name, const std::string& light = "key", bool continuous = false)
        : folder(fresh_folder(name)) {
        const std::string of = continuous ? "rsm.disc_continuous" : "rsm.disc";
        Words words = {"export", small_scene(folder), "--stage", of, "--light", light, "--set", "rsm.rotations=1", "-o", folder};
        if (continuous) words.insert(words.end(), {"--set", "rsm.texels=continuous"});
        const Result r = run(words);
        if (r.exit != 0) throw std::runtime_error(r.err);
        stage = folder + "/" + of + "." + light;
        manifest = read(folder + "/manifest.toml");
        position = words_of<float>(stage + "/in/position.bin"), normal = words_of<float>(stage + "/in/normal.bin");
        map_position = words_of<float>(stage + "/in/rsm_position.bin");
        map_normal = words_of<float>(stage + "/in/rsm_normal.bin"), flux = words_of<float>(stage + "/in/rsm_flux.bin");
        weights = words_of<float>(stage + "/in/weights.bin");
        if (continuous)
            positions = words_of<float>(stage + "/in/positions.bin");
        else
            offsets = words_of<std::int32_t>(stage + "/in/offsets.bin");
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
    Json judged(int exit, const std::string& most_ambiguous = "0.005") const {
        write(folder + "/manifest.toml", manifest);
        const Result r = run({"validate", folder + "/manifest.toml", "--json", "--no-diagnosis", "--max-ambiguous", most_ambiguous});
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
inline glm::vec3 xyz(const std::vector<float>& texels, std::size_t i) {
    return {texels[4 * i], texels[4 * i + 1], texels[4 * i + 2]};
}

// What a sample of the map brings, the projection of the point at (u, v) texels; nothing where there is none.
struct Sample {
    glm::vec3 x, n, flux;
    float weight;
};
using SampleOf = std::function<std::optional<Sample>(int px, int py, std::size_t k, float u, float v)>;

inline SampleOf whole_texels(const Exported& e) {
    return [&e](int, int, std::size_t k, float u, float v) -> std::optional<Sample> {
        const int x = int(std::floor(u)) + std::int16_t(e.offsets[k] & 0xffff), y = int(std::floor(v)) + (e.offsets[k] >> 16);
        if (x < 0 || y < 0 || x >= map_side || y >= map_side) return {};
        const std::size_t i = std::size_t(y) * map_side + std::size_t(x);
        return Sample{xyz(e.map_position, i), xyz(e.map_normal, i), xyz(e.flux, i), e.weights[k]};
    };
}

// VRSM (3.2) as a shader has it that nobody here wrote: unit directions in place of d / d^4, samples last to first.
inline void gather(const Exported& e, const PointOf& point_of, const SampleOf& sample_of, std::size_t samples) {
    std::vector<float> out(4 * std::size_t(width) * height, 0.0f);
    for (int py = 0; py < height; ++py)
        for (int px = 0; px < width; ++px) {
            const Point p = point_of(px, py);
            const auto row = [&](const std::vector<float>& r) { return r[3] + glm::dot(glm::vec3(r[0], r[1], r[2]), p.x); };
            const float w = 1.0f / std::max(row(e.row_w), 1e-6f);
            const float u = std::clamp(row(e.row_x) * w, -0x1p20f, 0x1p20f), v = std::clamp(row(e.row_y) * w, -0x1p20f, 0x1p20f);
            glm::vec3 sum(0);
            for (std::size_t k = samples; k-- > 0;) {
                const std::optional<Sample> s = sample_of(px, py, k, u, v);
                if (!s) continue;
                const glm::vec3 d = s->x - p.x;
                const float d2 = std::max(glm::dot(d, d), e.least), length = std::sqrt(d2);
                const float cos_x = std::max(0.0f, glm::dot(p.n, d) / length);
                const float cos_p = std::max(0.0f, -glm::dot(s->n, d) / length);
                sum += s->flux * (e.scale * cos_x * cos_p * s->weight / d2);
            }
            for (int c = 0; c < 3; ++c) out[4 * (std::size_t(py) * width + std::size_t(px)) + std::size_t(c)] = sum[c];
        }
    write_words(e.stage + "/out/irradiance.bin", out);
}
inline void gather(const Exported& e, const PointOf& point_of) {
    gather(e, point_of, whole_texels(e), e.weights.size());
}
inline std::size_t pixel(int x, int y) { return std::size_t(y) * width + std::size_t(x); }

inline std::string list(const glm::dmat4& m, bool by_rows) {
    std::string text;
    for (int i = 0; i < 16; ++i) {
        const double v = by_rows ? m[i % 4][i / 4] : m[i / 4][i % 4];
        text += (text.empty() ? "[" : ", ") + fmt::format("{}", double(float(v)));
    }
    return text + "]";
}
inline glm::vec3 times(const glm::mat4& m, const glm::vec3& v, float w) { return glm::vec3(m * glm::vec4(v, w)); }

inline glm::mat4 rounded(const glm::dmat4& m) { return glm::mat4(m); }

using Row = std::array<double, 4>;
inline std::string rows_of(const std::vector<Row>& rows) {
    std::string text;
    for (const Row& row : rows)
        for (const double v : row) text += (text.empty() ? "rows = [" : ", ") + fmt::format("{}", v);
    return text + "]\n";
}
// The row of clip space that a row in texels came from.
inline Row clip_row(const std::vector<float>& texels, const std::vector<float>& w, int side, bool negated = false) {
    Row row;
    for (std::size_t c = 0; c < 4; ++c) row[c] = (2.0 * double(texels[c]) / side - double(w[c])) * (negated ? -1 : 1);
    return row;
}

}  // namespace plumb::program
