#include "gi/stability/radiosity.h"

#include <algorithm>
#include <cmath>

#include "core/host_math.h"
#include "gi/lend.h"
#include "gi/radiosity/elements.h"
#include "gi/radiosity/gather.h"
#include "gi/radiosity/items.h"
#include "gi/radiosity/lookup.h"
#include "gi/radiosity/reduce.h"
#include "gi/radiosity/rows.h"
#include "gi/radiosity/solve.h"
#include "gi/reference/closed_form_scenes.h"
#include "gi/stability/cases_parts.h"

namespace plumb::stability {

namespace {

using radiosity::Elements;

constexpr const char* group = "radiosity";
constexpr int small = 16;  // texels of a hemicube's side

template <class Kernel>
StageData own(const StageData& data, const std::string& form) {
    StageData owned_data = owned(stage<Kernel>(), data);
    owned_data.label = data.stage + form;
    return owned_data;
}

struct Lists {
    Buffer<glm::vec4> vertices;
    Buffer<glm::ivec4> triangles;
};

Lists lists_of(const Geometry& g) {
    Lists l;
    for (const Vertex& v : g.vertices) l.vertices.push_back(glm::vec4(v.position, 0));
    for (const glm::uvec3& t : g.triangles) l.triangles.push_back(glm::ivec4(glm::ivec3(t), 0));
    return l;
}

// Hemicubes where eyes stand, of all triangles.
StageData items_data(const Lists& l, const Buffer<glm::vec4>& eye, const Buffer<glm::vec4>& normal, int size, const std::string& form) {
    const Buffer<glm::vec4> eyes = radiosity::eyes_of(eye, normal);
    return own<radiosity::ItemsKernel>(radiosity::data_of({&l.vertices, &l.triangles, &eyes, size}, 0, int(eye.size())), form);
}

// Of some elements, spread evenly.
StageData items_of(const Elements& e, const std::string& form) {
    Buffer<glm::vec4> eye, normal;
    const int some = std::min(5, e.count());
    for (int k = 0; k < some; ++k) {
        const auto i = std::size_t(k) * std::size_t(e.count()) / std::size_t(some);
        eye.push_back(e.eye[i]), normal.push_back(e.normal[i]);
    }
    return items_data(lists_of(e.geometry), eye, normal, small, form);
}

// What leaves elements: each emits 1 W/m2, too, so that there is light in any scene.
Buffer<glm::vec4> leaving(const Elements& e, const radiosity::FormFactors& f, const RunOptions& options) {
    constexpr int passes = 6;
    Buffer<glm::vec4> b(e.position.size(), glm::vec4(0)), h;
    const Buffer<glm::vec4> none(b.size(), glm::vec4(0));
    for (int pass = 0; pass < passes; ++pass) {
        radiosity::gather(f, none, b, options, h);
        for (std::size_t i = 0; i < b.size(); ++i) b[i] = e.exitance[i] + glm::vec4(1, 0.5f, 0.25f, 0) + e.reflectance[i] * h[i];
    }
    return b;
}

// The rows of each block under `radiosity`, and points of triangles under what was gathered.
void add_gathered(const Elements& e, const radiosity::FormFactors& f, const Buffer<glm::vec4>& radiosity, const std::string& form,
                  const RunOptions& options, std::vector<StageData>& all) {
    Buffer<glm::vec4> lamps, irradiance;
    for (int i = 0; i < e.count(); ++i) lamps.push_back({0.125f * float(i % 3), 0.5f, i % 5 == 0 ? 0.0f : 2.0f, 0});
    for (const radiosity::RowBlock& block : f.blocks) {
        radiosity::GatherInputs in{&block, &lamps, &radiosity};
        in.decoded = true;
        all.push_back(own<radiosity::GatherKernel>(data_of(in), form));
    }
    radiosity::gather(f, lamps, radiosity, options, irradiance);
    const radiosity::TriangleElements t = radiosity::triangle_elements(e);
    const int n = 96, triangles = int(t.of.size());
    Image4 position(n, 1);
    Image<glm::ivec2> id(n, 1);
    for (int i = 0; i < n; ++i) {
        const int at = int(std::int64_t(i) * triangles / n);
        const glm::vec4* c = &t.corners[3 * std::size_t(at)];
        const float b = 0.1f + 0.07f * float(i % 7), g = 0.05f + 0.08f * float(i % 5);
        position(i, 0) = c[0] + b * (c[1] - c[0]) + g * (c[2] - c[0]);
        id(i, 0) = {0, i == n / 2 ? -1 : at};
    }
    all.push_back(own<radiosity::LookupKernel>(data_of(radiosity::LookupInputs{&position, &id, &t, &irradiance}), form));
}

// Three hemicubes whose texels are from 1e-12 to 1e12 W/m2, in boxes of `box`.
BakeCase of_reduction(const std::string& name, const std::string& meaning, int size, const glm::ivec2& box, float gain) {
    return {name, group, meaning, [=] {
                Buffer<glm::vec4> texels;
                for (int i = 0; i < 9 * size * size; ++i)
                    texels.push_back({float(host::pow(10.0, double(i * 7 % 25) - 12)), float(i % 5), i == 40 ? 1e6f : 1e-6f, i % 4 == 0 ? 0.0f : 1.0f});
                Buffer<float> weights;
                for (const double w : radiosity::texel_weights(size, radiosity::Weights::exact)) weights.push_back(float(w));
                return std::vector{own<radiosity::ReduceKernel>(data_of(radiosity::ReduceInputs{&texels, size, 3 * size, &weights, box, gain}), " (" + name + ")")};
            }};
}

void add_scene(const Scene& scene, const std::string& form, const RunOptions& options, std::vector<StageData>& all) {
    const Elements e = radiosity::elements_of(scene, {}, options);
    all.push_back(items_of(e, form));
    const radiosity::FormFactors f = radiosity::form_factors(e, {small, radiosity::Weights::exact}, options);
    add_gathered(e, f, leaving(e, f, options), form, options, all);
}

Scene box(double half = 1) {
    Scene scene;
    reference::add_cube(scene, reference::grey(0.5), glm::dvec3(-half), glm::dvec3(half));
    return scene;
}

BakeCase of_scene(const std::string& name, const std::string& meaning, const Scene& scene) {
    return {name, group, meaning, [=] {
                std::vector<StageData> all;
                add_scene(scene, " (" + name + ")", {}, all);
                return all;
            }};
}

// A hemicube of `size` in a box.
BakeCase of_eye(const std::string& name, const std::string& meaning, const glm::vec3& eye, const glm::vec3& normal, int size = 32) {
    return {name, group, meaning, [=] {
                const Lists l = lists_of(flatten(box()));
                return std::vector{items_data(l, {glm::vec4(eye, 0)}, {glm::vec4(normal, 0)}, size, " (" + name + ")")};
            }};
}

// A closed cube that reflects rho and emits 1 W/m2, and one of its faces ten, when light has come to rest.
BakeCase of_reflectance(const std::string& name, float rho) {
    return {name, group, "a closed cube under all of its reflections, by BiCGSTAB", [=] {
                Elements e = radiosity::elements_of(box(), {});
                for (std::size_t i = 0; i < e.position.size(); ++i)
                    e.reflectance[i] = glm::vec4(glm::vec3(rho), 0), e.exitance[i] = glm::vec4(i < 4 ? 10.0f : 1.0f);
                const radiosity::FormFactors f = radiosity::form_factors(e, {small, radiosity::Weights::exact}, {});
                std::vector<double> sums;
                std::vector<float> row;
                for (int i = 0; i < e.count(); ++i) {
                    row.assign(std::size_t(e.count()), 0.0f), f.add_row(i, row);
                    double sum = 0;
                    for (const float x : row) sum += double(x);
                    sums.push_back(sum);
                }
                radiosity::Transport transport;
                transport.count = e.count(), transport.area = &e.area, transport.row_sums = &sums;
                transport.gather = [&](const Buffer<glm::vec4>& b, Buffer<glm::vec4>& h, const RunOptions& options) {
                    radiosity::gather(f, Buffer<glm::vec4>(b.size(), glm::vec4(0)), b, options, h);
                };
                transport.row = [&](int i, std::vector<float>& to) { to.assign(std::size_t(e.count()), 0.0f), f.add_row(i, to); };
                const radiosity::Solution solved = radiosity::solve({&e.reflectance, &e.exitance, nullptr}, transport, {});
                std::vector<StageData> all;
                add_gathered(e, f, floats_of(solved), " (" + name + ")", {}, all);
                return all;
            }};
}

// Quads on the floor of the box whose sides shrink tenfold each, to a millionth of its area.
Scene million_to_one() {
    Scene scene = box();
    for (int k = 0; k < 4; ++k) {
        const float side = float(host::pow(0.1, double(k))), x = -0.9f + 0.4f * float(k);
        scene.meshes.push_back(quad("quad", {glm::vec3(x, -0.5f, side), {x + side, -0.5f, side}, {x + side, -0.5f, 0}, {x, -0.5f, 0}}, 0));
    }
    return scene;
}

// Triangles as long as the box, a thousandth to a ten-millionth of that wide, along its axes and across.
Scene slivers() {
    Scene scene = box();
    std::vector<glm::vec3> corners;
    for (const float wide : {1e-3f, 1e-5f, 1e-7f}) {
        const float y = 10 * wide - 0.5f;
        corners.insert(corners.end(), {{-0.9f, y, -0.8f}, {0.9f, y, 0.7f}, {0.9f, y + wide, 0.7f}});
        corners.insert(corners.end(), {{-0.9f, y, 0.25f}, {0.9f, y, 0.25f + wide}, {0.9f, y, 0.25f}});
    }
    scene.meshes.push_back(triangles("slivers", corners, 0));
    return scene;
}

// A wall that stands in the middle of the floor's triangles: corners of the floor are in its plane and in it.
Scene vertex_in_wall() {
    Scene scene = box();
    const float y = -1;
    scene.meshes.push_back(triangles("floor", {{0, y, 0}, {0.5f, y, 0}, {0, y, -0.5f}, {0, y, 0}, {-0.5f, y, 0}, {0, y, 0.5f}}, 0));
    scene.meshes.push_back(quad("wall", {glm::vec3(0, y, 0.75f), {0, y, -0.75f}, {0, 0.5f, -0.75f}, {0, 0.5f, 0.75f}}, 0));
    return scene;
}

}  // namespace

std::vector<StageData> radiosity_data(const Scene& scene, const RunOptions& options) {
    std::vector<StageData> all;
    add_scene(scene, "", options, all);
    return all;
}

void add_radiosity_cases(std::vector<BakeCase>& cases) {
    const glm::vec3 eye(0.25f, -0.999f, 0.125f), up(0, 1, 0);
    cases.push_back(of_eye("items, 2", "2 x 2 texels and four times 2 x 1", eye, up, 2));
    cases.push_back(of_eye("items, 1024", "1024 x 1024 texels and four times 1024 x 512", eye, up, 1024));
    cases.push_back(of_eye("items without a normal", "of an element whose normal is 0: it sees nothing", eye, glm::vec3(0)));
    cases.push_back(of_eye("items, a normal of 1e-20", "as short as that, and along no axis", eye, 1e-20f * glm::vec3(3, 5, 1)));
    cases.push_back(of_eye("items, an eye in a wall", "in the plane of a wall, to the bit", {1, 0.125f, 0.25f}, up));
    cases.push_back(of_eye("items, an eye at a wall", "3.4e-4 m off it, as elements of a room of 2 m are", {1 - 3.4e-4f, 0.125f, 0.25f}, {-1, 0, 0}));
    cases.push_back(of_eye("items, an eye in a corner", "1e-6 m from three walls", glm::vec3(-1 + 1e-6f), {1, 2, 3}));
    cases.push_back(of_reduction("reduced in boxes of 2", "24 orders of magnitude in one hemicube", 32, {2, 2}, 1));
    cases.push_back(of_reduction("reduced to means at once", "a box of all columns", 64, {64, 64}, 1.0f / 4096));
    cases.push_back(of_scene("slivers among elements", "a thousandth to a ten-millionth as wide as long", slivers()));
    cases.push_back(of_scene("elements in a wall", "vertices of a floor in the plane of a wall that stands on it", vertex_in_wall()));
    cases.push_back(of_scene("areas of a million to one", "quads of 1 m to 1 mm a side in one room", million_to_one()));
    cases.push_back(of_reflectance("gathered, rho 0.5", 0.5f));
    cases.push_back(of_reflectance("gathered, rho 0.999999", 1 - 1e-6f));
}

}  // namespace plumb::stability
