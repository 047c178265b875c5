#pragma once
// The exact tangent of the internal force, K = -df/dd = sum_i V_i B_i^T (d2W/dq2) B_i with q = (H_i, K_i), for the free
// particles, plus a multiple of their mass; and its Cholesky factor. Of a shell A_i in place of V_i, and q = (x_,a, x_,ab).

#include <Eigen/CholmodSupport>
#include <Eigen/SparseCore>
#include <type_traits>
#include <vector>

#include "structure/state.hpp"

namespace tern::structure {

template <int D>
class Tangent {
 public:
  explicit Tangent(const Reference<D>& reference);
  Tangent(const Tangent&) = delete;
  Tangent& operator=(const Tangent&) = delete;

  /// Number of unknowns: D per free particle, in the order of free_rows().
  Eigen::Index unknowns() const { return matrix_.rows(); }
  const std::vector<std::int32_t>& free_rows() const { return free_rows_; }
  /// Non-zeros of the factor.
  double factor_size() const { return factor_size_; }
  /// Multiplications of one assembly, and of one factor.
  double assembly_size() const { return assembly_size_; }
  double factor_work() const { return factor_work_; }

  /// K + `mass_factor` M [1/s^2] at the deformation in `work` (its lower triangle).
  void assemble(const Reference<D>& reference, const Workspace<D>& work, double mass_factor);
  const Eigen::SparseMatrix<double>& lower() const { return matrix_; }

  /// Factors the assembled matrix; false when it is not positive definite.
  bool factorise();
  Eigen::VectorXd solve(const Eigen::VectorXd& right) { return factor_.solve(right); }

 private:
  static constexpr int operators = D + curvature_components<D>;  // first and second derivatives

  struct Particle {
    std::int32_t row = 0;
    std::uint32_t body = 0;
    std::vector<UnseenField<D, double>> unseen;
    Eigen::MatrixXd derivative;       // of the free particles it sees, itself included: a row for each operator
    std::vector<std::int32_t> node;   // which those are, ascending
    std::vector<std::int32_t> place;  // per pair node[j] >= node[l]: position of j below the diagonal of column l, -1: on it
  };

  /// Its entries: `hessian` times `size`, index(component, operator) a row of it.
  template <int Operators, class Hessian, class Index>
  void add(const Particle& particle, const Hessian& hessian, double size, const Index& index);

  std::vector<std::int32_t> free_rows_;
  std::vector<Particle> particles_;
  Eigen::SparseMatrix<double> matrix_;
  /// In 3D the factor fills up, and dense blocks of it are factored many times as fast (docs/STRUCTURE.md).
  using Symmetric = Eigen::SparseMatrix<double>;
  std::conditional_t<D == 3, Eigen::CholmodSupernodalLLT<Symmetric, Eigen::Lower>, Eigen::CholmodSimplicialLLT<Symmetric, Eigen::Lower>>
      factor_;
  double factor_size_ = 0, factor_work_ = 0, assembly_size_ = 0;
};

template <int D>
using CellHessian = Eigen::Matrix<double, D * D + D * curvature_components<D>, D * D + D * curvature_components<D>>;

/// d2W/dq2 of a particle's cell, q = (H_00, H_01, ..., K_0^00, K_0^01, ...), see first_piola_kirchhoff.cpp.
template <int D>
CellHessian<D> energy_hessian(const Body& body, const Workspace<D>& work, std::int32_t row);

/// The same over the derivatives of the fit, which `unseen` completes (unseen_fields.hpp).
template <int D>
CellHessian<D> energy_hessian_of_fit(const std::vector<UnseenField<D, double>>& unseen, const Body& body, const Workspace<D>& work,
                                     std::int32_t row);

}  // namespace tern::structure
