#include "fluid/pressure/conjugate_gradient.hpp"

#include <algorithm>
#include <cmath>

#include "base/parallel.hpp"

namespace tern::fluid {

SolveResult conjugate_gradient(const Ranks& ranks, const Halo& ghosts, const EdgeMatrix& matrix, const Add& add,
                               const Precondition& precondition, const std::vector<double>& b, const Accuracy& accuracy, int limit,
                               std::vector<double>& p, ConjugateGradientWork& work) {
  const std::ptrdiff_t n = matrix.rows(), all = static_cast<std::ptrdiff_t>(p.size());
  for (auto* v : {&work.residual, &work.preconditioned, &work.direction, &work.product}) v->assign(p.size(), 0);
  auto& [r, z, d, q] = work;
  const auto own_dot = [&](const std::vector<double>& x, const std::vector<double>& y) {
    return ordered_dot(std::span(x).first(n), std::span(y).first(n));
  };
  double largest = 0;  // of |r|
  // Both travel together.
  const auto measure_residual = [&] {
    double of_r = own_dot(r, r);
    largest = ordered_max(n, 0.0, [&](std::ptrdiff_t i) { return std::abs(r[i]); });
    ranks.sum_and_most(std::span(&of_r, 1), std::span(&largest, 1));
    return std::sqrt(of_r);
  };

  SolveResult result;
  double of_b_and_p[] = {own_dot(b, b), own_dot(p, p)};
  ranks.sum(std::span<double>(of_b_and_p));
  const double norm_b = result.source = std::sqrt(of_b_and_p[0]);
  if (norm_b == 0) {
    std::fill(p.begin(), p.end(), 0.0);
    result.converged = true;
    return result;
  }
  if (of_b_and_p[1] != 0) {
    ghosts.update(p);
    matrix.multiply(p, q);
    add(p, q);
  }
  parallel_for(n, [&](std::ptrdiff_t i) { r[i] = b[i] - q[i]; });
  result.residual = measure_residual() / norm_b;
  result.asked = std::max(accuracy.least, std::min(accuracy.most, accuracy.of_start * result.residual));
  double rho = 0;
  while (result.residual > result.asked) {
    if (result.iterations == limit || !std::isfinite(result.residual)) return result;
    precondition(largest, r, z);
    const double rho_next = ranks.sum(own_dot(r, z));
    if (!(rho_next > 0)) return result;
    const double beta = result.iterations == 0 ? 0 : rho_next / rho;
    rho = rho_next;
    parallel_for(n, [&](std::ptrdiff_t i) { d[i] = z[i] + beta * d[i]; });
    ghosts.update(d);
    matrix.multiply(d, q);
    add(d, q);
    const double curvature = ranks.sum(own_dot(d, q));
    if (!(curvature > 0)) return result;
    const double alpha = rho / curvature;
    parallel_for(n, [&](std::ptrdiff_t i) {
      p[i] += alpha * d[i];
      r[i] -= alpha * q[i];
    });
    for (std::ptrdiff_t i = n; i < all; ++i) p[i] += alpha * d[i];
    result.residual = measure_residual() / norm_b;
    ++result.iterations;
  }
  result.converged = true;
  return result;
}

}  // namespace tern::fluid
