#include "gi/radiosity/surface_means.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"

namespace plumb::radiosity {
namespace {

constexpr int fewest_parts = 4, most_parts = 16;  // along an edge

struct Corners {
    glm::dvec2 uv[3];
};

Corners corners_of(const Geometry& g, std::size_t t) {
    Corners c;
    for (int k = 0; k < 3; ++k) {
        const Vertex& v = g.vertices[g.triangles[t][k]];
        c.uv[k] = {v.u, v.v};
    }
    return c;
}

// Texels under the triangle, of the larger of the material's textures.
double texels_of(const Scene& scene, const Material& m, const Corners& c) {
    double most = 0;
    for (int texture : {m.texture, m.emission_texture})
        if (texture >= 0) most = std::max(most, double(scene.textures[std::size_t(texture)].texels.size()));
    const glm::dvec2 a = c.uv[1] - c.uv[0], b = c.uv[2] - c.uv[0];
    return most * std::fabs(a.x * b.y - a.y * b.x) / 2;
}

int parts_for(double texels) {
    const double parts = std::ceil(std::sqrt(texels));
    return parts > fewest_parts ? int(std::min(parts, double(most_parts))) : fewest_parts;
}

class TriangleMean {
  public:
    TriangleMean(const raster::SurfaceArgs& surfaces, const Material& m, const float* row, std::size_t triangle,
                 const Corners& corners)
        : surfaces_(surfaces), material_(m), base_(int(row[8])), emission_(int(row[9])), triangle_(std::int32_t(triangle)),
          corners_(corners) {}

    // At (1 - a - b, a, b) of the corners.
    void add(double a, double b) {
        if (material_.alpha_cutoff > 0 && !raster::passes_alpha<float>(surfaces_, triangle_, {float(a), float(b)})) return;
        const double weight[3] = {1 - a - b, a, b};
        glm::dvec2 uv(0);
        for (int k = 0; k < 3; ++k) uv += weight[k] * corners_.uv[k];
        const glm::dvec3 rho = glm::dvec3(material_.reflectance) * read(base_, uv);
        const glm::dvec3 exitance = glm::dvec3(material_.emission) * read(emission_, uv);
        for (int k = 0; k < 3; ++k) {
            reflectance_[k] += weight[k] * rho, exitance_[k] += weight[k] * exitance;
            weights_[k] += weight[k];
        }
    }
    void take(int samples, CornerMean* means) const {
        for (int k = 0; k < 3; ++k) {
            means[k].share = weights_[k] / samples;
            if (!(weights_[k] > 0)) continue;
            means[k].reflectance = reflectance_[k] / weights_[k], means[k].exitance = exitance_[k] / weights_[k];
        }
    }

  private:
    glm::dvec3 read(int row, const glm::dvec2& uv) const {
        if (row == 0) return glm::dvec3(1);
        NoTap quiet;
        const auto c = raster::sample<float>(surfaces_.textures, row, {float(uv.x), float(uv.y)}, 0.0f, false, quiet);
        return {c.x, c.y, c.z};
    }

    const raster::SurfaceArgs& surfaces_;
    const Material& material_;
    int base_, emission_;  // rows of the textures
    std::int32_t triangle_;
    const Corners& corners_;
    glm::dvec3 reflectance_[3] = {}, exitance_[3] = {};
    double weights_[3] = {};
};

void mean_over(TriangleMean& mean, int parts, CornerMean* means) {
    for (int i = 0; i < parts; ++i)
        for (int j = 0; i + j < parts; ++j) {
            mean.add((i + 1.0 / 3) / parts, (j + 1.0 / 3) / parts);
            if (i + j + 1 < parts) mean.add((i + 2.0 / 3) / parts, (j + 2.0 / 3) / parts);
        }
    mean.take(parts * parts, means);
}

}  // namespace

std::vector<CornerMean> corner_means(const Scene& scene, const Geometry& g, const raster::Surfaces& surfaces,
                                     const RunOptions& options) {
    std::vector<CornerMean> means(3 * g.triangles.size());
    const raster::SurfaceArgs args = raster::surface_args(g, surfaces, View{});
    parallel_bands(int(g.triangles.size()), 1024, options, [&](int first, int last) {
        for (std::size_t t = std::size_t(first); t < std::size_t(last); ++t) {
            const Material& m = scene.materials[std::size_t(g.material[t])];
            CornerMean* const at = &means[3 * t];
            if (m.texture < 0 && m.emission_texture < 0 && !(m.alpha_cutoff > 0)) {
                for (int k = 0; k < 3; ++k) at[k].reflectance = m.reflectance, at[k].exitance = m.emission;
                continue;
            }
            const Corners corners = corners_of(g, t);
            TriangleMean mean(args, m, &surfaces.materials[record_stride * std::size_t(g.material[t])], t, corners);
            mean_over(mean, parts_for(texels_of(scene, m, corners)), at);
        }
    });
    return means;
}

}  // namespace plumb::radiosity
