#include "tools/mutants/dispatches.h"

#include <algorithm>
#include <bit>
#include <cstddef>

#include "core/hash.h"
#include "gi/compose/compose.h"
#include "gi/filter/filter.h"
#include "gi/frame/frame.h"
#include "gi/parity/stages.h"
#include "io/scene_file.h"
#include "raster/light_kernel.h"
#include "tests/parity/twin_data.h"
#include "tools/mutants/panels.h"
#include "tools/mutants/ties.h"

namespace plumb::mutants {
namespace {

struct Lit {
    Scene scene;
    frame::Settings settings;
    frame::Plan plan;
    frame::Frame frame;
};

Lit execute(Scene scene, const frame::Settings& settings) {
    Lit lit{std::move(scene), settings, {}, {}};
    lit.plan = frame::plan(lit.scene, lit.settings);
    lit.frame = frame::execute(lit.scene, lit.settings, lit.plan, {});
    return lit;
}

// The dispatches of those stages, under other settings, of a frame that is there.
void append(const std::string& name, const Lit& lit, const frame::Settings& settings,
            const std::vector<std::string>& stages, std::vector<Dispatch>& out) {
    const frame::Plan plan = frame::plan(lit.scene, settings);
    for (StageData& data : parity::frame_data(lit.scene, settings, plan, lit.frame))
        if (std::find(stages.begin(), stages.end(), data.stage) != stages.end())
            out.push_back({name + ": " + data.id, std::move(data)});
}

// A spot with a wide penumbra, a lamp that shines everywhere, and a sun through the open side.
std::vector<Light> three_lights() {
    Light key, bulb, sun;
    key.name = "key", key.position = {0, 1.97f, 0}, key.direction = {0.1f, -0.99f, -0.1f};
    key.direction = normalize3<float>(key.direction);
    key.cone_inner_deg = 25, key.cone_outer_deg = 60, key.intensity = {12, 11, 9}, key.rsm_size = 48;
    bulb.name = "bulb", bulb.type = LightType::point, bulb.position = {-0.45f, 1.3f, 0.4f};
    bulb.intensity = {1, 1.5f, 2}, bulb.rsm_size = 40;
    sun.name = "sun", sun.type = LightType::directional, sun.direction = normalize3<float>(glm::vec3(0.3f, -0.5f, -1));
    sun.intensity = {2, 2, 1.5f}, sun.rsm_size = 48;
    return {key, bulb, sun};
}

void append_cornell(const std::filesystem::path& source, std::vector<Dispatch>& out) {
    Scene scene = io::load_scene((source / "data/scenes/cornell_small.toml").string(), frame::method_tables());
    scene.settings.clear();
    scene.lights = three_lights();
    scene.frame_size = {96, 80};
    frame::Settings settings;
    settings.rsm.samples = 40, settings.rsm.rotations = 16, settings.rsm.radius = 0.4f;
    settings.shadow.mode = direct::ShadowMode::density, settings.shadow.kernel = 3;
    const Lit lit = execute(scene, settings);
    append("cornell", lit, settings, {"gbuffer", "rsm", "shadow", "direct", "rsm.disc", "compose"}, out);

    frame::Settings hard = settings, published = settings;
    hard.shadow.mode = direct::ShadowMode::hard, hard.shadow.max_slope = 1.5f;
    published.shadow.variant = direct::ShadowVariant::published;
    append("cornell, hard", lit, hard, {"shadow"}, out);
    append("cornell, published", lit, published, {"shadow"}, out);
    frame::Settings coloured = settings, printed = settings;
    coloured.compose.shadow_color = glm::vec3(0.1f, 0.2f, 0.4f);
    printed.direct.variant = direct::DirectVariant::published;
    append("cornell, shadow density", lit, coloured, {"direct"}, out);
    append("cornell, density without the first light", lit, coloured, {"direct"}, out);
    for (Array& input : out.back().data.inputs.arrays)
        if (input.name == "lights")
            std::fill_n(input.bytes.begin() + offsetof(raster::LightArgs, intensity), 3 * sizeof(float), 0);
    append("cornell, direct light as printed", lit, printed, {"direct"}, out);

    // Paths of eight by five, and what the twin's branches are for: Algorithm 2, tiles, no visibility.
    frame::Settings paths = settings, tiled = settings, unhidden = settings;
    paths.rsm.gather = rsm::Gather::paths, paths.rsm.directions = 8, paths.rsm.steps = 5;
    tiled.rsm = unhidden.rsm = paths.rsm;
    tiled.rsm.visibility = rsm::Visibility::algorithm_2, tiled.rsm.slots = 9, tiled.rsm.turn = rsm::Turn::tile;
    tiled.rsm.projection = rsm::Projection::clamped;
    unhidden.rsm.visibility = rsm::Visibility::none;
    append("cornell, paths", lit, paths, {"rsm.paths"}, out);
    append("cornell, paths by tiles", lit, tiled, {"rsm.paths"}, out);
    append("cornell, paths without visibility", lit, unhidden, {"rsm.paths"}, out);

    // Ties, for the lights that have one map.
    std::vector<Dispatch> tied;
    append("cornell with ties", lit, settings, {"shadow", "rsm.disc"}, tied);
    append("cornell with ties, hard", lit, hard, {"shadow"}, tied);
    append("cornell with ties, paths", lit, paths, {"rsm.paths"}, tied);
    for (Dispatch& d : tied)
        if (d.data.id.find(".bulb.") == std::string::npos) plant_ties(d.data), out.push_back(std::move(d));

    // The filters of indirect light, on odd sides, in their modes and forms.
    scene.frame_size = {95, 79};
    frame::Settings filtered = settings, by_depth = settings, bilinear = settings, printed_picks = settings;
    filtered.indirect.resolution = filter::Resolution::half, filtered.indirect.blur = filter::Blur::separable;
    filtered.indirect.kernel = 7;
    by_depth.indirect = bilinear.indirect = printed_picks.indirect = filtered.indirect;
    by_depth.indirect.similarity = filter::Similarity::depth, by_depth.indirect.blur = filter::Blur::full;
    bilinear.indirect.upsample = filter::Upsample::bilinear;
    printed_picks.indirect.upsample = filter::Upsample::published;
    const Lit half = execute(scene, filtered);
    append("cornell, filtered", half, filtered, {"filter.reduce", "filter.upsample", "filter.blur"}, out);
    append("cornell, filtered by depth", half, by_depth, {"filter.upsample", "filter.blur"}, out);
    append("cornell, bilinear", half, bilinear, {"filter.upsample"}, out);
    append("cornell, bilinear as printed", half, printed_picks, {"filter.upsample"}, out);

    // Every texel of a small map.
    for (Light& light : scene.lights) light.rsm_size = 16;
    scene.frame_size = {48, 40};
    settings.rsm.gather = rsm::Gather::all, settings.rsm.min_distance = 0.05f;
    append("small cornell", execute(scene, settings), settings, {"rsm.all"}, out);
}

// Soft shadows, and the blur of the maps that they read.
void append_soft_shadows(const std::filesystem::path& source, std::vector<Dispatch>& out) {
    using direct::ShadowMode, direct::ShadowVariant;
    Scene scene = io::load_scene((source / "data/scenes/cornell_small.toml").string(), frame::method_tables());
    scene.settings.clear();
    scene.lights = three_lights();
    scene.frame_size = {61, 47};
    frame::Settings settings;
    for (const auto& [name, mode] : {std::pair{"pcf", ShadowMode::pcf}, {"esm", ShadowMode::esm}}) {
        settings.shadow.mode = mode;
        const Lit lit = execute(scene, settings);
        append(std::string("cornell, ") + name, lit, settings, {"shadow", "shadow.blur"}, out);
        frame::Settings printed = settings;
        printed.shadow.variant = ShadowVariant::published;
        append(std::string("cornell, ") + name + " as printed", lit, printed, {"shadow"}, out);
        std::vector<Dispatch> tied;
        append(std::string("cornell with ties, ") + name, lit, settings, {"shadow"}, tied);
        for (Dispatch& d : tied)
            if (d.data.id.find(".bulb.") == std::string::npos) plant_ties(d.data), out.push_back(std::move(d));
    }
    const glm::ivec2 size(37, 23);
    for (StageData& data : test::compute_cases(size)) {
        const bool soft = data.id.starts_with("shadow.pcf") || data.id.starts_with("shadow.esm");
        if (soft || data.stage == "shadow.blur") out.push_back({"by hand: " + data.id, std::move(data)});
    }
}

// Image-space radiosity, on odd sides: with all that ISR's chapter 6 adds, as printed, and by inverse matrices.
void append_image_space(const std::filesystem::path& source, std::vector<Dispatch>& out) {
    Scene scene = io::load_scene((source / "data/scenes/cornell_small.toml").string(), frame::method_tables());
    scene.settings.clear();
    scene.lights = three_lights();
    scene.frame_size = {59, 45};
    frame::Settings settings;
    settings.method = frame::Method::isr;
    settings.isr.rings = 3, settings.isr.spacing = 2, settings.isr.k_ssao = 0.5f, settings.isr.blur_radius = 3;
    frame::Settings wide = settings, edges = settings, printed = settings, inverse = settings;
    wide.isr.bounces = 2, wide.isr.guard = 8, wide.isr.cameras = 1;
    edges.isr.blur = isr::Blur::edge_aware, edges.isr.rotations = 4;
    edges.isr.far_rings = 1, edges.isr.full_depth = 2, edges.isr.upsample = isr::Upsample::bilinear;
    printed.isr.variant = isr::Variant::published, printed.isr.guard = 4;
    inverse.isr.position = isr::Position::inverse_matrix;
    for (const auto& [name, of] : {std::pair{"wide", wide}, {"edges", edges}, {"as printed", printed}, {"inverse", inverse}}) {
        const Lit lit = execute(scene, of);
        append(std::string("cornell, isr ") + name, lit, of,
               {"isr.downsample", "isr.gather", "isr.bounce", "isr.unseen", "isr.gather_camera", "isr.ssao", "isr.blur",
                "isr.upsample", "isr.compose"}, out);
    }
    for (StageData& data : test::isr_cases({29, 22})) out.push_back({"by hand: " + data.id, std::move(data)});
}

// A number of any size up to 2^high, of both signs now and then, or 0.
float any_size(std::uint32_t i, int low, int high) {
    const std::uint32_t h = pcg<std::uint32_t>(i);
    if (h % 29 == 0) return 0;
    const std::uint32_t exponent = std::uint32_t(127 + low) + (h >> 3) % std::uint32_t(high - low);
    const float size = std::bit_cast<float>(exponent << 23 | h >> 9);
    return h % 23 == 0 ? -size : size;
}

Image4 any_image(glm::ivec2 size, std::uint32_t seed, int low, int high) {
    Image4 image(size.x, size.y);
    for (std::size_t i = 0; i < image.size(); ++i)
        for (int c = 0; c < 4; ++c) image.data()[i][c] = any_size(seed + std::uint32_t(4 * i) + std::uint32_t(c), low, high);
    return image;
}

void append_values(std::vector<Dispatch>& out) {
    const glm::ivec2 size(72, 64);
    const Image4 normal = any_image(size, 100000, -1, 1), albedo = any_image(size, 200000, -6, 0),
                 emission = any_image(size, 300000, -3, 4), direct = any_image(size, 400000, -12, 10),
                 indirect = any_image(size, 500000, -14, 8), radiance = any_image(size, 600000, -16, 8);
    const compose::ComposeInputs inputs{&normal, &albedo, &emission, &direct, &indirect, glm::vec3(0.3f, 0.5f, 0.9f)};
    auto keep = [&](const std::string& name, StageData data) {
        data.label = data.id = data.stage;
        out.push_back({name, owned(parity::find_binding(data.stage, name), data)});
    };
    for (const glm::vec3 shadow_color : {glm::vec3(0), glm::vec3(0.5f, 0.2f, 0.7f)}) {
        keep("values: compose", compose::data_of(compose::ComposeParams{shadow_color}, inputs));
    }
    const std::pair<const char*, compose::Operator> operators[] = {{"exposure", compose::Operator::exposure},
                                                                   {"clamp", compose::Operator::clamp},
                                                                   {"reinhard", compose::Operator::reinhard},
                                                                   {"filmic", compose::Operator::filmic}};
    for (const auto& [name, op] : operators) {
        keep(std::string("values: tonemap ") + name,
             compose::data_of(compose::TonemapParams{op, 0.7f}, compose::TonemapInputs{&radiance}));
    }
}

// Surfaces that fill an odd frame up to its borders, at two depths and turned two ways, with holes where nothing is seen
// but where some light lies.
void append_surfaces(std::vector<Dispatch>& out) {
    const glm::ivec2 size(37, 29);
    Image4 position(size.x, size.y), normal(size.x, size.y), irradiance(size.x, size.y);
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            const std::uint32_t h = pcg<std::uint32_t>(std::uint32_t(y * size.x + x));
            for (int c = 0; c < 3; ++c) irradiance(x, y)[c] = 0.5f + float(h >> (8 * c) & 0xff) / 256;
            if (h % 7 == 0) continue;  // nothing is seen
            const bool near = h % 5 < 2;
            const float depth = (near ? 1.0f : 4.0f) + 0.01f * float(x) + 0.02f * float(y);
            position(x, y) = glm::vec4(0.1f * float(x), 0.1f * float(y), -depth, depth);
            normal(x, y) = glm::vec4(near ? glm::vec3(0, 0, 1) : glm::vec3(0.6f, 0, 0.8f), 1);
            irradiance(x, y).w = depth;
        }
    auto keep = [&](const std::string& name, StageData data) {
        data.label = data.id = data.stage;
        out.push_back({"surfaces: " + name, owned(parity::find_binding(data.stage, name), data)});
    };
    keep("reduce", filter::data_of({}, filter::ReduceInputs{&irradiance}));
    filter::FilterParams params;
    params.kernel = 5;
    keep("blur", filter::data_of(params, filter::BlurInputs{&irradiance, &position, &normal}));
    Image4 coarse_irradiance, coarse_position, coarse_normal;
    filter::run(params, filter::ReduceInputs{&irradiance}, {}, coarse_irradiance);
    filter::run(params, filter::ReduceInputs{&position}, {}, coarse_position);
    filter::run(params, filter::ReduceInputs{&normal}, {}, coarse_normal);
    const filter::UpsampleInputs in{&coarse_irradiance, &coarse_position, &coarse_normal, &position, &normal};
    keep("upsample", filter::data_of(params, in));
    params.similarity = filter::Similarity::depth;
    keep("upsample by depth", filter::data_of(params, in));
}

}  // namespace

std::vector<Dispatch> dispatches(const std::filesystem::path& source) {
    std::vector<Dispatch> out;
    const Scene scene = panels();
    frame::Settings settings;
    settings.method = frame::Method::rsm, settings.rsm.samples = 8;
    append("panels", execute(scene, settings), settings, {"gbuffer", "rsm"}, out);
    append_cornell(source, out);
    append_soft_shadows(source, out);
    append_image_space(source, out);
    append_values(out);
    append_surfaces(out);
    return out;
}

}  // namespace plumb::mutants
