// Which pixels of a band rsm.disc and rsm.paths shade together. Only stages_isa.cpp includes it.
//
// shade_packets() would give a packet neighbours, each with a rotation of its own: two gathers a sample to read the
// tables, and every lane somewhere else on the map. There time goes into waiting for memory: a disc of 0.3 x 512
// texels is 2.4 MB of half records, more than the processor's second cache level holds, and hardly two samples share
// a line.
//
// Here a packet is pixels of one rotation, so that an entry of a table is one number for all lanes. Where the records of a
// sample lie is computed eight samples ahead, and they are asked for then, an instruction each: when they are summed their
// places have been in memory, and they themselves in the second cache level, for long. Where all of them lie outside the
// map nothing is read. Pixels that fill no packet of their rotation share packets, and each lane looks up its own rows.
//
// A pixel's samples are added up as gather_disc() and gather_paths() do, whatever packet it is in: not a bit depends on
// any of this.
#pragma once

#include "core/kernel_rows.h"
#include "core/tap.h"
#include "core/wide.h"
#include "gi/rsm/paths_kernel.h"

namespace plumb::rsm {

// The places of lanes' records; core/wide.h has them of packets alone.
template <class F, class Component>
PLUMB_INLINE auto places_of(const index_t<F>& record) {
    if constexpr (number<F>::width == 1)
        return record;
    else
        return number<F>::template record_places<Component>(record);
}

// Whether a sample outside the map, for which the kernels take texel 0 with the weight 0, adds 0 to the sums of all lanes
// that are near: it does, unless something there is no number or overflows.
template <class F, class View, class Point>
PLUMB_INLINE bool outside_adds_nothing(const View& in, const Point& point) {
    NoTap tap;
    const Record<F> p = number<F>::fetch_record(in.records, index_t<F>(0));
    const F zero(0.0f);
    F share(1.0f);
    if (in.u.sample_area > 0.0f) share = share_of_disc(in.u, point.x, xyz<F>(p.a), xyz<F>(p.b), zero, tap);
    const F g = form(point.x, point.n, xyz<F>(p.a), xyz<F>(p.b), F(in.u.least_distance2), tap) * (zero * share);
    const mask_t<F> nothing = (p.c.x * g == zero) & (p.c.y * g == zero) & (p.c.z * g == zero);
    return !any(point.near & !nothing);
}

// The samples of a packet, each located and asked for before it is summed. It stands for `rotation` in the kernels.
template <class F, class Kernel, bool shared>
class SamplesAhead {
    using N = number<F>;
    using I = index_t<F>;
    using View = typename Kernel::View;
    using Component = std::remove_cvref_t<decltype(*View::records)>;
    using Point = ProjectedPoint<F, Kernel::continuous>;
    using Row = std::conditional_t<shared, std::int32_t, I>;
    using Places = decltype(places_of<F, Component>(I(0)));
    // How many samples ahead; and how many are kept, so that one is located before another is read.
    static constexpr int ahead = 8, kept = 2 * ahead;

  public:
    PLUMB_INLINE SamplesAhead(const View& in, const Point& point, const Row& rotation)
        : in_(in), point_(point), rotation_(rotation), samples_(Kernel::samples(in.u)),
          skips_(outside_adds_nothing<F>(in, point)) {
        for (int k = 0; k < min(ahead, samples_); ++k) locate(k);
    }

    PLUMB_INLINE const Row& rotation() const { return rotation_; }

    // Also locates a later sample: to be called for each, in order, before sample().
    PLUMB_INLINE bool idle(int k) const {
        if (k + ahead < samples_) locate(k + ahead);
        return located_[k % kept].idle;
    }
    PLUMB_INLINE MapSample<F> sample(int k) const {
        const Located& at = located_[k % kept];
        return {at.inside, N::fetch_record(in_.records, at.places), {}};
    }

  private:
    struct Located {
        Places places;
        mask_t<F> inside;
        bool idle;
    };

    PLUMB_INLINE void locate(int k) const {
        Located& to = located_[k % kept];
        NoTap tap;
        const I size(in_.u.map.size);
        const ivec2<I> texel = point_.texels.texel(in_, row_of(rotation_, k * in_.u.rotations), tap);
        to.inside = in_range(texel.x, size) & in_range(texel.y, size);
        to.places = places_of<F, Component>(select(to.inside, texel.y * size + texel.x, I(0)));
        to.idle = skips_ && !any(to.inside);
        if (!to.idle) ask(to.places);
    }

    // The second cache level is asked to hold the records: the first is too small for those of so many samples. What asks
    // is inlined all the way: a compiler takes a function that only asks for one without effect, and drops calls.
    PLUMB_INLINE void ask(const Places& at) const {
#pragma GCC unroll 16
        for (int i = 0; i < N::width; ++i) {
            std::ptrdiff_t byte;
            if constexpr (N::width == 1)
                byte = std::ptrdiff_t(at) * record_stride * std::ptrdiff_t(sizeof(Component));
            else
                byte = at.byte[i];
            __builtin_prefetch(reinterpret_cast<const char*>(in_.records) + byte, 0, 2);
        }
    }

    const View& in_;
    const Point& point_;
    const Row rotation_;
    const int samples_;
    const bool skips_;
    mutable Located located_[kept];
};

template <class F, class Kernel, bool shared>
PLUMB_INLINE auto row_of(const SamplesAhead<F, Kernel, shared>& samples, int first) {
    return row_of(samples.rotation(), first);
}
template <class F, class Kernel, bool shared>
PLUMB_INLINE bool adds_nothing(const SamplesAhead<F, Kernel, shared>& samples, int k) {
    return samples.idle(k);
}
template <class F, class View, class Point, class Kernel, bool shared, class Tap>
PLUMB_INLINE MapSample<F> map_sample(const View&, const Point&, const SamplesAhead<F, Kernel, shared>& samples, int k,
                                     Tap&) {
    return samples.sample(k);
}

// Shades a pixel a lane: py << 16 | px. `shared`: all have the same rotation.
template <class F, class Kernel, bool shared>
PLUMB_INLINE void shade_packet(const typename Kernel::View& in, const std::int32_t* pixels) {
    using I = index_t<F>;
    I place;
    std::memcpy(&place, pixels, sizeof place);
    const I px = place & I(0xffff), py = place >> 16;
    NoTap tap;
    const auto point = projected_point<F, Kernel::continuous>(in, px, py, tap);
    vec3<F> sum{F(0.0f), F(0.0f), F(0.0f)};
    if (any(point.near)) {
        if constexpr (shared) {
            const SamplesAhead<F, Kernel, true> samples(
                in, point, rotation_of(in.u, pixels[0] & 0xffff, pixels[0] >> 16));
            Kernel::template gather<F>(in, point, samples, sum, tap);
        } else {
            const SamplesAhead<F, Kernel, false> samples(in, point, point.rotation);
            Kernel::template gather<F>(in, point, samples, sum, tap);
        }
    }
    const vec3<F> irradiance = irradiance_of<F, Kernel::continuous>(in.u, point, sum, tap);
    number<F>::store4(in.irradiance, py * I(in.u.width) + px, vec4<F>(irradiance, F(0.0f)), I(0) < I(1));
}

// The pixels of a block by rotation: those that fill packets first, the others behind them.
template <class F>
struct SortedBlock {
    static constexpr int width = number<F>::width, rows = 32, columns = 128, most_rotations = 4096;
    static constexpr int most = rows * columns + width;
    std::int32_t pixels[most];  // py << 16 | px
    int shared = 0, all = 0;    // pixels in packets of one rotation, and in all; both fill packets

    // The columns [left, right) of rows [first, last).
    template <class Uniforms>
    PLUMB_INLINE SortedBlock(const Uniforms& u, int left, int right, int first, int last, const Tiles& tiles) {
        std::int32_t found[most], rotation[most];
        int n = 0;
        for (int y = first; y < last; ++y) {
            const std::uint8_t* row = tiles.row(y);
            for (int x = left; x < right; x += width) {
                if (row && !row[x >> 4]) continue;
                const auto of_lanes = rotation_of(u, number<F>::iota(x), index_t<F>(y));
                std::memcpy(rotation + n, &of_lanes, sizeof of_lanes);
                for (int i = 0; i < width && x + i < right; ++i) found[n++] = y << 16 | (x + i);
            }
        }
        sort(u.rotations <= most_rotations ? u.rotations : 0, found, rotation, n);
    }

  private:
    PLUMB_INLINE void sort(int rotations, const std::int32_t* found, const std::int32_t* rotation, int n) {
        int next[most_rotations] = {}, full[most_rotations];
        if (rotations > 0)
            for (int i = 0; i < n; ++i) ++next[rotation[i]];
        for (int r = 0; r < rotations; ++r) {
            const int in_packets = next[r] - next[r] % width;
            next[r] = shared, shared += in_packets, full[r] = shared;
        }
        all = shared;
        for (int i = 0; i < n; ++i) {
            const bool fits = rotations > 0 && next[rotation[i]] < full[rotation[i]];
            pixels[fits ? next[rotation[i]]++ : all++] = found[i];
        }
        // The last packet repeats a pixel.
        for (; all % width != 0; ++all) pixels[all] = pixels[all - 1];
    }
};

// Rows [first, last) of the image.
template <class F, class Kernel>
PLUMB_INLINE void shade_by_rotation(const typename Kernel::View& in, int first, int last, const Tiles& tiles) {
    using Block = SortedBlock<F>;
    for (int y = first; y < last; y += Block::rows)
        for (int x = 0; x < in.u.width; x += Block::columns) {
            const Block block(in.u, x, min(in.u.width, x + Block::columns), y, min(last, y + Block::rows), tiles);
            int i = 0;
            for (; i < block.shared; i += Block::width) shade_packet<F, Kernel, true>(in, block.pixels + i);
            for (; i < block.all; i += Block::width) shade_packet<F, Kernel, false>(in, block.pixels + i);
        }
}

}  // namespace plumb::rsm
