#pragma once
// integrator = "auto": implicit steps where they are cheaper. What they cost is counted, not timed, so that a run has the same
// bits however busy the machine is.

#include <algorithm>

namespace tern::structure {

/// What implicit steps of a structure cost, in its explicit sub-steps with diffusion.
struct ImplicitCosts {
  // 2D, measured by bench-structure_substep (docs/STRUCTURE.md), where they depend little on the body. 3D: implicit_costs().
  double evaluation = 1.8;  ///< of the elastic force, with one solve
  double factor = 50;       ///< assembled and factored tangent
  double window = 20;       ///< in quiet motion

  double of(long evaluations, long factors) const {
    return evaluation * static_cast<double>(evaluations) + factor * static_cast<double>(factors);
  }
};

class IntegratorChoice {
 public:
  IntegratorChoice() = default;
  explicit IntegratorChoice(const ImplicitCosts& costs) : cost_(costs.window) {}

  /// Whether a window of so many explicit sub-steps is cheaper in implicit steps. Now and then the more expensive way is
  /// tried again, for the motion may have become quieter.
  bool prefers_implicit(int sub_steps) {
    ++windows_;
    return cost_ * (windows_ % trial_interval == 0 ? 0.5 : 1) < sub_steps;
  }

  /// After a window in implicit steps: what it took, in explicit sub-steps.
  void add(double spent) { cost_ += (spent - cost_) / memory; }

  /// Of an implicit window, in explicit sub-steps; running mean.
  double cost() const { return cost_; }

  /// visit(name, member of each) for every member, as of a State.
  template <class Visit, class... Choices>
  static void for_each_field(Visit&& visit, Choices&... choice) {
    visit("cost", choice.cost_...);
    visit("windows", choice.windows_...);
  }

 private:
  static constexpr double memory = 10;
  static constexpr long trial_interval = 50;
  double cost_ = ImplicitCosts{}.window;
  long windows_ = 0;
};

}  // namespace tern::structure
