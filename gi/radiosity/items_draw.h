// Hemicubes drawn triangle by triangle: what items_kernel.h asks of every texel and triangle, to the bit, in the order that a
// processor likes. Only kernel files include it, after core/wide.h.
//
//     turn     vertices into the hemicube's axes, once for all five faces, each with 25 bits: what reaches() compares
//     cull     packets of triangles by the bits of their corners: which faces each may reach
//     box      the texels whose centres its bounds hold: mostly none, or one
//     draw     boxes of a few texels a lane each, all triangles of the packet at once; larger ones row by row
//
// Triangles come in any order. A texel keeps the nearest one, of equals that of the lowest number: the first one, as the kernel has it.
#pragma once

#include "core/wide.h"
#include "gi/radiosity/items_kernel.h"

namespace plumb::radiosity {
namespace {

using F = PLUMB_ISA::Real;
using N = number<F>;
using I = index_t<F>;
using Mask = mask_t<F>;
using Lanes = std::int32_t[N::width];

PLUMB_INLINE I load_index(const std::int32_t* p) {
#if defined(PLUMB_NO_WIDE)
    return *p;
#else
    PLUMB_ISA::native::Int v;  // and not a lane's class, which goes through memory
    std::memcpy(&v, p, sizeof v);
    return v;
#endif
}

// Lane k of a mask is bit k.
PLUMB_INLINE unsigned bits_of(const Mask& mask) {
#if defined(__AVX512F__)
    return mask.m;
#elif defined(__AVX2__)
    return unsigned(_mm256_movemask_ps((__m256)mask.m));
#elif defined(__SSE4_2__)
    return unsigned(_mm_movemask_ps((__m128)mask.m));
#else
    return mask ? 1 : 0;
#endif
}

// Stores x, y, z, w of lane k at to + 4 k.
PLUMB_INLINE void save4(float* to, F x, F y, F z, F w) {
    if constexpr (N::width == 1) {
        N::save(to, x), N::save(to + 1, y), N::save(to + 2, z), N::save(to + 3, w);
    } else {
        alignas(64) float from[4][N::width];
        N::save(from[0], x), N::save(from[1], y), N::save(from[2], z), N::save(from[3], w);
        for (int k = 0; k < N::width; k += 4, to += 16) {
            __m128 a = _mm_load_ps(from[0] + k), b = _mm_load_ps(from[1] + k), c = _mm_load_ps(from[2] + k), d = _mm_load_ps(from[3] + k);
            _MM_TRANSPOSE4_PS(a, b, c, d);
            _mm_store_ps(to, a), _mm_store_ps(to + 4, b), _mm_store_ps(to + 8, c), _mm_store_ps(to + 12, d);
        }
    }
}

// Turns with a face that the compiler knows.
template <int face, class G>
PLUMB_INLINE vec3<G> turned_to(const vec3<G>& p) {
    if constexpr (face == 0) return {-p.y, p.x, p.z};
    if constexpr (face == 1) return {p.y, p.z, p.x};
    if constexpr (face == 2) return {-p.y, p.z, -p.x};
    if constexpr (face == 3) return {-p.x, p.z, p.y};
    if constexpr (face == 4) return {p.x, p.z, -p.y};
}

// What reaches() compares of a corner, five bits a face: in front of the eye; beyond the right, left, upper, lower border.
constexpr int code_bits = 5;
constexpr std::int32_t fronts = 0b00001'00001'00001'00001'00001;

template <int face>
PLUMB_INLINE I code_on(const vec3<F>& p) {
    const vec3<F> q = turned_to<face>(p);
    const auto bit = [](const Mask& is, int k) { return select(is, I(1 << (code_bits * face + k)), I(0)); };
    return bit(q.z > F(0.0f), 0) | bit(q.x > q.z, 1) | bit(-q.x > q.z, 2) | bit(q.y > q.z, 3) | bit(-q.y > q.z, 4);
}

// Of the front bits those of faces that reaches() says yes to, of corners with those codes.
PLUMB_INLINE I faces_reached(const I& a, const I& b, const I& c) {
    const I some = a | b | c, all = a & b & c;
    const I beyond = shift_right(all, 1) | shift_right(all, 2) | shift_right(all, 3) | shift_right(all, 4);
    return select((some & I(1)) == I(0), I(0), some & ~beyond & I(fronts));
}

// Lane k of vectors that were saved.
struct SavedPlanes {
    alignas(64) float e0[3][N::width], e1[3][N::width], e2[3][N::width], normal[3][N::width];
    alignas(64) float volume[N::width], inverse[N::width];

    static void save(float (&to)[3][N::width], const vec3<F>& v) { N::save(to[0], v.x), N::save(to[1], v.y), N::save(to[2], v.z); }
    static vec3<float> lane(const float (&of)[3][N::width], int k) { return {of[0][k], of[1][k], of[2][k]}; }

    void save(const Planes<F>& p, F inverse_volume) {
        save(e0, p.e0), save(e1, p.e1), save(e2, p.e2), save(normal, p.normal);
        N::save(volume, p.volume), N::save(inverse, inverse_volume);
    }
};

class Drawing {
  public:
    Drawing(const ItemsUniforms& u, const DrawList& list, float* memory) : u_(u), size_(u.width), list_(list), m_(memory, u.vertices, u.width) {
        for (int i = 0; i < size_; i += N::width)
            N::save(m_.centre + i, (N::from_index(N::iota(i)) + F(0.5f)) * F(u.texel) - F(1.0f));
    }

    // Rows [first, last) of the hemicube with that eye, [4][4].
    void draw(const float* vertices, const float* eye, int first, int last) {
        first_ = first, last_ = last, eye_ = eye;
        const I nothing(-1);
        for (int at = first * size_; at < last * size_; at += N::width)
            N::save(m_.nearness + at, F(0.0f)), std::memcpy(m_.seen + at, &nothing, sizeof nothing);
        if (eye[12] == 0 && eye[13] == 0 && eye[14] == 0) return;  // without a normal nothing is above
        turn_vertices(vertices, eye);
        constexpr int step = packets_at_once * N::width;
        for (int i = 0; i < list_.count; i += step) draw_packets(i, min(i + step, list_.count));
    }

    // Of the texels of row `row` from column x on: what they see.
    Item<F> resolve(int row, int x) const {
        const int at = row * size_ + x;
        const I seen = load_index(m_.seen + at);
        const Mask some = I(-1) < seen, front = (seen & I(1)) == I(0);
        const F zero(0.0f);
        return {seen >> 1,
                {select(some, N::load(m_.b1 + at), zero), select(some, N::load(m_.b2 + at), zero), N::load(m_.nearness + at),
                 select(some, select(front, F(1.0f), F(-1.0f)), zero)}};
    }

    const DrawMemory& memory() const { return m_; }

  private:
    int first_row(int face) const { return face == 0 ? 0 : size_ + (face - 1) * (size_ / 2); }
    int rows_of(int face) const { return face == 0 ? size_ : size_ / 2; }

    static PLUMB_INLINE Eye<F> eye_of(const float* e) {
        return {{F(e[0]), F(e[1]), F(e[2])}, {F(e[4]), F(e[5]), F(e[6])}, {F(e[8]), F(e[9]), F(e[10])}, {F(e[12]), F(e[13]), F(e[14])}};
    }

    void turn_vertices(const float* vertices, const float* e) {
        const Eye<F> eye = eye_of(e);
        for (int i = 0; i < u_.vertices; i += N::width) {
            const vec3<F> p = eye.local(xyz<F>(N::fetch4(vertices, min(N::iota(i), I(u_.vertices - 1)))));
            const I code = code_on<0>(p) | code_on<1>(p) | code_on<2>(p) | code_on<3>(p) | code_on<4>(p);
            save4(m_.turned + 4 * std::ptrdiff_t(i), p.x, p.y, p.z, N::from_bits(code));
        }
    }

    // A packet of triangles: corners along u, t, n, and which faces they may reach.
    struct Packet {
        vec3<F> p[3];
        I faces;
    };

    PLUMB_INLINE Packet packet_at(int i) const {
        Packet q;
        I code[3];
        for (int k = 0; k < 3; ++k) {
            const vec4<F> v = N::fetch4(m_.turned, load_index(list_.corner[k] + i));
            q.p[k] = xyz<F>(v), code[k] = N::bits(v.w);
        }
        q.faces = faces_reached(code[0], code[1], code[2]);
        return q;
    }

    // Fetches several packets without a branch, so that one's memory is waited for while others are fetched, and draws them.
    void draw_packets(int first, int end) {
        Packet packets[packets_at_once];
        int n = 0;
        for (int i = first; i < end; i += N::width) packets[n++] = packet_at(i);
        for (int k = 0; k < n; ++k)
            if (any(I(0) < packets[k].faces)) draw_packet(packets[k], first + k * N::width);
    }

    void draw_packet(const Packet& q, int i) {
        has_planes_ = has_saved_ = false;
        draw_on_face<0>(q.p, q.faces, i), draw_on_face<1>(q.p, q.faces, i), draw_on_face<2>(q.p, q.faces, i);
        draw_on_face<3>(q.p, q.faces, i), draw_on_face<4>(q.p, q.faces, i);
    }

    // The texels from, to which centres lie within [low, high], a thousandth of a texel more: whatever rounding makes of it.
    static PLUMB_INLINE F from_column(F low, F per) { return max(F(0.0f), -floor(-(low * per - F(0.501f)))); }
    static PLUMB_INLINE F to_column(F high, F per, int count) { return min(F(float(count - 1)), floor(high * per - F(0.499f))); }

    // Columns, and rows of the face, inclusive.
    struct Boxes {
        F left, right, top, bottom;
    };

    template <int face>
    PLUMB_INLINE void draw_on_face(const vec3<F> (&p)[3], const I& faces, int first_triangle) {
        Mask draws = I(0) < (faces & I(1 << (code_bits * face)));
        if (!any(draws)) return;
        const int begin = first_row(face), rows = rows_of(face);
        if (begin >= last_ || begin + rows <= first_) return;
        const vec3<F> a = turned_to<face>(p[0]), b = turned_to<face>(p[1]), c = turned_to<face>(p[2]);
        const Bounds<F> bounds = bounds_of<F>(a, b, c, F(u_.slack));
        const F per(0.5f * float(size_)), one(1.0f);
        const Boxes box{from_column(bounds.left + one, per), to_column(bounds.right + one, per, size_),
                        max(F(float(first_ - begin)), from_column(one - bounds.top, per)),
                        min(F(float(last_ - 1 - begin)), to_column(one - bounds.bottom, per, rows))};
        draws = draws & (box.left <= box.right) & (box.top <= box.bottom);
        if (!any(draws)) return;
        if (!has_planes_) make_planes(p, first_triangle);
        const Mask small = draws & ((box.right - box.left + one) * (box.bottom - box.top + one) <= F(float(most_texels_a_lane)));
        if (any(small)) draw_small<face>(small, box, bounds, load_index(list_.number + first_triangle) << 1);
        if (const unsigned large = bits_of(draws & !small)) draw_large<face>(large, box, bounds, first_triangle);
    }

    PLUMB_INLINE void make_planes(const vec3<F> (&p)[3], int first_triangle) {
        const auto at = [&](int k) { return N::load(list_.plane[k] + first_triangle); };
        planes_ = planes_of<F>(p[0], p[1], p[2], {at(0), at(1), at(2)}, {at(3), at(4), at(5)}, eye_of(eye_));
        inverse_ = F(1.0f) / planes_.volume, has_planes_ = true;
    }

    // A lane walks over the texels of its box.
    template <int face>
    PLUMB_INLINE void draw_small(const Mask& small, const Boxes& box, const Bounds<F>& bounds, const I& twice_number) {
        const F one(1.0f), half(0.5f), texel(u_.texel);
        const vec3<F> e0 = turned_to<face>(planes_.e0), e1 = turned_to<face>(planes_.e1), e2 = turned_to<face>(planes_.e2),
                      normal = turned_to<face>(planes_.normal);
        const I seen = twice_number + select(planes_.volume > F(0.0f), I(0), I(1));
        F x = box.left, y = box.top;
        Mask on = small;
        do {
            const F cx = (x + half) * texel - one, cy = one - (y + half) * texel;
            const F at0 = plane_at<F>(e0, cx, cy), at1 = plane_at<F>(e1, cx, cy), at2 = plane_at<F>(e2, cx, cy);
            const Crossing<F> c = crossing<F>(at0, at1, at2, plane_at<F>(normal, cx, cy), planes_.volume, inverse_);
            const Mask takes = on & c.covered & (bounds.left <= cx) & (cx <= bounds.right) & (bounds.bottom <= cy) & (cy <= bounds.top);
            if (const unsigned lanes = bits_of(takes))
                put(lanes, N::truncate_to_index((y + F(float(first_row(face)))) * F(float(size_)) + x), c.nearness,
                    barycentrics_of<F>(at0, at1, at2), seen);
            x = x + one;
            const Mask next_row = x > box.right;
            x = select(next_row, box.left, x), y = select(next_row, y + one, y);
            on = on & (y <= box.bottom);
        } while (any(on));
    }

    // One after the other: several lanes may be of one texel.
    PLUMB_INLINE void put(unsigned lanes, const I& texel, F nearness, const vec2<F>& barycentrics, const I& seen) {
        alignas(64) Lanes at, what;
        alignas(64) float near[N::width], b1[N::width], b2[N::width];
        std::memcpy(at, &texel, sizeof at), std::memcpy(what, &seen, sizeof what);
        N::save(near, nearness), N::save(b1, barycentrics.x), N::save(b2, barycentrics.y);
        for (; lanes != 0; lanes &= lanes - 1) {
            const int k = __builtin_ctz(lanes), to = at[k];
            if (near[k] < m_.nearness[to] || (near[k] == m_.nearness[to] && m_.seen[to] < what[k])) continue;
            m_.nearness[to] = near[k], m_.seen[to] = what[k], m_.b1[to] = b1[k], m_.b2[to] = b2[k];
        }
    }

    template <int face>
    __attribute__((noinline)) void draw_large(unsigned lanes, const Boxes& box, const Bounds<F>& bounds, int first_triangle) {
        if (!has_saved_) saved_.save(planes_, inverse_), has_saved_ = true;
        const I l = N::truncate_to_index(box.left), r = N::truncate_to_index(box.right), t = N::truncate_to_index(box.top),
                u = N::truncate_to_index(box.bottom);
        alignas(64) Lanes from, to, from_row, to_row;
        alignas(64) float low_x[N::width], high_x[N::width], low_y[N::width], high_y[N::width];
        std::memcpy(from, &l, sizeof from), std::memcpy(to, &r, sizeof to);
        std::memcpy(from_row, &t, sizeof t), std::memcpy(to_row, &u, sizeof u);
        N::save(low_x, bounds.left), N::save(high_x, bounds.right), N::save(low_y, bounds.bottom), N::save(high_y, bounds.top);
        for (; lanes != 0; lanes &= lanes - 1) {
            const int k = __builtin_ctz(lanes);
            draw_rows<face>(k, list_.number[first_triangle + k], {from[k], to[k], from_row[k], to_row[k]}, {low_x[k], high_x[k], low_y[k], high_y[k]});
        }
    }

    struct Box {
        int left, right, top, bottom;  // columns, and rows of the face, inclusive
    };

    template <int face>
    PLUMB_INLINE void draw_rows(int lane, std::int32_t triangle, Box box, const Bounds<float>& bounds) {
        const float volume = saved_.volume[lane];
        if (!(volume != 0)) return;
        const vec3<float> e0 = turned_to<face>(SavedPlanes::lane(saved_.e0, lane)), e1 = turned_to<face>(SavedPlanes::lane(saved_.e1, lane)),
                          e2 = turned_to<face>(SavedPlanes::lane(saved_.e2, lane)), n = turned_to<face>(SavedPlanes::lane(saved_.normal, lane));
        const F inverse(saved_.inverse[lane]), v(volume), low(bounds.left), high(bounds.right);
        const I seen(2 * triangle + (volume > 0 ? 0 : 1));
        const int begin = first_row(face);
        for (int row = box.top; row <= box.bottom; ++row) {
            const float y = 1.0f - (float(row) + 0.5f) * u_.texel;
            if (!(bounds.bottom <= y && y <= bounds.top)) continue;
            const F r0(e0.y * y + e0.z), r1(e1.y * y + e1.z), r2(e2.y * y + e2.z), rn(n.y * y + n.z);
            for (int x = box.left; x <= box.right; x += N::width) {
                const F cx = N::load(m_.centre + x);
                const F at0 = F(e0.x) * cx + r0, at1 = F(e1.x) * cx + r1, at2 = F(e2.x) * cx + r2;
                const Crossing<F> c = crossing<F>(at0, at1, at2, F(n.x) * cx + rn, v, inverse);
                Mask takes = c.covered & (low <= cx) & (cx <= high) & (N::iota(x) <= I(box.right));
                if (!any(takes)) continue;
                const int at = (begin + row) * size_ + x;
                const F before = N::load(m_.nearness + at);
                I was = load_index(m_.seen + at);
                takes = takes & ((c.nearness > before) | ((c.nearness == before) & (seen < was)));
                if (!any(takes)) continue;
                const vec2<F> b = barycentrics_of<F>(at0, at1, at2);
                was = select(takes, seen, was);
                std::memcpy(m_.seen + at, &was, sizeof was);
                N::save(m_.nearness + at, select(takes, c.nearness, before));
                N::save(m_.b1 + at, select(takes, b.x, N::load(m_.b1 + at)));
                N::save(m_.b2 + at, select(takes, b.y, N::load(m_.b2 + at)));
            }
        }
    }

    static constexpr int packets_at_once = 8, most_texels_a_lane = 16;
    const ItemsUniforms& u_;
    const int size_;
    const DrawList list_;
    DrawMemory m_;
    int first_ = 0, last_ = 0;
    const float* eye_ = nullptr;
    bool has_planes_ = false, has_saved_ = false;
    Planes<F> planes_;
    F inverse_;
    SavedPlanes saved_;
};

}  // namespace
}  // namespace plumb::radiosity
