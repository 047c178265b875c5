#pragma once
// The particles at t = 0.

#include <algorithm>
#include <cstddef>
#include <vector>

#include "fluid/state.hpp"
#include "scene/case_file.hpp"
#include "scene/geometry.hpp"

namespace tern::fluid {

/// Particles that fill the fluid bodies, body by body. Kept are the rows of their lattices, so that no process needs memory for all.
template <int D>
class StartParticles {
 public:
  /// Throws BadInput when there is no particle.
  explicit StartParticles(const Case& scene);

  std::size_t size() const { return size_; }
  /// Calls visit(body, x) for the particles first .. last - 1.
  template <class Visit>
  void for_each(std::size_t first, std::size_t last, Visit&& visit) const {
    std::size_t before = 0;  // particles
    for (std::size_t body = 0; body < bodies_.size(); ++body)
      for (const auto& run : bodies_[body].runs()) {
        const std::size_t count = static_cast<std::size_t>(run.count);
        const std::size_t from = first > before ? first - before : 0, to = last > before ? std::min(last - before, count) : 0;
        for (std::size_t i = from; i < to; ++i) visit(body, bodies_[body].at(run, static_cast<long>(i)));
        before += count;
      }
  }

 private:
  std::vector<LatticePoints<D>> bodies_;
  std::size_t size_ = 0;
};

/// The state of the particles first .. last - 1, whose labels are these numbers.
template <int D>
State<D> initial_state(const Case& scene, const StartParticles<D>& particles, std::size_t first, std::size_t last);

}  // namespace tern::fluid
