// plumb experiment ipr: what the thesis has no table for: small emissive quads, and a lightmap's errors receiver by receiver.
#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/view.h"
#include "gi/probes/converge.h"
#include "gi/probes/hit_surfaces.h"
#include "gi/probes/lit_hits.h"
#include "gi/probes/lightmap_pictures.h"
#include "tools/experiments/ipr.h"
#include "tools/experiments/ipr_truth.h"

namespace plumb::cli {

namespace {

// Corners a, a + u, a + u + v, a + v; the front is where u x v points.
void add_quad(Mesh& mesh, const glm::vec3& a, const glm::vec3& u, const glm::vec3& v, int material) {
    const unsigned first = unsigned(mesh.vertices.size());
    const glm::vec3 n = glm::normalize(glm::cross(u, v));
    for (const glm::vec3& p : {a, a + u, a + u + v, a + v}) mesh.vertices.push_back({p, 0, n, 0});
    mesh.triangles.push_back({first, first + 1, first + 2}), mesh.triangles.push_back({first, first + 2, first + 3});
    mesh.material.insert(mesh.material.end(), 2, material);
}

void add_box(Mesh& mesh, const glm::vec3& low, const glm::vec3& high, bool inwards, int material) {
    const glm::vec3 size = high - low;
    for (int c = 0; c < 3; ++c) {
        glm::vec3 u(0), v(0), w(0);
        u[(c + 1) % 3] = size[(c + 1) % 3], v[(c + 2) % 3] = size[(c + 2) % 3], w[c] = size[c];
        if (inwards)
            add_quad(mesh, low, u, v, material), add_quad(mesh, low + w, v, u, material);
        else
            add_quad(mesh, low, v, u, material), add_quad(mesh, low + w, u, v, material);
    }
}

constexpr double most_change = 1e-5;  // of the mean: rounds end there

Image4 rows_of(const std::vector<glm::dvec3>& all, const std::vector<int>& index) {
    Image4 row(int(index.size()), 1);
    for (std::size_t i = 0; i < index.size(); ++i) row.texels[i] = glm::vec4(glm::vec3(all[std::size_t(index[i])]), 0);
    return row;
}

}  // namespace

Scene ipr_quad_room() {
    // A square of 1.28 m: 7 of 512 rays are 0.17 sr, the mean of places beside walls, which see it aslant or not at all.
    Scene scene;
    scene.name = "quads";
    scene.materials.resize(3);
    scene.materials[0].name = "walls", scene.materials[0].reflectance = {0.7f, 0.5f, 0.4f};
    scene.materials[1].name = "box", scene.materials[1].reflectance = {0.3f, 0.5f, 0.7f};
    scene.materials[2].name = "quad", scene.materials[2].reflectance = glm::vec3(0), scene.materials[2].emission = glm::vec3(100);
    Mesh mesh;
    mesh.name = "room";
    add_box(mesh, glm::vec3(-2), glm::vec3(2), true, 0);
    add_box(mesh, {-1.1f, -1.8f, -0.9f}, {0.1f, -0.4f, 0.3f}, false, 1);
    add_quad(mesh, {-0.64f, 1.98f, -0.64f}, {1.28f, 0, 0}, {0, 0, 1.28f}, 2);
    scene.meshes = {std::move(mesh)};
    scene.camera.position = {1.7, 0.2, 1.8}, scene.camera.look_at = {-0.5, -0.8, -0.5}, scene.camera.fov_y_deg = 65;
    scene.camera.near = 0.01;
    scene.frame_size = {320, 180};
    return scene;
}

IprQuads IprBench::quads(const probes::BakeParams& params) {
    const probes::Bake& b = bake(params);
    IprVariant variant;
    variant.bake = params, variant.run.tolerance = float(most_change);
    IprQuads q;
    const IprRow chain = row(variant);
    if (!chain.refused.empty()) throw InputError(chain.refused);
    q.chain = chain.at_receivers;
    const probes::HitSurfaces hits = probes::hit_surfaces(scene_, b, options_, probes::Unasked::black);
    const auto lit = probes::lit_scene(scene_, params.rays);
    const Image4 direct = probes::lamp_irradiance(*lit, hits.position, hits.normal, options_);
    probes::Relit relit;
    for (std::size_t i = 0; i < hits.surface.size(); ++i) {
        relit.emitted.emplace_back(glm::vec3(hits.emitted.texels[i]));
        relit.reflectance.emplace_back(glm::vec3(hits.surface.texels[i]));
        relit.direct.emplace_back(glm::vec3(direct.texels[i]));
        q.hits += hits.emitted.texels[i].x > 0 ? 1.0 / b.relight.probes : 0.0;
    }
    q.relight_rays = b.relight.rays;
    probes::RunTime run(b, std::move(relit), probes::Transport::whole, probes::stand_ins(b, variant.run.unasked, options_));
    (void)run.converge(1000, most_change);
    const IprTruth& truth = truth_of(b.receivers);
    q.whole = ipr_errors(compare::luminances(rows_of(run.irradiance(), truth.index)), truth.mean, truth.error);
    return q;
}

IprLightmap IprBench::lightmap(const probes::BakeParams& params) {
    const probes::Bake& b = bake(params);
    IprVariant variant;
    variant.bake = params;
    const frame::Frame f = frame_of(scene_, variant);
    IprLightmap l;
    l.receivers = b.receivers.count(), l.side = b.atlas.size.x;
    l.samples = std::max(request_.samples / 16, 32);
    const probes::ReceiverIrradiance truth = trace_all_receivers(scene_, b.receivers, l.samples, params.rays, options_);
    const probes::Lightmap layout = probes::place_lightmap(scene_, b.atlas, params, options_);
    Image4 map = f.probes.lightmap;  // one level: the strip is the map
    const probes::LightmapCheck check = probes::check_lightmap(map, {}, layout, truth);
    l.leaks = int(check.leaks.size()), l.leaking = check.leaking, l.black_leaking = check.black_leaking;
    l.told = check.told, l.told_by_chance = check.told_by_chance;
    Image4 own(l.receivers, 1), mean = own, error = own;
    for (std::size_t i = 0; i < own.size(); ++i) {
        const glm::ivec2 t = b.receivers.texel[i];
        own.texels[i] = map(t.x, t.y), mean.texels[i] = truth.mean[i], error.texels[i] = truth.error[i];
    }
    l.errors = ipr_errors(compare::luminances(own), compare::luminances(mean), compare::luminance_errors(error));
    const View view = make_view(scene_.camera, double(request_.size.x) / request_.size.y, scene_.convention, request_.size);
    for (probes::DebugLayer& layer : probes::lightmap_pictures(map, layout, truth, check, {}, {view, request_.size, -1}, options_))
        if (layer.name.rfind("error", 0) == 0 || layer.name.rfind("leaks", 0) == 0) l.pictures.push_back(std::move(layer));
    return l;
}

}  // namespace plumb::cli
