#pragma once
// How sentences about a case file name keys, tables and what is missing or nearest.

#include <string>
#include <vector>

#include "scene/parameter_table.hpp"

namespace tern {

/// Throws BadInput: "WHERE: SENTENCE".
[[noreturn]] void fail_at(const std::string& where, const std::string& sentence);

/// The sentence without line breaks and other control characters, and cut in its middle where a text of the case makes it a page.
std::string one_line(std::string sentence);

/// "[fluid.body]", or "the top of the file".
std::string table_label(const std::string& path);
/// "density [kg/m^3] of [fluid]"
std::string label(const Parameter& key);
/// "density [kg/m^3] of [fluid] is missing (density of the fluid); give a value from 1e-09 to 1e+09."
std::string missing(const Parameter& key);

/// Number of insertions, deletions and replacements that turn a into b.
std::size_t edit_distance(const std::string& a, const std::string& b);
/// The one of `valid`, which is not empty, that needs fewest of them.
std::string nearest(const std::string& text, const std::vector<std::string>& valid);

}  // namespace tern
