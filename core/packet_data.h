// Sixteen lanes of Bounded (core/bounded.h) as they lie in memory, and the operations on them that
// core/packet_ops_isa.cpp defines once per instruction set. Kernel files include it: no container, no function.
#pragma once

#include <cstdint>

#include "core/isa_name.h"
#include "core/number.h"

namespace plumb {

struct alignas(64) PacketData {
    static constexpr int lanes = 16;
    static constexpr std::uint32_t all = 0xffff;

    float value[lanes];
    // Written unless `exact`. terms is Bounded::terms(), additions what it counts.
    double shadow[lanes], bound[lanes], terms[lanes], additions[lanes];
    // A bit a lane:
    std::uint32_t sums = 0;   // additions > 0
    std::uint32_t blend = 0;  // Bounded::blend
    std::uint32_t odd = 0;    // not plain: infinite, NaN or a denormal shadow, or a bound beyond the floats
    bool exact = false;       // in every lane the shadow is the value, and bound, additions and blend are 0
    std::int32_t users = 1;
    PacketData* next = nullptr;  // of those that are free
};

// What BoundedState grants.
struct PacketGrants {
    double add, multiply, divide, sqrt, flushed, underflow;
};

// Each computes all lanes as Bounded does where they are plain, bit for bit, and returns those of its result that the
// scalar operation has to compute instead.
struct PacketOps {
    using Lanes = std::uint32_t;
    using Unary = Lanes (*)(const PacketData& a, const PacketGrants& grants, PacketData& r);
    using Binary = Lanes (*)(const PacketData& a, const PacketData& b, const PacketGrants& grants, PacketData& r);
    Binary add, subtract, multiply, divide, min, max;
    Unary sqrt;
    Lanes (*clamp)(const PacketData& x, const PacketData& low, const PacketData& high, PacketData& r);

    // Nothing of these is left to do. negate() and abs() keep the form of their operand.
    void (*negate)(const PacketData& a, PacketData& r);
    void (*abs)(const PacketData& a, PacketData& r);
    void (*blend)(Lanes mask, const PacketData& a, const PacketData& b, PacketData& r);

    // As the float has it, of every lane; in the upper 16 bits those that are undecided. Of plain lanes alone.
    Lanes (*less)(const PacketData& a, const PacketData& b);
    Lanes (*less_equal)(const PacketData& a, const PacketData& b);

    // What is exact: one number for all lanes; of lane i the number p[at[i]], the texel of four, the record of twelve.
    void (*splat)(float x, PacketData& r);
    void (*number)(const float* p, const std::int32_t* at, PacketData& r);
    void (*texel)(const float* p, const std::int32_t* at, PacketData* const* four);
    void (*half_texel)(const Half* p, const std::int32_t* at, PacketData* const* four);
    void (*record)(const float* p, const std::int32_t* at, PacketData* const* twelve);
    void (*half_record)(const Half* p, const std::int32_t* at, PacketData* const* twelve);
};

template <Isa isa>
struct PacketOpsOf {
    static const PacketOps ops;
};

}  // namespace plumb
