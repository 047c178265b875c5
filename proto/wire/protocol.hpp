#pragma once
// The version of the protocol and the kinds of its messages (tern.proto).

#include <cstdint>

#include "proto/wire/tern.pb.h"

namespace tern::proto {

inline constexpr std::uint32_t protocol_version = 6;

using Kind = wire::Message::BodyCase;

}  // namespace tern::proto
