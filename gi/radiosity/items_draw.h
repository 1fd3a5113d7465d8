// One hemicube drawn triangle by triangle: what items_kernel.h asks of every texel and triangle, to the bit, in the order
// that a processor likes. Only kernel files include it, after core/wide.h.
//
// Vertices are turned into the hemicube's axes once for all five faces. A packet of triangles is held against each face; what
// reaches none of its texels' centres, by the same comparisons as the kernel's, goes no further: of 30,000 triangles over
// 12,288 texels that is most. What is left is drawn row by row.
#pragma once

#include "core/wide.h"
#include "gi/radiosity/items_kernel.h"

namespace plumb::radiosity {
namespace {

using F = PLUMB_ISA::Real;
using N = number<F>;
using I = index_t<F>;
using Lanes = std::int32_t[N::width];

// Lane k of vectors that were saved.
struct SavedPlanes {
    alignas(64) float e0[3][N::width], e1[3][N::width], e2[3][N::width], normal[3][N::width];
    alignas(64) float volume[N::width], inverse[N::width];

    static void save(float (&to)[3][N::width], const vec3<F>& v) { N::save(to[0], v.x), N::save(to[1], v.y), N::save(to[2], v.z); }
    static vec3<float> lane(const float (&of)[3][N::width], int k) { return {of[0][k], of[1][k], of[2][k]}; }

    void save(const Planes<F>& p) {
        save(e0, p.e0), save(e1, p.e1), save(e2, p.e2), save(normal, p.normal);
        N::save(volume, p.volume), N::save(inverse, F(1.0f) / p.volume);
    }
};

class Drawing {
  public:
    Drawing(const ItemsView& in, float* memory) : in_(in), size_(in.u.width), m_(memory, in.u.vertices, in.u.width) {
        for (int i = 0; i < size_; i += N::width)
            N::save(m_.centre + i, (N::from_index(N::iota(i)) + F(0.5f)) * F(in.u.texel) - F(1.0f));
    }

    // Rows [first, last) of the hemicube with that eye, [4][4].
    void draw(const float* eye, int first, int last) {
        first_ = first, last_ = last;
        turn_vertices(eye);
        for (int at = first * size_; at < last * size_; at += N::width)
            N::save(m_.nearness + at, F(0.0f)), std::memcpy(m_.triangle + at, &nothing_, sizeof nothing_);
        for (int i = 0; i < in_.u.triangles; i += N::width) draw_packet(i);
    }

    // Of the texels of row `row` from column x on: what they see.
    Item<F> resolve(int row, int x) const {
        const int at = row * size_ + x;
        Item<F> item;
        std::memcpy(&item.triangle, m_.triangle + at, sizeof item.triangle);
        const mask_t<F> some = I(-1) < item.triangle;
        const F zero(0.0f);
        if (!any(some)) return {item.triangle, {zero, zero, zero, zero}};
        const I corner = max(item.triangle, I(0)) * I(4);
        const Planes<F> s = planes_of<F>(corner_at(corner), corner_at(corner + I(1)), corner_at(corner + I(2)));
        const I face(face_of(row));
        const F cx = N::load(m_.centre + x), cy = F(row_centre(row));
        const vec2<F> b = barycentrics_of<F>(plane_at<F>(turned<F>(s.e0, face), cx, cy), plane_at<F>(turned<F>(s.e1, face), cx, cy),
                                             plane_at<F>(turned<F>(s.e2, face), cx, cy));
        item.seen = {select(some, b.x, zero), select(some, b.y, zero), N::load(m_.nearness + at),
                     select(some, select(s.volume > zero, F(1.0f), F(-1.0f)), zero)};
        return item;
    }

    const std::int32_t* triangles() const { return m_.triangle; }

  private:
    int face_of(int row) const { return row < size_ ? 0 : 1 + (row - size_) / (size_ / 2); }
    int first_row(int face) const { return face == 0 ? 0 : size_ + (face - 1) * (size_ / 2); }
    int rows_of(int face) const { return face == 0 ? size_ : size_ / 2; }
    float row_centre(int row) const {
        return 1.0f - (float(row - first_row(face_of(row))) + 0.5f) * in_.u.texel;
    }
    vec3<F> corner_at(const I& corner) const {
        const I v = N::fetch(in_.triangles, corner);
        return {N::fetch(m_.x, v), N::fetch(m_.y, v), N::fetch(m_.z, v)};
    }

    void turn_vertices(const float* e) {
        const Eye<F> eye{{F(e[0]), F(e[1]), F(e[2])}, {F(e[4]), F(e[5]), F(e[6])}, {F(e[8]), F(e[9]), F(e[10])}, {F(e[12]), F(e[13]), F(e[14])}};
        for (int i = 0; i < in_.u.vertices; i += N::width) {
            const vec3<F> p = eye.local(xyz<F>(N::fetch4(in_.vertices, min(N::iota(i), I(in_.u.vertices - 1)))));
            N::save(m_.x + i, p.x), N::save(m_.y + i, p.y), N::save(m_.z + i, p.z);
        }
    }

    // Triangles [i, i + width).
    void draw_packet(int i) {
        const I triangle = min(N::iota(i), I(in_.u.triangles - 1)), corner = triangle * I(4);
        I v[3];
        mask_t<F> exists = N::iota(i) < I(in_.u.triangles);
        for (int k = 0; k < 3; ++k) {
            v[k] = N::fetch(in_.triangles, corner + I(k));
            exists = exists & in_range(v[k], I(in_.u.vertices));
        }
        vec3<F> p[3];
        for (int k = 0; k < 3; ++k) {
            v[k] = select(exists, v[k], I(0));
            p[k].z = N::fetch(m_.z, v[k]);
        }
        const F zero(0.0f);
        const mask_t<F> above = exists & ((p[0].z > zero) | (p[1].z > zero) | (p[2].z > zero));
        if (!any(above)) return;
        for (int k = 0; k < 3; ++k) p[k].x = N::fetch(m_.x, v[k]), p[k].y = N::fetch(m_.y, v[k]);
        saved_ = false;
        draw_on_face<0>(p, above, i), draw_on_face<1>(p, above, i), draw_on_face<2>(p, above, i);
        draw_on_face<3>(p, above, i), draw_on_face<4>(p, above, i);
    }

    // Turns with a face that the compiler knows.
    template <int face, class G>
    static PLUMB_INLINE vec3<G> turned_to(const vec3<G>& p) {
        if constexpr (face == 0) return {-p.y, p.x, p.z};
        if constexpr (face == 1) return {p.y, p.z, p.x};
        if constexpr (face == 2) return {-p.y, p.z, -p.x};
        if constexpr (face == 3) return {-p.x, p.z, p.y};
        if constexpr (face == 4) return {p.x, p.z, -p.y};
    }

    // The texels from, to which centres lie within [low, high], a thousandth of a texel more: whatever rounding makes of it.
    static PLUMB_INLINE F from_column(F low, F per) { return max(F(0.0f), -floor(-(low * per - F(0.501f)))); }
    static PLUMB_INLINE F to_column(F high, F per, int count) { return min(F(float(count - 1)), floor(high * per - F(0.499f))); }

    template <int face>
    void draw_on_face(const vec3<F> (&p)[3], const mask_t<F>& above, int first_triangle) {
        const int begin = first_row(face), rows = rows_of(face);
        if (begin >= last_ || begin + rows <= first_) return;
        const vec3<F> a = turned_to<face>(p[0]), b = turned_to<face>(p[1]), c = turned_to<face>(p[2]);
        mask_t<F> draws = reaches<F>(a, b, c, above);
        if (!any(draws)) return;
        const Bounds<F> bounds = bounds_of<F>(a, b, c, F(in_.u.slack));
        const F per(0.5f * float(size_)), one(1.0f);
        const F left = from_column(bounds.left + one, per), right = to_column(bounds.right + one, per, size_);
        const F top = from_column(one - bounds.top, per), bottom = to_column(one - bounds.bottom, per, rows);
        draws = draws & (left <= right) & (top <= bottom);
        if (!any(draws)) return;
        if (!saved_) planes_.save(planes_of<F>(p[0], p[1], p[2])), saved_ = true;
        alignas(64) Lanes on, from, to, from_row, to_row;
        alignas(64) float low_x[N::width], high_x[N::width], low_y[N::width], high_y[N::width];
        const I lanes = select(draws, I(-1), I(0)), l = N::truncate_to_index(left), r = N::truncate_to_index(right),
                t = N::truncate_to_index(top), u = N::truncate_to_index(bottom);
        std::memcpy(on, &lanes, sizeof on), std::memcpy(from, &l, sizeof from), std::memcpy(to, &r, sizeof to);
        std::memcpy(from_row, &t, sizeof t), std::memcpy(to_row, &u, sizeof u);
        N::save(low_x, bounds.left), N::save(high_x, bounds.right), N::save(low_y, bounds.bottom), N::save(high_y, bounds.top);
        for (int k = 0; k < N::width; ++k)
            if (on[k])
                draw_triangle<face>(k, first_triangle + k, {from[k], to[k], from_row[k] + begin, to_row[k] + begin},
                                    {low_x[k], high_x[k], low_y[k], high_y[k]});
    }

    struct Box {
        int left, right, top, bottom;  // columns and rows of the hemicube, inclusive
    };

    template <int face>
    void draw_triangle(int lane, int triangle, Box box, const Bounds<float>& bounds) {
        const vec3<float> e0 = turned_to<face>(SavedPlanes::lane(planes_.e0, lane)), e1 = turned_to<face>(SavedPlanes::lane(planes_.e1, lane)),
                          e2 = turned_to<face>(SavedPlanes::lane(planes_.e2, lane)), n = turned_to<face>(SavedPlanes::lane(planes_.normal, lane));
        const float volume = planes_.volume[lane];
        if (!(volume != 0)) return;
        const F inverse(planes_.inverse[lane]), v(volume), low(bounds.left), high(bounds.right);
        for (int row = box.top < first_ ? first_ : box.top; row <= box.bottom && row < last_; ++row) {
            const float y = row_centre(row);
            if (!(bounds.bottom <= y && y <= bounds.top)) continue;
            const F r0(e0.y * y + e0.z), r1(e1.y * y + e1.z), r2(e2.y * y + e2.z), rn(n.y * y + n.z);
            for (int x = box.left; x <= box.right; x += N::width) {
                const F cx = N::load(m_.centre + x);
                const Crossing<F> c = crossing<F>(F(e0.x) * cx + r0, F(e1.x) * cx + r1, F(e2.x) * cx + r2, F(n.x) * cx + rn, v, inverse);
                const int at = row * size_ + x;
                const F before = N::load(m_.nearness + at);
                const mask_t<F> takes = c.covered & (low <= cx) & (cx <= high) & (c.nearness > before) & (N::iota(x) <= I(box.right));
                if (!any(takes)) continue;
                N::save(m_.nearness + at, select(takes, c.nearness, before));
                I id;
                std::memcpy(&id, m_.triangle + at, sizeof id);
                id = select(takes, I(triangle), id);
                std::memcpy(m_.triangle + at, &id, sizeof id);
            }
        }
    }

    const ItemsView& in_;
    const int size_;
    DrawMemory m_;
    const I nothing_ = I(-1);
    int first_ = 0, last_ = 0;
    bool saved_ = false;
    SavedPlanes planes_;
};

}  // namespace
}  // namespace plumb::radiosity
