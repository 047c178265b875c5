// The comparison of the handshake, in the order in which a difference makes the rest meaningless.

#include "proto/wire/handshake.hpp"

#include <fmt/format.h>

#include "proto/wire/names.hpp"

namespace tern::proto {

std::string find_difference(const wire::Message& message, const std::string& case_hash, int dimension) {
  const std::string who = name(message.sender());
  const wire::Hello& hello = message.hello();
  if (message.protocol_version() != protocol_version)
    return fmt::format("The {} process speaks protocol version {}, the coupler version {}: run builds of the same release.", who,
                       message.protocol_version(), protocol_version);
  if (hello.case_hash() != case_hash)
    return fmt::format(
        "The {} process runs the case with hash {}, the coupler the one with hash {}: start all processes with the "
        "same case "
        "file, preset and --set options.",
        who, hello.case_hash(), case_hash);
  if (static_cast<int>(hello.dimension()) != dimension)
    return fmt::format("The {} process runs in {} dimensions, the coupler in {}: start all with the same case file.", who,
                       hello.dimension(), dimension);
  return {};
}

}  // namespace tern::proto
