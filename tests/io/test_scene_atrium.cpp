// The scenes `atrium` and `hall`: how many triangles, whether they are sound, what they close in, that every machine
// makes the same ones.
#include <array>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <map>

#include "core/content_hash.h"
#include "core/hash.h"
#include "core/scene.h"
#include "io/scenes/generate.h"

using namespace plumb;

namespace {

Scene make(const std::string& name, std::int64_t triangles, std::uint32_t seed = 1) {
    return io::generate_scene(name, {triangles, seed}, "test");
}

std::int64_t count(const Scene& scene) {
    std::int64_t n = 0;
    for (const Mesh& mesh : scene.meshes) n += std::int64_t(mesh.triangles.size());
    return n;
}

std::uint64_t hash_of(const Scene& scene) {
    std::uint64_t hash = 0;
    for (const Mesh& m : scene.meshes) {
        hash = content_hash(m.vertices.data(), m.vertices.size() * sizeof(Vertex), hash);
        hash = content_hash(m.triangles.data(), m.triangles.size() * sizeof(glm::uvec3), hash);
        hash = content_hash(m.tangents.data(), m.tangents.size() * sizeof(glm::vec4), hash);
        hash = content_hash(m.material.data(), m.material.size() * sizeof(std::int32_t), hash);
    }
    for (const Texture& t : scene.textures) hash = content_hash(t.texels, hash);
    return hash;
}

// Soundness of what a mesh says: "" or the first fault.
std::string fault(const Scene& scene) {
    for (const Mesh& m : scene.meshes) {
        if (m.triangles.empty() || m.triangles.size() != m.material.size()) return m.name + ": triangles";
        for (std::size_t t = 0; t < m.triangles.size(); ++t) {
            const std::string at = m.name + ": triangle " + std::to_string(t);
            if (m.material[t] < 0 || m.material[t] >= int(scene.materials.size())) return at + ": material";
            glm::dvec3 p[3];
            for (int k = 0; k < 3; ++k) {
                if (m.triangles[t][k] >= m.vertices.size()) return at + ": index";
                const Vertex& v = m.vertices[m.triangles[t][k]];
                p[k] = glm::dvec3(v.position);
                // Three floats of a unit vector are each off by half an ulp at most.
                if (!(std::abs(glm::length(glm::dvec3(v.normal)) - 1) < 2e-7)) return at + ": normal";
                if (!(std::abs(v.u) < 100 && std::abs(v.v) < 100)) return at + ": texture coordinates";
            }
            if (!(glm::length(glm::cross(p[1] - p[0], p[2] - p[0])) > 1e-9)) return at + ": no area";
        }
    }
    for (const Material& m : scene.materials) {
        if (m.texture >= int(scene.textures.size())) return m.name + ": texture";
        for (int c = 0; c < 3; ++c)
            if (!(m.reflectance[c] > 0 && m.reflectance[c] <= 1)) return m.name + ": reflectance";
    }
    return "";
}

// How often an edge between two positions is not one triangle's forth and another's back.
std::int64_t open_edges(const Mesh& mesh) {
    using Key = std::array<float, 6>;
    std::map<Key, int> balance;
    std::int64_t uses = 0;
    for (const glm::uvec3& t : mesh.triangles)
        for (int k = 0; k < 3; ++k) {
            const glm::vec3 a = mesh.vertices[t[k]].position, b = mesh.vertices[t[(k + 1) % 3]].position;
            ++balance[Key{a.x, a.y, a.z, b.x, b.y, b.z}], --balance[Key{b.x, b.y, b.z, a.x, a.y, a.z}];
            ++uses;
        }
    REQUIRE(uses > 0);
    std::int64_t open = 0;
    for (const auto& [key, n] : balance) open += n != 0;
    return open;
}

struct Hit {
    double distance = 1e30;
    bool front = false;
    std::string mesh;
};
Hit trace(const Scene& scene, const glm::dvec3& origin, const glm::dvec3& direction) {
    Hit nearest;
    for (const Mesh& m : scene.meshes)
        for (std::size_t t = 0; t < m.triangles.size(); ++t) {
            if (scene.materials[std::size_t(m.material[t])].alpha_cutoff > 0) continue;
            const glm::dvec3 a(m.vertices[m.triangles[t].x].position), b(m.vertices[m.triangles[t].y].position),
                c(m.vertices[m.triangles[t].z].position);
            // Moeller and Trumbore 1997.
            const glm::dvec3 e1 = b - a, e2 = c - a, p = glm::cross(direction, e2), s = origin - a;
            const double det = glm::dot(e1, p), u = glm::dot(s, p) / det;
            if (!(u >= 0 && u <= 1)) continue;
            const glm::dvec3 q = glm::cross(s, e1);
            const double v = glm::dot(direction, q) / det, distance = glm::dot(e2, q) / det;
            if (!(v >= 0 && u + v <= 1 && distance > 0 && distance < nearest.distance)) continue;
            nearest = {distance, det > 0, m.name};
        }
    return nearest;
}

// Rays from inside [low, high] into all directions: what they meet faces them, or they leave through an opening.
void check_rays(const Scene& scene, const glm::dvec3& low, const glm::dvec3& high, int rays,
                const std::function<bool(const glm::dvec3&, const glm::dvec3&)>& may_leave) {
    int left = 0, met = 0;
    for (int i = 0; i < rays; ++i) {
        auto random = [&](int k) {
            return double(unit_float<float>(pixel_hash<std::int32_t>(i, k, 0, 99).x));
        };
        const glm::dvec3 origin = low + (high - low) * glm::dvec3(random(0), random(1), random(2));
        const double y = 2 * random(3) - 1, angle = 6.283185307 * random(4), r = std::sqrt(1 - y * y);
        const glm::dvec3 direction(r * std::cos(angle), y, r * std::sin(angle));
        const Hit hit = trace(scene, origin, direction);
        INFO("from " << origin.x << " " << origin.y << " " << origin.z << " along " << direction.x << " " << direction.y
                     << " " << direction.z << ": " << hit.mesh << " after " << hit.distance << " m");
        if (hit.distance > 1e29) {
            CHECK(may_leave(origin, direction));
            ++left;
        } else {
            CHECK(hit.front);
            ++met;
        }
    }
    CHECK(left > 0);
    CHECK(met > rays / 2);
}

}  // namespace

TEST_CASE("atrium and hall: as many triangles as asked for, within 5 percent", "[scenes]") {
    for (const char* name : {"atrium", "hall"})
        for (const double wanted : {14e3, 3e4, 7e4, 262e3, 1e6}) {
            const Scene scene = make(name, std::int64_t(wanted));
            INFO(name << ": " << wanted << ", made " << count(scene));
            CHECK(std::abs(double(count(scene)) - wanted) < 0.05 * wanted);
            CHECK(fault(scene) == "");
        }
}

TEST_CASE("atrium and hall: cloth and spheres are closed", "[scenes]") {
    for (const char* name : {"atrium", "hall"}) {
        int closed = 0;
        for (const Mesh& mesh : make(name, 60'000).meshes) {
            const bool cloth = mesh.name.rfind("curtain", 0) == 0 || mesh.name.rfind("banner", 0) == 0;
            if (!cloth && mesh.name != "sphere") continue;
            INFO(name << ": " << mesh.name);
            CHECK(open_edges(mesh) == 0);
            ++closed;
        }
        CHECK(closed >= 9);
    }
}

TEST_CASE("atrium: light leaves the court and its galleries through the open roof only", "[scenes]") {
    const Scene scene = make("atrium", 30'000);
    // The eaves: 12 - 0.2 - 0.75 and 4.5 - 0.2 - 0.75 from the middle, 11.05 m above the floor.
    auto through_roof = [](const glm::dvec3& from, const glm::dvec3& along) {
        if (!(along.y > 0)) return false;
        const glm::dvec3 at = from + (11.05 - from.y) / along.y * along;
        return std::abs(at.x) < 11.06 && std::abs(at.z) < 3.56;
    };
    check_rays(scene, {-10, 2, -2.5}, {-3, 9, 2.5}, 400, through_roof);
    check_rays(scene, {-9, 1.5, 5.9}, {9, 3, 6.2}, 300, through_roof);
    check_rays(scene, {-9, 7.3, 5.5}, {9, 9.5, 6.5}, 300, through_roof);
}

TEST_CASE("hall: light leaves through the arches of the open side and the skylights only", "[scenes]") {
    const Scene scene = make("hall", 30'000);
    auto through_opening = [](const glm::dvec3& from, const glm::dvec3& along) {
        // Over the terrace's wall: the arches end at 7.2 m. Skylights: 2.5 m deep from rim to rim around the crown.
        const glm::dvec3 side = from + (14.4 - from.z) / along.z * along, top = from + (16 - from.y) / along.y * along;
        const double bay = side.x - 6 * std::floor(side.x / 6) - 3;
        if (along.z > 0 && side.y > 0 && side.y < 7.25 && std::abs(bay) < 2.25) return true;
        return along.y > 0 && std::abs(top.z) < 1.65 && std::abs(top.x - 6 * std::floor(top.x / 6) - 3) < 1.95;
    };
    check_rays(scene, {-25, 2.5, -2.5}, {10, 9, 2.5}, 400, through_opening);
    check_rays(scene, {-28, 1, -12}, {28, 9, -9}, 300, through_opening);
    check_rays(scene, {-28, 1, 9}, {28, 9, 12}, 300, through_opening);
}

TEST_CASE("atrium and hall: the same bytes on every machine", "[scenes]") {
    // From this program, on x86-64 with gcc 12; no other source.
    const Scene atrium = make("atrium", 262'000), hall = make("hall", 150'000);
    CHECK(hash_text(hash_of(atrium)) == "c9a9127fb8d0e1ee");
    CHECK(hash_text(hash_of(hall)) == "5531ff320712c89c");
    CHECK(hash_of(make("atrium", 262'000, 2)) == hash_of(atrium));
    CHECK(make("atrium", 262'000, 2).camera.position != atrium.camera.position);
}

TEST_CASE("atrium and hall: time to generate", "[.benchmark]") {
    for (const char* name : {"atrium", "hall"})
        for (const std::int64_t triangles : {20'000, 262'000, 4'000'000}) {
            const auto start = std::chrono::steady_clock::now();
            const std::int64_t made = count(make(name, triangles));
            const auto end = std::chrono::steady_clock::now();
            const double ms = std::chrono::duration<double, std::milli>(end - start).count();
            std::printf("%s: %lld triangles in %.0f ms\n", name, static_cast<long long>(made), ms);
        }
}
