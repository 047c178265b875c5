#pragma once
// Preconditioner of the pressure solve: a V-cycle whose finest level is the particles and whose coarser levels are a
// Cartesian grid of spacing H = 2 dx, rebuilt every step. The grid operator is integrated with the particles as points:
//   (A_H)_ab = sum_i [ V_i grad phi_a . grad phi_b + c_i phi_a phi_b ](x_i),
// phi_a the multilinear hats, c_i the part of row i that ties p_i to zero (missing neighbours at the free surface, Robin
// term). Without the c-part the coarse problem would not know the free surface, and the count of iterations grows tenfold.
//
// A thin body between two waters would be invisible to such a grid: a function on it cannot jump where the pressure does, and
// the count grows with the number of particles. Near bodies a place of the grid therefore has one node per side. Sides are
// connected parts: particles of a cell, and the parts of the cells around a place, belong together when edges of the matrix
// connect them; on the coarser levels the same holds for the finer nodes around a place. This needs no notion of what the
// body looks like, and beyond its tip both sides meet in one node again.
//
// With several ranks the grids are divided as space is: a node belongs to the rank in whose part it lies. On the finest grid this rank
// knows all particles around the node, its own and its ghosts. On the coarser ones every rank makes the rows of the parents of its own
// nodes, and what it makes of the rows of others is sent to these. A rank holds copies of the nodes of others that are parents of its nodes
// or stand beside its own ones. Smoothing takes them as they were before. The coarsest grids, from 150 2^D nodes on, are the same on all
// ranks. What belongs to one side is known to a rank as far as its own rows go; the owner of a place joins what all say of it
// (parts_of_places.hpp), and whoever has a place has all of its nodes, in the same order.
//
// In a periodic direction the grid closes on itself: m 2^k cells per period, m = 4 .. 7, as near to H = 2 dx as that allows;
// it is coarsened while the number of cells is even.

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "base/vector.hpp"
#include "fluid/domain.hpp"
#include "fluid/particle_class.hpp"
#include "fluid/period.hpp"
#include "fluid/pressure/connected_parts.hpp"
#include "fluid/pressure/edge_matrix.hpp"
#include "fluid/pressure/galerkin_terms.hpp"
#include "fluid/pressure/grid_stencil.hpp"
#include "fluid/pressure/parts_of_places.hpp"
#include "fluid/pressure/yielding_surface.hpp"

namespace tern::fluid {

template <int D>
class Multigrid {
 public:
  explicit Multigrid(const Period<D>& period) : period_(period) {}

  /// Rebuilds the hierarchy for the matrix A of particles at x, own ones and ghosts; unknowns are those that `particle_class` says.
  /// `beside_body`: particles near bodies that may part the fluid, of each rank. `gradient_scale`: V times the ratio of A to a Laplacian of
  /// unit coefficient. `yielding`: what the matrix has a bound of, on the particles `at_structure`. Matrix and arrays must outlive use.
  void build(const Domain<D>& domain, EdgeMatrix& matrix, const std::vector<Vector<D>>& position,
             const std::vector<ParticleClass>& particle_class, const std::vector<int>& beside_body, double spacing, double gradient_scale,
             const YieldingSurface<D>& yielding, const std::vector<int>& at_structure);

  /// z = B r, symmetric positive definite: one V(1,1) cycle from zero. 0 where r and the matrix have no unknown. `largest`: of |r_i|, of
  /// all ranks.
  void apply(double largest, const std::vector<double>& r, std::vector<double>& z);

  /// Parts of the fluid that the coarsest grid does not connect: waters on the two sides of a wall, or far apart. Their number, and the
  /// part of each particle (0 where its pressure is not an unknown).
  int parts() const { return parts_.count(); }
  const std::vector<int>& part_of_particle() const { return part_of_particle_; }

 private:
  static constexpr int corners = 1 << D;  ///< nodes of a grid cell
  static constexpr int stencil = D == 2 ? 9 : 27;
  /// Drops beside a body are parts as well. They need no node of their own, and so many would keep the coarsest grid from being small:
  /// parts beyond this number share the last node.
  static constexpr int most_nodes_at_a_place = 4;
  static constexpr std::uint8_t no_part = 255;
  static constexpr int undecided = -1;    ///< neighbour of a row by_split that has no entry yet
  static constexpr int colors = stencil;  ///< parity by direction; a third for the last of an odd period

  /// Entry of the matrix of a level that its stencil has no room for: the neighbouring place has a second node.
  struct Entry {
    int row, column;
    float value;
  };

  /// How the structure yields, on a level (multigrid_yielding.cpp).
  struct Beside {
    std::vector<int> begin, node;            ///< nodes from which each particle beside the structure takes its value
    std::vector<float> weight;               ///< and their weights
    std::vector<int> lump_begin, lump_node;  ///< nodes whose pressures push each lump
    std::vector<Vector<D>> lump_vector;      ///< and how
  };

  struct Level {
    bool divided = false;                        ///< among the ranks; otherwise all of them have all of it
    std::array<int, D> size{};                   ///< places per direction of the index map
    std::array<int, D> first{}, whole{};         ///< where the map begins in that of all ranks (an even number), and its size
    Vector<D> width = Vector<D>::Zero();         ///< of a cell [m]
    std::vector<std::uint8_t> foreign;           ///< nodes of other ranks; empty: there are none
    Halo copies;                                 ///< of these nodes
    std::array<bool, D> periodic{};              ///< directions in which the place after the last is the first
    std::vector<int> map;                        ///< number of the first node at a place, or -1
    std::vector<std::array<int, D>> coordinate;  ///< the first node of each place in their order, then the further ones
    std::vector<std::pair<int, int>> further;    ///< place and number of further nodes, in order of the places
    std::vector<std::uint8_t> side;              ///< which of its place's nodes a node is; empty: all are the only ones
    std::vector<std::uint8_t> by_split;          ///< there are further nodes at the place of a node or next to it
    std::vector<int> suspects;                   ///< first nodes of places where there may be two sides
    std::vector<Entry> further_entries;          ///< by row; while they are gathered in any order
    std::array<std::vector<std::array<int, 3>>, colors> further_rows;  ///< by colour: row, first and last of its entries
    std::vector<std::array<int, stencil>> neighbour;                   ///< node number, or the node itself where there is none
    std::vector<std::array<float, stencil>> row;                       ///< matrix entries, 0 where there is no node
    std::vector<float> inverse_diagonal;
    std::array<std::vector<int>, colors> color;    ///< nodes of one colour are not neighbours of each other
    std::vector<std::array<int, corners>> parent;  ///< of this level's nodes in the next; -1 where none
    std::vector<std::array<float, corners>> parent_weight;
    std::vector<float> x, b, residual;
    Beside beside;
    std::size_t nodes() const { return coordinate.size(); }
    bool own(std::size_t node) const { return foreign.empty() || !foreign[node]; }
  };

  /// Number of the node at a place of the index map, wrapped where the level is periodic; -1 where there is none.
  static int node_at(const Level& level, const std::array<int, D>& at);
  /// Gives the places marked in the map their nodes, in the order of the places.
  static void number_places(Level& level);
  void build_finest(const EdgeMatrix& matrix, const std::vector<Vector<D>>& position, const std::vector<ParticleClass>& particle_class,
                    const std::vector<int>& beside_body, double spacing, double gradient_scale);
  /// Rank in whose part a place of the map of all ranks lies.
  int owner(const Level& level, const std::array<int, D>& at) const;
  bool coarser_is_divided(std::size_t level) const;
  void build_next(Level& fine, Level& coarse);
  void connect(Level& level);
  void mark_by_split(Level& level);
  static int color_of(const Level& level, int node);
  /// Adds to the entry of a row that is by_split; `offset` leads to the place of the column.
  void add_entry(Level& level, int row, const std::array<int, D>& offset, int column, float value);
  /// Makes one of the entries of a row and a column, in an order that does not depend on that in which they came.
  template <class AnyEntry>
  static void add_up(std::vector<AnyEntry>& entries) {
    std::sort(entries.begin(), entries.end(), [](const AnyEntry& a, const AnyEntry& b) {
      return a.row != b.row ? a.row < b.row : a.column != b.column ? a.column < b.column : a.value < b.value;
    });
    std::size_t kept = 0;
    for (const AnyEntry& entry : entries) {
      if (kept > 0 && entries[kept - 1].row == entry.row && entries[kept - 1].column == entry.column)
        entries[kept - 1].value += entry.value;
      else
        entries[kept++] = entry;
    }
    entries.resize(kept);
  }
  void finish(Level& level);
  void find_parts();
  /// Calls visit(node, value) for the entries of a row that are not 0.
  template <class Visit>
  static void for_entries(const Level& level, int row, Visit&& visit) {
    for (int s = 0; s < stencil; ++s)
      if (level.row[row][s] != 0) visit(level.neighbour[row][s], level.row[row][s]);
    if (level.further_entries.empty()) return;
    const auto by_row = [](const Entry& entry, int r) { return entry.row < r; };
    for (auto entry = std::lower_bound(level.further_entries.begin(), level.further_entries.end(), row, by_row);
         entry != level.further_entries.end() && entry->row == row; ++entry)
      visit(entry->column, entry->value);
  }
  /// Calls visit(node) for the nodes at a coordinate, the first one first.
  template <class Visit>
  static void for_nodes_at(const Level& level, const std::array<int, D>& at, Visit&& visit) {
    const int place = place_at<D>(at, level.size, level.periodic);
    if (place < 0 || level.map[place] < 0) return;
    visit(level.map[place]);
    for (auto node = std::lower_bound(level.further.begin(), level.further.end(), std::pair(place, 0));
         node != level.further.end() && node->first == place; ++node)
      visit(node->second);
  }
  // multigrid_ranks.cpp
  /// A place of the map of all ranks that a rank has marked, and whether it has seen there what may have two sides.
  struct Mark {
    std::array<int, D> at;
    int suspect;
  };
  void find_owners(Level& level);
  void share_places(Level& level, const std::vector<Mark>& marked);
  void mark_on_all_ranks(Level& level, const std::vector<Mark>& marked);
  void number_suspect_places(Level& level);
  void ask_which_are_suspect(Level& level) const;
  void finish_copies(Level& level);
  void tell_ghosts_beside_body(const std::vector<int>& beside_body);
  void share_parts_of_cells();
  void join_at_owners(const Level& level, const std::vector<std::uint8_t>& counted);
  void join_with_other_ranks(const Level& level);
  void share_by_split(Level& level) const;
  void share_entries(Level& level);
  // Names of places and nodes of a level, the same on all ranks.
  static std::int64_t place_of_all(const Level& level, std::array<int, D> at);
  static std::array<int, D> at_place_of_all(const Level& level, std::int64_t place);
  static std::int64_t node_of_all(const Level& level, int node);
  static int node_from_all(const Level& level, std::int64_t node);
  // multigrid_sides.cpp
  void split_cells(const std::vector<int>& beside_body, const std::array<int, D>& cells);
  void split_places(const std::array<int, D>& cells);
  void note_links(std::int64_t place);
  void note_sides(const Level& level, int suspect, bool shared);
  void clear_sides(Level& level);
  template <class Assign>
  void give_nodes_to_parts(Level& level, bool shared, Assign&& assign);
  void split_coarse_places(Level& fine, Level& coarse, const std::array<bool, D>& halved);
  // multigrid_yielding.cpp
  void build_yielding(const YieldingSurface<D>& yielding, const std::vector<int>& at_structure);
  void gather_rows_of_all(const YieldingSurface<D>& yielding);
  /// Calls visit(m, c_ma) for the rows of a level that push lump a.
  template <class Visit>
  void for_rows_of_lump(bool of_all, std::size_t a, Visit&& visit) const;
  double bound_of_row(bool of_all, std::size_t m) const { return of_all ? rows_of_all_.bound[m] : yielding_->bound(m); }
  /// y += (kappa - R) x
  void add_difference(const Level& level, const std::vector<float>& x, std::vector<float>& y);
  void add_rows(const Level& level, bool of_all, const std::vector<float>& x, std::vector<float>& y) const;
  void push_lumps(const Level& level, const std::vector<float>& x) const;
  void add_lumps(const Level& level, std::vector<float>& y) const;
  // multigrid_cycle.cpp
  void cycle(std::size_t level);
  void smooth(Level& level, bool forward);
  void compute_residual(Level& level);
  /// Sum of entries first .. last - 1 of those without room in the stencil times x.
  static float further_product(const Level& level, int first, int last);

  Period<D> period_;
  const Domain<D>* domain_ = nullptr;
  Vector<D> origin_ = Vector<D>::Zero();  ///< of the places of all ranks [m]
  const EdgeMatrix* matrix_ = nullptr;
  const YieldingSurface<D>* yielding_ = nullptr;  ///< null: nothing yields
  const std::vector<int>* at_structure_ = nullptr;
  std::vector<Level> levels_;
  std::array<std::optional<GalerkinTerms<D>>, corners> galerkin_terms_;  ///< by the directions in which grids are halved, bit by bit
  std::vector<double> coarsest_, coarsest_solution_;                     ///< Cholesky factor of the last level, column by column
  // Particles by grid cell, so that restriction gathers in a fixed order.
  std::vector<int> cell_start_, cell_particle_;
  std::vector<std::array<int, corners>> cell_node_;
  std::vector<std::array<float, corners>> particle_weight_;  ///< phi of the cell's corners at each particle, in cell order
  std::vector<std::array<float, corners>> cell_sum_;
  std::vector<std::array<int, corners>> node_cell_;  ///< cells around a node, -1 where none: corner c of that cell
  std::vector<float> r_, z_, az_;
  std::vector<std::array<int, 3>> further_cells_;  ///< node, corner and cell that node_cell_ has no room for

  // Scratch of the building, kept so that a step allocates nothing. A cell with two sides is two cells from here on: the
  // further ones have the numbers after the last cell of the grid.
  std::vector<int> cell_of_particle_, population_, compact_, next_;
  std::vector<int> home_of_further_cell_, suspect_cells_;                  ///< cells of the grid, both in ascending order
  std::vector<std::uint8_t> part_of_further_cell_, part_of_suspect_cell_;  ///< which part of its cell it is
  std::vector<std::array<float, corners * corners>> element_;
  ConnectedParts parts_;  ///< in the end those of the coarsest grid
  std::vector<int> around_, corner_of_, row_of_particle_, place_;
  std::vector<std::int64_t> thing_;  ///< names that all ranks have for what is around
  std::vector<Mark> parents_;
  /// What is around the suspect places of a level, one after the other, and the part of the place that it is in.
  struct Sides {
    std::vector<std::size_t> begin;  ///< of each place
    std::vector<int> thing, corner;
    std::vector<std::uint8_t> part, count;  ///< parts at each place
    std::vector<std::uint8_t> count_of;     ///< by node of other ranks
    std::vector<Link> link;                 ///< for several ranks: what this one knows of each thing
  } sides_;
  bool parted_ = false;  ///< somewhere, on any rank, a body may part the fluid
  PartsOfPlaces joined_;
  std::vector<std::vector<int>> take_, give_;  ///< first nodes of other ranks, by rank; own ones of which other ranks have copies
  std::vector<std::int64_t> name_;             ///< of own particles and ghosts, that all ranks have for them
  std::vector<std::uint8_t> beside_, part_in_cell_;
  /// What a rank adds to a row of which another rank knows the columns as well.
  struct FarEntry {
    std::int64_t row, column;
    float value;
  };
  std::vector<FarEntry> far_entries_;
  std::vector<std::pair<int, int>> corner_of_row_;  ///< cell, and entry in it, of each particle beside the structure
  /// The particles beside the structure of all ranks, in their order: what YieldingSurface knows of the own ones.
  struct RowsOfAll {
    std::vector<double> bound;
    std::vector<int> first, row;  ///< of each lump: where its rows begin; these
    std::vector<Vector<D>> vector;
  } rows_of_all_;
  mutable std::vector<Vector<D>> push_;  ///< on each lump
  std::vector<float> difference_;        ///< by node of the finest level
  std::vector<int> part_of_particle_, part_of_node_, part_of_finer_node_;
};

}  // namespace tern::fluid
