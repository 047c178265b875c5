// Enclosed regions, compatible source, account of the volume that walls push into them.

#include "fluid/pressure/enclosed_regions.hpp"

#include <algorithm>
#include <numeric>

#include <fmt/format.h>

#include "base/error.hpp"
#include "base/log.hpp"
#include "fluid/boundary/interface_reaction.hpp"
#include "scene/geometry.hpp"
#include "scene/scene_check.hpp"

namespace tern::fluid {
namespace {

/// Of a region; more is worth a warning. The patches of a round wall that moves sweep some 1e-4 of it though their sum should be 0.
constexpr double tolerated_volume_error = 1e-3;
constexpr double tolerated_lag = 0.1;  ///< of what bodies have swept; worth a warning where that is more than ...
constexpr double least_way = 0.01;     ///< spacings
constexpr double kept = 0.8;           ///< per window, of how a region has answered

}  // namespace

void EnclosedRegions::add_up(const std::vector<double>& values) {
  sum.assign(size.size(), 0);
  for (std::size_t i = 0; i < region.size(); ++i)
    if (region[i] >= 0) sum[region[i]] += values[i];
  ranks.sum(std::span(sum));
}

void EnclosedRegions::subtract_means(std::vector<double>& values) {
  add_up(values);
  for (std::size_t k = 0; k < size.size(); ++k) sum[k] /= size[k];
  for (std::size_t i = 0; i < region.size(); ++i)
    if (region[i] >= 0) values[i] -= sum[region[i]];
}

void EnclosedRegions::set_sums(const std::vector<double>& sums, double scale, std::vector<double>& values) {
  add_up(values);
  for (std::size_t k = 0; k < size.size(); ++k) sum[k] = (scale * sums[k] - sum[k]) / size[k];
  for (std::size_t i = 0; i < region.size(); ++i)
    if (region[i] >= 0) values[i] += sum[region[i]];
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
void find_enclosed_regions_of_ranks(const Domain<D>& domain, const Neighbours<D>& neighbours,
                                    const std::vector<ParticleClass>& particle_class, const std::vector<std::uint32_t>& label,
                                    const std::vector<std::uint8_t>& at_surface, EnclosedRegions& regions) {
  regions.ranks = domain.ranks();
  const int n = static_cast<int>(neighbours.rows());
  std::vector<std::uint8_t>& tied = regions.tied;
  regions.size.clear();
  tied.assign(particle_class.size(), 0);
  for (int i = 0; i < n; ++i) tied[i] = particle_class[i].pressure_unknown() && at_surface[i] != 0;
  // A neighbour with a tie is at the end of the row that the sweep comes from.
  const auto sweep_over = [&](int i, bool backwards, std::int64_t& loose, std::int64_t& newly_tied) {
    if (!particle_class[i].pressure_unknown() || tied[i]) return;
    const int first = neighbours.begin[i], last = first + neighbours.length[i] - 1;
    for (int n_th = 0; n_th <= last - first && !tied[i]; ++n_th) {
      const int k = backwards ? last - n_th : first + n_th;
      tied[i] = neighbours.weight[k] != 0 && tied[neighbours.column(k)];
    }
    tied[i] ? ++newly_tied : ++loose;
  };
  // Ties go from rank to rank: as many rounds as ranks lie between the surface and the bottom.
  std::int64_t loose = 0;
  for (bool goes_on = true; goes_on;) {
    domain.particles().update(tied);
    std::int64_t found[] = {0, 0}, seen = 0;  // loose, newly tied
    for (int i = n - 1; i >= 0; --i) sweep_over(i, true, seen, found[1]);
    for (int i = 0; i < n; ++i) sweep_over(i, false, found[0], found[1]);
    domain.ranks().sum(std::span<std::int64_t>(found));
    loose = found[0];
    goes_on = loose > 0 && found[1] > 0;
  }
  if (loose == 0) return;

  // Parts of this rank that are connected here, each with the least label that any rank knows of it.
  constexpr std::uint32_t none = ~std::uint32_t{0};
  auto &part = regions.region, &queue = regions.queue;
  part.assign(n, -1);
  std::vector<std::uint32_t> least(particle_class.size(), none);
  std::vector<int> first{0};
  queue.clear();
  const auto is_loose = [&](int i) { return particle_class[i].pressure_unknown() && !tied[i]; };
  for (int start = 0; start < n; ++start) {
    if (!is_loose(start) || part[start] >= 0) continue;
    const int number = static_cast<int>(first.size()) - 1;
    part[start] = number;
    queue.push_back(start);
    for (std::size_t next = first.back(); next < queue.size(); ++next)
      neighbours.for_each(queue[next], [&](int j, float) {
        if (j >= n || !is_loose(j) || part[j] >= 0) return;
        part[j] = number;
        queue.push_back(j);
      });
    first.push_back(static_cast<int>(queue.size()));
  }
  for (const int i : queue) least[i] = label[i];
  for (bool changed = true; changed;) {
    changed = false;
    domain.particles().update(least);
    for (std::size_t k = 0; k + 1 < first.size(); ++k) {
      std::uint32_t low = none;
      for (int m = first[k]; m < first[k + 1]; ++m) {
        low = std::min(low, least[queue[m]]);
        neighbours.for_each(queue[m], [&](int j, float) { low = std::min(low, least[j]); });
      }
      for (int m = first[k]; m < first[k + 1]; ++m) changed = changed || least[queue[m]] != low, least[queue[m]] = low;
    }
    changed = domain.ranks().any(changed);
  }
  std::vector<std::uint32_t> labels;
  for (std::size_t k = 0; k + 1 < first.size(); ++k) labels.push_back(least[queue[first[k]]]);
  domain.ranks().gather_on_all(labels);
  std::sort(labels.begin(), labels.end());
  labels.erase(std::unique(labels.begin(), labels.end()), labels.end());
  std::vector<std::int64_t> size(labels.size(), 0);
  for (const int i : queue) {
    part[i] = static_cast<int>(std::lower_bound(labels.begin(), labels.end(), least[i]) - labels.begin());
    ++size[part[i]];
  }
  domain.ranks().sum(std::span(size));
  regions.size.assign(size.begin(), size.end());
}

void select_regions(const EnclosedRegions& regions, const std::vector<int>& number, EnclosedRegions& selected) {
  selected.ranks = regions.ranks;
  selected.size.clear();
  for (std::size_t k = 0; k < regions.size.size(); ++k) {
    if (number[k] < 0) continue;
    selected.size.resize(std::max(selected.size.size(), static_cast<std::size_t>(number[k]) + 1), 0);
    selected.size[number[k]] += regions.size[k];
  }
  if (selected.size.empty()) return;
  selected.region.resize(regions.region.size());
  for (std::size_t i = 0; i < regions.region.size(); ++i) selected.region[i] = regions.region[i] < 0 ? -1 : number[regions.region[i]];
}

namespace {

/// Number of the wall whose patches the particles of each region see most of; -1: no wall moves, none is seen, or the region is counted in
/// the frame at rest, of a plane wall that is not seen patch by patch.
template <int D>
std::vector<int> main_walls(const Boundary<D>& boundary, const EnclosedRegions& regions) {
  std::vector<int> result(regions.size.size(), -1);
  if (!boundary.walls.moving()) return result;
  const std::vector<Wall<D>>& walls = boundary.walls.all();
  const std::size_t columns = walls.size() + 1;
  std::vector<double> seen(regions.size.size() * columns, 0);
  const FaceRows& rows = boundary.wall_rows;
  for (std::size_t i = 0; i < regions.region.size(); ++i) {
    if (regions.region[i] < 0) continue;
    double* const of_region = &seen[static_cast<std::size_t>(regions.region[i]) * columns];
    of_region[walls.size()] += rows.before_plane(static_cast<std::ptrdiff_t>(i));
    for (int entry = rows.begin[i]; entry < rows.begin[i] + rows.count[i]; ++entry)
      of_region[boundary.walls.wall_of(rows.face[entry])] += rows.weight[entry];
  }
  regions.ranks.sum(std::span(seen));
  for (std::size_t r = 0; r < result.size(); ++r) {
    const auto first = seen.begin() + static_cast<std::ptrdiff_t>(r * columns);
    if (first[static_cast<std::ptrdiff_t>(walls.size())] > 0) continue;
    const auto most = std::max_element(first, first + static_cast<std::ptrdiff_t>(walls.size()));
    if (*most > 0) result[r] = static_cast<int>(most - first);
  }
  return result;
}

/// Whether another wall is in front of the patch k, so that no fluid is. `shapes`: of all walls, without their open faces.
template <int D>
bool is_covered(const Walls<D>& walls, const std::vector<Shape>& shapes, double spacing, std::size_t k) {
  constexpr double before = 1e-3;  // spacings
  const Vector<D> x = walls.faces().position[k] + before * spacing * walls.faces().normal[k];
  const std::vector<Wall<D>>& all = walls.all();
  for (std::size_t w = 0; w < all.size(); ++w) {
    if (w == walls.wall_of(static_cast<int>(k))) continue;
    if ((signed_distance<D>(shapes[w], all[w].reference(x)) < 0) != all[w].scene.container) return true;
  }
  return false;
}

/// What a patch of a wall counts for where walls move, over the weights with which particles see it: one over the share of it that they
/// fill.
template <int D>
void find_shares_of_walls(const Constants<D>& constants, const Boundary<D>& boundary, const EnclosedRegions& regions,
                          std::vector<double>& share) {
  const FaceRows& rows = boundary.wall_rows;
  const Faces<D>& faces = boundary.walls.faces();
  share.assign(faces.size(), 0);
  for (std::size_t i = 0; i < regions.region.size(); ++i)
    for (int entry = rows.begin[i]; entry < rows.begin[i] + rows.count[i]; ++entry)
      share[rows.face[entry]] += 2 * constants.volume * rows.weight[entry] / faces.area[rows.face[entry]];
  // An image of a patch is the patch again, that other particles see.
  for (std::size_t k = 0; k < share.size(); ++k)
    if (const auto original = static_cast<std::size_t>(faces.original_of(k)); original != k) share[original] += share[k];
  boundary.patches.collect(share, [](double& own, double other) { own += other; });
  boundary.patches.update(share);
  for (std::size_t k = 0; k < share.size(); ++k) share[k] = share[faces.original_of(k)];
  std::vector<Shape> shapes;
  for (const Wall<D>& wall : boundary.walls.all()) shapes.push_back(without_open_faces(wall.scene));
  for (std::size_t k = 0; k < share.size(); ++k)
    share[k] = share[k] > least_seen && !is_covered(boundary.walls, shapes, constants.spacing, k) ? 1 / share[k] : 0;
}

/// How far the point of a wall that is now at x has come since the wall was at `before` [m].
template <int D>
Vector<D> moved(const Wall<D>& wall, const Placement<D>& before, const Vector<D>& x) {
  return wall.scene.motion ? Vector<D>(x - before(wall.reference(x))) : Vector<D>(Vector<D>::Zero());
}

}  // namespace

template <int D>
void FaceMotion<D>::find(double duration, const Faces<D>& surface, const State<D>& state) {
  for (auto* values : {&place, &displacement, &mean_normal, &turn}) values->resize(surface.size());
  if (state.face.size() != surface.size()) {  // from the begin of this window
    time = 0.5 * duration;
    for (std::size_t k = 0; k < surface.size(); ++k) {
      place[k] = surface.position[k];
      displacement[k] = time * surface.velocity[k];
      mean_normal[k] = surface.normal[k];
      turn[k].setZero();
    }
    return;
  }
  time = 0.5 * (duration + state.last_duration);
  for (std::size_t k = 0; k < surface.size(); ++k) {
    const Vector<D> change = surface.normal[k] - state.face[k] / surface.area[k];
    turn[k] = (0.5 * duration / time) * change;
    // A path that keeps its speed along a normal that turns leaves the chord by this; a sway that windows do not resolve has no part in it.
    place[k] = surface.position[k] + 0.25 * duration * surface.velocity[k].dot(turn[k]) * surface.normal[k];
    displacement[k] = place[k] - state.face_position[k];
    mean_normal[k] = surface.normal[k] - 0.5 * change;
  }
}

template <int D>
void SweptVolume<D>::find(const Constants<D>& constants, double duration, const InterfaceCondition<D>& load, const Boundary<D>& boundary,
                          const EnclosedRegions& regions, const State<D>& state) {
  const bool first = load.surface_velocity.empty(), is_answered = load.answered_change.size() == boundary.surface.size();
  const Faces<D>&walls = boundary.walls.faces(), &surface = boundary.surface;
  const FaceRows &wall_rows = boundary.wall_rows, &surface_rows = boundary.surface_rows;
  if (first) motion.find(duration, surface, state);
  const std::vector<int> frame = main_walls(boundary, regions);
  const std::vector<Wall<D>>& all = boundary.walls.all();
  std::vector<Placement<D>> before(all.size());  // where walls were when `motion` begins
  const double begin = seconds(state.time) + 0.5 * duration - motion.time;
  for (std::size_t w = 0; w < all.size(); ++w)
    if (all[w].scene.motion) before[w] = placement<D>(*all[w].scene.motion, begin);
  if (first && boundary.walls.moving()) find_shares_of_walls(constants, boundary, regions, wall_share);
  const std::size_t count = regions.size.size();
  // One sum over the ranks: of each region, and the way and the area of all.
  enum Sum : std::size_t { of_rate, of_pushed_in, of_lasting, of_mean_size, of_change, of_taken_away, of_answered, of_square, kinds };
  sums.assign(kinds * count + 2, 0);
  for (std::size_t i = 0; i < regions.region.size(); ++i) {
    const int r = regions.region[i];
    if (r < 0) continue;
    const auto of_frame = [&](const Vector<D>& position) -> Vector<D> {
      return frame[r] < 0 ? Vector<D>(Vector<D>::Zero()) : all[frame[r]].velocity(position);
    };
    const auto frame_moved = [&](const Vector<D>& position) -> Vector<D> {
      return frame[r] < 0 ? Vector<D>(Vector<D>::Zero()) : moved(all[frame[r]], before[frame[r]], position);
    };
    double by_walls = 0, by_surface = 0, pushed = 0, change = 0, way_of_surface = 0, area_of_surface = 0;
    if (boundary.walls.moving())
      for (int entry = wall_rows.begin[i]; entry < wall_rows.begin[i] + wall_rows.count[i]; ++entry) {
        const int k = wall_rows.face[entry];
        const double weight = wall_share[k] * wall_rows.weight[entry];
        const int w = static_cast<int>(boundary.walls.wall_of(k));
        by_walls += weight * (walls.velocity[k] - of_frame(walls.position[k])).dot(walls.normal[k]);
        pushed += weight * (moved(all[w], before[w], walls.position[k]) - frame_moved(walls.position[k])).dot(walls.normal[k]);
      }
    for (int entry = surface_rows.begin[i]; entry < surface_rows.begin[i] + surface_rows.count[i]; ++entry) {
      const int k = surface_rows.face[entry];
      const double weight = boundary.sums.swept_share[k] * surface_rows.weight[entry];
      const Vector<D> frame_velocity = of_frame(surface.position[k]);
      by_surface += weight * (surface.velocity[k] - frame_velocity).dot(surface.normal[k] + motion.turn[k]);
      if (is_answered) change += weight * load.answered_change[k].dot(surface.normal[k] + motion.turn[k]);
      const double swept = weight * (motion.displacement[k] - frame_moved(motion.place[k])).dot(motion.mean_normal[k]);
      pushed += swept;
      way_of_surface += std::abs(swept);
      area_of_surface += weight;
    }
    const auto sum = [&](Sum kind) -> double& { return sums[kinds * static_cast<std::size_t>(r) + kind]; };
    sum(of_rate) += 2 * constants.volume * (by_walls + by_surface);
    sum(of_pushed_in) += 2 * constants.volume * pushed;
    sum(of_change) += 2 * constants.volume * change;
    if (const std::uint32_t old = state.region[i]; old != EnclosedPast::none) {  // its share of what was there
      const EnclosedPast& of = state.enclosed_past;
      sum(of_pushed_in) += of.pushed_in[old] / of.size[old];
      sum(of_lasting) += of.lasting[old] / of.size[old];
      sum(of_mean_size) += of.mean_size[old] / of.size[old];
      sum(of_taken_away) += of.taken_away[old] / of.size[old];
      sum(of_answered) += of.answered[old] / of.size[old];
      sum(of_square) += of.square[old] / of.size[old];
    }
    sums[kinds * count] += 2 * constants.volume * way_of_surface;
    sums[kinds * count + 1] += 2 * constants.volume * area_of_surface;
  }
  regions.ranks.sum(std::span(sums));
  way = sums[kinds * count];
  area = sums[kinds * count + 1];
  rate.resize(count);
  past.size = regions.size;
  for (std::vector<double>* values : {&past.pushed_in, &past.lasting, &past.mean_size, &past.taken_away, &past.answered, &past.square})
    values->resize(count);
  for (std::size_t r = 0; r < count; ++r) {
    const double* const sum = &sums[kinds * r];
    rate[r] = sum[of_rate];
    if (!first) continue;
    past.pushed_in[r] = sum[of_pushed_in];
    past.lasting[r] = sum[of_lasting] + newest_in_mean * (past.pushed_in[r] - sum[of_lasting]);
    past.mean_size[r] = sum[of_mean_size] + newest_in_mean * (std::abs(past.pushed_in[r]) - sum[of_mean_size]);
    past.answered[r] = kept * sum[of_answered] - (is_answered ? sum[of_change] * sum[of_taken_away] : 0);
    past.square[r] = kept * sum[of_square] + (is_answered ? sum[of_taken_away] * sum[of_taken_away] : 0);
  }
}

template <int D>
double SweptVolume<D>::answer(std::size_t region) const {
  constexpr double least = 0.5, most = 2;
  const double square = past.square[region];
  return square > 0 ? std::clamp(past.answered[region] / square, least, most) : 1;
}

template <int D>
double SweptVolume<D>::taken_away(std::size_t region, double duration) const {
  const double mean_size = past.mean_size[region];
  return level_taken_away(rate[region], past.pushed_in[region] / duration, mean_size > 0 ? past.lasting[region] / mean_size : 1);
}

template <int D>
void SweptVolume<D>::remember(double duration, const Faces<D>& surface, const EnclosedRegions& regions, State<D>& state) {
  if (!regions.any()) motion.find(duration, surface, state);  // fluid may be enclosed from the next window on
  state.last_duration = duration;
  state.face_position = motion.place;
  state.face.resize(surface.size());
  for (std::size_t k = 0; k < surface.size(); ++k) state.face[k] = surface.area[k] * surface.normal[k];
  for (std::size_t i = 0; i < state.size(); ++i) {
    const int r = regions.any() ? regions.region[i] : -1;
    state.region[i] = r >= 0 ? static_cast<std::uint32_t>(r) : EnclosedPast::none;
  }
  state.enclosed_past = regions.any() ? past : EnclosedPast{};
}

template <int D>
void SweptVolume<D>::watch_lag(const Constants<D>& constants, const Window& window, const EnclosedRegions& regions, State<D>& state) const {
  EnclosedAccount& account = state.enclosed;
  if (!regions.any()) return;
  account.way += way;
  double lag = 0;
  for (const double volume : past.pushed_in) lag = std::max(lag, std::abs(volume));
  if (account.warned_of_lag || account.way < least_way * constants.spacing * area || lag < tolerated_lag * account.way) return;
  account.warned_of_lag = true;
  if (!regions.ranks.first()) return;
  log_warning(fmt::format(
      "Bodies around enclosed fluid lag behind the volume that it has to keep: by {:.3g} m^{} at t = {:.6g} s, where their faces have "
      "swept {:.3g}. They answer its pressure faster than windows of {:.3g} s resolve, and loads and displacements are off while "
      "something moves them. Make the windows shorter until the lag is small: a smaller fluid.numerics.gravity_courant, courant, or both.",
      lag, D, window.begin + window.duration, account.way, window.duration));
}

template <int D>
void account_for_enclosed_fluid(const Reference<D>& reference, const Window& window, const Boundary<D>& boundary,
                                const std::vector<double>& source, const EnclosedRegions& beside_bodies, const SweptVolume<D>& swept,
                                EnclosedRegions& regions, State<D>& state) {
  const double volume = reference.constants.volume;
  const std::int64_t enclosed_rows = std::accumulate(regions.size.begin(), regions.size.end(), std::int64_t{0});
  const Ranks& ranks = regions.ranks;
  state.fills_enclosure = state.fills_enclosure || (enclosed_rows == ranks.sum(static_cast<std::int64_t>(state.size())) &&
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
  const std::vector<int> frame = main_walls(boundary, regions);
  const std::vector<Wall<D>>& walls = boundary.walls.all();
  const Faces<D>& faces = boundary.walls.faces();
  const FaceRows& rows = boundary.wall_rows;
  std::vector<double> share;
  if (boundary.walls.moving()) find_shares_of_walls(reference.constants, boundary, regions, share);
  for (std::size_t i = 0; i < regions.region.size(); ++i) {
    // What faces push into the fluid per time, of what a particle sees of them: walls in the frame of the main one.
    const int r = regions.region[i], k = beside_bodies.any() ? beside_bodies.region[i] : -1;
    if (r < 0) continue;
    if (k >= 0) regions.sum[r] += swept.rate[k] / beside_bodies.size[k];
    if (k >= 0 || !boundary.walls.moving()) continue;
    for (int entry = rows.begin[i]; entry < rows.begin[i] + rows.count[i]; ++entry) {
      const int patch = rows.face[entry];
      const Vector<D>& x = faces.position[patch];
      const Vector<D> of_frame = frame[r] < 0 ? Vector<D>(Vector<D>::Zero()) : walls[frame[r]].velocity(x);
      regions.sum[r] += 2 * volume * share[patch] * rows.weight[entry] * (faces.velocity[patch] - of_frame).dot(faces.normal[patch]);
    }
  }
  ranks.sum(std::span(regions.sum));
  account.pushed.resize(reference.particles, 0);
  std::vector<double> by_label;  // all ranks know what every particle has been pushed: it may come to them
  if (!ranks.alone()) by_label.assign(reference.particles, 0);
  std::vector<double>& pushed = ranks.alone() ? account.pushed : by_label;
  for (std::size_t i = 0; i < regions.region.size(); ++i)
    if (const int k = regions.region[i]; k >= 0) pushed[state.id[i]] += window.duration * regions.sum[k] / (regions.size[k] * volume);
  ranks.sum(std::span(by_label));
  for (std::size_t label = 0; label < by_label.size(); ++label) account.pushed[label] += by_label[label];
  std::int64_t largest = -1;
  for (std::size_t i = 0; i < regions.region.size(); ++i) {
    const int k = regions.region[i];
    if (k < 0) continue;
    const double own = account.pushed[state.id[i]];
    if (std::abs(own) > std::abs(account.volume_error)) account.volume_error = own, largest = k;
  }
  if (!ranks.alone()) {
    const bool has_it = ranks.most(std::abs(account.volume_error)) == std::abs(account.volume_error);
    const double value = has_it ? account.volume_error : 0, high = ranks.most(value), low = ranks.least(value);
    account.volume_error = high >= -low ? high : low;
    largest = ranks.most(has_it ? largest : -1);
  }
  if (account.warned || largest < 0 || std::abs(account.volume_error) < tolerated_volume_error) return;
  account.warned = true;
  if (!ranks.first()) return;
  log_warning(fmt::format(
      "A wall or a body moves {} sealed fluid, which cannot change its volume: by t = {:.6g} s it has swept {:.3g} of the volume of "
      "{} particles ({:.4g} m^{}); their pressure is what it would be at constant volume. Open the container, or leave "
      "room for a free surface.",
      account.volume_error > 0 ? "into" : "away from", window.begin + window.duration, std::abs(account.volume_error),
      regions.size[largest], regions.size[largest] * volume, D));
}

#define TERN_INSTANTIATE(D)                                                                                                               \
  template void find_enclosed_regions_of_ranks<D>(const Domain<D>&, const Neighbours<D>&, const std::vector<ParticleClass>&,              \
                                                  const std::vector<std::uint32_t>&, const std::vector<std::uint8_t>&, EnclosedRegions&); \
  template void find_enclosed_regions<D>(const Neighbours<D>&, const std::vector<ParticleClass>&, const std::vector<std::uint8_t>&,       \
                                         EnclosedRegions&);                                                                               \
  template struct FaceMotion<D>;                                                                                                          \
  template struct SweptVolume<D>;                                                                                                         \
  template void account_for_enclosed_fluid<D>(const Reference<D>&, const Window&, const Boundary<D>&, const std::vector<double>&,         \
                                              const EnclosedRegions&, const SweptVolume<D>&, EnclosedRegions&, State<D>&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
