#pragma once
// Loops and reductions with the same bits for any number of threads. A reduction cuts its range into blocks of fixed length, each block is
// reduced by one thread from its first index to its last, and the block results are combined in the order of the blocks.

#include <omp.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

namespace tern {

inline constexpr std::ptrdiff_t reduction_block = 1024;     ///< indices per block; changing it changes last bits
inline constexpr std::ptrdiff_t parallel_threshold = 8192;  ///< below this a parallel region costs more than it saves

namespace detail {

/// A function of its own, so that one thread and several run the same instructions.
template <class Index, class Work>
[[gnu::noinline]] void for_range(Index begin, Index end, const Work& work) {
  for (Index i = begin; i < end; ++i) work(i);
}

}  // namespace detail

/// work(i) for each i in [0, n), in equal ranges for all threads where `items`, what the loop works on in all, are worth it. `work` must
/// not throw. One thread enters no parallel region: at the end of each, GCC's runtime makes a system call, also for a team of one.
template <class Index, class Work>
void parallel_for(Index n, std::ptrdiff_t items, const Work& work) {
  if (items < parallel_threshold || omp_get_max_threads() == 1) {
    detail::for_range(Index{0}, n, work);
    return;
  }
#pragma omp parallel
  {
    const std::ptrdiff_t threads = omp_get_num_threads(), thread = omp_get_thread_num();
    detail::for_range(static_cast<Index>(n * thread / threads), static_cast<Index>(n * (thread + 1) / threads), work);
  }
}

template <class Index, class Work>
void parallel_for(Index n, const Work& work) {
  parallel_for(n, n, work);
}

/// combine(...combine(combine(initial, term(0)), term(1))...) in the block order described above. `initial` must be
/// neutral (0 of a sum): every block starts from it. `term(i)` is called once per i in [0, n), concurrently, and must
/// not throw. T is a number, a Vector<D> or anything copyable.
template <class T, class Term, class Combine>
T ordered_fold(std::ptrdiff_t n, const T& initial, Term&& term, Combine&& combine) {
  const std::ptrdiff_t blocks = (n + reduction_block - 1) / reduction_block;
  const auto fold_block = [&](std::ptrdiff_t block) {
    T value = initial;
    const std::ptrdiff_t end = std::min(n, (block + 1) * reduction_block);
    for (std::ptrdiff_t i = block * reduction_block; i < end; ++i) value = combine(value, T(term(i)));
    return value;
  };
  if (blocks == 0) return initial;
  if (n < parallel_threshold) {
    T total = fold_block(0);
    for (std::ptrdiff_t block = 1; block < blocks; ++block) total = combine(total, fold_block(block));
    return total;
  }
  // Kept from call to call: steps shall allocate nothing. The reference is to that of the calling thread.
  thread_local std::vector<T> kept;
  std::vector<T>& partial = kept;
  partial.resize(static_cast<std::size_t>(blocks), initial);
  parallel_for(blocks, n, [&](std::ptrdiff_t block) { partial[static_cast<std::size_t>(block)] = fold_block(block); });
  T total = partial[0];
  for (std::size_t block = 1; block < partial.size(); ++block) total = combine(total, partial[block]);
  return total;
}

/// Sum of term(i), i in [0, n); `zero` gives the type, e.g. 0.0 or Vector<D>(Vector<D>::Zero()).
template <class T, class Term>
T ordered_reduce(std::ptrdiff_t n, const T& zero, Term&& term) {
  return ordered_fold(n, zero, term, [](const T& a, const T& b) { return T(a + b); });
}

/// Largest of `lowest` and term(i), i in [0, n); not-a-number if any term is, so that a check on the result sees it.
template <class Term>
double ordered_max(std::ptrdiff_t n, double lowest, Term&& term) {
  return ordered_fold(n, lowest, term, [](double a, double b) { return a > b || std::isnan(a) ? a : b; });
}

/// Sum of the values.
double ordered_sum(std::span<const double> values);

/// Sum of a_i b_i; both of the same length.
double ordered_dot(std::span<const double> a, std::span<const double> b);

}  // namespace tern
