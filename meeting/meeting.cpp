#include "meeting/meeting.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

#include <fmt/format.h>

#include "base/error.hpp"
#include "scene/scene_check.hpp"

namespace tern {
namespace {

constexpr double allowed = 0.1;   ///< depth, in patches, that is no meeting yet
constexpr double far_apart = 3;   ///< patches between parts of one body that are strangers to each other
constexpr double looked_for = 3;  ///< patches within which another surface counts for the clearance
constexpr double beyond = std::numeric_limits<double>::infinity();

/// Point k lies this deep behind the patch of point m of another surface.
struct NearPatch {
  int point;
  std::uint32_t body;  ///< of m
  double depth;        ///< [m]; negative in front of it
};

template <int D>
std::string text_of(const Vector<D>& x) {
  return D == 2 ? fmt::format("({:.4g}, {:.4g}) m", x[0], x[1]) : fmt::format("({:.4g}, {:.4g}, {:.4g}) m", x[0], x[1], x[D - 1]);
}

[[noreturn]] void refuse(const std::string& first, const std::string& second, double depth, double length, double time,
                         const std::string& place) {
  throw EndOfModel(fmt::format(
      "The body '{}' has entered {} by {:.3g} m, {:.2g} of a patch of its surface, at t = {:.4g} s near {}. Contact of bodies is "
      "not modelled: the results are good up to here and would be wrong from here on. End the run before (end_time), or keep "
      "them apart.",
      first, second, depth, depth / length, time, place));
}

/// Pairs of points that are strangers, nearer to each other than a patch; and the least distance of all strangers within `range`.
template <int D>
double find_strangers(const Meetable& meetable, const Surface<D>& surface, const MeetingState<D>& state, double range,
                      std::vector<NearPatch>& near) {
  const auto& x = surface.position;
  Vector<D> low = x[0], high = x[0];
  for (const auto& place : x) low = low.cwiseMin(place), high = high.cwiseMax(place);
  int axis = 0;
  (high - low).maxCoeff(&axis);
  std::vector<int> order(x.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int a, int b) { return std::tie(x[a][axis], a) < std::tie(x[b][axis], b); });

  double least = range;
  const auto look_at = [&](int k, int m, double distance) {
    const bool same = meetable.body[k] == meetable.body[m];
    if (distance >= state.length[m] || (same && surface.normal[k].dot(surface.normal[m]) >= 0)) return;
    near.push_back({k, meetable.body[m], -(x[k] - x[m]).dot(surface.normal[m])});
  };
  for (std::size_t first = 0; first < order.size(); ++first)
    for (std::size_t second = first + 1; second < order.size(); ++second) {
      const int k = order[first], m = order[second];
      if (x[m][axis] - x[k][axis] > range) break;
      const double distance2 = (x[m] - x[k]).squaredNorm();
      if (distance2 > range * range) continue;
      const double strange = far_apart * std::max(state.length[k], state.length[m]);
      if (meetable.body[k] == meetable.body[m] && (state.start[k] - state.start[m]).squaredNorm() < strange * strange) continue;
      const double distance = std::sqrt(distance2);
      least = std::min(least, distance);
      look_at(k, m, distance);
      look_at(m, k, distance);
    }
  return least;
}

/// Depth of every point in other bodies: it lies in one when it is behind all of its patches that are near.
template <int D>
void compare_bodies(const Meetable& meetable, double time, const Surface<D>& surface, bool first_look, MeetingState<D>& state) {
  const double reach = *std::max_element(state.length.begin(), state.length.end());
  std::vector<NearPatch> near;
  const double least = find_strangers(meetable, surface, state, looked_for * reach, near);
  state.compared = surface.position;
  state.clearance = 0.5 * (least - reach);

  std::sort(near.begin(), near.end(),
            [](const NearPatch& a, const NearPatch& b) { return std::tie(a.point, a.body, a.depth) < std::tie(b.point, b.body, b.depth); });
  for (std::size_t n = 0; n < near.size(); ++n) {  // the first of a point and a body has the least depth
    const auto& [k, body, depth] = near[n];
    if (n > 0 && near[n - 1].point == k && near[n - 1].body == body) continue;
    if (first_look) {
      state.depth_in_bodies[k] = std::max(state.depth_in_bodies[k], depth);
    } else if (depth > state.depth_in_bodies[k] + allowed * state.length[k]) {
      refuse(meetable.body_name[meetable.body[k]],
             body == meetable.body[k] ? "itself" : fmt::format("the body '{}'", meetable.body_name[body]), depth, state.length[k], time,
             text_of<D>(surface.position[k]));
    }
  }
}

/// Whether a clamp of the body of point k is within this distance of x.
template <int D>
bool is_held(const Meetable& meetable, std::size_t k, const Vector<D>& x, double distance) {
  const auto& clamps = meetable.clamps[meetable.body[k]];
  return std::any_of(clamps.begin(), clamps.end(), [&](const Shape& clamp) { return signed_distance<D>(clamp, x) < distance; });
}

template <int D>
void compare_walls(const Meetable& meetable, double time, const Surface<D>& surface, bool first_look, MeetingState<D>& state) {
  for (std::size_t w = 0; w < meetable.walls.size(); ++w) {
    const WallCase& wall = meetable.walls[w];
    const Placement<D> place = wall.motion ? placement<D>(*wall.motion, time) : Placement<D>{};
    for (std::size_t k = 0; k < surface.position.size(); ++k) {
      double& at_first = state.in_walls[w][k];
      if (at_first == beyond) continue;
      const double distance = signed_distance<D>(wall.shape, wall.motion ? place.reference(surface.position[k]) : surface.position[k]);
      const double depth = wall.container ? distance : -distance;
      if (first_look) {
        const bool held = depth > -far_apart * state.length[k] && is_held(meetable, k, surface.position[k], far_apart * state.length[k]);
        at_first = held || depth > state.length[k] ? beyond : std::max(depth, 0.0);
      } else if (depth > at_first + allowed * state.length[k]) {
        refuse(meetable.body_name[meetable.body[k]], fmt::format("the wall '{}'", wall.name), depth, state.length[k], time,
               text_of<D>(surface.position[k]));
      }
    }
  }
}

}  // namespace

Meetable::Meetable(const Case& scene, std::vector<std::uint32_t> body_of_point) : body(std::move(body_of_point)), walls(scene.walls) {
  for (const StructureBody& one : scene.structure->bodies) {
    body_name.push_back(one.name);
    clamps.push_back(one.clamps);
  }
  for (WallCase& wall : walls) wall.shape = without_open_faces(wall);
}

template <int D>
void watch_meetings(const Meetable& meetable, double time, const Surface<D>& surface, MeetingState<D>& state) {
  if (surface.position.empty()) return;
  const bool first_look = state.start.empty();
  if (first_look) {
    state.start = surface.position;
    for (double area : surface.area) state.length.push_back(D == 2 ? area : std::sqrt(area));
    state.depth_in_bodies.assign(state.start.size(), 0);
    state.in_walls.assign(meetable.walls.size(), std::vector<double>(state.start.size(), 0));
  }
  compare_walls(meetable, time, surface, first_look, state);

  double moved2 = 0;
  for (std::size_t k = 0; k < state.compared.size(); ++k)
    moved2 = std::max(moved2, (surface.position[k] - state.compared[k]).squaredNorm());
  if (first_look || moved2 >= state.clearance * std::abs(state.clearance)) compare_bodies(meetable, time, surface, first_look, state);
}

template void watch_meetings<2>(const Meetable&, double, const Surface<2>&, MeetingState<2>&);
template void watch_meetings<3>(const Meetable&, double, const Surface<3>&, MeetingState<3>&);

}  // namespace tern
