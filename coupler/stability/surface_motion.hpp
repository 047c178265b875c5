#pragma once
// Does the surface go where its velocity carries it? Found by name: velocities of another unit or sign, not interleaved, of another
// point; positions that jump.
//
// Let w_j be the velocity at the end of window j - 1, dt_j the length of window j, x_j the position at its begin. A surface is sound where
// its mean velocity in a window lies between those at the two ends (in steady motion of tern.participant: the mean of both).
// Then, with the position m_j halfway under the old load, at whose end the velocity is w*_j,
//     x_j         = m_j - dt_j/4 (w_j + w*_j)      up to  dt_j/4 |w*_j - w_j|
//     x_j+1 - x_j = dt_j/2 (w_j + w_j+1)           up to  dt_j/2 |w_j+1 - w_j|
// The sums of both sides over several windows are compared. w_j+1 is known where the last load was tried (SurfaceVelocity). Where it was
// not, it is that of the last trial up to D = 4 dt/m |change of pressure|: a mean velocity changes by dt/2 p/m, a velocity at the end by
// less than twice that, and a stiff bar that is loaded at its end moves there four times as fast as its whole mass would.
// On top, half the sum of both sides is granted: only what is wrong by a factor above 3, or by more than 60 degrees, is refused.

#include <optional>
#include <string>
#include <vector>

#include "proto/interface.hpp"

namespace tern::coupler {

template <int D>
class SurfaceMotion {
 public:
  /// `size` of the scene [m]: positions are taken to be exact to its single precision. `from_start`: the surface has not been loaded yet.
  SurfaceMotion(const SurfaceProperties& properties, double size, bool from_start);

  /// Of a window of this length [s]; the fault, or nothing.
  std::string surface(double duration, const Surface<D>& surface);
  void answer(const SurfaceLoad<D>& load, const std::vector<Vector<D>>& velocity);
  void apply(const SurfaceLoad<D>& load);

 private:
  std::string compare(const Surface<D>& surface);
  std::vector<double> doubt(const SurfaceLoad<D>& load) const;

  std::vector<std::uint32_t> body_;
  std::vector<double> mass_;  ///< least of each body [kg/m^2]
  double round_off_;
  double duration_ = 0;
  std::vector<double> area_;
  std::optional<SurfaceLoad<D>> last_load_;  ///< under which the next Surface is made; empty: not known
  std::optional<SurfaceLoad<D>> tried_load_;
  std::vector<Vector<D>> tried_velocity_;

  std::vector<Vector<D>> velocity_;  ///< at the begin of the window; empty: not known
  std::vector<double> velocity_doubt_;

  int windows_ = 0;                  ///< since the place that is compared with
  double time_ = 0;                  ///< the same [s]
  std::vector<Vector<D>> position_;  ///< then; empty: none yet
  std::vector<Vector<D>> carried_;   ///< since then, by the velocities
  std::vector<double> tolerance_;
};

}  // namespace tern::coupler
