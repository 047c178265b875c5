#include "coupler/acceleration/coupling_iteration.hpp"

#include "coupler/acceleration/flat.hpp"

namespace tern::coupler {

template <int D>
void begin_iterations(const Setup<D>& setup, Workspace<D>& window, State<D>& state) {
  window.iterations = 0;
  window.contacts_are_given = false;
  window.agreed = true;
  if (setup.iterates) state.fixed_point.begin_window(window.answer.gain, window.begin);
}

template <int D>
bool note_iteration(State<D>& state, const Workspace<D>& window) {
  const std::vector<Vector<D>>& normal = window.surface.normal;
  return state.fixed_point.add(parts(window.assumed_load, window.assumed_contact, normal),
                               parts(window.answered_load, window.contact, normal), static_cast<Eigen::Index>(normal.size()));
}

template <int D>
void assume_next_load(State<D>& state, Workspace<D>& window) {
  ++state.evaluations.coupling_iterations;
  const auto points = static_cast<Eigen::Index>(window.assumed_load.force.size());
  const Eigen::VectorXd next = state.fixed_point.next();
  window.contacts_are_given = state.fixed_point.gives_contacts();
  for (Eigen::Index k = 0; k < points; ++k) {
    window.assumed_contact.force[k] = -next[D * points + k] * window.surface.normal[k];
    window.assumed_load.force[k] = next.segment<D>(D * k) + window.assumed_contact.force[k];
  }
}

template void begin_iterations<2>(const Setup<2>&, Workspace<2>&, State<2>&);
template void begin_iterations<3>(const Setup<3>&, Workspace<3>&, State<3>&);
template bool note_iteration<2>(State<2>&, const Workspace<2>&);
template bool note_iteration<3>(State<3>&, const Workspace<3>&);
template void assume_next_load<2>(State<2>&, Workspace<2>&);
template void assume_next_load<3>(State<3>&, Workspace<3>&);

}  // namespace tern::coupler
