// plumb render --frames: what a sequence of frames took, and what each frame reused.
#pragma once

#include <string>
#include <vector>

#include "tools/shared/reports.h"

namespace plumb::cli {

struct FrameRun {
    int frame = 0;
    std::vector<frame::StageRun> stages;
    double ms = 0;         // of making the frame, with its plan and its keys
    double write_ms = 0;   // of encoding and writing its files
    Json truth = nullptr;  // truth_json(), where something was path traced
    Json radiosity = nullptr;  // radiosity_json(), of that method
    Json lights = nullptr;     // light_costs_json()
};

struct FramesReport {
    const Scene& scene;
    const frame::Settings& settings;
    const RunOptions& options;
    const std::vector<FrameRun>& frames;
    RunTimes times;
    std::size_t peak_bytes = 0;
};

// As run_json(), with "frames" in place of "stages".
Json frames_json(const FramesReport& report);

// One line a frame: its time, and what was kept.
std::string frames_text(const FramesReport& report);

// "out.0007", for frame 7 of the scene out.toml; at least four digits.
std::string frame_name(const std::string& name, int frame);

}  // namespace plumb::cli
