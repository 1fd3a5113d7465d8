// Hemicube radiosity: what hemicubes of 64 see, rows of form factors, their sums, and irradiance at 1024^2 pixels, by instruction
// set, on one thread.
//
//     plumb_bench --benchmark_filter=radiosity
#include <benchmark/benchmark.h>

#include <string>

#include "gi/radiosity/elements.h"
#include "gi/radiosity/gather.h"
#include "gi/radiosity/items.h"
#include "gi/radiosity/lookup.h"
#include "gi/radiosity/reduce.h"
#include "gi/radiosity/rows.h"
#include "io/scenes/generate.h"
#include "tools/bench_stages/isa_stages.h"

namespace {

using namespace plumb;

constexpr int side = 1024, hemicube = 64, hemicubes = 16;

// HEM 5.8's box of 4,800 triangles and 2,734 vertices.
struct Box {
    radiosity::Elements elements;
    radiosity::FormFactors factors;
    radiosity::TriangleElements triangles;
    Buffer<glm::vec4> vertices, eyes, own, leaving, irradiance, drawn;
    Buffer<glm::ivec4> corners;
    Buffer<float> planes, weights;
    Image4 position{side, side};
    Image<glm::ivec2> id{side, side};

    Box() {
        radiosity::ElementParams p;
        p.of_file = true, p.inset = false;
        io::GenerateOptions options;
        options.triangles = 4800;
        elements = radiosity::elements_of(io::generate_scene("hemicube_box", options, "bench"), p);
        factors = radiosity::form_factors(elements, {hemicube, radiosity::Weights::exact}, {});
        triangles = radiosity::triangle_elements(elements);
        const auto n = std::size_t(elements.count());
        own.assign(n, glm::vec4(1)), leaving.assign(n, glm::vec4(2, 1, 0.5f, 0));
        planes = radiosity::planes_of(leaving);
        radiosity::gather(factors, own, leaving, {}, irradiance);
        for (const Vertex& v : elements.geometry.vertices) vertices.push_back(glm::vec4(v.position, 0));
        for (const glm::uvec3& t : elements.geometry.triangles) corners.push_back(glm::ivec4(glm::ivec3(t), 0));
        Buffer<glm::vec4> eye, normal;
        for (std::size_t k = 0; k < hemicubes; ++k) {
            eye.push_back(elements.eye[k * n / hemicubes]), normal.push_back(elements.normal[k * n / hemicubes]);
        }
        eyes = radiosity::eyes_of(eye, normal);
        drawn.assign(std::size_t(hemicubes * 3 * hemicube * hemicube), glm::vec4(2, 1, 0.5f, 1));
        for (const double w : radiosity::texel_weights(hemicube, radiosity::Weights::exact)) weights.push_back(float(w));
        // Pixels side by side see the same triangle, as in a picture.
        const int count = int(corners.size());
        for (int y = 0; y < side; ++y)
            for (int x = 0; x < side; ++x) {
                const int t = (y / 8 * (side / 8) + x / 8) % count;
                const glm::vec4* c = &triangles.corners[3 * std::size_t(t)];
                const float b = (float(x % 8) + 0.5f) / 16, g = (float(y % 8) + 0.5f) / 16;
                position(x, y) = c[0] + b * (c[1] - c[0]) + g * (c[2] - c[0]);
                id(x, y) = {0, t};
            }
    }
};

const Box& box() {
    static const Box b;
    return b;
}

StageData data_at(const std::string& stage) {
    const Box& b = box();
    if (stage == "items") return data_of(radiosity::ItemsInputs{&b.vertices, &b.corners, &b.eyes, hemicube}, 0, hemicubes);
    if (stage == "lookup") return data_of(radiosity::LookupInputs{&b.position, &b.id, &b.triangles, &b.irradiance});
    if (stage == "reduce") return data_of(radiosity::ReduceInputs{&b.drawn, hemicube, 3 * hemicube, &b.weights});
    radiosity::GatherInputs in{&b.factors.blocks[0], &b.own, &b.leaving, &b.planes};
    return data_of(in);
}

[[maybe_unused]] const bool registered = [] {
    bench::add_stages("radiosity", {{"items", stage<radiosity::ItemsKernel>}, {"gather", stage<radiosity::GatherKernel>}, {"lookup", stage<radiosity::LookupKernel>}, {"reduce", stage<radiosity::ReduceKernel>}},
                      data_at);
    for (const Isa isa : supported_isas()) {
        RunOptions options;
        options.isa = isa, options.threads = 1;
        benchmark::RegisterBenchmark((std::string("radiosity.rows/") + isa_name(isa)).c_str(), [options](benchmark::State& state) {
            // Rows of 256 of its elements, each of all.
            radiosity::Elements some = box().elements;
            for (auto* list : {&some.position, &some.normal, &some.eye}) list->resize(radiosity::rows_of_block);
            for (glm::uvec3& of : some.of) of = {of.x % 256, of.y % 256, of.z % 256};
            for (auto _ : state) benchmark::DoNotOptimize(radiosity::form_factors(some, {hemicube, radiosity::Weights::exact}, options).count);
        })->Unit(benchmark::kMillisecond)->UseRealTime()->MinTime(0.2);
    }
    return true;
}();

}  // namespace
