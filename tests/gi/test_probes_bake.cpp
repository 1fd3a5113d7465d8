// Whole bakes: the graph's steps, parts, bits, refusals.
#include <Eigen/SVD>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <set>

#include "core/error.h"
#include "gi/graph/memory_store.h"
#include "gi/probes/bake.h"
#include "gi/probes/debug_layers.h"
#include "gi/probes/kept_steps.h"
#include "gi/reference/ray_query.h"
#include "probe_bakes.h"

using namespace plumb;
using namespace plumb::probes;
using namespace plumb::test;

TEST_CASE("bake: full rank gives back the transport as it was", "[probes]") {
    BakeParams params = small();
    params.receivers_per_m2 = 2, params.degree = 1, params.singular_values = 64, params.cluster_receivers = 65;
    Scene scene = furnished();
    BakeGraph graph(scene, params);
    run_all(graph);
    const Bake& b = graph.bake();
    double worst = 0, largest = 0;
    for (const Cluster& c : b.clusters.clusters) {
        REQUIRE(c.rank == int(c.spectrum.size()));
        for (const std::int32_t i : c.receivers)
            for (std::size_t p = 0; p < c.probes.size(); ++p)
                for (int j = 0; j < 4; ++j) {
                    double made = 0, given = 0;
                    for (int k = 0; k < c.rank; ++k)
                        made += double(b.clusters.u[std::size_t(i * 64 + k)]) *
                                double(c.sigma_vt[(std::size_t(k) * c.probes.size() + p) * 4 + std::size_t(j)]);
                    for (int s = 0; s < b.supports.overlaps; ++s)
                        if (b.supports.probe[std::size_t(i * b.supports.overlaps + s)] == c.probes[p])
                            given = double(b.alpha[std::size_t((i * b.supports.overlaps + s) * 4 + j)]);
                    worst = std::max(worst, std::fabs(made - given)), largest = std::max(largest, std::fabs(given));
                }
    }
    CHECK(largest > 0.1);
    CHECK(worst < 1e-6 * largest * 8);
}

TEST_CASE("bake: a room's clusters and errors are those of full decompositions", "[probes][IPR 3.2.4.2]") {
    Scene scene = furnished();
    BakeParams params = small();
    BakeGraph graph(scene, params);
    run_all(graph);
    const Bake& b = graph.bake();
    const int coefficients = b.coefficients();
    REQUIRE(b.clusters.clusters.size() > 5);
    for (const Cluster& c : b.clusters.clusters) {
        const auto rows = Eigen::Index(c.receivers.size()), columns = Eigen::Index(c.probes.size()) * coefficients;
        Eigen::MatrixXd a = Eigen::MatrixXd::Zero(rows, columns), kept(rows, columns);
        for (Eigen::Index i = 0; i < rows; ++i) {
            const std::int64_t r = c.receivers[std::size_t(i)];
            for (int s = 0; s < b.supports.overlaps; ++s) {
                const auto p = std::find(c.probes.begin(), c.probes.end(), b.supports.probe[std::size_t(r * b.supports.overlaps + s)]);
                if (p == c.probes.end()) continue;
                for (int j = 0; j < coefficients; ++j)
                    a(i, (p - c.probes.begin()) * coefficients + j) =
                        double(b.alpha[std::size_t((r * b.supports.overlaps + s) * coefficients + j)]);
            }
            for (Eigen::Index k = 0; k < columns; ++k) {
                double sum = 0;
                for (int q = 0; q < c.rank; ++q)
                    sum += double(b.clusters.u[std::size_t(r * b.clusters.singular_values + q)]) * double(c.sigma_vt[std::size_t(q * columns + k)]);
                kept(i, k) = sum;
            }
        }
        const Eigen::VectorXd s = Eigen::BDCSVD<Eigen::MatrixXd>(a).singularValues();
        const double all = s.sum(), head = s.head(std::min<Eigen::Index>(32, s.size())).sum();
        const double published = all > 0 ? 1 - std::sqrt(head / all) : 0;
        CHECK(c.error_published == Approx(published).margin(2e-5));
        CHECK((published < params.threshold + 2e-5 || c.receivers.size() <= 32));
        const double tail = s.size() > 32 ? s.tail(s.size() - 32).norm() : 0;
        CHECK((a - kept).norm() <= 1.01 * tail + 1e-6 * a.norm());
    }
}

TEST_CASE("bake: receivers inside of a box are moved out of it", "[probes][IPR 5.1.4]") {
    Scene scene = furnished(2, -1);
    BakeParams params = small();
    params.receivers_per_m2 = 36;
    BakeGraph graph(scene, params);
    run_all(graph);
    const Bake& b = graph.bake();
    int under = 0;
    for (int i = 0; i < b.receivers.count(); ++i) {
        const glm::vec3 at(b.receivers.position[std::size_t(i)]), was = at - glm::vec3(b.receivers.shift[std::size_t(i)]);
        const bool covered = b.receivers.normal[std::size_t(i)].y > 0 && was.y < -1.99f && was.x > -0.59f && was.x < 0.79f && std::fabs(was.z) < 0.59f;
        if (!covered) continue;
        ++under;
        CHECK(b.receivers.shift[std::size_t(i)].w == 1);
        // Out of the box, through the side that is nearest along a ray.
        CHECK((at.x < -0.6f || at.x > 0.8f || std::fabs(at.z) > 0.6f || at.y > -0.4f || at.y < -2));
    }
    CHECK(under > 30);
    CHECK(b.shifted >= under);
    // Of those on the walls none.
    for (int i = 0; i < b.receivers.count(); ++i)
        if (b.receivers.position[std::size_t(i)].y > 0) CHECK(b.receivers.shift[std::size_t(i)].w == 0);
}

// Four boxes, each a step higher and shorter than the one before, that overlap and share the planes of their sides: as stairs
// are often built. Of those receivers that lie inside of one, returns how many are left in one.
struct OnStair {
    int inside = 0, left = 0, moved = 0, moved_in_the_open = 0;
};
OnStair on_stair(int crossings) {
    Mesh mesh;
    test::add_box(mesh, glm::vec3(-2), glm::vec3(2), 0, true);
    std::vector<std::pair<glm::vec3, glm::vec3>> steps;
    for (int k = 0; k < 4; ++k) {
        const float step = float(k);
        steps.push_back({{-1.2f + 0.5f * step, -2, -0.8f}, {1.3f, -1.7f + 0.3f * step, 0.8f}});
        test::add_box(mesh, steps.back().first, steps.back().second, 1);
    }
    const Scene scene = scene_of(std::move(mesh));
    AtlasParams atlas_params;
    atlas_params.receivers_per_m2 = 60;
    const Atlas atlas = make_atlas(scene, flatten(scene), atlas_params);
    const raster::Surfaces surfaces = raster::prepare(scene, atlas.geometry);
    const auto query = reference::build_ray_query(atlas.geometry, surfaces, Rays::exact);
    const auto in_a_step = [&](const glm::vec3& p) {
        return std::any_of(steps.begin(), steps.end(), [&](const auto& box) {
            return glm::all(glm::greaterThan(p, box.first + 1e-3f)) && glm::all(glm::lessThan(p, box.second - 1e-3f));
        });
    };
    Receivers r = place_receivers(atlas, surfaces, {});
    ShiftParams params;
    params.crossings = crossings;
    OnStair found;
    found.moved = shift_receivers(r, raster::surface_args(atlas.geometry, surfaces, View{}), *query,
                                  offset_of(extent_of(atlas.geometry)), params, {});
    for (std::size_t i = 0; i < r.position.size(); ++i) {
        const glm::vec3 at(r.position[i]), was = at - glm::vec3(r.shift[i]);
        // Where rays begin: faces lie on each other.
        const bool inside = in_a_step(was + 2e-3f * glm::vec3(r.normal[i]));
        found.inside += inside ? 1 : 0;
        found.left += inside && in_a_step(at) ? 1 : 0;
        found.moved_in_the_open += !inside && r.shift[i].w == 1 && was.y > -1.99f ? 1 : 0;
    }
    return found;
}

TEST_CASE("bake: receivers inside of solids that overlap are moved out of all of them", "[probes][IPR 5.1.4]") {
    const OnStair all = on_stair(64), published = on_stair(1);
    CHECK(all.inside > 300);
    CHECK(all.left == 0);
    CHECK(all.moved_in_the_open == 0);
    // The first hit alone is the front of another step too often, and behind a back lies the next.
    CHECK(published.left > all.inside / 4);
}

TEST_CASE("bake: border texels hold the mean of the receivers around them", "[probes][IPR 3.2.1.1]") {
    Receivers r;
    r.size = {8, 6};
    for (const glm::ivec2 t : {glm::ivec2(2, 2), glm::ivec2(3, 2), glm::ivec2(2, 3)}) {
        r.texel.push_back(t);
        r.position.push_back({}), r.normal.push_back({});
    }
    r.border = {border_left | border_up, border_right | border_up | border_down, border_left | border_right | border_down};
    const Image4 lightmap = scatter(r, {glm::vec4(1), glm::vec4(2), glm::vec4(4)});
    const Image4 extended = extend_borders(r, lightmap);
    CHECK(extended(2, 2).x == 1);
    CHECK(extended(1, 1).x == 1);                  // at a corner: one neighbour
    CHECK(extended(2, 1).x == 1.5f);               // two
    CHECK(extended(3, 3).x == Approx(7 / 3.0));    // three: in the corner between them
    CHECK(extended(0, 0).x == 1);                  // two texels away: the mean of the first ring, here of one
    CHECK(extended(4, 4).x == Approx((7 / 3.0 + 2 + 4) / 3));  // of three of them: (3, 3), (4, 3), (3, 4)
    CHECK(extended(6, 5).x == 0);                  // three texels away
    const Image4 published = extend_borders(r, lightmap, true);
    CHECK(published(1, 1).x == 0);                 // as printed: the corner stays black
    CHECK(published(3, 3).x == 4);                 // two write it; the last one stays
}

TEST_CASE("bake: the same bits for every instruction set and number of threads", "[probes][bits]") {
    Scene scene = furnished();
    BakeParams params = small();
    params.receivers_per_m2 = 4;
    std::uint64_t first = 0;
    for (const Isa isa : supported_isas())
        for (const int threads : {1, 3}) {
            RunOptions options;
            options.isa = isa, options.threads = threads;
            BakeGraph graph(scene, params);
            run_all(graph, options);
            const std::uint64_t hash = content_hash(lent(graph.bake().flat), content_hash(graph.bake().alpha.data(), graph.bake().alpha.size() * 4));
            if (first == 0) first = hash;
            CHECK(hash == first);
        }
}

TEST_CASE("bake: probes tell all that a receiver of an empty room sees, and nothing behind a wall", "[probes]") {
    Mesh mesh;
    test::add_box(mesh, glm::vec3(-2), glm::vec3(2), 0, true);
    const Scene room = scene_of(std::move(mesh));
    BakeGraph empty(room, small());
    run_all(empty);
    for (int i = 0; i < empty.bake().receivers.count(); ++i) CHECK(told_share(empty.bake(), i) == Approx(1).margin(1e-5));
    CHECK(black_receivers(empty.bake()) == 0);
    // Two rooms and a probe: it is in one of them, and those of the other stay black.
    Mesh two;
    test::add_box(two, {-2, -1, -1}, {-0.05f, 1, 1}, 0, true);
    test::add_box(two, {0.05f, -1, -1}, {2, 1, 1}, 0, true);
    BakeParams params = small();
    params.placement.count = 1, params.placement.radius_of = RadiusOf::largest;
    const Scene rooms = scene_of(std::move(two));
    BakeGraph halved(rooms, params);
    run_all(halved);
    const Bake& b = halved.bake();
    const bool left = b.placement.probes.at(0).x < 0;
    int black = 0;
    for (int i = 0; i < b.receivers.count(); ++i) {
        const bool with_probe = (b.receivers.position[std::size_t(i)].x < 0) == left;
        CHECK(told_share(b, i) == Approx(with_probe ? 1 : 0).margin(1e-5));
        black += with_probe ? 0 : 1;
    }
    CHECK(black > 50);
    CHECK(black_receivers(b) == black);
}

TEST_CASE("bake: every step comes back from a store, and then no ray is asked", "[probes][graph]") {
    const Scene scene = furnished();
    BakeParams params = small();
    params.receiver_rays = 16;
    graph::MemoryStore store;
    graph::RunWith with;
    with.store = &store;
    BakeGraph first(scene, params), again(scene, params);
    for (const graph::NodeRun& r : graph::run(first.nodes(), with)) CHECK_FALSE(r.kept);
    for (const graph::NodeRun& r : graph::run(again.nodes(), with)) {
        INFO(r.label);
        CHECK(r.kept);
    }
    CHECK(again.seconds_of_rays() == 0);
    const auto content_of = [](const Bake& b) {
        return std::vector<std::uint64_t>{content_hash(lent(b.atlas)), content_hash(lent(b.receivers, b.shifted)),
                                          content_hash(lent(b.placement, b.radius)), content_hash(lent(b.supports)),
                                          content_hash(lent_rays(b)), content_hash(lent(b.relight, 0, b.relight.probes)),
                                          content_hash(lent(b.flat))};
    };
    CHECK(content_of(again.bake()) == content_of(first.bake()));
    CHECK(again.bake().alpha == first.bake().alpha);
    // What is traced after that has rays all the same.
    CHECK(again.traced(0, {}).shares == first.traced(0, {}).shares);
}

TEST_CASE("bake: what does not fit is not taken from a store", "[probes][graph]") {
    const Scene scene = furnished();
    BakeGraph graph(scene, small());
    run_all(graph);
    const Bake& b = graph.bake();
    Receivers receivers;
    int moved = -1;
    Bundle kept = lent(b.receivers, b.shifted);
    take(kept, receivers, moved);
    CHECK(moved == b.shifted);
    CHECK(receivers.texel == b.receivers.texel);
    for (std::size_t i = 0; i < kept.arrays.size(); ++i) {
        Bundle less = kept;
        less.arrays.erase(less.arrays.begin() + std::ptrdiff_t(i));
        CHECK_THROWS_AS(take(less, receivers, moved), InputError);
    }
    Atlas shorter = b.atlas;
    shorter.uv.pop_back();
    Atlas atlas;
    CHECK_THROWS_AS(take(lent(shorter), atlas), InputError);
    RelightHits other = no_hits(b.relight.probes, b.relight.rays + 1);
    CHECK_THROWS_AS(take(lent(b.relight, 0, 1), other, 0, 1), InputError);
}

TEST_CASE("bake: parts fill a store, and what is joined of them has the same bits", "[probes][graph]") {
    Scene scene = furnished();
    BakeParams params = small();
    params.receivers_per_m2 = 30, params.receiver_rays = 16;
    params.placement.count = 2 * block_probes + 1;
    BakeGraph alone(scene, params);
    const std::vector<graph::NodeRun> whole = run_all(alone);
    REQUIRE(alone.bake().blocks() >= 3);
    graph::MemoryStore store;
    graph::RunWith with;
    with.store = &store;
    for (const int part : {2, 0, 1}) {
        BakeGraph graph(scene, params, {part, 3});
        graph::run(graph.nodes(), with);
    }
    // Five steps that each part reads, three blocks of probes, and the blocks of receivers; clusters are of the whole.
    CHECK(int(store.size()) == 5 + 3 + alone.bake().blocks());
    CHECK(whole.size() == store.size() + 1);
    BakeGraph joined(scene, params);
    std::set<std::string> made;
    for (const graph::NodeRun& r : graph::run(joined.nodes(), with))
        if (!r.kept) made.insert(r.label);
    CHECK(made == std::set<std::string>{"probes.clusters"});
    CHECK(joined.bake().alpha == alone.bake().alpha);
    CHECK(content_hash(lent(joined.bake().flat)) == content_hash(lent(alone.bake().flat)));
    CHECK(content_hash(lent(joined.bake().relight, 0, 2 * block_probes + 1)) ==
          content_hash(lent(alone.bake().relight, 0, 2 * block_probes + 1)));
    CHECK(joined.bake().counts().traced == alone.bake().counts().traced);
    // What no ray depends on leaves the blocks as they are; what one does not.
    const auto blocks_kept = [&](const BakeParams& other) {
        BakeGraph graph(scene, other);
        int n = 0;
        for (const graph::NodeRun& r : graph::run(graph.nodes(), with)) n += r.kept && r.label.starts_with("probes.coefficients") ? 1 : 0;
        return n;
    };
    BakeParams other = params;
    other.threshold = 0.2f, other.singular_values = 8;
    CHECK(blocks_kept(other) == alone.bake().blocks());
    for (const auto& change : std::vector<std::function<void(BakeParams&)>>{
             [](BakeParams& p) { p.degree = 5; }, [](BakeParams& p) { p.receiver_rays = 17; },
             [](BakeParams& p) { p.distribution = Distribution::uniform; }, [](BakeParams& p) { p.weighting = Weighting::published; },
             [](BakeParams& p) { p.escapes = Escapes::all_probes; }, [](BakeParams& p) { p.placement.count = 7; },
             [](BakeParams& p) { p.test_rays = 0; }, [](BakeParams& p) { p.rays = Rays::native; }}) {
        other = params;
        change(other);
        CHECK(blocks_kept(other) == 0);
    }
}

TEST_CASE("bake: another scene has another hash, another light has not", "[probes]") {
    Scene scene = furnished();
    scene.textures.resize(1);
    scene.textures[0].texels = Image<std::uint32_t>(2, 2, 0x80ffffff);
    scene.materials[0].texture = 0, scene.materials[0].alpha_cutoff = 0.4f;
    const std::uint64_t hash = scene_hash(scene, flatten(scene));
    // All that a mask is made of.
    for (const auto& change : std::vector<std::function<void(Scene&)>>{
             [](Scene& s) { s.textures[0].filter = Filter::nearest; }, [](Scene& s) { s.textures[0].wrap_u = Wrap::clamp_to_edge; },
             [](Scene& s) { s.textures[0].wrap_v = Wrap::mirrored_repeat; }, [](Scene& s) { s.textures[0].mips = true; },
             [](Scene& s) { s.textures[0].texels(1, 1) = 0; }, [](Scene& s) { s.materials[0].alpha_cutoff = 0.5f; },
             [](Scene& s) { s.materials[0].alpha = 0.5f; }}) {
        Scene changed = scene;
        change(changed);
        CHECK(scene_hash(changed, flatten(changed)) != hash);
    }
    Scene lit = scene;
    lit.lights.emplace_back(), lit.materials[0].emission = glm::vec3(1), lit.materials[1].reflectance = glm::vec3(0.9f);
    CHECK(scene_hash(lit, flatten(lit)) == hash);
    Scene moved = scene;
    moved.meshes[0].vertices[3].position.x += 1e-3f;
    CHECK(scene_hash(moved, flatten(moved)) != hash);
    Scene other = scene;
    other.meshes[0].material[0] = 1;
    CHECK(scene_hash(other, flatten(other)) != hash);
}

TEST_CASE("bake: refusals name what is wrong", "[probes][refusals]") {
    Scene scene = furnished();
    const auto refused = [&](const Scene& s, const BakeParams& params, Part part = {}, std::uint64_t memory = ~std::uint64_t(0)) {
        try {
            BakeGraph graph(s, params, part, memory);
            run_all(graph);
        } catch (const InputError& e) {
            return std::string(e.what());
        }
        return std::string("nothing");
    };
    using Catch::Matchers::Contains;
    BakeParams params = small();
    CHECK(refused(scene, params) == "nothing");
    CHECK_THAT(refused(Scene{}, params), Contains("surface"));
    params.degree = 8;
    CHECK_THAT(refused(scene, params), Contains("degree"));
    params = small(), params.receivers_per_m2 = std::nanf("");
    CHECK_THAT(refused(scene, params), Contains("receivers_per_m2"));
    params = small(), params.receiver_rays = 0;
    CHECK_THAT(refused(scene, params), Contains("receiver_rays"));
    params = small(), params.receivers_per_m2 = 1e9f;
    CHECK_THAT(refused(scene, params), Contains("16384"));
    params = small(), params.placement.count = -1;
    CHECK_THAT(refused(scene, params), Contains("count"));
    CHECK_THAT(refused(scene, small(), {}, 1000), Contains("MB of memory; there are 0.001 MB"));
    CHECK_THAT(refused(scene, small(), {3, 3}), Contains("part"));
}

TEST_CASE("bake: every step has a picture", "[probes]") {
    Scene scene = furnished();
    BakeGraph graph(scene, small());
    run_all(graph);
    DebugView view;
    view.size = {64, 48};
    Camera camera;
    camera.position = {1.5, 1.5, 1.5}, camera.look_at = {-1, -1, -1};
    view.view = make_view(camera, 64.0 / 48);
    std::set<std::string> nodes;
    for (const DebugLayer& layer : debug_layers(graph.bake(), graph.surfaces(), view, {})) {
        nodes.insert(layer.node);
        std::set<std::uint64_t> colours;
        for (const glm::vec4& t : layer.picture.texels) {
            CHECK((t.x >= 0 && t.y >= 0 && t.z >= 0));
            colours.insert(content_hash(&t, sizeof t));
        }
        INFO(layer.name);
        CHECK(colours.size() >= 2);
    }
    CHECK(nodes == std::set<std::string>{"probes.atlas", "probes.receivers", "probes.placement", "probes.supports", "probes.relight",
                                         "probes.coefficients", "probes.clusters"});
}
