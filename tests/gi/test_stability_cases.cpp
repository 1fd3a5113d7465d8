// The stiff and extreme cases: each makes legal inputs that are hard in the way that its name says.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/frame/rules.h"
#include "gi/parity/stages.h"
#include "gi/stability/cases.h"
#include "gi/stability/cases_parts.h"
#include "gi/stability/run.h"
#include "raster/light_view.h"

using namespace plumb;
using namespace plumb::stability;
using Catch::Matchers::Contains;

namespace {

const Case& case_of(const std::string& name) {
    for (const Case& c : cases())
        if (c.name == name) return c;
    FAIL("no case \"" << name << "\"");
    return cases().front();
}

// The dispatches of a case's frame, before its edit.
std::vector<StageData> data_of(const Case& c, rsm::Gather gather = rsm::Gather::disc) {
    const Scene scene = c.scene();
    frame::Settings settings = case_settings(c, scene);
    settings.rsm.gather = gather;
    const frame::Plan plan = frame::plan(scene, settings);
    return parity::frame_data(scene, settings, plan, frame::execute(scene, settings, plan, {}));
}

// Those of the plain room, made once.
const std::vector<StageData>& room_data() {
    static const std::vector<StageData> data = [] {
        std::vector<StageData> all = data_of(case_of("room"));
        for (const rsm::Gather gather : {rsm::Gather::paths, rsm::Gather::all})
            for (StageData& d : data_of(case_of("room"), gather))
                if (d.stage == rsm::stage_name(gather)) all.push_back(std::move(d));
        return all;
    }();
    return data;
}

std::vector<glm::vec3> points(StageData& d, const std::string& input, std::size_t step = 4) {
    const std::span<float> f = input_floats(d, input);
    std::vector<glm::vec3> all;
    for (std::size_t i = 0; i + 2 < f.size(); i += step) all.emplace_back(f[i], f[i + 1], f[i + 2]);
    return all;
}

// What a stage measures distances from.
std::vector<glm::vec3> anchors(StageData& d) {
    return d.stage == "direct" ? points(d, "lights", 12) : points(d, "rsm_position");
}

double length(const glm::dvec3& v) { return std::sqrt(glm::dot(v, v)); }

glm::dvec4 clip(const View& view, const glm::vec3& p) { return view.world_to_clip() * glm::dvec4(glm::dvec3(p), 1); }

View camera_view(const Scene& s) {
    return make_view(s.camera, double(s.frame_size.x) / s.frame_size.y, s.convention, s.frame_size);
}
View key_view(const Scene& s) {
    glm::vec3 low, high;
    bounds(flatten(s), low, high);
    return raster::light_view(s.lights[key], low, high);
}

bool is_denormal(float v) { return std::fpclassify(v) == FP_SUBNORMAL; }

const Cell& only(const std::vector<Cell>& cells) {
    REQUIRE(cells.size() == 1);
    return cells[0];
}

}  // namespace

TEST_CASE("stability: every case is a legal scene with legal settings, said in one sentence", "[stability]") {
    std::set<std::string> names, groups;
    std::string group;
    for (const CaseInfo& c : case_infos()) {
        INFO(c.name);
        CHECK(names.insert(c.name).second);
        CHECK(!c.meaning.empty());
        CHECK(c.meaning.back() != '.');
    }
    for (const Case& c : cases()) {
        INFO(c.name);
        const Scene scene = c.scene();
        validate(scene.camera);
        for (const Material& m : scene.materials)
            for (int i = 0; i < 3; ++i) CHECK((m.reflectance[i] >= 0 && m.reflectance[i] <= 1 && m.emission[i] >= 0));
        for (const Mesh& mesh : scene.meshes) {
            CHECK(mesh.material.size() == mesh.triangles.size());
            for (const glm::uvec3& t : mesh.triangles) CHECK(std::max({t.x, t.y, t.z}) < mesh.vertices.size());
        }
        frame::Settings settings = case_settings(c, scene);
        for (const std::string& table : frame::method_tables())
            if (table != "layout") validate_fields(c.name, frame::table_fields(settings, table, c.name));
        CHECK(!frame::plan(scene, settings, frame::rules()).stages.empty());
    }
}

TEST_CASE("stability: scales, offsets and depths are what their names say", "[stability]") {
    glm::vec3 low, high;
    for (const auto& [name, by] : {std::pair{"scale 1e-4", 1e-4}, {"scale 1e6", 1e6}}) {
        const Scene s = case_of(name).scene();
        REQUIRE(bounds(flatten(s), low, high));
        CHECK(high.x - low.x == Approx(2 * by));
        // Irradiance stays: intensity over distance squared.
        CHECK(s.lights[key].intensity.x / (s.lights[key].position.y * s.lights[key].position.y) ==
              Approx(4 / (1.875 * 1.875)));
    }
    for (const auto& [name, by] : {std::pair{"offset 1e3", 1e3}, {"offset 1e7", 1e7}}) {
        REQUIRE(bounds(flatten(case_of(name).scene()), low, high));
        CHECK((low.x == by - 1 && high.x == by + 1 && low.y == by && high.z == by + 1));
    }
    CHECK(case_of("far/near 1e7").scene().camera.far / case_of("far/near 1e7").scene().camera.near == Approx(1e7));
    CHECK(case_of("far infinite, reversed z").scene().camera.reversed_z);
    CHECK(std::isinf(case_of("far infinite, reversed z").scene().camera.far));
}

TEST_CASE("stability: w is 0 at corners, and below 0 behind the eye", "[stability]") {
    const Scene on = case_of("w = 0").scene(), through = case_of("w < 0").scene();
    const Geometry on_plane = flatten(on), through_plane = flatten(through);
    for (const bool camera : {true, false}) {
        const View view = camera ? camera_view(on) : key_view(on);
        int zero = 0, at_eye = 0;
        for (const Vertex& v : on_plane.vertices) {
            const glm::dvec4 c = clip(view, v.position);
            zero += float(c.w) == 0;
            at_eye += glm::dvec3(v.position) == view.eye;
        }
        CHECK(zero >= 3);
        CHECK(at_eye >= 1);

        const View behind = camera ? camera_view(through) : key_view(through);
        int crossing = 0;
        for (const glm::uvec3& t : through_plane.triangles) {
            double least = 1e30, most = -1e30;
            for (int k = 0; k < 3; ++k) {
                const double w = clip(behind, through_plane.vertices[t[k]].position).w;
                least = std::min(least, w), most = std::max(most, w);
            }
            crossing += least < 0 && most > 0;
        }
        CHECK(crossing >= 2);
    }
    // The camera is between the box's sides.
    const Scene inside = case_of("camera inside geometry").scene();
    CHECK(std::abs(inside.camera.position.x - 0.25) < 0.25);
    CHECK((inside.camera.position.y > 0 && inside.camera.position.y < 0.75));
}

TEST_CASE("stability: triangles are huge, flat, thin and twice there", "[stability]") {
    const Scene huge = case_of("guard band").scene();
    const View view = camera_view(huge);
    double farthest = 0;
    for (const Vertex& v : flatten(huge).vertices) {
        const glm::dvec4 c = clip(view, v.position);
        if (c.w > 0) farthest = std::max(farthest, std::abs(c.x / c.w) * huge.frame_size.x / 2);
    }
    CHECK(farthest > 65536);  // pixels: raster/README.md, the guard band

    auto areas = [](const std::string& name) {
        const Geometry g = flatten(case_of(name).scene());
        std::vector<std::pair<double, double>> all;  // area, longest edge
        for (const glm::uvec3& t : g.triangles) {
            const glm::dvec3 a(g.vertices[t.x].position), b(g.vertices[t.y].position), c(g.vertices[t.z].position);
            all.push_back(
                {length(glm::cross(b - a, c - a)) / 2, std::max({length(b - a), length(c - a), length(c - b)})});
        }
        return all;
    };
    auto thinnest = [](const std::vector<std::pair<double, double>>& all, double least) {
        double ratio = 1;
        for (const auto& [area, edge] : all)
            if (area > least) ratio = std::min(ratio, area / (edge * edge));
        return ratio;
    };
    const auto flat = areas("zero area"), thin = areas("slivers");
    CHECK(std::count_if(flat.begin(), flat.end(), [](const auto& t) { return t.first == 0; }) == 3);
    CHECK(thinnest(flat, 0) > 1e-2);
    CHECK(thinnest(thin, 0) < 1e-7);

    const Geometry twice = flatten(case_of("coincident").scene());
    std::multiset<std::array<float, 3>> corners;
    for (const Vertex& v : twice.vertices) corners.insert({v.position.x, v.position.y, v.position.z});
    CHECK(corners.count({-1, 0, 1}) >= 3);  // of the floor, of the floor again, of the left wall
    for (const Vertex& v : flatten(case_of("no normal").scene()).vertices) REQUIRE(v.normal == glm::vec3(0));
}

TEST_CASE("stability: light and view graze the floor under the angle of the name", "[stability]") {
    for (const auto& [name, angle] : {std::pair{"1e-3", 1e-3}, {"1e-6", 1e-6}}) {
        const Scene light = case_of(std::string("light grazing ") + name).scene();
        for (const int l : {key, sun}) {
            const glm::dvec3 d(light.lights[std::size_t(l)].direction);
            CHECK(-d.y / length(d) == Approx(angle));
        }
        const Scene view = case_of(std::string("view grazing ") + name).scene();
        for (const int y : {0, view.frame_size.y - 1}) {
            const Ray ray = ray_through_pixel(view.camera, view.frame_size, {view.frame_size.x / 2, y});
            CHECK(-ray.direction.y > 0.3 * angle);
            CHECK(-ray.direction.y < 1.7 * angle);
        }
    }
    CHECK(case_of("light at 90 degrees").scene().lights[sun].direction.y == 0);
    CHECK(case_of("light at 90 degrees").scene().lights[key].position.y == 0);
    CHECK(case_of("view at 90 degrees").scene().camera.position.y == 0);
}

TEST_CASE("stability: lights are as many and as strong as their case says", "[stability]") {
    auto lights = [](const std::string& name) { return case_of(name).scene().lights; };
    CHECK(lights("no light").empty());
    CHECK(lights("1000 lights").size() == 1000);
    for (const Light& l : lights("black light")) CHECK(l.intensity == glm::vec3(0));
    for (const Light& l : lights("denormal intensity")) CHECK(is_denormal(l.intensity.x));
    for (const auto& [name, by] : {std::pair{"light ratio 1e-6", 1e-6}, {"light ratio 1e8", 1e8}})
        CHECK(lights(name)[key].intensity.y / lights(name)[lamp].intensity.y == Approx(by));
    CHECK(lights("light on a surface")[key].position.y == 0);
    CHECK(lights("light on a surface")[lamp].position.x == -1);
    CHECK(case_of("empty scene").scene().meshes.empty());
    for (const Material& m : case_of("reflectance 0.999999").scene().materials)
        CHECK(m.reflectance == glm::vec3(0.999999f));
}

TEST_CASE("stability: at distance 0 every point coincides with a texel or a light", "[stability]") {
    std::set<std::string> looked_at;
    for (StageData d : room_data()) {
        INFO(d.label);
        if (!case_of("distance 0").edit(d)) continue;
        looked_at.insert(d.stage);
        const std::vector<glm::vec3> x = points(d, "position"), from = anchors(d);
        if (d.stage == "gbuffer" || d.stage == "rsm") {
            for (const glm::vec3& v : points(d, "vertices", 8)) REQUIRE(v == glm::vec3(0));
        } else if (d.stage == "shadow") {
            for (const glm::vec3& p : x) REQUIRE(p == glm::vec3(0));
        } else {
            REQUIRE(!from.empty());
            for (const glm::vec3& p : x) REQUIRE(std::count(from.begin(), from.end(), p) > 0);
        }
    }
    CHECK(looked_at == std::set<std::string>{"gbuffer", "rsm", "shadow", "direct", "rsm.disc", "rsm.paths", "rsm.all"});
}

TEST_CASE("stability: at a distance every texel and light is so far before every surface", "[stability]") {
    for (const auto& [name, distance] : {std::pair{"distance 1e-20", 1e-20}, {"distance 1e20", 1e20}})
        for (StageData d : room_data()) {
            if (d.stage != "direct" && d.stage.rfind("rsm.", 0) != 0) continue;
            INFO(name << " " << d.label);
            REQUIRE(case_of(name).edit(d));
            const std::vector<glm::vec3> x = points(d, "position"), n = points(d, "normal"), from = anchors(d);
            for (const glm::vec3& a : from) REQUIRE(a == from[0]);
            for (std::size_t i = 0; i < x.size(); ++i) {
                if (n[i] == glm::vec3(0)) continue;
                const glm::dvec3 v = glm::dvec3(from[0]) - glm::dvec3(x[i]);
                REQUIRE(length(v) == Approx(distance).margin(0));
                REQUIRE(glm::dot(v, glm::dvec3(n[i])) > 0.99 * length(v));
            }
        }
}

TEST_CASE("stability: denormals reach every input of every stage", "[stability]") {
    // Where a triangle is on the screen stays; the table that decodes bytes and the edges of slots are no numbers of the
    // scene's.
    const std::set<std::string> kept = {"clip_positions", "decode", "edges"};
    for (StageData d : room_data()) {
        INFO(d.label);
        const StageData before = d;
        REQUIRE(case_of("denormals everywhere").edit(d));
        for (std::size_t a = 0; a < d.inputs.arrays.size(); ++a) {
            const Array& now = d.inputs.arrays[a];
            INFO(now.name);
            if (now.dtype != DType::f32 || kept.count(now.name)) {
                CHECK(now.bytes == before.inputs.arrays[a].bytes);
                continue;
            }
            const std::span<float> values = input_floats(d, now.name);
            // A texel of nothing stands for what a stage does not read.
            if (now.shape == Shape{1, 1, 4} && std::all_of(values.begin(), values.end(), [](float v) { return v == 0; })) continue;
            CHECK(std::any_of(values.begin(), values.end(), is_denormal));
            CHECK(std::all_of(values.begin(), values.end(), [](float v) { return std::isfinite(v); }));
        }
    }
}

TEST_CASE("stability: what a layout cannot hold is refused before it is computed", "[stability]") {
    Effort effort;
    effort.pixels = 4, effort.patterns = 2;
    const Cell fits = only(run({"gbuffer", "rgba16f at 65504"}, effort));
    CHECK(!fits.refused);
    CHECK(fits.pixels == 4);
    for (const auto& [name, sentence] :
         {std::pair{"rgba16f at 65520", "gbuffer: positions up to 65.52 km do not fit rgba16f"},
          {"isr, far infinite", "gbuffer: layout \"isr\" divides depth by the far plane, which is infinite"}}) {
        const Cell cell = only(run({"gbuffer", name}, effort));
        CHECK((cell.refused && cell.ok && cell.pixels == 0));
        CHECK_THAT(cell.reason, Contains(sentence));
    }
    // The light's map, which sees nothing so far away, is drawn; what would read a G-buffer that is not there has no
    // cell.
    CHECK(!only(run({"rsm", "rgba16f at 65520"}, effort)).refused);
    for (const char* reader : {"shadow", "direct", "rsm.disc", "rsm.paths", "rsm.all", "compose", "tonemap"})
        CHECK(run({reader, "rgba16f at 65520"}, effort).empty());
}

TEST_CASE("stability: a stage or a case that does not exist is named with the nearest one", "[stability]") {
    CHECK_THROWS_WITH(run({"gbufer", ""}, {}), "unknown stage 'gbufer'; the nearest known one is 'gbuffer'");
    CHECK_THROWS_WITH(run({"", "rooom"}, {}), "unknown case 'rooom'; the nearest known one is 'room'");
}
