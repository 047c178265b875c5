#include "fluid/pressure/level_ties.hpp"

#include <numeric>
#include <span>

namespace tern::fluid {
namespace {

constexpr double least_moved = 0.5;  ///< of what a level would move, were no push undone

/// Sets of the numbers 0 ... n - 1, each known by its least member.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }
  int find(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void unite(int i, int j) {
    i = find(i), j = find(j);
    parent_[std::max(i, j)] = std::min(i, j);
  }

 private:
  std::vector<int> parent_;
};

}  // namespace

template <int D>
LevelTies find_level_ties(const YieldingSurface<D>& yielding, const std::vector<int>& at_structure, const EnclosedRegions& enclosed) {
  const std::size_t regions = enclosed.size.size(), lumps = yielding.any() ? yielding.lumps() : 0;
  LevelTies ties;
  ties.beside_bodies.assign(regions, -1);
  ties.sealed.assign(regions, -1);
  if (regions == 0) return ties;

  constexpr std::size_t numbers = D + 1;  // of each lump and region: the push of a level of 1 Pa, and its parts either way
  std::vector<double> push(lumps * regions * numbers, 0);
  const auto of = [&](std::size_t a, std::size_t k) { return push.begin() + static_cast<std::ptrdiff_t>((a * regions + k) * numbers); };
  for (std::size_t a = 0; a < lumps; ++a)
    yielding.for_rows(a, [&](int m, const Vector<D>& c) {
      const int k = enclosed.region[at_structure[m]];
      if (k < 0) return;
      const auto sum = of(a, static_cast<std::size_t>(k));
      for (int x = 0; x < D; ++x) sum[x] += c[x];
      sum[D] += c.norm();
    });
  enclosed.ranks.sum(std::span(push));

  DisjointSets bodies(lumps), groups(regions);
  yielding.for_lumps_of_a_point([&](int a, int b) { bodies.unite(a, b); });
  std::vector<int> pushes(lumps, -1);  // by body: a region that does
  for (std::size_t a = 0; a < lumps; ++a)
    for (std::size_t k = 0; k < regions; ++k) {
      if (of(a, k)[D] == 0) continue;
      int& known = pushes[bodies.find(static_cast<int>(a))];
      if (known >= 0) groups.unite(known, static_cast<int>(k));
      known = static_cast<int>(k);
      ties.beside_bodies[k] = 0;
    }

  // A body is pushed by one group alone.
  std::vector<double> moved(lumps, 0), undone_by_none(lumps, 0);
  for (std::size_t a = 0; a < lumps; ++a) {
    Vector<D> sum = Vector<D>::Zero();
    double either_way = 0;
    for (std::size_t k = 0; k < regions; ++k) {
      for (int x = 0; x < D; ++x) sum[x] += of(a, k)[x];
      either_way += of(a, k)[D];
    }
    const int body = bodies.find(static_cast<int>(a));
    moved[body] += yielding.scale(a) * sum.squaredNorm();
    undone_by_none[body] += yielding.scale(a) * either_way * either_way;
  }
  std::vector<char> tied(regions, 0);
  for (std::size_t body = 0; body < lumps; ++body)
    if (pushes[body] >= 0 && moved[body] >= least_moved * undone_by_none[body]) tied[groups.find(pushes[body])] = 1;

  int beside = 0, sealed = 0;
  for (std::size_t k = 0; k < regions; ++k) {
    const int group = groups.find(static_cast<int>(k));
    if (ties.beside_bodies[k] == 0) ties.beside_bodies[k] = beside++;
    if (!tied[group]) ties.sealed[k] = group == static_cast<int>(k) ? sealed++ : ties.sealed[group];
  }
  return ties;
}

template LevelTies find_level_ties<2>(const YieldingSurface<2>&, const std::vector<int>&, const EnclosedRegions&);
template LevelTies find_level_ties<3>(const YieldingSurface<3>&, const std::vector<int>&, const EnclosedRegions&);

}  // namespace tern::fluid
