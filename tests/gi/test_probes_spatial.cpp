// Spatial receivers: the grid, what its receivers gather, which of them are asked.
#include <catch2/catch.hpp>
#include <set>

#include "core/error.h"
#include "core/formats.h"
#include "core/hash.h"
#include "gi/graph/memory_store.h"
#include "gi/probes/kept_steps.h"
#include "gi/probes/run_data.h"
#include "gi/probes/update.h"
#include "gi/probes/volume.h"
#include "probe_bakes.h"

using namespace plumb;
using namespace plumb::probes;
using namespace plumb::test;

namespace {

BakeParams with_places(int wanted, SpatialWeight weight = SpatialWeight::corrected) {
    BakeParams p = small();
    p.receivers_per_m2 = 1, p.spatial_receivers = wanted, p.spatial_weight = weight;
    return p;
}

// E_d of each spatial receiver, by the un-truncated transport.
std::vector<glm::dvec3> spatial_irradiance(const Bake& b, const std::vector<glm::dvec3>& lambda) {
    return irradiance(b.spatial.supports, b.spatial.alpha, b.params.degree, lambda);
}

// Two quads of a centimetre in the sky, 4 m apart.
Scene specks() {
    Mesh quads;
    for (const glm::vec3 at : {glm::vec3(-1, -1.5f, -1), glm::vec3(1, 1.5f, 1)})
        add_quad(quads, at, at + glm::vec3(0, 0, 0.01f), at + glm::vec3(0.01f, 0, 0), 0);
    Scene scene = scene_of(quads);
    scene.environment.radiance = glm::vec3(1);
    return scene;
}

}  // namespace

TEST_CASE("spatial grid: IPR (1) to (3), by hand", "[probes][spatial][IPR 4.1.1][analytic]") {
    const auto count = [](glm::vec3 size, int n) { return spatial_grid(glm::vec3(1), glm::vec3(1) + size, n).count; };
    CHECK(count({2, 2, 2}, 8) == glm::ivec3(2));
    CHECK(count({3, 3, 3}, 27) == glm::ivec3(3));
    CHECK(count({3, 3, 3}, 1000) == glm::ivec3(10));
    // N_z = ceil(cbrt(9)) = 3, N_y = ceil(sqrt(9 / 3)) = 2, N_x = ceil(9 / 6) = 2.
    CHECK(count({1, 1, 1}, 9) == glm::ivec3(2, 2, 3));
    // N_z = ceil(cbrt(8 / 8)) = 1, N_y = ceil(sqrt(8 2 / 4)) = 2, N_x = 8 / 2.
    CHECK(count({4, 2, 1}, 8) == glm::ivec3(4, 2, 1));
    // N_z = ceil(cbrt(100 16 / 2)) = ceil(9.28), N_y = ceil(sqrt(100 2 / 10)) = ceil(4.47), N_x = 100 / 50.
    CHECK(count({1, 2, 4}, 100) == glm::ivec3(2, 5, 10));
    CHECK(count({1, 1, 1}, 1) == glm::ivec3(1));
    // Sides that differ by the rounding of a float are equal.
    CHECK(count({3, 3.0000004f, 3}, 27) == glm::ivec3(3));

    const SpatialGrid g = spatial_grid({-1, 0, 2}, {3, 2, 3}, 8);
    CHECK(g.count == glm::ivec3(4, 2, 1));
    CHECK(g.origin == glm::vec3(-0.5f, 0.5f, 2.5f));
    CHECK(g.spacing == glm::vec3(1));
    const SpatialGrid faces = spatial_grid({-1, 0, 2}, {3, 2, 3}, 8, 0);
    CHECK(faces.origin == glm::vec3(-1, 0, 2.5f));
    CHECK((faces.spacing.x == Approx(4.0 / 3) && faces.spacing.y == 2));
    // A floor: one place high.
    const SpatialGrid floor = spatial_grid({0, 0, 0}, {10, 0, 10}, 100);
    CHECK(floor.count.y == 1);
    CHECK(floor.places() >= 100);
    CHECK((floor.spacing.y > 0 && floor.origin.y == 0));
    CHECK_THROWS_AS(spatial_grid(glm::vec3(1), glm::vec3(1), 8), InputError);
    CHECK_THROWS_AS(spatial_grid(glm::vec3(0), glm::vec3(std::nanf("")), 8), InputError);
    CHECK_THROWS_AS(spatial_grid(glm::vec3(0), glm::vec3(1), 0), InputError);
}

TEST_CASE("spatial receivers: in a furnace E is pi L at every place, in all six directions", "[probes][spatial][analytic][furnace]") {
    // Of an empty room probes see all, so that each is exact; of a furnished one nearly all.
    for (const auto& [scene, weight] : {std::pair(empty_room(), SpatialWeight::corrected), std::pair(empty_room(), SpatialWeight::published),
                                        std::pair(furnished(), SpatialWeight::corrected)}) {
        BakeParams params = with_places(27, weight);
        params.receiver_rays = 512;
        BakeGraph graph(scene, params);
        run_all(graph);
        const Bake& b = graph.bake();
        REQUIRE(b.spatial.grid.count == glm::ivec3(3));
        REQUIRE(b.spatial.receivers.count() == 162);
        const std::vector<glm::dvec3> e = spatial_irradiance(b, lambda_of(b, [](std::size_t) { return 0.5; }));
        // What no probe sees is lost, and told by the counts; the weights' own sum is pi, or nearly 2 pi - 4.
        double lost = 0, most = 0;
        for (const RayCounts& c : b.spatial.block_counts) lost += double(c.unseen + c.back + c.escaped) / (162 * 512);
        const double whole = weight == SpatialWeight::corrected ? host::pi : 2 * host::pi - 4;
        CAPTURE(lost, whole);
        CHECK(lost < (scene.meshes[0].triangles.size() == 12 ? 1e-9 : 0.05));
        double mean = 0;
        for (const glm::dvec3& one : e) {
            CHECK(one.x < 0.5 * whole * 1.003);
            mean += one.x / double(e.size()), most = std::max(most, one.x);
        }
        CHECK(mean == Approx(0.5 * whole).epsilon(0.003 + lost));
        CHECK(most == Approx(0.5 * whole).epsilon(0.003));
        if (lost > 0) continue;
        for (const glm::dvec3& one : e) CHECK(one.x == Approx(0.5 * whole).epsilon(weight == SpatialWeight::corrected ? 2e-5 : 0.003));
    }
}

TEST_CASE("spatial receivers: radiance a + b . w arrives as pi a + 2 pi / 3 b . d", "[probes][spatial][analytic]") {
    // Of the sky alone: rays of receivers and of probes escape in the same directions.
    const Scene scene = specks();
    BakeParams params = with_places(8);
    params.receiver_rays = 2048, params.placement.count = 2, params.lightmap_size = 16;
    BakeGraph graph(scene, params);
    run_all(graph);
    const Bake& b = graph.bake();
    // Places are metres away from probes; those have a radius that reaches them.
    CHECK(b.spatial.radius > 1);
    CHECK(b.spatial.supports.unsupported == 0);
    const glm::dvec3 slope(0.5, -0.3, 0.2);
    std::vector<glm::dvec3> f;
    for (std::size_t k = 0; k < b.relight.material.size(); ++k) {
        const glm::vec4 d = b.relight_directions[k % std::size_t(b.relight.rays)];
        f.emplace_back(1 + glm::dot(slope, glm::dvec3(d)));
    }
    const std::vector<glm::dvec3> lambda = probe_coefficients(f, b.relight.probes, b.relight_weights, b.harmonics, b.params.degree);
    const std::vector<glm::dvec3> e = spatial_irradiance(b, lambda);
    REQUIRE(e.size() == 6 * std::size_t(b.spatial.grid.places()));
    for (std::size_t i = 0; i < e.size(); ++i) {
        const glm::dvec3 d(spatial_direction(int(i) / b.spatial.grid.places()));
        CHECK(e[i].x == Approx(host::pi + 2 * host::pi / 3 * glm::dot(slope, d)).epsilon(0.01));
    }
}

TEST_CASE("spatial receivers: places inside of solids and beyond walls are moved into the room", "[probes][spatial][IPR 4.1.1]") {
    // A block fills the middle of a room; 4 x 4 x 4 places, of which the inner 8 lie in it.
    Mesh mesh;
    add_box(mesh, glm::vec3(-2), glm::vec3(2), 0, true);
    add_box(mesh, glm::vec3(-0.9f), glm::vec3(0.9f), 1);
    const Scene block = scene_of(mesh);
    BakeGraph graph(block, with_places(64));
    run_all(graph);
    const Spatial& s = graph.bake().spatial;
    REQUIRE(s.grid.count == glm::ivec3(4));
    CHECK(s.shifted == 8);
    for (int i = 0; i < s.receivers.count(); ++i) {
        const glm::vec3 at(s.receivers.position[std::size_t(i)]), was = at - glm::vec3(s.receivers.shift[std::size_t(i)]);
        const bool inside = glm::all(glm::lessThan(glm::abs(was), glm::vec3(0.9f)));
        CHECK((s.receivers.shift[std::size_t(i)].w == 1) == inside);
        const float out = std::max({std::fabs(at.x), std::fabs(at.y), std::fabs(at.z)});
        CHECK((out > 0.9f && out < 2));
        if (inside) CHECK(out < 0.91f);  // just beyond its face
        CHECK(glm::vec3(s.receivers.normal[std::size_t(i)]) == spatial_direction(i / s.grid.places()));
    }
    // Two rooms that are a metre apart: what lies between sees backs on both sides and the sky beside, and moves into one.
    Mesh two;
    add_box(two, {-3, -1, -1}, {-0.5f, 1, 1}, 0, true), add_box(two, {0.5f, -1, -1}, {3, 1, 1}, 0, true);
    const Scene rooms = scene_of(two);
    BakeParams params = with_places(3);
    params.spatial_back_share = 0.8f;
    BakeGraph between(rooms, params);
    run_all(between);
    const Spatial& t = between.bake().spatial;
    REQUIRE(t.grid.count == glm::ivec3(3, 1, 1));
    CHECK(t.shifted == 1);
    CHECK(t.receivers.shift[1].w == 1);
    CHECK(std::fabs(t.receivers.position[1].x) > 0.5f);
    // Not asked, nothing moves.
    params.test_rays = 0;
    BakeGraph still(rooms, params);
    run_all(still);
    CHECK(still.bake().spatial.shifted == 0);
}

TEST_CASE("spatial receivers: clustered a direction at a time, and then the same irradiance", "[probes][spatial]") {
    const Scene scene = furnished();
    BakeParams params = with_places(64);
    params.degree = 3, params.singular_values = 64, params.cluster_receivers = 16;
    BakeGraph graph(scene, params);
    run_all(graph);
    const Bake& b = graph.bake();
    const int places = b.spatial.grid.places();
    REQUIRE(b.spatial.flat.cluster_of.size() == std::size_t(6 * places));
    for (const Cluster& c : b.spatial.clusters.clusters) {
        std::set<int> directions;
        for (const std::int32_t r : c.receivers) directions.insert(r / places);
        CHECK(directions.size() == 1);
    }
    const std::vector<glm::dvec3> lambda = lambda_of(b, [](std::size_t k) { return 1 + double(k % 7); });
    const std::vector<glm::dvec3> whole = spatial_irradiance(b, lambda);
    // The run time's way: basis and irradiance as stages, all places active, then some.
    const ClusterData data = cluster_data(b.spatial.flat, 6 * places, b.coefficients());
    const std::vector<std::int32_t> cluster_level(data.clusters.size(), 0);
    Buffer<glm::vec4> lambdas;
    for (const glm::dvec3& l : lambda) lambdas.push_back(glm::vec4(glm::vec3(l), 0));
    BasisInputs basis{.clusters = &data, .cluster_level = cluster_level.data(), .lambda = lambdas.data(), .probes = b.relight.probes};
    Buffer<glm::vec4> of_clusters;
    run(basis, {}, of_clusters);
    const auto grid_of = [&](const std::vector<Box>& boxes) {
        const std::vector<std::int32_t> levels = active_levels(b.spatial.grid, active_places(b.spatial.grid, boxes), data.receiver);
        Buffer<glm::vec4> found, grid;
        run(IrradianceInputs{&data, cluster_level.data(), levels.data(), of_clusters.data()}, {}, found);
        gather_grid(b.spatial.grid, data.receiver, found, grid);
        return grid;
    };
    const Buffer<glm::vec4> all = grid_of({{glm::vec3(-9), glm::vec3(9)}});
    double worst = 0, largest = 0;
    for (int d = 0; d < 6; ++d)
        for (int i = 0; i < places; ++i) {
            const double e = whole[std::size_t(d * places + i)].x;
            CHECK(all[std::size_t(i * 6 + d)].w == 1);
            worst = std::max(worst, std::fabs(double(all[std::size_t(i * 6 + d)].x) - e)), largest = std::max(largest, std::fabs(e));
        }
    CHECK(largest > 3);
    CHECK(worst < 0.01 * largest);

    // A thing in a corner: few places are computed, and what is seen of it has the same bits.
    const Box thing{{-1.3f, -1.4f, -1.2f}, {-0.6f, -0.7f, -0.5f}};
    const Buffer<glm::vec4> few = grid_of({thing});
    int computed = 0;
    for (const glm::vec4& e : few) computed += e.w == 1 ? 1 : 0;
    CHECK((computed >= 6 * 8 && computed <= 6 * 27));
    Image4 position(64, 1), normal(64, 1), uv(64, 1, glm::vec4(-1));
    for (int i = 0; i < 64; ++i) {
        const glm::vec3 t(float(i & 3) / 3, float(i >> 2 & 3) / 3, float(i >> 4) / 3);  // its corners, too
        position(i, 0) = glm::vec4(thing.low + t * (thing.high - thing.low), 0);
        normal(i, 0) = glm::vec4(glm::normalize(t - glm::vec3(0.4f)), 1);
    }
    const auto seen = [&](const Buffer<glm::vec4>& grid) {
        VolumeInputs in;
        in.grid = b.spatial.grid, in.position = &position, in.normal = &normal, in.lightmap_uv = &uv, in.irradiance = &grid;
        VolumeLight out;
        run(in, {}, out);
        return out;
    };
    const VolumeLight by_all = seen(all), by_few = seen(few);
    CHECK(by_all.irradiance.texels == by_few.irradiance.texels);
    CHECK(by_all.light.texels == by_few.light.texels);
    CHECK(by_all.from_light.texels == by_few.from_light.texels);
    CHECK(by_few.irradiance(0, 0).x > 1);
    // Clusters without an active place read nothing of their matrix and change nothing.
    const std::vector<std::int32_t> levels = active_levels(b.spatial.grid, active_places(b.spatial.grid, {thing}), data.receiver);
    const std::vector<std::int32_t> some = active_clusters(levels, data.cluster, data.clusters.size());
    const auto idle = std::count(some.begin(), some.end(), no_level);
    CHECK((idle > 0 && idle < std::ptrdiff_t(some.size())));
    for (std::size_t i = 0; i < levels.size(); ++i)
        if (levels[i] >= 0) CHECK(some[std::size_t(data.cluster[i])] == 0);
    ClusterData untouched = data;
    for (std::size_t c = 0; c < some.size(); ++c)
        if (some[c] == no_level) {
            const glm::ivec4 of = data.clusters[c];
            std::fill_n(untouched.matrix.begin() + of.x, of.z * data.coefficients * of.w, std::nanf(""));
        }
    basis.clusters = &untouched, basis.cluster_level = some.data();
    run(basis, {}, of_clusters);
    Buffer<glm::vec4> found, of_some;
    run(IrradianceInputs{&untouched, some.data(), levels.data(), of_clusters.data()}, {}, found);
    gather_grid(b.spatial.grid, data.receiver, found, of_some);
    CHECK(of_some == few);
    // With one place fewer they would not be.
    Buffer<glm::vec4> fewer = few;
    for (std::size_t i = 0; i < fewer.size(); i += 6)
        if (fewer[i].w == 1) {
            for (std::size_t d = 0; d < 6; ++d) fewer[i + d] = glm::vec4(0);
            break;
        }
    CHECK(seen(fewer).irradiance.texels != by_all.irradiance.texels);
}

TEST_CASE("spatial receivers: which places dynamic objects ask for", "[probes][spatial][IPR 4.1.1]") {
    const SpatialGrid g{{5, 4, 3}, {0, 0, 0}, {1, 1, 1}};
    using Places = std::set<std::vector<int>>;
    const auto asked = [&](const std::vector<Box>& boxes) {
        Places places;
        const std::vector<std::uint8_t> active = active_places(g, boxes);
        REQUIRE(active.size() == 60);
        for (int i = 0; i < 60; ++i)
            if (active[std::size_t(i)]) places.insert({i % 5, i / 5 % 4, i / 20});
        return places;
    };
    const auto block = [](glm::ivec3 low, glm::ivec3 high) {
        Places places;
        for (int z = low.z; z <= high.z; ++z)
            for (int y = low.y; y <= high.y; ++y)
                for (int x = low.x; x <= high.x; ++x) places.insert({x, y, z});
        return places;
    };
    CHECK(asked({}).empty());
    // In one cell: its 8 corners.
    CHECK(asked({{{1.2f, 2.3f, 0.4f}, {1.7f, 2.6f, 0.8f}}}) == block({1, 2, 0}, {2, 3, 1}));
    // In two cells along x.
    CHECK(asked({{{1.2f, 2.3f, 0.4f}, {2.7f, 2.6f, 0.8f}}}) == block({1, 2, 0}, {3, 3, 1}));
    // With a face on a plane of places: the cells on both sides.
    CHECK(asked({{{2, 2.3f, 0.4f}, {2.7f, 2.6f, 0.8f}}}) == block({1, 2, 0}, {3, 3, 1}));
    CHECK(asked({{{1.3f, 2.3f, 0.4f}, {2, 2.6f, 0.8f}}}) == block({1, 2, 0}, {3, 3, 1}));
    // Beyond the grid: those of its edge, which a lookup there reads.
    CHECK(asked({{{9, 2.3f, 0.4f}, {10, 2.6f, 0.8f}}}) == block({4, 2, 0}, {4, 3, 1}));
    CHECK(asked({{{-7, -8, -9}, {-5, -5, -5}}}) == block({0, 0, 0}, {1, 1, 1}));
    // Around all of it; two things.
    CHECK(asked({{glm::vec3(-1), glm::vec3(9)}}).size() == 60);
    CHECK(asked({{{0.2f, 0.3f, 0.4f}, {0.7f, 0.6f, 0.8f}}, {{3.2f, 2.3f, 1.4f}, {3.7f, 2.6f, 1.8f}}}).size() == 16);
    CHECK_THROWS_AS(active_places(g, {{glm::vec3(0), glm::vec3(std::nanf(""))}}), InputError);
    CHECK(active_places(SpatialGrid{}, {{glm::vec3(0), glm::vec3(1)}}).empty());

    // Boxes are those of dynamic meshes, in world space.
    Scene scene = furnished();
    scene.meshes.push_back(scene.meshes[0]);
    scene.meshes[1].dynamic = true;
    scene.meshes[1].transform = glm::dmat4(0, 0.5, 0, 0, -0.5, 0, 0, 0, 0, 0, 0.5, 0, 3, 4, 5, 1);  // halved, turned about z, moved
    const std::vector<Box> boxes = dynamic_boxes(scene);
    REQUIRE(boxes.size() == 1);
    CHECK(boxes[0].low == glm::vec3(2, 3, 4));
    CHECK(boxes[0].high == glm::vec3(4, 5, 6));
}

TEST_CASE("spatial receivers: places that positions rounded to half floats read are computed, too", "[probes][spatial][IPR 4.1.1][property]") {
    // A G-buffer of half floats moves a corner of a box across a plane of places, by 2^-12 of its coordinate at most.
    const SpatialGrid g{{9, 9, 9}, {-0.7013f, 0.1001f, 3.3307f}, {1.1f, 0.9f, 1.3f}};
    const auto half = [](float x) { return half_to_float(float_to_half(x)); };
    int missing = 0, moved = 0;
    for (std::uint32_t round = 0; round < 4000; ++round) {
        std::uint32_t salt = 0;
        const auto random = [&] { return float(pcg(round * 64 + salt++) & 0xffffff) / 16777216.0f; };
        Box box;
        for (int c = 0; c < 3; ++c) {
            // Within a thousandth of a coordinate beside a plane.
            const float plane = g.origin[c] + g.spacing[c] * float(1 + int(7 * random()));
            const float beside = plane + 1e-3f * (random() - 0.5f) * std::fabs(plane);
            const float size = 0.8f * random();
            box.low[c] = round % 2 ? beside : beside - size, box.high[c] = round % 2 ? beside + size : beside;
        }
        const std::vector<std::uint8_t> active = active_places(g, {box});
        for (int corner = 0; corner < 8; ++corner) {
            glm::ivec3 first, exact;
            for (int c = 0; c < 3; ++c) {
                const float x = (corner >> c & 1) != 0 ? box.high[c] : box.low[c];
                first[c] = grid_cell<float>(half(x), g.origin[c], g.spacing[c], 9).first, exact[c] = grid_cell<float>(x, g.origin[c], g.spacing[c], 9).first;
            }
            moved += first != exact;
            for (int k = 0; k < 8; ++k) {
                const glm::ivec3 at = glm::min(first + glm::ivec3(k & 1, k >> 1 & 1, k >> 2), glm::ivec3(8));
                missing += !active[std::size_t(at.x + 9 * (at.y + 9 * at.z))];
            }
        }
    }
    CHECK(moved > 1000);
    CHECK(missing == 0);
}

TEST_CASE("spatial receivers: what a bake knows of surfaces is the same with them and without", "[probes][spatial][graph]") {
    const Scene scene = furnished();
    BakeParams params = with_places(64);
    params.receiver_rays = 16;
    BakeParams none = params;
    none.spatial_receivers = 0;
    graph::MemoryStore store, other;
    graph::RunWith with;
    with.store = &store;
    BakeGraph without(scene, none), first(scene, params), again(scene, params);
    for (const graph::NodeRun& r : graph::run(without.nodes(), with)) CHECK_FALSE(r.kept);
    CHECK(without.bake().spatial.empty());
    std::set<std::string> made;
    for (const graph::NodeRun& r : graph::run(first.nodes(), with))
        if (!r.kept) made.insert(r.label);
    CHECK(made == std::set<std::string>{"probes.spatial", "probes.coefficients (spatial receivers 0 to 383)",
                                        "probes.clusters (spatial receivers)"});
    for (const graph::NodeRun& r : graph::run(again.nodes(), with)) {
        INFO(r.label);
        CHECK(r.kept);
    }
    const auto content_of = [](const Bake& b) {
        return std::vector<std::uint64_t>{content_hash(lent(b.spatial)), content_hash(lent(b.spatial.flat)),
                                          content_hash(b.spatial.alpha.data(), b.spatial.alpha.size() * 4)};
    };
    CHECK(content_of(again.bake()) == content_of(first.bake()));
    CHECK(again.bake().spatial.grid.count == glm::ivec3(4));
    // Parts do their own blocks, and what is joined has the same bits.
    graph::RunWith apart;
    apart.store = &other;
    for (const int part : {1, 0}) {
        BakeGraph of_two(scene, params, {part, 2});
        graph::run(of_two.nodes(), apart);
    }
    BakeGraph joined(scene, params);
    made.clear();
    for (const graph::NodeRun& r : graph::run(joined.nodes(), apart))
        if (!r.kept) made.insert(r.label);
    CHECK(made == std::set<std::string>{"probes.clusters", "probes.clusters (spatial receivers)"});
    CHECK(content_of(joined.bake()) == content_of(first.bake()));
    // Another weight is another transport of the same places.
    params.spatial_weight = SpatialWeight::published;
    BakeGraph published(scene, params);
    made.clear();
    for (const graph::NodeRun& r : graph::run(published.nodes(), with))
        if (!r.kept) made.insert(r.label);
    CHECK(made == std::set<std::string>{"probes.coefficients (spatial receivers 0 to 383)", "probes.clusters (spatial receivers)"});
    // What does not fit is not taken.
    Spatial taken;
    Bundle kept = lent(first.bake().spatial);
    take(kept, taken);
    CHECK(taken.receivers.position == first.bake().spatial.receivers.position);
    for (std::size_t i = 0; i < kept.arrays.size(); ++i) {
        Bundle less = kept;
        less.arrays.erase(less.arrays.begin() + std::ptrdiff_t(i));
        CHECK_THROWS_AS(take(less, taken), InputError);
    }
    Spatial shorter = first.bake().spatial;
    shorter.receivers.normal.pop_back();
    CHECK_THROWS_AS(take(lent(shorter), taken), InputError);
}

TEST_CASE("spatial receivers: the same bits for every instruction set and number of threads", "[probes][spatial][bits]") {
    const Scene scene = furnished();
    BakeParams params = with_places(64);
    params.receiver_rays = 32;
    std::uint64_t first = 0;
    for (const Isa isa : supported_isas())
        for (const int threads : {1, 3}) {
            RunOptions options;
            options.isa = isa, options.threads = threads;
            BakeGraph graph(scene, params);
            run_all(graph, options);
            const Spatial& s = graph.bake().spatial;
            const std::uint64_t hash = content_hash(lent(s.flat), content_hash(lent(s), content_hash(s.alpha.data(), s.alpha.size() * 4)));
            if (first == 0) first = hash;
            CHECK(hash == first);
        }
}
