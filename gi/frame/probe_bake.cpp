#include "gi/frame/probe_bake.h"

#include "gi/probes/bake.h"

namespace plumb::frame {

void add_bake(const Scene& scene, Settings& settings, const RunOptions& options) {
    if (settings.method != Method::probes || settings.bake) return;
    probes::BakeGraph graph(scene, settings.probes);
    graph::run(graph.nodes(), {options});
    settings.bake = std::make_shared<const probes::Bake>(graph.release());
}

}  // namespace plumb::frame
