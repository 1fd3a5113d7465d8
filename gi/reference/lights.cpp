#include "gi/reference/lights.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/reference/light_kernel.h"
#include "raster/light_view.h"

namespace plumb::reference {

namespace {

constexpr double steps_of_u = 0x1p24;  // values that a random number takes

double sum(const glm::dvec3& v) { return v.x + v.y + v.z; }

// The mean of a texture's texels, linear; alpha is left aside.
glm::dvec3 mean_of(const raster::Surfaces& s, int row) {
    const std::int32_t* t = s.textures.data() + 4 * std::size_t(row);
    const std::size_t first = std::size_t(t[0]), count = std::size_t(t[1]) * std::size_t(t[2]);
    const float* decode = s.decode.data() + (t[3] & raster::flag_srgb ? 256 : 0);
    glm::dvec3 total(0);
    for (std::size_t i = first; i < first + count; ++i)
        for (int c = 0; c < 3; ++c) total[c] += decode[(std::uint32_t(s.texels[i]) >> (8 * c)) & 255];
    return total / double(count);
}

struct Builder {
    LightTable table;
    std::vector<double> power;        // W, summed over the channels
    std::vector<std::size_t> source;  // of each light: index into source_power
    std::vector<double> source_power;

    // Lights that follow belong to a new source: a lamp, an object that emits, the environment.
    void begin_source() { source_power.push_back(0); }

    void add(LightKind kind, const glm::vec3& a, float aw, const glm::vec3& b, float bw, const glm::vec3& c, double p,
             float inverse_radius2 = 0) {
        if (!(p > 0)) return;
        source.push_back(source_power.size() - 1);
        source_power.back() += p;
        table.rows.insert(table.rows.end(),
                          {a.x, a.y, a.z, aw, b.x, b.y, b.z, bw, c.x, c.y, c.z, float(int(kind)),
                           inverse_radius2, 0, 0, 0});
        power.push_back(p);
        table.any_radius = table.any_radius || inverse_radius2 > 0;
    }

    void add_lamp(const Light& light, double radius) {
        begin_source();
        const raster::LightArgs l = raster::light_args(light);
        const glm::vec3 axis(l.direction[0], l.direction[1], l.direction[2]);
        const double strength = sum(light.intensity);
        if (light.type == LightType::directional) {
            // Where the scene has no extent, any positive weight will do.
            const double disc = host::pi * std::max(radius * radius, 1e-30);
            return add(LightKind::directional, glm::vec3(0), 0, axis, 0, light.intensity, strength * disc);
        }
        // Half of the falloff's ring counts.
        double solid_angle = 4 * host::pi;
        if (light.type == LightType::spot) {
            const double inner = host::cos(light.cone_inner_deg * (host::pi / 180));
            const double outer = host::cos(light.cone_outer_deg * (host::pi / 180));
            solid_angle = std::max(2 * host::pi * (1 - (inner + outer) / 2), 1e-6);
        }
        // Of a lamp that ends, the most that a sphere around it receives.
        const double reach = light.radius > 0 ? double(l.radius2) / 4 : 1;
        add(LightKind::lamp, light.position, l.cos_outer, axis, l.falloff_scale, light.intensity,
            strength * solid_angle * reach, l.inverse_radius2);
    }

    void add_triangle(const Geometry& geometry, std::size_t t, const glm::dvec3& exitance) {
        const glm::uvec3 v = geometry.triangles[t];
        const glm::dvec3 a(geometry.vertices[v.x].position);
        const glm::dvec3 e1 = glm::dvec3(geometry.vertices[v.y].position) - a,
                         e2 = glm::dvec3(geometry.vertices[v.z].position) - a;
        const glm::dvec3 n(e1.y * e2.z - e1.z * e2.y, e1.z * e2.x - e1.x * e2.z, e1.x * e2.y - e1.y * e2.x);
        const double area = std::sqrt(n.x * n.x + n.y * n.y + n.z * n.z) / 2;
        float index;
        const std::uint32_t bits = std::uint32_t(t);
        std::memcpy(&index, &bits, 4);
        // Both sides emit. Positive areas that a float cannot invert are as good as none.
        if (!(area > 1e-37) || !(area < 1e37)) return;
        const std::size_t before = power.size();
        add(LightKind::triangle, glm::vec3(a), index, glm::vec3(e1), 0, glm::vec3(e2), 2 * area * sum(exitance));
        if (power.size() == before) return;
        table.triangle_pdf[t] = float(1 / area);
        table.any_triangle = true;
    }

    // Probabilities in whole steps of u, at least one each, so that what is chosen and what is computed with agree.
    void finish() {
        const std::size_t n = power.size();
        if (double(n) > steps_of_u / 2)
            throw InputError(fmt::format("reference: {} lights and emitting triangles: expected at most {}", n,
                                         std::size_t(steps_of_u / 2)));
        table.count = int(n);
        table.cdf.assign(n + 1, 0.0f);
        double total = 0, shares = 0, so_far = 0;
        std::size_t sources = 0;
        for (const double p : source_power) total += p, sources += p > 0;
        if (!(total < 1e300)) throw InputError("reference: the power of all lights is not finite");
        // Half by power, half evenly over the sources: the sun is stronger than any lamp, but may not reach the room.
        auto share = [&](std::size_t i) {
            return power[i] / total + power[i] / (source_power[source[i]] * double(sources));
        };
        for (std::size_t i = 0; i < n; ++i) shares += share(i);
        double last = 0;
        for (std::size_t i = 0; i < n; ++i) {
            so_far += share(i);
            const double wanted = std::floor(so_far / shares * steps_of_u + 0.5);
            last = std::clamp(wanted, last + 1, steps_of_u - double(n - 1 - i));
            table.cdf[i + 1] = float(last / steps_of_u);
        }
        for (std::size_t i = 0; i < n; ++i) {
            const float probability = table.cdf[i + 1] - table.cdf[i];
            const float* row = table.rows.data() + 16 * i;
            const auto kind = LightKind(int(row[11]));
            if (kind == LightKind::environment) table.environment_probability = probability;
            if (kind != LightKind::triangle) continue;
            std::uint32_t t;
            std::memcpy(&t, row + 3, 4);
            table.triangle_pdf[t] *= probability;
        }
    }
};

}  // namespace

LightTable light_table(const Scene& scene, const Geometry& geometry, const raster::Surfaces& surfaces,
                       const EnvironmentTable& environment) {
    glm::vec3 low(0), high(0);
    bounds(geometry, low, high);
    const glm::dvec3 diagonal = glm::dvec3(high) - glm::dvec3(low);
    const double radius = std::sqrt(diagonal.x * diagonal.x + diagonal.y * diagonal.y + diagonal.z * diagonal.z) / 2;

    Builder b;
    for (const Light& light : scene.lights)
        if (light.on) b.add_lamp(light, radius);
    b.table.lamps = int(b.power.size());
    std::vector<glm::dvec3> exitance;
    bool any = false;
    for (std::size_t m = 0; m < scene.materials.size(); ++m) {
        const int row = int(surfaces.materials[16 * m + 9]);
        const glm::dvec3 texture = row > 0 ? mean_of(surfaces, row) : glm::dvec3(1);
        exitance.push_back(glm::dvec3(scene.materials[m].emission) * texture);
        any = any || sum(exitance.back()) > 0;
    }
    b.table.triangle_pdf.assign(any ? geometry.triangles.size() : 1, 0.0f);
    for (std::size_t t = 0; any && t < geometry.triangles.size(); ++t) {
        if (t == 0 || geometry.object[t] != geometry.object[t - 1]) b.begin_source();
        b.add_triangle(geometry, t, exitance[std::size_t(geometry.material[t])]);
    }
    b.begin_source();
    const double sphere = 4 * host::pi * std::max(radius * radius, 1e-30);
    b.add(LightKind::environment, glm::vec3(0), 0, glm::vec3(0), 0, glm::vec3(0),
          3 * environment.mean_radiance * host::pi * sphere);
    b.finish();
    return std::move(b.table);
}

}  // namespace plumb::reference
