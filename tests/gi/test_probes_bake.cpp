// Whole bakes: light in closed rooms in closed form, the graph's steps, extremes, refusals.
#include <Eigen/SVD>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <set>

#include "core/error.h"
#include "core/host_math.h"
#include "core/sh.h"
#include "gi/probes/bake.h"
#include "gi/probes/converge.h"
#include "gi/probes/debug_layers.h"
#include "random_scene.h"

namespace {

using namespace plumb;
using namespace plumb::probes;

Scene scene_of(Mesh mesh) {
    Scene scene;
    scene.materials.resize(2);
    mesh.material.resize(mesh.triangles.size(), 0);
    scene.meshes = {std::move(mesh)};
    return scene;
}

// A room with a box in it, which stands in the floor or above it.
Scene furnished(float half = 2, float foot = -0.9f) {
    Mesh mesh;
    test::add_box(mesh, glm::vec3(-half), glm::vec3(half), 0, true);
    test::add_box(mesh, half * glm::vec3(-0.3f, foot, -0.3f), half * glm::vec3(0.4f, -0.2f, 0.3f), 1);
    return scene_of(mesh);
}

// The inside of a ball of triangles by longitude and latitude, fronts inwards.
Scene inside_of_ball(int rings) {
    Mesh mesh;
    for (int j = 0; j <= rings; ++j)
        for (int i = 0; i <= 2 * rings; ++i) {
            const double theta = host::pi * j / rings, phi = host::pi * i / rings;
            const glm::dvec3 p(host::sin(theta) * host::cos(phi), host::cos(theta), host::sin(theta) * host::sin(phi));
            mesh.vertices.push_back({glm::vec3(2.0 * p), float(i) / float(2 * rings), glm::vec3(-p), float(j) / float(rings)});
        }
    const auto at = [&](int i, int j) { return unsigned(j * (2 * rings + 1) + i); };
    for (int j = 0; j < rings; ++j)
        for (int i = 0; i < 2 * rings; ++i) {
            if (j > 0) mesh.triangles.push_back({at(i, j), at(i, j + 1), at(i + 1, j)});
            if (j < rings - 1) mesh.triangles.push_back({at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)});
        }
    return scene_of(mesh);
}

BakeParams small() {
    BakeParams p;
    p.receivers_per_m2 = 9, p.relight_rays = 256, p.receiver_rays = 128;
    p.placement.count = 6;
    return p;
}

std::vector<graph::NodeRun> run_all(BakeGraph& graph, RunOptions options = {}) {
    graph::RunWith with;
    with.options = options;
    return graph::run(graph.nodes(), with);
}

// The run time's rounds where every receiver has the direct irradiance e, every surface the reflectance rho.
RunTime rounds_of(const Bake& bake, double e, double rho, Transport transport) {
    const std::size_t rays = bake.relight.material.size();
    Relit relit{std::vector<glm::dvec3>(rays, glm::dvec3(0)), std::vector<glm::dvec3>(rays, glm::dvec3(rho)),
                std::vector<glm::dvec3>(rays, glm::dvec3(e))};
    for (std::size_t k = 0; k < rays; ++k)
        if (bake.relight.material[k] < 0) relit.reflectance[k] = relit.direct[k] = glm::dvec3(0);
    return RunTime(bake, std::move(relit), transport);
}

}  // namespace

TEST_CASE("bake: in a closed scene indirect irradiance is E rho / (1 - rho), everywhere", "[probes][analytic][furnace]") {
    // Every surface has the direct irradiance E and reflectance rho: I = rho (E + I). Of a sphere with a lamp of power P in
    // it, E = P / A: (P/A) rho / (1 - rho). Discrete rays: lambda of a constant f is not quite its first harmonic, which 4 pi
    // / N sum Y_j of 256 directions says; the shares of receivers' rays are exact.
    const double e = 3, rho = 0.5;
    // In the furnished room some rays end where no probe looks, and bring nothing.
    struct Case {
        const char* name;
        Scene scene;
        double mean, spread;  // by how much they may differ
    };
    Mesh walls;
    test::add_box(walls, glm::vec3(-2), glm::vec3(2), 0, true);
    Case cases[] = {{"room", scene_of(walls), 0.01, 0.1}, {"ball", inside_of_ball(16), 0.01, 0.1}, {"furnished", furnished(), 0.06, 1}};
    for (auto& [name, scene, of_mean, of_spread] : cases) {
        BakeParams params = small();
        params.receivers_per_m2 = 5;
        BakeGraph graph(scene, params);
        run_all(graph);
        const Bake& b = graph.bake();
        CHECK(b.supports.unsupported == 0);
        RunTime whole = rounds_of(b, e, rho, Transport::whole), clustered = rounds_of(b, e, rho, Transport::clustered);
        CHECK(whole.without_receiver() == 0);
        for (int round = 0; round < 40; ++round) whole.round(), clustered.round();
        INFO(name << ", " << b.receivers.count() << " receivers, mean " << whole.mean() << ", spread "
                                      << whole.spread());
        CHECK(whole.mean() == Approx(e * rho / (1 - rho)).epsilon(of_mean));
        CHECK(whole.spread() <= of_spread);
        // Truncation loses what the criterion allows.
        double worst = 0;
        for (std::size_t i = 0; i < whole.irradiance().size(); ++i)
            worst = std::max(worst, std::fabs(whole.irradiance()[i].x - clustered.irradiance()[i].x));
        CHECK(worst < 0.05 * e);
        CHECK(clustered.mean() == Approx(whole.mean()).epsilon(0.005));
    }
}

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

TEST_CASE("bake: border texels hold the mean of the receivers around them", "[probes][IPR 3.2.1.1]") {
    Receivers r;
    r.size = {6, 5};
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
    CHECK(extended(0, 0).x == 0);                  // two texels away
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

namespace {

class MemoryStore : public graph::Store {
  public:
    std::optional<Bundle> find(graph::Key key) override {
        const auto at = kept_.find(key);
        return at == kept_.end() ? std::nullopt : std::optional(at->second);
    }
    void keep(graph::Key key, const Bundle& bundle, const std::string&) override {
        Bundle own = bundle;
        for (Array& a : own.arrays) a.bytes.own();
        kept_[key] = own;
    }
    std::map<graph::Key, Bundle> kept_;
};

}  // namespace

TEST_CASE("bake: parts fill a store, and what is joined of them has the same bits", "[probes][graph]") {
    Scene scene = furnished();
    BakeParams params = small();
    params.receivers_per_m2 = 30, params.receiver_rays = 16;
    BakeGraph alone(scene, params);
    const std::vector<graph::NodeRun> whole = run_all(alone);
    REQUIRE(alone.bake().blocks() >= 3);
    MemoryStore store;
    graph::RunWith with;
    with.store = &store;
    for (const int part : {2, 0, 1}) {
        BakeGraph graph(scene, params, {part, 3});
        graph::run(graph.nodes(), with);
    }
    CHECK(int(store.kept_.size()) == alone.bake().blocks());
    BakeGraph joined(scene, params);
    int kept = 0;
    for (const graph::NodeRun& r : graph::run(joined.nodes(), with)) kept += r.kept ? 1 : 0;
    CHECK(kept == alone.bake().blocks());
    CHECK(joined.bake().alpha == alone.bake().alpha);
    CHECK(content_hash(lent(joined.bake().flat)) == content_hash(lent(alone.bake().flat)));
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

TEST_CASE("bake: extremes", "[probes][extreme]") {
    BakeParams params = small();
    SECTION("0.2 mm and 2000 km") {
        for (const double half : {1e-4, 1e6}) {
            Scene scene = furnished(float(half));
            params.lightmap_size = 64;
            BakeGraph graph(scene, params);
            run_all(graph);
            const Bake& b = graph.bake();
            CHECK(b.supports.unsupported == 0);
            CHECK(b.counts().escaped == 0);
            RunTime rounds = rounds_of(b, 1, 0.5, Transport::whole);
            rounds.round();
            CHECK(rounds.mean() == Approx(0.5).epsilon(0.1));
        }
    }
    SECTION("one receiver, one probe") {
        Mesh quad;
        test::add_quad(quad, {0, 0, 0}, {0, 0, 1}, {1, 0, 0}, 0);
        Scene scene = scene_of(quad);
        scene.environment.radiance = glm::vec3(1);
        params.receivers_per_m2 = 1, params.placement.count = 1, params.placement.least = 1;
        BakeGraph graph(scene, params);
        run_all(graph);
        CHECK(graph.bake().receivers.count() == 1);
        CHECK(graph.bake().placement.probes.size() == 1);
        CHECK(graph.bake().clusters.clusters.size() == 1);
        CHECK(graph.bake().transport.escape == Escape::same_direction);
        // pi Y_0: all rays escape, and the probe's do as well.
        CHECK(graph.bake().alpha[0] == Approx(std::sqrt(host::pi) / 2).epsilon(1e-4));
    }
    SECTION("coplanar receivers, two coincident quads") {
        Mesh quads;
        test::add_quad(quads, {0, 0, 0}, {0, 0, 2}, {2, 0, 0}, 0);
        test::add_quad(quads, {0, 0, 0}, {0, 0, 2}, {2, 0, 0}, 0);
        Scene scene = scene_of(quads);
        BakeGraph graph(scene, params);
        run_all(graph);
        for (const float a : graph.bake().alpha) CHECK(a == 0);  // nothing is seen, and there is no sky
        for (const Cluster& c : graph.bake().clusters.clusters) CHECK(c.error_published == 0);
    }
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
    CHECK_THAT(refused(scene, small(), {}, 1000), Contains("GB of memory"));
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
