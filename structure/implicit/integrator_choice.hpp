#pragma once
// integrator = "auto": implicit steps where they are cheaper. What they cost is counted, not timed, so that a run has the same
// bits however busy the machine is.

#include <algorithm>

namespace tern::structure {

class IntegratorChoice {
 public:
  /// Whether a window of so many explicit sub-steps is cheaper in implicit steps. Now and then the more expensive way is
  /// tried again, for the motion may have become quieter.
  bool prefers_implicit(int sub_steps) {
    ++windows_;
    return cost_ * (windows_ % trial_interval == 0 ? 0.5 : 1) < sub_steps;
  }

  /// After a window in implicit steps: what it took.
  void add(long evaluations, long factors) {
    const double spent = cost_of_an_evaluation * static_cast<double>(evaluations) + cost_of_a_factor * static_cast<double>(factors);
    cost_ += (spent - cost_) / memory;
  }

  /// Of an implicit window, in explicit sub-steps; running mean.
  double cost() const { return cost_; }

  /// visit(name, member of each) for every member, as of a State.
  template <class Visit, class... Choices>
  static void for_each_field(Visit&& visit, Choices&... choice) {
    visit("cost", choice.cost_...);
    visit("windows", choice.windows_...);
  }

 private:
  // In explicit sub-steps with diffusion, 2D, measured by bench-structure_substep (docs/STRUCTURE.md). An evaluation goes with
  // one solve.
  static constexpr double cost_of_an_evaluation = 1.8, cost_of_a_factor = 50, memory = 10;
  static constexpr long trial_interval = 50;
  double cost_ = 20;
  long windows_ = 0;
};

}  // namespace tern::structure
