#pragma once
// Symmetric matrix of the pressure Poisson equation in edge form,
//   (A x)_i = c_i x_i + sum_j a_ij (x_i - x_j),  a_ij = a_ji = s w_ij >= 0, c_i >= 0,
// over unknowns j. The edges are the pairs of the neighbour lists themselves, w_ij their weights in single precision and s one number;
// there is no copy of them. x is in double precision for the equation and in single inside the preconditioner. So the matrix is exactly
// symmetric and exact on constants.
// Neighbours that are no unknowns lie in the lists too. Their x is 0: with it the sum over all of a row is the sum over unknowns and the
// part of c_i that ties x_i to them. So do particles that are no neighbours; their weight is 0.

#include <algorithm>
#include <cstddef>
#include <vector>

#include "base/parallel.hpp"
#include "fluid/neighbours.hpp"

namespace tern::fluid {

class EdgeMatrix {
 public:
  int rows() const { return rows_; }
  /// c_i, with what ties row i to neighbours that are no unknowns.
  const std::vector<float>& constant() const { return constant_; }
  const std::vector<float>& diagonal() const { return diagonal_; }
  /// Calls update(values...) for what other ranks have to know of a row, with room for `all`, the further ones of other ranks.
  template <class Update>
  void with_ghosts(std::size_t all, Update&& update) {
    for (auto* v : {&constant_, &diagonal_}) v->resize(all);
    update(constant_, diagonal_);
  }

  /// Starts a matrix over lists of pairs. They must outlive its use and stay as they are.
  template <int D>
  void reset(const Neighbours<D>& neighbours, double scale) {
    rows_ = static_cast<int>(neighbours.begin.size());
    begin_ = neighbours.begin.data();
    length_of_list_ = neighbours.length.data();
    first_ = neighbours.first.data();
    weight_ = neighbours.weight.data();
    scale_ = scale;
    for (auto* v : {&constant_, &apart_, &diagonal_}) v->resize(rows_);
    length_.resize(rows_);
  }

  /// Row i of an unknown, c_i = apart + to_fixed; `to_fixed`: its edges to neighbours that are no unknowns.
  void set_row(int i, double apart, double to_fixed) {
    const float* const weight = weight_ + begin_[i];
    length_[i] = length_of_list_[i];
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

  /// Calls visit(j, a_ij) for the edges of row i to unknowns, and to all particles of other ranks.
  template <class Visit>
  void for_edges(int i, Visit&& visit) const {
    for (int k = begin_[i]; k < begin_[i] + length_[i]; ++k)
      if (const int j = first_[k / lanes] + k % lanes; weight_[k] != 0 && (j >= rows_ || length_[j] > 0))
        visit(j, static_cast<float>(scale_ * weight_[k]));
  }

  /// y = A x, for x that is 0 where there is no unknown. T = double for the equation, float inside the preconditioner.
  template <class T>
  void multiply(const std::vector<T>& x, std::vector<T>& y) const {
    const T scale = static_cast<T>(scale_);
    parallel_for(rows_, [&](int i) { y[i] = T(apart_[i]) * x[i] + scale * sum_row(i, x.data()); });
  }

 private:
  /// sum_j w_ij (x_i - x_j), four edges at a time and two sums in turns, so that one need not wait for the other.
  template <class T>
  T sum_row(int i, const T* x) const {
    typedef T Numbers __attribute__((vector_size(lanes * sizeof(T)), aligned(sizeof(T))));
    const Numbers own = x[i] - Numbers{};
    const int* first = first_ + begin_[i] / lanes;
    const float *weight = weight_ + begin_[i], *const end = weight + length_[i];
    const auto add_next = [&](Numbers& sum) {
      const Numbers other = *reinterpret_cast<const Numbers*>(x + *first);
      if constexpr (sizeof(T) == sizeof(float))
        sum += *reinterpret_cast<const Numbers*>(weight) * (own - other);
      else
        sum += load(weight) * (own - other);
      ++first;
      weight += lanes;
    };
    Numbers even = {}, odd = {};
    if (length_[i] % (2 * lanes) != 0) add_next(odd);
    while (weight < end) {
      add_next(even);
      add_next(odd);
    }
    even += odd;
    return (even[0] + even[2]) + (even[1] + even[3]);
  }

  int rows_ = 0;
  const int *begin_ = nullptr, *length_of_list_ = nullptr, *first_ = nullptr;
  const float* weight_ = nullptr;
  double scale_ = 1;
  std::vector<int> length_;  ///< entries of a row; 0 of what is no unknown
  std::vector<float> constant_, apart_, diagonal_;
};

}  // namespace tern::fluid
