// Formulas bound as stages, so that what is known of their conditioning and their error can be held against
// stability::evaluate().
#pragma once

#include "core/detmath.h"
#include "core/kernel_stage.h"

namespace plumb::test {

// Two rows of numbers, read by every pixel, and one number of the uniform block.
struct FormulaArgs {
    struct Uniforms {
        float c;
        std::int32_t count;  // of a
        std::int32_t width, height;
    } u;
    const float *a, *b;
    float* f;
};

// Formula::compute<F>(args): one number for each pixel.
template <class Formula>
struct FormulaKernel {
    using View = FormulaArgs;
    template <class F, class Tap>
    static F item(const View& in, index_t<F>, index_t<F>, Tap&) {
        return Formula::template compute<F>(in);
    }
    static float* out(const View& in) { return in.f; }
    template <class F>
    static mask_t<F> writes(const View&, index_t<F> x, index_t<F>) {
        return mask_t<F>(x != 1);
    }
};

// What a twin's header would hold.
struct FormulaTwin {
    static constexpr TwinMember members[] = {{"c", "float", 0}, {"count", "int", 4}, {"width", "int", 8}, {"height", "int", 12}};
    static constexpr TwinBinding bindings[] = {{"a", TwinKind::sampled_image, 1, ""},
                                               {"b", TwinKind::sampled_image, 2, ""},
                                               {"f", TwinKind::storage_image, 3, "float"}};
    static constexpr TwinLayout layout{"formula", false, members, sizeof(FormulaArgs::Uniforms), bindings};
    template <class Block>
    static consteval bool fits() {
        return sizeof(Block) == 16;
    }
};

template <class Formula>
StageDescription<FormulaArgs> describe(FormulaKernel<Formula>) {
    const auto any = [](const FormulaArgs&) { return glm::ivec2(0); };
    return {.name = "formula",
            .source = "a test",
            .domain = "pixel",
            .inputs = {{.name = "a", .at = &FormulaArgs::a, .channels = 1, .size = any},
                       {.name = "b", .at = &FormulaArgs::b, .channels = 1, .size = any}},
            .outputs = {{.name = "f", .at = &FormulaArgs::f}}};
}

template <class Formula>
const StageBinding& formula_binding() {
    return made<FormulaKernel<Formula>, FormulaTwin>();
}

inline StageData formula_data(const std::vector<float>& a, const std::vector<float>& b, float c = 0) {
    StageData d;
    d.stage = d.label = "formula";
    d.size = {1, 1};
    d.uniforms = uniform_block(FormulaArgs::Uniforms{c, std::int32_t(a.size()), 1, 1});
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
        for (int i = 0; i < in.u.count; ++i) sum += F(in.a[i]), squares += F(in.a[i]) * F(in.a[i]);
        const F n(float(in.u.count));
        return squares / n - (sum / n) * (sum / n);
    }
};
struct TwoPassVariance {
    template <class F>
    static F compute(const FormulaArgs& in) {
        F sum(0.0f), squares(0.0f);
        for (int i = 0; i < in.u.count; ++i) sum += F(in.a[i]);
        const F n(float(in.u.count)), mean = sum / n;
        for (int i = 0; i < in.u.count; ++i) squares += (F(in.a[i]) - mean) * (F(in.a[i]) - mean);
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
        for (int i = 0; i < in.u.count; ++i) sum += F(in.a[i]);
        return sum;
    }
};
// Kahan 1965.
struct CompensatedSum {
    template <class F>
    static F compute(const FormulaArgs& in) {
        F sum(0.0f), lost(0.0f);
        for (int i = 0; i < in.u.count; ++i) {
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

namespace plumb {

template <class Formula, Isa isa>
struct Rows<test::FormulaKernel<Formula>, isa> {
    static void run(const test::FormulaArgs& in, int first, int last, const Tiles&, float*) {
        for (int i = first * in.u.width; i < last * in.u.width; ++i) in.f[i] = Formula::template compute<float>(in);
    }
};

}  // namespace plumb
