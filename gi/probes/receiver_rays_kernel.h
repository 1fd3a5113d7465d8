// What receivers see, and which probes see the same (IPR 3.2.3.2, figure 3.17); and whether receivers lie inside of things
// (IPR 5.1.4). A packet's lanes are receivers, so that on a flat surface its rays are parallel.
//
// Rays start off the surface by a distance that covers the rounding of positions, on its front side. A probe sees what a ray
// met where nothing is between it and a point just in front of that surface; one behind it needs no ray to be told.
//
// differs: IPR asks for the same surface without saying of which side. A ray that ended on the surface itself would let a
// probe behind a thin wall see what lies on it: light would leak through every wall.
#pragma once

#include "core/number.h"
#include "gi/reference/warp_kernel.h"
#include "gi/trace_rays.h"
#include "raster/surface_kernel.h"

namespace plumb::probes {

// What a ray that meets nothing brings a receiver: the four solutions of IPR 5.1.3.1.
enum class Escape : int {
    nothing,         // the first: no contribution
    same_direction,  // the second: from probes whose ray in the same direction meets nothing, either
    visible_probes,  // the third: from probes that the receiver sees
    all_probes,      // the fourth: from all that support it
    sky,             // from the sky, which is the probe of the last slot (sky_probe.h)
};

inline constexpr float escaped_length = 1e15f;  // m: stands for the length of a ray that met nothing

struct ReceiverRaysView {
    raster::SurfaceArgs surfaces;
    std::int32_t width;           // receivers
    std::int32_t slots;
    std::int32_t escape;          // Escape
    float offset;                 // m, off surfaces
    const float* position;        // [width][4]: m, world
    const float* normal;          // [width][4]: unit
    const float* directions;      // [rays][4]: unit, z along the normal
    const float* supporting;      // [slots][width][4]: xyz the probe, m; w its weight, 0: none
    float* seen;                  // out: [rays][width][4]: xyz what the ray met, m, w 1; or its direction, w 0
    float* normals;               // out: [rays][width][4]: unit, of what the ray met; null: not asked
    std::int32_t* visible;        // out: [rays][width]: bit i: probe i sees it, too
    float* lengths;               // out: [rays][width], m
};

// How often rays ended in what no probe can tell.
struct RayCounts {
    std::uint64_t traced = 0;     // all rays, those between probes and what was met included
    std::uint64_t escaped = 0;    // receivers' rays that met nothing
    std::uint64_t back = 0;       // that met the back of a surface: nothing is known to leave it
    std::uint64_t unseen = 0;     // that met what no probe sees
};

// What a ray met: the point, the unit normal of its triangle, and on which side.
template <class F>
struct Met {
    vec3<F> point, normal;
    mask_t<F> front;
};

template <class F>
PLUMB_INLINE Met<F> met_by(const raster::SurfaceArgs& surfaces, const RayHit<F>& hit, const vec3<F>& direction) {
    const raster::Corners<F> c = raster::fetch_corners<F>(surfaces, hit.triangle);
    const vec3<F> a = xyz<F>(c.a.p), e1 = raster::minus3(xyz<F>(c.b.p), a), e2 = raster::minus3(xyz<F>(c.c.p), a);
    const vec3<F> n = raster::cross3(e1, e2);
    // Scaled before it is squared: triangles may be smaller or larger than what a float's square holds.
    const F most = raster::largest3(n);
    const vec3<F> m = n * (F(1.0f) / select(most > F(0.0f), most, F(1.0f)));
    const F length = max(sqrt(dot3(m, m)), F(1e-18f));
    Met<F> met;
    met.point = {raster::interpolate(a.x, e1.x, e2.x, hit.barycentrics),
                 raster::interpolate(a.y, e1.y, e2.y, hit.barycentrics),
                 raster::interpolate(a.z, e1.z, e2.z, hit.barycentrics)};
    met.normal = m * (F(1.0f) / length);
    met.front = dot3(met.normal, direction) < F(0.0f);
    return met;
}

// Writes the first n lanes.
template <class F>
PLUMB_INLINE void store_lanes(std::int32_t* to, const index_t<F>& value, int n) {
    alignas(64) std::int32_t each[number<F>::width];
    std::memcpy(each, &value, sizeof each);
    for (int k = 0; k < n && k < number<F>::width; ++k) to[k] = each[k];
}

template <class F>
PLUMB_INLINE std::uint64_t lanes_of(const mask_t<F>& mask) {
    std::int32_t each[number<F>::width];
    store_lanes<F>(each, select(mask, index_t<F>(1), index_t<F>(0)), number<F>::width);
    std::uint64_t n = 0;
    for (const std::int32_t one : each) n += std::uint64_t(one);
    return n;
}

// Which supporting probes see what ray `direction` met, a bit each.
template <class F>
PLUMB_INLINE index_t<F> probes_that_see(const ReceiverRaysView& in, index_t<F> receiver, const vec3<F>& origin,
                                        const vec3<F>& direction, const RayHit<F>& hit, const Met<F>& met,
                                        RayTracer<F>& tracer, const mask_t<F>& active) {
    using N = number<F>;
    using I = index_t<F>;
    const vec3<F> start = met.point + met.normal * F(in.offset);
    const mask_t<F> on_front = active & hit.found & met.front, free = active & !hit.found;
    I bits(0);
    const int standing = in.escape == int(Escape::sky) ? in.slots - 1 : in.slots;
    if (standing < in.slots) bits = select(free, I(1 << standing), I(0));
    for (int slot = 0; slot < standing; ++slot) {
        const vec4<F> probe = N::fetch4(in.supporting, I(slot * in.width) + receiver);
        const mask_t<F> supports = probe.w > F(0.0f);
        const vec3<F> to_probe = raster::minus3(xyz<F>(probe), start);
        mask_t<F> sees = on_front & supports & (dot3(met.normal, to_probe) > F(0.0f));
        if (any(sees)) sees = tracer.visible(start, to_probe, F(0.0f), F(1.0f), sees);
        mask_t<F> escapes = free & supports;
        if (in.escape == int(Escape::nothing) || in.escape == int(Escape::sky) || !any(escapes)) {
            escapes = escapes & (F(1.0f) < F(0.0f));
        } else if (in.escape == int(Escape::same_direction)) {
            escapes = tracer.visible(xyz<F>(probe), direction, F(0.0f), F(__builtin_inff()), escapes);
        } else if (in.escape == int(Escape::visible_probes)) {
            escapes = tracer.visible(origin, raster::minus3(xyz<F>(probe), origin), F(0.0f), F(1.0f), escapes);
        }
        bits = bits | select(sees | escapes, I(1 << slot), I(0));
    }
    return bits;
}

// Traces the rays [first, last) of all receivers.
template <class F>
RayCounts receiver_rays(const ReceiverRaysView& in, const RayQuery& query, int first, int last) {
    using N = number<F>;
    using I = index_t<F>;
    RayTracer<F> tracer(query);
    RayCounts counts;
    for (int x = 0; x < in.width; x += N::width) {
        const I receiver = min(N::iota(x), I(in.width - 1));
        const mask_t<F> active = N::iota(x) < I(in.width);
        const vec3<F> position = xyz<F>(N::fetch4(in.position, receiver)), normal = xyz<F>(N::fetch4(in.normal, receiver));
        const reference::Basis<F> frame = reference::basis_of<F>(normal);
        const vec3<F> origin = position + normal * F(in.offset);
        for (int ray = first; ray < last; ++ray) {
            const float* local = in.directions + 4 * std::ptrdiff_t(ray);
            const vec3<F> direction =
                reference::to_world<F>(frame, vec3<F>{F(local[0]), F(local[1]), F(local[2])});
            const RayHit<F> hit = tracer.nearest(origin, direction, active);
            const Met<F> met = met_by<F>(in.surfaces, hit, direction);
            const I bits = probes_that_see<F>(in, receiver, origin, direction, hit, met, tracer, active);
            const I at = I(ray * in.width) + receiver;
            N::store4(in.seen, at,
                      vec4<F>(select3<F>(hit.found, met.point, direction), select(hit.found, F(1.0f), F(0.0f))), active);
            if (in.normals) N::store4(in.normals, at, vec4<F>(met.normal, F(0.0f)), active);
            N::store(in.lengths, at, select(hit.found, hit.t, F(escaped_length)), active);
            store_lanes<F>(in.visible + std::ptrdiff_t(ray) * in.width + x, bits, in.width - x);
            const mask_t<F> escaped = active & !hit.found, back = active & hit.found & !met.front;
            counts.escaped += lanes_of<F>(escaped);
            counts.back += lanes_of<F>(back);
            counts.unseen += lanes_of<F>(active & hit.found & met.front & (bits == I(0)));
        }
    }
    counts.traced = tracer.traced();
    return counts;
}

// ---- Inside of things ------------------------------------------------------------------------------------------------

struct TestRaysView {
    raster::SurfaceArgs surfaces;
    float offset;
    std::int32_t rays;
    std::int32_t crossings;       // surfaces that a ray is followed through; 1: as published
    const float* position;        // [receivers][4]
    const float* normal;
    const float* directions;      // [rays][4]: unit, z along the normal
    float* shortest;              // out: [receivers][4]: xyz direction of the shortest of the deepest rays, w how long it is till it
                                  // is out, m; 0 where none starts inside
    std::int32_t* insides;        // out: [receivers]: rays that start inside; -1: a ray met nothing, where `escapes` is null
    std::int32_t* escapes;        // out: [receivers]: rays that met nothing; null: a receiver with one lies in no solid
    std::int32_t least;           // rays that must start inside for it to matter; fewer are not counted to the end. 0: all are
};

// How deep inside a ray starts, and where it is out.
template <class F>
struct WayOut {
    F depth, length;
};

// Of a ray whose first hit is known. Leaving a solid counts 1, entering one -1: the largest sum on the way is the number of
// solids that the ray starts in, whatever overlaps them and whatever room is around, and where it is first reached the ray is out
// of all. `active`: lanes that are followed through more than the first surface.
template <class F>
PLUMB_INLINE WayOut<F> way_out(const TestRaysView& in, RayTracer<F>& tracer, const vec3<F>& origin, const vec3<F>& direction,
                               const RayHit<F>& first, const mask_t<F>& active) {
    RayHit<F> hit = first;
    F sum(0.0f);
    WayOut<F> out{F(0.0f), F(0.0f)};
    mask_t<F> alive = hit.found;
    for (int k = 0; k < in.crossings && any(alive); ++k) {
        if (k > 0) hit = tracer.nearest(origin, direction, hit.t, alive), alive = alive & hit.found;
        sum = sum + select(alive, select(met_by<F>(in.surfaces, hit, direction).front, F(-1.0f), F(1.0f)), F(0.0f));
        const mask_t<F> farther = alive & (sum > out.depth);
        out = {select(farther, sum, out.depth), select(farther, hit.t, out.length)};
        alive = alive & active;
    }
    return out;
}

// Rays of a receiver are followed beyond their first surface where so many of them meet a back there: most receivers lie inside of
// nothing.
inline int followed_from(int rays) { return (rays + 7) / 8; }

// Asks of receivers [first, last).
template <class F>
std::uint64_t test_rays(const TestRaysView& in, const RayQuery& query, int first, int last) {
    using N = number<F>;
    using I = index_t<F>;
    RayTracer<F> tracer(query);
    for (int x = first; x < last; x += N::width) {
        const I receiver = min(N::iota(x), I(last - 1));
        const mask_t<F> active = N::iota(x) < I(last);
        const vec3<F> position = xyz<F>(N::fetch4(in.position, receiver)), normal = xyz<F>(N::fetch4(in.normal, receiver));
        const reference::Basis<F> frame = reference::basis_of<F>(normal);
        const vec3<F> origin = position + normal * F(in.offset);
        vec4<F> shortest{F(0.0f), F(0.0f), F(0.0f), F(0.0f)};
        F depth(0.0f);
        I insides(0), escapes(0);
        mask_t<F> followed = active & (F(1.0f) < F(0.0f));
        // Once to see where backs are, and, where it is worth it, once more to the way out.
        for (const bool again : {false, true}) {
            if (again) {
                followed = active & (in.escapes ? active : escapes == I(0)) & !(insides < I(followed_from(in.rays)));
                if (in.crossings == 1 || !any(followed)) break;
                insides = select(followed, I(0), insides), escapes = select(followed, I(0), escapes);
                depth = select(followed, F(0.0f), depth), shortest.w = select(followed, F(0.0f), shortest.w);
            }
            mask_t<F> asked = again ? followed : active;
            for (int ray = 0; ray < in.rays; ++ray) {
                const float* local = in.directions + 4 * std::ptrdiff_t(ray);
                const vec3<F> direction =
                    reference::to_world<F>(frame, vec3<F>{F(local[0]), F(local[1]), F(local[2])});
                // What is certain needs no more rays: one has met nothing, or there are too few left.
                if (!in.escapes) asked = asked & (escapes == I(0)) & !(insides < I(in.least - in.rays + ray));
                if (!any(asked)) break;
                const RayHit<F> hit = tracer.nearest(origin, direction, asked);
                const WayOut<F> out = way_out<F>(in, tracer, origin, direction, hit, followed);
                const mask_t<F> inside = asked & (out.depth > F(0.0f));
                // Of two surfaces in one place a ray meets one: it misses what it leaves there. So the deepest rays are believed.
                const mask_t<F> shorter = inside & ((out.depth > depth) | ((out.depth == depth) & (out.length < shortest.w)));
                depth = max(depth, select(inside, out.depth, F(0.0f)));
                shortest = vec4<F>(select3<F>(shorter, direction, xyz<F>(shortest)), select(shorter, out.length, shortest.w));
                insides = insides + select(inside, I(1), I(0));
                escapes = escapes + select(asked & !hit.found, I(1), I(0));
            }
        }
        N::store4(in.shortest, receiver, shortest, active);
        if (in.escapes) store_lanes<F>(in.escapes + x, escapes, last - x);
        const mask_t<F> none = in.escapes ? active : escapes == I(0);
        store_lanes<F>(in.insides + x, select(none, insides, I(-1)), last - x);
    }
    return tracer.traced();
}

}  // namespace plumb::probes
