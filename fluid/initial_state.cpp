#include "fluid/initial_state.hpp"

#include <algorithm>

#include "base/error.hpp"

namespace tern::fluid {

template <int D>
StartParticles<D>::StartParticles(const Case& scene) {
  for (const FluidBody& body : scene.fluid->bodies) {
    bodies_.push_back(fill_with_fluid<D>(body.shape, scene.fluid->spacing));
    size_ += bodies_.back().size();
  }
  if (size_ == 0) throw BadInput(scene.path + ": the fluid bodies hold no particle; make them larger than fluid.spacing.");
}

template <int D>
State<D> initial_state(const Case& scene, const StartParticles<D>& particles, std::size_t first, std::size_t last) {
  State<D> state;
  particles.for_each(first, last, [&](std::size_t body, const Vector<D>& x) {
    Vector<D> u;
    for (int c = 0; c < D; ++c) u[c] = scene.fluid->bodies[body].velocity[c](0, x[0], x[1], D == 3 ? x[D - 1] : 0);
    state.id.push_back(static_cast<std::uint32_t>(first + state.id.size()));
    state.position.push_back(x);
    state.velocity.push_back(u);
  });
  for_each_particle_field(state, [n = state.size()](const char*, const char*, auto& values) { values.resize(n); });
  std::fill(state.stopped.begin(), state.stopped.end(), Vector<D>::Zero());
  std::fill(state.region.begin(), state.region.end(), EnclosedPast::none);
  return state;
}

template class StartParticles<2>;
template class StartParticles<3>;
template State<2> initial_state<2>(const Case&, const StartParticles<2>&, std::size_t, std::size_t);
template State<3> initial_state<3>(const Case&, const StartParticles<3>&, std::size_t, std::size_t);

}  // namespace tern::fluid
