// Sums of arrays in blocks of fixed length, vectorised inside a block (the order of additions is fixed when compiled).

#include "base/parallel.hpp"

#include <cassert>

namespace tern {

namespace {

template <class BlockSum>
double sum_of_blocks(std::ptrdiff_t n, BlockSum&& block_sum) {
  const std::ptrdiff_t blocks = (n + reduction_block - 1) / reduction_block;
  const auto of_block = [&](std::ptrdiff_t block) {
    return block_sum(block * reduction_block, std::min(n, (block + 1) * reduction_block));
  };
  double total = 0;
  if (n < parallel_threshold) {
    for (std::ptrdiff_t block = 0; block < blocks; ++block) total += of_block(block);
    return total;
  }
  std::vector<double> partial(static_cast<std::size_t>(blocks));
  parallel_for(blocks, n, [&](std::ptrdiff_t block) { partial[static_cast<std::size_t>(block)] = of_block(block); });
  for (const double value : partial) total += value;
  return total;
}

}  // namespace

double ordered_sum(std::span<const double> values) {
  const double* v = values.data();
  return sum_of_blocks(std::ssize(values), [v](std::ptrdiff_t begin, std::ptrdiff_t end) {
    double sum = 0;
#pragma omp simd reduction(+ : sum)
    for (std::ptrdiff_t i = begin; i < end; ++i) sum += v[i];
    return sum;
  });
}

double ordered_dot(std::span<const double> a, std::span<const double> b) {
  assert(a.size() == b.size());
  const double *x = a.data(), *y = b.data();
  return sum_of_blocks(std::ssize(a), [x, y](std::ptrdiff_t begin, std::ptrdiff_t end) {
    double sum = 0;
#pragma omp simd reduction(+ : sum)
    for (std::ptrdiff_t i = begin; i < end; ++i) sum += x[i] * y[i];
    return sum;
  });
}

}  // namespace tern
