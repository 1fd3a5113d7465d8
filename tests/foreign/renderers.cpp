#include "tests/foreign/renderers.h"

#include <algorithm>
#include <cstdlib>
#include <stdexcept>

namespace plumb::foreign {

std::string render(const vulkan::Device& device, const Exported& exported, const Variant& variant,
                   const std::string& folder) {
    if (variant.renderer == "A") return render_in_view_space(device, exported, variant, folder);
    if (variant.renderer == "B") return render_deferred(device, exported, variant, folder);
    return render_in_opengl(exported, variant, folder);
}

std::string chosen_device() {
    const char* name = std::getenv("PLUMB_DEVICE");
    return name && *name ? name : "llvmpipe";
}

std::string no_vulkan() {
    const std::vector<std::string> names = vulkan::device_names();
    const auto is_chosen = [](const std::string& name) { return name.find(chosen_device()) != std::string::npos; };
    if (std::any_of(names.begin(), names.end(), is_chosen)) return "";
    if (std::getenv("PLUMB_DEVICE")) throw std::runtime_error("PLUMB_DEVICE: no device " + chosen_device());
    return "no lavapipe here (mesa-vulkan-drivers)";
}

}  // namespace plumb::foreign
