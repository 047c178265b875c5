#pragma once
// Gravity in the course of a run.

#include <vector>

#include "base/vector.hpp"
#include "scene/case_file.hpp"

namespace tern {

/// Largest |g| of the run at these places [m/s^2]; where gravity changes in time, at some instants from the start to the end. What a run
/// reckons with must not be that of t = 0 alone: a tank may be let be first, and shaken then.
template <int D>
double largest_gravity(const Case& scene, const std::vector<Vector<D>>& places);

}  // namespace tern
