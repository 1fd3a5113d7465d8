// What the program is at, on standard error, where that is a terminal; nothing otherwise.
#pragma once

#include <chrono>
#include <map>
#include <mutex>
#include <string>

#include "gi/frame/frame.h"

namespace plumb::cli {

// One line of at most `width` columns: stage, bar, percentage, time left (negative: not known yet).
std::string progress_line(const std::string& stage, double share, double seconds_left, int width);

// Says at once what is done where no stage runs, "reading city.toml", until it is destroyed, which wipes it. The line of
// an outer one comes back then.
class StatusLine {
  public:
    explicit StatusLine(std::string what);
    ~StatusLine();
    StatusLine(const StatusLine&) = delete;
    StatusLine& operator=(const StatusLine&) = delete;

  private:
    std::string what_;
    StatusLine* outer_;
    bool terminal_;
};
// What it shows: one line of at most `width` columns, whose end stays where it is too long.
std::string status_text(const std::string& what, int width);

class ProgressBar {
  public:
    explicit ProgressBar(const frame::Plan& plan);  // says that the scene is prepared
    ~ProgressBar();  // wipes the line

    // What frame::execute calls; empty where there is no terminal.
    frame::Progress callback();

  private:
    void show(const std::string& label, double done);

    bool terminal_;
    double total_ = 0;                                        // expected ms of all stages
    std::map<std::string, std::pair<double, double>> stage_;  // label: expected ms before it, and of it
    std::map<std::string, int> samples_;                      // label: paths a pixel, where their number is known
    std::mutex mutex_;
    std::chrono::steady_clock::time_point start_, last_;
    std::string label_;
    double furthest_ = 0;  // bands finish in any order, the bar never goes back
};

}  // namespace plumb::cli
