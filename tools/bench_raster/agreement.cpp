#include "tools/bench_raster/agreement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace plumb::bench {
namespace {

constexpr double most_coverage = 0.01, most_position = 0.03, most_normal = 0.05, most_albedo = 0.05;

float furthest(const glm::vec4& a, const glm::vec4& b) {
    return std::max({std::abs(a.x - b.x), std::abs(a.y - b.y), std::abs(a.z - b.z)});
}

// One side truncates to half precision and the other rounds: a unit each.
bool near_position(const glm::vec4& a, const glm::vec4& b) {
    const float largest = std::max({std::abs(a.x), std::abs(a.y), std::abs(a.z)});
    return furthest(a, b) <= 0.01f + largest / 512;
}

}  // namespace

bool Agreement::plausible() const {
    return covered > 0.05 && coverage <= most_coverage && position <= most_position && normal <= most_normal &&
           albedo <= most_albedo;
}

std::string Agreement::text() const {
    return fmt::format(
        "covered {:.1f} %; of all pixels differ in coverage {:.3f} %, position {:.3f} %, normal {:.3f} %, "
        "albedo {:.3f} %",
        100 * covered, 100 * coverage, 100 * position, 100 * normal, 100 * albedo);
}

Agreement compare(const raster::GBuffer& ours, const raster::GBuffer& theirs) {
    Agreement out;
    const std::size_t n = ours.depth.size();
    for (std::size_t i = 0; i < n; ++i) {
        const bool here = ours.depth.texels[i] < 1, there = theirs.depth.texels[i] < 1;
        out.covered += here;
        out.coverage += here != there;
        if (!here || !there) continue;
        out.position += !near_position(ours.position.texels[i], theirs.position.texels[i]);
        const glm::vec4 a = ours.normal.texels[i], b = theirs.normal.texels[i];
        out.normal += !(a.x * b.x + a.y * b.y + a.z * b.z > 0.996f);
        out.albedo += !(furthest(ours.albedo.texels[i], theirs.albedo.texels[i]) <= 0.03f);
    }
    for (double* share : {&out.covered, &out.coverage, &out.position, &out.normal, &out.albedo}) *share /= double(n);
    return out;
}

}  // namespace plumb::bench
