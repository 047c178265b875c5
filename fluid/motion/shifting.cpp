// Particle shifting against clumps and voids (Lind et al. 2012), with the part normal to a free surface left out
// (optimised shifting, Khayyer et al. 2017):
//   dr_i = min(10 C_s g_i dt, 1/2) (1e-3 dx e_i - h^2 grad C_i),   grad C_i = sum V_j (1 + 0.2 (w_ij/w(dx))^4) grad w_ij,
//   du_i = 1/2 L_i dr_i
// g is the rate of strain. What takes particles out of their order is strain, and nothing else: particles that rest, move or turn
// together are left where they are. With the largest speed of the scene in the place of h g, the particles beside a body that swings in
// calm water would creep to and fro between the places where the shifting and the pressure want them. The pressure of deep water on
// particles out of place is a load, and one that follows the motion with a delay takes its energy.
//
// A disturbance of the lattice decays by up to 3.9 dr/(h^2 grad C) in a window (2D; 3.4 in 3D), so that 1/2 is the most which does not
// make one grow.
//
// e_i, parts between -1 and 1 that look like chance, makes every flow a little uneven. On the line towards a stagnation point of an exactly
// symmetric flow particles close in on each other, and have to leave the line in turn to its two sides. By symmetry none would, but for
// rounding: whether pairs meet would depend on that. A particle of the line that is off it moves on by a factor of 1.1 to 5.5 in a window
// as the lattice is compressed from dx to 0.45 dx (bench/shift_growth.py), and by exp(0.69/a) until then, with the strain
// a of a window. 1e-3 dx become a third of dx where a is up to 0.12. Nothing is shifted that way where nothing strains.
//
// A particle that keeps its velocity carries it to where another one belongs: shifts without a direction spread the velocity as a
// viscosity does, and the field loses |L dr|^2 a shift. With the whole of L dr the field gains as much, because the curvature is left
// out. With half of it the smooth field keeps its energy. Particles with the symmetric pressure gradient keep their velocity, because
// there momentum is conserved pair by pair.
//
// The term with 0.2 keeps pairs apart. The hidden side has no such term, so that beside faces it is left out: it would push an orderly
// lattice against them for ever.
//
// And off faces: the displacement of a face of the structure differs a little from dt times the velocity that was sent, and a wall that
// turns moves in a straight line within a window. A particle beside such a face would creep up to it and through it. Where a lattice is
// cut by a curved or oblique wall, some particles also start nearer to it than any may come later.

#include "fluid/motion/shifting.hpp"

#include <algorithm>
#include <cstdint>

#include "base/parallel.hpp"
#include "sph/contact.hpp"

namespace tern::fluid {
namespace {

constexpr double rate_over_strain = 10;                                   ///< at C_s = 1
constexpr double stable_share = 0.5;                                      ///< of h^2 grad C in a window
constexpr double unevenness = 1e-3;                                       ///< in dx, of the places that the shifting aims at
constexpr double largest_shift = 0.1, largest_shift_at_structure = 0.05;  ///< in dx
constexpr double regained = 0.1;                                          ///< of the contact distance, that a particle has lost, per window

/// Takes out the part of `shift` that points into a face nearer than `distance`.
template <int D>
void keep_off_faces(const Faces<D>& faces, const FaceRows& rows, std::ptrdiff_t i, const Vector<D>& x, double distance, Vector<D>& shift) {
  if (rows.height[i] > distance) return;
  for (int entry = rows.begin[i]; entry < rows.begin[i] + rows.count[i]; ++entry) {
    const int k = rows.face[entry];
    if (!touches<D>(faces.position[k], faces.normal[k], faces.area[k], x, distance)) continue;
    const double into = shift.dot(faces.normal[k]);
    if (into < 0) shift -= into * faces.normal[k];
  }
}

/// Way back to the contact distance of the faces [m].
template <int D>
Vector<D> off_faces(const Faces<D>& faces, const FaceRows& rows, std::ptrdiff_t i, const Vector<D>& x, double distance) {
  Vector<D> way = Vector<D>::Zero();
  if (rows.height[i] > distance) return way;
  for (int entry = rows.begin[i]; entry < rows.begin[i] + rows.count[i]; ++entry) {
    const int k = rows.face[entry];
    if (!touches<D>(faces.position[k], faces.normal[k], faces.area[k], x, distance)) continue;
    const double lost = distance - (x - faces.position[k]).dot(faces.normal[k]) - way.dot(faces.normal[k]) / regained;
    if (lost > 0) way += regained * lost * faces.normal[k];
  }
  return way;
}

/// A vector with parts from -size to size that look like chance, always the same for a label.
template <int D>
Vector<D> place_of_its_own(std::uint32_t label, double size) {
  Vector<D> result;
  for (int c = 0; c < D; ++c) {
    std::uint64_t bits = (std::uint64_t{label} * D + c + 1) * 0x9e3779b97f4a7c15;
    bits = (bits ^ bits >> 32) * 0xd6e8feb86659fd93;
    result[c] = size * (0x1p-31 * static_cast<double>(bits >> 32) - 1);
  }
  return result;
}

}  // namespace

template <int D>
void move_off_faces(const Constants<D>& constants, const Boundary<D>& boundary, const std::vector<Vector<D>>& predicted_position,
                    std::vector<Vector<D>>& position) {
  const double contact = constants.numerics.contact_distance * constants.spacing;
  if (contact == 0) return;
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(position.size());
  parallel_for(n, [&](std::ptrdiff_t i) {
    if (boundary.sees_wall(i)) position[i] += off_faces<D>(boundary.seen_walls(), boundary.wall_rows, i, predicted_position[i], contact);
    if (!boundary.sees_structure(i)) return;
    Vector<D> way = off_faces<D>(boundary.surface, boundary.surface_rows, i, predicted_position[i], contact);
    keep_off_faces<D>(boundary.seen_walls(), boundary.wall_rows, i, predicted_position[i], contact, way);
    position[i] += way;
  });
}

template <int D>
void shift_particles(const Constants<D>& constants, double duration, const Neighbours<D>& neighbours, const Boundary<D>& boundary,
                     const Corrections<D>& correction, const std::vector<ParticleClass>& particle_class, const PackedVelocities<D>& packed,
                     const std::vector<std::uint32_t>& label, const std::vector<Vector<D>>& predicted_position,
                     std::vector<Vector<D>>& position, std::vector<Vector<D>>& velocity) {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(position.size());
  const double h2 = constants.kernel.smoothing_length() * constants.kernel.smoothing_length();
  const double beside = unevenness * constants.spacing;
  const double time = rate_over_strain * constants.numerics.shifting * duration;
  parallel_for(n, [&](std::ptrdiff_t i) {
    if (!particle_class[i].interior() || !particle_class[i].has(ParticleClass::corrected_gradient)) return;
    const Vector<D> hidden = boundary.sums.faces_gradient(i) + boundary.sums.back_facing_gradient[i];
    const Vector<D>& own = boundary.sees_face(i) ? neighbours.kernel_gradient[i] : neighbours.concentration_gradient[i];
    const double share = std::min(time * packed.strain_rate[i], stable_share);
    Vector<D> shift = share * (place_of_its_own<D>(label[i], beside) - h2 * (own + hidden));
    if (particle_class[i].has(ParticleClass::beside_surface)) {
      const Vector<D> outward = correction.matrix[i] * (neighbours.kernel_gradient[i] + hidden);
      const double size2 = outward.squaredNorm();
      if (size2 > 0) shift -= shift.dot(outward) / size2 * outward;
    }
    const bool at_structure = boundary.sees_structure(i);
    const double limit = (at_structure ? largest_shift_at_structure : largest_shift) * constants.spacing;
    const double size = shift.norm();
    if (size > limit) shift *= limit / size;
    keep_off_faces<D>(boundary.seen_walls(), boundary.wall_rows, i, predicted_position[i], 0.5 * constants.spacing, shift);
    if (at_structure) keep_off_faces<D>(boundary.surface, boundary.surface_rows, i, predicted_position[i], 0.5 * constants.spacing, shift);
    position[i] += shift;
    if (particle_class[i].has(ParticleClass::symmetric_gradient)) return;  // no other term changes the sum of the momenta here
    for (int a = 0; a < D; ++a) velocity[i][a] += packed.half_stretch[a][i] * shift[a];
    for_axis_pairs<D>([&](int a, int b, int place) {
      velocity[i][a] += 0.5 * (packed.shear[place][i] + packed.spin[place][i]) * shift[b];
      velocity[i][b] += 0.5 * (packed.shear[place][i] - packed.spin[place][i]) * shift[a];
    });
  });
}

template void move_off_faces<2>(const Constants<2>&, const Boundary<2>&, const std::vector<Vector<2>>&, std::vector<Vector<2>>&);
template void move_off_faces<3>(const Constants<3>&, const Boundary<3>&, const std::vector<Vector<3>>&, std::vector<Vector<3>>&);
template void shift_particles<2>(const Constants<2>&, double, const Neighbours<2>&, const Boundary<2>&, const Corrections<2>&,
                                 const std::vector<ParticleClass>&, const PackedVelocities<2>&, const std::vector<std::uint32_t>&,
                                 const std::vector<Vector<2>>&, std::vector<Vector<2>>&, std::vector<Vector<2>>&);
template void shift_particles<3>(const Constants<3>&, double, const Neighbours<3>&, const Boundary<3>&, const Corrections<3>&,
                                 const std::vector<ParticleClass>&, const PackedVelocities<3>&, const std::vector<std::uint32_t>&,
                                 const std::vector<Vector<3>>&, std::vector<Vector<3>>&, std::vector<Vector<3>>&);

}  // namespace tern::fluid
