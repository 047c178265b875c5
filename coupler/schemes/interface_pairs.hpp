#pragma once
// Pairs of fluid particle i and surface point k that see each other, with the vector all interface operators share:
//   b_ik = -2 V_i A_k w~(r_ik) n_k
// (beside corners with the share of convex_corner.hpp). A pressure p puts the force +p b_ik on k and -p b_ik on i, so that the
// exchange conserves momentum exactly; away from corners div_i takes (1/V_i) b_ik . (u_k - u_i), so that its power is p div u.
// Thin bodies need no special care, because the hidden half space is replaced by its surface (Gauss' theorem).
// Where a face meets a wall, part of the half space before its points lies beyond the wall. The fluid is mirrored there, and
// the images of particles have pairs too: with them the face has its whole load.

#include <span>
#include <vector>

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

template <int D>
class InterfacePairs {
 public:
  InterfacePairs(double smoothing_length, double fluid_spacing) : kernel_(Kernel<D>(smoothing_length), fluid_spacing) {}

  /// Finds all pairs of the window, particle by particle. The same bits for any number of threads.
  void find(const InterfaceParticles<D>& particles, const Surface<D>& surface);

  /// Of the particles themselves.
  std::span<const InterfacePair<D>> pairs() const { return {pairs_.data(), particle_pairs_}; }
  /// Of particles past a corner with faces that are turned away from them (sph/convex_corner.hpp): of the pressure only.
  std::span<const InterfacePair<D>> back_facing_pairs() const { return {pairs_.data() + particle_pairs_, back_facing_pairs_}; }
  /// Of their images behind walls: `particle` is the one that is mirrored, everything else is that of the image.
  std::span<const InterfacePair<D>> image_pairs() const { return std::span(pairs_).subspan(particle_pairs_ + back_facing_pairs_); }
  /// Part of the half space before each point that the particles that it sees fill, as the fluid's own sums have it.
  std::vector<double> seen_share(const Surface<D>& surface) const;

  /// Those of the particles, the back-facing ones, then those of the images.
  std::span<const InterfacePair<D>> all_pairs() const { return pairs_; }

 private:
  /// What one thread finds, of its particles one after the other.
  struct Found {
    std::vector<int> seen, back_facing;              ///< points
    std::vector<int> seen_count, back_facing_count;  ///< per particle
    CornerScratch corners;
  };
  void look(const InterfaceParticles<D>& particles);
  void find_borne_shares();

  FaceKernel<D> kernel_;
  FaceFinder<D> finder_;
  Faces<D> faces_;
  std::vector<Found> found_;  ///< by thread
  std::vector<InterfacePair<D>> pairs_;
  std::size_t particle_pairs_ = 0, back_facing_pairs_ = 0;
  std::vector<std::uint8_t> covered_, asked_;  ///< per surface point; asked_: some particle has a pair with it
  std::vector<double> borne_share_;
  std::vector<std::size_t> first_;  ///< pair of each particle, then the number of them all
};

}  // namespace tern::coupler
