#pragma once
// Conjugate gradients for A p = b, preconditioned.

#include <functional>
#include <vector>

#include "fluid/pressure/edge_matrix.hpp"
#include "ranks/halo.hpp"
#include "ranks/ranks.hpp"

namespace tern::fluid {

/// When a solve from p_0 may end: when |b - A p| <= max(least |b|, min(most |b|, of_start |b - A p_0|)) (2-norms).
struct Accuracy {
  double least = 0, most = 0, of_start = 0;
};

struct SolveResult {
  int iterations = 0;
  double residual = 0;  ///< |b - A p| / |b|
  double asked = 0;     ///< the largest with which it may end
  double source = 0;    ///< |b|
  bool converged = false;
};

/// Work vectors, kept so that a step allocates nothing.
struct ConjugateGradientWork {
  std::vector<double> residual, preconditioned, direction, product;
};

/// y += (A - matrix) x
using Add = std::function<void(const std::vector<double>& x, std::vector<double>& y)>;
/// z = B r; B symmetric positive definite. `largest`: of |r_i|, of all ranks.
using Precondition = std::function<void(double largest, const std::vector<double>& r, std::vector<double>& z)>;

/// `ghosts`: of the rows of other ranks, which come behind the own ones in p. A is the matrix and what `add` adds to its product. Starts
/// from p, which is 0 where there is no unknown; its ghosts are up to date, before and after. Ends without convergence after `limit`
/// iterations or when A or B turns out not to be positive definite (which rounding can cause near singularity).
SolveResult conjugate_gradient(const Ranks& ranks, const Halo& ghosts, const EdgeMatrix& matrix, const Add& add,
                               const Precondition& precondition, const std::vector<double>& b, const Accuracy& accuracy, int limit,
                               std::vector<double>& p, ConjugateGradientWork& work);

}  // namespace tern::fluid
