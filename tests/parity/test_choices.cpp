// The discrete choices that a twin stores (core/tap.glsl, compiled with PLUMB_CHOICES), and verdicts that follow them.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstring>

#include "core/hash.h"
#include "core/tap.h"
#include "gi/parity/stages.h"
#include "gi/parity/verdict.h"
#include "raster/project_kernel.h"
#include "tests/parity/devices.h"
#include "tests/parity/twin_data.h"
#include "tools/vulkan/choices.h"
#include "tools/vulkan/compute.h"
#include "tools/vulkan/runner.h"

namespace {

using namespace plumb;

constexpr int width = 21, height = 10, per_pixel = 3;  // project() makes two choices: the third stays as it was

struct Choices {
    std::int32_t width = ::width, per_pixel = ::per_pixel;
    std::int32_t index[height][::width][::per_pixel];
};

// A perspective map of 64 texels, 1 m below the points' middle.
raster::Projection map_of_64() {
    return {{40, 3, 32, 5}, {-2, 41, 32, 4}, {0.01f, 0.02f, 1, 0.5f}, 1e-3f, -1e6f, 1e6f, 64};
}

std::vector<glm::vec4> points() {
    std::vector<glm::vec4> out;
    for (int i = 0; i < width * height; ++i) {
        const auto h = pixel_hash<std::int32_t>(i, 0, 0, 3);
        auto coordinate = [](std::int32_t bits) { return float(bits & 0xffff) / 32768 - 1; };
        out.push_back({coordinate(h.x), coordinate(h.y), coordinate(h.z), 1});
    }
    return out;
}

void check_silence(const vulkan::Device& device) {
    for (const std::string& complaint : device.complaints()) UNSCOPED_INFO(complaint);
    CHECK(device.complaints().empty());
}

constexpr glm::ivec2 frame_size(40, 24);

// The stages that project to a map.
std::vector<StageData> projecting_stages() {
    using namespace direct;
    return {test::shadow_case(frame_size, LightType::spot, 0, ShadowMode::hard, ShadowVariant::corrected, "shadow"),
            test::shadow_case(frame_size, LightType::directional, 0, ShadowMode::density, ShadowVariant::corrected,
                              "shadow.density"),
            test::shadow_case(frame_size, LightType::point, 3, ShadowMode::hard, ShadowVariant::corrected, "shadow.ny"),
            test::gather_case(frame_size, rsm::Gather::disc, LightType::spot, 0, "rsm.disc"),
            test::gather_case(frame_size, rsm::Gather::disc, LightType::directional, 0.1f, "rsm.disc.sun")};
}

const StageBinding& binding_of(const StageData& data) { return parity::find_binding(data.stage, "test"); }

vulkan::TwinResult run_choosing(const vulkan::Device& device, const StageData& data) {
    vulkan::RunTwin options;
    options.choices = true;
    return vulkan::run_twin(device, binding_of(data), data, options);
}

// Of what a device made, with its choices or without them, on any device that keeps Vulkan's table.
parity::StageVerdict judge(const StageData& data, const vulkan::TwinResult& made, bool with_choices = true) {
    parity::JudgeOptions options;
    if (with_choices) options.choices = made.choices, options.choices_a_pixel = made.choices_a_pixel;
    const Array& output = made.outputs.arrays.at(0);
    return parity::judge(binding_of(data), data, {{output.name, output}}, options);
}

std::int64_t count(const parity::StageVerdict& v, parity::Verdict verdict) { return v.count[std::size_t(verdict)]; }

// A matrix that projects to `texels` texels farther right.
StageData shifted(StageData data, double texels) {
    const StageBinding& binding = binding_of(data);
    std::vector<double> x = uniform_value(binding, data, "map.to_texel_x");
    const std::vector<double> w = uniform_value(binding, data, "map.to_texel_w");
    for (std::size_t c = 0; c < 4; ++c) x[c] += texels * w[c];
    set_uniform(binding, data, "map.to_texel_x", x, "test");
    return data;
}

// Moves every point that is there along the map's rows, so that it projects to 2^-20 texels left of a border between
// texels: nearer than float arithmetic can tell.
void move_to_borders(StageData& data) {
    const StageBinding& binding = binding_of(data);
    const std::vector<double> to_x = uniform_value(binding, data, "map.to_texel_x");
    const std::vector<double> to_w = uniform_value(binding, data, "map.to_texel_w");
    Array& position = *std::find_if(data.inputs.arrays.begin(), data.inputs.arrays.end(),
                                    [](const Array& array) { return array.name == "position"; });
    auto* p = reinterpret_cast<glm::vec4*>(position.bytes.data());
    for (int i = 0; i < frame_size.x * frame_size.y; ++i) {
        const auto row = [&](const std::vector<double>& m) {
            return m[0] * p[i].x + m[1] * p[i].y + m[2] * p[i].z + m[3];
        };
        const double w = row(to_w), texel = row(to_x) / w;
        if (p[i] == glm::vec4(0) || !(texel > 1 && texel < 40)) continue;
        // Newton's step along the gradient of row_x - border row_w, which is 0 on the border.
        const double border = std::floor(texel) + 1 - 0x1p-20;
        double g[3], length2 = 0;
        for (std::size_t c = 0; c < 3; ++c) g[c] = to_x[c] - border * to_w[c], length2 += g[c] * g[c];
        const double off = row(to_x) - border * w;
        for (std::size_t c = 0; c < 3; ++c) p[i][int(c)] = float(p[i][int(c)] - off * g[c] / length2);
    }
}

int differing_choices(const vulkan::TwinResult& a, const vulkan::TwinResult& b) {
    REQUIRE(a.choices.size() == b.choices.size());
    int n = 0;
    for (std::size_t i = 0; i < a.choices.size(); ++i) n += a.choices[i] != b.choices[i];
    return n;
}

// Outcomes of all pixels whose choices differ from `than`'s, and of how many of these there is none.
struct Outcomes {
    std::size_t all = 0, pixels = 0, none = 0;
};
Outcomes outcomes(const StageData& data, const vulkan::TwinResult& made, const vulkan::TwinResult& than, bool follow) {
    const auto bound = binding_of(data).bind(data);
    Outcomes sum;
    std::vector<Outcome> out;
    const float got[4] = {};
    for (int i = 0; i < frame_size.x * frame_size.y; ++i) {
        const std::span<const std::int32_t> own(made.choices.data() + 2 * i, 2), other(than.choices.data() + 2 * i, 2);
        if (std::equal(own.begin(), own.end(), other.begin())) continue;
        bound->outcomes({i % frame_size.x, i / frame_size.x}, {}, got, follow ? own : own.first(0), out);
        ++sum.pixels, sum.all += out.size(), sum.none += out.empty();
    }
    return sum;
}

}  // namespace

TEST_CASE("choices: the twins' own are legal, and nothing is left ambiguous", "[vulkan][choices]") {
    const vulkan::Device* device = test::lavapipe();
    if (!device) return;
    for (const StageData& data : projecting_stages()) {
        INFO(data.id);
        const vulkan::TwinResult made = run_choosing(*device, data);
        REQUIRE(made.choices_a_pixel == 2);  // a texel's column and row
        REQUIRE(made.choices.size() == std::size_t(2 * frame_size.x * frame_size.y));
        // Where a face of a point light does not serve the pixel there is none.
        const auto bound = binding_of(data).bind(data);
        int unwritten = 0;
        for (int y = 0; y < frame_size.y; ++y)
            for (int x = 0; x < frame_size.x; ++x) {
                const bool none = made.choices[std::size_t(2 * (y * frame_size.x + x))] == vulkan::no_choice;
                unwritten += none == bound->writes({x, y});
            }
        CHECK(unwritten == 0);
        const parity::StageVerdict v = judge(data, made);
        CHECK(v.passed);
        CHECK(count(v, parity::Verdict::equal) == v.pixels);
        // The choosing twin computes what the plain one does.
        const vulkan::TwinResult plain = vulkan::run_twin(*device, binding_of(data), data);
        CHECK(plain.outputs.arrays[0].bytes == made.outputs.arrays[0].bytes);
        CHECK(plain.choices.empty());
    }
    check_silence(*device);
}

TEST_CASE("choices: a gather of continuous texels makes two for each sample", "[vulkan][choices][continuous]") {
    const vulkan::Device* device = test::lavapipe();
    if (!device) return;
    const rsm::GatherParams paths{.directions = 3, .steps = 4, .texels = rsm::Texels::continuous};
    for (const StageData& data : {test::gather_case(frame_size, rsm::Gather::disc, LightType::spot, 0,
                                                    "rsm.disc.continuous", rsm::Texels::continuous),
                                  test::paths_case(frame_size, LightType::spot, paths, "rsm.paths.continuous")}) {
        INFO(data.id);
        const vulkan::TwinResult made = run_choosing(*device, data);
        CHECK(made.choices_a_pixel == 2 * (data.stage == "rsm.disc_continuous" ? 60 : 12));
        const parity::StageVerdict v = judge(data, made);
        CHECK(v.passed);
        CHECK(count(v, parity::Verdict::equal) == v.pixels);
        // A texel to the right every sample reads another.
        const parity::StageVerdict moved = judge(data, run_choosing(*device, shifted(data, 1)));
        CHECK_FALSE(moved.passed);
        CHECK(count(moved, parity::Verdict::wrong) > 0);
        // A legal other texel is followed, in each of a pixel's choices.
        StageData at_borders = data;
        move_to_borders(at_borders);
        const parity::StageVerdict followed = judge(at_borders, run_choosing(*device, shifted(at_borders, 0x1p-18)));
        CHECK(followed.passed);
        CHECK(count(followed, parity::Verdict::ambiguous) == 0);
    }
    check_silence(*device);
}

TEST_CASE("choices: a texel's offset is no legal choice", "[vulkan][choices]") {
    const vulkan::Device* device = test::lavapipe();
    if (!device) return;
    for (const StageData& data : projecting_stages()) {
        INFO(data.id);
        // What the device computes from the shifted matrix is our kernel's at the next texel.
        const vulkan::TwinResult right = run_choosing(*device, data), wrong = run_choosing(*device, shifted(data, 1));
        CHECK(differing_choices(right, wrong) > frame_size.x);
        const parity::StageVerdict v = judge(data, wrong);
        CHECK_FALSE(v.passed);
        CHECK(count(v, parity::Verdict::wrong) > 0);
        const Outcomes o = outcomes(data, wrong, right, true);
        // Of a point a kilometre away float arithmetic knows the texel to 0.01: for one in a hundred both are legal.
        CHECK(double(o.none) > 0.99 * double(o.pixels));
        // Of what the offset changes nothing is excused.
        CHECK(count(v, parity::Verdict::ambiguous) == 0);
        CHECK(count(v, parity::Verdict::within_bound) == 0);
    }
    check_silence(*device);
}

TEST_CASE("choices: a legal other texel is followed", "[vulkan][choices]") {
    const vulkan::Device* device = test::lavapipe();
    if (!device) return;
    for (StageData data : projecting_stages()) {
        if (data.id == "shadow.ny") continue;  // a border of the map may be one of its faces
        INFO(data.id);
        move_to_borders(data);
        // A shift that is nearer to nothing than rounding is: 2^-18 of a texel, where coordinates of 32 have 2^-18.
        const vulkan::TwinResult ours = run_choosing(*device, data);
        const vulkan::TwinResult other = run_choosing(*device, shifted(data, 0x1p-18));
        CHECK(differing_choices(ours, other) > frame_size.x);
        const parity::StageVerdict v = judge(data, other);
        CHECK(v.passed);
        CHECK(count(v, parity::Verdict::ambiguous) == 0);
        CHECK(count(v, parity::Verdict::wrong) == 0);
        // One way to come out is left where there were two; a shadow's comparisons are others.
        const Outcomes followed = outcomes(data, other, ours, true), both = outcomes(data, other, ours, false);
        CHECK(followed.none == 0);
        CHECK(both.all >= 2 * followed.all);
        if (data.stage == "rsm.disc") CHECK(followed.all == followed.pixels);
        // A value must be that of the choice: our own values with the other's choices are not, where they differ.
        vulkan::TwinResult mixed = other;
        mixed.choices = ours.choices;
        CHECK(count(judge(data, mixed), parity::Verdict::wrong) > 0);
        CHECK(count(judge(data, mixed, false), parity::Verdict::wrong) == 0);
    }
    check_silence(*device);
}

TEST_CASE("choices: a twin stores the texels that it chose, a pixel's own together", "[vulkan][choices]") {
    const vulkan::Device* found = test::lavapipe();
    if (!found) return;
    const vulkan::Device& device = *found;
    const raster::Projection map = map_of_64();
    const std::vector<glm::vec4> x = points();
    const auto usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
    const vulkan::Buffer map_buffer = vulkan::device_buffer(device, &map, sizeof map, usage);
    const vulkan::Buffer point_buffer = vulkan::device_buffer(device, x.data(), x.size() * sizeof x[0], usage);
    const vulkan::Buffer texels = vulkan::host_buffer(device, x.size() * sizeof(glm::ivec2), usage);
    const vulkan::Buffer chosen = vulkan::host_buffer(device, sizeof(Choices), usage);
    Choices empty;
    std::fill_n(&empty.index[0][0][0], width * height * per_pixel, -77);
    std::memcpy(chosen.mapped, &empty, sizeof empty);

    const std::vector<vulkan::Resource> resources{{.binding = 0, .buffer = &map_buffer},
                                                  {.binding = 1, .buffer = &point_buffer},
                                                  {.binding = 2, .buffer = &texels},
                                                  {.binding = 30, .buffer = &chosen}};
    const vulkan::DescriptorSet set = vulkan::make_descriptor_set(device, resources);
    const vulkan::Spirv spirv = vulkan::load_spirv(PLUMB_SPIRV_DIR "/tests.parity.choices.comp.spv");
    const vulkan::ComputePipeline pipeline =
        vulkan::make_compute_pipeline(device, vulkan::make_shader(device, spirv, "choices"), set.layout.get());
    device.run([&](VkCommandBuffer commands) {
        pipeline.dispatch(commands, set.set, {width, height});
        vulkan::full_barrier(commands);
    });

    const auto* stored = static_cast<const Choices*>(chosen.mapped);
    int different = 0;
    for (int i = 0; i < width * height; ++i) {
        NoTap tap;
        const glm::vec4& p = x[std::size_t(i)];
        const ivec2<std::int32_t> expected = raster::project<float>(map, vec3<float>(p.x, p.y, p.z), tap);
        const std::int32_t* c = stored->index[i / width][i % width];
        different += !(c[0] == expected.x && c[1] == expected.y && c[2] == -77);
    }
    CHECK(different == 0);
    CHECK(stored->index[0][0][0] != stored->index[1][0][0]);  // the points differ
    check_silence(device);
}
