// Eyes where they should not be, and triangles that are hardly any.
#include "gi/stability/cases_parts.h"

namespace plumb::stability {

namespace {

Case geometry(const std::string& name, const std::string& group, const std::string& meaning, void (*change)(Scene&)) {
    return {name, group, meaning, [change] {
                Scene s = room();
                change(s);
                return s;
            }};
}

void camera_inside(Scene& s) { s.camera.position = {0.25, 0.375, -0.125}, s.camera.look_at = {0.25, 0.25, -4}; }

// The eye plane is z = 3.25 exactly, and the spot's y = 1.75. Triangles start on them, one of each in the eye itself.
void on_eye_plane(Scene& s) {
    s.camera.look_at = {0, 1, 0};
    s.lights[key].position = {0.25f, 1.75f, 0.5f}, s.lights[key].direction = {0, -1, 0};
    s.meshes.push_back(triangles("on the plane",
                                 {{-0.5f, 0.5f, 3.25f}, {0.5f, 0.5f, 3.25f}, {0, 0.25f, 0},
                                  {0, 1, 3.25f}, {0.5f, 0.75f, 1}, {0.25f, 1.25f, 1},
                                  {-0.25f, 1.75f, 0.25f}, {0, 1.75f, 0.75f}, {-0.25f, 0, 0.25f},
                                  {0.25f, 1.75f, 0.5f}, {0.5f, 0.5f, 0.25f}, {0.375f, 0.5f, 0.75f}},
                                 glow));
}

// A floor from behind the camera, and a wall that stands through the planes of the spot and the lamp.
void through_eye_plane(Scene& s) {
    s.meshes.push_back(plain(64, -0.25, tiles));
    s.meshes.push_back(quad("through", {{{-0.75f, -3, 0.75f}, {-0.75f, -3, -0.75f}, {-0.75f, 5, -0.75f},
                                         {-0.75f, 5, 0.75f}}}, red));
}

// The camera looks along -z: corners far to the side are near to it in depth.
void beyond_guard_band(Scene& s) {
    const float far = 1e6f;
    s.camera.look_at = {0, 1, 0};
    s.meshes.push_back(triangles("huge", {{-far, -0.0625f, 3}, {far, -0.0625f, 3}, {0, -0.0625f, -far},
                                          {-far, -far, -1.0625f}, {far, -far, -1.0625f}, {0, far, -1.0625f}}, bumps));
}

// Points and lines that lie on what is seen.
void without_area(Scene& s) {
    s.meshes.push_back(triangles("no area", {{0, 0, 0.5f}, {0, 0, 0.5f}, {0, 0, 0.5f},
                                             {-1, 0.0625f, 0.5f}, {1, 0.0625f, 0.5f}, {0, 0.0625f, 0.5f},
                                             {-0.5f, 1, -0.9375f}, {-0.5f, 1, -0.9375f}, {0.5f, 1, -0.9375f}}, glow));
}

// The back wall as a fan whose blades are half as wide each: the last of 24 are 0.1 um wide and 2 m long.
void slivers(Scene& s) {
    std::vector<glm::vec3> corners;
    float y = 0;
    for (int k = 1; k <= 24; ++k) {
        const float next = k == 24 ? 2.0f : 2.0f - 2.0f / float(1 << k);
        for (const glm::vec3& p : {glm::vec3(-1, 0, -1), glm::vec3(1, y, -1), glm::vec3(1, next, -1)})
            corners.push_back(p);
        y = next;
    }
    for (const glm::vec3& p : {glm::vec3(-1, 0, -1), glm::vec3(1, 2, -1), glm::vec3(-1, 2, -1)}) corners.push_back(p);
    s.meshes[back_mesh] = triangles("back", corners, green);
    // In front of it two blades 1 um wide at their foot, which cover a pixel's centre or none.
    s.meshes.push_back(triangles("blades", {{-1, 0, 0.5f}, {-1 + 1e-6f, 0, 0.5f}, {1, 2, 0.5f},
                                            {-1, 1, 0.5f}, {1, 1, 0.5f}, {1, 1 + 1e-6f, 0.5f}}, glow));
}

// The floor as a grid: every pixel centre near an edge that two or six triangles share.
void shared_edges(Scene& s) {
    constexpr int n = 32;
    Mesh grid;
    grid.name = "floor";
    for (int z = 0; z <= n; ++z)
        for (int x = 0; x <= n; ++x) {
            const float u = float(x) / n, v = float(z) / n;
            grid.vertices.push_back({{2 * u - 1, 0, 2 * v - 1}, u, {0, 1, 0}, v});
        }
    for (unsigned z = 0; z < n; ++z)
        for (unsigned x = 0; x < n; ++x) {
            const unsigned i = z * (n + 1) + x;
            grid.triangles.emplace_back(i, i + n + 1, i + 1);
            grid.triangles.emplace_back(i + 1, i + n + 1, i + n + 2);
        }
    grid.material.assign(grid.triangles.size(), tiles);
    s.meshes[floor_mesh] = grid;
}

// Floor and back wall once more in the same place, of other material, split along the other diagonal.
void coincident(Scene& s) {
    s.meshes.push_back(quad("floor again", {{{1, 0, 1}, {1, 0, -1}, {-1, 0, -1}, {-1, 0, 1}}}, red));
    s.meshes.push_back(quad("back again", {{{1, 0, -1}, {1, 2, -1}, {-1, 2, -1}, {-1, 0, -1}}}, green));
}

void without_normals(Scene& s) {
    for (Mesh& mesh : s.meshes)
        for (Vertex& v : mesh.vertices) v.normal = glm::vec3(0);
}

// Along the middle of each quad the interpolated normal has no length.
void cancelling_normals(Scene& s) {
    for (const int m : {floor_mesh, left_mesh})
        for (const std::size_t v : {2u, 3u})
            s.meshes[std::size_t(m)].vertices[v].normal = -s.meshes[std::size_t(m)].vertices[v].normal;
}

}  // namespace

std::vector<Case> geometry_cases() {
    return {
        geometry("camera inside geometry", "w", "the camera is inside the box", camera_inside),
        geometry("w = 0", "w",
                 "triangles with corners in the plane of the eye, of camera and spot, and in the eye itself",
                 on_eye_plane),
        geometry("w < 0", "w", "triangles that reach behind the eye, of the camera and of every light",
                 through_eye_plane),
        geometry("guard band", "triangles", "triangles of 1,000 km, whose corners lie beyond any guard band",
                 beyond_guard_band),
        geometry("zero area", "triangles", "triangles that are points and lines", without_area),
        geometry("slivers", "triangles", "a wall as a fan of blades down to 0.1 um, and blades of 1 um before it",
                 slivers),
        geometry("shared edges", "triangles", "the floor as 2,048 triangles that share their edges", shared_edges),
        geometry("coincident", "triangles", "floor and back wall twice in the same place", coincident),
        geometry("no normal", "normals", "vertices without a normal: the face's is taken", without_normals),
        geometry("cancelling normals", "normals", "corners whose normals are opposite: none is left in between",
                 cancelling_normals),
    };
}

}  // namespace plumb::stability
