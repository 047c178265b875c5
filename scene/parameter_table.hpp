#pragma once
// Every key of a case file as the validation and docs/PARAMETERS.md see it. The rows themselves, each with the member it fills,
// stand in scene/keys/.

#include <limits>
#include <string>
#include <vector>

#include "scene/settings.hpp"

namespace tern {

enum class ParameterType {
  text,     ///< "..."
  choice,   ///< one of Parameter::choices
  choices,  ///< list of some of Parameter::choices
  boolean,
  integer,
  number,
  point,        ///< list of D numbers
  expression,   ///< number or expression text
  expressions,  ///< list of D numbers or expression texts
  vertices,     ///< list of at least 2 points [x, y]
  places,       ///< list of at least 3 points [x, y, z]
  shape,        ///< table with exactly one of box, polygon, ball, ring, line, tube, plate, union, difference
  shapes,       ///< list of shapes
};

/// Allowed interval of a number; an excluded end is open.
struct Range {
  double lowest = -std::numeric_limits<double>::infinity();
  double highest = std::numeric_limits<double>::infinity();
  bool lowest_excluded = false;
  bool highest_excluded = false;
};

inline constexpr Range any{};
constexpr Range from_to(double lowest, double highest) { return {lowest, highest, false, false}; }
constexpr Range above_to(double lowest, double highest) { return {lowest, highest, true, false}; }
constexpr Range between(double lowest, double highest) { return {lowest, highest, true, true}; }

// Physical quantities in SI units, far wider than what anybody simulates in them, scaled units included, and narrow enough that no
// product of a few of them leaves the range of a double. Of expressions: what a constant one may be.
inline constexpr Range a_place = from_to(-1e9, 1e9);          ///< a coordinate, or a way [m]
inline constexpr Range a_size = from_to(1e-9, 1e9);           ///< [m]
inline constexpr Range an_angle = from_to(-1e9, 1e9);         ///< [rad]
inline constexpr Range a_speed = from_to(-1e9, 1e9);          ///< [m/s]; light has 3e8
inline constexpr Range an_acceleration = from_to(-1e9, 1e9);  ///< [m/s^2]
inline constexpr Range a_density = from_to(1e-9, 1e9);        ///< [kg/m^3]
inline constexpr Range a_modulus = from_to(1e-9, 1e15);       ///< [Pa]; diamond has 1e12
inline constexpr Range a_stress = from_to(-1e15, 1e15);       ///< [Pa]
inline constexpr Range a_body_force = from_to(-1e18, 1e18);   ///< [N/m^3]
inline constexpr Range a_viscosity = from_to(1e-12, 1e12);    ///< [Pa s]
inline constexpr Range a_rate = from_to(1e-12, 1e12);         ///< [1/s]
inline constexpr Range an_interval = from_to(0, 1e9);         ///< [s]; 0 is no interval
inline constexpr Range a_factor = from_to(0, 1e9);

struct Parameter {
  std::string table;  ///< "" for the top of the file
  std::string key;
  ParameterType type;
  std::string unit;           ///< SI; "-" for a pure number, "" where there is none
  std::string default_value;  ///< as TOML; "required"; "absent" = the key may be missing and then has no value
  Range range;
  std::vector<std::string> choices;
  std::string meaning;  ///< one sentence
};

struct TableDefinition {
  enum class Presence {
    optional,  ///< absent table = absent model
    required,  ///< must be given where the table that holds it is given
    filled     ///< made of defaults where it is absent
  };
  std::string path;  ///< "fluid.body"
  bool repeated;     ///< written [[path]]
  Presence presence;
  std::string meaning;          ///< one sentence
  std::vector<Parameter> keys;  ///< in the order of the document
};

/// In the order of the document; a table comes after the one that holds it.
const std::vector<TableDefinition>& table_definitions();
/// The keys of all tables.
const std::vector<Parameter>& parameters();

/// The effective settings: `document` with every default filled in. Throws BadInput on an unknown key, a missing,
/// wrongly typed or out-of-range value, naming place, table, key, unit, range and the nearest valid key.
Setting complete_settings(const Setting& document);

/// The text of docs/PARAMETERS.md.
std::string parameter_reference();

/// "greater than 0", "from 0 to 1", ...: for sentences; empty for an unbounded range.
std::string describe(const Range& range);

}  // namespace tern
