// core/detmath.h for Followed: the value as float has it, beside it the function in double. Part of core/detmath.h.
// What our functions decide inside (how an argument is split) is theirs alone: nothing of it is recorded.
#pragma once

#include "core/detmath.h"
#include "core/followed.h"

namespace plumb::detmath {

PLUMB_INLINE Followed exp(const Followed& x) { return {exp(x.value), host::exp(x.exact)}; }
PLUMB_INLINE Followed exp2(const Followed& x) { return {exp2(x.value), host::exp2(x.exact)}; }
PLUMB_INLINE Followed expm1(const Followed& x) { return {expm1(x.value), host::expm1(x.exact)}; }
PLUMB_INLINE Followed log(const Followed& x) { return {log(x.value), host::log(x.exact)}; }
PLUMB_INLINE Followed log2(const Followed& x) { return {log2(x.value), host::log2(x.exact)}; }
PLUMB_INLINE Followed sin(const Followed& x) { return {sin(x.value), host::sin(x.exact)}; }
PLUMB_INLINE Followed cos(const Followed& x) { return {cos(x.value), host::cos(x.exact)}; }
PLUMB_INLINE Followed acos(const Followed& x) { return {acos(x.value), host::acos(x.exact)}; }
PLUMB_INLINE Followed pow(const Followed& x, const Followed& y) {
    return {pow(x.value, y.value), host::pow(x.exact, y.exact)};
}

}  // namespace plumb::detmath
