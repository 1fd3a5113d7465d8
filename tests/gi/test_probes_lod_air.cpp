// Levels of detail in the air: what is read there is computed, by the light of probes that nothing else asks; what is left out.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <set>

#include "core/hash.h"
#include "gi/frame/kept.h"
#include "gi/frame/probe_bake.h"
#include "gi/frame/rules.h"
#include "gi/probes/basis_kernel.h"
#include "probe_bakes.h"

using namespace plumb;
using namespace plumb::test;
using namespace plumb::probes;
using Catch::Matchers::Contains;

namespace {

// A room of 12 m whose box glows, and a small thing in the middle, 0.8 m before the eye; nothing reflects, so that light on surfaces
// is nothing to the air. Surfaces are 3 m away and more.
Scene room_with_thing(const glm::dvec3& thing = {1, 2.5, 0.8}, float half = 0.2f) {
    Scene scene = furnished(6);
    for (Material& m : scene.materials) m.reflectance = glm::vec3(0);
    scene.materials[1].emission = {3, 2, 1};
    Mesh box;
    add_box(box, glm::vec3(-half), glm::vec3(half), 0);
    box.name = "thing", box.dynamic = true, box.material.assign(box.triangles.size(), 0);
    box.transform[3] = glm::dvec4(thing, 1);
    scene.meshes.push_back(std::move(box));
    scene.camera.position = {1, 2.5, 1.8}, scene.camera.look_at = {1, 2.5, 0.8};
    scene.camera.fov_y_deg = 60, scene.camera.near = 1e-2;
    scene.frame_size = {25, 25}, scene.method = "probes";
    return scene;
}

frame::Settings settings_for(const Scene& scene, int places = 27) {
    frame::Settings settings = frame::settings_of(scene);
    settings.probes = small();
    settings.probes.receivers_per_m2 = 5, settings.probes.spatial_receivers = places, settings.probes.gap = 12;
    settings.probes.cluster_receivers = 32;
    frame::add_bake(scene, settings);
    return settings;
}
frame::Frame frame_of(const Scene& scene, const frame::Settings& settings) {
    return frame::execute(scene, settings, frame::plan(scene, settings), {});
}

// All rays and degrees in each level.
LodParams alike(int levels, float distance) {
    LodParams p;
    p.levels = levels, p.distance_1 = p.distance_2 = p.distance_3 = distance;
    p.rays_0 = p.rays_1 = p.rays_2 = p.rays_3 = 256;
    p.degree_0 = p.degree_1 = p.degree_2 = p.degree_3 = 7;
    return p;
}

struct Compared {
    int pixels = 0, differing = 0, black = 0;
};
// Indirect light of what moves, in all bits.
Compared of_thing(const frame::Frame& a, const frame::Frame& b) {
    Compared n;
    for (std::size_t i = 0; i < a.indirect.size(); ++i) {
        if (a.gbuffer.id.texels[i].x != 1) continue;
        ++n.pixels;
        n.differing += std::memcmp(&a.indirect.texels[i], &b.indirect.texels[i], sizeof(glm::vec4)) != 0;
        n.black += !(a.indirect.texels[i].x > 0);
    }
    return n;
}

std::string reason_of(const frame::Frame& f, const std::string& label) {
    for (const frame::StageRun& s : f.stages)
        if (s.label == label) return s.reason;
    return "";
}

}  // namespace

TEST_CASE("lod in the air: coefficients that only what moves reads are computed", "[probes][lod][air][frame][analytic]") {
    const Scene scene = room_with_thing();
    frame::Settings settings = settings_for(scene);
    const frame::Frame without = frame_of(scene, settings);
    // Surfaces are of level 1 but for few, and probes that they alone ask of a constant radiance; the thing is of level 0: what light it gets has no fewer degrees.
    settings.lod = alike(2, 1.1f);
    settings.lod.degree_1 = 0;
    const frame::Frame with = frame_of(scene, settings);
    CHECK(std::count(with.probes.cluster_level.begin(), with.probes.cluster_level.end(), 1) > 10);
    std::set<std::int32_t> of_surfaces, of_air;  // probes that are read at level 0
    const auto add = [](const FlatClusters& flat, const std::vector<std::int32_t>& level, std::set<std::int32_t>& probes) {
        for (std::size_t c = 0; c < level.size(); ++c)
            if (level[c] == 0) probes.insert(flat.probes.begin() + flat.first_probe[c], flat.probes.begin() + flat.first_probe[c + 1]);
    };
    add(settings.bake->flat, with.probes.cluster_level, of_surfaces), add(settings.bake->spatial.flat, with.probes.air.cluster, of_air);
    CHECK(std::any_of(of_air.begin(), of_air.end(), [&](std::int32_t p) { return of_surfaces.count(p) == 0; }));
    const Compared n = of_thing(with, without);
    CHECK(n.pixels > 100);
    CHECK(n.black == 0);
    CHECK(n.differing == 0);
    CHECK_THAT(reason_of(with, "probes.level"), Contains("8 places in the air for 8 that are read, by clusters of levels 0 to 1: "));
}

TEST_CASE("lod in the air: what is far is lit by its level's degrees, and of levels with all degrees as without", "[probes][lod][air][frame][analytic]") {
    const Scene scene = room_with_thing();
    frame::Settings settings = settings_for(scene);
    const frame::Frame without = frame_of(scene, settings);
    settings.lod = alike(3, 0.1f);
    const frame::Frame full = frame_of(scene, settings);
    CHECK(std::count(full.probes.air.cluster.begin(), full.probes.air.cluster.end(), 2) > 0);
    CHECK(of_thing(full, without).differing == 0);
    // Of degree 0 it is the light of a bake without levels whose probes have degree 0.
    settings.lod.degree_2 = 0;
    const frame::Frame far = frame_of(scene, settings);
    settings.lod = {};
    settings.lod.degree_0 = 0;
    const frame::Frame plain = frame_of(scene, settings);
    const Compared n = of_thing(far, plain);
    CHECK(n.pixels > 100);
    CHECK(n.black == 0);
    CHECK(n.differing == 0);
    CHECK(of_thing(far, without).differing == n.pixels);
}

TEST_CASE("lod in the air: places between those that are computed are linear, and every place that is read is there", "[probes][lod][air][analytic]") {
    // A linear field is itself on every lattice. 200 times three boxes of all sizes, inside of grids of all counts and beyond.
    int thinned = 0, read = 0, wrong = 0;
    for (std::uint32_t round = 0; round < 200; ++round) {
        std::uint32_t salt = 0;
        const auto random = [&] { return float(pcg(round * 1024 + salt++) & 0xffffff) / 16777216.0f; };
        SpatialGrid g;
        g.count = {1 + int(13 * random()), 1 + int(13 * random()), 1 + int(13 * random())};
        g.origin = {-2, 1, -3}, g.spacing = {0.5f, 0.7f, 0.4f};
        std::vector<Box> boxes;
        for (int k = 0; k < 3; ++k) {
            const glm::vec3 size = glm::vec3(random(), random(), random()) * (k == 0 ? 8.0f : 0.6f);
            const glm::vec3 low = glm::vec3(-4, -1, -5) + glm::vec3(random(), random(), random()) * 9.0f;
            boxes.push_back({low, low + size});
        }
        const AirReads reads = air_reads(g, boxes);
        std::vector<std::int32_t> level;
        for (std::size_t i = 0; i < reads.cell.size(); ++i) level.push_back(int(4 * random()));
        const AirLevels levels = air_levels(g, reads, level, {}, 0);
        const auto field = [&](std::size_t place, std::size_t d) {
            const int i = int(place);
            return 3 + float(d) + 0.5f * float(i % g.count.x) - 0.25f * float(i / g.count.x % g.count.y) + float(i / (g.count.x * g.count.y));
        };
        Buffer<glm::vec4> grid(std::size_t(g.places()) * 6, glm::vec4(std::nanf("")));
        for (std::size_t place = 0; place < std::size_t(g.places()); ++place)
            for (std::size_t d = 0; d < 6 && levels.place[place] != no_level; ++d) grid[place * 6 + d] = glm::vec4(glm::vec3(field(place, d)), 1);
        fill_air(g, levels.place, grid);
        const std::vector<std::uint8_t> active = active_places(g, boxes);
        for (std::size_t place = 0; place < active.size(); ++place) {
            if (!active[place]) continue;
            ++read, thinned += levels.place[place] == no_level;
            for (std::size_t d = 0; d < 6; ++d) wrong += !(std::fabs(grid[place * 6 + d].y - field(place, d)) < 1e-5f * 30);
        }
        // Of a lattice there are no more places than of the grid.
        for (const Box& box : boxes) {
            const AirReads one = air_reads(g, {box});
            const AirLevels coarse = air_levels(g, one, std::vector<std::int32_t>(one.cell.size(), 3), {}, 0);
            const std::vector<std::uint8_t> fine = active_places(g, {box});
            CHECK(std::ptrdiff_t(coarse.place.size()) - std::count(coarse.place.begin(), coarse.place.end(), no_level) <= std::count(fine.begin(), fine.end(), 1));
        }
    }
    CHECK(read > 5000);
    CHECK(thinned > 1000);
    CHECK(wrong == 0);
}

TEST_CASE("lod in the air: of what is read in a cell nothing is finer than the cell, and a small thing has the eight places about it",
          "[probes][lod][air][property]") {
    const SpatialGrid g{{9, 7, 8}, {-4, -3, -4}, {1, 1, 1}};
    LodParams params;
    params.levels = 4, params.distance_1 = 1.5f, params.distance_2 = 3, params.distance_3 = 5, params.zones = true;
    const Lod lod = lod_of(params, 14, 7, 512, 24);
    int asked = 0, finer = 0, far = 0, small_thinned = 0;
    for (std::uint32_t round = 0; round < 200; ++round) {
        std::uint32_t salt = 0;
        const auto random = [&] { return float(pcg(round * 2048 + salt++) & 0xffffff) / 16777216.0f; };
        const auto random_point = [&](float half) { return (glm::vec3(random(), random(), random()) * 2.0f - 1.0f) * half; };
        const bool large = round % 2 == 0;
        const glm::vec3 low = random_point(4.5f), size = glm::vec3(random(), random(), random()) * (large ? 4.0f : 0.9f);
        const Box box{low, low + size};
        const LevelRule rule = rule_at(lod, random_point(4), random_point(1));
        const AirReads reads = air_reads(g, {box});
        std::vector<std::int32_t> level;
        run(LevelInputs{&reads.low, &reads.high, rule}, {}, level);
        const AirLevels levels = air_levels(g, reads, level, {}, 0);
        for (int k = 0; k < 40; ++k) {
            const glm::vec3 x = low + size * glm::vec3(k % 2 ? random() : float(k & 4) / 4, random(), k % 3 ? random() : 1.0f);
            const int own = level_at(rule, x).level;
            const auto cx = grid_cell<float>(x.x, -4, 1, 9), cy = grid_cell<float>(x.y, -3, 1, 7), cz = grid_cell<float>(x.z, -4, 1, 8);
            ++asked;
            bool found = false;
            for (std::size_t i = 0; i < reads.cell.size(); ++i)
                if (reads.cell[i] == glm::ivec3(cx.first, cy.first, cz.first)) found = true, finer += own < level[i], far += level[i] > 0;
            REQUIRE(found);
        }
        const std::vector<std::uint8_t> active = active_places(g, {box});
        if (!large)
            for (std::size_t i = 0; i < active.size(); ++i) small_thinned += (levels.place[i] != no_level) != (active[i] != 0);
    }
    CHECK(asked == 8000);
    CHECK(finer == 0);
    CHECK(far > 1000);
    CHECK(small_thinned == 0);
}

TEST_CASE("lod in the air: in a furnace static surfaces with normal maps find the same light from every lattice", "[probes][lod][air][frame][analytic][furnace]") {
    // All surfaces emit M and reflect nothing: E is M in the air, of all degrees and places.
    Scene scene = empty_room();
    scene.materials[0].emission = glm::vec3(2), scene.materials[0].reflectance = glm::vec3(0);
    scene.meshes[0].tangents.assign(scene.meshes[0].vertices.size(), glm::vec4(1, 0, 0, 1));
    Texture bent;
    bent.name = "bent", bent.srgb = false, bent.filter = Filter::nearest, bent.texels = Image<std::uint32_t>(1, 1, 0xffff80a0u);
    scene.textures = {bent}, scene.materials[0].normal_texture = 0;
    scene.camera.position = {0, 0.2, 0.5}, scene.camera.look_at = {0, 0, -1}, scene.camera.near = 1e-2, scene.camera.fov_y_deg = 80;
    scene.frame_size = {21, 21}, scene.method = "probes";
    frame::Settings settings = settings_for(scene, 64);
    settings.lod.levels = 4, settings.lod.distance_1 = settings.lod.distance_2 = settings.lod.distance_3 = 0;
    const frame::Frame f = frame_of(scene, settings);
    // 4 x 4 x 4 places, of each axis the first and the last.
    CHECK_THAT(reason_of(f, "probes.level"), Contains("8 places in the air for 64 that are read, by clusters of levels 0 to 3: 0, 0, 0, "));
    int seen = 0;
    for (const glm::vec4& e : f.probes.relief.fixed.irradiance.texels) {
        if (e.w == 0) continue;
        ++seen;
        CHECK(e.x == Approx(2).epsilon(0.02));
    }
    CHECK(seen > 400);
}

TEST_CASE("pruning: for what moves and is not in view no place in the air is computed, and no bit changes", "[probes][frame][pruning][air]") {
    for (const Loop loop : {Loop::converged, Loop::pipelined})
        for (const int levels : {1, 3}) {
            Scene scene = room_with_thing();
            Mesh behind = scene.meshes[1];
            behind.name = "behind", behind.transform[3] = glm::dvec4(0.9, 2.4, 4, 1);
            scene.meshes.push_back(behind);
            frame::Settings settings = settings_for(scene, 64);
            settings.lod.levels = levels, settings.probe_run.loop = loop;
            const frame::Plan plan = frame::plan(scene, settings);
            CHECK(plan.unseen == std::vector<int>{2});
            const auto active = [&](const frame::Frame& f) { return std::count_if(f.probes.spatial_active.begin(), f.probes.spatial_active.end(), [](int a) { return a >= 0; }); };
            frame::Settings all = settings;
            all.pruning = false;
            const frame::Plan whole = frame::plan(scene, all);
            CHECK(whole.unseen.empty());
            frame::KeptStages kept, kept_whole;
            // The eye turns round: the other thing is seen, and the first is not.
            for (const double z : {0.0, 0.2, 2.0, 6.0}) {
                scene.camera.look_at.z = z;
                const frame::Frame& f = frame::execute(scene, settings, frame::plan(scene, settings), {}, kept);
                const frame::Frame& w = frame::execute(scene, all, frame::plan(scene, all), {}, kept_whole);
                CHECK(active(f) == 6 * 8);
                CHECK(active(w) == 6 * 12);  // of two cells with a face in common
                CHECK(std::memcmp(f.radiance.data(), w.radiance.data(), f.radiance.size() * sizeof(glm::vec4)) == 0);
                CHECK(std::memcmp(f.indirect.data(), w.indirect.data(), f.indirect.size() * sizeof(glm::vec4)) == 0);
                CHECK(std::any_of(f.gbuffer.id.texels.begin(), f.gbuffer.id.texels.end(), [&](glm::ivec2 id) { return id.x == (z < 1 ? 1 : 2); }));
            }
            std::string told;
            for (const frame::PlannedStage& s : plan.stages)
                if (s.label == "probes.active") told = s.reason;
            CHECK_THAT(told, Contains("1 left out: each is not in view"));
            // Where shadows or static surfaces ask the air, too, it is computed.
            settings.probe_run.indirect_shadow = IndirectShadow::uniform;
            CHECK(frame::plan(scene, settings).unseen.empty());
        }
    // A rule that always holds leaves what is seen black.
    const Scene scene = room_with_thing();
    const frame::Settings settings = settings_for(scene);
    std::vector<frame::Rule> broken = frame::rules();
    for (frame::Rule& rule : broken)
        if (rule.name == "mesh-unseen") rule.holds = [](const frame::PlanFacts&, const frame::Work&) { return true; };
    const frame::Frame f = frame::execute(scene, settings, frame::plan(scene, settings, broken), {});
    const Compared n = of_thing(f, frame_of(scene, settings));
    CHECK((n.black == n.pixels && n.differing == n.pixels && n.pixels > 100));
}
