// visibility, hemicube and texture_space.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "core/fp_environment.h"
#include "core/hash.h"
#include "gi/reference/ray_query.h"
#include "gi/stability/followed_kernels.h"
// After the ray tracer of Followed.
#include "gi/stability/unbound_stages.h"
#include "raster/hemicube.h"
#include "raster/screen_triangle.h"
#include "raster/texture_space.h"

namespace plumb::stability {

namespace {

// 113 bits, in software: the same on every processor, unlike long double.
__extension__ typedef __float128 Extended;

struct Window {
    Extended depth = 0, l1 = 0, l2 = 0;
};

// Whether the triangle covers the centre of the pixel, and what is there: weights are exact integers; the corners'
// depth and 1/w come from their clip positions, or are those that clipping left.
bool window_at(const raster::ScreenTriangles& screen, const raster::ScreenTriangle& t, const glm::vec4* corners,
               glm::ivec2 pixel, Window& out) {
    Extended e[3], sum = 0, depth = 0, q[3], weights = 0;
    for (int i = 0; i < 3; ++i) {
        const raster::EdgeRow edge = raster::edge_row(t, raster::area2(t) > 0, i, pixel.y);
        const std::int64_t value = edge.value + edge.step * pixel.x;
        if (value < edge.least) return false;
        e[i] = Extended(value);
        sum += e[i];
    }
    for (int i = 0; i < 3; ++i) {
        const bool whole = t.corners < 0;
        depth += e[i] * (whole ? Extended(corners[i].z) / corners[i].w : Extended(t.z[i]));
        q[i] = e[i] * (whole ? 1 / Extended(corners[i].w) : Extended(t.inverse_w[i]));
        weights += q[i];
    }
    out.depth = std::min(depth / sum, Extended(1));
    if (t.corners < 0) {
        out.l1 = q[1] / weights, out.l2 = q[2] / weights;
        return true;
    }
    const glm::dvec2* l = screen.corners[std::size_t(t.corners)].barycentrics;
    out.l1 = (q[0] * l[0].x + q[1] * l[1].x + q[2] * l[2].x) / weights;
    out.l2 = (q[0] * l[0].y + q[1] * l[1].y + q[2] * l[2].y) / weights;
    return true;
}

// Finds the point at the pixel's centre, in extended precision: of the pieces of `triangle` the nearest.
bool truth_at(const Geometry& geometry, const raster::ScreenTriangles& screen, const Buffer<glm::vec4>& clip,
              bool reversed_z, std::int32_t triangle, glm::ivec2 pixel, Window& out) {
    const glm::uvec3& v = geometry.triangles[std::size_t(triangle)];
    const glm::vec4 corners[3] = {clip[v.x], clip[v.y], clip[v.z]};
    auto before = [](const raster::ScreenTriangle& t, std::int32_t index) { return t.triangle < index; };
    auto piece = std::lower_bound(screen.triangles.begin(), screen.triangles.end(), triangle, before);
    bool any = false;
    for (; piece != screen.triangles.end() && piece->triangle == triangle; ++piece) {
        Window w;
        if (!window_at(screen, *piece, corners, pixel, w)) continue;
        if (!any || (reversed_z ? w.depth > out.depth : w.depth < out.depth)) out = w;
        any = true;
    }
    return any;
}

// The point of the view's frustum at the pixel's centre and that depth.
glm::dvec3 unprojected(const glm::dmat4& clip_to_world, glm::ivec2 size, glm::ivec2 pixel, double depth) {
    const glm::dvec4 p =
        clip_to_world * glm::dvec4((pixel.x + 0.5) * 2 / size.x - 1, (pixel.y + 0.5) * 2 / size.y - 1, depth, 1);
    return glm::dvec3(p) / p.w;
}

// Pixels of `chosen` where a ray through the centre meets another triangle than the one that was drawn.
std::int64_t flips(const RayQuery& query, const View& view, const Image<std::int32_t>& triangle,
                   const std::vector<std::size_t>& chosen) {
    const glm::dmat4 clip_to_world = glm::inverse(view.world_to_clip());
    const glm::ivec2 size{triangle.width, triangle.height};
    RayTracer<float> tracer(query);
    std::int64_t count = 0;
    for (const std::size_t i : chosen) {
        const glm::ivec2 pixel{int(i % std::size_t(size.x)), int(i / std::size_t(size.x))};
        const glm::dvec3 start = unprojected(clip_to_world, size, pixel, view.reversed_z ? 1 : 0);
        const glm::dvec3 towards = unprojected(clip_to_world, size, pixel, 0.5) - start;
        const RayHit<float> hit = tracer.nearest(glm::vec3(start), glm::vec3(towards), true);
        count += (hit.found ? hit.triangle : -1) != triangle.texels[i];
    }
    return count;
}

}  // namespace

Drawable drawable(const Scene& scene) {
    Drawable d{flatten(scene), {}};
    d.surfaces = raster::prepare(scene, d.geometry);
    return d;
}

std::vector<std::size_t> picked(std::size_t count, int wanted) {
    std::vector<std::size_t> order(count);
    std::iota(order.begin(), order.end(), std::size_t(0));
    auto hash = [](std::size_t i) { return std::uint32_t(pcg(std::int32_t(i))); };
    const std::size_t kept = std::min(count, std::size_t(std::max(wanted, 0)));
    std::partial_sort(order.begin(), order.begin() + std::ptrdiff_t(kept), order.end(),
                      [&](std::size_t a, std::size_t b) { return std::pair(hash(a), a) < std::pair(hash(b), b); });
    order.resize(kept);
    return order;
}

Cell visibility_cell(const Drawable& drawn, const View& view, glm::ivec2 size, const Effort& effort) {
    FpEnvironment environment;
    Cell cell;
    cell.stage = "visibility";
    const Geometry& g = drawn.geometry;
    const Buffer<glm::vec4> clip = raster::clip_positions(g, view, effort.run.threads);
    const raster::ScreenTriangles screen = raster::screen_triangles(g, clip, size, effort.run.threads);
    raster::VisibilityBuffer seen;
    RunOptions quiet = effort.run;
    quiet.progress = nullptr;
    raster::draw_visibility(g, &drawn.surfaces, clip, view.reversed_z, size, quiet, seen);
    const std::vector<std::size_t> chosen = picked(seen.triangle.size(), effort.pixels);
    for (const std::size_t i : chosen) {
        ++cell.pixels;
        const std::int32_t triangle = seen.triangle.texels[i];
        if (triangle < 0) continue;
        const glm::ivec2 pixel{int(i % std::size_t(size.x)), int(i / std::size_t(size.x))};
        Window truth;
        if (!truth_at(g, screen, clip, view.reversed_z, triangle, pixel, truth))
            throw std::logic_error(
                fmt::format("visibility: triangle {} does not cover pixel ({}, {})", triangle, pixel.x, pixel.y));
        const glm::vec2 l = seen.barycentrics.texels[i];
        static const char* const names[] = {"depth", "l1", "l2"};
        judge(
            {{seen.depth.texels[i], double(truth.depth)}, {l.x, double(truth.l1)}, {l.y, double(truth.l2)}},
            [&](std::size_t c) { return fmt::format("pixel ({}, {}), {}", pixel.x, pixel.y, names[c]); }, cell);
    }
    if (!g.triangles.empty())
        cell.flips = flips(*reference::build_ray_query(g, drawn.surfaces, Rays::exact), view, seen.triangle, chosen);
    conclude(cell);
    return cell;
}

Cell hemicube_cell(const Drawable& drawn, const glm::dvec3& eye, const glm::dvec3& normal, double near, int size,
                   const Effort& effort) {
    FpEnvironment environment;
    Cell cell;
    cell.stage = raster::info_hemicube().name;
    raster::Hemicube cube;
    RunOptions quiet = effort.run;
    quiet.progress = nullptr;
    raster::draw_hemicube(drawn.geometry, &drawn.surfaces, eye, normal, near, size, quiet, cube);

    // As floats, and their sum, which is 1 but for what midpoints of pixels leave out: that is the method's error, and
    // tests/raster/test_hemicube.cpp has its size.
    const std::vector<double> top = raster::delta_form_factors_top(size), side = raster::delta_form_factors_side(size);
    const Extended width = Extended(2) / size, pi = Extended(0x1.921fb54442d18p+1) + 0x1.1a62633145c07p-53;
    std::vector<Checked> numbers;
    double sum = 0;
    Extended exact_sum = 0;
    for (const bool is_top : {true, false}) {
        const std::vector<double>& factors = is_top ? top : side;
        for (std::size_t i = 0; i < factors.size(); ++i) {
            const Extended x = (Extended(i % std::size_t(size)) + 0.5) * width - 1,
                           y = (Extended(i / std::size_t(size)) + 0.5) * width, z = is_top ? 1 : 1 - y;
            const Extended r2 = is_top ? x * x + (y - 1) * (y - 1) + 1 : x * x + z * z + 1;
            const Extended exact = z * width * width / (pi * r2 * r2);
            numbers.push_back({float(factors[i]), double(exact)});
            sum += (is_top ? 1 : 4) * factors[i], exact_sum += (is_top ? 1 : 4) * exact;
        }
    }
    judge(
        numbers, [](std::size_t i) { return fmt::format("delta form factor {}", i); }, cell);
    judge({{sum, double(exact_sum)}}, [](std::size_t) { return "sum of the delta form factors"; }, cell);

    // The item buffer.
    const std::vector<View> views = raster::hemicube_views(eye, normal, near);
    std::unique_ptr<RayQuery> rays;
    if (!drawn.geometry.triangles.empty())
        rays = reference::build_ray_query(drawn.geometry, drawn.surfaces, Rays::exact);
    for (int face = 0; face < raster::hemicube_faces; ++face) {
        const Image<std::int32_t>& items = cube.faces[face].triangle;
        const std::vector<std::size_t> chosen = picked(items.size(), effort.pixels);
        cell.pixels += std::int64_t(chosen.size());
        if (rays) cell.flips += flips(*rays, views[std::size_t(face)], items, chosen);
    }
    conclude(cell);
    return cell;
}

Cell texture_space_cell(Drawable drawn, const std::vector<glm::vec2>& uv, int size, const Effort& effort) {
    raster::TextureSpace map;
    RunOptions quiet = effort.run;
    quiet.progress = nullptr;
    raster::draw_texture_space(drawn.geometry, drawn.surfaces, uv, {size, size}, quiet, map);
    raster::SurfaceArgs args = raster::surface_args(drawn.geometry, drawn.surfaces, View{});
    for (float& c : args.viewer) c = 0;

    Subject subject{raster::info_texture_space().name, {}, {}, {}};
    for (const char* image : {"position", "normal", "albedo", "emission"})
        for (const char c : {'x', 'y', 'z'}) subject.components.push_back(fmt::format("{}.{}", image, c));
    std::vector<std::size_t> covered;
    for (std::size_t i = 0; i < map.id.size(); ++i)
        if (map.id.texels[i].y >= 0) covered.push_back(i);
    for (const std::size_t at : picked(covered.size(), effort.pixels)) {
        const std::size_t i = covered[at];
        subject.invocations.push_back(
            {fmt::format("texel ({}, {})", i % std::size_t(size), i / std::size_t(size)),
             [&map, &args, i](std::vector<Followed>& out) {
                 NoTap tap;
                 const glm::vec2 l = map.barycentrics.texels[i];
                 const raster::Surface<Followed> s =
                     raster::surface<Followed>(args, map.id.texels[i].y, {Followed(l.x), Followed(l.y)}, tap);
                 for (const vec3<Followed>* v : {&s.position, &s.normal, &s.albedo, &s.emission})
                     out.insert(out.end(), {v->x, v->y, v->z});
             }});
        // What the pass wrote is what is looked at.
        DecisionTape tape;
        const FollowScope scope(tape);
        std::vector<Followed> values;
        subject.invocations.back().run(values);
        const glm::vec4* written[] = {&map.position.texels[i], &map.normal.texels[i], &map.albedo.texels[i],
                                      &map.emission.texels[i]};
        for (std::size_t c = 0; c < values.size(); ++c)
            if (float w = (*written[c / 3])[int(c % 3)];
                !(values[c].value == w || (values[c].value != values[c].value && w != w)))
                throw std::logic_error(fmt::format("texture_space: texel {}, {}: {} and {}", i, subject.components[c],
                                                   values[c].value, w));
    }
    add_columns("vertices", &drawn.geometry.vertices.data()->position.x, drawn.geometry.vertices.size(), 8,
                {0, 1, 2, 3, 4, 5, 6, 7}, subject.inputs);
    add_columns("materials", drawn.surfaces.materials.data(), drawn.surfaces.materials.size() / record_stride,
                record_stride, {0, 1, 2, 4, 5, 6, 11}, subject.inputs);
    add_columns("barycentrics", &map.barycentrics.data()->x, map.barycentrics.size(), 2, {0, 1}, subject.inputs);
    Cell cell = look(subject, effort);
    // A chart that no texel's centre lies in is drawn as nothing, and all of it is there.
    cell.pixels += std::int64_t(map.id.size()) - std::int64_t(covered.size());
    conclude(cell);
    return cell;
}

}  // namespace plumb::stability
