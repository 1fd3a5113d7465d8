#include "gi/probes/converge.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/host_math.h"

namespace plumb::probes {

RunTime::RunTime(const Bake& bake, Relit relit, Transport transport, std::vector<std::int32_t> stand_in)
    : bake_(bake), relit_(std::move(relit)), transport_(transport), stand_in_(std::move(stand_in)) {
    const std::size_t rays = bake.relight.material.size();
    for (const auto* list : {&relit_.emitted, &relit_.reflectance, &relit_.direct})
        if (list->size() != rays) throw InputError("run time: as many surfaces as relight rays expected");
    if (!stand_in_.empty() && stand_in_.size() != rays) throw InputError("run time: as many stand-ins as relight rays expected");
    Image<std::int32_t> receivers(bake.atlas.size.x, bake.atlas.size.y, -1);
    for (int i = 0; i < bake.receivers.count(); ++i) {
        const glm::ivec2 t = bake.receivers.texel[std::size_t(i)];
        receivers(t.x, t.y) = i;
    }
    receiver_of_.assign(rays, -1);
    for (std::size_t k = 0; k < rays; ++k) {
        if (bake.relight.material[k] < 0) continue;
        receiver_of_[k] = receiver_at(receivers, bake.relight.uv[k]);
        without_receiver_ += receiver_of_[k] < 0 ? 1 : 0;
    }
    irradiance_.assign(std::size_t(bake.receivers.count()), glm::dvec3(0));
}

// The receiver of that texel, or the nearest within two.
std::int32_t RunTime::receiver_at(const Image<std::int32_t>& receivers, const glm::vec2& uv) const {
    const int x = std::clamp(int(uv.x * float(receivers.width)), 0, receivers.width - 1),
              y = std::clamp(int(uv.y * float(receivers.height)), 0, receivers.height - 1);
    for (int reach = 0; reach <= 2; ++reach)
        for (int ty = std::max(y - reach, 0); ty <= std::min(y + reach, receivers.height - 1); ++ty)
            for (int tx = std::max(x - reach, 0); tx <= std::min(x + reach, receivers.width - 1); ++tx)
                if (receivers(tx, ty) >= 0) return receivers(tx, ty);
    return -1;
}

std::vector<glm::dvec3> RunTime::radiance() const {
    std::vector<glm::dvec3> f = relit_.emitted;
    for (std::size_t k = 0; k < f.size(); ++k) {
        const std::int32_t receiver = receiver_of_[k];
        const glm::dvec3 indirect = receiver < 0 ? glm::dvec3(0) : irradiance_[std::size_t(receiver)];
        f[k] += relit_.reflectance[k] * (relit_.direct[k] + indirect) / host::pi;
    }
    return f;
}

std::vector<glm::dvec3> RunTime::lambda() const {
    std::vector<glm::dvec3> f = radiance();
    if (!stand_in_.empty()) {
        const std::vector<glm::dvec3> found = f;
        for (std::size_t k = 0; k < f.size(); ++k) f[k] = found[std::size_t(stand_in_[k])];
    }
    return probe_coefficients(f, bake_.relight.probes, bake_.relight_weights, bake_.harmonics, bake_.params.degree);
}

std::vector<glm::dvec3> RunTime::lambda_everywhere() const {
    return probe_coefficients(radiance(), bake_.relight.probes, bake_.relight_weights, bake_.harmonics, bake_.params.degree);
}

std::vector<glm::dvec3> clustered_irradiance(const Bake& b, const std::vector<glm::dvec3>& lambda) {
    std::vector<glm::dvec3> all(std::size_t(b.receivers.count()), glm::dvec3(0));
    const std::size_t coefficients = std::size_t(b.coefficients()), kept = std::size_t(b.clusters.singular_values);
    for (const Cluster& c : b.clusters.clusters) {
        std::vector<glm::dvec3> basis(std::size_t(c.rank), glm::dvec3(0));
        for (std::size_t k = 0; k < basis.size(); ++k)
            for (std::size_t p = 0; p < c.probes.size(); ++p)
                for (std::size_t j = 0; j < coefficients; ++j)
                    basis[k] += double(c.sigma_vt[(k * c.probes.size() + p) * coefficients + j]) *
                                lambda[std::size_t(c.probes[p]) * coefficients + j];
        for (const std::int32_t i : c.receivers)
            for (std::size_t k = 0; k < basis.size(); ++k)
                all[std::size_t(i)] += double(b.clusters.u[std::size_t(i) * kept + k]) * basis[k];
    }
    return all;
}

void RunTime::round() {
    const std::vector<glm::dvec3> of_probes = lambda();
    irradiance_ = transport_ == Transport::clustered
                      ? clustered_irradiance(bake_, of_probes)
                      : probes::irradiance(bake_.supports, bake_.alpha, bake_.params.degree, of_probes);
}

int RunTime::converge(int most, double change) {
    for (int done = 1; done <= most; ++done) {
        const std::vector<glm::dvec3> before = irradiance_;
        round();
        double sum = 0, largest = 0;
        for (std::size_t i = 0; i < before.size(); ++i)
            for (int c = 0; c < 3; ++c) {
                sum += std::fabs(irradiance_[i][c]);
                largest = std::max(largest, std::fabs(irradiance_[i][c] - before[i][c]));
            }
        if (largest <= change * sum / (3 * double(before.size()))) return done;
    }
    return most;
}

double RunTime::mean() const {
    double sum = 0;
    for (const glm::dvec3& e : irradiance_) sum += e.x;
    return sum / double(irradiance_.size());
}

double RunTime::spread() const {
    double most = 0;
    for (const glm::dvec3& e : irradiance_) most = std::max(most, std::fabs(e.x / mean() - 1));
    return most;
}

}  // namespace plumb::probes
