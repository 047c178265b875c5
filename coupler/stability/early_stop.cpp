// What staggering spoils, ended by name within a few windows (load_alternation.hpp, interface_energy.hpp).

#include <cmath>

#include <fmt/format.h>

#include "base/error.hpp"
#include "coupler/coupling_step.hpp"

namespace tern::coupler {
namespace {

/// Amplitude of an alternating load from which it counts, by how far it moves a layer of fluid particles in a window, over their
/// spacing.
constexpr double least_alternation = 1e-3;
constexpr double least_energy = 0.02;  ///< that counts, over that of the scene

}  // namespace

template <int D>
void CouplingStep<D>::check_alternation() {
  const double unit = least_alternation * density_ * spacing_ * spacing_ / (duration_ * duration_);  // Pa
  for (std::size_t b = 0; b < alternation_.size(); ++b) {
    SurfaceLoad<D> own;
    std::vector<std::size_t> point;
    double area = 0;
    for (std::size_t k = 0; k < load_.force.size(); ++k) {
      if (properties_.body[k] != b) continue;
      own.force.push_back(load_.force[k]);
      point.push_back(k);
      area += surface_.area[k] * surface_.area[k];
    }
    LoadAlternation& alternation = alternation_[b];
    if (!alternation.add(flat(own), unit * std::sqrt(area))) continue;
    std::size_t worst = 0;
    const auto size = [&](std::size_t m) { return alternation.kink().template segment<D>(D * static_cast<Eigen::Index>(m)).norm(); };
    for (std::size_t m = 1; m < point.size(); ++m)
      if (size(m) > size(worst)) worst = m;
    std::string place;
    for (int c = 0; c < D; ++c) place += fmt::format("{}{:.5g}", c ? ", " : "", surface_.position[point[worst]][c]);
    throw NumericalFailure(fmt::format(
        "The load on body '{}' turns round from window to window at t = {:.6g} s: by {:.3g} {} (norm over its surface points) "
        "about a mean of {:.3g}, most near ({}) m, and without dying out; the limit is the mean, or a tenth of it when it grows by half "
        "every {} windows. The coupling makes this load: {}.",
        body_name_[b], begin_ + duration_, alternation.amplitude(), D == 2 ? "N/m" : "N", alternation.mean(), place,
        LoadAlternation::reversals, remedy()));
  }
}

template <int D>
const char* CouplingStep<D>::remedy() const {
  if (algorithm_ == CouplingAlgorithm::cm0)
    return "explicit staggering is unstable for a body that is light for its fluid, or that vibrates faster than the windows "
           "resolve, use coupling.algorithm = \"CM2\" or \"CM3\"";
  if (algorithm_ == CouplingAlgorithm::cm2) return "the body is too light for one pass, use coupling.algorithm = \"CM3\"";
  return "the windows are too long for a body as light as this, use a smaller fluid.numerics.gravity_courant and courant, or a "
         "heavier or thicker body";
}

template <int D>
void CouplingStep<D>::check_energy(double time, double total, double present) {
  // What counts: a fiftieth of the energy that the weight of the fluid beside the bodies and its motion at the start have; where there is
  // neither, the motion of a layer of particles at the speed that the window is made for.
  double area = 0;
  for (double a : surface_.area) area += a;
  if (!energy_at_start_) energy_at_start_ = present;
  const double of_scene = fluid_weight_.energy(area) + *energy_at_start_, speed = duration_ > 0 ? courant_ * spacing_ / duration_ : 0;
  if (!energy_.add(total, present, of_scene > 0 ? least_energy * of_scene : 0.5 * density_ * spacing_ * area * speed * speed)) return;
  throw NumericalFailure(fmt::format(
      "The interface has made {:.3g} {} in the last {} windows up to t = {:.6g} s, of {:.3g} that are present as motion and strain; "
      "the limit is {:g} of it. The fluid sees another motion of the bodies' surface than they make: {}.",
      energy_.made(), D == 2 ? "J/m" : "J", InterfaceEnergy::windows, time, present, InterfaceEnergy::share, remedy()));
}

template void CouplingStep<2>::check_alternation();
template void CouplingStep<3>::check_alternation();
template void CouplingStep<2>::check_energy(double, double, double);
template void CouplingStep<3>::check_energy(double, double, double);
template const char* CouplingStep<2>::remedy() const;
template const char* CouplingStep<3>::remedy() const;

}  // namespace tern::coupler
