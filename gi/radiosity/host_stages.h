// The steps of radiosity that no device runs: what `plumb stages` lists of them, light at elements, and the solution.
#pragma once

#include <string>

#include "core/stage.h"
#include "gi/radiosity/radiosity_params.h"

namespace plumb::radiosity {

StageInfo info_elements();
StageInfo info_rows();
StageInfo info_light();
StageInfo info_solve();

// Irradiance of elements by lamps, W/m2: where each looks from, along its normal, with shadows by rays.
Buffer<glm::vec4> lamps_at(const Scene& scene, const Elements& elements, const RunOptions& options);
// The same by the sky, of a colour everywhere: pi times its radiance times the share of texels that see nothing.
Buffer<glm::vec4> sky_at(const Scene& scene, const FormFactors& factors);

struct Solved {
    int passes = 0;
    double radius = 0;  // estimated: by what each pass shrinks what is left
    double error = 0;   // estimated, of the mean radiosity
};
std::string text_of(const Solved& solved);

// B = M + rho (lamps + sky + F B), by passes from black (HEM 4.5.4), until the estimated error is below the tolerance. Throws
// InputError where that takes more passes than are allowed, or diverges.
Solved solve(const FormFactors& factors, const Elements& elements, const Buffer<glm::vec4>& lamps, const Buffer<glm::vec4>& sky,
             const RadiosityParams& params, const RunOptions& options, Buffer<glm::vec4>& radiosity);

}  // namespace plumb::radiosity
