// Light of frames before this one: the clock that turns patterns and hands the last frame over, and the stage that joins them.
#include "gi/frame/filters.h"
#include "gi/frame/frame_graph.h"
#include "gi/screen/screen.h"

namespace plumb::frame {

bool reuses_light(const Settings& settings) { return settings.method == Method::rsm && settings.reuse.frames > 0; }

int pattern_turn(const Context& c, int rotations) {
    const std::uint32_t frames = c.frame.light_frames;
    return reuses_light(c.settings) && frames > 0 ? screen::turn_of_frame(frames - 1, rotations) : 0;
}

void add_light_clock(Context& c, Nodes& nodes) {
    PlannedNode node = begin_node(c, "light clock", "", "", 0, {});
    node.listed = false;
    // What it counts is another number in each frame.
    node.reads = [&c](graph::Reads& r) { r.value(c.frame.light_frames, c.size); };
    node.outputs = [] { return Bundle(); };
    node.run = [&c](const RunOptions&, graph::NodeRun&) {
        Frame& f = c.frame;
        f.last_light = f.next_light;
        if (f.last_light.frame != c.size) f.last_light = {};
        ++f.light_frames;
    };
    node.leave_out = [] {};
    nodes.push_back(std::move(node));
}

namespace {

// What the next frame finds.
void add_latch(Context& c, Image4 Frame::*light, Nodes& nodes) {
    PlannedNode node = begin_node(c, "light latch", "", "", 0, {});
    node.listed = false;
    const auto points = [&c](bool normal) -> const Image4& {
        const Frame& f = c.frame;
        if (halves_indirect(c.settings)) return normal ? f.half_normal : f.half_position;
        return normal ? f.gbuffer.normal : f.gbuffer.position;
    };
    node.reads = [=, &c](graph::Reads& r) {
        r.image(c.frame.*light), r.image(c.frame.reused_age), r.image(points(false)), r.image(points(true));
        r.value(c.frame.light_frames);
    };
    node.outputs = [] { return Bundle(); };
    node.run = [=, &c](const RunOptions&, graph::NodeRun&) {
        c.frame.next_light = {c.frame.*light, c.frame.reused_age, points(false), points(true), c.camera_view(), c.size};
    };
    node.leave_out = [] {};
    nodes.push_back(std::move(node));
}

}  // namespace

void add_reuse(Context& c, Nodes& nodes) {
    screen::validate(c.settings.reuse);
    const bool half = halves_indirect(c.settings), filtered = half || blur_of(c.settings) != filter::Blur::none;
    Image4 Frame::*light = filtered ? &Frame::reused : &Frame::indirect;
    const StageBinding& binding = stage<screen::ReuseKernel>();
    const glm::ivec2 size = gather_size(c.settings, c.size);
    PlannedNode node = begin_node(c, binding, "filter", "gathered light is a mean of frames", double(size.x) * size.y);
    node.size = [=] { return size; };
    const auto inputs = [=, &c] {
        const Frame& f = c.frame;
        return screen::ReuseInputs{&f.gathered, half ? &f.half_position : &f.gbuffer.position,
                                   half ? &f.half_normal : &f.gbuffer.normal, c.camera_view(), &f.last_light, c.size};
    };
    const screen::ReuseParams& params = c.settings.reuse;
    node.dispatches = [=, &params] { return std::vector<StageData>{screen::data_of(params, inputs())}; };
    node.reads = [=, &params, &binding](graph::Reads& r) { r.dispatch(binding, screen::data_of(params, inputs())); };
    node.outputs = [=, &c, &binding] {
        Bundle b;
        lend(b, binding.outputs[0].name, c.frame.*light), lend(b, binding.outputs[1].name, c.frame.reused_age);
        return b;
    };
    node.run = [=, &c, &params](const RunOptions& options, graph::NodeRun& run) {
        screen::run_reuse(params, inputs(), options, c.frame.*light, c.frame.reused_age);
        run.bytes = 2 * bytes_of(c.frame.*light);
        if (c.frame.last_light.empty()) {
            run.reason += "; there is no last frame";
            return;
        }
        std::size_t seen = 0, fresh = 0, ghosts = 0;
        for (const glm::vec4& age : c.frame.reused_age.texels) seen += age.w > 0, fresh += age.w > 0 && age.x == 1, ghosts += age.z > 0;
        run.reason += fmt::format("; of {} pixels {} were not seen in the last frame, {} had other light", seen, fresh, ghosts);
    };
    node.explain = [=, &params](glm::ivec2 at) { return plumb::explain(params, inputs(), at); };
    node.leave_out = [=, &c] {
        Image4& image = c.frame.*light = Image4(size.x, size.y);
        const Image4& position = half ? c.frame.half_position : c.frame.gbuffer.position;
        for (std::size_t i = 0; i < image.size(); ++i) image.texels[i].w = position.texels[i].w;
        c.frame.reused_age = Image4(size.x, size.y);
    };
    node.reads_left_out = [=, &c](graph::Reads& r) { r.image(half ? c.frame.half_position : c.frame.gbuffer.position); };
    node.results = {{"reused", "reused", "reused"}, {"frames", "age", "frames", 0, 1}};
    nodes.push_back(std::move(node));
    add_latch(c, light, nodes);
}

}  // namespace plumb::frame
