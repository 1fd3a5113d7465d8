// Table 7.6 of LRA, and one of many lights that moves under a camera at rest.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <memory>

#include "gi/frame/kept.h"
#include "tools/experiments/lra.h"
#include "tools/shared/sweep.h"

namespace plumb::cli {

namespace {

using page::Chart;
using page::ChartLine;

// A scene in which lights turn, frame by frame, in the memory of the frame before; `keeps`: what did not change is kept.
class Motion {
  public:
    Motion(LraWorld& world, const LraCase& row, bool keeps, const RunOptions& options)
        : world_(world), row_(row), options_(options), turned_(row.lights.size(), 0.0),
          kept_(keeps ? frame::KeptStages::OtherKey() : [this](const graph::Node&, graph::Key) { return ++run_; }) {}

    struct Frame {
        double wall_ms = 0;      // of all: keys, too
        LraTimes times;          // of stages that ran, by what they are of
        int maps = 0, gathers = 0, stages = 0;  // that ran
        std::size_t map_bytes = 0, gather_bytes = 0;  // that are held
    };
    // Turns these lights by a degree, then draws.
    Frame turn(const std::vector<int>& lights) {
        for (const int l : lights) turned_[std::size_t(l)] += 1;
        Scene& scene = world_.scene(row_);
        for (std::size_t l = 0; l < turned_.size(); ++l) scene.lights[l] = world_.light(row_.lights[l], int(l), turned_[l]);
        const frame::Settings settings = world_.settings(row_);
        const frame::Plan plan = frame::plan(scene, settings);
        const auto start = std::chrono::steady_clock::now();
        const double before = processor_ms();
        const frame::Frame& f = frame::execute(scene, settings, plan, options_, kept_);
        Frame frame;
        frame.wall_ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
        frame.times.processor = processor_ms() - before;
        for (std::size_t i = 0; i < plan.stages.size(); ++i) {
            const frame::StageRun& run = f.stages[i];
            if (!run.needed) continue;
            const std::string& name = plan.stages[i].name;
            const bool map = name == "rsm", gather = name.starts_with("rsm.");
            (map ? frame.map_bytes : frame.gather_bytes) += map || gather ? run.bytes : 0;
            if (run.kept) continue;
            frame.stages += 1, frame.maps += map, frame.gathers += gather;
            add_stage(name, run.ms, frame.times);
        }
        return frame;
    }

  private:
    LraWorld& world_;
    LraCase row_;
    RunOptions options_;
    std::vector<double> turned_;
    std::uint64_t run_ = 0;
    frame::KeptStages kept_;
};

Motion::Frame median_of(const std::vector<Motion::Frame>& frames) {
    Motion::Frame m = frames.front();
    const auto median = [&](auto of) {
        std::vector<double> values;
        for (const Motion::Frame& f : frames) values.push_back(of(f));
        return quantile(std::move(values), 0.5);
    };
    m.wall_ms = median([](const Motion::Frame& f) { return f.wall_ms; });
    for (double LraTimes::*part : {&LraTimes::all, &LraTimes::maps, &LraTimes::direct, &LraTimes::mirrors, &LraTimes::ao, &LraTimes::gather, &LraTimes::rest, &LraTimes::processor})
        m.times.*part = median([=](const Motion::Frame& f) { return f.times.*part; });
    return m;
}

// LRA, table 7.6 as printed.
struct Printed {
    double fps, ms;
};
constexpr Printed table_6[] = {{11.66, 86.85}, {11.42, 87.56}, {11.35, 88.10}, {11.28, 88.56}};

std::vector<int> first(int n) {
    std::vector<int> all;
    for (int i = 0; i < n; ++i) all.push_back(i);
    return all;
}

IprSheet table_7_6(LraWorld& world, const RunOptions& options, const LraTell& tell) {
    IprSheet sheet{"table 7.6", "lights that move", fmt::format("half of the model, {} x {}, three spots; the camera rests; frames of all rows in turns", world.size({}).x, world.size({}).y), {}, {}, {}, {}};
    sheet.heads = {{"ms", 1}, {"ms, nothing kept", 1}, {"processor ms", 1}, {"processor ms, nothing kept", 1}, {"stages that ran"}, {"maps drawn"}, {"gathers"}, {"maps ms", 1}, {"IS ms", 1}, {"AO ms", 1}, {"ID ms", 1}, {"direct ms", 1},
                   {"thesis FPS", 2}, {"thesis ms", 2}, {"1000 / thesis FPS", 2}};
    LraCase row;
    row.share = 0.5, row.lights = {LraLight::spot, LraLight::spot, LraLight::spot};
    std::vector<std::vector<Motion::Frame>> kept(4), anew(4);
    for (const bool keeps : {true, false}) {
        Motion motion(world, row, keeps, options);
        motion.turn(first(3));
        for (int r = 0; r < world.request().repeats; ++r)
            for (int n = 0; n <= 3; ++n) {
                tell(fmt::format("{} lights move, {}", n, keeps ? "kept" : "nothing kept"));
                (keeps ? kept : anew)[std::size_t(n)].push_back(motion.turn(first(n)));
            }
    }
    Chart chart{"table 7.6", "lights that move", "ms", false, false, {{"ours, kept, processor time", {}}, {"ours, nothing kept, processor time", {}}, {"LRA: 1000 / FPS", {}}}};
    for (std::size_t n = 0; n <= 3; ++n) {
        const Motion::Frame k = median_of(kept[n]), a = median_of(anew[n]);
        sheet.rows.push_back({fmt::format("{}", n), "", {k.wall_ms, a.wall_ms, k.times.processor, a.times.processor, double(k.stages), double(k.maps), double(k.gathers), k.times.maps, k.times.mirrors, k.times.ao, k.times.gather, k.times.direct,
                                                         table_6[n].fps, table_6[n].ms, 1000 / table_6[n].fps}, {}});
        chart.lines[0].points.push_back({double(n), k.times.processor}), chart.lines[1].points.push_back({double(n), a.times.processor}), chart.lines[2].points.push_back({double(n), 1000 / table_6[n].fps});
    }
    sheet.lines = {"The thesis draws a light's map again only where it moves, but shades every frame: its four rows differ by maps and SSAO alone. Ours also keeps what a light at rest sends to a camera at rest, "
                   "so that a frame costs what moves. The thesis' own case, maps at rest kept and all shaded anew, lies between the two columns.",
                   "0: nothing moves, and nothing runs. ms: the whole frame by the clock, with the keys by which it is known what changed."};
    sheet.charts = {chart};
    return sheet;
}

LraCase spots(int n, bool with_ao) {
    LraCase row;
    row.share = 0.5, row.algorithms = with_ao ? lra_all() : std::vector<std::string>{"ID"};
    row.lights.assign(std::size_t(n), LraLight::spot);
    return row;
}

// Of the frames of a scene with one light and one with n, in turns: the median of each, and of the ratio of two in a row.
struct Beside {
    Motion::Frame one, many;
    double ratio = 0, processor_ratio = 0;
};
Beside beside_one(LraWorld& world, int n, bool with_ao, const RunOptions& options) {
    Motion one(world, spots(1, with_ao), true, options), many(world, spots(n, with_ao), true, options);
    one.turn({0}), many.turn(first(n));
    std::vector<Motion::Frame> ones, all;
    std::vector<double> ratios, processor_ratios;
    // Lights spread over all, since what of the others runs again may depend on its place; the first of both takes memory.
    const int frames = 2 * world.request().repeats + 1;
    for (int r = -1; r < frames; ++r) {
        const Motion::Frame a = one.turn({0}), b = many.turn({std::max(0, 2 * r + 1) * n / (2 * frames)});
        if (r < 0) continue;
        ones.push_back(a), all.push_back(b), ratios.push_back(b.wall_ms / a.wall_ms);
        processor_ratios.push_back(b.times.processor / a.times.processor);
    }
    return {median_of(ones), median_of(all), quantile(ratios, 0.5), quantile(processor_ratios, 0.5)};
}

IprSheet one_of_many(LraWorld& world, const RunOptions& options, const LraTell& tell) {
    IprSheet sheet{"one of many", "one light moves, the camera rests", fmt::format("half of the model, {} x {}, spots; frames of a scene with one light, which moves, and of one with more, in turns; each frame turns another light", world.size({}).x, world.size({}).y), {}, {}, {}, {}};
    sheet.heads = {{"ms", 1}, {"one light ms", 1}, {"ratio", 2}, {"processor ms", 1}, {"ratio of these", 2}, {"stages that ran"}, {"maps drawn"}, {"gathers"}, {"maps ms", 1}, {"direct ms", 1}, {"IS ms", 1}, {"AO ms", 1}, {"ID ms", 1}, {"rest ms", 1}, {"beside stages ms", 1},
                   {"held: maps MB", 1}, {"gathers MB", 2}, {"a light MB", 1}};
    for (const bool with_ao : {false, true})
        for (const int n : {1, 4, 16}) {
            if (n > world.request().most_lights) continue;
            tell(fmt::format("one of {} lights moves", n));
            const Beside b = beside_one(world, n, with_ao, options);
            const Motion::Frame& m = b.many;
            const double mb = 1e-6;
            sheet.rows.push_back({fmt::format("one of {}", n), with_ao ? "all algorithms" : "ID",
                                  {m.wall_ms, b.one.wall_ms, b.ratio, m.times.processor, b.processor_ratio, double(m.stages), double(m.maps), double(m.gathers), m.times.maps, m.times.direct, m.times.mirrors, m.times.ao, m.times.gather, m.times.rest,
                                   m.wall_ms - m.times.all, mb * double(m.map_bytes), mb * double(m.gather_bytes), mb * double(m.map_bytes + m.gather_bytes) / n}, {}});
        }
    sheet.lines = {"Each light's map and what it sends to each pixel are held (16 bytes a pixel), and the sum is formed again from all of them; direct light is one stage over all lights. "
                   "Of ambient occlusion each light's node adds to those before it: those after the one that moves run again, but only to add what they hold (16 bytes a pixel).",
                   "Beside stages: hashes of the scene, by which it is known what changed."};
    return sheet;
}

}  // namespace

std::vector<IprSheet> lra_moving_tables(LraWorld& world, const RunOptions& options, const LraTell& tell) {
    std::vector<IprSheet> sheets;
    if (world.request().wants("moving")) sheets.push_back(table_7_6(world, options, tell));
    if (world.request().wants("kept")) sheets.push_back(one_of_many(world, options, tell));
    return sheets;
}

}  // namespace plumb::cli
