#pragma once
// The structure as the coupling sees it: a predicted surface, then the load of the window.

#include "particles/case_file.hpp"
#include "structure/structure.hpp"

namespace tern::structure {

template <int D>
class CoupledStructure {
 public:
  CoupledStructure(Structure<D>& structure, CouplingAlgorithm algorithm) : structure_(structure), algorithm_(algorithm) {}

  /// CM2: halfway to the trial state under the old load, with that state's velocity. CM0: the present surface moved on for
  /// half a window at its velocity.
  Surface<D> predict_surface(Ticks begin, Ticks duration) {
    begin_ = begin;
    duration_ = duration;
    Surface<D> surface = structure_.surface();
    if (algorithm_ == CouplingAlgorithm::cm0) {
      for (std::size_t k = 0; k < surface.position.size(); ++k)
        surface.position[k] += 0.5 * seconds(duration) * surface.velocity[k];
      return surface;
    }
    Surface<D> trial = structure_.trial(begin, duration);
    for (std::size_t k = 0; k < surface.position.size(); ++k) {
      trial.position[k] = 0.5 * (surface.position[k] + trial.position[k]);
      trial.normal[k] = (surface.normal[k] + trial.normal[k]).normalized();
      trial.area[k] = 0.5 * (surface.area[k] + trial.area[k]);
    }
    return trial;
  }

  /// Brings the structure to the end of the window under this load.
  void apply(const SurfaceLoad<D>& load) {
    if (algorithm_ == CouplingAlgorithm::cm0) structure_.trial(begin_, duration_);
    structure_.advance(load);
  }

 private:
  Structure<D>& structure_;
  CouplingAlgorithm algorithm_;
  Ticks begin_ = 0, duration_ = 0;
};

}  // namespace tern::structure
