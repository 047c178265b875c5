// Least squares in the tangent plane. The offsets are measured in spacings, so that the weights are those of a square lattice.

#include "structure/shell/shell_layer.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "base/error.hpp"
#include "sph/kernel.hpp"
#include "sph/symmetric_matrix.hpp"
#include "structure/shell/shell_force.hpp"

namespace tern::structure {
namespace {

constexpr double smoothing_ratio = 1.1;  // h over spacing, on a lattice
constexpr double most_smoothing = 2;     // h over spacing, of a particle in a sharp corner

template <int D>
using Offset = Eigen::Matrix<double, shell_slopes<D>, 1>;  ///< xi_a over the spacing along a

template <int D>
Offset<D> offset_between(const ShellParticles<D>& particles, std::size_t i, std::size_t j) {
  Offset<D> offset;
  for (int a = 0; a < D - 1; ++a)
    offset[a] = (particles.position[j] - particles.position[i]).dot(particles.frame[i].col(a)) / particles.spacing[a];
  return offset;
}

/// Squared distance in spacings as i sees it; the height over the tangent plane counts in the smallest spacing.
template <int D>
double squared_distance(const ShellParticles<D>& particles, std::size_t i, std::size_t j) {
  const double height = (particles.position[j] - particles.position[i]).dot(particles.frame[i].col(D - 1)) /
                        *std::min_element(particles.spacing.begin(), particles.spacing.end());
  return offset_between(particles, i, j).squaredNorm() + height * height;
}

/// Particles beside i, by their cells: what lies over another part of the layer is none. In ascending order.
template <int D>
std::vector<std::uint32_t> cells_beside(const ShellParticles<D>& particles, std::size_t i) {
  constexpr int reach = 3;  // cells; 2.2 spacings round a circle of ten reach into the third
  std::vector<std::uint32_t> beside;
  if (!particles.beside.empty()) return particles.beside[i];
  if (!particles.in_rows) {  // nothing lies over another part of a ball
    for (std::size_t j = 0; j < particles.position.size(); ++j)
      if (j != i) beside.push_back(static_cast<std::uint32_t>(j));
    return beside;
  }
  std::array<int, 2> size{1, 1}, at{static_cast<int>(i), 0}, low{0, 0}, high{0, 0};
  for (int a = 0; a < D - 1; ++a) size[a] = particles.size[a];
  at = {static_cast<int>(i) % size[0], static_cast<int>(i) / size[0]};
  for (int a = 0; a < D - 1; ++a) {
    low[a] = particles.closed[a] ? at[a] - reach : std::max(0, at[a] - reach);
    high[a] = particles.closed[a] ? at[a] + reach : std::min(size[a] - 1, at[a] + reach);
  }
  if (D == 2) low[1] = high[1] = 0;
  for (int b = low[1]; b <= high[1]; ++b)
    for (int a = low[0]; a <= high[0]; ++a) {
      const int j = (a + size[0]) % size[0] + size[0] * ((b + size[1]) % size[1]);
      if (j != static_cast<int>(i)) beside.push_back(static_cast<std::uint32_t>(j));
    }
  std::sort(beside.begin(), beside.end());
  beside.erase(std::unique(beside.begin(), beside.end()), beside.end());
  return beside;
}

/// Weights of the first `slopes` and of all second derivatives in spacings, one column per offset, by the terms xi_a (if slopes > 0)
/// and xi_a xi_b/2 (a <= b; xi_0 xi_1 whole). Empty when the offsets do not determine them.
template <int D>
Eigen::MatrixXd fit(const std::vector<Offset<D>>& offsets, bool with_slopes, double smoothing) {
  const int slopes = with_slopes ? shell_slopes<D> : 0, terms = slopes + shell_unknowns<D> - shell_slopes<D>;
  const Kernel<2> kernel(smoothing);
  Eigen::MatrixXd basis(terms, offsets.size());
  Eigen::VectorXd weight(offsets.size());
  for (std::size_t n = 0; n < offsets.size(); ++n) {
    const auto& xi = offsets[n];
    int m = 0;
    for (int a = 0; a < slopes; ++a) basis(m++, n) = xi[a];
    for (int a = 0; a < D - 1; ++a)
      for (int b = a; b < D - 1; ++b) basis(m++, n) = (a == b ? 0.5 : 1) * xi[a] * xi[b];
    weight[n] = kernel.value(xi.norm());
  }
  const Eigen::MatrixXd weighted = basis * weight.asDiagonal();
  const Eigen::MatrixXd inverse = inverse_of_moments(weighted * basis.transpose());
  if (inverse.size() == 0) return {};
  return inverse * weighted;
}

/// Smoothing length in spacings of a particle of a plate. Beside an edge that runs across the lattice the particles within the usual
/// reach may hardly determine the fit. It grows until no derivative takes more from the noise of the positions than in the corner of a
/// lattice: the slope there is (-3 x_0 + 4 x_1 - x_2)/2, whose squared weights sum to 6.5.
template <int D>
double smoothing_of(const ShellParticles<D>& particles, std::size_t i) {
  constexpr double of_corner = 6.5 * (1 + 1e-6), step = 0.1;
  for (double smoothing = smoothing_ratio; smoothing < most_smoothing; smoothing += step) {
    std::vector<Offset<D>> offsets;
    for (const std::uint32_t j : cells_beside(particles, i))
      if (squared_distance(particles, i, j) < 4 * smoothing * smoothing * (1 - 1e-9)) offsets.push_back(offset_between(particles, i, j));
    const auto is_quiet = [&](const Eigen::MatrixXd& weights) {
      if (weights.size() == 0) return false;
      for (Eigen::Index row = 0; row < weights.rows(); ++row)
        if (weights.row(row).squaredNorm() + std::pow(weights.row(row).sum(), 2) > of_corner) return false;
      return true;
    };
    if (is_quiet(fit<D>(offsets, true, smoothing)) && (particles.clamp[i] < 0 || is_quiet(fit<D>(offsets, false, smoothing))))
      return smoothing;
  }
  return most_smoothing;
}

}  // namespace

template <int D>
ShellParticles<D> shell_particles(const MidSurface<D>& surface) {
  ShellParticles<D> particles;
  for (int a = 0; a < D - 1; ++a) {
    particles.spacing[a] = surface.spacing(a);
    particles.size[a] = surface.count[a] + surface.held_ends(a);
  }
  particles.closed = surface.closed;
  particles.in_rows = is_in_rows(surface);
  for (const SurfaceCell<D>& cell : cells_of(surface)) {
    particles.position.push_back(cell.place.position);
    particles.frame.push_back(cell.place.frame);
    particles.area.push_back(cell.area);
    particles.held.push_back(cell.edge != EdgeKind::free);
    particles.clamp.push_back(cell.edge == EdgeKind::clamp ? 0 : -1);
  }
  if constexpr (D == 3)
    if (surface.kind == MidSurface<D>::Kind::plate) {
      std::vector<Vector<2>> places;
      for (const Vector<D>& x : particles.position) {
        const Vector<D> from = x - surface.origin;
        places.emplace_back(surface.axes.col(0).dot(from), surface.axes.col(1).dot(from));
      }
      particles.beside = points_beside(surface.outline, places, 2 * most_smoothing * std::max(surface.spacing(0), surface.spacing(1)));
    }
  return particles;
}

template <int D>
double ShellLayer<D>::modulus() const {
  const double nu = poisson_ratio();
  return D == 2 && material.plane_stress ? material.young_modulus : material.young_modulus / (1 - nu * nu);
}

template <int D>
ShellLayer<D> make_shell_layer(const std::string& name, ShellParticles<D> particles, const Material& material, double thickness) {
  if (!material.has_law_of_a_layer())
    throw BadInput(
        fmt::format("Body '{}': a shell of the material {} is not built; use neo_hookean or st_venant_kirchhoff, or model it as "
                    "a solid.",
                    name, material.name()));
  ShellLayer<D> layer{std::move(particles), material, thickness, {}, {}, {}, {}, {}, {}, {}, {}, {}, {}};
  const ShellParticles<D>& p = layer.particles;
  const std::size_t count = p.position.size();
  for (int a = 0; a < D - 1; ++a) layer.cell_squared[a] = std::pow(std::min(p.spacing[a], thickness), 2) / 12;
  layer.clamp_slope.resize(count);
  layer.reference.resize(count);
  layer.first.push_back(0);
  std::vector<double> smoothing(count, smoothing_ratio);
  for (std::size_t i = 0; i < count && !p.beside.empty(); ++i) smoothing[i] = smoothing_of(p, i);
  for (std::size_t i = 0; i < count; ++i) {
    std::vector<Offset<D>> offsets;
    for (const std::uint32_t j : cells_beside(p, i)) {
      const double reach = 2 * std::max(smoothing[i], smoothing[j]);
      if (0.5 * (squared_distance(p, i, j) + squared_distance(p, j, i)) >= reach * reach * (1 - 1e-9)) continue;
      layer.neighbour.push_back(j);
      offsets.push_back(offset_between(p, i, j));
    }
    layer.first.push_back(static_cast<std::uint32_t>(layer.neighbour.size()));
    Eigen::MatrixXd weights = fit<D>(offsets, true, smoothing[i]);
    const Eigen::MatrixXd held = p.clamp[i] >= 0 ? fit<D>(offsets, false, smoothing[i]) : Eigen::MatrixXd();
    if (weights.size() == 0 || (p.clamp[i] >= 0 && held.size() == 0))
      throw BadInput(
          fmt::format("Body '{}': a particle of the shell has {} neighbours within {:.3g} spacings, which do not determine its "
                      "curvature; make the spacing at most a third of its shortest side.",
                      name, offsets.size(), 2 * smoothing[i]));
    if (p.clamp[i] >= 0) weights.bottomRows(held.rows()) = held;
    Eigen::Matrix<double, shell_unknowns<D>, 1> scale;
    for (int a = 0; a < D - 1; ++a) {
      scale[a] = 1 / p.spacing[a];
      for (int b = a; b < D - 1; ++b) scale[second_derivative<D>(a, b)] = 1 / (p.spacing[a] * p.spacing[b]);
    }
    layer.reference[i].setZero();
    layer.clamp_slope[i].setZero();
    for (std::size_t n = 0; n < offsets.size(); ++n) {
      layer.weight.push_back(scale.cwiseProduct(weights.col(n)));
      const auto& w = layer.weight.back();
      layer.reference[i] += (p.position[layer.neighbour[layer.first[i] + n]] - p.position[i]) * w.transpose();
      if (p.clamp[i] < 0) continue;
      for (int c = 0; c < D - 1; ++c)
        layer.clamp_slope[i].col(c) += w.template tail<shell_unknowns<D> - shell_slopes<D>>() * offsets[n][c] * p.spacing[c];
    }
    for (int c = 0; c < D - 1 && p.clamp[i] >= 0; ++c)
      layer.reference[i].template rightCols<shell_unknowns<D> - shell_slopes<D>>() -=
          p.frame[i].col(c) * layer.clamp_slope[i].col(c).transpose();
  }
  layer.mirror.resize(layer.neighbour.size());
  for (std::size_t i = 0; i < count; ++i)
    for (auto n = layer.first[i]; n < layer.first[i + 1]; ++n) {
      const auto j = layer.neighbour[n];
      const auto begin = layer.neighbour.begin() + layer.first[j], end = layer.neighbour.begin() + layer.first[j + 1];
      layer.mirror[n] = static_cast<std::uint32_t>(std::lower_bound(begin, end, i) - layer.neighbour.begin());
    }
  layer.weight_sum.assign(count, ShellLayer<D>::Weights::Zero());
  for (std::size_t i = 0; i < count; ++i)
    for (auto n = layer.first[i]; n < layer.first[i + 1]; ++n) {
      layer.weight_sum[i] += p.area[i] * layer.weight[n];
      layer.mirror_weight.push_back(-p.area[layer.neighbour[n]] * layer.weight[layer.mirror[n]]);
    }
  if constexpr (D == 3)
    for (std::size_t i = 0; i < count; ++i) layer.rest.push_back(shell_rest(layer, i));
  return layer;
}

template ShellParticles<2> shell_particles<2>(const MidSurface<2>&);
template ShellParticles<3> shell_particles<3>(const MidSurface<3>&);
template struct ShellLayer<2>;
template struct ShellLayer<3>;
template ShellLayer<2> make_shell_layer<2>(const std::string&, ShellParticles<2>, const Material&, double);
template ShellLayer<3> make_shell_layer<3>(const std::string&, ShellParticles<3>, const Material&, double);

}  // namespace tern::structure
