// One pixel of the G-buffer (ISR 4.2, VRSM 4.2): the algorithm that gbuffer.frag mirrors; and what its targets make of
// it, which no shader sees.
#pragma once

#include "core/quantise_kernel.h"
#include "raster/surface_kernel.h"

namespace plumb::raster {

// How a pixel is stored, and what a later pass needs to read it back.
struct GBufferStore {
    Format position = Format::rgba32f, normal = Format::rgba32f, albedo = Format::rgba32f, emission = Format::rgba32f;
    Format depth = Format::r32f;
    bool position_from_depth = false, depth_from_position = false, radiation_mask = false;
    float range = 1, over_range = 1;               // linear depth that is stored as 1, m; its inverse, 1/m
    float corner[3]{}, across[3]{}, down[3]{};     // F0, FU, FV of ISR (24): m, from the eye, at depth `range`
};

struct GBufferArgs {
    SurfaceArgs surfaces;
    float eye[3], forward[3];     // m; unit
    std::int32_t width, height;
    const std::int32_t* object;   // [triangle]; read for `id` alone
    float* position;              // [height][width] rgba32f, out; null: not wanted
    float* normal;
    float* albedo;
    float* emission;
    std::int32_t* id;             // [height][width][2]: object, triangle
    std::uint8_t* covered;        // raster/covered.h, out: set to 1 where a surface is seen; null: not wanted
    std::int32_t covered_columns; // tiles a row of it
    GBufferStore store;
};

template <class F>
struct GBufferPixel {
    vec4<F> position, normal, albedo, emission;
};

template <class F, class Tap>
PLUMB_INLINE GBufferPixel<F> gbuffer(const GBufferArgs& in, index_t<F> triangle, const vec2<F>& l, Tap& tap) {
    const Surface<F> s = surface<F>(in.surfaces, triangle, l, tap);
    const F depth = linear_depth(in.eye, in.forward, s.position);    tap("depth", depth, "ISR 4.2: eye depth, m");
    return {vec4<F>(s.position, depth), vec4<F>(s.normal, F(1.0f)), vec4<F>(s.albedo, F(0.0f)),
            vec4<F>(s.emission, F(0.0f))};
}

// camera + (F0 + u FU + v FV) depth, ISR Listing 5; u, v in 0..1 from the top left, depth as it is stored.
template <class F>
PLUMB_INLINE vec3<F> position_from_depth(const float* eye, const GBufferStore& store, F u, F v, F depth) {
    auto along = [&](int c) {
        return F(eye[c]) + (F(store.corner[c]) + u * F(store.across[c]) + v * F(store.down[c])) * depth;
    };
    return {along(0), along(1), along(2)};
}

template <class F>
PLUMB_INLINE F stored_depth(Format format, F depth) {
    return format == Format::r16f ? half_rounded(depth) : depth;
}
// A unit normal; r10g10b10a2 holds it as ISR (22) does, at 10 bits.
template <class F>
PLUMB_INLINE vec3<F> stored_normal(Format format, const vec4<F>& n) {
    if (format != Format::r10g10b10a2) return xyz<F>(quantised<F>(format, n));
    return {biased_rounded(n.x, 1023), biased_rounded(n.y, 1023), biased_rounded(n.z, 1023)};
}

// What a later pass reads of pixel (px, py).
template <class F>
PLUMB_INLINE GBufferPixel<F> stored(const GBufferArgs& in, const GBufferPixel<F>& p, index_t<F> px, index_t<F> py) {
    using N = number<F>;
    const GBufferStore& store = in.store;
    GBufferPixel<F> s;
    F depth = stored_depth(store.depth, p.position.w * F(store.over_range));
    vec3<F> position;
    if (store.position_from_depth) {
        const F u = (N::from_index(px) + F(0.5f)) / F(float(in.width));
        const F v = (N::from_index(py) + F(0.5f)) / F(float(in.height));
        position = position_from_depth(in.eye, store, u, v, depth);
    } else {
        position = xyz<F>(quantised<F>(store.position, p.position));
    }
    depth = depth * F(store.range);
    if (store.depth_from_position) depth = linear_depth(in.eye, in.forward, position);
    s.position = vec4<F>(position, depth);
    s.normal = vec4<F>(stored_normal<F>(store.normal, p.normal), p.normal.w);

    // The weights of ISR (17).
    vec4<F> albedo = p.albedo;
    if (store.radiation_mask) albedo.w = F(0.27f) * albedo.x + F(0.67f) * albedo.y + F(0.06f) * albedo.z;
    s.albedo = quantised<F>(store.albedo, albedo);
    if (!store.radiation_mask) s.albedo.w = F(0.0f);
    s.emission = vec4<F>(xyz<F>(quantised<F>(store.emission, p.emission)), F(0.0f));
    return s;
}

}  // namespace plumb::raster
