// The README.txt of an export: how to use it, and what to bind where.
#pragma once

#include <string>
#include <vector>

#include "core/binding.h"
#include "io/manifest.h"

namespace plumb::cli {

// The VkFormat, without VK_FORMAT_, of a texel of an image or an element of a buffer.
std::string vk_format(const Slot& slot);

// Says how to use the folder, then stage by stage what to bind.
class ExportReadme {
  public:
    ExportReadme(const std::string& scene, const std::string& device);

    // `folder`: what file names are told from.
    void add(const StageBinding& binding, const StageData& data, const io::ManifestStage& stage,
             const std::string& folder);
    // Puts the sections of these labels, out of an earlier README.txt, before the others. A section that is not there is
    // a line which says so.
    void keep(const std::string& earlier, const std::vector<std::string>& labels);

    std::string text() const { return head_ + kept_ + stages_; }

  private:
    std::string head_, kept_, stages_;
};

}  // namespace plumb::cli
