// The three renderers: each gets what was exported, draws, and writes raw dumps with a manifest of its own.
//
// `Variant::host` is what the program around the shaders does otherwise:
//     "last frame"        binds the positions of the frame before, when the camera stood elsewhere
//     "linear"            samplers filter bilinearly
//     "row-major"         hands its matrix over by rows
//     "rgb for bgr"       uploads the light's colour with its components turned around
//     "no border"         samplers repeat the edge
//     "full floats"       A's textures are floats of 32 bits
//     "half floats"       B's positions are floats of 16 bits
#pragma once

#include <string>

#include "tests/foreign/exported.h"
#include "tests/foreign/variants.h"
#include "tools/vulkan/device.h"

namespace plumb::foreign {

// Each returns the manifest's path. `folder` exists.
// A: Vulkan, compute, view space, half floats: rsm.disc_continuous and shadow.
std::string render_in_view_space(const vulkan::Device& device, const Exported& exported, const Variant& variant,
                                 const std::string& folder);
// B: Vulkan, fragments: shadow, direct, screen.ssao, screen.occlude, compose, tonemap.
std::string render_deferred(const vulkan::Device& device, const Exported& exported, const Variant& variant,
                            const std::string& folder);
// C: OpenGL, fragments, bottom row first: rsm.disc, shadow, direct.
std::string render_in_opengl(const Exported& exported, const Variant& variant, const std::string& folder);

// The one that the variant is of.
std::string render(const vulkan::Device& device, const Exported& exported, const Variant& variant,
                   const std::string& folder);

// A part of the name of the device that they draw on: PLUMB_DEVICE, or "llvmpipe" where that is not set.
std::string chosen_device();

// Why they cannot run here; "" where they can.
std::string no_vulkan();
std::string no_opengl();

}  // namespace plumb::foreign
