// What a stage binds, by name and number, is what its twin declares; and data at the edge of what a kernel may follow
// is bound, one step beyond it is refused.
#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "core/error.h"
#include "gi/parity/stages.h"
#include "tests/parity/twin_data.h"

using namespace plumb;

namespace {

// A twin with all that it includes, each file once.
std::string text_of(const std::string& path, std::set<std::string>& seen) {
    if (!seen.insert(path).second) return "";
    std::ifstream file(std::string(PLUMB_SOURCE_DIR) + "/" + path);
    INFO(path);
    REQUIRE(file.good());
    std::string text, line;
    std::smatch include;
    while (std::getline(file, line))
        text += (std::regex_match(line, include, std::regex(R"rx(#include "(.*)")rx")) ? text_of(include[1], seen)
                                                                                       : line) +
                "\n";
    return text;
}
std::string text_of(const StageBinding& b) {
    std::set<std::string> seen;
    return b.raster ? text_of(b.twin + ".vert", seen) + text_of(b.twin + ".frag", seen) : text_of(b.twin, seen);
}

int rounded_up(int offset, int alignment) { return (offset + alignment - 1) / alignment * alignment; }

// Appends the members that are declared between the braces behind `opening`, structs member by member, and returns
// where the block ends: std140, OpenGL 4.6, 7.6.2.2.
int add_members(const std::string& text, const std::string& opening, const std::string& prefix, int start,
                std::vector<UniformMember>& members) {
    const std::size_t at = text.find(opening);
    INFO(opening);
    REQUIRE(at != text.npos);
    const std::size_t begin = text.find('{', at), end = text.find('}', begin);
    const std::string body = text.substr(begin, end - begin);
    const std::regex declaration(R"((\w+)\s+(\w+)\s*;)");
    const std::map<std::string, int> sizes = {{"float", 4}, {"int", 4}, {"uint", 4}, {"vec3", 12}, {"vec4", 16}};
    int next = start;
    const std::sregex_iterator first(body.begin(), body.end(), declaration), none;
    for (std::sregex_iterator i = first; i != none; ++i) {
        const std::string type = (*i)[1], name = (*i)[2];
        const auto size = sizes.find(type);
        next = rounded_up(next, size != sizes.end() && size->second == 4 ? 4 : 16);
        if (size == sizes.end()) {
            // `uniform Block { Struct u; };` has the struct's members.
            const bool alone = std::next(first) == none && prefix.empty();
            const std::string inner = alone ? "" : prefix + name + ".";
            next = rounded_up(add_members(text, "struct " + type + " ", inner, next, members), 16);
        } else {
            if (name != "padding") members.push_back({prefix + name, type, next});
            next += size->second;
        }
    }
    return next;
}

// What is bound, a line each: "5 irradiance: storage_image f32 4".
using Lines = std::set<std::string>;

std::string line_of(const std::string& number, const std::string& name, const std::string& kind) {
    return number + " " + name + ": " + kind;
}

std::string element_of(const std::string& type) {
    static const std::map<std::string, std::string> elements = {
        {"int", "i32 1"}, {"ivec2", "i32 2"}, {"ivec4", "i32 4"}, {"float", "f32 1"}, {"vec2", "f32 2"},
        {"vec4", "f32 4"},
        {"LightArgs", "f32 4"},  // of four vec4
        {"r32f", "f32 1"}, {"rgba32f", "f32 4"}};
    INFO(type);
    REQUIRE(elements.count(type) == 1);
    return elements.at(type);
}

Lines inputs_of_twin(const std::string& text) {
    Lines found;
    auto each = [&](const char* pattern, auto&& add) {
        const std::regex regex(pattern);
        for (std::sregex_iterator i(text.begin(), text.end(), regex), none; i != none; ++i) add(*i);
    };
    auto base = [](std::string name) { return std::regex_replace(name, std::regex("_image$"), ""); };
    each(R"(\(binding = (\d+)\) uniform sampler2D(Array)? (\w+);)", [&](const std::smatch& m) {
        const bool single = m[3] == "behind_image" || m[3] == "visibility_image";  // those of one channel
        found.insert(line_of(m[1], base(m[3]), m[2].matched ? "image_array f32 1" : single ? "image f32 1" : "image f32 4"));
    });
    each(R"(\(std430, binding = (\d+)\) readonly buffer \w+ \{ (\w+) (\w+)\[\]; \})", [&](const std::smatch& m) {
        found.insert(line_of(m[1], m[3], "buffer " + element_of(m[2])));
    });
    return found;
}

Lines outputs_of_twin(const std::string& text, bool raster) {
    Lines found;
    const std::regex image(R"(\(binding = (\d+), (\w+)\) uniform writeonly image2D (\w+)_image;)");
    const std::regex target(R"(\(location = (\d+)\) out (\w+) (\w+);)");
    const std::regex list(R"(\(std430, binding = (\d+)\) writeonly buffer \w+ \{ (\w+) (\w+)\[\]; \})");
    for (std::sregex_iterator i(text.begin(), text.end(), list), none; i != none; ++i)
        found.insert(line_of((*i)[1], (*i)[3], "storage_buffer " + element_of((*i)[2])));
    for (std::sregex_iterator i(text.begin(), text.end(), raster ? target : image), none; i != none; ++i) {
        const std::string format = (*i)[2], name = (*i)[3];
        if (name == "barycentrics") continue;  // of the vertex stage
        found.insert(line_of((*i)[1], name, (raster ? "target " : "storage_image ") + element_of(format)));
    }
    return found;
}

std::string kind_text(const Slot& s) {
    const char* const kinds[] = {"image",          "image_array", "buffer", "storage_image",
                                 "storage_buffer", "target",      "depth"};
    return kinds[int(s.kind)] + std::string(" ") + dtype_name(s.dtype) + " " + std::to_string(s.channels);
}
Lines lines_of(const std::vector<Slot>& slots) {
    Lines all;
    for (const Slot& s : slots)
        if (s.kind != SlotKind::depth) all.insert(line_of(std::to_string(s.binding), s.name, kind_text(s)));
    return all;
}

}  // namespace

TEST_CASE("stage bindings: uniform blocks have the twins' members at std140's offsets", "[bindings][std140]") {
    for (const StageBinding& b : parity::bindings()) {
        std::vector<UniformMember> twin;
        const int end = add_members(text_of(b), "layout(std140, binding = 0) uniform ", "", 0, twin);
        INFO(b.info.name);
        CHECK(int(b.uniform_bytes) == rounded_up(end, 16));
        REQUIRE(b.uniforms.size() == twin.size());
        for (std::size_t i = 0; i < twin.size(); ++i) {
            INFO(twin[i].name);
            CHECK(b.uniforms[i].name == twin[i].name);
            CHECK(b.uniforms[i].type == twin[i].type);
            CHECK(b.uniforms[i].offset == twin[i].offset);
        }
    }
}

TEST_CASE("stage bindings: every slot has the twin's number, name, kind and format", "[bindings][twins]") {
    for (const StageBinding& b : parity::bindings()) {
        const std::string text = text_of(b);
        INFO(b.info.name);
        CHECK(lines_of(b.inputs) == inputs_of_twin(text));
        CHECK(lines_of(b.outputs) == outputs_of_twin(text, b.raster));
        CHECK(lines_of(b.inputs).size() == b.inputs.size());
        CHECK(lines_of(b.outputs).size() + (b.raster ? 1 : 0) == b.outputs.size());
        if (b.raster) CHECK(kind_text(b.outputs.back()) == "depth f32 1");

        // A light's maps, buffers, blocks of texels and the last frame have sizes of their own; those of image-space radiosity, of octahedral
        // tiles and of what is read beside a sheet of rays are checked when they are bound.
        const std::set<std::string> checked = {"ddgi.sample", "screen.lobe", "screen.reflect", "screen.cells", "screen.mirror"};
        for (const Slot& s : b.inputs)
            if (!b.info.name.starts_with("isr.") && checked.count(b.info.name) == 0) CHECK(s.frame == !(s.kind == SlotKind::buffer || s.name.starts_with("rsm_") || s.name.starts_with("map_") ||
                               s.name.starts_with("coarse_") || s.name.starts_with("last_") ||
                                  s.name.starts_with("vertex_") || s.name == "full" || s.name == "lightmap" || s.name == "nearest"));
        for (const Slot& s : b.outputs) CHECK(s.frame);
    }
}

namespace {

constexpr glm::ivec2 small(9, 5);

Array& input_of(StageData& data, const std::string& name) {
    for (Array& a : data.inputs.arrays)
        if (a.name == name) return a;
    FAIL(name);
    return data.inputs.arrays[0];
}

void resize(Array& array, const Shape& shape) {
    array.shape = shape;
    array.bytes.resize(element_count(array.name, shape) * 4);
}

// The message, or "" for data that is bound.
std::string refusal(const StageData& data) {
    try {
        parity::find_binding(data.stage, "test").bind(data);
        return "";
    } catch (const InputError& error) {
        return error.what();
    }
}

std::string with_uniform(StageData data, const std::string& member, double value) {
    set_uniform(parity::find_binding(data.stage, "test"), data, member, {{value}}, "test");
    return refusal(data);
}
std::string with_shape(StageData data, const std::string& input, const Shape& shape) {
    resize(input_of(data, input), shape);
    return refusal(data);
}
double uniform(const StageData& data, const std::string& member) {
    return uniform_value(parity::find_binding(data.stage, "test"), data, member)[0];
}

StageData disc_case() { return test::gather_case(small, rsm::Gather::disc, LightType::spot, 0, "disc"); }
StageData continuous_case() {
    return test::gather_case(small, rsm::Gather::disc, LightType::spot, 0, "continuous", rsm::Texels::continuous);
}
StageData paths_case() { return test::paths_case(small, LightType::spot, {.directions = 4, .steps = 3, .turn = rsm::Turn::hash}, "paths"); }
StageData isr_case(const std::string& id) {
    for (StageData& data : test::isr_cases(small))
        if (data.id == id) return std::move(data);
    throw std::logic_error(id);
}
StageData shadow_case() {
    return test::shadow_case(small, LightType::spot, 0, direct::ShadowMode::hard, direct::ShadowVariant::corrected,
                             "shadow");
}

}  // namespace

// Inputs of the frame's size have exactly that; the others lose their map.size. Every axis is tried on its own.
TEST_CASE("stage bindings: an input that is missing, of another type or one too large or small is refused",
          "[bindings]") {
    for (const StageData& data : test::compute_cases(small)) {
        INFO(data.id);
        CHECK(refusal(data) == "");
        for (const Slot& slot : parity::find_binding(data.stage, "test").inputs) {
            const std::string named = "input \"" + slot.name + "\"";
            INFO(slot.name);
            StageData changed = data;
            std::erase_if(changed.inputs.arrays, [&](const Array& a) { return a.name == slot.name; });
            const std::string unread = "shadow: test = 2 reads map_normal, which is missing";
            if (slot.name == "map_normal" && refusal(changed) == unread) {
                CHECK(data.id.starts_with("shadow."));
            } else if (slot.optional) {
                // It counts as zeros; of a manifest it is asked for (tools/plumb/stage_case.cpp).
                const StageBinding& binding = parity::find_binding(data.stage, "test");
                StageData zeros = owned(binding, changed);
                if (slot.kind == SlotKind::buffer) add(zeros.inputs, slot.name, slot.dtype, at(data.inputs, slot.name).shape);
                Bundle without, with;
                binding.bind(changed)->run({}, {}, without), binding.bind(zeros)->run({}, {}, with);
                CHECK(without.arrays.at(0).bytes == with.arrays.at(0).bytes);
            } else {
                CHECK(refusal(changed) == data.label + ": " + named + " is missing");
            }
            changed = data;
            input_of(changed, slot.name).dtype = DType::u32;
            CHECK_THAT(refusal(changed), Catch::Contains(named + " holds u32"));

            if (slot.kind == SlotKind::buffer) continue;
            const Shape shape = at(data.inputs, slot.name).shape;
            for (std::size_t axis = slot.kind == SlotKind::image_array ? 1 : 0; axis < shape.size(); ++axis)
                for (int step : {-1, 1}) {
                    Shape other = shape;
                    other[axis] += step;
                    const std::string start = data.label + ": " + named + " is ";
                    CHECK_THAT(with_shape(data, slot.name, other), Catch::StartsWith(start));
                }
            Shape flat = shape;
            flat.pop_back();
            CHECK_THAT(with_shape(data, slot.name, flat), Catch::Contains(named + " is "));
        }
        for (int step : {-1, 1}) {
            StageData changed = data;
            changed.uniforms.resize(std::size_t(int(data.uniforms.size()) + step));
            CHECK_THAT(refusal(changed), Catch::Contains("the uniform block has"));
        }
    }
}

TEST_CASE("stage bindings: outputs are 1 to 32767 pixels a side, and so are maps", "[bindings]") {
    auto sized = [](glm::ivec2 size) {
        StageData data = test::tonemap_case(small, compose::Operator::clamp, "tonemap");
        data.size = size;
        resize(input_of(data, "radiance"), {size.y, size.x, 4});
        return refusal(data);
    };
    for (glm::ivec2 size : {glm::ivec2(1, 1), glm::ivec2(32767, 1), glm::ivec2(1, 32767)}) CHECK(sized(size) == "");
    CHECK(sized({32768, 1}) == "tonemap: size 32768 x 1: expected 1 to 32767");
    CHECK(sized({1, 32768}) == "tonemap: size 1 x 32768: expected 1 to 32767");
    CHECK(sized({0, 1}) == "tonemap: size 0 x 1: expected 1 to 32767");
    CHECK(sized({1, 0}) == "tonemap: size 1 x 0: expected 1 to 32767");

    CHECK_THAT(with_shape(shadow_case(), "map_position", {1, 32767, 4}), Catch::Contains("expected 48 x 48, map.size a side"));
    CHECK_THAT(with_shape(shadow_case(), "map_position", {1, 32768, 4}), Catch::Contains("expected [*, *, 4]"));
    CHECK_THAT(with_shape(shadow_case(), "map_position", {0, 48, 4}), Catch::Contains("expected [*, *, 4]"));
}

TEST_CASE("stage bindings: a map of another size than the block's is refused", "[bindings]") {
    for (const StageData& data : {shadow_case(), disc_case(), paths_case(),
                                  test::gather_case(small, rsm::Gather::all, LightType::spot, 0, "all")}) {
        const double side = uniform(data, "map.size");
        CHECK(with_uniform(data, "map.size", side) == "");
        for (double other : {side - 1, side + 1})
            CHECK_THAT(with_uniform(data, "map.size", other), Catch::Contains("expected ") && Catch::Contains("map.size"));
    }
}

TEST_CASE("stage bindings: numbers that kernels loop over and index by are held to their ranges", "[bindings]") {
    struct Range {
        StageData data;
        std::string member;
        double first, last;  // that are bound
    };
    const StageData tonemap = test::tonemap_case(small, compose::Operator::clamp, "tonemap");
    const StageData map_blur = test::log_blur_case(small, 32, 8, direct::Direction::vertical, "shadow.blur");
    const StageData filter = test::shadow_filter_case(small, direct::VisibilityFilter::edge_aware, 32, 8,
                                                      direct::Direction::vertical, "shadow.filter");
    const StageData isr_gather = isr_case("isr.gather.turned"), isr_ssao = isr_case("isr.ssao"),
                    isr_camera = isr_case("isr.gather_camera"), isr_blur = isr_case("isr.blur.rows"),
                    isr_upsample = isr_case("isr.upsample"), isr_compose = isr_case("isr.compose");
    for (const Range& r : {Range{shadow_case(), "kernel", 1, 64}, {shadow_case(), "soft", 0, 2},
                           {map_blur, "radius", 0, 32}, {filter, "radius", 0, 32}, {filter, "kind", 0, 1},
                           {filter, "vertical", 0, 1}, {disc_case(), "reach", 0, 32768},
                           {continuous_case(), "reach", 0, 32769},
                           {continuous_case(), "samples", 0, uniform(continuous_case(), "samples")},
                           {disc_case(), "samples", 0, uniform(disc_case(), "samples")}, {tonemap, "op", 0, 3},
                           {paths_case(), "reach", 0, 32768}, {paths_case(), "directions", 0, 4},
                           {paths_case(), "steps", 0, 3}, {paths_case(), "slots", 2, 5},
                           {paths_case(), "propagates", -1, 0},
                           {test::direct_case(small, "direct"), "lights", 0, 4}, {isr_gather, "rings", 0, 3},
                           {isr_gather, "margin", 0, 6}, {isr_ssao, "rings", 0, 2}, {isr_camera, "u.rings", 0, 3},
                           {isr_blur, "radius", 0, 3}, {isr_blur, "kind", 0, 2}, {isr_blur, "vertical", 0, 1},
                           {isr_upsample, "bilateral", 0, 1}, {isr_upsample, "clip_depth", 0, 1},
                           {isr_compose, "published", 0, 1}}) {
        INFO(r.member);
        CHECK(with_uniform(r.data, r.member, r.first) == "");
        CHECK(with_uniform(r.data, r.member, r.last) == "");
        for (double beyond : {r.first - 1, r.last + 1})
            CHECK_THAT(with_uniform(r.data, r.member, beyond),
                       Catch::StartsWith(r.data.label + ": ") && Catch::Contains("expected"));
    }
    // How large a sample is, is nothing without the area of a texel.
    for (const StageData& data : {disc_case(), continuous_case(), paths_case()}) {
        CHECK(with_uniform(data, "sample_area", 0) == "");
        CHECK_THAT(with_uniform(data, "sample_area", 0.3), Catch::Contains("texel_area = 0: expected that of the map's view"));
    }
    // The rotation is picked by the lower bits of a hash.
    for (const StageData& data : {disc_case(), continuous_case(), paths_case(), isr_gather}) {
        CHECK(with_uniform(data, "rotations", 1) == "");
        CHECK(with_uniform(data, "rotations", 2) == "");
        for (double rotations : {-1, 0, 3, 6})
            CHECK_THAT(with_uniform(data, "rotations", rotations), Catch::Contains("a power of two"));
    }
    // No visibility is no slots; a product beyond an int is refused, too.
    CHECK(with_uniform(paths_case(), "slots", 0) == "");
    StageData large = paths_case();
    const double directions[] = {65536};
    set_uniform(parity::find_binding(large.stage, "test"), large, "directions", directions, "test");
    CHECK_THAT(with_uniform(large, "steps", 65537), Catch::StartsWith("paths: directions = 65536, steps = 65537"));
}

TEST_CASE("stage bindings: buffers hold all that is read of them", "[bindings]") {
    const auto samples = std::int64_t(uniform(disc_case(), "samples"));
    const std::int64_t offsets = samples * std::int64_t(uniform(disc_case(), "rotations"));
    CHECK(with_shape(disc_case(), "offsets", {offsets}) == "");
    CHECK_THAT(with_shape(disc_case(), "offsets", {offsets - 1}),
               Catch::Contains(fmt::format("\"offsets\" has {} elements: expected {}", offsets - 1, offsets)));
    CHECK(with_shape(disc_case(), "weights", {samples}) == "");
    CHECK_THAT(with_shape(disc_case(), "weights", {samples - 1}),
               Catch::Contains(fmt::format("\"weights\" has {} elements: expected {}", samples - 1, samples)));

    const std::int64_t rows = 4 * 3 * std::int64_t(uniform(paths_case(), "rotations"));
    for (const char* table : {"offsets", "weights"}) {
        CHECK(with_shape(paths_case(), table, {rows}) == "");
        CHECK_THAT(with_shape(paths_case(), table, {rows - 1}),
                   Catch::Contains(fmt::format("\"{}\" has {} elements: expected {}", table, rows - 1, rows)));
    }
    CHECK(with_shape(paths_case(), "edges", {4}) == "");
    CHECK_THAT(with_shape(paths_case(), "edges", {3}), Catch::Contains("\"edges\" has 3 elements: expected 4"));

    // Four lights of four vec4, a layer each.
    const StageData direct = test::direct_case(small, "direct");
    CHECK(with_shape(direct, "lights", {16, 4}) == "");
    CHECK_THAT(with_shape(direct, "lights", {15, 4}), Catch::Contains("\"lights\" has 15 elements: expected 16"));
    CHECK_THAT(with_shape(direct, "lights", {35}), Catch::Contains("35 numbers: expected elements of 4"));
    CHECK_THAT(with_shape(direct, "lights", {0, 4}), Catch::Contains("0 numbers"));
    CHECK(with_shape(direct, "visibility", {5, small.y, small.x}) == "");
    CHECK(with_shape(direct, "visibility", {4, small.y, small.x}) == "");
    CHECK_THAT(with_shape(direct, "visibility", {3, small.y, small.x}), Catch::Contains("\"visibility\" has 135 elements: expected 180"));
    CHECK_THAT(with_shape(direct, "visibility", {0, small.y, small.x}), Catch::Contains("is [0, 5, 9]"));
}

// A texel's number is an int32: 32767 x 65538 is 2^31 - 2, 16384 x 512 x 256 is 2^31.
TEST_CASE("stage bindings: layers beyond what an index can count are refused", "[bindings]") {
    auto layers = [](std::int64_t n, glm::ivec2 size) {
        StageData data = test::direct_case(small, "direct");
        data.size = size;
        for (const char* name : {"position", "normal"}) resize(input_of(data, name), {size.y, size.x, 4});
        input_of(data, "visibility").shape = {n, size.y, size.x};  // nothing is read of it here
        return refusal(data);
    };
    CHECK(layers(32767, {10923, 6}) == "");
    CHECK_THAT(layers(16384, {512, 256}), Catch::Contains("16384 layers: too many"));
    CHECK(layers(16383, {512, 256}) == "");
}

// ---- the dispatches of a frame --------------------------------------------------------------------------------------

namespace {

// A floor of 2 m under a lamp at the height of 1 m: the lamp's upper face sees nothing.
Scene lamp_over_floor() {
    Scene s;
    s.frame_size = {20, 12};
    s.camera.position = {0, 1, 2};
    s.camera.look_at = {0, 0, 0};
    s.materials.resize(1);
    Mesh mesh;
    for (glm::vec3 p : {glm::vec3(-1, 0, 1), glm::vec3(1, 0, 1), glm::vec3(1, 0, -1), glm::vec3(-1, 0, -1)})
        mesh.vertices.push_back({p, 0, glm::vec3(0, 1, 0), 0});
    mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
    mesh.material = {0, 0};
    s.meshes.push_back(mesh);
    Light lamp = test::make_light(LightType::point, 8), spot = test::make_light(LightType::spot, 8);
    lamp.name = "lamp", spot.name = "spot";
    lamp.position = {0, 1, 0};
    s.lights = {lamp, spot};
    return s;
}

struct Dispatches {
    frame::Frame frame;
    std::vector<StageData> list, planned;  // of the frame, and of one that was not executed

    Dispatches(const Scene& scene, bool pruning = true) {
        frame::Settings settings;
        settings.rsm.gather = rsm::Gather::disc, settings.rsm.samples = 4;
        settings.pruning = pruning;
        const frame::Plan plan = frame::plan(scene, settings);
        frame = frame::execute(scene, settings, plan, {});
        list = parity::frame_data(scene, settings, plan, frame);
        planned = parity::frame_data(scene, settings, plan, {});
    }
    std::vector<std::string> ids(const std::string& stage) const {
        std::vector<std::string> of_stage;
        for (const StageData& d : list)
            if (d.stage == stage) of_stage.push_back(d.id);
        return of_stage;
    }
    const StageData& at(const std::string& id) const {
        for (const StageData& d : list)
            if (d.id == id) return d;
        INFO(id);
        REQUIRE(false);
        return list[0];
    }
};

using Ids = std::vector<std::string>;

}  // namespace

TEST_CASE("frame_data: each shadow dispatch serves the face whose map it reads", "[frame][point]") {
    const Dispatches d(lamp_over_floor());
    int faces = 0;
    for (int face = 0; face < raster::light_faces; ++face) {
        const raster::Rsm& map = d.frame.rsms[0][std::size_t(face)];
        if (map.size == 0) continue;
        ++faces;
        const std::string of_face = std::string("lamp.") + raster::face_names[face];
        const StageData& shadow = d.at("shadow." + of_face);
        CHECK(uniform(shadow, "face") == face);
        const Array& depth = at(shadow.inputs, "map_position");
        CHECK(std::memcmp(depth.bytes.data(), map.position.data(), depth.bytes.size()) == 0);
        const Array& flux = at(d.at("rsm.disc." + of_face).inputs, "rsm_flux");
        CHECK(std::memcmp(flux.bytes.data(), map.flux.data(), flux.bytes.size()) == 0);
    }
    CHECK(faces == 5);
    CHECK(uniform(d.at("shadow.spot"), "face") == -1);
}

// Expected: nothing lies above the lamp, so that the face +y has no dispatch at all.
TEST_CASE("frame_data: a face that sees nothing has no dispatch, drawn or planned", "[frame][point]") {
    const Dispatches d(lamp_over_floor());
    REQUIRE(d.frame.rsms[0][2].size == 0);
    for (const char* stage : {"rsm", "shadow", "rsm.disc"}) {
        const std::string s = stage;
        CHECK(d.ids(s) == Ids{s + ".lamp.px", s + ".lamp.nx", s + ".lamp.ny", s + ".lamp.pz", s + ".lamp.nz",
                              s + ".spot"});
    }
    REQUIRE(d.planned.size() == d.list.size());
    for (std::size_t i = 0; i < d.list.size(); ++i) {
        INFO(d.list[i].id);
        CHECK(d.planned[i].id == d.list[i].id);
        CHECK(d.planned[i].uniforms == d.list[i].uniforms);
    }
}

TEST_CASE("frame_data: a light that is off sends nothing, and has dispatches only where nothing is pruned", "[frame]") {
    Scene scene = lamp_over_floor();
    scene.lights[1].on = false;
    const Dispatches pruned(scene), whole(scene, false);
    CHECK(pruned.ids("rsm").size() == 5);
    CHECK(pruned.ids("shadow").size() == 5);
    CHECK(whole.ids("shadow").size() == 7);  // the face that sees nothing, too
    const StageBinding& rsm = parity::find_binding("rsm", "test");
    CHECK(uniform_value(rsm, whole.at("rsm.spot"), "light.intensity") == std::vector<double>{0, 0, 0});
    CHECK(uniform_value(rsm, whole.at("rsm.lamp.ny"), "light.intensity")[0] == scene.lights[0].intensity.x);
    // Rows of a light: position, direction, intensity.
    for (const Dispatches* d : {&pruned, &whole}) {
        const float* lights = floats(d->at("direct"), "lights");
        for (int c = 0; c < 3; ++c) {
            CHECK(lights[8 + c] == scene.lights[0].intensity[c]);
            CHECK(lights[16 + 8 + c] == 0);
        }
    }
}

TEST_CASE("frame_data: lights of one name, or of none, have dispatches of names of their own", "[frame]") {
    Scene scene = lamp_over_floor();
    const Light spot = scene.lights[1];
    scene.lights.assign(5, spot);
    const char* const names[] = {"key light", "key_light", "key/light", "", "light"};
    for (std::size_t i = 0; i < 5; ++i) scene.lights[i].name = names[i];
    const Dispatches d(scene);
    CHECK(d.ids("shadow") == Ids{"shadow.key_light", "shadow.key_light_", "shadow.key_light__", "shadow.light",
                                 "shadow.light_"});
    CHECK(d.ids("rsm").size() == 5);
}
