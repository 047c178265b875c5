#include "fluid/gauges/probe.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "fluid/boundary/wetness.hpp"
#include "fluid/motion/viscosity.hpp"
#include "scene/scene_check.hpp"
#include "sph/symmetric_matrix.hpp"
#include "sph/wet_share.hpp"

namespace tern::fluid {
namespace {

constexpr double joined = 1.5;        ///< in dx: the next particle of a sheet is nearer
constexpr double off_wall = 0.01;     ///< in dx
constexpr double least_space = 0.02;  ///< that a wall leaves to be filled, as in wetness.cpp
constexpr double sampling = 0.25;     ///< in dx, along lines

/// Two unit vectors that span the plane across the unit vector n; the second is meant for 3D only.
template <int D>
std::array<Vector<D>, 2> tangents(const Vector<D>& n) {
  if constexpr (D == 2) {
    return {Vector<2>(-n[1], n[0]), Vector<2>::Zero()};
  } else {
    int axis = 0;
    n.cwiseAbs().minCoeff(&axis);
    const Vector<3> first = n.cross(Vector<3>::Unit(axis)).normalized();
    return {first, n.cross(first)};
  }
}

/// Length (2D) and corners of the area across a flux: normal and the edges from `from` that span it.
template <int D>
struct Section {
  Vector<D> normal;
  std::array<Vector<D>, D - 1> edges;
};

template <int D>
Section<D> section(const Vector<D>& from, const Vector<D>& to) {
  const Vector<D> d = to - from;
  if constexpr (D == 2) {
    return {Vector<2>(d[1], -d[0]).normalized(), {d}};
  } else {
    int axis = 0;
    d.cwiseAbs().minCoeff(&axis);
    const int one = (axis + 1) % 3, other = (axis + 2) % 3;
    return {Vector<3>::Unit(axis), {d[one] * Vector<3>::Unit(one), d[other] * Vector<3>::Unit(other)}};
  }
}

}  // namespace

template <int D>
Probe<D>::Probe(const Fluid<D>& fluid, Moment moment)
    : fluid_(fluid), time_(seconds(fluid.state().time)), position_(moment == Moment::middle ? in_middle_ : fluid.state().position) {
  if (moment == Moment::middle) {
    const double half = 0.5 * fluid.window_length();
    time_ -= half;
    in_middle_ = fluid.state().position;
    for (std::size_t i = 0; i < in_middle_.size(); ++i) in_middle_[i] -= half * fluid.state().velocity[i];
  }
  for (const Wall<D>& wall : fluid.walls().all())
    if (wall.scene.container) containers_.emplace_back(&wall, without_open_faces(wall.scene));
  low_ = high_ = position_[0];
  for (const auto& x : position_) low_ = low_.cwiseMin(x), high_ = high_.cwiseMax(x);
  grid_.reset(low_, high_, fluid.constants().kernel.support());
  contents_.template fill<D>(grid_, position_);
}

/// Calls visit(i, d, w) for each particle within the support of x: the vector d from x to it, w = V w(|d|).
template <int D>
template <class Visit>
void Probe<D>::for_particles_around(const Vector<D>& x, Visit&& visit) const {
  const Constants<D>& constants = fluid_.constants();
  const auto around = [&](const Vector<D>& image) {
    grid_.for_rows_around(image, [&](int low, int high) {
      for (int entry = contents_.start[low]; entry < contents_.start[high + 1]; ++entry) {
        const int i = contents_.order[entry];
        const Vector<D> d = position_[i] - image;
        const double r = d.norm();
        if (r < constants.kernel.support()) visit(i, d, constants.volume * constants.kernel.value(r));
      }
    });
  };
  around(x);
  if (fluid_.period().any())
    for_images(fluid_.period(), x, low_, high_, constants.kernel.support(), [&](const Vector<D>& shift) { around(x + shift); });
}

/// A point on a wall sees it only from a little nearer to the fluid.
template <int D>
Vector<D> Probe<D>::off_wall_at(const Vector<D>& x, const Vector<D>& normal) const {
  return x + off_wall * fluid_.constants().spacing * normal;
}

template <int D>
bool Probe<D>::any_around(const Vector<D>& x) const {
  if (fluid_.period().any()) return true;
  bool any = false;
  grid_.for_rows_around(x, [&](int low, int high) { any = any || contents_.start[high + 1] > contents_.start[low]; });
  return any;
}

template <int D>
std::optional<double> Probe<D>::pressure(const Vector<D>& x) const {
  // Weighted linear fit over the fluid around x: exact for a hydrostatic field up to the wall itself.
  constexpr int unknowns = D + 1;
  Eigen::Matrix<double, unknowns, unknowns> a = Eigen::Matrix<double, unknowns, unknowns>::Zero();
  Eigen::Matrix<double, unknowns, 1> b = Eigen::Matrix<double, unknowns, 1>::Zero();
  double filled = 0;
  for_particles_around(x, [&](int i, const Vector<D>& d, double w) {
    Eigen::Matrix<double, unknowns, 1> basis;
    basis << 1, d / fluid_.constants().spacing;
    a += w * basis * basis.transpose();
    b += w * fluid_.state().pressure[i] * basis;
    filled += w;
  });
  if (filled < 0.35) return std::nullopt;
  const Eigen::MatrixXd inverse = inverse_of_moments(a);
  return inverse.size() > 0 ? std::optional<double>(inverse.row(0).dot(b)) : std::nullopt;
}

/// Share of the kernel around x behind walls and structure: the hidden part of sum V w.
template <int D>
double Probe<D>::hidden(const Vector<D>& x) const {
  double sum = 0;
  std::vector<int> seen;
  for (const auto& [faces, finder] : fluid_.faces()) sum += hidden_density(fluid_.constants(), *faces, *finder, x, seen);
  return sum;
}

template <int D>
double Probe<D>::filling(const Vector<D>& x) const {
  double sum = 0;
  Vector<D> centroid = Vector<D>::Zero();
  for_particles_around(x, [&](int, const Vector<D>& d, double w) { sum += w, centroid += w * d; });
  return filling(x, sum, centroid);
}

/// As above, of the sums of w and w d over the particles around x.
template <int D>
double Probe<D>::filling(const Vector<D>& x, double sum, const Vector<D>& centroid) const {
  if (sum == 0) return 0;
  // Deep in a corner little is left to be filled, and the quotient would be noise.
  return sum / std::max(fluid_.constants().lattice.density - hidden(off_wall_at(x, centroid.normalized())), 0.1);
}

template <int D>
std::optional<double> Probe<D>::elevation(const Vector<D>& x) const {
  const double dx = fluid_.constants().spacing, support = fluid_.constants().kernel.support(), step = sampling * dx;
  const auto [axis, sense] = fluid_.reference().up;
  double low = 1e300, high = -1e300;  // heights, as of what follows
  for (const Vector<D>& particle : position_) {
    Vector<D> d = fluid_.period().nearest(particle - x);
    d[axis] = 0;
    if (d.norm() > support) continue;
    low = std::min(low, sense * particle[axis]), high = std::max(high, sense * particle[axis]);
  }
  std::optional<double> surface;
  double above = 0, left_at = 0;   // left_at: where the walk down last came out of water
  int dry = 0, dry_and_solid = 0;  // places since then
  bool inside = false;
  Vector<D> point = x;
  for (double height = high + dx; height > low - 0.5 * step; height -= step) {
    point[axis] = sense * height;
    const double here = filling(point);
    if (inside != (here >= 0.5)) {
      const double crossing = height + step * (here - 0.5) / (here - above);
      if (inside)
        left_at = crossing, dry = dry_and_solid = 0;
      else
        surface = surface ? *surface - (left_at - crossing) * (dry - dry_and_solid) / std::max(dry, 1) : crossing;
      inside = !inside;
    }
    if (!inside && surface) ++dry, dry_and_solid += solid(point);
    above = here;
  }
  if (surface) *surface *= sense;
  return surface;
}

template <int D>
double Probe<D>::flux(const Vector<D>& from, const Vector<D>& to) const {
  const Section<D> across = section<D>(from, to);
  std::array<int, 2> count{1, 1};
  double area = 1;
  for (int k = 0; k < D - 1; ++k) {
    count[k] = std::max(1, static_cast<int>(std::ceil(across.edges[k].norm() / (sampling * fluid_.constants().spacing))));
    area *= across.edges[k].norm() / count[k];
  }
  double sum = 0;
  for (int b = 0; b < count[1]; ++b)
    for (int a = 0; a < count[0]; ++a) {
      Vector<D> x = from + (a + 0.5) / count[0] * across.edges[0];
      if constexpr (D == 3) x += (b + 0.5) / count[1] * across.edges[1];
      Vector<D> momentum = Vector<D>::Zero(), centroid = Vector<D>::Zero();
      double weight = 0;
      for_particles_around(x, [&](int i, const Vector<D>& d, double w) {
        momentum += w * fluid_.state().velocity[i];
        centroid += w * d;
        weight += w;
      });
      if (weight == 0) continue;
      // From nothing outside to all inside across the free surface, so that the flux does not jump from point to point.
      // What walls hide makes it fuller: where it is full without, they are not looked at.
      const bool is_full = wet_share(weight / fluid_.constants().lattice.density) == 1;
      const double wet = is_full ? 1 : wet_share(filling(x, weight, centroid));
      sum += area * wet * momentum.dot(across.normal) / weight;
    }
  return sum;
}

template <int D>
bool Probe<D>::covered(const Vector<D>& x) const {
  const auto [faces, finder] = fluid_.faces()[1];
  int nearest = -1;
  double least = 0;
  finder->for_each_around(x, [&, &faces = *faces](int k) {
    const double distance = (x - faces.position[k]).squaredNorm();
    if (nearest < 0 || distance < least) nearest = k, least = distance;
  });
  return nearest >= 0 && (x - faces->position[nearest]).dot(faces->normal[nearest]) < 0;
}

template <int D>
bool Probe<D>::obstructed(const Vector<D>& x) const {
  for (const Wall<D>& wall : fluid_.walls().all())
    if (!wall.scene.container && contains<D>(wall.scene.shape, wall.reference(x))) return true;
  return covered(x);
}

template <int D>
bool Probe<D>::solid(const Vector<D>& x) const {
  if (obstructed(x)) return true;
  for (const auto& [wall, shape] : containers_)
    if (signed_distance<D>(shape, wall->reference(x)) >= 0) return true;
  return false;
}

template <int D>
std::vector<typename Probe<D>::Near> Probe<D>::before_wall(const Vector<D>& x, const Vector<D>& normal) const {
  std::vector<Near> before;
  for_particles_around(x, [&](int i, const Vector<D>& d, double w) {
    if (!fluid_.state().particle_class[i].spray() && d.dot(normal) > 0) before.push_back({i, d, w});
  });
  if (before.empty()) return before;  // most walls are dry, and what follows takes longer
  const Vector<D> eye = off_wall_at(x, normal);
  if (obstructed(eye)) return {};  // another wall may stand on this one, or a body
  std::vector<std::pair<const Faces<D>*, int>> screens;
  std::vector<int> seen;
  for (const auto& [faces, finder] : fluid_.faces()) {
    seen.clear();
    finder->see(*faces, eye, seen);
    for (int k : seen)
      if (faces->two_sided[k]) screens.emplace_back(faces, k);
  }
  std::erase_if(before, [&](const Near& near) {
    return std::any_of(screens.begin(), screens.end(),
                       [&](const auto& screen) { return patch_separates(*screen.first, screen.second, eye, Vector<D>(x + near.d)); });
  });
  return before;
}

// Mean of what the wall mirrors of each particle before it, p = p_i + rho (g - a_w) . (x - x_i): the pressure that the
// pressure gradient of the step uses behind walls (boundary.cpp).
template <int D>
double Probe<D>::wall_pressure(const std::vector<Near>& before, const Vector<D>& x, const Vector<D>& normal,
                               double normal_acceleration) const {
  const Constants<D>& constants = fluid_.constants();
  const Vector<D> acceleration = fluid_.gravity_at(time_, x) - normal_acceleration * normal;
  double sum = 0, weight = 0;
  for (const Near& near : before) {
    sum += near.w * (fluid_.state().pressure[near.i] - constants.density * acceleration.dot(near.d));
    weight += near.w;
  }
  return weight > 0 ? sum / weight : 0;
}

template <int D>
std::pair<double, Vector<D>> Probe<D>::open_part(const Faces<D>& faces, std::size_t k) const {
  constexpr int count = 4;  // along each side
  const double side = D == 2 ? faces.area[k] : std::sqrt(faces.area[k]);
  const auto along = tangents<D>(faces.normal[k]);
  const Vector<D> eye = off_wall_at(faces.position[k], faces.normal[k]);
  Vector<D> sum = Vector<D>::Zero();
  int open = 0, all = 0;
  for (int b = 0; b < (D == 2 ? 1 : count); ++b)
    for (int a = 0; a < count; ++a) {
      const Vector<D> off = side * (((a + 0.5) / count - 0.5) * along[0] + (D == 2 ? 0 : (b + 0.5) / count - 0.5) * along[1]);
      ++all;
      if (solid(eye + off)) continue;
      ++open;
      sum += off;
    }
  return {double(open) / all, faces.position[k] + sum / std::max(open, 1)};
}

// As in the sums of the fluid over the hidden side (wetness.cpp).
template <int D>
double Probe<D>::share_of_wall(const std::vector<Near>& before, double space) const {
  double filled = 0;
  for (const Near& near : before) filled += near.w;
  return filled == 0 ? 0 : wet_share(filled / std::max(space, least_space));
}

template <int D>
double Probe<D>::space_before(const Faces<D>& faces, std::size_t k) const {
  const auto [bodies, finder] = fluid_.faces()[1];
  if (bodies->size() == 0) return fluid_.space_before_wall(k);
  std::vector<int> seen;
  return fluid_.space_before_wall(k) -
         hidden_density(fluid_.constants(), *bodies, *finder, off_wall_at(faces.position[k], faces.normal[k]), seen);
}

// What add_viscosity() takes from the particles before the patch, mu sum_i 2 V A_k w~ (u_i - u_k)/y, but with velocities as seen by one who
// turns with the wall, u_k + omega x d for u_k: the traction is mu (du/dn + grad(u . n)). Its second part does nothing to a fluid of one
// viscosity, but is there on the wall, to which the fluid sticks: grad(u . n) = -omega x n.
template <int D>
Vector<D> Probe<D>::friction(const std::vector<Near>& before, const Wall<D>& wall, const Faces<D>& faces, std::size_t k) const {
  const Constants<D>& constants = fluid_.constants();
  Vector<D> force = Vector<D>::Zero();
  for (const Near& near : before) {
    const double height = seen_height(constants, near.d.dot(faces.normal[k]));
    Vector<D> of_wall = faces.velocity_of(k);
    if (wall.scene.motion) of_wall += turning_velocity<D>(wall.now.turn_rate, wall.scene.motion->axis, near.d);
    force += constants.faces.surface_weight(near.d.norm()) / height * (fluid_.state().velocity[near.i] - of_wall);
  }
  return 2 * constants.viscosity * constants.mass * faces.area[k] * force;
}

// The patch that has stopped a particle: the nearest of those that look the way of what has been taken away.
template <int D>
template <class Visit>
void Probe<D>::for_contacts(const Wall<D>& wall, bool spray, Visit&& visit) const {
  const State<D>& state = fluid_.state();
  const auto [faces, finder] = fluid_.faces()[0];
  for (std::size_t i = 0; i < state.size(); ++i) {
    const double size = state.stopped[i].norm();
    if (size == 0 || (!spray && state.particle_class[i].spray())) continue;
    int nearest = -1;
    double least = 0;
    finder->for_each_around(position_[i], [&, &faces = *faces](int k) {
      const double distance = (position_[i] - faces.position[k]).squaredNorm();
      if (faces.normal[k].dot(state.stopped[i]) > 0.5 * size && (nearest < 0 || distance < least)) nearest = k, least = distance;
    });
    if (nearest < 0) continue;
    const std::size_t k = static_cast<std::size_t>(faces->original_of(nearest));
    if (k >= wall.first && k < wall.last) visit(k, Vector<D>(-fluid_.constants().mass * state.stopped[i]));
  }
}

template <int D>
std::optional<double> Probe<D>::sensor(const Wall<D>& wall, const Vector<D>& at, double diameter) const {
  const Faces<D>& faces = fluid_.walls().faces();
  const Vector<D> centre = wall.now.place(at);
  const auto squared = [&](std::size_t k, const Vector<D>& x) { return (faces.position[k] - x).squaredNorm(); };
  std::size_t middle = wall.first;
  for (std::size_t k = wall.first; k < wall.last; ++k)
    if (squared(k, centre) < squared(middle, centre)) middle = k;
  // The patches that look the same way, not round an edge, and may be the nearest to a place of the gauge. Such a place is at most half a
  // diameter from the centre; so the patch nearest to it is at most a diameter farther from the centre than the middle patch.
  const double reach = std::sqrt(squared(middle, centre)) + 1.01 * diameter;
  std::vector<std::size_t> near;
  for (std::size_t k = wall.first; k < wall.last; ++k)
    if (squared(k, centre) <= reach * reach && faces.normal[k].dot(faces.normal[middle]) > 0.5) near.push_back(k);
  const auto along = tangents<D>(faces.normal[middle]);
  const int count = std::max(2, static_cast<int>(std::ceil(diameter / (sampling * fluid_.constants().spacing))));
  double sum = 0;
  int points = 0;
  for (int b = 0; b < (D == 2 ? 1 : count); ++b)
    for (int a = 0; a < count; ++a) {
      const double u = (a + 0.5) / count - 0.5, v = D == 2 ? 0 : (b + 0.5) / count - 0.5;
      if (u * u + v * v > 0.25) continue;
      ++points;
      const Vector<D> x = centre + diameter * (u * along[0] + v * along[1]);
      const std::size_t k =
          *std::min_element(near.begin(), near.end(), [&](auto one, auto other) { return squared(one, x) < squared(other, x); });
      const double wet = share_of_wall(before_wall(faces.position[k], faces.normal[k]), space_before(faces, k));
      if (wet == 0) continue;
      if (!fluid_.has_pressure()) return std::nullopt;
      const Vector<D>& normal = faces.normal[middle];
      sum += wet * wall_pressure(before_wall(x, normal), x, normal, faces.acceleration_of(middle));
    }
  double by_contact = 0;
  for_contacts(wall, false, [&](std::size_t k, const Vector<D>& force) {
    if (squared(k, centre) < 0.25 * diameter * diameter && faces.normal[k].dot(faces.normal[middle]) > 0.5)
      by_contact -= force.dot(faces.normal[middle]);
  });
  return sum / points + by_contact / (D == 2 ? diameter : 0.25 * std::numbers::pi * diameter * diameter);
}

template <int D>
std::optional<WallForce<D>> Probe<D>::force(const Wall<D>& wall, const Vector<D>& at) const {
  const Faces<D>& faces = *fluid_.faces()[0].first;  // as bodies leave them
  const Vector<D> about = wall.now.place(at);
  WallForce<D> total;
  const auto add = [&](std::size_t k, const Vector<D>& force) {
    const Vector<D> arm = faces.position[k] - about;
    total.force += force;
    if constexpr (D == 2)
      total.moment[2] += arm[0] * force[1] - arm[1] * force[0];
    else
      total.moment += arm.cross(force);
  };
  for_contacts(wall, true, add);
  for (std::size_t k = wall.first; k < wall.last; ++k) {
    if (faces.original_of(k) != static_cast<int>(k)) continue;  // an image of a patch already counted
    if (!any_around(faces.position[k])) continue;
    const Vector<D>& normal = faces.normal[k];
    const auto [open, place] = open_part(faces, k);
    if (open == 0) continue;
    const std::vector<Near> before = before_wall(place, normal);
    if (before.empty()) continue;
    const double space = open == 1 ? space_before(faces, k) : fluid_.constants().lattice.density - hidden(off_wall_at(place, normal));
    const double wet = open * share_of_wall(before, space);
    if (wet == 0) continue;
    if (!fluid_.has_pressure()) return std::nullopt;
    Vector<D> force = -wall_pressure(before, place, normal, faces.acceleration_of(k)) * faces.area[k] * normal;
    if (fluid_.constants().viscosity > 0 && !fluid_.walls().slips(static_cast<int>(k))) force += friction(before, wall, faces, k);
    add(k, wet * force);
  }
  return total;
}

template <int D>
double Probe<D>::front() const {
  const State<D>& state = fluid_.state();
  const double reach = joined * fluid_.constants().spacing;
  double front = -1e300;
  const auto add = [&](int i) { front = std::max(front, position_[i][0] + 0.5 * fluid_.constants().spacing); };
  const auto for_joined = [&](int i, auto&& what) {
    for_particles_around(position_[i], [&](int j, const Vector<D>& d, double) {
      if (d.norm() <= reach) what(j);
    });
  };
  std::vector<char> of_fluid(state.size());
  for (std::size_t i = 0; i < state.size(); ++i) {
    of_fluid[i] = !state.particle_class[i].spray();
    if (of_fluid[i]) add(static_cast<int>(i));
  }
  std::vector<int> newest;  // of the spray that the fluid is joined to
  for (std::size_t i = 0; i < state.size(); ++i) {
    bool beside_bulk = false;
    if (state.particle_class[i].spray()) for_joined(static_cast<int>(i), [&](int j) { beside_bulk |= !state.particle_class[j].spray(); });
    if (beside_bulk) newest.push_back(static_cast<int>(i));
  }
  for (int i : newest) of_fluid[i] = true;
  while (!newest.empty()) {
    const int i = newest.back();
    newest.pop_back();
    add(i);
    for_joined(i, [&](int j) {
      if (!std::exchange(of_fluid[j], true)) newest.push_back(j);
    });
  }
  return front;
}

template class Probe<2>;
template class Probe<3>;

}  // namespace tern::fluid
