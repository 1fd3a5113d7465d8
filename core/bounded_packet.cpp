#include "core/bounded_packet.h"

#include <memory>

namespace plumb {

// Defined once per instruction set, in packet_ops_isa.cpp.
template <>
const PacketOps PacketOpsOf<Isa::scalar>::ops;
template <>
const PacketOps PacketOpsOf<Isa::sse>::ops;
template <>
const PacketOps PacketOpsOf<Isa::avx2>::ops;
template <>
const PacketOps PacketOpsOf<Isa::avx512>::ops;

constinit thread_local PacketState packet_state;
const PacketData BoundedPacket::zero = [] {
    PacketData d{};
    d.exact = true;
    return d;
}();

namespace {

constexpr int lanes = PacketData::lanes;

// Packets of a thread; as many as its kernels hold at once.
thread_local std::vector<std::unique_ptr<PacketData[]>> slabs;

[[gnu::noinline]] void add_slab() {
    constexpr int more = 64;
    slabs.push_back(std::make_unique<PacketData[]>(more));
    for (int i = 0; i < more; ++i) slabs.back()[i].next = packet_state.free, packet_state.free = &slabs.back()[i];
}

PLUMB_INLINE PacketData* take() {
    PacketState& s = packet_state;
    if (!s.free) [[unlikely]]
        add_slab();
    PacketData* const taken = s.free;
    s.free = taken->next, taken->users = 1;
    return taken;
}

bool plain(const Bounded& x) {
    const double magnitude = abs(x.shadow);
    return magnitude + x.bound <= 0x1.fffffep127 && (magnitude == 0 || magnitude >= 0x1p-126);
}

// Of a packet that is not of the exact form.
void put(PacketData& r, int i, const Bounded& x) {
    const std::uint32_t bit = 1u << i;
    r.value[i] = x.value, r.shadow[i] = x.shadow, r.bound[i] = x.bound;
    r.terms[i] = x.terms(), r.additions[i] = x.additions;
    r.sums = x.additions > 0 ? r.sums | bit : r.sums & ~bit;
    r.blend = x.blend ? r.blend | bit : r.blend & ~bit;
    r.odd = plain(x) ? r.odd & ~bit : r.odd | bit;
    if (x.ambiguous) packet_state.left |= bit;
}

// Runs of(lane) for some of the lanes. Where it meets a decision, the item is left.
template <class Of>
void each_lane(std::uint32_t which, Of of) {
    Decisions& decisions = *bounded_state.decisions;
    for (int i = 0; i < lanes; ++i) {
        if (!(which >> i & 1)) continue;
        decisions.begin();
        of(i);
        if (decisions.met() > 0 || decisions.ambiguous) packet_state.left |= 1u << i;
    }
}

template <class Of>
BoundedPacket by_lanes(Of of) {
    PacketData* const r = take();
    r->sums = r->blend = r->odd = 0, r->exact = false;
    each_lane(PacketData::all, [&](int i) { put(*r, i, of(i)); });
    return BoundedPacket(r);
}

// The lanes that an operation leaves over, one by one.
template <class Of>
BoundedPacket mended(PacketData* r, std::uint32_t over, Of of) {
    r->odd = 0;
    if (over) each_lane(over, [&](int i) { put(*r, i, of(i)); });
    return BoundedPacket(r);
}
template <class Of>
BoundedPacket binary(PacketOps::Binary op, const PacketData& a, const PacketData& b, Of of) {
    PacketData* const r = take();
    return mended(r, op(a, b, packet_state.grants, *r),
                  [&](int i) { return of(BoundedPacket::lane(a, i), BoundedPacket::lane(b, i)); });
}

template <class Of>
PacketMask compared(std::uint32_t found, std::uint32_t over, const PacketData& a, const PacketData& b, Of of) {
    PacketMask r{found & PacketData::all & ~over, found >> 16 & ~over};
    if (over) {
        each_lane(over, [&](int i) {
            const BoundedMask m = of(BoundedPacket::lane(a, i), BoundedPacket::lane(b, i));
            r.value |= std::uint32_t(m.value) << i, r.undecided |= std::uint32_t(m.slot != 0) << i;
        });
    }
    return r;
}

template <class Of>
PacketIndex index_of(const PacketData& a, Of of) {
    PacketIndex r;
    each_lane(PacketData::all, [&](int i) { r.v[i] = of(BoundedPacket::lane(a, i)); });
    return r;
}

template <int count>
struct Several {
    PacketData* data[count];
    Several() {
        for (PacketData*& d : data) d = take();
    }
    vec4<BoundedPacket> four(int first) const {
        return {BoundedPacket(data[first]), BoundedPacket(data[first + 1]), BoundedPacket(data[first + 2]),
                BoundedPacket(data[first + 3])};
    }
};

const std::int32_t* words(const PacketIndex& i) { return reinterpret_cast<const std::int32_t*>(&i.v); }

vec4<BoundedPacket> inexact_texel(const float* p, const PacketIndex& i, int stride) {
    vec4<BoundedPacket> r;
    for (int c = 0; c < 4; ++c)
        r[c] = by_lanes([&](int k) { return read_inexact(p + stride * std::ptrdiff_t(i.v[k]) + c); });
    return r;
}

}  // namespace

PacketScope::PacketScope(Isa isa) : saved_(packet_state), scope_(decisions_) {
    const BoundedState& s = bounded_state;
    PacketState& mine = packet_state;
    dispatch(isa, [&](auto of) { mine.ops = &PacketOpsOf<of()>::ops; });
    mine.grants = {s.add, s.multiply, s.divide, s.sqrt, s.flushed, s.underflow};
    mine.left = 0;
}
PacketScope::~PacketScope() {
    PacketData* const free = packet_state.free;
    packet_state = saved_;
    packet_state.free = free;
}

BoundedPacket::BoundedPacket(float x) : data_(take()) { packet_state.ops->splat(x, *data_); }
BoundedPacket::BoundedPacket(const Bounded& x) : BoundedPacket(by_lanes([&](int) { return x; })) {}
BoundedPacket::BoundedPacket(PacketIndex i) : BoundedPacket(by_lanes([&](int k) { return Bounded(i.v[k]); })) {}

BoundedPacket operator+(const BoundedPacket& a, const BoundedPacket& b) {
    return binary(packet_state.ops->add, *a, *b, [](const Bounded& x, const Bounded& y) { return x + y; });
}
BoundedPacket operator-(const BoundedPacket& a, const BoundedPacket& b) {
    return binary(packet_state.ops->subtract, *a, *b, [](const Bounded& x, const Bounded& y) { return x - y; });
}
BoundedPacket operator*(const BoundedPacket& a, const BoundedPacket& b) {
    return binary(packet_state.ops->multiply, *a, *b, [](const Bounded& x, const Bounded& y) { return x * y; });
}
BoundedPacket operator/(const BoundedPacket& a, const BoundedPacket& b) {
    return binary(packet_state.ops->divide, *a, *b, [](const Bounded& x, const Bounded& y) { return x / y; });
}
BoundedPacket operator-(const BoundedPacket& a) {
    PacketData* const r = take();
    packet_state.ops->negate(*a, *r);
    return BoundedPacket(r);
}

PacketMask operator<(const BoundedPacket& a, const BoundedPacket& b) {
    return compared(packet_state.ops->less(*a, *b), a->odd | b->odd, *a, *b,
                    [](const Bounded& x, const Bounded& y) { return x < y; });
}
PacketMask operator<=(const BoundedPacket& a, const BoundedPacket& b) {
    return compared(packet_state.ops->less_equal(*a, *b), a->odd | b->odd, *a, *b,
                    [](const Bounded& x, const Bounded& y) { return x <= y; });
}
PacketMask operator==(const BoundedPacket& a, const BoundedPacket& b) {
    return compared(0, PacketData::all, *a, *b, [](const Bounded& x, const Bounded& y) { return x == y; });
}

BoundedPacket min(const BoundedPacket& a, const BoundedPacket& b) {
    return binary(packet_state.ops->min, *a, *b, [](const Bounded& x, const Bounded& y) { return min(x, y); });
}
BoundedPacket max(const BoundedPacket& a, const BoundedPacket& b) {
    return binary(packet_state.ops->max, *a, *b, [](const Bounded& x, const Bounded& y) { return max(x, y); });
}
BoundedPacket clamp(const BoundedPacket& x, const BoundedPacket& low, const BoundedPacket& high) {
    PacketData* const r = take();
    return mended(r, packet_state.ops->clamp(*x, *low, *high, *r), [&](int i) {
        return clamp(BoundedPacket::lane(*x, i), BoundedPacket::lane(*low, i), BoundedPacket::lane(*high, i));
    });
}
BoundedPacket abs(const BoundedPacket& a) {
    PacketData* const r = take();
    packet_state.ops->abs(*a, *r);
    return BoundedPacket(r);
}
BoundedPacket sqrt(const BoundedPacket& a) {
    PacketData* const r = take();
    return mended(r, packet_state.ops->sqrt(*a, packet_state.grants, *r),
                  [&](int i) { return sqrt(BoundedPacket::lane(*a, i)); });
}
BoundedPacket floor(const BoundedPacket& a) {
    return by_lanes([&](int i) { return floor(BoundedPacket::lane(*a, i)); });
}
BoundedPacket select(PacketMask m, const BoundedPacket& a, const BoundedPacket& b) {
    const std::uint32_t mask = m.resolved();
    if (mask == PacketData::all) return a;
    if (mask == 0) return b;
    PacketData* const r = take();
    packet_state.ops->blend(mask, *a, *b, *r);
    return BoundedPacket(r);
}
PacketIndex chosen(const BoundedPacket& x) {
    return index_of(*x, [](const Bounded& lane) { return chosen(lane); });
}

PacketIndex number<BoundedPacket>::round_to_index(const F& x) {
    return index_of(*x, [](const Bounded& lane) { return number<Bounded>::round_to_index(lane); });
}
PacketIndex number<BoundedPacket>::truncate_to_index(const F& x) {
    return index_of(*x, [](const Bounded& lane) { return number<Bounded>::truncate_to_index(lane); });
}
PacketIndex number<BoundedPacket>::bits(const F& x) {
    return index_of(*x, [](const Bounded& lane) { return number<Bounded>::bits(lane); });
}
BoundedPacket number<BoundedPacket>::from_bits(index i) {
    return by_lanes([&](int k) { return number<Bounded>::from_bits(i.v[k]); });
}
BoundedPacket number<BoundedPacket>::fetch(const float* p, index i) {
    if (!inexact_ranges.empty()) return by_lanes([&](int k) { return read_inexact(p + i.v[k]); });
    PacketData* const r = take();
    packet_state.ops->number(p, words(i), *r);
    return F(r);
}
vec4<BoundedPacket> number<BoundedPacket>::texel(const float* p, index i) {
    if (!inexact_ranges.empty()) return inexact_texel(p, i, 4);
    const Several<4> r;
    packet_state.ops->texel(p, words(i), r.data);
    return r.four(0);
}
vec4<BoundedPacket> number<BoundedPacket>::texel(const Half* p, index i) {
    const Several<4> r;
    packet_state.ops->half_texel(p, words(i), r.data);
    return r.four(0);
}
Record<BoundedPacket> number<BoundedPacket>::record(const float* p, index i) {
    if (!inexact_ranges.empty())
        return {inexact_texel(p, i, record_stride), inexact_texel(p + 4, i, record_stride),
                inexact_texel(p + 8, i, record_stride)};
    const Several<12> r;
    packet_state.ops->record(p, words(i), r.data);
    return {r.four(0), r.four(4), r.four(8)};
}
Record<BoundedPacket> number<BoundedPacket>::record(const Half* p, index i) {
    const Several<12> r;
    packet_state.ops->half_record(p, words(i), r.data);
    return {r.four(0), r.four(4), r.four(8)};
}

namespace detmath {
#define PLUMB_BY_LANES(f)                                                              \
    template <>                                                                        \
    BoundedPacket f(BoundedPacket x) {                                                 \
        return by_lanes([&](int i) { return detmath::f(BoundedPacket::lane(*x, i)); }); \
    }
PLUMB_BY_LANES(exp)
PLUMB_BY_LANES(exp2)
PLUMB_BY_LANES(expm1)
PLUMB_BY_LANES(log)
PLUMB_BY_LANES(log2)
PLUMB_BY_LANES(sin)
PLUMB_BY_LANES(cos)
PLUMB_BY_LANES(acos)
#undef PLUMB_BY_LANES
template <>
BoundedPacket pow(BoundedPacket x, BoundedPacket y) {
    return by_lanes([&](int i) { return detmath::pow(BoundedPacket::lane(*x, i), BoundedPacket::lane(*y, i)); });
}
}  // namespace detmath

}  // namespace plumb
