// isr.gather and isr.ssao over rows: without rotations from planes (source_planes.h).
#include "core/shade_rows.h"
#include "gi/isr/gather_kernel.h"
#include "gi/isr/ssao_kernel.h"

namespace plumb::isr {

namespace {

using F = PLUMB_ISA::Real;
using N = number<F>;
using I = index_t<F>;

// The samples of the pixels (x + lane, y), from planes; without rotations.
struct PlaneSamples {
    const SourcePlanes& planes;
    const std::int32_t* offsets;
    int x, y, source_width;  // x, y: of the sources

    PLUMB_INLINE const float* at(int k) const {
        const ivec2<int> offset = offset_of(offsets[k]);
        const int column = x + offset.x, row = y + offset.y;
        const bool inside = row >= planes.first_row && row < planes.first_row + planes.rows && column > -N::width &&
                            column < source_width;
        return inside ? planes.at(column, row) : planes.nothing();
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
        const ivec2<int> offset = offset_of(offsets[k]);
        const vec3<float> step = step_of<float>(u, float(offset.x), float(offset.y));
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

void clear_row(const SourcePlanes& planes, float* row) {
    float* p = row - SourcePlanes::padding;
    for (int i = 0; i < planes.count * planes.stride; ++i) p[i] = 0;
}

PLUMB_INLINE void save(const SourcePlanes& planes, int plane, int x, int y, F value, mask_t<F> on) {
    N::save(planes.at(x, y) + std::ptrdiff_t(plane) * planes.stride, select(on, value, F(0.0f)));
}
PLUMB_INLINE void save3(const SourcePlanes& planes, int plane, int x, int y, const vec3<F>& value, mask_t<F> on) {
    for (int c = 0; c < 3; ++c) save(planes, plane + c, x, y, value[c], on);
}

// Calls each(x, px, i, y, on) for the packets of all rows of sources: columns px, pixels i, of which `on` exist.
template <class Each>
PLUMB_INLINE void each_source(const SampleUniforms& u, const SourcePlanes& planes, Each each) {
    for (int y = planes.first_row; y < planes.first_row + planes.rows; ++y) {
        clear_row(planes, planes.at(0, y));
        for (int x = 0; x < u.source_width; x += N::width) {
            const I px = min(N::iota(x), I(u.source_width - 1));
            each(x, px, I(y * u.source_width) + px, y, N::iota(x) < I(u.source_width));
        }
    }
    clear_row(planes, planes.nothing());
}

void take_apart(const GatherInputsView& in, const SourcePlanes& planes) {
    const SampleUniforms& u = in.u;
    each_source(u, planes, [&](int x, I px, I i, int y, mask_t<F> on) {
        const Surface<F> s = surface_of<F>(u, px - I(u.margin), I(y - u.margin), N::fetch4(in.source_surface, i));
        save(planes, SourcePlanes::depth, x, y, s.depth, on);
        save(planes, SourcePlanes::source_area, x, y, area_of(u, s), on);
        save3(planes, SourcePlanes::normal_x, x, y, s.normal, on);
        save3(planes, SourcePlanes::red, x, y, light_of(s, xyz<F>(N::fetch4(in.source_radiosity, i))), on);
    });
}

void take_apart(const SsaoInputsView& in, const SourcePlanes& planes) {
    const SampleUniforms& u = in.u;
    each_source(u, planes, [&](int x, I px, I i, int y, mask_t<F> on) {
        const Sphere<F> s = sphere_of<F>(u, px - I(u.margin), I(y - u.margin), N::fetch4(in.source_surface, i));
        save3(planes, SourcePlanes::position_x, x, y, s.position, on);
        save(planes, SourcePlanes::area, x, y, s.radius2, on);
    });
}

}  // namespace

}  // namespace plumb::isr

namespace plumb {

using namespace isr;

template <>
void Rows<GatherKernel, Isa::PLUMB_ISA>::run(const GatherInputsView& in, int first, int last, const Tiles& tiles,
                                             float* scratch) {
    const SampleUniforms& u = in.u;
    if (u.rotations > 1)
        return shade_packets<F>(u.width, first, last, tiles, in.gathered, [&](int, I px, int y, NoTap& tap) {
            return GatherKernel::item<F>(in, px, I(y), tap);
        });
    const SourcePlanes planes(u, SourcePlanes::of_gather, in.reach, first, last, scratch);
    take_apart(in, planes);
    shade_packets<F>(u.width, first, last, tiles, in.gathered, [&](int x, I px, int y, NoTap& tap) {
        const PlaneSources sources{{planes, in.offsets, x + u.margin, y + u.margin, u.source_width}, u, in.weights};
        return isr::gather<F>(in, px, I(y), sources, tap);
    });
}

template <>
void Rows<SsaoKernel, Isa::PLUMB_ISA>::run(const SsaoInputsView& in, int first, int last, const Tiles& tiles,
                                           float* scratch) {
    const SampleUniforms& u = in.u;
    if (u.rotations > 1)
        return shade_packets<F>(u.width, first, last, tiles, in.lit, [&](int, I px, int y, NoTap& tap) {
            return SsaoKernel::item<F>(in, px, I(y), tap);
        });
    const SourcePlanes planes(u, SourcePlanes::of_ssao, in.reach, first, last, scratch);
    take_apart(in, planes);
    shade_packets<F>(u.width, first, last, tiles, in.lit, [&](int x, I px, int y, NoTap& tap) {
        const PlaneSpheres spheres{{planes, in.offsets, x + u.margin, y + u.margin, u.source_width}};
        return isr::ssao<F>(in, px, I(y), spheres, tap);
    });
}

}  // namespace plumb
