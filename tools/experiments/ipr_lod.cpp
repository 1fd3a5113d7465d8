// plumb experiment ipr: updates of the lightmap with levels of detail, and the pictures that they make.
#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/lend.h"
#include "tools/experiments/ipr_lod_world.h"
#include "tools/experiments/ipr_pictures.h"
#include "tools/experiments/ipr_truth.h"

namespace plumb::cli {

double lod_median_ms(const std::function<void()>& once, int times) {
    using Clock = std::chrono::steady_clock;
    std::vector<double> ms;
    for (int i = 0; i < std::max(times, 1); ++i) {
        const auto start = Clock::now();
        once();
        ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - start).count());
    }
    std::nth_element(ms.begin(), ms.begin() + std::ptrdiff_t(ms.size() / 2), ms.end());
    return ms[ms.size() / 2];
}

namespace {

// Beyond borders nothing: of all levels, or of those from row `first` on.
void without_borders(Image<std::int32_t>& cover, int first) {
    for (int y = first; y < cover.height; ++y)
        for (int x = 0; x < cover.width; ++x)
            if (cover(x, y) < 0) cover(x, y) = probes::cover_nothing;
}

}  // namespace

LodRun LodBench::World::run_of(const probes::LodParams& params, LodBorders borders) const {
    LodRun run;
    run.lod = probes::lod_of(params, bake);
    run.data = probes::run_data(bake, run.lod.levels);
    run.weights = probes::level_weights(bake.relight_directions, {run.lod.rays.begin(), run.lod.rays.begin() + run.lod.levels});
    if (borders != LodBorders::all) without_borders(run.data.cover, borders == LodBorders::none ? 0 : bake.atlas.size.y);
    run.place = hits.place;
    return run;
}

void LodBench::World::take_levels(LodRun& run, const Camera& camera) const {
    const CameraAxes view = axes(camera);
    run.levels = probes::levels_at(run.lod, bake, boxes, glm::vec3(camera.position), glm::vec3(view.forward), options,
                                   probes::air_reads(bake.spatial.grid, moving));
    for (std::size_t i = 0; i < run.levels.hit.size(); ++i) run.place.texels[i].z = float(run.levels.hit[i]);
    run.basis_level = probes::basis_levels(run.data, run.levels.cluster);
    run.tiles.wanted = probes::tiles_to_write(run.data.tiles, run.levels.cluster);
}

probes::UpdateBuffers LodBench::World::buffers(LodRun& run) const {
    probes::UpdateBuffers b;
    b.data = &run.data, b.harmonics = &bake.harmonics, b.weights = &run.weights;
    b.probe_level = &run.levels.probe, b.cluster_level = &run.levels.cluster;
    b.counts = {run.lod.levels, run.lod.rays, run.lod.coefficients};
    b.surface = &hits.surface, b.emitted = &hits.emitted, b.place = &run.place, b.direct = &direct;
    b.last_lightmap = &run.before, b.read_lambda = &run.lambda, b.read_basis = &run.basis;
    b.radiance = &run.radiance, b.lambda = &run.lambda, b.basis = &run.basis, b.irradiance = &run.irradiance, b.lightmap = &run.lightmap;
    b.basis_level = &run.basis_level, b.tiles = &run.tiles;
    return b;
}

LodStageMs LodBench::World::stage_ms(LodRun& run, const Camera& camera, int times) const {
    const probes::UpdateBuffers b = buffers(run);
    const auto of = [&](const auto& in, Image4& out) {
        return lod_median_ms([&] { plumb::run(stage<typename std::decay_t<decltype(in)>::Kernel>(), data_of(in), options, out); }, times);
    };
    LodStageMs ms;
    ms.levels = lod_median_ms([&] { take_levels(run, camera); }, times);
    ms.radiance = of(probes::radiance_inputs(b), *b.radiance), ms.lambda = of(probes::lambda_inputs(b), *b.lambda);
    ms.basis = of(probes::basis_inputs(b), *b.basis), ms.irradiance = of(probes::irradiance_inputs(b), *b.irradiance);
    ms.lightmap = lod_median_ms([&] { probes::write_lightmap(probes::lightmap_inputs(b), options, *b.tiles, *b.lightmap); }, times);
    return ms;
}

LodSeen LodBench::World::seen_by(const LodView& view) const {
    LodSeen s;
    const int width = view.size.x, height = view.size.y;
    s.position = s.normal = s.albedo = s.emitted = s.direct = Image4(width, height);
    const Buffer<glm::vec4> eye = {glm::vec4(glm::vec3(view.camera.position), 0)};
    Buffer<glm::vec4> rays;
    for (int y = 0; y < height; ++y) {
        Buffer<glm::vec4> row;
        for (int x = 0; x < width; ++x) row.push_back(glm::vec4(glm::vec3(ray_through_pixel(view.camera, view.size, {x, y}).direction), 0));
        const probes::LitHits lit_row = probes::lit_hits(*lit, eye, row, options);
        std::copy(lit_row.position.texels.begin(), lit_row.position.texels.end(), &s.position(0, y));
        std::copy(lit_row.normal.texels.begin(), lit_row.normal.texels.end(), &s.normal(0, y));
        std::copy(lit_row.albedo.texels.begin(), lit_row.albedo.texels.end(), &s.albedo(0, y));
        std::copy(lit_row.emitted.texels.begin(), lit_row.emitted.texels.end(), &s.emitted(0, y));
        std::copy(lit_row.direct.texels.begin(), lit_row.direct.texels.end(), &s.direct(0, y));
        rays.insert(rays.end(), row.begin(), row.end());
    }
    s.hits = probes::relight_rays(bake.atlas, raster::surface_args(lit->geometry, lit->surfaces, View{}), *lit->query, eye, rays, options);
    s.compared = Image<std::uint8_t>(width, height);
    for (std::size_t i = 0; i < s.compared.size(); ++i) s.compared.texels[i] = s.position.texels[i].w > 0 ? 1 : 0;
    if (view.samples > 0) {
        Image4 error;
        trace_points(scene, {&s.position, &s.normal}, view.samples, bake.params.rays, options, s.traced, error);
        s.truth = compare::luminances(s.traced), s.error = compare::luminance_errors(error);
    }
    return s;
}

const LodSeen& LodBench::World::look(const LodView& view) {
    const auto known = seen.find(view.name);
    return known != seen.end() ? known->second : seen.emplace(view.name, seen_by(view)).first->second;
}

// Of pixels, blended between levels as probes.lookup has it. W/m2.
Image4 LodBench::World::indirect(const LodRun& run, const LodSeen& seen, const Camera& camera, glm::ivec2 size) const {
    Image4 image(size.x, size.y);
    const probes::LevelRule rule = probes::fragment_rule_at(run.lod, glm::vec3(camera.position), glm::vec3(axes(camera).forward));
    const probes::LightmapArgs map{&run.lightmap.texels[0].x, run.data.lightmap_size.x, run.lod.levels};
    NoTap quiet;
    for (std::size_t i = 0; i < image.size(); ++i) {
        if (seen.hits.material[i] < 0) continue;
        const probes::PointLevel l = run.lod.off() ? probes::PointLevel{} : probes::level_at(rule, glm::vec3(seen.hits.position[i]));
        const vec2<float> uv{seen.hits.uv[i].x, seen.hits.uv[i].y};
        glm::vec3 value = probes::lightmap_at<float>(map, uv, l.level, quiet);
        if (l.share > 0) value = probes::mixed<float>(value, probes::lightmap_at<float>(map, uv, l.level + 1, quiet), l.share);
        image.texels[i] = glm::vec4(value, 1);
    }
    return image;
}

LodBench::LodBench(const Scene& scene, const probes::Bake& bake, const RunOptions& options)
    : world_(std::make_unique<World>(scene, bake, options)) {
    World& w = *world_;
    w.lit = probes::lit_scene(w.scene, bake.params.rays);
    if (w.lit->geometry.triangles.size() != bake.atlas.geometry.triangles.size())
        throw InputError("level of detail: the scene's static meshes have other triangles than the bake");
    w.hits = probes::hit_surfaces(w.scene, bake, options);
    w.direct = probes::lamp_irradiance(*w.lit, w.hits.position, w.hits.normal, options);
    w.boxes = probes::lod_boxes(bake);
    if (!bake.spatial.empty()) w.take_moving(scene);
}
LodBench::~LodBench() = default;

namespace {

Image4 lit_picture(const LodSeen& seen, const Image4& indirect) {
    Image4 picture(indirect.width, indirect.height);
    for (std::size_t i = 0; i < picture.size(); ++i)
        for (int c = 0; c < 3; ++c)
            picture.texels[i][c] = seen.emitted.texels[i][c] +
                                   seen.albedo.texels[i][c] * float(1 / host::pi) * (seen.direct.texels[i][c] + indirect.texels[i][c]);
    return picture;
}

constexpr int block = 64;  // pixels a side, for the worst of an error

void add_errors(const Image4& indirect, const Image4& reference, LodMeasured& m) {
    double sum = 0, difference = 0;
    std::vector<double> blocks(std::size_t((indirect.width + block - 1) / block) * std::size_t((indirect.height + block - 1) / block), 0.0);
    for (int y = 0; y < indirect.height; ++y)
        for (int x = 0; x < indirect.width; ++x)
            for (int c = 0; c < 3; ++c) {
                const double d = std::fabs(double(indirect(x, y)[c]) - double(reference(x, y)[c]));
                sum += double(reference(x, y)[c]), difference += d;
                blocks[std::size_t(y / block) * std::size_t((indirect.width + block - 1) / block) + std::size_t(x / block)] += d;
            }
    if (!(sum > 0)) throw InputError("level of detail: no indirect light is in view");
    const double mean = sum / (3 * double(indirect.size()));
    m.error = difference / sum;
    m.worst = *std::max_element(blocks.begin(), blocks.end()) / (3 * block * block) / mean;
}

constexpr glm::vec3 level_colours[probes::most_levels] = {{1, 0.15f, 0.15f}, {0.2f, 1, 0.2f}, {0.25f, 0.35f, 1}, {1, 1, 0.15f}};  // figure 5.29

// The picture in the colours of its levels.
Image4 level_picture(const LodRun& run, const LodSeen& seen, const Camera& camera, const Image4& picture) {
    const probes::LevelRule rule = probes::fragment_rule_at(run.lod, glm::vec3(camera.position), glm::vec3(axes(camera).forward));
    Image4 coloured(picture.width, picture.height);
    for (std::size_t i = 0; i < picture.size(); ++i) {
        if (seen.hits.material[i] < 0) continue;
        const probes::PointLevel l = run.lod.off() ? probes::PointLevel{} : probes::level_at(rule, glm::vec3(seen.hits.position[i]));
        const int next = std::min(l.level + 1, probes::most_levels - 1);
        const glm::vec3 colour = glm::mix(level_colours[l.level], level_colours[next], l.share);
        coloured.texels[i] = glm::vec4(float(0.25 + 0.75 * lod_luminance(picture.texels[i])) * colour, 1);
    }
    return coloured;
}

// Of the indirect light of pixels, and of the receivers that are computed.
void add_truth(const LodRun& run, const LodSeen& seen, const Image4& indirect, const LodView& view, LodMeasured& m) {
    if (!seen.truth.empty()) {
        const compare::Plane own = compare::luminances(indirect);
        m.at_pixels = ipr_errors(own, seen.truth, seen.error, seen.compared);
        m.error_picture = error_picture(own, seen.truth, seen.error, seen.compared, 0.1 * m.at_pixels->truth);
    }
    if (!view.receivers) return;
    std::vector<double> own, truth, error;
    for (std::size_t i = 0; i < view.receivers->index.size(); ++i) {
        const glm::vec4& light = run.irradiance.texels[std::size_t(run.data.place_of[std::size_t(view.receivers->index[i])])];
        if (!(light.w > 0)) continue;
        own.push_back(lod_luminance(light)), truth.push_back(view.receivers->mean.texels[i]), error.push_back(view.receivers->error.texels[i]);
    }
    if (own.empty()) return;
    const auto plane = [](const std::vector<double>& values) {
        compare::Plane p(int(values.size()), 1);
        std::copy(values.begin(), values.end(), p.texels.begin());
        return p;
    };
    m.at_receivers = ipr_errors(plane(own), plane(truth), plane(error));
}

}  // namespace

std::vector<LodMeasured> LodBench::measure(const LodView& view, const std::vector<LodSetup>& setups, int updates, const std::string& reference) const {
    World& w = *world_;
    std::vector<LodSetup> all = {lod_setup("NO LOD")};
    for (const LodSetup& s : setups)
        if (s.name != all[0].name) all.push_back(s);
    const LodSeen& seen = w.look(view);
    std::vector<LodMeasured> measured;
    Image4 reference_indirect, reference_air;
    double white = 1;
    for (const LodSetup& s : all) {
        LodRun run = w.run_of(s.params, s.borders);
        w.take_levels(run, view.camera);
        Image4 before;
        probes::converge(w.buffers(run), probes::RunParams{}, w.options, before);
        run.before = std::move(before);
        LodMeasured m;
        m.setup = s.name, m.notes = run.lod.notes;
        m.counts = probes::lod_counts(run.lod, w.bake, run.levels), m.receivers = m.counts.receivers;
        m.ms = lod_median_ms([&] {
            w.take_levels(run, view.camera);
            probes::update(w.buffers(run), w.options);
        }, updates);
        m.stages = w.stage_ms(run, view.camera, updates);
        Image4 in_air;
        if (!w.moving.empty()) m.air = w.in_the_air(run, updates, in_air, reference_air);
        if (measured.empty()) reference_air = in_air;
        const Image4 indirect = w.indirect(run, seen, view.camera, view.size), picture = lit_picture(seen, indirect);
        if (measured.empty()) reference_indirect = indirect, white = white_of(picture);
        m.picture = displayed(picture, white);
        m.speed_up = measured.empty() ? 1 : measured[0].ms / m.ms;
        add_errors(indirect, reference_indirect, m);
        add_truth(run, seen, indirect, view, m);
        if (!seen.traced.empty()) m.ssim_truth = ssim_of(m.picture, displayed(lit_picture(seen, seen.traced), white));
        if (view.levels) m.levels = level_picture(run, seen, view.camera, m.picture), m.lightmap = smaller(displayed(run.lightmap, white), 512);
        measured.push_back(std::move(m));
    }
    const auto beside = std::find_if(measured.begin(), measured.end(), [&](const LodMeasured& m) { return m.setup == reference; });
    if (beside == measured.end()) throw InputError("level of detail: no setup \"" + reference + "\" to be the reference");
    const Image4 picture = beside->picture;
    for (LodMeasured& m : measured) m.ssim = ssim_of(m.picture, picture), m.ssim_picture = ssim_map(m.picture, picture);
    return measured;
}

}  // namespace plumb::cli
