// ZeroMQ would silently take over an existing socket file and bind to any interface: both are refused here.

#include "proto/endpoint.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <filesystem>

#include "particles/error.hpp"

namespace tern::proto {
namespace {

constexpr const char* forms = "ipc:///path/to/file or tcp://127.0.0.1:PORT";

bool is_loopback(const std::string& host) {
  in_addr address{};
  const bool numeric = ::inet_pton(AF_INET, host.c_str(), &address) == 1;
  return host == "localhost" || host == "[::1]" || (numeric && (ntohl(address.s_addr) >> 24) == 127);
}

bool somebody_listens(const std::string& path) {
  const int probe = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (probe < 0) return false;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, path.c_str(), sizeof(address.sun_path) - 1);
  const bool answered = ::connect(probe, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
  ::close(probe);
  return answered;
}

}  // namespace

std::string socket_file(const std::string& endpoint) {
  return endpoint.starts_with("ipc://") ? endpoint.substr(6) : std::string();
}

void check_connect_endpoint(const std::string& endpoint) {
  if (endpoint.starts_with("ipc://")) {
    const std::string path = socket_file(endpoint);
    if (path.empty() || path[0] == '@' || path[0] == '*')
      throw BadInput(fmt::format("The endpoint \"{}\" names no file; use {}.", endpoint, forms));
    if (path.size() >= sizeof(sockaddr_un::sun_path))
      throw BadInput(
          fmt::format("The path of the endpoint \"{}\" has {} bytes, the system's limit is {}; use a shorter one.",
                      endpoint, path.size(), sizeof(sockaddr_un::sun_path) - 1));
  } else if (endpoint.starts_with("tcp://")) {
    const auto colon = endpoint.rfind(':');
    const std::string port = endpoint.substr(colon + 1);
    const bool number = !port.empty() && port.size() <= 5 &&
                        port.find_first_not_of("0123456789") == std::string::npos && std::stoi(port) <= 65535;
    if (colon <= 6 || !(number || port == "*"))
      throw BadInput(fmt::format("The endpoint \"{}\" lacks a host or a port of 1 to 65535; use {}.", endpoint, forms));
  } else {
    throw BadInput(fmt::format("The endpoint \"{}\" is of an unknown kind; use {}.", endpoint, forms));
  }
}

void check_bind_endpoint(const std::string& endpoint) {
  check_connect_endpoint(endpoint);
  const std::string path = socket_file(endpoint);
  if (path.empty()) {
    const std::string host = endpoint.substr(6, endpoint.rfind(':') - 6);
    if (!is_loopback(host))
      throw BadInput(
          fmt::format("The endpoint \"{}\" could be reached from the network, and messages are neither encrypted nor "
                      "authenticated; use a loopback address such as tcp://127.0.0.1:PORT.",
                      endpoint));
    return;
  }
  std::error_code ignored;
  const auto directory = std::filesystem::absolute(path, ignored).parent_path();
  if (!std::filesystem::is_directory(directory, ignored))
    throw InputOutputError(fmt::format("The endpoint \"{}\" lies in {}, which is not a directory; make it first.",
                                       endpoint, directory.string()));
  const auto status = std::filesystem::symlink_status(path, ignored);
  if (!std::filesystem::exists(status)) return;
  if (!std::filesystem::is_socket(status))
    throw BadInput(
        fmt::format("The endpoint \"{}\" names an existing file that is not a socket; choose another path.", endpoint));
  if (somebody_listens(path))
    throw BadInput(fmt::format(
        "The endpoint \"{}\" is in use by a running coupler; choose another path or end that run.", endpoint));
}

}  // namespace tern::proto
