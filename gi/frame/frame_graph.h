// The graph of a frame (gi/graph/graph.h): every stage's node is added once, in the file of its method, and all that is
// done with stages goes through it: plan, execute, explain, export, stability. Private to gi/, but for who looks at a frame.
//
//     nodes_raster.cpp   G-buffers and maps            nodes_filter.cpp    filters of indirect light
//     nodes_direct.cpp   shadows and direct light      nodes_isr.cpp       image-space radiosity
//     nodes_rsm.cpp      gathers and their sum         nodes_compose.cpp   the picture, and what is path traced
//     nodes_probes.cpp   irradiance probes (nodes_probes.h)
//     nodes_radiosity.cpp   hemicube radiosity
//     nodes_zbuffer.cpp  light at vertices and pixels
//     nodes_ao.cpp       ambient occlusion
//     nodes_reuse.cpp    light of frames before
//     nodes_reflect.cpp  reflections
//     nodes_shade.cpp    indirect shadows of what moves
//     nodes_relief.cpp   their normal maps, highlights, static lamps
#pragma once

#include <memory>
#include <vector>

#include "core/error.h"
#include "gi/frame/frame.h"
#include "gi/frame/isr.h"
#include "gi/frame/keys.h"
#include "gi/frame/kept_memory.h"
#include "gi/frame/relief_use.h"
#include "gi/graph/graph.h"
#include "gi/lend.h"
#include "raster/light_view.h"

namespace plumb::frame {

// A row of the work that a rule may leave out (rules.h), and what it is expected to take.
struct TileWork {
    std::string work;
    int light = -1;
    double expected_ms = 0;
};

// What nodes are made from, and where they find what they read and write.
struct Context {
    Context(const Scene& scene, const Settings& settings, Frame& frame);

    const Scene& scene;
    const Settings& settings;
    Frame& frame;
    KeptMemory* memory = nullptr;   // of an execution; else null
    const Plan* plan = nullptr;     // what of buffers and maps is wanted, and the rules that the run asks; null: all, and none
    std::unique_ptr<Tracer> tracer = {};
    SceneKeys keys = {};            // where keys are asked for
    std::uint64_t bake_key = 0;     // as well
    graph::Store* rows = nullptr;   // Stores::rows
    Isa isa = Isa::scalar;
    bool keeps = false;             // of an execution: what each gather makes is wanted again
    std::vector<std::string> summed = {};  // labels of gathers that have added to the sum themselves
    double triangles = 0;           // to plan with
    glm::ivec2 size{0};
    std::vector<Light> lights;      // shining()
    std::vector<IsrView> views;     // isr_views()
    ReliefUse relief;               // relief_use()
    std::vector<bool> static_lamps; // static_lamps()
    int isr_gathers = 0, isr_bounces = 0, isr_unseen = 0;  // images of Frame::isr
    int ao_views = 0;               // of Frame::ao
    int reflect_views = 0;          // of Frame::reflect

    // The scene as stages read it; made here where nobody has given it.
    World& world();

    View camera_view() const { return make_view(scene.camera, double(size.x) / size.y, scene.convention, size); }
    raster::GBuffer& gbuffer(int view) { return view == 0 ? frame.gbuffer : frame.views[std::size_t(view)].gbuffer; }
    // What direct light of the frame reads.
    Buffer<float>& lit(int view) {
        return view == 0 && !static_lamps.empty() ? frame.probes.relief.visibility : shadows(view);
    }
    // Of the frame itself filtered, where its shadows are.
    Buffer<float>& shadows(int view) {
        return view == 0 && filters_shadows(settings) ? frame.visibility_filtered : visibility(view);
    }
    bool is_static(int light) const { return !static_lamps.empty() && static_lamps[std::size_t(light)]; }
    Image4& direct(int view) { return view == 0 ? frame.direct : frame.views[std::size_t(view)].direct; }
    Buffer<float>& visibility(int view) { return view == 0 ? frame.visibility : frame.views[std::size_t(view)].visibility; }
    float* visibility(int light, int view) {
        return visibility(view).data() + std::size_t(light) * pixels(view);
    }
    std::size_t pixels(int view) const {
        const glm::ivec2 of = views[std::size_t(view)].size;
        return std::size_t(of.x) * std::size_t(of.y);
    }
    std::vector<raster::Rsm>& maps(int light) { return frame.rsms[std::size_t(light)]; }
    // What a light's gather adds to the sum, and its standard error, where they are wanted again.
    Image4& term(int light);
    Image4& term_error(int light);

    // The tiles that a node shades, where a rule of the plan leaves out others, which `run` tells; empty: all of them.
    // covered: of the pixels that it writes.
    raster::Covered tiles_to_shade(const TileWork& work, const raster::Covered& covered, graph::NodeRun& run) const;

  private:
    std::unique_ptr<World> own_world_;
    std::vector<Image4> own_terms_, own_errors_;
};

// What a stage's run() takes for them.
inline const raster::Covered* or_all(const raster::Covered& tiles) { return tiles.any.empty() ? nullptr : &tiles; }

// A part of a node that a rule of the plan may leave out. Parts of one name that have an index are told together.
struct Part {
    std::string name;  // as Work has it
    int index = -1;
    std::function<double(const Plan&)> ms;
    std::function<void(Plan&)> leave_out;
};

// A value of an item that its stage explains and writes: `count` channels from `channel` on of one output.
struct Result {
    std::string name;    // as people read it
    std::string output;  // which of the node's outputs; of several maps behind the face's name; of compute(): its one
    std::string tap;     // the name of the value in explain()
    int channel = 0, count = 3;
    bool stored = false;      // a target may have rounded it: "stored_<tap>" goes before `tap`
    bool where_seen = false;  // of an item that sees nothing nothing is explained
};

// A picture of one item, beside its values: what the image's slot would be, and its own bytes.
struct ItemPicture {
    Slot slot;
    Array array;
};

struct PlannedNode : graph::Node {
    std::string work;            // as rules name it (rules.h): "gather", "isr lit"; empty where the node has no row
    std::vector<Part> parts = {};
    double map_texels = 0;       // that it holds
    std::string of_layer = {};   // of a node without a row: it runs where that layer is traced; empty: always
    std::string view_name = {};  // of a view beside the frame
    bool of_scene = false;       // it reads nothing that another node makes
    bool of_pixels = true;       // its items are pixels of the frame, or stand for some
    bool by_name = true;         // it can be asked for by its stage's name: it is of the frame itself
    bool in_steps = false;       // all nodes of the stage (of a light) make one thing, and are looked at together
    std::function<raster::Covered()> covered = {};  // of the pixels that it writes; missing: the G-buffer's
    bool direct = false;         // it is of what is seen and lit without a bounce, and stands on nothing else
    bool adds = false;           // it adds to the sum of gathers
    std::vector<Result> results = {};
    std::function<std::vector<ItemPicture>(glm::ivec2 item)> pictures = {};
    // Of a stage without a twin: dispatches of one that reads the same, to look at.
    std::function<std::vector<StageData>()> like = {};
    // What it reads by the names of its stage's ports, where no dispatch says it.
    std::function<Bundle()> inputs = {};
    std::function<void()> fill = {};  // makes what is missing of its outputs for others to read; missing: as left out

    TileWork tile_work() const { return {work, plan.light, plan.expected_ms}; }
};

// All nodes of a frame of those settings, in their order, each planned as if nothing were left out.
class FrameGraph {
  public:
    // To plan with: nothing was made yet.
    FrameGraph(const Scene& scene, const Settings& settings, const Geometry& geometry);
    // To look at what was made. Changes nothing of it, but by fill().
    FrameGraph(const Scene& scene, const Settings& settings, const Frame& frame);
    // To execute a plan.
    FrameGraph(const Scene& scene, const Settings& settings, const Plan& plan, KeptMemory& memory);

    Context& context() { return *context_; }
    const std::vector<PlannedNode>& nodes() const { return nodes_; }
    // The node that a row of a plan stands for. Throws std::logic_error where there is none.
    const PlannedNode& node(const PlannedStage& stage) const;
    // Those that a plan runs or leaves out, each as the plan has it, with what joins them.
    std::vector<const graph::Node*> planned(const Plan& plan);
    // What a device would be given for the node, each under its label and file_name(): lent, of what lies in the frame now.
    std::vector<StageData> dispatches(const PlannedNode& node) const;
    // A name for files of what the node, or that part of it, makes: letters, digits, '.', '_' and '-'; no two alike.
    std::string file_name(const PlannedNode& node, const std::string& part = "") const;
    // Memory that several nodes write parts of.
    void make_room();
    // Makes what is missing of what any node reads: what is written where nothing is seen.
    void fill();

  private:
    void add_nodes();
    std::unique_ptr<Frame> own_frame_;
    std::unique_ptr<Context> context_;
    std::vector<PlannedNode> nodes_;
    std::vector<std::string> light_words_;  // of the lights, as parts of files' names
};

// The settings, or the nearest to them whose frame has that stage, in that form; as they are where none has.
Settings settings_running(const Settings& settings, const std::string& stage, const std::string& form = "");
// "surface" is that of the frame itself; one of another view is named as its label has it: "surface, guard".
bool has_form(const PlannedStage& stage, const std::string& form);

// ---- For the files that add nodes --------------------------------------------------------------------------------------

using Nodes = std::vector<PlannedNode>;
void add_gbuffer(Context& c, int view, Nodes& nodes);
void add_maps(Context& c, int light, Nodes& nodes);
void add_map_blurs(Context& c, int light, Nodes& nodes);
void add_shadow(Context& c, int light, int view, Nodes& nodes);
void add_shadow_filter(Context& c, int light, Nodes& nodes);  // of the frame itself
void add_direct(Context& c, int view, Nodes& nodes);
void add_gather(Context& c, int light, Nodes& nodes);
void add_sum(Context& c, Nodes& nodes);
void begin_sum(Context& c);  // sets the sum to 0, for gathers that add to it
void add_filters_before(Context& c, Nodes& nodes);
void add_filters_after(Context& c, Nodes& nodes);
// The clock of frames whose light is reused, before gathers; and the stage, after their sum.
void add_light_clock(Context& c, Nodes& nodes);
void add_reuse(Context& c, Nodes& nodes);
// By how many columns this frame turns the patterns of its gathers.
int pattern_turn(const Context& c, int rotations);
void add_isr(Context& c, Nodes& nodes);
void add_probe_hits(Context& c, int view, Nodes& nodes);
void add_probes(Context& c, Nodes& nodes);
void add_radiosity(Context& c, Nodes& nodes);
void add_indirect_shadow(Context& c, bool spatial, Nodes& nodes);  // spatial: there is a grid of spatial receivers
// Where the indirect light of probes lies that shadows of what moves are still to be taken from.
Image4& indirect_to_shade(Context& c);
// Of the method probes (nodes_relief.cpp). Before direct light: what static lamps do not send to what moves.
void add_static_visibility(Context& c, Nodes& nodes);
void add_static_light(Context& c, Nodes& nodes);
void add_relief(Context& c, Nodes& nodes);
void add_relief_layers(Context& c, Nodes& nodes);
// Of the method zbuffer: in place of direct light; and, after the picture, the same with normals over it.
void add_zbuffer(Context& c, Nodes& nodes);
void add_vertex_normals(Context& c, Nodes& nodes);
// Before the picture: ambient occlusion over indirect light; and what the picture reads of it.
void add_ao(Context& c, Nodes& nodes);
const Image4& indirect_to_compose(const Context& c);
void add_compose(Context& c, Nodes& nodes);
// After the picture: what mirrors show of it and of the lights' maps; and where the picture without them lies.
void add_reflect(Context& c, Nodes& nodes);
Image4& composed_picture(Context& c);
void add_tonemap(Context& c, Nodes& nodes);
void add_traced(Context& c, const std::string& layer, const std::string& why, Nodes& nodes);

// A node of that stage as plans show it. cost: what a million turns of its inner loop take.
PlannedNode begin_node(Context& c, const std::string& name, const std::string& work, const std::string& why, double turns,
                       const Cost& cost, int light = -1);
PlannedNode begin_node(Context& c, const StageBinding& binding, const std::string& work, const std::string& why,
                       double turns, int light = -1);
// Of a view beside the frame, of a stage that runs in several forms.
void set_view(Context& c, PlannedNode& node, int view);
void set_form(PlannedNode& node, const std::string& form);

// Calls one(map, index, name of the face, or nothing where it is the only one) for each map that sees something.
template <class One>
void each_map(const std::vector<raster::Rsm>& maps, One one) {
    for (std::size_t m = 0; m < maps.size(); ++m)
        if (maps[m].size > 0) one(maps[m], int(m), maps.size() > 1 ? std::string(raster::face_names[m]) : "");
}

template <class T>
std::size_t bytes_of(const Image<T>& image) {
    return image.size() * sizeof(T);
}
Bundle lent(const std::string& name, const Image4& image);
// What the rasterizer reads, by the names of raster::surface_ports(), lent.
void lend_surfaces(const Geometry& geometry, const raster::Surfaces& surfaces, Bundle& b);
// Appends the result of that name as a target of that format gives it back to the stages after.
std::vector<TapValue> with_stored(std::vector<TapValue> values, const char* name, Format format,
                                  const raster::Layout& layout);

// The functions of a node whose stage writes one image. `inputs` returns what it reads, `result` where it writes. A stage
// that leaves out tiles reads them as the member `tiles`.
template <class Params, class InputsOf, class To>
void compute(Context& c, PlannedNode& node, const Params& params, InputsOf inputs, To result) {
    using Inputs = decltype(inputs());
    const StageBinding& binding = stage<typename Inputs::Kernel>();
    const TileWork work = node.tile_work();
    const auto covered = node.covered;
    node.dispatches = [=] { return std::vector<StageData>{data_of(params, inputs())}; };
    node.reads = [=, &binding](graph::Reads& r) { r.dispatch(binding, data_of(params, inputs())); };
    node.outputs = [=, &binding] { return lent(binding.outputs[0].name, result()); };
    node.run = [=, &c](const RunOptions& options, graph::NodeRun& run) {
        Inputs in = inputs();
        [[maybe_unused]] Context& context = c;
        raster::Covered tiles;
        if constexpr (requires { in.tiles; }) {
            tiles = context.tiles_to_shade(work, covered ? covered() : context.frame.gbuffer.covered, run);
            in.tiles = or_all(tiles);
        }
        Image4& made = result();
        plumb::run(params, in, options, made);
        run.bytes = bytes_of(made);
    };
    node.explain = [=](glm::ivec2 pixel) { return plumb::explain(params, inputs(), pixel); };
    const std::string& made_name = binding.outputs[0].name;
    if (node.results.empty()) node.results = {{made_name, made_name, made_name}};
    for (Result& r : node.results) r.output = made_name;
    if (!node.leave_out)
        node.leave_out = [=, size = node.size] { result() = Image4(size().x, size().y); };
}

}  // namespace plumb::frame
