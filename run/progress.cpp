// The progress line.

#include "run/progress.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

namespace tern {

namespace {

constexpr double terminal_interval_s = 0.2, plain_interval_s = 10.0;
constexpr double newest_weight = 0.3;  ///< of the latest interval in the shown rates

std::string duration_text(double seconds) {
  const long s = std::lround(seconds);
  if (s >= 3600) return fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60);
  return fmt::format("{}:{:02}", s / 60, s % 60);
}

}  // namespace

Progress::Progress(double end_time_s, bool quiet)
    : Progress(end_time_s, quiet, stdout, isatty(STDOUT_FILENO) == 1, isatty(STDOUT_FILENO) == 1 ? terminal_interval_s : plain_interval_s) {
}

Progress::Progress(double end_time_s, bool quiet, std::FILE* stream, bool terminal, double interval_s)
    : end_time_s_(end_time_s), quiet_(quiet), terminal_(terminal), stream_(stream), interval_s_(interval_s) {}

Progress::~Progress() {
  if (open_line_) {
    std::fputc('\n', stream_);
    std::fflush(stream_);
  }
}

void Progress::step(double t_s, long step, double dt_s, const std::string& limit, int iterations) {
  if (steps_before_ < 0) {
    printed_step_ = steps_before_ = step - 1;
    printed_t_s_ = t_s - dt_s;
  }
  t_s_ = t_s;
  step_ = step;
  dt_s_ = dt_s;
  iterations_ = iterations;
  const double elapsed = since_print_.seconds();
  // A terminal shows the first step at once: it is how a user sees that the run has started.
  if (quiet_ || (elapsed < interval_s_ && !(terminal_ && !printed_))) return;

  const auto smooth = [this](double& mean, double newest) { mean = mean > 0 ? mean + newest_weight * (newest - mean) : newest; };
  if (step_ > printed_step_) smooth(ms_per_step_, 1e3 * elapsed / static_cast<double>(step_ - printed_step_));
  if (t_s_ > printed_t_s_) smooth(wall_per_time_, elapsed / (t_s_ - printed_t_s_));
  print(line(limit));
  printed_t_s_ = t_s_;
  printed_step_ = step_;
  printed_ = true;
  since_print_.restart();
}

std::string Progress::line(const std::string& limit) const {
  const double percent = end_time_s_ > 0 ? std::min(100.0, 100.0 * t_s_ / end_time_s_) : 100.0;
  std::string text = fmt::format("t = {:.4f} s  {:.1f} %  step {}  dt {:.1e} s", t_s_, percent, step_, dt_s_);
  if (!limit.empty()) text += fmt::format(" ({})", limit);
  if (iterations_ >= 0) text += fmt::format("  CG {}", iterations_);
  if (ms_per_step_ > 0) text += fmt::format("  {:.3g} ms/step", ms_per_step_);
  const double remaining = std::max(0.0, end_time_s_ - t_s_);
  if (wall_per_time_ > 0) text += fmt::format("  ETA {}", duration_text(remaining * wall_per_time_));
  return text;
}

void Progress::print(const std::string& text) {
  if (terminal_) {
    // A line that wraps could not be taken back by a carriage return.
    winsize window = {};
    const bool known = ioctl(fileno(stream_), TIOCGWINSZ, &window) == 0 && window.ws_col > 1;
    const int width = known ? window.ws_col - 1 : static_cast<int>(text.size());
    std::fprintf(stream_, "\r%.*s\033[K", width, text.c_str());
    open_line_ = true;
  } else {
    std::fprintf(stream_, "%s\n", text.c_str());
  }
  std::fflush(stream_);
}

void Progress::finish(const std::string& ending) {
  if (quiet_ || finished_) return;
  finished_ = true;
  const double wall = wall_.seconds();
  std::string text = fmt::format("t = {:.4f} s  {}  {} steps  {} wall", t_s_, ending, step_, duration_text(wall));
  const long own = step_ - std::max(0L, steps_before_);
  if (own < step_) text += fmt::format(" since step {}", steps_before_);
  if (own > 0) text += fmt::format("  {:.3g} ms/step", 1e3 * wall / static_cast<double>(own));
  print(text);
  if (terminal_) std::fputc('\n', stream_);
  open_line_ = false;
  std::fflush(stream_);
}

}  // namespace tern
