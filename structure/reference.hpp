#pragma once
// The reference configuration: everything that never changes after the start.
//
// A clamp is a rigid region of a body. Of the particles in it, those beside free ones are moved onto the face of the
// region (half a spacing towards the free side) and become its face particles: they carry the prescribed motion, have no
// volume, and are all that the free particles see of the clamp. A displacement field has a kink at the face; a sum that
// reached across it into the clamp would smear the kink and hold the body 0.8 spacings too deep.
//
// Particles live in rows of structure-of-arrays storage. Each lattice line of a body (along its longest side) occupies
// consecutive rows and starts at a multiple of four, so that four consecutive rows (a block) share their neighbour
// offsets and every neighbour access is one load of four consecutive values. Rows without a particle (line ends, and the
// margins before the first and after the last block) have no mass, no motion and zero weight in every sum. At least three
// of them separate two lines, so that four consecutive rows never reach from the end of one line into the next.

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/lanes.hpp"
#include "base/vector.hpp"
#include "scene/case_file.hpp"
#include "scene/rigid_motion.hpp"
#include "structure/gradient_vectors.hpp"
#include "structure/material/registry.hpp"
#include "structure/shell/shell_layer.hpp"
#include "structure/unseen_fields.hpp"

namespace tern::structure {

inline constexpr int margin_rows = lane_count;

/// One neighbour of each row of a block. Zero weights where a lane has no such neighbour.
template <int D>
struct Neighbour {
  Lanes gradient[D];                                ///< V_j g_ij [1/m]
  Lanes mirror_gradient[D];                         ///< V_i V_j g_ji [m^(D-1)]
  Lanes curvature[curvature_components<D>];         ///< V_j k_ij [1/m^2]
  Lanes mirror_curvature[curvature_components<D>];  ///< V_i V_j k_ji [m^(D-2)]
};

/// The same neighbour as the other end of a pair force. The force is computed once, from the first row of the pair.
template <int D>
struct Pair {
  Lanes half_offset[D];  ///< (X_j - X_i)/2 [m]
  Lanes diffusion;       ///< chi rho_0 V_i V_j |w'_ij|
};

/// The neighbourhood of a block; blocks with the same neighbourhood share one. Entries are in the order of their rows.
template <int D>
struct Stencil {
  std::uint32_t first = 0, count = 0;                 ///< range of Reference::neighbours, pairs, row_offset and pair_slot
  std::uint32_t later = 0;                            ///< the first of those in later rows
  std::uint32_t first_unseen = 0, unseen = 0;         ///< range of Reference::unseen
  Lanes gradient_sum[D] = {};                         ///< V_i sum_j V_j g_ij
  Lanes curvature_sum[curvature_components<D>] = {};  ///< V_i sum_j V_j k_ij
};

struct Block {
  std::int32_t row = 0;
  std::uint32_t stencil = 0;
  std::uint32_t body = 0;
  bool deforms = false;   ///< some row of it is free or on the face of a clamp
  bool has_face = false;  ///< some row of it is on the face of a clamp
};

struct Body {
  std::string name;
  Shape shape;
  std::vector<Shape> clamps;  ///< without the hinges of a shell
  Material material;
  double spacing = 0;                ///< dx_s [m]
  double smoothing_length = 0;       ///< h_0 [m]
  double cell_volume = 0;            ///< dx_s^D [m^D]
  double mass_damping = 0;           ///< [1/s]
  double stable_step_at_rest = 0;    ///< of explicit steps (stable_step.hpp) [s]
  bool is_held = false;              ///< by a clamp or a hinge, some of it
  std::int32_t shell = -1;           ///< index of Reference::shells; of a solid -1
  std::size_t first = 0, count = 0;  ///< range of Reference::particle_row
};

/// A named clamp: who is in it and how it moves.
struct Clamp {
  std::string name;
  std::uint32_t body = 0;
  std::optional<RigidMotion> motion;
  std::vector<std::int32_t> row;  ///< of its particles
};

/// A body that is a shell; its particles are rows one after the other, in the order of its layer.
template <int D>
struct ShellBody {
  ShellLayer<D> layer;
  std::uint32_t body = 0;
  std::size_t index = 0;  ///< of it in Reference::shells and Workspace::shells
  std::int32_t first_row = 0;
  std::ptrdiff_t first_block = 0;  ///< in Reference::blocks
  double viscous_time = 0;         ///< stress per stress rate, beta of shell_viscous_stress() [s]
};

template <int D>
struct Reference {
  std::vector<Body> bodies;
  std::vector<std::int32_t> particle_row;  ///< row of each particle, in the order of the bodies and their lattices
  std::vector<std::uint32_t> particle_body;
  std::size_t rows = 0;                         ///< length of every row array, margins included
  std::array<std::vector<double>, D> position;  ///< X [m]
  std::vector<double> mass;                     ///< [kg/m^(3-D)], 0 in rows without particle
  std::vector<double> inverse_mass;             ///< 0 where clamped or without particle
  std::vector<double> volume;                   ///< V [m^D], 0 where clamped or without particle
  std::vector<Block> blocks;
  std::vector<Stencil<D>> stencils;
  std::vector<Neighbour<D>> neighbours;
  std::vector<Pair<D>> pairs;
  std::vector<std::int32_t> row_offset;  ///< first row of the neighbours minus first row of the block
  std::vector<std::int32_t> pair_slot;   ///< which array of Workspace::pair_force the pair is in: one per lattice offset
  std::int32_t pair_slots = 0;
  std::vector<UnseenField<D>> unseen;  ///< what neighbours do not say of second derivatives, of all stencils
  std::vector<Clamp> clamps;
  std::vector<ShellBody<D>> shells;
  bool has_diffusion = false, has_damping = false;

  /// The shell that the body is; null when it is a solid.
  const ShellBody<D>* shell_of(const Body& body) const { return body.shell < 0 ? nullptr : &shells[body.shell]; }

  Vector<D> position_of(std::int32_t row) const {
    Vector<D> x;
    for (int a = 0; a < D; ++a) x[a] = position[a][row];
    return x;
  }
};

/// work(n, block, stencil) for every block that deforms, n its index, in parallel as for_each_block().
template <int D, class Work>
inline void for_each_deforming_block(const Reference<D>& reference, const Work& work) {
  for_each_block(static_cast<std::ptrdiff_t>(reference.blocks.size()), [&](std::ptrdiff_t n) {
    const Block& block = reference.blocks[n];
    if (block.deforms) work(n, block, reference.stencils[block.stencil]);
  });
}

/// Throws BadInput when a body or a named clamp holds no particle, or a particle has too few neighbours to carry a gradient.
template <int D>
Reference<D> build_reference(const StructureCase& structure);

}  // namespace tern::structure
