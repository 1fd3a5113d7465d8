// Kept references: what their key depends on, how many are kept, and where.
#include <stdlib.h>
#include <sys/resource.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>
#include <optional>
#include <set>

#include "core/content_hash.h"
#include "gi/reference/ray_query.h"
#include "io/file.h"
#include "tests/io/bundle_bytes.h"
#include "tools/shared/reference_files.h"
#include "tools/shared/truth.h"

using namespace plumb;
using namespace plumb::cli;
namespace fs = std::filesystem;

namespace {

// One triangle, one of each thing that a ray can meet.
Scene small() {
    Scene s;
    Mesh mesh;
    mesh.vertices = {{{0, 0, 0}, 0, {0, 0, 1}, 0}, {{1, 0, 0}, 1, {0, 0, 1}, 0}, {{0, 1, 0}, 0, {0, 0, 1}, 1}};
    mesh.tangents.assign(3, {1, 0, 0, 1});
    mesh.triangles = {{0, 1, 2}};
    mesh.material = {0};
    s.meshes.push_back(mesh);
    Material material;
    material.normal_texture = 0;
    s.materials.push_back(material);
    Texture texture;
    texture.texels = Image<std::uint32_t>(2, 2, 0xff808080);
    s.textures.push_back(texture);
    s.lights.emplace_back();
    s.environment.map = Image4(2, 1, glm::vec4(1));
    return s;
}

struct Request {
    reference::PathParams params;
    Scene scene = small();
    std::uint32_t seed = 1;
    Isa isa = Isa::sse;

    std::uint64_t key() const { return reference::cache_key(params, scene, flatten(scene), seed, isa); }
};

std::string fresh_folder(const char* name) {
    const std::string folder = std::string(PLUMB_BINARY_DIR) + "/tools_tests/" + name;
    fs::remove_all(folder);
    return folder;
}

reference::KeptEstimate kept_of(glm::ivec2 size, float value) {
    reference::KeptEstimate kept;
    kept.estimate.mean = Image4(size.x, size.y, glm::vec4(value, 2 * value, 3 * value, 0));
    kept.estimate.error = Image4(size.x, size.y, glm::vec4(0.1f * value));
    kept.estimate.samples = 48;
    kept.estimate.rounds = 16;
    kept.estimate.rays = 123456789012345;
    kept.estimate.nonfinite = 7;
    kept.estimate.relative_error = 0.0123;
    kept.ms = 4.5;
    return kept;
}

}  // namespace

TEST_CASE("cache key: changes with everything that a bit can depend on", "[tools][cache]") {
    using Change = std::function<void(Request&)>;
    const std::vector<Change> changes = {
        [](Request& r) { r.seed = 2; },
        [](Request& r) { r.isa = Isa::avx2; },  // of native rays
        [](Request& r) { r.scene.frame_size.x = 512; },
        [](Request& r) { r.scene.camera.position.x += 1e-9; },
        [](Request& r) { r.scene.camera.look_at.y = 1; },
        [](Request& r) { r.scene.camera.up = {1, 0, 0}; },
        [](Request& r) { r.scene.camera.fov_y_deg = 46; },
        [](Request& r) { r.scene.camera.near = 0.2; },
        [](Request& r) { r.scene.camera.far = 50; },
        [](Request& r) { r.scene.meshes[0].vertices[1].position.x = 1.0000001f; },
        [](Request& r) { r.scene.meshes[0].vertices[1].normal = {0, 1, 0}; },
        [](Request& r) { r.scene.meshes[0].vertices[1].u = 0.5f; },
        [](Request& r) { r.scene.meshes[0].tangents[1].w = -1; },
        [](Request& r) { r.scene.meshes[0].triangles = {{0, 2, 1}}; },
        [](Request& r) { r.scene.meshes[0].transform[3][0] = 1; },
        [](Request& r) { r.scene.meshes[0].share = 0; },
        [](Request& r) { r.scene.meshes.push_back(r.scene.meshes[0]); },
        [](Request& r) {
            r.scene.materials.push_back(r.scene.materials[0]);
            r.scene.meshes[0].material = {1};
        },
        [](Request& r) { r.scene.materials[0].reflectance.y = 0.6f; },
        [](Request& r) { r.scene.materials[0].emission.z = 1; },
        [](Request& r) { r.scene.materials[0].texture = 0; },
        [](Request& r) { r.scene.materials[0].emission_texture = 0; },
        [](Request& r) { r.scene.materials[0].normal_texture = -1; },
        [](Request& r) { r.scene.textures.push_back(r.scene.textures[0]); },
        [](Request& r) {
            r.scene.textures.push_back(r.scene.textures[0]);
            r.scene.materials[0].normal_texture = 1;
        },
        [](Request& r) { r.scene.materials[0].normal_scale = 2; },
        [](Request& r) { r.scene.materials[0].alpha = 0.5f; },
        [](Request& r) { r.scene.materials[0].alpha_cutoff = 0.5f; },
        [](Request& r) { r.scene.materials[0].specular.x = 0.1f; },
        [](Request& r) { r.scene.materials[0].exponent = 51; },
        [](Request& r) { r.scene.materials[0].mirror.x = 0.1f; },
        [](Request& r) { r.scene.materials[0].microfacet = true; },
        [](Request& r) { r.scene.materials[0].metalness = 0.1f; },
        [](Request& r) { r.scene.materials[0].roughness = 0.9f; },
        [](Request& r) { r.scene.materials[0].surface_texture = 0; },
        [](Request& r) { r.scene.textures[0].texels(1, 1) = 0; },
        [](Request& r) { r.scene.textures[0].srgb = false; },
        [](Request& r) { r.scene.textures[0].filter = Filter::nearest; },
        [](Request& r) { r.scene.textures[0].wrap_u = Wrap::clamp_to_edge; },
        [](Request& r) { r.scene.textures[0].wrap_v = Wrap::clamp_to_edge; },
        [](Request& r) { r.scene.textures[0].mips = true; },
        [](Request& r) { r.scene.lights.clear(); },
        [](Request& r) { r.scene.lights[0].type = LightType::point; },
        [](Request& r) { r.scene.lights[0].position.x = 1; },
        [](Request& r) { r.scene.lights[0].direction = {1, 0, 0}; },
        [](Request& r) { r.scene.lights[0].cone_inner_deg = 39; },
        [](Request& r) { r.scene.lights[0].cone_outer_deg = 46; },
        [](Request& r) { r.scene.lights[0].intensity.y = 2; },
        [](Request& r) { r.scene.lights[0].on = false; },
        [](Request& r) { r.scene.environment.radiance.x = 1; },
        [](Request& r) { r.scene.environment.map(1, 0).x = 2; },
        [](Request& r) { r.scene.environment.map = Image4(1, 2, glm::vec4(1)); },
    };
    std::set<std::uint64_t> keys = {Request().key()};
    for (std::size_t i = 0; i < changes.size(); ++i) {
        Request request;
        changes[i](request);
        CAPTURE(i);
        CHECK(keys.insert(request.key()).second);
    }

    // Every parameter there is.
    reference::PathParams defaults;
    for (std::size_t i = 0; i < reference::fields(defaults).size(); ++i) {
        Request request;
        const Field field = reference::fields(request.params)[i];
        CAPTURE(field.name);
        if (const auto p = std::get_if<int*>(&field.value)) **p += **p > 0 && !field.choices.empty() ? -1 : 1;
        if (const auto p = std::get_if<float*>(&field.value)) **p += 0.25f;
        CHECK(keys.insert(request.key()).second);
    }

    // Points in place of the camera.
    const Request r;
    const Geometry geometry = flatten(r.scene);
    const Image4 a(2, 2, glm::vec4(1)), b(2, 2, glm::vec4(2)), c(4, 1, glm::vec4(1));
    for (const reference::PointInputs& points :
         {reference::PointInputs{&a, &a}, reference::PointInputs{&a, &b}, reference::PointInputs{&b, &a},
          reference::PointInputs{&c, &c}})
        CHECK(keys.insert(reference::cache_key(r.params, r.scene, geometry, points, r.seed, r.isa)).second);
}

TEST_CASE("cache key: does not change with names, conventions and other stages", "[tools][cache]") {
    const std::uint64_t key = Request().key();
    Request r;
    r.scene.name = "other.toml";
    r.scene.meshes[0].name = r.scene.materials[0].name = r.scene.textures[0].name = r.scene.lights[0].name = "other";
    r.scene.convention = Convention::d3d9;
    r.scene.camera.reversed_z = true;
    r.scene.lights[0].rsm_size = 8;
    r.scene.method = "direct";
    r.scene.layout = "isr";
    r.scene.settings.push_back({"rsm", "samples", 4.0, ""});
    CHECK(r.key() == key);
    // A mesh moved by its transform is the mesh with moved vertices.
    Request moved, placed;
    moved.scene.meshes[0].transform[3][0] = 1;
    for (Vertex& v : placed.scene.meshes[0].vertices) v.position.x += 1;
    CHECK(moved.key() == placed.key());
    // Exact rays are the same bits by every instruction set.
    Request exact, wide;
    exact.params.rays = wide.params.rays = Rays::exact;
    wide.isa = Isa::avx512;
    CHECK(exact.key() == wide.key());
}

TEST_CASE("cache key: knows the version of Embree that runs", "[tools][cache]") {
    const std::string version = reference::embree_version();
    CHECK(version.substr(0, 2) == "3.");
    CHECK(std::count(version.begin(), version.end(), '.') == 2);
}

TEST_CASE("kept references: are named after their key and the program's bytes", "[tools][cache]") {
    const std::string folder = fresh_folder("named");
    ReferenceFiles(folder).keep(7, kept_of({1, 1}, 1));
    const std::vector<unsigned char> program = io::read_bytes("/proc/self/exe");
    const std::uint64_t key = 7, own = content_hash(&key, sizeof key, content_hash(program.data(), program.size()));
    CHECK(fs::directory_iterator(folder)->path().filename() == hash_text(own) + ".reference");
}

TEST_CASE("kept references: come back to the bit, for their key and size alone", "[tools][cache]") {
    ReferenceFiles files(fresh_folder("kept"));
    CHECK_FALSE(files.find(1, {3, 2}));
    reference::KeptEstimate kept = kept_of({3, 2}, 1);
    kept.estimate.mean(1, 1).x = std::numeric_limits<float>::quiet_NaN();
    files.keep(1, kept);
    CHECK(files.notes().empty());
    const auto found = files.find(1, {3, 2});
    REQUIRE(found);
    CHECK(content_hash(found->estimate.mean) == content_hash(kept.estimate.mean));
    CHECK(content_hash(found->estimate.error) == content_hash(kept.estimate.error));
    CHECK(found->estimate.samples == 48);
    CHECK(found->estimate.rounds == 16);
    CHECK(found->estimate.rays == 123456789012345);
    CHECK(found->estimate.nonfinite == 7);
    CHECK(found->estimate.relative_error == 0.0123);
    CHECK(found->ms == 4.5);
    CHECK_FALSE(files.find(2, {3, 2}));
    CHECK(files.notes().empty());
    CHECK_FALSE(files.find(1, {2, 3}));
    CHECK(files.notes().size() == 1);
}

TEST_CASE("kept references: a file larger than its picture is not read", "[tools][cache]") {
    const std::string folder = fresh_folder("large");
    ReferenceFiles files(folder);
    files.keep(1, kept_of({3, 2}, 1));
    const fs::path path = fs::directory_iterator(folder)->path();
    fs::resize_file(path, std::uintmax_t(100) << 20);  // a sparse one: it takes no room
    CHECK_FALSE(files.find(1, {3, 2}));
    // 2 pictures of 3 x 2 x 16 bytes, and 64 KiB for all else.
    CHECK(files.notes() == std::vector<std::string>{path.string() +
                                                    ": 104857600 bytes: expected at most 65728; traced anew"});
    files.keep(1, kept_of({3, 2}, 1));
    CHECK(files.find(1, {3, 2}));
}

// The sanitizer ends the program where memory runs out.
#ifndef PLUMB_SANITIZED
TEST_CASE("kept references: where memory runs out they are not there", "[tools][cache]") {
    const std::string folder = fresh_folder("memory");
    ReferenceFiles files(folder);
    const glm::ivec2 size(4096, 4096);
    files.keep(1, kept_of({3, 2}, 1));
    // A sparse file of one array, for which there is no room.
    const fs::path path = fs::directory_iterator(folder)->path();
    const std::string head = io::bundle_head(
        R"({"arrays":[{"name":"x","type":"u8","shape":[536870912],"offset":0,"checksum":"0000000000000000"}]})", 1 << 29);
    std::ofstream(path, std::ios::binary) << head;
    fs::resize_file(path, head.size() + (std::uintmax_t(1) << 29));
    REQUIRE(files.find(1, {3, 2}) == std::nullopt);
    rlimit before{};
    REQUIRE(getrlimit(RLIMIT_DATA, &before) == 0);
    rlimit low = before;
    low.rlim_cur = 1 << 27;
    REQUIRE(setrlimit(RLIMIT_DATA, &low) == 0);
    const auto found = files.find(1, size);
    REQUIRE(setrlimit(RLIMIT_DATA, &before) == 0);
    CHECK_FALSE(found);
    REQUIRE(files.notes().size() == 2);
    CHECK(files.notes()[1].find(": out of memory; traced anew") != std::string::npos);
}
#endif

TEST_CASE("kept references: those used last stay, the others go", "[tools][cache]") {
    const std::string folder = fresh_folder("bound");
    const glm::ivec2 size(64, 64);
    constexpr std::uint64_t bytes = 2 * 16 * 64 * 64;
    ReferenceFiles files(folder, 3 * bytes + bytes / 2);
    auto age = [&] {
        for (const fs::directory_entry& e : fs::directory_iterator(folder))
            fs::last_write_time(e.path(), fs::last_write_time(e.path()) - std::chrono::hours(48));
    };
    for (std::uint64_t key = 1; key <= 3; ++key) {
        files.keep(key, kept_of(size, float(key)));
        age();
    }
    CHECK(files.find(1, size));  // is used again
    // What a killed run left goes when it is a day old; what is not ours stays.
    fs::create_directories(folder);
    for (const char* name : {".0123456789abcdef.reference.1-0.part", ".0123456789abcdef.reference.2-0.part", "notes.txt"})
        fs::copy_file(fs::directory_iterator(folder)->path(), folder + "/" + name);
    fs::last_write_time(folder + "/.0123456789abcdef.reference.1-0.part",
                        fs::file_time_type::clock::now() - std::chrono::hours(25));
    fs::last_write_time(folder + "/notes.txt", fs::file_time_type::clock::now() - std::chrono::hours(1000));
    files.keep(4, kept_of(size, 4));
    CHECK(files.find(1, size));
    CHECK_FALSE(files.find(2, size));
    CHECK(files.find(3, size));
    CHECK(files.find(4, size));
    CHECK_FALSE(fs::exists(folder + "/.0123456789abcdef.reference.1-0.part"));
    CHECK(fs::exists(folder + "/.0123456789abcdef.reference.2-0.part"));
    CHECK(fs::exists(folder + "/notes.txt"));

    // One that is larger than all the room is not kept, and pushes nothing out.
    files.keep(5, kept_of({256, 256}, 5));
    CHECK_FALSE(files.find(5, {256, 256}));
    CHECK(files.find(4, size));
    CHECK(files.notes().empty());
}

TEST_CASE("kept references: $PLUMB_CACHE, else $XDG_CACHE_HOME, else the home folder", "[tools][cache]") {
    std::vector<std::pair<std::string, std::optional<std::string>>> before;
    for (const char* name : {"PLUMB_CACHE", "XDG_CACHE_HOME", "HOME"}) {
        const char* value = getenv(name);
        before.emplace_back(name, value ? std::optional<std::string>(value) : std::nullopt);
    }
    setenv("PLUMB_CACHE", "/a", 1);
    setenv("XDG_CACHE_HOME", "/b", 1);
    setenv("HOME", "/c", 1);
    CHECK(cache_folder() == "/a");
    setenv("PLUMB_CACHE", "", 1);
    CHECK(cache_folder() == "/b/plumbline");
    unsetenv("XDG_CACHE_HOME");
    CHECK(cache_folder() == "/c/.cache/plumbline");
    unsetenv("HOME");
    CHECK(cache_folder().empty());
    for (const auto& [name, value] : before) {
        if (value)
            setenv(name.c_str(), value->c_str(), 1);
        else
            unsetenv(name.c_str());
    }
}

TEST_CASE("truth: noise, bias and the share above the noise", "[tools]") {
    reference::Estimate truth;
    truth.mean = Image4(4, 1, glm::vec4(1, 1, 1, 0));
    truth.error = Image4(4, 1, glm::vec4(0.1f, 0.1f, 0.1f, 0));
    Image4 layer = truth.mean;
    layer(0, 0).x += 0.29f;  // within 3 standard errors
    layer(1, 0).y -= 0.31f;  // beyond
    const TruthComparison c = compare_with_truth(layer, {}, truth, 1);
    CHECK(c.noise == Approx(0.1));
    CHECK(c.bias == Approx((0.29 - 0.31) / 12).epsilon(1e-5));
    CHECK(c.share_above_noise == 0.25);
    // sqrt((0.29^2 + 0.31^2) / 12) = 0.12254
    CHECK(*c.report.rmse == Approx(0.1225425).epsilon(1e-5));
    CHECK_FALSE(c.below_noise);

    layer(1, 0).y = 1;
    CHECK(compare_with_truth(layer, {}, truth, 1).below_noise);
    CHECK(compare_with_truth(layer, {}, truth, 1).share_above_noise == 0);

    // Float rounds where the truth has no noise; what is not finite is never below it.
    truth.error = Image4(4, 1);
    layer = truth.mean;
    layer(2, 0).z = 1.000001f;
    CHECK(compare_with_truth(layer, {}, truth, 1).share_above_noise == 0);
    layer(2, 0).z = 1.0001f;
    CHECK(compare_with_truth(layer, {}, truth, 1).share_above_noise == 0.25);
    layer(2, 0).z = 1;
    truth.mean(3, 0).x = std::numeric_limits<float>::quiet_NaN();
    const TruthComparison nan = compare_with_truth(layer, {}, truth, 1);
    CHECK(nan.share_above_noise == 0.25);
    CHECK_FALSE(nan.below_noise);
}

TEST_CASE("truth: a picture's own standard error counts as the truth's does", "[tools]") {
    reference::Estimate truth;
    truth.mean = Image4(2, 1, glm::vec4(1, 1, 1, 0));
    truth.error = Image4(2, 1, glm::vec4(0.03f, 0.03f, 0.03f, 0));
    const Image4 own(2, 1, glm::vec4(0.04f, 0.04f, 0.04f, 0));
    Image4 layer = truth.mean;
    layer(0, 0).x += 0.149f;  // 3 sqrt(0.03^2 + 0.04^2) = 0.15
    layer(1, 0).y -= 0.151f;
    const TruthComparison c = compare_with_truth(layer, own, truth, 1);
    CHECK(c.noise == Approx(0.05));
    CHECK(c.share_above_noise == 0.5);
    CHECK_FALSE(c.below_noise);  // RMSE sqrt((0.149^2 + 0.151^2) / 6) = 0.0866
    layer(0, 0).x = 1.1f;
    layer(1, 0).y = 1;
    CHECK(compare_with_truth(layer, own, truth, 1).below_noise);  // 0.1 / sqrt(6) = 0.0408
    CHECK_FALSE(compare_with_truth(layer, {}, truth, 1).below_noise);
}

TEST_CASE("truth: color's own error is that of indirect, times albedo / pi", "[tools]") {
    frame::Frame frame;
    CHECK(color_error(frame).empty());
    frame.indirect_error = Image4(1, 1, glm::vec4(1, 2, 4, 0));
    frame.gbuffer.albedo = Image4(1, 1, glm::vec4(0.5f, 0.25f, 1, 0));
    const glm::vec4 error = color_error(frame)(0, 0);
    CHECK(error.x == Approx(0.1591549));  // 0.5 / pi
    CHECK(error.y == Approx(0.1591549));
    CHECK(error.z == Approx(1.2732395));  // 4 / pi
}

TEST_CASE("truth: a standard error that is no number is undefined", "[tools]") {
    frame::Frame frame;
    frame.traced.resize(1);
    frame.traced[0].layer = "color";
    frame.traced[0].estimate.samples = 16;
    frame.traced[0].estimate.relative_error = -std::numeric_limits<double>::quiet_NaN();
    const std::string text = truth_text(frame, compare_layers(frame, 1), {});
    CHECK(text.find("standard error undefined of the mean") != std::string::npos);
}

TEST_CASE("truth: values that are not finite are a warning", "[tools]") {
    frame::Frame frame;
    frame.traced.resize(2);
    frame.traced[0].layer = "truth";
    frame.traced[1].layer = "truth.direct";
    frame.traced[1].estimate.nonfinite = 3;
    CHECK(truth_warnings(frame) ==
          std::vector<std::string>{
              "warning: truth.direct: 3 values that are not finite; none was left out or clamped"});
}
