#pragma once
// Symmetric matrix of the pressure Poisson equation in edge form,
//   (A x)_i = c_i x_i + sum_j a_ij (x_i - x_j),  a_ij = a_ji = s w_ij >= 0, c_i >= 0,
// over unknowns j. The edges are the pairs of the neighbour lists themselves, w_ij their weights in single precision and s one number;
// there is no copy of them. x is in double precision for the equation and in single inside the preconditioner. So the matrix is exactly
// symmetric and exact on constants.
// Neighbours that are no unknowns lie in the lists too. Their x is 0: with it the sum over all of a row is the sum over unknowns and the
// part of c_i that ties x_i to them.

#include <algorithm>
#include <cstddef>
#include <vector>

#include "base/parallel.hpp"

namespace tern::fluid {

class EdgeMatrix {
 public:
  static constexpr int unit = 4;  ///< edges computed at a time: rows of pairs are filled up to a whole number of it with weight 0

  int rows() const { return rows_; }
  /// c_i, with what ties row i to neighbours that are no unknowns.
  const std::vector<float>& constant() const { return constant_; }
  /// The same with room for those of `all` rows, the further ones of other ranks.
  std::vector<float>& constant_of_all(std::size_t all) {
    constant_.resize(all);
    return constant_;
  }
  const std::vector<float>& diagonal() const { return diagonal_; }

  /// Starts a matrix of n rows over lists of pairs whose rows begin at `begin`. The lists must outlive its use and stay as they are.
  void reset(int n, const int* begin, const int* column, const float* weight, double scale) {
    rows_ = n;
    begin_ = begin;
    column_ = column;
    weight_ = weight;
    scale_ = scale;
    for (auto* v : {&constant_, &apart_, &diagonal_}) v->resize(n);
    length_.resize(n);
  }

  /// Row i of an unknown with n pairs, c_i = apart + to_fixed; `to_fixed`: its edges to neighbours that are no unknowns.
  void set_row(int i, int n, double apart, double to_fixed) {
    const float* const weight = weight_ + begin_[i];
    length_[i] = (n + unit - 1) & -unit;
    double sum = 0;
#pragma omp simd reduction(+ : sum)
    for (int k = 0; k < length_[i]; ++k) sum += weight[k];
    apart_[i] = static_cast<float>(apart);
    constant_[i] = static_cast<float>(apart + to_fixed);
    diagonal_[i] = static_cast<float>(apart + scale_ * sum);
  }

  /// Row i of what is no unknown: x_i = b_i.
  void set_fixed(int i) {
    length_[i] = 0;
    apart_[i] = constant_[i] = diagonal_[i] = 1;
  }

  /// Calls visit(j, a_ij) for the edges of row i to unknowns.
  template <class Visit>
  void for_edges(int i, Visit&& visit) const {
    for (int k = begin_[i]; k < begin_[i] + length_[i]; ++k)
      if (weight_[k] != 0 && length_[column_[k]] > 0) visit(column_[k], static_cast<float>(scale_ * weight_[k]));
  }

  /// y = A x, for x that is 0 where there is no unknown. T = double for the equation, float inside the preconditioner.
  template <class T>
  void multiply(const std::vector<T>& x, std::vector<T>& y) const {
    const T scale = static_cast<T>(scale_);
    parallel_for(rows_, [&](int i) { y[i] = T(apart_[i]) * x[i] + scale * sum_row(i, x.data()); });
  }

 private:
  /// sum_j w_ij (x_i - x_j), four edges in a register and two registers in turns, so that one sum need not wait for the other.
  template <class T>
  T sum_row(int i, const T* x) const {
    typedef T Four __attribute__((vector_size(unit * sizeof(T))));
    typedef float Weights __attribute__((vector_size(unit * sizeof(float)), aligned(sizeof(float))));
    const Four own = x[i] - Four{};
    const int *column = column_ + begin_[i], *const end = column + length_[i];
    const float* weight = weight_ + begin_[i];
    const auto add_next = [&](Four& sum) {
      const Four other = {x[column[0]], x[column[1]], x[column[2]], x[column[3]]};
      sum += __builtin_convertvector(*reinterpret_cast<const Weights*>(weight), Four) * (own - other);
      column += unit;
      weight += unit;
    };
    Four even = {}, odd = {};
    if (length_[i] % (2 * unit) != 0) add_next(odd);
    while (column < end) {
      add_next(even);
      add_next(odd);
    }
    even += odd;
    return (even[0] + even[2]) + (even[1] + even[3]);
  }

  int rows_ = 0;
  const int *begin_ = nullptr, *column_ = nullptr;
  const float* weight_ = nullptr;
  double scale_ = 1;
  std::vector<int> length_;  ///< pairs of a row, filled up; 0 of what is no unknown
  std::vector<float> constant_, apart_, diagonal_;
};

}  // namespace tern::fluid
