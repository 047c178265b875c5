#include "coupler/load_alternation.hpp"

#include <algorithm>
#include <utility>

namespace tern::coupler {
namespace {

constexpr double opposite = -0.9;  ///< cosine of the angle between two kinks; white noise of many points has -2/3
constexpr double growth = 1.5, tenth = 0.1;

}  // namespace

bool LoadAlternation::add(const Eigen::VectorXd& load, double least) {
  if (last_.size() != load.size()) {
    last_ = load;
    return false;
  }
  const Eigen::VectorXd change = load - last_;
  mean_ = (load + last_).norm() / 2;
  last_ = load;
  const Eigen::VectorXd before = std::exchange(change_, change);
  if (before.size() == 0) return false;
  const Eigen::VectorXd kink = change - before, kink_before = std::exchange(kink_, kink);
  if (kink_before.size() > 0 && !(kink.dot(kink_before) < opposite * kink.norm() * kink_before.norm())) amplitudes_.clear();
  amplitudes_.push_back(amplitude());
  if (amplitudes_.size() > 2 * reversals + 1) amplitudes_.pop_front();
  const double now = amplitudes_.back();
  if (amplitudes_.size() <= reversals || now < least) return false;
  const double before_them = amplitudes_[amplitudes_.size() - 1 - reversals];
  if (now > mean_ && now >= *std::max_element(amplitudes_.end() - 1 - reversals, amplitudes_.end())) return true;
  return amplitudes_.size() > 2 * reversals && before_them >= growth * amplitudes_.front() && now >= growth * before_them && now > tenth * mean_;
}

}  // namespace tern::coupler
