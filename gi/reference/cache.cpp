#include "gi/reference/cache.h"

#include "gi/reference/lobes.h"

#include <cpuid.h>

#include "core/content_hasher.h"
#include "gi/reference/ray_query.h"

namespace plumb::reference {

namespace {

// Counts the changes of what is traced, of the same scene by the same parameters.
constexpr int tracer_version = 2;

// What the processor calls itself (CPUID leaves 0x80000002 to 4): Embree chooses its code by it.
std::string processor() {
    unsigned words[12] = {};
    for (unsigned i = 0; i < 3; ++i)
        __get_cpuid(0x80000002 + i, &words[4 * i], &words[4 * i + 1], &words[4 * i + 2], &words[4 * i + 3]);
    return {reinterpret_cast<const char*>(words), sizeof words};
}

void add_scene(const Scene& scene, const Geometry& geometry, ContentHasher& h) {
    h.add_all(geometry.vertices);
    h.add_all(geometry.tangents);
    h.add_all(geometry.triangles);
    h.add_all(geometry.material);
    h.add(scene.materials.size(), scene.textures.size(), scene.lights.size());
    for (const Material& m : scene.materials) {
        h.add(m.reflectance, m.emission, m.texture, m.emission_texture, m.normal_texture, m.normal_scale, m.alpha,
              m.alpha_cutoff, m.specular, m.exponent, m.mirror, m.microfacet, m.metalness, m.roughness, m.surface_texture);
    }
    for (const Texture& t : scene.textures) {
        h.add(t.srgb, t.filter, t.wrap_u, t.wrap_v, t.mips);
        h.add_image(t.texels);
    }
    for (const Light& l : scene.lights)
        h.add(l.type, l.position, l.direction, l.cone_inner_deg, l.cone_outer_deg, l.intensity, l.on, l.radius);
    h.add(scene.environment.radiance);
    h.add_image(scene.environment.map);
    if (!scene.environment.map.empty() && scene.environment.filter == plumb::Filter::bilinear) h.add(std::int32_t(1));
}

ContentHasher begin(const PathParams& given, const Scene& scene, const Geometry& geometry, std::uint32_t seed, Isa isa) {
    ContentHasher h;
    h.add(tracer_version, seed);
    PathParams params = given;
    for (const Field& f : fields(params)) h.add(f.name + " = " + value_text(f));
    if (given.rays == Rays::native) {
        h.add(isa);
        h.add(processor());
        h.add(embree_version());
    }
    add_scene(scene, geometry, h);
    return h;
}

}  // namespace

std::uint64_t cache_key(const PathParams& params, const Scene& scene, const Geometry& geometry, std::uint32_t seed,
                        Isa isa) {
    ContentHasher h = begin(params, scene, geometry, seed, isa);
    const Camera& c = scene.camera;
    h.add(c.position, c.look_at, c.up, c.fov_y_deg, c.near, c.far, scene.frame_size);
    return h.hash;
}

std::uint64_t cache_key(const PathParams& params, const Scene& scene, const Geometry& geometry,
                        const PointInputs& points, std::uint32_t seed, Isa isa) {
    ContentHasher h = begin(params, scene, geometry, seed, isa);
    h.add_image(*points.position);
    h.add_image(*points.normal);
    return h.hash;
}

std::uint64_t cache_key(const PathParams& params, const Scene& scene, const Geometry& geometry,
                        const PointInputs& points, const glm::dvec3& eye, std::uint32_t seed, Isa isa) {
    ContentHasher h = begin(params, scene, geometry, seed, isa);
    h.add_image(*points.position);
    h.add_image(*points.normal);
    h.add(eye);
    return h.hash;
}

std::uint64_t cache_key_of_lobes(const PathParams& params, const Scene& scene, const Geometry& geometry,
                                 const PointInputs& points, const glm::dvec3& eye, std::uint32_t seed, Isa isa) {
    ContentHasher h{cache_key(params, scene, geometry, points, eye, seed, isa)};
    h.add(std::int32_t(2));  // PathArgs::mirrored
    return h.hash;
}

}  // namespace plumb::reference
