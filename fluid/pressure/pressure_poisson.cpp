// Pressure Poisson equation (seed paper eq. 2 with the sign a projection needs), rows scaled by V_i:
//   sum_j a_ij (p_i - p_j) + c_i p_i = -(rho/dt) V_i (div_i(u*) - s_i) + sum_k kappa_ik (p^_k - rho g.(x_k - x_i))
//   a_ij  = V_i V_j K_ij,  K = 2 |w'|/r                        (Cummins & Rudman 1999)
//   c_i   = V_i f_i K_full + sum_k kappa_ik + sum_spray a_ij
// Free surface: the missing part f_i = 1 - tr M_i / D of a support acts as neighbours at p = 0. Unlike p = 0 on marked
// particles this never switches a particle between two kinds of row, and the matrix keeps one size. Fluid that fills its
// enclosure has no surface (sealed.hpp).
// Fluid that no free surface ties, but bodies that yield: the level p of its pressure pushes particles whose kernels have a gap E_i by the
// sum form's -2 p E_i, of which the differences above know nothing. Its divergence is 4 (dt/rho) p E_i^2, so that
//   c_i += 4 V_i E_i^2,   E_i = sum V grad w over fluid and faces.
// Otherwise the motion counts as a change of volume in the next window only, the level answers it one late, and both swing and grow.
// Walls and structure are no unknowns: their flux is in div(u*). The structure yields to an increment of pressure,
// du_k = -dt (p + rho g.(x_k - x_i) - p^_k)/m_k n_k, which inserted in div(u^{n+1}) gives kappa_ik = 2 rho V_i A_k w~_ik / m_k.

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "fluid/fluid.hpp"

namespace tern::fluid {
namespace {

constexpr double least_deficit = 0.08;  ///< of tr M / D: less is disorder, not a surface
constexpr int multigrid_limit = 60;     ///< iterations; more means that the preconditioner has failed
constexpr int jacobi_limit = 20000;

}  // namespace

template <int D>
double Fluid<D>::missing_support(int i) const {
  const double deficit = enclosed_ ? 0 : 1 - trace_[i];
  return deficit > least_deficit ? deficit : 0;
}

template <int D>
void Fluid<D>::assemble_pressure_matrix() {
  const int n = static_cast<int>(state_.size());
  yields_to_level_.clear();
  matrix_.reset(n, [&](int i) { return active_[i] ? neighbours_.count[i] : 0; });
  const InterfaceCondition<D> none;
#pragma omp parallel for schedule(static) if (n >= parallel_threshold)
  for (int i = 0; i < n; ++i)
    if (surface_rows_.count[i] == 0) assemble_pressure_row(i, none);
  matrix_.pad();
}

template <int D>
void Fluid<D>::assemble_pressure_matrix_at_structure(const InterfaceCondition<D>& load) {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(band_.size()), all = static_cast<std::ptrdiff_t>(state_.size());
  if (n > 0) find_pools_that_yield(load);
#pragma omp parallel for schedule(static) if (n >= parallel_threshold)
  for (std::ptrdiff_t m = 0; m < n; ++m) assemble_pressure_row(band_[m], load);
  if (yields_to_level_.empty()) return;
#pragma omp parallel for schedule(static) if (all >= parallel_threshold)
  for (std::ptrdiff_t i = 0; i < all; ++i)
    if (surface_rows_.count[i] == 0 && yields_to_level_[i]) assemble_pressure_row(static_cast<int>(i), load);
}

template <int D>
void Fluid<D>::find_pools_that_yield(const InterfaceCondition<D>& load) {
  const int n = static_cast<int>(state_.size());
  missing_support_.resize(n);
  for (int i = 0; i < n; ++i) missing_support_[i] = static_cast<float>(missing_support(i));
  find_sealed_pools<D>(neighbours_, active_, missing_support_, without_surface_);
  if (!without_surface_.any()) return;
  std::vector<std::uint8_t>& yields = without_surface_.tied;
  yields.assign(without_surface_.size.size(), 0);
  for (int i : band_) {
    if (without_surface_.pool[i] < 0) continue;
    for (int entry = surface_rows_.begin[i]; entry < surface_rows_.begin[i] + surface_rows_.count[i]; ++entry)
      if (yielding(load, surface_rows_.face[entry], surface_rows_.weight[entry]) > 0) yields[without_surface_.pool[i]] = 1;
  }
  if (std::find(yields.begin(), yields.end(), 1) == yields.end()) return;
  yields_to_level_.resize(n);
  for (int i = 0; i < n; ++i) yields_to_level_[i] = sum_form_[i] && without_surface_.pool[i] >= 0 && yields[without_surface_.pool[i]];
}

template <int D>
void Fluid<D>::assemble_pressure_row(int i, const InterfaceCondition<D>& load) {
  if (!active_[i]) {
    matrix_.set_row(i, 0, 1, [](int) { return std::pair<int, float>{0, 0.0f}; });
    return;
  }
  const double volume = constants_.volume;
  const double full = constants_.lattice.laplacian_weight / constants_.lattice.gradient_moment;
  const int first = neighbours_.begin[i], count = neighbours_.count[i];
  double constant = volume * missing_support(i) * full;
  if (!yields_to_level_.empty() && yields_to_level_[i])
    constant +=
        4 * volume *
        (neighbours_.kernel_gradient[i] + boundary_.wall_gradient[i] + boundary_.surface_gradient[i] + boundary_.averted_gradient[i])
            .squaredNorm();
  for (int entry = surface_rows_.begin[i]; entry < surface_rows_.begin[i] + surface_rows_.count[i]; ++entry)
    constant += yielding(load, surface_rows_.face[entry], surface_rows_.weight[entry]);
  const int* column = neighbours_.column.data() + first;
  const double* weight = neighbours_.weight.data() + first;
  const auto edge = [&](int k) { return static_cast<float>(2 * volume * weight[k]); };
  if (near_spray_[i]) {
    for (int k = 0; k < count; ++k)
      if (!active_[column[k]]) constant += edge(k);
    matrix_.set_row(i, count, static_cast<float>(constant), [&](int k) {
      return active_[column[k]] ? std::pair<int, float>{column[k], edge(k)} : std::pair<int, float>{i, 0.0f};
    });
  } else {
    matrix_.set_row(i, count, static_cast<float>(constant), [&](int k) { return std::pair<int, float>{column[k], edge(k)}; });
  }
}

template <int D>
void Fluid<D>::assemble_pressure_source(const InterfaceCondition<D>& load) {
  const int n = static_cast<int>(state_.size());
  const double density = constants_.density, scale = -density / duration_s_ * constants_.volume;
  source_.assign(matrix_.padded_rows(), 0);
#pragma omp parallel for schedule(static) if (n >= parallel_threshold)
  for (int i = 0; i < n; ++i) {
    if (!active_[i]) continue;
    double b = scale * (density_source_.empty() ? divergence_[i] : divergence_[i] - density_source_[i]);
    // Past a corner the pressure behind the face goes on along the face as before it, by the weight of the fluid.
    b += 2 * density * constants_.volume * gravity_[i].dot(boundary_.averted_gradient[i]);
    for (int entry = surface_rows_.begin[i]; entry < surface_rows_.begin[i] + surface_rows_.count[i]; ++entry) {
      // The face answers the pressure at the face: that of the particle and the weight of the fluid between.
      const int k = surface_rows_.face[entry];
      const double between = density * gravity_[i].dot(surface_.position[k] - predicted_position_[i]);
      b += yielding(load, k, surface_rows_.weight[entry]) * (load.reference_pressure[k] - between);
    }
    source_[i] = b;
  }
}

template <int D>
double Fluid<D>::yielding(const InterfaceCondition<D>& load, int k, double weight) const {
  return load.robin_mass[k] > 0 ? 2 * constants_.density * constants_.volume * weight / load.robin_mass[k] : 0;
}

template <int D>
void Fluid<D>::prepare_pressure_solve() {
  solve_ = {};
  multigrid_.build(matrix_, predicted_position_, active_, neighbours_.beside_body, constants_.spacing, constants_.volume);
  find_sealed_pools<D>(neighbours_, active_, matrix_.constant(), pools_);
  if (pools_.any()) account_for_sealed_fluid();
}

template <int D>
void Fluid<D>::solve_pressure_poisson() {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(state_.size());
  pressure_.assign(matrix_.padded_rows(), 0);
#pragma omp parallel for schedule(static) if (n >= parallel_threshold)
  for (std::ptrdiff_t i = 0; i < n; ++i) pressure_[i] = active_[i] ? state_.pressure[i] : 0;

  // Sealed fluid can obey the source but for its mean.
  if (pools_.any()) pools_.subtract_means(source_);

  const double tolerance = constants_.numerics.pressure_tolerance;
  const int before = solve_.iterations;  // of the trials before
  const auto multigrid = [&](const std::vector<double>& r, std::vector<double>& z) {
    multigrid_.apply(r, z);
    if (pools_.any()) pools_.subtract_means(z);
  };
  solve_ = conjugate_gradient(matrix_, multigrid, source_, tolerance, multigrid_limit, pressure_, work_);
  if (!solve_.converged) {
    ++fallback_solves_;
    spdlog::warn(
        "The multigrid solve stopped after {} iterations at a residual of {:.1e}; this step is solved by "
        "Jacobi-preconditioned conjugate gradients.",
        solve_.iterations, solve_.residual);
    std::fill(pressure_.begin(), pressure_.end(), 0.0);
    const int wasted = solve_.iterations;
    const auto jacobi = [&](const std::vector<double>& r, std::vector<double>& z) {
      for (std::ptrdiff_t i = 0; i < n; ++i) z[i] = r[i] / matrix_.diagonal()[i];
      if (pools_.any()) pools_.subtract_means(z);
    };
    solve_ = conjugate_gradient(matrix_, jacobi, source_, tolerance, jacobi_limit, pressure_, work_);
    solve_.iterations += wasted;
  }
  solve_.iterations += before;
  if (!solve_.converged) {
    const std::ptrdiff_t worst =
        std::max_element(work_.residual.begin(), work_.residual.begin() + n, [](double a, double b) { return std::abs(a) < std::abs(b); }) -
        work_.residual.begin();
    std::string where;
    for (int c = 0; c < D; ++c) where += fmt::format("{}{:.5g}", c ? ", " : "", predicted_position_[worst][c]);
    throw NumericalFailure(fmt::format(
        "The pressure solve did not converge in the window from t = {:.6g} s: relative residual {:.2g} after {} iterations, asked for "
        "is {:g}; largest at fluid particle {} at ({}) m. Either a velocity has run away before: look at the last frames, or try a smaller "
        "fluid.numerics.courant; or raise fluid.numerics.pressure_tolerance.",
        begin_s_, solve_.residual, solve_.iterations, tolerance, state_.id[worst], where));
  }
  if (pools_.any()) pools_.subtract_means(pressure_);
#pragma omp parallel for schedule(static) if (n >= parallel_threshold)
  for (std::ptrdiff_t i = 0; i < n; ++i) state_.pressure[i] = pressure_[i];
}

#define TERN_INSTANTIATE(D)                                                                    \
  template void Fluid<D>::assemble_pressure_matrix();                                          \
  template void Fluid<D>::assemble_pressure_matrix_at_structure(const InterfaceCondition<D>&); \
  template void Fluid<D>::assemble_pressure_row(int, const InterfaceCondition<D>&);            \
  template void Fluid<D>::assemble_pressure_source(const InterfaceCondition<D>&);              \
  template double Fluid<D>::missing_support(int) const;                                        \
  template void Fluid<D>::find_pools_that_yield(const InterfaceCondition<D>&);                 \
  template double Fluid<D>::yielding(const InterfaceCondition<D>&, int, double) const;         \
  template void Fluid<D>::prepare_pressure_solve();                                            \
  template void Fluid<D>::solve_pressure_poisson();
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
