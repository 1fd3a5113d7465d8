#include <cstddef>
#include <optional>

#include "core/fp_environment.h"
#include "gi/bind_stage.h"
#include "gi/isr/bindings.h"
#include "gi/isr/gather_inputs.h"

namespace plumb::isr {

namespace {

// An image that the kernel does not read may be a pixel of nothing.
const Image4& or_nothing(const Image4* image) {
    static const Image4 nothing(1, 1);
    return image ? *image : nothing;
}

struct DownsampleOf {
    static constexpr int components = 4;
    DownsampleInputsView view{};

    explicit DownsampleOf(const StageData& d) {
        DownsampleUniforms& u = view.u = uniforms_of_frame<DownsampleUniforms>(d);
        if (u.what < 0 || u.what > int(Coarse::reflectance))
            throw InputError(fmt::format("{}: what = {}: expected 0 to 2", d.label, u.what));
        if (u.full_width < 1 || u.full_height < 1 || coarse_size({u.full_width, u.full_height}) != d.size)
            throw InputError(fmt::format("{}: {} x {} of {} x {}: expected half of it, rounded up", d.label, d.size.x,
                                         d.size.y, u.full_width, u.full_height));
        const char* why = "as full_width and full_height say";
        check_shape(d, "normal", u.full_width, u.full_height, why);
        check_shape(d, u.what == 0 ? "position" : "albedo", u.full_width, u.full_height, why);
        if (u.what == 1 && u.published == 0)
            for (const char* name : {"emission", "direct"}) check_shape(d, name, u.full_width, u.full_height, why);
        for (const char* name : {"position", "albedo", "emission", "direct"})
            if (at(d.inputs, name).shape != Shape{1, 1, 4}) check_shape(d, name, u.full_width, u.full_height, why);
        view.position = floats(d, "position"), view.normal = floats(d, "normal"), view.albedo = floats(d, "albedo");
        view.emission = floats(d, "emission"), view.direct = floats(d, "direct");
    }
    template <class F, class Tap>
    std::array<F, components> pixel(int x, int y, Tap& tap) const {
        return components_of(downsample<F>(view, x, y, tap));
    }
    template <Isa isa>
    void rows(float* out, int first, int last) const {
        DownsampleInputsView v = view;
        v.coarse = out;
        GatherRows<isa>::downsample(v, first, last);
    }
    bool writes(glm::ivec2) const { return true; }
};

// What isr.gather and isr.ssao bind alike. Returns the pattern's reach.
int check_samples(const StageData& d, const SampleUniforms& u) {
    if (u.rings < 0 || u.rings > 127 || u.rotations < 1 || (u.rotations & (u.rotations - 1)) != 0)
        throw InputError(fmt::format("{}: rings = {}, rotations = {}: expected 0 to 127, and a power of two", d.label,
                                     u.rings, u.rotations));
    const std::size_t offsets = at(d.inputs, "offsets").bytes.size() / 4;
    const std::size_t needed = std::size_t(sample_count(u.rings)) * std::size_t(u.rotations);
    if (offsets < needed)
        throw InputError(fmt::format("{}: {} offsets: expected {} x {}", d.label, offsets, sample_count(u.rings), u.rotations));
    check_shape(d, "source_surface", u.source_width, u.source_height, "as source_width and source_height say");
    if (u.margin < 0 || u.margin > u.source_width - d.size.x || u.margin > u.source_height - d.size.y)
        throw InputError(fmt::format("{}: margin = {}: expected 0 or more, and sources of {} x {} around it", d.label,
                                     u.margin, d.size.x, d.size.y));
    int reach = 0;
    const std::int32_t* table = ints(d, "offsets");
    for (std::size_t i = 0; i < needed; ++i) {
        const ivec2<std::int32_t> offset = offset_of(table[i]);
        reach = max(reach, max(max(offset.x, -offset.x), max(offset.y, -offset.y)));
    }
    return reach;
}

// All sources taken apart, once; without rotations alone, since with them samples are fetched.
class AllPlanes {
  public:
    template <class View>
    void make(const View& view, int count, int reach) {
        if (view.u.rotations > 1) return;
        floats_.resize(SourcePlanes::floats(view.u, count, reach, view.u.height));
        planes_.emplace(view.u, count, reach, 0, view.u.height, floats_.data());
        FpEnvironment environment;
        GatherRows<Isa::scalar>::take_apart(view, *planes_);
    }
    const SourcePlanes* get() const { return planes_ ? &*planes_ : nullptr; }

  private:
    Buffer<float> floats_;
    std::optional<SourcePlanes> planes_;
};

struct GatherOf {
    static constexpr int components = 4;
    GatherInputsView view{};
    AllPlanes planes;

    explicit GatherOf(const StageData& d) {
        const SampleUniforms& u = view.u = uniforms_of_frame<SampleUniforms>(d);
        const int reach = check_samples(d, u);
        check_shape(d, "source_radiosity", u.source_width, u.source_height, "as source_surface");
        view.surface = floats(d, "surface"), view.source_surface = floats(d, "source_surface");
        view.source_radiosity = floats(d, "source_radiosity"), view.before = floats(d, "before");
        view.offsets = ints(d, "offsets");
        planes.make(view, SourcePlanes::of_gather, reach);
    }
    template <class F, class Tap>
    std::array<F, components> pixel(int x, int y, Tap& tap) const {
        return components_of(gather<F>(view, x, y, SourceImages<F>{view, x, y, rotation_of<F>(view.u, x, y)}, tap));
    }
    template <Isa isa>
    void rows(float* out, int first, int last) const {
        GatherInputsView v = view;
        v.gathered = out;
        GatherRows<isa>::gather(v, planes.get(), first, last);
    }
    bool writes(glm::ivec2) const { return true; }
};

struct SsaoOf {
    static constexpr int components = 4;
    SsaoInputsView view{};
    AllPlanes planes;

    explicit SsaoOf(const StageData& d) {
        const SampleUniforms& u = view.u = uniforms_of_frame<SampleUniforms>(d);
        const int reach = check_samples(d, u);
        view.surface = floats(d, "surface"), view.source_surface = floats(d, "source_surface");
        view.gathered = floats(d, "gathered"), view.offsets = ints(d, "offsets");
        planes.make(view, SourcePlanes::of_ssao, reach);
    }
    template <class F, class Tap>
    std::array<F, components> pixel(int x, int y, Tap& tap) const {
        return components_of(ssao<F>(view, x, y, SphereImage<F>{view, x, y, rotation_of<F>(view.u, x, y)}, tap));
    }
    template <Isa isa>
    void rows(float* out, int first, int last) const {
        SsaoInputsView v = view;
        v.lit = out;
        GatherRows<isa>::ssao(v, planes.get(), first, last);
    }
    bool writes(glm::ivec2) const { return true; }
};

struct BounceOf {
    static constexpr int components = 4;
    BounceInputsView view{};

    explicit BounceOf(const StageData& d) {
        const BounceUniforms& u = view.u = uniforms_of_frame<BounceUniforms>(d);
        if (u.receivers_width < 1 || u.receivers_height < 1)
            throw InputError(fmt::format("{}: receivers of {} x {}: expected a pixel", d.label, u.receivers_width,
                                         u.receivers_height));
        for (const char* name : {"reflectance", "gathered"})
            check_shape(d, name, u.receivers_width, u.receivers_height, "as receivers_width and receivers_height say");
        view.radiosity = floats(d, "radiosity"), view.reflectance = floats(d, "reflectance");
        view.gathered = floats(d, "gathered");
    }
    template <class F, class Tap>
    std::array<F, components> pixel(int x, int y, Tap& tap) const {
        return components_of(bounce<F>(view, x, y, tap));
    }
    template <Isa isa>
    void rows(float* out, int first, int last) const {
        BounceInputsView v = view;
        v.bounced = out;
        GatherRows<isa>::bounce(v, first, last);
    }
    bool writes(glm::ivec2) const { return true; }
};

std::vector<UniformMember> sample_members() {
    using U = SampleUniforms;
    return {{"right", "vec4", offsetof(U, right)},
            {"down", "vec4", offsetof(U, down)},
            {"of_depth", "vec4", offsetof(U, of_depth)},
            {"origin", "vec4", offsetof(U, origin)},
            {"width", "int", offsetof(U, width)},
            {"height", "int", offsetof(U, height)},
            {"source_width", "int", offsetof(U, source_width)},
            {"source_height", "int", offsetof(U, source_height)},
            {"margin", "int", offsetof(U, margin)},
            {"rings", "int", offsetof(U, rings)},
            {"rotations", "int", offsetof(U, rotations)},
            {"seed", "uint", offsetof(U, seed)},
            {"far_rings", "int", offsetof(U, far_rings)},
            {"published", "int", offsetof(U, published)},
            {"inverse_matrix", "int", offsetof(U, inverse_matrix)},
            {"area", "float", offsetof(U, area)},
            {"least_cosine", "float", offsetof(U, least_cosine)},
            {"full_reach", "float", offsetof(U, full_reach)},
            {"scale", "float", offsetof(U, scale)}};
}

}  // namespace

const StageBinding& downsample_binding() {
    using U = DownsampleUniforms;
    static const StageBinding binding{
        .info = info_downsample(),
        .twin = "gi/isr/downsample.comp",
        .uniforms = {{"width", "int", offsetof(U, width)},
                     {"height", "int", offsetof(U, height)},
                     {"full_width", "int", offsetof(U, full_width)},
                     {"full_height", "int", offsetof(U, full_height)},
                     {"what", "int", offsetof(U, what)},
                     {"published", "int", offsetof(U, published)},
                     {"clip_depth", "int", offsetof(U, clip_depth)},
                     {"depth_slope", "float", offsetof(U, depth_slope)},
                     {"depth_offset", "float", offsetof(U, depth_offset)}},
        .uniform_bytes = sizeof(U),
        .inputs = {{.name = "position", .binding = 1, .frame = false, .unit = "m", .meaning = "w: linear eye depth"},
                   {.name = "normal", .binding = 2, .frame = false, .meaning = "unit normal, w 1", .fixed = 0b1000},
                   {.name = "albedo", .binding = 3, .frame = false, .meaning = "reflectance; w: radiation mask"},
                   {.name = "emission", .binding = 4, .frame = false, .unit = "W/m2", .meaning = "radiant exitance"},
                   {.name = "direct", .binding = 5, .frame = false, .unit = "W/m2", .meaning = "direct irradiance"}},
        .outputs = {{.name = "coarse", .kind = SlotKind::storage_image, .binding = 6,
                     .meaning = "surface, radiosity or reflectance of a quarter of the pixels"}},
        .bind = bind_kernel<DownsampleOf, downsample_binding>};
    return binding;
}

const StageBinding& gather_binding() {
    static const StageBinding binding{
        .info = info_gather(),
        .twin = "gi/isr/gather.comp",
        .uniforms = sample_members(),
        .uniform_bytes = sizeof(SampleUniforms),
        .inputs = {{.name = "surface", .binding = 1, .unit = "m", .meaning = "receivers: xyz unit normal, w depth"},
                   {.name = "source_surface", .binding = 2, .frame = false, .unit = "m",
                    .meaning = "where light comes from: xyz unit normal, w depth"},
                   {.name = "source_radiosity", .binding = 3, .frame = false, .unit = "W/m2",
                    .meaning = "w: radiation mask"},
                   {.name = "before", .binding = 4, .unit = "W/m2",
                    .meaning = "what other sources sent; w: sum of form factors"},
                   {.name = "offsets", .kind = SlotKind::buffer, .binding = 5, .dtype = DType::i32, .channels = 1,
                    .frame = false, .unit = "coarse pixels", .meaning = "[samples][rotations]"}},
        .outputs = {{.name = "gathered", .kind = SlotKind::storage_image, .binding = 6, .unit = "W/m2",
                     .meaning = "irradiance; w: sum of form factors"}},
        .bind = bind_kernel<GatherOf, gather_binding>};
    return binding;
}

const StageBinding& ssao_binding() {
    static const StageBinding binding{
        .info = info_ssao(),
        .twin = "gi/isr/ssao.comp",
        .uniforms = sample_members(),
        .uniform_bytes = sizeof(SampleUniforms),
        .inputs = {{.name = "surface", .binding = 1, .unit = "m", .meaning = "receivers: xyz unit normal, w depth"},
                   {.name = "source_surface", .binding = 2, .frame = false, .unit = "m",
                    .meaning = "what occludes: xyz unit normal, w depth"},
                   {.name = "gathered", .binding = 3, .unit = "W/m2", .meaning = "irradiance, which goes through"},
                   {.name = "offsets", .kind = SlotKind::buffer, .binding = 4, .dtype = DType::i32, .channels = 1,
                    .frame = false, .unit = "coarse pixels", .meaning = "[samples][rotations]"}},
        .outputs = {{.name = "lit", .kind = SlotKind::storage_image, .binding = 5, .unit = "W/m2",
                     .meaning = "irradiance; w: accessibility"}},
        .bind = bind_kernel<SsaoOf, ssao_binding>};
    return binding;
}

const StageBinding& bounce_binding() {
    using U = BounceUniforms;
    static const StageBinding binding{
        .info = info_bounce(),
        .twin = "gi/isr/bounce.comp",
        .uniforms = {{"width", "int", offsetof(U, width)},
                     {"height", "int", offsetof(U, height)},
                     {"receivers_width", "int", offsetof(U, receivers_width)},
                     {"receivers_height", "int", offsetof(U, receivers_height)},
                     {"margin", "int", offsetof(U, margin)}},
        .uniform_bytes = sizeof(U),
        .inputs = {{.name = "radiosity", .binding = 1, .unit = "W/m2", .meaning = "B0 of all sources; w: radiation mask"},
                   {.name = "reflectance", .binding = 2, .frame = false, .meaning = "of the receivers"},
                   {.name = "gathered", .binding = 3, .frame = false, .unit = "W/m2",
                    .meaning = "irradiance of the receivers"}},
        .outputs = {{.name = "bounced", .kind = SlotKind::storage_image, .binding = 4, .unit = "W/m2",
                     .meaning = "B = B0 + rho E of all sources; w: radiation mask"}},
        .bind = bind_kernel<BounceOf, bounce_binding>};
    return binding;
}

StageData downsample_data(const IsrParams& params, Coarse what, const DownsampleInputs& in) {
    validate(params, what, in);
    StageData d;
    d.stage = "isr.downsample";
    d.size = coarse_size({in.normal->width, in.normal->height});
    d.uniforms = uniform_block(uniforms(params, what, in));
    const bool surface = what == Coarse::surface;
    const bool lit = what == Coarse::radiosity && params.variant == Variant::corrected;
    add(d.inputs, "position", or_nothing(surface ? in.position : nullptr));
    add(d.inputs, "normal", *in.normal);
    add(d.inputs, "albedo", or_nothing(surface ? nullptr : in.albedo));
    add(d.inputs, "emission", or_nothing(lit ? in.emission : nullptr));
    add(d.inputs, "direct", or_nothing(lit ? in.direct : nullptr));
    return d;
}

StageData gather_data(const IsrParams& params, const GatherInputs& in) {
    validate(params, in);
    StageData d;
    d.stage = "isr.gather";
    d.size = {in.surface->width, in.surface->height};
    d.uniforms = uniform_block(uniforms(params, in));
    add(d.inputs, "surface", *in.surface);
    add(d.inputs, "source_surface", *in.source_surface);
    add(d.inputs, "source_radiosity", *in.source_radiosity);
    add(d.inputs, "before", in.before ? *in.before : Image4(d.size.x, d.size.y));
    add(d.inputs, "offsets", {int(in.pattern->offsets.size())}, in.pattern->offsets.data());
    return d;
}

StageData ssao_data(const IsrParams& params, const SsaoInputs& in) {
    validate(params, in);
    StageData d;
    d.stage = "isr.ssao";
    d.size = {in.surface->width, in.surface->height};
    d.uniforms = uniform_block(uniforms(params, in));
    add(d.inputs, "surface", *in.surface);
    add(d.inputs, "source_surface", *in.source_surface);
    add(d.inputs, "gathered", in.gathered ? *in.gathered : Image4(d.size.x, d.size.y));
    add(d.inputs, "offsets", {int(in.pattern->offsets.size())}, in.pattern->offsets.data());
    return d;
}

StageData bounce_data(const IsrParams&, const BounceInputs& in) {
    validate(in);
    StageData d;
    d.stage = "isr.bounce";
    d.size = {in.radiosity->width, in.radiosity->height};
    d.uniforms = uniform_block(uniforms(in));
    add(d.inputs, "radiosity", *in.radiosity);
    add(d.inputs, "reflectance", *in.reflectance);
    add(d.inputs, "gathered", *in.gathered);
    return d;
}

}  // namespace plumb::isr
