#include "fluid/pressure/conjugate_gradient.hpp"

#include <cmath>

#include "base/parallel.hpp"

namespace tern::fluid {

SolveResult conjugate_gradient(const Ranks& ranks, const Halo& ghosts, const EdgeMatrix& matrix, const Apply& add,
                               const Apply& precondition, const std::vector<double>& b, double tolerance, int limit, std::vector<double>& p,
                               ConjugateGradientWork& work) {
  const std::ptrdiff_t n = matrix.rows();
  for (auto* v : {&work.residual, &work.preconditioned, &work.direction, &work.product}) v->assign(p.size(), 0);
  auto& [r, z, d, q] = work;
  const auto dot = [&](const std::vector<double>& x, const std::vector<double>& y) {
    return ranks.sum(ordered_dot(std::span(x).first(n), std::span(y).first(n)));
  };

  SolveResult result;
  const double norm_b = result.source = std::sqrt(dot(b, b));
  if (norm_b == 0) {
    std::fill(p.begin(), p.end(), 0.0);
    result.converged = true;
    return result;
  }
  if (dot(p, p) != 0) {
    ghosts.update(p);
    matrix.multiply(p, q);
    add(p, q);
  }
  parallel_for(n, [&](std::ptrdiff_t i) { r[i] = b[i] - q[i]; });
  result.residual = std::sqrt(dot(r, r)) / norm_b;
  double rho = 0;
  while (result.residual > tolerance) {
    if (result.iterations == limit || !std::isfinite(result.residual)) return result;
    precondition(r, z);
    const double rho_next = dot(r, z);
    if (!(rho_next > 0)) return result;
    const double beta = result.iterations == 0 ? 0 : rho_next / rho;
    rho = rho_next;
    parallel_for(n, [&](std::ptrdiff_t i) { d[i] = z[i] + beta * d[i]; });
    ghosts.update(d);
    matrix.multiply(d, q);
    add(d, q);
    const double curvature = dot(d, q);
    if (!(curvature > 0)) return result;
    const double alpha = rho / curvature;
    parallel_for(n, [&](std::ptrdiff_t i) {
      p[i] += alpha * d[i];
      r[i] -= alpha * q[i];
    });
    result.residual = std::sqrt(dot(r, r)) / norm_b;
    ++result.iterations;
  }
  result.converged = true;
  return result;
}

}  // namespace tern::fluid
