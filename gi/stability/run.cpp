#include "gi/stability/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <mutex>
#include <utility>

#include "core/error.h"
#include "core/nearest_known.h"
#include "core/parallel.h"
#include "gi/frame/frame_graph.h"
#include "gi/frame/rules.h"
#include "gi/parity/stages.h"
#include "gi/stability/bake.h"
#include "gi/stability/cases.h"
#include "gi/stability/unbound.h"

namespace plumb::stability {

namespace {

// Dispatches of a stage in a case that are given the full number of pixels; more of them share it. Of more than
// `most_dispatches`, as a thousand lights make, some are looked at that are spread evenly.
constexpr int full_dispatches = 8, least_pixels = 4, most_dispatches = 32;

bool is_raster(const std::string& stage) {
    const std::vector<StageBinding>& all = parity::bindings();
    return std::any_of(all.begin(), all.end(), [&](const StageBinding& b) { return b.raster && b.info.name == stage; });
}

// "rsm: light "key": ..." is what the stage rsm says of itself; "raster: ..." says the rasterizer that it draws with.
bool is_own_refusal(const std::string& stage, const std::string& message) {
    auto starts = [&](const std::string& prefix) { return message.compare(0, prefix.size(), prefix) == 0; };
    return starts(stage + ":") || (is_raster(stage) && starts("raster:"));
}

// A cell of a stage that computed nothing: it refused, as its own message says, or it failed.
Cell cell_without_result(const std::string& stage, const std::string& own_name, const std::exception& error) {
    Cell cell;
    cell.stage = stage;
    cell.refused = cell.ok = dynamic_cast<const InputError*>(&error) && is_own_refusal(own_name, error.what());
    cell.reason = cell.refused ? error.what() : std::string("failed: ") + error.what();
    if (!cell.refused) cell.used = std::numeric_limits<double>::infinity();
    return cell;
}

double budget_of(const std::string& stage) {
    for (const StageInfo& info : frame::all_stages())
        if (info.name == stage) return info.budget.c;
    return Cell().budget;
}

// A frame, as far as it came.
struct Drawn {
    frame::Plan plan;
    frame::Frame frame;
    bool whole = true;        // no stage refused or failed
    std::vector<Cell> cells;  // of stages that refused or failed
};

// Plans without refusing anything for the whole frame: each stage refuses for itself what it cannot serve.
frame::Plan plan_of(const Scene& scene, const frame::Settings& settings) {
    return frame::plan(scene, settings, frame::rules());
}

// Of the scene's largest side, m: whatever its unit, surfaces that are so thick hide some of what lies behind them, not all.
float a_twentieth(const Scene& scene) {
    glm::vec3 low(0), high(0);
    if (!bounds(flatten(scene), low, high)) return 1;
    const glm::vec3 side = high - low;
    return std::clamp(0.05f * std::max({side.x, side.y, side.z}), 0.0f, 1e9f);
}

// Runs the frame; where a stage refuses, again without it and without what reads it: the maps depend on nothing.
Drawn draw(const Scene& scene, const frame::Settings& settings, const RunOptions& options) {
    Drawn drawn;
    drawn.plan = plan_of(scene, settings);
    const frame::FrameGraph graph(scene, settings, drawn.frame);
    for (;;) {
        std::string label;
        try {
            drawn.frame = frame::execute(scene, settings, drawn.plan, options,
                                         [&](const std::string& running, double) { label = running; });
            return drawn;
        } catch (const std::exception& error) {
            if (label.empty()) throw;
            drawn.whole = false;
            for (frame::PlannedStage& s : drawn.plan.stages) {
                if (s.label == label) drawn.cells.push_back(cell_without_result(s.name, s.name, error));
                if (s.label == label || !graph.node(s).of_scene) s.needed = false;
            }
        }
    }
}

struct Writer {
    const Filter& filter;
    const std::string& case_name;
    std::vector<Cell> cells{};  // one a stage

    bool wants(const std::string& stage) const { return filter.stage.empty() || filter.stage == stage; }
    void add(Cell cell) {
        if (!wants(cell.stage)) return;
        cell.case_name = case_name, cell.budget = budget_of(cell.stage);
        for (Cell& known : cells)
            if (known.stage == cell.stage) return merge(known, cell);
        cells.push_back(std::move(cell));
    }
};

// Values of a node's outputs that are not finite, which no later stage can mend.
struct Buffers {
    std::int64_t nonfinite = 0;
    std::string where;

    void look(const Array& array, const std::string& name) {
        const auto* values = reinterpret_cast<const float*>(std::as_const(array.bytes).data());
        const std::int64_t wrong = std::count_if(values, values + array.bytes.size() / sizeof(float),
                                                 [](float v) { return !std::isfinite(v); });
        if (wrong > 0 && where.empty()) where = name;
        nonfinite += wrong;
    }
};

Buffers buffers_of(const frame::PlannedNode& node) {
    Buffers found;
    if (!node.dispatches) return found;
    const std::vector<Slot>& slots = parity::find_binding(node.plan.name, node.plan.label).outputs;
    const Bundle outputs = node.outputs();
    for (const Array& array : outputs.arrays) {
        // Of several maps each has its face's name in front.
        const std::string name = array.name.substr(array.name.rfind('.') + 1);
        const bool is_output = std::any_of(slots.begin(), slots.end(), [&](const Slot& slot) { return slot.name == name; });
        if (is_output && array.dtype == DType::f32) found.look(array, name);
    }
    return found;
}

// The first stage whose buffers hold infinity or NaN as they are stored is at fault; those after it read them.
void look_at_buffers(const Scene& scene, const frame::Settings& settings, const Drawn& drawn, Writer& out) {
    const frame::FrameGraph graph(scene, settings, drawn.frame);
    for (const frame::PlannedStage& s : drawn.plan.stages) {
        if (!s.needed) continue;
        const Buffers b = buffers_of(graph.node(s));
        if (b.nonfinite == 0) continue;
        Cell cell;
        cell.stage = s.name;
        cell.nonfinite = b.nonfinite;
        cell.reason = fmt::format("{} values of its buffers are not finite as they are stored, first in {}",
                                  b.nonfinite, b.where);
        return out.add(std::move(cell));
    }
}

// The stages of a plan that another has not.
std::vector<std::string> stages_beyond(const frame::Plan& plan, const frame::Plan& base) {
    std::vector<std::string> names;
    auto has = [](const frame::Plan& p, const std::string& name) {
        return std::any_of(p.stages.begin(), p.stages.end(), [&](const frame::PlannedStage& s) { return s.name == name; });
    };
    for (const frame::PlannedStage& s : plan.stages)
        if (!has(base, s.name) && std::find(names.begin(), names.end(), s.name) == names.end()) names.push_back(s.name);
    return names;
}

// The dispatches of `stage`, or of all stages, with other settings than those that the frame was drawn with.
void look(const Case& c, const Scene& scene, const frame::Settings& settings, const Drawn& drawn, frame::Plan plan,
          const std::string& stage, const Effort& effort, Writer& out) {
    for (frame::PlannedStage& s : plan.stages)
        s.needed = s.needed && (stage.empty() || s.name == stage) && out.wants(s.name);
    std::vector<StageData> all = parity::frame_data(scene, settings, plan, drawn.frame);
    std::map<std::string, int> dispatches, place;
    for (const StageData& data : all) ++dispatches[data.stage];
    for (StageData& data : all) {
        const int n = dispatches[data.stage], apart = (n + most_dispatches - 1) / most_dispatches;
        if (place[data.stage]++ % apart != 0 || (c.edit && !c.edit(data))) continue;
        Effort share = effort;
        share.pixels = std::min(effort.pixels, std::max(effort.pixels * full_dispatches / n, least_pixels));
        try {
            out.add(evaluate(parity::find_binding(data.stage, data.label), data, share));
        } catch (const std::exception& error) {
            out.add(cell_without_result(data.stage, data.label, error));
        }
    }
}

// Draws a frame of other settings, and looks at the stages that the case's own frame has not.
void look_beyond(const Case& c, const Scene& scene, const frame::Settings& settings, const frame::Plan& base,
                 const Effort& effort, Writer& out) {
    std::vector<std::string> stages = stages_beyond(plan_of(scene, settings), base);
    std::erase_if(stages, [&](const std::string& stage) { return !out.wants(stage); });
    if (stages.empty()) return;
    const Drawn drawn = draw(scene, settings, effort.run);
    for (const Cell& cell : drawn.cells)
        if (std::find(stages.begin(), stages.end(), cell.stage) != stages.end()) out.add(cell);
    if (!drawn.whole) return;
    look_at_buffers(scene, settings, drawn, out);
    for (const std::string& stage : stages) look(c, scene, settings, drawn, drawn.plan, stage, effort, out);
}

// The filters of indirect light. Kernel 7: every tap is the same.
void look_at_filters(const Case& c, const Scene& scene, frame::Settings settings, const frame::Plan& base,
                     const Effort& effort, Writer& out) {
    settings.indirect.resolution = filter::Resolution::half;
    settings.indirect.blur = filter::Blur::full;
    settings.indirect.kernel = 7;
    look_beyond(c, scene, settings, base, effort, out);
}

// Shadows in between, filtered by the Gaussian alone and along edges.
void look_at_shadow_filter(const Case& c, const Scene& scene, frame::Settings settings, const frame::Plan& base,
                           const Effort& effort, Writer& out) {
    settings.method = frame::Method::direct;
    settings.shadow.mode = direct::ShadowMode::pcf, settings.shadow.filter_radius = 3;
    for (const direct::VisibilityFilter filter : {direct::VisibilityFilter::gaussian, direct::VisibilityFilter::edge_aware}) {
        settings.shadow.filter = filter;
        look_beyond(c, scene, settings, base, effort, out);
    }
}

// Image-space radiosity: with what ISR's chapter 6 adds, as printed, and with positions by inverse matrices. Few samples:
// every one is the same.
void look_at_isr(const Case& c, const Scene& scene, frame::Settings settings, const frame::Plan& base, const Effort& effort,
                 Writer& out) {
    settings.method = frame::Method::isr;
    isr::IsrParams& p = settings.isr;
    p.rings = 2, p.spacing = 2, p.ssao_rings = 2, p.blur_radius = 2, p.k_ssao = 0.5f, p.ambient = isr::Ambient::environment;
    const isr::IsrParams plain = p;
    auto by = [&](auto change) {
        p = plain;
        change();
        look_beyond(c, scene, settings, base, effort, out);
    };
    by([&] { p.bounces = 2, p.cameras = 1, p.guard = 4; });
    by([&] { p.rotations = 4, p.blur = isr::Blur::edge_aware, p.far_rings = 1, p.full_depth = 1; });
    by([&] { p.position = isr::Position::inverse_matrix; });
    if (std::isfinite(scene.camera.far)) by([&] { p.variant = isr::Variant::published; });
}

// The z-buffer techniques, with highlights on all materials: at vertices and at pixels, as printed, of half vectors.
void look_at_zbuffer(const Case& c, Scene scene, frame::Settings settings, const frame::Plan& base, const Effort& effort, Writer& out) {
    settings.method = frame::Method::zbuffer;
    for (Material& m : scene.materials) m.specular = glm::vec3(0.25f), m.exponent = 20;
    for (const zbuffer::Technique technique : {zbuffer::Technique::cads, zbuffer::Technique::cads_p}) {
        settings.zbuffer = {.technique = technique};
        look_beyond(c, scene, settings, base, effort, out);
        settings.zbuffer.lobe = zbuffer::Lobe::blinn, settings.zbuffer.range = zbuffer::Range::saturate;
        look_beyond(c, scene, settings, base, effort, out);
        // As printed unit vectors to the viewer are interpolated, which nearly cancel in triangles that begin beside the eye and end far
        // away: no float has digits of that.
        if (zbuffer::per_pixel(technique) && c.name.starts_with("far")) continue;
        settings.zbuffer = {.technique = technique, .variant = zbuffer::Variant::published};
        look_beyond(c, scene, settings, base, effort, out);
    }
    settings.zbuffer = {.renormalise = false};
    look_beyond(c, scene, settings, base, effort, out);
}

// Ambient occlusion over ambient light: from the camera and the lights, as printed, by horizons.
void look_at_ao(const Case& c, const Scene& scene, frame::Settings settings, const frame::Plan& base, const Effort& effort,
                Writer& out) {
    using namespace screen;
    settings.method = frame::Method::direct;
    settings.ao = {.method = AoMethod::ssao, .samples = 16, .views = AoViews::lights, .ambient = glm::vec3(0.5f)};
    look_beyond(c, scene, settings, base, effort, out);
    settings.ao.blur = AoBlur::edge_aware;
    settings.ao.variant = AoVariant::published;
    look_beyond(c, scene, settings, base, effort, out);
    settings.ao = {.method = AoMethod::horizon, .slices = 2, .steps = 4, .ambient = glm::vec3(0.5f)};
    look_beyond(c, scene, settings, base, effort, out);
}

// The first frame of those whose light is reused; reuse.cpp has later ones.
void look_at_reuse(const Case& c, const Scene& scene, frame::Settings settings, const frame::Plan& base, const Effort& effort,
                   Writer& out) {
    settings.method = frame::Method::rsm, settings.rsm.samples = 4;
    settings.reuse.frames = 8;
    look_beyond(c, scene, settings, base, effort, out);
}

// Reflections in surfaces that all are mirrors, in what the camera sees and in the lights' maps; as printed.
void look_at_reflections(const Case& c, Scene scene, frame::Settings settings, const frame::Plan& base, const Effort& effort,
                         Writer& out) {
    using namespace screen;
    settings.method = frame::Method::direct;
    for (Material& m : scene.materials) m.mirror = 0.5f * (glm::vec3(1) - m.reflectance);
    settings.reflect = {.march = March::steps, .views = ReflectViews::lights, .steps = 32, .fade = 0.1f, .attenuation = 2};
    look_beyond(c, scene, settings, base, effort, out);
    settings.reflect = {.march = March::hierarchical, .views = ReflectViews::lights, .steps = 32, .cells = 64};
    look_beyond(c, scene, settings, base, effort, out);
    settings.reflect = {.march = March::steps, .variant = ReflectVariant::published, .steps = 32};
    look_beyond(c, scene, settings, base, effort, out);
    for (Material& m : scene.materials) m.specular = 0.5f * m.mirror, m.mirror = 0.5f * m.mirror, m.exponent = 40;
    settings.reflect = {.march = March::steps, .layers = 1, .lobe = Lobe::phong, .rays = 2, .steps = 32};
    look_beyond(c, scene, settings, base, effort, out);
}

void run_frame(const Case& c, const Scene& scene, const Effort& effort, Writer& out) {
    const frame::Settings settings = case_settings(c, scene);
    const Drawn drawn = draw(scene, settings, effort.run);
    for (const Cell& cell : drawn.cells) out.add(cell);
    look_at_buffers(scene, settings, drawn, out);
    look(c, scene, settings, drawn, drawn.plan, "", effort, out);
    if (!drawn.whole) return;

    // Looks at `stage` of the same frame by other settings, and at the stages that only those have.
    auto otherwise = [&](const std::string& stage, auto change) {
        frame::Settings other = settings;
        change(other);
        const frame::Plan plan = plan_of(scene, other);
        std::vector<std::string> stages = stages_beyond(plan, drawn.plan);
        if (!stage.empty()) stages.push_back(stage);
        for (const std::string& name : stages)
            if (out.wants(name)) look(c, scene, other, drawn, plan, name, effort, out);
    };
    for (const rsm::Gather gather : {rsm::Gather::all, rsm::Gather::disc, rsm::Gather::paths})
        otherwise("", [=](frame::Settings& s) { s.rsm.gather = gather; });
    for (const rsm::Gather gather : {rsm::Gather::disc, rsm::Gather::paths})
        otherwise("", [=](frame::Settings& s) { s.rsm.gather = gather, s.rsm.texels = rsm::Texels::continuous; });
    otherwise(rsm::stage_name(rsm::Gather::disc, rsm::Texels::whole), [](frame::Settings& s) {
        s.rsm.gather = rsm::Gather::disc, s.rsm.sample_area = rsm::SampleArea::texels;
    });
    otherwise(rsm::stage_name(rsm::Gather::paths, rsm::Texels::whole), [](frame::Settings& s) {
        s.rsm.gather = rsm::Gather::paths, s.rsm.sample_area = rsm::SampleArea::texels;
    });
    const float thickness = a_twentieth(scene);
    otherwise(rsm::stage_name(rsm::Gather::paths, rsm::Texels::whole), [=](frame::Settings& s) {
        s.rsm.gather = rsm::Gather::paths, s.rsm.thickness = thickness;
    });
    for (const direct::ShadowMode mode : {direct::ShadowMode::hard, direct::ShadowMode::density, direct::ShadowMode::pcf, direct::ShadowMode::esm})
        otherwise("shadow", [mode](frame::Settings& s) { s.shadow.mode = mode, s.shadow.test = direct::ShadowTest::depth; });
    for (const direct::ShadowMode mode : {direct::ShadowMode::hard, direct::ShadowMode::density, direct::ShadowMode::pcf})
        otherwise("shadow", [mode](frame::Settings& s) {
            s.shadow.mode = mode, s.shadow.test = direct::ShadowTest::planes, s.shadow.pcf_kernel = 3;
        });
    const glm::vec3 shadow_color(0.25f, 0.5f, 1);
    otherwise("direct", [=](frame::Settings& s) { s.compose.shadow_color = shadow_color; });
    otherwise("direct", [](frame::Settings& s) { s.direct.variant = direct::DirectVariant::published; });
    otherwise("compose", [=](frame::Settings& s) { s.compose.shadow_color = shadow_color; });
    look_at_filters(c, scene, settings, drawn.plan, effort, out);
    look_at_shadow_filter(c, scene, settings, drawn.plan, effort, out);
    look_at_isr(c, scene, settings, drawn.plan, effort, out);
    look_at_zbuffer(c, scene, settings, drawn.plan, effort, out);
    look_at_ao(c, scene, settings, drawn.plan, effort, out);
    look_at_reuse(c, scene, settings, drawn.plan, effort, out);
    look_at_reflections(c, scene, settings, drawn.plan, effort, out);
    using compose::Operator;
    for (const Operator op : {Operator::clamp, Operator::exposure, Operator::reinhard, Operator::filmic})
        if (op != settings.tonemap.op) otherwise("tonemap", [op](frame::Settings& s) { s.tonemap.op = op; });
    // A steeper power of 1e-30 is no number of 32 bits any more.
    for (const float power : {1.2f, 0.8f})
        otherwise("tonemap", [power](frame::Settings& s) { s.tonemap.contrast = s.tonemap.gamma = power; });
}

bool bound(const std::string& stage) {
    const std::vector<StageBinding>& all = parity::bindings();
    return std::any_of(all.begin(), all.end(), [&](const StageBinding& b) { return b.info.name == stage; });
}

// Whether a filter leaves any stage of a frame, or of a bake.
bool wants_frame(const Filter& f) { return f.stage.empty() || (bound(f.stage) && !is_of_bake(f.stage)); }
bool wants_bake(const Filter& f) { return f.stage.empty() || is_of_bake(f.stage); }

std::vector<Cell> run_case(const Case& c, const Filter& filter, const Effort& effort) {
    Writer out{filter, c.name};
    const Scene scene = c.scene();
    if (wants_frame(filter)) run_frame(c, scene, effort, out);
    if (wants_bake(filter) && is_baked(c))
        for (Cell& cell : bake_cells(scene, filter.stage, effort)) out.add(std::move(cell));
    if ((filter.stage.empty() || !bound(filter.stage)) && !c.edit)
        for (Cell& cell : unbound_cells(c.name, scene, case_settings(c, scene), effort)) out.add(std::move(cell));
    return std::move(out.cells);
}

std::vector<Cell> run_unbound(const UnboundCase& c, const Filter& filter, const Effort& effort) {
    Writer out{filter, c.name};
    for (Cell& cell : c.run(effort)) out.add(std::move(cell));
    return std::move(out.cells);
}

std::vector<Cell> run_bake(const BakeCase& c, const Filter& filter, const Effort& effort) {
    Writer out{filter, c.name};
    for (Cell& cell : bake_cells(c.data(), filter.stage, effort)) out.add(std::move(cell));
    return std::move(out.cells);
}

// Sorted by stages, as `plumb stages` lists them.
void append_in_order(std::vector<Cell> cells, std::vector<Cell>& all) {
    const std::vector<std::string>& names = stage_names();
    auto place = [&](const Cell& c) { return std::find(names.begin(), names.end(), c.stage); };
    std::stable_sort(cells.begin(), cells.end(), [&](const Cell& a, const Cell& b) { return place(a) < place(b); });
    all.insert(all.end(), std::make_move_iterator(cells.begin()), std::make_move_iterator(cells.end()));
}

void check(const char* what, const std::string& asked, const std::vector<std::string>& known) {
    if (asked.empty() || std::find(known.begin(), known.end(), asked) != known.end()) return;
    throw InputError(fmt::format("unknown {} '{}'{}", what, asked, nearest_known(asked, known)));
}

}  // namespace

const std::vector<CaseInfo>& case_infos() {
    static const std::vector<CaseInfo> all = [] {
        std::vector<CaseInfo> infos;
        for (const Case& c : cases()) infos.push_back({c.name, c.group, c.meaning});
        for (const UnboundCase& c : unbound_cases()) infos.push_back({c.name, c.group, c.meaning});
        for (const BakeCase& c : bake_cases()) infos.push_back({c.name, c.group, c.meaning});
        return infos;
    }();
    return all;
}

const std::vector<std::string>& stage_names() {
    static const std::vector<std::string> all = [] {
        std::vector<std::string> names;
        for (const StageInfo& stage : frame::all_stages()) names.push_back(stage.name);
        names.push_back("visibility");  // which gbuffer and rsm draw with
        return names;
    }();
    return all;
}

std::vector<Cell> run(const Filter& filter, const Effort& effort, const Progress& progress) {
    std::vector<std::string> names;
    for (const CaseInfo& c : case_infos()) names.push_back(c.name);
    check("stage", filter.stage, stage_names());
    check("case", filter.case_name, names);

    Effort alone = effort;
    alone.run.threads = 1, alone.run.progress = nullptr;
    std::vector<std::function<std::vector<Cell>()>> wanted;
    auto want = [&](const std::string& name, std::function<std::vector<Cell>()> body) {
        if (filter.case_name.empty() || filter.case_name == name) wanted.push_back(std::move(body));
    };
    for (const Case& c : cases()) want(c.name, [&] { return run_case(c, filter, alone); });
    if (filter.stage.empty() || !bound(filter.stage))
        for (const UnboundCase& c : unbound_cases()) want(c.name, [&] { return run_unbound(c, filter, alone); });
    if (wants_bake(filter))
        for (const BakeCase& c : bake_cases()) want(c.name, [&] { return run_bake(c, filter, alone); });

    std::vector<std::vector<Cell>> found(wanted.size());
    std::mutex mutex;
    std::size_t done = 0;
    parallel_bands(int(wanted.size()), 1, effort.run.threads, [&](int first, int) {
        found[std::size_t(first)] = wanted[std::size_t(first)]();
        const std::lock_guard lock(mutex);
        ++done;
        if (progress) progress(double(done) / double(wanted.size()));
    });
    std::vector<Cell> all;
    for (std::vector<Cell>& cells : found) append_in_order(std::move(cells), all);
    return all;
}

}  // namespace plumb::stability
