#pragma once
// How the surface answers a pressure, as the pressure equation is told (Robin condition; docs/THEORY.md, section 3).

#include <vector>

#include "coupler/acceleration/learnt_mass.hpp"
#include "coupler/setup.hpp"
#include "coupler/workspace.hpp"

namespace tern::coupler {

/// Area of every point over that at the start, which is remembered.
template <int D>
std::vector<double> stretch_of(const Surface<D>& surface, std::vector<double>& area_at_start);

/// m_s, mass per area behind a point that a pressure moves within the window [kg/m^2].
template <int D>
double responding_mass(const Setup<D>& setup, const Workspace<D>& window, std::size_t k);

/// m_p, mass per area with which the pressure equation takes each point to answer in this window [kg/m^2]: the learnt mass where one pass
/// may be enough, m_s times a factor in one pass, and at least some layers of fluid where a body is light.
template <int D>
std::vector<double> robin_mass(const Setup<D>& setup, const Workspace<D>& window, const LearntMass& learnt);

/// How many times an error of the load may come back in its answer: the largest m_p/m_s, at least 1.
template <int D>
double largest_gain(const Setup<D>& setup, const Workspace<D>& window);

/// Reference pressure and Robin mass of the window's condition, from the assumed load and what is known of the answer to it.
template <int D>
void set_robin_condition(const Setup<D>& setup, Workspace<D>& window);

}  // namespace tern::coupler
