#include "coupler/schemes/scheme.hpp"

namespace tern::coupler {

#define LINE(name, meaning) \
  template <int D>          \
  Scheme<D> name();
TERN_INTERFACE_SCHEMES(LINE)
#undef LINE

template <int D>
const Scheme<D>& scheme_of(InterfaceScheme scheme) {
#define LINE(name, meaning) name<D>(),
  static const Scheme<D> schemes[] = {TERN_INTERFACE_SCHEMES(LINE)};
#undef LINE
  return schemes[static_cast<int>(scheme)];
}

template <int D>
std::vector<double> uniform_load(const Scheme<D>& scheme, const InterfacePairs<D>& pairs) {
  std::vector<double> filled = pairs.filled();
  for (double& f : filled) f = scheme.load_share(f);
  return filled;
}

template const Scheme<2>& scheme_of<2>(InterfaceScheme);
template const Scheme<3>& scheme_of<3>(InterfaceScheme);
template std::vector<double> uniform_load<2>(const Scheme<2>&, const InterfacePairs<2>&);
template std::vector<double> uniform_load<3>(const Scheme<3>&, const InterfacePairs<3>&);

}  // namespace tern::coupler
