// What core/kernel_stage.h makes of a description: stages of this file's own, over a list and with two outputs.
#include <catch2/catch.hpp>

#include "core/error.h"
#include "core/kernel_stage.h"

namespace plumb {

namespace {

// ---- one over a list of receivers, its inputs and its output buffers ---------------------------------------------------

struct ScaleView {
    struct Uniforms {
        float scale;
        std::int32_t width, height;  // receivers, 1
        std::int32_t padding;
    } u;
    const float* receivers;  // [width][4]
    const std::int32_t* order;  // [width]
    float* scaled;           // [width][4]
};
struct ScaleKernel {
    using View = ScaleView;
    template <class F, class Tap>
    static vec4<F> item(const View& in, index_t<F> x, index_t<F>, Tap& tap) {
        const index_t<F> i = number<F>::fetch(in.order, x);
        tap("receiver", i, "");
        const vec4<F> r = number<F>::fetch4(in.receivers, i);
        return {F(in.u.scale) * r.x, F(in.u.scale) * r.y, F(in.u.scale) * r.z, r.w};
    }
    static float* out(const View& in) { return in.scaled; }
};
struct ScaleTwin {
    static constexpr TwinMember members[] = {{"scale", "float", 0}, {"width", "int", 4}, {"height", "int", 8}};
    static constexpr TwinBinding bindings[] = {{"receivers", TwinKind::buffer, 1, "vec4"},
                                               {"order", TwinKind::buffer, 2, "int"},
                                               {"scaled", TwinKind::storage_buffer, 3, "vec4"}};
    static constexpr TwinLayout layout{"tests/scale.comp", false, members, 16, bindings};
    template <class Block>
    static consteval bool fits() {
        return sizeof(Block) == 16;
    }
};
std::size_t receivers_of(const ScaleView& v) { return std::size_t(v.u.width); }
StageDescription<ScaleView> describe(ScaleKernel) {
    return {.name = "test.scale",
            .source = "this test",
            .domain = "receiver",
            .inputs = {{.name = "receivers", .at = &ScaleView::receivers, .count = receivers_of, .why = "one a receiver"},
                       {.name = "order", .at = &ScaleView::order, .count = receivers_of, .why = "one a receiver"}},
            .outputs = {{.name = "scaled", .at = &ScaleView::scaled}},
            .uniforms = {{"scale", 0, 10}}};
}

// ---- one with two outputs of different types --------------------------------------------------------------------------

template <class F>
struct Pair {
    vec4<F> value;
    F length;
    template <class Each>
    void components(Each each) const {
        each(value.x), each(value.y), each(value.z), each(value.w), each(length);
    }
};
struct PairView {
    struct Uniforms {
        std::int32_t width, height, padding[2];
    } u;
    const float* normal;
    float *value, *length;
};
struct PairKernel {
    using View = PairView;
    template <class F, class Tap>
    static Pair<F> item(const View& in, index_t<F> x, index_t<F> y, Tap&) {
        const vec4<F> n = number<F>::fetch4(in.normal, y * index_t<F>(in.u.width) + x);
        return {n, sqrt(n.x * n.x + n.y * n.y + n.z * n.z)};
    }
    template <class F>
    static void store(const View& in, index_t<F> at, const Pair<F>& p, mask_t<F> active) {
        number<F>::store4(in.value, at, p.value, active);
        number<F>::store(in.length, at, p.length, active);
    }
};
struct PairTwin {
    static constexpr TwinMember members[] = {{"width", "int", 0}, {"height", "int", 4}};
    static constexpr TwinBinding bindings[] = {{"normal_image", TwinKind::sampled_image, 1, ""},
                                               {"value_image", TwinKind::storage_image, 2, "vec4"},
                                               {"length_image", TwinKind::storage_image, 3, "float"}};
    static constexpr TwinLayout layout{"tests/pair.comp", false, members, 16, bindings};
    template <class Block>
    static consteval bool fits() {
        return sizeof(Block) == 16;
    }
};
StageDescription<PairView> describe(PairKernel) {
    return {.name = "test.pair",
            .source = "this test",
            .domain = "pixel",
            .inputs = {{.name = "normal", .at = &PairView::normal}},
            .outputs = {{.name = "value", .at = &PairView::value}, {.name = "length", .at = &PairView::length}}};
}

}  // namespace

// One lane at a time serves these tests; shade_rows.h is for kernel files.
template <Isa isa>
struct Rows<ScaleKernel, isa> {
    static void run(const ScaleView& in, int, int, const Tiles&, float*) {
        NoTap tap;
        for (int x = 0; x < in.u.width; ++x)
            number<float>::store4(in.scaled, x, ScaleKernel::item<float>(in, x, 0, tap), true);
    }
};
template <Isa isa>
struct Rows<PairKernel, isa> {
    static void run(const PairView& in, int first, int last, const Tiles&, float*) {
        NoTap tap;
        for (int y = first; y < last; ++y)
            for (int x = 0; x < in.u.width; ++x)
                PairKernel::store<float>(in, y * in.u.width + x, PairKernel::item<float>(in, x, y, tap), true);
    }
};

namespace {

StageData scale_data(int n, float scale) {
    StageData d = begin_data(made<ScaleKernel, ScaleTwin>(), {n, 1}, uniform_block(ScaleView::Uniforms{scale, n, 1, 0}));
    std::vector<float> receivers;
    std::vector<std::int32_t> order;
    for (int i = 0; i < n; ++i) {
        for (int c = 0; c < 4; ++c) receivers.push_back(float(10 * i + c));
        order.push_back(n - 1 - i);
    }
    add(d.inputs, "receivers", {n, 4}, receivers.data());
    add(d.inputs, "order", {n}, order.data());
    return d;
}

}  // namespace

TEST_CASE("a stage over a list: its buffers, its outcomes and its refusals", "[stage]") {
    const StageBinding& binding = made<ScaleKernel, ScaleTwin>();
    REQUIRE(binding.inputs.size() == 2);
    CHECK(binding.inputs[1].dtype == DType::i32);  // as the twin says
    CHECK(binding.inputs[0].channels == 4);
    CHECK(binding.outputs[0].kind == SlotKind::storage_buffer);
    CHECK(binding.info.outputs[0].type == "buffer f32 x 4");

    // More items than an image is wide.
    const int n = 70001;
    const StageData data = scale_data(n, 2);
    Bundle outputs;
    const auto bound = binding.bind(data);
    bound->run({}, {}, outputs);
    REQUIRE(outputs.arrays.at(0).shape == Shape{n, 4});
    const auto scaled = elements<float>(outputs, "scaled", {n, 4});
    for (int i : {0, 1, n - 1}) {
        CHECK(scaled[std::size_t(4 * i + 1)] == 2 * float(10 * (n - 1 - i) + 1));
        std::vector<double> exact;
        bound->in_double({i, 0}, exact);
        CHECK(exact == std::vector<double>{2.0 * (10 * (n - 1 - i)), 2.0 * (10 * (n - 1 - i) + 1),
                                           2.0 * (10 * (n - 1 - i) + 2), 10.0 * (n - 1 - i) + 3});
        CHECK(bound->explain({i, 0}).at(0).value.at(0) == n - 1 - i);
    }

    CHECK_THROWS_WITH(binding.bind(scale_data(3, 11)), "test.scale: scale = 11: expected 0 to 10");
    StageData cut = scale_data(3, 1);
    cut.size.x = 4;
    CHECK_THROWS_WITH(binding.bind(cut),
                      "test.scale: input \"receivers\" has 3 elements: expected 4, one a receiver");
}

TEST_CASE("a stage with two outputs of different types", "[stage]") {
    const StageBinding& binding = made<PairKernel, PairTwin>();
    Image4 normal(3, 2, glm::vec4(3, 0, 4, 1));
    StageData data = begin_data(binding, {3, 2}, uniform_block(PairView::Uniforms{3, 2, {}}));
    lend(data.inputs, "normal", normal);
    const auto bound = binding.bind(data);
    Bundle outputs;
    bound->run({}, {}, outputs);
    REQUIRE(outputs.arrays.size() == 2);
    CHECK(outputs.arrays[0].shape == Shape{2, 3, 4});
    CHECK(outputs.arrays[1].shape == Shape{2, 3});
    for (const float length : elements<float>(outputs, "length", {2, 3})) CHECK(length == 5);
    std::vector<Outcome> ways;
    bound->outcomes({1, 1}, {}, {}, {}, ways);
    REQUIRE(ways.size() == 1);
    REQUIRE(ways[0].values.size() == 5);
    CHECK(ways[0].values[4].shadow == 5);
    CHECK(ways[0].values[4].bound > 0);
    CHECK(ways[0].values[0].bound == 0);
    DecisionTape tape;
    tape.record();
    std::vector<Followed> along;
    bound->follow({2, 0}, tape, along);
    CHECK(along.size() == 5);
}

TEST_CASE("what a device makes of an input before it reads it lies within the input's bound", "[stage]") {
    const StageBinding& binding = made<PairKernel, PairTwin>();
    Image4 normal(2, 1, glm::vec4(3, 0, 4, 1)), moved(2, 1, glm::vec4(0));
    moved(1, 0) = glm::vec4(0.01f, 0.02f, 0, 0);
    StageData data = begin_data(binding, {2, 1}, uniform_block(PairView::Uniforms{2, 1, {}}));
    lend(data.inputs, "normal", normal);
    std::vector<Outcome> exact, inexact;
    binding.bind(data)->outcomes({0, 0}, {}, {}, {}, exact);
    lend(data.inputs, moved_name("normal"), moved);
    const auto bound = binding.bind(data);
    for (const int x : {0, 1}) {
        INFO(x);
        bound->outcomes({x, 0}, {}, {}, {}, inexact);
        REQUIRE(inexact.size() == 1);
        const auto& values = inexact[0].values;
        // Its own float result is the same; the length moves by n . moved / |n| = 0.006, and of second order by less than
        // |moved|^2 / |n| = 0.0001 (3.01^2 + 0.02^2 + 4^2 is 5.00605^2).
        CHECK(values[4].shadow == 5);
        CHECK(values[0].bound == (x == 0 ? 0 : double(0.01f)));
        CHECK(values[1].bound == (x == 0 ? 0 : double(0.02f)));
        CHECK(values[2].bound == 0);
        if (x == 0) CHECK(values[4].bound == exact[0].values[4].bound);
        if (x == 1) CHECK(values[4].bound > 0.00605);
        if (x == 1) CHECK(values[4].bound < 0.0063);
    }
    // Who reads the same numbers afterwards reads them as they are.
    binding.bind(data)->outcomes({0, 0}, {}, {}, {}, exact);
    CHECK(number<Bounded>::fetch4(&normal(0, 0).x, 1).x.bound == 0);
    // So is a number that is fetched alone.
    const InexactRange range{&normal(0, 0).x, &moved(0, 0).x, 8};
    {
        const InexactScope inexact({&range, 1});
        CHECK(number<Bounded>::fetch(&normal(0, 0).x, 5).bound == double(0.02f));
        CHECK(number<Bounded>::fetch(&normal(0, 0).x, 5).shadow == double(normal(1, 0).y));
    }
    CHECK(number<Bounded>::fetch(&normal(0, 0).x, 5).bound == 0);
    const Image4 wrong(1, 1);
    StageData cut = begin_data(binding, {2, 1}, uniform_block(PairView::Uniforms{2, 1, {}}));
    lend(cut.inputs, "normal", normal), lend(cut.inputs, moved_name("normal"), wrong);
    CHECK_THROWS_WITH(binding.bind(cut), "normal.moved: expected numbers of the input's shape");
}

namespace {

struct Unbound : PairTwin {
    static constexpr TwinBinding bindings[] = {{"normal_image", TwinKind::sampled_image, 1, ""},
                                               {"value_image", TwinKind::storage_image, 2, "vec4"},
                                               {"size_image", TwinKind::storage_image, 3, "float"}};
    static constexpr TwinLayout layout{"tests/pair.comp", false, members, 16, bindings};
};
struct Another : PairTwin {
    static constexpr TwinBinding bindings[] = {{"normal_image", TwinKind::sampled_image, 1, ""},
                                               {"value_image", TwinKind::storage_image, 2, "vec4"},
                                               {"length_image", TwinKind::storage_image, 3, "float"},
                                               {"depth_image", TwinKind::sampled_image, 4, ""}};
    static constexpr TwinLayout layout{"tests/pair.comp", false, members, 16, bindings};
};

}  // namespace

TEST_CASE("a description that its twin contradicts is refused in one line", "[stage]") {
    const auto description = describe(PairKernel{});
    CHECK_THROWS_WITH(binding_of(description, Unbound::layout), "tests/pair.comp: \"length\" is no binding of the twin");
    CHECK_THROWS_WITH(binding_of(description, Another::layout),
                      "tests/pair.comp: the twin binds \"depth_image\", which the description names nowhere");
    StageDescription<PairView> swapped = description;
    swapped.inputs[0].name = "value", swapped.outputs[0].name = "normal";
    CHECK_THROWS_WITH(binding_of(swapped, PairTwin::layout),
                      "tests/pair.comp: the twin writes \"value\", the description has it among its inputs");
}

// ---- one that draws ---------------------------------------------------------------------------------------------------

namespace {

struct DrawTwin {
    static constexpr TwinMember members[] = {{"viewer", "vec4", 0}, {"light.on", "float", 16}};
    static constexpr TwinBinding bindings[] = {{"triangles", TwinKind::buffer, 2, "int"},
                                               {"behind_image", TwinKind::sampled_image, 5, ""},
                                               {"colour", TwinKind::target, 0, "vec4"},
                                               {"id", TwinKind::target, 1, "ivec2"}};
    static constexpr TwinLayout layout{"tests/draw", true, members, 32, bindings};
};
NamedStage drawing() {
    return {.name = "test.draw",
            .source = "this test",
            .domain = "pixel",
            .inputs = {{.name = "triangles"}, {.name = "behind", .channels = 1}},
            .outputs = {{.name = "colour"}, {.name = "id"}, {.name = "depth"}},
            .fixed_uniforms = {{"light.on", 1}}};
}
std::string refusal(const NamedStage& stage) {
    try {
        binding_of(stage, DrawTwin::layout);
        return "";
    } catch (const std::logic_error& error) {
        return error.what();
    }
}

}  // namespace

TEST_CASE("a raster stage: numbers, locations and types are the twin's, and it has a depth buffer", "[stage][raster]") {
    const StageBinding binding = binding_of(drawing(), DrawTwin::layout);
    CHECK(binding.raster);
    CHECK(binding.twin == "tests/draw");
    CHECK(binding.info.twin == "tests/draw.frag");
    CHECK(binding.uniform_bytes == 32);
    REQUIRE(binding.uniforms.size() == 2);
    CHECK(binding.uniforms[0].fixed == 0);
    CHECK(binding.uniforms[1].fixed == 1);
    struct Expected {
        const Slot& slot;
        SlotKind kind;
        int at;
        DType dtype;
        int channels;
        bool frame;
    };
    REQUIRE(binding.inputs.size() == 2);
    REQUIRE(binding.outputs.size() == 3);
    for (const Expected& e : {Expected{binding.inputs[0], SlotKind::buffer, 2, DType::i32, 1, false},
                              {binding.inputs[1], SlotKind::image, 5, DType::f32, 1, true},
                              {binding.outputs[0], SlotKind::target, 0, DType::f32, 4, true},
                              {binding.outputs[1], SlotKind::target, 1, DType::i32, 2, true},
                              {binding.outputs[2], SlotKind::depth, 0, DType::f32, 1, true}}) {
        INFO(e.slot.name);
        CHECK(e.slot.kind == e.kind);
        CHECK(e.slot.binding == e.at);
        CHECK(e.slot.dtype == e.dtype);
        CHECK(e.slot.channels == e.channels);
        CHECK(e.slot.frame == e.frame);
    }
    CHECK(binding.info.outputs[1].type == "image rg32i");
    CHECK(binding.info.outputs[2].type == "image r32f");
}

TEST_CASE("a raster stage that its twin contradicts is refused in one line", "[stage][raster]") {
    CHECK(refusal(drawing()) == "");
    NamedStage changed = drawing();
    changed.inputs[0].name = "vertices";
    CHECK(refusal(changed) == "tests/draw: \"vertices\" is no binding of the twin");
    changed = drawing();
    changed.inputs.pop_back();
    CHECK(refusal(changed) == "tests/draw: the twin binds \"behind_image\", which the description names nowhere");
    changed = drawing();
    changed.outputs.pop_back();
    CHECK(refusal(changed) == "tests/draw: the twin binds \"depth\", which the description names nowhere");
    changed = drawing();
    changed.outputs.insert(changed.outputs.begin(), changed.outputs[0]);
    CHECK(refusal(changed) == "tests/draw: the twin binds \"colour\", which the description names more than once");
    changed = drawing();
    std::swap(changed.inputs[0], changed.outputs[1]);
    CHECK(refusal(changed) == "tests/draw: the twin writes \"id\", the description has it among its inputs");
    changed = drawing();
    changed.fixed_uniforms[0].first = "light.off";
    CHECK(refusal(changed) == "tests/draw: \"light.off\" is no member of the twin's uniform block");
}

TEST_CASE("lent bytes: read in place, written in place, or copied first", "[bundle]") {
    const float values[] = {1, 2, 3};
    float written[] = {0, 0, 0};
    Bundle bundle;
    lend(bundle, "read", {3}, values);
    lend(bundle, "write", {3}, written);
    CHECK(static_cast<const Bundle&>(bundle).arrays[0].bytes.data() == reinterpret_cast<const unsigned char*>(values));
    reinterpret_cast<float*>(bundle.arrays[1].bytes.data())[2] = 7;
    CHECK(written[2] == 7);
    reinterpret_cast<float*>(bundle.arrays[0].bytes.data())[0] = 9;  // copies
    CHECK(values[0] == 1);
    CHECK(elements<float>(bundle, "read", {3})[0] == 9);
    Array copy = bundle.arrays[1];
    copy.bytes.own();
    written[2] = 8;
    CHECK(elements<float>(copy, {3})[2] == 7);
    CHECK_FALSE(copy.bytes == bundle.arrays[1].bytes);
}

}  // namespace plumb
