// One update of the lightmap, and updates until nothing changes (IPR 3.3.1): how the five stages hang together, once, for frames,
// experiments and tests.
//
//     probes.radiance -> probes.lambda -> probes.basis -> probes.irradiance -> probes.lightmap -> the next probes.radiance
#pragma once

#include <array>

#include "gi/probes/lambda.h"
#include "gi/probes/radiance.h"
#include "gi/probes/run_params.h"
#include "gi/probes/update.h"

namespace plumb::probes {

// What probes and clusters of each level of detail use: the first rays, the first coefficients.
struct LevelCounts {
    int levels = 1;
    std::array<int, most_levels> rays{}, coefficients{};
};

// Where an update reads and writes. What a stage reads of another need not be what that writes: in a pipeline it is of the frame
// before. Images of relight rays have a column a ray and a row a probe.
struct UpdateBuffers {
    const RunData* data = nullptr;
    const Buffer<float>* harmonics = nullptr;  // [rays][coefficients]
    const Buffer<float>* weights = nullptr;    // [levels][rays]
    const std::vector<std::int32_t>*probe_level = nullptr, *cluster_level = nullptr;
    const std::vector<std::int32_t>* basis_level = nullptr;  // basis_levels(); null: cluster_level
    LevelCounts counts;
    Feedback feedback = Feedback::corrected;
    float constant = published_constant;
    const Image4 *surface = nullptr, *emitted = nullptr, *place = nullptr, *direct = nullptr;
    const Image4 *last_lightmap = nullptr, *read_lambda = nullptr, *read_basis = nullptr;
    Image4 *radiance = nullptr, *lambda = nullptr, *basis = nullptr, *irradiance = nullptr, *lightmap = nullptr;
    TilesToWrite* tiles = nullptr;  // of that lightmap; null: all are written
};
RadianceInputs radiance_inputs(const UpdateBuffers& b);
LambdaInputs lambda_inputs(const UpdateBuffers& b);
BasisInputs basis_inputs(const UpdateBuffers& b);
IrradianceInputs irradiance_inputs(const UpdateBuffers& b);
LightmapInputs lightmap_inputs(const UpdateBuffers& b);

// The five stages, one after the other.
void update(const UpdateBuffers& b, const RunOptions& options);

// The series of rounds. With I_k the irradiance after round k, s_k = sum |I_k - I_(k-1)| over receivers and channels, and
// g = s_k / s_(k-1), later rounds add about s_k g / (1 - g): that, and not the step, has to be small.
struct Convergence {
    int rounds = 0;
    double gain = 0;  // g of the last round whose step is more than rounding: what a round multiplies light by
    double left = 0;  // what all further rounds would add, of the sum of I; infinite where g is 1 or more, and after one round
    NegativeIrradiance negative;  // of the last round
};

// Updates from a black lightmap until `left` is at most params.tolerance, or params.rounds are done. Leaves the last lightmap in
// b.lightmap and the one before in `before`, so that one more update of it gives the last again; b.last_lightmap, b.read_lambda
// and b.read_basis are not asked. Throws InputError where light grows from round to round, with the gain, and where it is not finite.
Convergence converge(UpdateBuffers b, const RunParams& params, const RunOptions& options, Image4& before);

// A reason or a note: "23 rounds, gain 0.41, 0.02 % left, irradiance below 0 at 12 of 4096 receivers, -0.01 W/m2 at least".
std::string text_of(const Convergence& c);

}  // namespace plumb::probes
