// What came of a lightmap's check, in words, as JSON and as a page.
#pragma once

#include <string>
#include <vector>

#include "gi/probes/debug_layers.h"
#include "tools/plumb/lightmap.h"
#include "tools/shared/reports.h"

namespace plumb::cli {

// Which bound is exceeded, and by what; empty: none. What is undefined exceeds every bound.
std::string verdict_of(const LightmapOptions& given, const probes::LightmapCheck& check);

struct LightmapReport {
    const LightmapOptions& given;
    const LightmapScene& scene;
    std::string layout;
    const probes::Lightmap& lightmap;
    const probes::ReceiverIrradiance& truth;
    const probes::LightmapCheck& check;
    std::string verdict;
};

std::string lightmap_text(const LightmapReport& report);
Json lightmap_json(const LightmapReport& report);
std::string lightmap_page(const LightmapReport& report, const std::vector<probes::DebugLayer>& pictures);

}  // namespace plumb::cli
