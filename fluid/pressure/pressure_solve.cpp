#include "fluid/pressure/pressure_solve.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "base/error.hpp"
#include "base/parallel.hpp"

namespace tern::fluid {
namespace {

constexpr int multigrid_limit = 60;  ///< iterations; more means that the preconditioner has failed
constexpr int jacobi_limit = 20000;
constexpr double rounding = 1e-12;  ///< of a mean that is subtracted
/// Where no particle is at a body, the correction answers to what the first solve leaves as well. It may leave this part of what is left
/// behind anyway.
constexpr double of_what_is_left = 0.1;
/// The correction of the pressure is solved for to this, because a part of what it answers to stays in any case.
constexpr double of_correction = 0.1;
/// Beside a body windows are repeated, and what the fluid answers to a motion has to be that of the motion, not of what was tried before.
/// So it goes on to this there, and the first solve to pressure_tolerance; but no farther than the coupler asks for.
constexpr double of_correction_beside_bodies = 1e-4;
/// As long as what is left is not known, beside bodies, or if a finer tolerance than this is asked for, the first solve may leave so many
/// times that one at most.
constexpr double usual_tolerance = 1e-6, first_by_tolerance = 1e3;

/// `solution`, from what it is, of the matrix and this source.
template <int D>
void solve(const Domain<D>& domain, const Window& window, const std::vector<Vector<D>>& position, const std::vector<int>& at_structure,
           const Accuracy& accuracy, std::vector<double>& source, std::vector<double>& solution, State<D>& state,
           PressureSystem<D>& system) {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(state.size());
  // Sealed fluid can obey the source but for its mean. What is left of a source that was all mean is rounding.
  if (system.sealed.any()) {
    const auto squared = [&] { return domain.ranks().sum(ordered_dot(std::span<const double>(source), std::span<const double>(source))); };
    const double whole = squared();
    system.sealed.subtract_means(source);
    if (squared() < rounding * rounding * whole) std::fill(source.begin(), source.end(), 0.0);
  }

  const int before = system.result.iterations;  // of the coupling iterations before
  // A body whose faces nearly undo the push of a level answers a little to it still.
  if (system.sealed.any() && system.beside_bodies.any()) {
    system.sealed.subtract_means(solution);
    domain.particles().update(solution);
  }
  const auto yielding = [&](const std::vector<double>& x, std::vector<double>& y) {
    system.yielding.add_difference(at_structure, x, y);
    if (system.sealed.any() && system.beside_bodies.any()) system.sealed.subtract_means(y);
  };
  const auto multigrid = [&](double largest, const std::vector<double>& r, std::vector<double>& z) {
    system.multigrid.apply(largest, r, z);
    if (system.sealed.any()) system.sealed.subtract_means(z);
  };
  system.result = conjugate_gradient(domain.ranks(), domain.particles(), system.matrix, yielding, multigrid, source, accuracy,
                                     multigrid_limit, solution, system.work);
  if (!system.result.converged) {
    ++state.fallback_solves;
    if (domain.ranks().first())
      spdlog::warn(
          "The multigrid solve stopped after {} iterations at a residual of {:.1e}; this step is solved by "
          "Jacobi-preconditioned conjugate gradients.",
          system.result.iterations, system.result.residual);
    std::fill(solution.begin(), solution.end(), 0.0);
    const int wasted = system.result.iterations;
    const auto jacobi = [&](double, const std::vector<double>& r, std::vector<double>& z) {
      for (std::ptrdiff_t i = 0; i < n; ++i) z[i] = r[i] / system.matrix.diagonal()[i];
      if (system.sealed.any()) system.sealed.subtract_means(z);
    };
    system.result = conjugate_gradient(domain.ranks(), domain.particles(), system.matrix, yielding, jacobi, source, accuracy, jacobi_limit,
                                       solution, system.work);
    system.result.iterations += wasted;
  }
  system.result.iterations += before;
  if (!system.result.converged) {
    const auto residual = [&](std::ptrdiff_t i) { return std::abs(system.work.residual[i]); };
    const double largest = domain.ranks().most(ordered_max(n, 0.0, residual));
    std::string sentence;
    for (std::ptrdiff_t worst = 0; worst < n && sentence.empty(); ++worst) {
      if (residual(worst) < largest) continue;
      std::string where;
      for (int c = 0; c < D; ++c) where += fmt::format("{}{:.5g}", c ? ", " : "", position[worst][c]);
      sentence = fmt::format(
          "The pressure solve did not converge in the window from t = {:.6g} s: relative residual {:.2g} after {} iterations, asked for "
          "is {:g}; largest at fluid particle {} at ({}) m. Either a velocity has run away before: look at the last frames, or try a "
          "smaller fluid.numerics.courant; or raise fluid.numerics.pressure_tolerance.",
          window.begin, system.result.residual, system.result.iterations, system.result.asked, state.id[worst], where);
    }
    throw NumericalFailure(domain.ranks().first_word(sentence));
  }
  if (!system.sealed.any()) return;
  system.sealed.subtract_means(solution);
  domain.particles().update(solution);
}

}  // namespace

template <int D>
void prepare_pressure_solve(const Constants<D>& constants, const Domain<D>& domain, const Neighbours<D>& neighbours,
                            const std::vector<ParticleClass>& particle_class, const std::vector<Vector<D>>& position,
                            const std::vector<int>& at_structure, PressureSystem<D>& system) {
  system.result = {};
  system.multigrid.build(domain, system.matrix, position, particle_class, neighbours.beside_body, constants.spacing, constants.volume,
                         system.yielding, at_structure);
}

template <int D>
void solve_pressure_poisson(const Constants<D>& constants, const Domain<D>& domain, const Window& window,
                            const std::vector<Vector<D>>& position, const std::vector<int>& at_structure, bool any_at_structure,
                            State<D>& state, PressureSystem<D>& system) {
  const std::ptrdiff_t all = static_cast<std::ptrdiff_t>(state.pressure.size());
  system.solution.assign(state.pressure.size(), 0);
  parallel_for(static_cast<std::ptrdiff_t>(state.size()), [&](std::ptrdiff_t i) {
    if (state.particle_class[i].pressure_unknown()) system.solution[i] = state.pressure[i] - state.pressure_correction[i];
  });

  const double tolerance = constants.numerics.pressure_tolerance, usual = std::min(tolerance, usual_tolerance);
  Accuracy accuracy{tolerance, usual * first_by_tolerance, system.answer_tolerance * usual / usual_tolerance};
  if (!any_at_structure) {
    if (state.left_share > 0 && tolerance >= usual_tolerance) accuracy.most = std::min(state.left_share, 1.0) * of_what_is_left;
    accuracy.least = std::max(tolerance, accuracy.most);
  }
  solve(domain, window, position, at_structure, accuracy, system.source, system.solution, state, system);
  parallel_for(all, [&](std::ptrdiff_t i) { state.pressure[i] = system.solution[i]; });
  state.has_pressure = true;
}

template <int D>
void solve_for_correction(const Constants<D>& constants, const Domain<D>& domain, const Window& window,
                          const std::vector<Vector<D>>& position, const std::vector<int>& at_structure, bool any_at_structure,
                          State<D>& state, PressureSystem<D>& system) {
  const SolveResult of_the_equation = system.result;
  system.correction.assign(state.pressure.size(), 0);
  parallel_for(static_cast<std::ptrdiff_t>(state.size()), [&](std::ptrdiff_t i) {
    if (state.particle_class[i].pressure_unknown()) system.correction[i] = state.pressure_correction[i];
  });
  const double finer = std::min(1.0, constants.numerics.pressure_tolerance / usual_tolerance);
  const Accuracy accuracy{(any_at_structure ? of_correction_beside_bodies : of_correction) * finer, of_correction * finer,
                          system.answer_tolerance * finer};
  solve(domain, window, position, at_structure, accuracy, system.left_behind, system.correction, state, system);
  state.left_share = of_the_equation.source > 0 ? system.result.source / of_the_equation.source : 0;
  system.result = of_the_equation;
}

template void prepare_pressure_solve<2>(const Constants<2>&, const Domain<2>&, const Neighbours<2>&, const std::vector<ParticleClass>&,
                                        const std::vector<Vector<2>>&, const std::vector<int>&, PressureSystem<2>&);
template void prepare_pressure_solve<3>(const Constants<3>&, const Domain<3>&, const Neighbours<3>&, const std::vector<ParticleClass>&,
                                        const std::vector<Vector<3>>&, const std::vector<int>&, PressureSystem<3>&);
template void solve_pressure_poisson<2>(const Constants<2>&, const Domain<2>&, const Window&, const std::vector<Vector<2>>&,
                                        const std::vector<int>&, bool, State<2>&, PressureSystem<2>&);
template void solve_pressure_poisson<3>(const Constants<3>&, const Domain<3>&, const Window&, const std::vector<Vector<3>>&,
                                        const std::vector<int>&, bool, State<3>&, PressureSystem<3>&);
template void solve_for_correction<2>(const Constants<2>&, const Domain<2>&, const Window&, const std::vector<Vector<2>>&,
                                      const std::vector<int>&, bool, State<2>&, PressureSystem<2>&);
template void solve_for_correction<3>(const Constants<3>&, const Domain<3>&, const Window&, const std::vector<Vector<3>>&,
                                      const std::vector<int>&, bool, State<3>&, PressureSystem<3>&);

}  // namespace tern::fluid
