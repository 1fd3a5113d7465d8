#include <cmath>

#include "gltf_files.h"
#include "io/glb_write.h"
#include "io/make_scene.h"
#include "io/scene_file.h"
#include "io/scenes/builder.h"

using namespace plumb;
using namespace plumb::io;

namespace {

// A scene with something of everything, in numbers that no decimal of a few digits holds.
Scene rich_scene() {
    using namespace scenes;
    Builder b("rich");
    Texture noise = paint("noise", 8, [](double u, double v) { return glm::dvec3(u, v, fractal_noise(u, v, 2, 2, 1)); });
    noise.filter = Filter::nearest, noise.wrap_u = Wrap::mirrored_repeat, noise.wrap_v = Wrap::clamp_to_edge;
    for (std::size_t i = 0; i < noise.texels.size(); ++i) noise.texels.data()[i] -= std::uint32_t(i) << 24;
    Texture bumps = noise;
    bumps.name = "bumps", bumps.srgb = false, bumps.mips = true;
    Material stone;
    stone.name = "stone \"rough\"";
    stone.texture = b.texture(noise), stone.normal_texture = b.texture(bumps);
    stone.reflectance = {0.1f, 1 / 3.0f, 0.7f}, stone.normal_scale = 0.3f;
    stone.alpha = 0.9f, stone.alpha_cutoff = 0.45f;
    Material lamp;
    lamp.name = "lamp", lamp.emission = {17.123f, 3.3f, 1e-20f}, lamp.emission_texture = 0;
    Material dim;
    dim.name = "dim", dim.emission = {0.1f, 0.2f, 0.3f};
    dim.specular = {0.1f, 1 / 3.0f, 1e-20f}, dim.exponent = 33.3f, dim.mirror = {0.3f, 0, 1 / 7.0f};
    Material metal;
    metal.name = "metal", metal.microfacet = true, metal.metalness = 0.7f, metal.roughness = 1 / 3.0f;
    metal.reflectance = {0.9f, 1, 0.1f}, metal.surface_texture = stone.normal_texture;
    const int materials[] = {b.material(stone), b.material(lamp), b.material(dim), b.material(metal)};
    b.object("pillar");
    // Materials take turns: the triangles of a mesh are not sorted by them.
    for (int i = 0; i < 7; ++i)
        b.lathe(materials[i % 4], move({0.1 * i, 1 / 3.0, 0}) * turn_y(10.0 * i), {{0.3, 0}, {0.2, 0.7}, {0, 1}}, 5);
    b.object("box");
    b.box(materials[2], Place(1), {-1, -1, -1}, {1, 1.0 / 3, 1});
    Scene s = b.take();
    s.meshes[0].transform = move({0.1, -0.0, 1e-7}) * turn_y(33) * scale({1, -2, 1 / 3.0});
    s.meshes[0].share = 0.7;
    s.meshes[1].dynamic = true;
    for (std::size_t i = 0; i < s.meshes[1].vertices.size(); ++i)
        s.meshes[1].tangents.emplace_back(0.6f, 0.8f, 0, i % 2 ? 1 : -1);
    Light spot;
    spot.name = "spot", spot.position = {0.1f, 5, 0.3f}, spot.direction = glm::vec3(0.36f, -0.8f, 0.48f);
    spot.intensity = {1 / 3.0f, 7.7f, 0.123f}, spot.cone_inner_deg = 33.3f, spot.cone_outer_deg = 44.4f;
    spot.rsm_size = 64;
    Light sun = spot;
    sun.name = "sun", sun.type = LightType::directional, sun.direction = {0, -1, 0}, sun.on = false;
    Light bulb;
    bulb.name = "bulb", bulb.type = LightType::point, bulb.position = {0, 1e-3f, 0};
    bulb.radius = 1 / 3.0f;
    Light tight = spot;
    tight.name = "tight", tight.cone_inner_deg = tight.cone_outer_deg = 12.3f;
    s.lights = {spot, sun, bulb, tight};
    s.camera.position = {0.1, 2, 5}, s.camera.look_at = {0, 0.3, 0}, s.camera.fov_y_deg = 39.3;
    return s;
}

void check_same_materials(const std::vector<Material>& a, const std::vector<Material>& b) {
    REQUIRE(a.size() == b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        CAPTURE(a[i].name);
        CHECK(a[i].name == b[i].name);
        CHECK(a[i].reflectance == b[i].reflectance);
        CHECK(a[i].emission == b[i].emission);
        CHECK((a[i].texture == b[i].texture && a[i].emission_texture == b[i].emission_texture &&
               a[i].normal_texture == b[i].normal_texture));
        CHECK((a[i].normal_scale == b[i].normal_scale && a[i].alpha == b[i].alpha));
        CHECK(a[i].alpha_cutoff == b[i].alpha_cutoff);
        CHECK((a[i].microfacet == b[i].microfacet && a[i].metalness == b[i].metalness && a[i].roughness == b[i].roughness));
        CHECK(a[i].surface_texture == b[i].surface_texture);
        CHECK((a[i].specular == b[i].specular && a[i].exponent == b[i].exponent && a[i].mirror == b[i].mirror));
    }
}

void check_same_lights(const std::vector<Light>& a, const std::vector<Light>& b) {
    REQUIRE(a.size() == b.size());
    for (std::size_t i = 0; i < a.size(); ++i) {
        CAPTURE(a[i].name);
        CHECK(a[i].name == b[i].name);
        CHECK(a[i].type == b[i].type);
        CHECK(a[i].position == b[i].position);
        if (a[i].type != LightType::point) CHECK(a[i].direction == b[i].direction);
        CHECK(a[i].intensity == b[i].intensity);
        if (a[i].type == LightType::spot)
            CHECK((a[i].cone_inner_deg == b[i].cone_inner_deg && a[i].cone_outer_deg == b[i].cone_outer_deg));
        CHECK(a[i].on == b[i].on);
        CHECK(a[i].rsm_size == b[i].rsm_size);
        CHECK(a[i].radius == b[i].radius);
    }
}

void check_same_geometry(const Scene& a, const Scene& b) {
    const Geometry ga = flatten(a), gb = flatten(b);
    REQUIRE(ga.vertices.size() == gb.vertices.size());
    CHECK(std::memcmp(ga.vertices.data(), gb.vertices.data(), ga.vertices.size() * sizeof(Vertex)) == 0);
    CHECK(ga.triangles == gb.triangles);
    CHECK(ga.material == gb.material);
    CHECK(ga.object == gb.object);
}

}  // namespace

TEST_CASE("glb: what is written comes back bit for bit", "[io][round trip]") {
    const Folder folder;
    const Scene s = rich_scene();
    write_glb(folder / "a.glb", s);
    GltfModel m = read_gltf(folder / "a.glb");
    REQUIRE(m.meshes.size() == s.meshes.size());
    for (std::size_t i = 0; i < m.meshes.size(); ++i) {
        CHECK(m.meshes[i].name == s.meshes[i].name);
        CHECK(bytes_of(m.meshes[i].vertices) == bytes_of(s.meshes[i].vertices));
        CHECK(m.meshes[i].triangles == s.meshes[i].triangles);
        CHECK(m.meshes[i].material == s.meshes[i].material);
        CHECK(std::memcmp(&m.meshes[i].transform, &s.meshes[i].transform, sizeof(glm::dmat4)) == 0);
        CHECK(m.meshes[i].dynamic == s.meshes[i].dynamic);
        CHECK(m.meshes[i].share == s.meshes[i].share);
        CHECK(m.meshes[i].tangents == s.meshes[i].tangents);
    }
    check_same_materials(m.materials, s.materials);
    check_same_lights(m.lights, s.lights);
    REQUIRE(m.textures.size() == s.textures.size());
    for (std::size_t i = 0; i < m.textures.size(); ++i) {
        CHECK(m.textures[i].name == s.textures[i].name);
        CHECK(m.textures[i].texels.texels == s.textures[i].texels.texels);
        CHECK(m.textures[i].srgb == s.textures[i].srgb);
        CHECK(m.textures[i].mips == s.textures[i].mips);
        CHECK(m.textures[i].filter == s.textures[i].filter);
        CHECK((m.textures[i].wrap_u == s.textures[i].wrap_u && m.textures[i].wrap_v == s.textures[i].wrap_v));
    }
    REQUIRE(m.has_camera);
    CHECK(m.camera.position == s.camera.position);
    CHECK(m.camera.fov_y_deg == Approx(s.camera.fov_y_deg).epsilon(1e-14));
    const glm::dvec3 a = axes(m.camera).forward, b = axes(s.camera).forward;
    CHECK(glm::dot(a, b) == Approx(1).epsilon(1e-14));

    Scene back = s;
    back.meshes = std::move(m.meshes);
    check_same_geometry(back, s);
    // Equal scenes are equal files.
    back.materials = m.materials, back.textures = m.textures;
    write_glb(folder / "b.glb", back);
    CHECK(read_bytes(folder / "a.glb") == read_bytes(folder / "b.glb"));
    CHECK(folder.files() == 2);
}

TEST_CASE("glb: emission and intensity survive pi and 683 for any float", "[io][round trip]") {
    const Folder folder;
    Scene s = rich_scene();
    s.materials.clear(), s.lights.clear(), s.textures.clear();
    std::uint32_t bits = 0x00800000;  // the smallest normal number; to the largest in odd steps
    for (int i = 0; i < 2000; ++i, bits += 1065001) {
        float x;
        std::memcpy(&x, &bits, 4);
        if (!(x < 1e37f)) break;
        Material material;
        material.name = std::to_string(i), material.emission = {x, x / 3, 0};
        s.materials.push_back(material);
        Light light;
        light.name = material.name, light.type = LightType::point, light.intensity = {x, x / 3, 0};
        s.lights.push_back(light);
    }
    CHECK(s.materials.size() > 1800);
    write_glb(folder / "a.glb", s);
    const GltfModel m = read_gltf(folder / "a.glb");
    check_same_materials(m.materials, s.materials);
    check_same_lights(m.lights, s.lights);
}

TEST_CASE("glb: a scene that glTF cannot hold is refused, and nothing is written", "[io][robustness]") {
    const Folder folder;
    Scene s = rich_scene();
    s.meshes[1].vertices[3].position.y = NAN;
    require_message(error_of([&] { write_glb(folder / "a.glb", s); }),
                    {"a.glb: cannot be written: vertex 3 of mesh \"box\" is not finite"});
    require_message(error_of([&] { write_glb(folder / "none/a.glb", rich_scene()); }), {"none/a.glb: cannot be written"});
    CHECK(folder.files() == 0);
}

TEST_CASE("make_scene: the TOML of a generated scene is the same scene as generate =", "[io][round trip]") {
    const Folder folder;
    for (const GeneratedScene& generated : generated_scenes()) {
        CAPTURE(generated.name);
        // The others paint large textures, which takes longer than a unit test may.
        const std::string name = generated.name;
        if (name == "atrium" || name == "hall" || name == "city" || name == "rooms") continue;
        const std::int64_t triangles = std::max<std::int64_t>(generated.least_triangles, 3000);
        const MadeScene made = make_scene(generated.name, folder / generated.name, {triangles, 3});
        const std::vector<std::string> tables = {"rsm", "shadow", "tonemap"};
        const Scene a = load_scene(made.file, tables);
        const Scene b = load_scene(folder.put("g.toml", "[[mesh]]\ngenerate = \"" + std::string(generated.name) +
                                                            "\"\ntriangles = " + std::to_string(triangles) +
                                                            "\nseed = 3\n"),
                                   tables);
        CHECK(made.triangles == std::int64_t(flatten(a).triangles.size()));
        check_same_geometry(a, b);
        check_same_materials(a.materials, b.materials);
        check_same_lights(a.lights, b.lights);
        CHECK((a.camera.position == b.camera.position && a.camera.look_at == b.camera.look_at));
        CHECK((a.camera.up == b.camera.up && a.camera.fov_y_deg == b.camera.fov_y_deg));
        CHECK((a.camera.near == b.camera.near && a.camera.far == b.camera.far));
        CHECK(a.camera.reversed_z == b.camera.reversed_z);
        CHECK(a.environment.radiance == b.environment.radiance);
        CHECK((a.method == b.method && a.layout == b.layout && a.frame_size == b.frame_size && a.seed == b.seed));
        REQUIRE(a.settings.size() == b.settings.size());
        for (std::size_t i = 0; i < a.settings.size(); ++i) {
            CHECK(a.settings[i].key == b.settings[i].key);
            CHECK(a.settings[i].value == b.settings[i].value);
        }
    }
}

TEST_CASE("make_scene: the TOML holds every light and setting of a rich scene", "[io][round trip]") {
    const Folder folder;
    Scene s = rich_scene();
    s.environment.radiance = {0.1f, 0.2f, 0.3f};
    s.settings = {{"rsm", "samples", 400.0, ""}, {"rsm", "gather", std::string("a\"b\\\n"), ""},
                  {"rsm", "flag", true, ""},     {"rsm", "axis", glm::vec3(0.1f, 0, 1e-20f), ""},
                  {"rsm", "samples", 0.1, ""}};
    write_glb(folder / "s.glb", s);
    const Scene a = load_scene(folder.put("s.toml", scene_toml(s, "s.glb", "a rich scene")), {"rsm"});
    check_same_lights(a.lights, s.lights);
    check_same_materials(a.materials, s.materials);
    CHECK(a.environment.radiance == s.environment.radiance);
    CHECK(a.camera.look_at == s.camera.look_at);
    CHECK(a.camera.up == s.camera.up);
    REQUIRE(a.settings.size() == 4);
    CHECK(std::get<std::string>(a.settings[0].value) == "a\"b\\\n");
    CHECK(std::get<bool>(a.settings[1].value));
    CHECK(std::get<glm::vec3>(a.settings[2].value) == glm::vec3(0.1f, 0, 1e-20f));
    CHECK(std::get<double>(a.settings[3].value) == 0.1);
}
