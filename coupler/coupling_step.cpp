// The interaction of one window (seed paper section II.C), read from top to bottom. Between the two halves the fluid solves
// its pressure, knowing the dissipative forces and how far the surface yields to a change of pressure.

#include "coupler/coupling_step.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "base/error.hpp"
#include "coupler/schemes/face_pressure.hpp"
#include "coupler/schemes/riemann.hpp"
#include "coupler/schemes/velocity_divergence_mitigation.hpp"
#include "coupler/stability/added_mass.hpp"
#include "sph/contact.hpp"

namespace tern::coupler {
namespace {

/// Mass behind a face, over that of a layer of fluid particles, up to which one pass is not enough.
constexpr double lightest_of_one_pass = 0.5 * (1 + 1e-9);  // a plate of just this mass is one of them, whatever its rounding
/// Mass with which a light surface yields in the pressure equation of CM3, in layers of fluid particles. From 2 to 12 it makes
/// no difference to the number of trials.
constexpr double robin_layers = 5;
/// Of the half space before a point. At the end of the kernel, where w~ may be negative, particles and point feel nothing of each other.
constexpr double least_share = 1e-3;

}  // namespace

template <int D>
void CouplingStep<D>::pass(double begin, double duration, const Surface<D>& surface) {
  begin_ = begin;
  duration_ = duration;
  load_.force.assign(surface.position.size(), Vector<D>::Zero());
  stretch(surface);
  if (algorithm_ == CouplingAlgorithm::cm3) fixed_point_.begin_window(largest_gain(), begin);
  contact_.force.clear();
  for (LoadAlternation& alternation : alternation_) alternation = {};
  audit_ = {};
  ++evaluations_.windows_without_exchange;
}

template <int D>
InterfaceCondition<D> CouplingStep<D>::dissipative_load(double begin, double duration, const Surface<D>& surface,
                                                        const InterfaceParticles<D>& band) {
  begin_ = begin;
  duration_ = duration;
  surface_ = surface;
  band_ = &band;
  if (coupling_.vem_coefficient && band.divergence.size() != band.id.size())
    throw BadInput(
        "The fluid process sends no divergence of the velocity, which [coupling.vem] needs; leave that table out, or use "
        "a fluid that has it.");
  stretch(surface);
  pairs_.find(band, surface);
  share_ = uniform_load<D>(pairs_.all_pairs(), surface, coupling_.scheme);
  // The structure makes its first trial under the load of the last window.
  const std::size_t points = surface.position.size();
  if (load_.force.size() == points)
    trial_load_ = load_;
  else
    trial_load_.force.assign(points, Vector<D>::Zero());
  trial_contact_ = contact_;
  trial_contact_.force.resize(points, Vector<D>::Zero());
  if (algorithm_ == CouplingAlgorithm::cm3) fixed_point_.begin_window(largest_gain(), begin_);
  dissipative_.surface_velocity.clear();
  add_known_forces();
  return dissipative_;
}

template <int D>
InterfaceCondition<D> CouplingStep<D>::dissipative_load(const std::vector<Vector<D>>& surface_velocity) {
  surface_.velocity = dissipative_.surface_velocity = surface_velocity;
  add_known_forces();
  return dissipative_;
}

template <int D>
void CouplingStep<D>::add_known_forces() {
  load_.force.assign(surface_.position.size(), Vector<D>::Zero());
  dissipative_.force.assign(band_->id.size(), Vector<D>::Zero());
  audit_ = {};
  if (coupling_.scheme == InterfaceScheme::riemann && coupling_.riemann_limiter > 0) add_riemann();
  if (coupling_.vem_coefficient) add_velocity_divergence_mitigation();
  set_robin_condition();
  audit_.band = static_cast<int>(band_->id.size());
  audit_.pairs = static_cast<int>(pairs_.all_pairs().size());
}

template <int D>
const SurfaceLoad<D>* CouplingStep<D>::next_trial(const InterfacePressure<D>& pressure) {
  if (algorithm_ != CouplingAlgorithm::cm3) return nullptr;
  const SurfaceLoad<D> known = load_;
  const WindowAudit audit = audit_;
  band_force_.force.assign(band_->id.size(), Vector<D>::Zero());
  add_pressure(pressure);
  settle_contacts(pressure);
  audit_ = audit;
  const SurfaceLoad<D> answer = std::exchange(load_, known);
  if (fixed_point_.add(parts(trial_load_, trial_contact_), parts(answer, contact_))) return nullptr;
  ++evaluations_.repeated_trials;
  const Eigen::VectorXd next = fixed_point_.next();
  const auto points = static_cast<Eigen::Index>(trial_load_.force.size());
  for (Eigen::Index k = 0; k < points; ++k) {
    trial_contact_.force[k] = next.segment<D>(D * (points + k));
    trial_load_.force[k] = next.segment<D>(D * k) + trial_contact_.force[k];
  }
  return &trial_load_;
}

template <int D>
InterfaceForce<D> CouplingStep<D>::interface_force(const InterfacePressure<D>& pressure) {
  band_force_.force.assign(band_->id.size(), Vector<D>::Zero());
  add_pressure(pressure);
  settle_contacts(pressure);
  check_balance();
  check_alternation();
  return band_force_;
}

template <int D>
Eigen::VectorXd CouplingStep<D>::flat(const SurfaceLoad<D>& load) {
  Eigen::VectorXd values(D * static_cast<Eigen::Index>(load.force.size()));
  for (std::size_t k = 0; k < load.force.size(); ++k) values.segment<D>(D * static_cast<Eigen::Index>(k)) = load.force[k];
  return values;
}

template <int D>
Eigen::VectorXd CouplingStep<D>::parts(const SurfaceLoad<D>& load, const SurfaceLoad<D>& contact) {
  const Eigen::VectorXd all = flat(load), contacts = flat(contact);
  Eigen::VectorXd values(all.size() + contacts.size());
  values << all - contacts, contacts;
  return values;
}

template <int D>
CouplingStep<D>::CouplingStep(const Case& scene, const SurfaceProperties& properties)
    : coupling_(scene.coupling),
      algorithm_(scene.coupling.algorithm),
      density_(scene.fluid->density),
      spacing_(scene.fluid->spacing),
      smoothing_length_(scene.fluid->numerics.smoothing_length_ratio * scene.fluid->spacing),
      contact_distance_(scene.fluid->numerics.contact_distance * scene.fluid->spacing),
      courant_(scene.fluid->numerics.courant),
      gravity_(scene.gravity),
      properties_(properties),
      kernel_(smoothing_length_),
      fluid_weight_(weight_of_fluid<D>(scene)),
      fixed_point_(coupling_.acceleration, coupling_.tolerance),
      pairs_(smoothing_length_, scene.fluid->spacing) {
  for (const StructureBody& body : scene.structure->bodies) {
    body_density_.push_back(body.density);
    body_name_.push_back(body.name);
  }
  alternation_.resize(body_density_.size());
  if (algorithm_ == CouplingAlgorithm::automatic) {
    algorithm_ = CouplingAlgorithm::cm2;
    for (std::size_t b = 0; b < body_density_.size(); ++b)
      if (const double mass = section_mass(properties, b); mass > 0 && mass <= lightest_of_one_pass * density_ * spacing_)
        algorithm_ = CouplingAlgorithm::cm3;
  }
  dissipative_.repeats = algorithm_ == CouplingAlgorithm::cm3;
}

template <int D>
void CouplingStep<D>::add_riemann() {
  double fastest = 0;
  for (const auto& u : band_->velocity) fastest = std::max(fastest, u.norm());
  for (const auto& pair : pairs_.pairs()) fastest = std::max(fastest, surface_.velocity[pair.point].norm());
  const double sound_speed = 10 * fastest;
  if (sound_speed == 0) return;
  evaluations_.riemann_dissipation += static_cast<long>(pairs_.pairs().size());
  for (const auto& pair : pairs_.pairs()) {
    const Vector<D>& n = surface_.normal[pair.point];
    const double approach = (surface_.velocity[pair.point] - band_->velocity[pair.particle]).dot(n);
    const double mean_density = 0.5 * (density_ + body_density_[properties_.body[pair.point]]);
    const double pressure = riemann_pressure(coupling_.riemann_limiter, mean_density, sound_speed, approach);
    if (pressure == 0) continue;
    add_pair_force(dissipative_.force, pair, Vector<D>(pressure * pair.b));
    audit_.riemann_dissipation += pressure * -pair.b.dot(n) * approach * duration_;
  }
}

template <int D>
void CouplingStep<D>::add_velocity_divergence_mitigation() {
  evaluations_.vem += static_cast<long>(pairs_.pairs().size());
  double fastest = 0;
  for (const auto& pair : pairs_.pairs()) fastest = std::max(fastest, band_->velocity[pair.particle].norm());
  const auto pressure_of = [&](double density, double divergence) {
    return -density * *coupling_.vem_coefficient * smoothing_length_ * fastest * divergence;
  };
  std::vector<double> surface_divergence;
  if (coupling_.vem_form == VemForm::seed) surface_divergence = divergence_at_surface<D>(kernel_, pairs_.pairs(), surface_, *band_);
  for (const auto& pair : pairs_.pairs()) {
    const int i = pair.particle, k = pair.point;
    const double fluid = pressure_of(density_, band_->divergence[i]);
    const double structure = surface_divergence.empty() ? fluid : pressure_of(body_density_[properties_.body[k]], surface_divergence[k]);
    const MitigationPressure pressure = mitigation_pressure(coupling_.vem_form, fluid, structure);
    if (pressure.on_fluid == 0 && pressure.on_structure == 0) continue;
    load_.force[k] += pressure.on_structure * pair.b;
    dissipative_.force[i] -= pressure.on_fluid * pair.b;
    audit_.mitigation_dissipation -=
        duration_ * pair.b.dot(pressure.on_structure * surface_.velocity[k] - pressure.on_fluid * band_->velocity[i]);
  }
}

template <int D>
void CouplingStep<D>::stretch(const Surface<D>& surface) {
  if (area_at_start_.empty()) area_at_start_ = surface.area;
  stretch_.resize(surface.area.size());
  for (std::size_t k = 0; k < stretch_.size(); ++k) stretch_[k] = surface.area[k] / area_at_start_[k];
}

template <int D>
double CouplingStep<D>::responding_mass(std::size_t k) const {
  // Over a window a pressure accelerates the section behind the point. As long as an elastic wave is on its way through it the
  // face moves at the constant p/(rho c) instead, which for the fluid, that takes the mean velocity for half of that at the
  // end, is the answer of half the layer that the wave reaches. At least one particle moves. All of this is mass over the area that
  // the body had at the start; where it has been stretched since, a pressure finds less behind the same area.
  return std::max(std::min(properties_.section_mass[k], 0.5 * properties_.impedance[k] * duration_), properties_.least_mass[k]) /
         stretch_[k];
}

template <int D>
double CouplingStep<D>::robin_mass(std::size_t k) const {
  const double responding = responding_mass(k);
  if (algorithm_ != CouplingAlgorithm::cm3) return coupling_.robin_mass_factor * responding;
  // Of the motions of a light body a few answer with its mass, all others are held by its stiffness. Between the two the fluid
  // is best told of a mass like its own: what it then expects wrongly of the few, the trials find out.
  return std::max(responding, robin_layers * density_ * spacing_);
}

template <int D>
double CouplingStep<D>::largest_gain() const {
  double largest = 1;
  for (std::size_t k = 0; k < properties_.body.size(); ++k) largest = std::max(largest, robin_mass(k) / responding_mass(k));
  return largest;
}

template <int D>
void CouplingStep<D>::set_robin_condition() {
  // The trial state moved under the trial load. A pressure in excess of it moves the surface on.
  const std::size_t points = surface_.position.size();
  dissipative_.reference_pressure.assign(points, 0);
  dissipative_.robin_mass.assign(points, 0);
  // Explicit coupling: the fluid takes the surface as a wall that moves as given; mass 0 says that a point does not yield.
  if (algorithm_ == CouplingAlgorithm::cm0) return;
  for (std::size_t k = 0; k < points; ++k) {
    // A pressure p loads the point with s p A, s being the share of its half space that particles fill: some per cent off 1 where they
    // are on no lattice, less at a free surface. So it answers p with the mass m/s, and its load is that of the pressure L/(s A). With s
    // left out, a body that rests under p is taken to give way by dt (1 - s) p/m in every window: where s > 1 that makes energy.
    const double share = share_[k] > least_share ? share_[k] : 1;
    dissipative_.robin_mass[k] = robin_mass(k) / share;
    // What the trial carries, less what is known of its answer; the contacts of CM3's trials are not the pressure's.
    const Vector<D> carried = trial_load_.force[k] - load_.force[k] - trial_contact_.force[k];
    dissipative_.reference_pressure[k] = -carried.dot(surface_.normal[k]) / (share * surface_.area[k]);
  }
}

template <int D>
void CouplingStep<D>::add_pressure(const InterfacePressure<D>& pressure) {
  evaluations_.pressure += static_cast<long>(pairs_.all_pairs().size());
  const Vector<D> gravity = [&] {
    Vector<D> g;
    for (int c = 0; c < D; ++c) g[c] = gravity_[c](begin_);
    return g;
  }();
  // Pressure of every particle, carried to the surface by the weight of the fluid between. Behind a wall it goes on as before
  // it: an image carries what its particle does.
  carried_.clear();
  for (const auto& pair : pairs_.all_pairs()) {
    const Vector<D> d = surface_.position[pair.point] - band_->position[pair.particle];
    carried_.push_back(pressure.pressure[pair.particle] + density_ * gravity.dot(d));
  }
  if (coupling_.scheme != InterfaceScheme::riemann)
    integrate_over_faces<D>(kernel_, pairs_.all_pairs(), surface_, *band_, coupling_.scheme, carried_);
  std::size_t m = 0;
  for (const auto& pair : pairs_.pairs()) add_pair_force(band_force_.force, pair, Vector<D>(carried_[m++] * pair.b));
  for (const auto& pair : pairs_.averted_pairs()) add_pair_force(band_force_.force, pair, Vector<D>(carried_[m++] * pair.b));
  // What images take back, the fluid has from the mirror that its walls are.
  for (const auto& pair : pairs_.image_pairs()) load_.force[pair.point] += carried_[m++] * pair.b;
}

template <int D>
void CouplingStep<D>::settle_contacts(const InterfacePressure<D>& pressure) {
  if (algorithm_ == CouplingAlgorithm::cm3) contact_.force.assign(load_.force.size(), Vector<D>::Zero());
  // Inelastic: a particle nearer to a face than the contact distance goes on with the face; the impulse is part of the load.
  // Thin sheets and spray feel too little pressure to be stopped otherwise.
  for (const auto& pair : pairs_.pairs()) {
    const int i = pair.particle, k = pair.point;
    const Vector<D>& n = surface_.normal[k];
    if (!touches<D>(surface_.position[k], n, surface_.area[k], band_->position[i], contact_distance_)) continue;
    const Vector<D> velocity = pressure.velocity[i] + (duration_ / band_->mass[i]) * band_force_.force[i];
    const double approach = (surface_.velocity[k] - velocity).dot(n);
    // The face gives way, as the mass does that lies behind the particle.
    double behind = responding_mass(k) * std::pow(band_->volume[i], (D - 1.0) / D), expected = approach;
    if (algorithm_ == CouplingAlgorithm::cm3) {
      // As the pressure equation has it, to what exceeds the load of the trial. When both sides agree nothing does, and the
      // particle has the velocity of the face, be that held by its stiffness or free.
      behind = robin_mass(k) * surface_.area[k];
      expected += duration_ / behind * (load_.force[k] - trial_load_.force[k]).dot(n);
    }
    if (expected <= 0) continue;
    const double mass = band_->mass[i] * behind / (band_->mass[i] + behind);
    const Vector<D> force = -(mass * expected / duration_) * n;
    add_pair_force(band_force_.force, pair, force);
    if (algorithm_ == CouplingAlgorithm::cm3) contact_.force[k] += force;
    audit_.contact_dissipation += 0.5 * mass * expected * approach;
    ++audit_.contacts;
  }
}

template <int D>
void CouplingStep<D>::check_balance() {
  Vector<D> force = Vector<D>::Zero();
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  double size = 0, moment_size = 0;
  const auto add = [&](const Vector<D>& x, const Vector<D>& f) {
    force += f;
    size += f.norm();
    moment_size += x.norm() * f.norm();
    Eigen::Vector3d x3 = Eigen::Vector3d::Zero(), f3 = Eigen::Vector3d::Zero();
    x3.head<D>() = x;
    f3.head<D>() = f;
    moment += x3.cross(f3);
  };
  for (std::size_t i = 0; i < band_->id.size(); ++i) {
    add(band_->position[i], band_force_.force[i] + dissipative_.force[i]);
  }
  std::size_t m = pairs_.pairs().size() + pairs_.averted_pairs().size();
  for (const auto& pair : pairs_.image_pairs())  // theirs is what walls give the fluid
    add(surface_.position[pair.point] + pair.offset, Vector<D>(-carried_[m++] * pair.b));
  for (std::size_t k = 0; k < load_.force.size(); ++k) {
    if (!load_.force[k].allFinite())
      throw NumericalFailure(
          fmt::format("The load on surface point {} is not finite at t = {:.6g} s; a pressure or a velocity "
                      "at the interface has run away. Try a smaller fluid.numerics.courant.",
                      k, begin_));
    add(surface_.position[k], load_.force[k]);
    // The fluid sees the surface move at the trial velocity. The structure's own account uses the motion under the new load;
    // the sum of both is what staggering creates or destroys.
    audit_.work_on_fluid -= duration_ * load_.force[k].dot(surface_.velocity[k]);
  }
  audit_.force_sum = force.norm();
  audit_.force_size = size;
  if (size > 0) {
    audit_.force_error = force.norm() / size;
    audit_.moment_error = moment_size > 0 ? moment.norm() / moment_size : 0;
  }
}

template <int D>
Vector<D> CouplingStep<D>::total_load(std::uint32_t body) const {
  Vector<D> sum = Vector<D>::Zero();
  for (std::size_t k = 0; k < load_.force.size(); ++k)
    if (properties_.body[k] == body) sum += load_.force[k];
  return sum;
}

template class CouplingStep<2>;
template class CouplingStep<3>;

}  // namespace tern::coupler
