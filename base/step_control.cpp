#include "base/step_control.hpp"

#include <algorithm>
#include <cmath>

namespace tern {
namespace {

constexpr double largest_growth = 1.1;   ///< per step
constexpr double largest_stretch = 1.1;  ///< of a proposal, to meet a time
constexpr int steps_ahead = 10;          ///< a time this near is met by equal steps
constexpr int patience = 100;  ///< windows at a share of their length, before it doubles: some times as many as had to be repeated

}  // namespace

void StepControl::shorten(int halvings, Ticks until, double longest) {
  halvings_ = halvings;
  until_ = until;
  longest_ = longest;
  windows_ = 0;
}

Ticks StepControl::next(double proposed_seconds, Ticks now, Ticks target) {
  crawling_ = proposed_seconds < seconds(10) ? crawling_ + 1 : 0;
  if (halvings_ > 0 && now >= until_ && ++windows_ > patience) shorten(halvings_ - 1, until_, 2 * longest_);
  double step = proposed_seconds;
  if (halvings_ > 0) step = std::min(step, halvings_ == 1 ? std::max(longest_, fastest_shortening * previous_) : longest_);
  // By a tick at least: a tenth of few ticks is none.
  if (previous_ > 0) step = std::min(step, std::max(largest_growth * previous_, previous_ + seconds(1)));
  const double remaining = seconds(target - now);
  const double count = std::max(1.0, std::ceil(remaining / (largest_stretch * step)));
  Ticks ticks;
  if (count <= 1) {
    ticks = target - now;
  } else if (count <= steps_ahead) {
    ticks = to_ticks(remaining / count);
  } else {
    ticks = to_ticks(step);
  }
  ticks = std::clamp<Ticks>(ticks, 1, target - now);
  previous_ = seconds(ticks);
  return ticks;
}

}  // namespace tern
