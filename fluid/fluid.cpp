// Start of a fluid, and what its state says of itself.

#include "fluid/fluid.hpp"

#include <algorithm>

#include "fluid/boundary/wetness.hpp"
#include "fluid/gauges/probe.hpp"
#include "fluid/gauges/totals.hpp"
#include "fluid/initial_state.hpp"
#include "scene/estimate.hpp"

namespace tern::fluid {

template <int D>
Fluid<D>::Fluid(const Case& scene, const Ranks& ranks, const StartParticles<D>& start)
    : reference_(scene, start),
      domain_(ranks, reference_),
      reports_divergence_(scene.coupling.vem_coefficient.has_value()),
      foretells_interface_(scene.coupling.scheme != InterfaceScheme::fsa),
      boundary_(scene, reference_.constants, ranks.alone(), {ranks.own(), ranks.count()}),
      system_(reference_.period) {
  const auto [first, last] = domain_.equal_share(start.size());
  state_ = initial_state(scene, start, first, last);
  const double largest = ranks.most(fluid::largest_speed(state_.velocity));
  if (scene.walls.empty() && !scene.structure && largest > 0) {
    Vector<D> sum = fluid::momentum(1 / static_cast<double>(start.size()), state_);
    ranks.sum(std::span<double>(sum.data(), D));
    if (sum.norm() > 1e-9 * largest) mean_at_start_ = sum;  // not the round-off of a flow that stays where it is
  }
  state_.reference_speed = std::max({2 * reference_.speed_floor, largest, largest_clamp_speed(scene)});
  domain_.cut_anew(state_);
  if (!domain_.alone()) set_totals();
}

template <int D>
void Fluid<D>::set_whole_state(State<D> state, const Shares& shares) {
  domain_.share_out(state, shares);
  state_ = std::move(state);
  if (!domain_.alone()) set_totals();
}

template <int D>
const typename Fluid<D>::AllWalls& Fluid<D>::all_walls() const {
  if (!all_walls_) {
    all_walls_ = std::make_unique<AllWalls>(boundary_.walls.in_whole());
    all_walls_->finder.fill(all_walls_->walls.faces(), constants().faces.support());
    all_walls_->space.assign(all_walls_->walls.faces().size(), -1);
  }
  if (std::exchange(all_walls_->window, windows_) == windows_) return *all_walls_;
  if (boundary_.walls.moving()) {
    all_walls_->walls.move_as(boundary_.walls);
    all_walls_->finder.fill(all_walls_->walls.faces(), constants().faces.support());
    all_walls_->space.assign(all_walls_->walls.faces().size(), -1);
    all_walls_->clipped.reset();
  }
  all_walls_->clipped.clip(all_walls_->walls.faces(), all_walls_->finder, boundary_.surface);
  return *all_walls_;
}

template <int D>
double Fluid<D>::space_before_wall(std::size_t k) const {
  std::vector<int> seen;
  if (!boundary_.walls.whole()) {
    const Faces<D>& walls = all_walls().walls.faces();
    double& space = all_walls_->space[k];
    if (space < 0) space = space_before(constants(), walls, all_walls_->finder, k, seen);
    return space;
  }
  const double space = boundary_.space_before_walls[k];
  return space >= 0 ? space : space_before(constants(), boundary_.walls.faces(), boundary_.wall_finder, k, seen);
}

template <int D>
void Fluid<D>::set_totals() {
  totals_ = add_up(domain_.ranks(), totals_here());
  if (totals_.particles > 0)
    domain_.set_imbalance(static_cast<double>(totals_.most_particles) * domain_.ranks().count() / static_cast<double>(totals_.particles));
}

template <int D>
State<D> Fluid<D>::whole_state() const {
  State<D> whole = domain_.gather(state_);
  if (domain_.alone()) return whole;
  whole.potential = totals_.potential;
  whole.removed = totals_.removed;
  whole.leaked = totals_.leaked;
  whole.evaluations = totals_.evaluations;
  return whole;
}

template <int D>
Totals<D> Fluid<D>::totals_here() const {
  const double mass = constants().mass;
  return {kinetic_energy(mass, state_),
          state_.potential,
          fluid::momentum(mass, state_),
          fluid::angular_momentum(mass, state_),
          fluid::largest_speed(state_.velocity),
          frame_velocity() ? fluid::largest_speed(state_.velocity, *frame_velocity()) : 0,
          fluid::filling(constants(), neighbours_, boundary_, correction_, state_),
          fluid_extent(reference_, state_),
          state_.size(),
          fluid::spray_particles(state_),
          state_.removed,
          state_.leaked,
          state_.evaluations,
          domain_.ghosts(),
          traffic_};
}

template <int D>
Filling Fluid<D>::filling() const {
  Filling filled = fluid::filling(constants(), neighbours_, boundary_, correction_, state_);
  double sums[] = {filled.density, filled.inside, filled.all};
  domain_.ranks().sum(std::span<double>(sums));
  return {sums[0], sums[1], sums[2]};
}

template <int D>
std::optional<FluidExtent<D>> Fluid<D>::extent() const {
  return domain_.alone() ? fluid_extent(reference_, state_) : totals_.extent;
}

template <int D>
Energies Fluid<D>::energies() const {
  if (!domain_.alone()) return {totals_.kinetic, totals_.potential};
  return {kinetic_energy(constants().mass, state_), state_.potential};
}

template <int D>
Vector<D> Fluid<D>::momentum() const {
  return domain_.alone() ? fluid::momentum(constants().mass, state_) : totals_.momentum;
}

template <int D>
Vector<3> Fluid<D>::angular_momentum() const {
  return domain_.alone() ? fluid::angular_momentum(constants().mass, state_) : totals_.angular_momentum;
}

template <int D>
VolumeDrift Fluid<D>::volume_drift() const {
  return (domain_.alone() ? fluid::filling(constants(), neighbours_, boundary_, correction_, state_) : totals_.filling).volume_drift();
}

template <int D>
double Fluid<D>::largest_speed() const {
  return domain_.alone() ? fluid::largest_speed(state_.velocity) : totals_.largest_speed;
}

template <int D>
std::optional<Vector<D>> Fluid<D>::frame_velocity() const {
  return boundary_.walls.all().empty() ? mean_at_start_ : boundary_.walls.frame_velocity(state_.walls);
}

template <int D>
std::optional<double> Fluid<D>::largest_speed_in_frame() const {
  const std::optional<Vector<D>> frame = frame_velocity();
  if (!frame) return std::nullopt;
  return domain_.alone() ? fluid::largest_speed(state_.velocity, *frame) : totals_.largest_in_frame;
}

template <int D>
std::size_t Fluid<D>::spray_particles() const {
  return domain_.alone() ? fluid::spray_particles(state_) : totals_.spray_particles;
}

template <int D>
std::optional<double> Fluid<D>::pressure_at(const Vector<D>& x) const {
  return Probe<D>(*this, Moment::middle).pressure(x);
}

template <int D>
std::optional<double> Fluid<D>::elevation_at(const Vector<D>& x) const {
  return Probe<D>(*this, Moment::end).elevation(x);
}

template class Fluid<2>;
template class Fluid<3>;

}  // namespace tern::fluid
