#pragma once
// The gauges that the structure evaluates.

#include <functional>
#include <vector>

#include "scene/gauges.hpp"
#include "structure/structure.hpp"

namespace tern::structure {

/// The gauges of a scene that belong to the structure, with what they know of the undeformed body found once.
template <int D>
class StructureGauges {
 public:
  /// `structure` at t = 0. Throws BadInput for a gauge outside its body or at a clamp that does not exist.
  StructureGauges(const Case& scene, const Structure<D>& structure);
  /// In the present state, in the order of their columns.
  GaugeValues values(const Structure<D>& structure) const;

 private:
  std::vector<std::function<void(const Structure<D>&, GaugeValues&)>> gauges_;
};

}  // namespace tern::structure
