// The rasterizer of a device's profile against the device itself, bit by bit: which triangle each pixel sees, its depth
// and its barycentric coordinates. Expected everywhere: no difference. PLUMB_FULL=1 draws some 800,000 triangles and
// the large scenes; GALLIUM_OVERRIDE_CPU_CAPS=sse4.1 makes lavapipe the device without fused multiply-adds, and
// VK_ICD_FILENAMES names SwiftShader's driver.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <optional>

#include "core/camera.h"
#include "io/scene_model.h"
#include "raster/bindings.h"
#include "raster/device_raster.h"
#include "raster/light_view.h"
#include "raster/screen_triangle.h"
#include "tests/raster/drawing.h"
#include "tools/vulkan/graphics.h"
#include "tools/vulkan/runner.h"

namespace {

using namespace plumb;
using raster::VisibilityBuffer;
using raster::test::Random;

bool full() { return std::getenv("PLUMB_FULL") != nullptr; }

// The first device whose rasterizer is known, and its profile.
struct KnownDevice {
    std::string device;
    DeviceProfile profile;
};
std::optional<KnownDevice> known_device() {
    const char* caps = std::getenv("GALLIUM_OVERRIDE_CPU_CAPS");
    const bool fused = !caps && __builtin_cpu_supports("fma");
    for (const std::string& name : vulkan::device_names()) {
        if (name.find("llvmpipe") != std::string::npos)
            return KnownDevice{"llvmpipe", find_profile(fused ? "lavapipe-22.3-fma" : "lavapipe-22.3-sse4.1", "test")};
        if (name.find("SwiftShader") != std::string::npos)
            return KnownDevice{"SwiftShader", find_profile("swiftshader", "test")};
    }
    std::cout << "SKIPPED: neither lavapipe (mesa-vulkan-drivers) nor SwiftShader here\n";
    return std::nullopt;
}

// A device that draws triangles into targets of one size.
struct Peer {
    const vulkan::Device& device;
    DeviceProfile profile;
    glm::ivec2 size;
    bool reversed_z;
    vulkan::Targets targets;
    vulkan::GraphicsPipeline pipeline;

    Peer(const vulkan::Device& on, const DeviceProfile& known, glm::ivec2 frame, bool reversed)
        : device(on), profile(known), size(frame), reversed_z(reversed) {
        targets = vulkan::make_targets(device, {std::uint32_t(size.x), std::uint32_t(size.y)},
                                       {VK_FORMAT_R32_SINT, VK_FORMAT_R32G32_SFLOAT});
        if (reversed_z) targets.clear.back().depthStencil.depth = 0;
        vulkan::GraphicsOptions options;
        options.vertex_shader = vulkan::load_spirv(PLUMB_SPIRV_DIR "/tests.parity.device_raster.vert.spv");
        options.fragment_shader = vulkan::load_spirv(PLUMB_SPIRV_DIR "/tests.parity.device_raster.frag.spv");
        options.name = "tests/parity/device_raster";
        options.stride = sizeof(glm::vec4);
        options.attributes = {{VK_FORMAT_R32G32B32A32_SFLOAT, 0}};
        if (reversed_z) options.depth_test = VK_COMPARE_OP_GREATER;
        pipeline = vulkan::make_graphics_pipeline(device, targets, options);
    }

    VisibilityBuffer draw(const std::vector<glm::vec4>& corners) const {
        const vulkan::Buffer vertices = vulkan::device_buffer(
            device, corners.data(), corners.size() * sizeof(glm::vec4), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
        device.run([&](VkCommandBuffer commands) {
            targets.begin(commands);
            pipeline.bind(commands);
            const VkBuffer buffer = vertices.get();
            const VkDeviceSize offset = 0;
            vkCmdBindVertexBuffers(commands, 0, 1, &buffer, &offset);
            vkCmdDraw(commands, std::uint32_t(corners.size()), 1, 0, 0);
            targets.end(commands);
        });
        VisibilityBuffer out{Image<std::int32_t>(size.x, size.y), Image1(size.x, size.y),
                             Image<glm::vec2>(size.x, size.y)};
        vulkan::read_image(device, targets.colours[0], out.triangle.data(), out.triangle.size() * 4);
        vulkan::read_image(device, targets.colours[1], out.barycentrics.data(), out.barycentrics.size() * 8);
        vulkan::read_image(device, targets.depth, out.depth.data(), out.depth.size() * 4);
        for (std::int32_t& t : out.triangle.texels) --t;
        return out;
    }
};

// Three corners a triangle.
VisibilityBuffer draw_here(const Peer& peer, const std::vector<glm::vec4>& corners) {
    Geometry geometry;
    Buffer<glm::vec4> positions(corners.size());
    std::copy(corners.begin(), corners.end(), positions.begin());
    geometry.vertices.resize(corners.size());
    for (unsigned i = 0; i < corners.size(); i += 3) geometry.triangles.push_back({i, i + 1, i + 2});
    geometry.material.assign(geometry.triangles.size(), 0);
    geometry.object.assign(geometry.triangles.size(), 0);
    VisibilityBuffer out;
    raster::draw_device_visibility(geometry, nullptr, positions, peer.reversed_z, peer.size, peer.profile, {}, out);
    return out;
}

// Every NaN is one.
std::uint32_t bits(float x) {
    std::uint32_t u;
    if (x != x) x = __builtin_nanf("");
    std::memcpy(&u, &x, 4);
    return u;
}

struct Differences {
    int covered = 0, id = 0, depth = 0, l = 0;
    std::string first;

    bool none() const { return id + depth + l == 0; }
};
Differences compare(const VisibilityBuffer& theirs, const VisibilityBuffer& ours) {
    Differences d;
    for (int y = 0; y < theirs.depth.height; ++y) {
        for (int x = 0; x < theirs.depth.width; ++x) {
            const glm::vec2 a = theirs.barycentrics(x, y), b = ours.barycentrics(x, y);
            const bool id = theirs.triangle(x, y) != ours.triangle(x, y);
            const bool depth = bits(theirs.depth(x, y)) != bits(ours.depth(x, y));
            const bool l = bits(a.x) != bits(b.x) || bits(a.y) != bits(b.y);
            d.covered += theirs.triangle(x, y) >= 0;
            d.id += id, d.depth += depth, d.l += l;
            if (!d.first.empty() || !(id || depth || l)) continue;
            char text[400];
            std::snprintf(text, sizeof text, "pixel (%d, %d): theirs %d, %.9g, (%.9g, %.9g); ours %d, %.9g, (%.9g, %.9g)",
                          x, y, theirs.triangle(x, y), double(theirs.depth(x, y)), double(a.x), double(a.y),
                          ours.triangle(x, y), double(ours.depth(x, y)), double(b.x), double(b.y));
            d.first = text;
        }
    }
    return d;
}

void check_none(const Peer& peer, const std::vector<glm::vec4>& corners, const std::string& what,
                std::int64_t& covered) {
    const VisibilityBuffer theirs = peer.draw(corners);
    const Differences d = compare(theirs, draw_here(peer, corners));
    covered += d.covered;
    INFO(what << ": " << corners.size() / 3 << " triangles, " << d.covered << " pixels covered; different: id " << d.id
              << ", depth " << d.depth << ", l1 or l2 " << d.l << "; first: " << d.first);
    CHECK(d.none());
}

// ---- random triangles -------------------------------------------------------------------------------------------------

// A clip position from a window position, depth and w.
glm::vec4 from_window(glm::ivec2 size, double x, double y, double z, double w) {
    return {float((2 * x / size.x - 1) * w), float((2 * y / size.y - 1) * w), float(z * w), float(w)};
}

double power_of_two(int e) { return e < 0 ? 1 / double(std::uint64_t(1) << -e) : double(std::uint64_t(1) << e); }

using Corners = std::vector<glm::vec4>;

// Around a random place, `extent` pixels wide; w between 2^-octaves and 2^octaves.
void add_placed(Corners& out, Random& random, glm::ivec2 size, double extent, int octaves) {
    const double cx = random.between(-0.1, 1.1) * size.x, cy = random.between(-0.1, 1.1) * size.y;
    for (int i = 0; i < 3; ++i) {
        const double w = random.between(1, 2) * power_of_two(random.below(2 * octaves + 1) - octaves);
        out.push_back(from_window(size, cx + random.between(-0.5, 0.5) * extent, cy + random.between(-0.5, 0.5) * extent,
                                  random.between(0.01, 1), w));
    }
}

struct Kind {
    const char* name;
    int extent_limit;
    void (*add)(Corners& out, Random& random, glm::ivec2 size);
};

const Kind kinds[] = {
    {"a pixel or two", 2, [](Corners& c, Random& r, glm::ivec2 s) { add_placed(c, r, s, 3, 1); }},
    {"small", 20, [](Corners& c, Random& r, glm::ivec2 s) { add_placed(c, r, s, 20, 2); }},
    {"all sizes", 2000,
     [](Corners& c, Random& r, glm::ivec2 s) { add_placed(c, r, s, power_of_two(r.below(12)) * r.between(1, 2), 3); }},
    {"w over 40 octaves", 100, [](Corners& c, Random& r, glm::ivec2 s) { add_placed(c, r, s, 100, 20); }},
    {"across every plane, w of both signs", 1000,
     [](Corners& c, Random& r, glm::ivec2) {
         for (int i = 0; i < 3; ++i)
             c.push_back({float(r.between(-2, 2)), float(r.between(-2, 2)), float(r.between(-0.3, 1.3)),
                          float(r.between(-0.5, 1.5))});
     }},
    {"across the depth planes", 1000,
     [](Corners& c, Random& r, glm::ivec2) {
         for (int i = 0; i < 3; ++i) {
             const double w = r.between(0.5, 4);
             c.push_back({float(w * r.between(-0.9, 0.9)), float(w * r.between(-0.9, 0.9)), float(w * r.between(-1, 2)),
                          float(w)});
         }
     }},
    {"one corner at the eye", 1000,
     [](Corners& c, Random& r, glm::ivec2) {
         const int near = r.below(3);
         for (int i = 0; i < 3; ++i) {
             const double scale = i == near ? power_of_two(-r.below(40)) : 1;
             c.push_back({float(scale * r.between(-1, 1)), float(scale * r.between(-1, 1)),
                          float(scale * r.between(-0.2, 1)), float(scale * r.between(0, 1))});
         }
     }},
    {"slivers", 1000,
     [](Corners& c, Random& r, glm::ivec2 s) {
         const double x0 = r.between(0, s.x), y0 = r.between(0, s.y), x1 = r.between(0, s.x), y1 = r.between(0, s.y);
         const double t = r.uniform(), off = r.between(-1, 1) * power_of_two(-r.below(14));
         c.push_back(from_window(s, x0, y0, r.uniform(), r.between(0.5, 2)));
         c.push_back(from_window(s, x1, y1, r.uniform(), r.between(0.5, 2)));
         c.push_back(from_window(s, x0 + t * (x1 - x0) + off, y0 + t * (y1 - y0), r.uniform(), r.between(0.5, 2)));
     }},
    {"corners on multiples of 1/512 pixel", 60,
     [](Corners& c, Random& r, glm::ivec2 s) {
         const int x = r.below(s.x * 512), y = r.below(s.y * 512), z = r.below(256);
         for (int i = 0; i < 3; ++i)
             c.push_back(from_window(s, (x + r.below(30000)) / 512.0, (y + r.below(30000)) / 512.0, z / 256.0, 1));
     }},
    {"no area before snapping", 100,
     [](Corners& c, Random& r, glm::ivec2 s) {
         const int dx = r.below(300000) - 150000, dy = r.below(300000) - 150000;
         const int x = r.below(s.x * 4096), y = r.below(s.y * 4096), far = 2 + r.below(3);
         for (int i : {0, 1, far})
             c.push_back(from_window(s, (x + i * dx) / 4096.0, (y + i * dy) / 4096.0, r.uniform(), 1));
     }},
    {"near the far plane", 100,
     [](Corners& c, Random& r, glm::ivec2 s) {
         for (int i = 0; i < 3; ++i)
             c.push_back(from_window(s, r.between(0, s.x), r.between(0, s.y), 1 - power_of_two(-24) * r.below(4),
                                     r.between(1, 100)));
     }},
    {"near the near plane", 100,
     [](Corners& c, Random& r, glm::ivec2 s) {
         const double x = r.between(0, s.x), y = r.between(0, s.y);
         for (int i = 0; i < 3; ++i)
             c.push_back(from_window(s, x + r.between(0, 20), y + r.between(0, 20), r.between(0, 1e-7),
                                     r.between(1, 100)));
     }},
    {"depths and w that are denormal or nearly", 100,
     [](Corners& c, Random& r, glm::ivec2 s) {
         const double tiny = 0x1p-126 * power_of_two(r.below(20) - 5);
         for (int i = 0; i < 3; ++i)
             c.push_back(from_window(s, r.between(0, s.x), r.between(0, s.y), r.uniform() * tiny * 16,
                                     power_of_two(r.below(12))));
     }},
};

// The same depth for all, so that the first in order wins, and edges that neighbours share, from a bent grid.
Corners mesh(Random& random, glm::ivec2 size, int cells) {
    std::vector<glm::vec4> grid;
    for (int j = 0; j <= cells; ++j)
        for (int i = 0; i <= cells; ++i)
            grid.push_back(from_window(size, (i + random.between(-0.4, 0.4)) * size.x / cells,
                                       (j + random.between(-0.4, 0.4)) * size.y / cells, 0.5, random.between(0.5, 2)));
    Corners out;
    auto at = [&](int i, int j) { return grid[std::size_t(j * (cells + 1) + i)]; };
    for (int j = 0; j < cells; ++j)
        for (int i = 0; i < cells; ++i)
            for (const glm::vec4& c :
                 {at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)})
                out.push_back(c);
    return out;
}

TEST_CASE("device raster: random triangles are the device's to the bit", "[parity][raster]") {
    const std::optional<KnownDevice> known = known_device();
    if (!known) return;
    const vulkan::Device device({.name = known->device});
    std::int64_t drawn = 0, covered = 0;
    for (const glm::ivec2 size : {glm::ivec2(256, 256), glm::ivec2(1000, 562), glm::ivec2(1024, 1024)}) {
        const Peer peer(device, known->profile, size, size.x == 256);
        Random random(std::uint64_t(size.x));
        for (const Kind& kind : kinds) {
            // Small triangles many at once; large ones few, so that most of them are seen.
            const int at_once = kind.extent_limit < 100 ? 2000 : 100, frames = full() ? 22000 / at_once : 2;
            for (int frame = 0; frame < frames; ++frame) {
                Corners corners;
                for (int i = 0; i < at_once; ++i) kind.add(corners, random, size);
                check_none(peer, corners, kind.name, covered);
                drawn += at_once;
            }
        }
        for (int cells : {7, 50, 200}) {
            const Corners corners = mesh(random, size, cells);
            check_none(peer, corners, "mesh", covered);
            drawn += std::int64_t(corners.size() / 3);
        }
    }
    WARN(drawn << " triangles, " << covered << " pixels");
    CHECK(covered > drawn);
}

// ---- scenes -----------------------------------------------------------------------------------------------------------

TEST_CASE("device raster: scenes are the device's to the bit", "[parity][raster]") {
    const std::optional<KnownDevice> known = known_device();
    if (!known) return;
    const vulkan::Device device({.name = known->device});
    std::vector<std::string> names = {"cornell", "box"};
    if (full()) names.insert(names.end(), {"shapes", "atrium", "city", "rooms", "hall"});
    for (const std::string& name : names) {
        const Scene scene = io::generate_model(name, {}, "test").scene;
        const Geometry geometry = flatten(scene);
        for (const glm::ivec2 size : {glm::ivec2(1000, 562), glm::ivec2(1024, 1024)}) {
            const View view = make_view(scene.camera, double(size.x) / size.y);
            const Buffer<glm::vec4> positions = raster::clip_positions(geometry, view, 0);
            Corners corners;
            for (const glm::uvec3& t : geometry.triangles)
                for (int i = 0; i < 3; ++i) corners.push_back(positions[t[i]]);
            std::int64_t covered = 0;
            check_none(Peer(device, known->profile, size, view.reversed_z), corners, name, covered);
            CHECK(covered > size.x * size.y / 20);
        }
    }
}

// ---- whole passes -----------------------------------------------------------------------------------------------------

void check_pass(const vulkan::Device& device, const DeviceProfile& profile, const StageBinding& binding,
                const StageData& data, const std::string& what) {
    const Bundle theirs = vulkan::run_twin(device, binding, data).outputs;
    Bundle ours;
    binding.bind(data)->run({}, profile, ours);
    REQUIRE(theirs.arrays.size() == ours.arrays.size());
    for (const Array& a : ours.arrays) {
        const Array& b = at(theirs, a.name);
        REQUIRE(a.bytes.size() == b.bytes.size());
        std::size_t different = 0;
        for (std::size_t i = 0; i < a.bytes.size(); i += 4) {
            float x, y;
            std::memcpy(&x, a.bytes.data() + i, 4), std::memcpy(&y, b.bytes.data() + i, 4);
            different += bits(x) != bits(y);
        }
        INFO(what << ": " << a.name << ": " << different << " of " << a.bytes.size() / 4 << " values");
        CHECK(different == 0);
    }
}

// Pixels in which another triangle is seen where every material is taken to be whole.
std::int64_t cut_away(const Geometry& geometry, const raster::Surfaces& surfaces, const View& view, glm::ivec2 size,
                      const DeviceProfile& profile) {
    const Buffer<glm::vec4> positions = raster::clip_positions(geometry, view, 0);
    VisibilityBuffer masked, whole;
    raster::draw_device_visibility(geometry, &surfaces, positions, view.reversed_z, size, profile, {}, masked);
    raster::draw_device_visibility(geometry, nullptr, positions, view.reversed_z, size, profile, {}, whole);
    std::int64_t n = 0;
    for (std::size_t i = 0; i < whole.triangle.size(); ++i)
        n += masked.triangle.texels[i] != whole.triangle.texels[i];
    return n;
}

// The atrium has leaves that an alpha mask cuts out: their fragments, judged through l1 and l2, have to fall away in the
// same pixels.
TEST_CASE("device raster: whole passes are the device's to the bit", "[parity][raster]") {
    const std::optional<KnownDevice> known = known_device();
    if (!known) return;
    const vulkan::Device device({.name = known->device});
    std::vector<std::string> names = {"cornell", "atrium"};
    if (full()) names.insert(names.end(), {"box", "shapes", "city", "rooms", "hall"});
    for (const std::string& name : names) {
        io::GenerateOptions options;
        if (!full() && name == "atrium") options.triangles = 20000;
        if (name == "city") options.triangles = 1000000;  // lavapipe's storage buffers hold 128 MiB
        const Scene scene = io::generate_model(name, options, "test").scene;
        const Geometry geometry = flatten(scene);
        const raster::Surfaces surfaces = raster::prepare(scene, geometry);
        const glm::ivec2 size(500, 281);
        const View view = make_view(scene.camera, double(size.x) / size.y);
        check_pass(device, known->profile, raster::gbuffer_binding(), raster::gbuffer_data(geometry, surfaces, view, size),
                   name + ": gbuffer");
        if (name == "atrium") CHECK(cut_away(geometry, surfaces, view, size, known->profile) > 500);
        glm::vec3 low, high;
        REQUIRE(bounds(geometry, low, high));
        for (Light light : scene.lights) {
            light.rsm_size = 256;
            for (const View& seen_by : raster::light_views(light, low, high))
                check_pass(device, known->profile, raster::rsm_binding(), raster::rsm_data(geometry, surfaces, light, seen_by),
                           name + ": rsm of " + light.name);
        }
    }
}

}  // namespace
