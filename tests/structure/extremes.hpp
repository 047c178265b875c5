#pragma once
// How an extreme of the structure is run, and the verdict on what came of it.

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <limits>
#include <map>

#include "particles/error.hpp"
#include "tests/structure/extreme_scenes.hpp"

namespace tern::structure::testing {

struct Outcome {
  enum class Verdict { bounded, stopped, wrong };
  Verdict verdict = Verdict::wrong;
  std::string text;  ///< figures, or what went wrong
};

inline const char* name_of(Outcome::Verdict verdict) {
  return verdict == Outcome::Verdict::bounded ? "bounded" : verdict == Outcome::Verdict::stopped ? "stopped" : "**WRONG**";
}

/// What is wrong with the message of a run that stopped between `begin` and `end` [s]; empty when it names body, place and
/// cause, the time is that of the window, and J is one at which a run has to stop.
inline std::string fault_of_message(const std::string& message, const std::string& body, double begin, double end) {
  const auto collapsed = message.find("has collapsed to");
  if (collapsed != std::string::npos) {
    double share = 1, t = -1;
    const bool read = std::sscanf(message.c_str() + collapsed, "has collapsed to %lf of that at rest at t = %lf", &share, &t) == 2;
    const bool fine = read && share <= 1e-3 && std::abs(t - begin) <= 1e-5 * end && message.find("body '" + body + "'") != std::string::npos;
    return fine ? "" : "wrong body, sub-step or time: " + message;
  }
  for (const std::string& part : {"body '" + body + "'", std::string("Likely cause: "), std::string("Refine ")})
    if (message.find(part) == std::string::npos) return fmt::format("message without \"{}\": {}", part, message);
  if (message.find("have passed through each other at t = ") != std::string::npos) return "";
  double j = 1, t = -1;
  const auto at = message.find("J = det F = ");
  if (at == std::string::npos || std::sscanf(message.c_str() + at, "J = det F = %lf at t = %lf", &j, &t) != 2)
    return "message without J and time: " + message;
  if (j > 0 && std::isfinite(j)) return fmt::format("stopped at J = {:.3g}, which is no reason", j);
  const double slack = 1e-5 * end;  // of the printed digits
  if (t < begin - slack || t > end + slack) return fmt::format("stopped at {:.6g} s in a window from {:.6g} to {:.6g} s", t, begin, end);
  return "";
}

/// Whether the free particles have kept their order: every one sees its neighbours along the axes in the orientation they had.
/// Particles that have passed through each other can have any J of their own.
template <int D>
bool keeps_its_order(const Fields<D>& fields, double spacing) {
  const auto cell_of = [&](std::size_t p, int axis) {
    std::array<long, 3> cell{};
    for (int a = 0; a < D; ++a) cell[a] = std::lround(2 * (fields.position[p][a] - fields.displacement[p][a]) / spacing) + 2 * (a == axis);
    return cell;
  };
  std::map<std::array<long, 3>, std::size_t> particle;
  for (std::size_t p = 0; p < fields.position.size(); ++p)
    if (!fields.clamped[p]) particle[cell_of(p, -1)] = p;
  for (const auto& [cell, p] : particle) {
    Matrix<D> edges;
    bool complete = true;
    for (int a = 0; a < D && complete; ++a) {
      const auto neighbour = particle.find(cell_of(p, a));
      complete = neighbour != particle.end();
      if (complete) edges.col(a) = fields.position[neighbour->second] - fields.position[p];
    }
    if (complete && edges.determinant() <= 0) return false;
  }
  return true;
}

/// Runs the scene in windows as tern-structure does with 60 rows of output. Wrong is: a value that is not finite, energy from nothing (more than 1 %
/// of the largest energy), an account that does not close (explicit steps, the same 1 %; the loss of implicit ones is counted
/// nowhere, so they only must not gain), particles that have passed through each other, a message that misleads, a stop
/// where nothing is violent, survival of what cannot be survived.
template <int D>
Outcome run(const Extreme& extreme) {
  constexpr double tolerance = 0.01;
  const auto wrong = [](const std::string& why) { return Outcome{Outcome::Verdict::wrong, why}; };
  const bool is_explicit = extreme.scene.structure->numerics.integrator == Integrator::explicit_steps;
  const bool varies = !extreme.scene.structure->loads.empty() || !extreme.scene.structure->clamps.empty();
  const std::string& body = extreme.scene.structure->bodies[0].name;
  Structure<D> structure(extreme.scene);
  MaterialPoint end;
  if (extreme.result == Extreme::Result::frequency) end = structure.material_point(body, extreme.end);
  const auto total = [](const Energies& e) {
    return e.kinetic + e.strain + e.potential + e.penalty - e.interface_work - e.load_work - e.clamp_work;
  };
  const Energies at_start = structure.energies();
  const Momentum momentum = structure.momentum();
  double largest = at_start.kinetic + at_start.strain, highest = 0, open = 0, crossing = 0, before = 0;
  Energies e = at_start;
  while (seconds(structure.time()) < extreme.until) {
    const double begin = seconds(structure.time());
    Ticks window = 1;
    try {
      window = std::max<Ticks>(to_ticks(std::min((varies ? 10 : 100) * structure.largest_sub_step(), extreme.until / 60)), 1);
      structure.trial(structure.time(), window);
    } catch (const NumericalFailure& failure) {
      const std::string message = failure.what();
      const std::string fault = fault_of_message(message, body, begin, begin + seconds(window));
      if (extreme.stop == Extreme::Stop::never) return wrong("stopped: " + message);
      return fault.empty() ? Outcome{Outcome::Verdict::stopped, message.substr(0, message.find(". ", message.find("J = ") < message.size() ? message.find("Likely") : 0) + 1)} : wrong(fault);
    }
    e = structure.energies();
    const double present = e.kinetic + e.strain;
    largest = std::max({largest, present, std::abs(e.load_work), std::abs(e.clamp_work), std::abs(e.potential)});
    const double gain = total(e) + e.diffusion + e.damping - total(at_start);
    if (!std::isfinite(gain)) return wrong(fmt::format("energy not finite at {:.4g} s", seconds(structure.time())));
    highest = std::max(highest, gain);
    open = std::max(open, std::abs(gain));
    if (extreme.result == Extreme::Result::frequency && crossing == 0) {
      const double now = structure.displacement(end)[extreme.direction];
      if (before * now < 0) crossing = begin + seconds(window) * before / (before - now);
      before = now;
    }
  }
  const Fields<D> fields = structure.fields();
  for (const auto& x : fields.position)
    if (!x.allFinite()) return wrong("a place that is not finite");
  if (!keeps_its_order<D>(fields, extreme.scene.structure->bodies[0].spacing)) return wrong("particles have passed through each other");
  if (extreme.stop == Extreme::Stop::must) return wrong("survived");
  if (highest > tolerance * largest) return wrong(fmt::format("gained {:.2g} of its energy", highest / largest));
  if (is_explicit && open > tolerance * largest) return wrong(fmt::format("account open by {:.2g}", open / largest));
  std::string text = is_explicit ? fmt::format("account closed to {:.1e}, diffusion took {:.2g} %", open / largest, 100 * e.diffusion / largest)
                                 : fmt::format("lost {:.2g} %, gained {:.1e}", 100 * std::max(0.0, total(at_start) - total(e) - e.damping) / largest,
                                               highest / largest);
  double value = 0;
  if (extreme.result == Extreme::Result::frequency) value = crossing > 0 ? 0.5 / crossing / extreme.reference : 0;
  if (extreme.result == Extreme::Result::jacobian) {
    double nearest = std::numeric_limits<double>::max();
    for (std::size_t p = 0; p < fields.jacobian.size(); ++p) {
      double squared = 0;
      for (int a = 0; a < D; ++a) squared += std::pow(fields.position[p][a] - fields.displacement[p][a] - extreme.end[a], 2);
      if (squared < nearest) value = fields.jacobian[p] / extreme.reference;
      nearest = std::min(nearest, squared);
    }
  }
  if (extreme.result == Extreme::Result::angular_momentum) value = structure.momentum().angular[2] / momentum.angular[2];
  if (extreme.result == Extreme::Result::frequency && crossing == 0)
    text += "; has not come back";
  else if (extreme.result != Extreme::Result::none)
    text += fmt::format("; {} {:.4f}", extreme.reference_name, value);
  return {Outcome::Verdict::bounded, text};
}

inline Outcome run(const Extreme& extreme) { return extreme.scene.dimension == 2 ? run<2>(extreme) : run<3>(extreme); }
}  // namespace tern::structure::testing
