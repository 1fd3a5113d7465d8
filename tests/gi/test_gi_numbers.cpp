// Every kernel of gi/ is one template over its number type: here each runs for float, double and Bounded, on the same
// inputs, and the three have to fit together: |float - double| stays within the bound that Bounded carries.
#include <catch2/catch.hpp>
#include <cmath>
#include <type_traits>
#include <vector>

#include "core/bounded.h"
#include "core/detmath_bounded.h"
#include "core/inexact_inputs.h"
#include "core/tap.h"
#include "gi/compose/compose_kernel.h"
#include "gi/compose/tonemap_kernel.h"
#include "gi/direct/direct_kernel.h"
#include "gi/direct/shadow_kernel.h"
#include "gi/rsm/paths_kernel.h"

using namespace plumb;

namespace {

// Four pixels of RGBA, all different.
struct Pixels {
    alignas(64) float value[16];
    explicit Pixels(float first, float step) {
        for (int i = 0; i < 16; ++i) value[i] = first + step * float((i * 7) % 16);
    }
};

struct Inputs {
    Pixels position{-0.5f, 0.07f}, normal{0.1f, 0.05f}, albedo{0.05f, 0.06f}, emission{0, 0.3f}, direct{0, 0.9f},
        indirect{0, 0.2f};
    alignas(64) float records[4 * 16];
    std::int32_t offsets[2] = {1, 1 << 16};
    float weights[2] = {2.5f, 3.25f}, edges[2] = {-0.25f, 0.25f};
    float visibility[8] = {1, 1, 0, 1, 1, 1, 1, 0};
    raster::LightArgs lights[2] = {{{0.2f, 1, 0.3f}, 0.5f, {0, -1, 0}, 3, {4, 2, 1}, 0},
                                   {{0, 0, 0}, -2, {0.6f, -0.8f, 0}, 1, {9, 8, 7}, 1}};

    Inputs() {
        for (int t = 0; t < 4; ++t)
            for (int c = 0; c < 16; ++c) records[16 * t + c] = 0.3f + 0.11f * float((t * 5 + c * 3) % 13);
        for (int t = 0; t < 4; ++t)
            for (int c = 4; c < 7; ++c) records[16 * t + c] *= -1;
    }

    rsm::GatherInputsView<float> gather() const {
        rsm::GatherInputsView<float> v{};
        v.u = {{{0.5f, 0.1f, 0, 1}, {0, 0.5f, 0.1f, 1}, {0, 0, 0.1f, 1}, 1e-6f, 0, 1.5f, 2},
               1e-37f, 0.318309873f, 2, 1, 4, 1, 1, 0};
        v.position = position.value, v.normal = normal.value, v.records = records;
        v.offsets = offsets, v.weights = weights;
        return v;
    }
    rsm::AllInputsView every_texel() const {
        rsm::AllInputsView v{};
        const rsm::GatherInputsView<float> g = gather();
        v.u = {g.u.map, g.u.least_distance2, g.u.scale, g.u.width, g.u.height};
        v.position = g.position, v.normal = g.normal, v.records = g.records;
        return v;
    }
    rsm::PathsInputsView<float> paths() const {
        rsm::PathsInputsView<float> v{};
        v.u.map = gather().u.map;
        v.u.axis[1] = 1;
        v.u.least_distance2 = 1e-37f, v.u.scale = 0.318309873f;
        v.u.directions = 1, v.u.steps = 2, v.u.rotations = 1;
        v.u.width = 4, v.u.height = 1, v.u.seed = 1, v.u.reach = 1;
        v.u.slots = 3, v.u.propagates = -1;
        v.position = position.value, v.normal = normal.value, v.records = records;
        v.offsets = offsets, v.weights = weights, v.edges = edges;
        return v;
    }
    direct::ShadowInputsView shadow() const {
        direct::ShadowInputsView v{};
        v.u.map = gather().u.map;
        v.u.map.low = -1048576, v.u.map.high = 1048576;
        v.u.forward[2] = -1, v.u.eye[2] = 2;
        v.u.footprint_scale = 0.01f, v.u.bias = 0.1f, v.u.slope_bias = 1, v.u.max_slope = 16;
        v.u.kernel = 1, v.u.samples = 1, v.u.face = -1;
        v.u.perspective = 1, v.u.width = 4, v.u.height = 1;
        v.position = position.value, v.normal = normal.value, v.map_position = albedo.value;
        return v;
    }
    direct::DirectInputsView direct_light() const {
        return {{2, 4, 1, 0}, position.value, normal.value, lights, visibility, nullptr};
    }
    compose::ComposeInputsView composition() const {
        return {{{1, 2, 3, 0}, 0.318309873f, 4, 1, 0}, normal.value,   albedo.value, emission.value,
                direct.value,                          indirect.value, nullptr};
    }
};

// Runs a kernel on each of the four pixels for the three numbers. kernel(tag of F, pixel) returns vec3<F>.
template <class Kernel>
void require_within_bound(Kernel kernel) {
    for (int px = 0; px < 4; ++px) {
        const vec3<float> single = kernel(float{}, px);
        const vec3<double> exact = kernel(double{}, px);
        const vec3<Bounded> bounded = kernel(Bounded{}, px);
        const Bounded parts[] = {bounded.x, bounded.y, bounded.z};
        for (int c = 0; c < 3; ++c) {
            CAPTURE(px, c, single[c], exact[c], parts[c].bound, parts[c].ambiguous);
            CHECK(parts[c].value == single[c]);
            CHECK(std::isfinite(parts[c].bound));
            CHECK(parts[c].bound <= 1e-4 * (1 + std::abs(exact[c])));
            if (!parts[c].ambiguous) CHECK(std::abs(double(single[c]) - exact[c]) <= parts[c].bound);
        }
    }
}

const Inputs inputs;

}  // namespace

TEST_CASE("every kernel of gi/ runs for float, double and Bounded, and they fit together", "[numbers]") {
    NoTap tap;
    SECTION("rsm.disc") {
        require_within_bound([&](auto tag, int px) {
            return rsm::gather_disc<decltype(tag)>(inputs.gather(), index_t<decltype(tag)>(px), 0, tap);
        });
    }
    SECTION("rsm.paths") {
        require_within_bound([&](auto tag, int px) {
            return rsm::gather_paths<decltype(tag)>(inputs.paths(), index_t<decltype(tag)>(px), 0, tap);
        });
    }
    SECTION("rsm.all") {
        require_within_bound([&](auto tag, int px) {
            return rsm::gather_all<decltype(tag)>(inputs.every_texel(), index_t<decltype(tag)>(px), 0, tap);
        });
    }
    SECTION("shadow") {
        require_within_bound([&](auto tag, int px) {
            using F = decltype(tag);
            return vec3<F>(direct::shadow<F>(inputs.shadow(), index_t<F>(px), 0, tap), F(0.0f), F(0.0f));
        });
    }
    SECTION("direct") {
        require_within_bound([&](auto tag, int px) {
            return direct::direct<decltype(tag)>(inputs.direct_light(), index_t<decltype(tag)>(px), 0, tap);
        });
    }
    SECTION("compose") {
        require_within_bound([&](auto tag, int px) {
            return compose::compose<decltype(tag)>(inputs.composition(), index_t<decltype(tag)>(px), 0, tap);
        });
    }
    SECTION("tonemap") {
        for (int op = 0; op < 4; ++op) {
            CAPTURE(op);
            for (const compose::TonemapUniforms& u : {compose::TonemapUniforms{op, 0.7f, 4, 1, 1, 1, 0, 0},
                                                      // A root of nearly nothing would lift the rounding of black above the bound.
                                                      compose::TonemapUniforms{op, 0.7f, 4, 1, 0.3f, 2.1f, 1.6f, 0}}) {
                const compose::TonemapInputsView view{u, inputs.direct.value, nullptr};
                require_within_bound([&](auto tag, int px) {
                    return compose::tonemap<decltype(tag)>(view, index_t<decltype(tag)>(px), 0, tap);
                });
            }
        }
    }
}

TEST_CASE("Bounded: a comparison inside the bound marks its result as ambiguous", "[numbers]") {
    const Bounded third = Bounded(1.0f) / Bounded(3.0f), nearly = third * Bounded(3.0f);
    CHECK(select(nearly < Bounded(1.0f), Bounded(1.0f), Bounded(2.0f)).ambiguous);
    CHECK_FALSE(select(nearly < Bounded(1.001f), Bounded(1.0f), Bounded(2.0f)).ambiguous);
    CHECK_FALSE(select(Bounded(1.0f) < Bounded(1.0f), Bounded(1.0f), Bounded(2.0f)).ambiguous);
}
