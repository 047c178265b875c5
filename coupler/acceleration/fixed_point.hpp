#pragma once
// Coupling iterations as a fixed point. The structure moves under the load x, the fluid answers that motion with the load H(x); wanted is
// x = H(x). H changes little from window to window: what the iterations of the last windows have shown of it serves the next.

#include <deque>
#include <vector>

#include <Eigen/Core>

namespace tern::coupler {

class FixedPoint {
 public:
  /// `tolerance`: of |H(x) - x| / |H(x)|; below a hundredth of the largest load of the run, over that. `most`: iterations of a window.
  FixedPoint(double tolerance, int most) : tolerance_(tolerance), most_(most) {}

  /// `gain`: how many times an error of the load may come back in its answer, >= 1. `begin`: of the window, for messages [s].
  void begin_window(double gain, double begin);

  /// Takes note of the answer H(x) [N/m^(3-D)] to the load x; true when no further iteration is wanted. Throws NumericalFailure
  /// when the answer is not finite, or when the last iteration still changes the load by a twentieth.
  bool add(const Eigen::VectorXd& load, const Eigen::VectorXd& answer);

  /// The load to try next, after add().
  Eigen::VectorXd next();

  int iterations() const { return iterations_; }  ///< of this window
  double residual() const { return residual_; }   ///< of the last iteration, relative
  bool converged() const { return residual_ <= tolerance_; }

  /// The list of what it has learnt: visit(name, member of each) for every one.
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("iterations", all.iterations_...);
    visit("gain", all.gain_...);
    visit("largest_gain", all.largest_gain_...);
    visit("begin", all.begin_...);
    visit("residual", all.residual_...);
    visit("largest_answer", all.largest_answer_...);
    visit("base", all.base_...);
    visit("refused", all.refused_...);
    visit("first_load", all.first_load_...);
    visit("first_load_before", all.first_load_before_...);
    visit("expected", all.expected_...);
    visit("unknown", all.unknown_...);
    visit("changes", all.changes_...);
  }

 private:
  /// Of an iteration; or how they change between two iterations of a window.
  struct Outcome {
    Eigen::VectorXd residual, answer;

    /// The list of the members: visit(name, member of each) for every one.
    template <class Visit, class... Same>
    static void for_each_field(Visit&& visit, Same&... all) {
      visit("residual", all.residual...);
      visit("answer", all.answer...);
    }
  };

  double tolerance_;
  int most_;
  int iterations_ = 0;
  double gain_ = 1, largest_gain_ = 1, begin_ = 0, residual_ = 0, largest_answer_ = 0;
  Outcome base_;                                    ///< of the iteration that the next is built upon
  bool refused_ = false;                            ///< that is not the last one: it was worse
  Eigen::VectorXd first_load_, first_load_before_;  ///< of this window and of the one before; empty without iterations
  Eigen::VectorXd expected_;                        ///< answer to the next load, by what is known of H
  double unknown_ = 0;                              ///< size of that part of the step to it of which nothing is known
  std::deque<std::vector<Outcome>> changes_;        ///< of this window first, then of those before; of each the newest first
};

}  // namespace tern::coupler
