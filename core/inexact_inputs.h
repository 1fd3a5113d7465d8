// Inputs that a device does not read as they are but makes first: a normal that it unpacks and renormalises, a position
// out of its depth. What it makes lies within a bound of what we hold, and Bounded reads it so.
//
//     StageData::inputs holds "normal", and beside it "normal.moved": how far each number of "normal" may be elsewhere
//
// Read so is what a kernel fetches: texels, records, and numbers alone. What it reads of an array by itself is exact.
// Who computes a kernel with Bounded includes this: it specialises what core/bounded.h has for exact inputs.
#pragma once

#include <functional>
#include <span>
#include <string>

#include "core/bounded.h"

namespace plumb {

// The array beside an input that says how far its numbers may be elsewhere: f32, of the input's shape.
inline std::string moved_name(const std::string& input) { return input + ".moved"; }

// `count` numbers from `first` on, each within its `moved`.
struct InexactRange {
    const float* first;
    const float* moved;
    std::ptrdiff_t count;
};
inline constinit thread_local std::span<const InexactRange> inexact_ranges;

// Until the end of the scope, what this thread reads of those ranges is inexact.
class InexactScope {
  public:
    explicit InexactScope(std::span<const InexactRange> ranges) : saved_(inexact_ranges) { inexact_ranges = ranges; }
    ~InexactScope() { inexact_ranges = saved_; }
    InexactScope(const InexactScope&) = delete;
    InexactScope& operator=(const InexactScope&) = delete;

  private:
    std::span<const InexactRange> saved_;
};

// The number at p.
inline Bounded read_inexact(const float* p) {
    const std::less<const float*> before;
    for (const InexactRange& r : inexact_ranges)
        if (!before(p, r.first) && before(p, r.first + r.count)) return Bounded::within(*p, *p, r.moved[p - r.first]);
    return Bounded(*p);
}

template <>
inline Bounded number<Bounded>::fetch<float>(const float* p, index i) {
    return read_inexact(p + i);
}
template <>
inline vec4<Bounded> number<Bounded>::fetch4<float>(const float* p, index i) {
    p += 4 * std::ptrdiff_t(i);
    return {read_inexact(p), read_inexact(p + 1), read_inexact(p + 2), read_inexact(p + 3)};
}
template <>
inline Record<Bounded> number<Bounded>::fetch_record<float>(const float* p, index i) {
    p += record_stride * std::ptrdiff_t(i);
    return {fetch4(p, 0), fetch4(p, 1), fetch4(p, 2)};
}

}  // namespace plumb
