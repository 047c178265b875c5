// IQN-ILS (Degroote, Bathe & Vierendeels 2009).

#include "coupler/acceleration/fixed_point.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "base/error.hpp"

namespace tern::coupler {
namespace {

constexpr std::size_t reused_windows = 8;
constexpr std::size_t most_changes = 40;   ///< that one load is made of; a fit to more costs more than an iteration
constexpr double least_load = 0.01;        ///< that counts, over the largest of the run
constexpr double largest_residual = 0.05;  ///< with which a window may end after the last iteration
/// A change is used if at least this part of it is no combination of newer changes.
constexpr double least_new_part = 1e-3;
/// The same for a change of an earlier window. Since then H has changed, by some tenths where a particle came in touch. What is left of
/// an old change after the newer ones are taken out has the error of all of it.
constexpr double least_new_part_of_old = 0.3;
/// If the first residual exceeds this, most of the answer is error: the load is extrapolated linearly from the last two windows.
constexpr double mostly_error = 0.5;
/// The part of an answer by which it may change for what is not yet known of H. A load far off can break the structure.
constexpr double largest_surprise = 0.3;
/// After this part of the iterations of a window contacts are given. Nearly all windows that agree with contacts free take fewer.
constexpr double contacts_end = 0.6;

}  // namespace

void FixedPoint::Bounds::add(double load, double residual) {
  if (residual > 0) {
    low = load;
    residual_low = residual;
    if (high <= low) high = unknown;
  } else if (residual < 0) {
    high = load;
    residual_high = residual;
    if (low >= high) low = residual_low = 0;
  }
}

double FixedPoint::Bounds::estimate() const {
  if (residual_low == 0) return 0;  // nothing has been too little
  if (high == unknown) return std::max(0.0, low + residual_low);
  return std::max(0.0, low + residual_low / (residual_low - residual_high) * (high - low));
}

void FixedPoint::begin_window(double gain, double begin) {
  begin_ = begin;
  iterations_ = 0;
  residual_ = 0;
  gives_contacts_ = false;
  gain_ = largest_gain_ = gain;
  unknown_ = 0;
  first_load_before_ = std::exchange(first_load_, {});
  if (!changes_.empty() && changes_.front().empty()) return;
  changes_.emplace_front();
  if (changes_.size() > reused_windows + 1) changes_.pop_back();
}

bool FixedPoint::add(const Eigen::VectorXd& load, const Eigen::VectorXd& answer, Eigen::Index contacts) {
  const Eigen::VectorXd residual = answer - load;
  const double size = answer.norm();
  if (++iterations_ == 1) bounds_.assign(static_cast<std::size_t>(contacts), {});
  if (!gives_contacts())
    for (Eigen::Index c = 0, at = load.size() - contacts; c < contacts; ++c, ++at)
      bounds_[static_cast<std::size_t>(c)].add(load[at], residual[at]);
  if (!std::isfinite(size) || !std::isfinite(residual.norm()))
    throw NumericalFailure(
        fmt::format("The load on the surface is not finite in coupling iteration {} of the window from t = {:.6g} s: the coupling "
                    "iterations have run away. Try a smaller fluid.numerics.courant.",
                    iterations_, begin_));
  if (iterations_ == 1) {
    first_load_ = load;
  } else {
    changes_.front().insert(changes_.front().begin(), {residual - base_.residual, answer - base_.answer});
    // The largest gains show first: what is still unknown has hardly more than what has been found last.
    if (unknown_ > 0) gain_ = std::clamp((answer - expected_).norm() / unknown_, 1.0, largest_gain_);
  }
  // An iteration that is worse than its base is learned from but not built upon. A second one in a row is, or iterations go in circles.
  refused_ = iterations_ > 1 && !refused_ && residual.norm() >= base_.residual.norm();
  if (!refused_) base_ = {residual, answer};
  // Where there is next to no load, the residual is measured by the largest load of the run: the last digits of the pressure solve differ.
  largest_answer_ = std::max(largest_answer_, size);
  residual_ = largest_answer_ > 0 ? residual.norm() / std::max(size, least_load * largest_answer_) : residual.norm() > 0 ? 1 : 0;
  if (iterations_ == most_ && !(residual_ <= largest_residual))
    throw NumericalFailure(
        fmt::format("Fluid and structure do not agree on the load after {} coupling iterations of the window from t = {:.6g} s: it changes "
                    "by {:.2g} of itself "
                    "from one to the next, at most {:g} is accepted. A body is too light and too soft for windows this long; use a smaller "
                    "fluid.numerics.gravity_courant and "
                    "courant, or a thicker body.",
                    iterations_, begin_, residual_, largest_residual));
  return converged() || iterations_ == most_;
}

Eigen::VectorXd FixedPoint::next() {
  unknown_ = 0;
  if (iterations_ == 1 && residual_ > mostly_error && first_load_before_.size() == first_load_.size() && first_load_before_ != first_load_)
    return 2 * first_load_ - first_load_before_;  // as the load went on before
  std::vector<Given> given;
  if (iterations_ >= contacts_end * most_ && std::any_of(bounds_.begin(), bounds_.end(), [](const Bounds& b) { return b.is_met(); })) {
    gives_contacts_ = true;
    Eigen::Index at = base_.answer.size() - static_cast<Eigen::Index>(bounds_.size());
    for (const Bounds& bounds : bounds_) given.push_back({at++, bounds.estimate()});
  }
  return step(given);
}

Eigen::VectorXd FixedPoint::step(const std::vector<Given>& given) {
  // Least squares for the combination of changes that takes the residual away, by Gram-Schmidt, the newest change first. The
  // changes of the answers are combined alike, so that no triangular system is left to be solved.
  std::vector<Outcome> basis;
  std::vector<double> shares;  // of the basis in a change
  Eigen::VectorXd residual = base_.residual, answer = base_.answer;
  // What is given differs from that by its load, the answer less the residual.
  for (const auto& [c, load] : given) residual[c] = load - (answer[c] - residual[c]);
  for (const auto& window : changes_)
    for (const Outcome& change : window) {
      if (basis.size() == most_changes) break;
      Outcome part{change.residual, {}};
      for (const auto& [c, load] : given) part.residual[c] -= change.answer[c];
      double left2 = part.residual.squaredNorm();
      const double least = (&window == &changes_.front() ? least_new_part : least_new_part_of_old) * std::sqrt(left2);
      // Most are no news, and most of these show it before they are held against the whole basis.
      bool is_new = true;
      shares.clear();
      for (int pass = 0; pass < 2 && is_new; ++pass)
        for (const Outcome& known : basis) {
          const double share = known.residual.dot(part.residual);
          part.residual -= share * known.residual;
          shares.push_back(share);
          left2 -= share * share;
          is_new = left2 > 0.9 * least * least;  // not 1: rounding
          if (!is_new) break;
        }
      const double size = is_new ? part.residual.norm() : 0;
      if (!(size > least)) continue;
      part.answer = change.answer;
      for (std::size_t m = 0; m < shares.size(); ++m) part.answer -= shares[m] * basis[m % basis.size()].answer;
      part.residual /= size;
      part.answer /= size;
      const double share = part.residual.dot(residual);
      residual -= share * part.residual;
      answer -= share * part.answer;
      basis.push_back(std::move(part));
    }
  // The rest of the residual is where nothing is known of H: it comes back up to `gain` times.
  const double rest = residual.norm(), most = largest_surprise * std::max(base_.answer.norm(), least_load * largest_answer_) / gain_;
  unknown_ = std::min(rest, most);
  expected_ = answer;
  if (rest > most) answer += (most / rest - 1) * residual;
  for (const auto& [c, load] : given) answer[c] = load;
  return answer;
}

}  // namespace tern::coupler
