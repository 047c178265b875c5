#pragma once
// What the coupler knows before the first window and what never changes after.

#include <string>
#include <vector>

#include "coupler/stability/added_mass.hpp"
#include "meeting/meeting.hpp"
#include "proto/interface.hpp"
#include "scene/case_file.hpp"
#include "sph/kernel.hpp"

namespace tern::coupler {

template <int D>
struct Scheme;

/// Of the load, with which repeated windows end where the case gives none, coupling.tolerance.
constexpr double tolerance_by_default = 1e-4;

/// Of the change of its pressure, what the fluid's answer may miss where first passes are learnt from and tested. They are accepted where
/// the surface moves as the answer said to within a tenth of its change (acceleration/agreement.cpp).
constexpr double answer_tolerance = 0.01;

template <int D>
struct Setup {
  Setup(const Case& scene, const SurfaceProperties& properties);

  CouplingCase coupling;
  bool iterates;       ///< the pressure equation knows how the surface answers, and a window can be repeated; not of explicit
  bool learns;         ///< how the surface answers is learnt from first passes, which are enough where it moves as the fluid took it to
  const char* remedy;  ///< what to change when the coupling diverges
  const Scheme<D>& scheme;
  double first_window;         ///< length of the first window at most [s]
  double window_of_loads;      ///< length of every window at most, for the loads that change [s]
  std::vector<bool> is_light;  ///< a body has no more behind its faces than half a layer of fluid particles
  double window_share;         ///< of the length that the fluid proposes, which a window takes
  double density, spacing, smoothing_length, contact_distance, courant;  ///< of the fluid; courant with window_share
  double robin_mass_factor;                                              ///< m_p over m_s, the mass behind a face
  double mass_of_held;             ///< m_p of what is held by its stiffness, where the answer is not learnt [kg/m^2]
  std::vector<double> moved_mass;  ///< of the fluid that has to move with each body, m_a of stability/added_mass.hpp [kg/m^2]
  std::vector<bool> is_held;       ///< a clamp or a hinge holds a part of the body
  std::vector<double> body_density;
  std::vector<std::string> body_name;
  VectorExpression gravity;
  SurfaceProperties properties;
  Meetable meetable;
  Kernel<D> kernel;
  FluidWeight fluid_weight;
};

}  // namespace tern::coupler
