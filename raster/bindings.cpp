#include "raster/bindings.h"

#include <fmt/format.h>

#include "core/error.h"
#include "core/kernel_stage.h"
#include "raster/bound_pass.h"
#include "raster/pass_args.h"
#include "raster/resolve_tiles.h"
#include "raster/screen_triangle.h"
#include "raster/visibility.h"
#include "twins/raster.gbuffer.h"
#include "twins/raster.gbuffer_layer.h"
#include "twins/raster.rsm.h"

namespace plumb::raster {
namespace {

template <class T>
void aim(T*& target, Bundle& outputs, const std::string& name) {
    for (Array& array : outputs.arrays)
        if (array.name == name) return void(target = reinterpret_cast<T*>(array.bytes.data()));
    throw std::logic_error(name + " is no output of the pass");
}

// What raster/surface.glsl reads.
std::vector<NamedSlot> surface_inputs() {
    return {
        {.name = "vertices", .unit = "m", .meaning = "[vertex][8]: position, u; normal, v"},
        {.name = "triangles", .meaning = "[triangle][3]: vertices"},
        {.name = "triangle_material", .meaning = "[triangle]: material"},
        {.name = "materials", .unit = "W/m2",
         .meaning = "[material][16]: reflectance, alpha; emission, alpha cutoff; rows of textures (base, emission, "
                    "normal), scale of the normal; padding",
         .fixed = 0xf700},
        {.name = "tangents", .meaning = "[vertex]: tangent, side of the bitangent; zeros where none is read",
         .fixed = 8},
        {.name = "textures",
         .meaning = "[row]: first texel, width, height, 1 nearest | 2 sRGB | 4 wrap u | 16 wrap v | 64 levels; 0 is "
                    "white"},
        {.name = "texels", .meaning = "RGBA8 texels of all textures and levels"},
        {.name = "decode", .meaning = "[2][256]: byte to linear value, plain and sRGB"},
    };
}

// What every pass binds: that, and what raster/pull_triangle.glsl reads.
std::vector<NamedSlot> drawn_inputs() {
    std::vector<NamedSlot> all = surface_inputs();
    all.push_back({.name = "clip_positions", .meaning = "[vertex]: position in clip space, y down, 0 <= z <= w",
                   .fixed = 15});
    return all;
}

NamedSlot depth_buffer() { return {.name = "depth", .meaning = "z of the depth buffer; cleared to 1, reversed z: 0"}; }

template <class F>
void put(F* out, const vec4<F>& v) {
    out[0] = v.x, out[1] = v.y, out[2] = v.z, out[3] = v.w;
}

struct GBufferPass {
    using Uniforms = GBufferUniforms;
    using Twin = twins::raster_gbuffer;
    static constexpr int components = 16;
    GBufferArgs args{};

    static NamedStage describe() {
        NamedStage s{
            .name = "gbuffer",
            .source = "ISR 4.2-4.3, VRSM 4.2, LRA 4.2.1",
            .domain = "pixel",
            .inputs = drawn_inputs(),
            .outputs = {{.name = "position", .unit = "m", .meaning = "world-space position; w: linear eye depth"},
                        {.name = "normal", .meaning = "unit normal on the side that is seen; w: 1 covered"},
                        {.name = "albedo", .meaning = "diffuse reflectance rho, linear"},
                        {.name = "emission", .unit = "W/m2", .meaning = "radiant exitance"},
                        {.name = "id", .meaning = "object, triangle; -1 where nothing is seen"},
                        depth_buffer()},
            .fixed_uniforms = {{"viewer", 8}},
        };
        s.inputs.push_back({.name = "objects", .meaning = "[triangle]: object"});
        return s;
    }
    static void set_kept(std::vector<Port>& outputs) { outputs.at(2).meaning += "; w: the layout's radiation mask"; }

    GBufferPass(const StageData& data, const BoundScene& scene)
        : GBufferPass(uniforms_of<Uniforms>(data), data, scene) {}
    template <class Block>
    GBufferPass(const Block& u, const StageData& data, const BoundScene& scene) {
        args.surfaces = surface_args(scene, u.viewer, u.forward, u.pixel_area);
        for (int c = 0; c < 3; ++c) args.eye[c] = u.eye[c], args.forward[c] = u.forward[c];
        args.width = data.size.x, args.height = data.size.y;
        args.object = scene.geometry.object.data();
    }
    void target(Bundle& outputs) {
        aim(args.position, outputs, "position"), aim(args.normal, outputs, "normal");
        aim(args.albedo, outputs, "albedo"), aim(args.emission, outputs, "emission"), aim(args.id, outputs, "id");
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
    using Uniforms = GBufferLayerUniforms;
    using Twin = twins::raster_gbuffer_layer;

    static NamedStage describe() {
        NamedStage s = GBufferPass::describe();
        s.name = "gbuffer.layer", s.source = "ISR ch. 6, Everitt 2001";
        s.inputs.push_back({.name = "behind",
                            .meaning = "z of the depth buffer of the layer before; what lies farther is drawn",
                            .fixed = 1, .channels = 1});
        s.fixed_uniforms.push_back({"farther", 1});
        return s;
    }
    static std::string refuses(const StageData& data) {
        const float farther = uniforms_of<Uniforms>(data).farther, expected = data.reversed_z ? -1 : 1;
        if (farther == expected) return "";
        return fmt::format("uniform farther = {:g}: expected {:g}, as the depth test is", farther, expected);
    }
    GBufferLayerPass(const StageData& data, const BoundScene& scene)
        : GBufferPass(uniforms_of<Uniforms>(data), data, scene) {}
};

struct RsmPass {
    using Uniforms = RsmUniforms;
    using Twin = twins::raster_rsm;
    static constexpr int components = 12;
    RsmArgs args{};

    static NamedStage describe() {
        return {
            .name = "rsm",
            .source = "VRSM 4.2, LRA 4.2.2",
            .domain = "texel",
            .inputs = drawn_inputs(),
            .outputs = {{.name = "position", .unit = "m",
                         .meaning = "world-space position; w: linear depth from the light"},
                        {.name = "normal", .meaning = "unit normal on the side that the light sees; w: 1 covered"},
                        {.name = "flux", .unit = "W", .meaning = "reflected flux of the texel"},
                        depth_buffer()},
            .fixed_uniforms = {{"viewer", 8}, {"light.directional", 1}},
        };
    }
    // A map keeps no depth buffer, but records, which no shader writes.
    static void set_kept(std::vector<Port>& outputs) {
        outputs.back() = {"records", "records rsm", "", "position, normal and flux, a texel a record"};
    }
    static std::string refuses(const StageData& data) {
        if (data.size.x == data.size.y) return "";
        return fmt::format("size {} x {}: a map is square", data.size.x, data.size.y);
    }

    RsmPass(const StageData& data, const BoundScene& scene) {
        const auto u = uniforms_of<Uniforms>(data);
        args.surfaces = surface_args(scene, u.viewer, u.forward, u.pixel_area);
        for (int c = 0; c < 3; ++c) args.eye[c] = u.eye[c], args.forward[c] = u.forward[c];
        args.light = u.light;
        args.texel_scale = u.texel_scale, args.half_width = u.half_width;
        args.size = data.size.x;
    }
    void target(Bundle& outputs) {
        aim(args.position, outputs, "position"), aim(args.normal, outputs, "normal"), aim(args.flux, outputs, "flux");
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

// The one binding of a pass.
template <class Pass>
const StageBinding& pass_binding() {
    static_assert(Pass::Twin::template fits<typename Pass::Uniforms>());
    static const StageBinding binding = [] {
        StageBinding b = binding_of(Pass::describe(), Pass::Twin::layout);
        if constexpr (requires { Pass::set_kept(b.info.outputs); }) Pass::set_kept(b.info.outputs);
        b.bind = [](const StageData& data) -> std::unique_ptr<BoundStage> {
            check_slots(pass_binding<Pass>(), data);
            if constexpr (requires { Pass::refuses(data); })
                if (const std::string cause = Pass::refuses(data); !cause.empty())
                    throw InputError((data.label.empty() ? data.stage : data.label) + ": " + cause);
            return std::make_unique<BoundPass<Pass>>(pass_binding<Pass>(), data);
        };
        return b;
    }();
    return binding;
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

const StageBinding& gbuffer_binding() { return pass_binding<GBufferPass>(); }
const StageBinding& gbuffer_layer_binding() { return pass_binding<GBufferLayerPass>(); }
const StageBinding& rsm_binding() { return pass_binding<RsmPass>(); }

std::vector<Port> surface_ports() {
    std::vector<Port> ports;
    for (const Port& port : gbuffer_binding().info.inputs)
        for (const NamedSlot& s : surface_inputs())
            if (s.name == port.name) ports.push_back(port);
    return ports;
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
