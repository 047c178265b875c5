// Fills the bodies with lattice particles, numbers their rows, and collects the neighbourhoods. Neighbour lists are built
// per body: bodies never see each other, across a slit neither.

#include "structure/reference.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_map>

#include "base/error.hpp"
#include "scene/geometry.hpp"
#include "scene/mid_surface.hpp"
#include "sph/kernel.hpp"
#include "structure/face_balance.hpp"
#include "structure/gradient_vectors.hpp"
#include "structure/lattice.hpp"
#include "structure/shell/shell_body.hpp"

namespace tern::structure {
namespace {

/// Cells of the particles, counted from the lowest one along each axis of the lattice; sets its size.
template <int D>
std::vector<Cell<D>> cells_of(const std::vector<Vector<D>>& points, double spacing, Lattice<D>& lattice) {
  const auto along = [&](const Vector<D>& x) { return Vector<D>(lattice.axes.transpose() * x); };
  Vector<D> lowest = along(points.front());
  for (const auto& x : points) lowest = lowest.cwiseMin(along(x));
  std::vector<Cell<D>> cells(points.size());
  lattice.size.fill(0);
  for (std::size_t n = 0; n < points.size(); ++n) {
    const Vector<D> x = along(points[n]);
    for (int a = 0; a < D; ++a) {
      cells[n][a] = static_cast<int>(std::lround((x[a] - lowest[a]) / spacing));
      lattice.size[a] = std::max(lattice.size[a], cells[n][a] + 1);
    }
  }
  return cells;
}

/// Gives the cells rows from `next_row` on, line by line along the longest side. Returns the first row not used.
template <int D>
std::int32_t number_rows(const std::vector<Cell<D>>& cells, std::int32_t next_row, Lattice<D>& lattice) {
  const int fast = lattice.line_direction();
  const auto line_of = [&](Cell<D> cell) {
    cell[fast] = 0;
    std::reverse(cell.begin(), cell.end());
    return cell;
  };
  std::map<Cell<D>, std::pair<int, int>> lines;  // first and last cell of each line
  for (const auto& cell : cells) {
    auto [line, is_new] = lines.try_emplace(line_of(cell), cell[fast], cell[fast]);
    line->second.first = std::min(line->second.first, cell[fast]);
    line->second.second = std::max(line->second.second, cell[fast]);
  }
  std::map<Cell<D>, std::int32_t> row_of_cell_zero;
  for (const auto& [line, range] : lines) {
    const int first = range.first - range.first % lane_count;
    const int separated = range.second + lane_count - 1;
    const int last = separated - separated % lane_count + lane_count;
    row_of_cell_zero[line] = next_row - first;
    next_row += last - first;
  }
  std::ptrdiff_t volume = 1;
  for (int n : lattice.size) volume *= n;
  lattice.row.assign(volume, no_row);
  for (const auto& cell : cells) lattice.row[lattice.index(cell)] = row_of_cell_zero[line_of(cell)] + cell[fast];
  return next_row;
}

/// Decides what free particles see of the clamped ones: those with a free cell beside them (across a face of the cell or,
/// where there is none, an edge or a corner) are shifted towards it.
template <int D>
void place_faces(const std::vector<Cell<D>>& cells, const Reference<D>& reference, Lattice<D>& lattice) {
  const auto beside = offsets_within<D>(std::sqrt(D) + 1e-6);
  const auto is_free = [&](const Cell<D>& cell) {
    const auto n = lattice.index(cell);
    return n >= 0 && lattice.row[n] != no_row && reference.inverse_mass[lattice.row[n]] > 0;
  };
  lattice.content.assign(lattice.row.size(), hidden);
  for (const auto& cell : cells) {
    Content& content = lattice.content[lattice.index(cell)];
    if (is_free(cell)) {
      content = free_particle;
      continue;
    }
    Cell<D> towards{};
    bool found = false;
    for (int order = 1; order <= D && !found; ++order)
      for (const auto& offset : beside) {
        int squared = 0;
        for (int a = 0; a < D; ++a) squared += offset[a] * offset[a];
        if (squared != order || !is_free(shifted<D>(cell, offset))) continue;
        found = true;
        for (int a = 0; a < D; ++a) towards[a] += offset[a];
      }
    if (!found) continue;
    int code = 0;
    for (int a = D - 1; a >= 0; --a) code = 3 * code + 1 + (towards[a] > 0) - (towards[a] < 0);
    content = static_cast<Content>(face + code);
  }
}

/// Every neighbourhood that occurs.
template <int D>
std::vector<Neighbourhood<D>> neighbourhoods_of(const std::vector<Cell<D>>& cells, const std::vector<Cell<D>>& offsets, const Body& body,
                                                Lattice<D>& lattice) {
  std::map<std::vector<Content>, std::uint32_t> known;
  std::vector<Neighbourhood<D>> neighbourhoods;
  lattice.pattern.assign(lattice.row.size(), 0);
  for (const auto& cell : cells) {
    const Content own = lattice.content_of(cell);
    if (own == hidden) continue;
    std::vector<Content> contents{own};
    std::vector<Vector<D>> relative;
    for (const auto& offset : offsets) {
      contents.push_back(lattice.content_of(shifted<D>(cell, offset)));
      if (contents.back() != hidden) relative.push_back(offset_between<D>(lattice, cell, offset, body.spacing));
    }
    const auto [entry, is_new] = known.try_emplace(contents, static_cast<std::uint32_t>(neighbourhoods.size()));
    lattice.pattern[lattice.index(cell)] = entry->second;
    if (!is_new) continue;
    const DerivativeFit<D> fit = derivative_fit<D>(relative, std::pow(body.spacing, D), body.smoothing_length);
    if (fit.vectors.empty() && own == free_particle)
      throw BadInput(
          fmt::format("Body '{}': a particle has {} neighbours within {:.3g} m, which do not span {} dimensions, so no strain can be "
                      "computed there; make the spacing ({:.3g} m) at most half of the smallest thickness (a quarter is recommended).",
                      body.name, relative.size(), 2 * body.smoothing_length, D, body.spacing));
    Neighbourhood<D>& neighbourhood = neighbourhoods.emplace_back();
    neighbourhood.derivatives.resize(offsets.size());
    if (fit.vectors.empty()) continue;
    for (std::size_t o = 0, n = 0; o < offsets.size(); ++o)
      if (contents[o + 1] != hidden) neighbourhood.derivatives[o] = fit.vectors[n++];
    if (own == free_particle) neighbourhood.unseen = unseen_fields<D>(fit.vanishing, body.material);
  }
  return neighbourhoods;
}

/// One neighbour of a block before it is stored.
template <int D>
struct Entry {
  Neighbour<D> neighbour = {};
  Pair<D> pair = {};
  std::int64_t slot = 0;
};

/// Adds those of one of the four particles.
template <int D>
void add_unseen(const std::vector<UnseenField<D, double>>& of_particle, int lane, std::vector<UnseenField<D>>& fields) {
  if (fields.size() < of_particle.size()) fields.resize(of_particle.size(), UnseenField<D>{});
  for (std::size_t r = 0; r < of_particle.size(); ++r) {
    for (int b = 0; b < D; ++b) fields[r].gradient[b][lane] = of_particle[r].gradient[b];
    for (int n = 0; n < curvature_components<D>; ++n) {
      fields[r].curvature[n][lane] = of_particle[r].curvature[n];
      for (int c = 0; c < D; ++c)
        for (int m = 0; m < D; ++m) fields[r].amplitude[c][m][n][lane] = of_particle[r].amplitude[c][m][n];
    }
  }
}

/// Collects the stencils of the blocks and stores equal ones once.
template <int D>
class StencilStore {
 public:
  explicit StencilStore(Reference<D>& reference) : reference_(reference) {}

  /// `entries` by row offset.
  std::uint32_t add(const std::map<std::int32_t, Entry<D>>& entries, const Lanes (&gradient_sum)[D],
                    const Lanes (&curvature_sum)[curvature_components<D>], const std::vector<UnseenField<D>>& unseen) {
    std::string content(reinterpret_cast<const char*>(gradient_sum), sizeof gradient_sum);
    content.append(reinterpret_cast<const char*>(curvature_sum), sizeof curvature_sum);
    content.append(reinterpret_cast<const char*>(unseen.data()), unseen.size() * sizeof(UnseenField<D>));
    for (const auto& [offset, entry] : entries) {
      content.append(reinterpret_cast<const char*>(&offset), sizeof offset);
      content.append(reinterpret_cast<const char*>(&entry.slot), sizeof entry.slot);
      content.append(reinterpret_cast<const char*>(&entry.neighbour), sizeof entry.neighbour);
      content.append(reinterpret_cast<const char*>(&entry.pair), sizeof entry.pair);
    }
    const auto [found, is_new] = known_.try_emplace(std::move(content), reference_.stencils.size());
    if (is_new) {
      Stencil<D> stencil;
      std::copy_n(gradient_sum, D, stencil.gradient_sum);
      std::copy_n(curvature_sum, curvature_components<D>, stencil.curvature_sum);
      stencil.first = static_cast<std::uint32_t>(reference_.neighbours.size());
      stencil.count = static_cast<std::uint32_t>(entries.size());
      stencil.later = stencil.first;
      for (const auto& [offset, entry] : entries) {
        reference_.row_offset.push_back(offset);
        reference_.pair_slot.push_back(static_cast<std::int32_t>(entry.slot));
        reference_.neighbours.push_back(entry.neighbour);
        reference_.pairs.push_back(entry.pair);
        if (offset < 0) ++stencil.later;
      }
      stencil.first_unseen = static_cast<std::uint32_t>(reference_.unseen.size());
      stencil.unseen = static_cast<std::uint32_t>(unseen.size());
      reference_.unseen.insert(reference_.unseen.end(), unseen.begin(), unseen.end());
      reference_.stencils.push_back(stencil);
    }
    return static_cast<std::uint32_t>(found->second);
  }

 private:
  Reference<D>& reference_;
  std::unordered_map<std::string, std::size_t> known_;
};

template <int D>
void add_blocks(const std::vector<Cell<D>>& cells, const StructureNumerics& numerics, std::uint32_t body_index, std::int32_t first_row,
                std::int32_t end_row, Lattice<D>& lattice, StencilStore<D>& store, Reference<D>& reference) {
  const Body& body = reference.bodies[body_index];
  const Kernel<D> kernel(body.smoothing_length);
  const auto offsets = offsets_within<D>(kernel.support() / body.spacing);
  auto neighbourhoods = neighbourhoods_of<D>(cells, offsets, body, lattice);
  const Fit<D> fit{cells, offsets, body.spacing, lattice, neighbourhoods};
  balance_clamps(fit);
  const Vector<D> shift = body.spacing * (lattice.axes * shift_of<D>(lattice.content_of(cells.front())));
  balance_askew_faces(fit, body.shape, body.clamps, Vector<D>(reference.position_of(lattice.row[lattice.index(cells.front())]) - shift));
  const double volume = std::pow(body.spacing, D);
  reference.pair_slots = std::max(reference.pair_slots, static_cast<std::int32_t>(offsets.size() / 2));

  std::vector<const Cell<D>*> cell_of_row(end_row - first_row, nullptr);
  for (const auto& cell : cells) cell_of_row[lattice.row[lattice.index(cell)] - first_row] = &cell;

  // By where they are along their line, then line by line: what a block and its neighbours read and write is still in the
  // cache when the block beside it comes next.
  std::map<std::pair<int, std::int32_t>, Block> blocks;
  for (std::int32_t row = first_row; row < end_row; row += lane_count) {
    const auto first_cell = std::find_if(cell_of_row.begin() + (row - first_row), cell_of_row.begin() + (row - first_row + lane_count),
                                         [](const Cell<D>* cell) { return cell != nullptr; });
    if (first_cell == cell_of_row.begin() + (row - first_row + lane_count)) continue;
    Block block{row, 0, body_index};
    std::map<std::int32_t, Entry<D>> entries;
    Lanes gradient_sum[D] = {}, curvature_sum[curvature_components<D>] = {};
    std::vector<UnseenField<D>> unseen;
    for (int lane = 0; lane < lane_count; ++lane) {
      const Cell<D>* cell = cell_of_row[row - first_row + lane];
      if (cell == nullptr || lattice.content_of(*cell) == hidden) continue;
      block.deforms = true;
      const bool is_free = lattice.content_of(*cell) == free_particle;
      block.has_face |= !is_free;
      const Neighbourhood<D>& neighbourhood = neighbourhoods[lattice.pattern[lattice.index(*cell)]];
      const auto& own = neighbourhood.derivatives;
      add_unseen(neighbourhood.unseen, lane, unseen);
      for (std::size_t o = 0; o < offsets.size(); ++o) {
        const Content other = lattice.content_of(shifted<D>(*cell, offsets[o]));
        if (other == hidden) continue;
        const auto n = lattice.index(shifted<D>(*cell, offsets[o]));
        const auto& mirror = neighbourhoods[lattice.pattern[n]].derivatives[offsets.size() - 1 - o];
        Entry<D>& entry = entries[lattice.row[n] - lane - row];
        entry.slot = static_cast<std::int64_t>(std::min(o, offsets.size() - 1 - o));
        for (int a = 0; a < D; ++a) {
          entry.neighbour.gradient[a][lane] = volume * own[o].gradient[a];
          entry.neighbour.mirror_gradient[a][lane] = volume * volume * mirror.gradient[a];
          gradient_sum[a][lane] += volume * volume * own[o].gradient[a];
        }
        for (int c = 0; c < curvature_components<D>; ++c) {
          entry.neighbour.curvature[c][lane] = volume * own[o].curvature[c];
          entry.neighbour.mirror_curvature[c][lane] = volume * volume * mirror.curvature[c];
          curvature_sum[c][lane] += volume * volume * own[o].curvature[c];
        }
        const Vector<D> x = offset_between<D>(lattice, *cell, offsets[o], body.spacing);
        for (int a = 0; a < D; ++a) entry.pair.half_offset[a][lane] = 0.5 * x[a];
        if (!is_free && other != free_particle) continue;
        const double r = x.norm();
        entry.pair.diffusion[lane] = numerics.riemann_diffusion * body.material.density * volume * volume * kernel.gradient_weight(r) * r;
      }
    }
    block.stencil = store.add(entries, gradient_sum, curvature_sum, unseen);
    blocks.emplace(std::pair{(**first_cell)[lattice.line_direction()] / lane_count, row}, block);
  }
  for (const auto& [place, block] : blocks) reference.blocks.push_back(block);
}

/// The named clamps and their particles; a particle of several belongs to the first.
template <int D>
void add_clamps(const StructureCase& structure, const std::vector<Vector<D>>& points, Reference<D>& reference) {
  std::vector<bool> taken(points.size(), false);
  for (const ClampCase& input : structure.clamps) {
    Clamp clamp{input.name, 0, input.motion, {}};
    for (std::size_t b = 0; b < reference.bodies.size(); ++b)
      if (reference.bodies[b].name == input.body) clamp.body = static_cast<std::uint32_t>(b);
    for (std::size_t p = 0; p < points.size(); ++p) {
      if (reference.particle_body[p] != clamp.body || taken[p]) continue;
      const Body& body = reference.bodies[clamp.body];
      if (const ShellBody<D>* shell = reference.shell_of(body)) {  // its held particles stand on the face of the region
        constexpr double round_off = 1e-6;
        if (!shell->layer.particles.held[p - body.first]) continue;
        if (signed_distance<D>(input.region, points[p]) > round_off * body.spacing) continue;
      } else if (!contains<D>(input.region, points[p])) {
        continue;
      }
      taken[p] = true;
      clamp.row.push_back(reference.particle_row[p]);
    }
    if (clamp.row.empty())
      throw BadInput(
          fmt::format("The clamp '{}' holds no particle of body '{}'; enlarge its region to at least one spacing "
                      "({:.3g} m) of the body.",
                      clamp.name, input.body, reference.bodies[clamp.body].spacing));
    reference.clamps.push_back(std::move(clamp));
  }
}

}  // namespace

template <int D>
Reference<D> build_reference(const StructureCase& structure) {
  Reference<D> reference;
  StencilStore<D> store(reference);

  std::vector<std::vector<Cell<D>>> cells;
  std::vector<Lattice<D>> lattices(structure.bodies.size());
  std::vector<std::int32_t> first_row;
  std::int32_t next_row = margin_rows;
  std::vector<Vector<D>> points;
  for (const StructureBody& input : structure.bodies) {
    Body body{.name = input.name,
              .shape = input.shape,
              .clamps = {input.rigid_clamps().begin(), input.rigid_clamps().end()},
              .material = Material(input),
              .spacing = input.spacing,
              .smoothing_length = structure.numerics.smoothing_length_ratio * input.spacing,
              .cell_volume = std::pow(input.spacing, D),
              .mass_damping = input.mass_damping,
              .shell = input.is_shell ? static_cast<std::int32_t>(reference.shells.size()) : -1,
              .first = points.size(),
              .count = 0};
    if (input.is_shell) {
      const MidSurface<D> surface = mid_surface<D>(input);
      ShellBody<D> shell{.layer = make_shell_layer<D>(input.name, shell_particles(surface), body.material, surface.thickness),
                         .body = static_cast<std::uint32_t>(reference.bodies.size()),
                         .index = reference.shells.size(),
                         .first_row = next_row};
      const auto& positions = shell.layer.particles.position;
      body.count = positions.size();
      cells.emplace_back();
      first_row.push_back(next_row);
      for (std::size_t p = 0; p < body.count; ++p) {
        reference.particle_row.push_back(next_row + static_cast<std::int32_t>(p));
        reference.particle_body.push_back(shell.body);
      }
      next_row += (static_cast<std::int32_t>(body.count) + lane_count - 1) / lane_count * lane_count;
      points.insert(points.end(), positions.begin(), positions.end());
      reference.has_damping |= body.mass_damping > 0;
      reference.bodies.push_back(std::move(body));
      reference.shells.push_back(std::move(shell));
      continue;
    }
    const LatticePoints<D> inside = fill_body<D>(input);
    const std::vector<Vector<D>> filled(inside.begin(), inside.end());
    if (filled.empty())
      throw BadInput(
          fmt::format("Body '{}' holds no particle at spacing {:.3g} m; make the spacing at most half of its "
                      "smallest thickness.",
                      input.name, input.spacing));
    body.count = filled.size();
    Lattice<D>& lattice = lattices[reference.bodies.size()];
    lattice.axes = lattice_axes<D>(input.shape);
    cells.push_back(cells_of<D>(filled, input.spacing, lattice));
    first_row.push_back(next_row);
    next_row = number_rows<D>(cells.back(), next_row, lattice);
    for (const auto& cell : cells.back()) {
      reference.particle_row.push_back(lattice.row[lattice.index(cell)]);
      reference.particle_body.push_back(static_cast<std::uint32_t>(reference.bodies.size()));
    }
    points.insert(points.end(), filled.begin(), filled.end());
    reference.has_damping |= body.mass_damping > 0;
    reference.bodies.push_back(std::move(body));
  }
  first_row.push_back(next_row);

  reference.has_diffusion = structure.numerics.riemann_diffusion > 0;
  reference.rows = static_cast<std::size_t>(next_row) + margin_rows;
  for (auto& axis : reference.position) axis.assign(reference.rows, 0);
  for (auto* values : {&reference.mass, &reference.inverse_mass, &reference.volume}) values->assign(reference.rows, 0);
  for (std::size_t p = 0; p < points.size(); ++p) {
    const auto row = reference.particle_row[p];
    Body& body = reference.bodies[reference.particle_body[p]];
    for (int a = 0; a < D; ++a) reference.position[a][row] = points[p][a];
    if (const ShellBody<D>* shell = reference.shell_of(body)) {
      const std::size_t particle = row - shell->first_row;
      reference.mass[row] = shell->layer.mass(particle);
      const bool held = shell->layer.particles.held[particle];
      body.is_held |= held;
      if (held) continue;
      reference.inverse_mass[row] = 1 / reference.mass[row];
      reference.volume[row] = shell->layer.thickness * shell->layer.particles.area[particle];
      continue;
    }
    reference.mass[row] = body.material.density * std::pow(body.spacing, D);
    const bool clamped =
        std::any_of(body.clamps.begin(), body.clamps.end(), [&](const Shape& clamp) { return contains<D>(clamp, points[p]); });
    body.is_held |= clamped;
    if (clamped) continue;
    reference.inverse_mass[row] = 1 / reference.mass[row];
    reference.volume[row] = std::pow(body.spacing, D);
  }
  add_clamps<D>(structure, points, reference);
  for (ShellBody<D>& shell : reference.shells) {
    auto& clamp = shell.layer.particles.clamp;
    for (auto& c : clamp)
      if (c >= 0) c = static_cast<std::int32_t>(reference.clamps.size());
    for (std::size_t c = 0; c < reference.clamps.size(); ++c)
      for (const auto row : reference.clamps[c].row)
        if (reference.clamps[c].body == shell.body && clamp[row - shell.first_row] >= 0)
          clamp[row - shell.first_row] = static_cast<std::int32_t>(c);
    shell.first_block = static_cast<std::ptrdiff_t>(reference.blocks.size());
    for (std::int32_t row = shell.first_row; row < shell.first_row + static_cast<std::int32_t>(shell.layer.size()); row += lane_count)
      reference.blocks.push_back({row, 0, shell.body});
  }
  for (std::uint32_t b = 0; b < reference.bodies.size(); ++b) {
    if (cells[b].empty()) continue;  // a shell
    place_faces<D>(cells[b], reference, lattices[b]);
    for (const auto& cell : cells[b]) {
      const Vector<D> shift = reference.bodies[b].spacing * (lattices[b].axes * shift_of<D>(lattices[b].content_of(cell)));
      for (int a = 0; a < D; ++a) reference.position[a][lattices[b].row[lattices[b].index(cell)]] += shift[a];
    }
    add_blocks<D>(cells[b], structure.numerics, b, first_row[b], first_row[b + 1], lattices[b], store, reference);
  }
  return reference;
}

template Reference<2> build_reference<2>(const StructureCase&);
template Reference<3> build_reference<3>(const StructureCase&);

}  // namespace tern::structure
