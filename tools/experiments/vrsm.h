// plumb experiment vrsm: the evaluation of Bang 2011, "Reflective shadow maps with visibility" (VRSM), chapter 5, on
// our scenes: tables 5.1-5.3 and figures 3.1-3.4 and 5.1-5.5, the errors against the ray-cast truth that the thesis does not
// state, each a mean over seeds with its standard error, and settings beyond the thesis' that reach its error for less.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/signed_error.h"
#include "gi/frame/frame.h"
#include "gi/frame/kept.h"
#include "tools/experiments/vrsm_seeds.h"
#include "tools/page/page.h"
#include "tools/shared/reports.h"

namespace plumb::cli {

inline bool vrsm_is_gather(const std::string& stage) { return stage.starts_with("rsm."); }

struct VrsmRequest {
    std::vector<std::string> scenes;  // files; none: the atrium's three views and the Cornell box
    std::vector<std::string> sets;    // table.key=value in place of the thesis'
    int size = 256;                   // pixels of a side of the frame, texels of a side of the maps
    int seeds = 4;                    // of the patterns and of the pixels' rotations
    bool times = false;               // whether frames are timed: of a machine that does nothing else
    int repeats = 9;                  // of what is timed
    int crops = 2;                    // enlarged regions of a scene
    double truth_rays = 0;            // of each scene; 0: every lit texel at every point
    std::vector<int> slots = {3, 5, 9, 17, 32};
    Rays rays = Rays::native;  // of the truth
    bool beyond = true;        // whether settings beyond the thesis' are measured
};

// Table 5.3's passes; every stage of a frame is part of one.
inline constexpr std::array<const char*, 4> vrsm_passes = {"RSM generation", "G-buffer generation", "RSM sampling",
                                                           "Post processing"};
// The shadow density belongs to the G-buffer (VRSM 4.3), direct light and the synthesis to post processing (VRSM 4.5).
std::size_t vrsm_pass(const std::string& stage);

// One setting's times: of each repetition, all settings of a scene in turns.
struct VrsmTimes {
    bool half = true, visibility = false;
    std::vector<double> frame_ms;  // sums of the frame's stages
    std::array<std::vector<double>, vrsm_passes.size()> pass_ms;
};

// One setting's errors: of the gather alone at full resolution, or of the whole chain, half resolution and blur.
struct VrsmErrors {
    bool chain = false;
    rsm::Visibility visibility = rsm::Visibility::none;
    int slots = 0;                                 // without visibility none
    std::optional<rsm::Spacing> spacing = {};      // none: the setting's own
    bool best = false;                             // the least rms of its kind, told apart from all others of it
    bool tied = false;                             // not told apart from the least rms of its kind
    std::vector<compare::SignedErrors> seeds = {};
    std::vector<std::optional<double>> leak_stopped = {};  // share of the energy that leaks without visibility, seed by seed

    VrsmEstimate estimate(std::optional<double> compare::SignedErrors::* quantity) const;
    VrsmEstimate estimate(double compare::SignedErrors::* quantity) const;
    VrsmEstimate rms() const { return estimate(&compare::SignedErrors::rms); }
    // Whether the rms is less than twice the truth's noise: then nothing is concluded from it.
    bool noisy() const;
};
inline constexpr float vrsm_growth = 64;  // of the geometric spacing that is measured

// The truth that errors are measured against.
struct VrsmTruth {
    Image4 irradiance;                // W/m2
    compare::Plane luminance, error;  // error: of one standard deviation; empty where every texel was asked
    Image<std::uint8_t> surface;      // not 0 where there is one
};

// A setting beside the thesis', half resolution and blurred as its is.
struct VrsmBeyond {
    std::string family;             // settings that only the number of samples tells apart: a curve
    std::vector<std::string> sets;  // table.key=value in place of the thesis'; none: the thesis' own
    glm::ivec2 samples{0};          // of a point: directions, steps
    std::vector<compare::SignedErrors> seeds = {};
    std::vector<double> ms = {};  // of each repetition, all settings in turns: the stages from positions to irradiance
    double relative_time = 1;     // median over the repetitions of the time over the thesis' in the same one
    bool winner = false;          // the least cost of those whose rms is told to be at most the thesis', and of the thesis'
    bool least_rms = false;       // of those that cost at most as much as the thesis', told apart from all others of them

    VrsmEstimate estimate(std::optional<double> compare::SignedErrors::* quantity) const;
    // Time over the thesis'; where nothing was timed, samples of a point.
    double cost(const VrsmBeyond& thesis) const;
};

// One path of one point as the light sees it, for figures 3.3 and 3.4: across the light's axis and towards the light, m, from
// the point; what the map's surface is along it, and the samples as Algorithms 2 and 6 judge them.
struct VrsmPath {
    struct Sample {
        glm::dvec2 at;
        int slot = 0;
        bool seen_by_2 = true, seen_by_6 = true;
    };
    glm::ivec2 pixel{0};
    int path = 0;
    std::vector<glm::dvec2> surface;  // texel by texel; NaN where the map shows nothing
    std::vector<Sample> samples;      // that lie on a surface, from near to far
    std::vector<double> edges;        // elevations where slots meet, rad
};

// sRGB-encoded, of one size; W/m2 at which irradiance is white.
struct VrsmPictures {
    Image4 noised;            // figure 3.2 a, whose b is indirect_with
    Image4 without_check;     // figure 3.4 c: by Algorithm 2; d is indirect_with
    Image4 global_without, global_with;            // figures 5.2-5.4 a, b
    Image4 indirect_without, indirect_with;        // c, d; figure 5.1 a, b
    Image4 difference;                             // figure 5.1 c: luminance, times difference_gain
    Image4 truth;                                  // figure 5.1 d
    Image4 error_without, error_with, error_best;  // signed, full colour at error_swing
    std::vector<glm::ivec4> crops;                 // x, y, width, height: where `difference` is largest
    double white = 0;
};
inline constexpr compare::SignedErrorOptions vrsm_judgement = {0.1, 3};  // 10 % of the local truth, 3 standard errors
inline constexpr double vrsm_difference_gain = 4;                        // of the irradiance that is white
inline constexpr double vrsm_error_swing = 0.5;                          // of the local truth
inline constexpr double vrsm_error_floor = 0.05;  // of the truth's mean: dark points are not worth as much

struct VrsmScene {
    std::string name;
    std::string test_case;  // the thesis' A, B, C, or none
    std::size_t triangles = 0;
    glm::ivec2 size{0};
    Json settings;                 // as the chain with visibility runs
    std::vector<VrsmTimes> times;  // half without, with; of the first scene full without, with, too; empty: not timed
    std::string truth;             // what was asked of it: rsm.all_rays' reason
    double truth_seconds = 0;
    std::vector<VrsmErrors> errors;   // by algorithm and slots, of the setting's own spacing
    std::vector<VrsmErrors> spacing;  // by spacing, of 5 slots
    std::vector<VrsmBeyond> beyond;  // the thesis' first; empty where they are not measured
    VrsmPictures pictures;
    std::optional<VrsmPath> hidden, neighbours;  // paths for figures 3.3 and 3.4; none where no point looked at has one
};

struct Vrsm {
    VrsmRequest request;
    std::string isa, processor;
    int threads = 0;
    double load_before = 0, load_after = 0;  // processes that ran or wanted to, mean of a minute; NaN: not known
    std::vector<VrsmScene> scenes;
};

// The subject of a run: a scene at the thesis' setting.
struct VrsmSubject {
    Scene scene;
    std::string test_case;
    std::vector<std::string> sets;
};
// Throws InputError for a scene without indirect light and for settings that the experiment chooses itself.
VrsmSubject vrsm_subject(Scene scene, const VrsmRequest& request);

// vrsm_measure.cpp. `full`: table 5.2, too.
std::vector<VrsmTimes> vrsm_times(const VrsmSubject& subject, const VrsmRequest& request, bool full,
                                  const RunOptions& options);
// Errors, truth and pictures.
void vrsm_look(const VrsmSubject& subject, const VrsmRequest& request, const RunOptions& options, VrsmScene& scene);
frame::Settings vrsm_settings(const VrsmSubject& subject, bool half, rsm::Visibility visibility, int slots);
double median(std::vector<double> values);
// Marks the least rms of those, or what is not told apart from it. Null where there is none.
VrsmErrors* vrsm_mark_best(const std::vector<VrsmErrors*>& rows);

// vrsm_beyond.cpp.
std::vector<VrsmBeyond> vrsm_candidates();
frame::Settings vrsm_settings(const VrsmSubject& subject, const VrsmBeyond& candidate);
std::vector<VrsmBeyond> vrsm_beyond(const VrsmSubject& subject, const VrsmRequest& request, const VrsmTruth& truth,
                                    const RunOptions& options);
// Seed by seed over the thesis'.
VrsmEstimate relative_rms(const VrsmBeyond& candidate, const VrsmBeyond& thesis);
// The candidate whose rms is told to be at most the thesis' on every scene, or the thesis', and of these the one whose largest
// relative cost is least: a number in every scene's `beyond`. None where none was measured.
std::optional<std::size_t> vrsm_winner(const Vrsm& result);

// vrsm_pictures.cpp.
struct VrsmViews {
    const raster::GBuffer* gbuffer = nullptr;
    // Irradiance, W/m2.
    const Image4 *truth = nullptr, *without = nullptr, *with = nullptr, *best = nullptr, *noised = nullptr,
                 *without_check = nullptr;
    const compare::Plane* truth_error = nullptr;                                          // of its luminance
};
VrsmPictures vrsm_pictures(const VrsmViews& views, int crops, const RunOptions& options);

// vrsm_report.cpp: every number of the experiment, once. CSV and JSON hold nothing else, the page shows it.
struct VrsmNumber {
    std::string table;  // "5.1", "5.2", "5.3", "errors", "spacing", "beyond", "beyond all"
    std::string scene, row, quantity, unit;
    std::optional<double> value;   // none where it is undefined
    std::optional<double> thesis;  // what VRSM prints, where it does
};
std::vector<VrsmNumber> vrsm_numbers(const Vrsm& result);
std::string vrsm_row(const VrsmErrors& errors);     // "gather, algorithm_6, S = 5", "frame, none, uniform"
std::string vrsm_row(const VrsmBeyond& candidate);  // "VRSM", "rsm.turn=tile rsm.rotations=16"
std::string vrsm_csv(const std::vector<VrsmNumber>& numbers);
Json vrsm_json(const Vrsm& result, const std::vector<VrsmNumber>& numbers);
std::string vrsm_text(const Vrsm& result, const std::vector<VrsmNumber>& numbers);
std::string value_text(const std::optional<double>& value, const std::string& unit);
std::string estimate_text(const VrsmEstimate& share);  // "54.5 +- 0.2", %

// vrsm_beyond_page.cpp.
// Throws std::logic_error where there is none.
const VrsmNumber& find_number(const std::vector<VrsmNumber>& numbers, const std::string& table, const std::string& scene,
                              const std::string& row, const std::string& quantity);
void add_beyond(page::Page& page, const Vrsm& result, const std::vector<VrsmNumber>& numbers);

// vrsm_paths.cpp. Looks at some points of a frame that gathers along paths at full resolution.
void vrsm_paths(const VrsmSubject& subject, const RunOptions& options, frame::KeptStages& kept, VrsmScene& scene);

// vrsm_figures.cpp: figures 3.1 to 3.4 by the pattern, pictures and paths that were measured.
void add_pattern_figure(page::Page& page, const Vrsm& result);
void add_noise_figure(page::Page& page, const VrsmScene& scene);
void add_buffer_figure(page::Page& page, const VrsmScene& scene);

// vrsm_page.cpp. `command`: the command line that measured it.
std::string vrsm_html(const Vrsm& result, const std::vector<VrsmNumber>& numbers, const std::string& command);

}  // namespace plumb::cli
