#include "gi/frame/frame.h"

#include <algorithm>

#include "gi/methods.h"

namespace plumb::frame {

const Traced* find_traced(const Frame& frame, const std::string& layer) {
    for (const Traced& traced : frame.traced)
        if (traced.layer == layer) return &traced;
    return nullptr;
}

std::vector<StageInfo> all_stages() {
    std::vector<StageInfo> all;
    for (const ListedStage& s : stages()) all.push_back(s.info);
    return all;
}

bool in_a_frame(const std::string& stage) {
    return std::any_of(stages().begin(), stages().end(),
                       [&](const ListedStage& s) { return s.of_frame && s.info.name == stage; });
}

}  // namespace plumb::frame
