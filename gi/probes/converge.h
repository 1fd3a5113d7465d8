// Irradiance on the lightmap by a bake: the run time's three formulas in double, round after round, until their stages come.
//
//     f(r)   = emitted + reflectance / pi (direct + I)             what relight ray r finds to leave the surface
//     lambda = sum_r w_r f(r) Y_j(r)                               IPR (10)
//     I      = sum_ij lambda_ij alpha_ij, or U (Sigma V^T lambda)  IPR (5), 3.3.1.2, 3.3.1.3
#pragma once

#include <vector>

#include "gi/probes/bake.h"

namespace plumb::probes {

// Of each relight ray, [probes][rays].
struct Relit {
    std::vector<glm::dvec3> emitted;      // radiance, W/(m2 sr)
    std::vector<glm::dvec3> reflectance;  // diffuse
    std::vector<glm::dvec3> direct;       // irradiance, W/m2
};

enum class Transport : int { whole, clustered };

// I = U (Sigma V^T lambda) of all receivers of a whole bake, W/m2; 0 of those without probe. IPR 3.3.1.2, 3.3.1.3.
std::vector<glm::dvec3> clustered_irradiance(const Bake& bake, const std::vector<glm::dvec3>& lambda);

class RunTime {
  public:
    // The bake must outlive it, and be whole: not a part. stand_in: stand_ins(); empty: each ray for itself. Throws InputError for
    // lists of another length.
    RunTime(const Bake& bake, Relit relit, Transport transport, std::vector<std::int32_t> stand_in = {});

    // I of the receivers becomes what the probes see of the last round's.
    void round();
    // Rounds until the largest change is at most `change` times the mean, or `most` of them; returns how many.
    int converge(int most, double change);

    const std::vector<glm::dvec3>& irradiance() const { return irradiance_; }  // [receivers], W/m2
    // What the probes see of it, [probes][(degree + 1)^2], W/(m2 sr).
    std::vector<glm::dvec3> lambda() const;
    // The same without stand-ins: for who asks everywhere.
    std::vector<glm::dvec3> lambda_everywhere() const;
    double mean() const;    // of x over the receivers
    double spread() const;  // largest |x / mean - 1|
    // Relight rays that met a surface without a receiver within two texels: they bring what is emitted alone.
    int without_receiver() const { return without_receiver_; }

  private:
    std::vector<glm::dvec3> radiance() const;
    std::int32_t receiver_at(const Image<std::int32_t>& receivers, const glm::vec2& uv) const;

    const Bake& bake_;
    Relit relit_;
    Transport transport_;
    std::vector<std::int32_t> stand_in_;     // [probes][rays], of the same probe
    std::vector<std::int32_t> receiver_of_;  // [probes][rays]; -1: none
    std::vector<glm::dvec3> irradiance_;
    int without_receiver_ = 0;
};

}  // namespace plumb::probes
