// Which pixels of a band rsm.disc and rsm.paths shade together. Only stages_isa.cpp includes it.
//
// shade_packets() would give a packet neighbours, each with a rotation of its own: two gathers a sample to read the
// tables, and every lane somewhere else on the map. There time goes into waiting for memory: a disc of 0.3 x 512
// texels is 2.4 MB of half records, more than the processor's second cache level holds, and hardly two samples share
// a line.
//
// Here a packet is pixels of one rotation. An entry of a table is one number for all lanes; and since a step moves
// every lane by the same distance on the map, the records of the next path, or of the disc's next samples, are asked for,
// an instruction each, while these are summed. Pixels that fill no packet of their rotation share packets, and each lane looks up its own
// rows.
//
// A pixel's samples are added up as gather_disc() and gather_paths() do, whatever packet it is in: not a bit depends on any of this.
#pragma once

#include "core/kernel_rows.h"
#include "core/tap.h"
#include "core/wide.h"
#include "gi/rsm/paths_kernel.h"

namespace plumb::rsm {

// Asks for the records of samples ahead. Nothing is read, so that no place on the map or off it does harm.
//
// What asks is inlined all the way: a compiler takes a function that only asks for one without effect, and drops calls.
template <class F, class Kernel>
class RecordsAhead {
    using View = typename Kernel::View;
    static constexpr int width = number<F>::width;

  public:
    PLUMB_INLINE RecordsAhead(const View& in, const ProjectedPoint<F, Kernel::continuous>& point)
        : in_(in) {
        using I = index_t<F>;
        if constexpr (!Kernel::continuous) {
            const I across = select(point.near, point.texels.centre.x, I(0));
            const I down = select(point.near, point.texels.centre.y, I(0));
            std::int32_t x[width], y[width];
            std::memcpy(x, &across, sizeof x), std::memcpy(y, &down, sizeof y);
            const std::uintptr_t first = reinterpret_cast<std::uintptr_t>(in.records);
            for (int i = 0; i < width; ++i) record_[i] = first + distance(x[i], y[i]);
            std::memcpy(rotation_, &point.rotation, sizeof rotation_);
        }
    }

    // Of lanes that share a rotation, or that have their own. The second cache level is asked to hold the records: in
    // the first a path's lines, 160 of 512, would push out what is in use. Continuous texels are not asked for.
    template <bool shared>
    PLUMB_INLINE void ask(std::int32_t rotation, SampleGroup samples) const {
        if constexpr (Kernel::continuous) return;
        const std::int32_t* offsets = in_.offsets + std::ptrdiff_t(samples.first) * in_.u.rotations;
        for (int k = samples.first; k < samples.end; ++k, offsets += in_.u.rotations) {
            const std::uintptr_t moved = shared ? distance(offsets[rotation]) : 0;
            for (int i = 0; i < width; ++i) {
                const std::uintptr_t to = record_[i] + (shared ? moved : distance(offsets[rotation_[i]]));
                __builtin_prefetch(reinterpret_cast<const void*>(to), 0, 2);
            }
        }
    }

  private:
    // Bytes from a texel to the one dx to the right and dy below.
    PLUMB_INLINE std::uintptr_t distance(std::int32_t dx, std::int32_t dy) const {
        const std::int64_t texels = std::int64_t(dy) * in_.u.map.size + dx;
        return std::uintptr_t(texels * record_stride * std::int64_t(sizeof *in_.records));
    }
    PLUMB_INLINE std::uintptr_t distance(std::int32_t offset) const {
        return distance(std::int16_t(offset & 0xffff), offset >> 16);
    }

    const View& in_;
    std::uintptr_t record_[width];  // of the projection
    std::int32_t rotation_[width];
};

// Shades a pixel a lane: py << 16 | px. `shared`: all have the same rotation.
template <class F, class Kernel, bool shared>
PLUMB_INLINE void shade_packet(const typename Kernel::View& in, const std::int32_t* pixels) {
    using I = index_t<F>;
    I place;
    std::memcpy(&place, pixels, sizeof place);
    const I px = place & I(0xffff), py = place >> 16;
    const std::int32_t rotation = rotation_of<std::int32_t>(in.u, pixels[0] & 0xffff, pixels[0] >> 16);
    NoTap tap;
    const auto point = projected_point<F, Kernel::continuous>(in, px, py, tap);
    const RecordsAhead<F, Kernel> ahead(in, point);
    vec3<F> sum{F(0.0f), F(0.0f), F(0.0f)};
    const int groups = any(point.near) ? Kernel::groups(in.u) : 0;
    for (int i = 0; i < groups; ++i) {
        if (i + 1 < groups) ahead.template ask<shared>(rotation, Kernel::samples(in.u, i + 1));
        if constexpr (shared)
            Kernel::template gather<F>(in, point, rotation, i, sum, tap);
        else
            Kernel::template gather<F>(in, point, point.rotation, i, sum, tap);
    }
    const vec3<F> irradiance = irradiance_of<F, Kernel::continuous>(in.u, point, sum, tap);
    number<F>::store4(in.irradiance, py * I(in.u.width) + px, vec4<F>(irradiance, F(0.0f)), I(0) < I(1));
}

// The pixels of a block by rotation: those that fill packets first, the others behind them.
template <class F>
struct SortedBlock {
    static constexpr int width = number<F>::width, rows = 16, columns = 256, most_rotations = 4096;
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
                const auto of_lanes = rotation_of<index_t<F>>(u, number<F>::iota(x), index_t<F>(y));
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
