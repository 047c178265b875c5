#pragma once
// Names of roles and message kinds for sentences.

#include <string>

#include "proto/wire/protocol.hpp"

namespace tern::proto {

std::string name(wire::Role role);                     ///< "coupler", "fluid", "structure" or "role 7"
std::string name(Kind kind);                           ///< as in tern.proto: "BeginWindow"; "nothing" when the body is absent
std::string with_article(Kind kind);                   ///< "a BeginWindow", "an Abort"
std::string where(std::uint64_t step, double time_s);  ///< "at step 17, t = 0.0123 s"; "before the first step"

}  // namespace tern::proto
