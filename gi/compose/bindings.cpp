#include "gi/compose/bindings.h"

#include <cstddef>

#include "core/detmath_bounded.h"
#include "gi/bind_stage.h"
#include "gi/compose/compose_rows.h"

namespace plumb::compose {

namespace {

struct ComposeOf {
    static constexpr int components = 4;
    ComposeInputsView view{};

    explicit ComposeOf(const StageData& d) {
        view.u = uniforms_of_frame<ComposeUniforms>(d);
        view.normal = floats(d, "normal"), view.albedo = floats(d, "albedo"), view.emission = floats(d, "emission");
        view.direct = floats(d, "direct"), view.indirect = floats(d, "indirect");
    }
    template <class F, class Tap>
    std::array<F, components> pixel(int x, int y, Tap& tap) const {
        const vec3<F> c = compose<F>(view, x, y, tap);
        return {c.x, c.y, c.z, F(0.0f)};
    }
    template <Isa isa>
    void rows(float* out, int first, int last) const {
        ComposeInputsView v = view;
        v.radiance = out;
        Rows<isa>::compose(v, first, last);
    }
    bool writes(glm::ivec2) const { return true; }
};

struct TonemapOf {
    static constexpr int components = 4;
    TonemapInputsView view{};

    explicit TonemapOf(const StageData& d) {
        view.u = uniforms_of_frame<TonemapUniforms>(d);
        if (view.u.op < 0 || view.u.op > int(Operator::filmic))
            throw InputError(d.label + ": op = " + std::to_string(view.u.op) + ": expected 0 to 3");
        view.radiance = floats(d, "radiance");
    }
    template <class F, class Tap>
    std::array<F, components> pixel(int x, int y, Tap& tap) const {
        const vec3<F> c = tonemap<F>(view, x, y, tap);
        return {c.x, c.y, c.z, F(1.0f)};
    }
    template <Isa isa>
    void rows(float* out, int first, int last) const {
        TonemapInputsView v = view;
        v.display = out;
        Rows<isa>::tonemap(v, first, last);
    }
    bool writes(glm::ivec2) const { return true; }
};

}  // namespace

const StageBinding& compose_binding() {
    using U = ComposeUniforms;
    static const StageBinding binding{
        .info = compose_info(),
        .twin = "gi/compose/compose.comp",
        .uniforms = {{"environment", "vec4", offsetof(U, environment)},
                     {"inv_pi", "float", offsetof(U, inv_pi)},
                     {"width", "int", offsetof(U, width)},
                     {"height", "int", offsetof(U, height)},
                     {"shadowed", "int", offsetof(U, shadowed)},
                     {"shadow_color", "vec4", offsetof(U, shadow_color)}},
        .uniform_bytes = sizeof(U),
        .inputs = {{.name = "normal", .binding = 1, .meaning = "w: 1 on a surface, 0 where nothing is", .fixed = 8},
                   {.name = "albedo", .binding = 2, .meaning = "diffuse reflectance rho"},
                   {.name = "emission", .binding = 3, .unit = "W/m2", .meaning = "radiant exitance M"},
                   {.name = "direct", .binding = 4, .unit = "W/m2", .meaning = "direct irradiance; w: shadow density"},
                   {.name = "indirect", .binding = 5, .unit = "W/m2", .meaning = "indirect irradiance"}},
        .outputs = {{.name = "radiance", .kind = SlotKind::storage_image, .binding = 6, .unit = "W/(m2 sr)",
                     .meaning = "outgoing radiance towards the viewer"}},
        .bind = bind_kernel<ComposeOf, compose_binding>};
    return binding;
}

const StageBinding& tonemap_binding() {
    using U = TonemapUniforms;
    static const StageBinding binding{
        .info = tonemap_info(),
        .twin = "gi/compose/tonemap.comp",
        .uniforms = {{"op", "int", offsetof(U, op)},
                     {"exposure", "float", offsetof(U, exposure)},
                     {"width", "int", offsetof(U, width)},
                     {"height", "int", offsetof(U, height)}},
        .uniform_bytes = sizeof(U),
        .inputs = {{.name = "radiance", .binding = 1, .unit = "W/(m2 sr)", .meaning = "outgoing radiance"}},
        .outputs = {{.name = "display", .kind = SlotKind::storage_image, .binding = 2,
                     .meaning = "sRGB-encoded, 0..1; w 1"}},
        .bind = bind_kernel<TonemapOf, tonemap_binding>};
    return binding;
}

StageData compose_data(const ComposeParams& params, const ComposeInputs& in) {
    validate(in);
    StageData d;
    d.stage = "compose";
    d.size = {in.normal->width, in.normal->height};
    d.uniforms = uniform_block(uniforms(params, in));
    add(d.inputs, "normal", *in.normal);
    add(d.inputs, "albedo", *in.albedo);
    add(d.inputs, "emission", *in.emission);
    add(d.inputs, "direct", *in.direct);
    add(d.inputs, "indirect", *in.indirect);
    return d;
}

StageData tonemap_data(const TonemapParams& params, const Image4& radiance) {
    StageData d;
    d.stage = "tonemap";
    d.size = {radiance.width, radiance.height};
    d.uniforms = uniform_block(uniforms(params, radiance));
    add(d.inputs, "radiance", radiance);
    return d;
}

}  // namespace plumb::compose
