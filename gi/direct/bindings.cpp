#include "gi/direct/bindings.h"

#include <cstddef>

#include "gi/bind_stage.h"
#include "gi/direct/direct_rows.h"

namespace plumb::direct {

namespace {

struct LogBlurOf {
    static constexpr int components = 4;
    LogBlurInputsView view{};

    explicit LogBlurOf(const StageData& d) {
        const LogBlurUniforms& u = view.u = uniforms_of_frame<LogBlurUniforms>(d);
        if (u.radius < 0 || u.radius > most_blur_radius)
            throw InputError(fmt::format("{}: radius = {}: expected 0 to {}", d.label, u.radius, most_blur_radius));
        const std::size_t weights = at(d.inputs, "spatial").bytes.size() / 4, needed = std::size_t(2 * u.radius + 1);
        if (weights < needed)
            throw InputError(fmt::format("{}: {} spatial weights: expected {}", d.label, weights, needed));
        view.depth_map = floats(d, "depth_map"), view.spatial = floats(d, "spatial");
    }
    template <class F, class Tap>
    std::array<F, components> pixel(int x, int y, Tap& tap) const {
        const vec4<F> v = log_blur<F>(view, x, y, tap);
        return {v.x, v.y, v.z, v.w};
    }
    template <Isa isa>
    void rows(float* out, int first, int last) const {
        LogBlurInputsView v = view;
        v.blurred = out;
        Rows<isa>::log_blur(v, first, last);
    }
    bool writes(glm::ivec2) const { return true; }
};

struct ShadowOf {
    static constexpr int components = 1;
    ShadowInputsView view{};

    explicit ShadowOf(const StageData& d) {
        const ShadowUniforms& u = view.u = uniforms_of_frame<ShadowUniforms>(d);
        check_map(d, "map_position", u.map.size);
        if (u.kernel < 1 || u.kernel > 64)
            throw InputError(fmt::format("{}: kernel = {}: expected 1 to 64", d.label, u.kernel));
        if (u.soft < int(Soft::none) || u.soft > int(Soft::esm))
            throw InputError(fmt::format("{}: soft = {}: expected 0 to {}", d.label, u.soft, int(Soft::esm)));
        view.position = floats(d, "position"), view.normal = floats(d, "normal");
        view.map_position = floats(d, "map_position");
    }
    template <class F, class Tap>
    std::array<F, components> pixel(int x, int y, Tap& tap) const {
        return {shadow<F>(view, x, y, tap)};
    }
    template <Isa isa>
    void rows(float* out, int first, int last) const {
        ShadowInputsView v = view;
        v.visibility = out;
        Rows<isa>::shadow(v, first, last);
    }
    template <class F>
    mask_t<F> served(glm::ivec2 pixel) const {
        const float* x = view.position + 4 * (std::ptrdiff_t(pixel.y) * view.u.width + pixel.x);
        return mask_t<F>(view.u.face < 0) | serves<F>(view.u, vec3<F>{F(x[0]), F(x[1]), F(x[2])});
    }
    bool writes(glm::ivec2 pixel) const { return served<float>(pixel); }
    // Of a pixel that is written: whether its face is the same on every device.
    bool surely_writes(glm::ivec2 pixel) const {
        Decisions decisions;
        decisions.widen = true;
        const DecisionScope scope(decisions);
        served<Bounded>(pixel);
        return view.u.face < 0 || !decisions.ambiguous;
    }
};

struct DirectOf {
    static constexpr int components = 4;
    DirectInputsView view{};

    explicit DirectOf(const StageData& d) {
        view.u = uniforms_of_frame<DirectUniforms>(d);
        const std::int64_t layers = at(d.inputs, "visibility").shape[0];
        const std::size_t lights = at(d.inputs, "lights").bytes.size() / sizeof(raster::LightArgs);
        if (view.u.lights < 0 || std::size_t(view.u.lights) > lights || view.u.lights > layers)
            throw InputError(fmt::format("{}: lights = {}: \"lights\" has {}, \"visibility\" has {}", d.label,
                                         view.u.lights, lights, layers));
        if (layers * d.size.x * d.size.y > 0x7fffffff)
            throw InputError(fmt::format("{}: input \"visibility\" has {} layers: too many", d.label, layers));
        view.position = floats(d, "position"), view.normal = floats(d, "normal");
        view.lights = reinterpret_cast<const raster::LightArgs*>(floats(d, "lights"));
        view.visibility = floats(d, "visibility");
    }
    template <class F, class Tap>
    std::array<F, components> pixel(int x, int y, Tap& tap) const {
        const vec4<F> e = direct<F>(view, x, y, tap);
        return {e.x, e.y, e.z, e.w};
    }
    template <Isa isa>
    void rows(float* out, int first, int last) const {
        DirectInputsView v = view;
        v.irradiance = out;
        Rows<isa>::direct(v, first, last);
    }
    bool writes(glm::ivec2) const { return true; }
};

}  // namespace

const StageBinding& log_blur_binding() {
    using U = LogBlurUniforms;
    static const StageBinding binding{
        .info = log_blur_info(),
        .twin = "gi/direct/log_blur.comp",
        .uniforms = {{"width", "int", offsetof(U, width)},
                     {"height", "int", offsetof(U, height)},
                     {"radius", "int", offsetof(U, radius)},
                     {"vertical", "int", offsetof(U, vertical)},
                     {"c", "float", offsetof(U, c)}},
        .uniform_bytes = sizeof(U),
        .inputs = {{.name = "depth_map", .binding = 1, .unit = "m",
                    .meaning = "w: linear light-space depth; 0 where nothing is"},
                   {.name = "spatial", .kind = SlotKind::buffer, .binding = 2, .channels = 1, .frame = false,
                    .meaning = "[2 radius + 1]: Gaussian of the distance"}},
        .outputs = {{.name = "blurred", .kind = SlotKind::storage_image, .binding = 3, .unit = "m",
                     .meaning = "w: blurred depth; 0 where no tap has anything"}},
        .bind = bind_kernel<LogBlurOf, log_blur_binding>};
    return binding;
}

const StageBinding& shadow_binding() {
    using U = ShadowUniforms;
    static const StageBinding binding{
        .info = shadow_info(),
        .twin = "gi/direct/shadow.comp",
        .uniforms = members_after_map(offsetof(U, map), {{"eye", "vec4", offsetof(U, eye)},
                                                         {"forward", "vec4", offsetof(U, forward)},
                                                         {"footprint_scale", "float", offsetof(U, footprint_scale)},
                                                         {"footprint_base", "float", offsetof(U, footprint_base)},
                                                         {"bias", "float", offsetof(U, bias)},
                                                         {"slope_bias", "float", offsetof(U, slope_bias)},
                                                         {"max_slope", "float", offsetof(U, max_slope)},
                                                         {"perspective", "float", offsetof(U, perspective), 1},
                                                         {"kernel", "int", offsetof(U, kernel)},
                                                         {"samples", "float", offsetof(U, samples), 1},
                                                         {"published", "int", offsetof(U, published)},
                                                         {"face", "int", offsetof(U, face)},
                                                         {"width", "int", offsetof(U, width)},
                                                         {"height", "int", offsetof(U, height)},
                                                         {"soft", "int", offsetof(U, soft)},
                                                         {"c", "float", offsetof(U, c)}}),
        .uniform_bytes = sizeof(U),
        .inputs = {{.name = "position", .binding = 1, .unit = "m",
                    .meaning = "world-space position of the shading points"},
                   {.name = "normal", .binding = 2, .meaning = "unit normal of the shading points"},
                   {.name = "map_position", .binding = 3, .frame = false, .unit = "m",
                    .meaning = "w: linear light-space depth; 0 where nothing is"}},
        .outputs = {{.name = "visibility", .kind = SlotKind::storage_image, .binding = 4, .channels = 1,
                     .meaning = "1 lit, 0 shadowed; but for the hard test in between"}},
        .bind = bind_kernel<ShadowOf, shadow_binding>};
    return binding;
}

const StageBinding& direct_binding() {
    using U = DirectUniforms;
    static const StageBinding binding{
        .info = direct_info(),
        .twin = "gi/direct/direct.comp",
        .uniforms = {{"lights", "int", offsetof(U, lights)},
                     {"width", "int", offsetof(U, width)},
                     {"height", "int", offsetof(U, height)},
                     {"density", "int", offsetof(U, density)}},
        .uniform_bytes = sizeof(U),
        .inputs = {{.name = "position", .binding = 1, .unit = "m",
                    .meaning = "world-space position of the shading points"},
                   {.name = "normal", .binding = 2, .meaning = "unit normal, w 1; all 0 where nothing is", .fixed = 8},
                   {.name = "lights", .kind = SlotKind::buffer, .binding = 3, .channels = 4, .frame = false,
                    .unit = "m, W/sr, W/m2",
                    .meaning = "four vec4 a light: position, cos_outer; direction, falloff_scale; intensity, "
                               "directional; 1 / radius^2, radius^2"},
                   {.name = "visibility", .kind = SlotKind::image_array, .binding = 4, .channels = 1,
                    .meaning = "a layer a light: 1 lit, 0 shadowed"}},
        .outputs = {{.name = "irradiance", .kind = SlotKind::storage_image, .binding = 5, .unit = "W/m2",
                     .meaning = "direct irradiance; w: shadow density where it is asked for"}},
        .bind = bind_kernel<DirectOf, direct_binding>};
    return binding;
}

StageData log_blur_data(const ShadowParams& params, const LogBlurInputs& in) {
    validate(params, in);
    const Buffer<float> spatial = blur_weights(params);
    StageData d;
    d.stage = "shadow.blur";
    d.size = {in.map->width, in.map->height};
    d.uniforms = uniform_block(log_blur_uniforms(params, in));
    add(d.inputs, "depth_map", *in.map);
    add(d.inputs, "spatial", {int(spatial.size())}, spatial.data());
    return d;
}

StageData shadow_data(const ShadowParams& params, const ShadowInputs& in, int face) {
    StageData d;
    d.stage = "shadow";
    d.size = {in.position->width, in.position->height};
    d.uniforms = uniform_block(shadow_uniforms(params, in, face));
    add(d.inputs, "position", *in.position);
    add(d.inputs, "normal", *in.normal);
    add(d.inputs, "map_position", map_of(in, face));
    return d;
}

StageData direct_data(const DirectParams& params, const DirectInputs& in) {
    StageData d;
    d.stage = "direct";
    d.size = {in.position->width, in.position->height};
    const int lights = int(in.lights->size());
    d.uniforms = uniform_block(direct_uniforms(params, in));
    add(d.inputs, "position", *in.position);
    add(d.inputs, "normal", *in.normal);

    // A device binds no empty buffer: without a light there is one that is not read.
    std::vector<raster::LightArgs> args;
    for (const Light& light : *in.lights) args.push_back(raster::light_args(light));
    args.resize(std::max(args.size(), std::size_t(1)));
    add(d.inputs, "lights", {std::int64_t(args.size()) * 4, 4}, args[0].position);
    const Shape layers{std::max(lights, 1), d.size.y, d.size.x};
    if (lights > 0)
        add(d.inputs, "visibility", layers, in.visibility->data());
    else
        add(d.inputs, "visibility", DType::f32, layers);
    return d;
}

}  // namespace plumb::direct
