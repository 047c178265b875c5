#pragma once
// The tree of settings as it stands in a TOML file, each value with the place it came from.

#include <string>
#include <utility>
#include <vector>

namespace tern {

struct Setting {
  enum class Type { boolean, integer, number, text, list, table };
  Type type = Type::table;
  bool boolean = false;
  double number = 0;  ///< integer and number
  std::string text;
  std::vector<Setting> items;     ///< list and table
  std::vector<std::string> keys;  ///< table: one per item
  std::string where;              ///< "FILE:LINE:COLUMN", "--set KEY", or "default"

  /// The value of a key of a table; null if absent.
  const Setting* find(const std::string& key) const;
  Setting* find(const std::string& key);
  /// The value of a key that is known to be there.
  const Setting& at(const std::string& key) const;
  /// Sets or replaces the value of a key of a table.
  Setting& set(const std::string& key, Setting value);
};

/// "a number", "a list", ...: for sentences.
std::string type_name(Setting::Type type);
/// The value as TOML text, short enough for a sentence.
std::string to_text(const Setting& setting);
/// As JSON with sorted keys; equal settings give equal text. Shortest decimal form of each number.
std::string to_json(const Setting& setting);

/// Throws BadInput with the place of the fault, InputOutputError if the file cannot be read.
Setting read_toml_file(const std::string& path);
/// One TOML value; text that is not TOML is taken as a string.
Setting read_toml_value(const std::string& text, const std::string& where);

/// Applies one `--set key=value`. Elements of a list of tables are named by their position from 0 or by their `name`;
/// the position may be left out where there is one element. Throws BadInput if the path leads nowhere.
void apply_override(Setting& settings, const std::string& key, const std::string& value);

}  // namespace tern
