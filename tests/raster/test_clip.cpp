// Clipping against the view volume and its guard band.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <cstring>
#include <vector>

#include "core/hash.h"
#include "raster/clip.h"

using namespace plumb;
using namespace plumb::raster;

namespace {

double uniform(int i, int channel) { return unit_float<float>(pixel_hash<std::int32_t>(i, channel, 0, 17).x); }

using Bits = std::vector<std::uint64_t>;  // x, y, z, w

Bits bits(const glm::dvec4& p) {
    Bits out(4);
    std::memcpy(out.data(), &p, sizeof(p));
    return out;
}

// The clipped vertices on the edge opposite to corner 1 or 2, where that corner's barycentric coordinate is exactly 0.
std::vector<Bits> on_edge(const ClipPolygon& polygon, int opposite) {
    std::vector<Bits> out;
    for (int i = 0; i < polygon.count; ++i)
        if (polygon.vertices[i].barycentrics[opposite - 1] == 0) out.push_back(bits(polygon.vertices[i].position));
    std::sort(out.begin(), out.end());
    return out;
}

}  // namespace

// Sutherland and Hodgman walk a shared edge once in each direction; both walks have to find the same point. A mesh whose
// clipped vertices differ in the last bit has cracks and pixels drawn twice.
TEST_CASE("clip: both triangles of an edge find the same bits on it, whatever their order", "[raster][clip][bits]") {
    const ClipVolume volume = clip_volume({640, 480});
    const double wide = 2 * volume.guard.x;  // corners lie within twice the guard band
    int one_plane = 0, two_planes = 0;
    for (int i = 0; i < 20000; ++i) {
        // Corners before and behind the near and far planes; every second edge reaches beyond the guard band.
        auto corner = [&](int k) {
            const double w = 0.1 + 3 * uniform(i, 4 * k), reach = i % 2 ? wide : 1;
            return glm::vec4(float(w * reach * (2 * uniform(i, 4 * k + 1) - 1)),
                             float(w * reach * (2 * uniform(i, 4 * k + 2) - 1)),
                             float(4 * uniform(i, 4 * k + 3) - 1), float(w));
        };
        const glm::vec4 a = corner(0), b = corner(1), c = corner(2), d = corner(3);
        // The same edge in both directions, with its far corner in the last place and in the middle.
        const struct {
            glm::vec4 corners[3];
            int opposite;
        } triangles[] = {{{a, b, c}, 2}, {{b, c, a}, 1}, {{b, a, d}, 2}, {{a, d, b}, 1}};
        const std::vector<Bits> expected = on_edge(clip(volume, triangles[0].corners), 2);
        for (const auto& t : triangles) {
            CAPTURE(i, t.opposite);
            REQUIRE(on_edge(clip(volume, t.corners), t.opposite) == expected);
        }
        const int crossed = int(expected.size()) - (expected.size() == 2 && inside(volume, a)) -
                            (expected.size() == 2 && inside(volume, b));
        one_plane += crossed == 1, two_planes += crossed == 2;
    }
    CHECK(one_plane > 1000);
    CHECK(two_planes > 1000);
}
