// Enclosed regions, compatible source, account of the volume that walls push into them.

#include "fluid/pressure/enclosed_regions.hpp"

#include <numeric>

#include <fmt/format.h>

#include "base/error.hpp"
#include "base/log.hpp"

namespace tern::fluid {
namespace {

constexpr double tolerated_volume_error = 1e-4;  ///< of a region; more is worth a warning

}  // namespace

void EnclosedRegions::add_up(const std::vector<double>& values) {
  sum.assign(size.size(), 0);
  for (std::size_t i = 0; i < region.size(); ++i)
    if (region[i] >= 0) sum[region[i]] += values[i];
}

void EnclosedRegions::subtract_means(std::vector<double>& values) {
  add_up(values);
  for (std::size_t k = 0; k < size.size(); ++k) sum[k] /= size[k];
  for (std::size_t i = 0; i < region.size(); ++i)
    if (region[i] >= 0) values[i] -= sum[region[i]];
}

template <int D>
void find_enclosed_regions(const Neighbours<D>& neighbours, const std::vector<ParticleClass>& particle_class,
                           const std::vector<std::uint8_t>& at_surface, EnclosedRegions& regions) {
  const int n = static_cast<int>(particle_class.size());
  std::vector<std::uint8_t>& tied = regions.tied;
  auto &region = regions.region, &size = regions.size, &queue = regions.queue;
  tied.resize(n);
  size.clear();
  bool any_tied = false;
  for (int i = 0; i < n; ++i) {
    tied[i] = particle_class[i].pressure_unknown() && at_surface[i] != 0;
    any_tied = any_tied || tied[i];
  }
  int loose = 0;
  // Rows are in the order of the particles, so the ties a sweep brings along are at the end it comes from.
  const auto tied_at = [&](int i, bool from_the_end) {
    const int first = neighbours.begin[i], last = first + neighbours.length[i] - 1;
    for (int n_th = 0; n_th <= last - first; ++n_th) {
      const int k = from_the_end ? last - n_th : first + n_th;
      if (tied[neighbours.column(k)] && neighbours.weight[k] != 0) return true;
    }
    return false;
  };
  const auto sweep_over = [&](int i, bool backwards) {
    if (!particle_class[i].pressure_unknown() || tied[i]) return;
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
    region.clear();
    return;
  }
  region.assign(n, -1);
  for (int start = 0; start < n; ++start) {
    if (!particle_class[start].pressure_unknown() || tied[start] || region[start] >= 0) continue;
    const int number = static_cast<int>(size.size());
    bool reaches_tie = false;
    queue.assign(1, start);
    region[start] = number;
    for (std::size_t next = 0; next < queue.size(); ++next) {
      const int i = queue[next];
      neighbours.for_each(i, [&](int j, float) {
        reaches_tie = reaches_tie || tied[j];
        if (!particle_class[j].pressure_unknown() || tied[j] || region[j] >= 0) return;
        region[j] = number;
        queue.push_back(j);
      });
    }
    if (reaches_tie)
      for (int i : queue) region[i] = -1, tied[i] = 1;
    else
      size.push_back(static_cast<int>(queue.size()));
  }
}

template <int D>
void check_that_none_is_enclosed(const Domain<D>& domain, const Neighbours<D>& neighbours, const std::vector<ParticleClass>& particle_class,
                                 const std::vector<std::uint8_t>& at_surface, EnclosedRegions& regions) {
  const int n = static_cast<int>(neighbours.rows());
  std::vector<std::uint8_t>& tied = regions.tied;
  regions.size.clear();
  tied.assign(particle_class.size(), 0);
  for (int i = 0; i < n; ++i) tied[i] = particle_class[i].pressure_unknown() && at_surface[i] != 0;
  const auto sweep_over = [&](int i, std::int64_t& loose, std::int64_t& newly_tied) {
    if (!particle_class[i].pressure_unknown() || tied[i]) return;
    for (int k = neighbours.begin[i]; k < neighbours.begin[i] + neighbours.length[i] && !tied[i]; ++k)
      tied[i] = neighbours.weight[k] != 0 && tied[neighbours.column(k)];
    tied[i] ? ++newly_tied : ++loose;
  };
  // Ties go from rank to rank: as many rounds as ranks lie between the surface and the bottom.
  while (true) {
    domain.particles().update(tied);
    std::int64_t found[] = {0, 0}, seen = 0;  // loose, newly tied
    for (int i = n - 1; i >= 0; --i) sweep_over(i, seen, found[1]);
    for (int i = 0; i < n; ++i) sweep_over(i, found[0], found[1]);
    domain.ranks().sum(std::span<std::int64_t>(found));
    if (found[0] == 0) return;
    if (found[1] == 0) break;
  }
  throw EndOfModel(
      "Not with --ranks: fluid that walls enclose all round, without a free surface. Run the case without --ranks, or open the container.");
}

void select_regions(const EnclosedRegions& regions, const std::vector<std::uint8_t>& property, bool value, EnclosedRegions& selected) {
  selected.size.clear();
  std::vector<int>& number = selected.queue;
  number.assign(regions.size.size(), -1);
  for (std::size_t k = 0; k < regions.size.size(); ++k)
    if ((property[k] != 0) == value) {
      number[k] = static_cast<int>(selected.size.size());
      selected.size.push_back(regions.size[k]);
    }
  if (selected.size.empty()) return;
  selected.region.resize(regions.region.size());
  for (std::size_t i = 0; i < regions.region.size(); ++i) selected.region[i] = regions.region[i] < 0 ? -1 : number[regions.region[i]];
}

template <int D>
void account_for_enclosed_fluid(const Reference<D>& reference, const Window& window, const Boundary<D>& boundary,
                                const std::vector<double>& source, EnclosedRegions& regions, State<D>& state) {
  const double volume = reference.constants.volume;
  const std::ptrdiff_t enclosed_rows = std::accumulate(regions.size.begin(), regions.size.end(), std::ptrdiff_t{0});
  state.fills_enclosure = state.fills_enclosure || (enclosed_rows == static_cast<std::ptrdiff_t>(state.size()) &&
                                                    !boundary.walls.moving() && boundary.surface.size() == 0);
  EnclosedAccount& account = state.enclosed;
  account.any = true;
  regions.add_up(source);
  for (double b : regions.sum) {
    const double flux = -window.duration / reference.constants.density * b;
    if (std::abs(flux) > std::abs(account.largest_flux)) account.largest_flux = flux;
  }
  if (!boundary.walls.moving() && boundary.surface.size() == 0) return;
  regions.sum.assign(regions.size.size(), 0);
  for (std::size_t i = 0; i < regions.region.size(); ++i) {
    // What the faces seen by a particle push into the fluid per time, as the divergence counts it.
    if (regions.region[i] >= 0) regions.sum[regions.region[i]] += 2 * volume * boundary.sums.flux[i];
  }
  account.pushed.resize(reference.particles, 0);
  int largest = -1;
  for (std::size_t i = 0; i < regions.region.size(); ++i) {
    const int k = regions.region[i];
    if (k < 0) continue;
    double& pushed = account.pushed[state.id[i]];
    pushed += window.duration * regions.sum[k] / (regions.size[k] * volume);
    if (std::abs(pushed) > std::abs(account.volume_error)) account.volume_error = pushed, largest = k;
  }
  if (account.warned || largest < 0 || std::abs(account.volume_error) < tolerated_volume_error) return;
  account.warned = true;
  log_warning(
      fmt::format("A wall moves {} sealed fluid, which cannot change its volume: by t = {:.6g} s it has swept {:.3g} of the volume of "
                  "{} particles ({:.4g} m^{}); their pressure is what it would be at constant volume. Open the container, or leave "
                  "room for a free surface.",
                  account.volume_error > 0 ? "into" : "away from", window.begin + window.duration, std::abs(account.volume_error),
                  regions.size[largest], regions.size[largest] * volume, D));
}

#define TERN_INSTANTIATE(D)                                                                                                         \
  template void check_that_none_is_enclosed<D>(const Domain<D>&, const Neighbours<D>&, const std::vector<ParticleClass>&,           \
                                               const std::vector<std::uint8_t>&, EnclosedRegions&);                                 \
  template void find_enclosed_regions<D>(const Neighbours<D>&, const std::vector<ParticleClass>&, const std::vector<std::uint8_t>&, \
                                         EnclosedRegions&);                                                                         \
  template void account_for_enclosed_fluid<D>(const Reference<D>&, const Window&, const Boundary<D>&, const std::vector<double>&,   \
                                              EnclosedRegions&, State<D>&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
