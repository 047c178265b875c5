// Largest eigenvalues by the Lanczos process (Golub and Van Loan, Matrix Computations, chapter 10), of all bodies at the same time:
//   f(eps x)/eps = -K x   and   f_diffusion(v) = -C v,   eigenvalues of M^-1 K and M^-1 C in the inner product x . M y.

#include "structure/stable_step.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sph/symmetric_matrix.hpp"
#include "structure/time_step.hpp"

namespace tern::structure {
namespace {

constexpr int most_vectors = 30;  ///< 2 are too few for the tests, 4 are enough
constexpr double shift = 1e-6;    ///< of particles, over the spacing: the forces are linear there

/// The products of one body.
struct Recurrence {
  std::vector<double> diagonal, beside;
  bool complete = false;  ///< all of the space has been seen

  double largest_eigenvalue() const { return diagonal.empty() ? 0 : std::max(0.0, tern::largest_eigenvalue(diagonal, beside)); }
};

/// Largest eigenvalue of each body of what `apply` does: from the vector x to the forces on its particles, negative.
template <int D, class Apply>
std::vector<double> largest_eigenvalues(const Reference<D>& reference, const Apply& apply) {
  RowVectors<D> x, before, product;
  for (auto* vectors : {&x, &before, &product})
    for (auto& axis : *vectors) axis.assign(reference.rows, 0);
  const auto dot = [&](const Body& body, const RowVectors<D>& a, const RowVectors<D>& b) {
    double sum = 0;
    for (std::size_t p = body.first; p < body.first + body.count; ++p) {
      const auto row = reference.particle_row[p];
      for (int c = 0; c < D; ++c) sum += reference.mass[row] * a[c][row] * b[c][row];
    }
    return sum;
  };
  // A start that has a part of every mode: no two particles alike.
  double phase = 0;
  for (const auto row : reference.particle_row)
    for (int c = 0; c < D; ++c) {
      phase += 0.6180339887498949;
      phase -= std::floor(phase);
      if (reference.inverse_mass[row] > 0) product[c][row] = phase - 0.5;
    }
  std::vector<Recurrence> recurrences(reference.bodies.size());
  for (int k = 0; k < most_vectors; ++k) {
    for (std::size_t b = 0; b < reference.bodies.size(); ++b) {
      const Body& body = reference.bodies[b];
      Recurrence& recurrence = recurrences[b];
      const double size = std::sqrt(dot(body, product, product));
      recurrence.complete = recurrence.complete || !(size > 1e-10 * (k == 0 ? 0 : std::abs(recurrence.diagonal[0])));
      if (k > 0 && !recurrence.complete) recurrence.beside.push_back(size);
      for (std::size_t p = body.first; p < body.first + body.count; ++p) {
        const auto row = reference.particle_row[p];
        for (int c = 0; c < D; ++c) {
          before[c][row] = x[c][row];
          x[c][row] = recurrence.complete ? 0 : product[c][row] / size;
        }
      }
    }
    apply(x, product);
    for (std::size_t b = 0; b < reference.bodies.size(); ++b) {
      const Body& body = reference.bodies[b];
      Recurrence& recurrence = recurrences[b];
      if (recurrence.complete) continue;
      for (std::size_t p = body.first; p < body.first + body.count; ++p) {
        const auto row = reference.particle_row[p];
        for (int c = 0; c < D; ++c) product[c][row] *= -reference.inverse_mass[row];
      }
      const double diagonal = dot(body, x, product), beside = k > 0 ? recurrence.beside.back() : 0;
      recurrence.diagonal.push_back(diagonal);
      for (std::size_t p = body.first; p < body.first + body.count; ++p) {
        const auto row = reference.particle_row[p];
        for (int c = 0; c < D; ++c) product[c][row] -= diagonal * x[c][row] + beside * before[c][row];
      }
    }
  }
  std::vector<double> result;
  for (const Recurrence& recurrence : recurrences) result.push_back(recurrence.largest_eigenvalue());
  return result;
}

}  // namespace

double longest_stable_step(double omega, double decay) {
  const double sum = decay + std::sqrt(decay * decay + 4 * omega * omega);
  return sum > 0 ? 4 / sum : std::numeric_limits<double>::max();
}

template <int D>
std::vector<double> stable_steps_at_rest(const Reference<D>& reference) {
  State<D> state = state_at_rest(reference, 0);
  Workspace<D> work = workspace_for(reference);
  double spacing = std::numeric_limits<double>::max();
  for (const Body& body : reference.bodies) spacing = std::min(spacing, body.spacing);
  const std::vector<double> squares = largest_eigenvalues<D>(reference, [&](const RowVectors<D>& x, RowVectors<D>& force) {
    double largest = 0;
    for (const auto& axis : x)
      for (const double value : axis) largest = std::max(largest, std::abs(value));
    const double scale = largest > 0 ? shift * spacing / largest : 0;
    for (int c = 0; c < D; ++c)
      for (std::size_t row = 0; row < reference.rows; ++row) state.displacement[c][row] = scale * x[c][row];
    internal_forces(reference, 0, state, work);
    for (int c = 0; c < D; ++c)
      for (std::size_t row = 0; row < reference.rows; ++row) force[c][row] = scale > 0 ? state.internal_force[c][row] / scale : 0;
  });
  for (auto& axis : state.displacement) std::fill(axis.begin(), axis.end(), 0);
  std::vector<double> decays(reference.bodies.size(), 0);
  if (reference.has_diffusion)
    decays = largest_eigenvalues<D>(reference, [&](const RowVectors<D>& x, RowVectors<D>& force) {
      state.velocity = x;
      internal_forces(reference, 0, state, work);
      force = state.internal_force;
    });
  std::vector<double> result;
  for (std::size_t b = 0; b < reference.bodies.size(); ++b) result.push_back(longest_stable_step(std::sqrt(squares[b]), decays[b]));
  return result;
}

template std::vector<double> stable_steps_at_rest<2>(const Reference<2>&);
template std::vector<double> stable_steps_at_rest<3>(const Reference<3>&);

}  // namespace tern::structure
