#pragma once
// What a case file says of the material of a body.

#include <string>

namespace tern {

struct MaterialParameters {
  std::string material = "neo_hookean";  ///< key of the law (structure/material/registry.hpp)
  double density = 0;                    ///< rho_0 [kg/m^3]
  double young_modulus = 0;              ///< E [Pa]
  double poisson_ratio = 0;              ///< nu [-]
  double mooney_ratio = 0.2;             ///< C01/(C10 + C01) of Mooney-Rivlin [-]
  bool plane_stress = false;             ///< 2D: plane stress instead of plane strain
};

}  // namespace tern
