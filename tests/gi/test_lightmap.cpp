// A lightmap's check: a right map passes, and what is planted is found where it was planted.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "core/compare_pictures.h"
#include "core/error.h"
#include "gi/probes/lightmap_check.h"
#include "gi/probes/lightmap_pictures.h"
#include "gi/probes/own_layout.h"
#include "random_scene.h"

namespace {

using namespace plumb;
using namespace plumb::probes;
using Catch::Matchers::Contains;

// A room of 4 m with a lamp, and a box that stands above its floor and throws a shadow.
Scene furnished() {
    Scene scene;
    scene.materials.resize(2);
    Mesh walls, box;
    walls.name = "walls", box.name = "box";
    test::add_box(walls, glm::vec3(-2), glm::vec3(2), 0, true);
    test::add_box(box, {-0.6f, -1.6f, -0.6f}, {0.8f, -0.4f, 0.6f}, 1);
    scene.meshes = {walls, box};
    scene.lights.resize(1);
    scene.lights[0].type = LightType::point, scene.lights[0].position = {0.3f, 1.2f, -0.4f}, scene.lights[0].intensity = {9, 8, 7};
    return scene;
}

struct Checked {
    Scene scene = furnished();
    Lightmap lightmap;
    ReceiverIrradiance truth, other;  // of two seeds
    Image4 map;                       // of the other, with borders

    Checked() {
        BakeParams params;
        params.receivers_per_m2 = 12;
        lightmap = place_lightmap(scene, make_atlas(scene, flatten(scene), atlas_params(params)), params, {});
        reference::PathParams path;
        path.samples = 512, path.rays = Rays::exact;
        const auto prepared = reference::prepare(scene, path.rays);
        truth = receiver_irradiance(lightmap.receivers, *prepared, path, 1, {});
        other = receiver_irradiance(lightmap.receivers, *prepared, path, 2, {});
        map = on_map(other.mean);
    }
    Image4 on_map(const Buffer<glm::vec4>& values) const { return extend_borders(lightmap.receivers, scatter(lightmap.receivers, values)); }
    Image4 map_error() const { return on_map(other.error); }
    LightmapCheck check(const Image4& m) const { return check_lightmap(m, map_error(), lightmap, truth); }
    std::int32_t chart_of(int i) const { return lightmap.atlas.chart[std::size_t(lightmap.receivers.triangle[std::size_t(i)])]; }
};
const Checked& checked() {
    static const Checked all;
    return all;
}

double luminance(const glm::vec4& v) { return compare::luminance(glm::dvec3(v)); }

int off_count(const LightmapCheck& c) {
    int n = 0;
    for (const ChartCheck& chart : c.charts) n += chart.off;
    return n;
}

// Every texel of a chart, and of the ring about it.
template <class Change>
void change_chart(const Checked& c, Image4& map, std::int32_t chart, Change change) {
    const ChartTexels texels(c.lightmap.atlas, c.lightmap.receivers, c.truth);
    for (int y = 0; y < map.height; ++y)
        for (int x = 0; x < map.width; ++x)
            if (texels.expected(chart, {x, y}).known) change(glm::ivec2(x, y), map(x, y));
}

double distance_to_segment(const glm::dvec2& p, const glm::dvec2& a, const glm::dvec2& b) {
    const glm::dvec2 d = b - a;
    const double along = std::clamp(glm::dot(p - a, d) / glm::dot(d, d), 0.0, 1.0);
    const glm::dvec2 away = p - a - along * d;
    return std::sqrt(glm::dot(away, away));
}

// One mesh of a square of 2 m, whose two triangles have coordinates of their own.
Scene two_triangles(std::vector<glm::vec2> uv) {
    Scene scene;
    scene.name = "two";
    scene.materials.resize(1);
    Mesh mesh;
    mesh.name = "sheet";
    const glm::vec3 corner[6] = {{0, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 0, 0}, {2, 2, 0}, {0, 2, 0}};
    for (int k = 0; k < 6; ++k) mesh.vertices.push_back({corner[k], uv[std::size_t(k)].x, {0, 0, 1}, uv[std::size_t(k)].y});
    mesh.triangles = {{0, 1, 2}, {3, 4, 5}};
    mesh.material = {0, 0};
    scene.meshes = {mesh};
    return scene;
}

Atlas laid_out(const Scene& scene, glm::ivec2 size, std::vector<bool> on_map = {}) {
    const Geometry g = flatten(scene);
    OwnLayout layout;
    for (const Vertex& v : g.vertices) layout.uv.push_back({v.u, v.v});
    layout.size = size, layout.on_map = std::move(on_map);
    return own_layout(scene, g, layout, "mine.exr");
}

}  // namespace

TEST_CASE("lightmap: its receivers are those of a bake", "[probes]") {
    BakeParams params;
    params.receivers_per_m2 = 3, params.relight_rays = 64, params.receiver_rays = 8, params.degree = 1, params.placement.count = 2;
    Scene scene = furnished();
    for (Vertex& v : scene.meshes[1].vertices) v.position.y -= 0.5f;  // the box stands in the floor: some are moved
    BakeGraph graph(scene, params);
    graph::run(graph.nodes(), {});
    const Receivers& baked = graph.bake().receivers;
    const Lightmap l = place_lightmap(scene, make_atlas(scene, flatten(scene), atlas_params(params)), params, {});
    CHECK(l.moved == graph.bake().shifted);
    CHECK(l.moved > 0);
    REQUIRE(l.receivers.count() == baked.count());
    CHECK(l.receivers.position == baked.position);
    CHECK(l.receivers.normal == baked.normal);
    CHECK(l.receivers.texel == baked.texel);
}

TEST_CASE("lightmap: Student's t", "[probes][analytic]") {
    // Two-sided tables: Abramowitz and Stegun 26.10, rounded to three decimals of t.
    struct Row {
        int degrees;
        double t, beyond;
    };
    for (const auto& [degrees, t, beyond] : {Row{1, 12.706, 0.05}, Row{2, 4.303, 0.05}, Row{3, 3.182, 0.05}, Row{8, 2.306, 0.05}, Row{15, 2.131, 0.05},
                                             Row{15, 4.073, 0.001}, Row{120, 1.980, 0.05}, Row{15, 0.691, 0.5}}) {
        CAPTURE(degrees, t);
        CHECK(student_beyond(t, degrees) == Approx(beyond).epsilon(2e-3));
    }
    CHECK(student_beyond(0, 15) == 1);
    // Of a normal distribution 5 % lie beyond 1.959964, 0.1 % beyond 3.290527: the same rows, read the other way.
    CHECK(student_sigmas(1.959964, 1) == Approx(12.706).epsilon(1e-4));
    CHECK(student_sigmas(1.959964, 15) == Approx(2.131).epsilon(3e-4));
    CHECK(student_sigmas(3.290527, 15) == Approx(4.073).epsilon(3e-4));
}

TEST_CASE("lightmap: a bilinear lookup is a GPU's", "[probes]") {
    const Bilinear centre = bilinear({3.5, 2.5}, {8, 8});
    CHECK(centre.texel[0] == glm::ivec2(3, 2));
    CHECK(centre.weight[0] == 1);
    const Bilinear between = bilinear({4.0, 2.75}, {8, 8});
    CHECK(between.texel[3] == glm::ivec2(4, 3));
    CHECK(between.weight == std::array<double, 4>{0.375, 0.375, 0.125, 0.125});
    const Bilinear edge = bilinear({0.0, 8.0}, {8, 8});
    for (const glm::ivec2& t : edge.texel) CHECK(t == glm::ivec2(0, 7));
}

TEST_CASE("lightmap: a right map of other random numbers passes", "[probes][lightmap]") {
    const Checked& c = checked();
    const LightmapCheck check = c.check(c.map);
    CHECK(check.leaking + check.black_leaking == 0);
    CHECK(check.leaks.empty());
    CHECK(check.bleeding.empty());
    CHECK(check.seams_off == 0);
    CHECK(off_count(check) == 0);
    CHECK(check.charts.size() == 12);
    CHECK(check.seams.size() > 15);      // 12 edges of each box, but where one side has no receiver
    CHECK(check.read_beside > 100);
    // By chance what of a normal distribution lies beyond 4. Errors of luminance are upper bounds.
    CHECK(check.told <= 0.0005);
    CHECK(check.told_by_chance == Approx(6.334e-5).epsilon(0.01));
    CHECK(check.rms_least == 0);
    CHECK(check.rms_most < 0.1);
    CHECK(std::fabs(*check.errors.mean_error) < 0.005);
    CHECK(*check.errors.rms < *check.errors.noise);
    CHECK(check.best_scale == Approx(1).epsilon(0.01));
    // Without the map's own error there is as much noise again: more is told, and nothing is called a leak or a seam.
    const LightmapCheck unknown = check_lightmap(c.map, {}, c.lightmap, c.truth);
    CheckParams near;
    near.sigmas = 1.5;
    CHECK(check_lightmap(c.map, {}, c.lightmap, c.truth, near).told > check_lightmap(c.map, c.map_error(), c.lightmap, c.truth, near).told);
    CHECK(unknown.leaks.empty());
    CHECK(unknown.seams_off == 0);
    // The truth itself differs nowhere.
    const LightmapCheck same = check_lightmap(c.on_map(c.truth.mean), {}, c.lightmap, c.truth);
    CHECK(same.told == 0);
    CHECK_FALSE(same.worst);
    CHECK(same.errors.below_noise);
    CHECK(same.seam_mean == 0);
    CHECK(same.smooth_user == same.smooth_truth);
}

TEST_CASE("lightmap: a chart that is too bright by a tenth is found and named, and no other", "[probes][lightmap]") {
    const Checked& c = checked();
    for (const std::int32_t chart : {0, 7}) {
        Image4 map = c.map;
        change_chart(c, map, chart, [](glm::ivec2, glm::vec4& v) { v *= 1.1f; });
        const LightmapCheck check = c.check(map);
        REQUIRE(off_count(check) == 1);
        const auto off = std::find_if(check.charts.begin(), check.charts.end(), [](const ChartCheck& x) { return x.off; });
        CHECK(off->chart == chart);
        CHECK(off->bias == Approx(0.1).margin(0.01));
        CHECK(check.leaks.empty());
        // Its edges no longer fit to what is beside it.
        REQUIRE(check.seams_off > 0);
        for (int i = 0; i < check.seams_off; ++i) {
            const Seam& s = check.seams[std::size_t(i)];
            CHECK((s.a.chart == chart || s.b.chart == chart));
        }
    }
}

TEST_CASE("lightmap: a planted seam is the worst one, at its edge", "[probes][lightmap]") {
    const Checked& c = checked();
    const LightmapCheck before = c.check(c.map);
    // An edge of the floor that has light on both sides.
    const auto planted = std::find_if(before.seams.begin(), before.seams.end(), [&](const Seam& s) {
        return s.length > 3 && s.a.truth > 0.5 * before.median && s.b.truth > 0.5 * before.median;
    });
    REQUIRE(planted != before.seams.end());
    Image4 map = c.map;
    change_chart(c, map, planted->a.chart, [&](glm::ivec2 t, glm::vec4& v) {
        if (distance_to_segment(glm::dvec2(t) + 0.5, planted->a_from, planted->a_to) < 1.5) v *= 1.5f;
    });
    const LightmapCheck check = c.check(map);
    REQUIRE(check.seams_off > 0);
    const Seam& worst = check.seams[0];
    CHECK(worst.from == planted->from);
    CHECK(worst.to == planted->to);
    // Half of side a's light, over the mean of both sides'.
    CHECK(worst.excess == Approx(0.5 * planted->a.truth / ((planted->a.truth + planted->b.truth) / 2)).epsilon(0.3));
    CHECK(worst.a.user == Approx(1.5 * worst.a.truth).epsilon(0.1));
    CHECK(check.leaks.empty());
}

TEST_CASE("lightmap: a planted leak is found at its texel", "[probes][lightmap]") {
    const Checked& c = checked();
    const Receivers& r = c.lightmap.receivers;
    const LightmapCheck before = c.check(c.map);
    // The darkest receiver that some light reaches: under the box.
    int dark = -1;
    for (int i = 0; i < r.count(); ++i)
        if (r.shift[std::size_t(i)].w == 0 && (dark < 0 || luminance(c.truth.mean[std::size_t(i)]) < luminance(c.truth.mean[std::size_t(dark)]))) dark = i;
    const glm::ivec2 at = r.texel[std::size_t(dark)];
    Image4 map = c.map;
    map(at.x, at.y) += glm::vec4(glm::vec3(float(before.median)), 0);
    const LightmapCheck check = c.check(map);
    REQUIRE(check.leaks.size() == 1);
    CHECK(check.leaking == 1);
    CHECK(check.leaks[0].texels == 1);
    CHECK(check.leaks[0].worst.texel == at);
    CHECK(check.leaks[0].worst.position == glm::dvec3(r.position[std::size_t(dark)]));
    CHECK(check.leaks[0].worst.object == c.lightmap.atlas.geometry.object[std::size_t(r.triangle[std::size_t(dark)])]);
    CHECK(check.leak_marks(at.x, at.y) == 1);
    REQUIRE(check.worst);
    CHECK(check.worst->texel == at);
    for (const ChartCheck& chart : check.charts) CHECK((!chart.off || chart.chart == check.worst->chart));
    // As bright a texel in full light is none.
    int bright = 0;
    for (int i = 0; i < r.count(); ++i)
        if (luminance(c.truth.mean[std::size_t(i)]) > luminance(c.truth.mean[std::size_t(bright)])) bright = i;
    Image4 lit = c.map;
    lit(r.texel[std::size_t(bright)].x, r.texel[std::size_t(bright)].y) += glm::vec4(glm::vec3(float(before.median)), 0);
    CHECK(c.check(lit).leaks.empty());
    // Where no light comes at all, the leak is of the other kind.
    ReceiverIrradiance black = c.truth;
    black.mean[std::size_t(dark)] = black.error[std::size_t(dark)] = glm::vec4(0);
    const LightmapCheck inside = check_lightmap(map, {}, c.lightmap, black);
    REQUIRE(inside.leaks.size() == 1);
    CHECK(inside.leaks[0].kind == LeakKind::black);
    CHECK(inside.black_leaking == 1);
}

TEST_CASE("lightmap: texels beside charts that lookups read are told when they hold another value", "[probes][lightmap]") {
    const Checked& c = checked();
    // No borders at all: every lit edge of every chart bleeds black.
    const LightmapCheck bare = c.check(scatter(c.lightmap.receivers, c.other.mean));
    CHECK(bare.bleeding.size() > 100);
    for (const Bleeding& b : bare.bleeding) {
        REQUIRE(b.kind == BleedingKind::unwritten);
        REQUIRE(b.place.user == 0);
        const ChartTexels texels(c.lightmap.atlas, c.lightmap.receivers, c.truth);
        REQUIRE(texels.receiver_at(b.place.texel) < 0);
    }
    CHECK(bare.told == c.check(c.map).told);  // receivers are as they were
    // A single one.
    Image4 map = c.map;
    const glm::ivec2 at = bare.bleeding[10].place.texel;
    map(at.x, at.y) = glm::vec4(0);
    const LightmapCheck one = c.check(map);
    REQUIRE(one.bleeding.size() == 1);
    CHECK(one.bleeding[0].place.texel == at);
    map(at.x, at.y) = 3.0f * c.map(at.x, at.y);
    REQUIRE(c.check(map).bleeding.size() == 1);
    CHECK(c.check(map).bleeding[0].kind == BleedingKind::wrong);
}

TEST_CASE("lightmap: charts without a gap bleed into each other", "[probes][lightmap]") {
    // Two triangles a texel apart, the one ten times as bright as the other; a square of 16 x 16 texels.
    const double d = 0.5 / 16;
    const Scene scene = two_triangles({{0, 0}, {float(1 - d), 0}, {float(1 - d), float(1 - d)}, {0, float(d)}, {float(1 - d), 1}, {0, 1}});
    const Lightmap l = place_lightmap(scene, laid_out(scene, {16, 16}), {}, {});
    REQUIRE(l.atlas.charts.size() == 2);
    ReceiverIrradiance truth;
    truth.rounds = 16;
    for (int i = 0; i < l.receivers.count(); ++i) {
        const bool bright = l.receivers.triangle[std::size_t(i)] == 0;
        truth.mean.push_back(glm::vec4(glm::vec3(bright ? 10.0f : 1.0f), 0)), truth.error.push_back(glm::vec4(0));
    }
    const Image4 map = extend_borders(l.receivers, scatter(l.receivers, truth.mean));
    const LightmapCheck check = check_lightmap(map, {}, l, truth);
    CHECK(check.told == 0);
    const auto others = std::count_if(check.bleeding.begin(), check.bleeding.end(), [](const Bleeding& b) { return b.kind == BleedingKind::other_chart; });
    CHECK(others > 10);
    // The diagonal is an edge with two places; the truth steps there by 9, chart by chart, but the map's lookups blend both.
    REQUIRE(check.seams.size() == 1);
    CHECK(check.seams[0].smooth);
    CHECK(check.seams[0].truth == Approx(9));
    CHECK(check.seams[0].user < 7);
    CHECK(check.seams_off == 1);
    // Noise is taken off the squares, and what it may explain is no seam.
    ReceiverIrradiance noisy = truth;
    for (glm::vec4& e : noisy.error) e = glm::vec4(glm::vec3(0.8f), 0);
    const double less = check_lightmap(map, {}, l, noisy).seams[0].excess;
    CHECK(less > 0.5 * check.seams[0].excess);
    CHECK(less < 0.998 * check.seams[0].excess);
    for (glm::vec4& e : noisy.error) e = glm::vec4(glm::vec3(8.0f), 0);
    CHECK(check_lightmap(map, {}, l, noisy).seams[0].excess == 0);
}

TEST_CASE("lightmap: a map of another unit says by how much", "[probes][lightmap]") {
    const Checked& c = checked();
    Image4 map = c.map;
    for (glm::vec4& v : map.texels) v /= float(3.14159265);
    const LightmapCheck check = c.check(map);
    CHECK(check.best_scale == Approx(3.14159265).epsilon(0.01));
    CHECK(*check.errors.rms > 0.5);
    CHECK(check.rms_at_best_scale < 0.1);
    CHECK(off_count(check) == 12);
    // A black map is wrong by all of the light, and leaks nowhere.
    const LightmapCheck black = c.check(Image4(c.map.width, c.map.height));
    CHECK(*black.errors.mean_error == Approx(-1));
    CHECK(black.leaks.empty());
    CHECK(black.best_scale == 1);
}

TEST_CASE("lightmap: maps of another size and what is not finite are refused", "[probes][lightmap]") {
    const Checked& c = checked();
    CHECK_THROWS_WITH(check_lightmap(Image4(8, 8), {}, c.lightmap, c.truth), Contains("8 x 8") && Contains("expected"));
    Image4 map = c.map;
    map(5, 3).y = std::numeric_limits<float>::quiet_NaN();
    CHECK_THROWS_WITH(check_lightmap(map, {}, c.lightmap, c.truth), Contains("texel 5,3") && Contains("in G"));
    map(5, 3).y = std::numeric_limits<float>::infinity();
    CHECK_THROWS_AS(check_lightmap(c.map, map, c.lightmap, c.truth), InputError);
}

TEST_CASE("lightmap: a layout of one's own has a chart for each island", "[probes][lightmap]") {
    // A square whose halves lie apart, and one that hangs together.
    const Scene apart = two_triangles({{0, 0}, {0.4f, 0}, {0.4f, 0.4f}, {0.5f, 0.5f}, {0.9f, 0.9f}, {0.5f, 0.9f}});
    const Atlas two = laid_out(apart, {32, 32});
    REQUIRE(two.charts.size() == 2);
    CHECK(two.chart == std::vector<std::int32_t>{0, 1});
    CHECK(two.charts[1].origin == glm::ivec2(16, 16));
    CHECK(two.charts[1].size == glm::ivec2(13, 13));
    CHECK(two.texels_per_m == Approx(0.4 * 32 / 2));
    const Scene whole = two_triangles({{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}});
    CHECK(laid_out(whole, {32, 32}).charts.size() == 1);
    CHECK(place_lightmap(whole, laid_out(whole, {8, 8}), {}, {}).receivers.count() == 64);
    // Twice as wide as high suits a sheet of that shape, and only that.
    CHECK_THROWS_WITH(laid_out(whole, {64, 32}), Contains("mine.exr") && Contains("64 x 32") && Contains("aspect"));
    Scene wide = whole;
    for (Vertex& v : wide.meshes[0].vertices) v.position.x *= 2;
    CHECK(texel_aspect(laid_out(wide, {32, 32})) == Approx(2));
    CHECK(laid_out(wide, {64, 32}).size == glm::ivec2(64, 32));
    CHECK_THROWS_WITH(laid_out(wide, {32, 64}), Contains("aspect"));
}

TEST_CASE("lightmap: layouts that cannot serve are refused with the mesh's name", "[probes][lightmap]") {
    const auto whole = two_triangles({{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}});
    const auto with = [&](int vertex, glm::vec2 uv) {
        Scene scene = whole;
        scene.meshes[0].vertices[std::size_t(vertex)].u = uv.x, scene.meshes[0].vertices[std::size_t(vertex)].v = uv.y;
        return scene;
    };
    CHECK_THROWS_WITH(laid_out(with(1, {1.5f, 0}), {32, 32}), Contains("mine.exr") && Contains("sheet") && Contains("(1.5, 0)"));
    CHECK_THROWS_WITH(laid_out(with(1, {std::nanf(""), 0}), {32, 32}), Contains("sheet") && Contains("nan"));
    CHECK_THROWS_WITH(laid_out(with(5, {1, 0}), {32, 32}), Contains("sheet") && Contains("overlap"));
    Scene none = whole;
    for (Vertex& v : none.meshes[0].vertices) v.u = v.v = 0;
    CHECK_THROWS_WITH(laid_out(none, {32, 32}), Contains("sheet") && Contains("no area"));
    // Two meshes on one place: both are named, and one alone is a layout.
    Scene twice = whole;
    twice.meshes.push_back(whole.meshes[0]), twice.meshes.push_back(whole.meshes[0]);
    twice.meshes[0].name = "first", twice.meshes[2].name = "third";
    for (Vertex& v : twice.meshes[1].vertices) v.u = v.u * 0.001f, v.v = v.v * 0.001f;  // within the slack of a texel
    CHECK_THROWS_WITH(laid_out(twice, {32, 32}), Contains("\"first\" and mesh \"third\"") && Contains("--mesh"));
    const Atlas third = laid_out(twice, {32, 32}, {false, false, true});
    CHECK(third.charts.size() == 1);
    CHECK(third.charts[0].object == 2);
    CHECK(place_lightmap(twice, third, {}, {}).receivers.count() == 32 * 32);
    CHECK_THROWS_WITH(laid_out(whole, {32, 32}, {false}), Contains("no mesh"));
}

TEST_CASE("lightmap: pictures show what was found", "[probes][lightmap]") {
    const Checked& c = checked();
    Image4 map = c.map;
    change_chart(c, map, 0, [](glm::ivec2, glm::vec4& v) { v *= 2.0f; });
    const LightmapCheck check = c.check(map);
    DebugView view;
    view.size = {64, 48};
    view.view = make_view(c.scene.camera, 64.0 / 48);
    const std::vector<DebugLayer> layers = lightmap_pictures(map, c.lightmap, c.truth, check, {}, view, {});
    std::vector<std::string> names;
    for (const DebugLayer& layer : layers) names.push_back(layer.name);
    CHECK(names == std::vector<std::string>{"truth", "truth.scene", "map", "map.scene", "error", "error.scene", "seams", "seams.scene", "leaks", "leaks.scene"});
    // The chart is red in the picture of errors, the others are white.
    const Image4& error = layers[4].picture;
    int red = 0, white = 0;
    for (int i = 0; i < c.lightmap.receivers.count(); ++i) {
        const glm::ivec2 t = c.lightmap.receivers.texel[std::size_t(i)];
        const bool is_red = error(t.x, t.y).x > 0.7f && error(t.x, t.y).y < 0.5f;
        red += is_red && c.chart_of(i) == 0;
        white += error(t.x, t.y) == glm::vec4(1) && c.chart_of(i) != 0;
    }
    const auto chart = std::find_if(check.charts.begin(), check.charts.end(), [](const ChartCheck& x) { return x.chart == 0; });
    CHECK(red > 0.9 * chart->receivers);
    CHECK(white > 0.95 * (c.lightmap.receivers.count() - chart->receivers - check.inside));
}
