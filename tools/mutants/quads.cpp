#include "tools/mutants/quads.h"

#include "core/hash.h"
#include "core/number.h"

namespace plumb::mutants {
namespace {

// Texels without any order, so that each wrong one shows; alpha too.
Texture noise(const std::string& name, int width, int height, std::uint32_t seed) {
    Texture t;
    t.name = name;
    t.texels = Image<std::uint32_t>(width, height);
    for (std::size_t i = 0; i < t.texels.size(); ++i) t.texels.data()[i] = pcg<std::uint32_t>(std::uint32_t(i) * 977u + seed);
    return t;
}

// Normals that lean to all sides: blue stays high. Marked as sRGB, which a normal map is never read as.
Texture bumps(int width, int height) {
    Texture t = noise("bumps", width, height, 71);
    for (std::size_t i = 0; i < t.texels.size(); ++i) t.texels.data()[i] = (t.texels.data()[i] & 0xff3fffffu) | 0x00c00000u;
    return t;
}

struct Panel {
    glm::vec3 corner, along_u, along_v;  // m
    glm::vec2 repeat{1, 1};              // texture coordinates at the far corner
    int material = 0;
    float bend = 0;         // how far the corners' normals lean outwards; below 0: there are none
    bool tangents = false;
    bool mirrored = false;  // the bitangent's side
};

void add(Mesh& mesh, const Panel& p) {
    const glm::vec3 n = normalize3<float>(glm::vec3(p.along_u.y * p.along_v.z - p.along_u.z * p.along_v.y,
                                                   p.along_u.z * p.along_v.x - p.along_u.x * p.along_v.z,
                                                   p.along_u.x * p.along_v.y - p.along_u.y * p.along_v.x));
    const unsigned first = unsigned(mesh.vertices.size());
    for (const glm::vec2 c : {glm::vec2(0, 0), glm::vec2(1, 0), glm::vec2(1, 1), glm::vec2(0, 1)}) {
        const glm::vec3 lean = p.along_u * (c.x - 0.5f) + p.along_v * (c.y - 0.5f);
        const glm::vec3 normal = p.bend < 0 ? glm::vec3(0) : normalize3<float>(n + p.bend * lean);
        // Texture coordinates start off zero, and run through it.
        const glm::vec2 uv = (c - 0.31f) * p.repeat;
        mesh.vertices.push_back({p.corner + p.along_u * c.x + p.along_v * c.y, uv.x, normal, uv.y});
        const glm::vec3 t = normalize3<float>(p.along_u + 0.2f * c.y * p.along_v);
        mesh.tangents.push_back(p.tangents ? glm::vec4(t, p.mirrored ? -1 : 1) : glm::vec4(0));
    }
    mesh.triangles.push_back(glm::uvec3(first, first + 1, first + 2));
    mesh.triangles.push_back(glm::uvec3(first, first + 2, first + 3));
    mesh.material.insert(mesh.material.end(), 2, p.material);
}

int add(Scene& scene, const Material& material) {
    scene.materials.push_back(material);
    return int(scene.materials.size()) - 1;
}

int add(Scene& scene, Texture texture, Wrap u, Wrap v, Filter filter = Filter::bilinear) {
    texture.wrap_u = u, texture.wrap_v = v, texture.filter = filter;
    scene.textures.push_back(std::move(texture));
    return int(scene.textures.size()) - 1;
}

Material textured(int texture, const glm::vec3& reflectance = glm::vec3(0.9f, 0.8f, 0.7f)) {
    Material m;
    m.reflectance = reflectance, m.texture = texture;
    return m;
}

}  // namespace

Scene quads() {
    Scene s;
    s.name = "quads";
    Texture levels = noise("levels", 64, 64, 5);
    levels.mips = true;
    Texture linear = noise("linear", 9, 14, 29);
    linear.srgb = false;
    const int repeated = add(s, levels, Wrap::repeat, Wrap::repeat);
    const int mirrored = add(s, noise("mirrored", 12, 7, 17), Wrap::mirrored_repeat, Wrap::repeat);
    const int clamped = add(s, linear, Wrap::clamp_to_edge, Wrap::mirrored_repeat);
    const int nearest = add(s, noise("nearest", 6, 10, 41), Wrap::repeat, Wrap::clamp_to_edge, Filter::nearest);
    const int normals = add(s, bumps(8, 8), Wrap::repeat, Wrap::repeat);

    Material plain;
    plain.reflectance = {0.6f, 0.4f, 0.2f}, plain.emission = {0, 0.25f, 0};
    Material bumped = textured(mirrored);
    bumped.normal_texture = normals, bumped.normal_scale = 0.7f;
    Material glowing = textured(clamped);
    glowing.emission = {3, 2, 1}, glowing.emission_texture = mirrored;
    Material masked = textured(clamped);
    masked.alpha = 0.9f, masked.alpha_cutoff = 0.45f;

    // A floor and, one above the other, rows of panels that lean a little; the last one is seen from behind.
    Mesh mesh;
    mesh.name = "panels";
    add(mesh, {{-2, 0, -0.5f}, {4, 0, 0}, {0, 0, -6}, {3, 7}, add(s, textured(repeated))});
    const int materials[6] = {add(s, bumped), add(s, glowing),          add(s, textured(nearest)),
                              add(s, plain),  add(s, textured(clamped)), add(s, textured(mirrored))};
    for (int i = 0; i < 6; ++i) {
        Panel p;
        p.corner = {-1.9f + 1.3f * float(i % 3), 0.15f + 1.1f * float(i / 3), -1.4f + 0.2f * float(i % 2)};
        p.along_u = {1.15f, 0.05f, -0.2f}, p.along_v = {0.03f, 1.0f, 0.1f};
        p.repeat = {1.7f + 0.2f * float(i), 2.3f}, p.material = materials[i];
        p.bend = i == 3 ? 0.8f : i == 4 ? -1.0f : 0.0f;
        p.tangents = i == 0;
        if (i == 5) p.corner += p.along_u, p.along_u = -p.along_u;
        add(mesh, p);
    }
    Panel mirror{{-0.5f, 2.3f, -1}, {1.6f, 0, 0}, {0, 0.5f, 0}, {2, 1}, materials[0], 0, true, true};
    add(mesh, mirror);
    add(mesh, {{-1.2f, 0.4f, -0.4f}, {2.2f, 0, 0}, {0, 1.5f, -0.1f}, {1.3f, 1.1f}, add(s, masked)});
    s.meshes.push_back(std::move(mesh));

    Light key;
    key.name = "key", key.position = {0.4f, 2.6f, 2.0f};
    key.direction = normalize3<float>(glm::vec3(-0.1f, -0.5f, -1));
    key.cone_inner_deg = 20, key.cone_outer_deg = 38, key.intensity = {20, 18, 16}, key.rsm_size = 96;
    Light sun;
    sun.name = "sun", sun.type = LightType::directional, sun.direction = normalize3<float>(glm::vec3(0.2f, -0.7f, -1));
    sun.intensity = {3, 3, 4}, sun.rsm_size = 96;
    s.lights = {key, sun};
    s.camera.position = {0.1, 1.5, 3.2};
    s.camera.look_at = {0, 1.2, -1};
    s.frame_size = {128, 96};
    return s;
}

}  // namespace plumb::mutants
