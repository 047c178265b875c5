#include "fluid/boundary/interface_particles.hpp"

#include "fluid/boundary/mirror_images.hpp"

namespace tern::fluid {
namespace {

/// Adds the images of particle i, the last of the interface particles, that a face of the structure sees as well.
template <int D>
void add_images(const Constants<D>& constants, int i, const Vector<D>& x, const Boundary<D>& boundary, std::vector<Vector<D>>& images,
                InterfaceParticles<D>& particles) {
  mirror_in_walls<D>(boundary.seen_walls(), boundary.wall_rows, i, x, 0.25 * constants.spacing, images);
  const double support = constants.faces.support();
  const FaceRows& rows = boundary.surface_rows;
  for (const Vector<D>& image : images) {
    bool near = false;
    for (int entry = rows.begin[i]; !near && entry < rows.begin[i] + rows.count[i]; ++entry)
      near = (image - boundary.surface.position[rows.face[entry]]).squaredNorm() < support * support;
    if (!near) continue;
    particles.image_of.push_back(static_cast<std::uint32_t>(particles.id.size() - 1));
    particles.image_position.push_back(image);
  }
}

}  // namespace

template <int D>
InterfaceParticles<D> interface_particles(const Constants<D>& constants, const State<D>& state, const Prediction<D>& prediction,
                                          const Boundary<D>& boundary, const std::vector<double>* divergence,
                                          std::vector<Vector<D>>& images, std::vector<int>& at_structure) {
  at_structure.clear();
  InterfaceParticles<D> particles;
  for (std::size_t i = 0; i < state.size(); ++i) {
    if (!boundary.sees_structure(i)) continue;
    at_structure.push_back(static_cast<int>(i));
    particles.id.push_back(state.id[i]);
    particles.position.push_back(prediction.position[i]);
    particles.velocity.push_back(prediction.velocity[i]);
    particles.mass.push_back(constants.mass);
    particles.volume.push_back(constants.volume);
    if (divergence) particles.divergence.push_back((*divergence)[i]);
    if (boundary.sees_wall(i)) add_images(constants, static_cast<int>(i), prediction.position[i], boundary, images, particles);
  }
  if (!at_structure.empty())
    for (std::size_t k = 0; k < boundary.covered_faces.size(); ++k)
      if (boundary.covered_faces[k]) particles.covered.push_back(static_cast<std::uint32_t>(k));
  return particles;
}

#define TERN_INSTANTIATE(D)                                                                                                             \
  template InterfaceParticles<D> interface_particles<D>(const Constants<D>&, const State<D>&, const Prediction<D>&, const Boundary<D>&, \
                                                        const std::vector<double>*, std::vector<Vector<D>>&, std::vector<int>&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
