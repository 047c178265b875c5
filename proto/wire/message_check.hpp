#pragma once
// Every message is checked before its content is used (and before it is sent): size before parsing, version, sender,
// sequence, step, kind, array lengths, labels, finiteness, physical bounds. A fault is a phrase that names field,
// index, value and limit; who reports it to whom is the channel's business.

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>

#include "proto/wire/protocol.hpp"

namespace tern::proto {

inline constexpr std::size_t max_message_bytes = std::size_t{256} << 20;  ///< about 3 million interface particles in 3D
inline constexpr std::size_t max_sentence_bytes = 4096;
inline constexpr std::size_t max_images = 7;        ///< of an interface particle in walls
inline constexpr int max_checkpoints = 16;          ///< that a participant offers to go on from
inline constexpr std::size_t max_name_bytes = 256;  ///< version, hash, name of a limit

/// What both ends of one connection know about the run; grows as messages pass (see remember()).
struct Agreement {
  int dimension = 0;                               ///< 2 or 3, from Hello
  std::optional<std::size_t> surface_points;       ///< from Welcome or the structure's Hello
  std::optional<std::size_t> interface_particles;  ///< of the last InterfaceParticles
  bool projected = false;                          ///< the pressure of this window has been asked for
  std::optional<std::size_t> energies, gauges;     ///< lengths of the participant's Account in its Hello
  std::optional<std::int64_t> next_begin_ticks;    ///< end of the last window
  bool extent = false;                             ///< the last WindowDone has one: the next Surface for the fluid may be empty
};

/// Keeps from a checked message what later ones are checked against.
void remember(const wire::Message& message, Agreement& agreement);

/// Bytes -> message. Returns the fault (too large, not a message, no body) or an empty string.
std::string parse(std::span<const std::byte> bytes, wire::Message& message);

/// What the receiver expects of the envelope.
struct Envelope {
  wire::Role sender;
  std::uint64_t sequence;  ///< the next one
  std::uint64_t step;      ///< of the current window; a BeginWindow must carry the next one
};

/// Version, sender, sequence, step, kind. `expected` empty = any kind. An Abort is welcome at any step and of any
/// version.
std::string find_envelope_fault(const wire::Message& message, const Envelope& envelope, std::initializer_list<Kind> expected);

/// Lengths, labels, finiteness and physical bounds of the body. Returns the fault or an empty string.
std::string find_body_fault(const wire::Message& message, const Agreement& agreement);

}  // namespace tern::proto
