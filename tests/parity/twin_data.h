// Data for every compute stage, made by hand: a floor and a wall, a map of each kind of light, and pixels that hold
// nothing, lie far away or sit on borders. Small, so that every stage runs in a moment.
#pragma once

#include <vector>

#include "gi/compose/compose.h"
#include "gi/direct/direct.h"
#include "gi/direct/visibility_filter.h"
#include "gi/filter/filter.h"
#include "gi/rsm/gather.h"
#include "tests/parity/twin_data_isr.h"
#include "tests/parity/twin_data_parts.h"
#include "tests/parity/twin_data_probes.h"
#include "tests/parity/twin_data_radiosity.h"
#include "tests/parity/twin_data_relight.h"
#include "tests/parity/twin_data_screen.h"
#include "tests/parity/twin_data_zbuffer.h"

namespace plumb::test {

inline StageData shadow_case(glm::ivec2 size, LightType type, int face, direct::ShadowMode mode,
                             direct::ShadowVariant variant, const std::string& id,
                             direct::ShadowTest test = direct::ShadowTest::depth, int square = 1) {
    const Light light = make_light(type, 48);
    std::vector<raster::Rsm> maps;
    for (int f = 0; f < raster::map_count(light); ++f) maps.push_back(make_map(light, f, 3));
    const Points p = room(size, 5);
    direct::ShadowParams params;
    params.mode = mode;
    params.variant = variant;
    params.test = test, params.pcf_kernel = square;
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

// Shadows in between on blocks of two depths, with holes.
inline StageData shadow_filter_case(glm::ivec2 size, direct::VisibilityFilter filter, int radius, float sigma,
                                    direct::Direction direction, const std::string& id) {
    const Points p = steps(size, 5);
    Buffer<float> visibility(p.position.size());
    for (std::size_t i = 0; i < visibility.size(); ++i) visibility[i] = i % 3 == 0 ? 1 : noise(int(i), 0, 0, 10);
    direct::ShadowParams params;
    params.filter = filter, params.filter_radius = radius, params.filter_sigma = sigma;
    const direct::VisibilityFilterInputs in{visibility.data(), &p.position, &p.normal, direction};
    return named(owned_data(direct::data_of(params, in)), id);
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
                             const std::string& id, rsm::Texels texels = rsm::Texels::whole,
                             rsm::SampleArea sample_area = rsm::SampleArea::none, rsm::Turn turn = rsm::Turn::hash) {
    const Light light = make_light(type, gather == rsm::Gather::disc ? 64 : 24);
    const raster::Rsm map = make_map(light, 0, 3);
    rsm::GatherParams params;
    params.gather = gather;
    params.samples = 60;
    params.min_distance = min_distance;
    params.texels = texels;
    params.sample_area = sample_area;
    params.turn = turn;
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

inline StageData tonemap_case(glm::ivec2 size, const compose::TonemapParams& params, const std::string& id) {
    const Image4 radiance = noise_image(size, 31, -0.1f, 6);
    return named(owned_data(compose::data_of(params, compose::TonemapInputs{&radiance})), id);
}
inline StageData tonemap_case(glm::ivec2 size, compose::Operator op, const std::string& id) {
    return tonemap_case(size, compose::TonemapParams{op, 0.7f}, id);
}

// Every compute stage, in every variant of it that is a branch of its own.
inline std::vector<StageData> compute_cases(glm::ivec2 size) {
    using namespace direct;
    std::vector<StageData> cases = {
        shadow_case(size, LightType::spot, 0, ShadowMode::hard, ShadowVariant::corrected, "shadow.hard"),
        shadow_case(size, LightType::directional, 0, ShadowMode::density, ShadowVariant::corrected, "shadow.density"),
        shadow_case(size, LightType::spot, 0, ShadowMode::density, ShadowVariant::published, "shadow.published"),
        shadow_case(size, LightType::point, 3, ShadowMode::hard, ShadowVariant::corrected, "shadow.ny"),
        shadow_case(size, LightType::spot, 0, ShadowMode::hard, ShadowVariant::corrected, "shadow.plane", ShadowTest::plane),
        shadow_case(size, LightType::directional, 0, ShadowMode::density, ShadowVariant::corrected, "shadow.planes", ShadowTest::planes),
        shadow_case(size, LightType::spot, 0, ShadowMode::pcf, ShadowVariant::corrected, "shadow.square", ShadowTest::planes, 3),
        shadow_case(size, LightType::point, 3, ShadowMode::pcf, ShadowVariant::corrected, "shadow.square.ny", ShadowTest::planes, 4),
        shadow_case(size, LightType::spot, 0, ShadowMode::pcf, ShadowVariant::corrected, "shadow.pcf"),
        shadow_case(size, LightType::point, 3, ShadowMode::pcf, ShadowVariant::corrected, "shadow.pcf.ny"),
        shadow_case(size, LightType::directional, 0, ShadowMode::esm, ShadowVariant::corrected, "shadow.esm"),
        shadow_case(size, LightType::point, 3, ShadowMode::esm, ShadowVariant::corrected, "shadow.esm.ny"),
        shadow_case(size, LightType::directional, 0, ShadowMode::pcf, ShadowVariant::published, "shadow.pcf.published"),
        shadow_case(size, LightType::spot, 0, ShadowMode::esm, ShadowVariant::published, "shadow.esm.published"),
        log_blur_case(size, 3, 1.5f, direct::Direction::horizontal, "shadow.blur.rows"),
        log_blur_case(size, 8, 4, direct::Direction::vertical, "shadow.blur.columns"),
        shadow_filter_case(size, VisibilityFilter::gaussian, 4, 2, direct::Direction::horizontal, "shadow.filter.rows"),
        shadow_filter_case(size, VisibilityFilter::edge_aware, 4, 2, direct::Direction::horizontal, "shadow.filter.edges.rows"),
        shadow_filter_case(size, VisibilityFilter::edge_aware, 8, 4, direct::Direction::vertical, "shadow.filter.edges.columns"),
        direct_case(size, "direct"),
        direct_case(size, "direct.density", true),
        direct_case(size, "direct.published", false, DirectVariant::published),
        gather_case(size, rsm::Gather::disc, LightType::spot, 0, "rsm.disc.spot"),
        gather_case(size, rsm::Gather::disc, LightType::directional, 0.1f, "rsm.disc.sun"),
        gather_case(size, rsm::Gather::disc, LightType::spot, 0, "rsm.disc.tiles", rsm::Texels::whole, rsm::SampleArea::none,
                    rsm::Turn::tile),
        gather_case(size, rsm::Gather::disc, LightType::spot, 0, "rsm.disc.continuous", rsm::Texels::continuous),
        gather_case(size, rsm::Gather::disc, LightType::spot, 0, "rsm.disc.area", rsm::Texels::whole,
                    rsm::SampleArea::texels),
        gather_case(size, rsm::Gather::disc, LightType::directional, 0.1f, "rsm.disc.area.sun", rsm::Texels::continuous,
                    rsm::SampleArea::texels),
        gather_case(size, rsm::Gather::all, LightType::spot, 0, "rsm.all.spot"),
        paths_case(size, LightType::spot, {.turn = rsm::Turn::hash}, "rsm.paths.spot"),
        paths_case(size, LightType::directional, {.visibility = rsm::Visibility::none, .turn = rsm::Turn::tile},
                   "rsm.paths.none"),
        paths_case(size, LightType::spot,
                   {.min_distance = 0.1f, .visibility = rsm::Visibility::algorithm_2, .slots = 32}, "rsm.paths.32"),
        paths_case(size, LightType::spot, {.texels = rsm::Texels::continuous}, "rsm.paths.continuous"),
        paths_case(size, LightType::spot, {.sample_area = rsm::SampleArea::texels}, "rsm.paths.area"),
        paths_case(size, LightType::spot, {.slots = 9, .thickness = 0.4f}, "rsm.paths.thick"),
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
        tonemap_case(size, {compose::Operator::exposure, 11.9f, 0.03f, 2.1f, 1.58f}, "tonemap.figure_a_1"),
    };
    for (StageData& data : probe_cases(size)) cases.push_back(std::move(data));
    for (StageData& data : relight_cases(size)) cases.push_back(std::move(data));
    for (StageData& data : radiosity_cases(size)) cases.push_back(std::move(data));
    for (StageData& data : zbuffer_cases(size)) cases.push_back(std::move(data));
    for (StageData& data : isr_cases(size)) cases.push_back(std::move(data));
    for (StageData& data : screen_cases(size)) cases.push_back(std::move(data));
    for (StageData& data : reflect_cases(size)) cases.push_back(std::move(data));
    return cases;
}

}  // namespace plumb::test
