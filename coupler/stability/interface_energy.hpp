#pragma once
// Detects spurious energy: the energy of the fluid, kinetic and potential, plus the work of the interface on the structure must not grow.
// It grows where the fluid has seen another motion of the surface than the one that came about, which is the error of every staggering. In
// a sound run that is a small part of the energy present. A run in which a few windows make a tenth of all energy is lost.

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

  /// The list of the members: visit(name, member of each) for every one.
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("total", all.total_...);
    visit("present", all.present_...);
  }

 private:
  std::deque<double> total_;
  double present_ = 0;
};

}  // namespace tern::coupler
