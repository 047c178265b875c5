#include "coupler/stability/interface_energy.hpp"

namespace tern::coupler {

bool InterfaceEnergy::add(double total, double present, double least) {
  total_.push_back(total);
  if (total_.size() > windows + 1) total_.pop_front();
  present_ = present;
  return made() > share * present && made() > least;
}

}  // namespace tern::coupler
