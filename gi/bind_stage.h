// What the bindings of the compute stages share: a kernel (core/bound_kernel.h) bound to data, and the map that some
// of them read.
#pragma once

#include <fmt/format.h>

#include "core/bound_kernel.h"
#include "core/error.h"
#include "raster/light_view.h"

namespace plumb {

// StageBinding::bind of the stage whose binding is binding().
template <class Kernel, const StageBinding& (*binding)()>
std::unique_ptr<BoundStage> bind_kernel(const StageData& data) {
    check_slots(binding(), data);
    return std::make_unique<BoundKernel<Kernel>>(binding(), data);
}

// The uniform block as the kernel's struct; whatever it says, the kernel walks the outputs.
template <class Uniforms>
Uniforms uniforms_of_frame(const StageData& data) {
    Uniforms u = uniforms_of<Uniforms>(data);
    u.width = data.size.x, u.height = data.size.y;
    return u;
}

// The members of a block that has the projection onto its map at `offset`, and then `others`.
inline std::vector<UniformMember> members_after_map(int offset, const std::vector<UniformMember>& others) {
    std::vector<UniformMember> members = raster::projection_members("map", offset);
    members.insert(members.end(), others.begin(), others.end());
    return members;
}

// The kernel indexes the map by map.size.
inline void check_map(const StageData& data, const char* input, int size) {
    const Shape& map = at(data.inputs, input).shape;
    if (map[0] != size || map[1] != size)
        throw InputError(fmt::format("{}: input \"{}\" is {}: expected map.size = {} a side", data.label, input,
                                     shape_text(map), size));
}

// What a kernel returns, as BoundKernel takes it.
template <class F>
std::array<F, 4> components_of(const vec4<F>& v) {
    return {v.x, v.y, v.z, v.w};
}

// An input of another size than the block says would be read beyond its end.
inline void check_shape(const StageData& d, const char* input, int width, int height, const char* why) {
    const Shape& shape = at(d.inputs, input).shape;
    if (shape[0] != height || shape[1] != width)
        throw InputError(fmt::format("{}: input \"{}\" is {}: expected {} x {}, {}", d.label, input, shape_text(shape),
                                     height, width, why));
}

inline void check_choice(const StageData& d, const char* name, int value, int last) {
    if (value < 0 || value > last)
        throw InputError(fmt::format("{}: {} = {}: expected 0 to {}", d.label, name, value, last));
}

}  // namespace plumb
