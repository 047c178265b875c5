#include "fluid/initial_state.hpp"

#include "base/error.hpp"

namespace tern::fluid {

template <int D>
State<D> initial_state(const Case& scene) {
  State<D> state;
  for (const FluidBody& body : scene.fluid->bodies)
    for (const Vector<D>& x : fill_with_fluid<D>(body.shape, scene.fluid->spacing)) {
      Vector<D> u;
      for (int c = 0; c < D; ++c) u[c] = body.velocity[c](0, x[0], x[1], D == 3 ? x[D - 1] : 0);
      state.id.push_back(static_cast<std::uint32_t>(state.id.size()));
      state.position.push_back(x);
      state.velocity.push_back(u);
    }
  if (state.size() == 0) throw BadInput(scene.path + ": the fluid bodies hold no particle; make them larger than fluid.spacing.");
  for_each_particle_field(state, [n = state.size()](const char*, const char*, auto& values) { values.resize(n); });
  return state;
}

template State<2> initial_state<2>(const Case&);
template State<3> initial_state<3>(const Case&);

}  // namespace tern::fluid
