// Stability of the coupling over density ratio, thickness, stiffness, wet faces and algorithm (tests/coupler/coupled_scenes.hpp).
// Prints the table of docs/STABILITY.md:  build/release/bench/bench-coupling_stability [words]
// With words, only the rows that have them. Ends with 1 when the default is wrong anywhere.

#include <ctime>
#include <map>

#include "tests/coupler/coupled_scenes.hpp"

int main(int argc, char** argv) {
  using namespace tern;
  using namespace tern::coupler::testing;
  using Verdict = CoupledOutcome::Verdict;
  const std::pair<const char*, CouplingAlgorithm> algorithms[] = {
      {"CM0", CouplingAlgorithm::cm0}, {"CM2", CouplingAlgorithm::cm2}, {"CM3", CouplingAlgorithm::cm3}};
  constexpr double until = 0.2;
  std::map<std::string, std::map<Verdict, int>> count;
  bool wrong = false;
  fmt::print("| plate | CM0 | CM2 | CM3 | default |\n|---|---|---|---|---|\n");
  for (int faces : {1, 2})
    for (double density : {0.01, 0.1, 1.0, 10.0})
      for (int layers : {2, 4, 8})
        for (double modulus : {1e5, 1e7, 1e9}) {
          CoupledScene s{density, layers, modulus, faces};
          if (argc > 1 && describe(s).find(argv[1]) == std::string::npos) continue;
          fmt::print("| {} |", describe(s));
          const auto default_algorithm = run(s, 1e-9).algorithm;
          for (const auto& [name, algorithm] : algorithms) {
            s.algorithm = algorithm;
            const CoupledOutcome o = run(s, until);
            const bool by_default = algorithm == default_algorithm;
            ++count[name][o.verdict];
            if (by_default) ++count["default"][o.verdict];
            wrong = wrong || (by_default && o.verdict == Verdict::wrong);
            fmt::print(" {}", o.verdict == Verdict::bounded ? fmt::format("{:.2f}, {:.3f}", o.largest_speed, o.unrest)
                              : o.verdict == Verdict::stopped ? fmt::format("stopped after {}", o.windows)
                                                              : fmt::format("**wrong** ({:.1f}, {:.2f})", o.largest_speed, o.unrest));
            if (algorithm == CouplingAlgorithm::cm3 && o.verdict == Verdict::bounded) fmt::print("; {:.1f} trials", o.trials);
            fmt::print(" |");
            std::fflush(stdout);
          }
          fmt::print(" {} |\n", default_algorithm == CouplingAlgorithm::cm3 ? "CM3" : "CM2");
        }
  fmt::print("\n");
  for (const char* name : {"CM0", "CM2", "CM3", "default"})
    fmt::print("{}: {} bounded, {} stopped, {} wrong\n", name, count[name][Verdict::bounded], count[name][Verdict::stopped],
               count[name][Verdict::wrong]);
  fmt::print("{:.0f} s of CPU\n", static_cast<double>(std::clock()) / CLOCKS_PER_SEC);
  return wrong;
}
