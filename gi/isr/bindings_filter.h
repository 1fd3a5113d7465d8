// What isr.blur, isr.upsample and isr.compose are given, as their kernels read it: shared by run() and by the bindings.
#pragma once

#include "gi/isr/blur_kernel.h"
#include "gi/isr/compose_kernel.h"
#include "gi/isr/isr.h"
#include "gi/isr/upsample_kernel.h"

namespace plumb::isr {

// Throws InputError unless all are bound and have this size; why says what the size is of.
struct NamedImage {
    const char* name;
    const Image4* image;
};
void check_images(const char* stage, std::initializer_list<NamedImage> images, glm::ivec2 size, const char* why);

// `image` at that size, written over where it has it already: memory that is new to a process costs more than these
// stages. What it held stays where `fill` is false.
void resize(Image4& image, glm::ivec2 size, bool fill, glm::vec4 value);

// g of blur_kernel.h, [2 radius + 1]; blur = none: one weight, 1.
Buffer<float> blur_weights(const IsrParams& params);

BlurUniforms uniforms(const IsrParams& params, const BlurInputs& inputs);
UpsampleUniforms uniforms(const IsrParams& params, const UpsampleInputs& inputs);
ComposeUniforms uniforms(const IsrParams& params, const ComposeInputs& inputs);

void validate(const IsrParams& params, const BlurInputs& inputs);
void validate(const IsrParams& params, const UpsampleInputs& inputs);
void validate(const IsrParams& params, const ComposeInputs& inputs);

}  // namespace plumb::isr
