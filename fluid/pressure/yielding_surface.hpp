#pragma once
// How the pressure equation knows that the structure yields (Robin condition, docs/THEORY.md section 3). The bodies answer in lumps,
// parts that are pushed and move as a whole (SurfaceResponse). A pressure p of particle i puts the force p b_ik on point k,
//   b_ik = -2 V_i A_k w~_ik n_k,      c_ia = sum_k share_ka b_ik A_k/|sum_j b_jk|,
// and all forces together let lump a be faster by dt/m_a sum_j c_ja . (p_j + rho g.(x_k - x_j) - p^_k) at the end of the window. Inserted
// in div(u^{n+1}), with the rows scaled as in pressure_poisson.hpp, this is a matrix of low rank on the particles beside the structure:
//   R_ij = rho sum_a c_ia . c_ja / m_a
// A pressure on both faces of a plate does not move it: c of the two faces are opposed, whatever the particles before them fill of their
// half spaces.
//
// So the forces are those of the loads. Of the motion the rows of the divergence count
//   d_ia = sum_k share_ka/(sum_b share_kb) b_ik
// instead, what the particles fill and no more. What R takes too much or too little belongs to what the solve leaves of the divergence
// (left_behind.hpp).
//
// R is symmetric and semi-definite, but no matrix of edges: the matrix has the sums of its absolute values in its place, a diagonal that
// is nowhere smaller,
//   kappa_i = rho sum_a |c_ia| sum_j |c_ja| / m_a >= R,
// and the solver adds the difference.

#include <vector>

#include "base/uninitialised.hpp"
#include "fluid/boundary/boundary.hpp"
#include "fluid/particle_class.hpp"
#include "fluid/reference.hpp"
#include "fluid/workspace.hpp"
#include "proto/interface.hpp"
#include "ranks/ranks.hpp"

namespace tern::fluid {

template <int D>
class YieldingSurface {
 public:
  /// c of the particles `at_structure` that are unknowns of the pressure, and kappa. All ranks know the whole surface, and each the rows of
  /// its own particles: the lumps are pushed by those of all.
  void assemble(const Constants<D>& constants, const Ranks& ranks, const SurfaceResponse& response, const Boundary<D>& boundary,
                const std::vector<ParticleClass>& particle_class, const Prediction<D>& prediction, const std::vector<int>& at_structure);

  /// kappa of the particle at_structure[m].
  double bound(std::ptrdiff_t m) const { return any() ? bound_[m] : 0; }

  /// y += (R - kappa) x. T = double for the equation, float inside the preconditioner.
  template <class T>
  void add_difference(const std::vector<int>& at_structure, const std::vector<T>& x, std::vector<T>& y) const;

  /// y -= what the rows of the divergence, scaled as those of the equation, count of the motion under pressures x beyond p^ and the weight
  /// of the fluid between: d_ia in place of c_ia on the left.
  void subtract_motion(const std::vector<double>& reference_pressure, const Boundary<D>& boundary, const std::vector<int>& at_structure,
                       const std::vector<double>& x, std::vector<double>& y) const;

  /// source += what p^ and the weight of the fluid between particles and faces put on the right-hand side.
  void add_source(const std::vector<double>& reference_pressure, const Boundary<D>& boundary, const std::vector<int>& at_structure,
                  std::vector<double>& source) const;

  bool any() const { return !response_.mass.empty(); }
  std::size_t lumps() const { return response_.mass.size(); }
  double scale(std::size_t a) const { return scale_[a]; }  ///< rho/m_a
  /// Calls visit(m, c_ma) for the particles at_structure[m] that push lump a.
  template <class Visit>
  void for_rows(std::size_t a, Visit&& visit) const {
    for (std::ptrdiff_t e = first_[a]; e < first_[a + 1]; ++e) visit(row_[e], pushing_[e]);
  }

  /// Calls visit(a, b) for pairs of lumps that have a point in common, so that chains of them join all of each part of the surface. A lump
  /// in which a point has no share, which only fills its place in the list, may be one of another body.
  template <class Visit>
  void for_lumps_of_a_point(Visit&& visit) const {
    const std::size_t points = transferred_.size(), per_point = response_.lumps_per_point(points);
    for (std::size_t k = 0; k < points; ++k) {
      int first = -1;
      for (std::size_t s = k * per_point; s < (k + 1) * per_point; ++s) {
        if (response_.share[s] == 0) continue;
        const int lump = static_cast<int>(response_.lump[s]);
        if (first < 0) first = lump;
        visit(first, lump);
      }
    }
  }

 private:
  /// Sets the motion of the lumps, rho/dt times their velocity, to that of p^ less what the weight of the fluid between does. It is known
  /// where it was asked for under the same p^ in this window.
  void set_carried_motion(const std::vector<double>& reference_pressure, const Boundary<D>& boundary) const;
  /// Adds `factor` times that under pressures x.
  template <class T>
  void push(double factor, const std::vector<T>& x) const;
  void sum_motion() const;  ///< over all ranks
  /// y_i += sum_a vector_ia . motion_a
  template <class T>
  void spread(const UninitialisedVector<Vector<D>>& vector, const std::vector<int>& at_structure, std::vector<T>& y) const;

  Ranks ranks_;
  SurfaceResponse response_;
  std::vector<double> scale_;                      ///< rho/m_a
  std::vector<std::ptrdiff_t> begin_;              ///< of each row, with room for all lumps it may have
  std::vector<int> count_;                         ///< of its entries
  UninitialisedVector<int> lump_;                  ///< of each entry
  UninitialisedVector<Vector<D>> vector_;          ///< c_ia
  UninitialisedVector<Vector<D>> counted_;         ///< d_ia
  UninitialisedVector<Vector<D>> between_;         ///< the same sum with the weight of the fluid between, p in Pa
  std::vector<std::ptrdiff_t> first_;              ///< of each lump in those that follow
  UninitialisedVector<int> row_;                   ///< m
  UninitialisedVector<int> particle_;              ///< at_structure[m]
  UninitialisedVector<std::ptrdiff_t> entry_;      ///< in the rows
  UninitialisedVector<Vector<D>> pushing_;         ///< c_ma
  std::vector<double> bound_;                      ///< kappa, by row
  std::vector<double> size_;                       ///< of each lump: rho/m_a sum_j |c_ja|
  std::vector<double> transferred_;                ///< by point: sum_i 2 V_i A_k w~_ik
  mutable std::vector<Vector<D>> motion_;          ///< of each lump; scratch
  mutable std::vector<Vector<D>> carried_motion_;  ///< of set_carried_motion()
  mutable std::vector<double> carried_under_;      ///< p^ of that; empty: not known in this window
};

}  // namespace tern::fluid
