#include "gi/isr/bindings_filter.h"

#include <cstddef>

#include "gi/bind_stage.h"
#include "gi/isr/bindings.h"
#include "gi/isr/blur_rows.h"
#include "gi/isr/compose_rows.h"
#include "gi/isr/upsample_rows.h"

namespace plumb::isr {

namespace {

struct BlurOf {
    static constexpr int components = 4;
    BlurInputsView view{};

    explicit BlurOf(const StageData& d) {
        const BlurUniforms& u = view.u = uniforms_of_frame<BlurUniforms>(d);
        check_choice(d, "kind", u.kind, int(BlurKind::published));
        check_choice(d, "vertical", u.vertical, 1);
        check_choice(d, "radius", u.radius, BlurPlanes::padding);
        const std::size_t weights = at(d.inputs, "spatial").bytes.size() / 4;
        const std::size_t needed = std::size_t(2 * u.radius + 1);
        if (weights < needed)
            throw InputError(fmt::format("{}: {} spatial weights: expected {}", d.label, weights, needed));
        view.lit = floats(d, "lit"), view.surface = floats(d, "surface"), view.spatial = floats(d, "spatial");
    }
    template <class F, class Tap>
    std::array<F, components> pixel(int x, int y, Tap& tap) const {
        return components_of(blur<F>(view.u, view.spatial, BlurImageTexels<F>{view, x, y}, tap));
    }
    template <Isa isa>
    void rows(float* out, int first, int last) const {
        BlurInputsView v = view;
        v.blurred = out;
        Buffer<float> scratch(BlurPlanes::floats(v.u, last - first));
        BlurRows<isa>::blur(v, first, last, scratch.data());
    }
    bool writes(glm::ivec2) const { return true; }
};

struct UpsampleOf {
    static constexpr int components = 4;
    UpsampleInputsView view{};

    explicit UpsampleOf(const StageData& d) {
        UpsampleUniforms& u = view.u = uniforms_of_frame<UpsampleUniforms>(d);
        for (const auto& [name, value] : {std::pair{"bilateral", u.bilateral}, std::pair{"published", u.published},
                                          std::pair{"clip_depth", u.clip_depth}})
            check_choice(d, name, value, 1);
        const glm::ivec2 coarse = coarse_size(d.size);
        u.coarse_width = coarse.x, u.coarse_height = coarse.y;
        for (const char* name : {"lit", "surface"}) {
            const Shape& shape = at(d.inputs, name).shape;
            if (shape[0] != coarse.y || shape[1] != coarse.x)
                throw InputError(fmt::format("{}: input \"{}\" is {}: expected {} x {}, half of the outputs", d.label,
                                             name, shape_text(shape), coarse.y, coarse.x));
        }
        view.lit = floats(d, "lit"), view.surface = floats(d, "surface");
        view.position = floats(d, "position"), view.normal = floats(d, "normal");
    }
    template <class F, class Tap>
    std::array<F, components> pixel(int x, int y, Tap& tap) const {
        return components_of(upsample<F>(view, UpsampleImageTexels<F>{view, x, y}, x, y, tap));
    }
    template <Isa isa>
    void rows(float* out, int first, int last) const {
        UpsampleInputsView v = view;
        v.upsampled = out;
        Buffer<float> scratch(UpsamplePlanes::floats(v.u.width, last - first));
        UpsampleRows<isa>::upsample(v, first, last, scratch.data());
    }
    bool writes(glm::ivec2) const { return true; }
};

struct ComposeOf {
    static constexpr int components = 4;
    ComposeInputsView view{};

    explicit ComposeOf(const StageData& d) {
        view.u = uniforms_of_frame<ComposeUniforms>(d);
        check_choice(d, "published", view.u.published, 1);
        view.normal = floats(d, "normal"), view.albedo = floats(d, "albedo"), view.emission = floats(d, "emission");
        view.direct = floats(d, "direct"), view.indirect = floats(d, "indirect");
    }
    template <class F, class Tap>
    std::array<F, components> pixel(int x, int y, Tap& tap) const {
        return components_of(vec4<F>(compose<F>(view, x, y, tap), F(0.0f)));
    }
    template <Isa isa>
    void rows(float* out, int first, int last) const {
        ComposeInputsView v = view;
        v.radiance = out;
        ComposeRows<isa>::compose(v, first, last);
    }
    bool writes(glm::ivec2) const { return true; }
};

}  // namespace

const StageBinding& blur_binding() {
    using U = BlurUniforms;
    static const StageBinding binding{
        .info = info_blur(),
        .twin = "gi/isr/blur.comp",
        .uniforms = {{"width", "int", offsetof(U, width)},
                     {"height", "int", offsetof(U, height)},
                     {"radius", "int", offsetof(U, radius)},
                     {"vertical", "int", offsetof(U, vertical)},
                     {"kind", "int", offsetof(U, kind)}},
        .uniform_bytes = sizeof(U),
        .inputs = {{.name = "lit", .binding = 1, .unit = "W/m2", .meaning = "irradiance; w: accessibility"},
                   {.name = "surface", .binding = 2, .meaning = "unit normal; w: linear eye depth, m"},
                   {.name = "spatial", .kind = SlotKind::buffer, .binding = 3, .channels = 1, .frame = false,
                    .meaning = "[2 radius + 1]: Gaussian of the distance; its sum is 1"}},
        .outputs = {{.name = "blurred", .kind = SlotKind::storage_image, .binding = 4, .unit = "W/m2",
                     .meaning = "irradiance; w: accessibility"}},
        .bind = bind_kernel<BlurOf, blur_binding>};
    return binding;
}

const StageBinding& upsample_binding() {
    using U = UpsampleUniforms;
    static const StageBinding binding{
        .info = info_upsample(),
        .twin = "gi/isr/upsample.comp",
        .uniforms = {{"width", "int", offsetof(U, width)},
                     {"height", "int", offsetof(U, height)},
                     {"coarse_width", "int", offsetof(U, coarse_width)},
                     {"coarse_height", "int", offsetof(U, coarse_height)},
                     {"bilateral", "int", offsetof(U, bilateral)},
                     {"published", "int", offsetof(U, published)},
                     {"clip_depth", "int", offsetof(U, clip_depth)},
                     {"epsilon", "float", offsetof(U, epsilon)},
                     {"far", "float", offsetof(U, far)},
                     {"per_near", "float", offsetof(U, per_near)},
                     {"per_far_less_near", "float", offsetof(U, per_far_less_near)}},
        .uniform_bytes = sizeof(U),
        .inputs = {{.name = "lit", .binding = 1, .frame = false, .unit = "W/m2",
                    .meaning = "coarse irradiance; w: accessibility"},
                   {.name = "surface", .binding = 2, .frame = false, .meaning = "coarse unit normal; w: depth"},
                   {.name = "position", .binding = 3, .unit = "m", .meaning = "w: linear eye depth"},
                   {.name = "normal", .binding = 4, .meaning = "unit normal"}},
        .outputs = {{.name = "upsampled", .kind = SlotKind::storage_image, .binding = 5, .unit = "W/m2",
                     .meaning = "irradiance of every pixel; w: accessibility"}},
        .bind = bind_kernel<UpsampleOf, upsample_binding>};
    return binding;
}

const StageBinding& compose_binding() {
    using U = ComposeUniforms;
    static const StageBinding binding{
        .info = info_compose(),
        .twin = "gi/isr/compose.comp",
        .uniforms = {{"environment", "vec4", offsetof(U, environment)},
                     {"ambient", "vec4", offsetof(U, ambient)},
                     {"inv_pi", "float", offsetof(U, inv_pi)},
                     {"k_ssao", "float", offsetof(U, k_ssao)},
                     {"k_isr", "float", offsetof(U, k_isr)},
                     {"published", "int", offsetof(U, published)},
                     {"width", "int", offsetof(U, width)},
                     {"height", "int", offsetof(U, height)}},
        .uniform_bytes = sizeof(U),
        .inputs = {{.name = "normal", .binding = 1, .meaning = "w: 1 on a surface, 0 where nothing is", .fixed = 8},
                   {.name = "albedo", .binding = 2, .meaning = "diffuse reflectance rho"},
                   {.name = "emission", .binding = 3, .unit = "W/m2", .meaning = "radiant exitance M"},
                   {.name = "direct", .binding = 4, .unit = "W/m2", .meaning = "direct irradiance"},
                   {.name = "indirect", .binding = 5, .unit = "W/m2",
                    .meaning = "indirect irradiance; w: accessibility"}},
        .outputs = {{.name = "radiance", .kind = SlotKind::storage_image, .binding = 6, .unit = "W/(m2 sr)",
                     .meaning = "outgoing radiance towards the viewer"}},
        .bind = bind_kernel<ComposeOf, compose_binding>};
    return binding;
}

StageData blur_data(const IsrParams& params, const BlurInputs& in) {
    validate(params, in);
    const Buffer<float> spatial = blur_weights(params);
    StageData d;
    d.stage = "isr.blur";
    d.size = {in.lit->width, in.lit->height};
    d.uniforms = uniform_block(uniforms(params, in));
    add(d.inputs, "lit", *in.lit);
    add(d.inputs, "surface", *in.surface);
    add(d.inputs, "spatial", {int(spatial.size())}, spatial.data());
    return d;
}

StageData upsample_data(const IsrParams& params, const UpsampleInputs& in) {
    validate(params, in);
    StageData d;
    d.stage = "isr.upsample";
    d.size = {in.position->width, in.position->height};
    d.uniforms = uniform_block(uniforms(params, in));
    add(d.inputs, "lit", *in.lit);
    add(d.inputs, "surface", *in.surface);
    add(d.inputs, "position", *in.position);
    add(d.inputs, "normal", *in.normal);
    return d;
}

StageData compose_data(const IsrParams& params, const ComposeInputs& in) {
    validate(params, in);
    StageData d;
    d.stage = "isr.compose";
    d.size = {in.normal->width, in.normal->height};
    d.uniforms = uniform_block(uniforms(params, in));
    add(d.inputs, "normal", *in.normal);
    add(d.inputs, "albedo", *in.albedo);
    add(d.inputs, "emission", *in.emission);
    add(d.inputs, "direct", *in.direct);
    add(d.inputs, "indirect", *in.indirect);
    return d;
}

}  // namespace plumb::isr
