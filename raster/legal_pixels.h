// Which triangles a device may show at a pixel, when all that is known of its rasteriser is how far from a vertex's
// exact window position it may place it. README.md, "What a device may draw".
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "core/bounded.h"
#include "core/device_profile.h"
#include "raster/bound_scene.h"
#include "raster/clip.h"

namespace plumb::raster {

struct Interval {
    double low, high;
    double middle() const { return (low + high) / 2; }
    // The kernel follows `value`.
    Bounded bounded(float value) const { return Bounded::within(value, middle(), (high - low) / 2); }
};

struct LegalTriangle {
    std::int32_t triangle;
    bool sure;        // covers the pixel's centre wherever its vertices are placed
    bool bounded;     // false: it is so narrow that nothing can be said of its values
    // How many of its edges may leave the centre outside, and the ends of one, in an order of their own; which side of
    // it the triangle lies on.
    int open;
    glm::vec4 edge[2];
    bool right;
    Interval l1, l2;  // barycentrics of the whole triangle, perspective-correct
    Interval z;       // of the depth buffer
    glm::vec2 l;      // one value of the barycentrics
    // The barycentrics go together: they are those of a point in a box about the pixel's centre, of which these are the
    // corners'; besides, each is off by roundings of its own.
    glm::dvec2 corner[4];
    glm::dvec2 rounding;
};

class LegalPixels {
  public:
    // The scene must outlive it, and so must `behind`: see visibility.h.
    LegalPixels(const BoundScene& scene, bool reversed_z, glm::ivec2 size, const DeviceProfile& profile,
                const Image1* behind = nullptr);

    // Every triangle that may win the depth test at the pixel, in no order that matters. `nothing`: whether it may also
    // stay empty.
    void at(glm::ivec2 pixel, std::vector<LegalTriangle>& out, bool& nothing) const;

  private:
    // A triangle in one of the bins that it may touch.
    struct Entry {
        float low[2], high[2];  // its extent, pixels
        float nearest;          // no depth is nearer; reversed depths are negated
        std::int32_t triangle;
    };
    struct Corner {
        double x, y, z, inverse_w;  // window space, pixels
        double slack;               // how far away a device may place it, along x and along y
    };
    struct Polygon {
        Corner corner[ClipPolygon::capacity];
        int count = 0;
        bool clipped = false;
        double narrowness = 0;  // slack over width: README.md's G
    };
    Polygon polygon(std::int32_t triangle) const;
    Entry entry(const Polygon& p, std::int32_t triangle) const;
    void sort_into_bins();
    bool judge(const Entry& entry, glm::dvec2 centre, LegalTriangle& out) const;
    bool passes_mask(LegalTriangle& t) const;
    bool lies_behind(LegalTriangle& t, glm::ivec2 pixel) const;
    double near_end(const LegalTriangle& t) const;
    double far_end(const LegalTriangle& t) const;
    double slack_at(const Polygon& p, glm::dvec2 centre) const;
    void bound_values(const Polygon& p, glm::dvec2 centre, LegalTriangle& out) const;

    const BoundScene& scene_;
    const bool reversed_z_;
    const glm::ivec2 size_;
    const ClipVolume volume_;
    const double snapping_;  // pixels
    const Image1* const behind_;
    SurfaceArgs masks_;
    glm::ivec2 bins_;
    std::vector<std::size_t> start_;
    std::vector<Entry> entries_;
};

}  // namespace plumb::raster
