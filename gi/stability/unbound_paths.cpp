// reference and rsm.all_rays: the kernels with Followed.
#include "gi/stability/followed_kernels.h"
// After the ray tracer of Followed.
#include <fmt/format.h>

#include <memory>

#include "core/fp_environment.h"
#include "core/hash.h"
#include "gi/reference/path_kernel.h"
#include "gi/rsm/all_rays_data.h"
#include "gi/stability/unbound_stages.h"

namespace plumb::reference {

// Phong's lobe splits floats into two: the double beside them takes the plain formula.
template <>
Followed phong_lobe<Followed>(const vec3<Followed>& a, const vec3<Followed>& b, Followed exponent) {
    const vec3<float> fa{a.x.value, a.y.value, a.z.value}, fb{b.x.value, b.y.value, b.z.value};
    const vec3<double> da{a.x.exact, a.y.exact, a.z.exact}, db{b.x.exact, b.y.exact, b.z.exact};
    return {phong_lobe<float>(fa, fb, exponent.value), phong_lobe<double>(da, db, exponent.exact)};
}
template <>
vec3<Followed> cosine_power<Followed>(Followed u1, Followed u2, Followed exponent) {
    const vec3<float> f = cosine_power<float>(u1.value, u2.value, exponent.value);
    const vec3<double> d = cosine_power<double>(u1.exact, u2.exact, exponent.exact);
    return {Followed(f.x, d.x), Followed(f.y, d.y), Followed(f.z, d.z)};
}

}  // namespace plumb::reference

namespace plumb::stability {

namespace {

const std::vector<std::size_t> xyz_columns{0, 1, 2};

float* floats(Buffer<Vertex>& vertices) { return &vertices.data()->position.x; }

// The scene as a path reads it. Tables of probabilities stay: they are multiples of 2^-24, and random numbers are
// compared with them.
void add_scene(reference::PathScene& s, std::vector<Input>& out) {
    add_columns("vertices", floats(s.geometry.vertices), s.geometry.vertices.size(), 8, {0, 1, 2, 3, 4, 5, 6, 7}, out);
    add_columns("materials", s.surfaces.materials.data(), s.surfaces.materials.size() / record_stride, record_stride,
                {0, 1, 2, 4, 5, 6, 11}, out);
    if (s.any_glossy)
        add_columns("reflection", s.reflection.data(), s.reflection.size() / 8, 8, {0, 1, 2, 3, 4, 5, 6}, out);
    if (s.any_microfacets) add_columns("microfacets", s.microfacets.data(), s.microfacets.size() / 4, 4, {0, 1}, out);
    add_columns("lights", s.lights.rows.data(), std::size_t(s.lights.count), record_stride,
                {0, 1, 2, 4, 5, 6, 8, 9, 10}, out);
    add_columns("triangle_pdf", s.lights.triangle_pdf.data(), s.lights.triangle_pdf.size(), 1, {0}, out);
    add_columns("environment", s.environment.radiance.data(), s.environment.radiance.size() / 4, 4, xyz_columns, out);
    add_columns("environment_pdf", s.environment.pdf.data(), s.environment.pdf.size(), 1, {0}, out);
}

// One invocation for each of `args`, which stay where they are: a pixel that stands alone in a frame of its own.
Subject subject_of(const reference::PathScene& scene, std::vector<reference::PathArgs>& args,
                   const std::vector<std::string>& places) {
    Subject subject{"reference", {"r", "g", "b"}, {}, {}};
    for (std::size_t i = 0; i < args.size(); ++i)
        subject.invocations.push_back({places[i], [&scene, &args, i](std::vector<Followed>& out) {
                                           float sum[4];
                                           double exact[3];
                                           reference::PathArgs one = args[i];
                                           one.sum = sum, one.exact_sum = exact;
                                           if (one.faceted)
                                               reference::trace_paths<Followed, true>(one, *scene.rays, 1);
                                           else
                                               reference::trace_paths<Followed>(one, *scene.rays, 1);
                                           for (int c = 0; c < 3; ++c) out.push_back({sum[c], exact[c]});
                                       }});
    return subject;
}

// A frame of one pixel, with random numbers of its own.
reference::PathArgs one_pixel(reference::PathArgs args, std::size_t i) {
    args.width = 1, args.first_row = 0, args.round = 0, args.samples = 1;
    args.seed = std::uint32_t(pcg(std::int32_t(i)));
    return args;
}

}  // namespace

Cell paths_cell(reference::PathScene& scene, const reference::PathParams& params, const Camera& camera, glm::ivec2 size,
                const Effort& effort) {
    const reference::PathArgs whole = reference::camera_args(params, scene, camera, size, 1);
    std::vector<reference::PathArgs> args;
    std::vector<std::string> places;
    for (const std::size_t i : picked(std::size_t(size.x) * std::size_t(size.y), effort.pixels)) {
        const int x = int(i % std::size_t(size.x)), y = int(i / std::size_t(size.x));
        args.push_back(one_pixel(whole, i));
        reference::CameraArgs& c = args.back().camera;
        for (int k = 0; k < 3; ++k) c.corner[k] += c.across[k] * float(x) + c.down[k] * float(y);
        places.push_back(fmt::format("path of pixel ({}, {})", x, y));
    }
    Subject subject = subject_of(scene, args, places);
    add_scene(scene, subject.inputs);
    constexpr std::size_t stride = sizeof(reference::PathArgs) / sizeof(float);
    static_assert(sizeof(reference::PathArgs) % sizeof(float) == 0);
    if (!args.empty()) {
        add_columns("eye", args[0].camera.eye, args.size(), stride, xyz_columns, subject.inputs);
        add_columns("corner", args[0].camera.corner, args.size(), stride, xyz_columns, subject.inputs);
    }
    return look(subject, effort);
}

Cell points_cell(reference::PathScene& scene, const reference::PathParams& params, const Image4& position,
                 const Image4& normal, const Effort& effort) {
    Image4 n = normal, x = reference::anchored(scene, {&position, &normal});
    const reference::PathArgs whole = reference::point_args(params, scene, {&x, &n}, 1);
    std::vector<reference::PathArgs> args;
    std::vector<std::string> places;
    for (const std::size_t i : picked(x.size(), effort.pixels)) {
        args.push_back(one_pixel(whole, i));
        args.back().position += 4 * i, args.back().normal += 4 * i;
        places.push_back(fmt::format("path of point {}", i));
    }
    Subject subject = subject_of(scene, args, places);
    add_scene(scene, subject.inputs);
    add_columns("position", &x.data()->x, x.size(), 4, xyz_columns, subject.inputs);
    add_columns("normal", &n.data()->x, n.size(), 4, xyz_columns, subject.inputs);
    return look(subject, effort);
}

namespace {

Cell gather_cell(const rsm::GatherParams& params, const rsm::GatherInputs& in, const std::vector<raster::Rsm>& maps,
                 Image4& position, Image4& normal, const Effort& effort) {
    rsm::AllRaysData data = rsm::prepare_all_rays(params, in, maps);
    const bool complete = data.view.strata_log2 < 0;
    Subject subject{rsm::stage_name(rsm::Gather::all_rays), {"r", "g", "b"}, {}, {}};
    if (!complete) subject.components.insert(subject.components.end(), {"error.r", "error.g", "error.b"});
    for (int i = 0; i < position.width; ++i)
        subject.invocations.push_back({fmt::format("point {}", i), [&, i](std::vector<Followed>& out) {
                                           rsm::ShadowRays<Followed> rays(*in.rays, in.offsets);
                                           NoTap tap;
                                           auto push = [&](const vec3<Followed>& v) {
                                               out.insert(out.end(), {v.x, v.y, v.z});
                                           };
                                           if (complete)
                                               return push(rsm::gather_all_rays<Followed>(data.view, i, 0, rays, tap));
                                           const auto e = rsm::gather_subset<Followed>(data.view, i, 0, rays, tap);
                                           push(e.irradiance), push(e.standard_error);
                                       }});
    add_columns("position", &position.data()->x, position.size(), 4, xyz_columns, subject.inputs);
    add_columns("normal", &normal.data()->x, normal.size(), 4, xyz_columns, subject.inputs);
    add_columns("records", data.texels.records.data(), std::size_t(data.texels.count()), record_stride,
                {0, 1, 2, 4, 5, 6, 8, 9, 10}, subject.inputs);
    return look(subject, effort);
}

}  // namespace

Cell all_rays_cell(rsm::GatherInputs in, const std::vector<raster::Rsm>& maps, const Effort& effort) {
    std::vector<std::size_t> points;
    for (std::size_t i = 0; i < in.normal->size(); ++i)
        if (glm::vec3(in.normal->texels[i]) != glm::vec3(0)) points.push_back(i);
    const std::vector<std::size_t> chosen = picked(points.size(), effort.pixels);
    Image4 position(int(chosen.size()), 1), normal(int(chosen.size()), 1);
    for (std::size_t i = 0; i < chosen.size(); ++i) {
        position.texels[i] = in.position->texels[points[chosen[i]]];
        normal.texels[i] = in.normal->texels[points[chosen[i]]];
    }
    Cell cell;
    cell.stage = rsm::stage_name(rsm::Gather::all_rays);
    if (chosen.empty()) return cell;
    in.position = &position, in.normal = &normal;
    rsm::GatherParams params;
    params.gather = rsm::Gather::all_rays;
    params.max_rays = 0;
    cell = gather_cell(params, in, maps, position, normal, effort);
    params.max_rays = float(32 * chosen.size());
    merge(cell, gather_cell(params, in, maps, position, normal, effort));
    return cell;
}

}  // namespace plumb::stability
