// plumb experiment ipr: updates of the lightmap with levels of detail, and the pictures that they make.
#include "tools/experiments/ipr_lod.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/probes/bake.h"
#include "gi/probes/hit_surfaces.h"
#include "gi/probes/lit_hits.h"

namespace plumb::cli {

namespace {

using Clock = std::chrono::steady_clock;

double luminance(const glm::vec4& v) { return 0.2126 * double(v.x) + 0.7152 * double(v.y) + 0.0722 * double(v.z); }

// What pixels see: where on the lightmap, and what else lights them.
struct Seen {
    probes::RelightHits hits;       // one probe: the eye; a ray a pixel
    Image4 albedo, emitted, direct;
};

// One update's inputs and outputs by one setup.
struct Run {
    probes::Lod lod;
    probes::RunData data;
    Buffer<float> weights;
    probes::Levels levels;
    Image4 place, before, radiance, lambda, basis, irradiance, lightmap;
};

}  // namespace

struct LodBench::World {
    World(const Scene& s, const probes::Bake& b, const RunOptions& o) : scene(s), bake(b), options(o) {}

    const Scene& scene;
    const probes::Bake& bake;
    const RunOptions& options;
    std::unique_ptr<probes::LitScene> lit;
    probes::HitSurfaces hits;
    Image4 direct;
    probes::LodBoxes boxes;

    Run run_of(const probes::LodParams& params) const;
    void take_levels(Run& run, const Camera& camera) const;
    probes::UpdateBuffers buffers(Run& run) const;
    Seen seen_by(const LodView& view) const;
    Image4 indirect(const Run& run, const Seen& seen, const Camera& camera, glm::ivec2 size) const;
};

Run LodBench::World::run_of(const probes::LodParams& params) const {
    Run run;
    run.lod = probes::lod_of(params, bake);
    run.data = probes::run_data(bake, run.lod.levels);
    run.weights = probes::level_weights(bake.relight_directions, {run.lod.rays.begin(), run.lod.rays.begin() + run.lod.levels});
    run.place = hits.place;
    return run;
}

void LodBench::World::take_levels(Run& run, const Camera& camera) const {
    const CameraAxes view = axes(camera);
    run.levels = probes::levels_at(run.lod, bake, boxes, glm::vec3(camera.position), glm::vec3(view.forward), options);
    for (std::size_t i = 0; i < run.levels.hit.size(); ++i) run.place.texels[i].z = float(run.levels.hit[i]);
}

probes::UpdateBuffers LodBench::World::buffers(Run& run) const {
    probes::UpdateBuffers b;
    b.data = &run.data, b.harmonics = &bake.harmonics, b.weights = &run.weights;
    b.probe_level = &run.levels.probe, b.cluster_level = &run.levels.cluster;
    b.counts = {run.lod.levels, run.lod.rays, run.lod.coefficients};
    b.surface = &hits.surface, b.emitted = &hits.emitted, b.place = &run.place, b.direct = &direct;
    b.last_lightmap = &run.before, b.read_lambda = &run.lambda, b.read_basis = &run.basis;
    b.radiance = &run.radiance, b.lambda = &run.lambda, b.basis = &run.basis, b.irradiance = &run.irradiance, b.lightmap = &run.lightmap;
    return b;
}

Seen LodBench::World::seen_by(const LodView& view) const {
    Seen s;
    const int width = view.size.x, height = view.size.y;
    s.albedo = s.emitted = s.direct = Image4(width, height);
    const Buffer<glm::vec4> eye = {glm::vec4(glm::vec3(view.camera.position), 0)};
    Buffer<glm::vec4> rays;
    for (int y = 0; y < height; ++y) {
        Buffer<glm::vec4> row;
        for (int x = 0; x < width; ++x) row.push_back(glm::vec4(glm::vec3(ray_through_pixel(view.camera, view.size, {x, y}).direction), 0));
        const probes::LitHits lit_row = probes::lit_hits(*lit, eye, row, options);
        std::copy(lit_row.albedo.texels.begin(), lit_row.albedo.texels.end(), &s.albedo(0, y));
        std::copy(lit_row.emitted.texels.begin(), lit_row.emitted.texels.end(), &s.emitted(0, y));
        std::copy(lit_row.direct.texels.begin(), lit_row.direct.texels.end(), &s.direct(0, y));
        rays.insert(rays.end(), row.begin(), row.end());
    }
    s.hits = probes::relight_rays(bake.atlas, raster::surface_args(lit->geometry, lit->surfaces, View{}), *lit->query, eye, rays, options);
    return s;
}

// Of pixels, blended between levels as probes.lookup has it. W/m2.
Image4 LodBench::World::indirect(const Run& run, const Seen& seen, const Camera& camera, glm::ivec2 size) const {
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
    w.lit = probes::lit_scene(scene, bake.params.rays);
    if (w.lit->geometry.triangles.size() != bake.atlas.geometry.triangles.size())
        throw InputError("level of detail: the scene has other triangles than the bake: dynamic objects are not asked here");
    w.hits = probes::hit_surfaces(scene, bake, options);
    w.direct = probes::lamp_irradiance(*w.lit, w.hits.position, w.hits.normal, options);
    w.boxes = probes::lod_boxes(bake);
}
LodBench::~LodBench() = default;

namespace {

// White: the value that one pixel of fifty exceeds; sRGB's exponent.
Image4 displayed(const Image4& radiance, double white) {
    Image4 shown(radiance.width, radiance.height);
    for (std::size_t i = 0; i < shown.size(); ++i)
        for (int c = 0; c < 3; ++c)
            shown.texels[i][c] = float(host::pow(std::clamp(double(radiance.texels[i][c]) / white, 0.0, 1.0), 1 / 2.2));
    return shown;
}

double white_of(const Image4& radiance) {
    std::vector<double> values;
    for (const glm::vec4& v : radiance.texels) values.push_back(luminance(v));
    const auto at = values.begin() + std::ptrdiff_t(values.size() - 1 - values.size() / 50);
    std::nth_element(values.begin(), at, values.end());
    return std::max(*at, 1e-30);
}

Image4 lit_picture(const Seen& seen, const Image4& indirect) {
    Image4 picture(indirect.width, indirect.height);
    for (std::size_t i = 0; i < picture.size(); ++i)
        for (int c = 0; c < 3; ++c)
            picture.texels[i][c] = seen.emitted.texels[i][c] +
                                   seen.albedo.texels[i][c] * float(1 / host::pi) * (seen.direct.texels[i][c] + indirect.texels[i][c]);
    return picture;
}

compare::Picture picture_of(const Image4& image) {
    compare::Picture p{{"R", "G", "B"}, image.width, image.height, {}};
    for (const glm::vec4& v : image.texels) p.data.insert(p.data.end(), {v.x, v.y, v.z});
    return p;
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

double median_ms(const std::function<void()>& once, int times) {
    std::vector<double> ms;
    for (int i = 0; i < std::max(times, 1); ++i) {
        const auto start = Clock::now();
        once();
        ms.push_back(std::chrono::duration<double, std::milli>(Clock::now() - start).count());
    }
    std::nth_element(ms.begin(), ms.begin() + std::ptrdiff_t(ms.size() / 2), ms.end());
    return ms[ms.size() / 2];
}

}  // namespace

std::vector<LodMeasured> LodBench::measure(const LodView& view, const std::vector<LodSetup>& setups, int updates) const {
    const World& w = *world_;
    std::vector<LodSetup> all = {lod_setup("NO LOD")};
    for (const LodSetup& s : setups)
        if (s.name != all[0].name) all.push_back(s);
    const Seen seen = w.seen_by(view);
    std::vector<LodMeasured> measured;
    Image4 reference_indirect;
    double white = 1;
    for (const LodSetup& s : all) {
        Run run = w.run_of(s.params);
        w.take_levels(run, view.camera);
        Image4 before;
        probes::converge(w.buffers(run), probes::RunParams{}, w.options, before);
        run.before = std::move(before);
        LodMeasured m;
        m.setup = s.name, m.notes = run.lod.notes;
        m.counts = probes::lod_counts(run.lod, w.bake, run.levels), m.receivers = m.counts.receivers;
        m.ms = median_ms([&] {
            w.take_levels(run, view.camera);
            probes::update(w.buffers(run), w.options);
        }, updates);
        const Image4 indirect = w.indirect(run, seen, view.camera, view.size), picture = lit_picture(seen, indirect);
        if (measured.empty()) reference_indirect = indirect, white = white_of(picture);
        m.picture = displayed(picture, white);
        m.speed_up = measured.empty() ? 1 : measured[0].ms / m.ms;
        compare::Options how;
        how.encoding = compare::Encoding::ldr_srgb;
        m.ssim = compare::compare(picture_of(m.picture), picture_of(measured.empty() ? m.picture : measured[0].picture), how).ssim;
        add_errors(indirect, reference_indirect, m);
        measured.push_back(std::move(m));
    }
    return measured;
}

// ---- Seams --------------------------------------------------------------------------------------------------------------

bool LodSeam::visible() const { return seen > visible_step; }

namespace {

// What a share `visible_length` of the values exceeds.
double exceeded(std::vector<double> values) {
    const auto at = values.begin() + std::ptrdiff_t(double(values.size()) * (1 - visible_length));
    std::nth_element(values.begin(), at, values.end());
    return *at;
}

// The largest relative change of each place's irradiance to a texel beside it; of one that has none 0.
std::vector<double> own_changes(const probes::RunData& data, const std::vector<double>& light) {
    std::vector<double> changes(light.size(), 0.0);
    const Image<std::int32_t>& cover = data.cover;
    for (int y = 0; y < cover.height; ++y)
        for (int x = 0; x < cover.width; ++x) {
            if (cover(x, y) < 0) continue;
            const std::size_t a = std::size_t(cover(x, y));
            for (const glm::ivec2& step : probes::border_steps) {
                const int bx = x + step.x, by = y + step.y;
                if (bx < 0 || by < 0 || bx >= cover.width || by >= cover.height || cover(bx, by) < 0 || !(light[a] > 0)) continue;
                changes[a] = std::max(changes[a], std::fabs(light[std::size_t(cover(bx, by))] - light[a]) / light[a]);
            }
        }
    return changes;
}

LodSeam seam_of(int near, int far, const std::vector<double>& a, const std::vector<double>& b, const std::vector<double>& own, double least) {
    LodSeam s{near, far};
    std::vector<double> steps, seen, texels;
    for (std::size_t i = 0; i < a.size(); ++i) {
        if (!(a[i] > least)) continue;
        const double step = std::fabs(b[i] - a[i]) / a[i];
        s.mean += step;
        steps.push_back(step), seen.push_back(step > own[i] ? step : 0);
        texels.push_back(step / std::max(own[i], visible_step));
    }
    if (steps.empty()) throw InputError("level of detail: no receiver is lit");
    s.mean /= double(steps.size());
    s.tenth = exceeded(std::move(steps)), s.seen = exceeded(std::move(seen)), s.texels = exceeded(std::move(texels));
    return s;
}

}  // namespace

LodSeams largest_gaps(std::vector<LodSeam> pairs) {
    if (pairs.empty()) throw InputError("level of detail: no pairs of degrees");
    LodSeams seams;
    int top = 0;
    for (const LodSeam& p : pairs) top = std::max(top, p.near);
    const auto largest = [&](auto counts) {
        for (int gap = 1; gap <= top; ++gap)
            if (std::any_of(pairs.begin(), pairs.end(), [&](const LodSeam& p) { return p.gap() == gap && counts(p) && p.visible(); })) return gap - 1;
        return top;
    };
    seams.largest_gap = largest([](const LodSeam&) { return true; });
    seams.largest_gap_from_top = largest([&](const LodSeam& p) { return p.near == top; });
    seams.pairs = std::move(pairs);
    return seams;
}

LodSeams LodBench::seams() const {
    const World& w = *world_;
    Run run = w.run_of({});
    w.take_levels(run, Camera{});
    Image4 before;
    probes::converge(w.buffers(run), probes::RunParams{}, w.options, before);
    run.before = before;
    // Levels of one light that differ in degree alone: the same radiance for all.
    const int top = w.bake.params.degree;
    std::vector<std::vector<double>> light;
    std::vector<std::vector<double>> own;
    double mean = 0;
    for (int degree = 0; degree <= top; ++degree) {
        run.lod.coefficients.fill((degree + 1) * (degree + 1));
        probes::update(w.buffers(run), w.options);
        std::vector<double> l;
        for (int i = 0; i < run.data.count(); ++i) l.push_back(luminance(run.irradiance.texels[std::size_t(i)]));
        own.push_back(own_changes(run.data, l));
        light.push_back(std::move(l));
    }
    for (const double l : light.back()) mean += l / double(light.back().size());
    std::vector<LodSeam> pairs;
    for (int near = top; near >= 0; --near)
        for (int far = near; far >= 0; --far)
            pairs.push_back(seam_of(near, far, light[std::size_t(near)], light[std::size_t(far)], own[std::size_t(near)], 0.05 * mean));
    return largest_gaps(std::move(pairs));
}

}  // namespace plumb::cli
