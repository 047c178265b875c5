#pragma once
// What a particle is in a step: one byte of named marks.

#include <cstdint>

namespace tern::fluid {

class ParticleClass {
 public:
  enum Mark : std::uint8_t {
    thin_support = 1,         ///< tr M / D says free surface. Kept from step to step for the hysteresis of this mark
    too_few_neighbours = 2,   ///< to hold a pressure: spray. The next step asks for it before it is set anew
    corrected_gradient = 4,   ///< the moments of the fluid neighbours alone have an inverse C^F
    beside_surface = 8,       ///< a neighbour is not interior
    beside_spray = 16,        ///< a neighbour is no pressure unknown
    symmetric_gradient = 32,  ///< pressure gradient in its symmetric form
    enclosed = 64,            ///< in a region without a free surface
  };

  bool has(Mark mark) const { return (marks_ & mark) != 0; }
  void set(Mark mark, bool value) { marks_ = static_cast<std::uint8_t>(value ? marks_ | mark : marks_ & ~mark); }
  /// Clears all marks but these.
  void keep(int marks) { marks_ = static_cast<std::uint8_t>(marks_ & marks); }
  std::uint8_t& marks() { return marks_; }  ///< for atomic writes

  bool spray() const { return has(too_few_neighbours); }
  bool pressure_unknown() const { return !spray(); }
  bool interior() const { return (marks_ & (thin_support | too_few_neighbours)) == 0; }
  /// Interior, and no neighbour is at a free surface.
  bool inside() const { return interior() && !has(beside_surface); }
  bool free_surface() const { return (marks_ & (thin_support | too_few_neighbours)) == thin_support; }

  friend bool operator==(ParticleClass, ParticleClass) = default;

 private:
  std::uint8_t marks_ = 0;
};

}  // namespace tern::fluid
