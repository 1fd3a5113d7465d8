// A sample pattern that a user made, as its file lists it.
#pragma once

#include <glm/glm.hpp>
#include <memory>
#include <string>
#include <vector>

namespace plumb {

struct SampleRows {
    std::string name;              // of the file, as the parameter says it
    std::string path;              // for messages
    std::vector<glm::dvec3> rows;  // dx, dy in texels from the projection of x, and the texels that the sample stands for
};
using SampleRowsPtr = std::shared_ptr<const SampleRows>;

}  // namespace plumb
