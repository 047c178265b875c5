#pragma once
// Loads as the vectors that accelerations and observers compute with.

#include <Eigen/Core>

#include "proto/interface.hpp"

namespace tern::coupler {

/// The load point by point.
template <int D>
Eigen::VectorXd flat(const SurfaceLoad<D>& load) {
  Eigen::VectorXd values(D * static_cast<Eigen::Index>(load.force.size()));
  for (std::size_t k = 0; k < load.force.size(); ++k) values.segment<D>(D * static_cast<Eigen::Index>(k)) = load.force[k];
  return values;
}

/// The unknowns of the coupling iterations: the load without its contacts, then what the contact of each point pushes with against its
/// normal. They stand apart because the fluid takes them differently: its answer must not depend on the contacts that another iteration
/// has met.
template <int D>
Eigen::VectorXd parts(const SurfaceLoad<D>& load, const SurfaceLoad<D>& contact, const std::vector<Vector<D>>& normal) {
  const Eigen::VectorXd all = flat(load), contacts = flat(contact);
  Eigen::VectorXd values(all.size() + static_cast<Eigen::Index>(normal.size()));
  values.head(all.size()) = all - contacts;
  for (std::size_t k = 0; k < normal.size(); ++k) values[all.size() + static_cast<Eigen::Index>(k)] = -contact.force[k].dot(normal[k]);
  return values;
}

}  // namespace tern::coupler
