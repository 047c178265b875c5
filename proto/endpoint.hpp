#pragma once
// Addresses of the coupler: ipc://PATH (default, one machine) or tcp://HOST:PORT (loopback addresses only).

#include <string>

namespace tern::proto {

/// Path of the socket file of an ipc endpoint, empty for tcp.
std::string socket_file(const std::string& endpoint);

/// Throws BadInput for an address of another form.
void check_connect_endpoint(const std::string& endpoint);

/// As check_connect_endpoint; besides, tcp must be a loopback address, and the ipc path must not be a file of another
/// kind or the socket of a coupler that is running. Throws InputOutputError when its directory does not exist.
void check_bind_endpoint(const std::string& endpoint);

}  // namespace tern::proto
