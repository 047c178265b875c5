#include "structure/shell/shell_surface.hpp"

namespace tern::structure {

namespace {

/// x(xi) + z n(xi) from the particle, and the directions in which it goes with xi and z: x_,a + z n_,a and n, with Weingarten's
/// n_,a = -(n.x_,ab) (metric^-1)_bc x_,c.
template <int D>
struct Fibre {
  Vector<D> offset = Vector<D>::Zero();
  Matrix<D> directions;

  Fibre(const ShellDerivatives<D>& d, const std::array<double, D - 1>& xi, double z) {
    using Slopes = Eigen::Matrix<double, D, D - 1>;
    using Plane = Eigen::Matrix<double, D - 1, D - 1>;
    Slopes slope;
    for (int a = 0; a < D - 1; ++a) {
      slope.col(a) = d.col(a);
      offset += xi[a] * d.col(a);
      for (int b = 0; b < D - 1; ++b) {
        const auto second = d.col(second_derivative<D>(a, b));
        slope.col(a) += xi[b] * second;
        offset += 0.5 * xi[a] * xi[b] * second;
      }
    }
    const Vector<D> normal = shell_normal<D>(slope);
    Plane bend;
    for (int a = 0; a < D - 1; ++a)
      for (int b = 0; b < D - 1; ++b) bend(a, b) = normal.dot(d.col(second_derivative<D>(a, b)));
    const Plane metric = slope.transpose() * slope;
    directions.template leftCols<D - 1>() = slope - z * slope * metric.inverse() * bend;
    directions.col(D - 1) = normal;
    offset += z * normal;
  }
};

}  // namespace

template <int D>
ShellPoint<D> shell_point(const ShellLayer<D>& layer, std::size_t particle, const Vector<D>& offset) {
  constexpr int iterations = 20;  // of Newton's method; a flat shell takes one
  ShellPoint<D> point;
  point.particle = particle;
  for (int n = 0; n < iterations; ++n) {
    const Fibre<D> fibre(layer.reference[particle], point.xi, point.z);
    point.from_reference = fibre.directions.inverse();
    const Vector<D> step = point.from_reference * (offset - fibre.offset);
    for (int a = 0; a < D - 1; ++a) point.xi[a] += step[a];
    point.z += step[D - 1];
    if (step.norm() < 1e-15 * layer.thickness) break;
  }
  return point;
}

// F = (directions now) (directions in the reference)^-1.
template <int D>
ShellPlace<D> place_of(const ShellLayer<D>&, const ShellWork<D>& work, const ShellPoint<D>& point) {
  const Fibre<D> fibre(work.derivatives[point.particle], point.xi, point.z);
  return {work.x[point.particle] + fibre.offset, fibre.directions * point.from_reference};
}

template ShellPoint<2> shell_point<2>(const ShellLayer<2>&, std::size_t, const Vector<2>&);
template ShellPoint<3> shell_point<3>(const ShellLayer<3>&, std::size_t, const Vector<3>&);
template ShellPlace<2> place_of<2>(const ShellLayer<2>&, const ShellWork<2>&, const ShellPoint<2>&);
template ShellPlace<3> place_of<3>(const ShellLayer<3>&, const ShellWork<3>&, const ShellPoint<3>&);

}  // namespace tern::structure
