// Back-facing faces of a particle, and the share that a face bears, against their definition, asked of all faces one by one.
// Seen to fail (FaceFinder::any_turned_around): with the least product larger by 0.8, and with holds(k) turned round; (CornerView::look)
// with faces taken for the far side of a plate up to a product that is larger by twice the turn of the sheet; (FaceFinder::see) with a
// spread of 0; (CornerView::borne_share) with a tenth less of every cone.

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <random>

#include "sph/convex_corner.hpp"

namespace tern {
namespace {

constexpr double dx = 0.01;

/// Patches of a plate that turns up, of a block with its corners beside it, and of a ball; in disorder.
template <int D>
Faces<D> bodies(std::mt19937& random) {
  Faces<D> faces;
  const double size = 0.5 * dx;
  std::uniform_real_distribution<double> disorder(-0.02 * size, 0.02 * size);
  const auto add = [&](Vector<D> x, const Vector<D>& n) {
    for (int c = 0; c < D; ++c) x[c] += disorder(random);
    faces.position.push_back(x);
    faces.normal.push_back(n.normalized());
    faces.area.push_back(D == 2 ? size : size * size);
    faces.two_sided.push_back(1);
  };
  const int across = D == 3 ? 12 : 1;
  for (int j = 0; j < across; ++j)
    for (int i = 0; i < 40; ++i)
      for (const double side : {1.0, -1.0}) {
        Vector<D> x = Vector<D>::Zero(), n = Vector<D>::Zero();
        const double s = size * i, turned = std::max(0.0, s - 0.1);
        x[0] = s, x[1] = 4 * turned * turned + side * 0.3 * dx;
        if constexpr (D == 3) x[2] = size * j;
        n[0] = -8 * turned, n[1] = 1;
        add(x, side * n);
      }
  for (int axis = 0; axis < D; ++axis)
    for (const double side : {1.0, -1.0})
      for (int i = 0; i < 8; ++i)
        for (int j = 0; j < (D == 3 ? 8 : 1); ++j) {
          Vector<D> x = Vector<D>::Zero(), n = Vector<D>::Zero();
          n[axis] = side;
          x[axis] = side * 4 * size;
          x[(axis + 1) % D] = (i - 3.5) * size;
          if constexpr (D == 3) x[(axis + 2) % D] = (j - 3.5) * size;
          x[1] += 7 * size;
          add(x, n);
        }
  return faces;
}

/// All that looks past the corners of faces, none of which is covered.
template <int D>
struct View {
  explicit View(const Faces<D>& faces) : corners(faces, finder, none_covered, kernel, scratch) { finder.fill(faces, kernel.support()); }
  FaceKernel<D> kernel{Kernel<D>(1.5 * dx), dx};
  FaceFinder<D> finder;
  std::vector<std::uint8_t> none_covered;
  CornerScratch scratch;
  CornerView<D> corners;
};

/// Faces turned away from x that bound what hides behind those it sees; `behind_plate(k)`: what x sees has k on its far side.
template <int D, class BehindPlate>
std::vector<int> back_facing_by_definition(const Faces<D>& faces, double support, const Vector<D>& x, const BehindPlate& behind_plate) {
  std::vector<int> far, found;
  for (int k = 0; k < static_cast<int>(faces.size()); ++k) {
    const Vector<D> d = faces.position[k] - x;
    if (d.dot(faces.normal[k]) <= 1e-6 * support || d.norm() >= support) continue;
    (behind_plate(k) ? far : found).push_back(k);
  }
  std::erase_if(found, [&](int k) {
    return std::any_of(far.begin(), far.end(), [&](int plate) { return patch_separates(faces, plate, faces.position[k], x); });
  });
  return found;
}

template <int D>
void compare(int particles) {
  std::mt19937 random(3);
  const Faces<D> faces = bodies<D>(random);
  View<D> view(faces);
  auto& [kernel, finder, none_covered, scratch, corners] = view;
  const double support = kernel.support();
  std::uniform_real_distribution<double> share(0, 1);
  std::size_t with = 0, before_a_plane = 0;
  for (int p = 0; p < particles; ++p) {
    const auto middle = faces.position[static_cast<std::size_t>(share(random) * static_cast<double>(faces.size()))];
    Vector<D> x;
    for (int c = 0; c < D; ++c) x[c] = middle[c] + (share(random) - 0.5) * support;
    std::vector<int> seen;
    const double spread = finder.see(faces, x, seen);
    if (seen.empty()) continue;
    corners.look(x, seen.data(), static_cast<int>(seen.size()), spread);
    std::vector<int> found = corners.back_facing();
    std::sort(found.begin(), found.end());
    const bool flat =
        std::all_of(seen.begin(), seen.end(), [&](int k) { return (faces.normal[k] - faces.normal[seen[0]]).squaredNorm() < 1e-12; });
    const auto expected = back_facing_by_definition(faces, support, x, [&](int k) {
      const auto makes_plate = [&](int face) { return faces.normal[face].dot(faces.normal[k]) <= -0.6; };
      return std::all_of(seen.begin(), seen.end(), makes_plate) || std::any_of(seen.begin(), seen.end(), [&](int face) {
               return makes_plate(face) && patch_separates(faces, face, x, faces.position[k]);
             });
    });
    ASSERT_EQ(found, expected) << "particle " << p;
    with += !expected.empty();
    before_a_plane += flat && !expected.empty();
  }
  EXPECT_GT(with, 20U) << "the scene has too few corners to show anything";
  EXPECT_GT(before_a_plane, 5U);
  std::size_t loaded_less = 0;
  for (int k = 0; k < static_cast<int>(faces.size()); ++k) {
    const auto turned = back_facing_by_definition(faces, support, faces.position[k],
                                                  [&](int other) { return faces.normal[k].dot(faces.normal[other]) <= -0.6; });
    const bool any = !turned.empty();
    const double borne = corners.borne_share(k);
    std::vector<int> seen;
    finder.see(faces, faces.position[k], seen);
    EXPECT_TRUE(any || !seen.empty() || borne == 1) << "face " << k;
    double past = 0;  // what is open beside the half space, over it
    for (const int other : turned) {
      const Vector<D> d = faces.position[other] - faces.position[k], n = -faces.normal[other];
      const double r = d.norm(), cone = subtended_angle<D>(d, n, faces.area[other]) * kernel.surface_weight_beyond(r);
      past += (cone + faces.area[other] * d.dot(n) / r * kernel.midpoint_rest(r)) / ((D == 2 ? 1 : 2) * std::numbers::pi);
    }
    const double expected = 1 / (1 + std::max(0.0, past) / kernel.surface_weight_beyond(0));
    EXPECT_NEAR(borne, seen.empty() ? expected : borne, 1e-6) << "face " << k;
    loaded_less += any && borne < 1;
  }
  EXPECT_GT(loaded_less, 20U);
}

/// Faces of the planes x = 0, y = 0 and, in 3D, z = 0 towards a corner of them that is full of particles on a lattice. Largest distance
/// from 1 of what these fill of the half space before a face, times the share that it bears.
template <int D>
double unfilled_in_a_corner() {
  const double size = 0.5 * dx;
  const int patches = 24, layers = 10;
  Faces<D> faces;
  for (int axis = 0; axis < D; ++axis)
    for (int i = 0; i < patches; ++i)
      for (int j = 0; j < (D == 3 ? patches : 1); ++j) {
        Vector<D> x = Vector<D>::Zero();
        x[(axis + 1) % D] = (i + 0.5) * size;
        if constexpr (D == 3) x[(axis + 2) % D] = (j + 0.5) * size;
        faces.position.push_back(x);
        faces.normal.push_back(Vector<D>::Unit(axis));
        faces.area.push_back(D == 2 ? size : size * size);
        faces.two_sided.push_back(1);
      }
  View<D> view(faces);
  double worst = 0;
  for (int k = 0; k < static_cast<int>(faces.size()); ++k) {
    if (faces.position[k].maxCoeff() > layers * dx - view.kernel.support()) continue;
    double filled = 0;
    for (int i = 0; i < layers; ++i)
      for (int j = 0; j < layers; ++j)
        for (int l = 0; l < (D == 3 ? layers : 1); ++l) {
          Vector<D> x;
          x[0] = (i + 0.5) * dx, x[1] = (j + 0.5) * dx;
          if constexpr (D == 3) x[2] = (l + 0.5) * dx;
          const double distance = (x - faces.position[k]).norm();
          if (distance < view.kernel.support()) filled += 2 * std::pow(dx, D) * view.kernel.surface_weight(distance);
        }
    worst = std::max(worst, std::abs(view.corners.borne_share(k) * filled - 1));
  }
  return worst;
}

// In a concave corner a face has as many times the particles' pressures as the other faces take of the half space before it.
// Seen to fail: with nothing hidden by the faces that a face sees (0.37 in 2D, 0.60 in 3D).
TEST(CornerView, MakesUpForWhatConcaveCornersTake) {
  const double in_2d = unfilled_in_a_corner<2>(), in_3d = unfilled_in_a_corner<3>();
  std::printf("[ filled times share is off 1 by %.4f in 2D, by %.4f in 3D ]\n", in_2d, in_3d);
  EXPECT_LT(in_2d, 0.03);
  EXPECT_LT(in_3d, 0.03);
}

/// Least share that a face below a plate bears which would see a wall above it, turned away, were it not for the plate.
template <int D>
double least_share_below_a_plate() {
  const double size = 0.5 * dx;
  Faces<D> faces;
  const auto add = [&](double x0, double x1, double x2, const Vector<D>& n) {
    Vector<D> x = Vector<D>::Zero();
    x[0] = x0, x[1] = x1;
    if constexpr (D == 3) x[2] = x2;
    faces.position.push_back(x);
    faces.normal.push_back(n);
    faces.area.push_back(D == 2 ? size : size * size);
    faces.two_sided.push_back(1);
  };
  const int across = D == 3 ? 20 : 1;
  for (int j = 0; j < across; ++j) {
    for (int i = 0; i < 40; ++i)
      for (const double side : {-1.0, 1.0}) add(size * i, 0.1 * dx * side, size * j, side * Vector<D>::Unit(1));
    for (int i = 0; i < 6; ++i) add(20 * size, 0.3 * dx + size * i, size * j, Vector<D>::Unit(0));
  }
  View<D> view(faces);
  double least = 1;
  for (int k = 0; k < static_cast<int>(faces.size()); ++k)
    if (faces.normal[k][1] < 0) least = std::min(least, view.corners.borne_share(k));
  return least;
}

// Seen to fail: (CornerView::find_behind) with what the first look finds taken as it is (0.85).
TEST(CornerView, PassesOverWhatLiesBeyondAPlate) {
  EXPECT_EQ(least_share_below_a_plate<2>(), 1);
  EXPECT_EQ(least_share_below_a_plate<3>(), 1);
}

TEST(CornerView, FindsWhatTurnsAway2D) { compare<2>(2000); }
TEST(CornerView, FindsWhatTurnsAway3D) { compare<3>(1000); }

}  // namespace
}  // namespace tern
