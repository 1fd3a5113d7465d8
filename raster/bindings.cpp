#include "raster/bindings.h"

#include <fmt/format.h>

#include <cstddef>

#include "core/error.h"
#include "raster/bound_pass.h"
#include "raster/gbuffer.h"
#include "raster/pass_args.h"
#include "raster/resolve_tiles.h"
#include "raster/rsm.h"
#include "raster/screen_triangle.h"

namespace plumb::raster {
namespace {

float* target_of(Bundle& outputs, int i) {
    return reinterpret_cast<float*>(outputs.arrays[std::size_t(i)].bytes.data());
}

template <class F>
void put(F* out, const vec4<F>& v) {
    out[0] = v.x, out[1] = v.y, out[2] = v.z, out[3] = v.w;
}

struct GBufferPass {
    static constexpr int components = 16;
    GBufferArgs args{};

    GBufferPass(const StageData& data, const BoundScene& scene)
        : GBufferPass(uniforms_of<GBufferUniforms>(data), data, scene) {}
    template <class Uniforms>
    GBufferPass(const Uniforms& u, const StageData& data, const BoundScene& scene) {
        args.surfaces = surface_args(scene, u.viewer, u.forward, u.pixel_area);
        for (int c = 0; c < 3; ++c) args.eye[c] = u.eye[c], args.forward[c] = u.forward[c];
        args.width = data.size.x, args.height = data.size.y;
        args.object = scene.geometry.object.data();
    }
    void target(Bundle& outputs) {
        args.position = target_of(outputs, 0), args.normal = target_of(outputs, 1);
        args.albedo = target_of(outputs, 2), args.emission = target_of(outputs, 3);
        args.id = reinterpret_cast<std::int32_t*>(target_of(outputs, 4));
    }
    std::vector<double> indices(std::int32_t triangle) const {
        return {triangle < 0 ? -1.0 : double(args.object[triangle]), double(triangle)};
    }
    template <Isa isa>
    void resolve(const TilePixels& seen) const {
        ResolveTile<isa>::gbuffer(args, seen);
    }
    template <class F, class Tap>
    std::array<F, components> pixel(glm::ivec2, std::int32_t triangle, const vec2<F>& l, Tap& tap) const {
        const GBufferPixel<F> p = gbuffer<F>(args, triangle, l, tap);
        std::array<F, components> out;
        put(out.data(), p.position), put(out.data() + 4, p.normal);
        put(out.data() + 8, p.albedo), put(out.data() + 12, p.emission);
        return out;
    }
};

// What lies behind the input "behind" is BoundPass' to say.
struct GBufferLayerPass : GBufferPass {
    GBufferLayerPass(const StageData& data, const BoundScene& scene)
        : GBufferPass(uniforms_of<GBufferLayerUniforms>(data), data, scene) {}
};

struct RsmPass {
    static constexpr int components = 12;
    RsmArgs args{};

    RsmPass(const StageData& data, const BoundScene& scene) {
        const auto u = uniforms_of<RsmUniforms>(data);
        args.surfaces = surface_args(scene, u.viewer, u.forward, u.pixel_area);
        for (int c = 0; c < 3; ++c) args.eye[c] = u.eye[c], args.forward[c] = u.forward[c];
        args.light = u.light;
        args.texel_scale = u.texel_scale, args.half_width = u.half_width;
        args.size = data.size.x;
    }
    void target(Bundle& outputs) {
        args.position = target_of(outputs, 0), args.normal = target_of(outputs, 1), args.flux = target_of(outputs, 2);
    }
    std::vector<double> indices(std::int32_t) const { return {}; }
    template <Isa isa>
    void resolve(const TilePixels& seen) const {
        ResolveTile<isa>::rsm(args, seen);
    }
    template <class F, class Tap>
    std::array<F, components> pixel(glm::ivec2 p, std::int32_t triangle, const vec2<F>& l, Tap& tap) const {
        const RsmTexel<F> t = rsm<F>(args, p.x, p.y, triangle, l, tap);
        std::array<F, components> out;
        put(out.data(), t.position), put(out.data() + 4, t.normal), put(out.data() + 8, t.flux);
        return out;
    }
};

std::unique_ptr<BoundStage> bind_gbuffer(const StageData& data) {
    check_slots(gbuffer_binding(), data);
    return std::make_unique<BoundPass<GBufferPass>>(gbuffer_binding(), data);
}
std::unique_ptr<BoundStage> bind_gbuffer_layer(const StageData& data) {
    check_slots(gbuffer_layer_binding(), data);
    const float farther = uniforms_of<GBufferLayerUniforms>(data).farther, expected = data.reversed_z ? -1 : 1;
    if (farther != expected)
        throw InputError(fmt::format("{}: uniform farther = {:g}: expected {:g}, as the depth test is",
                                     data.label.empty() ? data.stage : data.label, farther, expected));
    return std::make_unique<BoundPass<GBufferLayerPass>>(gbuffer_layer_binding(), data);
}
std::unique_ptr<BoundStage> bind_rsm(const StageData& data) {
    check_slots(rsm_binding(), data);
    if (data.size.x != data.size.y)
        throw InputError(fmt::format("{}: size {} x {}: a map is square", data.label.empty() ? data.stage : data.label,
                                     data.size.x, data.size.y));
    return std::make_unique<BoundPass<RsmPass>>(rsm_binding(), data);
}

Slot buffer(const char* name, int binding, DType dtype, int channels, const char* unit, const char* meaning,
            std::uint32_t fixed = 0) {
    return {name, SlotKind::buffer, binding, dtype, channels, false, unit, meaning, fixed};
}
Slot target(const char* name, int location, const char* unit, const char* meaning) {
    return {name, SlotKind::target, location, DType::f32, 4, true, unit, meaning};
}
Slot depth_slot() {
    return {"depth", SlotKind::depth, 0, DType::f32, 1, true, "", "z of the depth buffer; cleared to 1, reversed z: 0"};
}

// What raster/surface.glsl and raster/pull_triangle.glsl bind.
std::vector<Slot> surface_slots() {
    return {
        buffer("vertices", 1, DType::f32, 4, "m", "[vertex][8]: position, u; normal, v"),
        buffer("triangles", 2, DType::i32, 1, "", "[triangle][3]: vertices"),
        buffer("triangle_material", 3, DType::i32, 1, "", "[triangle]: material"),
        buffer("materials", 4, DType::f32, 4, "W/m2",
               "[material][16]: reflectance, alpha; emission, alpha cutoff; rows of textures (base, emission, normal), "
               "scale of the normal; padding", 0xf700),
        buffer("tangents", 5, DType::f32, 4, "", "[vertex]: tangent, side of the bitangent; zeros where none is read",
               8),
        buffer("textures", 6, DType::i32, 4, "",
               "[row]: first texel, width, height, 1 nearest | 2 sRGB | 4 wrap u | 16 wrap v | 64 levels; 0 is white"),
        buffer("texels", 7, DType::i32, 1, "", "RGBA8 texels of all textures and levels"),
        buffer("decode", 8, DType::f32, 1, "", "[2][256]: byte to linear value, plain and sRGB"),
        buffer("clip_positions", 9, DType::f32, 4, "", "[vertex]: position in clip space, y down, 0 <= z <= w",
               15),
    };
}

StageBinding make_gbuffer() {
    using U = GBufferUniforms;
    StageBinding b;
    b.info = info_gbuffer();
    b.raster = true;
    b.domain = "pixel";
    b.twin = "raster/gbuffer";
    b.uniforms = {{"viewer", "vec4", offsetof(U, viewer), 8},
                  {"eye", "vec3", offsetof(U, eye)},
                  {"forward", "vec3", offsetof(U, forward)},
                  {"pixel_area", "float", offsetof(U, pixel_area)}};
    b.uniform_bytes = sizeof(U);
    b.inputs = surface_slots();
    b.inputs.push_back(buffer("objects", 10, DType::i32, 1, "", "[triangle]: object"));
    b.outputs = {
        target("position", 0, "m", "world-space position; w: linear eye depth"),
        target("normal", 1, "", "unit normal on the side that is seen; w: 1 covered"),
        target("albedo", 2, "", "diffuse reflectance rho, linear"),
        target("emission", 3, "W/m2", "radiant exitance"),
        {"id", SlotKind::target, 4, DType::i32, 2, true, "", "object, triangle; -1 where nothing is seen"},
        depth_slot(),
    };
    b.bind = bind_gbuffer;
    return b;
}

StageBinding make_gbuffer_layer() {
    using U = GBufferLayerUniforms;
    StageBinding b = make_gbuffer();
    b.info = info_gbuffer_layer();
    b.twin = "raster/gbuffer_layer";
    b.uniforms = {{"viewer", "vec4", offsetof(U, viewer), 8},
                  {"eye", "vec3", offsetof(U, eye)},
                  {"farther", "float", offsetof(U, farther), 1},
                  {"forward", "vec3", offsetof(U, forward)},
                  {"pixel_area", "float", offsetof(U, pixel_area)}};
    b.uniform_bytes = sizeof(U);
    b.inputs.push_back({"behind", SlotKind::image, 11, DType::f32, 1, true, "",
                        "z of the depth buffer of the layer before; what lies farther is drawn", 1});
    b.bind = bind_gbuffer_layer;
    return b;
}

StageBinding make_rsm() {
    using U = RsmUniforms;
    constexpr int light = offsetof(U, light);
    StageBinding b;
    b.info = info_rsm();
    b.raster = true;
    b.domain = "texel";
    b.twin = "raster/rsm";
    b.uniforms = {{"viewer", "vec4", offsetof(U, viewer), 8},
                  {"eye", "vec3", offsetof(U, eye)},
                  {"forward", "vec3", offsetof(U, forward)},
                  {"pixel_area", "float", offsetof(U, pixel_area)},
                  {"light.position", "vec3", light + int(offsetof(LightArgs, position))},
                  {"light.cos_outer", "float", light + int(offsetof(LightArgs, cos_outer))},
                  {"light.direction", "vec3", light + int(offsetof(LightArgs, direction))},
                  {"light.falloff_scale", "float", light + int(offsetof(LightArgs, falloff_scale))},
                  {"light.intensity", "vec3", light + int(offsetof(LightArgs, intensity))},
                  {"light.directional", "float", light + int(offsetof(LightArgs, directional)), 1},
                  {"light.inverse_radius2", "float", light + int(offsetof(LightArgs, inverse_radius2))},
                  {"light.radius2", "float", light + int(offsetof(LightArgs, radius2))},
                  {"texel_scale", "float", offsetof(U, texel_scale)},
                  {"half_width", "float", offsetof(U, half_width)}};
    b.uniform_bytes = sizeof(U);
    b.inputs = surface_slots();
    b.outputs = {
        target("position", 0, "m", "world-space position; w: linear depth from the light"),
        target("normal", 1, "", "unit normal on the side that the light sees; w: 1 covered"),
        target("flux", 2, "W", "reflected flux of the texel"),
        depth_slot(),
    };
    b.bind = bind_rsm;
    return b;
}

// Appends a buffer of `rows` rows; one row of zeros where there is none.
template <class T>
void add_rows(Bundle& inputs, const char* name, std::size_t rows, std::int64_t width, const T* values) {
    Array& array = add(inputs, name, dtype_of<T>, {std::max<std::int64_t>(std::int64_t(rows), 1), width});
    if (rows) std::memcpy(array.bytes.data(), values, array.bytes.size());
}

void add_scene(StageData& d, const Geometry& g, const Surfaces& s, const View& view) {
    const SurfaceArgs a = surface_args(g, s, view);
    const std::size_t n = g.triangles.size();
    const Buffer<glm::vec4> clip = clip_positions(g, view, 0);
    add_rows(d.inputs, "vertices", g.vertices.size(), 8, a.vertices);
    add_rows(d.inputs, "triangles", n, 3, a.triangles);
    add_rows(d.inputs, "triangle_material", n, 1, a.material);
    add_rows(d.inputs, "materials", s.materials.size() / record_stride, record_stride, a.materials);
    add_rows(d.inputs, "tangents", g.tangents.size(), 4, a.tangents);
    add_rows(d.inputs, "textures", s.textures.size() / 4, 4, a.textures.rows);
    add_rows(d.inputs, "texels", s.texels.size(), 1, a.textures.texels);
    add_rows(d.inputs, "decode", 2, 256, a.textures.decode);
    add_rows(d.inputs, "clip_positions", clip.size(), 4, clip.empty() ? nullptr : &clip.data()->x);
    d.reversed_z = view.reversed_z;
}

// The members that both blocks start with.
template <class Uniforms, class Args>
Uniforms viewer_uniforms(const Args& a) {
    Uniforms u{};
    for (int c = 0; c < 4; ++c) u.viewer[c] = a.surfaces.viewer[c];
    for (int c = 0; c < 3; ++c) u.eye[c] = a.eye[c], u.forward[c] = a.forward[c];
    u.pixel_area = a.surfaces.pixel_area;
    return u;
}

}  // namespace

const StageBinding& gbuffer_binding() {
    static const StageBinding binding = make_gbuffer();
    return binding;
}
const StageBinding& gbuffer_layer_binding() {
    static const StageBinding binding = make_gbuffer_layer();
    return binding;
}
const StageBinding& rsm_binding() {
    static const StageBinding binding = make_rsm();
    return binding;
}

StageData gbuffer_data(const Geometry& geometry, const Surfaces& surfaces, const View& view, glm::ivec2 size) {
    StageData d;
    d.stage = "gbuffer";
    d.size = size;
    d.uniforms = uniform_block(viewer_uniforms<GBufferUniforms>(gbuffer_args(geometry, surfaces, view, size)));
    add_scene(d, geometry, surfaces, view);
    add_rows(d.inputs, "objects", geometry.object.size(), 1, geometry.object.data());
    return d;
}

StageData gbuffer_layer_data(const Geometry& geometry, const Surfaces& surfaces, const View& view, glm::ivec2 size,
                             const Image1& behind) {
    check_behind(&behind, size);
    StageData d = gbuffer_data(geometry, surfaces, view, size);
    d.stage = "gbuffer.layer";
    auto u = viewer_uniforms<GBufferLayerUniforms>(gbuffer_args(geometry, surfaces, view, size));
    u.farther = view.reversed_z ? -1.0f : 1.0f;
    d.uniforms = uniform_block(u);
    add(d.inputs, "behind", behind);
    return d;
}

StageData rsm_data(const Geometry& geometry, const Surfaces& surfaces, const Light& light, const View& light_view) {
    StageData d;
    d.stage = "rsm";
    d.size = glm::ivec2(light.rsm_size);
    const RsmArgs args = rsm_args(geometry, surfaces, light, light_view);
    auto u = viewer_uniforms<RsmUniforms>(args);
    u.light = args.light;
    u.texel_scale = args.texel_scale, u.half_width = args.half_width;
    d.uniforms = uniform_block(u);
    add_scene(d, geometry, surfaces, light_view);
    return d;
}

}  // namespace plumb::raster
