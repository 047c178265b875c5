#include "coupler/interface_pairs.hpp"

namespace tern::coupler {

template <int D>
void InterfacePairs<D>::find(const Band<D>& band, const Surface<D>& surface) {
  pairs_.clear();
  if (band.id.empty()) return;
  faces_.position = surface.position;
  faces_.normal = surface.normal;
  faces_.area = surface.area;
  faces_.two_sided.assign(surface.position.size(), 1);
  finder_.fill(faces_, kernel_.support());
  for (std::size_t i = 0; i < band.id.size(); ++i) {
    seen_.clear();
    finder_.see(faces_, band.position[i], seen_);
    for (int k : seen_) {
      const double weight = kernel_.surface_weight((surface.position[k] - band.position[i]).norm());
      pairs_.push_back({static_cast<int>(i), k, Vector<D>(-2 * band.volume[i] * surface.area[k] * weight * surface.normal[k])});
    }
  }
}

template class InterfacePairs<2>;
template class InterfacePairs<3>;

}  // namespace tern::coupler
