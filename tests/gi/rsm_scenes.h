// Hand-made reflective shadow maps whose gathered irradiance has a closed form.
#pragma once

#include <cmath>

#include "gi/rsm/gather.h"

namespace plumb::test {

inline void set_texel(raster::Rsm& rsm, int x, int y, glm::vec3 position, glm::vec3 normal, glm::vec3 flux) {
    float* r = rsm.records.data() + record_stride * (std::size_t(y) * rsm.size + x);
    for (int c = 0; c < 3; ++c) r[c] = position[c], r[4 + c] = normal[c], r[8 + c] = flux[c];
    r[7] = 1;  // there is a surface
}

inline raster::Rsm empty_map(int size) {
    raster::Rsm rsm;
    rsm.size = size;
    rsm.half = false;
    rsm.records.assign(std::size_t(record_stride) * size * size, 0.0f);
    return rsm;
}

// A map that looks along -z at the square [-1, 1]^2 of the plane z = 0: texel (i, j) is centred at x = (2 i + 1) / n - 1,
// y = 1 - (2 j + 1) / n (rows go down). Its texels reflect the flux radiosity(x, y) * area into +z.
template <class Radiosity>
raster::Rsm plane_map(int n, Radiosity radiosity) {
    raster::Rsm rsm = empty_map(n);
    rsm.view.orthographic = true;
    rsm.view.view_to_clip = glm::dmat4(1);
    rsm.view.view_to_clip[1][1] = -1;
    const double area = 4.0 / n / n;
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            const double x = (2 * i + 1.0) / n - 1, y = 1 - (2 * j + 1.0) / n;
            set_texel(rsm, i, j, glm::vec3(x, y, 0), {0, 0, 1}, glm::vec3(float(radiosity(x, y) * area)));
        }
    return rsm;
}

// One shading point, or a few.
struct Points {
    Image4 position, normal;
    Points(int width, int height) : position(width, height), normal(width, height) {}
    Points(glm::vec3 x, glm::vec3 n) : Points(1, 1) { position(0, 0) = glm::vec4(x, 0), normal(0, 0) = glm::vec4(n, 1); }
};

inline Image4 gather(const rsm::GatherParams& params, const Points& points, const raster::Rsm& map,
                     const rsm::Pattern* pattern = nullptr, RunOptions options = {}) {
    Image4 irradiance;
    rsm::run(params, {&points.position, &points.normal, &map, pattern, 1}, options, irradiance);
    return irradiance;
}

}  // namespace plumb::test
