#pragma once
// The materials: isotropic hyperelastic solids, P = dPsi/dF. A new one is a file beside this one and its name in MaterialLaw;
// case files, checks and documents take its key and words from there.
//
// In 2D a law is that of plane strain (F33 = 1) or plane stress (F33 such that P33 = 0; Psi is then the minimum over F33, so
// that dPsi/dF of the plane part needs no further term). Each law has, from H = F - I and F of D x D:
//   key, name, meaning      in case files, in messages, in the documents; weakness: why it may fail (a clause), or null
//   energy_density(H, F)    Psi [J/m^3]
//   stress(H, F, F^-T, det F, P)   first Piola-Kirchhoff stress of four particles (Lanes) or one (double) [Pa]
//   tangent(F)              d2Psi/dF dF [Pa], in plane stress with the thickness at its minimum
//   modulus_at(s)           d2Psi/ds2 along a direction stretched by s, from which the wave speed follows [Pa]
//   out_of_plane(H, det F)  2D: F33 and sigma_33

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "base/error.hpp"
#include "structure/material/mooney_rivlin.hpp"
#include "structure/material/neo_hookean.hpp"
#include "structure/material/st_venant_kirchhoff.hpp"

namespace tern::structure {

using MaterialLaw = std::variant<NeoHookean, StVenantKirchhoff, MooneyRivlin>;

/// found.operator()<Law>() for each material, in the order of MaterialLaw.
template <class Found>
void for_each_material(const Found& found) {
  [&]<std::size_t... n>(std::index_sequence<n...>) { (found.template operator()<std::variant_alternative_t<n, MaterialLaw>>(), ...); }
  (std::make_index_sequence<std::variant_size_v<MaterialLaw>>());
}

/// Choices of `material` in a case file.
inline std::vector<std::string> material_keys() {
  std::vector<std::string> keys;
  for_each_material([&]<class Law>() { keys.push_back(Law::key); });
  return keys;
}

/// A body's material: Hooke's law, which it follows at small strain, and its own.
struct Material : Hooke {
  MaterialLaw law;

  /// Throws BadInput when `parameters.material` is none of material_keys().
  explicit Material(const MaterialParameters& parameters) : Hooke(parameters), law(NeoHookean(parameters)) {
    bool found = false;
    for_each_material([&]<class Law>() {
      if (parameters.material != Law::key) return;
      law = Law(parameters);
      found = true;
    });
    if (!found) throw BadInput("There is no material '" + parameters.material + "'.");
  }

  /// Whether the law has a form for a layer of particles, a shell.
  bool has_law_of_a_layer() const { return std::holds_alternative<NeoHookean>(law) || std::holds_alternative<StVenantKirchhoff>(law); }

  /// Wave speed along a direction stretched by `stretch` [m/s].
  double wave_speed_at(double stretch) const {
    const double modulus = std::visit([&](const auto& own) { return own.modulus_at(stretch); }, law);
    return std::sqrt(std::max(modulus, 0.0) / density);
  }
  const char* name() const {
    return std::visit([](const auto& own) { return own.name; }, law);
  }
};

}  // namespace tern::structure
