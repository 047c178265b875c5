#pragma once
// Coupling iterations as a fixed point. The structure moves under the load x, the fluid answers that motion with the load H(x); wanted is
// x = H(x). H changes little from window to window: what the iterations of the last windows have shown of it serves the next.

#include <deque>
#include <vector>

#include <Eigen/Core>

#include "scene/case_file.hpp"

namespace tern::coupler {

class FixedPoint {
 public:
  /// `tolerance`: of |H(x) - x| / |H(x)|; below a hundredth of the largest load of the run, over that.
  FixedPoint(Acceleration acceleration, double tolerance) : acceleration_(acceleration), tolerance_(tolerance) {}

  /// `gain`: how many times an error of the trial may come back in its answer, >= 1. `begin`: of the window, for messages [s].
  void begin_window(double gain, double begin);

  /// Takes note of the answer H(x) [N/m^(3-D)] to the trial x; true when no further trial is wanted. Throws NumericalFailure
  /// when the answer is not finite.
  bool add(const Eigen::VectorXd& trial, const Eigen::VectorXd& answer);

  /// The trial to make next, after add().
  Eigen::VectorXd next() { return acceleration_ == Acceleration::aitken ? aitken() : quasi_newton(); }

  int trials() const { return trials_; }         ///< of this window
  double residual() const { return residual_; }  ///< of the last trial, relative
  bool converged() const { return residual_ <= tolerance_; }

 private:
  Eigen::VectorXd quasi_newton();
  Eigen::VectorXd aitken() const;

  /// Of a trial; or how they change between two trials of a window.
  struct Outcome {
    Eigen::VectorXd residual, answer;
  };

  Acceleration acceleration_;
  double tolerance_;
  int trials_ = 0;
  double gain_ = 1, largest_gain_ = 1, begin_ = 0, residual_ = 0, factor_ = 1, largest_answer_ = 0;
  Outcome last_, base_;                               ///< of the last trial, and of the one that the next is built upon
  bool refused_ = false;                              ///< the last trial is not the base: it was worse
  Eigen::VectorXd first_trial_, first_trial_before_;  ///< of this window and of the one before; empty without trials
  Eigen::VectorXd expected_;                          ///< answer to the next trial, by what is known of H
  double unknown_ = 0;                                ///< size of that part of the step to it of which nothing is known
  std::deque<std::vector<Outcome>> changes_;          ///< of this window first, then of those before; of each the newest first
};

}  // namespace tern::coupler
