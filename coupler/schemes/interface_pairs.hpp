#pragma once
// Pairs of fluid particle i and surface point k that see each other, with the vector all interface operators share:
//   b_ik = -2 V_i A_k w~(r_ik) n_k
// (beside corners with the share of convex_corner.hpp). A pressure p puts the force +p b_ik on k and -p b_ik on i, so that the
// exchange conserves momentum exactly; away from corners div_i takes (1/V_i) b_ik . (u_k - u_i), so that its power is p div u.
// Thin bodies need no special care, because the hidden half space is replaced by its surface (Gauss' theorem).
// Where a face meets a wall, part of the half space before its points lies beyond the wall. The fluid is mirrored there, and
// the images of particles have pairs too: with them the face has its whole load.

#include <cstddef>
#include <cstdint>
#include <iterator>
#include <vector>

#include "base/uninitialised.hpp"
#include "proto/interface.hpp"
#include "sph/convex_corner.hpp"
#include "sph/face_kernel.hpp"
#include "sph/faces.hpp"

namespace tern::coupler {

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
    const Vector<D>*point, *normal;
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
  int particle(std::ptrdiff_t m) const { return tables_.particle[first_[m].place]; }
  int point(std::ptrdiff_t m) const { return first_[m].point; }

 private:
  static InterfacePair<D> made(const Kept& pair, const Tables& tables) {
    return {tables.particle[pair.place], pair.point, pair.weight * tables.normal[pair.point],
            tables.position[pair.place] - tables.point[pair.point]};
  }

  const Kept *first_, *last_;
  Tables tables_;
};

template <int D>
class InterfacePairs {
 public:
  InterfacePairs(double smoothing_length, double fluid_spacing) : kernel_(Kernel<D>(smoothing_length), fluid_spacing) {}

  /// Finds all pairs of the window, particle by particle. The same bits for any number of threads.
  void find(const InterfaceParticles<D>& particles, const Surface<D>& surface);

  /// Of the particles themselves.
  PairRange<D> pairs() const { return range(0, particle_pairs_); }
  /// Of particles past a corner with faces that are turned away from them (sph/convex_corner.hpp): of the pressure only.
  PairRange<D> back_facing_pairs() const { return range(particle_pairs_, particle_pairs_ + back_facing_pairs_); }
  /// Of their images behind walls: `particle` is the one that is mirrored, everything else is that of the image.
  PairRange<D> image_pairs() const { return range(particle_pairs_ + back_facing_pairs_, pairs_.size()); }
  /// Those of the particles that stand over the patch of the point (sph/contact.hpp): calls visit(pair) in their order.
  template <class Visit>
  void for_each_standing(Visit&& visit) const {
    for (const Found& found : found_)
      for (const std::size_t m : found.standing) visit(pairs()[m]);
  }
  /// Part of the half space before each point that the particles that it sees fill, as the fluid's own sums have it.
  const std::vector<double>& seen_share() const { return seen_share_; }
  /// The same of all pairs, as they are weighed.
  const std::vector<double>& filled() const { return filled_; }
  /// The same times the area of the point: the sum of -b_ik . n_k over all pairs [m^(D-1)].
  const std::vector<double>& weighed_area() const { return weighed_area_; }

  /// Those of the particles, the back-facing ones, then those of the images.
  PairRange<D> all_pairs() const { return range(0, pairs_.size()); }

 private:
  /// What one thread finds, of its particles one after the other.
  struct Found {
    std::vector<int> seen, back_facing;              ///< points
    std::vector<int> seen_count, back_facing_count;  ///< per particle
    std::vector<std::size_t> standing;               ///< pairs that stand over their patch
    CornerScratch corners;
  };
  using Kept = PairRange<D>::Kept;

  PairRange<D> range(std::size_t first, std::size_t last) const {
    return {pairs_.data() + first, pairs_.data() + last, {particle_.data(), place_.data(), faces_.position.data(), faces_.normal.data()}};
  }
  double weight(double volume, double area, double borne_share, double distance) const;
  void look(const InterfaceParticles<D>& particles);
  void weigh(const InterfaceParticles<D>& particles, int particle, const int* points, std::ptrdiff_t count, Kept* pairs, std::size_t first,
             std::vector<std::size_t>* standing) const;
  void find_borne_shares();
  void sum_by_points(const Surface<D>& surface);

  FaceKernel<D> kernel_;
  FaceFinder<D> finder_;
  Faces<D> faces_;
  std::vector<Found> found_;  ///< by thread
  UninitialisedVector<Kept> pairs_;
  std::vector<int> particle_;     ///< of each place: those of the particles, then those of the images
  std::vector<Vector<D>> place_;  ///< the same [m]
  std::size_t particle_pairs_ = 0, back_facing_pairs_ = 0;
  std::vector<std::uint8_t> covered_, asked_;  ///< per surface point; asked_: some particle has a pair with it
  std::vector<double> borne_share_;
  std::vector<double> seen_share_, filled_, weighed_area_;  ///< per surface point
  std::vector<std::size_t> first_;                          ///< pair of each particle, then the number of them all
  std::vector<std::size_t> begin_, begin_past_;  ///< of the pairs of each thread's particles, those they see and those past corners
};

}  // namespace tern::coupler
