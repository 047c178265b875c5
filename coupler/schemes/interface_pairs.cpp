#include "coupler/schemes/interface_pairs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include <omp.h>

namespace tern::coupler {
namespace {

constexpr std::ptrdiff_t worth_threads = 512;  ///< particles

/// work(thread, first, last) for equal ranges of [0, n), in their order.
template <class Work>
void for_ranges(std::ptrdiff_t n, int threads, Work&& work) {
  if (threads == 1) return work(0, std::ptrdiff_t{0}, n);
#pragma omp parallel for num_threads(threads) schedule(static, 1)
  for (int thread = 0; thread < threads; ++thread) work(thread, n * thread / threads, n * (thread + 1) / threads);
}

}  // namespace

template <int D>
void InterfacePairs<D>::find(const InterfaceParticles<D>& particles, const Surface<D>& surface) {
  pairs_.clear();
  particle_pairs_ = back_facing_pairs_ = 0;
  for (Found& found : found_) found.standing.clear();
  for (std::vector<double>* sum : {&seen_share_, &filled_, &weighed_area_}) sum->assign(surface.position.size(), 0);
  if (particles.id.empty()) return;
  faces_.position = surface.position;
  faces_.normal = surface.normal;
  faces_.area = surface.area;
  faces_.two_sided.assign(surface.position.size(), 1);
  finder_.fill(faces_, kernel_.support());
  covered_.assign(surface.position.size(), 0);
  for (std::uint32_t k : particles.covered) covered_[k] = 1;
  look(particles);
  find_borne_shares();

  const auto n = static_cast<std::ptrdiff_t>(particles.id.size());
  place_.assign(particles.position.begin(), particles.position.end());
  place_.insert(place_.end(), particles.image_position.begin(), particles.image_position.end());
  particle_.resize(particles.id.size());
  std::iota(particle_.begin(), particle_.end(), 0);
  particle_.insert(particle_.end(), particles.image_of.begin(), particles.image_of.end());

  // Pairs of particles with points that they see come first, thread by thread. Behind all of these come those past corners.
  const int threads = static_cast<int>(found_.size());
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
  first_.resize(particles.id.size() + 1);
  first_.back() = particle_pairs_;
  for_ranges(n, threads, [&](int thread, std::ptrdiff_t first, std::ptrdiff_t last) {
    Found& found = found_[thread];
    found.standing.clear();
    std::size_t seen = 0, past = 0;
    for (std::ptrdiff_t i = first; i < last; ++i) {
      first_[i] = begin_[thread] + seen;
      const int count = found.seen_count[i - first], count_past = found.back_facing_count[i - first];
      weigh(particles, static_cast<int>(i), found.seen.data() + seen, count, pairs_.data() + first_[i], first_[i], &found.standing);
      weigh(particles, static_cast<int>(i), found.back_facing.data() + past, count_past, pairs_.data() + begin_past_[thread] + past, 0,
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
                          weight(particles.volume[i], surface.area[k], borne_share_[k], offset.norm())});
    }
  }
  sum_by_points(surface);
}

/// What the normal is multiplied with.
template <int D>
double InterfacePairs<D>::weight(double volume, double area, double borne_share, double distance) const {
  return -2 * volume * area * (borne_share * kernel_.surface_weight(distance));
}

/// Pairs of a particle with these points. `standing`: appends of those the number from `first` on that stand over their patch
/// (stands_over()); null: nobody asks.
template <int D>
void InterfacePairs<D>::weigh(const InterfaceParticles<D>& particles, int particle, const int* points, std::ptrdiff_t count, Kept* pairs,
                              std::size_t first, std::vector<std::size_t>* standing) const {
  constexpr std::ptrdiff_t together = 64;
  std::array<double, together> distance2, height, area, share, weights, beside;
  const Vector<D>& x = particles.position[particle];
  const double volume = particles.volume[particle];
  for (std::ptrdiff_t done = 0; done < count; done += together) {
    const std::ptrdiff_t here = std::min(together, count - done);
    for (std::ptrdiff_t m = 0; m < here; ++m) {
      const int k = points[done + m];
      const Vector<D> d = x - faces_.position[k];
      distance2[m] = d.squaredNorm();
      height[m] = d.dot(faces_.normal[k]);
      area[m] = faces_.area[k];
      share[m] = borne_share_[k];
    }
    for (std::ptrdiff_t m = 0; m < here; ++m) weights[m] = weight(volume, area[m], share[m], std::sqrt(distance2[m]));
    for (std::ptrdiff_t m = 0; m < here; ++m) pairs[done + m] = {static_cast<std::uint32_t>(particle), points[done + m], weights[m]};
    if (standing == nullptr) continue;
    for (std::ptrdiff_t m = 0; m < here; ++m) beside[m] = distance2[m] - height[m] * height[m] - patch_reach2<D>(area[m]);
    for (std::ptrdiff_t m = 0; m < here; ++m)
      if (beside[m] < 0) standing->push_back(first + static_cast<std::size_t>(done + m));
  }
}

/// Which points every particle sees, and which are past a corner of what it sees.
template <int D>
void InterfacePairs<D>::look(const InterfaceParticles<D>& particles) {
  const auto n = static_cast<std::ptrdiff_t>(particles.id.size());
  found_.resize(n < worth_threads ? 1 : static_cast<std::size_t>(omp_get_max_threads()));
  for_ranges(n, static_cast<int>(found_.size()), [&](int thread, std::ptrdiff_t first, std::ptrdiff_t last) {
    Found& found = found_[thread];
    for (auto* list : {&found.seen, &found.back_facing, &found.seen_count, &found.back_facing_count}) list->clear();
    CornerView<D> corners(faces_, finder_, covered_, kernel_, found.corners);
    for (std::ptrdiff_t i = first; i < last; ++i) {
      const std::size_t before = found.seen.size();
      finder_.see(faces_, particles.position[i], found.seen);
      const int count = static_cast<int>(found.seen.size() - before);
      found.seen_count.push_back(count);
      found.back_facing_count.push_back(0);
      if (count == 0) continue;
      corners.look(particles.position[i], found.seen.data() + before, count);
      found.back_facing.insert(found.back_facing.end(), corners.back_facing().begin(), corners.back_facing().end());
      found.back_facing_count.back() = static_cast<int>(corners.back_facing().size());
    }
  });
}

/// Of the points that have pairs; 0 of the others.
template <int D>
void InterfacePairs<D>::find_borne_shares() {
  asked_.assign(faces_.size(), 0);
  for (const Found& found : found_) {
    for (const int k : found.seen) asked_[k] = 1;
    for (const int k : found.back_facing) asked_[k] = 1;
  }
  borne_share_.assign(faces_.size(), 0);
  for_ranges(static_cast<std::ptrdiff_t>(faces_.size()), static_cast<int>(found_.size()),
             [&](int thread, std::ptrdiff_t first, std::ptrdiff_t last) {
               CornerView<D> corners(faces_, finder_, covered_, kernel_, found_[thread].corners);
               for (std::ptrdiff_t k = first; k < last; ++k)
                 if (asked_[k]) borne_share_[k] = corners.borne_share(static_cast<int>(k));
             });
}

template <int D>
void InterfacePairs<D>::sum_by_points(const Surface<D>& surface) {
  const auto add = [&](const PairRange<D>& range) {
    for (const auto& pair : range) {
      const double area = -pair.b.dot(surface.normal[pair.point]);
      filled_[pair.point] += area / surface.area[pair.point];
      weighed_area_[pair.point] += area;
    }
  };
  add(pairs());
  for (std::size_t k = 0; k < filled_.size(); ++k)
    if (filled_[k] != 0) seen_share_[k] = filled_[k] / borne_share_[k];
  add(range(particle_pairs_, pairs_.size()));
}

template class InterfacePairs<2>;
template class InterfacePairs<3>;

}  // namespace tern::coupler
