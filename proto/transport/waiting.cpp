// See waiting.hpp. The log is told at 5, 10, 20, 40 ... s so that a long wait stays visible without filling the log.

#include "proto/transport/waiting.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/error.hpp"
#include "base/interrupt.hpp"
#include "base/log.hpp"
#include "proto/transport/silence.hpp"
#include "proto/wire/names.hpp"

namespace tern::proto {

namespace {

constexpr double first_log_s = 5;

/// Since any wait of this process has noticed a signal [s].
double since_interrupt() {
  static const auto noticed = std::chrono::steady_clock::now();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - noticed).count();
}

}  // namespace

Waiting::Waiting(std::string who, std::string whom, std::uint64_t step, double time_s, double deadline_s)
    : who_(std::move(who)), whom_(std::move(whom)), step_(step), time_s_(time_s), deadline_s_(deadline_s) {}

void Waiting::check() {
  if (interrupted() && since_interrupt() >= patience_s_)
    throw_if_interrupted(fmt::format("while waiting for {} {}", whom_, where(step_, time_s_)).c_str());
  const auto now = std::chrono::steady_clock::now();
  present_s_ += std::min(std::chrono::duration<double>(now - std::exchange(checked_, now)).count(), longest_turn_s);
  if (present_s_ > deadline_s_)
    throw PeerLost(
        fmt::format("The {} process waited {:.3g} s for {} {} and gave up: it is stuck, was never started, or uses "
                    "another endpoint. Look into its log.",
                    who_, present_s_, whom_, where(step_, time_s_)));
  if (present_s_ >= next_log_s_) {
    const std::string since = step_ == 0 ? "the start" : fmt::format("step {}", step_);
    log_warning(fmt::format("{} waits for {} since {} ({:.0f} s)", who_, whom_, since, present_s_));
    next_log_s_ = next_log_s_ < first_log_s ? first_log_s : 2 * next_log_s_;
    spoken_ = true;
  }
}

void Waiting::speak_after(double seconds) {
  if (!spoken_) next_log_s_ = seconds;
}

}  // namespace tern::proto
