// Rough reflections: rays of Phong's lobe, what they weigh, and what a frame shows by them.
#include <catch2/catch.hpp>
#include <cmath>

#include "core/hash.h"
#include "gi/frame/kept.h"
#include "gi/frame/reflect_classes.h"
#include "gi/reference/bsdf_kernel.h"
#include "gi/screen/screen.h"
#include "tests/gi/open_room.h"

using namespace plumb;
using test::has;
using test::render;
using test::same;

namespace {

using screen::Lobe;
using screen::LobeInputs;
using screen::March;

constexpr double pi = 3.14159265358979;

screen::ReflectParams lobed(int rays, March march = March::steps) {
    screen::ReflectParams params;
    params.march = march, params.lobe = Lobe::phong, params.rays = rays;
    return params;
}

// Points at the origin, seen from `eye`, all of one lobe and no mirror.
struct Points {
    Image4 position, normal, mirror, lobe;
    LobeInputs in;
    Points(glm::ivec2 size, const glm::vec3& n, const glm::dvec3& eye, float exponent)
        : position(size.x, size.y), normal(size.x, size.y, glm::vec4(n, 1)), mirror(size.x, size.y),
          lobe(size.x, size.y, glm::vec4(0.5f, 0.25f, 0.125f, exponent)) {
        in = {&position, &normal, &mirror, &lobe, eye, 7};
    }
};

glm::dvec3 unit(const glm::dvec3& v) { return v / std::sqrt(glm::dot(v, v)); }

// A mirror or a lobe on the floor, before a wall that sends M = (3, 2, 1) W/m2 and is seen wholly.
Scene before_wall(const glm::vec3& mirror, const glm::vec3& specular, float exponent) {
    Scene s;
    s.name = "wall";
    s.materials.resize(2);
    s.materials[0].reflectance = glm::vec3(0), s.materials[0].emission = {3, 2, 1};
    s.materials[1].reflectance = glm::vec3(0), s.materials[1].mirror = mirror;
    s.materials[1].specular = specular, s.materials[1].exponent = exponent;
    Mesh& m = s.meshes.emplace_back();
    moving::add_quad(m, {-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, 1);
    moving::add_quad(m, {-1, 0, -1}, {2, 0, 0}, {0, 1, 0}, 0);
    s.camera.position = {0.2, 1, 3}, s.camera.look_at = {0, 0.4, -1}, s.camera.up = {0, 1, 0};
    s.camera.near = 0.1, s.camera.far = 20, s.frame_size = {96, 80};
    return s;
}

frame::Settings rough(int rays, March march = March::steps) {
    frame::Settings settings;
    settings.method = frame::Method::direct;
    settings.reflect = lobed(rays, march);
    settings.reflect.step = 0.05f, settings.reflect.steps = 96, settings.reflect.bias = 1e-3f;
    settings.reference.rays = Rays::exact;
    return settings;
}

// The pixel of ray j in a sheet, from that of the picture.
glm::ivec2 in_sheet(glm::ivec2 picture, int rays, int j, int x, int y) {
    const int across = screen::sheet_across(1 + rays);
    return {x + j % across * picture.x, y + j / across * picture.y};
}

}  // namespace

TEST_CASE("reflect: a lobe's rays are those that the path tracer draws", "[screen][reflect][lobe][analytic]") {
    const float exponent = GENERATE(0.0f, 1.0f, 60.0f, 1e4f, 1e6f);
    const glm::vec3 n = glm::vec3(unit({0.2, 0.9, -0.1}));
    const Points points({5, 4}, n, {0.4, 2, 1.5}, exponent);
    const int rays = 20;
    Image4 made;
    run(lobed(rays), points.in, {}, made);
    CHECK(made.width == 25);
    CHECK(made.height == 20);
    const glm::dvec3 normal(n), w_o = unit({0.4, 2, 1.5});
    double off = 0, off_weight = 0;
    int below = 0;
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 5; ++x) {
            CHECK(made(x, y) == glm::vec4(0));  // no mirror
            for (int j = 1; j < 25; ++j) {
                const glm::ivec2 at = in_sheet({5, 4}, rays, j, x, y);
                const glm::vec4 ray = made(at.x, at.y);
                if (j > rays) {
                    CHECK(ray == glm::vec4(0));
                    continue;
                }
                const Hash3<std::int32_t> h = pixel_hash<std::int32_t>(x, y, j, 7);
                const vec3<double> r = reference::mirrored<double>({normal.x, normal.y, normal.z}, {w_o.x, w_o.y, w_o.z});
                const vec3<double> d = reference::to_world(reference::basis_of(r), reference::cosine_power<double>(
                    unit_float<double>(h.x), unit_float<double>(h.y), double(exponent)));
                const double cosine = d.x * normal.x + d.y * normal.y + d.z * normal.z;
                if (cosine <= 0) {
                    ++below;
                    CHECK(ray == glm::vec4(0));
                    continue;
                }
                off = std::max({off, std::abs(ray.x - d.x), std::abs(ray.y - d.y), std::abs(ray.z - d.z)});
                off_weight = std::max(off_weight, std::abs(double(ray.w) - (exponent + 2.0) / (exponent + 1.0) * cosine));
                // What the path tracer's own sample weighs, of a reflectance of 1.
                const reference::Bsdf<double> bsdf{{0, 0, 0}, {1, 1, 1}, double(exponent), {0, 0, 0}};
                const auto s = reference::sample<double>(bsdf, {normal.x, normal.y, normal.z}, {w_o.x, w_o.y, w_o.z}, 0.5,
                                                         unit_float<double>(h.x), unit_float<double>(h.y));
                CHECK(double(ray.w) == Approx(s.weight.x).epsilon(1e-5).margin(2e-6));
            }
        }
    CHECK(off < 4e-7);
    CHECK(off_weight < 2e-6);
    CHECK((exponent > 1 || below > 20));
}

TEST_CASE("reflect: at normal incidence a lobe reflects all of its reflectance", "[screen][reflect][lobe][analytic]") {
    // w = (n + 2)/(n + 1) cos has mean 1 and variance 1 / ((n + 1) (n + 3)) over the lobe.
    for (const float exponent : {0.0f, 3.0f, 60.0f, 1000.0f}) {
        const Points points({32, 32}, {0, 0, 1}, {0, 0, 2}, exponent);
        Image4 made;
        run(lobed(64), points.in, {}, made);
        double sum = 0, of_squares = 0;
        int rays = 0;
        for (int j = 1; j <= 64; ++j)
            for (int y = 0; y < 32; ++y)
                for (int x = 0; x < 32; ++x) {
                    const glm::ivec2 at = in_sheet({32, 32}, 64, j, x, y);
                    const double w = made(at.x, at.y).w;
                    sum += w, of_squares += w * w, ++rays;
                }
        const double mean = sum / rays, variance = 1 / ((exponent + 1.0) * (exponent + 3.0));
        CAPTURE(exponent);
        CHECK(std::abs(mean - 1) < 4 * std::sqrt(variance / rays) + 1e-6);
        CHECK(of_squares / rays - mean * mean == Approx(variance).epsilon(0.05));
    }
}

TEST_CASE("reflect: a lobe of a huge exponent is the mirror times its cosine", "[frame][reflect][lobe][analytic]") {
    const March march = GENERATE(March::steps, March::hierarchical);
    const glm::vec3 k(0.75f, 0.5f, 0.25f);
    const Scene mirror = before_wall(k, glm::vec3(0), 50), lobe = before_wall(glm::vec3(0), k, 1e6f);
    const frame::Frame a = render(mirror, rough(4, march)), b = render(lobe, rough(4, march));
    int asked = 0, met = 0;
    for (int y = 0; y < 80; ++y)
        for (int x = 0; x < 96; ++x) {
            // Not at outlines: where neighbours all show the wall, or none does.
            bool inside = a.reflect.mirror(x, y).w > 0;
            const bool shows = a.reflect.reflection(x, y).w > 0;
            for (int v = -2; v <= 2 && inside; ++v)
                for (int u = -2; u <= 2 && inside; ++u)
                    inside = x + u >= 0 && y + v >= 0 && x + u < 96 && y + v < 80 && (a.reflect.reflection(x + u, y + v).w > 0) == shows;
            if (!inside) continue;
            ++asked, met += shows;
            const glm::dvec3 v = unit(glm::dvec3(a.gbuffer.position(x, y)) - mirror.camera.position);
            // A ray is some 1e-3 from the mirrored one, and so is its cosine; of four a quarter is the noise.
            for (int c = 0; c < 3; ++c)
                CHECK(double(b.reflect.reflection(x, y)[c]) == Approx(-v.y * double(a.reflect.reflection(x, y)[c])).margin(3e-3 * k[c]));
        }
    CHECK(met > 500);
    CHECK(asked > met + 100);
    // The mirror's own pictures do not change with lobes on.
    frame::Settings off = rough(4, march);
    off.reflect.lobe = Lobe::off;
    CHECK(same(render(mirror, off).reflect.reflection, a.reflect.reflection));
}

TEST_CASE("reflect: rough reflections of what is seen are those of the path tracer", "[frame][reflect][lobe][truth][analytic]") {
    const March march = GENERATE(March::steps, March::hierarchical);
    Scene scene = before_wall(glm::vec3(0), {0.75f, 0.5f, 0.25f}, 20);
    scene.frame_size = {72, 60};
    frame::Settings settings = rough(64, march);
    settings.truth = true, settings.reference.samples = 16, settings.reference.rounds = 4;
    const frame::Frame f = render(scene, settings);
    const frame::Traced* truth = frame::find_traced(f, "truth.reflection");
    REQUIRE(truth);
    double ours = 0, theirs = 0, variance = 0;
    int pixels = 0;
    for (int y = 0; y < 60; ++y)
        for (int x = 0; x < 72; ++x) {
            if (f.reflect.lobe(x, y).x == 0 || f.gbuffer.position(x, y).z < -0.9f) continue;  // contacts are lost
            double sum = 0, squares = 0;
            for (int j = 1; j <= 64; ++j) {
                const glm::ivec2 at = in_sheet(scene.frame_size, 64, j, x, y);
                const double w = f.reflect.hits.back()(at.x, at.y).w > 0 ? double(f.reflect.rays(at.x, at.y).w) : 0;
                sum += w, squares += w * w;
            }
            const double l = 0.75 * 3 / pi, mean = sum / 64;
            CHECK(double(f.reflect.reflection(x, y).x) == Approx(l * mean).epsilon(1e-5));
            const double error = truth->estimate.error(x, y).x;
            variance += error * error + l * l * (squares / 64 - mean * mean) / 63;
            ours += f.reflect.reflection(x, y).x, theirs += truth->estimate.mean(x, y).x, ++pixels;
        }
    CAPTURE(int(march), pixels, ours / pixels, theirs / pixels, std::sqrt(variance) / pixels);
    CHECK(pixels > 700);
    CHECK(theirs / pixels > 0.05);
    // Beside noise: at the wall's outline half a texel of what is seen, of a wall of 25 texels.
    CHECK(std::abs(ours - theirs) < 4 * std::sqrt(variance) + 0.01 * theirs);
    for (const Isa isa : supported_isas()) {
        RunOptions options;
        options.isa = isa, options.threads = isa == Isa::scalar ? 1 : 3;
        const frame::Frame other = render(scene, settings, options);
        CHECK(same(other.reflect.reflection, f.reflect.reflection));
        CHECK(same(frame::find_traced(other, "truth.reflection")->estimate.mean, truth->estimate.mean));
    }
}

TEST_CASE("reflect: the truth of a lobe in a white enclosure is what the lobe reflects", "[frame][reflect][lobe][truth][analytic]") {
    // Within a closed box that sends L = M / pi from everywhere its floor shows k a L of it, a the integral of
    // (n + 2)/(2 pi) (r.w)^n N.w over the half sphere.
    Scene scene;
    scene.name = "enclosure", scene.frame_size = {24, 20}, scene.materials.resize(2);
    scene.materials[0].reflectance = glm::vec3(0), scene.materials[0].emission = glm::vec3(float(pi));
    scene.materials[1] = {}, scene.materials[1].reflectance = glm::vec3(0);
    scene.materials[1].specular = {0.75f, 0.5f, 0.25f}, scene.materials[1].exponent = 5;
    Mesh& m = scene.meshes.emplace_back();
    moving::add_quad(m, {-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, 1);
    moving::add_quad(m, {-1, 2, -1}, {2, 0, 0}, {0, 0, 2}, 0);
    moving::add_quad(m, {-1, 0, -1}, {2, 0, 0}, {0, 2, 0}, 0);
    moving::add_quad(m, {1, 0, 1}, {-2, 0, 0}, {0, 2, 0}, 0);
    moving::add_quad(m, {-1, 0, 1}, {0, 0, -2}, {0, 2, 0}, 0);
    moving::add_quad(m, {1, 0, -1}, {0, 0, 2}, {0, 2, 0}, 0);
    scene.camera.position = {0, 1.5, 0.9}, scene.camera.look_at = {0, 0, 0.35}, scene.camera.up = {0, 1, 0};
    scene.camera.fov_y_deg = 45, scene.camera.near = 0.05, scene.camera.far = 20;
    frame::Settings settings = rough(1);
    settings.truth = true, settings.reference.samples = 16, settings.reference.rounds = 16;
    const frame::Frame f = render(scene, settings);
    const frame::Traced* truth = frame::find_traced(f, "truth.reflection");
    REQUIRE(truth);
    double difference = 0, variance = 0, expected_sum = 0;
    int pixels = 0;
    for (int y = 0; y < 20; ++y)
        for (int x = 0; x < 24; ++x) {
            if (f.reflect.lobe(x, y).x == 0) continue;
            const glm::dvec3 v = unit(glm::dvec3(f.gbuffer.position(x, y)) - scene.camera.position), r(v.x, -v.y, v.z);
            double a = 0;
            const int steps = 96;
            for (int i = 0; i < steps; ++i)
                for (int k = 0; k < 4 * steps; ++k) {
                    const double cosine = (i + 0.5) / steps, sine = std::sqrt(1 - cosine * cosine), angle = 2 * pi * (k + 0.5) / (4 * steps);
                    const glm::dvec3 w(sine * std::cos(angle), cosine, sine * std::sin(angle));
                    a += 7 / (2 * pi) * std::pow(std::max(0.0, glm::dot(r, w)), 5) * cosine * (2 * pi / (steps * 4.0 * steps));
                }
            for (int c = 0; c < 3; ++c) {
                const double full = double(scene.materials[1].specular[c]) * a, error = truth->estimate.error(x, y)[c];
                CHECK(std::abs(truth->estimate.mean(x, y)[c] - full) < 7 * error + 1e-3 * full);
                if (c > 0) continue;  // channels share their rays
                difference += truth->estimate.mean(x, y)[c] - full, variance += error * error, expected_sum += full;
            }
            ++pixels;
        }
    CHECK(pixels > 150);
    CHECK(std::abs(difference) < 4 * std::sqrt(variance) + 2e-4 * expected_sum);
    CHECK(std::sqrt(variance) < 4e-3 * expected_sum);
    // Another key than mirrors' at the same points, and no lamp in it: they are no surfaces.
    scene.lights.push_back(moving::spot("lamp", {0, 1.9f, 0}, {0, -1, 0}, 50));
    const frame::Frame lit = render(scene, settings);
    CHECK(same(frame::find_traced(lit, "truth.reflection")->estimate.mean, truth->estimate.mean));
}

TEST_CASE("reflect: what a pixel shows is the sum over its rays, in every view", "[frame][reflect][lobe]") {
    Scene scene = test::open_room({1, 0.1f, 0.6f, 0.7, {48, 40}});
    scene.materials.resize(2);
    scene.materials[1].reflectance = glm::vec3(0.125f), scene.materials[1].mirror = {0.25f, 0.5f, 0.125f};
    scene.materials[1].specular = {0.5f, 0.25f, 0.125f}, scene.materials[1].exponent = 12;
    frame::Settings settings = rough(3);
    settings.reflect.views = screen::ReflectViews::lights, settings.reflect.layers = 1;
    const frame::Plan plan = frame::plan(scene, settings);
    CHECK(has(plan, "screen.lobe"));
    const frame::Frame f = frame::execute(scene, settings, plan, {});
    CHECK(f.reflect.hits.back().width == 96);
    CHECK(f.reflect.hits.back().height == 80);
    const frame::SourceView& met = f.views.back();
    std::array<int, 11> by_view{};
    for (int y = 0; y < 40; ++y)
        for (int x = 0; x < 48; ++x) {
            glm::dvec3 sum(0);
            for (int j = 0; j <= 3; ++j) {
                const glm::ivec2 at = in_sheet({48, 40}, 3, j, x, y);
                const glm::vec4 hit = f.reflect.hits.back()(at.x, at.y), ray = f.reflect.rays(at.x, at.y);
                if (ray.w == 0) CHECK(hit.w == 0);
                if (hit.w == 0) continue;
                ++by_view[std::size_t(hit.w)];
                const glm::dvec3 l = hit.w == 1 ? glm::dvec3(f.reflect.composed(int(hit.x), int(hit.y)))
                                                : (glm::dvec3(met.gbuffer.albedo(at.x, at.y)) * glm::dvec3(met.direct(at.x, at.y)) +
                                                   glm::dvec3(met.gbuffer.emission(at.x, at.y))) / pi;
                sum += l * (j == 0 ? glm::dvec3(f.reflect.mirror(x, y)) : glm::dvec3(f.reflect.lobe(x, y)) * (double(ray.w) / 3));
            }
            for (int c = 0; c < 3; ++c) CHECK(double(f.reflect.reflection(x, y)[c]) == Approx(sum[c]).epsilon(1e-5).margin(1e-9));
        }
    CHECK(by_view[1] > 300);
    CHECK(by_view[2] > 0);
    CHECK(by_view[3] + by_view[4] + by_view[5] > 20);
    // Other seeds have other rays, and the mirrors' stay.
    scene.seed = settings.seed = 3;
    const frame::Frame other = render(scene, settings);
    int differ = 0;
    for (int y = 0; y < 40; ++y)
        for (int x = 0; x < 48; ++x) {
            CHECK(other.reflect.rays(x, y) == f.reflect.rays(x, y));
            differ += other.reflect.rays(x + 48, y) != f.reflect.rays(x + 48, y);
        }
    CHECK(differ > 200);
}

TEST_CASE("reflect: frames that keep what they made draw another lobe where its material is another", "[frame][reflect][lobe][keys]") {
    Scene scene = before_wall(glm::vec3(0), glm::vec3(0.5f), 9);
    const frame::Settings settings = rough(4);
    frame::KeptStages kept;
    const auto shown = [&] { return frame::execute(scene, settings, frame::plan(scene, settings), {}, kept).reflect.reflection; };
    const Image4 first = shown();
    Material* rough_one = nullptr;
    for (Material& m : scene.materials)
        if (m.specular != glm::vec3(0)) rough_one = &m;
    REQUIRE(rough_one);
    rough_one->exponent = 40;
    const Image4 narrow = shown();
    CHECK(same(narrow, render(scene, settings).reflect.reflection));
    CHECK_FALSE(same(narrow, first));
    rough_one->specular = glm::vec3(0.25f);
    const Image4 dark = shown();
    CHECK(same(dark, render(scene, settings).reflect.reflection));
    CHECK_FALSE(same(dark, narrow));
    rough_one->mirror = glm::vec3(0.5f);
    CHECK(same(shown(), render(scene, settings).reflect.reflection));
}

TEST_CASE("reflect: what lobes are not asked of", "[frame][reflect][lobe][input]") {
    frame::Settings settings = rough(4);
    settings.reflect.variant = screen::ReflectVariant::published;
    CHECK_THROWS_WITH(frame::plan(before_wall(glm::vec3(0), glm::vec3(0.5f), 9), settings), Catch::Contains("lobe = phong"));
    // 3840 x 2160 x 81 numbers of four do not have indices.
    settings = rough(64);
    Scene large = before_wall(glm::vec3(0), glm::vec3(0.5f), 9);
    large.frame_size = {3840, 2160};
    CHECK_THROWS_WITH(frame::plan(large, settings), "reflect: rays = 64 at 3840 x 2160: a sheet of 597 million pixels: expected at most 268 million");
    // Without a lobe and a mirror nothing runs; with the lobe off a lobe is none.
    settings = rough(4);
    for (const frame::StageRun& s : render(before_wall(glm::vec3(0), glm::vec3(0), 9), settings).stages)
        if (s.label.starts_with("screen.")) CHECK(s.rule == "no-mirror");
    settings.reflect.lobe = Lobe::off;
    for (const frame::StageRun& s : render(before_wall(glm::vec3(0), glm::vec3(0.5f), 9), settings).stages)
        if (s.label.starts_with("screen.")) CHECK(s.rule == "no-mirror");
}
