#include "coupler/motion_error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tern::coupler {
namespace {

/// What a window may leave of the surface's place, in spacings of the fluid: a vibration of one spacing then has about 59 windows a period,
/// and one of a hundredth 13. Displacements of 1e-4 dx are far below what particles resolve.
constexpr double tolerance = 1e-4;
/// Share of the last window in the mean. Two successive errors are multiplied: of a motion that windows resolve they agree,
/// of impacts and of noise, which no shorter window would resolve any better, they have opposite signs.
constexpr double share_of_last = 0.2;

}  // namespace

template <int D>
void follow_motion(const std::vector<std::uint32_t>& body, const std::vector<Vector<D>>& begin, const std::vector<Vector<D>>& end,
                   const std::vector<double>& area, double duration_before, double duration, MotionError<D>& motion) {
  if (begin.size() != end.size()) return;  // there is none before the first window
  const bool has_acceleration = !motion.acceleration.empty(), has_error = !motion.error.empty();
  const std::size_t bodies = body.empty() ? 0 : 1 + *std::max_element(body.begin(), body.end());
  std::vector<double> product(bodies, 0.0), sum(bodies, 0.0);
  motion.acceleration.resize(end.size());
  if (has_acceleration) motion.error.resize(end.size());
  motion.square.resize(bodies, 0.0);
  const double factor = duration * duration * duration / (6 * (duration_before + duration));
  // What longer windows have left counts as what this one would leave of such a motion, or windows that it has shortened would be
  // shortened again for it. What shorter ones have left is not made larger: it may be noise.
  const double shorter = duration_before > 0 ? std::pow(std::min(1.0, duration / duration_before), 3) : 1;
  for (std::size_t k = 0; k < end.size(); ++k) {
    const Vector<D> acceleration = (end[k] - begin[k]) / duration;
    if (has_acceleration) {
      const Vector<D> error = factor * (acceleration - motion.acceleration[k]);
      if (has_error) {
        product[body[k]] += area[k] * shorter * error.dot(motion.error[k]);
        sum[body[k]] += area[k];
      }
      motion.error[k] = error;
    }
    motion.acceleration[k] = acceleration;
  }
  for (double& square : motion.square) square *= shorter * shorter;
  for (std::size_t b = 0; b < bodies; ++b)
    if (sum[b] > 0) motion.square[b] += share_of_last * (product[b] / sum[b] - motion.square[b]);
}

template <int D>
double longest_window(double spacing, const MotionError<D>& motion, double duration) {
  double square = 0;
  for (const double of_body : motion.square) square = std::max(square, of_body);
  return square > 0 ? duration * std::cbrt(tolerance * spacing / std::sqrt(square)) : std::numeric_limits<double>::infinity();
}

template void follow_motion<2>(const std::vector<std::uint32_t>&, const std::vector<Vector<2>>&, const std::vector<Vector<2>>&,
                               const std::vector<double>&, double, double, MotionError<2>&);
template void follow_motion<3>(const std::vector<std::uint32_t>&, const std::vector<Vector<3>>&, const std::vector<Vector<3>>&,
                               const std::vector<double>&, double, double, MotionError<3>&);
template double longest_window<2>(double, const MotionError<2>&, double);
template double longest_window<3>(double, const MotionError<3>&, double);

}  // namespace tern::coupler
