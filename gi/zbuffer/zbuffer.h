// The z-buffer techniques of HEM 5.3 and 5.4: local illumination at vertices and at pixels. See README.md.
#pragma once

#include <vector>

#include "core/binding.h"
#include "core/scene.h"
#include "core/stage_description.h"
#include "gi/zbuffer/interpolate_kernel.h"
#include "gi/zbuffer/pixels_kernel.h"
#include "gi/zbuffer/vertex_table.h"
#include "gi/zbuffer/vertices_kernel.h"
#include "gi/zbuffer/zbuffer_params.h"

namespace plumb::zbuffer {

// ---- zbuffer.vertices ------------------------------------------------------------------------------------------------

struct VerticesInputs {
    using Kernel = VerticesKernel;
    const VertexTable* table = nullptr;
    const std::vector<Light>* lights = nullptr;
    glm::vec3 eye{0};  // m
};

template <class View>
std::size_t light_rows(const View& v) {
    return std::size_t(v.u.shade.lights) * sizeof(raster::LightArgs) / 16;
}

inline StageDescription<VerticesView> describe(VerticesKernel) {
    using View = VerticesView;
    ZbufferParams defaults;
    return {
        .name = "zbuffer.vertices",
        .source = "HEM 4.4, 5.3: ambient, diffuse and specular light at vertices; Phong 1975, Blinn 1977",
        .domain = "vertex, from its front and from its back",
        .inputs = {{.name = "vertices", .at = &View::vertices, .unit = "m", .meaning = "two vec4 a vertex: position; unit normal",
                    .count = [](const View& v) { return 2 * std::size_t(v.u.count); }, .why = "two a vertex"},
                   {.name = "kinds", .at = &View::kinds, .meaning = "material, object of each vertex",
                    .count = [](const View& v) { return std::size_t(v.u.count); }, .why = "one a vertex"},
                   {.name = "materials", .at = &View::materials, .meaning = "two vec4 a material: reflectance; specular colour, exponent",
                    .count = [](const View& v) { return 2 * std::size_t(v.u.shade.materials); }, .why = "two a material"},
                   {.name = "objects", .at = &View::objects, .meaning = "rows of M M^T and of M, M the world matrix of each object",
                    .count = [](const View& v) { return 6 * std::size_t(v.u.shade.objects); }, .why = "six an object"},
                   {.name = "lights", .at = &View::lights, .unit = "m, W/sr, W/m2", .meaning = "as direct has them",
                    .count = light_rows<View>, .why = "four vec4 a light"}},
        .outputs = {{.name = "diffuse", .at = &View::diffuse, .unit = "W/m2", .meaning = "irradiance of all vertices' fronts, then of their backs; w 1"},
                    {.name = "specular", .at = &View::specular, .unit = "W/m2", .meaning = "pi times the highlights' radiance, in the same order; w 1"}},
        .params = plumb::describe(fields(defaults)),
        .uniforms = {{"shade.lights", 0, 0x7fffffff}, {"shade.materials", 1, 1 << 24}, {"shade.objects", 1, 1 << 24}, {"count", 1, 1 << 24}},
        .cost = {8, "vertices x lights"},
    };
}
// Throws InputError where an input is missing, or there are more than 2^24 vertices.
StageData data_of(const ZbufferParams& params, const VerticesInputs& in);

struct VertexLight {
    Image4 diffuse, specular;
};
void run(const ZbufferParams& params, const VerticesInputs& in, const RunOptions& options, VertexLight& out);

// ---- zbuffer.interpolate ---------------------------------------------------------------------------------------------

// What pixels send, to be composed (gi/compose): E and, beside rho E / pi, `sent` / pi.
struct PixelLight {
    Image4 irradiance, sent;  // W/m2
};

struct InterpolateInputs {
    using Kernel = InterpolateKernel;
    const Image4* position = nullptr;        // xyz m
    const Image<glm::ivec2>* id = nullptr;   // object, triangle; -1, -1: nothing
    const Image4* emission = nullptr;        // W/m2
    const VertexTable* table = nullptr;
    const VertexLight* light = nullptr;      // of zbuffer.vertices
    glm::vec3 eye{0};                        // m
};

template <class View>
std::size_t pixels_of(const View& v) {
    return std::size_t(v.u.width) * std::size_t(v.u.height);
}
template <class View>
glm::ivec2 vertex_light_size(const View& v) {
    return {v.u.row, (2 * v.u.vertices + v.u.row - 1) / v.u.row};
}

inline StageDescription<InterpolateView> describe(InterpolateKernel) {
    using View = InterpolateView;
    return {
        .name = "zbuffer.interpolate",
        .source = "HEM 5.3: Gouraud's interpolation of what vertices are lit by",
        .domain = "pixel",
        .inputs = {{.name = "position", .at = &View::position, .unit = "m", .meaning = "world-space position; w unused", .fixed = 8},
                   {.name = "id", .at = &View::id, .meaning = "object, triangle; -1, -1 where nothing is", .count = pixels_of<View>, .why = "one a pixel"},
                   {.name = "emission", .at = &View::emission, .unit = "W/m2", .meaning = "radiant exitance M"},
                   {.name = "corners", .at = &View::corners, .meaning = "[triangle] its vertices; w unused",
                    .count = [](const View& v) { return std::size_t(v.u.triangles); }, .why = "one a triangle"},
                   {.name = "vertices", .at = &View::vertices, .unit = "m", .meaning = "two vec4 a vertex: position; unit normal",
                    .count = [](const View& v) { return 2 * std::size_t(v.u.vertices); }, .why = "two a vertex"},
                   {.name = "vertex_diffuse", .at = &View::diffuse, .unit = "W/m2", .meaning = "of zbuffer.vertices; w unused", .fixed = 8,
                    .size = vertex_light_size<View>, .why = "all vertices' fronts and backs"},
                   {.name = "vertex_specular", .at = &View::specular, .unit = "W/m2", .meaning = "of zbuffer.vertices; w unused", .fixed = 8,
                    .size = vertex_light_size<View>, .why = "all vertices' fronts and backs"}},
        .outputs = {{.name = "irradiance", .at = &View::irradiance, .unit = "W/m2", .meaning = "of ambient and diffuse light; w 0"},
                    {.name = "sent", .at = &View::sent, .unit = "W/m2", .meaning = "emission and pi times highlights; w 0"}},
        .uniforms = {{"triangles", 1, 1 << 29}, {"vertices", 1, 1 << 24}, {"row", 1, 32767}, {"emits", 0, 1}},
        .cost = {5, "pixels"},
    };
}
StageData data_of(const ZbufferParams& params, const InterpolateInputs& in);
void run(const ZbufferParams& params, const InterpolateInputs& in, const RunOptions& options, PixelLight& out);

// ---- zbuffer.pixels --------------------------------------------------------------------------------------------------

struct PixelsInputs {
    using Kernel = PixelsKernel;
    const Image4* position = nullptr;        // xyz m
    const Image4* normal = nullptr;          // xyz unit
    const Image4* albedo = nullptr;          // C_m
    const Image4* emission = nullptr;        // W/m2
    const Image<glm::ivec2>* id = nullptr;   // object, triangle; -1, -1: nothing
    const VertexTable* table = nullptr;
    const std::vector<Light>* lights = nullptr;
    glm::vec3 eye{0};                        // m
};

inline StageDescription<PixelsView> describe(PixelsKernel) {
    using View = PixelsView;
    ZbufferParams defaults;
    return {
        .name = "zbuffer.pixels",
        .source = "HEM 4.4, 5.4: ambient, diffuse and specular light at pixels; Phong 1975, Blinn 1977",
        .domain = "pixel",
        .inputs = {{.name = "position", .at = &View::position, .unit = "m", .meaning = "world-space position; w unused", .fixed = 8},
                   {.name = "normal", .at = &View::normal, .meaning = "unit normal; w unused", .fixed = 8},
                   {.name = "albedo", .at = &View::albedo, .meaning = "diffuse reflectance; w unused", .fixed = 8},
                   {.name = "emission", .at = &View::emission, .unit = "W/m2", .meaning = "radiant exitance M"},
                   {.name = "id", .at = &View::id, .meaning = "object, triangle; -1, -1 where nothing is", .count = pixels_of<View>, .why = "one a pixel"},
                   {.name = "corners", .at = &View::corners, .meaning = "[triangle] its vertices; w unused",
                    .count = [](const View& v) { return std::size_t(v.u.triangles); }, .why = "one a triangle"},
                   {.name = "vertices", .at = &View::vertices, .unit = "m", .meaning = "two vec4 a vertex: position; unit normal",
                    .count = [](const View& v) { return 2 * std::size_t(v.u.vertices); }, .why = "two a vertex"},
                   {.name = "kinds", .at = &View::kinds, .meaning = "material, object of each vertex",
                    .count = [](const View& v) { return std::size_t(v.u.vertices); }, .why = "one a vertex"},
                   {.name = "materials", .at = &View::materials, .meaning = "two vec4 a material: reflectance; specular colour, exponent",
                    .count = [](const View& v) { return 2 * std::size_t(v.u.shade.materials); }, .why = "two a material"},
                   {.name = "objects", .at = &View::objects, .meaning = "rows of M M^T and of M, M the world matrix of each object",
                    .count = [](const View& v) { return 6 * std::size_t(v.u.shade.objects); }, .why = "six an object"},
                   {.name = "lights", .at = &View::lights, .unit = "m, W/sr, W/m2", .meaning = "as direct has them",
                    .count = light_rows<View>, .why = "four vec4 a light"}},
        .outputs = {{.name = "irradiance", .at = &View::irradiance, .unit = "W/m2", .meaning = "of ambient and diffuse light; w 0"},
                    {.name = "sent", .at = &View::sent, .unit = "W/m2", .meaning = "emission and pi times highlights; w 0"}},
        .params = plumb::describe(fields(defaults)),
        .uniforms = {{"shade.lights", 0, 0x7fffffff}, {"shade.materials", 1, 1 << 24}, {"shade.objects", 1, 1 << 24},
                     {"triangles", 1, 1 << 29}, {"vertices", 1, 1 << 24}, {"normal", 0, 2}, {"emits", 0, 1}},
        .cost = {20, "pixels x (1 + lights)"},
    };
}
StageData data_of(const ZbufferParams& params, const PixelsInputs& in);
void run(const ZbufferParams& params, const PixelsInputs& in, const RunOptions& options, PixelLight& out);

}  // namespace plumb::zbuffer
