#pragma once
// A thin body as one layer of particles on its mid-surface (2D: a line), without rotations: the reference configuration.
//
// Particle i stands for the area A_i of the mid-surface, the thickness t through it. With its frame e_a, N and xi = (X_j - X_i).e_a,
//   x_,a = sum_j g^a_ij (x_j - x_i),   x_,ab = sum_j k^ab_ij (x_j - x_i)
// are exact for every quadratic field of xi (least squares, as in gradient_vectors.cpp, with one dimension less). The energy is a
// function of these derivatives alone (shell_force.hpp).
//
// Particles on a clamped edge turn with the clamp. Their x_,a is the one-sided fit as everywhere, but their x_,ab are the quadratic
// part of x_j - x_i - R e_a xi_a, in which the clamp prescribes the slope R e_a.

#include <array>
#include <cstdint>
#include <vector>

#include "base/vector.hpp"
#include "scene/mid_surface.hpp"
#include "structure/material/registry.hpp"

namespace tern::structure {

/// Number of derivatives x_,a and x_,ab of the mid-surface: 2 in 2D, 5 in 3D.
template <int D>
inline constexpr int shell_slopes = D - 1;
template <int D>
inline constexpr int shell_unknowns = shell_slopes<D> + (D - 1) * D / 2;

/// In the order x_,1 (x_,2) x_,11 (x_,12 x_,22), or what is conjugate to them.
template <int D>
using ShellDerivatives = Eigen::Matrix<double, D, shell_unknowns<D>, Eigen::DontAlign>;

/// Column of x_,ab in it.
template <int D>
constexpr int second_derivative(int a, int b) {
  return D == 2 ? 1 : 2 + a + b;
}

/// Unit normal n of a mid-surface with these slopes x_,a, the first columns of `slopes`.
template <int D, class Slopes>
Vector<D> shell_normal(const Slopes& slopes) {
  if constexpr (D == 2)
    return Vector<2>(-slopes(1, 0), slopes(0, 0)).normalized();
  else
    return Vector<3>(slopes.col(0)).cross(Vector<3>(slopes.col(1))).normalized();
}

/// What a layer is made of. Neighbours are the particles within 2.2 spacings along the mid-surface.
template <int D>
struct ShellParticles {
  std::vector<Vector<D>> position;                 ///< X [m]
  std::vector<Matrix<D>> frame;                    ///< columns: e_a, then the normal N
  std::vector<double> area;                        ///< of the mid-surface, half of it on a held edge [m^(D-1)]
  std::vector<bool> held;                          ///< on a clamped or hinged edge: its motion is prescribed
  std::vector<std::int32_t> clamp;                 ///< of its edge: index of Reference::clamps, their number without a name; -1: none
  std::array<double, shell_slopes<D>> spacing{};   ///< along e_a [m]
  std::array<int, shell_slopes<D>> size{};         ///< particles along e_a, the first fastest
  std::array<bool, shell_slopes<D>> closed{};      ///< the first of them is beside the last
  bool in_rows = true;                             ///< on a ball or plate they are not, and the two above say nothing
  std::vector<std::vector<std::uint32_t>> beside;  ///< plate: which others a straight line in it leads to; empty: to all
};

/// The cells of a mid-surface.
template <int D>
ShellParticles<D> shell_particles(const MidSurface<D>& surface);

/// What the energy compares with: metric x_,a.x_,b, bend n.x_,ab and x_,ac.x_,b + x_,bc.x_,a, halved, of x = X.
struct ShellRest {
  Eigen::Matrix<double, 2, 2, Eigen::DontAlign> metric, bend;
  std::array<Eigen::Matrix<double, 2, 2, Eigen::DontAlign>, 2> gradient;
};

template <int D>
struct ShellLayer {
  using Weights = Eigen::Matrix<double, shell_unknowns<D>, 1, Eigen::DontAlign>;

  ShellParticles<D> particles;
  Material material;
  double thickness = 0;                                ///< t [m]
  std::array<double, shell_slopes<D>> cell_squared{};  ///< min(spacing, t)^2/12, see shell_force.hpp [m^2]

  // Pairs (i, j), those of particle i from first[i] on.
  std::vector<std::uint32_t> first, neighbour, mirror;  ///< mirror: where the pair (j, i) is
  std::vector<Weights> weight;                          ///< g^a_ij, k^ab_ij
  std::vector<Weights> mirror_weight;                   ///< -A_j times those of the pair (j, i)
  std::vector<Weights> weight_sum;                      ///< A_i sum_j of those of particle i

  /// Of a particle of a clamp: sum_j k^ab_ij xi_c, row ab, column c, which the slopes R e_c of the clamp are to be multiplied with.
  std::vector<Eigen::Matrix<double, shell_unknowns<D> - shell_slopes<D>, shell_slopes<D>, Eigen::DontAlign>> clamp_slope;
  std::vector<ShellDerivatives<D>> reference;  ///< of x = X
  std::vector<ShellRest> rest;                 ///< 3D

  std::size_t size() const { return particles.position.size(); }
  /// E' = E/(1 - nu^2), the modulus of a plate; in plane stress E [Pa].
  double modulus() const;
  double poisson_ratio() const { return material.lambda / (2 * (material.lambda + material.mu)); }
  double mass(std::size_t i) const { return material.density * thickness * particles.area[i]; }
};

/// Throws BadInput when a particle has too few neighbours, or when the material has no law of a layer. `name` of the body is for messages.
template <int D>
ShellLayer<D> make_shell_layer(const std::string& name, ShellParticles<D> particles, const Material& material, double thickness);

}  // namespace tern::structure
