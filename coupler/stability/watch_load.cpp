#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/error.hpp"
#include "coupler/stability/observations.hpp"
#include "coupler/workspace.hpp"

namespace tern::coupler {
namespace {

/// Amplitude of an alternating load from which it counts, by how far it moves both a layer of fluid particles and the surface in a window,
/// over the spacing. A load that hardly moves the body is none that the coupling makes: the fluid has it by itself.
constexpr double least_alternation = 1e-3;

/// The load on one body, and where.
template <int D>
struct BodyLoad {
  Eigen::VectorXd load;
  std::vector<std::size_t> point;
  double area = 0;  ///< root of the sum of squares [m^(D-1)]
  double mass = 0;  ///< harmonic mean of what answers in a window [kg/m^2]
};

template <int D>
BodyLoad<D> load_on(std::size_t body, const SurfaceProperties& properties, const Workspace<D>& window) {
  BodyLoad<D> own;
  double area = 0, squares = 0, quickness = 0;
  for (std::size_t k = 0; k < window.load.force.size(); ++k) {
    if (properties.body[k] != body) continue;
    own.point.push_back(k);
    area += window.surface.area[k];
    squares += window.surface.area[k] * window.surface.area[k];
    quickness += window.surface.area[k] / window.responding_mass[k];
  }
  own.load.resize(D * static_cast<Eigen::Index>(own.point.size()));
  for (std::size_t m = 0; m < own.point.size(); ++m)
    own.load.template segment<D>(D * static_cast<Eigen::Index>(m)) = window.load.force[own.point[m]];
  own.area = std::sqrt(squares);
  own.mass = quickness > 0 ? area / quickness : 0;
  return own;
}

/// Place of the largest kink, in words.
template <int D>
std::string worst_place(const LoadAlternation& alternation, const std::vector<std::size_t>& point, const Surface<D>& surface) {
  std::size_t worst = 0;
  const auto size = [&](std::size_t m) { return alternation.kink().template segment<D>(D * static_cast<Eigen::Index>(m)).norm(); };
  for (std::size_t m = 1; m < point.size(); ++m)
    if (size(m) > size(worst)) worst = m;
  std::string place;
  for (int c = 0; c < D; ++c) place += fmt::format("{}{:.5g}", c ? ", " : "", surface.position[point[worst]][c]);
  return place;
}

}  // namespace

template <int D>
void watch_load(const Setup<D>& setup, const Workspace<D>& window, Observations& seen) {
  const double acceleration = least_alternation * setup.spacing / (window.duration * window.duration);
  for (std::size_t b = 0; b < seen.alternation.size(); ++b) {
    const BodyLoad<D> own = load_on(b, setup.properties, window);
    LoadAlternation& alternation = seen.alternation[b];
    const double least = acceleration * std::max(setup.density * setup.spacing, own.mass);  // Pa
    if (!alternation.add(own.load, least * own.area)) continue;
    throw NumericalFailure(fmt::format(
        "The load on body '{}' turns round from window to window at t = {:.6g} s: by {:.3g} {} (norm over its surface points) "
        "about a mean of {:.3g}, most near ({}) m, and without dying out; the limit is the mean, or a tenth of it when it grows by half "
        "every {} windows. The coupling makes this load: {}.",
        setup.body_name[b], window.begin + window.duration, alternation.amplitude(), D == 2 ? "N/m" : "N", alternation.mean(),
        worst_place(alternation, own.point, window.surface), LoadAlternation::reversals, setup.remedy));
  }
}

template void watch_load<2>(const Setup<2>&, const Workspace<2>&, Observations&);
template void watch_load<3>(const Setup<3>&, const Workspace<3>&, Observations&);

}  // namespace tern::coupler
