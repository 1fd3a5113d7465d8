#include "gi/filter/bindings.h"

#include <cstddef>

#include "gi/bind_stage.h"
#include "gi/filter/filter_rows.h"

namespace plumb::filter {

namespace {

struct ReduceOf {
    static constexpr int components = 4;
    ReduceInputsView view{};

    explicit ReduceOf(const StageData& d) {
        ReduceUniforms& u = view.u = uniforms_of_frame<ReduceUniforms>(d);
        check_shape(d, "full", u.full_width, u.full_height, "as full_width and full_height say");
        if (half_size({u.full_width, u.full_height}) != d.size)
            throw InputError(fmt::format("{}: {} x {} of {} x {}: expected half of it, rounded up", d.label, d.size.x,
                                         d.size.y, u.full_width, u.full_height));
        view.image = floats(d, "full");
    }
    template <class F, class Tap>
    std::array<F, components> pixel(int x, int y, Tap& tap) const {
        return components_of(reduce<F>(view, x, y, tap));
    }
    template <Isa isa>
    void rows(float* out, int first, int last) const {
        ReduceInputsView v = view;
        v.reduced = out;
        Rows<isa>::reduce(v, first, last);
    }
    bool writes(glm::ivec2) const { return true; }
};

struct UpsampleOf {
    static constexpr int components = 4;
    UpsampleInputsView view{};

    explicit UpsampleOf(const StageData& d) {
        UpsampleUniforms& u = view.u = uniforms_of_frame<UpsampleUniforms>(d);
        check_choice(d, "mode", u.mode, int(Upsample::published));
        check_choice(d, "similarity", u.similarity, int(Similarity::depth));
        const glm::ivec2 half = half_size(d.size);
        u.coarse_width = half.x, u.coarse_height = half.y;
        for (const char* name : {"coarse_irradiance", "coarse_position", "coarse_normal"})
            check_shape(d, name, half.x, half.y, "half of the outputs, rounded up");
        view.coarse_irradiance = floats(d, "coarse_irradiance"), view.coarse_position = floats(d, "coarse_position");
        view.coarse_normal = floats(d, "coarse_normal");
        view.position = floats(d, "position"), view.normal = floats(d, "normal");
    }
    template <class F, class Tap>
    std::array<F, components> pixel(int x, int y, Tap& tap) const {
        return components_of(upsample<F>(view, x, y, tap));
    }
    template <Isa isa>
    void rows(float* out, int first, int last) const {
        UpsampleInputsView v = view;
        v.upsampled = out;
        Rows<isa>::upsample(v, first, last);
    }
    bool writes(glm::ivec2) const { return true; }
};

struct BlurOf {
    static constexpr int components = 4;
    BlurInputsView view{};

    explicit BlurOf(const StageData& d) {
        const BlurUniforms& u = view.u = uniforms_of_frame<BlurUniforms>(d);
        check_choice(d, "similarity", u.similarity, int(Similarity::depth));
        check_choice(d, "radius_x", u.radius_x, BlurPlanes::padding);
        check_choice(d, "radius_y", u.radius_y, BlurPlanes::padding);
        const std::size_t weights = at(d.inputs, "spatial").bytes.size() / 4;
        const std::size_t needed = std::size_t(2 * u.radius_x + 1) * std::size_t(2 * u.radius_y + 1);
        if (weights < needed)
            throw InputError(fmt::format("{}: {} spatial weights: expected {}", d.label, weights, needed));
        view.irradiance = floats(d, "irradiance"), view.position = floats(d, "position");
        view.normal = floats(d, "normal"), view.spatial = floats(d, "spatial");
    }
    template <class F, class Tap>
    std::array<F, components> pixel(int x, int y, Tap& tap) const {
        return components_of(blur<F>(view.u, view.spatial, ImageTexels<F>{view, x, y}, tap));
    }
    template <Isa isa>
    void rows(float* out, int first, int last) const {
        BlurInputsView v = view;
        v.blurred = out;
        Buffer<float> scratch(BlurPlanes::floats(v.u.width, last - first, v.u.radius_y));
        Rows<isa>::blur(v, first, last, scratch.data());
    }
    bool writes(glm::ivec2) const { return true; }
};

}  // namespace

const StageBinding& reduce_binding() {
    using U = ReduceUniforms;
    static const StageBinding binding{
        .info = info_reduce(),
        .twin = "gi/filter/reduce.comp",
        .uniforms = {{"width", "int", offsetof(U, width)},
                     {"height", "int", offsetof(U, height)},
                     {"full_width", "int", offsetof(U, full_width)},
                     {"full_height", "int", offsetof(U, full_height)}},
        .uniform_bytes = sizeof(U),
        .inputs = {{.name = "full", .binding = 1, .frame = false, .meaning = "position or normal of every pixel"}},
        .outputs = {{.name = "reduced", .kind = SlotKind::storage_image, .binding = 2,
                     .meaning = "one pixel of every 2 x 2"}},
        .bind = bind_kernel<ReduceOf, reduce_binding>};
    return binding;
}

const StageBinding& upsample_binding() {
    using U = UpsampleUniforms;
    static const StageBinding binding{
        .info = info_upsample(),
        .twin = "gi/filter/upsample.comp",
        .uniforms = {{"width", "int", offsetof(U, width)},
                     {"height", "int", offsetof(U, height)},
                     {"coarse_width", "int", offsetof(U, coarse_width)},
                     {"coarse_height", "int", offsetof(U, coarse_height)},
                     {"mode", "int", offsetof(U, mode)},
                     {"similarity", "int", offsetof(U, similarity)},
                     {"sigma_depth", "float", offsetof(U, sigma_depth)},
                     {"normal_slope", "float", offsetof(U, normal_slope)},
                     {"normal_offset", "float", offsetof(U, normal_offset)}},
        .uniform_bytes = sizeof(U),
        .inputs = {{.name = "coarse_irradiance", .binding = 1, .frame = false, .unit = "W/m2",
                    .meaning = "at half size; w: linear depth, m"},
                   {.name = "coarse_position", .binding = 2, .frame = false, .unit = "m",
                    .meaning = "world-space position at half size"},
                   {.name = "coarse_normal", .binding = 3, .frame = false, .meaning = "unit normal at half size"},
                   {.name = "position", .binding = 4, .unit = "m", .meaning = "world-space position; w: linear depth"},
                   {.name = "normal", .binding = 5, .meaning = "unit normal"}},
        .outputs = {{.name = "upsampled", .kind = SlotKind::storage_image, .binding = 6, .unit = "W/m2",
                     .meaning = "irradiance of every pixel; w: linear depth, m"}},
        .bind = bind_kernel<UpsampleOf, upsample_binding>};
    return binding;
}

const StageBinding& blur_binding() {
    using U = BlurUniforms;
    static const StageBinding binding{
        .info = info_blur(),
        .twin = "gi/filter/blur.comp",
        .uniforms = {{"width", "int", offsetof(U, width)},
                     {"height", "int", offsetof(U, height)},
                     {"radius_x", "int", offsetof(U, radius_x)},
                     {"radius_y", "int", offsetof(U, radius_y)},
                     {"similarity", "int", offsetof(U, similarity)},
                     {"sigma_depth", "float", offsetof(U, sigma_depth)},
                     {"normal_slope", "float", offsetof(U, normal_slope)},
                     {"normal_offset", "float", offsetof(U, normal_offset)}},
        .uniform_bytes = sizeof(U),
        .inputs = {{.name = "irradiance", .binding = 1, .unit = "W/m2", .meaning = "w: linear depth, m"},
                   {.name = "position", .binding = 2, .unit = "m", .meaning = "world-space position"},
                   {.name = "normal", .binding = 3, .meaning = "unit normal"},
                   {.name = "spatial", .kind = SlotKind::buffer, .binding = 4, .channels = 1, .frame = false,
                    .meaning = "[2 radius_y + 1][2 radius_x + 1]: Gaussian of the distance; 0 in the middle"}},
        .outputs = {{.name = "blurred", .kind = SlotKind::storage_image, .binding = 5, .unit = "W/m2",
                     .meaning = "irradiance; w: linear depth, m"}},
        .bind = bind_kernel<BlurOf, blur_binding>};
    return binding;
}

StageData reduce_data(const Image4& image) {
    StageData d;
    d.stage = "filter.reduce";
    d.size = half_size({image.width, image.height});
    d.uniforms = uniform_block(uniforms(image));
    add(d.inputs, "full", image);
    return d;
}

StageData upsample_data(const FilterParams& params, const UpsampleInputs& in) {
    validate(params, in);
    StageData d;
    d.stage = "filter.upsample";
    d.size = {in.position->width, in.position->height};
    d.uniforms = uniform_block(uniforms(params, in));
    add(d.inputs, "coarse_irradiance", *in.coarse_irradiance);
    add(d.inputs, "coarse_position", *in.coarse_position);
    add(d.inputs, "coarse_normal", *in.coarse_normal);
    add(d.inputs, "position", *in.position);
    add(d.inputs, "normal", *in.normal);
    return d;
}

StageData blur_data(const FilterParams& params, const BlurInputs& in) {
    validate(params, in);
    const Buffer<float> spatial = spatial_weights(params, in.direction);
    StageData d;
    d.stage = "filter.blur";
    d.size = {in.irradiance->width, in.irradiance->height};
    d.uniforms = uniform_block(uniforms(params, in));
    add(d.inputs, "irradiance", *in.irradiance);
    add(d.inputs, "position", *in.position);
    add(d.inputs, "normal", *in.normal);
    add(d.inputs, "spatial", {int(spatial.size())}, spatial.data());
    return d;
}

}  // namespace plumb::filter
