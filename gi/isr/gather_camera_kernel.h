// Light that surfaces send which only an additional camera sees (ISR chapter 6): the algorithm that gather_camera.comp
// mirrors line by line. As gather_kernel.h, but samples lie around the point where a receiver projects to the camera's
// image, and their rays are that camera's.
#pragma once

#include "gi/isr/gather_kernel.h"
#include "gi/isr/unseen_kernel.h"

namespace plumb::isr {

// The twin's uniform block (std140).
struct GatherCameraUniforms {
    SampleUniforms u;      // of the receivers; margin is 0, source_width and source_height are the camera's
    SampleUniforms camera; // of the camera's own pixels: its rays, and the area that its samples stand for
    ViewProjection view;   // from the receivers' eye to the camera's image
    glm::vec4 camera_eye;  // xyz: the camera's eye as seen from the receivers', m
};
static_assert(sizeof(GatherCameraUniforms) == 384);

struct GatherCameraInputsView {
    GatherCameraUniforms u;
    const float* surface;           // [u.height][u.width] rgba32f
    const float* source_surface;    // [view.height][view.width] rgba32f: what only the camera sees
    const float* source_radiosity;  // xyz W/m2
    const float* before;            // [u.height][u.width] rgba32f; null: all 0
    const std::int32_t* offsets;    // [samples][rotations]
    const float* weights;           // [samples]
    float* gathered;                // out: [u.height][u.width] rgba32f
};

// The samples of a receiver around its projection. Beyond the border there is no surface.
template <class F>
struct CameraImages {
    const GatherCameraInputsView& in;
    index_t<F> rotation;
    ivec2<index_t<F>> centre;
    mask_t<F> before;  // whether the receiver lies before the camera

    template <class Tap>
    PLUMB_INLINE CameraImages(const GatherCameraInputsView& inputs, const vec3<F>& x, index_t<F> px, index_t<F> py, Tap& tap)
        : in(inputs), rotation(rotation_of<F>(inputs.u.u, px, py)) {
        const Projected<F> p = project_to(in.u.view, x);
        tap("projection", p.position, "P in the camera's image, coarse pixels");
        centre = {raster::chosen(p.position.x), raster::chosen(p.position.y)};
        tap("centre", centre, "pixel of the projection");
        before = p.before;
        tap("before", before, "1 if P lies before the camera's eye");
    }

    template <class Tap>
    PLUMB_INLINE Source<F> at(int k, const Surface<F>& p, Tap& tap) const {
        using N = number<F>;
        using I = index_t<F>;
        const SampleUniforms& c = in.u.camera;
        const ivec2<I> offset = offset_of(N::fetch(in.offsets, rotation + I(k * in.u.u.rotations)));
        const ivec2<I> texel{centre.x + offset.x, centre.y + offset.y};
        tap("texel", texel, "pixel of the camera's image");
        const mask_t<F> inside = in_range(texel.x, I(c.width)) & in_range(texel.y, I(c.height)) & before;
        tap("inside", inside, "1 if the camera's image has that pixel");
        const I i = select(inside, texel.y * I(c.width) + texel.x, I(0));
        const vec4<F> fetched = N::fetch4(in.source_surface, i);
        const F zero(0.0f);
        const vec4<F> surface{select(inside, fetched.x, zero), select(inside, fetched.y, zero),
                              select(inside, fetched.z, zero), select(inside, fetched.w, zero)};
        const Surface<F> s = surface_of<F>(c, texel.x, texel.y, surface);
        const glm::vec4& e = in.u.camera_eye;
        const vec3<F> x{s.position.x + F(e.x), s.position.y + F(e.y), s.position.z + F(e.z)};
        return {x - p.position, area_of(c, s), F(weight_of(in.weights, k)), s.normal,
                light_of(s, xyz<F>(N::fetch4(in.source_radiosity, i)))};
    }
};

template <class F, class Tap>
PLUMB_INLINE vec4<F> gather_camera(const GatherCameraInputsView& in, index_t<F> px, index_t<F> py, Tap& tap) {
    using N = number<F>;
    using I = index_t<F>;
    const SampleUniforms& u = in.u.u;
    const I pixel = py * I(u.width) + px;
    const Surface<F> p = surface_of<F>(u, px, py, N::fetch4(in.surface, pixel));
    tap("p", p.position, "P, from the eye, m");
    tap("n_p", p.normal, "unit normal of P");
    const F zero(0.0f);
    const vec4<F> before = in.before ? N::fetch4(in.before, pixel) : vec4<F>{zero, zero, zero, zero};
    const CameraImages<F> sources(in, p.position, px, py, tap);
    return gather_by<F, false>(u, p, before, zero, sources, tap);
}

struct GatherCameraKernel {
    using View = GatherCameraInputsView;
    template <class F, class Tap>
    PLUMB_INLINE static vec4<F> item(const View& in, index_t<F> px, index_t<F> py, Tap& tap) {
        return gather_camera<F>(in, px, py, tap);
    }
    static float* out(const View& in) { return in.gathered; }
    static auto& frame(auto& in) { return in.u.u; }
};

}  // namespace plumb::isr
