#include "gi/radiosity/host_stages.h"

#include <fmt/format.h>

#include <cmath>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/probes/host_step.h"
#include "gi/probes/lit_hits.h"
#include "gi/radiosity/gather.h"

namespace plumb::radiosity {

namespace {

constexpr auto step = probes::host_step<RadiosityParams>;

const Port elements = {"elements", "arrays", "", "positions, normals, materials"};

// Over all channels.
double mean_of(const Buffer<glm::vec4>& list) {
    double sum = 0;
    for (const glm::vec4& v : list) sum += double(v.x) + double(v.y) + double(v.z);
    return sum / (3.0 * double(list.size()));
}

}  // namespace

Buffer<glm::vec4> lamps_at(const Scene& scene, const Elements& elements, const RunOptions& options) {
    const int n = elements.count();
    if (n == 0) return {};
    const auto lit = probes::lit_scene(scene, Rays::exact);
    Image4 position(n, 1), normal(n, 1);
    for (int i = 0; i < n; ++i) position(i, 0) = elements.eye[std::size_t(i)], normal(i, 0) = elements.normal[std::size_t(i)];
    const Image4 sum = probes::lamp_irradiance(*lit, position, normal, options);
    return Buffer<glm::vec4>(sum.texels.begin(), sum.texels.end());
}

Buffer<glm::vec4> sky_at(const Scene& scene, const FormFactors& factors) {
    Buffer<glm::vec4> sky;
    const glm::dvec3 full = host::pi * glm::dvec3(scene.environment.radiance);
    for (const RowBlock& block : factors.blocks)
        for (const float escaped : block.escaped) sky.push_back(glm::vec4(glm::vec3(double(escaped) * full), 0));
    return sky;
}

std::string text_of(const Solved& s) {
    return fmt::format("{} passes, each leaves {:.3g}; estimated error {:.2g} of the mean", s.passes, s.radius, s.error);
}

Solved solve(const FormFactors& factors, const Elements& elements, const Buffer<glm::vec4>& lamps, const Buffer<glm::vec4>& sky,
             const RadiosityParams& params, const RunOptions& options, Buffer<glm::vec4>& radiosity) {
    const std::size_t n = std::size_t(elements.count());
    Buffer<glm::vec4> own(n), irradiance;
    for (std::size_t i = 0; i < n; ++i) own[i] = lamps[i] + sky[i];
    radiosity.assign(n, glm::vec4(0));
    Solved solved;
    if (n == 0) return solved;
    double last_step = 0;
    for (int pass = 1; pass <= params.passes; ++pass) {
        gather(factors, own, radiosity, options, irradiance);
        double step = 0;
        for (std::size_t i = 0; i < n; ++i)
            for (int c = 0; c < 3; ++c) {
                const float b = elements.exitance[i][c] + elements.reflectance[i][c] * irradiance[i][c];
                step += std::fabs(double(b) - double(radiosity[i][c]));
                radiosity[i][c] = b;
            }
        step /= 3.0 * double(n);
        solved.passes = pass, solved.radius = last_step > 0 ? step / last_step : 0;
        const double mean = mean_of(radiosity);
        if (!std::isfinite(mean)) throw InputError("radiosity: what leaves elements is not finite");
        if (step == 0) return solved.error = 0, solved;
        if (pass > 1 && solved.radius < 1) {
            solved.error = mean > 0 ? step * solved.radius / (1 - solved.radius) / mean : 0;
            if (pass > 2 && solved.error < double(params.tolerance)) return solved;
        }
        last_step = step;
    }
    throw InputError(fmt::format("radiosity: after {} passes the estimated error is {:.2g} of the mean, above tolerance = {}", solved.passes, solved.error,
                                 double(params.tolerance)));
}

StageInfo info_elements() {
    return step("radiosity.elements", "HEM 4.5.4, 5.5; without a twin: the mesh's vertices, split at creases and moved off their surface, when it changes",
                {{"scene", "meshes", "", "of all triangles"}}, {{"eye", "buffer f32 x 4", "m", "where each element's hemicube stands"}},
                {"elements", "crease_deg", "offset", "inset", "split", "small_emitters"});
}

StageInfo info_rows() {
    return step("radiosity.rows", "HEM 4.5.3, 5.6; without a twin: radiosity.items tells what each texel sees, the host sums and packs it", {elements},
                {{"weights", "buffer f16", "", "form factors, run by run"}}, {"size", "weights"});
}

StageInfo info_light() {
    return step("radiosity.light", "HEM 4.5.4 has emitters alone; without a twin: rays from elements to lamps and small emitters", {elements},
                {{"lamps", "buffer f32 x 4", "W/m2", "irradiance by lamps"}, {"sky", "buffer f32 x 4", "W/m2", "irradiance by the sky and small emitters"}}, {});
}

StageInfo info_solve() {
    return step("radiosity.solve", "HEM 4.5.4; without a twin: it runs radiosity.gather until little is left", {elements},
                {{"radiosity", "buffer f32 x 4", "W/m2", "what leaves each element"}}, {"tolerance", "passes"});
}

}  // namespace plumb::radiosity
