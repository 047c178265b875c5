#pragma once
// Points on the faces and rims of a shell, at xi from particle i along the mid-surface and at the height z over it:
//   x_k = x(xi) + z n(xi),  x(xi) = x_i + xi_a x_,a + xi_a xi_b x_,ab/2,  x_,a(xi) = x_,a + xi_b x_,ab.
// The force on a point goes to the particles by the adjoint of this map, so that its power is that of the point's velocity.

#include "structure/shell/shell_body.hpp"

namespace tern::structure {

template <int D>
struct ShellPoint {
  std::size_t particle = 0;
  std::array<double, D - 1> xi{};
  double z = 0;
  Matrix<D> from_reference = Matrix<D>::Identity();  ///< from offsets of the undeformed shell to those in xi and z
};

/// The point that is at `offset` from the particle in the undeformed shell.
template <int D>
ShellPoint<D> shell_point(const ShellLayer<D>& layer, std::size_t particle, const Vector<D>& offset);

template <int D>
struct ShellPlace {
  Vector<D> position;
  Matrix<D> gradient;  ///< F there: dx/dX
};
template <int D>
ShellPlace<D> place_of(const ShellLayer<D>& layer, const ShellWork<D>& work, const ShellPoint<D>& point);

/// Calls add(j, f_j) for every particle that bears part of the force f on the point.
template <int D, class Add>
void spread_force(const ShellLayer<D>& layer, const ShellWork<D>& work, const ShellPoint<D>& point, const Vector<D>& f, const Add& add) {
  const std::size_t i = point.particle;
  const ShellDerivatives<D>& d = work.derivatives[i];
  using Row = Eigen::Matrix<double, shell_unknowns<D>, 1>;
  // delta x = of.delta(x_,a, x_,ab) + delta x_i,  delta x_,a(xi) = turn[a].delta(...)
  Row of = Row::Zero();
  std::array<Row, D - 1> turn;
  Eigen::Matrix<double, D, D - 1> slope;
  for (int a = 0; a < D - 1; ++a) {
    of[a] = point.xi[a];
    turn[a] = Row::Unit(a);
    for (int b = 0; b < D - 1; ++b) {
      of[second_derivative<D>(a, b)] += 0.5 * point.xi[a] * point.xi[b];
      turn[a][second_derivative<D>(a, b)] += point.xi[b];
    }
    slope.col(a) = d * turn[a];
  }
  // z f.delta n = couple[a].delta x_,a(xi)
  std::array<Vector<D>, D - 1> couple;
  if constexpr (D == 2) {
    const Vector<2> a = slope.col(0);
    couple[0] = -point.z * f.dot(a) / std::pow(a.norm(), 3) * Vector<2>(-a[1], a[0]);
  } else {
    const Vector<3> first = slope.col(0), second = slope.col(1), c = first.cross(second), n = c.normalized();
    const Vector<3> p = point.z / c.norm() * (f - n.dot(f) * n);
    couple[0] = second.cross(p);
    couple[1] = p.cross(first);
  }
  Vector<D> own = f;
  for (auto n = layer.first[i]; n < layer.first[i + 1]; ++n) {
    Vector<D> share = of.dot(layer.weight[n]) * f;
    for (int a = 0; a < D - 1; ++a) share += turn[a].dot(layer.weight[n]) * couple[a];
    own -= share;
    add(layer.neighbour[n], share);
  }
  add(i, own);
}

}  // namespace tern::structure
