#pragma once
// The value of one key: its type and its range.

#include "scene/parameter_table.hpp"

namespace tern {

/// Throws BadInput where `value` is not of the type of `key`, out of its range, or none of its choices.
[[noreturn]] void wrong_type(const Parameter& key, const Setting& value, const std::string& wanted);
void check_number(const Parameter& key, const Setting& value);

/// The value as it stands in the effective settings, of every type but shapes; D numbers are `dimension` numbers. Throws BadInput.
Setting checked_value(const Parameter& key, const Setting& value, std::size_t dimension);

}  // namespace tern
