// Whether a lightmap that somebody else made can be trusted: texel by texel against the traced truth of the same layout. Where
// it errs, where charts do not fit together, where light is that should not be. README.md, "A lightmap checked", has the
// definitions; every comparison leaves room for what the truth does not know.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/signed_error.h"
#include "gi/probes/lightmap.h"

namespace plumb::probes {

struct CheckParams {
    double sigmas = 4;           // standard errors of the truth that are no error of the map
    double chart_bias = 0.02;    // of a chart's mean: what is less is not reported as a chart that is off
    double seam = 0.05;          // of the light at an edge: what both sides may differ by more than the truth's do
    double leak = 0.1;           // of the median of the truth: what is less is no leak
    double bleeding = 0.25;      // of the light beside a chart, at least of a quarter of the median: what a border texel may be off by
};

// Of two texels with one value each: luminance by ISR (17), W/m2.
struct Place {
    glm::ivec2 texel{-1};
    int object = -1;             // index into Scene::meshes
    std::int32_t chart = -1;     // index into Atlas::charts
    glm::dvec3 position{0};      // m
    double user = 0, truth = 0, error = 0;
};

struct ChartCheck {
    std::int32_t chart = 0;
    int receivers = 0;
    double truth = 0;            // mean, W/m2
    double bias = 0;             // sum of the map over sum of the truth, less 1; 0 where the truth is dark
    double bias_error = 0;       // standard error of that
    double rms = 0;              // relative to the truth's mean, less what the truth's noise explains
    bool off = false;            // |bias| > sigmas bias_error + chart_bias
};

// Both sides of an edge in space that has two places on the map. Values are means over points along it, by bilinear lookups.
struct Seam {
    Place a, b;                  // its worst point, as either side shows it; texel: where the lookup lies
    glm::dvec2 a_from{0}, a_to{0}, b_from{0}, b_to{0};  // the edge on the map, texels
    glm::dvec3 from{0}, to{0};   // m
    bool smooth = false;         // normals agree within 10 degrees: light is the same on both sides
    int points = 0;              // compared; others look where the layout has no receiver
    double length = 0;           // m
    double user = 0;             // mean of |a - b| of the map
    double truth = 0;            // mean of |a - b| of the truth's own map
    double excess = 0;           // rms of (a - b) - (truth's a - b) less the noise, over the light; 0 where noise may explain it
    double worst = 0;            // the largest of these over the light, with its noise
};

enum class LeakKind : int { lit, black };  // black: no path found any light at the place
struct Leak {                    // texels that touch each other
    LeakKind kind = LeakKind::lit;
    Place worst;
    int texels = 0;
};

enum class BleedingKind : int { unwritten, other_chart, wrong };
struct Bleeding {
    BleedingKind kind = BleedingKind::wrong;
    Place place;                 // truth: what the chart's own receivers say
};

struct LightmapCheck {
    compare::SignedErrors errors;    // of luminance, over receivers that lie outside of everything
    double median = 0;               // of the truth there, where it is not 0
    Buffer<glm::vec4> error;         // [receiver] W/m2: standard error of the difference between map and truth
    std::optional<Place> worst;      // farthest beyond the noise; none: nothing is
    int rounds = 0;                  // of the truth
    double sigmas = 0;               // params.sigmas, by Student's t of the truth's rounds
    double rms_least = 0, rms_most = 0;  // of errors.rms, by the noise's own spread: 4 and 2 of its standard errors off
    double told = 0;                 // share of these receivers that differ by more than `sigmas`
    double told_by_chance = 0;       // what share would if the map were right
    double told_energy = 0;          // share of the squared error that they hold
    double best_scale = 1;           // what the map were best multiplied by
    double rms_at_best_scale = 0;
    int inside = 0;                  // receivers that were moved out of something: they are not in `errors`
    compare::SignedErrors inside_errors;

    std::vector<ChartCheck> charts;  // that have receivers, in the atlas' order
    std::vector<Seam> seams;         // worst excess first
    int seams_off = 0;               // excess > CheckParams::seam
    int seams_unknown = 0;           // edges of which no point could be compared: not in the list
    double seam_mean = 0;            // of the excess, by length
    double smooth_user = 0, smooth_truth = 0;  // rms of (a - b) over the light, by length, of smooth edges, where a and b should be
                                               // alike: the map's, and the truth's own less its noise
    std::vector<Leak> leaks;         // largest first
    int leaking = 0, black_leaking = 0;        // texels
    Image<std::uint8_t> leak_marks;            // of each texel: 0 none, 1 + LeakKind
    std::vector<Bleeding> bleeding;  // in the map's order
    int read_beside = 0;             // texels beside a chart that lookups on it read
    int read_unknown = 0;            // of these, what lies farther from the chart's receivers than borders reach
};

// map: irradiance, W/m2, of the atlas' size and finite. map_error: its standard error where it is known, else empty. rounds of
// truth: 2 or more. Throws InputError for another size and for what is not finite, with its texel.
LightmapCheck check_lightmap(const Image4& map, const Image4& map_error, const Lightmap& lightmap, const ReceiverIrradiance& truth,
                             const CheckParams& params = {});

// The share of Student's t of so many degrees of freedom that lies beyond -t and t.
double student_beyond(double t, int degrees);
// The t beyond which as little of it lies as of a normal distribution beyond `sigmas`: of few rounds a standard error is a poor
// estimate itself.
double student_sigmas(double sigmas, int degrees);

}  // namespace plumb::probes
