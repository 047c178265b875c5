#pragma once
// What a kind of gauge is: who evaluates it, its keys, its columns, when it
// makes sense, where pictures show it. A new kind is one definition in the file
// of its owner here, and one function in OWNER/gauges/.

#include <functional>
#include <string>
#include <vector>

#include "scene/case_file.hpp"
#include "scene/parameter_table.hpp"

namespace tern {

enum class GaugeOwner { fluid, structure, coupler };

/// Where pictures of a run show a gauge: at `at`, from `from` to `to`, or as a
/// disc of `diameter` at `at`.
enum class GaugePlace { nowhere, point, line, disc };

struct GaugeKey {
  std::string key;
  ParameterType type;  ///< text, number or point
  bool needed;
  std::string meaning;  ///< what it is for this kind, without full stop
  std::string unit = "";
  Range range = {};
};

struct GaugeDefinition {
  std::string kind;
  GaugeOwner owner;
  std::string meaning;         ///< with its unit, without full stop
  std::vector<GaugeKey> keys;  ///< beside kind and name
  /// Quantity and unit of each column in 2D or 3D: "ux_m".
  std::function<std::vector<std::string>(int dimension)> columns;
  GaugePlace place = GaugePlace::nowhere;
  /// Sets what a case leaves out and the scene knows; null if there is no such
  /// thing.
  std::function<void(GaugeCase&, const Case&)> complete = {};
  /// Throws BadInput, beginning with `where`, when the gauge makes no sense in
  /// this scene; null if it always does.
  std::function<void(const GaugeCase&, const Case&, const std::string& where)> check = {};
};

// One list per owner, in the files of their names.
std::vector<GaugeDefinition> fluid_gauges();
std::vector<GaugeDefinition> structure_gauges();
std::vector<GaugeDefinition> coupler_gauges();

/// All kinds, in the order of the document.
const std::vector<GaugeDefinition>& gauge_definitions();
/// Of a kind that is known to be one.
const GaugeDefinition& gauge_definition(const std::string& kind);

// For the definitions.

/// A `complete`: the diameter of a sensor is one spacing of the fluid, where the case gives none.
void one_spacing_wide(GaugeCase& gauge, const Case& scene);
/// The elastic body that a gauge names with `body`; throws BadInput when there
/// is none of this name.
const StructureBody& body_of(const GaugeCase& gauge, const Case& scene, const std::string& where);
/// The rigid wall that a gauge names with `wall`; throws BadInput when there is
/// none of this name.
const WallCase& wall_of(const GaugeCase& gauge, const Case& scene, const std::string& where);
/// signed_distance() in the dimension of the scene.
double distance_from(const Shape& shape, const std::array<double, 3>& point, const Case& scene);
/// "(1, 2) m"
std::string place_text(const std::array<double, 3>& point, const Case& scene);
/// PREFIXx_UNIT and so on for each direction.
std::vector<std::string> component_columns(const std::string& prefix, const std::string& unit, int dimension);
/// Force and moment: D and 1 or 3 columns.
std::vector<std::string> force_and_moment_columns(int dimension);

}  // namespace tern
