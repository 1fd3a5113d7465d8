#include "tools/shared/progress.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

namespace plumb::cli {

namespace {

int terminal_width() {
    winsize size{};
    return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

std::string time_text(double seconds) {
    if (seconds < 0) return "";
    if (seconds < 60) return fmt::format("{:.0f} s left", seconds + 0.5);
    if (seconds < 3600) return fmt::format("{}:{:02} min left", int(seconds) / 60, int(seconds) % 60);
    return fmt::format("{}:{:02} h left", int(seconds) / 3600, int(seconds) / 60 % 60);
}

void show_line(const std::string& text) {
    std::fputs(("\r" + text + "\033[K").c_str(), stderr);
    std::fflush(stderr);
}

// Of the thread that reads the command line: nobody else makes one.
StatusLine* innermost = nullptr;

}  // namespace

std::string status_text(const std::string& what, int width) {
    const std::size_t room = std::size_t(std::max(0, width - 1));
    if (what.size() <= room) return what;
    const std::size_t dots = std::min<std::size_t>(3, room);
    return std::string(dots, '.') + what.substr(what.size() - (room - dots));
}

StatusLine::StatusLine(std::string what) : what_(std::move(what)), outer_(innermost), terminal_(isatty(STDERR_FILENO)) {
    innermost = this;
    if (terminal_) show_line(status_text(what_, terminal_width()));
}

StatusLine::~StatusLine() {
    innermost = outer_;
    if (terminal_) show_line(outer_ ? status_text(outer_->what_, terminal_width()) : "");
}

std::string progress_line(const std::string& stage, double share, double seconds_left, int width) {
    share = std::clamp(share, 0.0, 1.0);
    const std::string end = fmt::format(" {:3.0f} %  {}", 100 * share, time_text(seconds_left));
    const int bar = std::clamp(width - 1 - 28 - 2 - 24, 0, 40);
    const int full = int(share * bar);
    std::string line = fmt::format("{:<26.26}  ", stage);
    if (bar > 0) line += "[" + std::string(full, '#') + std::string(bar - full, '.') + "]";
    return (line + end).substr(0, std::max(0, width - 1));
}

ProgressBar::ProgressBar(const frame::Plan& plan) : terminal_(isatty(STDERR_FILENO)) {
    for (const frame::PlannedStage& s : plan.stages) {
        if (!s.needed) continue;
        stage_[s.label] = {total_, s.expected_ms};
        total_ += s.expected_ms;
        if (s.samples > 0) samples_[s.label] = s.samples;
    }
    start_ = std::chrono::steady_clock::now();
    if (terminal_) show_line(progress_line("preparing the scene", 0, -1, terminal_width()));
}

ProgressBar::~ProgressBar() {
    if (terminal_) show_line("");
}

frame::Progress ProgressBar::callback() {
    if (!terminal_) return {};
    return [this](const std::string& label, double done) { show(label, done); };
}

void ProgressBar::show(const std::string& label, double done) {
    std::lock_guard lock(mutex_);
    const auto now = std::chrono::steady_clock::now();
    const bool new_stage = label != label_;
    if (!new_stage && now - last_ < std::chrono::milliseconds(50)) return;
    last_ = now;
    label_ = label;

    // The plan's expectation says how much of the frame is done; the clock says how fast this machine is.
    const auto [before, own] = stage_[label];
    furthest_ = std::max(furthest_, total_ > 0 ? (before + done * own) / total_ : 0);
    const double elapsed = std::chrono::duration<double>(now - start_).count();
    const double left = furthest_ > 0.01 && elapsed > 0.3 ? elapsed * (1 - furthest_) / furthest_ : -1;
    const auto samples = samples_.find(label);
    std::string what = label;
    if (samples != samples_.end()) what += fmt::format(" {}/{}", int(done * samples->second), samples->second);
    show_line(progress_line(what, furthest_, left, terminal_width()));
}

}  // namespace plumb::cli
