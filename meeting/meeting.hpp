#pragma once
// Bodies that meet. There is no contact between elastic bodies, nor between them and rigid walls: without a word they would pass through
// each other. So a run is watched, and stops where the surface of a body enters another body, itself or a wall.

#include <cstdint>
#include <string>
#include <vector>

#include "proto/interface.hpp"
#include "scene/case_file.hpp"

namespace tern {

/// What can meet.
struct Meetable {
  /// `body_of_point`: index of the body of every surface point.
  Meetable(const Case& scene, std::vector<std::uint32_t> body_of_point);

  std::vector<std::uint32_t> body;
  std::vector<std::string> body_name;
  std::vector<WallCase> walls;             ///< containers without their open faces
  std::vector<std::vector<Shape>> clamps;  ///< of every body, where it is undeformed
};

/// What is remembered of the surface; empty before the first look at it.
template <int D>
struct MeetingState {
  std::vector<Vector<D>> start;               ///< where every point was at first [m]
  std::vector<double> length;                 ///< of its patch then [m]
  std::vector<double> depth_in_bodies;        ///< then [m]
  std::vector<std::vector<double>> in_walls;  ///< the same of each wall; infinite where it started beyond its face or is held there
  std::vector<Vector<D>> compared;            ///< where every point was when distances between bodies were computed last [m]
  double clearance = 0;                       ///< no two bodies meet before a point has moved as far as this from there [m]

  /// The list of the members: visit(name, member of each) for every one.
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("start", all.start...);
    visit("length", all.length...);
    visit("depth_in_bodies", all.depth_in_bodies...);
    visit("in_walls", all.in_walls...);
    visit("compared", all.compared...);
    visit("clearance", all.clearance...);
  }
};

/// A look at the surface at the instant `time` [s]; the first one is what later ones are compared with: it tells nothing. Throws
/// EndOfModel with names, place and depth when a point lies deeper in another body, in a far part of its own or in a wall than it
/// did at first, by more than a tenth of the length of its patch. A wall is no stranger to the part of a body that is clamped beside it.
template <int D>
void watch_meetings(const Meetable& meetable, double time, const Surface<D>& surface, MeetingState<D>& state);

}  // namespace tern
