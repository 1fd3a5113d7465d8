#include "tools/shared/light_costs.h"

#include <nlohmann/json.hpp>

namespace plumb::cli {

Json light_costs_json(const Scene& scene, const frame::Plan& plan, const std::vector<frame::StageRun>& stages) {
    struct Cost {
        double ms = 0, saved_ms = 0;
        std::size_t bytes = 0;
        int ran = 0, kept = 0;
    };
    std::vector<Cost> costs(scene.lights.size());
    // Both are in the frame's order; a run may have stages that no plan could know.
    std::size_t next = 0;
    for (const frame::StageRun& s : stages) {
        std::size_t at = next;
        while (at < plan.stages.size() && plan.stages[at].label != s.label) ++at;
        if (at == plan.stages.size()) continue;
        next = at + 1;
        const int light = plan.stages[at].light;
        if (light < 0 || !s.needed) continue;
        Cost& cost = costs.at(std::size_t(light));
        cost.ms += s.ms, cost.bytes += s.bytes;
        (s.kept ? cost.kept : cost.ran) += 1;
        if (s.kept) cost.saved_ms += s.saved_ms - s.ms;
    }
    Json json = Json::array();
    for (std::size_t l = 0; l < costs.size(); ++l) {
        const Light& light = scene.lights[l];
        const Cost& c = costs[l];
        json.push_back({{"name", light.name}, {"on", light.on}, {"ms", c.ms}, {"saved_ms", c.saved_ms}, {"ran", c.ran}, {"kept", c.kept}, {"bytes", c.bytes}});
    }
    return json;
}

}  // namespace plumb::cli
