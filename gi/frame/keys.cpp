// Structures are taken apart by name: one that gets a new member does not compile until somebody has said here which
// stages read it.
#include "gi/frame/keys.h"

#include "core/content_hasher.h"
#include "gi/frame/relief_use.h"

namespace plumb::frame {

namespace {

std::uint64_t of_geometry(const Scene& scene, bool fixed = false) {
    ContentHasher h;
    h.add(scene.meshes.size());
    for (const Material& material : scene.materials) h.add(material.normal_texture >= 0);  // tangents are read for them
    for (const Mesh& mesh : scene.meshes) {
        const auto& [name, vertices, tangents, triangles, material, transform, dynamic, share] = mesh;
        if (fixed && dynamic) continue;
        h.add_all(vertices), h.add_all(tangents), h.add_all(triangles), h.add_all(material);
        h.add(transform, share);
    }
    return h.hash;
}

void add_textures(const Scene& scene, ContentHasher& h) {
    h.add(scene.textures.size());
    for (const Texture& texture : scene.textures) {
        const auto& [name, texels, srgb, filter, wrap_u, wrap_v, mips] = texture;
        h.add_image(texels);
        h.add(srgb, filter, wrap_u, wrap_v, mips);
    }
}

// A texture counts where a material has it, by its place in the scene.
void add_materials(const Scene& scene, ContentHasher& surfaces, ContentHasher& emissions, ContentHasher& glossy) {
    surfaces.add(scene.materials.size());
    for (const Material& material : scene.materials) {
        const auto& [name, reflectance, emission, texture, emission_texture, normal_texture, normal_scale, alpha,
                     alpha_cutoff, specular, exponent, mirror, microfacet, metalness, roughness, surface_texture] = material;
        surfaces.add(reflectance, texture, normal_texture, normal_scale, alpha, alpha_cutoff);
        emissions.add(emission, emission_texture);
        glossy.add(specular, exponent, mirror, microfacet, metalness, roughness, surface_texture);
    }
}

void add_light(const Light& light, ContentHasher& h) {
    const auto& [name, type, position, direction, cone_inner_deg, cone_outer_deg, intensity, on, rsm_size,
                 radius] = light;
    h.add(type, position, direction, cone_inner_deg, cone_outer_deg, intensity, on, rsm_size, radius);
}

}  // namespace

Light shining(Light light) {
    if (!light.on) light.intensity = glm::vec3(0);
    light.on = true;
    return light;
}

SceneKeys scene_keys(const Scene& scene) {
    // Camera, convention and frame are added where they are read; a scene's parameters are those of Settings; motion
    // has become poses.
    const auto& [name, meshes, materials, textures, lights, environment, camera, convention, seed, frame_size, method,
                 layout, animation, settings, notes] = scene;
    SceneKeys keys;
    ContentHasher surfaces, emission, paths;
    add_materials(scene, surfaces, emission, paths);
    add_textures(scene, surfaces);
    keys.geometry = of_geometry(scene);
    keys.surfaces = surfaces.hash;
    keys.emission = emission.hash;

    const auto& [radiance, map, filter] = environment;
    paths.add(keys.geometry, keys.surfaces, keys.emission, radiance, lights.size());
    paths.add_image(map);
    paths.add(filter);
    for (Light light : lights) {
        light.rsm_size = 0;  // rays know no maps
        add_light(light, paths);
    }
    keys.paths = paths.hash;
    return keys;
}

SceneKeys scene_keys(const Scene& scene, const Settings& settings) {
    SceneKeys keys = scene_keys(scene);
    if (drops_normal_maps(settings)) {
        ContentHasher h;
        h.add(keys.surfaces, true);
        keys.surfaces = h.hash;
    }
    if (!static_lamps(scene, settings).empty()) keys.fixed = of_geometry(scene, true);
    return keys;
}

}  // namespace plumb::frame
