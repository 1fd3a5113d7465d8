// plumb experiment ipr, its part on level of detail (IPR 5.2.2): the thesis' setups and figures, ours beside them, and the largest gap
// in the degree of neighbouring levels that leaves no visible seam.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/camera.h"
#include "gi/probes/lod.h"
#include "gi/probes/run_loop.h"
#include "tools/experiments/ipr_errors.h"
#include "tools/shared/reports.h"

namespace plumb::cli {

// ---- What the thesis prints ---------------------------------------------------------------------------------------------

struct LodFigures {
    std::string setup;
    std::int64_t receivers = 0;  // active ones; 0: not printed
    double ms = 0, speed_up = 1;
    std::optional<double> ssim;
};
struct LodTable {
    std::string number, title;  // "5.5", "Open Hall, camera 1"
    std::vector<LodFigures> rows;
};
const std::vector<LodTable>& thesis_lod_tables();  // 5.5 to 5.9, figure 5.32

// Of which levels of the lightmap the light is extended beyond borders (figure 5.33).
enum class LodBorders : int { all, finest, none };

// Setups by name: "NO LOD"; "S0" to "S2" (table 5.4, with view zones); "LOD 0" to "LOD 3" (5.8); "SH 0" to "SH 7" (5.9); "D0" to "D2"
// (5.10); "SD0" to "SD2" (5.11); "R 512" to "R 64", "R adaptive" (figure 5.31); "zones", "no zones" (5.32); "borders: all", "borders:
// level 0", "borders: none" (5.33). The thesis does not say how many rays a level has in its tables: 512, 256, 128, 64 as its default
// (4.2.1), or the fewest whose weights integrate the level's degree; all of them where only distances, or only degrees, or only the
// lightmap are tested. Throws InputError for another name.
struct LodSetup {
    std::string name;
    probes::LodParams params;
    LodBorders borders = LodBorders::all;
};
// scale: of distances, for scenes smaller than the thesis' hall.
LodSetup lod_setup(const std::string& name, double scale = 1);
std::vector<LodSetup> lod_setups(const std::vector<std::string>& names, double scale = 1);

// ---- Ours ---------------------------------------------------------------------------------------------------------------

struct LodView {
    std::string name;
    Camera camera;
    glm::ivec2 size{320, 180};
    int samples = 0;                      // paths a pixel of the truth; 0: none is traced
    const IprTruth* receivers = nullptr;  // null: none is held against
    bool levels = false;                  // also pictures of levels and lightmaps
};

// What of an update its stages take, each run by itself: medians. levels: of all that has a level, and which tiles of the lightmap
// are written.
struct LodStageMs {
    double levels = 0, radiance = 0, lambda = 0, basis = 0, irradiance = 0, lightmap = 0;
};

// Of one setup in one view, what moves: places in the air, and the light that they give it, against no level of detail.
struct LodAir {
    std::int64_t read = 0, computed = 0;  // places
    probes::LodCounts counts;
    double ms = 0;                        // of their basis and irradiance, and of what lies between: the median
    double error = 0, worst = 0;          // of irradiance at the vertices: mean |difference| / mean; the largest / mean
    double least = 0;                     // the least irradiance / mean
};

// Of one setup in one view, against no level of detail.
struct LodMeasured {
    std::string setup;
    probes::LodCounts counts;
    std::int64_t receivers = 0;             // active: computed
    double ms = 0, speed_up = 1;            // one update, levels included: the median
    LodStageMs stages;                      // of it
    std::optional<double> ssim, ssim_truth; // of the displayed picture: against the reference's, and with traced indirect light
    std::optional<IprErrors> at_pixels;     // of the indirect light
    std::optional<IprErrors> at_receivers;  // of those that are computed
    double error = 0, worst = 0;            // of indirect irradiance of pixels: mean |difference| / mean; largest of 64 x 64 pixels' means
    std::optional<LodAir> air;              // where something moves, and the bake has spatial receivers
    std::vector<std::string> notes;
    Image4 picture;                         // displayed, 0..1
    Image4 ssim_picture, error_picture;     // beside the reference's, and beside the truth
    Image4 levels, lightmap;                // red, green, blue, yellow; the strip of levels: black where nothing is computed
};

// A step between levels that differ in degree alone, over all lit receivers: what a boundary shows, wherever it lies.
struct LodSeam {
    int near = 7, far = 7;  // degrees
    double mean = 0;        // of |step| / irradiance
    double tenth = 0;       // what a tenth of the receivers exceed
    double seen = 0;        // the same, of steps that are larger than those between neighbouring texels
    double texels = 0;      // over how many a step has to be spread, for a tenth to be above the light's own change, and visible_step, a texel
    int gap() const { return near - far; }
    bool visible() const;
};
// An 8-bit sRGB code at middle grey is 2.4 / (128 + 14) = 1.7 % of its luminance; the eye's Weber fraction is 1 to 2 %. A seam is
// called visible where a tenth of its length shows more than this, and more than the light's own change to the next texel.
inline constexpr double visible_step = 0.02, visible_length = 0.1;

struct LodSeams {
    std::vector<LodSeam> pairs;   // near 7 to 0, far from near to 0
    int largest_gap = 0;          // without a visible seam, whatever the near degree is, of those that pairs ask
    int largest_gap_from_top = 0; // where the near degree is the bake's
};

// What the pairs' largest gaps are. Throws InputError for no pairs.
LodSeams largest_gaps(std::vector<LodSeam> pairs);

// The scene without what moves.
Scene still_scene(const Scene& scene);

// A scene's static meshes and their bake, lit by lamps, sky and emission; and what moves, in the air. The bake must be whole, and outlive it.
class LodBench {
  public:
    LodBench(const Scene& scene, const probes::Bake& bake, const RunOptions& options);
    ~LodBench();

    // The first of them is no level of detail, whether it is asked for or not: speed-up and error are against it. updates: of which the
    // time is the median. reference: the setup whose picture SSIM is against. What a view of that name sees is kept.
    std::vector<LodMeasured> measure(const LodView& view, const std::vector<LodSetup>& setups, int updates = 5,
                                     const std::string& reference = "NO LOD") const;
    LodSeams seams() const;

  private:
    struct World;
    std::unique_ptr<World> world_;
};

std::string lod_text(const std::string& title, const std::vector<LodMeasured>& ours, const LodTable* thesis);
std::string seams_text(const LodSeams& seams);
Json lod_json(const std::vector<LodMeasured>& ours);
Json seams_json(const LodSeams& seams);

}  // namespace plumb::cli
