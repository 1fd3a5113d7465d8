// Scenes from a number: small, odd and often degenerate, for properties that have to hold of every scene.
#pragma once

#include <cstdint>

#include "core/hash.h"
#include "core/host_math.h"
#include "gi/frame/settings.h"

namespace plumb::test {

// A stream of hashed numbers.
class Dice {
  public:
    explicit Dice(std::uint32_t seed) : seed_(std::int32_t(seed)) {}
    std::uint32_t word() { return std::uint32_t(pcg(seed_ + pcg(next_++))); }
    int below(int n) { return int(word() % std::uint32_t(n)); }
    bool one_in(int n) { return below(n) == 0; }
    float unit() { return float(word() >> 8) * 0x1p-24f; }
    float between(float a, float b) { return a + (b - a) * unit(); }
    glm::vec3 in_box(glm::vec3 low, glm::vec3 high) {
        const float x = between(low.x, high.x), y = between(low.y, high.y);
        return {x, y, between(low.z, high.z)};
    }
    glm::vec3 direction() {
        glm::vec3 v = in_box(glm::vec3(-1), glm::vec3(1));
        if (dot3(v, v) < 0.01f) v = {0, -1, 0};
        return normalize3<float>(v);
    }
    // So far from the origin. One draw a statement: compilers order the operands of an expression as they like.
    glm::vec3 away(float least, float most) {
        const float distance = between(least, most);
        return direction() * distance;
    }

  private:
    std::int32_t seed_, next_ = 0;
};

// A parallelogram from three corners; counter-clockwise seen from its front.
inline void add_quad(Mesh& mesh, glm::vec3 a, glm::vec3 b, glm::vec3 d, int material) {
    const glm::vec3 u = b - a, v = d - a;
    const glm::vec3 n(u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x);
    const unsigned first = unsigned(mesh.vertices.size());
    const float coordinates[4][2] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    int k = 0;
    for (glm::vec3 p : {a, b, b + v, d}) {
        mesh.vertices.push_back({p, coordinates[k][0], normalize3<float>(n), coordinates[k][1]});
        ++k;
    }
    mesh.triangles.push_back(glm::uvec3(first, first + 1, first + 2));
    mesh.triangles.push_back(glm::uvec3(first, first + 2, first + 3));
    mesh.material.insert(mesh.material.end(), 2, material);
}

// Seen from outside, or, turned inside out, a room.
inline void add_box(Mesh& mesh, glm::vec3 low, glm::vec3 high, int material, bool room = false) {
    const glm::vec3 e = high - low, x(e.x, 0, 0), y(0, e.y, 0), z(0, 0, e.z);
    auto side = [&](glm::vec3 a, glm::vec3 u, glm::vec3 v) {
        room ? add_quad(mesh, a, a + v, a + u, material) : add_quad(mesh, a, a + u, a + v, material);
    };
    side(low, z, y), side(low + x, y, z), side(low, x, z), side(low + y, z, x), side(low, y, x), side(low + z, x, y);
}

// A ball of n strips with smooth normals.
inline void add_ball(Mesh& mesh, glm::vec3 centre, float radius, int n, int material) {
    const unsigned first = unsigned(mesh.vertices.size()), columns = unsigned(2 * n + 1);
    for (int i = 0; i <= n; ++i)
        for (int j = 0; j <= 2 * n; ++j) {
            const double down = host::pi * i / n, around = host::pi * j / n;
            const glm::vec3 d(host::sin(down) * host::cos(around), host::cos(down), -host::sin(down) * host::sin(around));
            mesh.vertices.push_back({centre + radius * d, float(j) / float(2 * n), d, float(i) / float(n)});
        }
    for (unsigned i = 0; i < unsigned(n); ++i)
        for (unsigned j = 0; j < 2 * unsigned(n); ++j) {
            const unsigned a = first + i * columns + j, b = a + columns;
            mesh.triangles.push_back(glm::uvec3(a, b, a + 1));
            mesh.triangles.push_back(glm::uvec3(a + 1, b, b + 1));
            mesh.material.insert(mesh.material.end(), 2, material);
        }
}

inline void add_materials(Dice& dice, Scene& s) {
    const bool all_black = dice.one_in(6), one_reflects = dice.one_in(3), none_emits = dice.one_in(3), dark_texture = dice.one_in(8);
    const bool all_masked = dice.one_in(7);
    Texture texture;
    texture.name = "texture";
    texture.texels = Image<std::uint32_t>(3, 2);
    for (std::uint32_t& texel : texture.texels.texels)
        texel = dark_texture ? 0xff000000u : dice.word() | 0xff000000u;
    texture.filter = dice.one_in(2) ? Filter::nearest : Filter::bilinear;
    s.textures.push_back(texture);
    for (int m = 0; m < 5; ++m) {
        Material& material = s.materials.emplace_back();
        material.name = "m" + std::to_string(m);
        const bool black = all_black || (one_reflects ? m > 0 : dice.one_in(4));
        if (black) material.reflectance = glm::vec3(m % 2 ? -0.0f : 0.0f);
        if (!black) material.reflectance = dice.in_box(glm::vec3(0.1f), glm::vec3(0.9f));
        if (none_emits) material.emission = glm::vec3(m % 3 ? 0.0f : -0.0f);
        if (!none_emits && dice.one_in(3)) material.emission = dice.in_box(glm::vec3(0), glm::vec3(4));
        if (dark_texture || dice.one_in(3)) material.texture = 0;
        if (dice.one_in(4)) material.emission_texture = 0;
        if (all_masked) material.alpha = 0, material.alpha_cutoff = 0.5f;
    }
}

inline void add_meshes(Dice& dice, Scene& s) {
    if (dice.one_in(12)) return;
    const bool room = dice.one_in(2);
    if (room || dice.one_in(2)) {
        Mesh& mesh = s.meshes.emplace_back();
        if (room)
            add_box(mesh, {-2, -1, -2}, {2, 3, 2}, dice.below(5), true);
        else
            add_quad(mesh, {-2, -1, 2}, {2, -1, 2}, {-2, -1, -2}, dice.below(5));
    }
    const int things = 1 + dice.below(3);
    for (int i = 0; i < things; ++i) {
        Mesh& mesh = s.meshes.emplace_back();
        const glm::vec3 at = dice.in_box({-1.5f, -0.8f, -1.5f}, {1.5f, 2, 1.5f});
        const float size = dice.between(0.1f, 0.6f);
        const bool round = dice.one_in(2);
        const int material = dice.below(5);
        if (round)
            add_ball(mesh, at, size, 3 + dice.below(3), material);
        else
            add_box(mesh, at - glm::vec3(size), at + glm::vec3(size), material);
    }
    // The one material that always reflects is on one thing.
    if (things > 1) s.meshes.back().material.assign(s.meshes.back().triangles.size(), 0);
    for (Mesh& mesh : s.meshes) mesh.name = "mesh" + std::to_string(&mesh - s.meshes.data());
}

inline void add_lights(Dice& dice, Scene& s) {
    const int lights = dice.below(4);
    const bool one_reflects = s.materials[0].reflectance != glm::vec3(0) && s.materials[1].reflectance == glm::vec3(0);
    for (int i = 0; i < lights; ++i) {
        Light& light = s.lights.emplace_back();
        light.name = "light" + std::to_string(i);
        light.type = dice.one_in(2) ? LightType::spot : LightType(dice.below(3));
        const bool outside = dice.one_in(3);
        light.position = outside ? dice.away(5, 9) : dice.in_box({-1.8f, 0, -1.8f}, {1.8f, 2.8f, 1.8f});
        const glm::vec3 outwards = normalize3<float>(light.position + glm::vec3(0.01f));
        light.direction = dice.one_in(3) ? outwards : dice.one_in(3) ? dice.direction() : -outwards;
        light.cone_outer_deg = dice.between(3, 80);
        if (!s.meshes.empty() && dice.below(5) < (one_reflects ? 4 : 1)) {
            // A narrow beam on one of the things, and on no other if there is luck.
            const Mesh& target = s.meshes[std::size_t(dice.below(int(s.meshes.size())))];
            const glm::vec3 middle = 0.5f * (target.vertices.front().position + target.vertices.back().position);
            light.direction = normalize3<float>(middle - light.position + glm::vec3(0.001f));
            light.cone_outer_deg = dice.between(1, 6);
        }
        light.cone_inner_deg = light.cone_outer_deg * dice.unit();
        light.intensity = dice.one_in(5) ? glm::vec3(0) : dice.in_box(glm::vec3(0.5f), glm::vec3(20));
        light.on = !dice.one_in(5);
        light.rsm_size = 8 + dice.below(25);
    }
}

inline Scene random_scene(std::uint32_t seed) {
    Dice dice(seed);
    Scene s;
    s.name = "random " + std::to_string(seed);
    add_materials(dice, s);
    add_meshes(dice, s);
    add_lights(dice, s);
    if (dice.one_in(2)) s.environment.radiance = dice.in_box(glm::vec3(0), glm::vec3(1));
    s.camera.position = glm::dvec3(dice.away(0.5f, 8));
    s.camera.look_at = dice.one_in(6) ? s.camera.position * 2.0 : glm::dvec3(dice.in_box(glm::vec3(-1), glm::vec3(1)));
    s.camera.up = {0.1, 1, 0.2};  // along no line of sight
    s.camera.fov_y_deg = dice.between(20, 90);
    s.camera.near = 0.05;
    s.camera.far = 100;
    s.camera.reversed_z = dice.one_in(2);
    s.convention = Convention(dice.below(5));
    const glm::ivec2 sizes[] = {{33, 17}, {16, 16}, {49, 31}, {1, 40}, {64, 20}};
    s.frame_size = sizes[dice.below(5)];
    s.seed = dice.word() & 0xffff;
    // Some of its materials also mirror half of what they do not reflect.
    Dice mirror(seed ^ 0x1b873593u);
    for (Material& m : s.materials)
        if (mirror.one_in(3)) m.mirror = 0.5f * (glm::vec3(1) - glm::max(m.reflectance, m.specular));
    return s;
}

inline void add_isr(Dice& dice, isr::IsrParams& p) {
    p.rings = 1 + dice.below(3), p.spacing = float(1 + dice.below(3));
    p.ssao_rings = 1 + dice.below(2), p.ssao_spacing = float(1 + dice.below(2));
    p.rotations = 1 << dice.below(3);
    p.mode = dice.one_in(4) ? isr::Mode(dice.below(4)) : isr::Mode::f2;
    if (dice.one_in(3)) p.bounces = 2;
    if (dice.one_in(4)) p.far_rings = 1, p.full_depth = dice.between(0.5f, 4);
    if (dice.one_in(4)) p.guard = 2 * (1 + dice.below(6));
    if (dice.one_in(4)) p.layers = 2;
    if (dice.one_in(4)) p.cameras = 1 + dice.below(2), p.camera_angle = dice.between(5, 90);
    if (dice.one_in(5)) p.variant = isr::Variant::published, p.layers = 1, p.cameras = 0;
    p.blur = isr::Blur(dice.below(3)), p.blur_radius = 1 + dice.below(3);
    p.upsample = isr::Upsample(dice.below(2));
    if (dice.one_in(4) && p.blur != isr::Blur::edge_aware) p.position = isr::Position::inverse_matrix;
    p.k_isr = dice.one_in(2) ? 0 : dice.unit();
    p.k_ssao = dice.one_in(2) ? 0 : dice.unit();
    if (dice.one_in(3)) p.ambient = isr::Ambient::none;
    // Without dice: what the others say stays as it was.
    const bool rings = p.variant == isr::Variant::corrected && (p.blur_radius + p.ssao_rings) % 2 == 0;
    if (rings) p.reach = 0.25f * p.spacing, p.spacing = 0;
}

inline frame::Settings random_settings(std::uint32_t seed) {
    Dice dice(seed ^ 0x9e3779b9u);
    frame::Settings t;
    t.shadow.mode = direct::ShadowMode::hard, t.shadow.test = direct::ShadowTest(pcg(seed) % 3);
    t.method = dice.one_in(10) ? frame::Method::reference : dice.one_in(4) ? frame::Method::direct : frame::Method::rsm;
    t.truth = dice.one_in(6);
    t.layout = raster::layouts()[std::size_t(dice.below(int(raster::layouts().size())))];
    t.rsm.gather = dice.one_in(6) ? rsm::Gather::all_rays : dice.one_in(4) ? rsm::Gather::all : rsm::Gather::disc;
    t.rsm.samples = 4 + dice.below(12);
    t.rsm.rotations = 1 << dice.below(4);
    t.rsm.radius = dice.between(0.05f, 0.8f);
    t.rsm.projection = rsm::Projection(dice.below(2));
    t.rsm.variant = rsm::Variant(dice.below(2));
    if (dice.one_in(3)) t.shadow.mode = direct::ShadowMode::density, t.shadow.kernel = 1 + dice.below(4);
    if (dice.one_in(4)) t.shadow.variant = direct::ShadowVariant::published, t.shadow.bias = dice.between(0, 2);
    // Of its own dice: what the others say stays as it was.
    Dice soft(seed ^ 0x51ed270bu);
    if (soft.one_in(3)) {
        t.shadow.mode = soft.one_in(3) ? direct::ShadowMode::pcf : direct::ShadowMode::esm;
        t.shadow.esm_blur_radius = soft.below(4);
    }
    Dice smooth(seed ^ 0x6a09e667u);
    if (smooth.one_in(3)) {
        t.shadow.filter = direct::VisibilityFilter(1 + smooth.below(2));
        t.shadow.filter_radius = 1 + smooth.below(4);
    }
    t.reference.samples = 2;
    t.seed = dice.word() & 0xffff;
    if (t.rsm.gather == rsm::Gather::disc && dice.one_in(2)) {
        t.rsm.gather = rsm::Gather::paths;
        t.rsm.directions = 1 + dice.below(5), t.rsm.steps = 1 + dice.below(5);
        t.rsm.visibility = rsm::Visibility(dice.below(4)), t.rsm.slots = 2 + dice.below(8);
        t.rsm.slot_edges = rsm::SlotEdges(dice.below(2)), t.rsm.jitter = dice.unit(), t.rsm.turn_jitter = dice.unit();
        if (dice.one_in(2)) t.rsm.turn = rsm::Turn::tile, t.rsm.rotations = 16;
    }
    Dice spaced(seed ^ 0x3c6ef372u);
    t.rsm.spacing = rsm::Spacing(spaced.below(3)), t.rsm.growth = 1 + 200 * spaced.unit();
    t.rsm.sample_area = rsm::SampleArea(spaced.below(2));
    if (spaced.one_in(2)) t.rsm.thickness = spaced.between(0, 2);
    if (dice.one_in(3)) t.compose.shadow_color = dice.in_box(glm::vec3(0), glm::vec3(1));
    if (dice.one_in(5)) t.direct.variant = direct::DirectVariant::published;
    if (t.method == frame::Method::rsm && dice.below(9) < 4) t.method = frame::Method::isr;
    if (t.method == frame::Method::isr) add_isr(dice, t.isr);
    Dice plain(seed ^ 0x2545f491u);
    if (t.method == frame::Method::direct && plain.one_in(3)) {
        t.method = frame::Method::zbuffer;
        t.zbuffer.technique = zbuffer::Technique(plain.below(7)), t.zbuffer.lobe = zbuffer::Lobe(plain.below(2));
        t.zbuffer.range = zbuffer::Range(plain.below(2)), t.zbuffer.ambient = plain.in_box(glm::vec3(0), glm::vec3(1));
    }
    if (t.method == frame::Method::direct && plain.one_in(3)) t.method = frame::Method::radiosity, t.radiosity.size = 2 + 2 * plain.below(5);
    Dice open(seed ^ 0x7f4a7c15u);
    if (open.one_in(3)) {
        t.ao.method = open.one_in(4) ? screen::AoMethod::horizon : screen::AoMethod::ssao;
        t.ao.radius = open.between(0.1f, 2), t.ao.samples = 1 + open.below(16), t.ao.slices = t.ao.steps = 2;
        t.ao.blur = screen::AoBlur(open.below(3)), t.ao.ambient = open.in_box(glm::vec3(0), glm::vec3(1));
        if (t.ao.method == screen::AoMethod::ssao) {
            t.ao.views = screen::AoViews(open.one_in(4) ? 0 : 1);
            if (open.one_in(4)) t.ao.variant = screen::AoVariant::published;
        }
    }
    Dice mirror(seed ^ 0x5bd1e995u);
    if (mirror.one_in(3)) {
        screen::ReflectParams& p = t.reflect;
        p.march = screen::March(1 + mirror.below(2)), p.views = screen::ReflectViews(mirror.below(2));
        p.step = mirror.between(0.05f, 1), p.steps = 1 + mirror.below(24), p.bisections = mirror.below(6);
        if (mirror.one_in(3)) p.fade = mirror.between(0, 0.5f), p.attenuation = mirror.between(0, 5);
        p.cells = 1 + mirror.below(100);
        if (p.march == screen::March::steps && p.views == screen::ReflectViews::camera && mirror.one_in(4)) p.variant = screen::ReflectVariant::published;
        if (p.variant == screen::ReflectVariant::corrected && mirror.one_in(3)) p.layers = 1 + mirror.below(2);
        if (p.variant == screen::ReflectVariant::corrected && mirror.one_in(3)) p.lobe = screen::Lobe::phong, p.rays = 1 + mirror.below(3);
    }
    if (t.rsm.gather == rsm::Gather::all_rays) return t;  // a truth is not filtered
    if (dice.one_in(3)) t.indirect.resolution = filter::Resolution::half;
    if (dice.one_in(3)) t.indirect.blur = filter::Blur(dice.below(4));
    t.indirect.upsample = filter::Upsample(dice.below(3)), t.indirect.similarity = filter::Similarity(dice.below(2));
    t.indirect.kernel = 1 + 2 * dice.below(4);
    return t;
}

}  // namespace plumb::test
