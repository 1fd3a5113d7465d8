#include "gi/probes/shadow_spheres.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/probes/indirect_shadow_kernel.h"
#include "gi/probes/run_params.h"
#include "gi/probes/volume.h"

namespace plumb::probes {

namespace {

constexpr int area_cells = 64, point_cells = 24;  // a side of a grid of lines
constexpr int area_directions = 32;
constexpr double golden_angle = 2.399963229728653;
constexpr int rounds = 24;                        // of k-means

double dot(const glm::dvec3& a, const glm::dvec3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

struct Axes {
    glm::dvec3 u, v, d;  // orthonormal; d along the lines
};
Axes axes_along(const glm::dvec3& direction) {
    const glm::dvec3 d = direction / std::sqrt(dot(direction, direction));
    const glm::dvec3 away = std::fabs(d.x) < 0.75 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    const glm::dvec3 across = away - d * dot(away, d), u = across / std::sqrt(dot(across, across));
    return {u, glm::cross(d, u), d};
}

// Lines through the middles of a grid's cells, across the mesh; the depths at which each meets it, m, in the triangles' order.
struct Lines {
    Axes axes;
    glm::dvec2 low{0}, cell{0};
    int side = 0;
    std::vector<std::vector<double>> depths;

    glm::dvec3 at(std::size_t line, double depth) const {
        const double x = low.x + (double(line % std::size_t(side)) + 0.5) * cell.x, y = low.y + (double(line / std::size_t(side)) + 0.5) * cell.y;
        return axes.u * x + axes.v * y + axes.d * depth;
    }
};

std::size_t drawn(const Mesh& mesh) {
    return std::min(std::size_t(std::max(mesh.share, 0.0) * double(mesh.triangles.size())), mesh.triangles.size());
}

std::vector<glm::dvec3> points_along(const Axes& axes, const Mesh& mesh) {
    std::vector<glm::dvec3> points;
    for (const Vertex& v : mesh.vertices) {
        const glm::dvec3 p(v.position);
        points.emplace_back(dot(p, axes.u), dot(p, axes.v), dot(p, axes.d));
        if (!std::isfinite(points.back().x + points.back().y + points.back().z))
            throw InputError(fmt::format("shadow spheres: mesh \"{}\" is not finite", mesh.name));
    }
    return points;
}

Lines begin_lines(std::span<const Mesh> meshes, const glm::dvec3& direction, int side) {
    Lines l;
    l.axes = axes_along(direction), l.side = side, l.depths.resize(std::size_t(side) * std::size_t(side));
    glm::dvec2 low(HUGE_VAL), high(-HUGE_VAL);
    for (const Mesh& mesh : meshes)
        for (const glm::dvec3& p : points_along(l.axes, mesh)) low = glm::min(low, glm::dvec2(p)), high = glm::max(high, glm::dvec2(p));
    l.low = low, l.cell = (high - low) / double(side);
    return l;
}

void add_mesh(const Mesh& mesh, Lines& l) {
    if (!(l.cell.x > 0 && l.cell.y > 0)) return;
    const std::vector<glm::dvec3> points = points_along(l.axes, mesh);
    const int side = l.side;
    const glm::dvec2 low = l.low;
    const auto cells = [&](double a, double b, int axis) {  // whose middles lie between
        const int first = std::max(int(std::ceil((a - low[axis]) / l.cell[axis] - 0.5)), 0);
        return std::pair(first, std::min(int(std::floor((b - low[axis]) / l.cell[axis] - 0.5)), side - 1));
    };
    for (std::size_t i = 0; i < drawn(mesh); ++i) {
        const glm::uvec3& t = mesh.triangles[i];
        const glm::dvec3 &a = points[t.x], &b = points[t.y], &c = points[t.z];
        const double area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
        if (area == 0) continue;
        const auto [x0, x1] = cells(std::min({a.x, b.x, c.x}), std::max({a.x, b.x, c.x}), 0);
        const auto [y0, y1] = cells(std::min({a.y, b.y, c.y}), std::max({a.y, b.y, c.y}), 1);
        for (int y = y0; y <= y1; ++y)
            for (int x = x0; x <= x1; ++x) {
                const double px = low.x + (x + 0.5) * l.cell.x, py = low.y + (y + 0.5) * l.cell.y;
                const double wb = ((px - a.x) * (c.y - a.y) - (c.x - a.x) * (py - a.y)) / area;
                const double wc = ((b.x - a.x) * (py - a.y) - (px - a.x) * (b.y - a.y)) / area;
                if (wb < 0 || wc < 0 || wb + wc > 1) continue;
                l.depths[std::size_t(y) * std::size_t(side) + std::size_t(x)].push_back(a.z + wb * (b.z - a.z) + wc * (c.z - a.z));
            }
    }
}

struct Point {
    glm::dvec3 at;
    double volume;  // m3
};

// Between the surfaces that a line meets.
void add_spans(const Lines& lines, std::size_t line, std::vector<double> depths, std::vector<Point>& points) {
    const double area = lines.cell.x * lines.cell.y, step = std::sqrt(area);
    std::sort(depths.begin(), depths.end());
    // An edge that two triangles share is met twice.
    depths.erase(std::unique(depths.begin(), depths.end(), [&](double a, double b) { return b - a <= 1e-9 * step; }), depths.end());
    for (std::size_t k = 0; k < depths.size(); k += 2) {
        const double first = depths[k], last = k + 1 < depths.size() ? depths[k + 1] : first;
        const int count = std::clamp(int(std::ceil((last - first) / step)), 1, 4 * point_cells);
        const double each = std::max((last - first) / count, 1e-3 * step);
        for (int j = 0; j < count; ++j) points.push_back({lines.at(line, first + (last - first) * (j + 0.5) / count), area * each});
    }
}

// Inside of each mesh, by lines along the three axes.
std::vector<Point> points_inside(std::span<const Mesh> meshes) {
    std::vector<Point> points;
    for (int axis = 0; axis < 3; ++axis) {
        glm::dvec3 direction(0);
        direction[axis] = 1;
        const Lines grid = begin_lines(meshes, direction, point_cells);
        if (!(grid.cell.x > 0 && grid.cell.y > 0)) continue;
        for (const Mesh& mesh : meshes) {
            Lines lines = grid;
            add_mesh(mesh, lines);
            for (std::size_t i = 0; i < lines.depths.size(); ++i) add_spans(lines, i, lines.depths[i], points);
        }
    }
    return points;
}

double distance2(const glm::dvec3& a, const glm::dvec3& b) { return dot(a - b, a - b); }

// The first centre is the middle of all, each further one the point farthest from those before it.
std::vector<glm::dvec3> first_centres(const std::vector<Point>& points, int count) {
    glm::dvec3 middle(0);
    double total = 0;
    for (const Point& p : points) middle += p.at * p.volume, total += p.volume;
    std::vector<glm::dvec3> centres = {middle / total};
    std::vector<double> nearest(points.size(), HUGE_VAL);
    while (int(centres.size()) < count) {
        std::size_t farthest = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            nearest[i] = std::min(nearest[i], distance2(points[i].at, centres.back()));
            if (nearest[i] > nearest[farthest]) farthest = i;
        }
        if (!(nearest[farthest] > 0)) break;
        centres.push_back(points[farthest].at);
    }
    return centres;
}

// k-means: xyz the mean of each part, w its volume; parts that nothing is left of are left out.
std::vector<glm::dvec4> parts_of(const std::vector<Point>& points, int count) {
    std::vector<glm::dvec3> centres = first_centres(points, count);
    std::vector<glm::dvec4> sums;
    for (int round = 0; round < rounds; ++round) {
        sums.assign(centres.size(), glm::dvec4(0));
        for (const Point& p : points) {
            std::size_t best = 0;
            double least = HUGE_VAL;
            for (std::size_t c = 0; c < centres.size(); ++c)
                if (const double d = distance2(p.at, centres[c]); d < least) least = d, best = c;
            sums[best] += glm::dvec4(p.at * p.volume, p.volume);
        }
        for (std::size_t c = 0; c < centres.size(); ++c)
            if (sums[c].w > 0) centres[c] = glm::dvec3(sums[c]) / sums[c].w;
    }
    std::vector<glm::dvec4> parts;
    for (std::size_t c = 0; c < centres.size(); ++c)
        if (sums[c].w > 0) parts.emplace_back(centres[c], sums[c].w);
    return parts;
}

bool same_transform(const Mesh& a, const Mesh& b) {
    for (int c = 0; c < 4; ++c)
        for (int k = 0; k < 4; ++k)
            if (a.transform[c][k] != b.transform[c][k]) return false;
    return true;
}

double covered_area(std::span<const Mesh> meshes) {
    double sum = 0;
    for (int i = 0; i < area_directions; ++i) {  // a spiral over the hemisphere, each for as much of it
        const double z = (i + 0.5) / area_directions, angle = i * golden_angle, across = std::sqrt(1 - z * z);
        Lines l = begin_lines(meshes, glm::dvec3(across * host::cos(angle), across * host::sin(angle), z), area_cells);
        for (const Mesh& mesh : meshes) add_mesh(mesh, l);
        if (!(l.cell.x > 0 && l.cell.y > 0)) continue;
        const std::ptrdiff_t cells = std::count_if(l.depths.begin(), l.depths.end(), [](const auto& d) { return !d.empty(); });
        sum += double(cells) * l.cell.x * l.cell.y;
    }
    return sum / area_directions;
}

}  // namespace

std::vector<MovingGroup> moving_groups(const Scene& scene) {
    std::vector<MovingGroup> groups;
    for (int i = 0; i < int(scene.meshes.size()); ++i) {
        const Mesh& mesh = scene.meshes[std::size_t(i)];
        if (!mesh.dynamic || mesh.triangles.empty()) continue;
        if (!groups.empty() && groups.back().last == i - 1 && same_transform(mesh, scene.meshes[std::size_t(i - 1)]))
            groups.back().last = i;
        else
            groups.push_back({i, i});
    }
    return groups;
}

double projected_area(std::span<const Mesh> meshes) { return covered_area(meshes); }

Buffer<glm::vec4> fit_spheres(std::span<const Mesh> meshes, int count) {
    Buffer<glm::vec4> spheres;
    const std::vector<Point> points = points_inside(meshes);
    const double area = covered_area(meshes);
    if (points.empty() || !(area > 0)) return spheres;
    const std::vector<glm::dvec4> parts = parts_of(points, count);
    std::vector<double> radii;
    double discs = 0;
    for (const glm::dvec4& p : parts) {
        radii.push_back(host::exp(host::log(3 * p.w / (4 * host::pi)) / 3));
        discs += host::pi * radii.back() * radii.back();
    }
    const double scale = std::sqrt(area / discs);
    for (std::size_t i = 0; i < parts.size(); ++i) spheres.push_back(glm::vec4(glm::dvec4(glm::dvec3(parts[i]), radii[i] * scale)));
    return spheres;
}

ShadowSpheres place_spheres(const Scene& scene, const std::vector<MovingGroup>& groups, const std::vector<Buffer<glm::vec4>>& fitted) {
    ShadowSpheres s;
    const auto add = [&](const glm::vec4& sphere, const glm::ivec2& owner) {
        s.rows.push_back(sphere);
        s.rows.insert(s.rows.end(), shadow_rows - 1, glm::vec4(0));
        s.owner.push_back(owner);
    };
    for (std::size_t g = 0; g < fitted.size(); ++g) {
        const glm::dmat4& t = scene.meshes[std::size_t(groups[g].first)].transform;
        double squares = 0;
        for (int k = 0; k < 3; ++k) squares += dot(glm::dvec3(t[k]), glm::dvec3(t[k]));
        const double scale = std::sqrt(squares / 3);
        for (const glm::vec4& f : fitted[g])
            add(glm::vec4(glm::dvec4(glm::dvec3(t * glm::dvec4(glm::dvec3(f), 1)), double(f.w) * scale)), {groups[g].first, groups[g].last});
    }
    if (s.owner.empty()) add(glm::vec4(0), {-1, -2});
    return s;
}

void light_spheres(const SpatialGrid& grid, const Buffer<glm::vec4>& irradiance, const std::vector<glm::vec3>& reflects,
                   const RunOptions& options, ShadowSpheres& spheres) {
    const int count = spheres.count();
    Image4 position(spatial_directions, count), normal(spatial_directions, count);
    const Image4 uv(spatial_directions, count, glm::vec4(-1));
    for (int i = 0; i < count; ++i)
        for (int d = 0; d < spatial_directions; ++d) {
            position(d, i) = glm::vec4(glm::vec3(spheres.rows[std::size_t(i) * shadow_rows]), 0);
            normal(d, i) = glm::vec4(spatial_direction(d), 1);
        }
    // Along an axis `cube` is the irradiance of that direction alone.
    VolumeInputs in;
    in.grid = grid, in.form = VolumeForm::cube, in.everywhere = true;
    in.position = &position, in.normal = &normal, in.lightmap_uv = &uv, in.irradiance = &irradiance;
    VolumeLight six;
    run(in, options, six);
    for (int i = 0; i < count; ++i) {
        const int owner = spheres.owner[std::size_t(i)].x;
        const glm::vec3 rho = owner >= 0 && std::size_t(owner) < reflects.size() ? reflects[std::size_t(owner)] : glm::vec3(0);
        for (int c = 0; c < 3; ++c) {
            double a = 0;
            glm::dvec3 b;
            for (int axis = 0; axis < 3; ++axis) {
                const double plus = double(six.irradiance(2 * axis, i)[c]), minus = double(six.irradiance(2 * axis + 1, i)[c]);
                a += (plus + minus) / (6 * host::pi), b[axis] = 3 * (plus - minus) / (4 * host::pi);
            }
            glm::vec4* row = &spheres.rows[std::size_t(i) * shadow_rows];
            row[1 + c] = glm::vec4(glm::dvec4(b, a));
            row[4 + c] = glm::vec4(double(rho[c]) * glm::dvec4(b * (-4.0 / 9), a));
        }
    }
}

std::vector<glm::vec3> mean_reflectance(const Scene& scene) {
    std::vector<glm::vec3> means(scene.meshes.size(), glm::vec3(0));
    for (const MovingGroup& group : moving_groups(scene)) {
        glm::dvec3 sum(0);
        double total = 0;
        for (int m = group.first; m <= group.last; ++m) {
            const Mesh& mesh = scene.meshes[std::size_t(m)];
            for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
                const glm::uvec3& t = mesh.triangles[i];
                const glm::dvec3 a(mesh.vertices[t.x].position), n = glm::cross(glm::dvec3(mesh.vertices[t.y].position) - a, glm::dvec3(mesh.vertices[t.z].position) - a);
                const std::int32_t material = mesh.material[i];
                if (material < 0 || std::size_t(material) >= scene.materials.size()) continue;
                const double area = std::sqrt(dot(n, n));
                sum += area * glm::dvec3(scene.materials[std::size_t(material)].reflectance), total += area;
            }
        }
        for (int m = group.first; m <= group.last && total > 0; ++m) means[std::size_t(m)] = glm::vec3(sum / total);
    }
    return means;
}

StageInfo info_shadow_spheres() {
    StageInfo info;
    info.name = "probes.shadow_spheres";
    info.source = "beyond IPR (its 6.1); without a twin: k-means of a mesh once, then a few numbers a sphere";
    info.inputs = {{"meshes", "triangles", "m", "that are dynamic"}, {"grid", "buffer f32 x 4", "W/m2", "[place][direction] irradiance of spatial receivers"}};
    info.outputs = {{"spheres", "buffer f32 x 4", "m; W/(m2 sr)", "[sphere][7] centre and radius; the light that it hides, and what it sends"},
                    {"owner", "buffer i32 x 2", "", "[sphere] first and last of the objects that it stands for"}};
    RunParams defaults;
    info.params = describe(fields(defaults), {"indirect_shadow", "shadow_spheres"});
    return info;
}

}  // namespace plumb::probes
