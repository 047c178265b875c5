#pragma once
// What must agree before the first step: protocol version, case, dimension. The first difference is told to both sides.

#include <string>

#include "proto/wire/protocol.hpp"

namespace tern::proto {

/// Returns the first difference between a Hello and the coupler's own case as a full sentence with a remedy, or an
/// empty string.
std::string find_difference(const wire::Message& hello, const std::string& case_hash, int dimension);

}  // namespace tern::proto
