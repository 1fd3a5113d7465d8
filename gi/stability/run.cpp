#include "gi/stability/run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <mutex>

#include "core/error.h"
#include "core/parallel.h"
#include "gi/frame/isr.h"
#include "gi/frame/rules.h"
#include "gi/parity/stages.h"
#include "gi/stability/cases.h"
#include "gi/stability/unbound.h"

namespace plumb::stability {

namespace {

// Dispatches of a stage in a case that are given the full number of pixels; more of them share it. Of more than
// `most_dispatches`, as a thousand lights make, some are looked at that are spread evenly.
constexpr int full_dispatches = 8, least_pixels = 4, most_dispatches = 32;

// "rsm: light "key": ..." is what the stage rsm says of itself; "raster: ..." says the rasterizer that it draws with.
bool is_own_refusal(const std::string& stage, const std::string& message) {
    auto starts = [&](const std::string& prefix) { return message.compare(0, prefix.size(), prefix) == 0; };
    return starts(stage + ":") || ((stage == "gbuffer" || stage == "rsm") && starts("raster:"));
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

// Runs the frame; where a stage refuses, again without it and without what reads it: the maps depend on nothing.
Drawn draw(const Scene& scene, const frame::Settings& settings, const RunOptions& options) {
    Drawn drawn;
    drawn.plan = plan_of(scene, settings);
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
                if (s.label == label || (s.name != "gbuffer" && s.name != "rsm")) s.needed = false;
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

// Values of a stage's buffers that are not finite, which no later stage can mend.
struct Buffers {
    std::int64_t nonfinite = 0;
    std::string where;

    void look(const char* name, const float* values, std::size_t n) {
        const std::int64_t wrong = std::count_if(values, values + n, [](float v) { return !std::isfinite(v); });
        if (wrong > 0 && where.empty()) where = name;
        nonfinite += wrong;
    }
    void look(const char* name, const Image4& image) {
        if (!image.empty()) look(name, &image.texels.data()->x, 4 * image.size());
    }
};

Buffers buffers_of(const frame::Frame& f, const std::string& stage) {
    Buffers b;
    if (stage == "gbuffer") {
        b.look("position", f.gbuffer.position), b.look("normal", f.gbuffer.normal);
        b.look("albedo", f.gbuffer.albedo), b.look("emission", f.gbuffer.emission);
        b.look("depth", f.gbuffer.depth.data(), f.gbuffer.depth.size());
    } else if (stage == "rsm") {
        for (const std::vector<raster::Rsm>& maps : f.rsms)
            for (const raster::Rsm& m : maps)
                b.look("position", m.position), b.look("normal", m.normal), b.look("flux", m.flux);
    } else if (stage == "shadow") {
        b.look("visibility", f.visibility.data(), f.visibility.size());
    } else if (stage == "direct") {
        b.look("irradiance", f.direct);
    } else if (frame::is_gather(stage)) {
        b.look("irradiance", f.gathered.empty() ? f.indirect : f.gathered);
    } else if (stage == "filter.reduce") {
        b.look("half position", f.half_position), b.look("half normal", f.half_normal);
    } else if (stage == "filter.upsample") {
        b.look("upsampled", f.upsampled.empty() ? f.indirect : f.upsampled);
    } else if (stage == "filter.blur") {
        b.look("blurred across", f.blurred_across), b.look("blurred", f.indirect);
    } else if (frame::is_isr_gather(stage)) {
        for (const Image4& gathered : f.isr.gathered) b.look("irradiance", gathered);
    } else if (stage == "isr.downsample") {
        b.look("surface", f.isr.surface), b.look("radiosity", f.isr.radiosity), b.look("reflectance", f.isr.reflectance);
    } else if (stage == "isr.bounce") {
        for (const Image4& radiosity : f.isr.radiosities) b.look("radiosity", radiosity);
    } else if (stage == "isr.unseen") {
        for (const Image4& unseen : f.isr.unseen) b.look("unseen", unseen);
    } else if (stage == "isr.ssao") {
        b.look("lit", f.isr.lit);
    } else if (stage == "isr.blur") {
        b.look("blurred across", f.isr.blurred_across), b.look("blurred", f.isr.blurred);
    } else if (stage == "isr.upsample") {
        b.look("upsampled", f.indirect);
    } else if (stage == "compose" || stage == "isr.compose") {
        b.look("radiance", f.radiance);
    } else if (stage == "tonemap") {
        b.look("display", f.display);
    }
    return b;
}

// The first stage whose buffers hold infinity or NaN as they are stored is at fault; those after it read them.
void look_at_buffers(const Drawn& drawn, Writer& out) {
    for (const frame::PlannedStage& s : drawn.plan.stages) {
        if (!s.needed) continue;
        const Buffers b = buffers_of(drawn.frame, s.name);
        if (b.nonfinite == 0) continue;
        Cell cell;
        cell.stage = s.name;
        cell.nonfinite = b.nonfinite;
        cell.reason = fmt::format("{} values of its buffers are not finite as they are stored, first in {}",
                                  b.nonfinite, b.where);
        return out.add(std::move(cell));
    }
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

// The filters of indirect light, of a frame that has them. Kernel 7: every tap is the same.
void look_at_filters(const Case& c, const Scene& scene, frame::Settings settings, const Effort& effort, Writer& out) {
    const char* const stages[] = {"filter.reduce", "filter.upsample", "filter.blur"};
    if (std::none_of(std::begin(stages), std::end(stages), [&](const char* s) { return out.wants(s); })) return;
    settings.indirect.resolution = filter::Resolution::half;
    settings.indirect.blur = filter::Blur::full;
    settings.indirect.kernel = 7;
    const Drawn drawn = draw(scene, settings, effort.run);
    if (!drawn.whole) return;
    for (const char* stage : stages)
        if (out.wants(stage)) look(c, scene, settings, drawn, drawn.plan, stage, effort, out);
}

// Image-space radiosity, of frames that have all of its stages: with what ISR's chapter 6 adds, as printed, and with
// positions by inverse matrices. Few samples: every one is the same.
void look_at_isr(const Case& c, const Scene& scene, frame::Settings settings, const Effort& effort, Writer& out) {
    settings.method = frame::Method::isr;
    isr::IsrParams& p = settings.isr;
    p.rings = 2, p.spacing = 2, p.ssao_rings = 2, p.blur_radius = 2, p.k_ssao = 0.5f, p.ambient = isr::Ambient::environment;
    const isr::IsrParams plain = p;
    auto by = [&](auto change) {
        p = plain;
        change();
        std::vector<std::string> stages;
        for (const frame::IsrStage& s : frame::isr_stages(scene, settings))
            if (out.wants(s.name) && std::find(stages.begin(), stages.end(), s.name) == stages.end()) stages.push_back(s.name);
        if (out.wants("isr.compose")) stages.push_back("isr.compose");
        if (stages.empty()) return;
        const Drawn drawn = draw(scene, settings, effort.run);
        for (const Cell& cell : drawn.cells)
            if (frame::is_isr(cell.stage)) out.add(cell);
        if (!drawn.whole) return;
        look_at_buffers(drawn, out);
        for (const std::string& stage : stages) look(c, scene, settings, drawn, drawn.plan, stage, effort, out);
    };
    by([&] { p.bounces = 2, p.cameras = 1, p.guard = 4; });
    by([&] { p.rotations = 4, p.blur = isr::Blur::edge_aware, p.far_rings = 1, p.full_depth = 1; });
    by([&] { p.position = isr::Position::inverse_matrix; });
    if (std::isfinite(scene.camera.far)) by([&] { p.variant = isr::Variant::published; });
}

void run_frame(const Case& c, const Scene& scene, const Effort& effort, Writer& out) {
    const frame::Settings settings = case_settings(c, scene);
    const Drawn drawn = draw(scene, settings, effort.run);
    for (const Cell& cell : drawn.cells) out.add(cell);
    look_at_buffers(drawn, out);
    look(c, scene, settings, drawn, drawn.plan, "", effort, out);
    if (!drawn.whole) return;

    auto otherwise = [&](const std::string& stage, auto change) {
        frame::Settings other = settings;
        change(other);
        if (out.wants(stage)) look(c, scene, other, drawn, plan_of(scene, other), stage, effort, out);
    };
    otherwise("rsm.all", [](frame::Settings& s) { s.rsm.gather = rsm::Gather::all; });
    otherwise("rsm.paths", [](frame::Settings& s) { s.rsm.gather = rsm::Gather::paths; });
    for (const rsm::Gather gather : {rsm::Gather::disc, rsm::Gather::paths})
        otherwise(rsm::stage_name(gather, rsm::Texels::continuous), [=](frame::Settings& s) {
            s.rsm.gather = gather, s.rsm.texels = rsm::Texels::continuous;
        });
    for (const direct::ShadowMode mode : {direct::ShadowMode::density, direct::ShadowMode::pcf, direct::ShadowMode::esm})
        otherwise("shadow", [mode](frame::Settings& s) { s.shadow.mode = mode; });
    otherwise("shadow.blur", [](frame::Settings& s) { s.shadow.mode = direct::ShadowMode::esm; });
    const glm::vec3 shadow_color(0.25f, 0.5f, 1);
    otherwise("direct", [=](frame::Settings& s) { s.compose.shadow_color = shadow_color; });
    otherwise("direct", [](frame::Settings& s) { s.direct.variant = direct::DirectVariant::published; });
    otherwise("compose", [=](frame::Settings& s) { s.compose.shadow_color = shadow_color; });
    look_at_filters(c, scene, settings, effort, out);
    look_at_isr(c, scene, settings, effort, out);
    using compose::Operator;
    for (const Operator op : {Operator::clamp, Operator::exposure, Operator::reinhard, Operator::filmic})
        if (op != settings.tonemap.op) otherwise("tonemap", [op](frame::Settings& s) { s.tonemap.op = op; });
}

bool bound(const std::string& stage) {
    const std::vector<StageBinding>& all = parity::bindings();
    return std::any_of(all.begin(), all.end(), [&](const StageBinding& b) { return b.info.name == stage; });
}

std::vector<Cell> run_case(const Case& c, const Filter& filter, const Effort& effort) {
    Writer out{filter, c.name};
    const Scene scene = c.scene();
    if (filter.stage.empty() || bound(filter.stage)) run_frame(c, scene, effort, out);
    if ((filter.stage.empty() || !bound(filter.stage)) && !c.edit)
        for (Cell& cell : unbound_cells(c.name, scene, case_settings(c, scene), effort)) out.add(std::move(cell));
    return std::move(out.cells);
}

std::vector<Cell> run_unbound(const UnboundCase& c, const Filter& filter, const Effort& effort) {
    Writer out{filter, c.name};
    for (Cell& cell : c.run(effort)) out.add(std::move(cell));
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
    throw InputError(
        fmt::format("unknown {} '{}'; the nearest known one is '{}'", what, asked, nearest_name(asked, known)));
}

}  // namespace

const std::vector<CaseInfo>& case_infos() {
    static const std::vector<CaseInfo> all = [] {
        std::vector<CaseInfo> infos;
        for (const Case& c : cases()) infos.push_back({c.name, c.group, c.meaning});
        for (const UnboundCase& c : unbound_cases()) infos.push_back({c.name, c.group, c.meaning});
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
