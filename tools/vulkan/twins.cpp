#include "tools/vulkan/twins.h"

#include "tools/vulkan/device.h"
#include "tools/vulkan/embedded_twins.h"

namespace plumb::vulkan {

Twin find_twin(const std::string& name) {
    if (embedded_twins().empty())
        throw Error("no twins: this program was built without glslangValidator and spirv-val, which compile them");
    for (const EmbeddedTwin& e : embedded_twins()) {
        if (name != e.name) continue;
        Twin twin{name, e.spirv, e.tapped, e.choosing, {}};
        for (const char* const* tap = e.taps; *tap; ++tap) twin.taps.push_back(*tap);
        return twin;
    }
    throw Error("no twin \"" + name + "\"");
}

}  // namespace plumb::vulkan
