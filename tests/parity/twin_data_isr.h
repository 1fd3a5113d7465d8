// Data for the stages of image-space radiosity.
#pragma once

#include <vector>

#include "gi/isr/isr.h"
#include "tests/parity/twin_data_parts.h"

namespace plumb::test {

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
    const glm::ivec2 full = params.resolution == isr::Resolution::native ? size : glm::ivec2(2 * size.x - 1, 2 * size.y);
    const Points p = room(full, 5);
    Image4 albedo = noise_image(full, 51, 0, 1);
    for (std::size_t i = 0; i < albedo.size(); i += 3) albedo.texels[i].w = 0;  // no radiation mask
    Image4 normal = p.normal;
    if (full.x > 5 && full.y > 5) {
        normal(4, 4) = glm::vec4(0, 1, 0, 1), normal(5, 4) = glm::vec4(0, -1, 0, 1);  // that cancel
        normal(4, 5) = normal(5, 5) = glm::vec4(0);
    }
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
    const isr::Pattern pattern = isr::gather_pattern(params, size.y);
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

inline StageData isr_bounce_case(glm::ivec2 size, int margin, const std::string& id,
                                 isr::Variant variant = isr::Variant::corrected) {
    const glm::ivec2 receivers = size - 2 * margin;
    const Image4 radiosity = noise_image(size, 66, 0, 3), reflectance = noise_image(receivers, 67, 0, 1),
                 gathered = noise_image(receivers, 68, 0, 5);
    const isr::BounceInputs in{&radiosity, &reflectance, &gathered, margin};
    isr::IsrParams params;
    params.variant = variant;
    return named(owned_data(isr::data_of(params, in)), id);
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
    const isr::Pattern pattern = isr::gather_pattern(params, sources.y);
    isr::CameraGatherInputs in;
    in.surface = &surface, in.camera = isr::coarse_camera(camera, 2 * size);
    in.source_surface = &source_surface, in.source_radiosity = &radiosity;
    in.source_camera = isr::coarse_camera(other_camera, 2 * sources);
    in.before = before ? &other : nullptr, in.pattern = &pattern, in.seed = 7;
    return named(owned_data(isr::data_of(params, in)), id);
}

inline StageData isr_blur_case(glm::ivec2 size, isr::Blur blur, isr::Variant variant, isr::Direction direction,
                               const std::string& id) {
    const Camera camera = isr_camera();
    const glm::vec3 to_eye(glm::normalize(camera.position - camera.look_at));
    const Image4 lit = noise_image(size, 75, 0, 3);
    Image4 surface = isr_surface(size, 61, isr::Position::linear, camera);
    // Two of three pixels face the eye, more or less, and are a few hundredths of their depth apart: neither near nor beyond.
    for (std::size_t i = 0; i < surface.size(); ++i) {
        glm::vec4& s = surface.texels[i];
        if (i % 3 == 0 || !(s.w > 0) || s.w > 10) continue;
        s = glm::vec4(normalize3<float>(glm::vec3(s) * 0.5f + to_eye), 2 + 0.1f * (s.w - 2));
    }
    isr::IsrParams params;
    params.blur = blur, params.variant = variant, params.blur_radius = 3, params.blur_sigma = 1.5f;
    const isr::BlurInputs in{&lit, &surface, isr::coarse_camera(camera, 2 * size), direction};
    return named(owned_data(isr::data_of(params, in)), id);
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

inline StageData isr_compose_case(glm::ivec2 size, isr::Variant variant, const std::string& id,
                                  isr::SsaoTerm term = isr::SsaoTerm::accessibility, float light_unit = 0) {
    const Points p = room(size, 5);
    const Image4 albedo = noise_image(size, 21, 0, 1), emission = noise_image(size, 22, 0, 3),
                 direct = noise_image(size, 23, 0, 1e3f), indirect = noise_image(size, 24, 0, 1.25f);
    isr::IsrParams params;
    params.variant = variant, params.k_ssao = 0.5f, params.k_isr = 0.75f, params.ambient = isr::Ambient::environment;
    params.ssao_term = term, params.light_unit = light_unit;
    const isr::ComposeInputs in{&p.normal, &albedo, &emission, &direct, &indirect, {0.25f, 0.5f, 1}};
    return named(owned_data(isr::data_of(params, in)), id);
}

inline std::vector<StageData> isr_cases(glm::ivec2 size) {
    using namespace isr;
    const IsrParams plain = isr_params();
    IsrParams printed = plain, inverse = plain, turned = plain, fewer = plain, ringed = plain, tiled = plain;
    printed.variant = Variant::published, inverse.position = Position::inverse_matrix, turned.rotations = 8;
    fewer.far_rings = 1, fewer.full_depth = 1, fewer.rotations = 2;
    ringed.spacing = 0, ringed.reach = 0.5f, ringed.rotations = 8;
    tiled.spacing = 0, tiled.reach = 0.5f, tiled.rotations = 16;
    IsrParams native = plain, summed = printed, by_angle = printed;
    native.resolution = Resolution::native;
    summed.solid_angle = SolidAngle::none, summed.length_unit = 0.25f;
    by_angle.solid_angle = SolidAngle::hemisphere, by_angle.far_rings = 1, by_angle.full_depth = 1;
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
        isr_downsample_case(size, native, Coarse::surface, "isr.downsample.surface.native"),
        isr_downsample_case(size, native, Coarse::radiosity, "isr.downsample.radiosity.native"),
        isr_gather_case(size, plain, "isr.gather"),
        isr_gather_case(size, turned, "isr.gather.turned", 3, true),
        isr_gather_case(size, fewer, "isr.gather.fewer"),
        isr_gather_case(size, ringed, "isr.gather.rings", 3, true),
        isr_gather_case(size, tiled, "isr.gather.tiles", 3, true),
        isr_gather_case(size, inverse, "isr.gather.inverse", 2),
        isr_gather_case(size, printed, "isr.gather.published", 2, true),
        isr_gather_case(size, summed, "isr.gather.published.sum", 2, true),
        isr_gather_case(size, by_angle, "isr.gather.published.hemisphere"),
        isr_bounce_case(size, 0, "isr.bounce"),
        isr_bounce_case(size, 2, "isr.bounce.guard"),
        isr_bounce_case(size, 2, "isr.bounce.published", published),
        isr_unseen_case(size, 0, linear, "isr.unseen"),
        isr_unseen_case(size, 3, inverse_matrix, "isr.unseen.inverse"),
        isr_gather_camera_case(size, turned, "isr.gather_camera", true),
        isr_gather_camera_case(size, ringed, "isr.gather_camera.rings", true),
        isr_gather_camera_case(size, tiled, "isr.gather_camera.tiles", true),
        isr_gather_camera_case(size, inverse, "isr.gather_camera.inverse"),
        isr_ssao_case(size, plain, "isr.ssao"),
        isr_ssao_case(size, turned, "isr.ssao.turned", 3),
        isr_ssao_case(size, tiled, "isr.ssao.tiles", 3),
        isr_ssao_case(size, inverse, "isr.ssao.inverse", 2),
        isr_ssao_case(size, printed, "isr.ssao.published"),
        isr_ssao_case(size, summed, "isr.ssao.published.sum"),
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
        isr_compose_case(size, published, "isr.compose.published.occlusion", SsaoTerm::occlusion, 2.5f),
    };
}

}  // namespace plumb::test
