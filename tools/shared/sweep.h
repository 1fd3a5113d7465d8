// Measures error against run time, methods by settings by scenes, in turns (`plumb sweep`; tools/plumb/README.md).
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/image.h"
#include "gi/frame/frame.h"
#include "tools/shared/options.h"
#include "tools/shared/reports.h"

namespace plumb::cli {

// A curve of a sweep: a method and the parameters that vary along it.
struct Variation {
    std::string table, key;           // by their names in scene files: rsm, samples
    std::vector<FieldValue> values;   // never empty
};
struct SweptMethod {
    std::string name;                 // as the curve is called: a gather, or "rsm.paths, radius = 0.15"
    frame::Method method = frame::Method::rsm;
    std::vector<Setting> fixed;       // parameters that all points of the curve share
    std::vector<Variation> varied;    // all combinations; empty: one point
};

// An error of a picture's outgoing radiance, W/(m2 sr), against a path traced one.
struct SweepError {
    double rmse = 0, rel_mse = 0, mean_error = 0;
    double standard_error = 0;        // of the truth and of the picture itself: the RMSE of an unbiased picture
    bool below_noise = false;         // rmse <= standard_error: more samples are needed to see a difference
    double truth_error = 0;           // the truth's part of standard_error: the same for all points of a truth
};

struct SweepPoint {
    std::string scene, method;        // the scene's name, SweptScene::name; the curve
    frame::Method base = frame::Method::rsm;
    std::string settings;             // what varies along the curve, as text: "rsm.samples = 100"; empty: nothing
    std::vector<Setting> changed;     // all that was set in place of the scene file's; not [render] method: base
    std::vector<double> frame_ms;     // of each run, in the order of the runs
    double median_ms = 0;             // of the frame
    double low_ms = 0, high_ms = 0;   // quartiles of the frame
    double stage_ms = 0;              // median of the sum of the stages that are named after the method
    std::size_t peak_bytes = 0;       // Sweep::memory says of what
    SweepError own, full;             // against the method's own transport; against full global illumination
    bool pareto = false;              // no other point of the scene beats it in time and error against full
    std::uint64_t picture_hash = 0;   // of color's bits: the same in every run
};

struct SweptScene {
    std::string name;                 // the file as it was given
    int width = 0, height = 0;
    std::uint64_t content = 0;        // hash of the scene, its size and its own settings
    std::uint64_t truth = 0;          // hash of the truth's bits
    int samples = 0;                  // of the truth, a pixel
    double relative_error = 0;        // of the truth: standard error in parts of the mean
};

// A point that was not measured.
struct LeftOut {
    std::string scene, method, settings, reason;
    bool too_long = false;            // by its time; else it was refused
};

struct Sweep {
    std::string isa, processor;
    int threads = 0, runs = 0;
    std::string memory;               // "resident": the growth of the program's resident memory; "stages": the sum of
                                      // what the stages made, where the system tells no more
    std::vector<SweptScene> scenes;
    std::vector<SweepPoint> points;   // by scene, then by curve
    std::vector<LeftOut> left_out;
    std::vector<std::string> notes;
};

// Pictures as a page shows them: red, green, blue, 8 bits each, sRGB, first row on top.
using Rgb8 = std::vector<unsigned char>;
struct PointPictures {
    Rgb8 color;                       // under the scene's tone curve, as its truth
    Rgb8 against_full, against_own;   // signed: mid gray is equal, brighter is too bright, full swing at difference_swing
};
struct ScenePictures {
    Rgb8 truth;                         // full global illumination
    std::map<frame::Method, Rgb8> own;  // what each method would be without an error: its own transport
};
struct SweepPictures {
    std::vector<ScenePictures> scenes;  // as Sweep::scenes
    std::vector<PointPictures> points;  // as Sweep::points
};
inline constexpr double difference_swing = 0.25;  // of the display's range

// The request for a sweep.
struct SweepRequest {
    std::vector<SceneOptions> scenes;   // file and sets
    const Scene* loaded = nullptr;      // of the only scene, in place of its file: one that was moved to a frame
    std::vector<std::string> methods;   // methods and gathers; empty: all
    std::vector<std::string> vary;      // "rsm.samples=50,100,200"; the last one along curves, a curve for each value of others
    int runs = 5;
    std::optional<glm::ivec2> size;     // in place of the scenes' own
    std::string samples, until_error;   // of the truth, in place of [reference]; words of the command line
    double longest_ms = unbounded;      // points that take longer are left out
    bool no_cache = false;
};

// The curves of a scene's settings: of every method, or those named, by the ranges that its fields() give. `vary` takes
// the place of the ranges of the curves that it concerns: the last one varies along them, of the others each combination of
// values is a curve. Throws InputError that names the nearest known name.
std::vector<SweptMethod> swept_methods(const frame::Settings& settings, const std::vector<std::string>& methods,
                                       const std::vector<std::string>& vary);

// The points of a curve, in order: what varies as text, and what is set.
struct SweptSettings {
    std::string text;
    std::vector<Setting> changed;
};
std::vector<SweptSettings> points_of(const SweptMethod& curve);
// The settings of a point.
frame::Settings apply(frame::Settings settings, frame::Method method, const std::vector<Setting>& changed);

// Hashes all that the pictures of a scene depend on but the settings.
std::uint64_t scene_hash(const Scene& scene);
// As the system calls it; "unknown" where it does not.
std::string processor_name();

// Traces the truths, then runs every point once to warm up, then in turns.
Sweep run_sweep(const SweepRequest& request, const RunOptions& options, SweepPictures* pictures = nullptr);

// Sets median, quartiles and Pareto front from the runs and errors of the points.
void summarise(SweepPoint& point, const std::vector<double>& stage_ms);
// Between the two nearest values where it falls between them; the values need no order. NaN for none.
double quantile(std::vector<double> values, double share);
// Marks the points that no other point of their scene beats: one as good in time and error, and better in one of them.
// A point whose error is no number is never on the front.
void mark_pareto(std::vector<SweepPoint>& points);

Json sweep_json(const Sweep& sweep);
std::string sweep_csv(const Sweep& sweep);
std::string sweep_text(const Sweep& sweep);
Json point_json(const SweepPoint& point);
// Throws InputError that names the place in `path`.
Sweep read_sweep(const std::string& path);
Sweep sweep_of(const std::string& text, const std::string& place);

// The setting to take: of the points of one scene within `budget_ms` the one with the least error against full
// illumination; or of those with at most `error` the fastest. Null where none is.
const SweepPoint* best_within(const Sweep& sweep, const std::string& scene, double budget_ms);
const SweepPoint* fastest_with(const Sweep& sweep, const std::string& scene, double error);
const SweepPoint* fastest(const Sweep& sweep, const std::string& scene);

// A point that changed beyond noise between two sweeps; tools/plumb/README.md says how that is decided.
struct Regression {
    const SweepPoint *before, *now;   // now: null where it was left out
    std::string what;                 // one sentence
};
struct SweepComparison {
    std::vector<Regression> worse, better;
    std::vector<std::string> notes;   // what could not be compared, and why
    std::size_t compared = 0;         // points in both
};
SweepComparison compare_sweeps(const Sweep& before, const Sweep& now);

}  // namespace plumb::cli
