// Taps: a kernel names its intermediate values, tap("cos_p", cos_p, "VRSM (3.2)"), so that `plumb explain` can list them.
// In production the tap is NoTap, an empty function; in `explain` it is a Recorder.
#pragma once

#include <string>
#include <vector>

#include "core/number.h"

namespace plumb {

struct NoTap {
    template <class V>
    PLUMB_INLINE void operator()(const char*, const V&, const char* = "") {}
    PLUMB_INLINE void sample(int) {}
};

// One named value of one invocation: one to four components.
struct TapValue {
    std::string name;
    int sample = -1;  // -1: not part of a loop over samples
    std::vector<double> value;
    std::string equation;
};

// Records values of a one-lane kernel (F is float or double).
struct Recorder {
    std::vector<TapValue> values;
    int current = -1;

    void sample(int k) { current = k; }
    void operator()(const char* name, float v, const char* equation = "") { add(name, {v}, equation); }
    void operator()(const char* name, double v, const char* equation = "") { add(name, {v}, equation); }
    void operator()(const char* name, std::int32_t v, const char* equation = "") { add(name, {double(v)}, equation); }
    void operator()(const char* name, bool v, const char* equation = "") { add(name, {v ? 1.0 : 0.0}, equation); }
    template <class F>
    void operator()(const char* name, const vec2<F>& v, const char* equation = "") {
        add(name, {double(v.x), double(v.y)}, equation);
    }
    template <class F>
    void operator()(const char* name, const vec3<F>& v, const char* equation = "") {
        add(name, {double(v.x), double(v.y), double(v.z)}, equation);
    }
    template <class I>
    void operator()(const char* name, const ivec2<I>& v, const char* equation = "") {
        add(name, {double(v.x), double(v.y)}, equation);
    }

  private:
    void add(const char* name, std::vector<double> v, const char* equation) {
        values.push_back({name, current, std::move(v), equation});
    }
};

}  // namespace plumb
