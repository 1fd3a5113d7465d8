// What a twin's SPIR-V says about its bindings: the members of its uniform block, its images and buffers. The build
// reads it (tools/twins/layout.cpp) and writes one header a twin, <build>/layouts/twins/<path>.h; a raster twin's holds
// what its two shaders bind and what its fragment shader writes.
#pragma once

#include <cstddef>
#include <span>

namespace plumb {

enum class TwinKind : int { sampled_image, sampled_array, storage_image, buffer, storage_buffer, target, depth };

// A member of the uniform block; members of a struct are written with a dot.
struct TwinMember {
    const char* name;
    const char* type;  // float, int, uint, vec2, vec3, vec4, ...
    int offset;        // bytes
};

struct TwinBinding {
    const char* name;  // of the variable; of a buffer, of its array
    TwinKind kind;
    int binding;          // of a target: its location
    const char* element;  // of a buffer, a storage image or a target: float, int, vec4, ...; "" of a buffer of structs
};

struct TwinLayout {
    const char* path;  // from the project's root; of a raster stage without .vert and .frag
    bool raster;
    std::span<const TwinMember> members;
    std::size_t block_bytes;  // 0: no block
    std::span<const TwinBinding> bindings;
};

}  // namespace plumb
