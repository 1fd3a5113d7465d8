#include "io/scenes/builder.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/hash.h"
#include "core/host_math.h"

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

// Sine and cosine, exact at multiples of a right angle.
glm::dvec2 sin_cos(double degrees) {
    const double turn = degrees - 360 * std::floor(degrees / 360);
    if (turn == 0) return {0, 1};
    if (turn == 90) return {1, 0};
    if (turn == 180) return {0, -1};
    if (turn == 270) return {-1, 0};
    const double radians = turn * (host::pi / 180);
    return {host::sin(radians), host::cos(radians)};
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
    const glm::dvec2 sc = sin_cos(degrees);
    Place m(1);
    m[0][0] = m[2][2] = sc.y;
    m[2][0] = sc.x;
    m[0][2] = -sc.x;
    return m;
}

Place scale(const Point& by) {
    Place m(1);
    for (int axis = 0; axis < 3; ++axis) m[axis][axis] = by[axis];
    return m;
}

Builder::Builder(std::string scene_name) { scene_.name = std::move(scene_name); }

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
    if (scene_.meshes.empty()) object(scene_.name);
    const int stride = g.columns + 1;
    const Mapping mapping(place);
    std::vector<Point>&points = points_, &normals = normals_;
    points.resize(std::size_t(stride) * (g.rows + 1));
    for (int j = 0; j <= g.rows; ++j)
        for (int i = 0; i <= g.columns; ++i)
            points[std::size_t(j) * stride + i] = patch(double(i) / g.columns, double(j) / g.rows);
    auto at = [&](int i, int j) -> const Point& { return points[std::size_t(j) * stride + i]; };
    auto u_of = [&](int i) { return g.texture.x * i / g.columns; };
    auto v_of = [&](int j) { return g.texture.y * j / g.rows; };

    if (!g.smooth) {
        for (int j = 0; j < g.rows; ++j)
            for (int i = 0; i < g.columns; ++i) {
                const Point n = cross(at(i + 1, j + 1) - at(i, j), at(i, j + 1) - at(i + 1, j));
                const std::uint32_t a = vertex(mapping, at(i, j), n, u_of(i), v_of(j));
                const std::uint32_t b = vertex(mapping, at(i + 1, j), n, u_of(i + 1), v_of(j));
                const std::uint32_t c = vertex(mapping, at(i + 1, j + 1), n, u_of(i + 1), v_of(j + 1));
                const std::uint32_t d = vertex(mapping, at(i, j + 1), n, u_of(i), v_of(j + 1));
                face(material, mapping, a, b, c);
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
        for (int i = 0; i <= g.columns; ++i)
            vertex(mapping, at(i, j), normals[std::size_t(j) * stride + i], u_of(i), v_of(j));
    for (int j = 0; j < g.rows; ++j)
        for (int i = 0; i < g.columns; ++i) {
            const std::uint32_t a = first + std::uint32_t(j * stride + i), b = a + 1, d = a + std::uint32_t(stride);
            face(material, mapping, a, b, d + 1);
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
    if (scene_.meshes.empty()) object(scene_.name);
    const Mapping mapping(place);
    const int stride = int(across.size()), rows = int(up.size());
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

void Builder::lathe(int material, const Place& place, const std::vector<glm::dvec2>& profile, int segments,
                    double texture_size, double crease_deg) {
    // Cut the profile where it bends sharply; each stretch is a smooth grid of its own.
    const double crease = sin_cos(crease_deg).y;
    std::size_t first = 0;
    for (std::size_t i = 1; i < profile.size(); ++i) {
        bool sharp = i + 1 == profile.size();
        if (!sharp) {
            const glm::dvec2 a = profile[i] - profile[i - 1], b = profile[i + 1] - profile[i];
            sharp = a.x * b.x + a.y * b.y < crease * std::sqrt((a.x * a.x + a.y * a.y) * (b.x * b.x + b.y * b.y));
        }
        if (!sharp) continue;
        double length = 0, widest = 0;
        for (std::size_t k = first; k <= i; ++k) {
            if (k > first) length += std::sqrt(glm::dot(profile[k] - profile[k - 1], profile[k] - profile[k - 1]));
            widest = std::max(widest, profile[k].x);
        }
        Grid g;
        g.columns = segments, g.rows = int(i - first);
        g.texture = {std::max(1.0, std::floor(2 * host::pi * widest / texture_size + 0.5)), length / texture_size};
        g.closed_u = true;
        grid(material, place, g, [&](double u, double v) {
            const glm::dvec2 p = profile[first + std::size_t(v * g.rows + 0.5)], sc = sin_cos(360 * u);
            return Point(p.x * sc.x, p.y, p.x * sc.y);
        });
        first = i;
    }
}

void Builder::triangle(int material, const Place& place, const Point& a, const Point& b, const Point& c) {
    if (scene_.meshes.empty()) object(scene_.name);
    const Mapping mapping(place);
    const Point n = cross(b - a, c - a);
    const std::uint32_t i = vertex(mapping, a, n, 0, 0), j = vertex(mapping, b, n, 1, 0), k = vertex(mapping, c, n, 0, 1);
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

Texture paint(const std::string& name, int side, const std::function<glm::dvec3(double u, double v)>& colour) {
    Texture texture;
    texture.name = name;
    texture.texels = Image<std::uint32_t>(side, side);
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            const glm::dvec3 c = colour((x + 0.5) / side, (y + 0.5) / side);
            std::uint32_t texel = 0xff000000u;
            for (int k = 0; k < 3; ++k) texel |= encode_srgb(c[k]) << (8 * k);
            texture.texels(x, y) = texel;
        }
    return texture;
}

}  // namespace plumb::io::scenes
