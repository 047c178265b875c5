#pragma once
// Loads of the case: traction and pressure on the surface points of a body, force per volume on its particles. All are
// taken at the middle of a window in time; a pressure acts along the normals at its begin.

#include <vector>

#include "structure/surface_points.hpp"

namespace tern::structure {

template <int D>
class Loads {
 public:
  Loads(const StructureCase& structure, const Reference<D>& reference, const SurfaceAttachment<D>& attachment);

  bool any() const { return !loads_.empty(); }

  /// Evaluates all loads at time `t` [s]. `work` holds the deformation gradient of `state`.
  void update(double t, const SurfaceAttachment<D>& attachment, const Reference<D>& reference, const State<D>& state,
              const Workspace<D>& work);

  /// Of the last update(), on the rows [N/m^(3-D)]; empty without loads.
  const RowVectors<D>& force() const { return force_; }
  void add_to(RowVectors<D>& force) const;

 private:
  struct Load {
    LoadCase input;
    std::vector<std::size_t> point;  // feet of the surface it acts on
    std::vector<std::int32_t> row;   // or particles
    std::vector<double> volume;      // and theirs [m^D]
  };
  std::vector<Load> loads_;
  RowVectors<D> force_;
};

}  // namespace tern::structure
