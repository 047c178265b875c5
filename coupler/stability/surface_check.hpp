#pragma once
// What only the coupler can see of a surface: whether it is that of the case's bodies, and whether it moves as a surface can.

#include <string>
#include <vector>

#include "base/time.hpp"
#include "coupler/stability/surface_motion.hpp"
#include "proto/interface.hpp"
#include "scene/case_file.hpp"

namespace tern::coupler {

/// Every function answers with the fault, a piece of a sentence, or with nothing.
template <int D>
class SurfaceCheck {
 public:
  /// `from_start`: the first surface is that of the bodies as the case has them. `own`: it is of tern's own structure, whose areas are
  /// right.
  SurfaceCheck(const Case& scene, const SurfaceProperties& properties, bool from_start, bool own = false);

  std::string surface(Ticks duration, const Surface<D>& surface);
  /// The velocities under a load that was tried.
  std::string answer(const SurfaceLoad<D>& load, const std::vector<Vector<D>>& velocity);
  void apply(const SurfaceLoad<D>& load) {
    if (moves_as_sent_) motion_.apply(load);
  }
  std::string particles(Ticks duration, const InterfaceParticles<D>& particles) const;

 private:
  std::string first(double duration, const Surface<D>& surface) const;
  std::string wrong_areas(std::size_t body, const Surface<D>& surface) const;
  std::string stretched(const Surface<D>& surface) const;
  std::string far(const std::vector<Vector<D>>& position) const;
  std::string fast(double duration, const std::vector<Vector<D>>& velocity) const;

  std::vector<StructureBody> bodies_;
  std::vector<std::uint32_t> body_;
  double density_;      ///< of the fluid [kg/m^3]
  Bounds<D> scene_;     ///< domain and bodies
  Vector<D> margin_;    ///< its diagonal; no end where the fluid repeats itself [m]
  bool moves_as_sent_;  ///< not with the explicit coupling, which sends the velocity at the begin
  bool first_, own_;
  double duration_ = 0;                       ///< of the present window [s]
  std::vector<Vector<D>> position_, normal_;  ///< in the window before
  std::vector<double> area_;                  ///< in the window before
  SurfaceMotion<D> motion_;
};

}  // namespace tern::coupler
