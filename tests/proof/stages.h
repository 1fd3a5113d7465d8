// Small stages of the tests' own, of the kinds that no frame has yet: over a list with a buffer as output, with two outputs of
// different types, and one step of an iteration. Each is a kernel, a description and a twin, as gi/README.md says.
#pragma once

#include "core/number.h"
#include "core/stage_description.h"

namespace plumb::proof {

// ---- Over a list -------------------------------------------------------------------------------------------------------

struct ListView {
    struct Uniforms {
        std::int32_t width, height;  // receivers, 1
        std::int32_t senders, links;
        float scale;
        std::int32_t padding[3];
    } u;
    const float* positions;       // [width]
    const std::int32_t* links;    // [width][links]
    const float* radiosity;       // [senders][4]; w: where it is sent from
    float* gathered;              // [width][4]
};

struct ListKernel {
    using View = ListView;
    template <class F, class Tap>
    static vec4<F> item(const View& in, index_t<F> receiver, index_t<F>, Tap& tap) {
        using N = number<F>;
        using I = index_t<F>;
        const F x = N::fetch(in.positions, receiver);
        tap("x", x, "where it is");
        vec3<F> sum{F(0.0f), F(0.0f), F(0.0f)};
        for (int k = 0; k < in.u.links; ++k) {
            tap.sample(k);
            const I sender = min(N::fetch(in.links, receiver * I(in.u.links) + I(k)), I(in.u.senders - 1));
            tap("sender", sender, "which sends");
            const vec4<F> b = N::fetch4(in.radiosity, sender);
            const F d = (x - b.w) * (x - b.w) + F(1.0f);
            const F w = F(in.u.scale) / d;
            tap("w", w, "scale / (1 + distance^2)");
            sum = {sum.x + w * b.x, sum.y + w * b.y, sum.z + w * b.z};
        }
        tap.sample(-1);
        tap("irradiance", sum, "sum of w B");
        return vec4<F>(sum, x);
    }
    static float* out(const View& in) { return in.gathered; }
};

inline StageDescription<ListView> describe(ListKernel) {
    using View = ListView;
    const auto receivers = [](const View& v) { return std::size_t(v.u.width); };
    return {.name = "proof.list",
            .source = "tests/proof",
            .domain = "receiver",
            .inputs = {{.name = "positions", .at = &View::positions, .unit = "m", .count = receivers, .why = "one a receiver"},
                       {.name = "links", .at = &View::links,
                        .count = [](const View& v) { return std::size_t(v.u.width) * std::size_t(v.u.links); },
                        .why = "links of each receiver"},
                       {.name = "radiosity", .at = &View::radiosity, .unit = "W/m2",
                        .count = [](const View& v) { return std::size_t(v.u.senders); }, .why = "one a sender"}},
            .outputs = {{.name = "gathered", .at = &View::gathered, .unit = "W/m2", .meaning = "irradiance of each receiver"}},
            .uniforms = {{"links", 0, 64}, {"senders", 1, 1 << 20}},
            .refuses = [](const View&, glm::ivec2 size) { return std::string(size.y == 1 ? "" : "a list has one row"); },
            .cost = {1, "links"}};
}

// ---- With two outputs of different types -------------------------------------------------------------------------------

template <class F>
struct Direction {
    vec4<F> direction;
    F length;
    template <class Each>
    void components(Each each) const {
        each(direction.x), each(direction.y), each(direction.z), each(direction.w), each(length);
    }
};

struct PairView {
    struct Uniforms {
        std::int32_t width, height, padding[2];
    } u;
    const float* vectors;
    float *direction, *length;
};

struct PairKernel {
    using View = PairView;
    template <class F, class Tap>
    static Direction<F> item(const View& in, index_t<F> x, index_t<F> y, Tap& tap) {
        const vec4<F> v = number<F>::fetch4(in.vectors, y * index_t<F>(in.u.width) + x);
        const F size = sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
        tap("length", size, "|v|");
        return {vec4<F>(vec3<F>{v.x / size, v.y / size, v.z / size}, v.w), size};
    }
    template <class F>
    static void store(const View& in, index_t<F> at, const Direction<F>& p, mask_t<F> active) {
        number<F>::store4(in.direction, at, p.direction, active);
        number<F>::store(in.length, at, p.length, active);
    }
};

inline StageDescription<PairView> describe(PairKernel) {
    return {.name = "proof.pair",
            .source = "tests/proof",
            .domain = "pixel",
            .inputs = {{.name = "vectors", .at = &PairView::vectors, .unit = "m", .fixed = 8}},
            .outputs = {{.name = "direction", .at = &PairView::direction, .meaning = "unit"},
                        {.name = "length", .at = &PairView::length, .unit = "m"}},
            .cost = {1, "pixels"}};
}

// ---- One step of an iteration ------------------------------------------------------------------------------------------

struct StepView {
    struct Uniforms {
        std::int32_t width, height;
        float rho;
        std::int32_t padding;
    } u;
    const float *source, *before;
    float* after;
};

struct StepKernel {
    using View = StepView;
    template <class F, class Tap>
    static vec4<F> item(const View& in, index_t<F> x, index_t<F> y, Tap& tap) {
        using N = number<F>;
        using I = index_t<F>;
        const I width(in.u.width), height(in.u.height);
        auto at = [&](I px, I py) {
            px = max(I(0), min(px, width - I(1))), py = max(I(0), min(py, height - I(1)));
            return N::fetch4(in.before, py * width + px);
        };
        const vec4<F> b = N::fetch4(in.source, y * width + x);
        const vec4<F> l = at(x - I(1), y), r = at(x + I(1), y), t = at(x, y - I(1)), d = at(x, y + I(1));
        const F quarter(0.25f), rho(in.u.rho);
        const vec3<F> mean{quarter * (l.x + r.x + t.x + d.x), quarter * (l.y + r.y + t.y + d.y),
                           quarter * (l.z + r.z + t.z + d.z)};
        tap("mean", mean, "of the four neighbours");
        const vec3<F> next{b.x + rho * mean.x, b.y + rho * mean.y, b.z + rho * mean.z};
        tap("next", next, "b + rho mean");
        return vec4<F>(next, b.w);
    }
    static float* out(const View& in) { return in.after; }
};

inline StageDescription<StepView> describe(StepKernel) {
    return {.name = "proof.step",
            .source = "tests/proof",
            .domain = "pixel",
            .inputs = {{.name = "source", .at = &StepView::source, .unit = "W/m2"},
                       {.name = "before", .at = &StepView::before, .unit = "W/m2"}},
            .outputs = {{.name = "after", .at = &StepView::after, .unit = "W/m2"}},
            .uniforms = {{"rho", 0, 1}},
            .cost = {1, "pixels"}};
}

}  // namespace plumb::proof
