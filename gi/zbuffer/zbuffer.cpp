#include "gi/zbuffer/zbuffer.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.h"
#include "core/host_math.h"
#include "gi/run_two.h"
#include "raster/light_view.h"

namespace plumb::zbuffer {

namespace {

constexpr int row = 1024, most_vertices = 1 << 24;

const VertexTable& table_of(const char* stage, const VertexTable* table) {
    if (!table) throw InputError(fmt::format("{}: the vertex table must be bound", stage));
    if (table->kinds.size() > std::size_t(most_vertices))
        throw InputError(fmt::format("{}: {} vertices: expected at most {}", stage, table->kinds.size(), most_vertices));
    return *table;
}

int at_least_one(std::size_t n) { return int(std::max<std::size_t>(n, 1)); }

glm::ivec2 vertex_items(const VertexTable& t) {
    const int items = 2 * at_least_one(t.kinds.size());
    return {std::min(items, row), (items + row - 1) / row};
}

ShadeUniforms shade_of(const ZbufferParams& p, const VertexTable& t, const std::vector<Light>* lights, const glm::vec3& eye) {
    const bool lit = lights && (has_diffuse(p.technique) || has_specular(p.technique));
    const glm::vec3 ambient = float(host::pi) * (has_ambient(p.technique) ? p.ambient : glm::vec3(1));
    return {lit ? std::int32_t(lights->size()) : 0, has_diffuse(p.technique), has_specular(p.technique), p.lobe == Lobe::blinn,
            p.variant == Variant::published, saturates(p), at_least_one(t.materials.size() / 2), at_least_one(t.objects.size() / 6),
            {ambient.x, ambient.y, ambient.z, 0}, {eye.x, eye.y, eye.z, 0}};
}

// A device binds no empty buffer: of nothing there is one that is not read.
template <class T>
void lend_list(StageData& d, const char* name, std::size_t count, int channels, const T* data) {
    static const glm::vec4 nothing[6] = {};
    const std::int64_t rows = std::int64_t(count);
    if (rows > 0) return void(lend(d.inputs, name, {rows, channels}, data));
    lend(d.inputs, name, {6, channels}, reinterpret_cast<const T*>(nothing));
}
void lend_vertices(StageData& d, const VertexTable& t) {
    lend_list(d, "vertices", t.vertices.size(), 4, t.vertices.empty() ? nullptr : &t.vertices[0].x);
}
void lend_corners(StageData& d, const VertexTable& t) {
    lend_list(d, "corners", t.corners.size(), 4, t.corners.empty() ? nullptr : &t.corners[0].x);
}
void lend_kinds(StageData& d, const VertexTable& t) {
    lend_list(d, "kinds", t.kinds.size(), 2, t.kinds.empty() ? nullptr : &t.kinds[0].x);
    lend_list(d, "materials", t.materials.size(), 4, t.materials.empty() ? nullptr : &t.materials[0].x);
    lend_list(d, "objects", t.objects.size(), 4, t.objects.empty() ? nullptr : &t.objects[0].x);
}
void add_lights(StageData& d, const std::vector<Light>* lights) {
    std::vector<raster::LightArgs> args;
    if (lights)
        for (const Light& light : *lights) args.push_back(raster::light_args(light));
    args.resize(std::max<std::size_t>(args.size(), 1));
    add(d.inputs, "lights", {std::int64_t(args.size()) * 4, 4}, args[0].position);
}

void lend_id(StageData& d, const Image<glm::ivec2>* id) {
    if (!id) throw InputError(fmt::format("{}: id must be bound", d.stage));
    lend(d.inputs, "id", {std::int64_t(id->size()), 2}, &id->data()->x);
}

}  // namespace

std::vector<Field> fields(ZbufferParams& p) {
    return {
        {"technique", as_int(p.technique), "", "HEM 5.3, 5.4: C colour, A ambient, D diffuse, S specular; (P): per pixel, else per vertex", 0, 6,
         {"C", "CA", "CAD", "CAS", "CADS", "CAS(P)", "CADS(P)"}, false, {SweepRange::Role::curves, {2, 4, 6}, "", ""}},
        {"lobe", as_int(p.lobe), "", "of highlights: about the mirrored vector (HEM 4.4.5), or the half vector (Blinn 1977)", 0, 1,
         {"phong", "blinn"}, false},
        {"variant", as_int(p.variant), "", "corrected, or the listings as printed: mirrored vector of the light's way, normals and light by the world matrix, "
         "view interpolated from unit vectors; saturated, without emission", 0, 1, {"corrected", "published"}, false},
        {"range", as_int(p.range), "", "hdr, or colours that end at 1 before they are interpolated, as the listings have it; published always does", 0, 1,
         {"hdr", "saturate"}, false},
        {"renormalise", &p.renormalise, "", "per pixel: normals are made unit again; false: as they are interpolated (HEM figure 5.2)", -unbounded, unbounded, {}, false},
        {"ambient", &p.ambient, "W/(m2 sr)", "radiance from everywhere, C_a of HEM (4.10); 0.2 is ours", 0, 1e20, {}, false},
        {"normals", &p.normals, "", "whether the picture is made again with the vertices' normals over it (HEM plate C.8)", -unbounded, unbounded, {}, false},
        {"normal_length", &p.normal_length, "", "of those lines, of the diagonal of the scene's bounds", 1e-6, 1, {}, false},
    };
}

void validate(const ZbufferParams& params) {
    ZbufferParams copy = params;
    validate_fields("zbuffer", fields(copy));
    if (params.variant == Variant::published && params.lobe == Lobe::blinn)
        throw InputError("zbuffer: lobe = blinn with variant = published: HEM prints no listing for it: expected lobe = phong");
    if (params.variant == Variant::published && !params.renormalise)
        throw InputError("zbuffer: renormalise = false with variant = published: HEM's listings make normals unit again: expected true");
}

StageData data_of(const ZbufferParams& params, const VerticesInputs& in) {
    validate(params);
    const VertexTable& t = table_of("zbuffer.vertices", in.table);
    const glm::ivec2 size = vertex_items(t);
    StageData d = begin_data<VerticesKernel>(
        size, VerticesUniforms{shade_of(params, t, in.lights, in.eye), size.x, size.y, at_least_one(t.kinds.size()), 0});
    lend_vertices(d, t), lend_kinds(d, t), add_lights(d, in.lights);
    return d;
}

StageData data_of(const ZbufferParams& params, const InterpolateInputs& in) {
    validate(params);
    const Image4& position = bound("zbuffer.interpolate", "position", in.position);
    const VertexTable& t = table_of("zbuffer.interpolate", in.table);
    if (!in.light) throw InputError("zbuffer.interpolate: the vertices' light must be bound");
    InterpolateUniforms u{position.width, position.height, at_least_one(t.corners.size()), at_least_one(t.kinds.size()), vertex_items(t).x,
                          params.variant == Variant::corrected, {}, {in.eye.x, in.eye.y, in.eye.z, 0}};
    StageData d = begin_data<InterpolateKernel>(size_of(position), u);
    lend(d, {{"position", in.position}, {"emission", in.emission}, {"vertex_diffuse", &in.light->diffuse}, {"vertex_specular", &in.light->specular}});
    lend_id(d, in.id), lend_corners(d, t), lend_vertices(d, t);
    return d;
}

StageData data_of(const ZbufferParams& params, const PixelsInputs& in) {
    validate(params);
    const Image4& position = bound("zbuffer.pixels", "position", in.position);
    const VertexTable& t = table_of("zbuffer.pixels", in.table);
    const PixelNormal normal = params.variant == Variant::published ? PixelNormal::renormalised
                               : params.renormalise                 ? PixelNormal::of_gbuffer
                                                                    : PixelNormal::interpolated;
    PixelsUniforms u{shade_of(params, t, in.lights, in.eye), position.width, position.height, at_least_one(t.corners.size()),
                     at_least_one(t.kinds.size()), std::int32_t(normal), params.variant == Variant::corrected, {}};
    StageData d = begin_data<PixelsKernel>(size_of(position), u);
    lend(d, {{"position", in.position}, {"normal", in.normal}, {"albedo", in.albedo}, {"emission", in.emission}});
    lend_id(d, in.id), lend_corners(d, t), lend_vertices(d, t), lend_kinds(d, t), add_lights(d, in.lights);
    return d;
}

void run(const ZbufferParams& params, const VerticesInputs& in, const RunOptions& options, VertexLight& out) {
    run_two(stage<VerticesKernel>(), data_of(params, in), options, out.diffuse, out.specular);
}
void run(const ZbufferParams& params, const InterpolateInputs& in, const RunOptions& options, PixelLight& out) {
    run_two(stage<InterpolateKernel>(), data_of(params, in), options, out.irradiance, out.sent);
}
void run(const ZbufferParams& params, const PixelsInputs& in, const RunOptions& options, PixelLight& out) {
    run_two(stage<PixelsKernel>(), data_of(params, in), options, out.irradiance, out.sent);
}

}  // namespace plumb::zbuffer
