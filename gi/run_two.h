// Runs a stage that makes two images.
#pragma once

#include "gi/lend.h"

namespace plumb {

// Into what the images hold already, where their size is right.
inline void run_two(const StageBinding& binding, const StageData& data, const RunOptions& options, Image4& first, Image4& second) {
    Bundle outputs;
    for (const auto& [slot, image] : {std::pair(&binding.outputs[0], &first), std::pair(&binding.outputs[1], &second)}) {
        if (size_of(*image) != data.size) *image = Image4(data.size.x, data.size.y);
        lend(outputs, slot->name, {data.size.y, data.size.x, 4}, &image->data()->x);
    }
    binding.bind(data)->run(options, {}, outputs);
}

}  // namespace plumb
