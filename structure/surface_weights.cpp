#include "structure/surface_weights.hpp"

#include <algorithm>

#include "structure/least_squares.hpp"

namespace tern::structure {
namespace {

constexpr int line_length = 6;  ///< particles of a line at most: b_j is 0 two supports away from the faces

template <int D>
class Neighbourhoods {
 public:
  explicit Neighbourhoods(const Reference<D>& reference) : reference_(reference), block_(reference.rows) {
    for (std::uint32_t n = 0; n < reference.blocks.size(); ++n) std::fill_n(block_.begin() + reference.blocks[n].row, lane_count, n);
  }

  /// visit(row of j, V_j g_ij) for all j around the particle i in the row.
  template <class Visit>
  void for_each(std::int32_t row, const Visit& visit) const {
    const Block& block = reference_.blocks[block_[row]];
    const Stencil<D>& stencil = reference_.stencils[block.stencil];
    const int lane = row - block.row;
    for (std::uint32_t n = stencil.first; n < stencil.first + stencil.count; ++n) {
      Vector<D> gradient;
      for (int a = 0; a < D; ++a) gradient[a] = reference_.neighbours[n].gradient[a][lane];
      if (gradient != Vector<D>::Zero()) visit(row + reference_.row_offset[n], gradient);
    }
  }

  /// The row that is `step` away; -1 when there is none.
  std::int32_t at(std::int32_t row, const Vector<D>& step) const {
    std::int32_t found = -1;
    for_each(row, [&](std::int32_t other, const Vector<D>&) {
      if ((reference_.position_of(other) - reference_.position_of(row) - step).norm() < 1e-3 * step.norm()) found = other;
    });
    return found;
  }

  /// The line of particles that goes inwards from the one in the row, behind a face with this normal and this far from it; none where the
  /// lattice does not lie flush with the face.
  std::vector<std::int32_t> line(std::int32_t row, const Vector<D>& normal, const Vector<D>& offset) const {
    Vector<D> step = Vector<D>::Zero();
    double most = 0;
    for_each(row, [&](std::int32_t other, const Vector<D>&) {
      const Vector<D> to = reference_.position_of(other) - reference_.position_of(row);
      const double straight = -to.dot(normal) / to.squaredNorm();  // greatest for the nearest that lies straight behind
      if (straight <= most || reference_.inverse_mass[other] == 0) return;
      most = straight;
      step = to;
    });
    const double spacing = step.norm();
    if (spacing == 0 || (step + spacing * normal).norm() > 1e-3 * spacing || std::abs(offset.dot(normal) - 0.5 * spacing) > 1e-3 * spacing)
      return {};
    std::vector<std::int32_t> rows = {row};
    while (rows.size() < line_length) {
      const std::int32_t next = at(rows.back(), step);
      if (next < 0 || reference_.inverse_mass[next] == 0) break;
      rows.push_back(next);
    }
    return rows;
  }

 private:
  const Reference<D>& reference_;
  std::vector<std::uint32_t> block_;  // of each row
};

/// b_j of all rows.
template <int D>
RowVectors<D> push_of_uniform_stress(const Reference<D>& reference, const Neighbourhoods<D>& neighbourhoods) {
  RowVectors<D> push;
  for (auto& axis : push) axis.assign(reference.rows, 0);
  for (std::size_t p = 0; p < reference.particle_row.size(); ++p) {
    const auto row = reference.particle_row[p];
    if (reference.volume[row] == 0 || reference.bodies[reference.particle_body[p]].shell >= 0) continue;
    neighbourhoods.for_each(row, [&](std::int32_t other, const Vector<D>& gradient) {
      for (int a = 0; a < D; ++a) {
        push[a][other] += reference.volume[row] * gradient[a];
        push[a][row] -= reference.volume[row] * gradient[a];
      }
    });
  }
  return push;
}

}  // namespace

template <int D>
SurfaceWeights surface_weights(const Reference<D>& reference, const std::vector<std::int32_t>& row, const std::vector<Vector<D>>& offset,
                               const std::vector<Vector<D>>& area) {
  const Neighbourhoods<D> neighbourhoods(reference);
  RowVectors<D> left = push_of_uniform_stress(reference, neighbourhoods);
  std::vector<std::vector<std::pair<std::int32_t, double>>> weights(row.size());
  std::vector<std::vector<std::int32_t>> line(row.size());
  std::vector<Eigen::Triplet<double>> entries;
  int unknowns = 0;
  for (std::size_t k = 0; k < row.size(); ++k) {
    if (row[k] < 0) continue;
    double own = 1;
    neighbourhoods.for_each(row[k], [&](std::int32_t other, const Vector<D>& gradient) {
      weights[k].emplace_back(other, gradient.dot(offset[k]));
      own -= weights[k].back().second;
    });
    weights[k].emplace_back(row[k], own);
    for (const auto& [j, weight] : weights[k])
      for (int a = 0; a < D; ++a) left[a][j] -= area[k][a] * weight;
    line[k] = neighbourhoods.line(row[k], area[k].normalized(), offset[k]);
    if (line[k].size() < 3) continue;
    // Along the lattice: faces that are parallel to it but for what their corners are rounded by would have columns that nearly depend on
    // each other, and take each other's load by shares without bound.
    const Vector<D> push = area[k].norm() * (reference.position_of(line[k][0]) - reference.position_of(line[k][1])).normalized();
    for (std::size_t q = 0; q + 2 < line[k].size(); ++q, ++unknowns)
      for (int m = 0; m < 3; ++m)
        for (int a = 0; a < D; ++a) entries.emplace_back(D * line[k][q + m] + a, unknowns, (m == 1 ? -2 : 1) * push[a]);
  }
  if (unknowns > 0) {
    std::vector<double> right(D * reference.rows);
    for (int a = 0; a < D; ++a)
      for (std::size_t j = 0; j < reference.rows; ++j) right[D * j + a] = reference.inverse_mass[j] > 0 ? left[a][j] : 0;
    const Eigen::VectorXd share = least_squares(entries, right, unknowns, 1e-12);
    int c = 0;
    for (std::size_t k = 0; k < row.size(); ++k)
      for (std::size_t q = 0; q + 2 < line[k].size(); ++q, ++c)
        for (int m = 0; m < 3; ++m) weights[k].emplace_back(line[k][q + m], (m == 1 ? -2 : 1) * share[c]);
  }
  SurfaceWeights result;
  for (auto& of_foot : weights) {
    std::sort(of_foot.begin(), of_foot.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    for (std::size_t n = 0; n < of_foot.size(); ++n) {
      if (n > 0 && of_foot[n].first == of_foot[n - 1].first) {
        result.weight.back() += of_foot[n].second;
        continue;
      }
      result.bearer.push_back(of_foot[n].first);
      result.weight.push_back(of_foot[n].second);
    }
    result.first.push_back(result.bearer.size());
  }
  return result;
}

template SurfaceWeights surface_weights<2>(const Reference<2>&, const std::vector<std::int32_t>&, const std::vector<Vector<2>>&,
                                           const std::vector<Vector<2>>&);
template SurfaceWeights surface_weights<3>(const Reference<3>&, const std::vector<std::int32_t>&, const std::vector<Vector<3>>&,
                                           const std::vector<Vector<3>>&);

}  // namespace tern::structure
