#include "gi/reference/reference.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>

#include "core/error.h"
#include "core/fp_environment.h"
#include "core/host_math.h"
#include "core/parallel.h"
#include "gi/reference/lobes.h"
#include "gi/reference/microfacet_tables.h"
#include "gi/reference/path_args.h"
#include "gi/reference/path_rows.h"
#include "gi/reference/ray_query.h"
#include "raster/bindings.h"

namespace plumb::reference {

namespace {

constexpr int band = 8;             // rows a task
constexpr int samples_of_until = 16;  // a round, where the number of rounds is open
constexpr int rounds_between_looks = 8;
constexpr int without_end = 1 << 24;

// How a number of samples is spent: rounds of a power of two, for that is where the points lie most evenly.
struct Schedule {
    int samples, rounds;  // of a round; in all
};
Schedule schedule_of(const PathParams& params) {
    if (params.until_error > 0)
        return {samples_of_until, std::max(params.max_samples / samples_of_until, rounds_between_looks)};
    int samples = 1;
    while (std::int64_t(samples) * 2 * params.rounds <= params.samples) samples *= 2;
    return {samples, std::max((params.samples + samples - 1) / samples, 2)};
}

// Sums over rounds, in double.
struct Moments {
    std::vector<glm::dvec3> mean, squares;  // of the rounds' means; sum of squared distances from their mean
    int rounds = 0;

    explicit Moments(std::size_t pixels) : mean(pixels, glm::dvec3(0)), squares(pixels, glm::dvec3(0)) {}

    // Welford 1962.
    void add(const Image4& sum, double scale, const RunOptions& options) {
        ++rounds;
        RunOptions quiet = options;
        quiet.progress = {};
        parallel_bands(sum.height, 16, quiet, [&](int first, int last) {
            for (std::size_t i = std::size_t(first) * sum.width; i < std::size_t(last) * sum.width; ++i) {
                const glm::dvec3 value = glm::dvec3(sum.texels[i]) * scale, step = value - mean[i];
                mean[i] += step / double(rounds);
                squares[i] += step * (value - mean[i]);
            }
        });
    }

    // The variance of the mean of a channel.
    double variance(std::size_t i, int c) const { return squares[i][c] / (double(rounds) * (rounds - 1)); }

    bool any_light() const {
        return std::any_of(mean.begin(), mean.end(), [](const glm::dvec3& m) { return m != glm::dvec3(0); });
    }

    // Root of the mean variance over the mean. In the order of the pixels.
    double relative_error() const {
        double variances = 0, total = 0;
        for (std::size_t i = 0; i < mean.size(); ++i)
            for (int c = 0; c < 3; ++c) variances += variance(i, c), total += mean[i][c];
        const double n = 3.0 * double(mean.size());
        return variances == 0 ? 0 : std::sqrt(variances / n) / std::abs(total / n);
    }
};

LightArgs light_args(const LightTable& t) {
    LightArgs a{t.count, 0, t.rows.data(), t.cdf.data(), t.triangle_pdf.data(), t.environment_probability, t.any_radius};
    while ((std::int64_t(1) << a.steps) < t.count) ++a.steps;
    return a;
}

// The arguments that all rounds share.
PathArgs args_of(const PathParams& params, const PathScene& scene, int width, std::uint32_t seed) {
    PathArgs a{};
    a.surfaces = raster::surface_args(scene.geometry, scene.surfaces, View{});
    a.lights = light_args(scene.lights);
    a.environment = environment_args(scene.environment);
    a.mirrors = {scene.lights.lamps > 0 ? scene.mirrors.count : 0, scene.lights.lamps, scene.mirrors.planes.data(),
                 scene.mirrors.plane.data()};
    a.reflection = scene.reflection.data();
    a.glossy = scene.any_glossy;
    a.faceted = scene.any_microfacets;
    if (scene.any_microfacets) {
        const MicrofacetTables& tables = microfacet_tables();
        a.microfacets = {scene.microfacets.data(), tables.cells.data(), tables.rows.data(),
                         params.microfacets == Microfacets::multiple};
    }
    a.emitters = scene.lights.any_triangle;
    a.width = width;
    a.seed = seed;
    a.inverse_roulette = 1 / params.roulette;
    a.openness = params.mode == Mode::ambient_occlusion;
    a.ao_distance = params.ao_distance > 0 ? params.ao_distance : std::numeric_limits<float>::infinity();
    a.jitter = params.filter == Filter::box;
    a.first_bounce = params.mode == Mode::one_bounce || params.mode == Mode::indirect ? 1 : 0;
    a.last_bounce = params.mode == Mode::direct ? 0 : params.mode == Mode::one_bounce ? 1 : without_end;
    if (params.max_bounces > 0) a.last_bounce = std::min(a.last_bounce, params.max_bounces);
    // Only where paths can run into light is the last surface's ray worth tracing.
    a.last_depth = a.last_bounce + (a.emitters || scene.environment.width > 0 ? 1 : 0);
    return a;
}

Estimate run_rounds(const PathParams& params, const PathScene& scene, PathArgs args, glm::ivec2 size, double scale,
                    const RunOptions& options) {
    const Schedule schedule = schedule_of(params);
    args.samples = schedule.samples;
    Image4 sum(size.x, size.y);
    args.sum = &sum.data()->x;
    Moments moments(sum.size());
    Estimate e;
    std::atomic<std::uint64_t> rays{0};
    const int least = params.until_error > 0 ? rounds_between_looks : schedule.rounds;
    double first_error = 0;
    for (int round = 0; round < schedule.rounds; ++round) {
        args.round = round;
        RunOptions part = options;
        if (options.progress)
            part.progress = [&, round](double done) {
                // Noise falls with the root of the rounds: so many will be needed.
                double expected = schedule.rounds;
                if (params.until_error > 0 && first_error > 0) {
                    const double ratio = first_error / params.until_error;
                    expected = std::clamp(ratio * ratio * least, double(round + 1), double(schedule.rounds));
                }
                options.progress(std::min((round + done) / expected, 1.0));
            };
        dispatch(options.isa, [&](auto isa) {
            parallel_bands(size.y, band, part, [&](int first, int last) {
                PathArgs rows = args;
                rows.first_row = first;
                rays += PathRows<isa()>::trace(rows, *scene.rays, last);
            });
        });
        moments.add(sum, scale / schedule.samples, options);
        if (params.until_error <= 0 || moments.rounds % rounds_between_looks != 0) continue;
        const double error = moments.relative_error();
        if (first_error == 0) first_error = error;
        // A black picture says nothing about what its lights would bring.
        if (error <= params.until_error && (moments.any_light() || args.lights.count == 0)) break;
    }

    // Results.
    e.mean = e.error = Image4(size.x, size.y);
    for (std::size_t i = 0; i < sum.size(); ++i)
        for (int c = 0; c < 3; ++c) {
            const double mean = moments.mean[i][c], variance = moments.variance(i, c);
            e.mean.texels[i][c] = float(mean);
            e.error.texels[i][c] = float(std::sqrt(variance));
            // As they are stored: what a double holds may be too large for a float.
            if (!std::isfinite(e.mean.texels[i][c]) || !std::isfinite(e.error.texels[i][c])) ++e.nonfinite;
        }
    e.rounds = moments.rounds;
    e.samples = moments.rounds * schedule.samples;
    e.rays = rays;
    e.relative_error = moments.relative_error();
    return e;
}

void validate(const PathParams& params, glm::ivec2 size) {
    PathParams copy = params;
    validate_fields("reference", fields(copy));
    if (size.x < 1 || size.y < 1 || size.x > 32768 || std::int64_t(size.x) * size.y >= (std::int64_t(1) << 31) - 64)
        throw InputError(fmt::format("reference: {} x {} pixels: expected 1 to 32768 a row, and fewer than 2^31 in all",
                                     size.x, size.y));
}

}  // namespace

std::vector<Field> fields(PathParams& p) {
    return {
        {"mode", as_int(p.mode), "",
         "light reflected any number of times before it reaches the surface that is seen, never, once, or once and "
         "more; or the open share of the hemisphere",
         0, 4, {"all", "direct", "one_bounce", "indirect", "ambient_occlusion"}, false},
        {"samples", &p.samples, "", "paths a pixel, rounded up to whole rounds", 1, 1 << 24, {}, false,
         {SweepRange::Role::along, {4, 8, 16, 32, 64}, "until_error", "0"}},
        {"rounds", &p.rounds, "",
         "independent estimates that the samples are divided into, at least, if there are so many: fewer lie more "
         "evenly, but tell less of their error",
         2, 1 << 16, {}, false},
        {"until_error", &p.until_error, "",
         "above 0: goes on until the standard error, relative to the picture's mean, is at most this", 0, 1, {}, false},
        {"max_samples", &p.max_samples, "", "where until_error gives up; it looks after every 128", 128, 1 << 24, {},
         false},
        {"max_bounces", &p.max_bounces, "", "reflections of a path; 0: no limit but Russian roulette", 0, 1 << 20, {},
         false},
        {"roulette", &p.roulette, "",
         "throughput below which Russian roulette may end a path; lower: fewer, longer paths to the same error where "
         "almost all light is reflected",
         1e-6, 1, {}, false},
        {"rays", as_int(p.rays), "", "exact: the same bits everywhere; native: Embree's own test, faster", 0, 1,
         {"exact", "native"}, false},
        {"filter", as_int(p.filter), "",
         "camera rays start at the pixel's centre, as samples of the rasterizer, or anywhere in it", 0, 1,
         {"centre", "box"}, false},
        {"ao_distance", &p.ao_distance, "m", "what is farther does not occlude; 0: no limit", 0, unbounded, {}, false},
        {"microfacets", as_int(p.microfacets), "",
         "light that meets several facets of a rough surface counts; or is lost, as glTF's appendix B has it", 0, 1,
         {"multiple", "single"}, false},
    };
}

namespace {

bool finite(const glm::vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }
bool not_negative(const glm::vec3& v) { return v.x >= 0 && v.y >= 0 && v.z >= 0; }

// A light that is no number would not be chosen, and so be hidden; a surface that reflects more than it receives would
// never end.
void check(const Scene& scene) {
    auto refuse = [&](const std::string& what, const std::string& name, const std::string& cause) {
        throw InputError(fmt::format("{}: {} \"{}\": {}", scene.name, what, name, cause));
    };
    for (const Light& l : scene.lights)
        if (!finite(l.position) || !finite(l.direction) || !finite(l.intensity) || !not_negative(l.intensity))
            refuse("light", l.name, "position, direction, intensity: expected finite numbers, intensity not negative");
    for (const Material& m : scene.materials) {
        for (const glm::vec3& part : {m.reflectance, m.specular, m.mirror, m.emission})
            if (!finite(part) || !not_negative(part))
                refuse("material", m.name, "reflectance, specular, mirror and emission: expected finite numbers >= 0");
        if (!(m.exponent >= 0 && m.exponent <= 1e6f))
            refuse("material", m.name, fmt::format("exponent = {}: expected 0 to 1e6", m.exponent));
        for (const auto& [name, value] : {std::pair{"metalness", m.metalness}, {"roughness", m.roughness}})
            if (!(value >= 0 && value <= 1)) refuse("material", m.name, fmt::format("{} = {}: expected 0 to 1", name, value));
        if (m.microfacet && (m.specular != glm::vec3(0) || m.mirror != glm::vec3(0)))
            refuse("material", m.name, "specular or mirror beside microfacets: expected one or the other");
        for (int c = 0; c < 3; ++c) {
            const double sum = double(m.reflectance[c]) + m.specular[c] + m.mirror[c];
            if (!(sum <= 1 + 1e-6))
                refuse("material", m.name,
                       fmt::format("reflectance + specular + mirror = {:.6g} in channel {}: expected at most 1", sum,
                                   "RGB"[c]));
        }
    }
}

// Where the scene's origin is to be. Along an axis on which all of it lies farther from the world's origin than eight
// times its size, coordinates are within a factor of two of each other: differences of theirs are exact (Sterbenz).
glm::vec3 anchor_of(const Geometry& geometry) {
    glm::vec3 low(0), high(0), anchor(0);
    bounds(geometry, low, high);
    const glm::dvec3 sides = glm::dvec3(high) - glm::dvec3(low);
    const double size = std::max({sides.x, sides.y, sides.z});
    for (int c = 0; c < 3; ++c) {
        const double nearest = low[c] > 0 ? low[c] : high[c] < 0 ? -double(high[c]) : 0;
        if (nearest > 8 * size) anchor[c] = low[c];
    }
    return anchor;
}

// The lamps of a scene that begins at an anchor.
Scene with_lights_at(Scene scene, const glm::vec3& anchor) {
    for (Light& l : scene.lights) l.position = glm::vec3(glm::dvec3(l.position) - glm::dvec3(anchor));
    return scene;
}

// The row of the texture of roughness and metalness, as a kernel reads it from a record of floats.
float surface_row(const Material& m, const raster::Surfaces& surfaces) {
    const int texture = m.surface_texture;
    if (texture < -1 || texture >= int(surfaces.texture_rows.size()))
        throw InputError(fmt::format("material \"{}\": surface_texture = {}: the scene has {}", m.name, texture,
                                     surfaces.texture_rows.size()));
    return m.microfacet && texture >= 0 ? float(surfaces.texture_rows[std::size_t(texture)]) : 0.0f;
}

// Lanes whose ray meets nothing read triangle 0: where there is none, one without area stands in.
Scene with_a_triangle(Scene scene) {
    Mesh dot;
    dot.vertices.resize(1);
    dot.triangles = {{0, 0, 0}};
    dot.material = {0};
    scene.meshes = {dot};
    if (scene.materials.empty()) scene.materials.emplace_back();
    return scene;
}

}  // namespace

std::unique_ptr<PathScene> prepare(const Scene& scene, Rays rays) {
    FpEnvironment environment;
    check(scene);
    Geometry geometry = flatten(scene);
    if (geometry.triangles.empty()) return prepare(with_a_triangle(scene), rays);
    auto s = std::make_unique<PathScene>();
    s->anchor = anchor_of(geometry);
    for (Vertex& v : geometry.vertices) v.position -= s->anchor;
    for (const Material& m : scene.materials) {
        s->any_glossy = s->any_glossy || m.specular != glm::vec3(0) || m.mirror != glm::vec3(0);
        s->reflection.insert(s->reflection.end(), {m.specular.x, m.specular.y, m.specular.z, m.exponent,  //
                                                   m.mirror.x, m.mirror.y, m.mirror.z, 0});
    }
    s->geometry = std::move(geometry);
    s->surfaces = raster::prepare(scene, s->geometry);
    s->mirrors = mirror_table(scene, s->geometry);
    for (const Material& m : scene.materials) {
        s->any_microfacets = s->any_microfacets || m.microfacet;
        s->microfacets.insert(s->microfacets.end(), {m.metalness, m.roughness, surface_row(m, s->surfaces),  //
                                                     m.microfacet ? 1.0f : 0.0f});
    }
    s->environment = environment_table(scene.environment);
    const bool moved = s->anchor != glm::vec3(0);
    s->lights = light_table(moved ? with_lights_at(scene, s->anchor) : scene, s->geometry, s->surfaces, s->environment);
    s->rays = build_ray_query(s->geometry, s->surfaces, rays);
    return s;
}

namespace {

void check_points(const PointInputs& points) {
    if (!points.position || !points.normal) throw InputError("reference: position and normal must be bound");
    const Image4 &p = *points.position, &n = *points.normal;
    if (p.width != n.width || p.height != n.height)
        throw InputError(fmt::format("reference: normal is {} x {}, position is {} x {}: expected equal sizes", n.width,
                                     n.height, p.width, p.height));
}

// The largest coordinate of the world's, and the largest side of what lies in it, m.
double world_extent(const PathScene& scene) {
    glm::vec3 low(0), high(0);
    bounds(scene.geometry, low, high);
    double extent = 0, size = 0;
    for (int c = 0; c < 3; ++c) {
        const double a = double(scene.anchor[c]) + low[c], b = double(scene.anchor[c]) + high[c];
        extent = std::max({extent, std::abs(a), std::abs(b)});
        size = std::max(size, b - a);
    }
    if (size > 0 && extent * 0x1p-19 > size / 64)
        throw InputError(fmt::format("reference: points up to {:.6g} m from the origin are known to {:.2g} m in a float, "
                                     "in a scene of {:.6g} m: move the scene towards the origin",
                                     extent, extent * 0x1p-19, size));
    return extent;
}

}  // namespace

PathArgs camera_args(const PathParams& params, const PathScene& scene, const Camera& camera, glm::ivec2 size,
                     std::uint32_t seed) {
    validate(params, size);
    validate(camera);
    PathArgs args = args_of(params, scene, size.x, seed);

    // The window's corner and its steps, at distance 1 along the view direction.
    const CameraAxes a = axes(camera);
    const double top = host::tan(camera.fov_y_deg * (host::pi / 360)), right = top * size.x / size.y;
    for (int c = 0; c < 3; ++c) {
        args.camera.eye[c] = float(camera.position[c] - double(scene.anchor[c]));
        args.camera.corner[c] = float(a.forward[c] - right * a.right[c] + top * a.up[c]);
        args.camera.across[c] = float(2 * right / size.x * a.right[c]);
        args.camera.down[c] = float(-2 * top / size.y * a.up[c]);
    }
    return args;
}

Image4 anchored(const PathScene& scene, const PointInputs& points) {
    Image4 moved = *points.position;
    if (scene.anchor == glm::vec3(0)) return moved;
    for (std::size_t i = 0; i < moved.size(); ++i)
        if (glm::vec3(points.normal->texels[i]) != glm::vec3(0)) moved.texels[i] -= glm::vec4(scene.anchor, 0);
    return moved;
}

PathArgs point_args(const PathParams& params, const PathScene& scene, const PointInputs& points, std::uint32_t seed) {
    check_points(points);
    const Image4 &p = *points.position, &n = *points.normal;
    validate(params, {p.width, p.height});
    PathArgs args = args_of(params, scene, p.width, seed);
    args.position = &p.data()->x;
    args.normal = &n.data()->x;
    args.extent = float(world_extent(scene));
    return args;
}

Estimate trace(const PathParams& params, const PathScene& scene, const Camera& camera, glm::ivec2 size,
               std::uint32_t seed, const RunOptions& options) {
    FpEnvironment environment;
    return run_rounds(params, scene, camera_args(params, scene, camera, size, seed), size, 1, options);
}

Estimate trace_irradiance(const PathParams& params, const PathScene& scene, const PointInputs& points,
                          std::uint32_t seed, const RunOptions& options) {
    FpEnvironment environment;
    check_points(points);
    const Image4 position = anchored(scene, points);
    const PathArgs args = point_args(params, scene, {&position, points.normal}, seed);
    const double scale = params.mode == Mode::ambient_occlusion ? 1 : host::pi;
    return run_rounds(params, scene, args, {points.position->width, points.position->height}, scale, options);
}

namespace {

// mirrored: as PathArgs has it.
Estimate trace_seen(int mirrored, const PathParams& params, const PathScene& scene, const PointInputs& points,
                    const glm::dvec3& eye, std::uint32_t seed, const RunOptions& options) {
    FpEnvironment environment;
    check_points(points);
    const Image4 position = anchored(scene, points);
    PathArgs args = point_args(params, scene, {&position, points.normal}, seed);
    args.mirrored = mirrored, args.glossy = 1;
    for (int c = 0; c < 3; ++c) args.camera.eye[c] = float(eye[c] - double(scene.anchor[c]));
    return run_rounds(params, scene, args, {points.position->width, points.position->height}, 1, options);
}

}  // namespace

Estimate trace_reflection(const PathParams& params, const PathScene& scene, const PointInputs& points,
                          const glm::dvec3& eye, std::uint32_t seed, const RunOptions& options) {
    return trace_seen(1, params, scene, points, eye, seed, options);
}

Estimate trace_lobes(const PathParams& params, const PathScene& scene, const PointInputs& points, const glm::dvec3& eye,
                     std::uint32_t seed, const RunOptions& options) {
    return trace_seen(2, params, scene, points, eye, seed, options);
}

StageInfo info() {
    PathParams defaults;
    StageInfo s;
    s.name = "reference";
    s.source = "the rendering equation (Kajiya 1986), by path tracing; no GPU pass, so without a twin: "
               "no device binds its inputs, they are what the function is given";
    s.inputs = raster::surface_ports();
    s.inputs.push_back({"lights", "buffer f32 x 4", "W", "[light][4]: gi/reference/light_kernel.h"});
    s.inputs.push_back({"position", "image rgba32f", "m", "points to ask about; none: the camera's pixels"});
    s.inputs.push_back({"normal", "image rgba32f", "", "of those points"});
    s.outputs = {{"truth", "image rgba32f", "W/(m2 sr)", "outgoing radiance; of points: irradiance, W/m2"},
                 {"truth.error", "image rgba32f", "W/(m2 sr)", "its standard error"}};
    s.params = describe(fields(defaults));
    return s;
}

}  // namespace plumb::reference
