// Preloaded into mpirun and what it starts: who asks to listen at all addresses of a machine listens at one. Open MPI has no keys, and
// its mpirun listens everywhere whatever it is told.
//
// TERN_LISTEN_ON is the name of a network interface, or a network as 10.1.0.0/16. A machine that has neither is listened at nowhere.
// An IPv6 address is never that of another machine, but loopback. TERN_LISTEN_PORTS, as 20000-20099, is where a free port is looked for.

#include <arpa/inet.h>
#include <dlfcn.h>
#include <ifaddrs.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>

namespace {

/// An IPv4 address in the network `text`.
bool lies_in(in_addr address, const std::string& text) {
  const std::size_t slash = text.find('/');
  if (slash == std::string::npos) return false;
  in_addr network{};
  if (::inet_pton(AF_INET, text.substr(0, slash).c_str(), &network) != 1) return false;
  const int bits = std::atoi(text.c_str() + slash + 1);
  const std::uint32_t mask = bits <= 0 ? 0 : ~std::uint32_t{0} << (32 - (bits < 32 ? bits : 32));
  return ((ntohl(address.s_addr) ^ ntohl(network.s_addr)) & mask) == 0;
}

/// This machine's own IPv4 address on the interface or in the network.
bool find_own(const std::string& where, in_addr& own) {
  ifaddrs* all = nullptr;
  if (::getifaddrs(&all) != 0) return false;
  bool found = false;
  for (const ifaddrs* one = all; one != nullptr && !found; one = one->ifa_next) {
    if (one->ifa_addr == nullptr || one->ifa_addr->sa_family != AF_INET) continue;
    sockaddr_in address{};
    std::memcpy(&address, one->ifa_addr, sizeof address);
    if (where != one->ifa_name && !lies_in(address.sin_addr, where)) continue;
    own = address.sin_addr;
    found = true;
  }
  ::freeifaddrs(all);
  return found;
}

using Bind = int (*)(int, const sockaddr*, socklen_t);

/// To the first port that is free, of those that may be used.
int bind_to_one(Bind real, int socket, sockaddr_in address) {
  const char* ports = std::getenv("TERN_LISTEN_PORTS");
  const auto to = [&](int port) {
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    return real(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address);
  };
  if (ports == nullptr || address.sin_port != 0) return to(ntohs(address.sin_port));
  const char* dash = std::strchr(ports, '-');
  const int first = std::atoi(ports), last = dash != nullptr ? std::atoi(dash + 1) : first;
  errno = EADDRINUSE;
  for (int port = first; port <= last; ++port)
    if (to(port) == 0) return 0;
  return -1;
}

}  // namespace

extern "C" int bind(int socket, const sockaddr* address, socklen_t size) {
  static const auto real = reinterpret_cast<Bind>(::dlsym(RTLD_NEXT, "bind"));
  const char* where = std::getenv("TERN_LISTEN_ON");
  if (where == nullptr || address == nullptr) return real(socket, address, size);
  if (address->sa_family == AF_INET && size >= sizeof(sockaddr_in)) {
    sockaddr_in wanted{};
    std::memcpy(&wanted, address, sizeof wanted);
    if (wanted.sin_addr.s_addr == htonl(INADDR_ANY)) {
      if (!find_own(where, wanted.sin_addr)) {
        errno = EADDRNOTAVAIL;
        return -1;
      }
      return bind_to_one(real, socket, wanted);
    }
  } else if (address->sa_family == AF_INET6 && size >= sizeof(sockaddr_in6)) {
    sockaddr_in6 wanted{};
    std::memcpy(&wanted, address, sizeof wanted);
    if (std::memcmp(&wanted.sin6_addr, &in6addr_any, sizeof in6addr_any) == 0) {
      wanted.sin6_addr = in6addr_loopback;  // the ranks speak IPv4; refused, they would not speak at all
      return real(socket, reinterpret_cast<const sockaddr*>(&wanted), sizeof wanted);
    }
  }
  return real(socket, address, size);
}
