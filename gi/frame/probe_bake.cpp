#include "gi/frame/probe_bake.h"

#include <algorithm>

#include "gi/probes/bake.h"

namespace plumb::frame {

probes::BakeParams bake_params(const Scene& scene, const Settings& settings) {
    probes::BakeParams params = settings.probes;
    const bool dynamic = std::any_of(scene.meshes.begin(), scene.meshes.end(), [](const Mesh& m) { return m.dynamic; });
    if (dynamic && params.spatial_receivers == 0) params.spatial_receivers = 1440;
    return params;
}

void add_bake(const Scene& scene, Settings& settings, const RunOptions& options) {
    if (settings.method != Method::probes || settings.bake) return;
    probes::BakeGraph graph(scene, bake_params(scene, settings));
    graph::run(graph.nodes(), {options});
    settings.bake = std::make_shared<const probes::Bake>(graph.release());
}

}  // namespace plumb::frame
