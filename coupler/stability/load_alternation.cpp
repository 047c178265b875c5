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

template <class Value>
void keep(std::deque<Value>& last, const Value& values) {
  last.push_back(values);
  if (last.size() > LoadAlternation::vibration + 2) last.pop_front();
}

}  // namespace

bool LoadAlternation::is_growing_vibration(double least) {
  if (squares_.size() < vibration + 2) return false;
  // The best a_{n+1} = p a_n - q a_{n-1}.
  double nn = 0, nb = 0, bb = 0, na = 0, ba = 0, aa = 0;
  for (std::size_t n = 1; n + 1 < squares_.size(); ++n) {
    nn += squares_[n], nb += products_[n], bb += squares_[n - 1];
    na += products_[n + 1], ba += second_products_[n + 1], aa += squares_[n + 1];
  }
  const double determinant = nn * bb - nb * nb;
  if (!(determinant > 0)) return false;
  const double p = (na * bb - ba * nb) / determinant, q = -(ba * nn - na * nb) / determinant;
  const double others = aa - p * na + q * ba;
  // Roots r exp(+-i theta), theta beyond a quarter of a turn.
  if (!(p < 0 && p * p <= 4 * q && others < most_of_others * aa && std::pow(q, 0.5 * vibration) >= least_doubling)) return false;
  // That growth from the first half of them to the second, so that it is not a blow and its echo.
  double early = 0, late = 0;
  for (std::size_t n = 0; n < squares_.size(); ++n) (n < squares_.size() / 2 ? early : late) += squares_[n];
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
  keep(sums_, (load + last_).squaredNorm());
  double squares = sums_.back();
  for (std::size_t n = 1; n + 1 < sums_.size(); ++n) squares += sums_[n];
  mean_ = std::sqrt(squares / static_cast<double>(std::max<std::size_t>(loads_.size() - 1, 1))) / 2;
  Eigen::VectorXd change = load - last_;
  last_ = load;
  change_.swap(change);  // now of the window before
  if (change.size() == 0) return false;
  second_before_ = std::move(kink_before_);
  kink_before_ = std::move(kink_);
  kink_ = change_ - change;
  const auto product = [&](const Eigen::VectorXd& other) { return other.size() > 0 ? kink_.dot(other) : 0; };
  const double square = kink_.squaredNorm(), with_before = product(kink_before_);
  if (kink_before_.size() > 0 && !(with_before < opposite * std::sqrt(square) * std::sqrt(squares_.back()))) amplitudes_.clear();
  keep(squares_, square);
  keep(products_, with_before);
  keep(second_products_, product(second_before_));
  amplitude_ = std::sqrt(square) / 4;
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
