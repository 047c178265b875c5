#pragma once
// What an implicit step leaves to the next one (implicit_step.cpp).

#include <Eigen/Core>
#include <array>
#include <vector>

#include "structure/state.hpp"

namespace tern::structure {

/// What implicit steps did, for reports and tests.
struct ImplicitCounts {
  long steps = 0;        ///< completed
  long failed = 0;       ///< given up, to be repeated in shorter ones
  long evaluations = 0;  ///< of the internal force
  long factors = 0;      ///< assembled and factored tangents

  /// The list of the members: visit(name, member of each) for every one.
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("steps", all.steps...);
    visit("failed", all.failed...);
    visit("evaluations", all.evaluations...);
    visit("factors", all.factors...);
  }
};

/// A step of the quasi-Newton method: `moved` of d, `change` of minus the residual, `product` = moved . change > 0.
struct QuasiNewtonUpdate {
  Eigen::VectorXd moved, change;
  double product;

  /// The list of the members: visit(name, member of each) for every one.
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("moved", all.moved...);
    visit("change", all.change...);
    visit("product", all.product...);
  }
};

/// What one step leaves to the next. The factor is not copied: it is made again, with the same bits, from where it was made.
template <int D>
struct ImplicitMemory {
  std::array<Eigen::VectorXd, 2> bend;  ///< how far the last step bent away from a straight line [m], in both parts; empty when it failed
  double bend_dt = 0;                   ///< its length [s]
  double factored_h = 0;                ///< of the present factor [s]; 0 = none
  RowVectors<D> factored_displacement;  ///< at which it was made [m]; empty = none
  std::vector<double> factored_clamp_angle;  ///< and State::clamp_angle there [rad]
  double excess = 0;                         ///< iterations since it was made beyond those a new one needs
  std::vector<QuasiNewtonUpdate> updates;    ///< kept while the factor is, the oldest first
  ImplicitCounts counts;

  /// visit(name, member of each) for every member, as of a State.
  template <class Visit, class... Memories>
  static void for_each_field(Visit&& visit, Memories&... memory) {
    visit("bend", memory.bend...);
    visit("bend_dt", memory.bend_dt...);
    visit("factored_h", memory.factored_h...);
    visit("factored_displacement", memory.factored_displacement...);
    visit("factored_clamp_angle", memory.factored_clamp_angle...);
    visit("excess", memory.excess...);
    visit("updates", memory.updates...);
    visit("counts", memory.counts...);
  }
};

}  // namespace tern::structure
