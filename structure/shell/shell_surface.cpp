#include "structure/shell/shell_surface.hpp"

namespace tern::structure {

template <int D>
ShellPoint<D> shell_point(const ShellLayer<D>& layer, std::size_t particle, const Vector<D>& offset) {
  ShellPoint<D> point;
  point.particle = particle;
  const Matrix<D>& frame = layer.particles.frame[particle];
  for (int a = 0; a < D - 1; ++a) point.xi[a] = frame.col(a).dot(offset);
  point.z = frame.col(D - 1).dot(offset);
  return point;
}

// F = (x_,a + z n_,a) e_a + n N, with Weingarten's n_,a = -(n.x_,ab) (metric^-1)_bc x_,c.
template <int D>
ShellPlace<D> place_of(const ShellLayer<D>& layer, const ShellWork<D>& work, const ShellPoint<D>& point) {
  const ShellDerivatives<D>& d = work.derivatives[point.particle];
  using Slopes = Eigen::Matrix<double, D, D - 1>;
  using Plane = Eigen::Matrix<double, D - 1, D - 1>;
  ShellPlace<D> place;
  place.position = work.x[point.particle];
  Slopes slope;
  for (int a = 0; a < D - 1; ++a) {
    slope.col(a) = d.col(a);
    place.position += point.xi[a] * d.col(a);
    for (int b = 0; b < D - 1; ++b) {
      const auto second = d.col(second_derivative<D>(a, b));
      slope.col(a) += point.xi[b] * second;
      place.position += 0.5 * point.xi[a] * point.xi[b] * second;
    }
  }
  const Vector<D> normal = shell_normal<D>(slope);
  Plane bend;
  for (int a = 0; a < D - 1; ++a)
    for (int b = 0; b < D - 1; ++b) bend(a, b) = normal.dot(d.col(second_derivative<D>(a, b)));
  const Plane metric = slope.transpose() * slope;
  const Slopes fibre = slope - point.z * slope * metric.inverse() * bend;
  const Matrix<D>& frame = layer.particles.frame[point.particle];
  place.position += point.z * normal;
  place.gradient = normal * frame.col(D - 1).transpose();
  for (int a = 0; a < D - 1; ++a) place.gradient += fibre.col(a) * frame.col(a).transpose();
  return place;
}

template ShellPoint<2> shell_point<2>(const ShellLayer<2>&, std::size_t, const Vector<2>&);
template ShellPoint<3> shell_point<3>(const ShellLayer<3>&, std::size_t, const Vector<3>&);
template ShellPlace<2> place_of<2>(const ShellLayer<2>&, const ShellWork<2>&, const ShellPoint<2>&);
template ShellPlace<3> place_of<3>(const ShellLayer<3>&, const ShellWork<3>&, const ShellPoint<3>&);

}  // namespace tern::structure
