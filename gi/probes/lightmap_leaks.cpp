// Light where the truth has little or none, and texels beside charts that lookups read.
#include <algorithm>
#include <cmath>

#include "gi/probes/lightmap_check_parts.h"
#include "gi/probes/overlap.h"

namespace plumb::probes {

namespace {

// Twice the truth, and beyond its noise by a share of the light that the map has in its middle.
bool leaks(const CheckInputs& in, const Place& p) {
    return p.user > 2 * p.truth + in.params.sigmas * p.error + in.params.leak * (in.median > 0 ? in.median : in.floor);
}

// 0: no leak; 1 + LeakKind.
Image<std::uint8_t> leak_marks(const CheckInputs& in, LightmapCheck& out) {
    Image<std::uint8_t> marks(in.receivers().size.x, in.receivers().size.y, 0);
    for (int i = 0; i < in.receivers().count(); ++i) {
        const Place p = place_of(in, i);
        if (in.is_inside(i) || !leaks(in, p)) continue;
        const bool black = glm::vec3(in.truth.truth().mean[std::size_t(i)]) == glm::vec3(0);
        marks(p.texel.x, p.texel.y) = std::uint8_t(1 + int(black ? LeakKind::black : LeakKind::lit));
        ++(black ? out.black_leaking : out.leaking);
    }
    return marks;
}

// Texels of one kind that touch `start`, also at corners; they are unmarked.
Leak take_leak(const CheckInputs& in, Image<std::uint8_t>& marks, const glm::ivec2& start) {
    const std::uint8_t kind = marks(start.x, start.y);
    Leak leak;
    leak.kind = LeakKind(kind - 1);
    std::vector<glm::ivec2> open = {start};
    marks(start.x, start.y) = 0;
    while (!open.empty()) {
        const glm::ivec2 at = open.back();
        open.pop_back();
        const Place p = place_of(in, in.truth.receiver_at(at));
        const double by = p.user - p.truth, most = leak.worst.user - leak.worst.truth;
        // Of equal ones the first in the map's order, whatever way the texels were found.
        const bool before = by == most && (p.texel.y < leak.worst.texel.y || (p.texel.y == leak.worst.texel.y && p.texel.x < leak.worst.texel.x));
        if (leak.texels == 0 || by > most || before) leak.worst = p;
        ++leak.texels;
        for (int dy = -1; dy <= 1; ++dy)
            for (int dx = -1; dx <= 1; ++dx) {
                const glm::ivec2 beside = at + glm::ivec2(dx, dy);
                if (in.truth.receiver_at(beside) < 0 || marks(beside.x, beside.y) != kind) continue;
                marks(beside.x, beside.y) = 0;
                open.push_back(beside);
            }
    }
    return leak;
}

// A texel and a chart whose lookups read it.
struct Read {
    glm::ivec2 texel;
    std::int32_t chart;
    bool operator<(const Read& o) const {
        if (texel.y != o.texel.y) return texel.y < o.texel.y;
        return texel.x != o.texel.x ? texel.x < o.texel.x : chart < o.chart;
    }
    bool operator==(const Read& o) const { return texel == o.texel && chart == o.chart; }
};

// A lookup reads a texel that is nearer than one texel along both axes; those that count, with a weight of 1/16 at least.
constexpr double reach = 1 - 1.0 / 16;

std::vector<Read> reads_beside_charts(const CheckInputs& in) {
    const Atlas& a = in.atlas();
    std::vector<Read> reads;
    for (std::size_t t = 0; t < a.chart.size(); ++t) {
        const std::int32_t chart = a.chart[t];
        if (chart < 0) continue;
        PlaneTriangle p;
        for (int k = 0; k < 3; ++k) p[std::size_t(k)] = glm::dvec2(a.uv[a.geometry.triangles[t][k]]) * glm::dvec2(a.size);
        const PlaneBox box = bounds_of(p);
        const glm::ivec2 low = glm::max(glm::ivec2(glm::floor(box.low)) - 1, glm::ivec2(0)),
                         high = glm::min(glm::ivec2(glm::floor(box.high)) + 1, a.size - 1);
        for (int y = low.y; y <= high.y; ++y)
            for (int x = low.x; x <= high.x; ++x) {
                const int receiver = in.truth.receiver_at({x, y});
                if (receiver >= 0 && in.truth.chart_of(receiver) == chart) continue;
                const glm::dvec2 centre(x + 0.5, y + 0.5);
                if (reaches(p, {centre - reach, centre + reach})) reads.push_back({{x, y}, chart});
            }
    }
    std::sort(reads.begin(), reads.end());
    reads.erase(std::unique(reads.begin(), reads.end()), reads.end());
    return reads;
}

// A receiver of the chart that is nearest to the texel, of equally near ones the first: where that is.
int receiver_beside(const CheckInputs& in, const Read& read) {
    for (int ring = 1; ring <= border_rings; ++ring)
        for (int dy = -ring; dy <= ring; ++dy)
            for (int dx = -ring; dx <= ring; ++dx) {
                const int i = in.truth.receiver_at(read.texel + glm::ivec2(dx, dy));
                if (i >= 0 && in.truth.chart_of(i) == read.chart) return i;
            }
    return -1;
}

}  // namespace

void find_leaks(const CheckInputs& in, LightmapCheck& out) {
    Image<std::uint8_t> marks = out.leak_marks = leak_marks(in, out);
    for (int y = 0; y < marks.height; ++y)
        for (int x = 0; x < marks.width; ++x)
            if (marks(x, y) != 0) out.leaks.push_back(take_leak(in, marks, {x, y}));
    std::stable_sort(out.leaks.begin(), out.leaks.end(), [](const Leak& a, const Leak& b) { return a.texels > b.texels; });
}

void find_bleeding(const CheckInputs& in, LightmapCheck& out) {
    for (const Read& read : reads_beside_charts(in)) {
        ++out.read_beside;
        const TexelValue expected = in.truth.expected(read.chart, read.texel);
        if (!expected.known) {
            ++out.read_unknown;
            continue;
        }
        Bleeding b;
        b.place = place_of(in, receiver_beside(in, read));
        b.place.texel = read.texel, b.place.chart = read.chart;
        b.place.user = in.user_at(read.texel);
        b.place.truth = compare::luminance(expected.value), b.place.error = compare::luminance(expected.error);
        const double allowed = in.params.sigmas * b.place.error + in.params.bleeding * std::max(b.place.truth, std::max(in.median / 4, in.floor));
        if (!(std::fabs(b.place.user - b.place.truth) > allowed)) continue;
        b.kind = in.truth.receiver_at(read.texel) >= 0 ? BleedingKind::other_chart
                 : b.place.user == 0                   ? BleedingKind::unwritten
                                                       : BleedingKind::wrong;
        out.bleeding.push_back(b);
    }
}

}  // namespace plumb::probes
