// Sums over the particles of a body: M v = sum m v_i, and I w = sum m r_i x v_i with r_i = x_i - c.

#include "structure/free_motion.hpp"

#include <Eigen/Cholesky>

namespace tern::structure {

/// The rotation of angular momentum sum m r x v, sum m r r^T = `second_moment` and sum m v r^T = `momentum_moment`.
template <int D>
Matrix<D> spin_of(const Matrix<D>& second_moment, const Matrix<D>& momentum_moment) {
  const Matrix<D> twice = momentum_moment - momentum_moment.transpose();
  Matrix<D> spin = Matrix<D>::Zero();
  if constexpr (D == 2) {
    spin(1, 0) = twice(1, 0) / second_moment.trace();
    spin(0, 1) = -spin(1, 0);
  } else {
    const Matrix<D> inertia = second_moment.trace() * Matrix<D>::Identity() - second_moment;
    const Vector<D> w = inertia.ldlt().solve(Vector<D>(twice(2, 1), twice(0, 2), twice(1, 0)));
    for (int a = 0; a < D; ++a) {
      const int b = (a + 1) % 3, c = (a + 2) % 3;
      spin(c, b) = w[a];
      spin(b, c) = -w[a];
    }
  }
  return spin;
}

template <int D>
std::vector<FreeMotion<D>> free_motions(const Reference<D>& reference, const State<D>& state) {
  std::vector<FreeMotion<D>> motions(reference.bodies.size());
  for (std::size_t b = 0; b < motions.size(); ++b) {
    const Body& body = reference.bodies[b];
    if (body.is_held) continue;
    const auto first = reference.particle_row.begin() + static_cast<std::ptrdiff_t>(body.first);
    const auto each = [&](auto&& visit) {
      for (auto row = first; row != first + static_cast<std::ptrdiff_t>(body.count); ++row) {
        Vector<D> x = reference.position_of(*row), v;
        for (int a = 0; a < D; ++a) {
          x[a] += state.displacement[a][*row];
          v[a] = state.velocity[a][*row];
        }
        visit(reference.mass[*row], x, v);
      }
    };
    FreeMotion<D>& motion = motions[b];
    double mass = 0;
    each([&](double m, const Vector<D>& x, const Vector<D>& v) {
      mass += m;
      motion.centre += m * x;
      motion.velocity += m * v;
    });
    motion.centre /= mass;
    motion.velocity /= mass;
    Matrix<D> second_moment = Matrix<D>::Zero(), momentum_moment = Matrix<D>::Zero();
    each([&](double m, const Vector<D>& x, const Vector<D>& v) {
      const Vector<D> arm = x - motion.centre;
      second_moment += m * arm * arm.transpose();
      momentum_moment += m * (v - motion.velocity) * arm.transpose();
    });
    motion.spin = spin_of<D>(second_moment, momentum_moment);
  }
  return motions;
}

template std::vector<FreeMotion<2>> free_motions<2>(const Reference<2>&, const State<2>&);
template std::vector<FreeMotion<3>> free_motions<3>(const Reference<3>&, const State<3>&);

}  // namespace tern::structure
