#include "tests/foreign/renderers.h"

#include <algorithm>

namespace plumb::foreign {

std::string render(const vulkan::Device& device, const Exported& exported, const Variant& variant,
                   const std::string& folder) {
    if (variant.renderer == "A") return render_in_view_space(device, exported, variant, folder);
    if (variant.renderer == "B") return render_deferred(device, exported, variant, folder);
    return render_in_opengl(exported, variant, folder);
}

std::string no_vulkan() {
    const std::vector<std::string> names = vulkan::device_names();
    const auto is_lavapipe = [](const std::string& name) { return name.find("llvmpipe") != std::string::npos; };
    return std::any_of(names.begin(), names.end(), is_lavapipe) ? "" : "no lavapipe here (mesa-vulkan-drivers)";
}

}  // namespace plumb::foreign
