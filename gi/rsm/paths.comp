#version 450
// Twin of paths_kernel.h: the gather along paths with a micro linear buffer for visibility (VRSM 3.2, 3.3).
#extension GL_GOOGLE_include_directive : require
#include "core/hash.glsl"
#include "gi/rsm/gather_form.glsl"
#include "gi/rsm/whole_texels.glsl"
#include "gi/rsm/gather_paths.glsl"
