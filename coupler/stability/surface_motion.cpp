#include "coupler/stability/surface_motion.hpp"

#include <algorithm>
#include <limits>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace tern::coupler {
namespace {

constexpr int windows_compared = 20;  ///< then another place is taken to compare with
constexpr double granted = 0.5;       ///< of the sum of both distances

template <int D>
std::string written(const Vector<D>& v) {
  return fmt::format("({:.3g})", fmt::join(v.data(), v.data() + D, ", "));
}

}  // namespace

template <int D>
SurfaceMotion<D>::SurfaceMotion(const SurfaceProperties& properties, double size, bool from_start)
    : body_(properties.body), round_off_(size * 0x1p-22) {
  mass_.assign(body_.empty() ? 0 : *std::max_element(body_.begin(), body_.end()) + 1, std::numeric_limits<double>::infinity());
  for (std::size_t k = 0; k < body_.size(); ++k)
    mass_[body_[k]] = std::min({mass_[body_[k]], properties.section_mass[k], properties.least_mass[k]});
  if (from_start) last_load_ = SurfaceLoad<D>{std::vector<Vector<D>>(body_.size(), Vector<D>::Zero())};
}

template <int D>
std::string SurfaceMotion<D>::surface(double duration, const Surface<D>& surface) {
  duration_ = duration;
  area_ = surface.area;
  tried_load_ = last_load_;
  tried_velocity_ = surface.velocity;
  return velocity_.empty() ? std::string() : compare(surface);
}

template <int D>
std::string SurfaceMotion<D>::compare(const Surface<D>& surface) {
  const std::size_t count = surface.position.size();
  const bool renew = position_.empty() || windows_ >= windows_compared;
  std::string fault;
  double worst = 1;
  std::vector<Vector<D>> at_begin(count);
  std::vector<double> doubt(count);
  for (std::size_t k = 0; k < count; ++k) {
    at_begin[k] = surface.position[k] - 0.25 * duration_ * (velocity_[k] + surface.velocity[k]);
    doubt[k] = 0.25 * duration_ * (surface.velocity[k] - velocity_[k]).norm() + 0.5 * duration_ * velocity_doubt_[k];
    if (position_.empty()) continue;
    const Vector<D> moved = at_begin[k] - position_[k];
    const double limit = tolerance_[k] + doubt[k] + round_off_ + granted * (moved.norm() + carried_[k].norm());
    const double excess = (moved - carried_[k]).norm() / limit;
    if (!(excess > worst)) continue;
    worst = excess;
    fault = fmt::format(
        "position and velocity of point {} do not belong together: in the last {} windows ({:.3g} s) it moved by {} m, and its velocity "
        "carries it by {} m; the two must agree to {:.3g} m",
        k, windows_, time_, written<D>(moved), written<D>(carried_[k]), limit);
  }
  if (renew) {
    position_ = std::move(at_begin);
    tolerance_ = std::move(doubt);
    carried_.assign(count, Vector<D>::Zero());
    windows_ = 0;
    time_ = 0;
  }
  return fault;
}

template <int D>
void SurfaceMotion<D>::answer(const SurfaceLoad<D>& load, const std::vector<Vector<D>>& velocity) {
  tried_load_ = load;
  tried_velocity_ = velocity;
}

template <int D>
std::vector<double> SurfaceMotion<D>::doubt(const SurfaceLoad<D>& load) const {
  std::vector<double> pressure(mass_.size(), 0), of_point(load.force.size());
  for (std::size_t k = 0; k < of_point.size(); ++k)
    pressure[body_[k]] = std::max(pressure[body_[k]], (load.force[k] - tried_load_->force[k]).norm() / area_[k]);
  for (std::size_t k = 0; k < of_point.size(); ++k) of_point[k] = 4 * duration_ * pressure[body_[k]] / mass_[body_[k]];
  return of_point;
}

template <int D>
void SurfaceMotion<D>::apply(const SurfaceLoad<D>& load) {
  last_load_ = load;
  if (!tried_load_) return;  // after a checkpoint: the next window tells
  std::vector<double> doubt_at_end = doubt(load);
  if (!position_.empty()) {
    for (std::size_t k = 0; k < carried_.size(); ++k) {
      carried_[k] += 0.5 * duration_ * (velocity_[k] + tried_velocity_[k]);
      tolerance_[k] += duration_ * (0.5 * (tried_velocity_[k] - velocity_[k]).norm() + std::max(velocity_doubt_[k], doubt_at_end[k]));
    }
    ++windows_;
    time_ += duration_;
  }
  velocity_ = tried_velocity_;
  velocity_doubt_ = std::move(doubt_at_end);
}

template class SurfaceMotion<2>;
template class SurfaceMotion<3>;

}  // namespace tern::coupler
