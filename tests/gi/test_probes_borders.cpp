// Lookups at the edges of charts: what borders hold, against lightmaps of twice the resolution (IPR 3.2.1.1, 3.2.5.8).
#include <catch2/catch.hpp>
#include <cmath>

#include "probe_bakes.h"

using namespace plumb;
using namespace plumb::probes;
using namespace plumb::test;

namespace {

// A lightmap as a GPU samples it: bilinear, texel centres at (k + 1/2) / size, clamped to the edge.
struct Sampled {
    glm::dvec4 value;
    bool at_edge;  // some of the four texels is no receiver, or lies beyond the lightmap
};

class Lightmap {
  public:
    // Of a value of each receiver; w has to be 1.
    Lightmap(const Atlas& atlas, const Receivers& receivers, const Buffer<glm::vec4>& values)
        : atlas_(atlas), plain_(scatter(receivers, values)), extended_(extend_borders(receivers, plain_)),
          published_(extend_borders(receivers, plain_, true)) {}

    enum class Borders { extended, published, none };

    // Of a triangle of the atlas, (1 - u - v, u, v) of its corners.
    Sampled at(std::size_t triangle, double u, double v, Borders borders = Borders::extended) const {
        const glm::uvec3 c = atlas_.geometry.triangles[triangle];
        const glm::dvec2 a(atlas_.uv[c.x]), b(atlas_.uv[c.y]), d(atlas_.uv[c.z]);
        const glm::dvec2 t = (a + u * (b - a) + v * (d - a)) * double(plain_.width) - 0.5;
        const Image4& map = borders == Borders::extended ? extended_ : borders == Borders::published ? published_ : plain_;
        const int x = int(std::floor(t.x)), y = int(std::floor(t.y));
        Sampled s{glm::dvec4(0), false};
        for (int k = 0; k < 4; ++k) {
            const int tx = x + k % 2, ty = y + k / 2;
            const double weight = (k % 2 ? t.x - x : 1 - (t.x - x)) * (k / 2 ? t.y - y : 1 - (t.y - y));
            const int cx = std::clamp(tx, 0, map.width - 1), cy = std::clamp(ty, 0, map.height - 1);
            s.value += weight * glm::dvec4(map(cx, cy));
            s.at_edge = s.at_edge || (weight > 0 && (plain_(cx, cy).w == 0 || cx != tx || cy != ty));
        }
        return s;
    }

  private:
    const Atlas& atlas_;
    Image4 plain_, extended_, published_;
};

glm::dvec3 position(const Atlas& atlas, std::size_t triangle, double u, double v) {
    const glm::uvec3 c = atlas.geometry.triangles[triangle];
    const glm::dvec3 a(atlas.geometry.vertices[c.x].position), b(atlas.geometry.vertices[c.y].position),
        d(atlas.geometry.vertices[c.z].position);
    return a + u * (b - a) + v * (d - a);
}

// Calls `call` for points of every triangle, its sides and corners among them.
template <class Call>
void for_points(const Atlas& atlas, int n, const Call& call) {
    for (std::size_t t = 0; t < atlas.geometry.triangles.size(); ++t) {
        if (atlas.chart[t] < 0) continue;
        for (int i = 0; i <= n; ++i)
            for (int j = 0; j <= n - i; ++j) call(t, double(i) / n, double(j) / n);
    }
}

const glm::dvec3 gradient(0.7, -0.4, 0.5);  // 1/m
double linear(const glm::dvec3& p) { return 5 + glm::dot(gradient, p); }

struct Baked {
    Atlas atlas;
    Receivers receivers;
    raster::Surfaces surfaces;
    Baked(const Scene& scene, double texels_a_metre) {
        AtlasParams params;
        params.receivers_per_m2 = texels_a_metre * texels_a_metre;
        atlas = make_atlas(scene, flatten(scene), params);
        surfaces = raster::prepare(scene, atlas.geometry);
        receivers = place_receivers(atlas, surfaces, {});
    }
    Lightmap linear_map() const {
        Buffer<glm::vec4> values;
        for (const glm::vec4& p : receivers.position) values.push_back(glm::vec4(float(linear(glm::dvec3(p))), 0, 0, 1));
        return Lightmap(atlas, receivers, values);
    }
};

struct Error {
    double most = 0, squares = 0;
    int count = 0;
    void add(double e) { most = std::max(most, std::fabs(e)), squares += e * e, ++count; }
    double rms() const { return std::sqrt(squares / count); }
};

}  // namespace

TEST_CASE("bake: a lookup at a chart's edge errs by less than its texel's width, and half as much at twice the resolution",
          "[probes][analytic][IPR 3.2.1.1]") {
    // Of a value that is linear in space, on flat charts: inside, a bilinear lookup is exact. A border texel holds the mean of
    // receivers at most (1, 1) texels away, so it is off by sqrt(2) h |gradient| at most, h the texel's width in metres, and so is
    // the lookup. Two lightmaps, one of twice the resolution, differ by 1.5 times that.
    for (const auto& [name, scene] : {std::pair("room", empty_room()), {"furnished", furnished(2, -1)}}) {
        double before = 0;
        for (const double s : {4.0, 8.0, 16.0}) {
            const Baked coarse(scene, s), fine(scene, 2 * s);
            const Lightmap a = coarse.linear_map(), b = fine.linear_map();
            const double bound = std::sqrt(2.0) * std::sqrt(glm::dot(gradient, gradient)) / s;
            Error inside, edge, between, none, published;
            double least_w = 1;
            for_points(coarse.atlas, 40, [&](std::size_t t, double u, double v) {
                const Sampled x = a.at(t, u, v), y = b.at(t, u, v);
                const double truth = linear(position(coarse.atlas, t, u, v));
                least_w = std::min({least_w, x.value.w, y.value.w});
                (x.at_edge ? edge : inside).add(x.value.x - truth);
                if (!x.at_edge) return;
                between.add(x.value.x - y.value.x);
                none.add(a.at(t, u, v, Lightmap::Borders::none).value.x - y.value.x);
                published.add(a.at(t, u, v, Lightmap::Borders::published).value.x - y.value.x);
            });
            CAPTURE(name, s, bound, inside.most, edge.most, edge.rms(), between.most, between.rms(), none.most, published.most);
            CHECK(least_w > 1 - 1e-12);  // no lookup reads a texel that nothing was written to
            CHECK(inside.count > 1000);
            CHECK(inside.most < bound / 256 + 1e-5);  // the rasterizer snaps corners to 1/256 of a texel
            CHECK(edge.count > 100);
            CHECK(edge.most <= bound);
            CHECK(between.most <= 1.5 * bound);
            if (before > 0) CHECK(between.rms() < 0.7 * before);
            before = between.rms();
            // Borders that nobody writes are told, at every resolution; and corners of those that are written as printed.
            CHECK(none.most > 1);
            CHECK(none.most > 1.5 * bound);
            CHECK(published.most > 1.5 * bound);
        }
    }
}

TEST_CASE("bake: at edges of bent charts, too, a lightmap comes nearer to one of twice the resolution", "[probes][IPR 3.2.1.1]") {
    // A texel of a chart that is tilted by at most 45 degrees, scaled by at most 2^(1/4), covers at most sqrt(2) 2^(1/4) of its
    // width.
    Scene scene = inside_of_ball(12);
    for (Vertex& v : scene.meshes[0].vertices) v.u = v.v = 0;
    double before = 0;
    for (const double s : {6.0, 12.0, 24.0}) {
        const Baked coarse(scene, s), fine(scene, 2 * s);
        const Lightmap a = coarse.linear_map(), b = fine.linear_map();
        const double width = std::sqrt(2.0) * host::pow(2, 0.25) / s;
        const double bound = std::sqrt(2.0) * width * std::sqrt(glm::dot(gradient, gradient));
        Error between, none;
        double least_w = 1;
        for_points(coarse.atlas, 12, [&](std::size_t t, double u, double v) {
            const Sampled x = a.at(t, u, v), y = b.at(t, u, v);
            least_w = std::min({least_w, x.value.w, y.value.w});
            if (!x.at_edge) return;
            between.add(x.value.x - y.value.x);
            none.add(a.at(t, u, v, Lightmap::Borders::none).value.x - y.value.x);
        });
        CAPTURE(s, coarse.atlas.charts.size(), bound, between.most, between.rms(), none.most);
        CHECK(least_w > 1 - 1e-12);
        CHECK(between.count > 100);
        CHECK(between.most <= 1.5 * bound);
        if (before > 0) CHECK(between.rms() < 0.75 * before);
        before = between.rms();
        CHECK(none.most > 1.5 * bound);
    }
}

TEST_CASE("bake: baked irradiance at charts' edges is that of a bake of twice the resolution", "[probes][IPR 3.2.1.1]") {
    // A room whose surfaces shine, by where they are: irradiance of 6 probes, looked up at the same places of both lightmaps.
    Scene scene = furnished();
    const auto lightmap = [&](const Bake& b) {
        const auto lambda = lambda_of(b, [&](std::size_t k) {
            return b.relight.material[k] >= 0 ? linear(glm::dvec3(b.relight.position[k])) / host::pi : 0;
        });
        Buffer<glm::vec4> values;
        for (const glm::dvec3& e : whole_irradiance(b, lambda)) values.push_back(glm::vec4(float(e.x), 0, 0, 1));
        return Lightmap(b.atlas, b.receivers, values);
    };
    double before = 0;
    for (const float s : {4.0f, 8.0f}) {
        BakeParams params = small();
        params.receivers_per_m2 = s * s;
        BakeGraph coarse(scene, params);
        run_all(coarse);
        params.receivers_per_m2 = 4 * s * s;
        BakeGraph fine(scene, params);
        run_all(fine);
        REQUIRE(coarse.bake().placement.probes == fine.bake().placement.probes);
        const Lightmap a = lightmap(coarse.bake()), b = lightmap(fine.bake());
        Error inside, edge, none;
        for_points(coarse.bake().atlas, 40, [&](std::size_t t, double u, double v) {
            const Sampled x = a.at(t, u, v);
            const double y = b.at(t, u, v).value.x;
            (x.at_edge ? edge : inside).add(x.value.x - y);
            if (x.at_edge) none.add(a.at(t, u, v, Lightmap::Borders::none).value.x - y);
        });
        CAPTURE(s, inside.rms(), inside.most, edge.rms(), edge.most, none.rms());
        // Irradiance is about 5 W/m2.
        CHECK(edge.rms() < 2 * inside.rms());
        CHECK(edge.rms() < 0.1);
        CHECK(none.rms() > 4 * edge.rms());
        if (before > 0) CHECK(edge.rms() < before);
        before = edge.rms();
    }
}
