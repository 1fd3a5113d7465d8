// Structures are taken apart by name: one that gets a new member does not compile until somebody has said here which
// stages read it.
#include "gi/frame/keys.h"

#include "core/content_hasher.h"
#include "core/fields.h"
#include "gi/frame/filters.h"
#include "gi/frame/isr.h"
#include "gi/frame/kept.h"
#include "raster/light_view.h"

namespace plumb::frame {

namespace {

std::uint64_t of_geometry(const Scene& scene) {
    ContentHasher h;
    h.add(scene.meshes.size());
    for (const Material& material : scene.materials) h.add(material.normal_texture >= 0);  // tangents are read for them
    for (const Mesh& mesh : scene.meshes) {
        const auto& [name, vertices, tangents, triangles, material, transform, dynamic, share] = mesh;
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
                     alpha_cutoff, specular, exponent, mirror] = material;
        surfaces.add(reflectance, texture, normal_texture, normal_scale, alpha, alpha_cutoff);
        emissions.add(emission, emission_texture);
        glossy.add(specular, exponent, mirror);
    }
}

void add_light(const Light& light, ContentHasher& h) {
    const auto& [name, type, position, direction, cone_inner_deg, cone_outer_deg, intensity, on, rsm_size,
                 radius] = light;
    h.add(type, position, direction, cone_inner_deg, cone_outer_deg, intensity, on, rsm_size, radius);
}

void add_camera(const Camera& camera, ContentHasher& h) {
    const auto& [position, look_at, up, fov_y_deg, near, far, reversed_z] = camera;
    h.add(position, look_at, up, fov_y_deg, near, far, reversed_z);
}

// Every parameter of a stage.
void add_fields(const std::vector<Field>& fields, ContentHasher& h) {
    for (const Field& f : fields) {
        h.add(f.name);
        std::visit([&](const auto* value) { h.add(*value); }, f.value);
    }
}

// The keys of one plan, stage by stage.
class Keys {
  public:
    Keys(const SceneKeys& of_scene, const Scene& scene, const Settings& settings, const Plan& plan, Isa isa)
        : scene_keys_(of_scene), scene_(scene), settings_(settings), plan_(plan), isa_(isa) {}

    std::vector<std::uint64_t> all() {
        std::vector<std::uint64_t> keys;
        for (const PlannedStage& stage : plan_.stages) {
            ContentHasher h;
            h.add(stage.name), h.add(stage.form), h.add(stage.layer);
            h.add(stage.needed, stage.light, scene_.frame_size, stage.view, stage.pass);
            if (stage.needed || stage.name == "reference")
                add_inputs(stage, h);
            else if (draws_view(stage.name))
                h.add(scene_.camera.reversed_z);  // what an empty depth buffer holds
            else if (is_filter(stage.name))
                h.add(gbuffer_);  // the depth that goes along
            else if (stage.light >= 0)
                h.add(raster::map_count(scene_.lights[std::size_t(stage.light)]));
            keys.push_back(h.hash);
            note(stage, h.hash);
        }
        return keys;
    }

  private:
    void add_inputs(const PlannedStage& stage, ContentHasher& h) {
        auto& [method, layout, rsm, isr, indirect, shadow, direct, compose, tonemap, path, seed, truth, pruning] = settings_;
        if (draws_view(stage.name)) {
            const auto& [stages, gbuffer, maps, at_run] = plan_;
            const auto& [position, normal, albedo, emission, id] = gbuffer;
            h.add(position, normal, albedo, emission, id);
            add_drawn(h);
            h.add(scene_keys_.emission, scene_.convention);
            add_camera(scene_.camera, h);
            if (stage.view > 0) add_views(h);
        } else if (stage.name == "rsm") {
            const auto& [wants, faces] = plan_.maps[std::size_t(stage.light)];
            h.add(wants.light, faces);
            add_drawn(h);
            add_light(shining(light(stage)), h);
        } else if (stage.name == "shadow.blur") {
            add_fields(direct::fields(shadow), h);
            h.add(map(stage));
        } else if (stage.name == "shadow") {
            add_fields(direct::fields(shadow), h);
            h.add(gbuffer_, map(stage));
            if (stage.view > 0) add_views(h);
        } else if (stage.name == "direct") {
            add_fields(direct::fields(direct), h);
            h.add(compose::reads_density(compose));
            h.add(gbuffer_, scene_.lights.size());
            for (const Light& l : scene_.lights) add_light(shining(l), h);
            h.add_all(visibility_);
            h.add(casts_shadows(settings_));
            if (stage.view > 0) add_views(h);
        } else if (is_gather(stage.name)) {
            add_fields(rsm::fields(rsm), h);
            if (rsm.own) h.add_all(rsm.own->rows);
            h.add(gbuffer_, map(stage), seed, indirect.resolution);
            if (stage.name == "rsm.all_rays") h.add(scene_keys_.geometry, scene_keys_.surfaces);
            if (stage.name == "rsm.all_rays" && rsm.rays == Rays::native) h.add(isa_);
        } else if (is_isr(stage.name)) {
            // All of them read nearly all of it.
            add_fields(isr::fields(isr), h);
            h.add(gbuffer_, direct_, seed, scene_.environment.radiance);
            h.add_all(views_), h.add_all(image_space_);
        } else if (is_filter(stage.name)) {
            h.add(gbuffer_);
            if (stage.name == "filter.reduce") return;
            add_fields(filter::fields(indirect), h);
            h.add_all(gathers_);
        } else if (stage.name == "compose") {
            add_fields(compose::fields(compose), h);
            h.add(gbuffer_, direct_, scene_.environment.radiance);
            h.add_all(gathers_), h.add(filtered_);
        } else if (stage.name == "tonemap") {
            add_fields(compose::fields(tonemap), h);
            h.add(radiance_);
        } else {
            add_fields(reference::fields(path), h);
            h.add(scene_keys_.paths, seed);
            if (own_transport(stage.layer)) h.add(gbuffer_);
            add_camera(scene_.camera, h);
            if (path.rays == Rays::native) h.add(isa_);
        }
    }

    // What the rasterizer reads of geometry and surfaces, and how it stores what it draws.
    void add_drawn(ContentHasher& h) {
        h.add(scene_keys_.geometry, scene_keys_.surfaces);
        h.add(settings_.layout.name);
        add_fields(raster::fields(settings_.layout), h);
    }

    // Which views there are beside the frame, and what was drawn of them before.
    void add_views(ContentHasher& h) {
        for (const IsrView& v : isr_views(scene_, settings_)) {
            h.add(int(v.kind), v.size, v.margin, v.behind);
            add_camera(v.camera, h);
        }
        h.add_all(views_);
    }

    // The key of what later stages read.
    void note(const PlannedStage& stage, std::uint64_t key) {
        if (is_isr(stage.name)) image_space_.push_back(key);
        if (stage.name == "isr.compose") radiance_ = key;
        if (stage.view > 0) return views_.push_back(key);
        if (stage.name == "gbuffer") gbuffer_ = key;
        if (stage.name == "rsm") maps_.resize(scene_.lights.size()), maps_[std::size_t(stage.light)] = key;
        if (stage.name == "shadow") visibility_.push_back(key);
        if (is_gather(stage.name)) gathers_.push_back(key);
        if (is_filter(stage.name)) filtered_ = key;
        if (stage.name == "direct") direct_ = key;
        if (stage.name == "compose" || stage.layer == "color") radiance_ = key;
    }

    const Light& light(const PlannedStage& stage) const { return scene_.lights[std::size_t(stage.light)]; }
    std::uint64_t map(const PlannedStage& stage) const { return maps_.at(std::size_t(stage.light)); }

    const SceneKeys& scene_keys_;
    const Scene& scene_;
    Settings settings_;  // fields() takes what it may change
    const Plan& plan_;
    Isa isa_;
    std::uint64_t gbuffer_ = 0, direct_ = 0, filtered_ = 0, radiance_ = 0;
    std::vector<std::uint64_t> maps_, visibility_, gathers_;  // a light each
    std::vector<std::uint64_t> views_, image_space_;          // of stages of views beside the frame; of isr.*
};

}  // namespace

Light shining(Light light) {
    if (!light.on) light.intensity = glm::vec3(0);
    light.on = true;
    return light;
}

std::uint64_t tonemap_key(const Settings& settings) {
    compose::TonemapParams params = settings.tonemap;
    ContentHasher h;
    add_fields(compose::fields(params), h);
    return h.hash;
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

    const auto& [radiance, map] = environment;
    paths.add(keys.geometry, keys.surfaces, keys.emission, radiance, lights.size());
    paths.add_image(map);
    for (Light light : lights) {
        light.rsm_size = 0;  // rays know no maps
        add_light(light, paths);
    }
    keys.paths = paths.hash;
    return keys;
}

std::vector<std::uint64_t> stage_keys(const SceneKeys& scene_keys, const Scene& scene, const Settings& settings,
                                      const Plan& plan, Isa isa) {
    return Keys(scene_keys, scene, settings, plan, isa).all();
}

std::vector<std::uint64_t> stage_keys(const Scene& scene, const Settings& settings, const Plan& plan, Isa isa) {
    return stage_keys(scene_keys(scene), scene, settings, plan, isa);
}

}  // namespace plumb::frame
