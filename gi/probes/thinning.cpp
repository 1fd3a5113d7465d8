#include "gi/probes/thinning.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <queue>

#include "core/error.h"
#include "gi/probes/density.h"

namespace plumb::probes {

namespace {

// Densities as whole numbers of 2^-32: differences are exact.
std::int64_t fixed(float x) { return std::int64_t(std::floor(double(x) * 0x1p32 + 0.5)); }
// As they are compared.
std::int64_t steps(std::int64_t density) { return (density + (1 << 19)) >> 20; }

// Candidates sorted into cubes of the kernel's radius.
class Neighbours {
  public:
    Neighbours(const Buffer<glm::vec4>& positions, float radius) : positions_(positions), radius_(radius) {
        low_ = positions[0];
        for (const glm::vec4& p : positions)
            for (int c = 0; c < 3; ++c) low_[c] = std::min(low_[c], p[c]);
        sorted_.reserve(positions.size());
        for (std::size_t i = 0; i < positions.size(); ++i)
            sorted_.push_back({key(cube(positions[i])), std::int32_t(i)});
        std::sort(sorted_.begin(), sorted_.end(), [](const Entry& a, const Entry& b) {
            return a.key != b.key ? a.key < b.key : a.index < b.index;
        });
    }

    // Calls visit(j) for all that may lie within the radius of candidate i, itself included.
    template <class Visit>
    void around(std::int32_t i, Visit visit) const {
        const Cube c = cube(positions_[std::size_t(i)]);
        for (std::int64_t z = c.z - 1; z <= c.z + 1; ++z)
            for (std::int64_t y = c.y - 1; y <= c.y + 1; ++y) {
                const std::int64_t last = key({c.x + 1, y, z});
                auto at = std::lower_bound(sorted_.begin(), sorted_.end(), key({c.x - 1, y, z}),
                                           [](const Entry& e, std::int64_t k) { return e.key < k; });
                for (; at != sorted_.end() && at->key <= last; ++at) visit(at->index);
            }
    }

  private:
    struct Entry {
        std::int64_t key;
        std::int32_t index;
    };
    struct Cube {
        std::int64_t x, y, z;
    };

    // Far away cubes count as one, which loses nobody.
    std::int64_t along(float x, float low) const {
        return 1 + std::int64_t(std::min(std::floor((double(x) - double(low)) / double(radius_) * (1 - 0x1p-20)), 0x1p20 - 4));
    }
    Cube cube(const glm::vec4& p) const { return {along(p.x, low_.x), along(p.y, low_.y), along(p.z, low_.z)}; }
    static std::int64_t key(const Cube& c) { return (c.z << 40) + (c.y << 20) + c.x; }

    const Buffer<glm::vec4>& positions_;
    float radius_;
    glm::vec4 low_{0};
    std::vector<Entry> sorted_;
};

struct Densest {
    std::int64_t steps;
    std::int32_t index;
    friend bool operator<(const Densest& a, const Densest& b) {
        return a.steps != b.steps ? a.steps < b.steps : a.index > b.index;
    }
};

// The indices that are left of `positions`: `wanted`, or more where none has a neighbour within the radius. A density
// only falls, so one that was written down is a bound: what is on top and has not changed is the densest.
std::vector<std::int32_t> remove_densest(const Buffer<glm::vec4>& positions, const Buffer<float>& density, float radius,
                                         int wanted) {
    const Neighbours neighbours(positions, radius);
    const float inverse = 1 / radius;
    std::vector<std::int64_t> left(positions.size());
    std::vector<char> removed(positions.size(), 0);
    std::priority_queue<Densest> densest;
    for (std::size_t i = 0; i < left.size(); ++i) {
        left[i] = fixed(density[i]);
        densest.push({steps(left[i]), std::int32_t(i)});
    }
    for (std::size_t n = positions.size(); n > std::size_t(wanted);) {
        const Densest top = densest.top();
        if (top.steps <= 0) break;
        densest.pop();
        if (const std::int64_t now = steps(left[std::size_t(top.index)]); now != top.steps) {
            densest.push({now, top.index});
            continue;
        }
        removed[std::size_t(top.index)] = 1, --n;
        const glm::vec3 p(positions[std::size_t(top.index)]);
        neighbours.around(top.index, [&](std::int32_t j) {
            if (removed[std::size_t(j)]) return;
            const float t = sqrt(distance2<float>(glm::vec3(positions[std::size_t(j)]), p)) * inverse;
            if (t < 1) left[std::size_t(j)] -= fixed(spatial_weight<float>(t));
        });
    }
    std::vector<std::int32_t> kept;
    for (std::size_t i = 0; i < removed.size(); ++i)
        if (!removed[i]) kept.push_back(std::int32_t(i));
    return kept;
}

}  // namespace

Thinned thin(const Buffer<glm::vec4>& positions, float radius, int wanted, const RunOptions& options) {
    if (wanted < 1 || std::size_t(wanted) > positions.size())
        throw InputError(fmt::format("probes: {} of {} candidates wanted", wanted, positions.size()));
    Thinned t;
    run(DensityInputs{&positions, radius}, options, t.density);
    t.radius = radius;
    t.kept = remove_densest(positions, t.density, radius, wanted);
    while (t.kept.size() > std::size_t(wanted)) {
        t.radius *= 2, ++t.doublings;
        Buffer<glm::vec4> left;
        for (const std::int32_t i : t.kept) left.push_back(positions[std::size_t(i)]);
        Buffer<float> density;
        run(DensityInputs{&left, float(t.radius)}, options, density);
        std::vector<std::int32_t> kept;
        for (const std::int32_t i : remove_densest(left, density, float(t.radius), wanted))
            kept.push_back(t.kept[std::size_t(i)]);
        t.kept = std::move(kept);
    }
    return t;
}

}  // namespace plumb::probes
