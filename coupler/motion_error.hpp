#pragma once
// What windows miss of the surface's motion. Fluid and structure exchange at the ends of windows; between them the fluid takes the velocity
// of the surface to change evenly. What that leaves of the surface's place in a window of length dt is dt^3 |d2v/dt2| / 12 (the trapezoidal
// rule). The window is short enough where that is a small part of the fluid's spacing (docs/THEORY.md, section 3).

#include <cstdint>
#include <vector>

#include "base/vector.hpp"

namespace tern::coupler {

template <int D>
struct MotionError {
  std::vector<Vector<D>> acceleration;  ///< of every surface point in the last window [m/s^2]; empty before the second one
  std::vector<Vector<D>> error;         ///< what the last window has left of its place [m]; empty before the third one
  std::vector<double> square;           ///< of that, by body: mean over its surface and the last windows [m^2]

  /// The list of the members: visit(name, member of each) for every one.
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("acceleration", all.acceleration...);
    visit("error", all.error...);
    visit("square", all.square...);
  }
};

/// After a window: the body of every surface point, its velocities at begin and end [m/s] and its area [m^(D-1)], length of the window
/// before and of this one [s].
template <int D>
void follow_motion(const std::vector<std::uint32_t>& body, const std::vector<Vector<D>>& begin, const std::vector<Vector<D>>& end,
                   const std::vector<double>& area, double duration_before, double duration, MotionError<D>& motion);

/// The longest window that leaves no more than the tolerance of any body's motion, after one of this duration [s]; infinite where nothing
/// is known of it. `spacing`: of the fluid [m].
template <int D>
double longest_window(double spacing, const MotionError<D>& motion, double duration);

}  // namespace tern::coupler
