// plumb experiment ipr: its parts, each a file of its own, as Measure::run() calls them.
#pragma once

#include "tools/experiments/ipr.h"

namespace plumb::cli {

// What a part adds to result, and to result.left_out where the scene has nothing for it.
struct IprPart {
    const Scene& scene;
    const frame::Settings& settings;
    const IprRequest& request;
    const RunOptions& options;
    const IprTell& tell;
    IprBench& bench;
    IprResult& result;
    // The side of a lightmap with so many receivers, where the search begins; known ones are asked once.
    const std::function<int(const probes::BakeParams& params, int receivers, int start)>& size_for;
};
probes::BakeParams as_published(const IprPart& part);  // the thesis' choices of a bake
void measure_spatial(const IprPart& part);   // table 5.3, figures 5.16 to 5.19
void measure_objects(const IprPart& part);   // figures 5.20 to 5.23
void measure_lod(const IprPart& part);       // tables 5.5 to 5.11, figures 5.24 to 5.33

}  // namespace plumb::cli
