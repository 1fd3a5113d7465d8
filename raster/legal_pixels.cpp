#include "raster/legal_pixels.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/outcomes.h"
#include "core/parallel.h"
#include "raster/surface_kernel.h"
#include "raster/texture_bounded.h"

namespace plumb::raster {
namespace {

constexpr int bin_shift = 4;  // bins of 16 x 16 pixels
constexpr double infinity = std::numeric_limits<double>::infinity();

// What a device's floats may cost (assumed: no specification says), in parts of the largest coordinate. A window
// coordinate is x / w, scaled and shifted: 2.5, 0.5 and 0.5 units in the last place. A plane a0 + x dadx + y dady has
// as many roundings of its largest term, and each plane its own: as good as a displacement, another one for each.
constexpr double float_slack = 0x1p-21;
// And each interpolated value errs by a few units in the last place of the largest corner's.
constexpr double float_ulps = 4 * 0x1p-24;

// The narrower a triangle is, the less is known of where in it a pixel lies; from here on, nothing.
constexpr double too_narrow = 0.5;

constexpr int many = 9;  // open edges: no neighbour makes up for them

bool before(const glm::vec4& a, const glm::vec4& b) {
    return std::lexicographical_compare(&a.x, &a.x + 4, &b.x, &b.x + 4);
}

// Whether the two meet in an edge, which has the same ends in both, and the centre lies within all their other edges:
// one of them covers it, wherever the ends go.
bool cover_together(const LegalTriangle& a, const LegalTriangle& b) {
    return a.open == 1 && b.open == 1 && a.edge[0] == b.edge[0] && a.edge[1] == b.edge[1] && a.right != b.right;
}

double support(const glm::dvec2& n, double slack) { return slack * (std::abs(n.x) + std::abs(n.y)); }

void widen(Interval& i, double x) { i.low = std::min(i.low, x), i.high = std::max(i.high, x); }

// l1, l2 and z where the triangle is seen at the point to which its corners are relative, in pixels times w; false
// where it is not in front of the viewer, or seen edge-on.
bool values_at(const glm::dvec3 corner[3], const glm::dvec4 clip[3], double out[3]) {
    double e[3];
    for (int i = 0; i < 3; ++i) {
        const glm::dvec3 &a = corner[(i + 1) % 3], &b = corner[(i + 2) % 3];
        e[i] = a.x * b.y - a.y * b.x;
    }
    const double sum = e[0] + e[1] + e[2], z = e[0] * clip[0].z + e[1] * clip[1].z + e[2] * clip[2].z;
    const double w = e[0] * clip[0].w + e[1] * clip[1].w + e[2] * clip[2].w;
    out[0] = e[1] / sum, out[1] = e[2] / sum, out[2] = z / w;
    return w / sum > 0 && out[0] - out[0] == 0 && out[1] - out[1] == 0 && out[2] - out[2] == 0;
}

}  // namespace

LegalPixels::LegalPixels(const BoundScene& scene, bool reversed_z, glm::ivec2 size, const DeviceProfile& profile,
                         const Image1* behind)
    : scene_(scene),
      reversed_z_(reversed_z),
      size_(size),
      volume_(clip_volume(size)),
      snapping_(std::ldexp(profile.snap_uncertainty, -profile.subpixel_bits)),
      behind_(behind),
      masks_(surface_args(scene.geometry, scene.surfaces, View())),
      bins_((size + (1 << bin_shift) - 1) >> bin_shift) {
    sort_into_bins();
}

// What is seen of a triangle, in window space. A corner that clipping made is farther off: its clip coordinates err by
// roundings of the larger end's.
LegalPixels::Polygon LegalPixels::polygon(std::int32_t triangle) const {
    const glm::uvec3& t = scene_.geometry.triangles[std::size_t(triangle)];
    const glm::vec4 corners[3] = {scene_.clip_positions[t.x], scene_.clip_positions[t.y], scene_.clip_positions[t.z]};
    Polygon p;
    if (outside_frame(corners)) return p;
    const double side = std::max(size_.x, size_.y);
    double perimeter = 0, area = 0, slack = 0;
    auto add = [&](const glm::dvec4& c, double clip_error) {
        Corner& corner = p.corner[p.count++];
        corner = {(c.x / c.w + 1) * 0.5 * size_.x, (c.y / c.w + 1) * 0.5 * size_.y, c.z / c.w, 1 / c.w, 0};
        corner.slack = snapping_ + float_slack * std::max({side, std::abs(corner.x), std::abs(corner.y)}) +
                       clip_error * side / c.w;
        slack = std::max(slack, corner.slack);
    };
    if (inside(volume_, corners[0]) && inside(volume_, corners[1]) && inside(volume_, corners[2])) {
        for (const glm::vec4& c : corners) add(glm::dvec4(c), 0);
    } else {
        p.clipped = true;
        double largest = 0;
        for (const glm::vec4& c : corners)
            for (int k = 0; k < 4; ++k) largest = std::max(largest, std::abs(double(c[k])));
        const ClipPolygon seen = clip(volume_, corners);
        for (int i = 0; i < seen.count; ++i) {
            const glm::dvec2 l = seen.vertices[i].barycentrics;
            const bool given = l == glm::dvec2(0, 0) || l == glm::dvec2(1, 0) || l == glm::dvec2(0, 1);
            add(seen.vertices[i].position, given ? 0 : 2 * float_slack * largest);
        }
    }
    for (int i = 0; i < p.count; ++i) {
        const Corner &a = p.corner[i], &b = p.corner[(i + 1) % p.count], &o = p.corner[0];
        perimeter += std::abs(b.x - a.x) + std::abs(b.y - a.y);
        area += (a.x - o.x) * (b.y - o.y) - (a.y - o.y) * (b.x - o.x);
    }
    p.narrowness = area == 0 ? infinity : slack * perimeter / std::abs(area);
    return p;
}

LegalPixels::Entry LegalPixels::entry(const Polygon& p, std::int32_t triangle) const {
    double low[2] = {infinity, infinity}, high[2] = {-infinity, -infinity}, nearest = infinity, farthest = -infinity;
    double slack = 0;
    for (int i = 0; i < p.count; ++i) {
        const Corner& c = p.corner[i];
        const double place[2] = {c.x, c.y}, z = reversed_z_ ? -c.z : c.z;
        for (int k = 0; k < 2; ++k) {
            low[k] = std::min(low[k], place[k] - c.slack);
            high[k] = std::max(high[k], place[k] + c.slack);
        }
        nearest = std::min(nearest, z), farthest = std::max(farthest, z);
        slack = std::max(slack, c.slack);
    }
    // Beyond its corners' depths by as much as the plane reaches within the slack: at most narrowness times the range.
    nearest -= p.narrowness < too_narrow ? 8 * p.narrowness * (farthest - nearest) + 0x1p-20 : infinity;
    auto down = [](double x) { return float(x - std::abs(x) * 0x1p-23); };
    return {{down(low[0]), down(low[1])}, {-down(-high[0]), -down(-high[1])}, down(nearest), triangle};
}

// Bins hold what may touch them, the nearest first.
void LegalPixels::sort_into_bins() {
    const int n = int(scene_.geometry.triangles.size());
    constexpr int chunk = 4096;
    std::vector<std::vector<Entry>> chunks(std::size_t((n + chunk - 1) / chunk));
    parallel_bands(n, chunk, 0, [&](int first, int last) {
        for (int t = first; t < last; ++t) {
            const Polygon p = polygon(t);
            if (p.count == 0) continue;
            const Entry e = entry(p, t);
            if (e.high[0] > 0 && e.high[1] > 0 && e.low[0] < float(size_.x) && e.low[1] < float(size_.y))
                chunks[std::size_t(first / chunk)].push_back(e);
        }
    });
    auto for_each = [&](auto&& visit) {
        auto bin = [](float x, int count) { return std::clamp(int(x) >> bin_shift, 0, count - 1); };
        for (const std::vector<Entry>& list : chunks)
            for (const Entry& e : list) {
                const int right = bin(std::min(e.high[0], 65536.0f), bins_.x);
                const int bottom = bin(std::min(e.high[1], 65536.0f), bins_.y);
                for (int y = bin(std::max(e.low[1], 0.0f), bins_.y); y <= bottom; ++y)
                    for (int x = bin(std::max(e.low[0], 0.0f), bins_.x); x <= right; ++x)
                        visit(std::size_t(y * bins_.x + x), e);
            }
    };
    start_.assign(std::size_t(bins_.x * bins_.y) + 1, 0);
    for_each([&](std::size_t bin, const Entry&) { ++start_[bin + 1]; });
    for (std::size_t b = 1; b < start_.size(); ++b) start_[b] += start_[b - 1];
    entries_.resize(start_.back());
    std::vector<std::size_t> next(start_.begin(), start_.end() - 1);
    for_each([&](std::size_t bin, const Entry& e) { entries_[next[bin]++] = e; });
    parallel_bands(bins_.x * bins_.y, 16, 0, [&](int first, int last) {
        for (int b = first; b < last; ++b)
            std::stable_sort(entries_.begin() + std::ptrdiff_t(start_[std::size_t(b)]),
                             entries_.begin() + std::ptrdiff_t(start_[std::size_t(b) + 1]),
                             [](const Entry& a, const Entry& c) { return a.nearest < c.nearest; });
    });
}

// The slack of the point of the triangle that is seen at the centre: sum l_i slack_i, l being affine barycentrics. A
// polygon may be cut into any triangles of its corners.
double LegalPixels::slack_at(const Polygon& p, glm::dvec2 centre) const {
    double most = 0, largest = 0;
    for (int i = 0; i < p.count; ++i) largest = std::max(largest, p.corner[i].slack);
    auto area = [&](const Corner& a, const Corner& b) {
        return (a.x - centre.x) * (b.y - centre.y) - (a.y - centre.y) * (b.x - centre.x);
    };
    bool inside = false;
    for (int i = 0; i < p.count; ++i)
        for (int j = i + 1; j < p.count; ++j)
            for (int k = j + 1; k < p.count; ++k) {
                const Corner &a = p.corner[i], &b = p.corner[j], &c = p.corner[k];
                const double of_a = area(b, c), of_b = area(c, a), of_c = area(a, b);
                const double whole = std::abs(of_a) + std::abs(of_b) + std::abs(of_c);
                if (whole == 0 || std::abs(of_a + of_b + of_c) < whole * (1 - 0x1p-30)) continue;
                inside = true;
                most = std::max(most, (std::abs(of_a) * a.slack + std::abs(of_b) * b.slack + std::abs(of_c) * c.slack) /
                                          whole);
            }
    return inside ? most : largest;
}

// Fills the barycentrics and the depth. If a device displaces corners by d_i, the point that it takes for the centre p
// is p - sum l'_i d_i of the exact triangle, l' being its own affine barycentrics: their sum is 1, and where p lies
// inside they are not negative, so p moves by no more than the corners do. Outside, sum |l'_i| exceeds 1 by at most
// what `narrowness` allows.
void LegalPixels::bound_values(const Polygon& p, glm::dvec2 centre, LegalTriangle& out) const {
    out.bounded = p.narrowness < too_narrow;
    out.z = {0, 1}, out.l1 = out.l2 = {0, 1};
    if (!out.bounded) return;
    double largest_z = 0, largest_inverse_w = 0;
    for (int i = 0; i < p.count; ++i) {
        largest_z = std::max(largest_z, std::abs(p.corner[i].z));
        largest_inverse_w = std::max(largest_inverse_w, p.corner[i].inverse_w);
    }
    const double excess = out.sure ? 1 : (1 + 2 * p.narrowness) / (1 - p.narrowness);
    const double reach = slack_at(p, centre) * excess;

    // All three values are projective maps of the window: along an axis they are monotone, and their extremes over a
    // box lie at its corners.
    const glm::uvec3& t = scene_.geometry.triangles[std::size_t(out.triangle)];
    const glm::dvec4 clip[3] = {glm::dvec4(scene_.clip_positions[t.x]), glm::dvec4(scene_.clip_positions[t.y]),
                                glm::dvec4(scene_.clip_positions[t.z])};
    // Beside them the planes that a device may interpolate, of l1 / w, l2 / w and 1 / w.
    const Interval empty{infinity, -infinity};
    Interval l1 = empty, l2 = empty, z = empty, plane[3] = {empty, empty, empty};
    for (int k = 0; k < 4; ++k) {
        const glm::dvec2 at = centre + reach * glm::dvec2(k & 1 ? 1 : -1, k & 2 ? 1 : -1);
        glm::dvec3 corner[3];
        for (int i = 0; i < 3; ++i)
            corner[i] = {(clip[i].x + clip[i].w) * 0.5 * size_.x - at.x * clip[i].w,
                         (clip[i].y + clip[i].w) * 0.5 * size_.y - at.y * clip[i].w, clip[i].w};
        double v[3];
        if (!values_at(corner, clip, v)) {
            out.bounded = false;
            return;
        }
        widen(l1, v[0]), widen(l2, v[1]), widen(z, v[2]);
        out.corner[k] = {v[0], v[1]};
        const double w = clip[0].w * (1 - v[0] - v[1]) + clip[1].w * v[0] + clip[2].w * v[1];
        widen(plane[0], v[0] / w), widen(plane[1], v[1] / w), widen(plane[2], 1 / w);
    }
    const double rounded_at = float_slack * std::max(size_.x, size_.y) / reach, w = 1 / plane[2].low;
    for (int k = 0; k < 2; ++k) {
        const Interval& l = k ? l2 : l1;
        const double size = std::max(std::abs(l.low), std::abs(l.high));
        out.rounding[k] = float_ulps * std::max(1.0, largest_inverse_w * w) +
                          rounded_at * w * (plane[k].high - plane[k].low + size * (plane[2].high - plane[2].low));
    }
    out.l1 = {l1.low - out.rounding.x, l1.high + out.rounding.x};
    out.l2 = {l2.low - out.rounding.y, l2.high + out.rounding.y};
    const double z_rounding = float_ulps * largest_z + rounded_at * (z.high - z.low);
    out.z = {std::clamp(z.low - z_rounding, 0.0, 1.0),
             std::clamp(z.high + z_rounding, 0.0, 1.0)};
    out.l = {float(out.l1.middle()), float(out.l2.middle())};
}

// Whether the triangle may cover the centre. Wherever corners go within their slack, a square about each, the triangle
// lies in the sum of itself and the square: no axis of either separates that from the centre. And it covers the centre
// surely if the square about it lies inside of every edge.
bool LegalPixels::judge(const Entry& entry, glm::dvec2 centre, LegalTriangle& out) const {
    const Polygon p = polygon(entry.triangle);
    double area = 0;
    for (int i = 0; i < p.count; ++i) {
        const Corner &a = p.corner[i], &b = p.corner[(i + 1) % p.count];
        area += (a.x - centre.x) * (b.y - centre.y) - (a.y - centre.y) * (b.x - centre.x);
    }
    out.triangle = entry.triangle;
    out.sure = area != 0;
    out.open = p.clipped ? many : 0;
    for (int i = 0; i < p.count; ++i) {
        const Corner &a = p.corner[i], &b = p.corner[(i + 1) % p.count];
        const glm::dvec2 n = (area < 0 ? -1.0 : 1.0) * glm::dvec2(a.y - b.y, b.x - a.x);
        const double length2 = n.x * n.x + n.y * n.y;
        if (length2 == 0) continue;
        auto along = [&](const Corner& c) { return n.x * (c.x - centre.x) + n.y * (c.y - centre.y); };

        // No corner reaches as far as the centre, on either side.
        double low = infinity, high = -infinity;
        for (int k = 0; k < p.count; ++k) {
            const double reach = support(n, p.corner[k].slack);
            low = std::min(low, along(p.corner[k]) - reach), high = std::max(high, along(p.corner[k]) + reach);
        }
        if (low > 0 || high < 0) return false;

        // The slack of an edge beside the centre is that of its ends, as far as each is from there.
        const double along_edge = (centre.x - a.x) * (b.x - a.x) + (centre.y - a.y) * (b.y - a.y);
        const double s = std::clamp(along_edge / length2, 0.0, 1.0);
        if (-along(a) > support(n, a.slack + s * (b.slack - a.slack))) continue;
        out.sure = false;
        ++out.open;
        const glm::uvec3& t = scene_.geometry.triangles[std::size_t(entry.triangle)];
        out.edge[0] = scene_.clip_positions[t[i % 3]], out.edge[1] = scene_.clip_positions[t[(i + 1) % 3]];
        const bool swap = before(out.edge[1], out.edge[0]);
        if (swap) std::swap(out.edge[0], out.edge[1]);
        out.right = (area > 0) != swap;
    }
    if (area == 0) out.open = many;

    bound_values(p, centre, out);
    return passes_mask(out);
}

// Whether the material's alpha may let anything be seen there; `sure` is taken back where it may not.
bool LegalPixels::passes_mask(LegalTriangle& t) const {
    if (!scene_.surfaces.masked[std::size_t(scene_.geometry.material[std::size_t(t.triangle)])]) return true;
    if (!t.bounded) {
        t.sure = false, t.open = many;
        return true;
    }
    std::vector<Outcome> outcomes;
    enumerate_outcomes(
        [&](std::vector<Bounded>& values) {
            const vec2<Bounded> l{t.l1.bounded(t.l.x), t.l2.bounded(t.l.y)};
            const BoundedMask passes = passes_alpha<Bounded>(masks_, t.triangle, l);
            values.push_back(select(passes, Bounded(1.0f), Bounded(0.0f)));
        },
        most_outcomes, outcomes);
    bool may = false;
    for (const Outcome& o : outcomes) {
        const BoundedValue& v = o.values[0];
        may = may || o.ambiguous || v.shadow + v.bound > 0;
        if (o.ambiguous || v.shadow - v.bound < 1) t.sure = false, t.open = many;
    }
    return may;
}

// Ends of the depths that the triangle may have at the pixel; reversed depths are negated.
double LegalPixels::near_end(const LegalTriangle& t) const {
    return !t.bounded ? -infinity : reversed_z_ ? -t.z.high : t.z.low;
}
double LegalPixels::far_end(const LegalTriangle& t) const {
    return !t.bounded ? infinity : reversed_z_ ? -t.z.low : t.z.high;
}

// Whether the triangle may lie behind the layer before; `sure` is taken back where it may not.
bool LegalPixels::lies_behind(LegalTriangle& t, glm::ivec2 pixel) const {
    if (!behind_) return true;
    const double peeled = (reversed_z_ ? -1.0 : 1.0) * (*behind_)(pixel.x, pixel.y);
    if (!(near_end(t) > peeled)) t.sure = false, t.open = many;
    return far_end(t) > peeled;
}

void LegalPixels::at(glm::ivec2 pixel, std::vector<LegalTriangle>& out, bool& nothing) const {
    out.clear();
    nothing = true;
    const glm::dvec2 centre = glm::dvec2(pixel) + 0.5;
    const auto bin = std::size_t((pixel.y >> bin_shift) * bins_.x + (pixel.x >> bin_shift));
    // No triangle that lies behind one that surely covers the centre wins.
    double wall = infinity;
    for (std::size_t k = start_[bin]; k < start_[bin + 1]; ++k) {
        const Entry& e = entries_[k];
        if (e.nearest > wall) break;
        if (centre.x < e.low[0] || centre.x > e.high[0] || centre.y < e.low[1] || centre.y > e.high[1]) continue;
        LegalTriangle t;
        if (!judge(e, centre, t) || !lies_behind(t, pixel)) continue;
        out.push_back(t);
        if (t.sure) nothing = false, wall = std::min(wall, far_end(t));
    }
    for (std::size_t i = 0; i < out.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
            if (cover_together(out[i], out[j]))
                nothing = false, wall = std::min(wall, std::max(far_end(out[i]), far_end(out[j])));
    std::erase_if(out, [&](const LegalTriangle& t) { return near_end(t) > wall; });
}

}  // namespace plumb::raster
