// A build in which a fluid has one process.

#include "ranks/ranks.hpp"

#include <cstdlib>

#include "ranks/waiting.hpp"

namespace tern {

Ranks Ranks::all() { return {}; }
void Ranks::sum_and_most(std::span<double>, std::span<double>) const {}
void Ranks::extremes(std::span<double>, std::span<double>) const {}
void Ranks::exchange(std::span<const RankMessage>, std::span<const RankMessage>, Subject) const {}
const Traffic& Ranks::traffic() {
  static const Traffic none;
  return none;
}
void Ranks::tell(void*, std::size_t, int) const {}
std::string Ranks::first_word(const std::string& own) const { return own; }
void Ranks::combine(void*, std::size_t, Kind, Operation) const {}
void Ranks::swap_sizes(std::vector<std::int64_t>&) const {}

RanksAtWork::RanksAtWork() {}
RanksAtWork::~RanksAtWork() {}
bool ranks_were_started() { return false; }
void abandon_ranks(int exit_code) { std::_Exit(exit_code); }
double seconds_with_ranks() { return 0; }

}  // namespace tern
