// Particle shifting against clumps and voids (Lind et al. 2012), with the part normal to a free surface left out
// (optimised shifting, Khayyer et al. 2017):
//   dr_i = -C_s h |u|max dt grad C_i,   grad C_i = sum V_j (1 + 0.2 (w_ij/w(dx))^4) grad w_ij
// And off the faces of the structure: these end a window elsewhere than the velocity says that the fluid has been given, a little each
// window, so that a particle beside a face that swings creeps up to it and through it.

#include "base/parallel.hpp"
#include "fluid/fluid.hpp"
#include "sph/contact.hpp"

namespace tern::fluid {
namespace {

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

/// Way back to the contact distance of the faces of the structure [m].
template <int D>
Vector<D> off_structure(const Faces<D>& faces, const FaceRows& rows, std::ptrdiff_t i, const Vector<D>& x, double distance) {
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

}  // namespace

template <int D>
void Fluid<D>::shift_particles() {
  const double contact = constants_.numerics.contact_distance * constants_.spacing;
  if (!surface_.position.empty() && contact > 0)
    for (int i : band_) {
      Vector<D> way = off_structure<D>(surface_, surface_rows_, i, predicted_position_[i], contact);
      keep_off_faces<D>(seen_walls_.faces(), wall_rows_, i, predicted_position_[i], contact, way);
      state_.position[i] += way;
    }
  const double coefficient = constants_.numerics.shifting * constants_.kernel.smoothing_length() * bulk_speed_ * duration_s_;
  if (coefficient == 0) return;
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(state_.size());
  evaluations_.shifting += n;
#pragma omp parallel for schedule(static) if (n >= parallel_threshold)
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    if (flag_[i] != Flag::interior) continue;
    const Vector<D> boundary = boundary_.wall_gradient[i] + boundary_.surface_gradient[i] + boundary_.averted_gradient[i];
    Vector<D> shift = -coefficient * (neighbours_.concentration_gradient[i] + boundary);
    if (near_surface_[i]) {
      const Vector<D> outward = correction_[i] * (neighbours_.kernel_gradient[i] + boundary);
      const double size2 = outward.squaredNorm();
      if (size2 > 0) shift -= shift.dot(outward) / size2 * outward;
    }
    const bool at_structure = surface_rows_.count[i] > 0;
    const double limit = (at_structure ? largest_shift_at_structure : largest_shift) * constants_.spacing;
    const double size = shift.norm();
    if (size > limit) shift *= limit / size;
    keep_off_faces<D>(seen_walls_.faces(), wall_rows_, i, predicted_position_[i], 0.5 * constants_.spacing, shift);
    if (at_structure) keep_off_faces<D>(surface_, surface_rows_, i, predicted_position_[i], 0.5 * constants_.spacing, shift);
    state_.position[i] += shift;
  }
}

template void Fluid<2>::shift_particles();
template void Fluid<3>::shift_particles();

}  // namespace tern::fluid
