#pragma once
// An implicit time step for stiff or finely resolved bodies: TR-BDF2 (Bank and others 1985; Hosea and Shampine 1996), two
// equations of the same matrix per step, second order, without damping of what the step resolves, and strong damping of what
// it does not. Each is solved by a Newton method whose factor is that of an earlier state, improved by the BFGS formula
// (Matthies and Strang 1979) and renewed when it no longer serves.

#include <vector>

#include "structure/implicit/tangent.hpp"

namespace tern::structure {

/// What implicit steps did, for reports and tests.
struct ImplicitCounts {
  long steps = 0;        ///< completed
  long failed = 0;       ///< given up, to be repeated in shorter ones
  long evaluations = 0;  ///< of the internal force
  long factors = 0;      ///< assembled and factored tangents
};

template <int D>
class ImplicitStep {
 public:
  explicit ImplicitStep(const Reference<D>& reference) : tangent_(reference) {}

  /// Advances the state by `dt` [s] under work.external_force, with the internal force of elasticity alone; clamped particles
  /// move with their velocity. Returns false, with the state as it was, when Newton's method does not converge.
  bool advance(const Reference<D>& reference, double dt, State<D>& state, Workspace<D>& work);

  const ImplicitCounts& counts() const { return counts_; }

 private:
  /// Solves M (d - predictor)/h^2 - f(d) = constant, from the d in `state` on; leaves d and f(d) there.
  bool solve(const Reference<D>& reference, double h, const Eigen::VectorXd& predictor, const Eigen::VectorXd& constant, State<D>& state,
             Workspace<D>& work);

  /// The quasi-Newton step for a residual.
  Eigen::VectorXd step_for(const Eigen::VectorXd& residual);

  struct Update {
    Eigen::VectorXd moved, change;  // of d, and of minus the residual
    double product;                 // moved . change > 0
  };

  Tangent<D> tangent_;
  /// First guess of a part of the step: where its begin and its velocity lead, bent as in the last step. A window that is
  /// repeated under another load, and the next one, accelerate much as that did.
  Eigen::VectorXd guess(int part, double dt, const Eigen::VectorXd& straight) const;

  /// How far the last step bent away from a straight line [m], in both of its parts; empty when it failed.
  Eigen::VectorXd bend_[2];
  double bend_dt_ = 0;           // its length [s]
  double factored_h_ = 0;        // of the present factor; 0 = none
  double excess_ = 0;            // iterations since it was made beyond those a new one needs
  std::vector<Update> updates_;  // of the present solve
  ImplicitCounts counts_;
};

}  // namespace tern::structure
