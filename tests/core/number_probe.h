// Every function of the number layer over arrays, compiled for every instruction set. A row is the results of one
// function: element i of it belongs to element i of the inputs.
#pragma once

#include "core/isa.h"
#include "core/number.h"

namespace plumb {

struct ProbeInput {
    int count;                  // a multiple of 16
    const float *a, *b, *c;     // `count` each
    const std::int32_t* at;     // a permutation of 0 .. count - 1
    const float* texels;        // 65536 components: 16384 texels or 4096 records
    const Half* half_texels;    // the same
    int active;                 // elements from here on are not stored
};

enum RealRow {
    row_add, row_subtract, row_multiply, row_divide, row_negate, row_assign, row_min, row_max, row_abs, row_sqrt,
    row_floor, row_clamp, row_select, row_dot3, row_normalize3, row_from_index, row_from_bits, row_fetch, row_stored,
    row_fused, row_texel, row_record = row_texel + 4, row_half_texel = row_record + 12,
    row_half_record = row_half_texel + 4, row_stored4 = row_half_record + 12, row_stored4_whole = row_stored4 + 4,
    real_rows = row_stored4_whole + 4,
};
enum IntegerRow {
    row_round, row_truncate, row_bits, row_less, row_less_equal, row_greater, row_greater_equal, row_equal, row_and,
    row_or, row_not, row_any, row_iota, row_int_add, row_int_subtract, row_int_multiply, row_int_and, row_int_or,
    row_int_xor, row_int_not, row_shift_left, row_shift_right, row_shift_right_logical, row_shift_left_by_lane,
    row_shift_right_by_lane, row_int_less, row_int_greater, row_int_less_equal, row_int_greater_equal, row_int_equal,
    row_int_select, row_int_min, row_int_max, row_int_fetch, integer_rows,
};

// Row r is at r * count. The four rows of row_stored4, and of row_stored4_whole, whose lanes are all active, hold texels instead:
// element i at 4 i.
struct ProbeOutput {
    float* reals;
    std::int32_t* integers;
};

template <Isa isa>
void number_probe(const ProbeInput& in, ProbeOutput& out);

template <>
void number_probe<Isa::scalar>(const ProbeInput&, ProbeOutput&);
template <>
void number_probe<Isa::sse>(const ProbeInput&, ProbeOutput&);
template <>
void number_probe<Isa::avx2>(const ProbeInput&, ProbeOutput&);
template <>
void number_probe<Isa::avx512>(const ProbeInput&, ProbeOutput&);

}  // namespace plumb
