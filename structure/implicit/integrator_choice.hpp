#pragma once
// integrator = "auto": implicit steps where they are cheaper. What they cost is counted, not timed, so that a run has the same
// bits however busy the machine is.

namespace tern::structure {

/// What implicit steps of a structure cost, in its explicit sub-steps with diffusion.
struct ImplicitCosts {
  // 2D, measured by bench-structure_substep (docs/STRUCTURE.md), where they depend little on the body. 3D: implicit_costs().
  double evaluation = 1.8;  ///< of the elastic force, with one solve
  double factor = 50;       ///< assembled and factored tangent

  double of(double evaluations, double factors) const { return evaluation * evaluations + factor * factors; }
};

class IntegratorChoice {
 public:
  /// Whether a window of so many explicit sub-steps is cheaper in implicit steps. Now and then the more expensive way is
  /// tried again, for the motion may have become quieter.
  bool prefers_implicit(const ImplicitCosts& costs, int sub_steps) {
    ++windows_;
    return costs.of(evaluations_, factors_) * (windows_ % trial_interval == 0 ? 0.5 : 1) < sub_steps;
  }

  /// After a window in implicit steps, or a part of its passes: what it took. The first factor of all says nothing of how often one is
  /// needed. A factor serves many windows: charged to the one that made it, it would keep the others from having it.
  void add(long evaluations, long factors, bool first) {
    evaluations_ += (static_cast<double>(evaluations) - evaluations_) / memory;
    factors_ += (static_cast<double>(factors - first) - factors_) / windows_of_a_factor;
  }

  /// visit(name, member of each) for every member, as of a State.
  template <class Visit, class... Choices>
  static void for_each_field(Visit&& visit, Choices&... choice) {
    visit("evaluations_a_window", choice.evaluations_...);
    visit("factors_a_window", choice.factors_...);
    visit("windows", choice.windows_...);
  }

 private:
  static constexpr double memory = 10, windows_of_a_factor = 40;
  static constexpr long trial_interval = 50;
  // Running means of an implicit window. They begin as in quiet motion (docs/STRUCTURE.md).
  double evaluations_ = 10, factors_ = 1 / windows_of_a_factor;
  long windows_ = 0;
};

}  // namespace tern::structure
