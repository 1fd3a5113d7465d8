#include "io/scenes/builder.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/hash.h"
#include "core/host_math.h"
#include "core/parallel.h"
#include "core/rotation.h"

namespace plumb::io::scenes {
namespace {

Point cross(const Point& a, const Point& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
double dot(const Point& a, const Point& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Point unit(const Point& v) {
    const double length = std::sqrt(dot(v, v));
    return length > 0 ? v / length : v;
}

// The byte that stands for a linear value: rounded to nearest on the sRGB curve (IEC 61966-2-1). A table of the values
// where the byte changes takes the place of a power a texel.
std::uint32_t encode_srgb(double c) {
    static const std::array<double, 255> steps = [] {
        std::array<double, 255> s;
        for (int k = 0; k < 255; ++k) {
            const double encoded = (k + 0.5) / 255;
            s[std::size_t(k)] = encoded <= 0.04045 ? encoded / 12.92 : host::pow((encoded + 0.055) / 1.055, 2.4);
        }
        return s;
    }();
    return std::uint32_t(std::upper_bound(steps.begin(), steps.end(), c) - steps.begin());
}

}  // namespace

Place move(const Point& by) {
    Place m(1);
    m[3] = glm::dvec4(by, 1);
    return m;
}

Place turn_y(double degrees) {
    const glm::dvec2 sc = sin_cos_deg(degrees);
    Place m(1);
    m[0][0] = m[2][2] = sc.y;
    m[2][0] = sc.x;
    m[0][2] = -sc.x;
    return m;
}

Place turn_x(double degrees) {
    const glm::dvec2 sc = sin_cos_deg(degrees);
    Place m(1);
    m[1][1] = m[2][2] = sc.y;
    m[1][2] = sc.x;
    m[2][1] = -sc.x;
    return m;
}

Place scale(const Point& by) {
    Place m(1);
    for (int axis = 0; axis < 3; ++axis) m[axis][axis] = by[axis];
    return m;
}

Builder::Builder(std::string scene_name, bool counting) : counting_(counting) { scene_.name = std::move(scene_name); }

int Builder::material(const Material& material) {
    scene_.materials.push_back(material);
    return int(scene_.materials.size()) - 1;
}

int Builder::texture(const Texture& texture) {
    scene_.textures.push_back(texture);
    return int(scene_.textures.size()) - 1;
}

void Builder::object(const std::string& name) {
    if (!scene_.meshes.empty() && scene_.meshes.back().triangles.empty()) scene_.meshes.pop_back();
    scene_.meshes.emplace_back();
    scene_.meshes.back().name = name;
}

Builder::Mapping::Mapping(const Place& p)
    : place(p),
      normals(glm::transpose(glm::inverse(glm::dmat3(p)))),
      mirrored(glm::determinant(glm::dmat3(p)) < 0) {}

void Builder::begin_mesh() {
    if (scene_.meshes.empty()) object(scene_.name);
}

std::uint32_t Builder::vertex(const Mapping& mapping, const Point& position, const Point& normal, double u, double v) {
    Mesh& mesh = scene_.meshes.back();
    const Point p(mapping.place * glm::dvec4(position, 1));
    const Point n = unit(mapping.normals * normal);
    mesh.vertices.push_back({glm::vec3(p), float(u), glm::vec3(n), float(v)});
    return std::uint32_t(mesh.vertices.size()) - 1;
}

void Builder::face(int material, const Mapping& mapping, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    Mesh& mesh = scene_.meshes.back();
    const Point pa(mesh.vertices[a].position), pb(mesh.vertices[b].position), pc(mesh.vertices[c].position);
    const Point normal = cross(pb - pa, pc - pa);
    if (!(dot(normal, normal) > 0)) return;
    if (mapping.mirrored) std::swap(b, c);
    mesh.triangles.push_back({a, b, c});
    mesh.material.push_back(material);
    ++triangles_;
}

void Builder::grid(int material, const Place& place, const Grid& g, const Patch& patch) {
    if (counting_) {
        triangles_ += std::int64_t(g.columns) * (2 * g.rows - (g.pole ? 1 : 0));
        return;
    }
    begin_mesh();
    const int stride = g.columns + 1;
    const Mapping mapping(place);
    std::vector<Point>&points = points_, &normals = normals_;
    points.resize(std::size_t(stride) * (g.rows + 1));
    for (int j = 0; j <= g.rows; ++j)
        for (int i = 0; i <= g.columns; ++i)
            points[std::size_t(j) * stride + i] = patch(double(i) / g.columns, double(j) / g.rows);
    auto at = [&](int i, int j) -> const Point& { return points[std::size_t(j) * stride + i]; };
    auto add = [&](int i, int j, const Point& normal) {
        const glm::dvec2 t = g.projection
                                 ? g.projection(at(i, j))
                                 : glm::dvec2(g.texture.x * i / g.columns, g.texture.y * j / g.rows);
        return vertex(mapping, at(i, j), normal, t.x, t.y);
    };

    if (!g.smooth) {
        for (int j = 0; j < g.rows; ++j)
            for (int i = 0; i < g.columns; ++i) {
                const Point n = cross(at(i + 1, j + 1) - at(i, j), at(i, j + 1) - at(i + 1, j));
                const std::uint32_t a = add(i, j, n), b = add(i + 1, j, n);
                const std::uint32_t c = add(i + 1, j + 1, n), d = add(i, j + 1, n);
                if (!g.pole || j > 0) face(material, mapping, a, b, c);
                face(material, mapping, a, c, d);
            }
        return;
    }

    // The normal of a vertex is the sum of the cross products of the quads around it.
    normals.assign(points.size(), Point(0));
    for (int j = 0; j < g.rows; ++j)
        for (int i = 0; i < g.columns; ++i) {
            const Point n = cross(at(i + 1, j + 1) - at(i, j), at(i, j + 1) - at(i + 1, j));
            for (int k = 0; k < 4; ++k) normals[std::size_t(j + k / 2) * stride + i + k % 2] += n;
        }
    if (g.closed_u)
        for (int j = 0; j <= g.rows; ++j) {
            Point &first = normals[std::size_t(j) * stride], &last = normals[std::size_t(j) * stride + g.columns];
            first = last = first + last;
        }
    const std::uint32_t first = std::uint32_t(scene_.meshes.back().vertices.size());
    for (int j = 0; j <= g.rows; ++j)
        for (int i = 0; i <= g.columns; ++i) add(i, j, normals[std::size_t(j) * stride + i]);
    for (int j = 0; j < g.rows; ++j)
        for (int i = 0; i < g.columns; ++i) {
            const std::uint32_t a = first + std::uint32_t(j * stride + i), b = a + 1, d = a + std::uint32_t(stride);
            if (!g.pole || j > 0) face(material, mapping, a, b, d + 1);
            face(material, mapping, a, d + 1, d);
        }
}

void Builder::quad(int material, const Place& place, const Point corners[4], int columns, int rows,
                   double texture_size) {
    const Point a = corners[0], b = corners[1], c = corners[2], d = corners[3];
    Grid g;
    g.columns = columns, g.rows = rows;
    g.texture = {std::sqrt(dot(b - a, b - a)) / texture_size, std::sqrt(dot(d - a, d - a)) / texture_size};
    grid(material, place, g,
         [&](double u, double v) { return (1 - v) * ((1 - u) * a + u * b) + v * ((1 - u) * d + u * c); });
}

void Builder::sheet(int material, const Place& place, const std::vector<double>& across, const std::vector<double>& up,
                    const std::function<bool(int, int)>& open, double texture_size) {
    const int stride = int(across.size()), rows = int(up.size());
    if (counting_) {
        for (int j = 0; j + 1 < rows; ++j)
            for (int i = 0; i + 1 < stride; ++i) triangles_ += open && open(i, j) ? 0 : 2;
        return;
    }
    begin_mesh();
    const Mapping mapping(place);
    const std::uint32_t first = std::uint32_t(scene_.meshes.back().vertices.size());
    for (double y : up)
        for (double x : across) vertex(mapping, {x, y, 0}, {0, 0, 1}, x / texture_size, -y / texture_size);
    for (int j = 0; j + 1 < rows; ++j)
        for (int i = 0; i + 1 < stride; ++i) {
            if (open && open(i, j)) continue;
            const std::uint32_t a = first + std::uint32_t(j * stride + i), d = a + std::uint32_t(stride);
            face(material, mapping, a, a + 1, d + 1);
            face(material, mapping, a, d + 1, d);
        }
}

void Builder::box(int material, const Place& place, const Point& low, const Point& high, double texture_size,
                  const glm::ivec3& cells) {
    // Each side spans axes a and b, which turn counter-clockwise about the side's outward normal.
    for (int axis = 0; axis < 3; ++axis)
        for (int side = 0; side < 2; ++side) {
            const int a = side ? (axis + 1) % 3 : (axis + 2) % 3, b = side ? (axis + 2) % 3 : (axis + 1) % 3;
            Point corner[4];
            for (int k = 0; k < 4; ++k) {
                corner[k][axis] = side ? high[axis] : low[axis];
                corner[k][a] = k == 1 || k == 2 ? high[a] : low[a];
                corner[k][b] = k >= 2 ? high[b] : low[b];
            }
            quad(material, place, corner, cells[a], cells[b], texture_size);
        }
}

void Builder::sweep(int material, const Place& place, const Profile& profile, int columns, double length,
                    double texture_size, const Sweep& path, bool closed_u) {
    // Cut the profile where it bends sharply; each stretch is a smooth grid of its own.
    const std::vector<glm::dvec2>& points = profile.points;
    const double crease = sin_cos_deg(profile.crease_deg).y;
    std::size_t first = 0;
    for (std::size_t i = 1; i < points.size(); ++i) {
        bool sharp = i + 1 == points.size();
        if (!sharp) {
            const glm::dvec2 a = points[i] - points[i - 1], b = points[i + 1] - points[i];
            sharp = a.x * b.x + a.y * b.y < crease * std::sqrt((a.x * a.x + a.y * a.y) * (b.x * b.x + b.y * b.y));
        }
        if (!sharp) continue;
        double width = 0;
        for (std::size_t k = first + 1; k <= i; ++k)
            width += std::sqrt(glm::dot(points[k] - points[k - 1], points[k] - points[k - 1]));
        Grid g;
        g.columns = columns, g.rows = int(i - first);
        g.texture = {length / texture_size, width / texture_size};
        g.closed_u = closed_u;
        grid(material, place, g,
             [&](double u, double v) { return path(u, points[first + std::size_t(v * g.rows + 0.5)]); });
        first = i;
    }
}

void Builder::lathe(int material, const Place& place, const std::vector<glm::dvec2>& profile, int segments,
                    double texture_size, double crease_deg) {
    // The texture closes around: the widest girth is a whole number of periods.
    double widest = 0;
    for (const glm::dvec2& p : profile) widest = std::max(widest, p.x);
    const double periods = std::max(1.0, std::floor(2 * host::pi * widest / texture_size + 0.5));
    // The quads at a pole are triangles.
    if (counting_) triangles_ -= segments * ((profile.front().x == 0 ? 1 : 0) + (profile.back().x == 0 ? 1 : 0));
    sweep(
        material, place, {profile, crease_deg}, segments, periods * texture_size, texture_size,
        [](double u, const glm::dvec2& p) {
            const glm::dvec2 sc = sin_cos_deg(360 * u);
            return Point(p.x * sc.x, p.y, p.x * sc.y);
        },
        true);
}

void Builder::frame(int material, const Place& place, const Profile& profile, const glm::dvec2& half,
                    const glm::ivec2& columns, double texture_size) {
    for (int side = 0; side < 4; ++side) {
        const bool along_x = side % 2 == 0;
        const double sign = side < 2 ? 1 : -1, length = 2 * (along_x ? half.x : half.y);
        // Seen from the middle, u runs from left to right.
        sweep(material, place, profile, along_x ? columns.x : columns.y, length, texture_size,
              [&](double u, const glm::dvec2& p) {
                  const double x = half.x - p.x, z = half.y - p.x;
                  return along_x ? Point(sign * x * (1 - 2 * u), p.y, sign * z)
                                 : Point(sign * x, p.y, sign * z * (2 * u - 1));
              });
    }
}

void Builder::cloth(int material, const Place& place, const Grid& g, const Point& thickness, const Patch& patch) {
    grid(material, place, g, patch);
    // The back exchanges u and v, which turns it around and keeps its diagonals: the sheets stay parallel.
    auto at = [&](int i, int j) { return patch(double(i) / g.columns, double(j) / g.rows); };
    Grid back = g;
    std::swap(back.columns, back.rows);
    std::swap(back.texture.x, back.texture.y);
    grid(material, place, back,
         [&](double u, double v) { return at(int(v * g.columns + 0.5), int(u * g.rows + 0.5)) - thickness; });
    Grid edge;
    edge.texture = {0.01, 0.01};
    for (int end = 0; end < 2; ++end) {
        edge.columns = 1, edge.rows = g.rows;
        grid(material, place, edge, [&](double u, double v) {
            return at(end * g.columns, int(v * g.rows + 0.5)) - ((end == 0) == (u == 0) ? thickness : Point(0));
        });
        edge.columns = g.columns, edge.rows = 1;
        grid(material, place, edge, [&](double u, double v) {
            return at(int(u * g.columns + 0.5), end * g.rows) - ((end == 0) == (v == 0) ? thickness : Point(0));
        });
    }
}

void Builder::triangle(int material, const Place& place, const Point& a, const Point& b, const Point& c) {
    if (counting_) {
        ++triangles_;
        return;
    }
    begin_mesh();
    const Mapping mapping(place);
    const Point n = cross(b - a, c - a);
    const std::uint32_t i = vertex(mapping, a, n, 0, 0), j = vertex(mapping, b, n, 1, 0),
                        k = vertex(mapping, c, n, 0, 1);
    face(material, mapping, i, j, k);
}

Scene Builder::take() {
    if (!scene_.meshes.empty() && scene_.meshes.back().triangles.empty()) scene_.meshes.pop_back();
    return std::move(scene_);
}

double white_noise(int x, int y, std::uint32_t seed) {
    return unit_float<float>(pixel_hash<std::int32_t>(x, y, 0, std::int32_t(seed)).x);
}

double smooth_noise(double u, double v, int periods, std::uint32_t seed) {
    const double x = u * periods, y = v * periods, left = std::floor(x), low = std::floor(y);
    auto wrapped = [&](double cell) { return int(cell - periods * std::floor(cell / periods)); };
    auto value = [&](int i, int j) { return white_noise(wrapped(left + i), wrapped(low + j), seed); };
    auto ease = [](double t) { return t * t * (3 - 2 * t); };
    const double s = ease(x - left), t = ease(y - low);
    return (1 - t) * ((1 - s) * value(0, 0) + s * value(1, 0)) + t * ((1 - s) * value(0, 1) + s * value(1, 1));
}

double fractal_noise(double u, double v, int periods, int octaves, std::uint32_t seed) {
    double sum = 0, weight = 0.5, total = 0;
    for (int k = 0; k < octaves; ++k, weight *= 0.5) {
        sum += weight * smooth_noise(u, v, periods << k, seed + std::uint32_t(k));
        total += weight;
    }
    return sum / total;
}

double fit_detail(std::int64_t triangles, double low, double high,
                  const std::function<void(Builder& builder, double detail)>& build) {
    auto count = [&](double detail) {
        Builder builder("", true);
        build(builder, detail);
        return builder.triangles();
    };
    for (int step = 0; step < 24; ++step) {
        const double middle = std::sqrt(low * high);
        (count(middle) <= triangles ? low : high) = middle;
    }
    return triangles - count(low) <= count(high) - triangles ? low : high;
}

Texture paint_masked(const std::string& name, int side, const std::function<glm::dvec4(double u, double v)>& colour) {
    Texture texture;
    texture.name = name;
    texture.texels = Image<std::uint32_t>(side, side);
    parallel_bands(side, 16, 0, [&](int first, int last) {
        for (int y = first; y < last; ++y)
            for (int x = 0; x < side; ++x) {
                const glm::dvec4 c = colour((x + 0.5) / side, (y + 0.5) / side);
                const double alpha = std::min(std::max(c.w, 0.0), 1.0);
                texture.texels(x, y) = encode_srgb(c.x) | encode_srgb(c.y) << 8 | encode_srgb(c.z) << 16 |
                                       std::uint32_t(std::floor(255 * alpha + 0.5)) << 24;
            }
    });
    return texture;
}

Texture paint(const std::string& name, int side, const std::function<glm::dvec3(double u, double v)>& colour) {
    return paint_masked(name, side, [&](double u, double v) { return glm::dvec4(colour(u, v), 1); });
}

}  // namespace plumb::io::scenes
