// plumb experiment isr: the evaluation of Rohleder 2010, "Real-time radiosity in image space" (ISR), chapter 5, on our
// scenes: figures 5.7-5.12 and table 2 against the path tracer and, for a few views, POV-Ray; settings beyond the
// thesis'; and what the same point of the world receives as the camera turns.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/compare.h"
#include "gi/frame/frame.h"
#include "gi/frame/kept.h"
#include "tools/experiments/vrsm.h"
#include "tools/shared/batch_files.h"
#include "tools/shared/batch_views.h"

namespace plumb::cli {

struct IsrRequest {
    std::vector<std::string> lists;  // camera lists
    glm::ivec2 size{192, 144};
    glm::ivec2 time_size{1024, 768};  // of figure 5.7
    int samples = 128;                // of the truth, paths a pixel
    int views = 0;                    // of each list, spread over it; 0: all
    int pov = 0;                      // views that POV-Ray renders as well
    int repeats = 3;                  // of times
    int beyond_views = 6;             // 0: no such section
    int turning_views = 3;            // 0: no such section
    bool truth_only = false;
    bool pairing = false;             // the thesis' pairing alone (isr_pairing.cpp)
};

// A picture against the model: as the display shows it, sRGB-encoded 0..1 (what Imalyzer compares), and as radiance.
struct IsrMeasure {
    double k_ssao = 0, k_isr = 0;
    double mean_error = 0;          // ISR (19) of the display
    std::optional<double> pearson;  // ISR (20) of the display
    double linear_error = 0;        // ISR (19), W/(m2 sr), over the model's mean
    std::optional<double> linear_pearson;
    double improved = 0, worse = 0;  // shares of the pixels: nearer to the model than direct light, or farther
};

// Figure 5.8-5.10's numbers of one view.
struct IsrViewResult {
    std::string name, group;
    std::size_t triangles = 0;
    double exposure = 1;
    double truth_ms = 0, truth_noise = 0;  // mean standard error of the truth over its mean
    double display_noise = 0;              // mean absolute error of the display that the noise alone makes
    double direct_ms = 0, isr_ms = 0;      // a frame's stages, medians
    IsrMeasure direct;
    // By k_ssao and k_isr, isr_grid(): the corrected composition with the environment as ambient light and without.
    std::vector<IsrMeasure> corrected, without_ambient, published;
    // Against what ISR means to compute (isr_own.cpp), of one bounce: direct light, and corrected without ambient light.
    IsrMeasure own_direct, own_isr;
    double own_noise = 0;  // mean standard error of that truth over its mean
};
struct IsrK {
    double ssao = 0, isr = 0;
    bool ambient = true;  // [isr] ambient = environment; not in the grid
};
// Every pair that is tried: k_ssao 0, 0.25, 0.5; k_isr 0, 0.1 .. 1.
const std::vector<IsrK>& isr_grid();
// The grid's index of what the thesis prints, of the corrected composition, and of any pair in it.
std::size_t isr_grid_index(double k_ssao, double k_isr);

double isr_gain(const IsrViewResult& view, const IsrMeasure& m);  // ISR 5.3.2, share of the error

// A setting of [isr] and what it costs: on one view, or the mean over views.
struct IsrBeyond {
    std::string family;
    std::vector<std::string> sets;
    std::string refused = {};  // why it was not measured
    std::vector<double> ms = {},
                        error = {};  // by view: median time of the stages of isr; linear error over the model's mean
    std::vector<double> display_error = {};        // by view
    double relative_time = 1, relative_error = 1;  // geometric means over the views, of the thesis' settings
    bool front = false;                            // no other is as good in both and better in one
};

// Points of the world, from a turning camera.
struct IsrTurning {
    std::string setting;  // "ISR", "guard band of 64"
    std::vector<std::string> sets;
    std::string refused;
    std::vector<double> yaw_deg;  // of the camera
    // [point][yaw]: luminance of the irradiance, W/m2; NaN where the point is not seen.
    std::vector<std::vector<double>> irradiance;
};
struct IsrTurningView {
    std::string name;
    std::vector<double> truth;  // W/m2, by point: luminance of one bounce, above 0
    double truth_error = 0;     // W/m2, mean over the points
    std::vector<IsrTurning> settings;
};

// How far ISR's samples reach: a share of the frame's height, the same at every size.
struct IsrReach {
    int rings = 0;
    double of_height = 0;
};

struct IsrTime {
    int samples = 0;  // 0: direct light alone
    double frame_ms = 0, isr_ms = 0;
    IsrReach reach = {};
};

// A view that POV-Ray rendered, and how far direct light and ISR are from it.
struct IsrPov {
    std::string name;
    std::string failed = {};  // why there is no picture
    double published_s = 0, physical_s = 0;
    double direct_error = 0, isr_error = 0, truth_error = 0;  // of the display, against POV-Ray's physical picture
    std::optional<double> direct_pearson = {}, isr_pearson = {};
    double improved = 0, worse = 0;
};

// A setting against a model under a display: what one view says.
struct IsrPair {
    std::string model, setting, display;
    double direct_error = 0, isr_error = 0;  // ISR (19)
    std::optional<double> direct_pearson = {}, isr_pearson = {};
    double better = 0, worse = 0;            // shares of the pixels; the others are ties
};
struct IsrPairing {
    std::string name;
    std::string failed = {};  // why there is no picture
    double pov_s = 0;         // that POV-Ray took for table 1's preset
    std::vector<IsrPair> pairs = {};
};

struct IsrResult {
    IsrRequest request;
    std::string isa, processor;
    int threads = 0;
    double load_before = 0, load_after = 0;
    std::vector<IsrViewResult> views;
    IsrK best;       // least mean error over all views, corrected, with ambient light or without
    IsrReach reach;
    std::string time_view;
    std::size_t time_triangles = 0;
    std::vector<IsrTime> times;  // figure 5.7
    std::vector<IsrPov> pov;
    std::vector<IsrBeyond> beyond;  // the thesis' first
    std::vector<std::string> beyond_names;
    std::vector<IsrTurningView> turning;
};

// isr_views.cpp
struct IsrCommon {
    BatchScenes& scenes;
    BatchTruths& truths;
    BatchResults& results;
    const IsrRequest& request;
    const RunOptions& options;
};
std::vector<BatchView> isr_views_of(const BatchScenes& scenes, int of_each_list);
frame::Settings isr_settings(const Scene& scene, const std::string& method, const std::vector<std::string>& sets);
frame::Frame isr_frame(const Scene& scene, const frame::Settings& settings, const RunOptions& options);
// Such that the logarithmic mean of the luminance is shown as 18 % (Reinhard 2002, 2.1).
double isr_exposure(const Image4& truth);
Image4 isr_display(const Image4& radiance, double exposure, const RunOptions& options);
compare::Picture isr_rgb(const Image4& image);
// The frame's radiance for other coefficients.
Image4 isr_composed(const Scene& scene, const frame::Settings& settings, const frame::Frame& frame, const IsrK& k,
                    const RunOptions& options);
IsrViewResult isr_measure_view(const IsrCommon& common, const BatchView& view);
// The least mean error over all views, of the corrected composition's grids.
IsrK isr_best(const std::vector<IsrViewResult>& views);
const IsrMeasure& isr_measure_of(const IsrViewResult& view, const IsrK& k);  // corrected
std::vector<std::string> isr_sets(const IsrK& k);
// A frame's stages, all run anew in memory that is kept: the sum of their times, and of isr's alone.
class IsrTimedFrame {
  public:
    IsrTimedFrame(const Scene& scene, frame::Settings settings);
    const frame::Frame& run(const RunOptions& options);
    std::vector<double> frame_ms, isr_ms;

  private:
    Scene scene_;
    frame::Settings settings_;
    frame::Plan plan_;
    std::uint64_t run_ = 0;
    frame::KeptStages kept_;
};
// The picture's numbers against the model's. `model`: radiance and display.
struct IsrModel {
    Image4 radiance, display;
    double exposure = 1, mean = 0;
};
IsrModel isr_model(const Image4& radiance, double exposure, const RunOptions& options);
IsrMeasure isr_compare(const IsrModel& model, const Image4& direct_display, const Image4& radiance, const IsrK& k,
                       const RunOptions& options);

// isr_times.cpp
void isr_times(const IsrCommon& common, const std::vector<BatchView>& views, IsrResult& result);
std::vector<IsrPov> isr_pov(const IsrCommon& common, const std::vector<BatchView>& views);

// isr_beyond.cpp
std::vector<IsrBeyond> isr_candidates();
void isr_beyond(const IsrCommon& common, const std::vector<BatchView>& views, IsrResult& result);

// isr_turning.cpp
std::vector<IsrTurningView> isr_turning(const IsrCommon& common, const std::vector<BatchView>& views);
// Sums over the points that are seen, over the sums of their truths: no point whose truth is tiny rules them.
struct IsrYaw {
    double yaw_deg = 0, mean = 0;  // of the truth
    int points = 0;                // seen at this yaw, one at least
};
std::vector<IsrYaw> isr_turning_curve(const IsrTurning& turning, const std::vector<double>& truth);
struct IsrSpread {
    double mean = 0;                  // of the truth; over all yaws and points
    double deviation = 0, range = 0;  // over yaw, of the truth; over the points that are seen from two yaws at least
    double relative = 0;              // each such point's deviation over its own mean, weighted by its truth
    int points = 0, seen = 0;         // such points, and how often they are seen
};
IsrSpread isr_spread(const IsrTurning& turning, const std::vector<double>& truth);

// isr_own.cpp
// What image-space radiosity of so many bounces means to compute at points: light of lamps, directly where `direct`, and reflected
// once to `bounces` times; and what surfaces emit, reflected at most once less. No environment, nothing glossy.
reference::Estimate isr_own_irradiance(const Scene& scene, const reference::PointInputs& points, int bounces, bool direct,
                                       int samples, const RunOptions& options);
// The same as a picture, of the points that the frame sees: direct light is in it. error: the standard error.
reference::Estimate isr_own_picture(const Scene& scene, const frame::Frame& frame, int bounces, int samples,
                                    const RunOptions& options);

// isr_pairing.cpp
// Every combination that a view is asked for, in the order of IsrPairing::pairs: model, setting, display.
struct IsrReading {
    std::string name;
    std::vector<std::string> sets;
    std::string why;  // what it tries
};
const std::vector<IsrReading>& isr_readings();
std::vector<IsrPairing> isr_pairing(const IsrCommon& common, const std::vector<BatchView>& views, const std::string& folder);

// isr_pairing_report.cpp
std::vector<VrsmNumber> isr_pairing_numbers(const std::vector<IsrPairing>& pairings);
Json isr_pairing_json(const IsrResult& result, const std::vector<IsrPairing>& pairings, std::size_t of,
                      const std::vector<VrsmNumber>& numbers);
std::string isr_pairing_text(const std::vector<IsrPairing>& pairings, std::size_t of, const std::vector<VrsmNumber>& numbers);
std::string isr_pairing_html(const IsrResult& result, const std::vector<IsrPairing>& pairings, std::size_t of,
                             const std::vector<VrsmNumber>& numbers, const std::string& command);

// isr_report.cpp
using IsrNumber = VrsmNumber;
std::vector<IsrNumber> isr_numbers(const IsrResult& result);
std::string isr_value_text(const IsrNumber& number);  // as people read it
Json isr_json(const IsrResult& result, const std::vector<IsrNumber>& numbers);
std::string isr_text(const IsrResult& result, const std::vector<IsrNumber>& numbers);

// isr_page.cpp
struct IsrPictures {  // sRGB-encoded
    std::string name, caption;
    Image4 truth, direct, isr, negative;  // negative: 1 - |ISR - DL|, ISR's own part, as figure 5.5 c
};
struct IsrGallery {
    std::vector<IsrPictures> best, worst;               // by gain
    std::vector<IsrPictures> correlated, uncorrelated;  // by gain of correlation: figures 5.11, 5.12
    std::string modes_name;
    std::vector<std::pair<std::string, Image4>> modes;  // F2-F5
};
IsrGallery isr_gallery(const IsrCommon& common, const std::vector<BatchView>& views, const IsrResult& result);
std::string isr_html(const IsrResult& result, const std::vector<IsrNumber>& numbers, const IsrGallery& gallery,
                     const std::string& command);

}  // namespace plumb::cli
