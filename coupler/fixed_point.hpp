#pragma once
// Repetition of a window until both sides agree (CM3). A load x on the surface makes the structure move, the fluid answers that
// motion with the load H(x): wanted is x = H(x). H changes little from window to window, so what the trials of the last
// windows have shown of it serves the next.

#include <deque>
#include <vector>

#include <Eigen/Core>

#include "particles/case_file.hpp"

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
  Eigen::VectorXd next() const { return acceleration_ == Acceleration::aitken ? aitken() : quasi_newton(); }

  int trials() const { return trials_; }         ///< of this window
  double residual() const { return residual_; }  ///< of the last trial, relative
  bool converged() const { return residual_ <= tolerance_; }

 private:
  Eigen::VectorXd quasi_newton() const;
  Eigen::VectorXd aitken() const;

  /// How residual and answer change between two trials of a window.
  struct Change {
    Eigen::VectorXd residual, answer;
  };

  Acceleration acceleration_;
  double tolerance_;
  int trials_ = 0;
  double gain_ = 1, begin_ = 0, residual_ = 0, factor_ = 1, largest_answer_ = 0;
  Eigen::VectorXd last_residual_, last_answer_;
  std::deque<std::vector<Change>> changes_;  ///< of this window first, then of those before; of each the newest first
};

}  // namespace tern::coupler
