// Data for every compute stage, made by hand: a floor and a wall, a map of each kind of light, and pixels that hold
// nothing, lie far away or sit on borders. Small, so that every stage runs in a moment.
#pragma once

#include <vector>

#include "core/sh.h"
#include "core/hash.h"
#include "gi/compose/compose.h"
#include "gi/ddgi/blend.h"
#include "gi/ddgi/sample.h"
#include "gi/direct/direct.h"
#include "gi/direct/log_blur.h"
#include "gi/filter/filter.h"
#include "gi/isr/isr.h"
#include "gi/lend.h"
#include "gi/parity/stages.h"
#include "gi/probes/coefficients.h"
#include "gi/probes/density.h"
#include "gi/probes/share.h"
#include "gi/probes/supports.h"
#include "gi/rsm/gather.h"
#include "raster/light_view.h"
#include "raster/rsm.h"

namespace plumb::test {

// Numbers of [0, 1) that follow from a seed and a place.
inline float noise(int x, int y, int channel, std::uint32_t seed) {
    const auto h = pixel_hash<std::int32_t>(x, y, channel, std::int32_t(seed));
    return float(std::uint32_t(h.x) >> 8) * 0x1p-24f;
}

inline Image4 noise_image(glm::ivec2 size, std::uint32_t seed, float low, float high) {
    Image4 image(size.x, size.y);
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x)
            for (int c = 0; c < 4; ++c) image(x, y)[c] = low + (high - low) * noise(x, y, c, seed);
    return image;
}

struct Points {
    Image4 position, normal;
};

// The left half a floor at y = 0, the right half a wall at z = -2, both 4 m wide, with rough normals; every 11th pixel
// is empty, every 13th a kilometre away.
inline Points room(glm::ivec2 size, std::uint32_t seed) {
    Points p{Image4(size.x, size.y), Image4(size.x, size.y)};
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            const int i = y * size.x + x;
            if (i % 11 == 0) continue;
            const float u = 4 * noise(x, y, 0, seed) - 2, v = 4 * noise(x, y, 1, seed) - 2;
            const bool floor = 2 * x < size.x;
            const float far = i % 13 == 0 ? 1000.0f : 1.0f;
            const glm::vec3 up = floor ? glm::vec3(0, 1, 0) : glm::vec3(0, 0, 1);
            const glm::vec3 bump(noise(x, y, 2, seed) - 0.5f, noise(x, y, 3, seed) - 0.5f, noise(x, y, 4, seed) - 0.5f);
            p.position(x, y) = glm::vec4(far * (floor ? glm::vec3(u, 0, v) : glm::vec3(u, v + 2, -2)), 1 + u * u);
            p.normal(x, y) = glm::vec4(glm::normalize(up + 0.5f * bump), 1);
        }
    return p;
}

inline Light make_light(LightType type, int rsm_size) {
    Light light;
    light.type = type;
    light.position = {0.3f, 3, 0.7f};
    light.direction = glm::normalize(glm::vec3(0.2f, -1, -0.6f));
    light.intensity = {17.25f, 11.5f, 3.75f};
    light.cone_inner_deg = 30;
    light.rsm_size = rsm_size;
    return light;
}

// A map filled with points of the room, whatever the light sees of it.
inline raster::Rsm make_map(const Light& light, int face, std::uint32_t seed) {
    const std::vector<View> views = raster::light_views(light, {-2, 0, -2}, {2, 4, 2});
    raster::Rsm map = raster::unseen_rsm(light, views[std::size_t(face)]);
    const Points p = room({light.rsm_size, light.rsm_size}, seed);
    map.position = p.position;
    map.normal = p.normal;
    map.flux = noise_image({light.rsm_size, light.rsm_size}, seed + 1, 0, 0.02f);
    for (std::size_t i = 0; i < map.position.size(); ++i) {
        const bool covered = map.normal.texels[i].w > 0;
        map.position.texels[i].w = covered ? 1 + 3 * map.flux.texels[i].w / 0.02f : 0;
        map.flux.texels[i].w = 0;
        if (!covered) map.flux.texels[i] = glm::vec4(0);
    }
    map.records.assign(map.position.size() * 16, 0);
    for (std::size_t i = 0; i < map.position.size(); ++i) {
        std::memcpy(&map.records[16 * i], &map.position.texels[i], 16);
        std::memcpy(&map.records[16 * i + 4], &map.normal.texels[i], 16);
        std::memcpy(&map.records[16 * i + 8], &map.flux.texels[i], 16);
    }
    return map;
}

// A copy of all that is lent.
inline StageData owned_data(const StageData& data) {
    return owned(parity::find_binding(data.stage, data.stage), data);
}

inline StageData named(StageData data, const std::string& id) {
    data.id = data.label = id;
    return data;
}

inline StageData shadow_case(glm::ivec2 size, LightType type, int face, direct::ShadowMode mode,
                             direct::ShadowVariant variant, const std::string& id) {
    const Light light = make_light(type, 48);
    std::vector<raster::Rsm> maps;
    for (int f = 0; f < raster::map_count(light); ++f) maps.push_back(make_map(light, f, 3));
    const Points p = room(size, 5);
    direct::ShadowParams params;
    params.mode = mode;
    params.variant = variant;
    return named(owned_data(direct::data_of(params, direct::ShadowInputs{&p.position, &p.normal, maps}, face)), id);
}

// A map of two layers, near each other in places, with holes.
inline StageData log_blur_case(glm::ivec2 size, int radius, float sigma, direct::Direction direction,
                               const std::string& id) {
    Image4 map(size.x, size.y);
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            const float gap = x < size.x / 2 ? 0.01f : 3.0f;
            if ((y * size.x + x) % 11 != 0) map(x, y).w = 1 + gap * noise(x, y, 0, 6) + (y % 5 == 0 ? gap : 0.0f);
        }
    direct::ShadowParams params;
    params.mode = direct::ShadowMode::esm;
    params.esm_blur_radius = radius, params.esm_blur_sigma = sigma;
    return named(owned_data(direct::data_of(params, direct::LogBlurInputs{&map, direction, 10})), id);
}

inline StageData direct_case(glm::ivec2 size, const std::string& id, bool density = false,
                             direct::DirectVariant variant = direct::DirectVariant::corrected) {
    std::vector<Light> lights = {make_light(LightType::spot, 16), make_light(LightType::directional, 16),
                                 make_light(LightType::point, 16), make_light(LightType::spot, 16)};
    lights[3].radius = 3.5f;  // ends in the room
    Buffer<float> visibility(lights.size() * std::size_t(size.x) * std::size_t(size.y));
    for (std::size_t i = 0; i < visibility.size(); ++i) visibility[i] = noise(int(i), 0, 0, 9);
    const Points p = room(size, 5);
    const direct::DirectInputs in{&p.position, &p.normal, &lights, &visibility, nullptr, density};
    return named(owned_data(direct::data_of(direct::DirectParams{variant}, in)), id);
}

inline StageData gather_case(glm::ivec2 size, rsm::Gather gather, LightType type, float min_distance,
                             const std::string& id, rsm::Texels texels = rsm::Texels::whole) {
    const Light light = make_light(type, gather == rsm::Gather::disc ? 64 : 24);
    const raster::Rsm map = make_map(light, 0, 3);
    rsm::GatherParams params;
    params.gather = gather;
    params.samples = 60;
    params.min_distance = min_distance;
    params.texels = texels;
    const rsm::Pattern pattern = rsm::disc_pattern(params, map.size, 7);
    const Points p = room(size, 5);
    rsm::GatherInputs in;
    in.position = &p.position;
    in.normal = &p.normal;
    in.rsm = &map;
    in.pattern = &pattern;
    in.seed = 7;
    return named(owned_data(rsm::data_of(params, in)), id);
}

inline StageData paths_case(glm::ivec2 size, LightType type, const rsm::GatherParams& given, const std::string& id) {
    const Light light = make_light(type, 64);
    const raster::Rsm map = make_map(light, 0, 3);
    rsm::GatherParams params = given;
    params.gather = rsm::Gather::paths;
    const rsm::Pattern pattern = rsm::paths_pattern(params, map.size, 7);
    const Points p = room(size, 5);
    rsm::GatherInputs in;
    in.position = &p.position;
    in.normal = &p.normal;
    in.rsm = &map;
    in.pattern = &pattern;
    in.seed = 7;
    return named(owned_data(rsm::data_of(params, in)), id);
}

// A rough wall with steps in depth, so that neighbours weigh anything from 0 to 1; every 11th pixel is empty.
inline Points steps(glm::ivec2 size, std::uint32_t seed) {
    Points p{Image4(size.x, size.y), Image4(size.x, size.y)};
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            if ((y * size.x + x) % 11 == 0) continue;
            const float z = ((x / 5 + y / 4) % 3 == 2 ? 2.5f : 2.0f) + 0.02f * noise(x, y, 0, seed);
            const glm::vec3 bump(noise(x, y, 2, seed) - 0.5f, noise(x, y, 3, seed) - 0.5f, noise(x, y, 4, seed) - 0.5f);
            p.position(x, y) = {0.01f * float(x), -0.01f * float(y), -z, z};
            p.normal(x, y) = glm::vec4(glm::normalize(glm::vec3(0, 0, 1) + 0.8f * bump), 1);
        }
    return p;
}
inline Image4 with_depth(Image4 image, const Image4& position) {
    for (std::size_t i = 0; i < image.size(); ++i)
        image.texels[i] = position.texels[i].w > 0 ? glm::vec4(glm::vec3(image.texels[i]), position.texels[i].w)
                                                   : glm::vec4(0);
    return image;
}

inline StageData reduce_case(glm::ivec2 size, const std::string& id) {
    const Points full = room({2 * size.x - 1, 2 * size.y}, 5);
    return named(owned_data(filter::data_of({}, filter::ReduceInputs{&full.position})), id);
}

inline StageData upsample_case(glm::ivec2 size, filter::Upsample mode, filter::Similarity similarity,
                               const std::string& id) {
    const Points full = steps(size, 5);
    Points half;
    filter::FilterParams params;
    filter::run(params, filter::ReduceInputs{&full.position}, {}, half.position);
    filter::run(params, filter::ReduceInputs{&full.normal}, {}, half.normal);
    const Image4 irradiance =
        with_depth(noise_image({half.position.width, half.position.height}, 41, 0.1f, 3), half.position);
    params.upsample = mode, params.similarity = similarity;
    const filter::UpsampleInputs in{&irradiance, &half.position, &half.normal, &full.position, &full.normal};
    return named(owned_data(filter::data_of(params, in)), id);
}

inline StageData blur_case(glm::ivec2 size, int kernel, filter::Similarity similarity, filter::Direction direction,
                           const std::string& id) {
    const Points p = steps(size, 5);
    const Image4 irradiance = with_depth(noise_image(size, 42, 0.1f, 3), p.position);
    filter::FilterParams params;
    params.kernel = kernel, params.similarity = similarity;
    const filter::BlurInputs in{&irradiance, &p.position, &p.normal, direction};
    return named(owned_data(filter::data_of(params, in)), id);
}

inline StageData compose_case(glm::ivec2 size, const std::string& id, const glm::vec3& shadow_color = glm::vec3(0)) {
    const Points p = room(size, 5);
    Image4 images[] = {noise_image(size, 21, 0, 1), noise_image(size, 22, 0, 3), noise_image(size, 23, 0, 1e3f),
                       noise_image(size, 24, 0, 1e-3f)};
    // What a broken pass may leave behind, and what a device may flush to 0.
    const float extremes[] = {std::numeric_limits<float>::infinity(),
                              std::numeric_limits<float>::quiet_NaN(),
                              3e38f,
                              1e-41f,
                              -0.0f,
                              65520,
                              1e-20f};
    for (int i = 0; i < 28; ++i) images[i % 4].texels[std::size_t(2 * i) % images[i % 4].size()].x = extremes[i % 7];
    compose::ComposeInputs in{&p.normal, &images[0], &images[1], &images[2], &images[3], {0.25f, 0.5f, 1}};
    return named(owned_data(compose::data_of(compose::ComposeParams{shadow_color}, in)), id);
}

inline StageData tonemap_case(glm::ivec2 size, compose::Operator op, const std::string& id) {
    const Image4 radiance = noise_image(size, 31, -0.1f, 6);
    return named(owned_data(compose::data_of(compose::TonemapParams{op, 0.7f}, compose::TonemapInputs{&radiance})), id);
}

// ---- Image-space radiosity ------------------------------------------------------------------------------------------

inline Camera isr_camera(double turned = 0) {
    Camera camera;
    camera.position = {3.1 + turned, 2.2, -4.7 + turned}, camera.look_at = {-0.4, 0.7, 0.2}, camera.up = {0.1, 1, 0.05};
    camera.fov_y_deg = 62, camera.near = 0.05, camera.far = 300;
    return camera;
}

// Coarse pixels of surfaces that face any way, about 2 m and in places 2.6 m away, with holes; one in thirteen lies too
// far away to count. w: depth, or clip depth.
inline Image4 isr_surface(glm::ivec2 size, std::uint32_t seed, isr::Position position, const Camera& camera) {
    Image4 surface(size.x, size.y);
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            const int i = y * size.x + x;
            if (i % 11 == 0) continue;
            const glm::vec3 way(noise(x, y, 0, seed) - 0.5f, noise(x, y, 1, seed) - 0.5f, noise(x, y, 2, seed) - 0.5f);
            const float z = ((x / 5 + y / 4) % 3 == 2 ? 2.6f : 2.0f) + 0.3f * noise(x, y, 3, seed);
            const double clip = camera.far / (camera.far - camera.near) * (1 - camera.near / double(z));
            const bool linear = position == isr::Position::linear;
            surface(x, y) = glm::vec4(normalize3<float>(way), linear ? (i % 13 == 0 ? 1e16f : z) : float(clip));
        }
    return surface;
}

inline isr::IsrParams isr_params() {
    isr::IsrParams params;
    params.rings = 3, params.spacing = 2, params.ssao_rings = 2, params.ssao_spacing = 1.5f;
    return params;
}

// The last column of coarse pixels stands for one pixel and not two. Normals cancel, masks are left out.
inline StageData isr_downsample_case(glm::ivec2 size, const isr::IsrParams& params, isr::Coarse what,
                                     const std::string& id) {
    const glm::ivec2 full(2 * size.x - 1, 2 * size.y);
    const Points p = room(full, 5);
    Image4 albedo = noise_image(full, 51, 0, 1);
    for (std::size_t i = 0; i < albedo.size(); i += 3) albedo.texels[i].w = 0;  // no radiation mask
    Image4 normal = p.normal;
    normal(4, 4) = glm::vec4(0, 1, 0, 1), normal(5, 4) = glm::vec4(0, -1, 0, 1);  // that cancel
    normal(4, 5) = normal(5, 5) = glm::vec4(0);
    const Image4 emission = noise_image(full, 52, 0, 3), direct = noise_image(full, 53, 0, 20);
    isr::DownsampleInputs in{what, &p.position, &normal, &albedo, &emission, &direct, 0.05, 300};
    return named(owned_data(isr::data_of(params, in)), id);
}

inline StageData isr_gather_case(glm::ivec2 size, const isr::IsrParams& params, const std::string& id, int margin = 0,
                                 bool before = false) {
    const Camera camera = isr_camera();
    const Image4 sources = isr_surface(size + 2 * margin, 61, params.position, camera);
    const Image4 surface = margin > 0 ? isr_surface(size, 62, params.position, camera) : sources;
    const Image4 radiosity = noise_image(size + 2 * margin, 63, 0, 3), other = noise_image(size, 64, 0, 1.5f);
    const isr::Pattern pattern = isr::gather_pattern(params);
    isr::GatherInputs in;
    in.surface = &surface, in.source_surface = &sources, in.source_radiosity = &radiosity;
    in.before = before ? &other : nullptr;
    in.camera = isr::coarse_camera(camera, 2 * size), in.margin = margin, in.pattern = &pattern, in.seed = 7;
    return named(owned_data(isr::data_of(params, in)), id);
}

inline StageData isr_ssao_case(glm::ivec2 size, const isr::IsrParams& params, const std::string& id, int margin = 0) {
    const Camera camera = isr_camera();
    const Image4 sources = isr_surface(size + 2 * margin, 61, params.position, camera);
    const Image4 surface = margin > 0 ? isr_surface(size, 62, params.position, camera) : sources;
    const Image4 gathered = noise_image(size, 65, 0, 3);
    const isr::Pattern pattern = isr::ssao_pattern(params);
    isr::SsaoInputs in;
    in.surface = &surface, in.source_surface = &sources, in.gathered = &gathered;
    in.camera = isr::coarse_camera(camera, 2 * size), in.margin = margin, in.pattern = &pattern, in.seed = 7;
    return named(owned_data(isr::data_of(params, in)), id);
}

inline StageData isr_bounce_case(glm::ivec2 size, int margin, const std::string& id) {
    const glm::ivec2 receivers = size - 2 * margin;
    const Image4 radiosity = noise_image(size, 66, 0, 3), reflectance = noise_image(receivers, 67, 0, 1),
                 gathered = noise_image(receivers, 68, 0, 5);
    const isr::BounceInputs in{&radiosity, &reflectance, &gathered, margin};
    return named(owned_data(isr::data_of({}, in)), id);
}

inline StageData isr_unseen_case(glm::ivec2 size, int margin, isr::Position position, const std::string& id) {
    isr::IsrParams params = isr_params();
    params.position = position;
    const Camera camera = isr_camera(0.3), view = isr_camera();
    const glm::ivec2 seen(size.x + 2 * margin - 6, size.y + 2 * margin);  // narrower: the camera sees beyond its borders
    const Image4 surface = isr_surface(size, 71, position, camera), view_surface = isr_surface(seen, 72, position, view);
    isr::UnseenInputs in;
    in.surface = &surface, in.camera = isr::coarse_camera(camera, 2 * size);
    in.view_surface = &view_surface, in.view = isr::coarse_camera(view, 2 * (seen - 2 * margin)), in.margin = margin;
    return named(owned_data(isr::data_of(params, in)), id);
}

inline StageData isr_gather_camera_case(glm::ivec2 size, const isr::IsrParams& params, const std::string& id,
                                        bool before = false) {
    const Camera camera = isr_camera(), other_camera = isr_camera(0.3);
    const glm::ivec2 sources(size.x - 3, size.y + 2);
    const Image4 surface = isr_surface(size, 61, params.position, camera),
                 source_surface = isr_surface(sources, 73, params.position, other_camera),
                 radiosity = noise_image(sources, 74, 0, 3), other = noise_image(size, 64, 0, 1.5f);
    const isr::Pattern pattern = isr::gather_pattern(params);
    isr::CameraGatherInputs in;
    in.surface = &surface, in.camera = isr::coarse_camera(camera, 2 * size);
    in.source_surface = &source_surface, in.source_radiosity = &radiosity;
    in.source_camera = isr::coarse_camera(other_camera, 2 * sources);
    in.before = before ? &other : nullptr, in.pattern = &pattern, in.seed = 7;
    return named(owned_data(isr::data_of(params, in)), id);
}

inline StageData isr_blur_case(glm::ivec2 size, isr::Blur blur, isr::Variant variant, isr::Direction direction,
                               const std::string& id) {
    const Image4 lit = noise_image(size, 75, 0, 3),
                 surface = isr_surface(size, 61, isr::Position::linear, isr_camera());
    isr::IsrParams params;
    params.blur = blur, params.variant = variant, params.blur_radius = 3, params.blur_sigma = 1.5f;
    return named(owned_data(isr::data_of(params, isr::BlurInputs{&lit, &surface, direction})), id);
}

inline StageData isr_upsample_case(glm::ivec2 size, isr::Upsample mode, isr::Variant variant, isr::Position position,
                                   const std::string& id) {
    const Points p = steps(size, 5);
    const glm::ivec2 half = isr::coarse_size(size);
    const Image4 lit = noise_image(half, 76, 0, 3),
                 surface = isr_surface(half, 61, position, isr_camera());
    isr::IsrParams params;
    params.upsample = mode, params.variant = variant, params.position = position;
    const isr::UpsampleInputs in{&lit, &surface, &p.position, &p.normal, 0.05, 300};
    return named(owned_data(isr::data_of(params, in)), id);
}

inline StageData isr_compose_case(glm::ivec2 size, isr::Variant variant, const std::string& id) {
    const Points p = room(size, 5);
    const Image4 albedo = noise_image(size, 21, 0, 1), emission = noise_image(size, 22, 0, 3),
                 direct = noise_image(size, 23, 0, 1e3f), indirect = noise_image(size, 24, 0, 1.25f);
    isr::IsrParams params;
    params.variant = variant, params.k_ssao = 0.5f, params.k_isr = 0.75f, params.ambient = isr::Ambient::environment;
    const isr::ComposeInputs in{&p.normal, &albedo, &emission, &direct, &indirect, {0.25f, 0.5f, 1}};
    return named(owned_data(isr::data_of(params, in)), id);
}

inline std::vector<StageData> isr_cases(glm::ivec2 size) {
    using namespace isr;
    const IsrParams plain = isr_params();
    IsrParams printed = plain, inverse = plain, turned = plain, fewer = plain;
    printed.variant = Variant::published, inverse.position = Position::inverse_matrix, turned.rotations = 8;
    fewer.far_rings = 1, fewer.full_depth = 1, fewer.rotations = 2;
    const auto horizontal = Direction::horizontal, vertical = Direction::vertical;
    const auto corrected = Variant::corrected, published = Variant::published;
    const auto linear = Position::linear, inverse_matrix = Position::inverse_matrix;
    return {
        isr_downsample_case(size, plain, Coarse::surface, "isr.downsample.surface"),
        isr_downsample_case(size, inverse, Coarse::surface, "isr.downsample.surface.inverse"),
        isr_downsample_case(size, printed, Coarse::surface, "isr.downsample.surface.published"),
        isr_downsample_case(size, plain, Coarse::radiosity, "isr.downsample.radiosity"),
        isr_downsample_case(size, printed, Coarse::radiosity, "isr.downsample.radiosity.published"),
        isr_downsample_case(size, plain, Coarse::reflectance, "isr.downsample.reflectance"),
        isr_gather_case(size, plain, "isr.gather"),
        isr_gather_case(size, turned, "isr.gather.turned", 3, true),
        isr_gather_case(size, fewer, "isr.gather.fewer"),
        isr_gather_case(size, inverse, "isr.gather.inverse", 2),
        isr_gather_case(size, printed, "isr.gather.published", 2, true),
        isr_bounce_case(size, 0, "isr.bounce"),
        isr_bounce_case(size, 2, "isr.bounce.guard"),
        isr_unseen_case(size, 0, linear, "isr.unseen"),
        isr_unseen_case(size, 3, inverse_matrix, "isr.unseen.inverse"),
        isr_gather_camera_case(size, turned, "isr.gather_camera", true),
        isr_gather_camera_case(size, inverse, "isr.gather_camera.inverse"),
        isr_ssao_case(size, plain, "isr.ssao"),
        isr_ssao_case(size, turned, "isr.ssao.turned", 3),
        isr_ssao_case(size, inverse, "isr.ssao.inverse", 2),
        isr_ssao_case(size, printed, "isr.ssao.published"),
        isr_blur_case(size, Blur::gaussian, corrected, horizontal, "isr.blur.rows"),
        isr_blur_case(size, Blur::gaussian, corrected, vertical, "isr.blur.columns"),
        isr_blur_case(size, Blur::edge_aware, corrected, horizontal, "isr.blur.edges.rows"),
        isr_blur_case(size, Blur::edge_aware, corrected, vertical, "isr.blur.edges.columns"),
        isr_blur_case(size, Blur::gaussian, published, horizontal, "isr.blur.published"),
        isr_blur_case(size, Blur::none, corrected, horizontal, "isr.blur.none"),
        isr_upsample_case(size, Upsample::bilateral, corrected, linear, "isr.upsample"),
        isr_upsample_case(size, Upsample::bilateral, corrected, inverse_matrix, "isr.upsample.inverse"),
        isr_upsample_case(size, Upsample::bilateral, published, linear, "isr.upsample.published"),
        isr_upsample_case(size, Upsample::bilinear, corrected, linear, "isr.upsample.bilinear"),
        isr_upsample_case(size, Upsample::bilinear, published, linear, "isr.upsample.bilinear.published"),
        isr_compose_case(size, corrected, "isr.compose"),
        isr_compose_case(size, published, "isr.compose.published"),
    };
}

// ---- Probes ----------------------------------------------------------------------------------------------------------

inline Buffer<glm::vec4> scattered(int n, std::uint32_t seed) {
    Buffer<glm::vec4> list;
    for (int i = 0; i < n; ++i) list.push_back({noise(i, 0, 0, seed), noise(i, 1, 0, seed), noise(i, 2, 0, seed), 0});
    return list;
}
// The last items of the domain are none, and one more lies behind the list.
inline StageData density_case(glm::ivec2 size, float radius, const std::string& id) {
    const int n = size.x * size.y - 5;
    const Buffer<glm::vec4> positions = scattered(n + 1, 81);
    StageData d = begin_data<probes::DensityKernel>(size, probes::DensityUniforms{size.x, size.y, n, 1 / radius});
    lend(d.inputs, "positions", {n + 1, 4}, &positions[0].x);
    return named(owned_data(d), id);
}
// The last probe lies behind the list; every third receiver is a little farther than the radius from one.
inline StageData supports_case(glm::ivec2 size, float radius, int overlaps, const std::string& id) {
    const int n = 40;
    Buffer<glm::vec4> receivers = scattered(size.y, 82), all = scattered(n + 1, 83);
    for (std::size_t i = 0; i < receivers.size(); i += 3)
        receivers[i] = all[i % n] + glm::vec4(1.002f * radius, 0, 0, 0);
    StageData d = owned_data(probes::data_of({&receivers, &all, radius, std::min(size.x, overlaps)}, 0, size.y));
    const double probes = n;
    set_uniform(parity::find_binding(d.stage, "test"), d, "probes", {&probes, 1}, "test");
    return named(d, id);
}

// What receivers' rays met: points, directions of those that met nothing, what no probe sees; a probe without weight.
struct RayInputs {
    int rays, slots = 3;
    Buffer<glm::vec4> supporting, seen;
    std::vector<std::int32_t> visible;
    Buffer<float> lengths, weights;

    RayInputs(int receivers, int rays_of_each) : rays(rays_of_each) {
        supporting = scattered(slots * receivers, 84), seen = scattered(rays * receivers, 85);
        for (std::size_t i = 0; i < supporting.size(); ++i) supporting[i].w = i % 7 == 3 ? 0 : noise(int(i), 3, 0, 84);
        for (std::size_t i = 0; i < seen.size(); ++i) {
            const bool escaped = i % 5 == 0;
            const glm::vec3 d = 2.0f * glm::vec3(seen[i]) - 1.0f;
            seen[i] = escaped ? glm::vec4(normalize3<float>(d), 0) : glm::vec4(5.0f * d, 1);
            visible.push_back(i % 11 == 0 ? 0 : std::int32_t(8 * noise(int(i), 4, 0, 85)));
            lengths.push_back(escaped ? 1e15f : 4 * noise(int(i), 5, 0, 85));
            weights.push_back(0.01f + noise(int(i), 6, 0, 85));
        }
    }
};
inline StageData share_case(glm::ivec2 size, bool published, const std::string& id) {
    const RayInputs r(size.x, size.y);
    probes::ShareInputs in{size.x, size.y, r.slots, published, r.supporting.data(), r.weights.data(), r.visible.data(),
                           r.lengths.data()};
    return named(owned_data(probes::data_of(in)), id);
}
// size.y rows, of all degrees; of few receivers, for there are many rays: a whole part of the sum, and three more.
inline StageData coefficients_case(glm::ivec2 size, const std::string& id) {
    size.x = std::min(size.x, 5);
    const RayInputs r(size.x, 131);
    const std::vector<std::int32_t> all = probes::coefficient_rows(r.slots, 7);
    std::vector<std::int32_t> rows;
    for (int y = 0; y < size.y; ++y)
        for (int c = 0; c < 4; ++c) rows.push_back(all[std::size_t((17 * y % (64 * r.slots)) * 4 + c)]);
    StageData d = begin_data<probes::CoefficientsKernel>(size, probes::CoefficientsUniforms{size.x, size.y, r.rays, r.slots});
    const std::int64_t receivers = size.x;
    lend(d.inputs, "rows", {size.y, 4}, rows.data());
    lend(d.inputs, "recurrence", {sh::recurrence_size}, sh::recurrence().data());
    lend(d.inputs, "supporting", {r.slots * receivers, 4}, &r.supporting[0].x);
    lend(d.inputs, "seen", {r.rays * receivers, 4}, &r.seen[0].x);
    lend(d.inputs, "visible", {r.rays * receivers}, r.visible.data());
    lend(d.inputs, "shares", {r.rays * receivers}, r.weights.data());
    return named(owned_data(d), id);
}

// ---- DDGI ------------------------------------------------------------------------------------------------------------

// Tiles of half a row; the last tile has no probe, and the atlas ends within tiles.
inline StageData ddgi_blend_case(glm::ivec2 size, int side, bool moments, float hysteresis, const std::string& id) {
    const int columns = std::max(1, size.x / (side + 2) - 1), rows = (size.y + side + 1) / (side + 2), rays = 13;
    Buffer<glm::vec4> directions = scattered(rays, 91);
    for (glm::vec4& d : directions) d = glm::vec4(normalize3<float>(2.0f * glm::vec3(d) - 1.0f), 0);
    const Image4 previous = noise_image(size, 92, 0, 3);
    const Image4 hits = noise_image({rays, std::max(1, columns * rows - 1)}, 93, 0, 4);
    ddgi::BlendInputs in;
    in.side = side, in.columns = columns, in.moments = moments, in.sharpness = moments ? 50 : 1, in.hysteresis = hysteresis;
    in.scale = moments ? 1.0f : 3.14159265f, in.farthest = 3;
    in.directions = &directions, in.hits = &hits, in.previous = &previous;
    return named(owned_data(ddgi::data_of(in)), id);
}
inline StageData ddgi_border_case(glm::ivec2 size, int side, const std::string& id) {
    const Image4 atlas = noise_image(size, 94, -1, 1);
    return named(owned_data(ddgi::data_of(ddgi::BorderInputs{side, &atlas})), id);
}
// Points within the grid, beyond it, a kilometre away, and none.
inline StageData ddgi_sample_case(glm::ivec2 size, bool by_eye, const ddgi::Weighing& weighing, const std::string& id) {
    const Points p = room(size, 95);
    ddgi::SampleInputs in;
    in.grid = {{3, 2, 2}, {-1.5f, -0.3f, -2.6f}, {1.3f, 1.1f, 0.9f}};
    in.weighing = weighing, in.side = 6, in.depth_side = 8;
    Image4 view = noise_image(size, 96, -1, 1);
    for (glm::vec4& v : view.texels) v = glm::vec4(normalize3<float>(glm::vec3(v)), 0);
    const Image4 irradiance = noise_image(in.grid.atlas_size(in.side), 97, 0, 9);
    Image4 moments = noise_image(in.grid.atlas_size(in.depth_side), 98, 0, 1);
    for (glm::vec4& m : moments.texels) {
        const float mean = 0.3f + 2 * m.x;
        m = glm::vec4(mean, mean * mean + 0.4f * m.y, 0, 0);
    }
    in.position = &p.position, in.normal = &p.normal, in.view = by_eye ? nullptr : &view, in.eye = {1, 2, 3};
    in.irradiance = &irradiance, in.moments = &moments;
    return named(owned_data(ddgi::data_of(in)), id);
}

// Every compute stage, in every variant of it that is a branch of its own.
inline std::vector<StageData> compute_cases(glm::ivec2 size) {
    using namespace direct;
    std::vector<StageData> cases = {
        shadow_case(size, LightType::spot, 0, ShadowMode::hard, ShadowVariant::corrected, "shadow.hard"),
        shadow_case(size, LightType::directional, 0, ShadowMode::density, ShadowVariant::corrected, "shadow.density"),
        shadow_case(size, LightType::spot, 0, ShadowMode::density, ShadowVariant::published, "shadow.published"),
        shadow_case(size, LightType::point, 3, ShadowMode::hard, ShadowVariant::corrected, "shadow.ny"),
        shadow_case(size, LightType::spot, 0, ShadowMode::pcf, ShadowVariant::corrected, "shadow.pcf"),
        shadow_case(size, LightType::point, 3, ShadowMode::pcf, ShadowVariant::corrected, "shadow.pcf.ny"),
        shadow_case(size, LightType::directional, 0, ShadowMode::esm, ShadowVariant::corrected, "shadow.esm"),
        shadow_case(size, LightType::point, 3, ShadowMode::esm, ShadowVariant::corrected, "shadow.esm.ny"),
        shadow_case(size, LightType::directional, 0, ShadowMode::pcf, ShadowVariant::published, "shadow.pcf.published"),
        shadow_case(size, LightType::spot, 0, ShadowMode::esm, ShadowVariant::published, "shadow.esm.published"),
        log_blur_case(size, 3, 1.5f, direct::Direction::horizontal, "shadow.blur.rows"),
        log_blur_case(size, 8, 4, direct::Direction::vertical, "shadow.blur.columns"),
        direct_case(size, "direct"),
        direct_case(size, "direct.density", true),
        direct_case(size, "direct.published", false, DirectVariant::published),
        gather_case(size, rsm::Gather::disc, LightType::spot, 0, "rsm.disc.spot"),
        gather_case(size, rsm::Gather::disc, LightType::directional, 0.1f, "rsm.disc.sun"),
        gather_case(size, rsm::Gather::disc, LightType::spot, 0, "rsm.disc.continuous", rsm::Texels::continuous),
        gather_case(size, rsm::Gather::all, LightType::spot, 0, "rsm.all.spot"),
        paths_case(size, LightType::spot, {}, "rsm.paths.spot"),
        paths_case(size, LightType::directional, {.visibility = rsm::Visibility::none, .turn = rsm::Turn::tile},
                   "rsm.paths.none"),
        paths_case(size, LightType::spot,
                   {.min_distance = 0.1f, .visibility = rsm::Visibility::algorithm_2, .slots = 32}, "rsm.paths.32"),
        paths_case(size, LightType::spot, {.texels = rsm::Texels::continuous}, "rsm.paths.continuous"),
        paths_case(size, LightType::point,
                   {.radius = 0.6f, .projection = rsm::Projection::clamped, .slots = 3,
                    .slot_edges = rsm::SlotEdges::solid_angle}, "rsm.paths.px"),
        reduce_case(size, "filter.reduce"),
        upsample_case(size, filter::Upsample::bilateral, filter::Similarity::plane, "filter.upsample.plane"),
        upsample_case(size, filter::Upsample::bilateral, filter::Similarity::depth, "filter.upsample.depth"),
        upsample_case(size, filter::Upsample::bilinear, filter::Similarity::plane, "filter.upsample.bilinear"),
        upsample_case(size, filter::Upsample::published, filter::Similarity::plane, "filter.upsample.published"),
        blur_case(size, 9, filter::Similarity::plane, filter::Direction::both, "filter.blur.plane"),
        blur_case(size, 5, filter::Similarity::depth, filter::Direction::both, "filter.blur.depth"),
        blur_case(size, 17, filter::Similarity::plane, filter::Direction::horizontal, "filter.blur.horizontal"),
        blur_case(size, 17, filter::Similarity::plane, filter::Direction::vertical, "filter.blur.vertical"),
        compose_case(size, "compose"),
        compose_case(size, "compose.shadow", {0.25f, 0, 2}),
        tonemap_case(size, compose::Operator::clamp, "tonemap.clamp"),
        tonemap_case(size, compose::Operator::exposure, "tonemap.exposure"),
        tonemap_case(size, compose::Operator::reinhard, "tonemap.reinhard"),
        tonemap_case(size, compose::Operator::filmic, "tonemap.filmic"),
    };
    cases.push_back(density_case(size, 0.3f, "probes.density"));
    cases.push_back(supports_case(size, 0.4f, 15, "probes.supports"));  // most receivers have fewer
    cases.push_back(supports_case(size, 2, 16, "probes.supports.all"));  // every probe is in reach
    cases.push_back(share_case(size, false, "probes.share"));
    cases.push_back(share_case(size, true, "probes.share.published"));
    cases.push_back(coefficients_case(size, "probes.coefficients"));
    cases.push_back(ddgi_blend_case(size, 4, false, 0.25f, "ddgi.blend"));
    cases.push_back(ddgi_blend_case(size, 6, true, 0, "ddgi.blend.moments"));
    cases.push_back(ddgi_border_case(size, 5, "ddgi.border"));
    cases.push_back(ddgi_sample_case(size, false, {.normal_bias = 0.05f, .view_bias = 0.2f, .scale = 1.5f}, "ddgi.sample"));
    cases.push_back(ddgi_sample_case(size, true, {.wrapped = false, .root = true, .view_bias = 0.1f}, "ddgi.sample.root"));
    cases.push_back(ddgi_sample_case(size, true, {.visibility = false}, "ddgi.sample.blind"));
    for (StageData& data : isr_cases(size)) cases.push_back(std::move(data));
    return cases;
}

}  // namespace plumb::test
