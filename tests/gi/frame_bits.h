// What tests of whole frames share: to plan and execute, the plan's labels, pictures' bits.
#pragma once

#include <cstring>
#include <string>
#include <vector>

#include "gi/frame/frame.h"

namespace plumb::test {

using Labels = std::vector<std::string>;

inline frame::Frame render(const Scene& scene, const frame::Settings& settings, const RunOptions& options = {}) {
    return frame::execute(scene, settings, frame::plan(scene, settings), options);
}

// Of the stages whose names begin so, in the plan's order.
inline Labels labels_of(const frame::Plan& plan, const std::string& start) {
    Labels labels;
    for (const frame::PlannedStage& s : plan.stages)
        if (s.name.rfind(start, 0) == 0) labels.push_back(s.label);
    return labels;
}

inline bool same_bits(const Image4& a, const Image4& b) {
    return a.width == b.width && a.height == b.height && std::memcmp(a.data(), b.data(), a.size() * sizeof(glm::vec4)) == 0;
}

}  // namespace plumb::test
