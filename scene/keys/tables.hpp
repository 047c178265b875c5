#pragma once
// The tables of a case file by subject: what their keys are, and how a table of effective settings becomes a part of the Case.
// A new key is one row in the file of its table, and the member that the row fills.

#include <filesystem>

#include "scene/case_file.hpp"
#include "scene/parameter_table.hpp"

namespace tern {

std::vector<TableDefinition> scene_tables();  ///< the top of the file and [domain]
std::vector<TableDefinition> wall_tables();
std::vector<TableDefinition> fluid_tables();
std::vector<TableDefinition> structure_tables();
std::vector<TableDefinition> coupling_tables();
std::vector<TableDefinition> gauge_tables();
std::vector<TableDefinition> output_tables();
std::vector<TableDefinition> shape_tables();

// From effective settings, whose types and ranges are checked. Each throws BadInput where keys contradict each other.

/// The whole case but for what check_scene() adds; `folder` is where the case file is.
Case read_scene(const Setting& settings, const std::filesystem::path& folder);
WallCase read_wall(const Setting& table, int dimension, const std::filesystem::path& folder);
FluidCase read_fluid(const Setting& table);
StructureCase read_structure(const Setting& table, int dimension, bool coupled, const std::filesystem::path& folder);
ClampCase read_clamp(const Setting& table, int dimension, const std::filesystem::path& folder);
LoadCase read_load(const Setting& table);
CouplingCase read_coupling(const Setting& table);
GaugeCase read_gauge(const Setting& table, const Case& scene);
OutputCase read_output(const Setting& table);
Shape read_shape(const Setting& table);

TableDefinition clamp_table();
TableDefinition load_table();

}  // namespace tern
