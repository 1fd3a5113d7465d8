// The README.txt of an exported stage: what to bind where.
#pragma once

#include <string>

#include "core/binding.h"
#include "io/manifest.h"

namespace plumb::cli {

// The VkFormat, without VK_FORMAT_, of a texel of an image or an element of a buffer.
std::string vk_format(const Slot& slot);

std::string readme_head(const std::string& scene, const std::string& device);
// `folder`: what file names are told from.
std::string readme_stage(const StageBinding& binding, const StageData& data, const io::ManifestStage& stage,
                         const std::string& folder);

}  // namespace plumb::cli
