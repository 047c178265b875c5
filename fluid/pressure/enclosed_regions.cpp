// Sealed fluid: pools, compatible source, account of the volume that walls push into them.

#include "fluid/pressure/enclosed_regions.hpp"

#include <numeric>

#include <fmt/format.h>

#include "base/log.hpp"
#include "fluid/fluid.hpp"

namespace tern::fluid {
namespace {

constexpr double tolerated_volume_error = 1e-4;  ///< of a pool; more is worth a warning

}  // namespace

void SealedPools::add_up(const std::vector<double>& values) {
  sum.assign(size.size(), 0);
  for (std::size_t i = 0; i < pool.size(); ++i)
    if (pool[i] >= 0) sum[pool[i]] += values[i];
}

void SealedPools::subtract_means(std::vector<double>& values) {
  add_up(values);
  for (std::size_t k = 0; k < size.size(); ++k) sum[k] /= size[k];
  for (std::size_t i = 0; i < pool.size(); ++i)
    if (pool[i] >= 0) values[i] -= sum[pool[i]];
}

template <int D>
void find_sealed_pools(const Neighbours<D>& neighbours, const std::vector<std::uint8_t>& active, const std::vector<float>& constant,
                       SealedPools& pools) {
  const int n = static_cast<int>(active.size());
  std::vector<std::uint8_t>& tied = pools.tied;
  auto &pool = pools.pool, &size = pools.size, &queue = pools.queue;
  tied.resize(n);
  size.clear();
  bool any_tied = false;
  for (int i = 0; i < n; ++i) {
    tied[i] = active[i] && constant[i] > 0;
    any_tied = any_tied || tied[i];
  }
  int loose = 0;
  // Rows are in the order of the particles, so the ties a sweep brings along are at the end it comes from.
  const auto tied_at = [&](int i, bool from_the_end) {
    const int first = neighbours.begin[i], last = first + neighbours.count[i] - 1;
    for (int k = 0; k <= last - first; ++k)
      if (tied[neighbours.column[from_the_end ? last - k : first + k]]) return true;
    return false;
  };
  const auto sweep_over = [&](int i, bool backwards) {
    if (!active[i] || tied[i]) return;
    tied[i] = tied_at(i, backwards);
    loose += !tied[i];
  };
  // Backwards first: where gravity points down, the surface and its ties come last.
  if (any_tied)
    for (int i = n - 1; i >= 0; --i) sweep_over(i, true);
  if (any_tied && loose > 0) {
    loose = 0;
    for (int i = 0; i < n; ++i) sweep_over(i, false);
  }
  if (any_tied && loose == 0) {
    pool.clear();
    return;
  }
  pool.assign(n, -1);
  for (int start = 0; start < n; ++start) {
    if (!active[start] || tied[start] || pool[start] >= 0) continue;
    const int number = static_cast<int>(size.size());
    bool reaches_tie = false;
    queue.assign(1, start);
    pool[start] = number;
    for (std::size_t next = 0; next < queue.size(); ++next) {
      const int i = queue[next];
      for (int k = neighbours.begin[i]; k < neighbours.begin[i] + neighbours.count[i]; ++k) {
        const int j = neighbours.column[k];
        reaches_tie = reaches_tie || tied[j];
        if (!active[j] || tied[j] || pool[j] >= 0) continue;
        pool[j] = number;
        queue.push_back(j);
      }
    }
    if (reaches_tie)
      for (int i : queue) pool[i] = -1, tied[i] = 1;
    else
      size.push_back(static_cast<int>(queue.size()));
  }
}

template <int D>
void Fluid<D>::account_for_sealed_fluid() {
  const std::ptrdiff_t sealed_rows = std::accumulate(pools_.size.begin(), pools_.size.end(), std::ptrdiff_t{0});
  enclosed_ = enclosed_ || (sealed_rows == static_cast<std::ptrdiff_t>(state_.size()) && !walls_.moving() && surface_.size() == 0);
  SealedAccount& account = sealed_account_;
  account.any = true;
  pools_.add_up(source_);
  for (double b : pools_.sum) {
    const double flux = -duration_s_ / constants_.density * b;
    if (std::abs(flux) > std::abs(account.largest_flux)) account.largest_flux = flux;
  }
  if (!walls_.moving() && surface_.size() == 0) return;
  pools_.sum.assign(pools_.size.size(), 0);
  for (std::size_t i = 0; i < pools_.pool.size(); ++i) {
    // What the faces seen by a particle push into the fluid per time, as the divergence counts it.
    if (pools_.pool[i] >= 0) pools_.sum[pools_.pool[i]] += 2 * constants_.volume * boundary_.flux[i];
  }
  pools_.pushed.resize(initial_particles_, 0);
  int largest = -1;
  for (std::size_t i = 0; i < pools_.pool.size(); ++i) {
    const int k = pools_.pool[i];
    if (k < 0) continue;
    double& pushed = pools_.pushed[state_.id[i]];
    pushed += duration_s_ * pools_.sum[k] / (pools_.size[k] * constants_.volume);
    if (std::abs(pushed) > std::abs(account.volume_error)) account.volume_error = pushed, largest = k;
  }
  if (account.warned || largest < 0 || std::abs(account.volume_error) < tolerated_volume_error) return;
  account.warned = true;
  log_warning(
      fmt::format("A wall moves {} sealed fluid, which cannot change its volume: by t = {:.6g} s it has swept {:.3g} of the volume of "
                  "{} particles ({:.4g} m^{}); their pressure is what it would be at constant volume. Open the container, or leave "
                  "room for a free surface.",
                  account.volume_error > 0 ? "into" : "away from", begin_s_ + duration_s_, std::abs(account.volume_error),
                  pools_.size[largest], pools_.size[largest] * constants_.volume, D));
}

#define TERN_INSTANTIATE(D)                                                                                                            \
  template void find_sealed_pools<D>(const Neighbours<D>&, const std::vector<std::uint8_t>&, const std::vector<float>&, SealedPools&); \
  template void Fluid<D>::account_for_sealed_fluid();
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
