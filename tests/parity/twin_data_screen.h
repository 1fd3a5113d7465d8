// Data for the stages of ambient occlusion and of reflections.
#pragma once

#include <vector>

#include "gi/screen/screen.h"
#include "tests/parity/twin_data_parts.h"

namespace plumb::test {

// The rough wall of steps(), as a camera before it sees it.
inline View before_the_steps(glm::ivec2 size) {
    Camera camera;
    camera.position = {0.005 * size.x, -0.005 * size.y, 0.1}, camera.look_at = {0.005 * size.x, -0.004 * size.y, -2};
    camera.fov_y_deg = 14, camera.near = 0.05, camera.far = 300;
    return make_view(camera, double(size.x) / size.y);
}

// The same wall, seen by a camera that leans to its side and stands among the steps: some of them lie behind it.
inline View among_the_steps(glm::ivec2 size) {
    Camera camera;
    camera.position = {0.0051 * size.x, -0.0052 * size.y, -1.97}, camera.look_at = {0.0058 * size.x, -0.0041 * size.y, -2.06};
    camera.up = {0.45, 0.8, 0.1}, camera.fov_y_deg = 95, camera.near = 1e-4, camera.far = 300;
    return make_view(camera, double(size.x) / size.y);
}

// Another view's sums, some of them without any weight.
inline Image4 summed_image(glm::ivec2 size, const Image4& normal) {
    Image4 summed = noise_image(size, 81, 0.1f, 1);
    for (int i = 0; i < int(summed.size()); ++i) {
        glm::vec4& s = summed.texels[std::size_t(i)];
        if (i % 7 == 0) s.x = s.y = 0;
        s.w = 1;
        if (normal.texels[std::size_t(i)].w == 0) s = glm::vec4(0);
    }
    return summed;
}

inline StageData ssao_own_case(glm::ivec2 size, screen::AoParams params, const std::string& id, bool among = false) {
    const Points p = steps(size, 5);
    params.method = screen::AoMethod::ssao, params.radius = 0.3f, params.samples = 16;
    const View view = among ? among_the_steps(size) : before_the_steps(size);
    return named(owned_data(screen::data_of(params, screen::SsaoInputs{&p.position, &p.normal, &p.position, view, !among,
                                                                       nullptr, nullptr})), id);
}

inline StageData ssao_light_case(glm::ivec2 size, LightType type, int face, screen::AoParams params, const std::string& id) {
    const Points p = room(size, 5);
    const raster::Rsm map = make_map(make_light(type, 32), face, 6);
    const Image4 before = summed_image(size, p.normal);
    params.method = screen::AoMethod::ssao, params.views = screen::AoViews::lights;
    params.radius = 0.7f, params.samples = 12;
    return named(owned_data(screen::data_of(params, screen::SsaoInputs{&p.position, &p.normal, &map.position, map.view, false,
                                                                       &before, nullptr})), id);
}

inline StageData horizon_case(glm::ivec2 size, int slices, int steps_a_side, const std::string& id, bool among = false) {
    const Points p = steps(size, 5);
    screen::AoParams params;
    params.method = screen::AoMethod::horizon, params.radius = 0.3f, params.slices = slices, params.steps = steps_a_side;
    return named(owned_data(screen::data_of(params, screen::HorizonInputs{&p.position, &p.normal,
                                                                          among ? among_the_steps(size) : before_the_steps(size), nullptr})), id);
}

inline StageData ao_blur_case(glm::ivec2 size, screen::AoBlur blur, screen::AoVariant variant, const std::string& id) {
    const Points p = steps(size, 5);
    const Image4 summed = summed_image(size, p.normal);
    screen::AoParams params;
    params.blur = blur, params.variant = variant;
    return named(owned_data(screen::data_of(params, screen::BlurInputs{&summed, &p.position, &p.normal, nullptr})), id);
}

inline StageData occlude_case(glm::ivec2 size, const std::string& id) {
    const Image4 indirect = noise_image(size, 82, 0, 30);
    Image4 open = noise_image(size, 83, 0, 1);
    for (std::size_t i = 0; i < open.size(); ++i) open.texels[i].w = i % 5 == 0 ? 0.0f : 1.0f;
    screen::AoParams params;
    params.ambient = {0.5f, 0, 3};
    return named(owned_data(screen::data_of(params, screen::OccludeInputs{&indirect, &open})), id);
}

// The rough wall of steps(), as the camera sees it now and as another view saw it before. Its normals look along all three axes.
enum class SawBefore : int { nothing, aside, among, sun };
inline StageData reuse_case(glm::ivec2 size, screen::ReuseClamp clamp, SawBefore saw, const std::string& id) {
    Points p = steps(size, 5), before = steps(size, 5);
    for (int i = 0; i < size.x * size.y; ++i)
        for (Image4* normal : {&p.normal, &before.normal}) {
            glm::vec4& n = normal->texels[std::size_t(i)];
            if (i / 3 % 3 == 1) n = {n.z, -n.x, n.y, n.w};
            if (i / 3 % 3 == 2) n = {-n.y, n.z, n.x, n.w};
        }
    const Image4 light = noise_image(size, 84, 0, 4), last = noise_image(size, 85, 0, 5);
    Image4 age = noise_image(size, 86, 1, 9);
    for (std::size_t i = 0; i < age.size(); ++i) age.texels[i].w = i % 9 == 4 ? 0.0f : 1.0f;
    Camera camera;
    camera.position = {0.0062 * size.x, -0.0047 * size.y, 0.13}, camera.look_at = {0.0054 * size.x, -0.0043 * size.y, -2};
    camera.up = {0.1, 1, 0}, camera.fov_y_deg = 13, camera.near = 0.05, camera.far = 300;
    View view = make_view(camera, double(size.x) / size.y);
    if (saw == SawBefore::among) view = among_the_steps(size);
    if (saw == SawBefore::sun) view = raster::light_view(make_light(LightType::directional, 32), glm::vec3(-1, -1, -3), glm::vec3(1, 1, -1));
    screen::LastFrame left{last, age, before.position, before.normal, view, size};
    if (saw == SawBefore::nothing) left = {};
    screen::ReuseParams params;
    params.frames = 6, params.clamp = clamp, params.sigma_depth = 0.2f, params.sigma_normal = 0.8f;
    return named(owned_data(screen::data_of(params, screen::ReuseInputs{&light, &p.position, &p.normal, before_the_steps(size), &left, {}})), id);
}

// ---- Reflections --------------------------------------------------------------------------------------------------------

// A camera before a floor, a wall behind it and a board between them, all a little rough: mirrors but for every 7th pixel.
struct MirrorRoom {
    Camera camera;
    View view;
    Image4 position, normal, mirror, lobe;

    explicit MirrorRoom(glm::ivec2 size)
        : position(size.x, size.y), normal(size.x, size.y), mirror(size.x, size.y), lobe(size.x, size.y) {
        camera.position = {0.3, 1.1, 2.4}, camera.look_at = {0.1, 0.45, -1}, camera.fov_y_deg = 50, camera.near = 0.05;
        view = make_view(camera, double(size.x) / size.y);
        struct Plane {
            glm::dvec3 normal;
            double offset;
            bool board;
        };
        const Plane planes[] = {{{0, 1, 0}, 0, false}, {{0, 0, 1}, -1, false}, {{0, 0, 1}, 0.4, true}};
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) {
                const Ray ray = ray_through_pixel(camera, size, {x, y});
                double nearest = 30;
                for (const Plane& p : planes) {
                    const double down = glm::dot(p.normal, ray.direction), t = (p.offset - glm::dot(p.normal, ray.origin)) / down;
                    const glm::dvec3 at = ray.origin + ray.direction * t;
                    if (!(down < 0) || !(t > 0) || t >= nearest || (p.board && (at.y > 0.7 || at.x < 0.2))) continue;
                    if (!p.board && p.offset < 0 && at.y > 1.4) continue;  // nothing is above the wall
                    nearest = t;
                    const float rough = 0.02f;
                    const glm::vec3 bump(noise(x, y, 0, 91) - 0.5f, noise(x, y, 1, 91) - 0.5f, noise(x, y, 2, 91) - 0.5f);
                    position(x, y) = glm::vec4(glm::vec3(at), float(linear_depth(camera, at)));
                    normal(x, y) = glm::vec4(glm::normalize(glm::vec3(p.normal) + rough * bump), 1);
                    mirror(x, y) = (x + 3 * y) % 7 == 0 ? glm::vec4(0) : glm::vec4(0.25f + 0.5f * noise(x, y, 3, 91), 0.5f, 0.75f, 1);
                    const float exponents[] = {0, 1, 8, 60, 1e3f, 1e6f};
                    lobe(x, y) = (x + y) % 5 == 0 ? glm::vec4(0) : glm::vec4(0.2f, 0.3f * noise(x, y, 4, 91), 0, exponents[(2 * x + y) % 6]);
                }
            }
    }
};

inline screen::LobeInputs lobes_of(const MirrorRoom& room) {
    return {&room.position, &room.normal, &room.mirror, &room.lobe, room.camera.position, 11};
}
inline StageData lobe_case(glm::ivec2 size, int rays, const std::string& id) {
    const MirrorRoom room(size);
    screen::ReflectParams params;
    params.lobe = screen::Lobe::phong, params.rays = rays;
    return named(owned_data(screen::data_of(params, lobes_of(room))), id);
}

inline StageData reflect_case(glm::ivec2 size, screen::ReflectParams params, const std::string& id) {
    const MirrorRoom room(size);
    params.march = screen::March::steps;
    screen::ReflectInputs in;
    in.position = in.seen = &room.position, in.normal = in.seen_normal = &room.normal, in.mirror = &room.mirror;
    in.eye = room.camera.position, in.view = room.view;
    return named(owned_data(screen::data_of(params, in)), id);
}

// What earlier views found: the camera, or another map, nearer and farther.
inline Image4 hits_before(glm::ivec2 size) {
    Image4 hits(size.x, size.y);
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x)
            hits(x, y) = glm::vec4((5 * x + y) % size.x, (3 * y + x) % size.y, 6 * noise(x, y, 0, 92), float((x + y) % 4 == 3 ? 1 : (x + y) % 4));
    for (glm::vec4& hit : hits.texels)
        if (hit.w == 0) hit = glm::vec4(0);
    return hits;
}

inline StageData reflect_map_case(glm::ivec2 size, LightType type, int face, const std::string& id) {
    const MirrorRoom room(size);
    const raster::Rsm map = make_map(make_light(type, 32), face, 6);
    const Image4 before = hits_before(size);
    screen::ReflectParams params;
    params.march = screen::March::steps, params.views = screen::ReflectViews::lights;
    params.step = 0.15f, params.steps = 24, params.bisections = 5, params.thickness = 4;
    screen::ReflectInputs in;
    in.position = &room.position, in.normal = &room.normal, in.mirror = &room.mirror, in.eye = room.camera.position;
    in.seen = &map.position, in.seen_normal = &map.normal, in.view = map.view, in.number = 4, in.before = &before;
    return named(owned_data(screen::data_of(params, in)), id);
}

// The same, from texel to texel.
inline StageData cells_case(screen::ReflectParams params, screen::ReflectInputs in, const std::string& id) {
    params.march = screen::March::hierarchical;
    Image4 nearest;
    screen::run(params, screen::NearestInputs{in.seen}, {}, nearest);
    return named(owned_data(screen::data_of(params, screen::CellsInputs{in, &nearest, nullptr})), id);
}

inline StageData cells_own_case(glm::ivec2 size, screen::ReflectParams params, const std::string& id) {
    const MirrorRoom room(size);
    screen::ReflectInputs in;
    in.position = in.seen = &room.position, in.normal = in.seen_normal = &room.normal, in.mirror = &room.mirror;
    in.eye = room.camera.position, in.view = room.view;
    return cells_case(params, in, id);
}

inline StageData cells_map_case(glm::ivec2 size, LightType type, int face, const std::string& id) {
    const MirrorRoom room(size);
    const raster::Rsm map = make_map(make_light(type, 32), face, 6);
    const Image4 before = hits_before(size);
    screen::ReflectParams params;
    params.views = screen::ReflectViews::lights, params.thickness = 6;
    screen::ReflectInputs in;
    in.position = &room.position, in.normal = &room.normal, in.mirror = &room.mirror, in.eye = room.camera.position;
    in.seen = &map.position, in.seen_normal = &map.normal, in.view = map.view, in.number = 4, in.before = &before;
    return cells_case(params, in, id);
}

// Rays of lobes in what the camera sees, and what pixels show by them.
inline StageData rough_case(glm::ivec2 size, screen::March march, const std::string& id) {
    const MirrorRoom room(size);
    screen::ReflectParams params;
    params.march = march, params.lobe = screen::Lobe::phong, params.rays = 2, params.steps = 24, params.bisections = 4;
    Image4 rays;
    screen::run(params, lobes_of(room), {}, rays);
    screen::ReflectInputs in;
    in.position = in.seen = &room.position, in.normal = in.seen_normal = &room.normal, in.mirror = &room.mirror;
    in.eye = room.camera.position, in.view = room.view, in.rays = &rays;
    if (march == screen::March::hierarchical) return cells_case(params, in, id);
    return named(owned_data(screen::data_of(params, in)), id);
}
inline StageData rough_mirror_case(glm::ivec2 size, int rays, screen::ReflectParams params, const std::string& id) {
    const MirrorRoom room(size);
    params.lobe = screen::Lobe::phong, params.rays = rays;
    Image4 drawn;
    screen::run(params, lobes_of(room), {}, drawn);
    const glm::ivec2 sheet = screen::sheet_of(size, 1 + rays);
    const Image4 hits = hits_before(sheet), composed = noise_image(size, 93, 0, 20), albedo = noise_image(sheet, 94, 0, 1);
    const Image4 emission = noise_image(sheet, 95, 0, 3), direct = noise_image(sheet, 96, 0, 40);
    const screen::MirrorInputs in{&hits, &room.mirror, &composed, &albedo, &emission, &direct, &room.lobe, &drawn};
    return named(owned_data(screen::data_of(params, in)), id);
}

inline StageData nearest_case(glm::ivec2 size, const std::string& id) {
    const MirrorRoom room(size);
    return named(owned_data(screen::data_of(screen::ReflectParams{}, screen::NearestInputs{&room.position})), id);
}

inline StageData mirror_case(glm::ivec2 size, bool of_maps, screen::ReflectParams params, const std::string& id) {
    const MirrorRoom room(size);
    Image4 hits = hits_before(size);
    for (int i = 0; i < int(hits.size()); ++i)
        if (hits.texels[std::size_t(i)].w > 1) hits.texels[std::size_t(i)].w += float(i % 3);
    // A dump's hits may lie outside of the picture, a texel beside it or far.
    const glm::vec2 outside[] = {{-1, 2}, {size.x, 2}, {2, -1}, {2, size.y}, {-1000, 3}, {3, 70000}};
    for (int i = 0; i < 6; ++i) hits.texels[std::size_t(19 * i + 5) % hits.size()] = glm::vec4(outside[i].x, outside[i].y, 1, 1);
    const Image4 composed = noise_image(size, 93, 0, 20), albedo = noise_image(size, 94, 0, 1);
    const Image4 emission = noise_image(size, 95, 0, 3), direct = noise_image(size, 96, 0, 40);
    screen::MirrorInputs in{&hits, &room.mirror, &composed};
    if (of_maps) in.albedo = &albedo, in.emission = &emission, in.direct = &direct;
    return named(owned_data(screen::data_of(params, in)), id);
}

inline std::vector<StageData> reflect_cases(glm::ivec2 size) {
    using namespace screen;
    ReflectParams fine, printed, thin, few, fading, short_rays, hasty;
    hasty.cells = 9;
    thin.variant = ReflectVariant::published, thin.thickness = 0.05f;
    few.step = 0.15f, few.steps = 7;
    short_rays.steps = 12, short_rays.cells = 20, short_rays.thickness = 0.5f;
    fine.step = 0.04f, fine.steps = 100, fine.bisections = 3, fine.thickness = 2;
    printed.variant = ReflectVariant::published;
    fading.fade = 0.3f, fading.attenuation = 1.5f;
    return {
        lobe_case(size, 1, "screen.lobe.one"),
        lobe_case(size, 6, "screen.lobe"),
        rough_case(size, March::steps, "screen.reflect.rough"),
        rough_case(size, March::hierarchical, "screen.cells.rough"),
        rough_mirror_case(size, 1, fading, "screen.mirror.rough.one"),
        rough_mirror_case(size, 5, {}, "screen.mirror.rough"),
        reflect_case(size, {}, "screen.reflect"),
        reflect_case(size, fine, "screen.reflect.fine"),
        reflect_case(size, few, "screen.reflect.few"),
        reflect_case(size, printed, "screen.reflect.published"),
        reflect_case(size, thin, "screen.reflect.published.thin"),
        reflect_map_case(size, LightType::spot, 0, "screen.reflect.spot"),
        reflect_map_case(size, LightType::directional, 0, "screen.reflect.sun"),
        reflect_map_case(size, LightType::point, 3, "screen.reflect.ny"),
        nearest_case(size, "screen.nearest"),
        nearest_case({2 * size.x + 5, 3 * size.y}, "screen.nearest.large"),
        cells_own_case(size, {}, "screen.cells"),
        cells_own_case(size, short_rays, "screen.cells.short"),
        cells_own_case(size, hasty, "screen.cells.hasty"),
        cells_map_case(size, LightType::spot, 0, "screen.cells.spot"),
        cells_map_case(size, LightType::directional, 0, "screen.cells.sun"),
        cells_map_case(size, LightType::point, 3, "screen.cells.ny"),
        mirror_case(size, true, {}, "screen.mirror"),
        mirror_case(size, true, fading, "screen.mirror.fading"),
        mirror_case(size, false, {}, "screen.mirror.camera"),
    };
}

inline std::vector<StageData> screen_cases(glm::ivec2 size) {
    using namespace screen;
    AoParams printed, weighted;
    printed.variant = AoVariant::published;
    weighted.views = AoViews::lights;
    return {
        ssao_own_case(size, {}, "screen.ssao"),
        ssao_own_case(size, weighted, "screen.ssao.weighted"),
        ssao_own_case(size, printed, "screen.ssao.published"),
        ssao_own_case(size, weighted, "screen.ssao.among", true),
        ssao_light_case(size, LightType::spot, 0, {}, "screen.ssao.spot"),
        ssao_light_case(size, LightType::directional, 0, {}, "screen.ssao.sun"),
        ssao_light_case(size, LightType::point, 3, {}, "screen.ssao.ny"),
        ssao_light_case(size, LightType::spot, 0, printed, "screen.ssao.spot.published"),
        horizon_case(size, 3, 6, "screen.horizon"),
        horizon_case(size, 1, 3, "screen.horizon.one"),
        horizon_case(size, 1, 3, "screen.horizon.among", true),
        ao_blur_case(size, AoBlur::box, AoVariant::corrected, "screen.blur"),
        ao_blur_case(size, AoBlur::edge_aware, AoVariant::corrected, "screen.blur.edges"),
        ao_blur_case(size, AoBlur::box, AoVariant::published, "screen.blur.published"),
        ao_blur_case(size, AoBlur::none, AoVariant::corrected, "screen.blur.none"),
        occlude_case(size, "screen.occlude"),
        reuse_case(size, ReuseClamp::none, SawBefore::aside, "screen.reuse"),
        reuse_case(size, ReuseClamp::box, SawBefore::aside, "screen.reuse.box"),
        reuse_case(size, ReuseClamp::box, SawBefore::among, "screen.reuse.among"),
        reuse_case(size, ReuseClamp::box, SawBefore::sun, "screen.reuse.sun"),
        reuse_case(size, ReuseClamp::box, SawBefore::nothing, "screen.reuse.first"),
    };
}

}  // namespace plumb::test
