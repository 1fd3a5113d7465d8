// The path tracer's sources of light, one at a time and all at once; what hides them; where a camera sees them; and
// what a run says of its own error. Each expected number is a closed form or follows from the images themselves.
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "core/host_math.h"
#include "gi/reference/closed_form_scenes.h"
#include "gi/reference/light_kernel.h"
#include "gi/reference/reference.h"
#include "raster/gbuffer.h"

using namespace plumb;
using namespace plumb::reference;

namespace {

struct Found {
    double value = 0, error = 0;  // mean over the points, and its standard error
};

PathParams with(Mode mode, int samples) {
    PathParams p;
    p.mode = mode, p.samples = samples;
    return p;
}

// At one point that looks up: 16 independent estimates of 1024 paths each.
Found looking_up(const Scene& scene, Mode mode = Mode::direct, const glm::dvec3& at = {0, 0, 0},
                 PathParams params = with(Mode::all, 1024)) {
    const ReceiverPoints point = repeated(at, {0, 1, 0}, 16 * 256);
    params.mode = mode;
    const Estimate e = trace_irradiance(params, *prepare(scene, Rays::native), {&point.position, &point.normal}, 5, {});
    REQUIRE(e.nonfinite == 0);
    Found f;
    for (std::size_t i = 0; i < e.mean.size(); ++i)
        f.value += e.mean.texels[i].x, f.error += double(e.error.texels[i].x) * e.error.texels[i].x;
    const auto n = double(e.mean.size());
    return {f.value / n, std::sqrt(f.error) / n};
}

// Within 4 standard errors, which have to be small enough for that to say something.
void check_equal(const Found& got, double want, double want_error = 0, double precision = 0.004) {
    CAPTURE(got.value, got.error, want, want_error);
    CHECK(got.error < precision * want);
    CHECK(want_error < precision * want);
    CHECK(std::abs(got.value - want) < 4 * std::sqrt(got.error * got.error + want_error * want_error) + 1e-5 * want);
}

// White in its right half (u above 1/2), `left` in the other.
Texture halves(std::uint32_t left) {
    Texture t;
    t.texels = Image<std::uint32_t>(2, 1, 0xffffffffu);
    t.texels(0, 0) = left;
    t.filter = plumb::Filter::nearest, t.wrap_u = t.wrap_v = Wrap::clamp_to_edge;
    return t;
}

// The last mesh's u runs from 0 at x = -1 to 1 at x = 1, and v with z.
void unfold(Scene& scene) {
    for (Vertex& v : scene.meshes.back().vertices)
        v.u = (v.position.x + 1) / 2, v.v = (v.position.z + 1) / 2;
}

// A camera that looks along -z at the plane z = 0, of which its frame shows x and y from -1 to 1.
Camera facing_the_plane() {
    Camera c;
    c.position = {0, 0, 1}, c.look_at = {0, 0, 0}, c.fov_y_deg = 90;
    return c;
}

// A plate of 2 cm so far from the origin (4096 m) that rays start 8 mm off it and may pass by its edge to what is
// behind. Its shading normals lean 45 degrees towards +x. With a camera that sees nothing but the plate, from above.
constexpr double far_away = 4096;
Scene leaning_plate() {
    Scene scene;
    add_rectangle(scene, grey(0.8), {far_away - 0.01, 0, -0.01}, {far_away + 0.01, 0, 0.01});
    const float half = float(std::sqrt(0.5));
    for (Vertex& v : scene.meshes.back().vertices) v.normal = {half, half, 0};
    scene.camera.position = {far_away, 1, 0}, scene.camera.look_at = {far_away, 0, 0}, scene.camera.up = {0, 0, 1};
    scene.camera.fov_y_deg = 0.5;
    return scene;
}

Estimate frame_of(const Scene& scene, const PathParams& params, glm::ivec2 size) {
    return trace(params, *prepare(scene, params.rays), scene.camera, size, 7, {});
}

double brightest(const Estimate& e) {
    double b = 0;
    for (const glm::vec4& v : e.mean.texels)
        for (int c = 0; c < 3; ++c) b = std::max(b, double(v[c]));
    return b;
}

}  // namespace

TEST_CASE("path lights: a lamp, an emitter and the environment add up to their closed forms",
          "[reference][lights][analytic]") {
    // A square of side 2 one metre above the point: factor F = 4 to_parallel_rectangle(1, 1, 1). What it does not cover
    // shows the environment: M F + pi L (1 - F). The lamp beside it: I cos(theta) / d^2.
    const double factor = 4 * to_parallel_rectangle(1, 1, 1);
    for (const double sky : {0.05, 0.5, 5.0}) {
        Scene scene;
        add_rectangle(scene, grey(0, 2), {-1, 1, -1}, {1, 1, 1});
        scene.lights.push_back(point_lamp({1.5, 0.5, 0}, 4 * host::pi));
        scene.environment.radiance = glm::vec3(float(sky));
        const double lamp = 0.5 / std::pow(2.5, 1.5);
        CAPTURE(sky);
        check_equal(looking_up(scene), 2 * factor + host::pi * sky * (1 - factor) + lamp);
    }
}

TEST_CASE("path lights: light of all sources is the sum of each one's", "[reference][lights]") {
    // Two walls and a floor that reflect; an environment whose map has one bright patch.
    Scene all;
    add_rectangle(all, grey(0.7), {-1, -0.01, -1}, {1, -0.01, 1});
    add_rectangle(all, grey(0.6), {-1, 0, -1}, {-1, 2, 1});
    add_rectangle(all, grey(0.5), {-1, 0, -1}, {1, 2, -1});
    add_rectangle(all, grey(0.1, 3), {-0.5, 1.5, -0.5}, {0.5, 1.5, 0.5});
    const std::size_t emitter = all.materials.size() - 1;
    all.lights.push_back(point_lamp({0.7, 1.2, 0.6}, 6));
    Light sun;
    sun.type = LightType::directional, sun.intensity = glm::vec3(0.4f), sun.direction = {-0.6f, -0.8f, 0};
    all.lights.push_back(sun);
    all.environment.radiance = glm::vec3(0.5f);
    all.environment.map = Image4(8, 4, glm::vec4(0.2f, 0.2f, 0.2f, 0));
    for (int x = 4; x < 6; ++x) all.environment.map(x, 1) = glm::vec4(4, 4, 4, 0);

    Scene dark = all;
    dark.lights.clear();
    dark.environment = {};
    dark.materials[emitter].emission = glm::vec3(0);
    std::vector<Scene> single(4, dark);
    single[0].lights = {all.lights[0]};
    single[1].lights = {all.lights[1]};
    single[2].materials[emitter] = all.materials[emitter];
    single[3].environment = all.environment;
    for (Mode mode : {Mode::direct, Mode::all}) {
        double sum = 0, variance = 0;
        for (const Scene& one : single) {
            const Found f = looking_up(one, mode, {0.2, 0, 0.3});
            CHECK(f.value > 0.1);
            sum += f.value, variance += f.error * f.error;
        }
        CAPTURE(int(mode));
        check_equal(looking_up(all, mode, {0.2, 0, 0.3}), sum, std::sqrt(variance), 0.01);
    }
}

TEST_CASE("path lights: half an emitter shines as half an emitter", "[reference][lights][analytic]") {
    const double half = 2 * to_parallel_rectangle(1, 1, 1);
    Scene masked;
    masked.textures = {halves(0x00ffffffu)};
    Material m = grey(0, 2);
    m.texture = 0, m.alpha_cutoff = 0.5f;
    add_rectangle(masked, m, {-1, 1, -1}, {1, 1, 1});
    unfold(masked);
    check_equal(looking_up(masked), 2 * half);
    // Through the hole a lamp is seen, through what is left it is not.
    masked.lights = {point_lamp({-0.5, 2, 0}, 4 * host::pi)};
    check_equal(looking_up(masked), 2 * half + 2 / std::pow(4.25, 1.5));
    masked.lights = {point_lamp({0.5, 2, 0}, 4 * host::pi)};
    check_equal(looking_up(masked), 2 * half);

    Scene black;
    black.textures = {halves(0xff000000u)};
    m = grey(0, 2);
    m.emission_texture = 0;
    add_rectangle(black, m, {-1, 1, -1}, {1, 1, 1});
    unfold(black);
    check_equal(looking_up(black), 2 * half);
}

TEST_CASE("path lights: an emitter is chosen by the mean of its texture", "[reference][lights]") {
    // The same table as that of an emitter without texture whose emission is the mean.
    auto table = [](std::uint32_t texel, bool srgb, double emission) {
        Scene scene;
        add_rectangle(scene, grey(0, 1), {-1, 1, -1}, {1, 1, 1});
        scene.textures = {halves(texel)};
        scene.textures[0].srgb = srgb;
        Material m = grey(0, emission);
        m.emission_texture = texel ? 0 : -1;
        add_rectangle(scene, m, {-1, 2, -1}, {1, 2, 1});
        const Geometry geometry = flatten(scene);
        return light_table(scene, geometry, raster::prepare(scene, geometry), environment_table(scene.environment));
    };
    const double decoded = std::pow((0.5 + 0.055) / 1.055, 2.4);  // IEC 61966-2-1, of nearly 1/2
    struct Case {
        std::uint32_t texel;
        bool srgb;
        double mean;
    };
    for (const Case& c : {Case{0xff000000u, true, 0.5}, {0xff808080u, false, (1 + 128 / 255.0) / 2},
                          {0xff808080u, true, (1 + decoded) / 2}}) {
        const LightTable textured = table(c.texel, c.srgb, 5), plain = table(0, false, 5 * c.mean);
        REQUIRE(textured.count == 4);
        for (std::size_t i = 0; i <= 4; ++i) {
            CAPTURE(c.texel, c.srgb, i);
            CHECK(textured.cdf[i] == Approx(plain.cdf[i]).margin(0.001));
        }
        for (std::size_t t = 0; t < 4; ++t)
            CHECK(textured.triangle_pdf[t] == Approx(plain.triangle_pdf[t]).epsilon(0.005));
    }
    CHECK(table(0, false, 5).cdf[2] < table(0, false, 2.5).cdf[2] - 0.02f);  // or else the above says nothing
}

TEST_CASE("path lights: no light comes through the face, wherever the normals lean", "[reference][lights]") {
    // 10 degrees below the face, but 35 degrees above the horizon of the shading normal.
    Scene sun = leaning_plate();
    sun.lights.emplace_back();
    sun.lights[0].type = LightType::directional;
    sun.lights[0].direction = {-0.98480775f, 0.17364818f, 0};
    CHECK(brightest(frame_of(sun, with(Mode::all, 16), {8, 8})) == 0);
    sun.lights[0].direction.y *= -1;
    CHECK(brightest(frame_of(sun, with(Mode::all, 16), {8, 8})) ==
          Approx(0.8 / host::pi * (0.98480775 + 0.17364818) * std::sqrt(0.5)).epsilon(1e-4));

    // An emitter: found by a point on it, or by a scattered direction.
    for (const double y : {-0.5, 0.5}) {
        Scene scene = leaning_plate();
        add_rectangle(scene, grey(0, 5), {far_away - 20, 2.5 * y, -20}, {far_away + 20, 2.5 * y, 20});
        const double b = brightest(frame_of(scene, with(Mode::all, 256), {8, 8}));
        if (y < 0) CHECK(b == 0);
        if (y > 0) CHECK(b > 0.5);
    }

    // Openness: of the cosine-weighted hemisphere about a normal that leans by theta, (1 + cos theta)/2 are above the
    // face.
    const Estimate open = frame_of(leaning_plate(), with(Mode::ambient_occlusion, 256), {16, 16});
    double mean = 0, variance = 0;
    for (std::size_t i = 0; i < 256; ++i)
        mean += open.mean.texels[i].x / 256.0, variance += std::pow(double(open.error.texels[i].x) / 256, 2);
    check_equal({mean, std::sqrt(variance)}, (1 + std::sqrt(0.5)) / 2);
}

TEST_CASE("path lights: what is hidden closely is hidden", "[reference][lights]") {
    // Coordinates reach 1 m: rays start 2^-19 m off the surface, and a point on an emitter lies as far off it.
    const double offset = 0x1p-19;
    auto scene_of = [](double plate, bool emitter, double extent) {
        Scene scene;
        add_rectangle(scene, grey(0.5), {-1, 0, -1}, {1, 0, 1});
        if (emitter) add_rectangle(scene, grey(0, 3), {-0.1, 1, -0.1}, {0.1, 1, 0.1});
        else scene.lights.push_back(point_lamp({0, 1, 0}, 10));
        add_rectangle(scene, grey(0), {-extent, plate, -extent}, {extent, plate, extent});
        return scene;
    };
    for (const bool emitter : {false, true}) {
        const Found free = looking_up(scene_of(-0.5, emitter, 0.5));
        CHECK(free.value > 0.02);
        for (const double plate : {1.5 * offset, 0.001, 0.5, 0.995, emitter ? 1 - 1.5 * offset : 0.99999}) {
            CAPTURE(emitter, plate);
            CHECK(looking_up(scene_of(plate, emitter, 0.5)).value == 0);
        }
        // Above the light, and where the point itself lies on top.
        check_equal(looking_up(scene_of(1.005, emitter, 0.5)), free.value, free.error, 0.01);
        const Found above = looking_up(scene_of(-0.5, emitter, 0.5), Mode::direct, {0, 0.001, 0});
        check_equal(looking_up(scene_of(0.001, emitter, 0.5), Mode::direct, {0, 0.001, 0}), above.value, above.error,
                    0.01);

        // The same of a surface that a camera sees: from between it and the plate.
        Scene seen = scene_of(1.5 * offset, emitter, 0.5);
        seen.camera.position = {0, 0.5 * offset, 0}, seen.camera.look_at = {0, 0, 0}, seen.camera.up = {0, 0, 1};
        CHECK(brightest(frame_of(seen, with(Mode::direct, 64), {8, 8})) == 0);
    }
}

TEST_CASE("path lights: openness ends at ao_distance", "[reference][analytic]") {
    // In the middle of a sphere everything is equally far, but for 0.1 % that the flat triangles make.
    PathParams params = with(Mode::all, 64);
    params.ao_distance = 2;
    for (const double distance : {1.99, 2.01}) {
        Scene scene;
        add_sphere(scene, grey(0.5), {0, 0, 0}, distance, 4);
        const Found open = looking_up(scene, Mode::ambient_occlusion, {0, 0, 0}, params);
        CAPTURE(distance);
        CHECK(open.value == (distance < 2 ? 0 : 1));
    }
}

TEST_CASE("path lights: the standard error is that of the rounds' mean", "[reference]") {
    // One sample a round, which is 0 or L: of R rounds of which a share p saw L, the squared distances from the mean
    // sum to R p (1 - p) L^2, and the standard error of the mean is L sqrt(p (1 - p) / (R - 1)).
    Scene scene;
    Material m = grey(0);
    m.emission = {1, 2, 4};
    add_rectangle(scene, m, {-0.2, -0.3, 0}, {0.6, 0.7, 0});
    scene.camera = facing_the_plane();
    for (int rounds : {2, 4, 7}) {
        PathParams params = with(Mode::all, rounds);
        params.rounds = rounds, params.filter = reference::Filter::box;
        const Estimate e = frame_of(scene, params, {5, 5});
        REQUIRE(e.rounds == rounds);
        REQUIRE(e.samples == rounds);
        double squares = 0, total = 0;
        int noisy = 0;
        for (std::size_t i = 0; i < e.mean.size(); ++i)
            for (int c = 0; c < 3; ++c) {
                const double light = m.emission[c] / host::pi, p = e.mean.texels[i][c] / light;
                const double want = light * std::sqrt(std::max(p * (1 - p), 0.0) / (rounds - 1));
                CHECK(p * rounds == Approx(std::floor(p * rounds + 0.5)).margin(1e-5));
                CHECK(e.error.texels[i][c] == Approx(want).margin(1e-3 * light));
                squares += double(e.error.texels[i][c]) * e.error.texels[i][c], total += e.mean.texels[i][c];
                noisy += want > 0.1 * light;
            }
        CHECK(noisy >= 3);
        CHECK(e.relative_error == Approx(std::sqrt(squares / 75) / (total / 75)).epsilon(1e-5));
    }
}

TEST_CASE("path lights: a box filter takes a pixel's share, its centre all or nothing", "[reference][analytic]") {
    // Pixels of side 1/2; the third column is x from 0 to 1/2, the second row y from 0 to 1/2.
    for (const double edge : {0.24, 0.26}) {
        for (const bool upright : {false, true}) {
            Scene scene;
            const glm::dvec3 low = upright ? glm::dvec3(edge, -2, 0) : glm::dvec3(-2, edge, 0);
            add_rectangle(scene, grey(0, host::pi), low, {2, 2, 0});
            scene.camera = facing_the_plane();
            PathParams params = with(Mode::all, 1024);
            const Estimate centre = frame_of(scene, params, {4, 4});
            params.filter = reference::Filter::box;
            const Estimate box = frame_of(scene, params, {4, 4});
            for (int k = 0; k < 4; ++k) {
                CAPTURE(edge, upright, k);
                const int x = upright ? 2 : k, y = upright ? k : 1;
                CHECK(centre.mean(x, y).x == Approx(edge < 0.25 ? 1 : 0).margin(1e-5));
                check_equal({box.mean(x, y).x, box.error(x, y).x}, (0.5 - edge) / 0.5, 0, 0.02);
                // One pixel over, all; one before, nothing.
                CHECK(box.mean(upright ? 3 : k, upright ? k : 0).x == Approx(1));
                CHECK(box.mean(upright ? 1 : k, upright ? k : 2).x == 0);
            }
        }
    }
}

TEST_CASE("path lights: a camera's pixels are the rasterizer's", "[reference]") {
    // A leaning wall of 31 x 23 tiles, each of its own emission: what tile a pixel's centre shows is known by colour.
    Scene scene;
    const int columns = 31, rows = 23;
    auto corner = [&](int i, int j) {
        const double x = 6.0 * i / columns - 3, y = 5.0 * j / rows - 2.5;
        return glm::dvec3(x, y, 0.3 * x - 0.2 * y);
    };
    for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i) {
            Material m = grey(0);
            m.emission = {float(1 + i), float(1 + j), 1};
            add_quad(scene, m, corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1));
        }
    scene.camera.position = {0.31, -0.17, 4.3}, scene.camera.look_at = {0.05, 0.11, 0}, scene.camera.up = {0.07, 1, 0};
    scene.camera.fov_y_deg = 41;
    const auto prepared = prepare(scene, Rays::native);
    for (const glm::ivec2 size : {glm::ivec2(64, 48), glm::ivec2(48, 63)}) {
        raster::GBuffer g;
        raster::draw_gbuffer(prepared->geometry, prepared->surfaces,
                             make_view(scene.camera, double(size.x) / size.y), size, raster::Layout::fp32, {}, g);
        const Estimate e = trace(with(Mode::direct, 2), *prepared, scene.camera, size, 1, {});
        int off = 0, seen = 0;
        for (std::size_t i = 0; i < e.mean.size(); ++i) {
            const glm::dvec3 difference = glm::dvec3(e.mean.texels[i]) * host::pi - glm::dvec3(g.emission.texels[i]);
            off += !(std::abs(difference.x) + std::abs(difference.y) + std::abs(difference.z) < 1e-3);
            seen += g.id.texels[i].x >= 0;
        }
        // The rasterizer rounds corners to its subpixels: few centres lie so close to an edge.
        CAPTURE(size.x, size.y, seen);
        CHECK(off <= 2);
        CHECK(seen > 3000);
    }
}

TEST_CASE("path lights: every value that is not finite is counted", "[reference]") {
    auto count = [](const Estimate& e, bool infinite) {
        std::size_t n = 0;
        for (std::size_t i = 0; i < e.mean.size(); ++i)
            for (int c = 0; c < 3; ++c) {
                const float mean = e.mean.texels[i][c], error = e.error.texels[i][c];
                n += infinite ? std::isinf(mean) : !(std::isfinite(mean) && std::isfinite(error));
            }
        return n;
    };
    // Points below a lamp by 1 m and by 0.8 m, where 3e38 / d^2 W/m2 is within a float and beyond; one in the lamp; and
    // one whose y is nowhere.
    Scene scene;
    scene.lights.push_back(point_lamp({0, 1, 0}, 1));
    scene.lights[0].intensity = glm::vec3(3e38f, 1, 0);
    Image4 position(4, 1), normal(4, 1, glm::vec4(0, 1, 0, 0));
    position(1, 0) = {0, 0.2f, 0, 0};
    position(2, 0) = {0, 1, 0, 0};
    position(3, 0) = {0, std::nanf(""), 0, 0};
    const Estimate e =
        trace_irradiance(with(Mode::direct, 16), *prepare(scene, Rays::native), {&position, &normal}, 1, {});
    CHECK(e.mean(0, 0).x == Approx(3e38));
    CHECK(!std::isfinite(e.mean(1, 0).x));
    CHECK(!std::isfinite(e.mean(3, 0).y));
    CHECK(e.mean(1, 0).z == 0);
    CHECK(e.nonfinite == count(e, false));

    // Two lamps of equal power, each chosen with 1/2: the nearer one's light over 1/2 is beyond a float. Of two samples
    // it is the last that finds it, where the mean is infinite; the first or both, and the mean is no number.
    scene.lights = {scene.lights[0], scene.lights[0]};
    scene.lights[0].intensity = scene.lights[1].intensity = glm::vec3(2e38f);
    scene.lights[1].position.y = 2;
    PathParams params = with(Mode::direct, 2);
    params.rounds = 2;
    const Image4 same(16, 4), up(16, 4, glm::vec4(0, 1, 0, 0));
    const Estimate mixed = trace_irradiance(params, *prepare(scene, Rays::native), {&same, &up}, 1, {});
    CHECK(count(mixed, true) > 15);
    CHECK(count(mixed, false) > count(mixed, true) + 45);
    CHECK(count(mixed, false) < 3 * 64 - 15);
    CHECK(mixed.nonfinite == count(mixed, false));

    // Sums that are within a float, of which pi times as much is not: an environment, met by chance.
    scene.lights.clear();
    scene.environment.radiance = glm::vec3(2e38f);
    const Estimate sky = trace_irradiance(params, *prepare(scene, Rays::native), {&same, &up}, 1, {});
    CHECK(sky.nonfinite == count(sky, false));
}
