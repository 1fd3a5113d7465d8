// Renderer C: gl/gather.frag and gl/direct.frag. Its textures and dumps have their lowest row first, its map's y points
// up.
#include <fstream>
#include <stdexcept>

#include "tests/foreign/renderers.h"

#ifdef PLUMB_WITH_OPENGL
#include "tests/foreign/gl_context.h"
#endif

namespace plumb::foreign {

#ifdef PLUMB_WITH_OPENGL

namespace {

constexpr float bias = 0.015f, range = 8, least_distance2 = 1e-4f;  // m, m, m2; the last as the shader has it

// The same matrix with y up.
glm::mat4 y_up(const Clip& clip) {
    glm::mat4 m(clip);
    for (int c = 0; c < 4; ++c) m[c][1] = -m[c][1];
    return m;
}

std::vector<float> columns(const glm::mat4& m) { return {&m[0].x, &m[0].x + 16}; }

struct Scene {
    Texture position, normal, map_position, map_normal, map_flux, map_depth;
    glm::mat4 light;
    Pattern kernel;  // y up
    int map_size = 0;
};

Scene scene_of(const Exported& e) {
    Scene s;
    s.map_size = int(e.number("shadow", "map.size"));
    s.light = y_up(clip_of(e.uniform("shadow", "map.to_texel_x"), e.uniform("shadow", "map.to_texel_y"),
                           e.uniform("shadow", "map.to_texel_w"), {s.map_size, s.map_size}, {0.05, 10}));
    s.kernel = spiral(24, 0.3f * float(s.map_size), true);
    const std::string gather = "rsm.disc_continuous";
    Image4 depth = e.image("shadow", "map_position");
    for (glm::vec4& d : depth.texels) d = {d.w > 0 ? d.w / range : 1, 0, 0, 0};
    s.position = upside_down(pack(e.image(gather, "position"), Format::rgba32f));
    s.normal = upside_down(pack_biased(e.image("compose", "normal"), Format::r10g10b10a2));
    s.map_position = upside_down(pack(e.image(gather, "rsm_position"), Format::rgba32f));
    s.map_normal = upside_down(pack(e.image(gather, "rsm_normal"), Format::rgba16f));
    s.map_flux = upside_down(pack(e.image(gather, "rsm_flux"), Format::rgba16f));
    s.map_depth = upside_down(pack(depth, Format::d32f));
    return s;
}

gl::Context& context() {
    static gl::Context one(chosen_device());
    return one;
}

struct Frame {
    Texture indirect, direct, lit;
};

Frame draw(const Exported& e, const Scene& s, const Variant& variant) {
    const gl::Filter filter = variant.host == "linear" ? gl::Filter::linear : gl::Filter::nearest;
    const gl::Border black = variant.host == "no border" ? gl::Border::edge : gl::Border::black;
    const gl::Sampled position{"u_position", variant.host == "last frame" ? moved(s.position, 2) : s.position},
        normal{"u_normal", s.normal};
    const gl::Uniform light{"u_light", 16, columns(variant.host == "row-major" ? glm::transpose(s.light) : s.light)};
    const glm::ivec2 size{e.width(), e.height()};
    const std::string vertex = shader_text("gl/fullscreen.vert", variant);

    std::vector<float> kernel;
    for (const glm::vec3& k : s.kernel) kernel.insert(kernel.end(), {k.x, k.y, k.z});
    Frame f;
    f.indirect = context().draw(size, vertex, shader_text("gl/gather.frag", variant),
                                {position,
                                 normal,
                                 {"u_rsm_position", s.map_position, filter, black},
                                 {"u_rsm_normal", s.map_normal, filter, black},
                                 {"u_rsm_flux", s.map_flux, filter, black}},
                                {light,
                                 {"u_map_size", 1, {float(s.map_size)}},
                                 {"u_count", 0, {float(s.kernel.size())}},
                                 {"u_kernel", 3, kernel}},
                                {"R32G32B32A32_SFLOAT"})[0];

    // raster/light.glsl: position, cos_outer; direction, falloff_scale; intensity, ...
    const std::vector<float> l = e.numbers("direct", "lights");
    const float cos_inner = float(double(l[3]) + 1 / double(l[7]));
    const std::vector<float> colour =
        variant.host == "rgb for bgr" ? std::vector<float>{l[10], l[9], l[8]} : std::vector<float>{l[8], l[9], l[10]};
    const std::vector<Texture> made =
        context().draw(size, vertex, shader_text("gl/direct.frag", variant),
                       {position, normal, {"u_shadow", s.map_depth, filter, gl::Border::white, true}},
                       {light,
                        {"u_light_position", 3, {l[0], l[1], l[2]}},
                        {"u_light_axis", 3, {l[4], l[5], l[6]}},
                        {"u_intensity", 3, colour},
                        {"u_cone", 2, {l[3], cos_inner}},
                        {"u_range", 1, {range}},
                        {"u_bias", 1, {bias}}},
                       {"R16G16B16A16_SFLOAT", "R32_SFLOAT"});
    f.direct = made[0], f.lit = made[1];
    return f;
}

}  // namespace

std::string no_opengl() {
    try {
        context();
        return "";
    } catch (const std::runtime_error& error) {
        return error.what();
    }
}

std::string render_in_opengl(const Exported& e, const Variant& variant, const std::string& folder) {
    const Scene s = scene_of(e);
    const Frame f = draw(e, s, variant);
    const io::DumpSpec position = write_texture(folder, "position", s.position);
    io::DumpSpec normal = write_texture(folder, "normal", s.normal, "", "biased");
    normal.normalized = true;
    const io::DumpSpec lit = write_texture(folder, "lit", f.lit, "x");
    // Where the normal's alpha is 0 nothing is seen.
    io::CoverageSpec covered{write_texture(folder, "normal", s.normal, "w")};
    covered.above = 0.5;

    io::ManifestStage gather = bare(e, "rsm.disc_continuous", "C: bounce");
    gather.stage = "rsm.disc";
    set_light(gather, s.light, true);
    gather.uniforms["least_distance2"] = {double(least_distance2)};
    for (const char* of_pattern : {"samples", "rotations", "reach"}) gather.uniforms.erase(of_pattern);
    gather.inputs = {{"position", position},
                     {"normal", normal},
                     {"rsm_position", write_texture(folder, "map_position", s.map_position)},
                     {"rsm_normal", write_texture(folder, "map_normal", s.map_normal)},
                     {"rsm_flux", write_texture(folder, "map_flux", s.map_flux)},
                     {"pattern", write_pattern(folder, "kernel", s.kernel)}};
    gather.inputs.at("pattern").y_up = true;
    gather.outputs = {{"irradiance", write_texture(folder, "indirect", f.indirect, "xyz")}};

    io::ManifestStage shadow = bare(e, "shadow", "C: shadow");
    set_light(shadow, s.light, true);
    shadow.uniforms["bias"] = {double(bias)};
    shadow.uniforms["slope_bias"] = {0};
    io::DumpSpec depth = write_texture(folder, "depth", s.map_depth, "000x", "linear_depth");
    depth.near_far = {0, double(range)};
    shadow.inputs = {{"position", position}, {"normal", normal}, {"map_position", depth}};
    shadow.outputs = {{"visibility", lit}};

    io::ManifestStage direct = bare(e, "direct", "C: direct");
    io::DumpSpec lights = e.stage("direct").inputs.at("lights");
    direct.inputs = {{"position", position}, {"normal", normal}, {"lights", lights}, {"visibility.0", lit}};
    direct.outputs = {{"irradiance", write_texture(folder, "direct", f.direct, "xyz")}};

    for (io::ManifestStage* stage : {&gather, &shadow, &direct}) stage->coverage = covered;

    io::Manifest manifest;
    manifest.file = folder + "/manifest.toml";
    manifest.device = "OpenGL: " + context().device();
    manifest.stages = {gather, shadow, direct};
    std::ofstream(manifest.file) << io::manifest_text(manifest);
    return manifest.file.string();
}

#else

std::string no_opengl() { return "built without OpenGL and EGL (libegl-dev, libgl-dev)"; }

std::string render_in_opengl(const Exported&, const Variant&, const std::string&) {
    throw std::runtime_error(no_opengl());
}

#endif

}  // namespace plumb::foreign
