#include "proto/transport/silence.hpp"

#include <linux/sockios.h>
#include <linux/tcp.h>
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <cstddef>
#include <utility>

namespace tern::proto {

bool Silence::too_long(int connection, double present_s) {
  const bool begins = present_s < looked_s_;
  if (!begins && present_s - looked_s_ < longest_turn_s) return false;
  looked_s_ = present_s;
  if (heard(connection) || begins) heard_s_ = present_s;
  return present_s - heard_s_ > longest_silence_s;
}

/// Since the last look. Over a network the peer's answers count, and what its machine takes of a message that is still on its way: the
/// question for a sign of life waits behind it. Within a machine nothing counts what has come, but what the peer has not read; a peer that
/// reads leaves nothing, or less than before. A connection that the kernel says nothing about is none, and its end is told otherwise.
bool Silence::heard(int connection) {
  tcp_info info{};
  socklen_t size = sizeof(info);
  if (::getsockopt(connection, IPPROTO_TCP, TCP_INFO, &info, &size) == 0) {
    if (size < offsetof(tcp_info, tcpi_notsent_bytes) + sizeof(info.tcpi_notsent_bytes)) return true;  // a kernel that does not say
    const bool came = std::exchange(received_, info.tcpi_bytes_received) != info.tcpi_bytes_received;
    const bool taken = std::exchange(taken_, info.tcpi_bytes_acked) != info.tcpi_bytes_acked;
    return came || (taken && info.tcpi_notsent_bytes > 0);
  }
  int unread = 0;
  if (::ioctl(connection, SIOCOUTQ, &unread) != 0) return true;
  return std::exchange(unread_, unread) > unread || unread == 0;
}

}  // namespace tern::proto
