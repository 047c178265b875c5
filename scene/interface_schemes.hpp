#pragma once
// Interface schemes, a line each: its key in a case file and what it does. The scheme itself is the function of that name in a file of
// coupler/schemes/.

#define TERN_INTERFACE_SCHEMES(LINE)                                   \
  LINE(fsa, "corrected pressure gradient at the face, times its area") \
  LINE(pi, "mean pressure at the face, times its area")                \
  LINE(riemann, "particle by particle, with Riemann dissipation")

namespace tern {

// clang-format off
enum class InterfaceScheme {
#define LINE(name, meaning) name,
  TERN_INTERFACE_SCHEMES(LINE)
#undef LINE
};
// clang-format on

struct InterfaceSchemeName {
  InterfaceScheme scheme;
  const char *key, *meaning;
};
inline constexpr InterfaceSchemeName interface_schemes[] = {
#define LINE(name, meaning) {InterfaceScheme::name, #name, meaning},
    TERN_INTERFACE_SCHEMES(LINE)
#undef LINE
};

inline const InterfaceSchemeName& name_of(InterfaceScheme scheme) { return interface_schemes[static_cast<int>(scheme)]; }

}  // namespace tern
