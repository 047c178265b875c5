#pragma once
// The structure of one scene: elastic bodies by total-Lagrangian SPH. This class is what the coupled loop, the solo loop
// and the tests see; the numerics are free functions in files named after their equation, called from time_step.cpp.

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "base/time.hpp"
#include "base/vector.hpp"
#include "proto/interface.hpp"
#include "scene/case_file.hpp"

namespace tern::structure {

/// Energy account of all bodies [J/m^(3-D)]. Balance: kinetic + strain + potential + diffusion + damping
/// - interface_work - load_work - clamp_work = its value at t = 0, to the error of the time integration.
struct Energies {
  double kinetic = 0;
  double strain = 0;
  double potential = 0;       ///< minus the work of gravity since t = 0
  double diffusion = 0;       ///< dissipated by the Riemann diffusion since t = 0, >= 0
  double interface_work = 0;  ///< done on the structure by the surface load since t = 0
  double damping = 0;         ///< dissipated by the mass damping since t = 0, >= 0
  double load_work = 0;       ///< done on the structure by the [[structure.load]]s since t = 0
  double clamp_work = 0;      ///< done on the structure by clamps that move since t = 0
};

/// Linear and angular momentum about the origin of the free particles; 2D: only the last entry of `angular` is non-zero.
struct Momentum {
  std::array<double, 3> linear{};   ///< [kg m/s /m^(3-D)]
  std::array<double, 3> angular{};  ///< [kg m^2/s /m^(3-D)]
};

/// A material point followed through the motion: weights of its neighbours, exact for linear displacement fields.
struct MaterialPoint {
  std::vector<std::uint32_t> particle;
  std::vector<double> weight;
};

/// How often each term was evaluated, in rows of particles, since construction. What a case leaves out counts nothing.
struct Evaluations {
  long elastic_force = 0, riemann_diffusion = 0, loads = 0, moving_clamps = 0;
  long windows_at_rest = 0;

  /// The list of the members: visit(name, member of each) for every one.
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("elastic_force", all.elastic_force...);
    visit("riemann_diffusion", all.riemann_diffusion...);
    visit("loads", all.loads...);
    visit("moving_clamps", all.moving_clamps...);
    visit("windows_at_rest", all.windows_at_rest...);
  }
};

/// Force and moment with which clamps hold a body; 2D: only the last entry of `moment` is non-zero.
struct Reaction {
  std::array<double, 3> force{};   ///< [N/m^(3-D)]
  std::array<double, 3> moment{};  ///< [N m/m^(3-D)]
};

/// Particle fields of one frame, all of length particles(), particle by particle in the order of the bodies.
template <int D>
struct Fields {
  std::vector<Vector<D>> position;      ///< [m]
  std::vector<Vector<D>> displacement;  ///< [m]
  std::vector<Vector<D>> velocity;      ///< [m/s]
  std::vector<Matrix<D>> stress;        ///< Cauchy [Pa]
  std::vector<double> von_mises;        ///< [Pa]
  std::vector<double> jacobian;         ///< J = det F
  std::vector<double> energy_density;   ///< strain energy per reference volume [J/m^3]
  std::vector<double> shell_thickness;  ///< of a shell, 0 of a solid; empty without shells [m]
  std::vector<std::uint32_t> body;
  std::vector<std::uint8_t> clamped;
};

template <int D>
struct CompleteState;  // structure/complete_state.hpp
template <int D>
struct FreeMotion;  // structure/free_motion.hpp

template <int D>
class Structure {
 public:
  /// Fills the bodies of `scene` with particles at rest in their reference configuration (t = 0). Throws BadInput when a
  /// body holds no particle, or its particles are too few to carry a gradient.
  explicit Structure(const Case& scene);
  ~Structure();
  Structure(Structure&&) noexcept;
  Structure& operator=(Structure&&) noexcept;

  // Coupled window: trial() under the load of the last window, then advance() under the new one.

  /// Constant properties of the surface points, in the order of surface().
  const SurfaceProperties& surface_properties() const;

  /// Saves the state, advances it over [begin, begin + duration] under the load of the last window (none at first) and
  /// returns the surface at the end of the window. Throws NumericalFailure when an element of volume is inverted.
  Surface<D> trial(Ticks begin, Ticks duration);

  /// Restores the state saved by trial() and advances the same window under `load`; when `load` is bitwise the one the
  /// present state was computed with, that state is kept instead. Follows trial(), any number of times. Throws
  /// NumericalFailure as trial() does.
  void advance(const SurfaceLoad<D>& load);

  /// Surface in the present state: after advance() the end of the window.
  Surface<D> surface() const;
  std::vector<Vector<D>> surface_velocity() const;  ///< the same, velocities only [m/s]

  /// Load under which the present state was reached; zero forces before the first window.
  const SurfaceLoad<D>& load() const;

  /// Everything from which another Structure of the same scene goes on with the same bits, after advance().
  CompleteState<D> state() const;
  /// Throws BadInput when the state is that of another scene.
  void set_state(const CompleteState<D>& state);

  // What the state says of itself.

  Ticks time() const;
  std::size_t particles() const;
  std::size_t surface_points() const;
  const Evaluations& evaluations() const;
  int sub_steps() const;            ///< of the last window
  double largest_sub_step() const;  ///< stable sub-step in the present state [s]
  Energies energies() const;
  Momentum momentum() const;
  std::vector<FreeMotion<D>> free_motions() const;  ///< of each body, in the order of SurfaceProperties::body
  Fields<D> fields() const;

  /// `body` by name, `at` in the reference configuration [m]. Throws BadInput when the body does not exist or the point
  /// is none of it.
  MaterialPoint material_point(const std::string& body, const std::array<double, 3>& at) const;
  Vector<D> displacement(const MaterialPoint& point) const;  ///< [m]

  /// Reaction of the clamp of a body with this name, or of all its clamps when the name is empty, with the moment about
  /// `about` [m]; of the last force evaluation. Throws BadInput when there is no such clamp or body.
  Reaction reaction(const std::string& body, const std::string& clamp, const std::array<double, 3>& about) const;

  /// Total load on the surface points of one body in the last window [N/m^(3-D)].
  Vector<D> total_load(const std::string& body) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

extern template class Structure<2>;
extern template class Structure<3>;

}  // namespace tern::structure
