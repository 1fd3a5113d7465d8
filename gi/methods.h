// Every stage that exists, a line each in methods.cpp. What works for all stages goes through this list and names none.
#pragma once

#include <string>
#include <vector>

#include "core/binding.h"

namespace plumb {

struct ListedStage {
    StageInfo info;
    const StageBinding* binding = nullptr;  // null: no data is bound to it, and info.source says why
    bool of_frame = true;                   // false: a pass that no frame runs by itself
};

// In the order of a frame.
const std::vector<ListedStage>& stages();

}  // namespace plumb
