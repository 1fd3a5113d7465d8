#include "gi/radiosity/own_light.h"

#include <algorithm>
#include <utility>

#include "core/host_math.h"
#include "core/parallel.h"
#include "gi/radiosity/element_items.h"
#include "gi/radiosity/emitters.h"
#include "gi/radiosity/host_stages.h"
#include "gi/reference/environment.h"
#include "gi/reference/environment_kernel.h"

namespace plumb::radiosity {
namespace {

constexpr int elements_at_once = 16;  // whose texels lie in memory, a thread

// Irradiance by a map, of what sees it: pi times the sum of weight and radiance over texels that see nothing.
glm::vec4 map_light(const reference::EnvironmentArgs& sky, const ElementItems& items, const SeenItems& seen, const std::vector<double>& weights, int i, int in) {
    const int size = items.size(), rows = rows_of_hemicube(size);
    glm::dvec3 sum(0);
    for (int row = 0; row < rows; ++row)
        for (int x = 0; x < size; ++x) {
            if (seen.at(x, in * rows + row).w != 0) continue;
            const glm::vec3 way(items.direction(i, row, x));
            if (way == glm::vec3(0)) return glm::vec4(0);  // it has no normal
            sum += weights[std::size_t(row) * std::size_t(size) + std::size_t(x)] * glm::dvec3(reference::environment_radiance<float>(sky, way));
        }
    return glm::vec4(glm::vec3(host::pi * sum), 0);
}

Buffer<glm::vec4> map_at(const Scene& scene, const Elements& elements, const RowParams& params, const RunOptions& options) {
    const reference::EnvironmentTable table = reference::environment_table(scene.environment);
    const reference::EnvironmentArgs sky = reference::environment_args(table);
    const ElementItems items(elements, params.size);
    const std::vector<double> weights = texel_weights(params.size, params.weights);
    Buffer<glm::vec4> out(std::size_t(elements.count()), glm::vec4(0));
    parallel_bands(elements.count(), elements_at_once, options, [&](int first, int last) {
        RunOptions one = options;
        one.threads = 1;
        const SeenItems seen = items.seen(first, last - first, one);
        for (int i = first; i < last; ++i) out[std::size_t(i)] = map_light(sky, items, seen, weights, i, i - first);
    });
    return out;
}

}  // namespace

Buffer<glm::vec4> own_light(const Scene& scene, const Elements& elements, const FormFactors& factors, const RadiosityParams& params,
                            const RunOptions& options, Buffer<glm::vec4>* by_emitters) {
    if (elements.count() == 0) return {};
    Buffer<glm::vec4> own = scene.environment.map.empty() ? sky_at(scene, factors) : map_at(scene, elements, row_params(params), options);
    Buffer<glm::vec4> sent = emitters_at(scene, elements, options);
    for (std::size_t i = 0; i < own.size(); ++i) own[i] += sent[i];
    if (by_emitters) *by_emitters = std::move(sent);
    return own;
}

}  // namespace plumb::radiosity
