// Shadow density and shadow colour (VRSM 4.3) against closed forms, and what may be left out of a frame that has them.
#include <catch2/catch.hpp>
#include <cstring>
#include <limits>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/compose/compose.h"
#include "gi/direct/direct.h"
#include "gi/frame/frame.h"
#include "rsm_scenes.h"
#include "tests/gi/moving_scene.h"
#include "tests/gi/random_scene.h"

using namespace plumb;
using namespace plumb::test;
using direct::DirectVariant;

namespace {

// A lamp of type k % 3 somewhere above the origin.
Light lamp(int k, float intensity = 1) {
    Light light;
    light.type = LightType(k % 3);
    light.position = {0.25f * float(k), 2, 0.5f};
    light.direction = {0, -1, 0};
    light.intensity = glm::vec3(intensity, 0, 2 * intensity);
    return light;
}

// What the stage makes of one point under those lights, seen by them to that share.
glm::vec4 lit(const std::vector<Light>& lights, const std::vector<float>& visible, bool density,
              DirectVariant variant = DirectVariant::corrected, glm::vec3 normal = {0, 1, 0}, float covered = 1) {
    Points point({0, 0, 0}, normal);
    point.normal(0, 0).w = covered;
    Buffer<float> visibility;
    for (const float v : visible) visibility.push_back(v);
    Image4 e;
    direct::run(direct::DirectParams{variant}, direct::DirectInputs{&point.position, &point.normal, &lights, &visibility, nullptr, density},
                {}, e);
    return e(0, 0);
}

// The radiance of one surface without emission.
glm::vec3 composed(glm::vec3 shadow_color, glm::vec3 albedo, glm::vec4 direct, glm::vec3 indirect, float covered = 1) {
    const Image4 normal(1, 1, {0, 1, 0, covered}), rho(1, 1, {albedo, 0}), emission(1, 1), d(1, 1, direct),
        i(1, 1, {indirect, 0});
    Image4 radiance;
    compose::run(compose::ComposeParams{shadow_color}, compose::ComposeInputs{&normal, &rho, &emission, &d, &i, glm::vec3(7, 8, 9)}, {},
                 radiance);
    CHECK(radiance(0, 0).w == 0);
    return radiance(0, 0);
}

template <class T>
bool same(const Image<T>& a, const Image<T>& b) {
    return a.width == b.width && a.height == b.height && std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0;
}

frame::Frame render(const Scene& scene, const frame::Settings& settings) {
    return frame::execute(scene, settings, frame::plan(scene, settings), {});
}

// The moving scene with soft shadows, a blue shadow colour and direct light as printed.
frame::Settings printed() {
    frame::Settings s;
    s.method = frame::Method::direct;
    s.shadow.mode = direct::ShadowMode::density;
    s.direct.variant = DirectVariant::published;
    s.compose.shadow_color = {0.1f, 0.2f, 0.6f};
    return s;
}

}  // namespace

TEST_CASE("shadow density: the mean over the lights that shine", "[direct][VRSM 4.3][analytic]") {
    const std::vector<Light> three{lamp(0), lamp(1), lamp(2)};
    CHECK(lit(three, {1, 1, 1}, true).w == 1);
    CHECK(lit(three, {0, 0, 0}, true).w == 0);
    CHECK(lit(three, {1, 0, 0}, true).w == 1 / 3.0f);
    CHECK(lit({three[0]}, {0.1875f}, true).w == 0.1875f);
    CHECK(lit({three[0], three[1]}, {0.25f, 0.5f}, true).w == 0.375f);
    // Which way the surface faces, and how far away the light is, do not matter to it.
    CHECK(lit(three, {1, 1, 0}, true, DirectVariant::corrected, {0, -1, 0}).w == 2 / 3.0f);

    // Black lights are not counted, and none at all is night; nor is one whose intensity a device may flush to 0.
    for (const float dark : {0.0f, -0.0f, 1e-41f}) {
        CHECK(lit({lamp(0), lamp(1, dark)}, {0.5f, 0}, true).w == 0.5f);
        CHECK(lit({lamp(0, dark), lamp(1)}, {1, 0.25f}, true).w == 0.25f);
        CHECK(lit({lamp(0, dark)}, {1}, true).w == 0);
    }
    CHECK(lit({}, {}, true).w == 0);
    CHECK(lit({lamp(0, 0x1p-126f)}, {1}, true).w == 1);
    Light blue = lamp(0, 0);
    blue.intensity.z = 1;
    CHECK(lit({blue}, {0.5f}, true).w == 0.5f);
}

TEST_CASE("shadow density: 0 where nothing is seen and where nobody asks; irradiance is the same", "[direct][bits]") {
    const std::vector<Light> lights{lamp(0), lamp(1)};
    const glm::vec4 with = lit(lights, {0.5f, 1}, true), without = lit(lights, {0.5f, 1}, false);
    CHECK(with.w == 0.75f);
    CHECK(without.w == 0);
    CHECK(glm::vec3(with) == glm::vec3(without));
    CHECK(lit(lights, {1, 1}, true, DirectVariant::corrected, {0, 0, 0}, 0) == glm::vec4(0));
    CHECK(lit(lights, {1, 1}, true, DirectVariant::published, {0, 0, 0}, 0) == glm::vec4(0));
}

TEST_CASE("direct, as printed: pi times the density, without cosine, distance and intensity", "[direct][VRSM 4.3]") {
    const float pi = 3.14159274f;
    for (const bool asked : {false, true})
        for (const glm::vec3 normal : {glm::vec3(0, 1, 0), glm::vec3(0.6f, 0.8f, 0), glm::vec3(0, -1, 0)})
            for (const float intensity : {1e-3f, 1.0f, 1e3f})
                CHECK(lit({lamp(0, intensity), lamp(1)}, {0.25f, 0.5f}, asked, DirectVariant::published, normal) ==
                      glm::vec4(glm::vec3(pi * 0.375f), 0.375f));
}

TEST_CASE("shadow colour: what direct light leaves out of it", "[compose][VRSM 4.3][analytic]") {
    const glm::vec3 colour(0.25f, 0.5f, 2), rho(0.5f, 0.25f, 0), indirect(2, 4, 6);
    const float pi = 3.14159274f, inv_pi = float(1 / host::pi);
    // All in shadow: the shadow colour and indirect light, to the bit. All lit: it is not there.
    const glm::vec3 dark = composed(colour, rho, {0, 0, 0, 0}, indirect);
    const glm::vec3 bright = composed(colour, rho, {pi, pi, pi, 1}, glm::vec3(0));
    const glm::vec3 half = composed(colour, rho, {pi / 2, pi / 2, pi / 2, 0.5f}, glm::vec3(0));
    for (int c = 0; c < 3; ++c) {
        CAPTURE(c);
        CHECK(dark[c] == rho[c] * indirect[c] * inv_pi + colour[c]);
        CHECK(bright[c] == Approx(rho[c]).epsilon(4 * 0x1p-24).margin(0));
        CHECK(half[c] == Approx((rho[c] + colour[c]) / 2).epsilon(4 * 0x1p-24).margin(0));
    }
    CHECK(composed(colour, rho, {1, 1, 1, 0}, indirect, 0) == glm::vec3(7, 8, 9));
    CHECK_THROWS_WITH(composed({0, -1, 0}, rho, {}, {}), Catch::Contains("compose: shadow_color"));
}

// mix(shadow colour, rho, density) = shadow colour (1 - density) + rho density. The kernel rounds pi density, times rho,
// times 1/pi, 1 - density, times the colour, and the sum; pi and 1/pi are floats: less than 6 half units of either term.
TEST_CASE("shadow colour: with direct light as printed it is the thesis' blend", "[compose][VRSM 4.3][analytic]") {
    Dice dice(7);
    for (int i = 0; i < 2000; ++i) {
        const glm::vec3 colour = dice.in_box(glm::vec3(0.01f), glm::vec3(1)), rho = dice.in_box(glm::vec3(0), glm::vec3(1));
        const float alpha = i % 2 ? float(dice.below(17)) / 16 : dice.unit();
        const glm::vec4 d = lit({lamp(0)}, {alpha}, false, DirectVariant::published);
        REQUIRE(d.w == alpha);
        const glm::vec3 radiance = composed(colour, rho, d, glm::vec3(0));
        for (int c = 0; c < 3; ++c) {
            const double exact = double(colour[c]) * (1 - double(alpha)) + double(rho[c]) * alpha;
            CAPTURE(i, c, alpha, radiance[c], exact);
            REQUIRE(std::abs(radiance[c] - exact) <= 6 * 0x1p-24 * exact);
        }
    }
}

TEST_CASE("shadow colour: a black one is as if it were not there, whatever the density is", "[compose][bits]") {
    const float infinity = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
    const glm::vec3 rho(0.5f, 0, -0.0f), e(3, 5, 7), indirect(1, -0.0f, 1e-41f);
    const glm::vec3 before = composed(glm::vec3(0), rho, {e, 0}, indirect);
    const float inv_pi = float(1 / host::pi);
    for (int c = 0; c < 3; ++c) CHECK(before[c] == (rho[c] * (e[c] + indirect[c]) + 0.0f) * inv_pi);
    for (const float w : {1.0f, 0.5f, -1.0f, infinity, nan}) {
        const glm::vec3 after = composed(glm::vec3(0), rho, {e, w}, indirect);
        CHECK(std::memcmp(&before, &after, sizeof before) == 0);
    }
}

TEST_CASE("shadow colour: a frame is the blend of its own buffers; by default it has no density", "[frame][VRSM 4.3]") {
    const Scene scene = moving::scene();
    frame::Settings settings = printed();
    for (const auto& layout : {raster::Layout::fp32, raster::Layout::vrsm})
        for (const int kernel : {3, 4}) {
            settings.layout = layout;
            settings.shadow.kernel = kernel;
            const frame::Frame f = render(scene, settings);
            const std::size_t pixels = f.radiance.size();
            int covered = 0, between = 0;
            for (std::size_t i = 0; i < pixels; ++i) {
                if (f.gbuffer.normal.texels[i].w == 0) {
                    REQUIRE(f.direct.texels[i] == glm::vec4(0));
                    continue;
                }
                double alpha = 0;
                for (std::size_t l = 0; l < 3; ++l) alpha += double(f.visibility[l * pixels + i]) / 3;
                REQUIRE(f.direct.texels[i].w == Approx(alpha).epsilon(1e-6).margin(1e-12));
                ++covered, between += alpha > 0.01 && alpha < 0.99;
                for (int c = 0; c < 3; ++c) {
                    const double rho = f.gbuffer.albedo.texels[i][c], m = f.gbuffer.emission.texels[i][c];
                    REQUIRE(f.radiance.texels[i][c] ==
                            Approx(settings.compose.shadow_color[c] * (1 - alpha) + rho * alpha + m / host::pi)
                                .epsilon(2e-6));
                }
            }
            CHECK(covered > 50);
            CHECK(between > 10);
        }
    frame::Settings plain = settings;
    plain.direct = {}, plain.compose = {};
    for (const glm::vec4& texel : render(scene, plain).direct.texels) REQUIRE(texel.w == 0);
}

// Figure 4.3: the density lies in a channel of halves. 3/16 is one, 1/9 is not.
TEST_CASE("layout vrsm: direct light reads densities that are halves", "[frame][layout][VRSM fig. 4.3]") {
    const Scene scene = moving::scene();
    for (const int kernel : {3, 4}) {
        frame::Settings settings = printed();
        settings.shadow.kernel = kernel;
        const frame::Frame exact = render(scene, settings);
        settings.layout = raster::Layout::vrsm;
        settings.layout.name = "custom";
        settings.layout.position = settings.layout.rsm_position = Format::rgba32f;  // the same shadow tests
        settings.layout.normal = settings.layout.rsm_normal = settings.layout.rsm_flux = Format::rgba32f;
        settings.layout.depth = settings.layout.rsm_depth = Format::r32f;
        const frame::Frame stored = render(scene, settings);
        REQUIRE(exact.visibility.size() == stored.visibility.size());
        int rounded = 0;
        for (std::size_t i = 0; i < exact.visibility.size(); ++i) {
            REQUIRE(stored.visibility[i] == half_to_float(float_to_half(exact.visibility[i])));
            rounded += stored.visibility[i] != exact.visibility[i];
        }
        CAPTURE(kernel, rounded);
        CHECK((kernel == 4 ? rounded == 0 : rounded > 10));
    }
    CHECK(half_to_float(float_to_half(3 / 16.0f)) == 3 / 16.0f);
    CHECK(half_to_float(float_to_half(1 / 9.0f)) == 1820 * 0x1p-14f);  // 1/9 = 1820.4 units of 2^-14
}

TEST_CASE("layout: indirect light in halves is each gather's rounded once", "[frame][layout][VRSM fig. 4.4]") {
    Scene scene = moving::scene();
    scene.lights.resize(1);
    frame::Settings settings;
    settings.rsm.gather = rsm::Gather::disc, settings.rsm.samples = 16, settings.indirect.blur = filter::Blur::none;
    const frame::Frame exact = render(scene, settings);
    settings.layout.name = "custom";
    settings.layout.indirect = Format::rgba16f;
    const frame::Frame stored = render(scene, settings);
    int rounded = 0;
    for (std::size_t i = 0; i < exact.indirect.size(); ++i)
        for (int c = 0; c < 4; ++c) {
            REQUIRE(stored.indirect.texels[i][c] == half_to_float(float_to_half(exact.indirect.texels[i][c])));
            rounded += stored.indirect.texels[i][c] != exact.indirect.texels[i][c];
        }
    CHECK(rounded > 100);

    // What a half does not hold is refused where it is found, by light, pixel and limit.
    scene.lights[0].intensity = glm::vec3(1e7f);
    CHECK_THROWS_AS(render(scene, settings), InputError);
    CHECK_THROWS_WITH(render(scene, settings),
                      Catch::StartsWith("rsm.disc: light \"key\": pixel ") &&
                          Catch::Contains("W/m2 does not fit rgba16f (65504), which layout \"custom\" stores it in: "));
    settings.layout = raster::Layout::fp32;
    CHECK_NOTHROW(render(scene, settings));
}

TEST_CASE("explain: the density, and what a layout stores of visibility and indirect light", "[frame][explain]") {
    const Scene scene = moving::scene();
    frame::Settings settings = printed();
    settings.method = frame::Method::rsm;
    settings.rsm.gather = rsm::Gather::disc, settings.rsm.samples = 16, settings.indirect.blur = filter::Blur::none;
    settings.layout = raster::Layout::vrsm;
    settings.shadow.kernel = 3;
    const frame::Plan plan = frame::plan(scene, settings);
    const frame::Frame f = frame::execute(scene, settings, plan, {});
    auto value = [&](const std::string& stage, int light, glm::ivec2 pixel, const std::string& name) {
        for (const frame::Explanation& e : frame::explain(scene, settings, plan, f, stage, light, pixel))
            for (auto v = e.values.rbegin(); v != e.values.rend(); ++v)
                if (v->name == name) return v->value;
        return std::vector<double>{};
    };
    for (const glm::ivec2 pixel : {glm::ivec2(3, 4), glm::ivec2(9, 7)}) {
        const std::size_t i = std::size_t(pixel.y) * std::size_t(scene.frame_size.x) + std::size_t(pixel.x);
        CHECK(value("direct", -1, pixel, "density") == std::vector<double>{f.direct.texels[i].w});
        CHECK(value("compose", -1, pixel, "shadow") == std::vector<double>{1 - f.direct.texels[i].w});
        CHECK(value("compose", -1, pixel, "radiance").at(1) == f.radiance.texels[i].y);
        glm::vec3 sum(0);
        for (int l = 0; l < 3; ++l) {
            CHECK(value("shadow", l, pixel, "stored_visibility") ==
                  std::vector<double>{f.visibility[std::size_t(l) * f.radiance.size() + i]});
            const std::vector<double> e = value("rsm.disc", l, pixel, "stored_irradiance");
            REQUIRE(e.size() == 3);
            for (int c = 0; c < 3; ++c) sum[c] += float(e[std::size_t(c)]);
        }
        CHECK(sum == glm::vec3(f.indirect.texels[i]));
    }
}

namespace {

// rules() but for one, which holds wherever it would if nobody looked at densities.
std::vector<frame::Rule> careless(const std::string& name) {
    std::vector<frame::Rule> all = frame::rules();
    for (frame::Rule& rule : all)
        if (rule.name == name)
            rule.holds = [](const frame::PlanFacts& known, const frame::Work& work) {
                frame::Settings plain = known.settings;
                plain.direct = {}, plain.compose = {};
                const frame::PlanFacts other = frame::known_of(known.scene, plain, known.geometry);
                for (const frame::Rule& r : frame::rules())
                    if (r.speaks_of(work) && (r.name == "light-misses" || r.name == "no-light") && r.holds(other, work))
                        return true;
                return false;
            };
    return all;
}

}  // namespace

TEST_CASE("shadow colour: what is left out of a frame with a shadow density changes no bit", "[frame][pruning]") {
    Scene base = moving::scene();
    base.lights.resize(2);
    const auto off = [](Scene& s) { s.lights[1].on = false; };
    const auto black = [](Scene& s) { s.lights[1].intensity = glm::vec3(0); };
    const auto misses = [](Scene& s) {
        s.lights[1] = moving::spot("away", {0, 3, 0}, {0, 1, 0}, 5);
        s.lights[1].cone_inner_deg = 5, s.lights[1].cone_outer_deg = 10;
    };
    const auto all_miss = [&](Scene& s) { misses(s), s.lights.erase(s.lights.begin()); };
    const auto all_off = [&](Scene& s) { off(s), s.lights.erase(s.lights.begin()); };
    struct Try {
        const char* name;
        std::function<void(Scene&)> change;
        const char* corrected;  // the rule that leaves out the shadow of the last light
        const char* published;  // by the shadow test as printed
    };
    const Try tries[] = {{"off", off, "light-off", "light-off"},
                         {"black", black, "light-black", "light-black"},
                         {"misses", misses, "light-misses", ""},
                         {"all miss", all_miss, "light-misses", ""},
                         {"all off", all_off, "light-off", "light-off"}};
    for (const Try& t : tries)
        for (const auto variant : {direct::ShadowVariant::corrected, direct::ShadowVariant::published})
            for (const bool as_printed : {false, true}) {
                CAPTURE(t.name, int(variant), as_printed);
                Scene scene = base;
                t.change(scene);
                frame::Settings settings = printed();
                settings.shadow.variant = variant;
                if (!as_printed) settings.direct = {};
                const frame::Plan plan = frame::plan(scene, settings);
                std::string rule;
                for (const frame::PlannedStage& s : plan.stages)
                    if (s.name == "shadow") rule = s.rule;
                CHECK(rule == (variant == direct::ShadowVariant::corrected ? t.corrected : t.published));
                const frame::Frame pruned = render(scene, settings);
                settings.pruning = false;
                const frame::Frame whole = render(scene, settings);
                CHECK(same(pruned.direct, whole.direct));
                CHECK(same(pruned.radiance, whole.radiance));
            }
}

TEST_CASE("shadow colour: 300 scenes are the same bit for bit with and without pruning; a careless rule is noticed",
          "[frame][pruning][property]") {
    std::map<std::string, int> noticed;
    for (std::uint32_t seed = 1000; seed < 1300; ++seed) {
        CAPTURE(seed);
        const Scene scene = random_scene(seed);
        frame::Settings settings = random_settings(seed);
        settings.method = frame::Method::direct, settings.truth = false;
        settings.compose.shadow_color = glm::vec3(0.3f, 0.1f, 0.2f);
        if (seed % 3 == 0) settings.direct.variant = DirectVariant::published;
        if (seed % 2 == 0) settings.shadow.variant = direct::ShadowVariant::published;
        const frame::Frame pruned = render(scene, settings);
        frame::Settings unpruned = settings;
        unpruned.pruning = false;
        const frame::Frame whole = render(scene, unpruned);
        REQUIRE(same(pruned.direct, whole.direct));
        REQUIRE(same(pruned.radiance, whole.radiance));
        for (const char* rule : {"light-misses", "no-light"}) {
            const frame::Plan plan = frame::plan(scene, settings, careless(rule));
            noticed[rule] += !same(frame::execute(scene, settings, plan, {}).radiance, whole.radiance);
        }
    }
    CHECK(noticed["light-misses"] >= 3);
    CHECK(noticed["no-light"] >= 3);
}
