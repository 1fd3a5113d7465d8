// What each layout's targets make of the G-buffer: closed-form error bounds, and equality with the definition of each
// format (core/formats.h), by every instruction set.
#include <algorithm>
#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "core/camera.h"
#include "core/error.h"
#include "core/quantise_kernel.h"
#include "drawing.h"
#include "raster/gbuffer.h"

using namespace plumb;
using namespace plumb::raster;
using namespace plumb::raster::test;

namespace {

constexpr glm::ivec2 frame{101, 67};  // no multiple of any vector

// Materials with values that every format treats in its own way.
Scene many_materials() {
    Scene scene;
    Random random(3);
    const float special[] = {0,     -0.0f,    1,   65504, 65519,   65520, 7e4f,
                             3e38f, INFINITY, NAN, 1e-8f, 6.1e-5f, 3e-5f, 1e-42f};
    for (int i = 0; i < 60; ++i) {
        const glm::vec3 rho = random.vector(0, 1);
        glm::vec3 emission = random.vector(0, 1) * float(std::exp2(random.between(-20, 18)));
        if (i % 3 == 0) emission[i % 2] = special[std::size_t(i / 3) % std::size(special)];
        scene.materials.push_back({"m", rho, emission});
    }
    return scene;
}

Camera camera_at(double far = 80) {
    Camera c;
    c.position = {0.5, 0.3, 2}, c.look_at = {0.3, 0.1, -1};
    c.fov_y_deg = 70, c.near = 0.1, c.far = far;
    return c;
}

Geometry soup(int n) {
    Random random(9);
    Geometry g;
    for (int i = 0; i < n; ++i) {
        const glm::vec3 centre = random.vector(-9, 9) - glm::vec3(0, 0, 9);
        auto corner = [&] {
            const glm::vec3 p = centre + random.vector(-2, 2);
            return at(p, random.vector(-1, 1));
        };
        const Vertex a = corner(), b = corner(), c = corner();
        add_triangle(g, a, b, c, i % 60, i % 7);
    }
    return g;
}

struct Drawn {
    Scene scene = many_materials();
    Geometry geometry = soup(700);
    Camera camera = camera_at();
    GBuffer draw(const Layout& layout, RunOptions options = {}, const GBufferWants& wants = {}) const {
        GBuffer out;
        draw_into(out, layout, options, wants);
        return out;
    }
    void draw_into(GBuffer& out, const Layout& layout, RunOptions options = {}, const GBufferWants& wants = {}) const {
        const View view = make_view(camera, double(frame.x) / frame.y);
        // Some emissions fit no target, to see what a store makes of them: nobody has said how bright it may be.
        Surfaces surfaces = prepare(scene, geometry);
        surfaces.brightest = {};
        draw_gbuffer(geometry, surfaces, view, frame, layout, options, out, wants);
    }
};

bool same(const Image4& a, const Image4& b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(glm::vec4)) == 0);
}
bool same(const GBuffer& a, const GBuffer& b) {
    return same(a.position, b.position) && same(a.normal, b.normal) && same(a.albedo, b.albedo) &&
           same(a.emission, b.emission) && a.id.texels == b.id.texels &&
           std::memcmp(a.depth.data(), b.depth.data(), 4 * a.depth.size()) == 0;
}

Layout custom() {
    Layout l;
    l.name = "custom";
    return l;
}

double angle_between(const glm::dvec3& a, const glm::dvec3& b) {
    return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

// The bits of a component, every NaN alike.
std::uint32_t bits_of(float x) { return x != x ? 0x7fc00000u : std::bit_cast<std::uint32_t>(x); }

}  // namespace

TEST_CASE("layout: a kernel's rounding is quantise() to the bit, for every format", "[layout][formats]") {
    Random random(41);
    const float special[] = {0,      -0.0f,    1,        -1,       0.5f,     -0.5f,      65504,  65519.996f, 65520,     1e30f,
                             -1e30f, 0x1p-14f, 0x1p-15f, 0x1p-24f, 0x1p-25f, 0x1.8p-25f, 1e-42f, INFINITY,   -INFINITY, NAN};
    for (const FormatInfo& f : formats()) {
        if (!quantised_by_kernel(f.format)) continue;
        CAPTURE(f.name);
        for (int i = 0; i < 40000; ++i) {
            glm::vec4 v;
            for (int c = 0; c < 4; ++c) {
                const int kind = random.below(8);
                v[c] = kind == 0   ? special[std::size_t(random.below(int(std::size(special))))]
                       : kind == 1 ? std::bit_cast<float>(random.next())
                       : kind == 2 ? float(random.below(4096)) / 510  // ties of 8 bits, and beyond 1
                                   : float(random.between(-1.2, 1.2));
            }
            glm::vec4 expected = v;
            quantise(f.format, expected);
            const vec4<float> got = quantised<float>(f.format, v);
            for (int c = 0; c < 4; ++c) {
                CAPTURE(v.x, v.y, v.z, v.w, c, got[c], expected[c]);
                REQUIRE(bits_of(got[c]) == bits_of(expected[c]));
            }
        }
    }
    // Every half, its neighbours in float, and the ties between halves.
    for (std::uint32_t h = 0; h < 65536; ++h) {
        const float x = half_to_float({std::uint16_t(h)}), next = half_to_float({std::uint16_t(h + 1)});
        const float tie = x * 0.5f + next * 0.5f;
        for (float y : {x, std::nextafterf(x, 1e9f), tie, std::nextafterf(tie, 0)})
            REQUIRE(bits_of(half_rounded(y)) == bits_of(half_to_float(float_to_half(y))));
    }
}

TEST_CASE("layout: every layout is the fp32 picture through quantise(), by every instruction set", "[layout][bits]") {
    const Drawn d;
    const GBuffer exact = d.draw(Layout::fp32);
    REQUIRE(std::count(exact.id.texels.begin(), exact.id.texels.end(), glm::ivec2(-1)) < frame.x * frame.y / 2);
    std::vector<Layout> all = layouts();
    for (Format normal : {Format::octahedral16, Format::octahedral8, Format::r10g10b10a2})
        for (Format colour : {Format::rgba8, Format::r11g11b10f, Format::r10g10b10a2, Format::rgbe}) {
            Layout l = custom();
            l.normal = normal, l.albedo = colour, l.emission = Format::r11g11b10f, l.depth_buffer = Format::d24s8;
            if (colour == Format::rgbe) l.emission = Format::rgbe, l.position = Format::rgba16f, l.depth = Format::r16f;
            all.push_back(l);
        }
    for (const Layout& l : all) {
        CAPTURE(l.name, info(l.normal).name, info(l.albedo).name);
        RunOptions options;
        options.isa = Isa::scalar, options.threads = 1;
        const GBuffer truth = d.draw(l, options);
        for (Isa isa : supported_isas()) {
            CAPTURE(isa_name(isa));
            options.isa = isa, options.threads = 2;
            CHECK(same(d.draw(l, options), truth));
        }
        for (std::size_t i = 0; i < truth.normal.size(); ++i) {
            glm::vec4 normal = exact.normal.texels[i], albedo = exact.albedo.texels[i],
                      emission = exact.emission.texels[i], position = exact.position.texels[i];
            if (exact.id.texels[i].y < 0) {
                REQUIRE(truth.position.texels[i] == glm::vec4(0));
                REQUIRE(truth.normal.texels[i] == glm::vec4(0));
                REQUIRE(truth.albedo.texels[i] == glm::vec4(0));
                REQUIRE(truth.emission.texels[i] == glm::vec4(0));
                REQUIRE(truth.id.texels[i] == glm::ivec2(-1));
                REQUIRE(truth.depth.texels[i] == 1.0f);
                continue;
            }
            if (l.normal == Format::r10g10b10a2) {
                for (int c = 0; c < 3; ++c)
                    normal[c] = 2.0f * float(encode_unorm(normal[c] * 0.5f + 0.5f, 10)) / 1023 - 1;
            } else {
                quantise(l.normal, normal);
            }
            quantise(l.albedo, albedo);
            quantise(l.emission, emission);
            for (int c = 0; c < 3; ++c) {
                CAPTURE(i, c, exact.emission.texels[i][c]);
                REQUIRE(bits_of(truth.normal.texels[i][c]) == bits_of(normal[c]));
                REQUIRE(bits_of(truth.albedo.texels[i][c]) == bits_of(albedo[c]));
                REQUIRE(bits_of(truth.emission.texels[i][c]) == bits_of(emission[c]));
            }
            REQUIRE(truth.normal.texels[i].w == 1);
            if (l.position_from_depth) continue;
            quantise(l.position, position);
            REQUIRE(glm::vec3(truth.position.texels[i]) == glm::vec3(position));
        }
    }
}

// Half a step of each format; a half keeps 11 bits.
TEST_CASE("layout: rgba8, rgba16f and ISR (22) round by half a step at most", "[layout][analytic]") {
    const Drawn d;
    const GBuffer exact = d.draw(Layout::fp32), isr = d.draw(Layout::isr), half = d.draw(Layout::vrsm);
    int covered = 0;
    for (std::size_t i = 0; i < exact.normal.size(); ++i) {
        if (exact.id.texels[i].y < 0) continue;
        ++covered;
        double luminance = 0;
        for (int c = 0; c < 3; ++c) {
            const double rho = exact.albedo.texels[i][c], n = exact.normal.texels[i][c];
            const double p = exact.position.texels[i][c];
            luminance += (c == 0 ? 0.27 : c == 1 ? 0.67 : 0.06) * rho;
            REQUIRE(std::abs(isr.albedo.texels[i][c] - rho) <= 1 / 510.0 + 1e-7);
            REQUIRE(std::abs(isr.normal.texels[i][c] - n) <= 1 / 255.0 + 1e-7);
            REQUIRE(std::abs(half.position.texels[i][c] - p) <= std::max(0x1p-11 * std::abs(p), 0x1p-25));
            REQUIRE(std::abs(half.normal.texels[i][c] - n) <= std::max(0x1p-11 * std::abs(n), 0x1p-25));
        }
        REQUIRE(std::abs(isr.albedo.texels[i].w - luminance) <= 1 / 510.0 + 1e-6);
        REQUIRE(std::abs(isr.depth.texels[i] - exact.depth.texels[i]) <= 0.5 / 0xffffff + 0x1p-25);
        const double w = exact.position.texels[i].w;
        REQUIRE(std::abs(half.position.texels[i].w - w) <= 0x1p-11 * w);
    }
    CHECK(covered > 3000);
    CHECK(same(half, d.draw(Layout::rgba16f)));
    // No code of (22) stands for 0.
    CHECK(std::none_of(isr.normal.texels.begin(), isr.normal.texels.end(),
                       [](const glm::vec4& n) { return n.w == 1 && (n.x == 0 || n.y == 0 || n.z == 0); }));
}

// Each coordinate of the square is off by at most h = 1 / (2 (2^15 - 1)); the point on the octahedron |x|+|y|+|z| = 1
// moves by at most sqrt(h^2 + h^2 + (2h)^2) = sqrt(6) h, at a distance from the origin of at least 1/sqrt(3): the angle
// is below sqrt(18) h. A fold may add as much once more on its other side: the bound is taken twice, and fp32 adds 1e-6.
TEST_CASE("layout: octahedral normals stay within the derived angle", "[layout][analytic]") {
    const Drawn d;
    const GBuffer exact = d.draw(Layout::fp32);
    for (Format format : {Format::octahedral16, Format::octahedral8}) {
        Layout l = custom();
        l.normal = format;
        const GBuffer out = d.draw(l);
        const double h = 0.5 / (format == Format::octahedral16 ? 32767 : 127);
        double worst = 0;
        for (std::size_t i = 0; i < exact.normal.size(); ++i) {
            if (exact.id.texels[i].y < 0) continue;
            const glm::dvec3 n(exact.normal.texels[i]), m(out.normal.texels[i]);
            const double angle = angle_between(n, m);
            REQUIRE(std::abs(glm::length(m) - 1) <= 4 * 0x1p-24);
            REQUIRE(angle <= 2 * std::sqrt(18.0) * h + 1e-6);
            worst = std::max(worst, angle);
        }
        CHECK(worst > 0.5 * h);  // the format was applied
    }
}

// A rebuilt position lies on the ray through the pixel's centre, e + r d with |r| the ray's length at depth 1. Its depth
// is the stored one: an R32F value of depth over the far plane, 2 roundings, times that plane. Along the ray three
// products and sums of terms below 2 |r| d and one with |e| + |r| d round: 2^-24 (8 |r| d + |e|) in each component.
TEST_CASE("layout: positions rebuilt from depth lie on their rays", "[layout][ISR 4.3][analytic]") {
    for (double far : {80.0, 1e6}) {
        Drawn d;
        d.camera = camera_at(far);
        const GBuffer exact = d.draw(Layout::fp32), isr = d.draw(Layout::isr);
        const CameraAxes a = axes(d.camera);
        int covered = 0;
        for (int y = 0; y < frame.y; ++y)
            for (int x = 0; x < frame.x; ++x) {
                if (exact.id(x, y).y < 0) continue;
                const double depth = exact.position(x, y).w;
                REQUIRE(std::abs(isr.position(x, y).w - depth) <= 4 * 0x1p-24 * depth);
                const Ray ray = ray_through_pixel(d.camera, frame, {x, y});
                const glm::dvec3 r = ray.direction / glm::dot(ray.direction, a.forward);
                const glm::dvec3 expected = ray.origin + r * depth;
                const double bound = 0x1p-24 * (12 * glm::length(r) * depth + 4 * glm::length(ray.origin));
                for (int c = 0; c < 3; ++c) {
                    CAPTURE(far, x, y, c, isr.position(x, y)[c], expected[c], bound);
                    REQUIRE(std::abs(isr.position(x, y)[c] - expected[c]) <= bound);
                }
                // What was drawn is the surface within half a unit of the grid that corners snap to.
                const double pixel = 2 * std::tan(d.camera.fov_y_deg * M_PI / 360) / frame.y;
                const glm::dvec3 off = glm::dvec3(isr.position(x, y)) - glm::dvec3(exact.position(x, y));
                REQUIRE(glm::length(off) <= 2 * pixel / 256 * depth * glm::length(r) + 4 * bound);
                ++covered;
            }
        CHECK(covered > 3000);
    }
}

TEST_CASE("layout: LRA's linear depth is that of the half position", "[layout][LRA 4.2.1]") {
    const Drawn d;
    const GBuffer out = d.draw(Layout::lra), half = d.draw(Layout::rgba16f);
    for (std::size_t i = 0; i < out.position.size(); ++i) {
        const glm::vec4 p = out.position.texels[i];
        REQUIRE(glm::vec3(p) == glm::vec3(half.position.texels[i]));
        if (out.id.texels[i].y < 0) continue;
        REQUIRE(std::abs(p.w - linear_depth(d.camera, glm::dvec3(p))) <= 8 * 0x1p-24 * 30);
    }
}

TEST_CASE("layout: what does not fit is refused by layout, extent and cause", "[layout][errors]") {
    const Scene scene = many_materials();
    Geometry far_away;
    add_triangle(far_away, at({-81000, 0, -81000}), at({81000, 0, -81000}), at({0, 0, 81000}));
    Camera camera = camera_at(INFINITY);
    auto draw = [&](const Layout& layout, const View& view) {
        GBuffer out;
        Surfaces surfaces = prepare(scene, far_away);
        surfaces.brightest = {};
        draw_gbuffer(far_away, surfaces, view, frame, layout, {}, out);
    };
    CHECK_NOTHROW(draw(Layout::fp32, make_view(camera, 1.5)));
    CHECK_THROWS_WITH(draw(Layout::vrsm, make_view(camera, 1.5)),
                      "gbuffer: positions up to 81 km do not fit rgba16f (65.504 km), which layout \"vrsm\" stores them "
                      "in: use fp32, or positions rebuilt from depth");
    CHECK_THROWS_WITH(draw(Layout::lra, make_view(camera, 1.5)), Catch::Contains("81 km"));
    Layout depths = custom();
    depths.depth = Format::r16f;
    CHECK_THROWS_WITH(draw(depths, make_view(camera, 1.5)), Catch::Contains("depths up to 114.553 km do not fit r16f"));
    CHECK_THROWS_WITH(draw(Layout::isr, make_view(camera, 1.5)), Catch::Contains("far plane, which is infinite"));
    View across = make_view(camera_at(), 1.5);
    across.orthographic = true;
    CHECK_THROWS_WITH(draw(Layout::isr, across), Catch::Contains("expected a perspective view"));
    // Nothing beyond the far plane is seen: the same scene fits. Its near end alone decides.
    CHECK_NOTHROW(draw(Layout::vrsm, make_view(camera_at(3e4), 1.5)));
    CHECK_NOTHROW(draw(Layout::isr, make_view(camera_at(1e6), 1.5)));
}

// Every channel of figures 4.2 to 4.4 has 16 bits; the depth lies in the positions' and in indirect light's alpha, the
// shadow density in the material colour's.
TEST_CASE("layout: vrsm is VRSM figures 4.2, 4.3 and 4.4", "[layout][VRSM fig. 4.2][VRSM fig. 4.3][VRSM fig. 4.4]") {
    const Layout& l = Layout::vrsm;
    for (Format f : {l.rsm_position, l.rsm_normal, l.rsm_flux, l.position, l.albedo, l.normal, l.indirect})
        CHECK(f == Format::rgba16f);
    for (Format f : {l.rsm_depth, l.depth, l.visibility}) CHECK(f == Format::r16f);
    CHECK_FALSE((l.position_from_depth || l.depth_from_position || l.depth_over_far || l.radiation_mask));
    // The others store neither, but rgba16f, which is halves throughout.
    for (const Layout& other : layouts()) {
        const bool halves = other.name == "vrsm" || other.name == "rgba16f";
        CHECK(other.visibility == (halves ? Format::r16f : Format::r32f));
        CHECK(other.indirect == (halves ? Format::rgba16f : Format::rgba32f));
    }
}

TEST_CASE("layout: what compute stages store is quantise() to the bit; the first value that does not fit is told",
          "[layout][formats]") {
    Random random(17);
    const glm::ivec2 size(37, 41);
    for (const Format format : {Format::rgba32f, Format::rgba16f, Format::r11g11b10f, Format::rgbe})
        for (const int threads : {1, 3}) {
            Image4 image(size.x, size.y);
            for (glm::vec4& v : image.texels)
                for (int c = 0; c < 4; ++c) v[c] = float(random.between(-2, 7) * std::exp2(random.between(-20, 12)));
            image(5, 5) = {INFINITY, NAN, -INFINITY, -0.0f};
            const Image4 before = image;
            CHECK_FALSE(quantise(format, image, threads));
            for (std::size_t i = 0; i < image.size(); ++i) {
                glm::vec4 expected = before.texels[i];
                if (format != Format::rgba32f) quantise(format, expected);
                for (int c = 0; c < 4; ++c) REQUIRE(bits_of(image.texels[i][c]) == bits_of(expected[c]));
            }
            image = before;
            image(30, 33).z = 65519.99f;
            CHECK_FALSE(quantise(format, image, threads));
            if (format != Format::rgba16f) continue;
            CHECK(image(30, 33).z == 65504);
            image(31, 33).y = 65520, image(7, 33).x = -7e4f, image(9, 34).x = 1e9f;
            const std::optional<Overflow> found = quantise(format, image, threads);
            REQUIRE(found);
            CHECK(found->pixel == glm::ivec2(7, 33));
            CHECK(found->value == -7e4f);
        }
    std::vector<float> values{0, 1, 3 / 16.0f, 1 / 9.0f, 1 / 3.0f, 65520}, same = values;
    CHECK_FALSE(quantise(Format::r32f, same.data(), {2, 3}, 1));
    CHECK(same == values);
    const std::optional<Overflow> found = quantise(Format::r16f, values.data(), {2, 3}, 1);
    REQUIRE(found);
    CHECK(found->pixel == glm::ivec2(1, 2));
    CHECK(values == std::vector<float>{0, 1, 3 / 16.0f, 1820 * 0x1p-14f, 1365 * 0x1p-12f, INFINITY});
}

TEST_CASE("layout: names and contradictions", "[layout][errors]") {
    for (const Layout& l : layouts()) {
        CHECK(parse_layout(l.name, "") == l);
        CHECK_NOTHROW(validate(l, ""));
    }
    CHECK(parse_layout("custom", "").name == "custom");
    CHECK_THROWS_WITH(parse_layout("issr", "scene.toml: line 3"),
                      "scene.toml: line 3: layout = \"issr\": expected one of fp32, rgba16f, vrsm, isr, lra, custom");
    Layout l = custom();
    std::vector<Field> f = fields(l);
    set_field(find_field(f, "normal", "here"), std::string("octahedral16"), "here");
    set_field(find_field(f, "position_from_depth", "here"), true, "here");
    CHECK(l.normal == Format::octahedral16);
    CHECK(l.position_from_depth);
    CHECK_THROWS_WITH(set_field(find_field(f, "rsm_flux", "here"), std::string("rgb9e5"), "here"),
                      Catch::Contains("rsm_flux = \"rgb9e5\": expected one of r32f, rgba32f,"));
    CHECK_THROWS_WITH(find_field(f, "rsm_flx", "here"), Catch::Contains("'rsm_flux'"));
    l.position = Format::rgba8;
    CHECK_THROWS_WITH(validate(l, "here"),
                      "here: [layout] position = \"rgba8\" cannot hold it: expected one of rgba32f, rgba16f");
    l.position = Format::rgba32f, l.depth_from_position = true;
    CHECK_THROWS_WITH(validate(l, "here"), Catch::Contains("one of them must be stored"));
    l.depth_from_position = false, l.radiation_mask = true, l.albedo = Format::rgbe;
    CHECK_THROWS_WITH(validate(l, "here"), Catch::Contains("has no alpha"));
    l = Layout::isr;
    l.normal = Format::rgba16f;
    CHECK_THROWS_WITH(validate(l, "here"), Catch::Contains("\"isr\" is a preset"));
    l = custom(), l.indirect = Format::rgba8;
    CHECK_THROWS_WITH(validate(l, "here"),
                      "here: [layout] indirect = \"rgba8\" cannot hold it: expected one of rgba32f, rgba16f");
    l = custom(), l.visibility = Format::rgba16f;
    CHECK_THROWS_WITH(validate(l, "here"),
                      "here: [layout] visibility = \"rgba16f\" cannot hold it: expected one of r32f, r16f");
    CHECK(Layout::vrsm.half_records());
    CHECK(!Layout::lra.half_records());  // its depth is no half
}

TEST_CASE("gbuffer: buffers that nobody wants are not written; those of the right size are kept", "[raster][gbuffer]") {
    const Drawn d;
    const GBuffer all = d.draw(Layout::rgba16f);
    for (int mask = 0; mask < 32; ++mask) {
        GBufferWants wants;
        wants.position = mask & 1, wants.normal = mask & 2, wants.albedo = mask & 4, wants.emission = mask & 8;
        wants.id = mask & 16;
        CAPTURE(mask);
        const GBuffer out = d.draw(Layout::rgba16f, {}, wants);
        CHECK((wants.position ? same(out.position, all.position) : out.position.empty()));
        CHECK((wants.normal ? same(out.normal, all.normal) : out.normal.empty()));
        CHECK((wants.albedo ? same(out.albedo, all.albedo) : out.albedo.empty()));
        CHECK((wants.emission ? same(out.emission, all.emission) : out.emission.empty()));
        CHECK((wants.id ? out.id.texels == all.id.texels : out.id.empty()));
        CHECK(out.depth.texels == all.depth.texels);
    }
    // A buffer that holds another picture becomes this one, in the same memory; empty pixels are cleared.
    GBuffer reused;
    Drawn other = d;
    other.camera.position = {0.5, 0.3, -3};
    other.draw_into(reused, Layout::fp32);
    const void* memory[] = {reused.position.data(), reused.normal.data(), reused.albedo.data(), reused.emission.data(),
                            reused.id.data()};
    d.draw_into(reused, Layout::rgba16f);
    CHECK(same(reused, all));
    const void* now[] = {reused.position.data(), reused.normal.data(), reused.albedo.data(), reused.emission.data(),
                         reused.id.data()};
    CHECK(std::equal(std::begin(memory), std::end(memory), std::begin(now)));
}
