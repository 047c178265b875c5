#pragma once
// Corners of bodies. What a body hides from a particle beside one of its convex corners is bounded by the face that the
// particle sees and, round the corner, by faces turned away from it: back-facing faces. The fluid beyond such a corner is seen past
// it, that beyond a thin plate is not. In a concave corner, or beside another body, a face sees faces itself: what they hide is not open
// to fluid.

#include <array>
#include <cstdint>
#include <vector>

#include "sph/face_kernel.hpp"
#include "sph/faces.hpp"

namespace tern {

/// Product of two normals from which the faces are those of a plate: faces at less than 53 degrees.
inline constexpr double plate_cosine = -0.6;

/// Whether a line that enters a body through a face of the first normal and leaves it through one of the second passes a corner
/// of it rather than a plate.
template <int D>
bool passes_corner(const Vector<D>& in, const Vector<D>& out) {
  return in.dot(out) > plate_cosine;
}

/// Faces seen from a place x in single precision, one array per quantity, so that many are looked at together.
struct FacesFrom {
  static constexpr std::size_t lanes = 8;

  std::vector<int> face;
  std::array<std::vector<float>, 3> way, normal;  ///< way: from x to the face
  std::vector<float> front, reach;                ///< height of x above it, and half its length, a little more than that

  template <int D>
  void set(const Faces<D>& faces, const Vector<D>& x, const int* first, int count);
  /// Whether holds(k) is true for one of the faces that may lie between x and a place within the support, and that x is before (`side` 1)
  /// or behind (-1). `at`: of the place from x.
  template <int D, class Holds>
  bool any_between(const Vector<D>& at, double support, float side, Holds&& holds) const;
};

/// Kept by the caller, so that a step allocates nothing.
struct CornerScratch {
  std::vector<int> back_facing, turned, seen;
  FacesFrom far, near;
};

/// Finds back-facing faces. The faces of the structure and their finder outlive it.
template <int D>
class CornerView {
 public:
  /// `covered`: faces before which there is a wall instead of room for fluid; empty: none is.
  CornerView(const Faces<D>& structure, const FaceFinder<D>& finder, const std::vector<std::uint8_t>& covered, const FaceKernel<D>& kernel,
             CornerScratch& scratch)
      : structure_(structure),
        finder_(finder),
        covered_(covered),
        kernel_(kernel),
        back_facing_(scratch.back_facing),
        turned_(scratch.turned),
        seen_(scratch.seen),
        far_(scratch.far),
        near_(scratch.near) {}

  /// Sets back_facing() for a particle at x: faces within the support that are turned away from it and bound what hides behind those it
  /// sees, at least one. `spread`: of the normals of these, as FaceFinder::see() has it; 2: it is not known.
  void look(const Vector<D>& x, const int* seen, int seen_count, double spread = 2);
  const std::vector<int>& back_facing() const { return back_facing_; }

  /// Share of the pressures before face k that is its load, 1 away from corners. A face has a half space before it, but beside
  /// a convex corner there is fluid behind its plane as well, and in a concave one another face takes a part of the half space.
  double borne_share(int k);

 private:
  template <class Turned>
  void find(const Vector<D>& x, Turned&& behind_plate);
  void sort_turned(int k, bool behind_plate);
  void remove_beyond_plates(const Vector<D>& x, std::vector<int>& faces);
  void find_behind(const Vector<D>& normal, const Vector<D>& x);

  const Faces<D>& structure_;
  const FaceFinder<D>& finder_;
  const std::vector<std::uint8_t>& covered_;
  const FaceKernel<D>& kernel_;
  std::vector<int>&back_facing_, &turned_, &seen_;
  FacesFrom &far_, &near_;
};

/// Marks the faces of the structure before which there is a wall. `before`: distance of the places that are asked [m].
template <int D>
void find_covered_faces(const Faces<D>& structure, const Faces<D>& walls, const FaceFinder<D>& wall_finder, double before,
                        std::vector<std::uint8_t>& covered);

}  // namespace tern
