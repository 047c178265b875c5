// Stability of the coupling over density ratio, thickness, stiffness, wet faces and algorithm (tests/coupler/coupled_scenes.hpp).
// Prints the table of docs/STABILITY.md:  build/release/bench/bench-coupling_stability [words]
// With words, only the rows that have them. Ends with 1 when the default is wrong anywhere.

#include <ctime>
#include <map>

#include "tests/coupler/coupled_scenes.hpp"

namespace {

using namespace tern;
using namespace tern::coupler::testing;
using Verdict = CoupledOutcome::Verdict;

/// `0.46, 0.022; 4.3 trials`: largest speed, unrest, and what CM3 took.
std::string describe(const CoupledOutcome& o) {
  if (o.verdict == Verdict::stopped) return fmt::format("stopped after {}", o.windows);
  if (o.verdict == Verdict::wrong) return fmt::format("**wrong** ({:.1f}, {:.2f})", o.largest_speed, o.unrest);
  return fmt::format("{:.2f}, {:.3f}", o.largest_speed, o.unrest) + (o.trials > 0 ? fmt::format("; {:.1f} trials", o.trials) : "");
}

}  // namespace

int main(int argc, char** argv) {
  const std::pair<const char*, CouplingAlgorithm> algorithms[] = {
      {"CM0", CouplingAlgorithm::cm0}, {"CM2", CouplingAlgorithm::cm2}, {"CM3", CouplingAlgorithm::cm3}};
  constexpr double until = 0.1;
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
          Verdict by_default = Verdict::wrong;
          for (const auto& [name, algorithm] : algorithms) {
            s.algorithm = algorithm;
            const CoupledOutcome o = run(s, until);
            ++count[name][o.verdict];
            if (algorithm == default_algorithm) ++count["default"][by_default = o.verdict];
            fmt::print(" {} |", describe(o));
            std::fflush(stdout);
          }
          wrong = wrong || by_default == Verdict::wrong;
          fmt::print(" {}", default_algorithm == CouplingAlgorithm::cm3 ? "CM3" : "CM2");
          if (by_default != Verdict::bounded) {
            s.algorithm = default_algorithm;
            s.window = 0.3;
            const CoupledOutcome o = run(s, until);
            ++count["not bounded by default, windows 0.3 as long"][o.verdict];
            fmt::print("; windows 0.3 as long: {}", describe(o));
          }
          fmt::print(" |\n");
        }
  fmt::print("\n");
  for (auto& [name, of] : count)
    fmt::print("{}: {} bounded, {} stopped, {} wrong\n", name, of[Verdict::bounded], of[Verdict::stopped], of[Verdict::wrong]);
  fmt::print("{:.0f} s of CPU\n", static_cast<double>(std::clock()) / CLOCKS_PER_SEC);
  return wrong;
}
