// BoundedPacket: sixteen items of Bounded (core/bounded.h) at once, each with the bits that Bounded has alone.
//
// It is a number type like the others, so every kernel runs over it. Nothing is enumerated: where a comparison or an
// index of an item is undecided, the item is left (PacketScope::left()), and who asked runs the kernel over Bounded for
// it. Operations of core/packet_ops_isa.cpp compute lanes that are plain numbers; the others, and elementary functions,
// go through Bounded lane by lane.
//
// A packet is a handle: copies share what they hold, which nobody changes.
#pragma once

#include <cstddef>
#include <vector>

#include "core/bounded.h"
#include "core/detmath.h"
#include "core/inexact_inputs.h"
#include "core/isa.h"
#include "core/packet_data.h"

namespace plumb {

// What packets of this thread compute with.
struct PacketState {
    const PacketOps* ops = nullptr;
    PacketGrants grants{};
    PacketData* free = nullptr;
    std::uint32_t left = 0;  // a bit an item
};
extern constinit thread_local PacketState packet_state;

// Until the end of the scope, this thread computes with packets: as the precision and the inexact inputs say that are in
// force. All packets end before it.
class PacketScope {
  public:
    explicit PacketScope(Isa isa);
    ~PacketScope();
    PacketScope(const PacketScope&) = delete;
    PacketScope& operator=(const PacketScope&) = delete;

    // Of which items something was undecided, or ambiguous.
    std::uint32_t left() const { return packet_state.left; }

  private:
    PacketState saved_;
    Decisions decisions_;
    DecisionScope scope_;
};

// A bit a lane: what the float kernel has, and what is undecided.
struct PacketMask {
    std::uint32_t value = 0, undecided = 0;

    friend PacketMask operator!(PacketMask a) { return {~a.value & PacketData::all, a.undecided}; }
    friend PacketMask operator&(PacketMask a, PacketMask b) {
        return {a.value & b.value, (a.undecided & (b.value | b.undecided)) | (b.undecided & (a.value | a.undecided))};
    }
    friend PacketMask operator|(PacketMask a, PacketMask b) { return !((!a) & (!b)); }
    // What is undecided matters from here on.
    std::uint32_t resolved() const {
        packet_state.left |= undecided;
        return value;
    }
    friend bool any(PacketMask a) { return a.resolved() != 0; }
};

struct PacketIndex {
    typedef std::int32_t Int __attribute__((vector_size(4 * PacketData::lanes)));
    typedef std::uint32_t UInt __attribute__((vector_size(4 * PacketData::lanes)));
    Int v;
    PacketIndex() = default;
    PacketIndex(Int x) : v(x) {}
    PacketIndex(UInt x) : v((Int)x) {}
    PacketIndex(std::int32_t x) : v(Int{} + x) {}

    // Sums, products and shifts go through unsigned lanes: they wrap.
    friend PacketIndex operator+(PacketIndex a, PacketIndex b) { return UInt(a.v) + UInt(b.v); }
    friend PacketIndex operator-(PacketIndex a, PacketIndex b) { return UInt(a.v) - UInt(b.v); }
    friend PacketIndex operator*(PacketIndex a, PacketIndex b) { return UInt(a.v) * UInt(b.v); }
    friend PacketIndex operator&(PacketIndex a, PacketIndex b) { return a.v & b.v; }
    friend PacketIndex operator|(PacketIndex a, PacketIndex b) { return a.v | b.v; }
    friend PacketIndex operator^(PacketIndex a, PacketIndex b) { return a.v ^ b.v; }
    friend PacketIndex operator~(PacketIndex a) { return ~a.v; }
    friend PacketIndex operator<<(PacketIndex a, int n) { return UInt(a.v) << unsigned(n); }
    friend PacketIndex operator>>(PacketIndex a, int n) { return a.v >> n; }
    friend PacketIndex shift_right(PacketIndex a, int n) { return UInt(a.v) >> unsigned(n); }
    friend PacketIndex operator<<(PacketIndex a, PacketIndex n) { return UInt(a.v) << UInt(n.v); }
    friend PacketIndex shift_right(PacketIndex a, PacketIndex n) { return UInt(a.v) >> UInt(n.v); }
    friend PacketMask operator<(PacketIndex a, PacketIndex b) { return mask(a.v < b.v); }
    friend PacketMask operator>(PacketIndex a, PacketIndex b) { return b < a; }
    friend PacketMask operator<=(PacketIndex a, PacketIndex b) { return !(b < a); }
    friend PacketMask operator>=(PacketIndex a, PacketIndex b) { return !(a < b); }
    friend PacketMask operator==(PacketIndex a, PacketIndex b) { return mask(a.v == b.v); }
    friend PacketMask in_range(PacketIndex i, PacketIndex n) { return mask(UInt(i.v) < UInt(n.v)); }
    friend PacketIndex select(PacketMask m, PacketIndex a, PacketIndex b) {
        const Int bit = {1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384, 32768};
        const Int on = ((Int{} + std::int32_t(m.resolved())) & bit) != 0;
        return (a.v & on) | (b.v & ~on);
    }
    friend PacketIndex min(PacketIndex a, PacketIndex b) { return select(b < a, b, a); }
    friend PacketIndex max(PacketIndex a, PacketIndex b) { return select(a < b, b, a); }

  private:
    static PacketMask mask(Int on) {
        __m128i quarter[4];
        std::memcpy(quarter, &on, sizeof on);
        std::uint32_t bits = 0;
        for (int q = 0; q < 4; ++q) bits |= std::uint32_t(_mm_movemask_ps(_mm_castsi128_ps(quarter[q]))) << 4 * q;
        return {bits, 0};
    }
};

class BoundedPacket {
  public:
    BoundedPacket() = default;  // 0
    BoundedPacket(float x);
    explicit BoundedPacket(const Bounded& x);
    explicit BoundedPacket(double x) : BoundedPacket(Bounded(x)) {}
    explicit BoundedPacket(int x) : BoundedPacket(Bounded(x)) {}
    explicit BoundedPacket(PacketIndex i);
    // Takes what its maker has counted.
    explicit BoundedPacket(PacketData* data) : data_(data) {}

    BoundedPacket(const BoundedPacket& o) : data_(o.data_) {
        if (data_) ++data_->users;
    }
    BoundedPacket(BoundedPacket&& o) noexcept : data_(o.data_) { o.data_ = nullptr; }
    BoundedPacket& operator=(BoundedPacket o) noexcept {
        PacketData* const mine = data_;
        data_ = o.data_, o.data_ = mine;
        return *this;
    }
    ~BoundedPacket() {
        if (data_ && --data_->users == 0) data_->next = packet_state.free, packet_state.free = data_;
    }

    const PacketData& operator*() const { return data_ ? *data_ : zero; }
    const PacketData* operator->() const { return &**this; }

    friend BoundedPacket operator+(const BoundedPacket& a, const BoundedPacket& b);
    friend BoundedPacket operator-(const BoundedPacket& a, const BoundedPacket& b);
    friend BoundedPacket operator*(const BoundedPacket& a, const BoundedPacket& b);
    friend BoundedPacket operator/(const BoundedPacket& a, const BoundedPacket& b);
    friend BoundedPacket operator-(const BoundedPacket& a);
    BoundedPacket& operator+=(const BoundedPacket& b) { return *this = *this + b; }
    BoundedPacket& operator-=(const BoundedPacket& b) { return *this = *this - b; }
    BoundedPacket& operator*=(const BoundedPacket& b) { return *this = *this * b; }
    BoundedPacket& operator/=(const BoundedPacket& b) { return *this = *this / b; }

    friend PacketMask operator<(const BoundedPacket& a, const BoundedPacket& b);
    friend PacketMask operator<=(const BoundedPacket& a, const BoundedPacket& b);
    friend PacketMask operator>(const BoundedPacket& a, const BoundedPacket& b) { return b < a; }
    friend PacketMask operator>=(const BoundedPacket& a, const BoundedPacket& b) { return b <= a; }
    friend PacketMask operator==(const BoundedPacket& a, const BoundedPacket& b);

    friend BoundedPacket min(const BoundedPacket& a, const BoundedPacket& b);
    friend BoundedPacket max(const BoundedPacket& a, const BoundedPacket& b);
    friend BoundedPacket clamp(const BoundedPacket& x, const BoundedPacket& low, const BoundedPacket& high);
    friend BoundedPacket abs(const BoundedPacket& a);
    friend BoundedPacket sqrt(const BoundedPacket& a);
    friend BoundedPacket floor(const BoundedPacket& a);
    friend BoundedPacket select(PacketMask m, const BoundedPacket& a, const BoundedPacket& b);
    friend PacketIndex chosen(const BoundedPacket& x);

    // One item alone.
    static Bounded lane(const PacketData& a, int i) {
        Bounded x;
        x.value = a.value[i], x.shadow = a.exact ? a.value[i] : a.shadow[i];
        if (a.exact) return x;
        x.bound = a.bound[i], x.additions = std::uint16_t(a.additions[i]), x.blend = a.blend >> i & 1;
        if (x.additions) x.magnitude = a.terms[i];
        return x;
    }

  private:
    static const PacketData zero;
    PacketData* data_ = nullptr;
};

template <>
struct number<BoundedPacket> {
    using F = BoundedPacket;
    using mask = PacketMask;
    using index = PacketIndex;
    static constexpr int width = PacketData::lanes;

    static index iota(int first) {
        return index::Int{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15} + first;
    }
    static F from_index(index i) { return F(i); }
    static index round_to_index(const F& x);
    static index truncate_to_index(const F& x);
    static index bits(const F& x);
    static F from_bits(index i);
    static F fetch(const float* p, index i);
    static index fetch(const std::int32_t* p, index i) {
        for (int k = 0; k < width; ++k) i.v[k] = p[i.v[k]];
        return i;
    }
    template <class Component>
    static vec4<F> fetch4(const Component* p, index i) {
        return texel(p, i);
    }
    template <class Component>
    static Record<F> fetch_record(const Component* p, index i) {
        return record(p, i);
    }

  private:
    static vec4<F> texel(const float* p, index i);
    static vec4<F> texel(const Half* p, index i);
    static Record<F> record(const float* p, index i);
    static Record<F> record(const Half* p, index i);
};

// The elementary functions, each lane by core/detmath_bounded.h.
namespace detmath {
template <>
BoundedPacket exp(BoundedPacket x);
template <>
BoundedPacket exp2(BoundedPacket x);
template <>
BoundedPacket expm1(BoundedPacket x);
template <>
BoundedPacket log(BoundedPacket x);
template <>
BoundedPacket log2(BoundedPacket x);
template <>
BoundedPacket sin(BoundedPacket x);
template <>
BoundedPacket cos(BoundedPacket x);
template <>
BoundedPacket acos(BoundedPacket x);
template <>
BoundedPacket pow(BoundedPacket x, BoundedPacket y);
}  // namespace detmath

}  // namespace plumb

template <>
struct std::numeric_limits<plumb::BoundedPacket> {
    static constexpr bool is_specialized = true, is_iec559 = true, is_signed = true, is_integer = false;
};
