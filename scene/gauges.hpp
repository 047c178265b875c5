#pragma once
// Which columns of gauges.csv and energy.csv belong to which process, and their names with units.

#include <optional>
#include <string>
#include <vector>

#include "scene/case_file.hpp"
#include "scene/gauges/gauge.hpp"

namespace tern {

/// The process that evaluates a gauge.
GaugeOwner owner(const GaugeCase& gauge);

/// Index of the elastic body that a gauge of a checked case names with `body`.
std::uint32_t body_index(const GaugeCase& gauge, const Case& scene);

/// Where up is, for the elevation of a surface: against what gravity is in the mean of the run, in the middle of the domain.
struct Upward {
  int axis = 1;      ///< that of its largest component; y without gravity
  double sense = 1;  ///< -1: down the axis
};
Upward upward(const Case& scene);

/// Names with units of the columns one gauge fills, in order.
std::vector<std::string> gauge_columns(const GaugeCase& gauge, int dimension);

/// Columns of all gauges of one owner, in the order of the case file.
std::vector<std::string> gauge_columns(const Case& scene, GaugeOwner who);

/// Columns of the energy accounts as the participants report them [J/m^(3-D)].
std::vector<std::string> fluid_energy_columns();
std::vector<std::string> structure_energy_columns(const Case& scene);

/// True when loads, clamps that move or damping take part in the energy account of the structure.
bool has_structure_loads(const StructureCase& structure);

/// Values of one owner's gauges at one instant, in the order of its columns.
using GaugeValues = std::vector<std::optional<double>>;

}  // namespace tern
