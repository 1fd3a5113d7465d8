// plumb validate: depth buffers and matrices in place of what follows from them.
#include "tests/program/vocabulary.h"

using namespace plumb;
using namespace plumb::program;
using Catch::Matchers::Contains;

namespace {

// The four habits of clip space.
struct Clip {
    bool below_zero, reversed, y_up, left_handed;
};
glm::dmat4 projection(const Clip& clip, double near, double far) {
    // Of a viewer that looks along -z; along +z where it is left-handed.
    const double f = 2.8, a = double(width) / height, toward = clip.left_handed ? 1 : -1;
    const double low = clip.below_zero ? -1 : 0, at_near = clip.reversed ? 1 : low, at_far = clip.reversed ? low : 1;
    // z_clip = p d + q with p + q / n = z at the near plane, p + q / f = z at the far one; d is the distance.
    const double q = (at_near - at_far) / (1 / near - 1 / far), p = at_near - q / near;
    glm::dmat4 m(0);
    m[0][0] = f / a, m[1][1] = clip.y_up ? f : -f, m[2][2] = toward * p, m[3][2] = q, m[2][3] = toward;
    return m;
}

}  // namespace

TEST_CASE("validate: positions out of a depth buffer", "[program][vocabulary]") {
    for (const Clip& clip : {Clip{false, false, false, false}, Clip{true, false, true, false}, Clip{false, true, false, true},
                             Clip{false, true, true, false}}) {
        CAPTURE(clip.below_zero, clip.reversed, clip.y_up, clip.left_handed);
        Exported e("vocabulary_depth");
        // Seen from where the scene's camera stands, with its angle: positions are about those of the scene.
        glm::dmat4 view(1);
        view[3] = glm::dvec4(0, -0.995, -3.934, 1);
        if (clip.left_handed)
            for (int c = 0; c < 4; ++c) view[c][2] = -view[c][2];
        const glm::dmat4 clip_of = projection(clip, 0.1, 50) * view, to_world = glm::inverse(clip_of);
        const glm::mat4 m = rounded(to_world);
        std::vector<float> depth;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                // Nothing is there where nothing was drawn.
                const double d = 3.934 - double(e.position[4 * pixel(x, y) + 2]);
                const glm::dmat4 p = projection(clip, 0.1, 50);
                const double z = p[2][2] * p[2][3] + p[3][2] / d;
                const bool seen = e.normal[4 * pixel(x, y) + 3] > 0;
                depth.push_back(!seen ? (clip.reversed ? 0.0f : 1.0f) : float(clip.below_zero ? 0.5 * z + 0.5 : z));
            }
        depth[pixel(30, 20)] = clip.reversed ? 0.0f : 1.0f;  // nothing there
        write_words(e.folder + "/depth.raw", depth);
        gather(e, [&](int x, int y) {
            const float d = depth[pixel(x, y)];
            if (d == (clip.reversed ? 0.0f : 1.0f)) return Point{glm::vec3(0), xyz(e.normal, pixel(x, y))};
            const glm::vec2 uv((float(x) + 0.5f) * (1.0f / width), (float(y) + 0.5f) * (1.0f / height));
            const float down = uv.y * 2.0f - 1.0f;
            const glm::vec4 h = m * glm::vec4(uv.x * 2.0f - 1.0f, clip.y_up ? -down : down,
                                              clip.below_zero ? 2.0f * d - 1.0f : d, 1.0f);
            return Point{glm::vec3(h) / h.w, xyz(e.normal, pixel(x, y))};
        });
        const std::string manifest = e.manifest;
        auto with = [&](const glm::dmat4& matrix, const std::string& more) {
            e.manifest = manifest;
            e.replace_input("position", "file = \"depth.raw\"\nvk_format = \"D32_SFLOAT\"\n[stage.input.position.from_depth]\n"
                                        "inverse_view_proj = { columns = " + list(matrix, false) + " }\n" + more);
        };
        const std::int64_t nothing = std::count(depth.begin(), depth.end(), clip.reversed ? 0.0f : 1.0f);
        const std::string right = std::string(clip.below_zero ? "clip_depth = [-1, 1]\n" : "") +
                                  (clip.reversed ? "reversed_z = true\n" : "") + (clip.y_up ? "y = \"up\"\n" : "");
        with(to_world, right);
        const Json stage = e.judged(0);
        CHECK(stage["counts"]["wrong"] == 0);
        CHECK(stage["left_out"] == nothing);
        CHECK(stage["counts"]["equal"].get<int>() + stage["counts"]["within_bound"].get<int>() > 2600 - nothing);
        // Each habit mistaken is told.
        with(to_world, clip.below_zero ? replaced(right, "clip_depth = [-1, 1]\n", "") : right + "clip_depth = [-1, 1]\n");
        CHECK(e.judged(1)["wrong"] > 0.1);
        with(to_world, clip.y_up ? replaced(right, "y = \"up\"\n", "") : right + "y = \"up\"\n");
        CHECK(e.judged(1)["wrong"] > 0.1);
        with(clip_of, right);
        CHECK(e.judged(1)["wrong"] > 0.1);
        // The matrix itself, of which the shader has the inverse.
        with(clip_of, right);
        e.manifest = replaced(e.manifest, "inverse_view_proj", "view_proj");
        CHECK(e.judged(0)["counts"]["wrong"] == 0);
        with(to_world, right);
        e.manifest = replaced(e.manifest, "inverse_view_proj", "view_proj");
        CHECK(e.judged(1)["wrong"] > 0.1);
    }
}

TEST_CASE("validate: a light's matrix instead of rows in texels, and what is harmless", "[program][vocabulary]") {
    Exported e("vocabulary_matrix");
    write_expected(e.folder);
    const Words rows = {"map.to_texel_x", "map.to_texel_y", "map.to_texel_w", "map.size"};
    const Words harmless = {"map.least_w", "map.low", "map.high", "seed", "least_distance2"};
    const Row w{double(e.row_w[0]), double(e.row_w[1]), double(e.row_w[2]), double(e.row_w[3])};
    // Any z will do where rays meet in the eye.
    const Row z{0.5 * w[0], 0.5 * w[1], 0.5 * w[2], 0.5 * w[3] - 0.01};
    const std::string bare = without(without(e.manifest, rows), harmless);
    auto with = [&](const std::string& lines) {
        const std::size_t at = bare.find("[stage.input.");
        e.manifest = bare.substr(0, at) + lines + bare.substr(at);
    };
    for (const bool up : {false, true}) {
        with("[stage.light_view_proj]\n" +
             rows_of({clip_row(e.row_x, e.row_w, map_side), clip_row(e.row_y, e.row_w, map_side, up), z, w}) +
             (up ? "y = \"up\"\nclip_depth = [-1, 1]\n" : ""));
        const Json stage = e.judged(0);
        CHECK(stage["counts"]["wrong"] == 0);
        CHECK_THAT(stage["notes"].at(0), Contains("taken as harmless: ") && Contains("map.least_w = 1e-06") &&
                                             Contains("map.low = -1048576") && Contains("least_distance2 = 1e-37") &&
                                             Contains("seed = 0"));
    }
    with("[stage.light_view_proj]\n" +
         rows_of({clip_row(e.row_x, e.row_w, map_side), clip_row(e.row_y, e.row_w, map_side), z, w}) + "y = \"up\"\n");
    CHECK(e.judged(1)["wrong"] > 0.1);
    // Nothing gives the rows, or both do; a matrix that is none; a view that the block has not.
    e.manifest = bare;
    CHECK_THAT(e.refused(), Contains("missing: map.to_texel_x, map.to_texel_y, map.to_texel_w, map.size;"));
    const std::string matrix = rows_of({clip_row(e.row_x, e.row_w, map_side), clip_row(e.row_y, e.row_w, map_side), z, w});
    with("\"map.to_texel_w\" = [0, 0, 0, 1]\n[stage.light_view_proj]\n" + matrix);
    CHECK_THAT(e.refused(), Contains("gives map.to_texel_w, which [stage.uniforms] gives, too"));
    with("[stage.light_view_proj]\n" + rows_of({z, z, z, w}));
    CHECK_THAT(e.refused(), Contains("is no view"));
    with("[stage.view_proj.view]\n" + matrix);
    CHECK_THAT(e.refused(), Contains("has no view \"view\""));
    with("[stage.light_view_proj]\n" + matrix + "[stage.view_proj.map]\n" + matrix);
    CHECK_THAT(e.refused(), Contains("is given twice"));
    with("[stage.light_view_proj]\nrows = [1]\n");
    CHECK_THAT(e.refused(), Contains("light_view_proj of stage 1 (rsm.disc): rows") && Contains("expected 16 numbers, 1 given"));
    // Where pixels have rotations, the seed matters.
    with("[stage.light_view_proj]\n" + matrix);
    e.manifest = replaced(e.manifest, "rotations = 1\n", "rotations = 2\n");
    CHECK_THAT(e.refused(), Contains("missing: seed;"));
}

TEST_CASE("validate: shadow tests by a light's matrix", "[program][vocabulary]") {
    for (const std::string light : {"key", "sun"}) {
        INFO(light);
        const std::string folder = fresh_folder("vocabulary_shadow");
        REQUIRE(run({"export", small_scene(folder), "--stage", "shadow", "--light", light, "-o", folder}).exit == 0);
        write_expected(folder);
        const std::string manifest = read(folder + "/manifest.toml");
        const int side = int(uniform_of(manifest, "map.size").at(0));
        const auto x = uniform_of(manifest, "map.to_texel_x"), y = uniform_of(manifest, "map.to_texel_y");
        const auto w = uniform_of(manifest, "map.to_texel_w"), eye = uniform_of(manifest, "eye");
        const auto forward = uniform_of(manifest, "forward");
        const std::string bare = without(manifest, {"map.to_texel_x", "map.to_texel_y", "map.to_texel_w", "map.size", "eye",
                                                    "forward", "perspective", "footprint_scale", "footprint_base"});
        for (const int habit : {0, 1, 2}) {
            CAPTURE(habit);
            // Depth over 9 m: 0 to 1, 1 to 0, -1 to 1.
            const double scale = habit == 0 ? 1 / 9.0 : habit == 1 ? -1 / 9.0 : 2 / 9.0, at_eye = habit == 2 ? -1 : habit;
            Row z{scale * double(forward[0]), scale * double(forward[1]), scale * double(forward[2]), at_eye};
            for (std::size_t c = 0; c < 3; ++c) z[3] -= z[c] * double(eye[c]);
            const Row row_w{double(w[0]), double(w[1]), double(w[2]), double(w[3])};
            const std::size_t at = bare.find("[stage.input.");
            const std::string lines = "[stage.light_view_proj]\n" +
                                      rows_of({clip_row(x, w, side), clip_row(y, w, side, habit == 2), z, row_w});
            auto counts = [&](const std::string& more, int exit) {
                write(folder + "/manifest.toml", bare.substr(0, at) + lines + more + bare.substr(at));
                const Result r = run({"validate", folder + "/manifest.toml", "--json"});
                INFO(r.out << r.err);
                REQUIRE(r.exit == exit);
                return Json::parse(r.out)["stages"][0];
            };
            const std::string right = habit == 1 ? "reversed_z = true\n" : habit == 2 ? "clip_depth = [-1, 1]\ny = \"up\"\n" : "";
            const Json stage = counts(right, 0);
            CHECK(stage["counts"]["wrong"] == 0);
            CHECK(stage["counts"]["equal"] == width * height);
            if (habit == 2) CHECK(counts("clip_depth = [-1, 1]\n", 1)["wrong"] > 0.01);
            // Of parallel rays the depth has to grow away from the light.
            if (habit == 1 && light == "sun") CHECK(counts("", 1)["wrong"] > 0.01);
        }
    }
}
