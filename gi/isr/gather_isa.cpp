// isr.gather and isr.ssao over rows: packets of one rotation from planes (source_planes.h), others by fetching.
#include "core/shade_rows.h"
#include "gi/isr/gather_kernel.h"
#include "gi/isr/ssao_kernel.h"

namespace plumb::isr {

namespace {

using F = PLUMB_ISA::Real;
using N = number<F>;
using I = index_t<F>;

// The samples of a packet of one rotation: the pixels (x + lane step, y) of the sources' grid.
struct PlaneSamples {
    const SourcePlanes& planes;
    const std::int32_t* offsets;  // of the rotation
    int rotations, x, y;

    PLUMB_INLINE ivec2<int> offset(int k) const { return offset_of(offsets[std::ptrdiff_t(k) * rotations]); }
    PLUMB_INLINE const float* at(int k) const {
        const ivec2<int> to = offset(k);
        return planes.first_of(x + to.x, y + to.y, N::width);
    }
    PLUMB_INLINE F load(const float* p, int plane) const { return N::load(p + std::ptrdiff_t(plane) * planes.stride); }
    PLUMB_INLINE vec3<F> load3(const float* p, int plane) const {
        return {load(p, plane), load(p, plane + 1), load(p, plane + 2)};
    }
};

struct PlaneSources : PlaneSamples {
    const SampleUniforms& u;
    const float* weights;

    template <class Tap>
    PLUMB_INLINE Source<F> at(int k, const Surface<F>& p, Tap&) const {
        const float* at = PlaneSamples::at(k);
        const ivec2<int> to = offset(k);
        const vec3<float> step = step_of<float>(u, float(to.x), float(to.y));
        return {between(p, vec3<F>{F(step.x), F(step.y), F(step.z)}, load(at, SourcePlanes::depth)),
                load(at, SourcePlanes::source_area), F(weight_of(weights, k)), load3(at, SourcePlanes::normal_x), load3(at, SourcePlanes::red)};
    }
};

struct PlaneSpheres : PlaneSamples {
    template <class Tap>
    PLUMB_INLINE Sphere<F> at(int k, Tap&) const {
        const float* p = PlaneSamples::at(k);
        return {load3(p, SourcePlanes::position_x), load(p, SourcePlanes::area)};
    }
};

PLUMB_INLINE void save(const SourcePlanes& planes, int plane, float* at, F value, mask_t<F> on) {
    N::save(at + std::ptrdiff_t(plane) * planes.stride, select(on, value, F(0.0f)));
}
PLUMB_INLINE void save3(const SourcePlanes& planes, int plane, float* at, const vec3<F>& value, mask_t<F> on) {
    for (int c = 0; c < 3; ++c) save(planes, plane + c, at, value[c], on);
}

// What lies beyond the border of the planes that begin at `first`, pixel 0 of plane 0; or all of them.
void clear(const SourcePlanes& planes, float* first, bool all) {
    const int inner = planes.stride - 2 * SourcePlanes::padding;
    for (int plane = 0; plane < planes.count; ++plane) {
        float* p = first + std::ptrdiff_t(plane) * planes.stride;
        for (int i = -SourcePlanes::padding; i < 0; ++i) p[i] = 0;
        for (int i = all ? 0 : inner; i < inner + SourcePlanes::padding; ++i) p[i] = 0;
    }
}

// Calls each(at, px, i, y, on) for the packets of rows [first, last) of sources: where they go in plane 0, their columns px and
// pixels i, of which `on` exist.
template <class Each>
PLUMB_INLINE void each_source(const SourcePlanes& planes, int first, int last, Each each) {
    const int inner = planes.stride - 2 * SourcePlanes::padding;
    for (int y = first; y < last; ++y)
        for (int x = 0; x < planes.step; ++x) {
            float* row = planes.at(x, y);
            clear(planes, row, false);
            for (int k = 0; k < inner; k += N::width) {
                const I column = N::iota(k) * I(planes.step) + I(x), px = min(column, I(planes.width - 1));
                each(row + k, px, I(y * planes.width) + px, y, column < I(planes.width));
            }
        }
    if (last == planes.height) clear(planes, planes.nothing(), true);
}

// Calls kernel(px, x, y) for packets of one rotation, x the first of the packet's columns, for rows [first, last) of the
// receivers, and stores what it says. Along a row one packet reads, of each sample, what lies beside the one before it.
template <class Kernel>
PLUMB_INLINE void shade_by_rotation(const SampleUniforms& u, int first, int last, const Tiles& tiles, float* out, Kernel kernel) {
    const int step = SourcePlanes::step_of(u);
    const auto wanted = [&](const std::uint8_t* row, int from, int to) {
        if (!row) return true;
        for (int t = from >> 4; t <= to >> 4; ++t)
            if (row[t]) return true;
        return false;
    };
    for (int y = first; y < last; ++y)
        for (int turn = 0; turn < step; ++turn)
            for (int x = turn; x < u.width; x += step * N::width) {
                if (!wanted(tiles.row(y), x, min(u.width - 1, x + step * (N::width - 1)))) continue;
                const I column = N::iota(0) * I(step) + I(x), px = min(column, I(u.width - 1));
                N::store4(out, I(y * u.width) + px, kernel(px, x, y), column < I(u.width));
            }
}

template <class View>
PLUMB_INLINE PlaneSamples samples_of(const View& in, const SourcePlanes& planes, int x, int y) {
    const SampleUniforms& u = in.u;
    return {planes, in.offsets + rotation_of<float>(u, x, y), u.rotations, x + u.margin, y + u.margin};
}

}  // namespace

}  // namespace plumb::isr

namespace plumb {

using namespace isr;

template <>
void SharedRows<GatherKernel, Isa::PLUMB_ISA>::run(const GatherInputsView& in, int first, int last, float* shared) {
    const SampleUniforms& u = in.u;
    const SourcePlanes planes(u, SourcePlanes::of_gather, shared);
    each_source(planes, first, last, [&](float* at, I px, I i, int y, mask_t<F> on) {
        const Surface<F> s = surface_of<F>(u, px - I(u.margin), I(y - u.margin), N::fetch4(in.source_surface, i));
        save(planes, SourcePlanes::depth, at, s.depth, on);
        save(planes, SourcePlanes::source_area, at, area_of(u, s), on);
        save3(planes, SourcePlanes::normal_x, at, s.normal, on);
        save3(planes, SourcePlanes::red, at, light_of(s, xyz<F>(N::fetch4(in.source_radiosity, i))), on);
    });
}

template <>
void SharedRows<SsaoKernel, Isa::PLUMB_ISA>::run(const SsaoInputsView& in, int first, int last, float* shared) {
    const SampleUniforms& u = in.u;
    const SourcePlanes planes(u, SourcePlanes::of_ssao, shared);
    each_source(planes, first, last, [&](float* at, I px, I i, int y, mask_t<F> on) {
        const Sphere<F> s = sphere_of<F>(u, px - I(u.margin), I(y - u.margin), N::fetch4(in.source_surface, i));
        save3(planes, SourcePlanes::position_x, at, s.position, on);
        save(planes, SourcePlanes::area, at, s.radius2, on);
    });
}

template <>
void Rows<GatherKernel, Isa::PLUMB_ISA>::run(const GatherInputsView& in, int first, int last, const Tiles& tiles, float*) {
    const SampleUniforms& u = in.u;
    if (!SourcePlanes::apply(u))
        return shade_packets<F>(u.width, first, last, tiles, in.gathered, [&](int, I px, int y, NoTap& tap) {
            return GatherKernel::item<F>(in, px, I(y), tap);
        });
    const SourcePlanes planes(u, SourcePlanes::of_gather, const_cast<float*>(in.shared));
    shade_by_rotation(u, first, last, tiles, in.gathered, [&](I px, int x, int y) {
        NoTap tap;
        return isr::gather<F>(in, px, I(y), PlaneSources{samples_of(in, planes, x, y), u, in.weights}, tap);
    });
}

template <>
void Rows<SsaoKernel, Isa::PLUMB_ISA>::run(const SsaoInputsView& in, int first, int last, const Tiles& tiles, float*) {
    const SampleUniforms& u = in.u;
    if (!SourcePlanes::apply(u))
        return shade_packets<F>(u.width, first, last, tiles, in.lit, [&](int, I px, int y, NoTap& tap) {
            return SsaoKernel::item<F>(in, px, I(y), tap);
        });
    const SourcePlanes planes(u, SourcePlanes::of_ssao, const_cast<float*>(in.shared));
    shade_by_rotation(u, first, last, tiles, in.lit, [&](I px, int x, int y) {
        NoTap tap;
        return isr::ssao<F>(in, px, I(y), PlaneSpheres{samples_of(in, planes, x, y)}, tap);
    });
}

}  // namespace plumb
