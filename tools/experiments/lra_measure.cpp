// Times of plumb experiment lra, all rows of a table in turns.
#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "gi/frame/kept.h"
#include "tools/experiments/lra.h"
#include "tools/shared/sweep.h"

namespace plumb::cli {

namespace {

// A row again and again, all of its stages each time, in the memory of the time before. Only the second frame of a visit counts:
// the first takes the memory, which no frame of a running program does.
LraTimes visit(const Scene& scene, const frame::Settings& settings, const RunOptions& options, const std::function<void(const frame::Plan&, const frame::Frame&)>& look) {
    std::uint64_t run = 0;
    frame::KeptStages kept([&run](const graph::Node&, graph::Key) { return ++run; });
    const frame::Plan plan = frame::plan(scene, settings);
    frame::execute(scene, settings, plan, options, kept);
    const double before = processor_ms();
    const frame::Frame& f = frame::execute(scene, settings, plan, options, kept);
    LraTimes times;
    times.processor = processor_ms() - before;
    for (std::size_t i = 0; i < plan.stages.size(); ++i)
        if (f.stages[i].needed) add_stage(plan.stages[i].name, f.stages[i].ms, times);
    look(plan, f);
    return times;
}

void count(const Scene& scene, const frame::Plan& plan, const frame::Frame& f, int samples, LraMeasured& m) {
    double seen = 0;
    for (const glm::vec4& n : f.gbuffer.normal.texels) seen += n.w != 0;
    m.maps = 0, m.samples = m.texels = 0;
    for (std::size_t i = 0; i < plan.stages.size(); ++i) {
        const frame::PlannedStage& s = plan.stages[i];
        if (!f.stages[i].needed || s.light < 0) continue;
        // Of a point light those of its six that may see something.
        double drawn = 0, texels = 0;
        for (const raster::Rsm& map : f.rsms[std::size_t(s.light)]) drawn += map.size > 0, texels += double(map.size) * map.size;
        if (s.name == "rsm") m.maps += int(drawn), m.texels += texels;
        if (s.name.starts_with("rsm.")) m.samples += drawn * seen * samples;
    }
    m.display = f.display;
    m.triangles = flatten(scene).triangles.size();
}

double median_of(const std::vector<LraTimes>& all, double LraTimes::*part) {
    std::vector<double> values;
    for (const LraTimes& t : all) values.push_back(t.*part);
    return quantile(std::move(values), 0.5);
}

LraTimes medians(const std::vector<LraTimes>& all) {
    LraTimes m;
    for (double LraTimes::*part : {&LraTimes::all, &LraTimes::camera, &LraTimes::maps, &LraTimes::direct, &LraTimes::mirrors, &LraTimes::ao, &LraTimes::gather, &LraTimes::rest, &LraTimes::processor})
        m.*part = median_of(all, part);
    return m;
}

}  // namespace

void add_stage(const std::string& name, double ms, LraTimes& times) {
    times.all += ms;
    if (name == "gbuffer")
        times.camera += ms;
    else if (name == "rsm")
        times.maps += ms;
    else if (name == "shadow" || name == "direct")
        times.direct += ms;
    else if (name == "screen.lobe" || name == "screen.reflect" || name == "screen.cells" || name == "screen.nearest" ||
             name == "screen.mirror")
        times.mirrors += ms;
    else if (name.starts_with("rsm.") || name == "screen.reuse")
        times.gather += ms;
    else if (name.starts_with("screen."))
        times.ao += ms;
    else
        times.rest += ms;
}

double processor_ms() {
    rusage used{};
    getrusage(RUSAGE_SELF, &used);
    const auto ms = [](const timeval& t) { return 1e3 * double(t.tv_sec) + 1e-3 * double(t.tv_usec); };
    return ms(used.ru_utime) + ms(used.ru_stime);
}

std::vector<std::optional<LraMeasured>> measure_cases(LraWorld& world, const std::vector<LraCase>& rows, const RunOptions& options, const LraTell& tell) {
    std::vector<std::optional<LraMeasured>> measured(rows.size());
    std::vector<std::vector<LraTimes>> times(rows.size());
    // In turns, every other time backwards, so that what slows the machine slows all of them.
    for (int r = 0; r < world.request().repeats; ++r)
        for (std::size_t k = 0; k < rows.size(); ++k) {
            const std::size_t i = r % 2 == 0 ? k : rows.size() - 1 - k;
            if (!lra_runs(rows[i])) continue;
            tell(fmt::format("{}, {} of {}", rows[i].name, r + 1, world.request().repeats));
            const Scene& scene = world.scene(rows[i]);
            times[i].push_back(visit(scene, world.settings(rows[i]), options, [&](const frame::Plan& plan, const frame::Frame& f) {
                if (r > 0) return;
                measured[i].emplace();
                count(scene, plan, f, world.request().samples, *measured[i]);
            }));
        }
    for (std::size_t i = 0; i < rows.size(); ++i) {
        if (!measured[i]) continue;
        measured[i]->times = medians(times[i]);
        // Of two rows of one view the fragments are the same.
        std::size_t same = 0;
        while (same < i && !(measured[same] && rows[same].share == rows[i].share && rows[same].size == rows[i].size)) ++same;
        measured[i]->fragments = same < i ? measured[same]->fragments : world.fragments(rows[i]);
    }
    return measured;
}

std::optional<LraLine> fitted_line(const std::vector<double>& x, const std::vector<double>& y) {
    // Weights 1/y^2: errors count as parts of y.
    double s = 0, sx = 0, sxx = 0, sy = 0, sxy = 0;
    for (std::size_t i = 0; i < x.size(); ++i) {
        const double w = 1 / (y[i] * y[i]);
        s += w, sx += w * x[i], sxx += w * x[i] * x[i], sy += w * y[i], sxy += w * x[i] * y[i];
    }
    const double spread = s * sxx - sx * sx;
    if (!(spread > 1e-12 * s * sxx)) return std::nullopt;
    LraLine line;
    line.each = (s * sxy - sx * sy) / spread;
    line.fixed = (sy - line.each * sx) / s;
    for (std::size_t i = 0; i < x.size(); ++i) line.off = std::max(line.off, std::abs((line.fixed + line.each * x[i]) / y[i] - 1));
    return line;
}

}  // namespace plumb::cli
