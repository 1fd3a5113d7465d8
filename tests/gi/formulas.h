// Formulas bound as stages, so that what is known of their conditioning and their error can be held against
// stability::evaluate().
#pragma once

#include "core/bound_kernel.h"
#include "core/detmath.h"

namespace plumb::test {

// Two rows of numbers, read by every pixel, and one number of the uniform block.
struct FormulaArgs {
    struct Uniforms {
        float c;
        std::int32_t padding[3];
    } u;
    const float *a, *b;
    std::int32_t count;
};

// Formula::compute<F>(args): one number for each pixel.
template <class Formula>
struct FormulaKernel {
    static constexpr int components = 1;
    FormulaArgs args{};
    int width;

    explicit FormulaKernel(const StageData& d) : width(d.size.x) {
        args.u = uniforms_of<FormulaArgs::Uniforms>(d);
        args.a = floats(d, "a"), args.b = floats(d, "b");
        args.count = std::int32_t(at(d.inputs, "a").bytes.size() / 4);
    }
    template <class F, class Tap>
    std::array<F, 1> pixel(int, int, Tap&) const {
        return {Formula::template compute<F>(args)};
    }
    template <Isa>
    void rows(float* out, int first, int last) const {
        NoTap tap;
        for (int i = first * width; i < last * width; ++i)
            number<float>::store(out, i, pixel<float>(0, 0, tap)[0], true);
    }
    bool writes(glm::ivec2 p) const { return p.x != 1; }
};

template <class Formula>
const StageBinding& formula_binding() {
    static const StageBinding binding = [] {
        StageBinding b;
        b.info.name = "formula";
        b.uniforms = {{"c", "float", 0}};
        b.uniform_bytes = sizeof(FormulaArgs::Uniforms);
        for (const char* name : {"a", "b"})
            b.inputs.push_back({.name = name, .kind = SlotKind::image, .channels = 1, .frame = false});
        b.outputs = {{.name = "f", .kind = SlotKind::storage_image, .channels = 1}};
        b.bind = [](const StageData& d) -> std::unique_ptr<BoundStage> {
            check_slots(formula_binding<Formula>(), d);
            return std::make_unique<BoundKernel<FormulaKernel<Formula>>>(formula_binding<Formula>(), d);
        };
        return b;
    }();
    return binding;
}

inline StageData formula_data(const std::vector<float>& a, const std::vector<float>& b, float c = 0) {
    StageData d;
    d.stage = d.label = "formula";
    d.size = {1, 1};
    d.uniforms = uniform_block(FormulaArgs::Uniforms{c, {}});
    // No image is a million texels wide.
    const std::int64_t rows = a.size() > 1000 ? std::int64_t(a.size()) / 1000 : 1;
    add(d.inputs, "a", {rows, std::int64_t(a.size()) / rows}, a.data());
    add(d.inputs, "b", {1, std::int64_t(b.size())}, b.data());
    return d;
}

// ---- formulas; pairs of a bad one and a good one compute the same
// ------------------------------------------------------

struct Difference {
    template <class F>
    static F compute(const FormulaArgs& in) {
        return F(in.a[0]) - F(in.b[0]);
    }
};
struct EighthPower {
    template <class F>
    static F compute(const FormulaArgs& in) {
        const F x(in.a[0]), x2 = x * x, x4 = x2 * x2;
        return x4 * x4;
    }
};
struct Uniform {
    template <class F>
    static F compute(const FormulaArgs& in) {
        return F(in.u.c) / F(in.a[0]);
    }
};

struct OneMinusCos {
    template <class F>
    static F compute(const FormulaArgs& in) {
        return F(1.0f) - detmath::cos(F(in.a[0]));
    }
};
struct TwoSinSquared {
    template <class F>
    static F compute(const FormulaArgs& in) {
        const F s = detmath::sin(F(in.a[0]) * F(0.5f));
        return F(2.0f) * s * s;
    }
};

struct NaiveVariance {
    template <class F>
    static F compute(const FormulaArgs& in) {
        F sum(0.0f), squares(0.0f);
        for (int i = 0; i < in.count; ++i) sum += F(in.a[i]), squares += F(in.a[i]) * F(in.a[i]);
        const F n(float(in.count));
        return squares / n - (sum / n) * (sum / n);
    }
};
struct TwoPassVariance {
    template <class F>
    static F compute(const FormulaArgs& in) {
        F sum(0.0f), squares(0.0f);
        for (int i = 0; i < in.count; ++i) sum += F(in.a[i]);
        const F n(float(in.count)), mean = sum / n;
        for (int i = 0; i < in.count; ++i) squares += (F(in.a[i]) - mean) * (F(in.a[i]) - mean);
        return squares / n;
    }
};

struct NaiveHypot {
    template <class F>
    static F compute(const FormulaArgs& in) {
        const F a(in.a[0]), b(in.b[0]);
        return sqrt(a * a + b * b);
    }
};
struct ScaledHypot {
    template <class F>
    static F compute(const FormulaArgs& in) {
        const F a = abs(F(in.a[0])), b = abs(F(in.b[0]));
        const F larger = max(max(a, b), F(1e-37f)), x = a / larger, y = b / larger;
        return larger * sqrt(x * x + y * y);
    }
};

struct NaiveSum {
    template <class F>
    static F compute(const FormulaArgs& in) {
        F sum(0.0f);
        for (int i = 0; i < in.count; ++i) sum += F(in.a[i]);
        return sum;
    }
};
// Kahan 1965.
struct CompensatedSum {
    template <class F>
    static F compute(const FormulaArgs& in) {
        F sum(0.0f), lost(0.0f);
        for (int i = 0; i < in.count; ++i) {
            const F term = F(in.a[i]) - lost, next = sum + term;
            lost = (next - sum) - term;
            sum = next;
        }
        return sum;
    }
};

// a < a + b, where float may lose b.
struct Grows {
    template <class F>
    static F compute(const FormulaArgs& in) {
        const F a(in.a[0]);
        return select(a < a + F(in.b[0]), F(1.0f), F(2.0f)) * a;
    }
};
// a b c, from the left.
struct Product {
    template <class F>
    static F compute(const FormulaArgs& in) {
        return F(in.a[0]) * F(in.b[0]) * F(in.u.c);
    }
};
struct Quotient {
    template <class F>
    static F compute(const FormulaArgs& in) {
        return F(in.a[0]) / F(in.b[0]);
    }
};

}  // namespace plumb::test
