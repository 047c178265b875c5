#pragma once
// Pairs of fluid particle i and surface point k that see each other, with the vector all interface operators share:
//   b_ik = -2 V_i A_k w~(r_ik) n_k
// (beside corners with the share of convex_corner.hpp). A pressure p puts the force +p b_ik on k and -p b_ik on i, so that the
// exchange conserves momentum exactly; away from corners div_i takes (1/V_i) b_ik . (u_k - u_i), so that its power is p div u.
// Thin bodies need no special care, because the hidden half space is replaced by its surface (Gauss' theorem).
// Where a face meets a wall, part of the half space before its points lies beyond the wall. The fluid is mirrored there, and
// the images of particles have pairs too: with them the face has its whole load.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>
#include <vector>

#include "base/uninitialised.hpp"
#include "coupler/schemes/point_sums.hpp"
#include "proto/interface.hpp"
#include "sph/convex_corner.hpp"
#include "sph/face_kernel.hpp"
#include "sph/faces.hpp"

namespace tern::coupler {

/// What pairs read of a surface point, side by side in memory: particles see points that lie together, though not one after the other.
template <int D>
struct alignas(64) PairPoint {
  Vector<D> position, normal;
  double area, borne_share;  ///< [m^(D-1)]; share of the pressures before it that is its load (convex_corner.hpp)
};

template <int D>
struct InterfacePair {
  int particle, point;
  Vector<D> b;       ///< [m^(D-1)]
  Vector<D> offset;  ///< from the point to the particle, or to its image [m]
};

/// Pairs one after the other. They are kept by what tells them apart, and made where they are read: there are some fifty of each particle,
/// and what is read of memory is what they cost.
template <int D>
class PairRange {
 public:
  struct Kept {
    std::uint32_t place;  ///< of a particle, or of an image of one
    std::int32_t point;
    double weight;  ///< b over the normal
  };
  struct Tables {
    const int* particle;        ///< of each place
    const Vector<D>* position;  ///< the same
    const PairPoint<D>* point;
  };

  PairRange(const Kept* first, const Kept* last, const Tables& tables) : first_(first), last_(last), tables_(tables) {}

  struct Iterator {
    using iterator_category = std::input_iterator_tag;
    using value_type = InterfacePair<D>;
    using difference_type = std::ptrdiff_t;
    using pointer = void;
    using reference = InterfacePair<D>;

    const Kept* at;
    Tables tables;

    InterfacePair<D> operator*() const { return made(*at, tables); }
    Iterator& operator++() { return ++at, *this; }
    Iterator operator++(int) {
      const Iterator before = *this;
      return ++at, before;
    }
    bool operator==(const Iterator& other) const { return at == other.at; }
  };

  Iterator begin() const { return {first_, tables_}; }
  Iterator end() const { return {last_, tables_}; }
  std::size_t size() const { return static_cast<std::size_t>(last_ - first_); }
  bool empty() const { return first_ == last_; }
  InterfacePair<D> operator[](std::size_t m) const { return made(first_[m], tables_); }
  /// As they are kept.
  std::span<const Kept> kept() const { return {first_, last_}; }
  const PairPoint<D>& point(const Kept& pair) const { return tables_.point[pair.point]; }

 private:
  static InterfacePair<D> made(const Kept& pair, const Tables& tables) {
    const PairPoint<D>& point = tables.point[pair.point];
    return {tables.particle[pair.place], pair.point, pair.weight * point.normal, tables.position[pair.place] - point.position};
  }

  const Kept *first_, *last_;
  Tables tables_;
};

/// Place of a pair among those of InterfacePairs::for_each_standing().
struct StandingPair {
  std::size_t part = 0, index = 0;
};

template <int D>
class InterfacePairs {
 public:
  InterfacePairs(double smoothing_length, double fluid_spacing) : kernel_(Kernel<D>(smoothing_length), fluid_spacing) {}

  /// Finds all pairs of the window, particle by particle. The same bits for any number of threads.
  void find(const InterfaceParticles<D>& particles, const Surface<D>& surface);

  /// Of the particles themselves.
  PairRange<D> pairs() const { return range(0, particle_pairs_); }
  /// Of particle i; all particles one after the other are pairs().
  PairRange<D> pairs_of(std::size_t i) const { return range(first_[i], first_[i + 1]); }
  /// Of particles past a corner with faces that are turned away from them (sph/convex_corner.hpp): of the pressure only.
  PairRange<D> back_facing_pairs() const { return range(particle_pairs_, particle_pairs_ + back_facing_pairs_); }
  /// Of their images behind walls: `particle` is the one that is mirrored, everything else is that of the image.
  PairRange<D> image_pairs() const { return range(particle_pairs_ + back_facing_pairs_, pairs_.size()); }
  /// Those of the particles that stand over the patch of the point (sph/contact.hpp), from one of them on: calls visit(pair) in their
  /// order.
  template <class Visit>
  void for_each_standing(StandingPair from, Visit&& visit) const {
    for (; from.part < found_.size(); from = {from.part + 1, 0})
      for (; from.index < found_[from.part].standing.size(); ++from.index) visit(made(found_[from.part].standing[from.index]));
  }
  /// The first of them for which holds(pair), asked by all threads, is true; the end where it is for none.
  template <class Holds>
  StandingPair first_standing(const Holds& holds) const {
    std::vector<std::size_t> first(found_.size());
    for_parts([&](int part, std::ptrdiff_t, std::ptrdiff_t) {
      const auto& standing = found_[part].standing;
      first[part] = std::find_if(standing.begin(), standing.end(), [&](const Kept& pair) { return holds(made(pair)); }) - standing.begin();
    });
    StandingPair from;
    while (from.part < first.size() && first[from.part] == found_[from.part].standing.size()) ++from.part;
    if (from.part < first.size()) from.index = first[from.part];
    return from;
  }
  /// Into how many parts the particles are cut, and work(part, first particle, last + 1) for each of them, by all threads.
  int parts() const { return static_cast<int>(found_.size()); }
  template <class Work>
  void for_parts(const Work& work) const {
    run_parts(static_cast<std::ptrdiff_t>(first_.size()) - 1, parts(), work);
  }
  /// Part of the half space before each point that the particles that it sees fill, as the fluid's own sums have it.
  const std::vector<double>& seen_share() const { return seen_share_; }
  /// The same of all pairs, as they are weighed.
  const std::vector<double>& filled() const { return filled_; }

  /// Those of the particles, the back-facing ones, then those of the images.
  PairRange<D> all_pairs() const { return range(0, pairs_.size()); }

 private:
  /// What is found in one part of the particles, of these one after the other.
  struct Found {
    std::vector<int> seen, back_facing;                         ///< points
    std::vector<int> seen_count, back_facing_count;             ///< per particle
    UninitialisedVector<typename PairRange<D>::Kept> standing;  ///< those of the pairs that stand over their patch
    CornerScratch corners;
  };
  using Kept = PairRange<D>::Kept;

  PairRange<D> range(std::size_t first, std::size_t last) const { return {pairs_.data() + first, pairs_.data() + last, tables()}; }
  PairRange<D>::Tables tables() const { return {particle_.data(), place_.data(), points_.data()}; }
  InterfacePair<D> made(const Kept& pair) const { return PairRange<D>(&pair, &pair + 1, tables())[0]; }
  double weight(double volume, double area, double borne_share, double distance) const;
  void look(const InterfaceParticles<D>& particles);
  void weigh(const InterfaceParticles<D>& particles, int particle, const int* points, std::ptrdiff_t count, Kept* pairs,
             UninitialisedVector<Kept>* standing, double* filled) const;
  void set_points();
  void sum_by_points();

  FaceKernel<D> kernel_;
  FaceFinder<D> finder_;
  Faces<D> faces_;
  std::vector<Found> found_;  ///< by part of the particles
  UninitialisedVector<Kept> pairs_;
  UninitialisedVector<PairPoint<D>> points_;
  PointSums sums_;
  std::vector<int> particle_;     ///< of each place: those of the particles, then those of the images
  std::vector<Vector<D>> place_;  ///< the same [m]
  std::size_t particle_pairs_ = 0, back_facing_pairs_ = 0;
  std::vector<std::uint8_t> covered_, asked_;    ///< per surface point; asked_: some particle has a pair with it
  std::vector<double> seen_share_, filled_;      ///< per surface point
  std::vector<std::size_t> first_;               ///< pair of each particle, then the number of them all
  std::vector<std::size_t> begin_, begin_past_;  ///< pairs of each part, of what they see and past corners
};

}  // namespace tern::coupler
