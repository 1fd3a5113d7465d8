// The page of `plumb graph`: the stages of a frame with their edges, and behind a click what each made.
#pragma once

#include <string>
#include <vector>

#include "core/bundle.h"
#include "core/image.h"
#include "gi/graph/graph.h"

namespace plumb::cli {

// A stage as it ran.
struct GraphNode {
    graph::NodePlan plan;
    graph::NodeRun run;
    std::string view;        // of a view beside the frame: its name
    std::string read_until;  // the label of the last stage that reads it; empty: none does
    Bundle outputs;
    struct Figure {
        Image4 picture;      // xyz 0..1, as it is to be seen
        std::string caption;
    };
    std::vector<Figure> figures = {};  // beside the outputs
};

// Opens without a network.
std::string graph_page(const std::string& title, const std::vector<GraphNode>& nodes);

}  // namespace plumb::cli
