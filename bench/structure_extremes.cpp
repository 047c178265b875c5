// Extremes of the structure (fixtures/extreme_scenes.hpp): what each comes to, bounded with its figures, stopped with a
// message, or WRONG. Prints the table of docs/STRUCTURE.md:  build/release/bench/bench-structure_extremes [words]
// With words, only the rows that have them. Ends with 1 when one is wrong.

#include <ctime>

#include "fixtures/extremes.hpp"

int main(int argc, char** argv) {
  using namespace tern::structure::testing;
  fmt::print("| what | outcome | |\n|---|---|---|\n");
  int rows = 0, wrong = 0;
  for (const Extreme& extreme : extremes()) {
    if (argc > 1 && extreme.what.find(argv[1]) == std::string::npos) continue;
    const Outcome outcome = run(extreme);
    fmt::print("| {} | {} | {} |\n", extreme.what, name_of(outcome.verdict), outcome.text);
    std::fflush(stdout);
    ++rows;
    wrong += outcome.verdict == Outcome::Verdict::wrong;
  }
  fmt::print("\n{} rows, {} wrong, {:.0f} s of CPU\n", rows, wrong, static_cast<double>(std::clock()) / CLOCKS_PER_SEC);
  return wrong > 0;
}
