#include "coupler/audit.hpp"

#include <fmt/format.h>

#include "base/error.hpp"
#include "coupler/workspace.hpp"

namespace tern::coupler {

template <int D>
void audit_balance(Workspace<D>& window) {
  Vector<D> force = Vector<D>::Zero();
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  double size = 0, moment_size = 0;
  const auto add = [&](const Vector<D>& x, const Vector<D>& f) {
    force += f;
    size += f.norm();
    moment_size += x.norm() * f.norm();
    Eigen::Vector3d x3 = Eigen::Vector3d::Zero(), f3 = Eigen::Vector3d::Zero();
    x3.head<D>() = x;
    f3.head<D>() = f;
    moment += x3.cross(f3);
  };
  const InterfaceParticles<D>& particles = window.particles;
  const InterfacePairs<D>& pairs = window.pairs;
  for (std::size_t i = 0; i < particles.id.size(); ++i) {
    add(particles.position[i], window.particle_force.force[i] + window.condition.force[i]);
  }
  std::size_t m = 0;
  for (const auto& pair : pairs.image_pairs())  // theirs is what walls give the fluid
    add(window.surface.position[pair.point] + pair.offset, Vector<D>(-window.image_force[m++]));
  WindowAudit& audit = window.audit;
  for (std::size_t k = 0; k < window.load.force.size(); ++k) {
    if (!window.load.force[k].allFinite())
      throw NumericalFailure(
          fmt::format("The load on surface point {} is not finite at t = {:.6g} s; a pressure or a velocity "
                      "at the interface has run away. Try a smaller fluid.numerics.courant.",
                      k, window.begin));
    add(window.surface.position[k], window.load.force[k]);
    // The fluid sees the surface end the window at the velocity that its own load makes of the one it was sent, as both sides have agreed;
    // one that does not iterate, at the one it was sent. The structure's own account uses the way that the surface has gone; the sum of
    // both is what staggering creates or destroys.
    audit.work_on_fluid -= window.duration * window.load.force[k].dot(window.velocity_at_end[k]);
  }
  audit.force_sum = force.norm();
  audit.force_size = size;
  if (size > 0) {
    audit.force_error = force.norm() / size;
    audit.moment_error = moment_size > 0 ? moment.norm() / moment_size : 0;
  }
}

template void audit_balance<2>(Workspace<2>&);
template void audit_balance<3>(Workspace<3>&);

}  // namespace tern::coupler
