// Windows of the structure: what is saved, restored and kept between trial() and advance().

#include "structure/structure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>

#include "base/error.hpp"
#include "structure/complete_state.hpp"
#include "structure/energy.hpp"
#include "structure/free_motion.hpp"
#include "structure/implicit/implicit_step.hpp"
#include "structure/loads.hpp"
#include "structure/material_point.hpp"
#include "structure/reference.hpp"
#include "structure/shell/shell_body.hpp"
#include "structure/stable_step.hpp"
#include "structure/surface_points.hpp"
#include "structure/time_step.hpp"

namespace tern::structure {

template <int D>
struct Structure<D>::Parts {
  Reference<D> reference;
  SurfaceAttachment<D> attachment;
  VectorExpression gravity;
  bool has_gravity = false;
  // Constant over the present window [N/m^(3-D)]: the weight of the particles, and the loads of the case.
  RowVectors<D> weight;
  Loads<D> loads;
  double courant = 0;

  State<D> state, saved;  // now, and at the begin of the window
  Workspace<D> work;      // between two calls it holds the deformation gradient of `state`
  Ticks duration = 0;     // of the present window
  int sub_steps = 0;      // explicit ones it takes, or would take
  IntegratorChoice choice;
  bool always_implicit = false, implicit_window = false;
  std::unique_ptr<ImplicitStep<D>> implicit;  // null when the integrator is explicit

  explicit Parts(const Case& scene)
      : reference(build_reference<D>(scene.structure.value())),
        attachment(attach_surface(reference, scene)),
        gravity(scene.gravity),
        loads(*scene.structure, reference, attachment),
        courant(scene.structure->numerics.courant),
        state(state_at_rest(reference, attachment.properties.body.size())),
        work(workspace_for(reference)) {
    for (auto& axis : weight) axis.assign(reference.rows, 0);
    for (int a = 0; a < D; ++a) has_gravity |= !gravity[a].is_constant() || gravity[a](0) != 0;
    for (std::size_t p = 0; p < reference.particle_row.size(); ++p) {
      const auto row = reference.particle_row[p];
      if (reference.inverse_mass[row] == 0) continue;
      const auto x = place(row);
      const auto& velocity = scene.structure->bodies[reference.particle_body[p]].velocity;
      for (int a = 0; a < D; ++a) {
        state.velocity[a][row] = velocity[a](0, x[0], x[1], x[2]);
        state.undisturbed &= state.velocity[a][row] == 0;
      }
    }
    if (scene.structure->numerics.integrator != Integrator::explicit_steps) {
      implicit = std::make_unique<ImplicitStep<D>>(reference);
    }
    always_implicit = scene.structure->numerics.integrator == Integrator::implicit_steps;
    const std::vector<double> stable = stable_steps_at_rest(reference);
    for (std::size_t b = 0; b < stable.size(); ++b) reference.bodies[b].stable_step_at_rest = stable[b];
    damp_shells(reference, scene.structure->numerics.riemann_diffusion);
    // A clamp that moves from the start on does so in the forces of the start as well: the diffusion asks how fast.
    if (const double soon = stable.empty() ? 0 : *std::min_element(stable.begin(), stable.end()); soon > 0)
      aim_clamps(reference, soon, soon, state);
    all_forces();
  }

  /// Internal force of the present state with everything explicit steps need.
  void all_forces() { internal_forces(reference, seconds(state.time), state, work); }

  std::array<double, 3> place(std::int32_t row) const {
    std::array<double, 3> x{};
    for (int a = 0; a < D; ++a) x[a] = reference.position[a][row] + state.displacement[a][row];
    return x;
  }

  /// Particles on the clamped edge of a shell stand for half a cell outside the clamp, which is loaded as the others are.
  bool is_shell(std::uint32_t body) const { return reference.bodies[body].shell >= 0; }

  /// Share that a foot of the surface has in the load on its patch.
  Vector<D> load_on(std::size_t foot) const { return attachment.share[foot] * state.load.force[attachment.patch[foot]]; }

  /// Weight of the free particles and loads of the case, taken at the middle of the window and at the positions of its begin.
  void update_forces() {
    const double t = seconds(state.time) + 0.5 * seconds(duration);
    loads.update(t, attachment, reference, state, work);
    if (!has_gravity) return;
    for (std::size_t p = 0; p < reference.particle_row.size(); ++p) {
      const auto row = reference.particle_row[p];
      if (reference.inverse_mass[row] == 0 && !is_shell(reference.particle_body[p])) continue;
      const auto x = place(row);
      for (int a = 0; a < D; ++a) weight[a][row] = reference.mass[row] * gravity[a](t, x[0], x[1], x[2]);
    }
  }

  /// Whether a clamp moves in the window.
  void begin_clamp_motion() {
    aim_clamps(reference, seconds(state.time) + seconds(duration), seconds(duration), state);
    bool moves = false;
    for (std::size_t c = 0; c < reference.clamps.size(); ++c) {
      if (!reference.clamps[c].motion) continue;
      moves |= state.clamp_spin[c] != 0;
      for (const auto row : reference.clamps[c].row)
        for (int a = 0; a < D; ++a) moves |= state.velocity[a][row] != 0;
      work.evaluations.moving_clamps += static_cast<long>(reference.clamps[c].row.size());
    }
    state.undisturbed &= !moves;
  }

  /// Advances the present window under state.load.
  void advance() {
    advance_state();
    deformation_gradient(reference, state, work);
  }

  /// Counts the work of the constant forces, too: f . (d_end - d_begin).
  void advance_state() {
    begin_clamp_motion();
    for (int a = 0; a < D; ++a) state.external_force[a] = weight[a];
    shell_derivatives(reference, state, work);  // of the begin of the window, at which their loads are spread
    for (std::size_t k = 0; k < attachment.row.size(); ++k)
      add_point_force<D>(attachment, reference, work, k, load_on(k), state.external_force);
    loads.add_to(state.external_force);
    if (loads.any()) work.evaluations.loads += reference.rows;
    for (const auto& axis : state.external_force)
      state.undisturbed = state.undisturbed && std::all_of(axis.begin(), axis.end(), [](double f) { return f == 0; });
    if (state.undisturbed) {  // nothing has moved it yet and nothing does now
      state.time += duration;
      ++work.evaluations.windows_at_rest;
      return;
    }
    const ImplicitCounts before = implicit ? implicit->memory().counts : ImplicitCounts{};
    advance_window(reference, duration, sub_steps, implicit_window ? implicit.get() : nullptr, state, work);
    if (implicit_window) {
      const ImplicitCounts& after = implicit->memory().counts;
      choice.add(implicit->costs(), sub_steps, after.evaluations - before.evaluations, after.factors - before.factors);
    }
    double total = 0, by_gravity = 0, by_loads = 0;
    for (int a = 0; a < D; ++a)
      for (const auto row : reference.particle_row) {
        const double moved = state.displacement[a][row] - saved.displacement[a][row];
        total += state.external_force[a][row] * moved;
        by_gravity += weight[a][row] * moved;
        if (loads.any()) by_loads += loads.force()[a][row] * moved;
      }
    double on_clamps = 0;  // of the fluid on the faces that lie in clamps
    const std::vector<Vector<D>> moved = held_feet_moved(attachment, reference, seconds(saved.time), seconds(state.time));
    for (std::size_t k = 0; k < moved.size(); ++k) on_clamps += load_on(attachment.held[k]).dot(moved[k]);
    total += on_clamps;
    state.clamp_work -= on_clamps;  // which the clamp takes, with
    for (std::size_t p = 0; p < reference.particle_row.size(); ++p) {
      const auto row = reference.particle_row[p];
      if (reference.inverse_mass[row] > 0) continue;
      for (int a = 0; a < D; ++a)  // all that loads the particles on its face
        state.clamp_work -= state.external_force[a][row] * (state.displacement[a][row] - saved.displacement[a][row]);
    }
    state.gravity_work += by_gravity;
    state.load_work += by_loads;
    state.interface_work += total - by_gravity - by_loads;
  }
};

template <int D>
Structure<D>::Structure(const Case& scene) : parts_(std::make_unique<Parts>(scene)) {}
template <int D>
Structure<D>::~Structure() = default;
template <int D>
Structure<D>::Structure(Structure&&) noexcept = default;
template <int D>
Structure<D>& Structure<D>::operator=(Structure&&) noexcept = default;

template <int D>
const SurfaceProperties& Structure<D>::surface_properties() const {
  return parts_->attachment.properties;
}

template <int D>
Surface<D> Structure<D>::trial(Ticks begin, Ticks duration) {
  Parts& p = *parts_;
  assert(begin == p.state.time && duration > 0);
  p.state.time = begin;
  p.duration = duration;
  p.saved = p.state;
  const double dt = stable_sub_step(p.reference, p.courant, p.state, p.work);
  check_bond_order(p.reference, p.state, p.work);
  p.sub_steps = std::max(1, static_cast<int>(std::ceil(seconds(duration) / dt)));
  if (p.implicit) {
    const bool was_implicit = p.implicit_window;
    p.implicit_window = p.always_implicit || p.choice.prefers_implicit(p.implicit->costs(), p.sub_steps);
    if (was_implicit && !p.implicit_window) {
      p.all_forces();
      p.saved = p.state;
    }
  }
  p.update_forces();
  p.advance();
  return present_surface(p.attachment, p.reference, p.state, p.work);
}

template <int D>
void Structure<D>::advance(const SurfaceLoad<D>& load) {
  Parts& p = *parts_;
  assert(load.force.size() == p.attachment.properties.body.size());
  const bool same =
      load.force.empty() || std::memcmp(load.force.data(), p.state.load.force.data(), load.force.size() * sizeof load.force[0]) == 0;
  if (same) return;
  p.state = p.saved;
  p.state.load = load;
  p.advance();
}

template <int D>
CompleteState<D> Structure<D>::state() const {
  const Parts& p = *parts_;
  return {p.state, p.implicit ? p.implicit->memory() : ImplicitMemory<D>{}, p.choice, p.implicit_window, p.work.evaluations};
}

template <int D>
void Structure<D>::set_state(const CompleteState<D>& given) {
  Parts& p = *parts_;
  CompleteState<D> state;
  copy_state(given, state);
  const auto fits = [&](const RowVectors<D>& values) { return values[D - 1].size() == p.reference.rows; };
  if (!fits(state.motion.displacement) || !fits(state.motion.velocity) || !fits(state.motion.internal_force) ||
      !fits(state.motion.external_force) || (state.implicit.factored_h > 0 && !fits(state.implicit.factored_displacement)) ||
      state.motion.load.force.size() != p.attachment.properties.body.size())
    throw BadInput("The state is that of another scene: it has other particles or surface points.");
  p.state = std::move(state.motion);
  if (p.implicit) p.implicit->set_memory(p.reference, state.implicit, p.state, p.work);
  p.choice = state.choice;
  p.implicit_window = state.implicit_window;
  p.work.evaluations = state.evaluations;
  deformation_gradient(p.reference, p.state, p.work);
}

template <int D>
Surface<D> Structure<D>::surface() const {
  return present_surface(parts_->attachment, parts_->reference, parts_->state, parts_->work);
}

template <int D>
std::vector<Vector<D>> Structure<D>::surface_velocity() const {
  return tern::structure::surface_velocity(parts_->attachment, parts_->reference, parts_->state, parts_->work);
}

template <int D>
const SurfaceLoad<D>& Structure<D>::load() const {
  return parts_->state.load;
}
template <int D>
Ticks Structure<D>::time() const {
  return parts_->state.time;
}
template <int D>
std::size_t Structure<D>::particles() const {
  return parts_->reference.particle_row.size();
}
template <int D>
std::size_t Structure<D>::surface_points() const {
  return parts_->attachment.properties.body.size();
}
template <int D>
const Evaluations& Structure<D>::evaluations() const {
  return parts_->work.evaluations;
}
template <int D>
int Structure<D>::sub_steps() const {
  return parts_->sub_steps;
}
template <int D>
double Structure<D>::largest_sub_step() const {
  return stable_sub_step(parts_->reference, parts_->courant, parts_->state, parts_->work);
}

template <int D>
Energies Structure<D>::energies() const {
  return energies_of(parts_->reference, parts_->state, parts_->work);
}

template <int D>
Momentum Structure<D>::momentum() const {
  return momentum_of(parts_->reference, parts_->state);
}

template <int D>
std::vector<FreeMotion<D>> Structure<D>::free_motions() const {
  return tern::structure::free_motions(parts_->reference, parts_->state);
}

template <int D>
Fields<D> Structure<D>::fields() const {
  return fields_of(parts_->reference, parts_->state, parts_->work);
}

template <int D>
MaterialPoint Structure<D>::material_point(const std::string& body, const std::array<double, 3>& at) const {
  Vector<D> x;
  for (int a = 0; a < D; ++a) x[a] = at[a];
  return find_material_point<D>(parts_->reference, body, x);
}

template <int D>
Vector<D> Structure<D>::displacement(const MaterialPoint& point) const {
  Vector<D> d = Vector<D>::Zero();
  for (std::size_t n = 0; n < point.particle.size(); ++n)
    for (int a = 0; a < D; ++a) d[a] += point.weight[n] * parts_->state.displacement[a][parts_->reference.particle_row[point.particle[n]]];
  return d;
}

template <int D>
Reaction Structure<D>::reaction(const std::string& body, const std::string& clamp, const std::array<double, 3>& about) const {
  const Reference<D>& reference = parts_->reference;
  const SurfaceAttachment<D>& attachment = parts_->attachment;
  const State<D>& state = parts_->state;
  Reaction reaction;
  const auto add = [&](const Vector<D>& place, const Vector<D>& held) {  // the force that has to be borne there
    std::array<double, 3> arm{}, force{};
    for (int a = 0; a < D; ++a) {
      arm[a] = place[a] - about[a];
      force[a] = -held[a];
    }
    for (int a = 0; a < 3; ++a) {
      const int b = (a + 1) % 3, c = (a + 2) % 3;
      reaction.force[a] += force[a];
      reaction.moment[a] += arm[b] * force[c] - arm[c] * force[b];
    }
  };
  const auto add_couple = [&](const Vector<3>& couple) {
    for (int a = 0; a < 3; ++a) reaction.moment[a] += couple[a];
  };
  const auto add_row = [&](std::int32_t row) {
    Vector<D> place = reference.position_of(row), held;
    for (int a = 0; a < D; ++a) {
      place[a] += state.displacement[a][row];
      held[a] = state.internal_force[a][row] + state.external_force[a][row];
    }
    add(place, held);
  };
  const std::vector<Vector<D>> moved = held_feet_moved(attachment, reference, 0, seconds(state.time));
  const auto add_fluid = [&](const auto& bears) {  // on the faces that are in the clamp
    for (std::size_t n = 0; n < moved.size(); ++n) {
      const std::size_t k = attachment.held[n];
      if (bears(k)) add(reference.position_of(attachment.row[k]) + attachment.offset[k] + moved[n], parts_->load_on(k));
    }
  };
  bool found = false;
  for (std::size_t n = 0; n < reference.clamps.size(); ++n) {
    const Clamp& known = reference.clamps[n];
    if (clamp.empty() || known.name != clamp || reference.bodies[known.body].name != body) continue;
    found = true;
    for (const auto row : known.row) add_row(row);
    for (const ShellBody<D>& shell : reference.shells)
      if (shell.body == known.body) add_couple(shell_clamp_couple(shell, parts_->work, static_cast<std::int32_t>(n)));
    add_fluid([&](std::size_t k) { return attachment.clamp[k] == static_cast<std::int32_t>(n); });
  }
  for (std::size_t n = 0; n < reference.bodies.size(); ++n) {
    const Body& known = reference.bodies[n];
    if (!clamp.empty() || known.name != body) continue;
    found = true;
    for (std::size_t p = known.first; p < known.first + known.count; ++p) {
      const auto row = reference.particle_row[p];
      if (reference.inverse_mass[row] == 0) add_row(row);
    }
    for (const ShellBody<D>& shell : reference.shells)
      if (shell.body == n) add_couple(shell_clamp_couple(shell, parts_->work, -1));
    add_fluid([&](std::size_t k) { return attachment.body[k] == n; });
  }
  if (!found)
    throw BadInput(
        fmt::format("A gauge asks for the reaction of {}, which does not exist; name a [[structure.body]] or one "
                    "of its [[structure.clamp]]s.",
                    clamp.empty() ? "body '" + body + "'" : "clamp '" + clamp + "' of body '" + body + "'"));
  return reaction;
}

template <int D>
Vector<D> Structure<D>::total_load(const std::string& body) const {
  Vector<D> total = Vector<D>::Zero();
  const auto& attachment = parts_->attachment;
  for (std::size_t k = 0; k < attachment.properties.body.size(); ++k)
    if (parts_->reference.bodies[attachment.properties.body[k]].name == body) total += parts_->state.load.force[k];
  return total;
}

template class Structure<2>;
template class Structure<3>;

}  // namespace tern::structure
