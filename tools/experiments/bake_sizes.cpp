#include "tools/experiments/bake_sizes.h"

#include <cmath>
#include <map>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/probes/bake.h"

namespace plumb::cli {

int receivers_at(const Scene& scene, probes::BakeParams params, int size, const RunOptions& options) {
    params.lightmap_size = size, params.test_rays = 0;
    probes::BakeGraph graph(scene, params);
    graph::RunWith with;
    with.options = options;
    try {
        graph::run({graph.nodes()[0], graph.nodes()[1]}, with);
    } catch (const InputError&) {
        return 0;
    }
    return graph.bake().receivers.count();
}

int lightmap_for(const Scene& scene, const probes::BakeParams& params, int receivers, int start, const RunOptions& options) {
    std::map<int, double> known;
    const auto too_many = [&](int size) {
        if (!known.count(size)) {
            const int found = receivers_at(scene, params, size, options);
            known[size] = found ? host::log(double(found) / receivers) : -1e9;
        }
        return known[size];
    };
    int low = start, high = low;
    while (high < 16384 && too_many(high) < 0) low = high, high *= 2;
    while (low > 8 && too_many(low) > 0) high = low, low /= 2;
    while (high - low > 1 && std::fabs(too_many(low)) > 0.005 && std::fabs(too_many(high)) > 0.005) {
        const int middle = (low + high) / 2;
        (too_many(middle) < 0 ? low : high) = middle;
    }
    return std::fabs(too_many(low)) < std::fabs(too_many(high)) ? low : high;
}

}  // namespace plumb::cli
