#pragma once
// Preconditioner of the pressure solve: a V-cycle whose finest level is the particles and whose coarser levels are a
// Cartesian grid of spacing H = 2 dx, rebuilt every step. The grid operator is integrated with the particles as points:
//   (A_H)_ab = sum_i [ V_i grad phi_a . grad phi_b + c_i phi_a phi_b ](x_i),
// phi_a the multilinear hats, c_i the part of row i that ties p_i to zero (missing neighbours at the free surface, Robin
// term). Without the c-part the coarse problem would not know the free surface, and the count of iterations grows tenfold.

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Cholesky>

#include "fluid/edge_matrix.hpp"
#include "fluid/period.hpp"
#include "particles/vector.hpp"

namespace tern::fluid {

//
// In a periodic direction the grid closes on itself: m 2^k cells per period, m = 4 .. 7, as near to H = 2 dx as that allows;
// it is coarsened while the number of cells is even.

template <int D>
class Multigrid {
 public:
  explicit Multigrid(const Period<D>& period) : period_(period) {}

  /// Rebuilds the hierarchy for the matrix A of particles at x; `active[i]` = 0 for rows that are no unknowns.
  /// `gradient_scale`: V times the ratio of A to a Laplacian of unit coefficient. Matrix and arrays must outlive use.
  void build(const EdgeMatrix& matrix, const std::vector<Vector<D>>& position, const std::vector<std::uint8_t>& active,
             double spacing, double gradient_scale);

  /// z = B r, symmetric positive definite: one V(1,1) cycle from zero. Both of padded length.
  void apply(const std::vector<double>& r, std::vector<double>& z);

 private:
  static constexpr int corners = 1 << D;                 ///< nodes of a grid cell
  static constexpr int stencil = D == 2 ? 9 : 27;
  static constexpr int colors = stencil;                 ///< parity by direction; a third for the last of an odd period

  struct Level {
    std::array<int, D> size{};                        ///< nodes per direction of the index map
    std::array<bool, D> periodic{};                   ///< directions in which the node after the last is the first
    std::vector<int> map;                             ///< node number or -1
    std::vector<std::array<int, D>> coordinate;
    std::vector<std::array<int, stencil>> neighbour;  ///< node number, or the node itself where there is none
    std::vector<std::array<float, stencil>> row;      ///< matrix entries, 0 where there is no node
    std::vector<float> inverse_diagonal;
    std::array<std::vector<int>, colors> color;       ///< nodes of one colour are not neighbours of each other
    std::vector<std::array<int, corners>> parent;     ///< of this level's nodes in the next; -1 where none
    std::vector<std::array<float, corners>> parent_weight;
    std::vector<float> x, b, residual;
    std::size_t nodes() const { return coordinate.size(); }
  };

  /// Number of the node at a place of the index map, wrapped where the level is periodic; -1 where there is none.
  static int node_at(const Level& level, std::array<int, D> at);
  void build_finest(const EdgeMatrix& matrix, const std::vector<Vector<D>>& position, const std::vector<std::uint8_t>& active,
                    double spacing, double gradient_scale);
  void build_next(const Level& fine, Level& coarse);
  void connect(Level& level);
  void finish(Level& level);
  void cycle(std::size_t level);
  void smooth(Level& level, bool forward);
  void compute_residual(Level& level);

  Period<D> period_;
  const EdgeMatrix* matrix_ = nullptr;
  std::vector<Level> levels_;
  Eigen::LLT<Eigen::MatrixXd> coarsest_;
  // Particles by grid cell, so that restriction gathers in a fixed order.
  std::vector<int> cell_start_, cell_particle_;
  std::vector<std::array<int, corners>> cell_node_;
  std::vector<std::array<float, corners>> particle_weight_;  ///< phi of the cell's corners at each particle, in cell order
  std::vector<std::array<float, corners>> cell_sum_;
  std::vector<std::array<int, corners>> node_cell_;          ///< cells around a node, -1 where none: corner c of that cell
  std::vector<float> r_, z_, az_;
  // Scratch of build_finest, kept so that a step allocates nothing.
  std::vector<int> cell_of_particle_, population_, compact_, next_;
  std::vector<std::array<float, corners * corners>> element_;
};

}  // namespace tern::fluid
