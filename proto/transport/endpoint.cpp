// ZeroMQ would silently take over an existing socket file, try to find an unknown host for ever, and bind to no host by name.

#include "proto/transport/endpoint.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netdb.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cstring>
#include <filesystem>
#include <memory>

#include "base/error.hpp"

namespace tern::proto {
namespace {

constexpr const char* forms = "ipc:///path/to/file or tcp://HOST:PORT";

/// The address of a host as ZeroMQ wants it.
std::string number_of(const std::string& host, const std::string& endpoint) {
  const bool bracketed = host.size() > 2 && host.front() == '[' && host.back() == ']';
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int fault = ::getaddrinfo(bracketed ? host.substr(1, host.size() - 2).c_str() : host.c_str(), nullptr, &hints, &found);
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> list(found, ::freeaddrinfo);
  const addrinfo* chosen = list.get();
  for (const addrinfo* one = list.get(); one != nullptr; one = one->ai_next)
    if (one->ai_family == AF_INET) {
      chosen = one;
      break;
    }
  std::array<char, NI_MAXHOST> number{};
  if (fault != 0 || chosen == nullptr ||
      ::getnameinfo(chosen->ai_addr, chosen->ai_addrlen, number.data(), number.size(), nullptr, 0, NI_NUMERICHOST) != 0)
    throw BadInput(
        fmt::format("The host of the endpoint \"{}\" cannot be found: {}; give its name or address as other "
                    "machines know it, an IPv6 address in brackets.",
                    endpoint, ::gai_strerror(fault)));
  return chosen->ai_family == AF_INET6 ? fmt::format("[{}]", number.data()) : std::string(number.data());
}

std::string host_of(const std::string& endpoint) { return endpoint.substr(6, endpoint.rfind(':') - 6); }

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

std::string socket_file(const std::string& endpoint) { return endpoint.starts_with("ipc://") ? endpoint.substr(6) : std::string(); }

std::string resolved(const std::string& endpoint) {
  if (endpoint.starts_with("ipc://")) {
    const std::string path = socket_file(endpoint);
    if (path.empty() || path[0] == '@' || path[0] == '*')
      throw BadInput(fmt::format("The endpoint \"{}\" names no file; use {}.", endpoint, forms));
    if (path.size() >= sizeof(sockaddr_un::sun_path))
      throw BadInput(fmt::format("The path of the endpoint \"{}\" has {} bytes, the system's limit is {}; use a shorter one.", endpoint,
                                 path.size(), sizeof(sockaddr_un::sun_path) - 1));
    return endpoint;
  }
  if (!endpoint.starts_with("tcp://")) throw BadInput(fmt::format("The endpoint \"{}\" is of an unknown kind; use {}.", endpoint, forms));
  const auto colon = endpoint.rfind(':');
  const std::string port = endpoint.substr(colon + 1);
  const bool number =
      !port.empty() && port.size() <= 5 && port.find_first_not_of("0123456789") == std::string::npos && std::stoi(port) <= 65535;
  if (colon <= 6 || !(number || port == "*"))
    throw BadInput(fmt::format("The endpoint \"{}\" lacks a host or a port of 1 to 65535; use {}.", endpoint, forms));
  const std::string host = host_of(endpoint);
  return host == "*" ? endpoint : fmt::format("tcp://{}:{}", number_of(host, endpoint), port);
}

bool is_local(const std::string& endpoint) {
  if (!endpoint.starts_with("tcp://")) return true;
  const std::string host = host_of(endpoint);
  in_addr address{};
  return host == "[::1]" || (::inet_pton(AF_INET, host.c_str(), &address) == 1 && (ntohl(address.s_addr) >> 24) == 127);
}

void check_socket_file(const std::string& endpoint) {
  const std::string path = socket_file(endpoint);
  if (path.empty()) return;
  std::error_code ignored;
  const auto directory = std::filesystem::absolute(path, ignored).parent_path();
  if (!std::filesystem::is_directory(directory, ignored))
    throw InputOutputError(
        fmt::format("The endpoint \"{}\" lies in {}, which is not a directory; make it first.", endpoint, directory.string()));
  const auto status = std::filesystem::symlink_status(path, ignored);
  if (!std::filesystem::exists(status)) return;
  if (!std::filesystem::is_socket(status))
    throw BadInput(fmt::format("The endpoint \"{}\" names an existing file that is not a socket; choose another path.", endpoint));
  if (somebody_listens(path))
    throw BadInput(fmt::format("The endpoint \"{}\" is in use by a running coupler; choose another path or end that run.", endpoint));
}

}  // namespace tern::proto
