#include "gi/reference/closed_form_scenes.h"

#include <algorithm>
#include <cmath>

#include "core/hash.h"
#include "core/host_math.h"
#include "core/sequences.h"
#include "gi/reference/ray_query.h"
#include "gi/rsm/gather.h"
#include "raster/light_view.h"

namespace plumb::reference {
namespace {

using Point = glm::dvec3;

constexpr int row_length = 16;       // points a row
constexpr int samples_of_one = 256;  // of a point that stands for itself: many, so that they lie evenly
constexpr int samples_of_many = 32;  // of one of many points: few, so that the points lie closely
constexpr std::uint64_t pilot_paths = 1 << 12, most_paths = 1 << 25;
constexpr float roulette = 0.1f;  // a path's length spreads by its mean where rho is near 1: wait for a tenth

double length(const Point& v) { return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z); }

// Corners are not shared and have no normal: the face's own counts.
void add_triangle(Mesh& mesh, const Point& a, const Point& b, const Point& c) {
    const auto first = std::uint32_t(mesh.vertices.size());
    for (const Point* p : {&a, &b, &c}) {
        Vertex v;
        v.position = glm::vec3(*p);
        v.normal = glm::vec3(0);
        mesh.vertices.push_back(v);
    }
    mesh.triangles.push_back({first, first + 1, first + 2});
}

void add_mesh(Scene& scene, const Material& material, Mesh mesh) {
    mesh.material.assign(mesh.triangles.size(), std::int32_t(scene.materials.size()));
    scene.materials.push_back(material);
    scene.meshes.push_back(std::move(mesh));
}

void add_quad(Mesh& mesh, const Point& a, const Point& b, const Point& c, const Point& d) {
    add_triangle(mesh, a, b, c);
    add_triangle(mesh, a, c, d);
}

void add_rectangle(Mesh& mesh, const Point& low, const Point& high) {
    const int axis = low.x == high.x ? 0 : low.y == high.y ? 1 : 2, u = (axis + 1) % 3;
    Point b = low, d = high;
    b[u] = high[u], d[u] = low[u];
    add_quad(mesh, low, b, high, d);
}

struct Corners {
    Point a, b, c;
};
Corners corners(const Mesh& mesh, std::size_t triangle) {
    const glm::uvec3 t = mesh.triangles[triangle];
    return {Point(mesh.vertices[t.x].position), Point(mesh.vertices[t.y].position), Point(mesh.vertices[t.z].position)};
}

Point cross(const Point& a, const Point& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

double area(const Corners& t) { return 0.5 * length(cross(t.b - t.a, t.c - t.a)); }

Point normal_towards(const Corners& t, const Point& eye) {
    const Point n = cross(t.b - t.a, t.c - t.a), to_eye = eye - t.a;
    const double side = n.x * to_eye.x + n.y * to_eye.y + n.z * to_eye.z;
    return n * ((side < 0 ? -1 : 1) / length(n));
}

// Splits in four by the middles of the edges, which neighbours share to the bit.
void split(Mesh& mesh, int levels, const Point& a, const Point& b, const Point& c) {
    if (levels == 0) return add_triangle(mesh, a, b, c);
    auto middle = [](const Point& p, const Point& q) { return (p + q) / length(p + q); };
    const Point ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    split(mesh, levels - 1, a, ab, ca);
    split(mesh, levels - 1, ab, b, bc);
    split(mesh, levels - 1, ca, bc, c);
    split(mesh, levels - 1, ab, bc, ca);
}

int rows_for(std::uint64_t paths, int samples) {
    const std::uint64_t row = std::uint64_t(row_length) * std::uint64_t(samples);
    return int((paths + row - 1) / row);
}

ReceiverPoints points_for(std::uint64_t paths, int samples) {
    const int rows = rows_for(paths, samples);
    return {Image4(row_length, rows), Image4(row_length, rows), samples};
}

PathParams path_params(Mode mode, int samples, const ClosedFormOptions& options) {
    PathParams params;
    params.mode = mode;
    params.samples = samples;
    params.roulette = roulette;
    params.rays = options.rays;
    return params;
}

// Pixels draw their own random numbers, so the variance of their mean is the sum of theirs over their number squared.
Measured mean_of(const Estimate& estimate, int channel) {
    double sum = 0, variance = 0;
    for (std::size_t i = 0; i < estimate.mean.size(); ++i) {
        const double error = estimate.error.texels[i][channel];
        sum += estimate.mean.texels[i][channel];
        variance += error * error;
    }
    const auto n = double(estimate.mean.size());
    Measured m;
    m.got = sum / n;
    m.standard_error = std::sqrt(variance) / n;
    m.samples = std::uint64_t(estimate.samples) * estimate.mean.size();
    m.rays = estimate.rays;
    m.nonfinite = estimate.nonfinite;
    return m;
}

// Runs `trace` for as many paths as the pilot asks for. The two share no random number.
template <class Trace>
Measured with_pilot(const ClosedFormOptions& options, Trace trace) {
    const Measured pilot = trace(pilot_paths, std::uint32_t(pcg(std::int32_t(options.seed))));
    const double ratio = pilot.standard_error / (options.error * std::fabs(pilot.got));
    if (!(ratio > 0)) return pilot;
    const double wanted = double(pilot_paths) * ratio * ratio;
    return trace(std::uint64_t(std::clamp(wanted, double(pilot_paths), double(most_paths))), options.seed);
}

}  // namespace

Material grey(double reflectance, double emission) {
    Material m;
    m.reflectance = glm::vec3(float(reflectance));
    m.emission = glm::vec3(float(emission));
    return m;
}

void add_quad(Scene& scene, const Material& material, const Point& a, const Point& b, const Point& c, const Point& d) {
    Mesh mesh;
    add_quad(mesh, a, b, c, d);
    add_mesh(scene, material, std::move(mesh));
}

void add_rectangle(Scene& scene, const Material& material, const Point& low, const Point& high) {
    Mesh mesh;
    add_rectangle(mesh, low, high);
    add_mesh(scene, material, std::move(mesh));
}

void add_cube(Scene& scene, const Material& material, const Point& low, const Point& high) {
    Mesh mesh;
    for (int axis = 0; axis < 3; ++axis) {
        Point top = low, bottom = high;
        top[axis] = high[axis], bottom[axis] = low[axis];
        add_rectangle(mesh, low, bottom);
        add_rectangle(mesh, top, high);
    }
    add_mesh(scene, material, std::move(mesh));
}

void add_frame(Scene& scene, const Material& material, double y, double outer, double inner) {
    const double o = outer / 2, i = inner / 2;
    Mesh mesh;
    add_rectangle(mesh, {-o, y, -o}, {o, y, -i});
    add_rectangle(mesh, {-o, y, i}, {o, y, o});
    add_rectangle(mesh, {-o, y, -i}, {-i, y, i});
    add_rectangle(mesh, {i, y, -i}, {o, y, i});
    add_mesh(scene, material, std::move(mesh));
}

void add_disc(Scene& scene, const Material& material, double y, double radius) {
    const int n = 128;
    const double step = 2 * host::pi / n, r = radius * std::sqrt(step / host::sin(step));
    auto corner = [&](int i) { return Point(r * host::cos(step * (i % n)), y, r * host::sin(step * (i % n))); };
    Mesh mesh;
    for (int i = 0; i < n; ++i) add_triangle(mesh, {0, y, 0}, corner(i), corner(i + 1));
    add_mesh(scene, material, std::move(mesh));
}

void add_sphere(Scene& scene, const Material& material, const Point& centre, double radius, int levels) {
    const double phi = (1 + std::sqrt(5.0)) / 2, r = std::sqrt(1 + phi * phi);
    // The icosahedron: three golden rectangles.
    Point p[12];
    for (int i = 0; i < 12; ++i) {
        const double u = i & 1 ? 1 : -1, v = i & 2 ? phi : -phi;
        p[i] = i < 4 ? Point(0, u, v) : i < 8 ? Point(u, v, 0) : Point(v, 0, u);
    }
    Mesh mesh;
    for (int i = 0; i < 12; ++i)
        for (int j = i + 1; j < 12; ++j)
            for (int k = j + 1; k < 12; ++k)
                // Edges are 2 long; all other corners are farther apart.
                if (length(p[i] - p[j]) < 2.1 && length(p[j] - p[k]) < 2.1 && length(p[k] - p[i]) < 2.1)
                    split(mesh, levels, p[i] / r, p[j] / r, p[k] / r);
    const double scale = radius * std::sqrt(4 * host::pi / area(mesh));
    for (Vertex& v : mesh.vertices) v.position = glm::vec3(centre + scale * Point(v.position));
    add_mesh(scene, material, std::move(mesh));
}

double area(const Mesh& mesh, int material) {
    double sum = 0;
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
        if (material < 0 || mesh.material[t] == material) sum += area(corners(mesh, t));
    return sum;
}

SurfacePoint middle_of(const Mesh& mesh, std::size_t triangle, const Point& eye) {
    const Corners t = corners(mesh, triangle);
    return {(t.a + t.b + t.c) / 3.0, normal_towards(t, eye)};
}

ReceiverPoints repeated(const Point& position, const Point& normal, std::uint64_t paths) {
    ReceiverPoints points = points_for(paths, samples_of_one);
    std::fill(points.position.texels.begin(), points.position.texels.end(), glm::vec4(glm::vec3(position), 0));
    std::fill(points.normal.texels.begin(), points.normal.texels.end(), glm::vec4(glm::vec3(normal), 0));
    return points;
}

ReceiverPoints spread(const Mesh& mesh, const Point& eye, std::uint64_t paths) {
    ReceiverPoints points = points_for(paths, samples_of_many);
    const double step = area(mesh) / double(points.position.size());
    // Walk along the triangles' areas laid end to end.
    std::size_t triangle = 0;
    Corners t = corners(mesh, 0);
    double end = area(t);
    for (std::size_t i = 0; i < points.position.size(); ++i) {
        while ((i + 0.5) * step >= end && triangle + 1 < mesh.triangles.size()) {
            t = corners(mesh, ++triangle);
            end += area(t);
        }
        const glm::dvec2 u = r2(i);
        const double s = std::sqrt(u.x);
        points.position.texels[i] = glm::vec4(glm::vec3(t.a * (1 - s) + t.b * (s * (1 - u.y)) + t.c * (s * u.y)), 0);
        points.normal.texels[i] = glm::vec4(glm::vec3(normal_towards(t, eye)), 0);
    }
    return points;
}

Light point_lamp(const Point& position, double power) {
    Light light;
    light.type = LightType::point;
    light.position = glm::vec3(position);
    light.intensity = glm::vec3(float(power / (4 * host::pi)));
    return light;
}

Measured trace_points(const Scene& scene, Mode mode, const PointMaker& points, const ClosedFormOptions& options,
                      int channel) {
    const std::unique_ptr<PathScene> prepared = prepare(scene, options.rays);
    return with_pilot(options, [&](std::uint64_t paths, std::uint32_t seed) {
        const ReceiverPoints at = points(paths);
        return mean_of(trace_irradiance(path_params(mode, at.samples, options), *prepared, {&at.position, &at.normal},
                                        seed, options.run),
                       channel);
    });
}

Measured trace_frame(const Scene& scene, const Camera& camera, const ClosedFormOptions& options) {
    const std::unique_ptr<PathScene> prepared = prepare(scene, options.rays);
    return with_pilot(options, [&](std::uint64_t paths, std::uint32_t seed) {
        const glm::ivec2 size(row_length, rows_for(paths, samples_of_one));
        const PathParams params = path_params(Mode::all, samples_of_one, options);
        return mean_of(trace(params, *prepared, camera, size, seed, options.run), 0);
    });
}

Measured gather_points(const Scene& scene, const ReceiverPoints& points, const ClosedFormOptions& options) {
    const Geometry geometry = flatten(scene);
    const raster::Surfaces surfaces = raster::prepare(scene, geometry);
    glm::vec3 low, high;
    bounds(geometry, low, high);
    std::vector<raster::Rsm> maps;
    for (const View& view : raster::light_views(scene.lights[0], low, high))
        raster::draw_rsm(geometry, surfaces, scene.lights[0], view, raster::Layout::fp32, options.run,
                         maps.emplace_back());
    return gather_maps(maps, points, options);
}

Measured gather_maps(const std::vector<raster::Rsm>& maps, const ReceiverPoints& points,
                     const ClosedFormOptions& options, const Occluders& occluders) {
    rsm::GatherParams params;
    params.gather = occluders.scene ? rsm::Gather::all_rays : rsm::Gather::all;
    params.max_rays = occluders.max_rays;
    rsm::GatherInputs inputs;
    inputs.position = &points.position;
    inputs.normal = &points.normal;
    inputs.seed = options.seed;
    Geometry geometry;
    raster::Surfaces surfaces;
    std::unique_ptr<RayQuery> rays;
    if (occluders.scene) {
        geometry = flatten(*occluders.scene);
        surfaces = raster::prepare(*occluders.scene, geometry);
        rays = build_ray_query(geometry, surfaces, options.rays);
        inputs.rays = rays.get();
        inputs.offsets = {1e-6f, 1e-6f};  // m
    }
    Estimate estimate;
    rsm::RaysReport report;
    rsm::run_maps(params, inputs, maps, options.run, estimate.mean, &report);
    estimate.error = occluders.scene ? report.standard_error : Image4(estimate.mean.width, estimate.mean.height);
    Measured m = mean_of(estimate, 0);
    m.rays = report.traced;
    for (const raster::Rsm& map : maps) m.samples += std::uint64_t(map.size) * map.size * points.position.size();
    if (occluders.scene) m.samples = report.asked * report.points;
    return m;
}

}  // namespace plumb::reference
