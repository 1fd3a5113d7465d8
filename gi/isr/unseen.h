// isr.unseen: leaves out of an additional camera's surface what another view sees itself: its light is counted there.
#pragma once

#include "core/binding.h"
#include "gi/isr/isr_params.h"
#include "gi/isr/unseen_kernel.h"

namespace plumb::isr {

struct UnseenInputs {
    using Kernel = UnseenKernel;
    const Image4* surface = nullptr;       // of the additional camera, or what is left of it
    CoarseCamera camera;
    const Image4* view_surface = nullptr;  // of the other view, with its margin
    CoarseCamera view;
    int margin = 0;
};

inline StageDescription<UnseenInputsView> describe(UnseenKernel) {
    using View = UnseenInputsView;
    return {
        .name = "isr.unseen",
        .source = "ISR chapter 6 (additional cameras): what only they see",
        .domain = "coarse pixel",
        .inputs = {{.name = "surface", .at = &View::surface, .unit = "m",
                    .meaning = "of the camera: xyz unit normal, w depth"},
                   {.name = "view_surface", .at = &View::view_surface, .unit = "m",
                    .meaning = "of a view whose light is gathered already",
                    .size = [](const View& v) { return glm::ivec2(v.u.view.width, v.u.view.height); },
                    .why = "as view.width and view.height say"}},
        .outputs = {{.name = "unseen", .at = &View::unseen, .unit = "m",
                     .meaning = "the camera's surface; 0 where the view sees the same"}},
        .params = params_of({"position"}),
        .uniforms = {{"view.width", 1, 32767}, {"view.height", 1, 32767}},
        .cost = {4, "pixels"},
    };
}

StageData data_of(const IsrParams& params, const UnseenInputs& in);

}  // namespace plumb::isr
