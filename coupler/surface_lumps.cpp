#include "coupler/surface_lumps.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

namespace tern::coupler {

SurfaceLumps lumps_of_points(std::size_t points) {
  SurfaceLumps lumps{1, points, std::vector<std::uint32_t>(points), std::vector<double>(points, 1)};
  std::iota(lumps.lump.begin(), lumps.lump.end(), 0u);
  return lumps;
}

template <int D>
SurfaceLumps lumps_of_width(double width, const SurfaceAtStart<D>& start, const std::vector<std::uint32_t>& body,
                            const std::vector<double>& depth) {
  constexpr std::size_t corners = std::size_t{1} << D;
  SurfaceLumps lumps{corners, 0, {}, {}};
  std::map<std::pair<std::uint32_t, std::array<long, D>>, std::uint32_t> known;  // lattice points of each body
  for (std::size_t k = 0; k < start.position.size(); ++k) {
    if (depth[k] == 0) {
      lumps.lump.insert(lumps.lump.end(), corners, static_cast<std::uint32_t>(lumps.count++));
      lumps.share.push_back(1);
      lumps.share.insert(lumps.share.end(), corners - 1, 0);
      continue;
    }
    const Vector<D> x = (start.position[k] - std::min(depth[k], 0.5 * width) * start.normal[k]) / width;
    for (std::size_t corner = 0; corner < corners; ++corner) {
      std::array<long, D> at{};
      double share = 1;
      for (int c = 0; c < D; ++c) {
        const double low = std::floor(x[c]);
        const bool upper = (corner >> c) & 1;
        at[c] = static_cast<long>(low) + upper;
        share *= upper ? x[c] - low : 1 - (x[c] - low);
      }
      if (share == 0) {
        lumps.lump.push_back(0);
      } else {
        const auto [entry, is_new] = known.try_emplace({body[k], at}, static_cast<std::uint32_t>(lumps.count));
        if (is_new) ++lumps.count;
        lumps.lump.push_back(entry->second);
      }
      lumps.share.push_back(share);
    }
  }
  return lumps;
}

std::vector<double> lump_masses(const SurfaceLumps& lumps, const std::vector<double>& mass_per_area, const std::vector<double>& area) {
  std::vector<double> mass(lumps.count, 0);
  for (std::size_t s = 0; s < lumps.lump.size(); ++s)
    mass[lumps.lump[s]] += lumps.share[s] * mass_per_area[s / lumps.per_point] * area[s / lumps.per_point];
  return mass;
}

template SurfaceLumps lumps_of_width<2>(double, const SurfaceAtStart<2>&, const std::vector<std::uint32_t>&, const std::vector<double>&);
template SurfaceLumps lumps_of_width<3>(double, const SurfaceAtStart<3>&, const std::vector<std::uint32_t>&, const std::vector<double>&);

}  // namespace tern::coupler
