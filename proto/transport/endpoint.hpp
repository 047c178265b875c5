#pragma once
// Addresses of the coupler: ipc://PATH (default, one machine) or tcp://HOST:PORT (HOST a name, a number, or [IPv6]).

#include <string>

namespace tern::proto {

/// Path of the socket file of an ipc endpoint, empty for tcp.
std::string socket_file(const std::string& endpoint);

/// The endpoint with the host of tcp as a number (IPv4 where there is one); "*" stays. Throws BadInput for an address of another
/// form and for a host that cannot be found.
std::string resolved(const std::string& endpoint);

/// Whether a resolved endpoint can only be reached from this machine.
bool is_local(const std::string& endpoint);

/// Throws BadInput for an ipc path that is a file of another kind or the socket of a coupler that is running,
/// InputOutputError when its directory does not exist. tcp always passes.
void check_socket_file(const std::string& endpoint);

}  // namespace tern::proto
