// What a plane face contributes to a particle's sums, against the lattice continued behind the plane.

#include "sph/face_kernel.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <random>

namespace tern {
namespace {

constexpr double spacing = 0.02;

/// A lattice of particles on the plane x_1 = 0 (y > 0, first layer dx/2 above it) and what one particle of a layer
/// sees.
template <int D>
struct LatticeOnPlane {
  double gradient = 0;  ///< dx sum grad w, component along the normal, fluid and hidden side, calibrated [-]
  double number = 0;    ///< (sum V w)/(value of the full lattice)
  double trace = 0;     ///< tr M / D
  double face = 0;      ///< dx sum_k A_k w~, the part of the face alone [-]
};

/// `patches` per spacing; `offset` of the particle along the plane [dx].
template <int D>
LatticeOnPlane<D> evaluate(double ratio, int layer, double patches, double offset = 0) {
  const Kernel<D> kernel(ratio * spacing);
  const FaceKernel<D> faces(kernel, spacing);
  const LatticeSums reference = lattice_sums<D>(kernel, spacing);
  const double volume = std::pow(spacing, D);
  const int reach = static_cast<int>(std::ceil(kernel.support() / spacing));

  LatticeOnPlane<D> result;
  for (int k = D == 3 ? -reach : 0; k <= (D == 3 ? reach : 0); ++k)
    for (int j = -layer; j <= reach; ++j)
      for (int i = -reach; i <= reach; ++i) {
        const double r = spacing * std::sqrt(double(i * i + j * j + k * k));
        result.number += volume * kernel.value(r);
        const double weight = volume * kernel.gradient_weight(r) / reference.gradient_moment;
        result.gradient += spacing * weight * j * spacing;
        result.trace += weight * r * r / D;
      }

  const double size = spacing / patches, area = std::pow(size, D - 1), height = (layer + 0.5) * spacing;
  const int extent = static_cast<int>(std::ceil(kernel.support() / size)) + 2;
  Vector<D> normal = Vector<D>::Zero();
  normal[1] = 1;
  for (int k = D == 3 ? -extent : 0; k < (D == 3 ? extent : 1); ++k)
    for (int i = -extent; i < extent; ++i) {
      Vector<D> d;
      d[0] = (i + 0.5) * size - offset * spacing;
      d[1] = -height;
      if (D == 3) d[D - 1] = (k + 0.5) * size - 0.7 * offset * spacing;
      const double r = d.norm();
      if (r >= faces.support()) continue;
      const double angle = subtended_angle<D>(d, normal, area);
      result.face += spacing * area * faces.surface_weight(r);
      result.number += angle * faces.hidden_density(r);
      result.trace += angle * faces.hidden_moment(r) / D;
    }
  result.gradient -= result.face;
  result.number /= reference.density;
  return result;
}

template <int D>
void expect_lattice_completed(double ratio) {
  for (int layer = 0; layer < 3; ++layer)
    for (double offset : {0.0, 0.11}) {
      const auto sums = evaluate<D>(ratio, layer, 4, offset);
      SCOPED_TRACE(testing::Message() << D << "D, h/dx " << ratio << ", layer " << layer << ", offset " << offset);
      EXPECT_NEAR(sums.gradient, 0, layer < 2 ? 1e-6 : 1e-3);
      EXPECT_NEAR(sums.number, 1, layer == 0 ? 2e-3 : 1e-4);
      EXPECT_NEAR(sums.trace, 1, layer == 1 ? 2e-4 : 1.2e-3);
    }
}

// Patches of a quarter spacing. Measured, h/dx 1.3 and 1.5, 2D and 3D: sum grad w dx below 6e-8 in the two layers of
// the calibration and 7e-4 in the third (1.5 only); n off by 0.7e-3 to 1.5e-3 in the layer at the plane, 5e-5 above; tr
// M/D by 0.5e-3 to 1.1e-3 at the plane, 1.5e-4 in the second layer, 1.1e-3 in the third. Seen to fail: with w in place
// of w~ (gradient); with the weights a + b s of the density, then of the moment, left out.
TEST(FaceKernel, CompletesALatticeRestingOnAPlane) {
  for (double ratio : {1.3, 1.5}) {
    expect_lattice_completed<2>(ratio);
    expect_lattice_completed<3>(ratio);
  }
}

/// What the layers of a lattice on a plane see in 3D, with the sums behind the whole plane in place of those of its patches.
LatticeOnPlane<3> evaluate_whole_plane(double ratio, int layer) {
  const Kernel<3> kernel(ratio * spacing);
  const FaceKernel<3>::PlaneSums plane = FaceKernel<3>(kernel, spacing).behind_plane((layer + 0.5) * spacing);
  const LatticeSums reference = lattice_sums<3>(kernel, spacing);
  const double volume = std::pow(spacing, 3);
  const int reach = static_cast<int>(std::ceil(kernel.support() / spacing));
  LatticeOnPlane<3> result;
  for (int k = -reach; k <= reach; ++k)
    for (int j = -layer; j <= reach; ++j)
      for (int i = -reach; i <= reach; ++i) {
        const double r = spacing * std::sqrt(double(i * i + j * j + k * k));
        const double weight = volume * kernel.gradient_weight(r) / reference.gradient_moment;
        result.number += volume * kernel.value(r) / reference.density;
        result.gradient += spacing * weight * j * spacing;
        result.trace += weight * r * r / 3;
      }
  result.number += plane.density / reference.density;
  result.gradient -= spacing * plane.weight;
  result.trace += (plane.normal + 2 * plane.along) / 3;
  return result;
}

// Seen to fail: with the part along the plane as large as that along the normal.
TEST(FaceKernel, CompletesALatticeRestingOnAWholePlaneWithoutPatches) {
  for (double ratio : {1.3, 1.5})
    for (int layer : {0, 1}) {
      const auto sums = evaluate_whole_plane(ratio, layer);
      SCOPED_TRACE(testing::Message() << "h/dx " << ratio << ", layer " << layer);
      EXPECT_NEAR(sums.gradient, 0, 2e-6);
      EXPECT_NEAR(sums.number, 1, 2e-6);
      EXPECT_NEAR(sums.trace, 1, 2e-6);
    }
}

// Patches of dx/16 under places in no order. The direction of what is behind a patch is that of its centre, so near ones are off by
// (dx/16 y)^2. Seen to fail: with the height of the plane in place of its third power, and with the
// part along the plane as large as that along the normal.
TEST(FaceKernel, HasInAPlaneWhatItsPatchesTendTo) {
  const Kernel<3> kernel(1.5 * spacing);
  const FaceKernel<3> faces(kernel, spacing);
  const double size = spacing / 16;
  const int extent = static_cast<int>(kernel.support() / size) + 2;
  for (double y : {0.3, 0.5, 0.9, 1.4, 2.2}) {
    double density = 0, normal = 0, along = 0, weight = 0;
    for (int i = -extent; i <= extent; ++i)
      for (int k = -extent; k <= extent; ++k) {
        const Vector<3> d((i + 0.3) * size, -y * spacing, (k - 0.2) * size);
        const double r = d.norm();
        if (r >= faces.support()) continue;
        const double angle = subtended_angle<3>(d, Vector<3>::Unit(1), size * size), moment = angle * faces.hidden_moment(r) / (r * r);
        density += angle * faces.hidden_density(r);
        normal += moment * d[1] * d[1];
        along += 0.5 * moment * (d[0] * d[0] + d[2] * d[2]);
        weight += size * size * faces.surface_weight(r);
      }
    const auto plane = faces.behind_plane(y * spacing);
    SCOPED_TRACE(testing::Message() << y << " spacings");
    EXPECT_NEAR(plane.density, density, 2e-4);
    EXPECT_NEAR(plane.normal, normal, 0.4 / (256 * y * y));
    EXPECT_NEAR(plane.along, along, 0.2 / (256 * y * y));
    EXPECT_NEAR(plane.weight * spacing, weight * spacing, 1e-6);
  }
}

template <int D>
void expect_convergence(double ratio) {
  double before = 0;
  for (double patches : {2., 4., 8., 16.}) {
    double error = 0;
    for (int layer = 0; layer < 2; ++layer) {
      const auto sums = evaluate<D>(ratio, layer, patches, 0.07);
      error = std::max({error, std::abs(sums.gradient), std::abs(sums.number - 1), std::abs(sums.trace - 1)});
    }
    SCOPED_TRACE(testing::Message() << D << "D, h/dx " << ratio << ", patches of dx/" << patches);
    if (before > 0) {
      EXPECT_LT(error, 0.27 * before);
    }
    before = error;
  }
  EXPECT_LT(before, 1e-4);
}

// The limit is what the lattice continued behind the plane would give. Patches of dx/2 are off by 3e-3 (2D) and 6e-3
// (3D), and every halving divides that by four. Seen to fail: with the hidden sums of a shell s^D instead of s^(D-1).
TEST(FaceKernel, SumsTendToTheContinuedLatticeAsPatchesShrink) {
  for (double ratio : {1.3, 1.5}) {
    expect_convergence<2>(ratio);
    expect_convergence<3>(ratio);
  }
}

/// Force of a uniform unit pressure per area of face: every particle above one lattice cell of it gives 2 p V A w~.
template <int D>
double transferred_pressure(double ratio) {
  double sum = 0;
  for (int layer = 0; (layer + 0.5) < 2 * ratio; ++layer) sum += 2 * evaluate<D>(ratio, layer, 4).face;
  return sum;
}

// Measured: 1.0000 at h/dx 1.3, 1.0014 (2D) and 1.0008 (3D) at 1.5. Seen to fail: with w in place of w~, and with the
// lattice behind the plane not calibrated by M_xx.
TEST(FaceKernel, TransfersAUniformPressureThroughAFlatFace) {
  for (double ratio : {1.3, 1.5}) {
    EXPECT_NEAR(transferred_pressure<2>(ratio), 1, 2e-3);
    EXPECT_NEAR(transferred_pressure<3>(ratio), 1, 2e-3);
  }
}

// Seen to fail: without the length of the segment (2D), and with corners a whole instead of half a side away (3D).
TEST(SubtendedAngle, OfAClosedBoxIsTheWholeSphere) {
  double circle = 0, sphere = 0;
  constexpr int patches = 6;
  const Vector<2> inside2(0.13, -0.21);
  const Vector<3> inside3(0.13, -0.21, 0.3);
  for (int side = 0; side < 6; ++side) {
    const int axis = side / 2, sign = side % 2 ? 1 : -1;
    for (int i = 0; i < patches; ++i) {
      const double u = (i + 0.5) / patches - 0.5;
      if (axis < 2) {
        Vector<2> x = Vector<2>::Zero(), n = x;
        x[axis] = 0.5 * sign, n[axis] = -sign, x[1 - axis] = u;
        circle += subtended_angle<2>(x - inside2, n, 1.0 / patches);
      }
      for (int j = 0; j < patches; ++j) {
        Vector<3> x = Vector<3>::Zero(), n = x;
        x[axis] = 0.5 * sign, n[axis] = -sign;
        x[(axis + 1) % 3] = u, x[(axis + 2) % 3] = (j + 0.5) / patches - 0.5;
        sphere += subtended_angle<3>(x - inside3, n, 1.0 / (patches * patches));
      }
    }
  }
  EXPECT_NEAR(circle, 2 * std::numbers::pi, 1e-12);
  EXPECT_NEAR(sphere, 4 * std::numbers::pi, 1e-12);
  // From behind a patch is not seen.
  EXPECT_EQ(subtended_angle<2>(Vector<2>(0, 1), Vector<2>(0, 1), 0.5), 0);
}

/// Of patches in random directions, from a twentieth of a side to ten sides away: largest relative difference of single from double
/// precision.
template <int D>
double off_in_single_precision() {
  std::mt19937 random(1);
  std::normal_distribution<double> any;
  std::uniform_real_distribution<double> share(0, 1);
  double worst = 0;
  for (int patch = 0; patch < 5000; ++patch) {
    const double side = std::pow(10, -6 * share(random)), distance = side * (0.05 + 10 * std::pow(share(random), 3));
    const double area = double(static_cast<float>(std::pow(side, D - 1)));
    Vector<D> n, d;
    for (int c = 0; c < D; ++c) n[c] = any(random), d[c] = any(random);
    n.normalize();
    d.normalize();
    if (d.dot(n) > 0) d = -d;
    if (d.dot(n) > -0.05) continue;  // what single precision makes of the height itself
    float d1[D], n1[D];
    for (int c = 0; c < D; ++c) {
      d1[c] = static_cast<float>(distance * d[c]), n1[c] = static_cast<float>(n[c]);
      d[c] = double(d1[c]), n[c] = double(n1[c]);
    }
    const double exact = subtended_angle<D>(d, n, area);
    worst = std::max(worst, std::abs(double(subtended_angle<D>(d1, n1, static_cast<float>(area))) / exact - 1));
  }
  return worst;
}

// Seen to fail: with one of the two triangles twice.
TEST(SubtendedAngle, InSinglePrecisionIsThatInDouble) {
  const double in_2d = off_in_single_precision<2>(), in_3d = off_in_single_precision<3>();
  std::printf("[ off by %.1e in 2D, by %.1e in 3D ]\n", in_2d, in_3d);
  EXPECT_LT(in_2d, 1e-5);
  EXPECT_LT(in_3d, 1e-5);
}

// Seen to fail: with the slope of w~ without its second part.
TEST(FaceKernel, OfConesInSinglePrecisionIsThatInDouble) {
  const FaceKernel<3> faces(Kernel<3>(0.015), 0.01);
  for (double r = 0; r < 1.1 * faces.support(); r += 1e-4) {
    const float at = static_cast<float>(r);
    EXPECT_NEAR(double(faces.cones()(at, 1, 0, 0)), faces.surface_weight_beyond(r), 1e-5 * faces.surface_weight_beyond(0));
    EXPECT_NEAR(double(faces.cones()(at, 0, 1, 1)), -faces.midpoint_rest(r), 1e-5 * faces.midpoint_rest(0.01));
  }
}

/// Largest change of sum_k A_k w~ along a plane, relative, at a height above patches of this length [dx].
template <int D>
double unevenness(double height, double length) {
  const Kernel<D> kernel(1.5 * spacing);
  const FaceKernel<D> faces(kernel, spacing);
  const int extent = static_cast<int>(std::ceil(kernel.support() / (length * spacing))) + 2;
  const auto sum = [&](double offset) {
    double result = 0;
    for (int k = D == 3 ? -extent : 0; k < (D == 3 ? extent : 1); ++k)
      for (int i = -extent; i < extent; ++i) {
        const double x = (i + 0.5 - offset) * length, z = D == 3 ? (k + 0.5 - offset) * length : 0;
        result += std::pow(length, D - 1) * faces.surface_weight(spacing * std::sqrt(x * x + height * height + z * z));
      }
    return result;
  };
  return std::abs(sum(0.5) / sum(0) - 1);
}

// Twice the pressure times this pushes a particle along the face. A particle comes as near as a quarter of a spacing.
// Seen to fail: with patches of a whole spacing (3.3 and 1.0 %).
TEST(FaceKernel, SeesAFlatFaceEvenlyBeforePatchesOfHalfASpacing) {
  for (double height : {0.25, 0.5, 0.75, 1.0}) {
    const double half[] = {unevenness<2>(height, 0.5), unevenness<3>(height, 0.5)};
    const double whole[] = {unevenness<2>(height, 1), unevenness<3>(height, 1)};
    std::printf("[ %.2f dx off patches of dx/2: %.5f (2D), %.5f (3D); of dx: %.5f, %.5f ]\n", height, half[0], half[1], whole[0], whole[1]);
    for (double uneven : half) EXPECT_LT(uneven, height < 0.5 ? 2.5e-3 : 5e-4) << height;
  }
}

}  // namespace
}  // namespace tern
