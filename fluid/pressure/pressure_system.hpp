#pragma once
// The pressure equation of one step: matrix, right-hand side, solution, and what solves it.

#include <vector>

#include "fluid/pressure/conjugate_gradient.hpp"
#include "fluid/pressure/edge_matrix.hpp"
#include "fluid/pressure/enclosed_regions.hpp"
#include "fluid/pressure/multigrid.hpp"

namespace tern::fluid {

template <int D>
struct PressureSystem {
  explicit PressureSystem(const Period<D>& period) : multigrid(period) {}

  EdgeMatrix matrix;
  std::vector<double> source, solution;         ///< of the padded length of the matrix
  std::vector<double> left_behind, still_left;  ///< by the first solve of this window and by its correction, as sources; empty before
  std::vector<double> correction;               ///< of the pressure
  std::vector<double> share;                    ///< of the correction that is taken, by part of the multigrid
  Multigrid<D> multigrid;
  EnclosedRegions regions;          ///< that neither a free surface nor a body ties
  EnclosedRegions without_surface;  ///< that no free surface ties, whether bodies yield to them or not
  SolveResult result;               ///< iterations: of all coupling iterations of the window

  // Scratch.
  std::vector<float> missing_support;
  std::vector<double> squared_change;  ///< of what is left behind, by part
  ConjugateGradientWork work;
};

}  // namespace tern::fluid
