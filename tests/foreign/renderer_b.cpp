// Renderer B: lighting.frag, ssao.frag, compose.frag, tonemap.frag: a deferred renderer's passes over the whole frame.
#include <filesystem>
#include <fstream>
#include <utility>

#include "tests/foreign/renderers.h"
#include "tests/foreign/vulkan_textures.h"

namespace plumb::foreign {

namespace {

constexpr glm::vec2 shadow_planes{0.05f, 6};    // m
constexpr float shadow_bias = 0.02f;            // m
constexpr glm::vec4 sky{0.2f, 0.35f, 0.6f, 0};  // W/(m2 sr)
constexpr float exposure = 1.5f;

struct GBuffer {
    Texture position;  // w: depth, 0 where nothing is
    Texture normal;    // octahedral
    Texture albedo;    // a: 1 on a surface
    Texture emission;

    GBuffer(const Exported& e, const Variant& variant) {
        const Image4 normals = e.image("compose", "normal");
        Image4 reflectance = e.image("compose", "albedo");
        for (std::size_t i = 0; i < reflectance.size(); ++i) reflectance.texels[i].w = normals.texels[i].w;
        position =
            pack(e.image("screen.ssao", "position"), variant.host == "half floats" ? Format::rgba16f : Format::rgba32f);
        normal = pack(normals, Format::octahedral16);
        albedo = pack(reflectance, Format::rgba8);
        emission = pack(e.image("compose", "emission"), Format::r11g11b10f);
    }
};

struct Camera {
    glm::mat4 world_to_clip;
    glm::vec4 eye, forward;
    float radius, bias;
    int count;
};

struct Spot {
    glm::mat4 world_to_map;
    glm::vec3 position;
    float cos_outer;
    glm::vec3 axis;
    float cos_inner;
    glm::vec3 colour;
    float bias;
    glm::vec2 planes;
};

struct Look {
    glm::vec4 ambient, sky;
};

// Depth as it is drawn, of linear depth; 1 where nothing is.
float drawn_depth(float metres) {
    const double n = double(shadow_planes.x), f = double(shadow_planes.y);
    return metres > 0 ? float(f / (f - n) * (1 - n / double(metres))) : 1.0f;
}

Spot spot_of(const Exported& e) {
    const int size = int(e.number("shadow", "map.size"));
    Spot s;
    s.world_to_map = glm::mat4(clip_of(e.uniform("shadow", "map.to_texel_x"), e.uniform("shadow", "map.to_texel_y"),
                                       e.uniform("shadow", "map.to_texel_w"), {size, size}, shadow_planes));
    // raster/light.glsl: position, cos_outer; direction, falloff_scale; intensity, ...
    const std::vector<float> light = e.numbers("direct", "lights");
    s.position = {light[0], light[1], light[2]};
    s.cos_outer = light[3];
    s.axis = {light[4], light[5], light[6]};
    s.cos_inner = float(double(light[3]) + 1 / double(light[7]));
    s.colour = {light[8], light[9], light[10]};
    s.bias = shadow_bias;
    s.planes = shadow_planes;
    return s;
}

Camera camera_of(const Exported& e) {
    const glm::dvec3 anchor = e.vector("screen.ssao", "view.anchor");
    const std::vector<double> forward = e.uniform("screen.ssao", "view.forward");
    const glm::ivec2 size{e.width(), e.height()};
    const Clip from_anchor =
        clip_of(e.uniform("screen.ssao", "view.to_x"), e.uniform("screen.ssao", "view.to_y"), forward, size, {0.1, 20});
    glm::dmat4 to_anchor(1);
    to_anchor[3] = glm::dvec4(-anchor, 1);
    Camera c;
    c.world_to_clip = glm::mat4(from_anchor * to_anchor);
    c.eye = glm::vec4(glm::dvec4(anchor, 0));
    c.forward = {float(forward[0]), float(forward[1]), float(forward[2]), 0};
    c.radius = float(e.number("screen.ssao", "radius"));
    c.bias = float(e.number("screen.ssao", "bias"));
    c.count = int(e.number("screen.ssao", "samples"));
    return c;
}

// Its outputs, pass by pass.
struct Frame {
    Texture shadow_map, turns, bounced;
    Texture direct, lit, open, radiance, soft, display;
};

class Passes {
  public:
    Passes(const vulkan::Device& device, const Exported& e, const GBuffer& g, const Variant& variant)
        : device_(device), e_(e), g_(g), variant_(variant), size_(e.width(), e.height()) {}

    Frame run() {
        Frame f;
        light(f);
        occlude(f);
        compose(f);
        f.display = draw("tonemap.frag", {block_bytes(glm::vec4(exposure)), {f.radiance}}, {"R8G8B8A8_UNORM"})[0];
        return f;
    }

  private:
    std::vector<Texture> draw(const std::string& file, PassInputs inputs, const std::vector<std::string>& formats) {
        if (variant_.host == "linear") inputs.filter = VK_FILTER_LINEAR;
        return draw_fullscreen(device_, size_, file, variant_, inputs, formats);
    }

    void light(Frame& f) {
        Image4 map = e_.image("shadow", "map_position");
        for (glm::vec4& texel : map.texels) texel = {drawn_depth(texel.w), 0, 0, 0};
        f.shadow_map = pack(map, Format::r32f);
        Spot spot = spot_of(e_);
        if (variant_.host == "row-major") spot.world_to_map = glm::transpose(spot.world_to_map);
        if (variant_.host == "rgb for bgr") std::swap(spot.colour.x, spot.colour.z);
        const Texture position = variant_.host == "last frame" ? moved(g_.position, 2) : g_.position;
        const std::vector<Texture> made =
            draw("lighting.frag", {block_bytes(spot), {position, g_.normal, f.shadow_map}},
                 {"R16G16B16A16_SFLOAT", "R32_SFLOAT"});
        f.direct = made[0], f.lit = made[1];
    }

    void occlude(Frame& f) {
        const std::vector<float> turns = e_.numbers("screen.ssao", "rotations");
        f.turns = {"R32G32_SFLOAT", 4, 4, {}, false};
        const auto* bytes = reinterpret_cast<const unsigned char*>(turns.data());
        f.turns.bytes.assign(bytes, bytes + turns.size() * sizeof(float));
        f.open =
            draw("ssao.frag",
                 {block_bytes(camera_of(e_)), {g_.position, g_.normal, f.turns}, e_.numbers("screen.ssao", "samples")},
                 {"R16_SFLOAT"})[0];
    }

    void compose(Frame& f) {
        const glm::dvec3 ambient = e_.vector("screen.occlude", "ambient");
        f.bounced = pack(e_.image("screen.occlude", "indirect"), Format::rgba16f);
        const std::vector<Texture> made = draw("compose.frag",
                                               {block_bytes(Look{glm::vec4(glm::dvec4(ambient, 0)), sky}),
                                                {g_.albedo, g_.emission, f.direct, f.bounced, f.open}},
                                               {"R16G16B16A16_SFLOAT", "R32G32B32A32_SFLOAT"});
        f.radiance = made[0], f.soft = made[1];
    }

    const vulkan::Device& device_;
    const Exported& e_;
    const GBuffer& g_;
    const Variant& variant_;
    const glm::ivec2 size_;
};

// What it wrote, and what of the stages that is.
class Dumps {
  public:
    Dumps(const Exported& e, const GBuffer& g, const Frame& f, const std::string& folder)
        : e_(e),
          g_(g),
          f_(f),
          folder_(folder),
          position_(write("position", g.position)),
          normal_(write("normal", g.normal, "xy", "octahedral")),
          albedo_(write("albedo", g.albedo)),
          emission_(write("emission", g.emission)),
          lit_(write("lit", f.lit, "x")),
          direct_(write("direct", f.direct, "xyz")),
          open_(write("open", f.open, "x")),
          soft_(write("soft", f.soft, "xyz")),
          radiance_(write("radiance", f.radiance, "xyz")) {
        // Where the albedo's alpha is 0 nothing is seen.
        covered_.dump = albedo_;
        covered_.dump.channels = "w";
    }

    std::vector<io::ManifestStage> stages() { return {shadow(), direct(), ssao(), occlude(), compose(), tonemap()}; }

  private:
    io::DumpSpec write(const std::string& name, const Texture& t, const std::string& channels = "",
                       const std::string& encoding = "plain") const {
        return write_texture(folder_, name, t, channels, encoding);
    }

    io::ManifestStage shadow() {
        const Spot spot = spot_of(e_);
        io::ManifestStage s = bare(e_, "shadow", "B: shadow");
        set_light(s, spot.world_to_map);
        set(s, "eye", spot.position);
        set(s, "forward", spot.axis);
        s.uniforms["bias"] = {double(spot.bias)};
        s.uniforms["slope_bias"] = {0};
        s.uniforms["kernel"] = {3};
        s.uniforms["samples"] = {9};
        io::DumpSpec map = write("shadow_map", f_.shadow_map, "000x", "depth");
        map.near_far = {double(spot.planes.x), double(spot.planes.y)};
        s.inputs = {{"position", position_}, {"normal", normal_}, {"map_position", map}};
        s.outputs = {{"visibility", lit_}};
        s.coverage = covered_;
        return s;
    }

    io::ManifestStage direct() {
        io::ManifestStage s = bare(e_, "direct", "B: direct");
        io::DumpSpec lights = e_.stage("direct").inputs.at("lights");
        lights.file = std::filesystem::absolute(lights.file);
        s.inputs = {{"position", position_}, {"normal", normal_}, {"lights", lights}, {"visibility.0", lit_}};
        s.outputs = {{"irradiance", direct_}};
        s.coverage = covered_;
        return s;
    }

    io::ManifestStage ssao() {
        io::ManifestStage s = bare(e_, "screen.ssao", "B: ambient occlusion");
        // No other view was summed before.
        s.inputs = {{"position", position_}, {"normal", normal_}, {"map_position", position_}};
        for (const char* buffer : {"samples", "rotations"})
            s.inputs[buffer] = e_.stage("screen.ssao").inputs.at(buffer);
        s.outputs = {{"summed", open_}};
        s.coverage = covered_;
        return s;
    }

    io::ManifestStage occlude() {
        io::ManifestStage s = bare(e_, "screen.occlude", "B: light from everywhere");
        // x: the open share; w: 1 on a surface.
        io::DumpSpec open = open_;
        open.channels = "x00";
        open.w = {covered_.dump};
        bounced_ = write("bounced", f_.bounced);
        s.inputs = {{"indirect", bounced_}, {"open", open}};
        s.outputs = {{"occluded", soft_}};
        return s;
    }

    io::ManifestStage compose() {
        io::ManifestStage s = bare(e_, "compose", "B: compose");
        set(s, "environment", glm::vec3(sky));
        io::DumpSpec covered = albedo_;
        covered.channels = "000w";
        s.inputs = {{"normal", covered},
                    {"albedo", albedo_},
                    {"emission", emission_},
                    {"direct", direct_},
                    {"indirect", soft_}};
        s.inputs["albedo"].channels = "xyz";
        s.outputs = {{"radiance", radiance_}};
        return s;
    }

    io::ManifestStage tonemap() {
        io::ManifestStage s = bare(e_, "tonemap", "B: tonemap");
        s.uniforms["exposure"] = {double(exposure)};
        s.inputs = {{"radiance", radiance_}};
        s.outputs = {{"display", write("display", f_.display)}};
        return s;
    }

    const Exported& e_;
    const GBuffer& g_;
    const Frame& f_;
    const std::string folder_;
    io::DumpSpec position_, normal_, albedo_, emission_, lit_, direct_, open_, soft_, radiance_, bounced_;
    io::CoverageSpec covered_;
};

}  // namespace

std::string render_deferred(const vulkan::Device& device, const Exported& e, const Variant& variant,
                            const std::string& folder) {
    const GBuffer g(e, variant);
    const Frame f = Passes(device, e, g, variant).run();
    io::Manifest manifest;
    manifest.file = folder + "/manifest.toml";
    manifest.device = device.name();
    manifest.stages = Dumps(e, g, f, folder).stages();
    std::ofstream(manifest.file) << io::manifest_text(manifest);
    return manifest.file.string();
}

}  // namespace plumb::foreign
