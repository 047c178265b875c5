#include "fluid/motion/advance.hpp"

#include "base/parallel.hpp"

namespace tern::fluid {

template <int D>
double work_of_gravity(double mass, double duration, const State<D>& state, const Prediction<D>& prediction) {
  return ordered_reduce(static_cast<std::ptrdiff_t>(state.size()), 0.0, [&](std::ptrdiff_t i) {
    return 0.5 * mass * duration * prediction.gravity[i].dot(state.velocity[i] + prediction.velocity[i]);
  });
}

template <int D>
void advance(double duration, const Prediction<D>& prediction, State<D>& state) {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(state.size());
  parallel_for(n, [&](std::ptrdiff_t i) {
    state.velocity[i] = prediction.velocity[i];
    state.position[i] = prediction.position[i] + 0.5 * duration * prediction.velocity[i];
  });
}

template double work_of_gravity<2>(double, double, const State<2>&, const Prediction<2>&);
template double work_of_gravity<3>(double, double, const State<3>&, const Prediction<3>&);
template void advance<2>(double, const Prediction<2>&, State<2>&);
template void advance<3>(double, const Prediction<3>&, State<3>&);

}  // namespace tern::fluid
