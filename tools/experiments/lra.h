// plumb experiment lra: chapter 7 of Haragas 2023 (LRA) again, tables 7.1 to 7.6, on the scene `city`: which algorithms run, how much of
// the model is drawn, which lights and how many, at which size, and what moves; and what the thesis calls surprising, explained by
// counting: fragments, texels, samples, maps.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/isa.h"
#include "core/scene.h"
#include "core/view.h"
#include "gi/frame/frame.h"
#include "tools/experiments/ipr_sheet.h"

namespace plumb::cli {

inline constexpr std::array<const char*, 7> lra_parts = {"algorithms", "share", "types", "lights", "sizes", "moving", "kept"};

struct LraRequest {
    std::set<std::string> parts;           // empty: all
    bool quick = false;                    // a small city, small frames and maps: to see that all of it works
    std::int64_t triangles = 4'000'000;    // LRA 7.1
    int divide = 1;                        // sides of frames by so much
    int map = 2048;                        // texels a side
    int samples = 200;                     // of a gather
    int most_lights = 32;
    int repeats = 3;                       // whose median is a time
    bool wants(const char* part) const { return parts.empty() || parts.count(part) > 0; }
};

// An algorithm of LRA 4.3 as settings; one without any has no stage in this program, and its rows do not run.
struct LraAlgorithm {
    const char* name;
    std::vector<std::string> sets;
};
const std::vector<LraAlgorithm>& lra_algorithms();
std::vector<std::string> lra_all();  // names of those with settings

enum class LraLight { direct, spot, point };

// What one row of a table draws, and what the thesis prints beside it.
struct LraCase {
    std::string name;
    std::vector<std::string> algorithms = lra_all();
    double share = 1;                      // of the model's triangles
    glm::ivec2 size{800, 800};             // pixels, before they are divided
    std::vector<LraLight> lights = {LraLight::direct};
    std::optional<double> thesis_fps = {}, thesis_ms = {};
};

// Milliseconds of a frame's stages, by what they are of; and what was counted.
struct LraTimes {
    double all = 0, camera = 0, maps = 0, direct = 0, mirrors = 0, ao = 0, gather = 0, rest = 0;
    double processor = 0;  // of all threads, the whole frame
    double still() const { return all - maps; }  // lights and model at rest: maps are kept (LRA 6.2.2)
};
// Adds what a stage of that name took to what it is of.
void add_stage(const std::string& name, double ms, LraTimes& times);
struct LraFragments {
    std::uint64_t triangles = 0;           // that touch the frame
    std::uint64_t covered = 0;             // pixels with a surface
    std::uint64_t drawn = 0;               // fragments without a depth test
    std::uint64_t passing = 0;             // that pass it in the model's order: a forward renderer shades them
    double overdraw() const { return covered ? double(passing) / double(covered) : 0; }
};
struct LraMeasured {
    LraTimes times;                        // medians
    std::size_t triangles = 0;             // of the share
    LraFragments fragments;
    double samples = 0, texels = 0;        // of gathers; of maps
    int maps = 0;
    Image4 display;
};

// lra_world.cpp: the model, scaled so that its bounding sphere has a radius of 35 m: a directional light's map then sees what the
// thesis' +-35 m do.
class LraWorld {
  public:
    LraWorld(const LraRequest& request);

    const LraRequest& request() const { return request_; }
    // The scene of a row, until the next call.
    Scene& scene(const LraCase& row);
    frame::Settings settings(const LraCase& row) const;
    glm::ivec2 size(const LraCase& row) const { return row.size / request_.divide; }
    // Light `index` turned by that angle: a spot about its place, as LRA's arrow keys do.
    Light light(LraLight kind, int index, double turned_deg = 0) const;
    LraFragments fragments(const LraCase& row);

  private:
    LraRequest request_;
    Scene scene_;
};
inline constexpr double lra_half_width = 35;  // m, LRA 6.1

// Of all threads, since the program began: what other programs on the machine delay least.
double processor_ms();

// Draws nothing: counts what a rasterizer would draw, by the coverage and depths of raster/screen_triangle.h; alpha masks hide nothing.
LraFragments count_fragments(const Geometry& geometry, const View& view, glm::ivec2 size);

// y = fixed + each x, by least squares of relative errors; `off`: the largest error, a part of y. Fewer than two x: nothing.
struct LraLine {
    double fixed = 0, each = 0, off = 0;
};
std::optional<LraLine> fitted_line(const std::vector<double>& x, const std::vector<double>& y);

// Rows that have no stage for one of their algorithms are nothing.
using LraTell = std::function<void(const std::string&)>;
bool lra_runs(const LraCase& row);
std::vector<std::optional<LraMeasured>> measure_cases(LraWorld& world, const std::vector<LraCase>& rows, const RunOptions& options,
                                                      const LraTell& tell);

// lra_tables.cpp: tables 7.1 to 7.5. lra_moving.cpp: 7.6, and one of many lights that moves.
std::vector<IprSheet> lra_still_tables(LraWorld& world, const RunOptions& options, const LraTell& tell);
std::vector<IprSheet> lra_moving_tables(LraWorld& world, const RunOptions& options, const LraTell& tell);

// lra_report.cpp.
struct Lra {
    LraRequest request;
    std::vector<IprSheet> sheets;
    std::string processor, isa;
    int threads = 0;
    double load = 0;  // of the machine before the run, mean of a minute
};
Lra measure_lra(const LraRequest& request, const RunOptions& options, const LraTell& tell);
// What is a guess of the text, a line each; what was not run.
std::vector<std::string> lra_guesses();
std::vector<std::string> lra_not_run();
std::string lra_text(const Lra& result);
page::Json lra_json(const Lra& result);
std::string lra_csv(const Lra& result);
std::string lra_html(const Lra& result, const std::string& command);

}  // namespace plumb::cli
