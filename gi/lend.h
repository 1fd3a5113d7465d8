// What the stages of a method share when they lend their inputs to a dispatch (core/binding.h).
#pragma once

#include <fmt/format.h>

#include "core/binding.h"
#include "core/error.h"
#include "raster/covered.h"

namespace plumb {

// A dispatch of the stage whose kernel is Kernel.
template <class Kernel, class Uniforms>
StageData begin_data(glm::ivec2 size, const Uniforms& uniforms) {
    return begin_data(stage<Kernel>(), size, uniform_block(uniforms));
}

inline const Image4& bound(const char* stage, const char* input, const Image4* image) {
    if (!image) throw InputError(fmt::format("{}: {} must be bound", stage, input));
    return *image;
}
inline glm::ivec2 size_of(const Image4& image) { return {image.width, image.height}; }

// Lends the images, each under its name.
inline void lend(StageData& data, std::initializer_list<std::pair<const char*, const Image4*>> images) {
    for (const auto& [name, image] : images) lend(data.inputs, name, bound(data.stage.c_str(), name, image));
}

// Leaves out the tiles that `covered` says nothing is in; null: none.
inline void lend_tiles(StageData& data, const raster::Covered* covered) {
    if (!covered) return;
    if (!covered->fits(data.size)) throw InputError(fmt::format("{}: tiles are of another size", data.stage));
    data.tiles = {covered->any.data(), covered->tiles.x};
}

// Runs the stage that reads `in`, or explains an item of it. data_of(params, in) is the
// method's: its parameters become a uniform block.
template <class Params, class Inputs>
void run(const Params& params, const Inputs& in, const RunOptions& options, Image4& output) {
    run(stage<typename Inputs::Kernel>(), data_of(params, in), options, output);
}
template <class Params, class Inputs>
std::vector<TapValue> explain(const Params& params, const Inputs& in, glm::ivec2 pixel) {
    return explain(stage<typename Inputs::Kernel>(), data_of(params, in), pixel);
}

}  // namespace plumb
