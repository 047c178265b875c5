// What moves: walls and clamps.

#include <fmt/format.h>

#include <cmath>

#include "base/error.hpp"
#include "scene/checks/checks.hpp"
#include "scene/parameter_table.hpp"

namespace tern {
namespace {

constexpr int instants = 500;  // of the run at which motions are looked at

template <int D>
void check_motion(const std::optional<RigidMotion>& motion, const Setting& table, const std::string& mover, double end_time) {
  if (!motion) return;
  const Setting* key = nullptr;
  for (const char* name : {"displacement", "rotation", "motion_file"})
    if (!key) key = table.find(name);
  const std::string& where = key ? key->where : table.where;
  for (int k = 0; k <= instants; ++k) {
    const double t = end_time * k / instants;
    try {
      const Placement<D> place = placement<D>(*motion, t);
      const double farthest = std::max(place.shift.cwiseAbs().maxCoeff(), std::abs(place.angle));
      if (farthest <= a_place.highest) continue;
      fail_at(where, fmt::format("the {} is displaced by {:.3g} m or turned by {:.3g} rad at t = {:.6g} s, but at most {:g} of either is "
                                 "allowed; correct its motion.",
                                 mover, place.shift.cwiseAbs().maxCoeff(), std::abs(place.angle), t, a_place.highest));
    } catch (const NumericalFailure& fault) {
      fail_at(where, fmt::format("{}: {}", mover, fault.what()));
    }
  }
}

}  // namespace

template <int D>
void check_motions(const Case& scene, const Setting& settings) {
  for (std::size_t i = 0; i < scene.walls.size(); ++i)
    check_motion<D>(scene.walls[i].motion, settings.at("wall").items[i], "wall '" + scene.walls[i].name + "'", scene.end_time);
  if (!scene.structure) return;
  const auto& clamps = scene.structure->clamps;
  for (std::size_t i = 0; i < clamps.size(); ++i)
    check_motion<D>(clamps[i].motion, settings.at("structure").at("clamp").items[i], "clamp '" + clamps[i].name + "'", scene.end_time);
}

template void check_motions<2>(const Case&, const Setting&);
template void check_motions<3>(const Case&, const Setting&);

}  // namespace tern
