// plumb experiment ipr: chapter 5 of IPR again, on scenes of a user's own: its tables and figures beside ours, and what it lacks: the
// error of indirect irradiance against path tracing. ipr_lod.h has its part on level of detail.
//
// The truth is all light but what lamps send straight to a surface: what probes can bring. It is asked at receivers, and at the
// picture's pixels.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "gi/frame/frame.h"
#include "gi/probes/bake.h"
#include "gi/probes/debug_layers.h"
#include "tools/experiments/ipr_errors.h"
#include "tools/experiments/ipr_lod.h"
#include "tools/experiments/ipr_sheet.h"

namespace plumb::cli {

struct IprRequest {
    bool quick = false;
    int samples = 16384;         // paths a receiver of the truth; of a pixel a 64th
    int receivers = 512;         // at most so many are held against it, every k-th
    int updates = 5;             // whose median is the time of one
    double open = 1;             // receivers more open to the sky than this share are left out
    glm::ivec2 size{320, 180};   // of pictures
    std::vector<LodView> cameras; // of level of detail, the thesis' cameras 1, 2, 3; empty: the scene's own
    std::set<std::string> parts; // of ipr_parts; empty: all
    bool wants(const std::string& part) const { return parts.empty() || parts.count(part) > 0; }
};
inline const std::vector<std::string> ipr_parts = {"tables", "graphs", "figures", "goals", "quads", "lightmap", "spatial", "objects", "lod"};

// ---- A setting ----------------------------------------------------------------------------------------------------------

struct IprThesis {
    int receivers = 0, clusters = 0;  // 0: not printed
    double ms = 0;                    // of a GeForce GT 630M
    double minutes = 0;               // of its precomputation, one thread of an i5-3210M
};

struct IprVariant {
    std::string name, settings;  // settings: in place of the others', in words
    probes::BakeParams bake;
    probes::RunParams run;
    bool shadow_rays = false;   // to lamps, in place of shadow maps
    int shadow_scale = 1;       // times the texels of shadow maps
    float reflectance = 1;      // planted: times what relight rays find
    IprThesis thesis;
    bool dots = false;          // a picture with the probes
    bool contacts = false;      // errors of pixels beside something else, too (figure 5.13)
    bool traced = false;        // the frame's truth, radiance, is traced
};

struct IprRow {
    std::string name, settings;
    IprThesis thesis;
    std::string refused;  // why there are no numbers; empty: there are
    int receivers = 0, probes = 0, clusters = 0, lightmap = 0;
    double bake_seconds = 0;
    std::size_t bytes = 0;    // of one update: matrices, U, lambda, basis, irradiance, lightmap, each once
    std::vector<double> ms;   // of updates, ascending
    std::string rounds;
    IprErrors at_receivers;
    std::optional<IprErrors> at_pixels;  // what the picture shows of it; none where the picture is of another light
    std::optional<IprErrors> at_contacts;
    std::optional<double> ssim, ssim_truth;  // of the displayed picture, against the reference row's, and with traced indirect light
    Image4 radiance, display, error, dots;   // error: of pixels, signed; dots: probes

    double median_ms() const { return ms.empty() ? 0 : ms[ms.size() / 2]; }
    double spread() const { return ms.empty() ? 0 : (ms.back() - ms.front()) / median_ms(); }
};

// A bake's transport without clusters, in double, under the same light, and what the run time makes of it in float.
struct IprQuads {
    double hits = 0;     // relight rays of a probe that meet what emits, mean
    int relight_rays = 0;
    IprErrors chain, whole;
    double ratio() const { return whole.rms > 0 ? chain.rms / whole.rms : chain.rms > 0 ? 1e9 : 1; }
};
inline constexpr double most_quad_ratio = 1.2;

// A room of 4 m with a box, lit by one small square in its ceiling that some 7 of 512 rays of a probe meet.
Scene ipr_quad_room();

struct IprLightmap {
    int receivers = 0, side = 0, samples = 0;
    IprErrors errors;
    int leaks = 0, leaking = 0, black_leaking = 0;  // places; texels of them; of these where no path found light
    double told = 0, told_by_chance = 0;            // shares of receivers told from noise
    std::vector<probes::DebugLayer> pictures;
};

// Bakes, lights and judges settings of one scene.
class IprBench {
  public:
    // Both must outlive it. settings: of the scene; method, bake and size are set here.
    IprBench(const Scene& scene, const frame::Settings& settings, const IprRequest& request, const RunOptions& options);
    ~IprBench();

    IprRow row(const IprVariant& variant);
    IprQuads quads(const probes::BakeParams& params);
    IprLightmap lightmap(const probes::BakeParams& params);
    // The bake, made or kept from the row before.
    const probes::Bake& bake(const probes::BakeParams& params);
    const Image4& truth_display() const { return truth_display_; }
    const IprTruth& receiver_truth(const probes::BakeParams& params) { return truth_of(bake(params).receivers); }
    // A frame by the bake that bake() made last: the scene may differ from this one's in all that a bake does not depend on.
    frame::Frame frame_of(const Scene& scene, const IprVariant& variant);
    double bake_seconds() const { return bake_seconds_; }  // of the bake that is kept

  private:
    const IprTruth& truth_of(const probes::Receivers& receivers);
    void judge_pixels(const frame::Frame& f, bool contacts, IprRow& row);
    void show(IprRow& row) const;

    const Scene& scene_;
    frame::Settings settings_;
    IprRequest request_;
    const RunOptions& options_;
    std::shared_ptr<const probes::Bake> bake_;
    std::string bake_key_;
    double bake_seconds_ = 0;
    std::map<std::uint64_t, IprTruth> truths_;
    Image4 pixel_truth_, truth_display_;
    compare::Plane pixel_mean_, pixel_error_;
    Image<std::uint8_t> pixel_compared_, pixel_contacts_;
    double white_ = 0;
};
// Of a frame: what an update reads and writes.
probes::UpdateBuffers update_buffers(frame::ProbeBuffers& p, const Image4& direct, const probes::RunParams& run);
// SSIM of each row that has a picture against that one's.
void against(const IprRow& reference, std::vector<IprRow>& rows);

// ---- The experiment -----------------------------------------------------------------------------------------------------

struct IprTable {
    std::string id, title;   // "5.1"
    std::string notes;
    std::vector<IprRow> rows;
    std::vector<std::string> left_out;
};
struct IprLodTable {
    std::string title, number;  // "table 5.8: ..."; number: of the thesis' rows; empty: none of its own
    std::string notes;
    std::vector<LodMeasured> rows = {};
};
// By how much of |error| a change of one resource is better than the default; the limit is the best of them.
struct IprGoal {
    double most = 0;      // mean |error| asked for; 0: none is
    double reached = 0;
    std::string limit;    // what a change of lowers it most
    double lowered = 0;   // by so much of it
};
struct IprResult {
    std::string scene;
    std::vector<IprTable> tables;
    std::vector<IprSheet> sheets;
    std::optional<IprGoal> goal;
    std::optional<IprLightmap> lightmap;
    std::optional<IprQuads> quads;  // of ipr_quad_room()
    std::vector<IprLodTable> lod;
    std::optional<LodSeams> seams;
    std::vector<std::string> left_out;
};
using IprTell = std::function<void(const std::string&)>;
IprResult measure_ipr(const Scene& scene, const frame::Settings& settings, const IprRequest& request, const RunOptions& options,
                      const IprTell& tell);
IprGoal goal_of(const std::string& scene, const IprTable& table);

std::string ipr_text(const std::vector<IprResult>& results);
Json ipr_json(const std::vector<IprResult>& results);
std::string ipr_csv(const std::vector<IprResult>& results);
// Sheets and level of detail: a line each number.
std::string ipr_parts_csv(const std::vector<IprResult>& results);
std::string ipr_html(const std::vector<IprResult>& results, const std::string& command);

}  // namespace plumb::cli
