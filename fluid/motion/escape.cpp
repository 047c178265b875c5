#include "fluid/motion/escape.hpp"

#include <fmt/format.h>

#include "base/error.hpp"
#include "base/parallel.hpp"

namespace tern::fluid {

template <int D>
std::size_t count_leaks(double spacing, double duration, const Faces<D>& faces, const FaceRows& rows, const std::vector<Vector<D>>& middle,
                        const std::vector<Vector<D>>& end) {
  // A particle that saw the front of a patch and now stands a quarter spacing behind it has gone through.
  const double depth = 0.25 * spacing;
  const bool at_rest = faces.velocity.empty();
  return ordered_reduce(static_cast<std::ptrdiff_t>(end.size()), std::size_t{0}, [&](std::ptrdiff_t i) -> std::size_t {
    if (at_rest && (end[i] - middle[i]).squaredNorm() < depth * depth) return 0;
    if (rows.before_plane(i)) {
      const int k = rows.face[rows.begin[i]];
      return (end[i] - faces.position[k]).dot(faces.normal[k]) < -depth;
    }
    for (int entry = rows.begin[i]; entry < rows.begin[i] + rows.count[i]; ++entry) {
      const int k = rows.face[entry];
      const Vector<D> to_face = end[i] - 0.5 * duration * faces.velocity_of(k);
      if (patch_separates(faces, k, middle[i], to_face, depth)) return 1;
    }
    return 0;
  });
}

template <int D>
void remove_escaped(const Reference<D>& reference, State<D>& state) {
  const auto outside = [&](const Vector<D>& x) {
    return (x.array() < reference.domain_min.array()).any() || (x.array() > reference.domain_max.array()).any();
  };
  const std::size_t escaped =
      ordered_reduce(static_cast<std::ptrdiff_t>(state.size()), std::size_t{0}, [&](std::ptrdiff_t i) -> std::size_t {
        Vector<D>& x = state.position[i];
        if (reference.period.any()) x += reference.period.into(x);
        return outside(x);
      });
  if (escaped == 0) return;
  state.removed += escaped;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < state.size(); ++i) {
    if (outside(state.position[i])) continue;
    if (kept != i) for_each_particle_field(state, [&](const char*, const char*, auto& values) { values[kept] = values[i]; });
    ++kept;
  }
  for_each_particle_field(state, [&](const char*, const char*, auto& values) { values.resize(kept); });
}

void check_that_some_are_left(const Window& window, std::size_t particles) {
  if (particles > 0) return;
  throw EndOfModel(
      fmt::format("All fluid has left the domain by t = {:.6g} s; enlarge [domain] or close the walls.", window.begin + window.duration));
}

template std::size_t count_leaks<2>(double, double, const Faces<2>&, const FaceRows&, const std::vector<Vector<2>>&,
                                    const std::vector<Vector<2>>&);
template std::size_t count_leaks<3>(double, double, const Faces<3>&, const FaceRows&, const std::vector<Vector<3>>&,
                                    const std::vector<Vector<3>>&);
template void remove_escaped<2>(const Reference<2>&, State<2>&);
template void remove_escaped<3>(const Reference<3>&, State<3>&);

}  // namespace tern::fluid
