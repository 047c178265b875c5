// Start of a fluid, and what its state says of itself.

#include "fluid/fluid.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "fluid/gauges/probe.hpp"

namespace tern::fluid {

template <int D>
Fluid<D>::Fluid(const Case& scene)
    : constants_(scene.fluid.value()),
      gravity_expression_(scene.gravity),
      period_(scene),
      walls_(scene, scene.fluid->spacing, constants_.faces.support()),
      multigrid_(period_) {
  for (int c = 0; c < D; ++c) {
    domain_min_[c] = scene.domain_min[c];
    domain_max_[c] = scene.domain_max[c];
  }
  reports_divergence_ = scene.coupling.vem_coefficient.has_value();
  uniform_gravity_ = std::all_of(scene.gravity.begin(), scene.gravity.end(), [](const Expression& e) { return e.is_constant(); });
  State<D> state;
  double fastest = 0;
  for (const FluidBody& body : scene.fluid->bodies)
    for (const Vector<D>& x : fill_lattice<D>(body.shape, constants_.spacing)) {
      Vector<D> u;
      for (int c = 0; c < D; ++c) u[c] = body.velocity[c](0, x[0], x[1], D == 3 ? x[D - 1] : 0);
      state.id.push_back(static_cast<std::uint32_t>(state.id.size()));
      state.position.push_back(x);
      state.velocity.push_back(u);
      state.pressure.push_back(0);
      state.free_surface.push_back(0);
      fastest = std::max(fastest, u.norm());
    }
  if (state.size() == 0) throw BadInput(scene.path + ": the fluid bodies hold no particle; make them larger than fluid.spacing.");
  initial_particles_ = state.size();

  // Reference speed: half the fall through the height of the fluid. It bounds the first steps from rest.
  Vector<D> mean = Vector<D>::Zero();
  for (const auto& x : state.position) mean += x / static_cast<double>(state.size());
  const Vector<D> g = gravity_at(0, mean);
  gravity_size_ = g.norm();
  if (gravity_size_ > 0 && uniform_gravity_) {
    double low = 1e300, high = -1e300;
    for (const auto& x : state.position) {
      const double height = -x.dot(g) / gravity_size_;
      low = std::min(low, height), high = std::max(high, height);
    }
    speed_floor_ = 0.5 * std::sqrt(gravity_size_ * (high - low + constants_.spacing));
  }
  if (!uniform_gravity_) {
    // Of a field that varies (about a centre, it vanishes in the middle) the strongest place and the widest extent count.
    Vector<D> low = state.position[0], high = low;
    for (const auto& x : state.position) {
      gravity_size_ = std::max(gravity_size_, gravity_at(0, x).norm());
      low = low.cwiseMin(x), high = high.cwiseMax(x);
    }
    speed_floor_ = 0.5 * std::sqrt(gravity_size_ * ((high - low).maxCoeff() + constants_.spacing));
  }
  reference_speed_ = std::max(2 * speed_floor_, fastest);
  set_state(std::move(state));
  seen_walls_.reset(walls_.faces());
  wall_finder_.fill(walls_.faces(), constants_.faces.support());
  space_before_walls_.assign(walls_.faces().size(), -1);
}

template <int D>
void Fluid<D>::set_state(State<D> state) {
  state_ = std::move(state);
  flag_.assign(state_.size(), Flag::interior);
}

template <int D>
Vector<D> Fluid<D>::gravity_at(double t, const Vector<D>& x) const {
  Vector<D> g;
  for (int c = 0; c < D; ++c) g[c] = gravity_expression_[c](t, x[0], x[1], D == 3 ? x[D - 1] : 0);
  return g;
}

template <int D>
double Fluid<D>::largest_speed() const {
  return std::sqrt(
      ordered_max(static_cast<std::ptrdiff_t>(state_.size()), 0.0, [&](std::ptrdiff_t i) { return state_.velocity[i].squaredNorm(); }));
}

template <int D>
double Fluid<D>::largest_bulk_speed() const {
  return std::sqrt(ordered_max(static_cast<std::ptrdiff_t>(state_.size()), 0.0,
                               [&](std::ptrdiff_t i) { return flag_[i] == Flag::spray ? 0.0 : state_.velocity[i].squaredNorm(); }));
}

template <int D>
Energies Fluid<D>::energies() const {
  const double kinetic = ordered_reduce(static_cast<std::ptrdiff_t>(state_.size()), 0.0,
                                        [&](std::ptrdiff_t i) { return 0.5 * constants_.mass * state_.velocity[i].squaredNorm(); });
  return {kinetic, potential_};
}

template <int D>
Vector<D> Fluid<D>::momentum() const {
  return ordered_reduce(static_cast<std::ptrdiff_t>(state_.size()), Vector<D>(Vector<D>::Zero()),
                        [&](std::ptrdiff_t i) { return Vector<D>(constants_.mass * state_.velocity[i]); });
}

template <int D>
Vector<3> Fluid<D>::angular_momentum() const {
  return ordered_reduce(static_cast<std::ptrdiff_t>(state_.size()), Vector<3>(Vector<3>::Zero()), [&](std::ptrdiff_t i) {
    Vector<3> x = Vector<3>::Zero(), u = Vector<3>::Zero();
    for (int c = 0; c < D; ++c) x[c] = state_.position[i][c], u[c] = state_.velocity[i][c];
    return Vector<3>(constants_.mass * x.cross(u));
  });
}

template <int D>
double Fluid<D>::volume_drift() const {
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < trace_.size(); ++i) {
    if (i >= flag_.size() || flag_[i] != Flag::interior || trace_[i] < 0.925) continue;
    sum += (neighbours_.number_density[i] + boundary_.number_density[i]) / constants_.lattice.density;
    ++count;
  }
  return count ? static_cast<double>(count) / sum - 1 : 0;
}

template <int D>
std::size_t Fluid<D>::spray_particles() const {
  return static_cast<std::size_t>(std::count(flag_.begin(), flag_.end(), Flag::spray));
}

template <int D>
std::optional<double> Fluid<D>::pressure_at(const Vector<D>& x) const {
  return Probe<D>(*this).pressure(x);
}

template <int D>
std::optional<double> Fluid<D>::elevation_at(const Vector<D>& x) const {
  return Probe<D>(*this).elevation(x);
}

template <int D>
double Fluid<D>::front() const {
  double front = -1e300;
  for (std::size_t i = 0; i < state_.size(); ++i)
    if (flag_[i] != Flag::spray) front = std::max(front, state_.position[i][0] + 0.5 * constants_.spacing);
  return front;
}

template class Fluid<2>;
template class Fluid<3>;

}  // namespace tern::fluid
