#include "fluid/boundary/patches_of_ranks.hpp"

#include <algorithm>

namespace tern::fluid {

template <int D>
void share_patches(const Domain<D>& domain, const Constants<D>& constants, const Period<D>& period, Boundary<D>& boundary) {
  const bool as_before = boundary.cuts_of_patches == domain.cuts() && boundary.changes_of_patches == boundary.held.changes;
  if (domain.alone() || (as_before && !boundary.walls.moving())) return;
  boundary.cuts_of_patches = domain.cuts();
  boundary.changes_of_patches = boundary.held.changes;
  const Faces<D>& walls = boundary.walls.faces();
  const int own = domain.ranks().own(), count = static_cast<int>(walls.size());
  const double reach = constants.faces.support() + constants.spacing;
  std::vector<std::vector<int>> give(static_cast<std::size_t>(domain.ranks().count())), take(give.size());
  const auto holds = [&](int rank, int k) {
    const int frame = boundary.walls.all()[boundary.walls.wall_of(k)].frame;
    return boundary.walls.whole() || lies_in_any(boundary.held.of_ranks[static_cast<std::size_t>(rank)][static_cast<std::size_t>(frame)],
                                                 boundary.walls.reference(static_cast<std::size_t>(k)));
  };
  std::vector<int> needs;
  for (int k = 0, next; k < count; k = next) {
    // What is filled of a patch and of its images beyond the end of a period is one number, that of the first of them.
    needs.clear();
    for (next = k; next < count && walls.original_of(next) == k; ++next)
      domain.for_owners_around(walls.position[next], reach, [&](int rank) {
        if (holds(rank, k)) needs.push_back(rank);
      });
    if (needs.empty()) continue;
    std::sort(needs.begin(), needs.end());
    needs.erase(std::unique(needs.begin(), needs.end()), needs.end());
    const int there = domain.owner(walls.position[k] + period.into(walls.position[k]));
    const int owner = holds(there, k) ? there : needs.front();
    for (const int rank : needs) {
      if (rank == owner) continue;
      if (owner == own) give[rank].push_back(k);
      if (rank == own) take[owner].push_back(k);
    }
  }
  boundary.patches.reset(domain.ranks(), Subject::other, give, take);
}

template void share_patches<2>(const Domain<2>&, const Constants<2>&, const Period<2>&, Boundary<2>&);
template void share_patches<3>(const Domain<3>&, const Constants<3>&, const Period<3>&, Boundary<3>&);

}  // namespace tern::fluid
