// [coupling] and [coupling.vem]

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "scene/keys/row.hpp"
#include "scene/keys/tables.hpp"

namespace tern {
namespace {

using Presence = TableDefinition::Presence;

std::vector<std::pair<std::string, InterfaceScheme>> scheme_keys() {
  std::vector<std::pair<std::string, InterfaceScheme>> keys;
  for (const auto& [scheme, key, meaning] : interface_schemes) keys.emplace_back(key, scheme);
  return keys;
}

std::string scheme_meanings() {
  std::vector<std::string> meanings;
  for (const auto& [scheme, key, meaning] : interface_schemes) meanings.push_back(fmt::format("{}: {}", key, meaning));
  return fmt::format("{}", fmt::join(meanings, "; "));
}

const Rows<CouplingCase>& coupling_rows() {
  // clang-format off
  static const Rows<CouplingCase> rows = {
      {"algorithm",
       one_of(&CouplingCase::algorithm, {{"auto", CouplingAlgorithm::automatic},
                                         {"explicit", CouplingAlgorithm::explicit_staggering}}),
       "", "\"auto\"", any,
       "auto: predict, project, correct, in the way in which the surface has been seen to answer, and repeated in windows after which "
       "fluid and structure do not agree; windows are half as long where the mass behind a face is at most that of half a layer of fluid "
       "particles, and all repeated until the load changes by 1e-4 where it is at most a twentieth. "
       "explicit: staggered, unstable where the fluid's added mass exceeds the mass of the structure; for studies."},
      {"max_iterations", &CouplingCase::max_iterations, "-", "50", from_to(1, 1000),
       "Passes of a window at most, not of explicit. A load that still changes by 0.05 of itself then ends the run, or the window is "
       "repeated at half its length. 1: one pass that is not tested, for studies."},
      {"tolerance", &CouplingCase::tolerance, "-", absent, between(0, 1),
       "Change of the load in one pass, over the load, at which a window is done, not of explicit; every window is repeated then, for "
       "studies. Absent: a window is done where the surface moves as the fluid has taken it to."},
      {"scheme", one_of(&CouplingCase::scheme, scheme_keys()), "", "\"riemann\"", any,
       "How the fluid's pressure becomes a load (docs/SCHEMES.md). " + scheme_meanings() + "."},
      {"riemann_limiter", &CouplingCase::riemann_limiter, "-", "3.0", a_factor,
       "Limiter eta of the Riemann dissipation, beta = min(eta max(du, 0)/c0, 1); 0 = none. Of scheme riemann only."},
      {"robin_mass_factor", &CouplingCase::robin_mass_factor, "-", "1.0", between(0, 2),
       "Mass with which the interface yields in the pressure solve over the mass that answers, m_p/m_s, learnt or by formula; not "
       "where every window is repeated."},
  };
  // clang-format on
  return rows;
}

const Rows<CouplingCase>& vem_rows() {
  // clang-format off
  static const Rows<CouplingCase> rows = {
      {"coefficient", &CouplingCase::vem_coefficient, "-", required, above_to(0, 10),
       "Coefficient C; 1 is advised, 5 over-predicts impact loads."},
      {"form", one_of(&CouplingCase::vem_form, {{"seed", VemForm::seed}, {"sum", VemForm::sum}, {"pairmax", VemForm::pairmax}}),
       "", "\"pairmax\"", any,
       "pairmax: pushes apart where the fluid converges; sum: pulls together too where it diverges; seed: each side switches by itself "
       "as published, which does not conserve momentum."},
  };
  // clang-format on
  return rows;
}

}  // namespace

std::vector<TableDefinition> coupling_tables() {
  return {{"coupling", false, Presence::filled, "What happens between fluid and structure; only in a case that has both.",
           parameters_of(coupling_rows())},
          {"coupling.vem", false, Presence::optional,
           "The velocity-divergence-error-mitigating term at the interface; absent = not evaluated.", parameters_of(vem_rows())}};
}

CouplingCase read_coupling(const Setting& table) {
  CouplingCase coupling = default_coupling();
  fill(coupling, coupling_rows(), table);
  if (const Setting* vem = table.find("vem")) fill(coupling, vem_rows(), *vem);
  return coupling;
}

CouplingCase default_coupling() {
  static const CouplingCase coupling = [] {
    CouplingCase all{};
    fill_defaults(all, coupling_rows());
    fill_defaults(all, vem_rows());
    return all;
  }();
  return coupling;
}

}  // namespace tern
