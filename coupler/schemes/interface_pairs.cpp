#include "coupler/schemes/interface_pairs.hpp"

namespace tern::coupler {

template <int D>
void InterfacePairs<D>::find(const InterfaceParticles<D>& particles, const Surface<D>& surface) {
  pairs_.clear();
  particle_pairs_ = back_facing_pairs_ = 0;
  if (particles.id.empty()) return;
  faces_.position = surface.position;
  faces_.normal = surface.normal;
  faces_.area = surface.area;
  faces_.two_sided.assign(surface.position.size(), 1);
  finder_.fill(faces_, kernel_.support());
  covered_.assign(surface.position.size(), 0);
  for (std::uint32_t k : particles.covered) covered_[k] = 1;
  CornerView<D> corners(faces_, finder_, covered_, kernel_, corner_scratch_);
  borne_share_.assign(surface.position.size(), 0);  // not asked for yet
  const auto pair = [&](int i, int k, const Vector<D>& offset) {
    if (borne_share_[k] == 0) borne_share_[k] = corners.borne_share(k);
    const double weight = borne_share_[k] * kernel_.surface_weight(offset.norm());
    return InterfacePair<D>{i, k, Vector<D>(-2 * particles.volume[i] * surface.area[k] * weight * surface.normal[k]), offset};
  };
  first_.clear();
  past_corners_.clear();
  for (int i = 0; i < static_cast<int>(particles.id.size()); ++i) {
    const Vector<D>& x = particles.position[i];
    first_.push_back(pairs_.size());
    seen_.clear();
    finder_.see(faces_, x, seen_);
    for (int k : seen_) pairs_.push_back(pair(i, k, x - surface.position[k]));
    if (seen_.empty()) continue;
    corners.look(x, seen_.data(), static_cast<int>(seen_.size()));
    back_facing_ = corners.back_facing();  // borne_share() looks elsewhere
    for (int k : back_facing_) past_corners_.push_back(pair(i, k, x - surface.position[k]));
  }
  particle_pairs_ = pairs_.size();
  back_facing_pairs_ = past_corners_.size();
  first_.push_back(particle_pairs_);
  pairs_.insert(pairs_.end(), past_corners_.begin(), past_corners_.end());
  // A face that the particle does not see, such as one that lies on the wall, is none before its image either.
  for (std::size_t m = 0; m < particles.image_of.size(); ++m) {
    const std::uint32_t i = particles.image_of[m];
    for (std::size_t seen = first_[i]; seen < first_[i + 1]; ++seen) {
      const int k = pairs_[seen].point;
      const Vector<D> offset = particles.image_position[m] - surface.position[k];
      if (offset.dot(surface.normal[k]) > 0 && offset.squaredNorm() < kernel_.support() * kernel_.support())
        pairs_.push_back(pair(static_cast<int>(i), k, offset));
    }
  }
}

template <int D>
std::vector<double> InterfacePairs<D>::seen_share(const Surface<D>& surface) const {
  std::vector<double> share(surface.position.size(), 0);
  for (const auto& pair : pairs()) share[pair.point] -= pair.b.dot(surface.normal[pair.point]) / surface.area[pair.point];
  for (std::size_t k = 0; k < share.size(); ++k)
    if (share[k] != 0) share[k] /= borne_share_[k];
  return share;
}

template class InterfacePairs<2>;
template class InterfacePairs<3>;

}  // namespace tern::coupler
