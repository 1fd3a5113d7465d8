#version 450
// Twin of paths_kernel.h, continuous.
#extension GL_GOOGLE_include_directive : require
#include "core/hash.glsl"
#include "gi/rsm/gather_form.glsl"
#include "gi/rsm/continuous_texels.glsl"
#include "gi/rsm/gather_paths.glsl"
