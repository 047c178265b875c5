// Stable sub-step of the explicit integration: dt = min(courant dx, 0.9 c_0 dt_0)/(c + |v|max), the minimum over the bodies. dt_0 is what
// the forces at rest allow (stable_step.hpp), c_0 the wave speed at rest. Under compression the neo-Hookean solid stiffens while its
// reference spacing stays, in tension the St Venant-Kirchhoff solid: c is the largest wave speed at rest, at the smallest and at the
// largest stretch. A sub-step a thousand times shorter than at rest means
// that a particle has been flung off or torn out; the run would crawl on from there and never end.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "structure/shell/shell_body.hpp"
#include "structure/time_step.hpp"

namespace tern::structure {
namespace {

/// Smallest and largest principal stretch of F.
template <int D>
std::pair<double, double> stretches(const Matrix<D>& f) {
  const Eigen::Matrix<double, D, D> c = f.transpose() * f;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, D, D>> eigen;
  eigen.computeDirect(c, Eigen::EigenvaluesOnly);
  return {std::sqrt(std::max(eigen.eigenvalues()[0], 0.0)), std::sqrt(std::max(eigen.eigenvalues()[D - 1], 0.0))};
}

}  // namespace

template <int D>
double stable_sub_step(const Reference<D>& reference, double courant, const State<D>& state, const Workspace<D>& work) {
  constexpr double least_stretch = 0.05;  // the step must not shrink without bound before J <= 0 is found
  constexpr double collapse = 1e-3;
  constexpr double margin = 0.9;  // of the measured step: the largest eigenvalues are found from below, and forces turn with the body
  double dt = shell_stable_sub_step(reference, courant, state, work);
  for (const Body& body : reference.bodies) {
    if (body.shell >= 0) continue;
    double smallest = 1, largest = 1, speed = 0;
    std::size_t fastest = body.first, longest = body.first;
    for (std::size_t p = body.first; p < body.first + body.count; ++p) {
      const auto row = reference.particle_row[p];
      double squared = 0;
      for (int a = 0; a < D; ++a) squared += state.velocity[a][row] * state.velocity[a][row];
      if (!(squared <= speed)) {
        speed = squared;
        fastest = p;
      }
      const auto [low, high] = stretches<D>(deformation_gradient_of<D>(work, row));
      smallest = std::min(smallest, low);
      if (high > largest) {
        largest = high;
        longest = p;
      }
    }
    const double at_rest = body.material.pressure_wave_speed();
    const double signal_speed =
        std::max({at_rest, body.material.wave_speed_at(std::max(smallest, least_stretch)), body.material.wave_speed_at(largest)}) +
        std::sqrt(speed);
    if (!(at_rest > collapse * signal_speed))
      throw NumericalFailure(fmt::format(
          "The sub-step of body '{}' has collapsed to {:.2g} of that at rest at t = {:.6g} s: particle {} moves at {:.3g} m/s, particle {} "
          "is stretched to {:.3g} of its length, the pressure wave at rest runs at {:.3g} m/s. A particle has been flung off or torn out; "
          "the load is too violent for this material and resolution. Refine [structure] spacing ({:.3g} m), or make the body stiffer.",
          body.name, at_rest / signal_speed, seconds(state.time), fastest, std::sqrt(speed), longest, largest, at_rest, body.spacing));
    dt = std::min(dt, std::min(courant * body.spacing, margin * body.stable_step_at_rest * at_rest) / signal_speed);
  }
  return dt;
}

template double stable_sub_step<2>(const Reference<2>&, double, const State<2>&, const Workspace<2>&);
template double stable_sub_step<3>(const Reference<3>&, double, const State<3>&, const Workspace<3>&);

}  // namespace tern::structure
