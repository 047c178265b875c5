#pragma once
// The pressure equation of one step: matrix, right-hand side, solution, and what solves it.

#include <cstdint>
#include <vector>

#include "fluid/pressure/conjugate_gradient.hpp"
#include "fluid/pressure/edge_matrix.hpp"
#include "fluid/pressure/enclosed_regions.hpp"
#include "fluid/pressure/multigrid.hpp"
#include "fluid/pressure/yielding_surface.hpp"

namespace tern::fluid {

template <int D>
struct PressureSystem {
  explicit PressureSystem(const Period<D>& period) : multigrid(period) {}

  EdgeMatrix matrix;                            ///< with a bound in place of how the structure yields
  YieldingSurface<D> yielding;                  ///< how it does
  std::vector<double> source, solution;         ///< 0 where there is no unknown
  std::vector<double> left_behind, still_left;  ///< by the solve of the equation and by its correction, as sources
  std::vector<double> correction;               ///< of the pressure
  std::vector<double> share;                    ///< of the correction that is taken, by part of the multigrid
  Multigrid<D> multigrid;
  EnclosedRegions enclosed;       ///< regions without a free surface, ...
  EnclosedRegions beside_bodies;  ///< those of them that bodies yield to, ...
  EnclosedRegions sealed;         ///< and those, put together, whose level nothing ties
  double answer_tolerance = 0;    ///< that of the InterfaceCondition
  SolveResult result;             ///< iterations: of all coupling iterations of the window

  // Scratch.
  std::vector<std::uint8_t> at_surface;  ///< particles whose pressure a free surface ties
  std::vector<double> squared_change;    ///< of what is left behind, by part
  SweptVolume<D> swept;                  ///< of the regions beside bodies
  std::vector<double> swept_left;        ///< the rate of it that the window leaves, known from its first coupling iteration
  std::vector<double> swept_wanted;      ///< the rate of it that the pressure has to answer
  ConjugateGradientWork work;
};

}  // namespace tern::fluid
