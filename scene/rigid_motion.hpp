#pragma once
// How a rigid wall moves: turned about a pivot, then displaced. Both are given as expressions in t, or as a table.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "base/vector.hpp"
#include "scene/expression.hpp"

namespace tern {

/// Displacement and angle over time, read from a CSV file. Between the rows cubic splines, whose second derivative
/// is continuous, and constant between the first two rows and between the last two. After the last row the last values are held.
class MotionTable {
 public:
  /// `text`: a header line of t_s and some of x_m, y_m, z_m, angle_rad, then at least two rows; lines that start with #
  /// do not count. `file`: its name for messages. Throws BadInput naming file and line.
  MotionTable(const std::string& text, const std::string& file, int dimension);

  bool rotates() const { return !values_[3].empty(); }
  /// x, y, z [m] and angle [rad] at time t [s].
  std::array<double, 4> at(double t) const;
  const std::string& text() const { return text_; }

 private:
  std::string text_;
  std::vector<double> time_;
  std::array<std::vector<double>, 4> values_, second_;  ///< of x, y, z, angle; empty where there is no such column
};

struct RigidMotion {
  VectorExpression displacement;        ///< [m] in t
  Expression rotation;                  ///< [rad] in t; positive from x to y (2D), by the right hand about the axis (3D)
  std::optional<MotionTable> table;     ///< instead of the expressions
  std::array<double, 3> pivot{};        ///< at t = 0 [m]
  std::array<double, 3> axis{0, 0, 1};  ///< unit vector
};

/// Where a rigid body is: x = pivot + turn (X - pivot) + shift for its point that was at X at t = 0.
template <int D>
struct Placement {
  double angle = 0;  ///< [rad]
  Matrix<D> turn = Matrix<D>::Identity();
  Vector<D> pivot = Vector<D>::Zero(), shift = Vector<D>::Zero();
  Vector<D> operator()(const Vector<D>& reference) const { return pivot + turn * (reference - pivot) + shift; }
  /// Where the point of the body that is now at x was at t = 0.
  Vector<D> reference(const Vector<D>& x) const { return pivot + turn.transpose() * (x - pivot - shift); }
};

/// Velocity that a turn at `rate` [rad/s] about `axis` (3D) gives a point at `arm` from it.
template <int D>
Vector<D> turning_velocity(double rate, const std::array<double, 3>& axis, const Vector<D>& arm) {
  if constexpr (D == 2)
    return rate * Vector<2>(-arm[1], arm[0]);
  else
    return rate * Vector<3>(axis[0], axis[1], axis[2]).cross(arm);
}

/// The turn by an angle [rad], positive from x to y (2D), or by the right hand about the unit vector `axis` (3D).
template <int D>
Matrix<D> turn_by(double angle, const std::array<double, 3>& axis);

template <int D>
Placement<D> placement(const RigidMotion& motion, double t);
/// Shifted [m] and turned [rad] by so much.
template <int D>
Placement<D> placed_at(const RigidMotion& motion, const Vector<D>& shift, double angle);

}  // namespace tern
