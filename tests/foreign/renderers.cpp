#include "tests/foreign/renderers.h"

namespace plumb::foreign {

std::string render(const vulkan::Device& device, const Exported& exported, const Variant& variant, const std::string& folder) {
    if (variant.renderer == "A") return render_in_view_space(device, exported, variant, folder);
    if (variant.renderer == "B") return render_deferred(device, exported, variant, folder);
    return render_in_opengl(exported, variant, folder);
}

}  // namespace plumb::foreign
