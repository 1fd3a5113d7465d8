// Seams: edges in space that have two places on the lightmap.
#include <algorithm>
#include <array>
#include <cmath>

#include "core/host_math.h"
#include "gi/probes/lightmap_check_parts.h"
#include "gi/probes/surface_mesh.h"

namespace plumb::probes {

namespace {

constexpr double points_a_texel = 2;
constexpr double points_alike = 6;                // points that share texels, and noise with them
constexpr int most_points = 4096;                 // of an edge
constexpr std::uint32_t most_at_an_edge = 4;      // half edges that are held against each other
constexpr double smooth_cosine = 0.984807753012208;  // of 10 degrees

// A half edge from its lower point to the higher one.
struct Side {
    std::uint32_t triangle = 0;
    std::array<std::uint32_t, 2> vertex{};
    std::array<glm::dvec3, 2> normal{};
    glm::dvec2 from{0}, to{0};  // texels
    std::int32_t chart = -1;
};

Side side_of(const CheckInputs& in, const SurfaceMesh& m, std::uint32_t h) {
    const std::uint32_t next = next_half_edge(h);
    Side s;
    s.triangle = h / 3;
    s.vertex = {m.corners(h / 3)[int(h % 3)], m.corners(next / 3)[int(next % 3)]};
    if (m.point[h] > m.point[next]) std::swap(s.vertex[0], s.vertex[1]);
    const glm::dvec2 size(in.atlas().size);
    s.from = glm::dvec2(in.atlas().uv[s.vertex[0]]) * size, s.to = glm::dvec2(in.atlas().uv[s.vertex[1]]) * size;
    s.chart = in.atlas().chart[s.triangle];
    for (std::size_t end = 0; end < 2; ++end) {
        const glm::dvec3 n(in.atlas().geometry.vertices[s.vertex[end]].normal);
        s.normal[end] = n == glm::dvec3(0) ? m.normal[s.triangle] : n;
    }
    return s;
}

double length_of(const glm::dvec2& v) { return std::sqrt(v.x * v.x + v.y * v.y); }

// What both sides show at one point of the edge.
struct Point {
    double user_a, user_b, truth_a, truth_b;
    double variance;  // of truth_a - truth_b, and of user_a - user_b where that is known
    double own_variance;  // of truth_a - truth_b alone
};
std::optional<Point> point_of(const CheckInputs& in, const Side& a, const Side& b, double along) {
    const Bilinear at_a = bilinear(a.from + along * (a.to - a.from), in.atlas().size),
                   at_b = bilinear(b.from + along * (b.to - b.from), in.atlas().size);
    const TexelValue truth_a = in.truth.lookup(a.chart, at_a), truth_b = in.truth.lookup(b.chart, at_b);
    if (!truth_a.known || !truth_b.known) return {};
    const auto variance = [](const TexelValue& x, const TexelValue& y) {
        const double error_x = compare::luminance(x.error), error_y = compare::luminance(y.error);
        return error_x * error_x + error_y * error_y;
    };
    return Point{compare::luminance(in.user_lookup(at_a)), compare::luminance(in.user_lookup(at_b)),
                 compare::luminance(truth_a.value), compare::luminance(truth_b.value), variance(truth_a, truth_b),
                 variance(in.alone.lookup(a.chart, at_a), in.alone.lookup(b.chart, at_b))};
}

Place place_of_side(const CheckInputs& in, const Seam& seam, const Side& s, double along, double user, double truth, double error) {
    Place p;
    p.texel = glm::clamp(glm::ivec2(glm::floor(s.from + along * (s.to - s.from))), glm::ivec2(0), in.atlas().size - 1);
    p.object = in.atlas().geometry.object[s.triangle];
    p.chart = s.chart;
    p.position = seam.from + along * (seam.to - seam.from);
    p.user = user, p.truth = truth, p.error = error;
    return p;
}

// What a sum of n squares of normal numbers, over n, exceeds with a probability of at most e^-x (Laurent and Massart 2000,
// lemma 1).
double largest_by_chance(double n, double x) {
    const double y = x / std::max(n, 1.0);
    return 1 + 2 * std::sqrt(y) + 2 * y;
}

struct Relative {
    double user = 0, truth = 0;  // means of (a - b)^2 over the light's square; the truth's less its variance
};

// rarity: an excess by chance has a probability of at most e^-rarity.
Seam measure(const CheckInputs& in, const Side& a, const Side& b, double rarity, Relative& relative) {
    Seam s;
    s.a_from = a.from, s.a_to = a.to, s.b_from = b.from, s.b_to = b.to;
    s.from = glm::dvec3(in.atlas().geometry.vertices[a.vertex[0]].position);
    s.to = glm::dvec3(in.atlas().geometry.vertices[a.vertex[1]].position);
    const glm::dvec3 d = s.to - s.from;
    s.length = std::sqrt(glm::dot(d, d));
    s.smooth = glm::dot(a.normal[0], b.normal[0]) > smooth_cosine && glm::dot(a.normal[1], b.normal[1]) > smooth_cosine;
    const double texels = std::max(length_of(a.to - a.from), length_of(b.to - b.from));
    const int n = int(std::clamp(std::ceil(points_a_texel * texels), 1.0, double(most_points)));
    double squares = 0, variances = 0, lights = 0;
    for (int k = 0; k < n; ++k) {
        const double along = (k + 0.5) / n;
        const std::optional<Point> p = point_of(in, a, b, along);
        if (!p) continue;
        const double difference = (p->user_a - p->user_b) - (p->truth_a - p->truth_b);
        const double light = std::max((p->truth_a + p->truth_b) / 2, in.floor), user = std::fabs(p->user_a - p->user_b),
                     truth = std::fabs(p->truth_a - p->truth_b), error = std::sqrt(p->variance);
        squares += difference * difference, variances += p->variance, lights += light;
        ++s.points, s.user += user, s.truth += truth;
        relative.user += user * user / (light * light), relative.truth += (truth * truth - p->own_variance) / (light * light);
        if (s.points > 1 && !(std::fabs(difference) / light > s.worst)) continue;
        s.worst = std::fabs(difference) / light;
        s.a = place_of_side(in, s, a, along, p->user_a, p->truth_a, error);
        s.b = place_of_side(in, s, b, along, p->user_b, p->truth_b, error);
    }
    if (s.points == 0) return s;
    if (squares > variances * largest_by_chance(s.points / points_alike, rarity))
        s.excess = std::sqrt((squares - variances) * s.points) / lights;
    for (double* mean : {&s.user, &s.truth, &relative.user, &relative.truth}) *mean /= s.points;
    return s;
}

using Sides = std::pair<Side, Side>;
std::vector<Sides> edges_with_two_places(const CheckInputs& in) {
    // All objects as one surface: walls made of pieces have seams, too.
    const SurfaceMesh m = surface_mesh(in.atlas().geometry, 0, 0, in.atlas().geometry.triangles.size());
    std::vector<Sides> edges;
    for (std::size_t e = 0; e + 1 < m.edge_begin.size(); ++e) {
        const std::uint32_t first = m.edge_begin[e], last = std::min(m.edge_begin[e + 1], first + most_at_an_edge);
        for (std::uint32_t i = first; i < last; ++i)
            for (std::uint32_t k = i + 1; k < last; ++k) {
                const Side a = side_of(in, m, m.half_edges[i]), b = side_of(in, m, m.half_edges[k]);
                if (a.chart >= 0 && b.chart >= 0 && (a.from != b.from || a.to != b.to)) edges.push_back({a, b});
            }
    }
    return edges;
}

}  // namespace

void find_seams(const CheckInputs& in, LightmapCheck& out) {
    const std::vector<Sides> edges = edges_with_two_places(in);
    // As seldom as one value lies `sigmas` out, over all edges together.
    const double rarity = in.params.sigmas * in.params.sigmas / 2 + host::log(double(std::max(edges.size(), std::size_t(1))));
    double length = 0, smooth_length = 0;
    for (const auto& [a, b] : edges) {
        Relative relative;
        const Seam seam = measure(in, a, b, rarity, relative);
        if (seam.points == 0) {
            ++out.seams_unknown;
            continue;
        }
        length += seam.length, out.seam_mean += seam.length * seam.excess;
        out.seams_off += seam.excess > in.params.seam;
        if (seam.smooth) {
            smooth_length += seam.length;
            out.smooth_user += seam.length * relative.user, out.smooth_truth += seam.length * relative.truth;
        }
        out.seams.push_back(seam);
    }
    if (length > 0) out.seam_mean /= length;
    for (double* square : {&out.smooth_user, &out.smooth_truth})
        *square = smooth_length > 0 ? std::sqrt(std::max(*square / smooth_length, 0.0)) : 0;
    std::stable_sort(out.seams.begin(), out.seams.end(), [](const Seam& a, const Seam& b) { return a.excess > b.excess; });
}

}  // namespace plumb::probes
