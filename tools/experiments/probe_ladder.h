// plumb experiment probe-ladder: what each number of a bake of irradiance probes buys, a rung a setting (gi/probes/README.md,
// "What each number buys"). probe_ladder_steps.h has the truth, and what lies between it and a rung.
#pragma once

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "tools/experiments/probe_ladder_steps.h"

namespace plumb::cli {

struct LadderRequest {
    CheckRequest check;
    int most_probes = 512;
    std::set<std::string> axes;  // empty: all
};
inline const std::vector<std::string> ladder_axes = {"probes",   "overlaps",  "degree",    "window",  "relight",
                                                     "rays",     "clusters",  "receivers", "placement", "products"};

// A setting, what it costs and how wrong it is.
struct LadderRung {
    std::string axis, line;  // the curve it is a point of
    double value = 0;        // along the axis
    std::string settings;    // in place of the default's: "probes.degree=3"
    bool is_default = false;
    int probes = 0, receivers = 0, clusters = 0;
    double seconds = 0;      // of the bake, wall
    std::uint64_t rays = 0;  // of the bake
    std::size_t bytes = 0;   // of its file; 0: there is none, the transport was never cut
    double products = 0;     // multiply-adds of the run time a relighting, a channel
    LadderErrors errors;
    double tail = -1;            // Frobenius error of the clusters, as their singular values say; -1: not asked
    std::vector<double> others;  // the axis' own step, local, by other sets of directions
    double lookup = -1;          // of a lightmap of another size: local, what interpolating adds; -1: none
};

struct Ladder {
    std::string scene;
    LadderRequest request;
    probes::BakeParams params;
    int receivers = 0, probes = 0, checked = 0, before_sky = 0;  // of the default
    double mean = 0, uncertainty = 0;                            // of the truth, W/m2; local
    double many_uncertainty = 0;                                 // of the step `degree` by the many relight rays, local
    std::vector<LadderRung> rungs;                               // the default alone is the first
    std::vector<std::string> left_out;                           // "probes = 512: ..."
};
Ladder climb(const Scene& scene, const probes::BakeParams& params, const LadderRequest& request, const RunOptions& options,
             const std::function<void(const std::string&)>& progress);

// The step that an axis is about; ladder_steps: none alone.
LadderStep own_step(const std::string& axis);

// Of rungs in the order of their cost: the first from which on none halves the error for twice the cost; -1 of an empty list.
int flat_from(const std::vector<std::pair<double, double>>& cost_and_error);
// Which rungs no other beats in cost and error.
std::vector<bool> on_front(const std::vector<std::pair<double, double>>& cost_and_error);

// Where the curve of an axis flattens, in words: by cost, and against the other steps.
struct LadderFlat {
    std::string axis, line;
    std::string rays, seconds, bytes, products;  // the first rung from which on none halves the whole error for twice the cost
    std::string settled;                         // the first from which on the axis' own step makes less than 5 % of the error
};
std::vector<LadderFlat> flats_of(const Ladder& ladder);

std::string ladder_text(const Ladder& ladder);
std::string ladder_json(const Ladder& ladder);
std::string ladder_html(const Ladder& ladder, const std::string& command);

// Rungs of an axis by their lines, in the order in which they were measured.
std::vector<std::pair<std::string, std::vector<const LadderRung*>>> lines_of(const Ladder& ladder, const std::string& axis);

}  // namespace plumb::cli
