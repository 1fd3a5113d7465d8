// A stage bound to named data, so that the commands that know no stage (validate, export, explain, stability) and the
// runner of the twins are written once, for all of them.
//
//     StageBinding   what one kind of stage binds: its uniform block, its inputs and outputs, its twin
//     StageData      one dispatch or draw: the values of all that
//     BoundStage     both together: what our kernel makes of it, and which other results are legal
#pragma once

#include <cstring>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/bundle.h"
#include "core/device_profile.h"
#include "core/followed.h"
#include "core/isa.h"
#include "core/kernel_rows.h"
#include "core/stage.h"
#include "core/tap.h"

namespace plumb {

enum class SlotKind : int {
    image,          // read by texelFetch: [height][width][4] or [height][width]
    image_array,    // [layer][height][width]
    buffer,         // std430, read only: [n][channels], or any shape of that many elements
    storage_image,  // written by a compute stage
    storage_buffer,  // written by a compute stage: [n][channels]
    target,         // written by a raster stage; `binding` is its location
    depth,          // the depth buffer of a raster stage
};

// A named input or output, as a GPU binds it.
struct Slot {
    std::string name;
    SlotKind kind = SlotKind::image;
    int binding = 0;           // of set 0
    DType dtype = DType::f32;  // f32, i32 or u32
    int channels = 4;          // components of a texel or an element: 1, 2 or 4
    bool frame = true;         // of the size of the outputs; else of a size of its own (maps, buffers)
    std::string unit = "", meaning = "";
    std::uint32_t fixed = 0;   // bit c: column c is a flag, a whole number or the rasteriser's: nothing rounds it
    glm::vec4 unwritten{0};    // of an output: what an item holds that is not computed
    bool optional = false;     // of an input: may be missing, and then is 0 everywhere
    std::string instead = "";  // of an input: may be missing where this one is lent, which holds the same (Lends)
};

// A member of the uniform block; members of a struct are written with a dot: "map.to_texel_x".
struct UniformMember {
    std::string name;
    std::string type;  // float, int, uint, vec3, vec4
    int offset = 0;    // bytes, std140
    std::uint32_t fixed = 0;  // bit c: component c is a flag or a whole number
};

struct StageData {
    std::string stage;                    // as `plumb stages` lists it
    std::string label;                    // "rsm.disc (key)": as people read it
    std::string id;                       // "rsm.disc.key": letters, digits, '.', '_' and '-', one of its kind in a frame
    glm::ivec2 size{0};                   // pixels of the outputs
    std::vector<unsigned char> uniforms;  // the std140 block
    Bundle inputs;                        // by the names of StageBinding::inputs
    bool reversed_z = false;              // of a raster stage: depth test "greater", cleared to 0
    Tiles tiles = {};                     // which squares of the outputs are wanted; others keep what they hold
};

// One component of what a stage may write at a pixel: every legal result is within `bound` of `shadow`.
struct BoundedValue {
    double shadow = 0;
    double bound = 0;  // infinity where nothing can be said
};

// One way in which a pixel may legally come out: all components of all outputs, in the outputs' order.
struct Outcome {
    std::vector<BoundedValue> values;
    bool ambiguous = false;  // a branch that is legal, but on which nothing more can be decided
};

// Data must outlive what is bound to it. All functions may be called by several threads at once.
class BoundStage {
  public:
    virtual ~BoundStage() = default;

    // Our own result: outputs by the names of StageBinding::outputs, [height][width][channels]. Rasterisation and stores
    // follow the profile; arithmetic is IEEE's. Outputs that fit are written in place, and keep what is not written.
    virtual void run(const RunOptions& options, const DeviceProfile& profile, Bundle& outputs) const = 0;

    // Whether this dispatch writes that pixel at all: the shadow pass of one face of a point light leaves the others'.
    virtual bool writes(glm::ivec2) const { return true; }

    // Every outcome that is legal at a pixel on a device of that profile: the first is our own branch. `got` is what the
    // device wrote, all components in the outputs' order, so that a stage can follow the device's branch (NaN where it
    // was not dumped). `choices`: the discrete choices that the device dumped, in the order of the twin's, or empty.
    virtual void outcomes(glm::ivec2 pixel, const DeviceProfile& profile, std::span<const float> got,
                          std::span<const std::int32_t> choices, std::vector<Outcome>& out) const = 0;

    // The same invocation in float and, along float's decisions, in double: all components of float outputs, in the
    // outputs' order, as run() would write them (a depth buffer's, which rasterisation computes, left out). `tape` says
    // whether it records or follows; who follows may be bound to data with other numbers, but with the same indices.
    virtual void follow(glm::ivec2 pixel, DecisionTape& tape, std::vector<Followed>& out) const = 0;

    // The same invocation in double from the start, decisions included: all components of the outputs.
    virtual void in_double(glm::ivec2 pixel, std::vector<double>& out) const;

    // Every named value of one invocation; what is seen at the pixel, and where in its triangle, follows the profile.
    virtual std::vector<TapValue> explain(glm::ivec2 pixel, const DeviceProfile& profile = {}) const = 0;
};

struct StageBinding {
    StageInfo info;
    std::string domain = {};   // what an item is: "pixel", "texel", "receiver"
    Cost cost = {};
    bool raster = false;
    std::string twin;  // SPIR-V is named after it: "gi/rsm/gather.comp"; of a raster stage without .vert, .frag
    std::vector<UniformMember> uniforms;
    std::size_t uniform_bytes = 0;
    std::vector<Slot> inputs, outputs;

    // Throws InputError "<label>: <what is wrong>" for data that is missing, of the wrong type or shape, or holds an
    // index out of range: dumps are not trusted.
    std::unique_ptr<BoundStage> (*bind)(const StageData& data) = nullptr;
};

// Checks what every stage needs: the size of the uniform block, each input's type and shape, and that sizes are 1 to
// 32767, of lists at most 524,280 rows.
void check_slots(const StageBinding& binding, const StageData& data);

// The value of one member of the block, as numbers; and back. Throws InputError for a name that the block lacks.
std::vector<double> uniform_value(const StageBinding& binding, const StageData& data, const std::string& member);
void set_uniform(const StageBinding& binding, StageData& data, const std::string& member, std::span<const double> value,
                 const std::string& place);

// The bytes of a uniform block, and the block as the kernel's struct.
template <class Uniforms>
std::vector<unsigned char> uniform_block(const Uniforms& u) {
    const auto* p = reinterpret_cast<const unsigned char*>(&u);
    return {p, p + sizeof u};
}
template <class Uniforms>
Uniforms uniforms_of(const StageData& data) {
    Uniforms u;
    std::memcpy(&u, data.uniforms.data(), sizeof u);
    return u;
}

// Typed views of an input.
const float* floats(const StageData& data, const std::string& input);
const std::int32_t* ints(const StageData& data, const std::string& input);

// The binding of the stage whose kernel is Kernel: a line a stage, in its folder's stages.cpp.
template <class Kernel>
const StageBinding& stage();

// Data of one dispatch without inputs: they are added, or lent.
StageData begin_data(const StageBinding& binding, glm::ivec2 size, std::vector<unsigned char> uniforms);

// As a device binds it and a file holds it: the binding's inputs alone, with copies of what is lent, and zeros for what
// may be missing.
StageData owned(const StageBinding& binding, const StageData& data);

// Binds the data and runs the dispatch into its one output, which takes its size and starts as what is not computed.
void run(const StageBinding& binding, const StageData& data, const RunOptions& options, Image4& output);
void run(const StageBinding& binding, const StageData& data, const RunOptions& options, Image1& output);
// The same into memory of the caller's, as large as that output: it keeps what is not computed.
void run(const StageBinding& binding, const StageData& data, const RunOptions& options, float* output);
// Every named value of one item.
std::vector<TapValue> explain(const StageBinding& binding, const StageData& data, glm::ivec2 pixel);
// The whole output in double.
void run_double(const StageBinding& binding, const StageData& data, const RunOptions& options, Image<glm::dvec4>& output);

// Outputs of zeros, and of -1 where they hold indices; where the stage says so, of what is not computed.
Bundle make_outputs(const StageBinding& binding, const StageData& data);

}  // namespace plumb
