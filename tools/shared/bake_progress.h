// How far a bake is, as a line on standard error.
#pragma once

#include <chrono>
#include <cstdio>
#include <mutex>
#include <string>

#include "gi/probes/bake.h"
#include "tools/shared/progress.h"

namespace plumb::cli {

// "step (receivers 0 to 1023)": one of many nodes of a step.
inline bool is_block(const std::string& label) { return label.find(" (") != std::string::npos; }
inline std::string step_of(const std::string& label) { return label.substr(0, label.find(" (")); }

// Of those, the ones that take nearly all of the time.
inline bool is_slow(const std::string& label) { return label.starts_with("probes.coefficients ("); }

// Says how far the blocks are.
class BakeProgress {
  public:
    explicit BakeProgress(const probes::BakeGraph& graph) : graph_(graph), bar_({}) {}
    graph::Progress callback() {
        if (!bar_.callback()) return {};
        return [this](const std::string& label, double done) { show(label, done); };
    }

  private:
    void show(const std::string& label, double done) {
        const std::lock_guard lock(mutex_);
        const auto now = std::chrono::steady_clock::now();
        if (label != label_ && is_slow(label_)) ++blocks_;
        if (label != label_ && blocks_ == 0) start_ = now;
        if (label == label_ && now - last_ < std::chrono::milliseconds(100)) return;
        label_ = label, last_ = now;
        const int blocks = graph_.bake().alpha.empty() ? 0 : graph_.blocks_here();
        const double share = blocks > 0 ? std::min(1.0, (blocks_ + (is_slow(label) ? done : 0)) / blocks) : 0;
        const double passed = std::chrono::duration<double>(now - start_).count();
        const double left = share > 0.01 ? passed * (1 - share) / share : -1;
        std::fprintf(stderr, "\r\033[K%s", progress_line(label, share, left, 80).c_str());
    }
    const probes::BakeGraph& graph_;
    ProgressBar bar_;  // wipes the line at the end
    std::mutex mutex_;
    std::string label_;
    int blocks_ = 0;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now(), last_{};
};

}  // namespace plumb::cli
