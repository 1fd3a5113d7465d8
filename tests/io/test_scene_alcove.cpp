// The generated scene `alcove`: sound, static, with normal maps that tile, the same everywhere.
#include <catch2/catch.hpp>

#include "core/content_hash.h"
#include "io/scenes/generate.h"
#include "scene_checks.h"

using namespace plumb;

TEST_CASE("alcove: as many triangles as asked for, sound, with normal maps and tangents", "[scenes]") {
    for (const std::int64_t wanted : {60, 1200, 20'000}) {
        const Scene s = io::generate_scene("alcove", {wanted, 1}, "test");
        INFO(wanted << ", made " << triangle_count(s));
        CHECK(std::abs(double(triangle_count(s) - wanted)) < 0.3 * double(wanted));
        const Faults f = faults_of(s);
        CHECK(f.index == 0);
        CHECK(f.area == 0);
        CHECK(f.normal == 0);
        CHECK(f.side == 0);
        CHECK(f.coordinate == 0);
        for (const Mesh& mesh : s.meshes) {
            CHECK_FALSE(mesh.dynamic);
            REQUIRE(mesh.tangents.size() == mesh.vertices.size());
            for (const std::int32_t m : mesh.material) CHECK(s.materials[std::size_t(m)].normal_texture >= 0);
        }
    }
}

TEST_CASE("alcove: its normal maps point outwards and bend at the joints alone", "[scenes]") {
    const Scene s = io::generate_scene("alcove", {0, 1}, "test");
    for (const Material& m : s.materials) {
        const Texture& t = s.textures[std::size_t(m.normal_texture)];
        CHECK_FALSE(t.srgb);
        double least = 1;
        int bent = 0;
        for (const std::uint32_t texel : t.texels.texels) {
            const double c = double(texel >> 16 & 255) / 127.5 - 1;
            least = std::min(least, c), bent += c < 0.9;
        }
        const double texels = double(t.texels.size());
        CAPTURE(m.name, least, bent / texels);
        CHECK(least > 0);
        CHECK(bent > 0.01 * texels);
        CHECK(bent < 0.4 * texels);
    }
}
