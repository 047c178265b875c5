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

/// How often a factor is needed cannot be known before: it serves a thousand windows or one. Implicit steps are therefore taken on credit.
/// A ledger has what they have cost more than explicit ones would have, factors included; what they save pays it off. Where it exceeds two
/// factors, explicit steps follow that cost as much, and every time that nothing was paid off in between, twice as much. So neither way
/// can cost much more than the cheaper one, whatever the motion does.
class IntegratorChoice {
 public:
  /// Whether a window of so many explicit sub-steps is to be done in implicit steps. Now and then the way that seems more expensive is
  /// tried, for the motion may have become quieter.
  bool prefers_implicit(const ImplicitCosts& costs, int sub_steps) {
    ++windows_;
    if (pause_ > 0) {
      pause_ -= sub_steps;
      return false;
    }
    return costs.of(evaluations_, 1 / windows_of_a_factor) * (windows_ % trial_interval == 0 ? 0.5 : 1) < sub_steps;
  }

  /// After a window of so many explicit sub-steps in implicit steps, or a part of its passes: what it took.
  void add(const ImplicitCosts& costs, int sub_steps, long evaluations, long factors) {
    evaluations_ += (static_cast<double>(evaluations) - evaluations_) / memory;
    debt_ += costs.of(static_cast<double>(evaluations), static_cast<double>(factors)) - sub_steps;
    if (debt_ <= 0) {
      debt_ = 0;
      length_ = 1;
    } else if (debt_ > credit * costs.factor) {
      pause_ = length_ * debt_;
      debt_ = 0;
      length_ = length_ < longest ? 2 * length_ : length_;
    }
  }

  /// visit(name, member of each) for every member, as of a State.
  template <class Visit, class... Choices>
  static void for_each_field(Visit&& visit, Choices&... choice) {
    visit("evaluations_a_window", choice.evaluations_...);
    visit("debt", choice.debt_...);
    visit("pause", choice.pause_...);
    visit("length_of_a_pause", choice.length_...);
    visit("windows", choice.windows_...);
  }

 private:
  static constexpr double memory = 10, windows_of_a_factor = 40;  // in quiet motion (docs/STRUCTURE.md)
  static constexpr double credit = 2;                             // factors: the one that begins, and another
  static constexpr double longest = 16;
  static constexpr long trial_interval = 50;
  double evaluations_ = 10;      // running mean of an implicit window; as in quiet motion
  double debt_ = 0, pause_ = 0;  // in explicit sub-steps
  double length_ = 1;            // of the next pause, over the debt
  long windows_ = 0;
};

}  // namespace tern::structure
