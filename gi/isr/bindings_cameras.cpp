#include <cstddef>

#include "gi/bind_stage.h"
#include "gi/isr/bindings.h"
#include "gi/isr/cameras_inputs.h"
#include "gi/isr/cameras_rows.h"

namespace plumb::isr {

namespace {

struct UnseenOf {
    static constexpr int components = 4;
    UnseenInputsView view{};

    explicit UnseenOf(const StageData& d) {
        UnseenUniforms& u = view.u = uniforms_of<UnseenUniforms>(d);
        u.u.width = d.size.x, u.u.height = d.size.y;
        check_shape(d, "view_surface", u.view.width, u.view.height, "as view.width and view.height say");
        view.surface = floats(d, "surface"), view.view_surface = floats(d, "view_surface");
    }
    template <class F, class Tap>
    std::array<F, components> pixel(int x, int y, Tap& tap) const {
        return components_of(unseen<F>(view, x, y, tap));
    }
    template <Isa isa>
    void rows(float* out, int first, int last) const {
        UnseenInputsView v = view;
        v.unseen = out;
        CameraRows<isa>::unseen(v, first, last);
    }
    bool writes(glm::ivec2) const { return true; }
};

struct GatherCameraOf {
    static constexpr int components = 4;
    GatherCameraInputsView view{};

    explicit GatherCameraOf(const StageData& d) {
        GatherCameraUniforms& u = view.u = uniforms_of<GatherCameraUniforms>(d);
        u.u.width = d.size.x, u.u.height = d.size.y;
        if (u.u.rings < 0 || u.u.rings > 127 || u.u.rotations < 1 || (u.u.rotations & (u.u.rotations - 1)) != 0)
            throw InputError(fmt::format("{}: u.rings = {}, u.rotations = {}: expected 0 to 127, and a power of two",
                                         d.label, u.u.rings, u.u.rotations));
        const std::size_t offsets = at(d.inputs, "offsets").bytes.size() / 4;
        if (offsets < std::size_t(sample_count(u.u.rings)) * std::size_t(u.u.rotations))
            throw InputError(fmt::format("{}: {} offsets: expected {} x {}", d.label, offsets, sample_count(u.u.rings),
                                         u.u.rotations));
        for (const char* name : {"source_surface", "source_radiosity"})
            check_shape(d, name, u.camera.width, u.camera.height, "as camera.width and camera.height say");
        view.surface = floats(d, "surface"), view.source_surface = floats(d, "source_surface");
        view.source_radiosity = floats(d, "source_radiosity"), view.before = floats(d, "before");
        view.offsets = ints(d, "offsets");
    }
    template <class F, class Tap>
    std::array<F, components> pixel(int x, int y, Tap& tap) const {
        return components_of(gather_camera<F>(view, x, y, tap));
    }
    template <Isa isa>
    void rows(float* out, int first, int last) const {
        GatherCameraInputsView v = view;
        v.gathered = out;
        CameraRows<isa>::gather_camera(v, first, last, nullptr);
    }
    bool writes(glm::ivec2) const { return true; }
};

void append(std::vector<UniformMember>& members, const std::string& prefix, int offset) {
    for (UniformMember m : gather_binding().uniforms) {
        m.name = prefix + m.name, m.offset += offset;
        members.push_back(m);
    }
}

void append_view(std::vector<UniformMember>& members, int offset) {
    using V = ViewProjection;
    for (const UniformMember& m : {UniformMember{"view.eye", "vec4", offsetof(V, eye)},
                                   UniformMember{"view.to_x", "vec4", offsetof(V, to_x)},
                                   UniformMember{"view.to_y", "vec4", offsetof(V, to_y)},
                                   UniformMember{"view.forward", "vec4", offsetof(V, forward)},
                                   UniformMember{"view.width", "int", offsetof(V, width)},
                                   UniformMember{"view.height", "int", offsetof(V, height)},
                                   UniformMember{"view.margin", "int", offsetof(V, margin)},
                                   UniformMember{"view.least_depth", "float", offsetof(V, least_depth)}}) {
        members.push_back(m);
        members.back().offset += offset;
    }
}

std::vector<UniformMember> unseen_members() {
    using U = UnseenUniforms;
    std::vector<UniformMember> members;
    append(members, "u.", offsetof(U, u));
    append_view(members, offsetof(U, view));
    members.push_back({"reach", "float", offsetof(U, reach)});
    return members;
}

std::vector<UniformMember> gather_camera_members() {
    using U = GatherCameraUniforms;
    std::vector<UniformMember> members;
    append(members, "u.", offsetof(U, u));
    append(members, "camera.", offsetof(U, camera));
    append_view(members, offsetof(U, view));
    members.push_back({"camera_eye", "vec4", offsetof(U, camera_eye)});
    return members;
}

}  // namespace

const StageBinding& unseen_binding() {
    static const StageBinding binding{
        .info = info_unseen(),
        .twin = "gi/isr/unseen.comp",
        .uniforms = unseen_members(),
        .uniform_bytes = sizeof(UnseenUniforms),
        .inputs = {{.name = "surface", .binding = 1, .unit = "m", .meaning = "of the camera: xyz unit normal, w depth"},
                   {.name = "view_surface", .binding = 2, .frame = false, .unit = "m",
                    .meaning = "of the view: xyz unit normal, w depth"}},
        .outputs = {{.name = "unseen", .kind = SlotKind::storage_image, .binding = 3, .unit = "m",
                     .meaning = "of the camera, 0 where the view sees the same"}},
        .bind = bind_kernel<UnseenOf, unseen_binding>};
    return binding;
}

const StageBinding& gather_camera_binding() {
    static const StageBinding binding{
        .info = info_gather_camera(),
        .twin = "gi/isr/gather_camera.comp",
        .uniforms = gather_camera_members(),
        .uniform_bytes = sizeof(GatherCameraUniforms),
        .inputs = {{.name = "surface", .binding = 1, .unit = "m", .meaning = "receivers: xyz unit normal, w depth"},
                   {.name = "source_surface", .binding = 2, .frame = false, .unit = "m",
                    .meaning = "what only the camera sees: xyz unit normal, w depth"},
                   {.name = "source_radiosity", .binding = 3, .frame = false, .unit = "W/m2", .meaning = "of the camera"},
                   {.name = "before", .binding = 4, .unit = "W/m2",
                    .meaning = "what other sources sent; w: sum of form factors"},
                   {.name = "offsets", .kind = SlotKind::buffer, .binding = 5, .dtype = DType::i32, .channels = 1,
                    .frame = false, .unit = "coarse pixels", .meaning = "[samples][rotations]"}},
        .outputs = {{.name = "gathered", .kind = SlotKind::storage_image, .binding = 6, .unit = "W/m2",
                     .meaning = "irradiance; w: sum of form factors"}},
        .bind = bind_kernel<GatherCameraOf, gather_camera_binding>};
    return binding;
}

StageData unseen_data(const IsrParams& params, const UnseenInputs& in) {
    validate(params, in);
    StageData d;
    d.stage = "isr.unseen";
    d.size = {in.surface->width, in.surface->height};
    d.uniforms = uniform_block(uniforms(params, in));
    add(d.inputs, "surface", *in.surface);
    add(d.inputs, "view_surface", *in.view_surface);
    return d;
}

StageData gather_camera_data(const IsrParams& params, const CameraGatherInputs& in) {
    validate(params, in);
    StageData d;
    d.stage = "isr.gather_camera";
    d.size = {in.surface->width, in.surface->height};
    d.uniforms = uniform_block(uniforms(params, in));
    add(d.inputs, "surface", *in.surface);
    add(d.inputs, "source_surface", *in.source_surface);
    add(d.inputs, "source_radiosity", *in.source_radiosity);
    add(d.inputs, "before", in.before ? *in.before : Image4(d.size.x, d.size.y));
    add(d.inputs, "offsets", {int(in.pattern->offsets.size())}, in.pattern->offsets.data());
    return d;
}

}  // namespace plumb::isr
