// TR-BDF2 for d' = v, M v' = f(d) + f_external, with g = 2 - sqrt(2) and h = g dt/2:
//   d_g = d_n + h (v_n + v_g),               M (v_g - v_n)/h = f_n + f(d_g) + 2 f_external      trapezoidal rule to t + g dt
//   d = d^ + h v,                            M (v - v^)/h = f(d) + f_external                   BDF2 to t + dt
//   (d^, v^) = [ (d_g, v_g) - (1 - g)^2 (d_n, v_n) ]/(g (2 - g)).
// With v eliminated both read  M (d - predictor)/h^2 - f(d) = constant,  whose tangent is M/h^2 + K. Mass damping decays the
// velocity by exp(-alpha dt/2) before and after the step.

#include "structure/implicit/implicit_step.hpp"

#include <cmath>

#include "structure/time_step.hpp"

namespace tern::structure {
namespace {

/// Newton's method ends when it moves no particle by more than this share of the way that the fastest goes in the time h: the velocity is
/// known to that share of the largest then, a tenth of what the coupling iterates to. Ten times as much gives a beam in five
/// periods 0.0015 of its energy (`./tern verify turek_hron_csm3`), ...
constexpr double tolerance = 1e-5;
/// ... or than this share of the spacing, for bodies at rest.
constexpr double tolerance_at_rest = 1e-7;
constexpr int most_iterations = 14;  // with one factor
constexpr int most_halvings = 6;
constexpr std::size_t most_updates = 6;  // kept while the factor is
constexpr int expected_iterations = 4;   // with a new factor
/// A factor made for another step length serves while h^2 differs by less than this factor.
constexpr double largest_ratio = 2;

template <int D>
Eigen::VectorXd gather(const std::vector<std::int32_t>& rows, const RowVectors<D>& from) {
  Eigen::VectorXd values(static_cast<Eigen::Index>(rows.size()) * D);
  Eigen::Index n = 0;
  for (const auto row : rows)
    for (int a = 0; a < D; ++a) values[n++] = from[a][row];
  return values;
}

template <int D>
void scatter(const std::vector<std::int32_t>& rows, const Eigen::VectorXd& values, RowVectors<D>& to) {
  Eigen::Index n = 0;
  for (const auto row : rows)
    for (int a = 0; a < D; ++a) to[a][row] = values[n++];
}

/// Moves the clamped particles on for `dt`.
template <int D>
void drift_clamps(const Reference<D>& reference, double dt, State<D>& state) {
  for (const Clamp& clamp : reference.clamps) {
    if (!clamp.motion) continue;
    for (const auto row : clamp.row)
      for (int a = 0; a < D; ++a) state.displacement[a][row] += dt * state.velocity[a][row];
  }
  for (std::size_t c = 0; c < state.clamp_angle.size(); ++c) state.clamp_angle[c] += dt * state.clamp_spin[c];
}

/// Decays the velocity for half of a step.
template <int D>
void damp(const Reference<D>& reference, double dt, State<D>& state) {
  if (!reference.has_damping) return;
  for (std::size_t n = 0; n < reference.blocks.size(); ++n) {
    const double damping = reference.bodies[reference.blocks[n].body].mass_damping;
    const double decay = std::exp(-0.5 * dt * damping);
    for (int lane = 0; lane < lane_count; ++lane) {
      const std::int32_t row = reference.blocks[n].row + lane;
      if (reference.inverse_mass[row] == 0) continue;
      for (int a = 0; a < D; ++a) {
        double& v = state.velocity[a][row];
        state.damping_loss[n][lane] += 0.5 * reference.mass[row] * v * v * (1 - decay * decay);
        v *= decay;
      }
    }
  }
}

}  // namespace

template <int D>
ImplicitCosts implicit_costs(const Reference<D>& reference, const Tangent<D>& tangent) {
  if (D == 2) return {};
  // Nanoseconds, by bench-structure_substep: of a sub-step per block and neighbour, or per pair of particles of a shell; of a
  // multiplication of the assembly and of the factor; of a solve per non-zero of the factor.
  constexpr double of_neighbour = 55, of_shell_pair = 60, of_assembly = 1, of_factor = 0.04, of_solve = 1.2;
  constexpr double share_of_elasticity = 0.6;  // of a sub-step, which has the diffusion as well
  double sub_step = 0;
  for (const Block& block : reference.blocks)
    if (block.deforms) sub_step += of_neighbour * reference.stencils[block.stencil].count;
  for (const ShellBody<D>& shell : reference.shells) sub_step += of_shell_pair * static_cast<double>(shell.layer.neighbour.size());
  ImplicitCosts costs;
  costs.evaluation = share_of_elasticity + of_solve * tangent.factor_size() / sub_step;
  costs.factor = (of_assembly * tangent.assembly_size() + of_factor * tangent.factor_work()) / sub_step;
  return costs;
}

template <int D>
ImplicitStep<D>::ImplicitStep(const Reference<D>& reference) : tangent_(reference), costs_(implicit_costs(reference, tangent_)) {
  const auto& rows = tangent_.free_rows();  // in the order of Reference::particle_row
  std::size_t node = 0;
  for (const Body& body : reference.bodies) {
    const std::size_t first = node;
    for (std::size_t p = body.first; p < body.first + body.count; ++p) node += reference.inverse_mass[reference.particle_row[p]] > 0;
    if (node - first == body.count && node <= rows.size()) loose_.push_back({first, body.count, Matrix<D>::Identity()});
  }
}

template <int D>
void ImplicitStep<D>::find_turns(const Reference<D>& reference, const State<D>& state) {
  if (memory_.factored_h == 0) return;
  const auto& rows = tangent_.free_rows();
  const auto place = [&](const RowVectors<D>& displacement, std::int32_t row) {
    Vector<D> x = reference.position_of(row);
    for (int a = 0; a < D; ++a) x[a] += displacement[a][row];
    return x;
  };
  for (LooseBody& body : loose_) {
    Vector<D> then = Vector<D>::Zero(), now = Vector<D>::Zero();
    for (std::size_t n = body.first; n < body.first + body.count; ++n) {
      then += place(memory_.factored_displacement, rows[n]) / static_cast<double>(body.count);
      now += place(state.displacement, rows[n]) / static_cast<double>(body.count);
    }
    Matrix<D> product = Matrix<D>::Zero();
    for (std::size_t n = body.first; n < body.first + body.count; ++n)
      product += (place(state.displacement, rows[n]) - now) * (place(memory_.factored_displacement, rows[n]) - then).transpose();
    const Eigen::JacobiSVD<Matrix<D>> svd(product, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Vector<D> sign = Vector<D>::Ones();
    sign[D - 1] = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
    body.turn = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  }
}

template <int D>
Eigen::VectorXd ImplicitStep<D>::turned(Eigen::VectorXd vector, bool back) const {
  for (const LooseBody& body : loose_) {
    const Matrix<D> turn = back ? Matrix<D>(body.turn.transpose()) : body.turn;
    for (std::size_t n = body.first; n < body.first + body.count; ++n) {
      auto part = vector.template segment<D>(static_cast<Eigen::Index>(n) * D);
      part = (turn * part).eval();
    }
  }
  return vector;
}

template <int D>
Eigen::VectorXd ImplicitStep<D>::step_for(const Eigen::VectorXd& residual) {
  Eigen::VectorXd step = turned(residual, true);
  std::vector<double> share(memory_.updates.size());
  for (std::size_t n = memory_.updates.size(); n-- > 0;) {
    share[n] = memory_.updates[n].moved.dot(step) / memory_.updates[n].product;
    step -= share[n] * memory_.updates[n].change;
  }
  step = tangent_.solve(step);
  for (std::size_t n = 0; n < memory_.updates.size(); ++n)
    step += (share[n] - memory_.updates[n].change.dot(step) / memory_.updates[n].product) * memory_.updates[n].moved;
  return turned(std::move(step), false);
}

template <int D>
bool ImplicitStep<D>::renew(const Reference<D>& reference, double h, const State<D>& state, const Workspace<D>& work) {
  memory_.updates.clear();
  memory_.excess = 0;
  memory_.factored_displacement = state.displacement;
  memory_.factored_clamp_angle = state.clamp_angle;
  for (LooseBody& body : loose_) body.turn.setIdentity();
  tangent_.assemble(reference, work, 1 / (h * h));
  memory_.factored_h = tangent_.factorise() ? h : 0;
  return memory_.factored_h > 0;
}

template <int D>
void ImplicitStep<D>::set_memory(const Reference<D>& reference, const ImplicitMemory<D>& memory, State<D> state, Workspace<D>& work) {
  if (memory.factored_h > 0) {
    state.displacement = memory.factored_displacement;
    state.clamp_angle = memory.factored_clamp_angle;
    displacement_gradients(reference, state, work);
    renew(reference, memory.factored_h, state, work);
  }
  memory_ = memory;
}

template <int D>
bool ImplicitStep<D>::solve(const Reference<D>& reference, double h, double speed, const Eigen::VectorXd& predictor,
                            const Eigen::VectorXd& constant, State<D>& state, Workspace<D>& work) {
  const auto& rows = tangent_.free_rows();
  double spacing = std::numeric_limits<double>::max();
  for (const Body& body : reference.bodies) spacing = std::min(spacing, body.spacing);
  const double small = std::max(tolerance * h * speed, tolerance_at_rest * spacing);
  Eigen::VectorXd inertia(predictor.size());
  for (std::size_t n = 0; n < rows.size(); ++n)
    inertia.template segment<D>(static_cast<Eigen::Index>(n) * D).setConstant(reference.mass[rows[n]] / (h * h));

  const auto evaluate = [&](const Eigen::VectorXd& at, Eigen::VectorXd& result) {
    ++memory_.counts.evaluations;
    scatter<D>(rows, at, state.displacement);
    if (!evaluate_elastic_force(reference, state, work)) return false;
    result = constant + gather<D>(rows, state.internal_force) - inertia.cwiseProduct(at - predictor);
    return result.allFinite();
  };
  // The residual in the norm of the inverse inertia.
  const auto size = [&](const Eigen::VectorXd& r) { return r.cwiseProduct(r).cwiseQuotient(inertia).sum(); };

  Eigen::VectorXd d = gather<D>(rows, state.displacement), residual, next, next_residual;
  if (!evaluate(d, residual)) return false;
  find_turns(reference, state);
  const double ratio = h * h / (memory_.factored_h * memory_.factored_h);
  const double worth_of_a_factor = std::round(costs_.factor / costs_.evaluation);  // in iterations
  bool outdated = !(ratio < largest_ratio && ratio * largest_ratio > 1) || memory_.excess > worth_of_a_factor;
  for (int attempt = 0; attempt < 2; ++attempt) {
    bool fresh = false;
    if (outdated) {
      ++memory_.counts.factors;
      if (!renew(reference, h, state, work)) return false;
      fresh = true;
    }
    for (int iteration = 0; iteration < most_iterations; ++iteration) {
      const Eigen::VectorXd step = step_for(residual);
      const double largest = step.cwiseAbs().maxCoeff();
      if (!std::isfinite(largest)) break;
      double share = 1;
      bool accepted = false;
      const double before = size(residual);
      for (int halving = 0; halving < most_halvings; ++halving, share *= 0.5) {
        next = d + share * step;
        accepted = evaluate(next, next_residual) && (size(next_residual) < before || share * largest <= small);
        if (accepted) break;
      }
      if (!accepted) break;
      QuasiNewtonUpdate update{next - d, residual - next_residual, 0};
      update.product = update.moved.dot(update.change);
      d = next;
      residual = next_residual;
      if (share * largest <= small) {
        memory_.excess += std::max(0, iteration + 1 - expected_iterations);
        return true;
      }
      if (update.product > 0) {
        if (memory_.updates.size() == most_updates) memory_.updates.erase(memory_.updates.begin());
        update.moved = turned(std::move(update.moved), true);
        update.change = turned(std::move(update.change), true);
        memory_.updates.push_back(std::move(update));
      }
    }
    if (fresh || !evaluate(d, residual)) return false;
    outdated = true;
  }
  return false;
}

template <int D>
Eigen::VectorXd ImplicitStep<D>::guess(int part, double dt, const Eigen::VectorXd& straight) const {
  if (memory_.bend[part].size() != straight.size()) return straight;
  const double ratio = dt / memory_.bend_dt;
  return straight + ratio * ratio * memory_.bend[part];
}

template <int D>
bool ImplicitStep<D>::advance(const Reference<D>& reference, double begin, double dt, State<D>& state, Workspace<D>& work) {
  const auto& rows = tangent_.free_rows();
  const State<D> saved = state;
  const double g = 2 - std::sqrt(2.0), h = 0.5 * g * dt;
  damp(reference, dt, state);
  const Eigen::VectorXd external = gather<D>(rows, state.external_force);
  const Eigen::VectorXd d_n = gather<D>(rows, state.displacement), v_n = gather<D>(rows, state.velocity);
  bool done = state.force_is_elastic;  // as the last implicit step leaves it
  if (!done) {
    done = evaluate_elastic_force(reference, state, work);
    ++memory_.counts.evaluations;
  }
  const Eigen::VectorXd f_n = gather<D>(rows, state.internal_force);

  // Clamps stand in their places at both stages. At one velocity through the step they would be off by a g (1 - g) dt^2/2 at the first,
  // and push with the stiffness of one spacing.
  aim_clamps(reference, begin + g * dt, g * dt, state);
  const double power_n = clamp_power(reference, state, work);
  drift_clamps(reference, g * dt, state);
  const Eigen::VectorXd straight = d_n + 2 * h * v_n;
  const double speed = v_n.size() > 0 ? v_n.cwiseAbs().maxCoeff() : 0;
  if (done) {
    scatter<D>(rows, guess(0, dt, straight), state.displacement);
    done = solve(reference, h, speed, straight, f_n + 2 * external, state, work);
  }
  if (done) {
    const Eigen::VectorXd d_g = gather<D>(rows, state.displacement);
    const Eigen::VectorXd v_g = (d_g - d_n) / h - v_n;
    const double own = 1 / (g * (2 - g)), past = (1 - g) * (1 - g) * own;
    const Eigen::VectorXd d_hat = own * d_g - past * d_n, v_hat = own * v_g - past * v_n;
    const double power_g = clamp_power(reference, state, work);
    aim_clamps(reference, begin + dt, (1 - g) * dt, state);
    const double power_on = clamp_power(reference, state, work);
    drift_clamps(reference, (1 - g) * dt, state);
    const Eigen::VectorXd straight_on = d_g + (1 - g) * dt * v_g;
    scatter<D>(rows, guess(1, dt, straight_on), state.displacement);
    done = solve(reference, h, speed, d_hat + h * v_hat, external, state, work);
    if (done) {
      const Eigen::VectorXd d = gather<D>(rows, state.displacement);
      memory_.bend[0] = d_g - straight;
      memory_.bend[1] = d - straight_on;
      memory_.bend_dt = dt;
      scatter<D>(rows, (d - d_hat) / h, state.velocity);
      damp(reference, dt, state);
      // Work of the clamps by the trapezoidal rule over both parts of the step.
      const double power = clamp_power(reference, state, work);
      state.clamp_work += 0.5 * dt * (g * (power_n + power_g) + (1 - g) * (power_on + power));
      ++memory_.counts.steps;
      return true;
    }
  }
  state = saved;
  for (auto& bend : memory_.bend) bend.resize(0);
  ++memory_.counts.failed;
  return false;
}

template ImplicitCosts implicit_costs<2>(const Reference<2>&, const Tangent<2>&);
template ImplicitCosts implicit_costs<3>(const Reference<3>&, const Tangent<3>&);
template class ImplicitStep<2>;
template class ImplicitStep<3>;

}  // namespace tern::structure
