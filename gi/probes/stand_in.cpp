#include "gi/probes/stand_in.h"

#include <algorithm>

#include "core/error.h"
#include "core/parallel.h"
#include "gi/probes/bake.h"
#include "gi/probes/sky_probe.h"

namespace plumb::probes {

namespace {

double cosine_of(const Buffer<glm::vec4>& directions, int a, int b) {
    const glm::dvec3 u(directions[std::size_t(a)]), v(directions[std::size_t(b)]);
    return u.x * v.x + u.y * v.y + u.z * v.z;
}

// Of each direction the others that are nearest to it, nearest first: most stand-ins are among them.
class NearRays {
  public:
    NearRays(const Buffer<glm::vec4>& directions, const RunOptions& options)
        : directions_(directions), rays_(int(directions.size())), kept_(std::min(32, rays_)), near_(std::size_t(rays_) * std::size_t(kept_)) {
        parallel_bands(rays_, 8, options, [&](int first, int last) {
            std::vector<std::pair<double, int>> all(directions_.size());  // minus the cosine, ray: pairs order as the search does
            for (int r = first; r < last; ++r) {
                for (int q = 0; q < rays_; ++q) all[std::size_t(q)] = {-cosine_of(directions_, r, q), q};
                std::partial_sort(all.begin(), all.begin() + kept_, all.end());
                for (int k = 0; k < kept_; ++k) near_[std::size_t(r) * std::size_t(kept_) + std::size_t(k)] = all[std::size_t(k)].second;
            }
        });
    }

    // asked: of one probe.
    int nearest(int ray, const std::uint8_t* asked) const {
        const std::int32_t* near = near_.data() + std::size_t(ray) * std::size_t(kept_);
        for (int k = 0; k < kept_; ++k)
            if (asked[near[k]]) return near[k];
        int best = ray;
        double most = -2;
        for (int q = 0; q < rays_; ++q)
            if (const double c = asked[q] ? cosine_of(directions_, ray, q) : -2; c > most) most = c, best = q;
        return best;
    }

  private:
    const Buffer<glm::vec4>& directions_;
    int rays_, kept_;
    std::vector<std::int32_t> near_;
};

}  // namespace

std::vector<std::int32_t> stand_ins(const Buffer<glm::vec4>& directions, const std::vector<std::uint8_t>& asked, const RunOptions& options) {
    const int rays = int(directions.size());
    if (rays == 0 ? !asked.empty() : asked.size() % std::size_t(rays) != 0)
        throw InputError("stand-ins: a whole number of probes' rays expected");
    const int probes = rays == 0 ? 0 : int(asked.size() / std::size_t(rays));
    std::vector<std::int32_t> of(asked.size());
    for (std::size_t i = 0; i < of.size(); ++i) of[i] = std::int32_t(i);
    if (std::find(asked.begin(), asked.end(), std::uint8_t(0)) == asked.end()) return of;
    const NearRays near(directions, options);
    parallel_bands(probes, 1, options, [&](int begin, int end) {
        for (int p = begin; p < end; ++p) {
            const std::int32_t first = std::int32_t(p) * rays;
            for (int r = 0; r < rays; ++r)
                if (!asked[std::size_t(first + r)]) of[std::size_t(first + r)] = first + near.nearest(r, asked.data() + first);
        }
    });
    return of;
}

std::vector<std::uint8_t> asked_rays(const std::vector<std::int32_t>& material, int rays, int standing, Escape escape, Unasked unasked) {
    std::vector<std::uint8_t> asked;
    asked.reserve(material.size());
    const bool everywhere = escape != Escape::nothing && escape != Escape::sky;
    for (std::size_t k = 0; k < material.size(); ++k) {
        const bool sky = everywhere || k / std::size_t(rays) >= std::size_t(standing);
        asked.push_back(unasked == Unasked::black || material[k] >= 0 || (material[k] == met_nothing && sky) ? 1 : 0);
    }
    return asked;
}

std::vector<std::int32_t> stand_ins(const Bake& bake, Unasked unasked, const RunOptions& options) {
    return stand_ins(bake.relight_directions,
                     asked_rays(bake.relight.material, bake.relight.rays, standing_probes(bake.placement.probes), bake.transport.escape, unasked), options);
}

}  // namespace plumb::probes
