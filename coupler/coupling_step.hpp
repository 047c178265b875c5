#pragma once
// The interaction of one window: from the trial surface and the fluid band to forces on both sides.

#include <optional>
#include <string>
#include <vector>

#include "coupler/acceleration/fixed_point.hpp"
#include "coupler/schemes/interface_pairs.hpp"
#include "coupler/stability/added_mass.hpp"
#include "coupler/stability/interface_energy.hpp"
#include "coupler/stability/load_alternation.hpp"
#include "proto/interface.hpp"
#include "scene/case_file.hpp"

namespace tern::coupler {

/// What one window did to momentum and energy. Momentum errors are relative to the sum of the force magnitudes.
struct WindowAudit {
  double force_error = 0;                                   ///< |sum of all forces| / sum of |force|
  double force_sum = 0, force_size = 0;                     ///< numerator and denominator of force_error [N/m^(3-D)]
  double moment_error = 0;                                  ///< the same for moments about the origin, relative to sum |x| |force|
  double work_on_fluid = 0;                                 ///< by the surface moving at its trial velocity [J/m^(3-D)]
  double riemann_dissipation = 0, contact_dissipation = 0;  ///< >= 0 [J/m^(3-D)]
  /// [J/m^(3-D)]; negative where the fluid alone squeezes a particle while the face recedes.
  double mitigation_dissipation = 0;
  int band = 0, pairs = 0, contacts = 0;
};

/// How often each term was evaluated, in pairs of a particle and a surface point (trials), since construction. What a case
/// leaves out counts nothing.
struct Evaluations {
  long pressure = 0, riemann_dissipation = 0, vem = 0, repeated_trials = 0, windows_without_exchange = 0;
};

template <int D>
class CouplingStep {
 public:
  CouplingStep(const Case& scene, const SurfaceProperties& properties);

  /// Instead of all that follows: the surface is out of the fluid's reach, and without load.
  void pass(double begin, double duration, const Surface<D>& surface);

  /// First exchange: who sees whom, Riemann and VEM forces from u* and the trial velocity, and how the surface yields.
  InterfaceCondition<D> dissipative_load(double begin, double duration, const Surface<D>& surface, const InterfaceParticles<D>& band);

  /// The same window once more, with the velocities that the structure reaches under next_trial().
  InterfaceCondition<D> dissipative_load(const std::vector<Vector<D>>& surface_velocity);

  /// CM3: the load under which structure and fluid have to try this window again, null when their answers agree or cannot be
  /// brought to agree; null with the other algorithms. Throws NumericalFailure when the load is not finite.
  const SurfaceLoad<D>* next_trial(const InterfacePressure<D>& pressure);

  /// Last exchange: pressure and contact forces, and the load of the structure (everything). Throws NumericalFailure
  /// when a force is not finite, and when a load turns round from window to window.
  InterfaceForce<D> interface_force(const InterfacePressure<D>& pressure);

  /// Load on the structure over this window; valid after interface_force().
  const SurfaceLoad<D>& surface_load() const { return load_; }
  const WindowAudit& audit() const { return audit_; }
  bool fluid_has_weight() const { return fluid_weight_.pressure > 0; }
  const Evaluations& evaluations() const { return evaluations_; }
  CouplingAlgorithm algorithm() const { return algorithm_; }
  /// CM3: how the trials of this window went.
  const FixedPoint& trials() const { return fixed_point_; }
  /// At the end of a window: `total`, kinetic and potential energy of the fluid and the work of the interface on the structure since the
  /// start; `present`, kinetic and strain energy of both sides [J/m^(3-D)]. Throws NumericalFailure when the interface makes energy.
  void check_energy(double time, double total, double present);
  /// Total load on one body in this window [N/m^(3-D)].
  Vector<D> total_load(std::uint32_t body) const;

 private:
  // coupling_step.cpp calls these in order.
  void add_known_forces();
  void add_riemann();
  void add_velocity_divergence_mitigation();
  void stretch(const Surface<D>& surface);
  double responding_mass(std::size_t k) const;  ///< [kg/m^2]
  double robin_mass(std::size_t k) const;       ///< [kg/m^2]
  double largest_gain() const;
  void set_robin_condition();
  void add_pressure(const InterfacePressure<D>& pressure);
  void settle_contacts(const InterfacePressure<D>& pressure);
  void check_balance();
  void check_alternation();

  /// What to change when the coupling itself fails.
  const char* remedy() const;

  static Eigen::VectorXd flat(const SurfaceLoad<D>& load);
  /// What the trials of CM3 look for: the load without its contacts, then the contacts. Both are unknowns, for the fluid takes them
  /// differently: its answer to a trial must not depend on the contacts that another trial has met.
  static Eigen::VectorXd parts(const SurfaceLoad<D>& load, const SurfaceLoad<D>& contact);

  /// Puts +f on a surface point and -f on a band particle.
  void add_pair_force(std::vector<Vector<D>>& on_band, const InterfacePair<D>& pair, const Vector<D>& force) {
    load_.force[pair.point] += force;
    on_band[pair.particle] -= force;
  }

  CouplingCase coupling_;
  CouplingAlgorithm algorithm_;  ///< not automatic
  double density_, spacing_, smoothing_length_, contact_distance_, courant_;
  std::vector<double> body_density_;
  std::vector<std::string> body_name_;
  VectorExpression gravity_;
  SurfaceProperties properties_;
  Kernel<D> kernel_;
  FluidWeight fluid_weight_;
  FixedPoint fixed_point_;
  InterfacePairs<D> pairs_;
  double begin_ = 0, duration_ = 0;
  Surface<D> surface_;                           ///< of the present trial
  const InterfaceParticles<D>* band_ = nullptr;  ///< of the present window; the caller keeps it alive until interface_force()
  SurfaceLoad<D> load_;                          ///< that the fluid answers the present trial with
  SurfaceLoad<D> trial_load_;                    ///< under which the structure has made it
  InterfaceCondition<D> dissipative_;
  std::vector<double> area_at_start_, stretch_;  ///< of every point [m^(D-1)]; its area over that
  std::vector<double> share_;                    ///< load of each point under a uniform pressure p, over p A; of the present window
  std::vector<double> carried_;                  ///< pressure of every pair, times b_ik its force [Pa]
  InterfaceForce<D> band_force_;
  SurfaceLoad<D> contact_, trial_contact_;  ///< CM3: the contacts in load_, and in trial_load_
  WindowAudit audit_;
  Evaluations evaluations_;
  InterfaceEnergy energy_;
  std::optional<double> energy_at_start_;
  std::vector<LoadAlternation> alternation_;  ///< by body
};

}  // namespace tern::coupler
