#include "coupler/acceleration/coupling_iteration.hpp"

#include "coupler/acceleration/flat.hpp"

namespace tern::coupler {

template <int D>
void begin_iterations(const Setup<D>& setup, Workspace<D>& window, State<D>& state) {
  window.iterations = 0;
  window.agreed = true;
  if (setup.iterates) state.fixed_point.begin_window(window.answer.gain, window.begin);
}

template <int D>
void assume_next_load(State<D>& state, Workspace<D>& window) {
  ++state.evaluations.coupling_iterations;
  const Eigen::VectorXd next = state.fixed_point.next();
  const auto points = static_cast<Eigen::Index>(window.assumed_load.force.size());
  for (Eigen::Index k = 0; k < points; ++k) {
    window.assumed_contact.force[k] = next.segment<D>(D * (points + k));
    window.assumed_load.force[k] = next.segment<D>(D * k) + window.assumed_contact.force[k];
  }
}

template void begin_iterations<2>(const Setup<2>&, Workspace<2>&, State<2>&);
template void begin_iterations<3>(const Setup<3>&, Workspace<3>&, State<3>&);
template void assume_next_load<2>(State<2>&, Workspace<2>&);
template void assume_next_load<3>(State<3>&, Workspace<3>&);

}  // namespace tern::coupler
