// The z-buffer techniques: light at 256k vertices and at 1024^2 pixels, by instruction set, on one thread.
//
//     plumb_bench --benchmark_filter=zbuffer
#include <benchmark/benchmark.h>

#include <string>

#include "core/host_math.h"
#include "gi/zbuffer/zbuffer.h"
#include "tools/bench_stages/isa_stages.h"

namespace {

using namespace plumb;

constexpr int side = 1024, cells = 512;  // pixels; squares of the floor a side

// A floor of squares, a spot, a lamp and a sun; every pixel sees it.
struct Floor {
    zbuffer::VertexTable table;
    std::vector<Light> lights{3};
    Image4 position{side, side}, normal{side, side, glm::vec4(0, 1, 0, 1)}, albedo{side, side, glm::vec4(0.5f)}, emission{side, side};
    Image<glm::ivec2> id{side, side};
    zbuffer::VertexLight light;
    glm::vec3 eye{0, 2, 3};

    Floor() {
        for (int z = 0; z <= cells; ++z)
            for (int x = 0; x <= cells; ++x) {
                table.vertices.emplace_back(4.0f * float(x) / cells - 2, 0, 4.0f * float(z) / cells - 2, 0);
                table.vertices.emplace_back(0, 1, 0, 0);
                table.kinds.emplace_back(0, 0);
            }
        for (int z = 0; z < cells; ++z)
            for (int x = 0; x < cells; ++x) {
                const int a = z * (cells + 1) + x, b = a + cells + 1;
                table.corners.emplace_back(a, b, b + 1, 0), table.corners.emplace_back(a, b + 1, a + 1, 0);
            }
        table.materials = {glm::vec4(0.5f), glm::vec4(0.3f, 0.3f, 0.3f, 20)};
        table.objects = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
        lights[0].position = {0, 3, 0};
        lights[1].type = LightType::point, lights[1].position = {1, 1, 1};
        lights[2].type = LightType::directional;
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) {
                const double u = (x + 0.5) / side, v = (y + 0.5) / side;
                position(x, y) = glm::vec4(float(4 * u - 2), 0, float(4 * v - 2), 3);
                const double i = u * cells, j = v * cells;
                id(x, y) = {0, 2 * (int(j) * cells + int(i)) + (i - int(i) > j - int(j) ? 1 : 0)};
            }
        zbuffer::run({.technique = zbuffer::Technique::cads}, zbuffer::VerticesInputs{&table, &lights, eye}, {}, light);
    }
};

const Floor& floor_of() {
    static const Floor floor;
    return floor;
}

StageData data_at(const std::string& stage) {
    const Floor& f = floor_of();
    if (stage == "vertices") return data_of({.technique = zbuffer::Technique::cads}, zbuffer::VerticesInputs{&f.table, &f.lights, f.eye});
    if (stage == "interpolate")
        return data_of({.technique = zbuffer::Technique::cads},
                       zbuffer::InterpolateInputs{&f.position, &f.id, &f.emission, &f.table, &f.light, f.eye});
    return data_of(zbuffer::ZbufferParams{},
                   zbuffer::PixelsInputs{&f.position, &f.normal, &f.albedo, &f.emission, &f.id, &f.table, &f.lights, f.eye});
}

[[maybe_unused]] const bool registered = [] {
    bench::add_stages("zbuffer", {{"vertices", stage<zbuffer::VerticesKernel>}, {"interpolate", stage<zbuffer::InterpolateKernel>}, {"pixels", stage<zbuffer::PixelsKernel>}},
                      data_at);
    return true;
}();

}  // namespace
