#pragma once
// Symmetric matrix of the pressure Poisson equation in edge form,
//   (A x)_i = c_i x_i + sum_j a_ij (x_i - x_j),  a_ij = a_ji >= 0, c_i >= 0,
// with a, c in single and x in double precision: exactly symmetric, exact on constants, and within 6e-8 of the double
// operator in the energy norm. Rows lie in slices of 16, column by column inside a slice, padded with a = 0 at the row
// itself, so that 16 rows advance together.

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "base/parallel.hpp"
#include "base/uninitialised.hpp"

namespace tern::fluid {

class EdgeMatrix {
 public:
  static constexpr int slice = 16;

  int rows() const { return rows_; }
  const std::vector<float>& constant() const { return constant_; }
  const std::vector<float>& diagonal() const { return diagonal_; }

  /// Starts a matrix of n rows; `length(i)` is the number of edges of row i.
  template <class Length>
  void reset(int n, Length&& length) {
    rows_ = n;
    const int slices = (n + slice - 1) / slice;
    start_.resize(slices + 1);
    start_[0] = 0;
    parallel_for(slices, n, [&](int s) {
      int longest = 0;
      for (int i = s * slice; i < std::min(n, (s + 1) * slice); ++i) longest = std::max(longest, length(i));
      start_[s + 1] = static_cast<std::size_t>(longest) * slice;
    });
    for (int s = 0; s < slices; ++s) start_[s + 1] += start_[s];
    if (column_.size() < start_[slices]) {
      column_.resize(start_[slices] + start_[slices] / 8);
      edge_.resize(column_.size());
    }
    constant_.assign(static_cast<std::size_t>(slices) * slice, 0);
    diagonal_.assign(static_cast<std::size_t>(slices) * slice, 1);
  }

  /// Writes row i: edges (column, weight) for k < n and the constant term; the diagonal follows.
  template <class Edge>
  void set_row(int i, int n, float constant, Edge&& edge) {
    const int s = i / slice, lane = i % slice;
    const std::size_t first = start_[s] + lane;
    const int length = static_cast<int>((start_[s + 1] - start_[s]) / slice);
    int* __restrict to_column = column_.data() + first;
    float* __restrict to_edge = edge_.data() + first;
    double even = constant, odd = 0;  // two sums, so that one need not wait for the other
    for (int k = 0; k < n; ++k, to_column += slice, to_edge += slice) {
      const auto [column, weight] = edge(k);
      *to_column = column;
      *to_edge = weight;
      even += weight;
      std::swap(even, odd);
    }
    const double diagonal = even + odd;
    for (int k = n; k < length; ++k, to_column += slice, to_edge += slice) {
      *to_column = i;
      *to_edge = 0;
    }
    constant_[i] = constant;
    diagonal_[i] = static_cast<float>(diagonal);
  }

  /// Rows beyond the last, up to a whole slice, get no edges.
  void pad() {
    const int slices = static_cast<int>(start_.size()) - 1;
    for (int i = rows_; i < slices * slice; ++i) set_row_empty(i);
  }

  /// Calls visit(j, a_ij) for the edges of row i that are not padding.
  template <class Visit>
  void for_edges(int i, Visit&& visit) const {
    const int s = i / slice;
    for (std::size_t k = start_[s] + i % slice; k < start_[s + 1]; k += slice)
      if (edge_[k] != 0) visit(column_[k], edge_[k]);
  }

  /// Length vectors must have: a whole number of slices.
  std::size_t padded_rows() const { return constant_.size(); }

  /// y = A x. T = double for the equation, float inside the preconditioner.
  template <class T>
  void multiply(const std::vector<T>& x, std::vector<T>& y) const {
    const std::ptrdiff_t slices = static_cast<std::ptrdiff_t>(start_.size()) - 1;
    parallel_for(slices, rows_, [&](std::ptrdiff_t s) {
      T sum[slice], own[slice];
      for (int lane = 0; lane < slice; ++lane) {
        own[lane] = x[s * slice + lane];
        sum[lane] = T(constant_[s * slice + lane]) * own[lane];
      }
      const int* column = column_.data() + start_[s];
      const float* edge = edge_.data() + start_[s];
      const T* values = x.data();
      for (std::size_t k = start_[s]; k < start_[s + 1]; k += slice, column += slice, edge += slice)
#pragma omp simd
        for (int lane = 0; lane < slice; ++lane) sum[lane] += T(edge[lane]) * (own[lane] - values[column[lane]]);
      for (int lane = 0; lane < slice; ++lane) y[s * slice + lane] = sum[lane];
    });
  }

 private:
  void set_row_empty(int i) {
    const int s = i / slice, lane = i % slice;
    for (std::size_t k = start_[s] + lane; k < start_[s + 1]; k += slice) {
      column_[k] = s * slice;
      edge_[k] = 0;
    }
    constant_[i] = 0;
    diagonal_[i] = 1;
  }

  int rows_ = 0;
  std::vector<std::size_t> start_;
  UninitialisedVector<int> column_;
  UninitialisedVector<float> edge_;
  std::vector<float> constant_, diagonal_;
};

}  // namespace tern::fluid
