#pragma once
// An implicit time step for stiff or finely resolved bodies: TR-BDF2 (Bank and others 1985; Hosea and Shampine 1996), two
// equations of the same matrix per step, second order, without damping of what the step resolves, and strong damping of what
// it does not. Each is solved by a Newton method whose factor is that of an earlier state, improved by the BFGS formula
// (Matthies and Strang 1979) and renewed when it no longer serves.

#include "structure/implicit/implicit_memory.hpp"
#include "structure/implicit/integrator_choice.hpp"
#include "structure/implicit/tangent.hpp"

namespace tern::structure {

/// What a solve and a factor cost is counted from the pattern of the factor. In 3D both grow faster than the number of particles.
template <int D>
ImplicitCosts implicit_costs(const Reference<D>& reference, const Tangent<D>& tangent);

template <int D>
class ImplicitStep {
 public:
  explicit ImplicitStep(const Reference<D>& reference);

  const ImplicitCosts& costs() const { return costs_; }

  /// Advances the state by `dt` [s] from the time `begin` [s] under state.external_force, with the internal force of elasticity alone;
  /// clamps stand in their places at both stages. Returns false, with the state as it was, when Newton's method does not converge.
  bool advance(const Reference<D>& reference, double begin, double dt, State<D>& state, Workspace<D>& work);

  const ImplicitMemory<D>& memory() const { return memory_; }

  /// Goes on as the step would that has left `memory`; makes its factor again. `state` and `work` serve to do so: the workspace
  /// then holds the derivatives of another state.
  void set_memory(const Reference<D>& reference, const ImplicitMemory<D>& memory, State<D> state, Workspace<D>& work);

 private:
  /// Solves M (d - predictor)/h^2 - f(d) = constant, from the d in `state` on; leaves d and f(d) there. `speed`: largest component of a
  /// velocity at the begin of the step [m/s].
  bool solve(const Reference<D>& reference, double h, double speed, const Eigen::VectorXd& predictor, const Eigen::VectorXd& constant,
             State<D>& state, Workspace<D>& work);

  /// Makes the tangent and its factor at the deformation in `work`, that of `state`; false when that is not possible.
  bool renew(const Reference<D>& reference, double h, const State<D>& state, const Workspace<D>& work);

  /// A body that nothing holds, and its mean turn since the factor was made. A turned body has the turned tangent, R K R^T, so the factor
  /// and the updates serve in the frame that turns with it. Without that, what turns a stiff body seems to strain it, and a turn by
  /// 1/(omega h) outdates the factor.
  struct LooseBody {
    std::size_t first, count;  ///< among the free rows
    Matrix<D> turn;
  };
  void find_turns(const Reference<D>& reference, const State<D>& state);
  /// A vector in the frame of the factor (`back`), or one of that frame in space.
  Eigen::VectorXd turned(Eigen::VectorXd vector, bool back) const;

  /// The quasi-Newton step for a residual.
  Eigen::VectorXd step_for(const Eigen::VectorXd& residual);

  /// First guess of a part of the step: where its begin and its velocity lead, bent as in the last step. A window that is
  /// repeated under another load, and the next one, accelerate much as that did.
  Eigen::VectorXd guess(int part, double dt, const Eigen::VectorXd& straight) const;

  Tangent<D> tangent_;
  ImplicitCosts costs_;
  ImplicitMemory<D> memory_;
  std::vector<LooseBody> loose_;
};

}  // namespace tern::structure
