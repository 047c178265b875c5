#include "fluid/pressure/yielding_surface.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/parallel.hpp"

namespace tern::fluid {
namespace {

constexpr double least_filled = 1e-3;  ///< of the half space before a point; at the end of the kernel w~ has both signs

}  // namespace

template <int D>
void YieldingSurface<D>::assemble(const Constants<D>& constants, const Ranks& ranks, const SurfaceResponse& response,
                                  const Boundary<D>& boundary, const std::vector<ParticleClass>& particle_class,
                                  const Prediction<D>& prediction, const std::vector<int>& at_structure) {
  ranks_ = ranks;
  response_ = response;
  if (!any()) return;
  const FaceRows& seen = boundary.surface_rows;
  const std::ptrdiff_t rows = static_cast<std::ptrdiff_t>(at_structure.size()), lumps = static_cast<std::ptrdiff_t>(response.mass.size());
  const std::ptrdiff_t per_point = static_cast<std::ptrdiff_t>(response.lumps_per_point(boundary.surface.size()));
  // A pressure p pushes a point with p A, whatever its particles fill of the half space before it: the sums over them are made up to that.
  transferred_.assign(boundary.surface.size(), 0);
  for (const int i : at_structure) {
    if (!particle_class[i].pressure_unknown()) continue;
    for (int entry = seen.begin[i]; entry < seen.begin[i] + seen.count[i]; ++entry)
      transferred_[seen.face[entry]] += 2 * constants.volume * seen.weight[entry];
  }
  ranks_.sum(std::span(transferred_));
  for (std::size_t s = 0; s < response_.share.size(); ++s) {
    const std::size_t k = s / static_cast<std::size_t>(per_point);
    const double filled = transferred_[k] / boundary.surface.area[k];
    if (filled > least_filled) response_.share[s] /= filled;
  }

  begin_.resize(rows + 1);
  begin_[0] = 0;
  for (std::ptrdiff_t m = 0; m < rows; ++m)
    begin_[m + 1] = begin_[m] + std::min<std::ptrdiff_t>(lumps, seen.count[at_structure[m]] * per_point);
  count_.assign(rows, 0);
  if (static_cast<std::ptrdiff_t>(lump_.size()) < begin_[rows]) {
    lump_.resize(begin_[rows] + begin_[rows] / 8);
    vector_.resize(lump_.size());
    counted_.resize(lump_.size());
    between_.resize(lump_.size());
  }
  parallel_for(rows, [&](std::ptrdiff_t m) {
    const int i = at_structure[m];
    if (!particle_class[i].pressure_unknown()) return;
    thread_local std::vector<int> place;  // in the row, of each lump that has one; -1 else
    if (static_cast<std::ptrdiff_t>(place.size()) < lumps) place.resize(lumps, -1);
    int* const lump = lump_.data() + begin_[m];
    Vector<D>*const vector = vector_.data() + begin_[m], *const between = between_.data() + begin_[m];
    Vector<D>* const counted = counted_.data() + begin_[m];
    int& count = count_[m];
    for (int entry = seen.begin[i]; entry < seen.begin[i] + seen.count[i]; ++entry) {
      const int k = seen.face[entry];
      const Vector<D> b = -2 * constants.volume * seen.weight[entry] * boundary.surface.normal[k];
      const double weight = constants.density * prediction.gravity[i].dot(boundary.surface.position[k] - prediction.position[i]);
      double sum = 0;
      for (std::ptrdiff_t s = k * per_point; s < (k + 1) * per_point; ++s) sum += response_.share[s];
      for (std::ptrdiff_t s = k * per_point; s < (k + 1) * per_point; ++s) {
        const double share = response_.share[s];
        if (share == 0) continue;
        const int a = static_cast<int>(response_.lump[s]);
        if (place[a] < 0) {
          place[a] = count;
          lump[count] = a;
          vector[count] = Vector<D>::Zero();
          counted[count] = Vector<D>::Zero();
          between[count++] = Vector<D>::Zero();
        }
        vector[place[a]] += share * b;
        counted[place[a]] += share / sum * b;
        between[place[a]] += share * weight * b;
      }
    }
    for (int e = 0; e < count; ++e) place[lump[e]] = -1;
  });

  first_.assign(lumps + 1, 0);
  for (std::ptrdiff_t m = 0; m < rows; ++m)
    for (std::ptrdiff_t e = begin_[m]; e < begin_[m] + count_[m]; ++e) ++first_[lump_[e] + 1];
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  if (static_cast<std::ptrdiff_t>(row_.size()) < first_[lumps]) {
    row_.resize(lump_.size());
    particle_.resize(lump_.size());
    entry_.resize(lump_.size());
    pushing_.resize(lump_.size());
  }
  for (std::ptrdiff_t m = 0; m < rows; ++m)
    for (std::ptrdiff_t e = begin_[m]; e < begin_[m] + count_[m]; ++e) {
      const std::ptrdiff_t to = first_[lump_[e]]++;
      row_[to] = static_cast<int>(m);
      particle_[to] = at_structure[m];
      entry_[to] = e;
      pushing_[to] = vector_[e];
    }
  std::rotate(first_.begin(), first_.end() - 1, first_.end());
  first_[0] = 0;

  scale_.resize(lumps);
  size_.assign(lumps, 0);
  parallel_for(lumps, rows, [&](std::ptrdiff_t a) {
    scale_[a] = constants.density / response_.mass[a];
    for (std::ptrdiff_t e = first_[a]; e < first_[a + 1]; ++e) size_[a] += scale_[a] * pushing_[e].norm();
  });
  ranks_.sum(std::span(size_));
  bound_.assign(rows, 0);
  parallel_for(rows, [&](std::ptrdiff_t m) {
    for (std::ptrdiff_t e = begin_[m]; e < begin_[m] + count_[m]; ++e) bound_[m] += vector_[e].norm() * size_[lump_[e]];
  });

  motion_.resize(lumps);
  carried_under_.clear();
}

template <int D>
void YieldingSurface<D>::set_carried_motion(const std::vector<double>& reference_pressure, const Boundary<D>& boundary) const {
  if (carried_under_ == reference_pressure) {
    motion_ = carried_motion_;
    return;
  }
  std::fill(motion_.begin(), motion_.end(), Vector<D>::Zero());
  const std::size_t points = boundary.surface.size(), per_point = response_.lumps_per_point(points);
  for (std::size_t k = 0; k < points && ranks_.first(); ++k)
    for (std::size_t s = k * per_point; s < (k + 1) * per_point; ++s)
      motion_[response_.lump[s]] -= response_.share[s] * transferred_[k] * reference_pressure[k] * boundary.surface.normal[k];
  const std::ptrdiff_t lumps = static_cast<std::ptrdiff_t>(response_.mass.size());
  parallel_for(lumps, first_[lumps], [&](std::ptrdiff_t a) {
    for (std::ptrdiff_t e = first_[a]; e < first_[a + 1]; ++e) motion_[a] -= between_[entry_[e]];
    motion_[a] *= scale_[a];
  });
  carried_motion_ = motion_;
  carried_under_ = reference_pressure;
}

template <int D>
template <class T>
void YieldingSurface<D>::push(double factor, const std::vector<T>& x) const {
  const std::ptrdiff_t lumps = static_cast<std::ptrdiff_t>(response_.mass.size());
  parallel_for(lumps, first_[lumps], [&](std::ptrdiff_t a) {
    Vector<D> force = Vector<D>::Zero();
    for (std::ptrdiff_t e = first_[a]; e < first_[a + 1]; ++e) force += pushing_[e] * double(x[particle_[e]]);
    motion_[a] += factor * scale_[a] * force;
  });
}

template <int D>
void YieldingSurface<D>::sum_motion() const {
  if (!ranks_.alone()) ranks_.sum(std::span(motion_.data()->data(), D * motion_.size()));
}

template <int D>
template <class T>
void YieldingSurface<D>::spread(const UninitialisedVector<Vector<D>>& vector, const std::vector<int>& at_structure,
                                std::vector<T>& y) const {
  const std::ptrdiff_t rows = static_cast<std::ptrdiff_t>(at_structure.size());
  parallel_for(rows, [&](std::ptrdiff_t m) {
    double sum = 0;
    for (std::ptrdiff_t e = begin_[m]; e < begin_[m] + count_[m]; ++e) sum += vector[e].dot(motion_[lump_[e]]);
    y[at_structure[m]] += static_cast<T>(sum);
  });
}

template <int D>
template <class T>
void YieldingSurface<D>::add_difference(const std::vector<int>& at_structure, const std::vector<T>& x, std::vector<T>& y) const {
  if (!any()) return;
  std::fill(motion_.begin(), motion_.end(), Vector<D>::Zero());
  push(1, x);
  sum_motion();
  for (std::size_t m = 0; m < at_structure.size(); ++m) y[at_structure[m]] -= static_cast<T>(bound_[m] * x[at_structure[m]]);
  spread(vector_, at_structure, y);
}

template <int D>
void YieldingSurface<D>::subtract_motion(const std::vector<double>& reference_pressure, const Boundary<D>& boundary,
                                         const std::vector<int>& at_structure, const std::vector<double>& x, std::vector<double>& y) const {
  if (!any()) return;
  set_carried_motion(reference_pressure, boundary);
  push(-1, x);
  sum_motion();
  spread(counted_, at_structure, y);
}

template <int D>
void YieldingSurface<D>::add_source(const std::vector<double>& reference_pressure, const Boundary<D>& boundary,
                                    const std::vector<int>& at_structure, std::vector<double>& source) const {
  if (!any()) return;
  set_carried_motion(reference_pressure, boundary);
  sum_motion();
  spread(vector_, at_structure, source);
}

#define TERN_INSTANTIATE(D, T) \
  template void YieldingSurface<D>::add_difference(const std::vector<int>&, const std::vector<T>&, std::vector<T>&) const;
TERN_INSTANTIATE(2, double)
TERN_INSTANTIATE(2, float)
TERN_INSTANTIATE(3, double)
TERN_INSTANTIATE(3, float)
#undef TERN_INSTANTIATE
template class YieldingSurface<2>;
template class YieldingSurface<3>;

}  // namespace tern::fluid
