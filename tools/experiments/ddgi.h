// plumb experiment ddgi: DDGI's probes (Majercik, Guertin, Nowrouzezahrai, McGuire 2019) and ours, with clustered transport, by
// one yardstick: irradiance of a lightmap's receivers against path tracing.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/signed_error.h"
#include "gi/ddgi/volume.h"
#include "gi/probes/bake_params.h"
#include "tools/shared/reports.h"

namespace plumb::cli {

struct DdgiRequest {
    std::vector<int> grids = {4, 8, 16};            // probes along each axis
    std::vector<int> sides = {6, 8};                // of irradiance; of moments 14 beside 6, else twice as many
    std::vector<int> rays = {64, 128, 256, 512};    // of each probe
    std::vector<int> probes = {8, 30, 78, 300};     // with clustered transport
    int lightmap = 128;                             // texels a side
    int samples = 1024;                             // of the truth, a receiver
    double open = 1;                                // receivers that are more open to the sky are left out
    bool variants = true;
    ddgi::VolumeParams volume;                      // what the table does not vary
    probes::BakeParams bake;
};

// One setting of one method.
struct DdgiRow {
    std::string method;         // "DDGI", "clusters", "whole transport"
    std::string setting;        // "8^3, 6 x 6"; of a variant what it changes
    int probes = 0, rays = 0;   // rays of a probe
    int rounds = 0;
    std::uint64_t traced = 0;   // rays in all, until the light has settled; of a bake without them
    std::uint64_t baked = 0;    // rays of a bake
    std::size_t bytes = 0;      // at run time, on a GPU
    double seconds = 0, bake_seconds = 0;
    compare::SignedErrors errors;
    double leaking = 0, black = 0;  // shares of the receivers
    bool variant = false;
    Image4 lightmap;            // irradiance, W/m2, borders extended

    // Places whose radiance is asked for at each update of the light.
    std::uint64_t places() const { return std::uint64_t(probes) * std::uint64_t(rays); }
    std::string name() const;
};

// Leaks: the truth is below the first share of its mean over all receivers, the method above the second. Black: the other way.
inline constexpr double ddgi_dark = 0.01, ddgi_bright = 0.05;

struct DdgiResult {
    std::string scene;
    int receivers = 0, left_out = 0, lightmap = 0;
    int truth_samples = 0;
    double truth_mean = 0, truth_noise = 0;  // luminance, W/m2; noise: relative
    double dark_receivers = 0;               // share of them that are dark in truth
    std::uint64_t truth_rays = 0;
    Image4 truth;                            // lightmap
    Image<std::uint8_t> receiver_texels;     // of those that are judged
    std::vector<DdgiRow> rows;
};

// Progress: a line before each step.
DdgiResult measure_ddgi(const Scene& scene, const DdgiRequest& request, const RunOptions& options,
                        const std::function<void(const std::string&)>& tell);

std::string ddgi_text(const DdgiResult& result);
Json ddgi_json(const DdgiResult& result);
std::string ddgi_html(const DdgiResult& result, const std::string& command, const RunOptions& options);

// On one scale: white at the 98th percentile of the truth; signed errors: full colour at +-100 %.
struct DdgiPictures {
    Image4 truth;
    std::vector<Image4> shown, error;  // of each row
};
DdgiPictures ddgi_pictures(const DdgiResult& result, const RunOptions& options);

}  // namespace plumb::cli
