// Small scenes of quads for the placement of probes, with their rays.
#pragma once

#include <memory>

#include "gi/reference/ray_query.h"
#include "raster/surfaces.h"

namespace plumb::test {

struct QuadScene {
    Scene scene;

    QuadScene() {
        scene.materials.resize(1);
        scene.meshes.resize(1);
    }
    // Corners a, a + u, a + u + v, a + v; the front is where u x v points.
    QuadScene& quad(glm::vec3 a, glm::vec3 u, glm::vec3 v) {
        Mesh& mesh = scene.meshes[0];
        const unsigned first = unsigned(mesh.vertices.size());
        const glm::vec3 n = glm::normalize(glm::cross(u, v));
        for (const glm::vec3& p : {a, a + u, a + u + v, a + v}) mesh.vertices.push_back({p, 0, n, 0});
        mesh.triangles.push_back({first, first + 1, first + 2});
        mesh.triangles.push_back({first, first + 2, first + 3});
        mesh.material.insert(mesh.material.end(), 2, 0);
        return *this;
    }
    // The six faces of a box, seen from within or from without.
    QuadScene& box(glm::vec3 low, glm::vec3 high, bool inwards) {
        const glm::vec3 size = high - low;
        for (int c = 0; c < 3; ++c) {
            glm::vec3 u(0), v(0), w(0);
            u[(c + 1) % 3] = size[(c + 1) % 3], v[(c + 2) % 3] = size[(c + 2) % 3], w[c] = size[c];
            if (inwards)
                quad(low, u, v), quad(low + w, v, u);
            else
                quad(low, v, u), quad(low + w, u, v);
        }
        return *this;
    }
};

struct Traced {
    Geometry geometry;
    raster::Surfaces surfaces;
    std::unique_ptr<RayQuery> rays;

    explicit Traced(const Scene& scene)
        : geometry(flatten(scene)),
          surfaces(raster::prepare(scene, geometry)),
          rays(reference::build_ray_query(geometry, surfaces, Rays::exact)) {}
    Traced(const Traced&) = delete;
};

}  // namespace plumb::test
