// plumb experiment screen: what the settings of gi/screen cost and what they err by: ambient occlusion and reflections against rays,
// rough reflections against paths, gathered light that frames share against many samples. A curve a choice, along the setting that buys accuracy.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "gi/frame/frame.h"
#include "tools/experiments/ipr_sheet.h"

namespace plumb::cli {

struct ScreenRequest {
    std::string size = "480x270";  // pixels
    int paths = 64;                // of the truths, a pixel
    int repeats = 5;               // whose median is a time
    int frames = 32;               // that share gathered light before they are compared
    std::string preset;            // frame::presets(); empty: none
    std::vector<std::string> sets;
};

// A curve: what is set along it, and what once.
struct ScreenCurve {
    std::string name;
    std::vector<std::string> sets;
    struct Point {
        double at;                      // of the setting along the curve
        std::vector<std::string> sets;
    };
    std::vector<Point> points;
    bool moving = false;  // the camera, of reuse_curves()
};
std::vector<ScreenCurve> occlusion_curves();
// length: that the ray is followed, m: of steps and their number each curve keeps the product.
std::vector<ScreenCurve> reflection_curves(double length);
// Of lobes in place of mirrors.
std::vector<ScreenCurve> lobe_curves();
std::vector<ScreenCurve> reuse_curves();

using ScreenTell = std::function<void(const std::string&)>;
// A sheet for each of what the scene has: reflections, and rough ones, where something mirrors, shared frames where a light shines.
std::vector<IprSheet> measure_screen(const std::string& scene, const ScreenRequest& request, const RunOptions& options, const ScreenTell& tell);

}  // namespace plumb::cli
