#pragma once
// Space that repeats itself in some directions. Particles live in one period; a pair is seen along its nearest image,
// which is the only one within the kernel support because every period is at least two supports long.

#include <array>
#include <cmath>
#include <type_traits>

#include "base/vector.hpp"
#include "scene/case_file.hpp"

namespace tern::fluid {

template <int D>
class Period {
 public:
  explicit Period(const Case& scene) {
    for (int c = 0; c < D; ++c) {
      if (!scene.periodic[c]) continue;
      any_ = true;
      begin_[c] = scene.domain_min[c];
      length_[c] = scene.domain_max[c] - scene.domain_min[c];
      inverse_length_[c] = 1 / length_[c];
    }
  }

  bool any() const { return any_; }
  bool repeats(int direction) const { return length_[direction] > 0; }
  double begin(int direction) const { return begin_[direction]; }
  /// Of one period [m]; 0 where space does not repeat itself.
  double length(int direction) const { return length_[direction]; }

  /// The vector from one point to another as that to the nearest image. Its bits turn sign with those of d.
  Vector<D> nearest(Vector<D> d) const {
    for (int c = 0; c < D; ++c) d[c] -= length_[c] * std::nearbyint(d[c] * inverse_length_[c]);
    return d;
  }

  /// What has to be added to x to bring it into the period.
  Vector<D> into(const Vector<D>& x) const {
    Vector<D> shift;
    for (int c = 0; c < D; ++c) shift[c] = -length_[c] * std::floor((x[c] - begin_[c]) * inverse_length_[c]);
    return shift;
  }

  /// Calls loop(std::true_type) in a space that repeats itself and loop(std::false_type) in one that does not, so that
  /// the latter is compiled without the search for the nearest image: see between().
  template <class Loop>
  void specialise(Loop&& loop) const {
    any_ ? loop(std::true_type{}) : loop(std::false_type{});
  }

  /// Component c of the vector between two coordinates.
  template <bool periodic>
  double between(double from, double to, int c) const {
    const double d = to - from;
    if constexpr (periodic)
      return d - length_[c] * std::nearbyint(d * inverse_length_[c]);
    else
      return d;
  }

 private:
  bool any_ = false;
  Vector<D> begin_ = Vector<D>::Zero(), length_ = Vector<D>::Zero(), inverse_length_ = Vector<D>::Zero();
};

/// Calls visit(shift) for every whole number of periods, zero left out, by which a particle at x has to be moved to come
/// within the support of the box [low, high] of all particles.
template <int D, class Visit>
void for_images(const Period<D>& period, const Vector<D>& x, const Vector<D>& low, const Vector<D>& high, double support, Visit&& visit) {
  constexpr int combinations = D == 2 ? 9 : 27;
  for (int k = 1; k < combinations; ++k) {
    Vector<D> shift;
    bool near = true;
    for (int c = 0, rest = k; c < D && near; ++c, rest /= 3) {
      shift[c] = rest % 3 == 0 ? 0 : rest % 3 == 1 ? period.length(c) : -period.length(c);
      const double image = x[c] + shift[c];
      near = rest % 3 == 0 || (period.repeats(c) && image > low[c] - support && image < high[c] + support);
    }
    if (near) visit(shift);
  }
}

}  // namespace tern::fluid
