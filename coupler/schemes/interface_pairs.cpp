#include "coupler/schemes/interface_pairs.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <numeric>

#include "base/parallel.hpp"

namespace tern::coupler {
template <int D>
void InterfacePairs<D>::find(const InterfaceParticles<D>& particles, const Surface<D>& surface) {
  pairs_.clear();
  particle_pairs_ = back_facing_pairs_ = 0;
  found_.resize(particle_parts(static_cast<std::ptrdiff_t>(particles.id.size())));
  for (Found& found : found_) found.standing.clear();
  first_.assign(particles.id.size() + 1, 0);
  for (std::vector<double>* sum : {&seen_share_, &filled_}) sum->assign(surface.position.size(), 0);
  if (particles.id.empty()) return;
  faces_.position = surface.position;
  faces_.normal = surface.normal;
  faces_.area = surface.area;
  faces_.two_sided.assign(surface.position.size(), 1);
  finder_.fill(faces_, kernel_.support());
  covered_.assign(surface.position.size(), 0);
  for (std::uint32_t k : particles.covered) covered_[k] = 1;
  look(particles);
  set_points();

  place_.assign(particles.position.begin(), particles.position.end());
  place_.insert(place_.end(), particles.image_position.begin(), particles.image_position.end());
  particle_.resize(particles.id.size());
  std::iota(particle_.begin(), particle_.end(), 0);
  particle_.insert(particle_.end(), particles.image_of.begin(), particles.image_of.end());

  // Pairs of particles with points that they see come first, part by part. Behind all of these come those past corners.
  begin_.clear();
  begin_past_.clear();
  for (const Found& found : found_) {
    begin_.push_back(particle_pairs_);
    particle_pairs_ += found.seen.size();
  }
  for (const Found& found : found_) {
    begin_past_.push_back(particle_pairs_ + back_facing_pairs_);
    back_facing_pairs_ += found.back_facing.size();
  }
  pairs_.resize(particle_pairs_ + back_facing_pairs_);
  first_.back() = particle_pairs_;
  sums_.reset(parts(), faces_.size());
  for_parts([&](int part, std::ptrdiff_t first, std::ptrdiff_t last) {
    Found& found = found_[part];
    double* filled = sums_.start(part);
    std::size_t seen = 0, past = 0;
    for (std::ptrdiff_t i = first; i < last; ++i) {
      first_[i] = begin_[part] + seen;
      const int count = found.seen_count[i - first], count_past = found.back_facing_count[i - first];
      weigh(particles, static_cast<int>(i), found.seen.data() + seen, count, pairs_.data() + first_[i], &found.standing, filled);
      weigh(particles, static_cast<int>(i), found.back_facing.data() + past, count_past, pairs_.data() + begin_past_[part] + past, nullptr,
            nullptr);
      seen += static_cast<std::size_t>(count);
      past += count_past;
    }
  });
  // A face that the particle does not see, such as one that lies on the wall, is none before its image either.
  for (std::size_t m = 0; m < particles.image_of.size(); ++m) {
    const std::uint32_t i = particles.image_of[m];
    for (std::size_t seen = first_[i]; seen < first_[i + 1]; ++seen) {
      const int k = pairs_[seen].point;
      const Vector<D> offset = particles.image_position[m] - surface.position[k];
      if (offset.dot(surface.normal[k]) > 0 && offset.squaredNorm() < kernel_.support() * kernel_.support())
        pairs_.push_back({static_cast<std::uint32_t>(particles.id.size() + m), k,
                          weight(particles.volume[i], points_[k].area, points_[k].borne_share, offset.norm())});
    }
  }
  sum_by_points();
}

/// What the normal is multiplied with.
template <int D>
double InterfacePairs<D>::weight(double volume, double area, double borne_share, double distance) const {
  return -2 * volume * area * (borne_share * kernel_.surface_weight(distance));
}

/// Pairs of a particle with these points. `standing`: appends those of them that stand over their patch (stands_over()); `filled`: takes
/// from the sum of every point what the pair weighs. Null: nobody asks.
template <int D>
void InterfacePairs<D>::weigh(const InterfaceParticles<D>& particles, int particle, const int* points, std::ptrdiff_t count, Kept* pairs,
                              UninitialisedVector<Kept>* standing, double* filled) const {
  constexpr std::ptrdiff_t together = 64;
  std::array<double, together> distance2, height, area, share, weights, beside;
  const Vector<D>& x = particles.position[particle];
  const double volume = particles.volume[particle];
  for (std::ptrdiff_t done = 0; done < count; done += together) {
    const std::ptrdiff_t here = std::min(together, count - done);
    for (std::ptrdiff_t m = 0; m < here; ++m) {
      const PairPoint<D>& point = points_[points[done + m]];
      const Vector<D> d = x - point.position;
      distance2[m] = d.squaredNorm();
      height[m] = d.dot(point.normal);
      area[m] = point.area;
      share[m] = point.borne_share;
    }
    for (std::ptrdiff_t m = 0; m < here; ++m) weights[m] = weight(volume, area[m], share[m], std::sqrt(distance2[m]));
    for (std::ptrdiff_t m = 0; m < here; ++m) pairs[done + m] = {static_cast<std::uint32_t>(particle), points[done + m], weights[m]};
    if (standing == nullptr) continue;
    for (std::ptrdiff_t m = 0; m < here; ++m) filled[points[done + m]] -= weights[m];  // b_ik . n_k
    for (std::ptrdiff_t m = 0; m < here; ++m) beside[m] = distance2[m] - height[m] * height[m] - patch_reach2<D>(area[m]);
    // Each is written, and the next one over it unless it is one.
    std::size_t kept = standing->size();
    standing->resize(kept + static_cast<std::size_t>(here));
    for (std::ptrdiff_t m = 0; m < here; ++m) {
      (*standing)[kept] = pairs[done + m];
      kept += beside[m] < 0;
    }
    standing->resize(kept);
  }
}

/// Which points every particle sees, and which are past a corner of what it sees.
template <int D>
void InterfacePairs<D>::look(const InterfaceParticles<D>& particles) {
  asked_.assign(faces_.size(), 0);
  const auto ask = [&](int k) { std::atomic_ref(asked_[k]).store(1, std::memory_order_relaxed); };
  for_parts([&](int part, std::ptrdiff_t first, std::ptrdiff_t last) {
    Found& found = found_[part];
    for (auto* list : {&found.seen, &found.back_facing, &found.seen_count, &found.back_facing_count}) list->clear();
    CornerView<D> corners(faces_, finder_, covered_, kernel_, found.corners);
    for (std::ptrdiff_t i = first; i < last; ++i) {
      const std::size_t before = found.seen.size();
      const double spread = finder_.see(faces_, particles.position[i], found.seen);
      const int count = static_cast<int>(found.seen.size() - before);
      found.seen_count.push_back(count);
      found.back_facing_count.push_back(0);
      if (count == 0) continue;
      corners.look(particles.position[i], found.seen.data() + before, count, spread);
      found.back_facing.insert(found.back_facing.end(), corners.back_facing().begin(), corners.back_facing().end());
      found.back_facing_count.back() = static_cast<int>(corners.back_facing().size());
    }
    for (const int k : found.seen) ask(k);
    for (const int k : found.back_facing) ask(k);
  });
}

/// Those of points that have no pairs bear 0.
template <int D>
void InterfacePairs<D>::set_points() {
  points_.resize(faces_.size());
  run_parts(static_cast<std::ptrdiff_t>(faces_.size()), parts(), [&](int part, std::ptrdiff_t first, std::ptrdiff_t last) {
    CornerView<D> corners(faces_, finder_, covered_, kernel_, found_[part].corners);
    for (std::ptrdiff_t k = first; k < last; ++k)
      points_[k] = {faces_.position[k], faces_.normal[k], faces_.area[k], asked_[k] ? corners.borne_share(static_cast<int>(k)) : 0};
  });
}

/// `sums_` has those of the pairs with points that are seen.
template <int D>
void InterfacePairs<D>::sum_by_points() {
  parallel_for(static_cast<std::ptrdiff_t>(filled_.size()), [&](std::ptrdiff_t k) { filled_[k] = sums_.sum(k); });
  for (std::size_t k = 0; k < filled_.size(); ++k)
    if (filled_[k] != 0) seen_share_[k] = filled_[k] / (points_[k].area * points_[k].borne_share);
  for (std::size_t m = particle_pairs_; m < pairs_.size(); ++m) filled_[pairs_[m].point] -= pairs_[m].weight;
  for (std::size_t k = 0; k < filled_.size(); ++k) filled_[k] /= points_[k].area;
}

template class InterfacePairs<2>;
template class InterfacePairs<3>;

}  // namespace tern::coupler
