#pragma once
// Finds energy from nowhere. What the fluid has, moving and in height, and what the interface has given to the structure cannot grow:
// whatever the structure gives the fluid has been taken from the latter. It does grow where the fluid has seen another motion of the
// surface than the one that came about, the error of every staggering, and where its pressure has answered a motion that did not. In
// every sound run that is a small part of what moves; when a few windows make a tenth of all energy that is present, it is not the scene
// any more that is seen.

#include <deque>

namespace tern::coupler {

class InterfaceEnergy {
 public:
  static constexpr std::size_t windows = 5;
  static constexpr double share = 0.1;

  /// `total`: kinetic and potential energy of the fluid and work of the interface on the structure; `present`: kinetic and strain
  /// energy of both sides; `least`: what counts as energy at all [J/m^(3-D)]. True when the last `windows` have made more than
  /// `share` of what is present and more than the least.
  bool add(double total, double present, double least);

  double made() const { return total_.back() - total_.front(); }  ///< by the last windows
  double present() const { return present_; }

 private:
  std::deque<double> total_;
  double present_ = 0;
};

}  // namespace tern::coupler
