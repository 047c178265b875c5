#include "coupler/stability/load_alternation.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tern::coupler {
namespace {

constexpr double opposite = -0.9;  ///< cosine of the angle between two kinks; white noise of many points has -2/3
constexpr double growth = 1.5, tenth = 0.1;
constexpr double least_doubling = 2;  ///< of a vibration over the kinks that it has been seen in
/// Of the kinks of a vibration, how much may be something else (squares); white noise of many points leaves 0.4.
constexpr double most_of_others = 0.1;

void keep(std::deque<Eigen::VectorXd>& last, const Eigen::VectorXd& values) {
  last.push_back(values);
  if (last.size() > LoadAlternation::vibration + 2) last.pop_front();
}

}  // namespace

bool LoadAlternation::is_growing_vibration(double least) {
  if (kinks_.size() < vibration + 2) return false;
  // The best a_{n+1} = p a_n - q a_{n-1}.
  double nn = 0, nb = 0, bb = 0, na = 0, ba = 0, aa = 0;
  for (std::size_t n = 1; n + 1 < kinks_.size(); ++n) {
    const auto &before = kinks_[n - 1], &now = kinks_[n], &after = kinks_[n + 1];
    nn += now.dot(now), nb += now.dot(before), bb += before.dot(before);
    na += now.dot(after), ba += before.dot(after), aa += after.dot(after);
  }
  const double determinant = nn * bb - nb * nb;
  if (!(determinant > 0)) return false;
  const double p = (na * bb - ba * nb) / determinant, q = -(ba * nn - na * nb) / determinant;
  const double others = aa - p * na + q * ba;
  // Roots r exp(+-i theta), theta beyond a quarter of a turn.
  if (!(p < 0 && p * p <= 4 * q && others < most_of_others * aa && std::pow(q, 0.5 * vibration) >= least_doubling)) return false;
  // That growth from the first half of them to the second, so that it is not a blow and its echo.
  double early = 0, late = 0;
  for (std::size_t n = 0; n < kinks_.size(); ++n) (n < kinks_.size() / 2 ? early : late) += kinks_[n].squaredNorm();
  if (late > 2 * std::pow(q, 0.5 * vibration) * early) return false;
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(loads_.front().size());
  for (const auto& load : loads_) sum += load;
  const double mean = sum.norm() / static_cast<double>(loads_.size());
  // A cos(n theta) has the kinks 2 (1 - cos theta) A cos(n theta), half of whose square is the mean.
  const double amplitude = std::sqrt(2 * aa / vibration) / (2 - p / std::sqrt(q));
  if (amplitude < std::max(least, mean)) return false;
  amplitude_ = amplitude;
  mean_ = mean;
  return true;
}

bool LoadAlternation::add(const Eigen::VectorXd& load, double least) {
  if (last_.size() != load.size()) {
    last_ = load;
    return false;
  }
  keep(loads_, load);
  double squares = (load + last_).squaredNorm();
  for (std::size_t n = 1; n + 1 < loads_.size(); ++n) squares += (loads_[n] + loads_[n - 1]).squaredNorm();
  mean_ = std::sqrt(squares / static_cast<double>(std::max<std::size_t>(loads_.size() - 1, 1))) / 2;
  const Eigen::VectorXd change = load - last_;
  last_ = load;
  const Eigen::VectorXd before = std::exchange(change_, change);
  if (before.size() == 0) return false;
  const Eigen::VectorXd kink = change - before, kink_before = std::exchange(kink_, kink);
  if (kink_before.size() > 0 && !(kink.dot(kink_before) < opposite * kink.norm() * kink_before.norm())) amplitudes_.clear();
  keep(kinks_, kink_);
  amplitude_ = kink_.norm() / 4;
  amplitudes_.push_back(amplitude_);
  if (amplitudes_.size() > 2 * reversals + 1) amplitudes_.pop_front();
  const double now = amplitudes_.back();
  if (is_growing_vibration(least)) return true;
  if (amplitudes_.size() <= reversals || now < least) return false;
  const double before_them = amplitudes_[amplitudes_.size() - 1 - reversals];
  if (now > mean_ && now >= *std::max_element(amplitudes_.end() - 1 - reversals, amplitudes_.end())) return true;
  return amplitudes_.size() > 2 * reversals && before_them >= growth * amplitudes_.front() && now >= growth * before_them &&
         now > tenth * mean_;
}

}  // namespace tern::coupler
