#include "structure/shell/shell_body.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "scene/mid_surface.hpp"
#include "scene/rigid_motion.hpp"
#include "structure/shell/shell_force.hpp"
#include "structure/stable_step.hpp"

namespace tern::structure {
namespace {

/// Area of the mid-surface over that of the reference.
template <int D>
double area_ratio(const ShellDerivatives<D>& d) {
  if constexpr (D == 2)
    return d.col(0).norm();
  else
    return Vector<3>(d.col(0)).cross(Vector<3>(d.col(1))).norm();
}

/// dR/dt of a turn R that goes on at `spin` [rad/s] about `axis` (3D).
template <int D>
Matrix<D> turn_rate(double spin, const std::array<double, 3>& axis, const Matrix<D>& turn) {
  Matrix<D> rate;
  for (int a = 0; a < D; ++a) rate.col(a) = turning_velocity<D>(spin, axis, turn.col(a));
  return rate;
}

/// Energies and elastic stresses of a shell; the first particle at which its mid-surface is torn or has collapsed, or their number.
template <int D>
std::size_t stresses_of(const ShellBody<D>& shell, ShellWork<D>& own) {
  constexpr double most = 1e3;
  for_each_block(static_cast<std::ptrdiff_t>(shell.layer.size()), [&](std::ptrdiff_t i) {
    own.energy_density[i] = shell_energy_density<D>(shell.layer, i, own.derivatives[i], own.turn, own.conjugate[i]);
  });
  std::size_t i = 0;
  for (; i < shell.layer.size(); ++i) {
    const double ratio = area_ratio<D>(own.derivatives[i]);
    if (!(ratio > 1 / most && ratio < most && std::isfinite(own.energy_density[i]))) break;
  }
  return i;
}

}  // namespace

template <int D>
void shell_derivatives(const Reference<D>& reference, const State<D>& state, Workspace<D>& work) {
  for (std::size_t s = 0; s < reference.shells.size(); ++s) {
    const ShellBody<D>& shell = reference.shells[s];
    ShellWork<D>& own = work.shells[s];
    for (std::size_t i = 0; i < shell.layer.size(); ++i)
      for (int a = 0; a < D; ++a)
        own.x[i][a] = shell.layer.particles.position[i][a] + state.displacement[a][shell.first_row + static_cast<std::int32_t>(i)];
    for (std::size_t c = 0; c < reference.clamps.size(); ++c) {
      if (!reference.clamps[c].motion) continue;
      own.turn[c] = turn_by<D>(state.clamp_angle[c], reference.clamps[c].motion->axis);
      own.turn_rate[c] = turn_rate<D>(state.clamp_spin[c], reference.clamps[c].motion->axis, own.turn[c]);
    }
    shell_derivatives_of<D>(shell.layer, own.x, own.turn, own.derivatives);
  }
}

template <int D>
bool shell_elastic_forces(const Reference<D>& reference, State<D>& state, Workspace<D>& work) {
  for (const ShellBody<D>& shell : reference.shells) {
    ShellWork<D>& own = work.shells[shell.index];
    if (stresses_of(shell, own) < shell.layer.size()) return false;
    std::fill(own.viscous.begin(), own.viscous.end(), ShellDerivatives<D>::Zero());
    for_each_block(static_cast<std::ptrdiff_t>(shell.layer.size()), [&](std::ptrdiff_t i) {
      const Vector<D> force = shell_force<D, 1>(shell.layer, static_cast<std::size_t>(i), {own.conjugate})[0];
      for (int a = 0; a < D; ++a) state.internal_force[a][shell.first_row + i] = force[a];
    });
  }
  return true;
}

template <int D>
void shell_internal_forces(const Reference<D>& reference, double time_s, State<D>& state, Workspace<D>& work) {
  for (std::size_t s = 0; s < reference.shells.size(); ++s) {
    const ShellBody<D>& shell = reference.shells[s];
    ShellWork<D>& own = work.shells[s];
    if (const std::size_t torn = stresses_of(shell, own); torn < shell.layer.size())
      throw NumericalFailure(
          fmt::format("The mid-surface of the shell '{}' is stretched to {:.4g} of its area at particle {} at t = {:.6g} s: "
                      "it is torn or has collapsed. Likely cause: a load too violent for this material and resolution. "
                      "Refine [structure] spacing, or make the body stiffer.",
                      reference.bodies[shell.body].name, area_ratio<D>(own.derivatives[torn]), torn, time_s));
    const bool is_viscous = shell.viscous_time > 0;
    if (is_viscous) {
      for (std::size_t i = 0; i < shell.layer.size(); ++i)
        for (int a = 0; a < D; ++a) own.v[i][a] = state.velocity[a][shell.first_row + static_cast<std::int32_t>(i)];
      shell_derivatives_of<D>(shell.layer, own.v, own.turn_rate, own.rate);
      for_each_block(static_cast<std::ptrdiff_t>(shell.layer.size()), [&](std::ptrdiff_t i) {
        shell_viscous_stress<D>(shell.layer, i, own.derivatives[i], own.rate[i], own.turn, own.turn_rate, shell.viscous_time,
                                own.viscous[i]);
      });
    }
    // The power of the viscous forces, and by how much it falls in a second, are accounted as those of the diffusion of solids.
    for_each_block(static_cast<std::ptrdiff_t>(shell.layer.size() + lane_count - 1) / lane_count, [&](std::ptrdiff_t n) {
      const std::ptrdiff_t block = shell.first_block + n;
      for (int lane = 0; lane < lane_count; ++lane) {
        const std::ptrdiff_t i = n * lane_count + lane, row = shell.first_row + i;
        if (i >= static_cast<std::ptrdiff_t>(shell.layer.size())) break;
        Vector<D> force;
        if (!is_viscous) {
          force = shell_force<D, 1>(shell.layer, static_cast<std::size_t>(i), {own.conjugate})[0];
        } else {
          const auto [elastic, viscous] = shell_force<D, 2>(shell.layer, static_cast<std::size_t>(i), {own.conjugate, own.viscous});
          force = elastic + viscous;
          state.diffusion_power[block][lane] =
              shell.layer.particles.area[i] *
                  shell_turning_power<D>(shell.layer, i, own.derivatives[i], own.viscous[i], own.turn, own.turn_rate) -
              viscous.dot(own.v[i]);
          state.diffusion_brake[block][lane] = reference.inverse_mass[row] * viscous.dot(force);
        }
        for (int a = 0; a < D; ++a) state.internal_force[a][row] = force[a];
      }
    });
  }
}

template <int D>
double shell_clamp_power(const Reference<D>& reference, const Workspace<D>& work) {
  double power = 0;
  for (const ShellBody<D>& shell : reference.shells) {
    const ShellWork<D>& own = work.shells[shell.index];
    for (std::size_t i = 0; i < shell.layer.size(); ++i) {
      const auto clamp = shell.layer.particles.clamp[i];
      if (clamp < 0 || own.turn_rate[clamp].isZero(0)) continue;
      ShellDerivatives<D> stress = own.conjugate[i];
      if (shell.viscous_time > 0) stress += own.viscous[i];
      power += shell.layer.particles.area[i] * shell_turning_power<D>(shell.layer, i, own.derivatives[i], stress, own.turn, own.turn_rate);
    }
  }
  return power;
}

template <int D>
void damp_shells(Reference<D>& reference, double coefficient) {
  constexpr double of_critical = 0.1;
  for (ShellBody<D>& shell : reference.shells) {
    double& step = reference.bodies[shell.body].stable_step_at_rest;
    const double fastest = 2 / step;
    shell.viscous_time = 2 * of_critical * coefficient / fastest;
    step = longest_stable_step(fastest, shell.viscous_time * fastest * fastest);
  }
}

template <int D>
double shell_stable_sub_step(const Reference<D>& reference, double courant, const State<D>& state, const Workspace<D>& work) {
  double dt = std::numeric_limits<double>::max();
  for (std::size_t s = 0; s < reference.shells.size(); ++s) {
    const ShellBody<D>& shell = reference.shells[s];
    const ShellLayer<D>& layer = shell.layer;
    double smallest = 1, largest = 1, speed = 0;
    for (std::size_t i = 0; i < layer.size(); ++i) {
      const ShellDerivatives<D>& d = work.shells[s].derivatives[i];
      const Vector<D> normal = shell_normal<D>(d);
      double squared = 0, bend = 0;
      for (int a = 0; a < D; ++a) squared += std::pow(state.velocity[a][shell.first_row + static_cast<std::int32_t>(i)], 2);
      for (int a = 0; a < D - 1; ++a) {
        smallest = std::min(smallest, d.col(a).norm());
        largest = std::max(largest, d.col(a).norm());
        if (layer.particles.clamp[i] < 0)
          bend = std::max(bend, layer.thickness * std::abs(normal.dot(d.col(second_derivative<D>(a, a)))) / d.col(a).squaredNorm());
      }
      speed = std::max(speed, squared);
      if (bend >= 2)
        throw NumericalFailure(
            fmt::format("The shell '{}' is bent to a radius of {:.3g} m at particle {} at t = {:.6g} s, half its thickness of "
                        "{:.3g} m or less: its inner fibres have turned over. Make it stiffer, or model it as a solid.",
                        reference.bodies[shell.body].name, layer.thickness / bend, i, seconds(state.time), layer.thickness));
    }
    const Material& material = layer.material;
    const double stiffening = std::max({1.0, material.wave_speed_at(std::max(smallest, 0.05)) / material.pressure_wave_speed(),
                                        material.wave_speed_at(largest) / material.pressure_wave_speed()});
    const double wave = std::sqrt(layer.modulus() / material.density) * stiffening + std::sqrt(speed);
    for (const double spacing : layer.particles.spacing) dt = std::min(dt, shell_sub_step<D>(courant, spacing, layer.thickness, wave));
    constexpr double margin = 0.9;  // of the measured step, as for solids
    dt = std::min(dt, margin * reference.bodies[shell.body].stable_step_at_rest * std::sqrt(layer.modulus() / material.density) / wave);
  }
  return dt;
}

template <int D>
double shell_strain_energy(const Reference<D>& reference, const Workspace<D>& work) {
  double energy = 0;
  ShellDerivatives<D> unused;
  for (std::size_t s = 0; s < reference.shells.size(); ++s) {
    const ShellLayer<D>& layer = reference.shells[s].layer;
    for (std::size_t i = 0; i < layer.size(); ++i)
      energy += layer.particles.area[i] * shell_energy_density<D>(layer, i, work.shells[s].derivatives[i], work.shells[s].turn, unused);
  }
  return energy;
}

// dU/dtheta of a turn R -> (1 + theta x) R at fixed x, through x_,ab (the slopes R e_c) and the normal R N.
template <int D>
Vector<3> shell_clamp_couple(const ShellBody<D>& shell, const Workspace<D>& work, std::int32_t clamp) {
  const ShellLayer<D>& layer = shell.layer;
  const ShellWork<D>& own = work.shells[shell.index];
  Vector<3> couple = Vector<3>::Zero();
  const auto cross = [](const Vector<D>& a, const Vector<D>& b) {
    Vector<3> full_a = Vector<3>::Zero(), full_b = Vector<3>::Zero();
    full_a.template head<D>() = a;
    full_b.template head<D>() = b;
    return Vector<3>(full_a.cross(full_b));
  };
  for (std::size_t i = 0; i < layer.size(); ++i) {
    if (layer.particles.clamp[i] < 0 || (clamp >= 0 && layer.particles.clamp[i] != clamp)) continue;
    ShellDerivatives<D> conjugate;
    shell_energy_density<D>(layer, i, own.derivatives[i], own.turn, conjugate);
    const Matrix<D> frame = own.turn[layer.particles.clamp[i]] * layer.particles.frame[i];
    const Vector<D> normal = frame.col(D - 1);
    for (int ab = 0; ab < shell_unknowns<D> - shell_slopes<D>; ++ab) {
      const Vector<D> q = conjugate.col(shell_slopes<D> + ab), x = own.derivatives[i].col(shell_slopes<D> + ab);
      couple += layer.particles.area[i] * q.dot(normal) * cross(normal, x);
      for (int c = 0; c < D - 1; ++c) couple -= layer.particles.area[i] * layer.clamp_slope[i](ab, c) * cross(frame.col(c), q);
    }
  }
  return couple;
}

template <int D>
ShellStress<D> shell_stress(const ShellBody<D>& shell, const Workspace<D>& work, std::size_t i) {
  const ShellLayer<D>& layer = shell.layer;
  const ShellDerivatives<D>&d = work.shells[shell.index].derivatives[i], &r = layer.reference[i];
  const auto clamp = layer.particles.clamp[i];
  const std::vector<Matrix<D>>& turn = work.shells[shell.index].turn;
  const Vector<D> own_normal = layer.particles.frame[i].col(D - 1);
  const Vector<D> normal = clamp >= 0 ? Vector<D>(turn[clamp] * own_normal) : shell_normal<D>(d);
  const Vector<D> reference_normal = clamp >= 0 ? own_normal : shell_normal<D>(r);
  using Plane = Eigen::Matrix<double, D - 1, D - 1>;
  const auto slopes = d.template leftCols<shell_slopes<D>>(), reference_slopes = r.template leftCols<shell_slopes<D>>();
  const Plane e = 0.5 * (slopes.transpose() * slopes - reference_slopes.transpose() * reference_slopes);
  Plane rho;
  for (int a = 0; a < D - 1; ++a)
    for (int b = 0; b < D - 1; ++b) {
      const int ab = second_derivative<D>(a, b);
      rho(a, b) = normal.dot(d.col(ab)) - reference_normal.dot(r.col(ab));
    }
  const double nu = layer.poisson_ratio();
  const auto hooke = [&](const Plane& strain) {
    return Plane(layer.modulus() * (D == 2 ? strain : Plane((1 - nu) * strain + nu * strain.trace() * Plane::Identity())));
  };
  ShellStress<D> result;
  result.area_ratio = area_ratio<D>(d);
  result.cauchy = slopes * hooke(e) * slopes.transpose() / result.area_ratio;
  result.von_mises = 0;
  for (const double z : {-0.5 * layer.thickness, 0.5 * layer.thickness}) {
    Eigen::Matrix3d full = Eigen::Matrix3d::Zero();
    full.topLeftCorner<D - 1, D - 1>() = hooke(e - z * rho);
    if (D == 2 && !layer.material.plane_stress) full(2, 2) = nu * full(0, 0);
    const Eigen::Matrix3d deviator = full - full.trace() / 3 * Eigen::Matrix3d::Identity();
    result.von_mises = std::max(result.von_mises, std::sqrt(1.5) * deviator.norm());
  }
  ShellDerivatives<D> unused;
  result.energy_density = shell_energy_density<D>(layer, i, d, turn, unused) / layer.thickness;
  return result;
}

#define TERN_INSTANTIATE(D)                                                                                    \
  template void shell_derivatives<D>(const Reference<D>&, const State<D>&, Workspace<D>&);                     \
  template void shell_internal_forces<D>(const Reference<D>&, double, State<D>&, Workspace<D>&);               \
  template bool shell_elastic_forces<D>(const Reference<D>&, State<D>&, Workspace<D>&);                        \
  template void damp_shells<D>(Reference<D>&, double);                                                         \
  template double shell_clamp_power<D>(const Reference<D>&, const Workspace<D>&);                              \
  template double shell_stable_sub_step<D>(const Reference<D>&, double, const State<D>&, const Workspace<D>&); \
  template double shell_strain_energy<D>(const Reference<D>&, const Workspace<D>&);                            \
  template Vector<3> shell_clamp_couple<D>(const ShellBody<D>&, const Workspace<D>&, std::int32_t);            \
  template ShellStress<D> shell_stress<D>(const ShellBody<D>&, const Workspace<D>&, std::size_t);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)

}  // namespace tern::structure
