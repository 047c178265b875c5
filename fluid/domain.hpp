#pragma once
// Which part of the fluid is computed here. Alone: all of it, and every function of this file does nothing.
//
// Space is cut in two again and again, across the longest side of the particles in it, until each rank has its part. A rank owns the
// particles whose predicted position lies in its part, and keeps copies of all others within the support of it, the ghosts. Arrays that
// are read at neighbours hold the own particles first, then the ghosts, each in rows along x (row_grid.hpp).

#include <cstdint>
#include <utility>
#include <vector>

#include "fluid/particle_class.hpp"
#include "fluid/reference.hpp"
#include "fluid/state.hpp"
#include "fluid/workspace.hpp"
#include "ranks/halo.hpp"
#include "ranks/ranks.hpp"

namespace tern::fluid {

/// How a state of all ranks is theirs. Only from the same shares do they go on with the same bits.
struct Shares {
  std::vector<std::int64_t> particles;  ///< of each rank, in the order of the ranks; empty: not known
  std::vector<double> potential;        ///< of each
  std::vector<std::int64_t> cut_axis;   ///< of the partition
  std::vector<double> cut_place;
  std::int64_t windows_since_cut = 0;

  /// The list of the members: visit(name, member of each) for every one.
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("particles", all.particles...);
    visit("potential", all.potential...);
    visit("cut_axis", all.cut_axis...);
    visit("cut_place", all.cut_place...);
    visit("windows_since_cut", all.windows_since_cut...);
  }
};

/// Parts of space, one per rank. The same on all ranks.
template <int D>
class Partition {
 public:
  /// Cuts space so that every rank gets as many of the particles, which lie at `position` on the ranks.
  void cut(const Ranks& ranks, const std::vector<Vector<D>>& position);
  void write_cuts(Shares& shares) const;
  void read_cuts(const Shares& shares);

  int owner(const Vector<D>& x) const {
    int first = 0, last = ranks_;
    while (last - first > 1) {
      const int middle = (first + last) / 2;
      (below(middle, x) ? last : first) = middle;
    }
    return first;
  }
  /// Calls visit(rank) for the ranks whose part is nearer than `reach` to x in all directions, in their order.
  template <class Visit>
  void for_owners_around(const Vector<D>& x, double reach, Visit&& visit) const {
    for_owners_around(x, reach, visit, 0, ranks_);
  }

 private:
  /// Between the ranks before number m and those from m on, within the part of both.
  struct Cut {
    int axis = 0;
    double place = 0;
  };
  bool below(int middle, const Vector<D>& x) const { return x[cuts_[middle].axis] < cuts_[middle].place; }
  template <class Visit>
  void for_owners_around(const Vector<D>& x, double reach, Visit& visit, int first, int last) const {
    if (last - first == 1) {
      visit(first);
      return;
    }
    const int middle = (first + last) / 2;
    const double height = x[cuts_[middle].axis] - cuts_[middle].place;
    if (height < reach) for_owners_around(x, reach, visit, first, middle);
    if (height >= -reach) for_owners_around(x, reach, visit, middle, last);
  }

  int ranks_ = 1;
  std::vector<Cut> cuts_;  ///< by the number m
};

template <int D>
class Domain {
 public:
  Domain(const Ranks& ranks, const Reference<D>& reference);

  const Ranks& ranks() const { return ranks_; }
  bool alone() const { return ranks_.alone(); }
  int owner(const Vector<D>& x) const { return partition_.owner(x); }
  /// Calls visit(rank) for the ranks whose part is nearer than `reach` to x in all directions, in their order.
  template <class Visit>
  void for_owners_around(const Vector<D>& x, double reach, Visit&& visit) const {
    partition_.for_owners_around(x, reach, visit);
  }
  /// How often space has been cut.
  std::int64_t cuts() const { return cuts_; }
  std::size_t ghosts() const { return ghosts_; }
  /// Of arrays with own particles and ghosts.
  const Halo& particles() const { return particles_; }
  /// Most particles of a rank over their mean.
  double imbalance() const { return imbalance_; }
  /// Where the totals of a window say so.
  void set_imbalance(double imbalance) { imbalance_ = imbalance; }

  /// Of n particles that all ranks know the first and the one after the last that are taken by this rank before space is cut.
  std::pair<std::size_t, std::size_t> equal_share(std::size_t n) const;
  /// Of a state that all ranks know: keeps the own part, by the shares of as many ranks, or of parts that are cut anew. What counts over
  /// the run goes on at the first rank.
  void share_out(State<D>& state, const Shares& shares = {});
  /// Cuts space and sends all particles to their owners; any rank has any of them.
  void cut_anew(State<D>& state);
  /// Those of now, on the first rank.
  Shares shares(const State<D>& own) const;
  /// Sends particles to their owners, of parts that are cut anew where these have become too unequal.
  void migrate(State<D>& state, Prediction<D>& prediction);
  /// Finds the ghosts, with their positions, velocities and pressures at the begin of a window, and puts them in rows of their own.
  void find_ghosts(State<D>& state, Prediction<D>& prediction, RowOrder<D>& rows);
  void forget_ghosts(State<D>& state);
  /// Marks that ranks have set on ghosts go to the owners, then all marks to the ghosts.
  void exchange_marks(std::vector<ParticleClass>& particle_class) const;
  /// All particles on the first rank, none on the others; not in the order of anything.
  State<D> gather(const State<D>& own) const;

 private:
  void move(State<D>& state, Prediction<D>& prediction, const std::vector<Vector<D>>& position);

  Ranks ranks_;
  Period<D> period_;
  double spacing_, support_;  ///< [m]
  double reach_;              ///< of the ghosts [m]
  Partition<D> partition_;
  Halo particles_;
  std::size_t ghosts_ = 0;
  double imbalance_ = 1;
  int windows_since_cut_ = 0;
  std::int64_t cuts_ = 0;
};

}  // namespace tern::fluid
