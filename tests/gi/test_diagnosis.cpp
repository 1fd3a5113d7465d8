// Diagnoses of planted bugs: the cause, which the test plants by arithmetic of its own, is among the first three. And
// what the statistics of wrong pixels say of pictures whose faults are known.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "core/formats.h"
#include "core/hash.h"
#include "gi/frame/frame.h"
#include "gi/parity/diagnosis.h"
#include "gi/parity/stages.h"
#include "tests/gi/verdict_scene.h"

using namespace plumb;
using parity::Diagnosis;
using parity::Verdict;

namespace {

const std::vector<StageData>& frame_stages() {
    static const std::vector<StageData> all = [] {
        const Scene scene = test::small_scene();
        frame::Settings settings;
        settings.rsm.gather = rsm::Gather::disc, settings.rsm.samples = 40, settings.rsm.turn = rsm::Turn::hash;
        settings.ao.method = screen::AoMethod::ssao;
        const frame::Plan plan = frame::plan(scene, settings);
        return parity::frame_data(scene, settings, plan, frame::execute(scene, settings, plan, {}));
    }();
    return all;
}

const StageData& data_of(const std::string& id) {
    for (const StageData& d : frame_stages())
        if (d.id == id) return d;
    throw std::runtime_error("no dispatch " + id);
}

const StageBinding& binding_of(const StageData& d) { return parity::find_binding(d.stage, "test"); }

Bundle outputs_of(const StageData& d) {
    Bundle out;
    binding_of(d).bind(d)->run({}, DeviceProfile{}, out);
    return out;
}

float* floats_of(Bundle& bundle, const std::string& name) {
    for (Array& a : bundle.arrays)
        if (a.name == name) return reinterpret_cast<float*>(a.bytes.data());
    throw std::runtime_error("no array " + name);
}
std::size_t texels(const StageData& d) { return std::size_t(d.size.x) * std::size_t(d.size.y); }

struct Judged {
    parity::StageVerdict verdict;
    Diagnosis diagnosis;
};

Judged judge(const StageData& d, const Bundle& got, Format stored = Format::rgba32f) {
    std::vector<parity::Dumped> dumped;
    for (const Array& a : got.arrays) dumped.push_back({a.name, a, stored, 15});
    Judged j{parity::judge(binding_of(d), d, dumped, {}), {}};
    j.diagnosis = parity::diagnose(binding_of(d), d, dumped, {}, j.verdict);
    return j;
}

// Whether one of the first three guesses, or of those that do as well as the last of them, says so; and how many pixels
// agree.
std::int64_t agree_with(const Judged& j, const std::string& text) {
    CHECK(j.verdict.verdict == Verdict::wrong);
    CHECK(j.diagnosis.causes.size() <= 3);
    std::string all;
    for (const parity::Cause& c : j.diagnosis.causes) {
        all += c.text + "\n";
        if (c.text == text) return c.agree;
        for (const std::string& other : c.alike) {
            all += "  " + other + "\n";
            if (other == text) return c.agree;
        }
    }
    UNSCOPED_INFO("of " << j.diagnosis.tried << " guesses:\n" << all);
    return -1;
}

// All pixels agree, and without the guess no more than the verdict says.
void check_cause(const Judged& j, const std::string& text) {
    INFO(text);
    CHECK(agree_with(j, text) == j.verdict.pixels);
    CHECK(j.diagnosis.causes.at(0).pixels == j.verdict.pixels);
    CHECK(j.diagnosis.causes.at(0).agree == j.verdict.pixels);
    CHECK(j.diagnosis.causes.at(0).without < j.verdict.pixels);
    CHECK(j.diagnosis.wrong.pixels == j.verdict.count[int(Verdict::wrong)]);
}

}  // namespace

TEST_CASE("diagnosis: of what agrees there is none", "[diagnosis]") {
    for (const StageData& d : frame_stages()) {
        INFO(d.id);
        const Judged j = judge(d, outputs_of(d));
        CHECK(j.verdict.verdict == Verdict::equal);
        CHECK(j.diagnosis.causes.empty());
        CHECK(j.diagnosis.tried == 0);
        CHECK(j.diagnosis.wrong.pixels == 0);
    }
}

TEST_CASE("diagnosis: compose with a result that is times pi, swapped, upside down, encoded, packed", "[diagnosis]") {
    const StageData& d = data_of("compose");
    const std::size_t n = texels(d), width = std::size_t(d.size.x);
    Bundle got = outputs_of(d);
    const Bundle honest = got;
    float* p = floats_of(got, "radiance");
    const float* right = reinterpret_cast<const float*>(at(honest, "radiance").bytes.data());
    SECTION("times pi: the division is missing") {
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t c = 0; c < 3; ++c) p[4 * i + c] *= 3.14159265f;
        const Judged j = judge(d, got);
        check_cause(j, "radiance times pi");
        for (const parity::Ratios& r : j.diagnosis.wrong.ratios) {
            CHECK(r.quartiles[1] == Approx(3.14159265));
            CHECK(r.constant());
        }
    }
    SECTION("a ratio without a name") {
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t c = 0; c < 3; ++c) p[4 * i + c] *= 1.2346f;
        check_cause(judge(d, got), "radiance times 1.235");
    }
    SECTION("blue and red swapped") {
        for (std::size_t i = 0; i < n; ++i) std::swap(p[4 * i], p[4 * i + 2]);
        check_cause(judge(d, got), "radiance with x and z swapped");
    }
    SECTION("the first row is the lowest") {
        for (int y = 0; y < d.size.y; ++y)
            std::memcpy(p + 4 * width * std::size_t(y), right + 4 * width * std::size_t(d.size.y - 1 - y), 16 * width);
        check_cause(judge(d, got), "the result flipped in y");
    }
    SECTION("encoded as sRGB") {
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t c = 0; c < 3; ++c) {
                const double x = double(p[4 * i + c]);
                p[4 * i + c] = float(x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055);
            }
        check_cause(judge(d, got), "radiance encoded as sRGB");
    }
    SECTION("alpha alone is another") {
        for (std::size_t i = 0; i < n; ++i) p[4 * i + 3] = 0.25f;
        check_cause(judge(d, got), "radiance.w left aside: channels = \"xyz\"");
    }
    SECTION("the reflectance is missing") {
        // (E_direct + E_indirect + M / rho) / pi: what is emitted is 0 in y alone, so that all else is no such factor.
        StageData other = d;
        std::fill_n(floats_of(other.inputs, "albedo"), 4 * n, 1.0f);
        check_cause(judge(d, outputs_of(other)), "albedo not read (1)");
    }
    SECTION("the wrong texture is bound") {
        StageData other = d;
        std::memcpy(floats_of(other.inputs, "indirect"), at(d.inputs, "direct").bytes.data(), 16 * n);
        check_cause(judge(d, outputs_of(other)), "direct read in the place of indirect");
    }
    SECTION("stored as halves") {
        for (std::size_t i = 0; i < n; ++i) {
            glm::vec4 v(p[4 * i] * 2, p[4 * i + 1] * 2, p[4 * i + 2] * 2, p[4 * i + 3]);
            quantise(Format::rgba16f, v, HalfStore::truncate);
            std::memcpy(p + 4 * i, &v, 16);
        }
        check_cause(judge(d, got, Format::rgba16f), "radiance times 2");
    }
}

TEST_CASE("diagnosis: a gather with normals unpacked twice, one sample less, another seed, half a texel beside",
          "[diagnosis]") {
    const StageData& d = data_of("rsm.disc.key_light");
    const StageBinding& b = binding_of(d);
    StageData other = d;
    auto uniform = [&](const char* name, double by) {
        const std::vector<double> value = {uniform_value(b, d, name)[0] + by};
        set_uniform(b, other, name, value, "test");
    };
    SECTION("normals unpacked twice") {
        float* normal = floats_of(other.inputs, "rsm_normal");
        for (std::size_t i = 0; i < at(d.inputs, "rsm_normal").bytes.size() / 16; ++i)
            for (std::size_t c = 0; c < 3; ++c)
                if (normal[4 * i + 3] > 0) normal[4 * i + c] = 2 * normal[4 * i + c] - 1;
        check_cause(judge(d, outputs_of(other)), "rsm_normal unpacked once more (2 x - 1)");
    }
    SECTION("one sample less") {
        uniform("samples", -1);
        check_cause(judge(d, outputs_of(other)), "samples one less");
    }
    SECTION("another seed") {
        uniform("seed", 1);
        check_cause(judge(d, outputs_of(other)), "seed one more");
    }
    SECTION("weights are squared") {
        float* w = floats_of(other.inputs, "weights");
        for (std::size_t i = 0; i < at(d.inputs, "weights").bytes.size() / 4; ++i) w[i] = w[i] * w[i];
        check_cause(judge(d, outputs_of(other)), "weights squared");
    }
    SECTION("normals turned") {
        float* normal = floats_of(other.inputs, "normal");
        for (std::size_t i = 0; i < texels(d); ++i)
            for (std::size_t c = 0; c < 3; ++c) normal[4 * i + c] = -normal[4 * i + c];
        check_cause(judge(d, outputs_of(other)), "normal negated");
    }
    SECTION("the map is projected to half a texel beside") {
        std::vector<double> x = uniform_value(b, d, "map.to_texel_x"), w = uniform_value(b, d, "map.to_texel_w");
        for (std::size_t i = 0; i < 4; ++i) x[i] += 0.5 * w[i];
        set_uniform(b, other, "map.to_texel_x", x, "test");
        check_cause(judge(d, outputs_of(other)), "map: +0.5 texels in x");
    }
    SECTION("the result is times the number of samples") {
        Bundle got = outputs_of(d);
        float* p = floats_of(got, "irradiance");
        for (std::size_t i = 0; i < texels(d); ++i)
            for (std::size_t c = 0; c < 3; ++c) p[4 * i + c] *= 40;
        check_cause(judge(d, got), "irradiance times samples");
    }
}

TEST_CASE("diagnosis: a shadow map upside down, not divided by w, its result turned", "[diagnosis]") {
    const StageData& d = data_of("shadow.key_light");
    const StageBinding& b = binding_of(d);
    StageData other = d;
    SECTION("y up for y down") {
        std::vector<double> y = uniform_value(b, d, "map.to_texel_y"), w = uniform_value(b, d, "map.to_texel_w");
        for (std::size_t i = 0; i < 4; ++i) y[i] = 24 * w[i] - y[i];
        set_uniform(b, other, "map.to_texel_y", y, "test");
        check_cause(judge(d, outputs_of(other)), "map: y flipped");
    }
    SECTION("no perspective divide") {
        set_uniform(b, other, "map.to_texel_w", std::vector<double>{0, 0, 0, 1}, "test");
        check_cause(judge(d, outputs_of(other)), "map: no perspective divide");
    }
    SECTION("lit and shadowed exchanged") {
        Bundle got = outputs_of(d);
        float* p = floats_of(got, "visibility");
        for (std::size_t i = 0; i < texels(d); ++i) p[i] = 1 - p[i];
        check_cause(judge(d, got), "visibility taken from 1");
    }
}

TEST_CASE("diagnosis: direct light with a swapped axis and without shadows", "[diagnosis]") {
    const StageData& d = data_of("direct");
    StageData other = d;
    SECTION("z of the normals turned") {
        float* normal = floats_of(other.inputs, "normal");
        for (std::size_t i = 0; i < texels(d); ++i) normal[4 * i + 2] = -normal[4 * i + 2];
        check_cause(judge(d, outputs_of(other)), "normal with z negated");
    }
    SECTION("y and z of positions swapped") {
        float* position = floats_of(other.inputs, "position");
        for (std::size_t i = 0; i < texels(d); ++i) std::swap(position[4 * i + 1], position[4 * i + 2]);
        check_cause(judge(d, outputs_of(other)), "position with y and z swapped");
    }
}

TEST_CASE("diagnosis: ambient occlusion of a view with another handedness, and of positions a texel beside",
          "[diagnosis]") {
    const StageData& d = data_of("screen.ssao");
    const StageBinding& b = binding_of(d);
    StageData other = d;
    SECTION("x of the world turned") {
        for (const char* row : {"view.to_x", "view.to_y", "view.forward"}) {
            std::vector<double> v = uniform_value(b, d, row);
            v[0] = -v[0];
            set_uniform(b, other, row, v, "test");
        }
        check_cause(judge(d, outputs_of(other)), "view: another handedness: x of the world negated");
    }
    SECTION("a texel to the right") {
        const float* from = reinterpret_cast<const float*>(at(d.inputs, "map_position").bytes.data());
        float* to = floats_of(other.inputs, "map_position");
        for (int y = 0; y < d.size.y; ++y)
            for (int x = 0; x < d.size.x; ++x)
                std::memcpy(to + 4 * (y * d.size.x + x), from + 4 * (y * d.size.x + std::min(x + 1, d.size.x - 1)), 16);
        check_cause(judge(d, outputs_of(other)), "map_position read at (+1, +0) texels");
    }
}

TEST_CASE("diagnosis: cosines that are not kept at 0 and above", "[diagnosis]") {
    // Of every other pixel the light is behind.
    StageData d = data_of("direct");
    const std::size_t n = texels(d);
    float* facing = floats_of(d.inputs, "normal");
    for (std::size_t i = 0; i < n; i += 2)
        for (std::size_t c = 0; c < 3; ++c) facing[4 * i + c] = -facing[4 * i + c];
    StageData turned = d;
    float* normal = floats_of(turned.inputs, "normal");
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t c = 0; c < 3; ++c) normal[4 * i + c] = -normal[4 * i + c];
    // |c| = max(0, c) + max(0, -c), and c is their difference.
    Bundle got = outputs_of(d), behind = outputs_of(turned);
    float *p = floats_of(got, "irradiance"), *q = floats_of(behind, "irradiance");
    SECTION("abs for max(0, .)") {
        for (std::size_t i = 0; i < 4 * n; ++i)
            if (i % 4 != 3) p[i] += q[i];
        check_cause(judge(d, got), "normal from both sides (abs for max(0, .))");
    }
    SECTION("no max(0, .)") {
        for (std::size_t i = 0; i < 4 * n; ++i)
            if (i % 4 != 3) p[i] -= q[i];
        check_cause(judge(d, got), "normal from behind less than 0 (no max(0, .))");
    }
}

TEST_CASE("diagnosis: direct light by d for d^2, and with the light's colour twice", "[diagnosis]") {
    // The first lamp alone: one distance, one colour.
    const StageData& d = data_of("direct");
    const StageBinding& b = binding_of(d);
    StageData one = d;
    set_uniform(b, one, "lights", std::vector<double>{1}, "test");
    const float* light = floats_of(one.inputs, "lights");
    REQUIRE(light[11] == 0);  // LightArgs::directional
    const float* position = floats_of(one.inputs, "position");
    Bundle got = outputs_of(one);
    float* p = floats_of(got, "irradiance");
    const std::size_t n = texels(d);
    SECTION("d for d^2") {
        for (std::size_t i = 0; i < n; ++i) {
            double d2 = 0;
            for (std::size_t c = 0; c < 3; ++c) {
                const double v = double(position[4 * i + c]) - double(light[c]);
                d2 += v * v;
            }
            for (std::size_t c = 0; c < 3; ++c) p[4 * i + c] = float(double(p[4 * i + c]) * std::sqrt(d2));
        }
        const Judged j = judge(one, got);
        REQUIRE(!j.diagnosis.causes.empty());
        CHECK_THAT(j.diagnosis.causes[0].text,
                   Catch::Matchers::StartsWith("irradiance times the distance from position to what lights holds"));
        CHECK(j.diagnosis.causes[0].agree == j.verdict.pixels);
    }
    SECTION("the colour twice") {
        REQUIRE((light[8] != light[9] || light[9] != light[10]));
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t c = 0; c < 3; ++c) p[4 * i + c] *= light[8 + c];
        const Judged j = judge(one, got);
        REQUIRE(!j.diagnosis.causes.empty());
        CHECK_THAT(j.diagnosis.causes[0].text, Catch::Matchers::StartsWith("irradiance times what lights holds"));
        CHECK(j.diagnosis.causes[0].agree == j.verdict.pixels);
    }
}

TEST_CASE("diagnosis: a gather with a matrix by rows, another border, packed normals, positions of another frame",
          "[diagnosis]") {
    const StageData& d = data_of("rsm.disc.key_light");
    const StageBinding& b = binding_of(d);
    StageData other = d;
    SECTION("rows for columns, planes of 0.1 and 50 m") {
        // clip = M (p, 1); the shader has the transpose of M.
        const std::vector<double> x = uniform_value(b, d, "map.to_texel_x"), y = uniform_value(b, d, "map.to_texel_y"),
                                  w = uniform_value(b, d, "map.to_texel_w");
        const double side = uniform_value(b, d, "map.size")[0];
        glm::dmat4 m;  // m[column][row]
        for (int c = 0; c < 4; ++c) {
            const std::size_t k = std::size_t(c);
            m[c] = {2 * x[k] / side - w[k], 2 * y[k] / side - w[k], 50 / 49.9 * w[k] - (c == 3 ? 50 * 0.1 / 49.9 : 0), w[k]};
        }
        const glm::dmat4 t = glm::transpose(m);
        std::vector<double> tx, ty, tw;
        for (int c = 0; c < 4; ++c) {
            tx.push_back(0.5 * side * (t[c][0] + t[c][3])), ty.push_back(0.5 * side * (t[c][1] + t[c][3]));
            tw.push_back(t[c][3]);
        }
        set_uniform(b, other, "map.to_texel_x", tx, "test");
        set_uniform(b, other, "map.to_texel_y", ty, "test");
        set_uniform(b, other, "map.to_texel_w", tw, "test");
        check_cause(judge(d, outputs_of(other)), "map: its matrix transposed (row-major), planes 0.1 and 50 m");
    }
    SECTION("normals that stay packed, and are normalised") {
        float* normal = floats_of(other.inputs, "normal");
        for (std::size_t i = 0; i < texels(d); ++i) {
            if (normal[4 * i] == 0 && normal[4 * i + 1] == 0 && normal[4 * i + 2] == 0) continue;
            double length = 0, v[3];
            for (std::size_t c = 0; c < 3; ++c) v[c] = 0.5 + 0.5 * double(normal[4 * i + c]), length += v[c] * v[c];
            for (std::size_t c = 0; c < 3; ++c) normal[4 * i + c] = float(v[c] / std::sqrt(length));
        }
        check_cause(judge(d, outputs_of(other)), "normal packed once more (0.5 x + 0.5), then normalised");
    }
    SECTION("positions of two pixels to the right and one below") {
        const float* from = reinterpret_cast<const float*>(at(d.inputs, "position").bytes.data());
        float* to = floats_of(other.inputs, "position");
        for (int y = 0; y < d.size.y; ++y)
            for (int x = 0; x < d.size.x; ++x)
                std::memcpy(to + 4 * (y * d.size.x + x),
                            from + 4 * (std::min(y + 1, d.size.y - 1) * d.size.x + std::min(x + 2, d.size.x - 1)), 16);
        check_cause(judge(d, outputs_of(other)), "position read at (+2, +1) texels, as of another frame");
    }
    SECTION("its edge goes on beyond the map") {
        // The same map with its edge around it, as wide as itself.
        const int side = int(uniform_value(b, d, "map.size")[0]);
        for (const char* name : {"rsm_position", "rsm_normal", "rsm_flux"})
            for (Array& a : other.inputs.arrays) {
                if (a.name != name) continue;
                const std::vector<unsigned char> old(a.bytes.begin(), a.bytes.end());
                a.shape[0] = a.shape[1] = 3 * side;
                a.bytes.resize(9 * old.size());
                for (int y = 0; y < 3 * side; ++y)
                    for (int x = 0; x < 3 * side; ++x) {
                        const int u = std::max(0, std::min(x - side, side - 1)), v = std::max(0, std::min(y - side, side - 1));
                        std::memcpy(a.bytes.data() + 16 * (y * 3 * side + x), old.data() + 16 * (v * side + u), 16);
                    }
            }
        for (const char* row : {"map.to_texel_x", "map.to_texel_y"}) {
            std::vector<double> v = uniform_value(b, d, row);
            const std::vector<double> w = uniform_value(b, d, "map.to_texel_w");
            for (std::size_t i = 0; i < 4; ++i) v[i] += side * w[i];
            set_uniform(b, other, row, v, "test");
        }
        set_uniform(b, other, "map.size", std::vector<double>{3.0 * side}, "test");
        check_cause(judge(d, outputs_of(other)), "beyond the border of map its edge is repeated");
    }
}

TEST_CASE("diagnosis: numbers that have no name are fitted", "[diagnosis]") {
    const StageData& d = data_of("screen.ssao");
    const StageBinding& b = binding_of(d);
    StageData other = d;
    set_uniform(b, other, "radius", std::vector<double>{1.37 * uniform_value(b, d, "radius")[0]}, "test");
    const Judged j = judge(d, outputs_of(other));
    REQUIRE(!j.diagnosis.causes.empty());
    CHECK(j.diagnosis.causes[0].text.starts_with("radius times 1.3"));
    CHECK(j.diagnosis.causes[0].fitted);
    CHECK(double(j.diagnosis.causes[0].agree) >= 0.99 * double(j.verdict.pixels));
}

TEST_CASE("diagnosis: a G-buffer whose normals stay packed", "[diagnosis]") {
    const StageData& d = data_of("gbuffer");
    Bundle got = outputs_of(d);
    float* normal = floats_of(got, "normal");
    for (std::size_t i = 0; i < 4 * texels(d); ++i)
        if (i % 4 != 3) normal[i] = 0.5f * normal[i] + 0.5f;
    check_cause(judge(d, got), "normal packed once more (0.5 x + 0.5)");
}

TEST_CASE("diagnosis: two bugs in two places are two rows", "[diagnosis]") {
    const StageData& d = data_of("compose");
    Bundle got = outputs_of(d);
    float* p = floats_of(got, "radiance");
    for (int y = 0; y < d.size.y; ++y)
        for (int x = 0; x < d.size.x; ++x) {
            float* texel = p + 4 * (y * d.size.x + x);
            if (x < 16)
                for (int c = 0; c < 3; ++c) texel[c] *= 0.5f;
            else if (x >= 24)
                std::swap(texel[0], texel[1]);
        }
    const Judged j = judge(d, got);
    REQUIRE(j.diagnosis.clusters.size() == 2);
    for (const parity::ClusterCause& c : j.diagnosis.clusters) {
        INFO(c.text);
        CHECK((c.high.x < 16 || c.low.x >= 24));
        CHECK(c.text == (c.high.x < 16 ? "radiance divided by 2" : "radiance with x and y swapped"));
        CHECK(c.agree == c.looked_at);
    }
}

TEST_CASE("diagnosis: what no guess explains is not explained", "[diagnosis]") {
    const StageData& d = data_of("compose");
    Bundle got = outputs_of(d);
    float* p = floats_of(got, "radiance");
    for (std::size_t i = 0; i < texels(d); ++i)
        for (std::size_t c = 0; c < 3; ++c) {
            const auto h = pixel_hash<std::int32_t>(std::int32_t(i), std::int32_t(c), 1, 5);
            p[4 * i + c] *= 0.5f + float(std::uint32_t(h.x) >> 8) * 0x1p-24f;
        }
    const Judged j = judge(d, got);
    CHECK(j.verdict.verdict == Verdict::wrong);
    CHECK(j.diagnosis.tried > 100);
    CHECK(j.diagnosis.causes.empty());
    for (const parity::Ratios& r : j.diagnosis.wrong.ratios) CHECK_FALSE(r.constant());
}

// A pixel whose result is doubled explains nothing of all: no guess that breaks the rest is named.
TEST_CASE("diagnosis: of one pixel the size of its error is told, and no cause", "[diagnosis]") {
    const StageData& d = data_of("compose");
    Bundle got = outputs_of(d);
    float* p = floats_of(got, "radiance");
    const std::size_t at = std::size_t(d.size.x) * 20 + 17;
    const float right = p[4 * at + 1];
    REQUIRE(right > 0);
    p[4 * at + 1] = 3 * right;
    const Judged j = judge(d, got);
    CHECK(j.diagnosis.causes.empty());
    REQUIRE(j.diagnosis.wrong.largest.size() == 1);
    const parity::LargeError& e = j.diagnosis.wrong.largest[0];
    CHECK(e.pixel == glm::ivec2(17, 20));
    CHECK(e.channel == 1);
    CHECK(e.expected == right);
    CHECK(e.got == 3 * right);
}

TEST_CASE("diagnosis: pixels that expect 0 are told beside the others", "[diagnosis]") {
    const StageData& d = data_of("direct");
    Bundle got = outputs_of(d);
    float* p = floats_of(got, "irradiance");
    std::int64_t dark = 0;
    for (std::size_t i = 0; i < texels(d); ++i) {
        if (p[4 * i] != 0 || p[4 * i + 1] != 0 || p[4 * i + 2] != 0) continue;
        p[4 * i + 1] = 0.25f + 0.001f * float(dark++);
    }
    REQUIRE(dark > 0);
    const Judged j = judge(d, got);
    const parity::WrongPixels& w = j.diagnosis.wrong;
    CHECK(w.pixels == dark);
    CHECK(w.unexpected == dark);
    REQUIRE(!w.unexpected_largest.empty());
    CHECK(w.unexpected_largest[0].got == Approx(0.25 + 0.001 * double(dark - 1)).epsilon(1e-5));
    CHECK(w.unexpected_largest[0].expected == 0);
}
