#include "coupler/interface_pairs.hpp"

namespace tern::coupler {

template <int D>
void InterfacePairs<D>::find(const Band<D>& band, const Surface<D>& surface) {
  pairs_.clear();
  particle_pairs_ = 0;
  if (band.id.empty()) return;
  faces_.position = surface.position;
  faces_.normal = surface.normal;
  faces_.area = surface.area;
  faces_.two_sided.assign(surface.position.size(), 1);
  finder_.fill(faces_, kernel_.support());
  const auto add = [&](int i, int k, const Vector<D>& offset) {
    const double weight = kernel_.surface_weight(offset.norm());
    pairs_.push_back({i, k, Vector<D>(-2 * band.volume[i] * surface.area[k] * weight * surface.normal[k]), offset});
  };
  first_.clear();
  for (std::size_t i = 0; i < band.id.size(); ++i) {
    first_.push_back(pairs_.size());
    seen_.clear();
    finder_.see(faces_, band.position[i], seen_);
    for (int k : seen_) add(static_cast<int>(i), k, band.position[i] - surface.position[k]);
  }
  particle_pairs_ = pairs_.size();
  first_.push_back(particle_pairs_);
  // A face that the particle does not see, such as one that lies on the wall, is none before its image either.
  for (std::size_t m = 0; m < band.image_of.size(); ++m) {
    const std::uint32_t i = band.image_of[m];
    for (std::size_t pair = first_[i]; pair < first_[i + 1]; ++pair) {
      const int k = pairs_[pair].point;
      const Vector<D> offset = band.image_position[m] - surface.position[k];
      if (offset.dot(surface.normal[k]) > 0 && offset.squaredNorm() < kernel_.support() * kernel_.support())
        add(static_cast<int>(i), k, offset);
    }
  }
}

template class InterfacePairs<2>;
template class InterfacePairs<3>;

}  // namespace tern::coupler
