#pragma once
// Which particles of a body its clamps and hinges hold.

#include <vector>

#include "scene/case_file.hpp"

namespace tern {

/// One entry for each particle of fill_body(), in its order. Those of a solid are inside a region. Those of a shell stand on a held edge,
/// where by round-off they may be outside of it.
template <int D>
std::vector<bool> held_particles(const StructureBody& body);

}  // namespace tern
