#pragma once
// What is asked of every call of ZeroMQ.

#include <fmt/format.h>
#include <zmq.h>

#include <cerrno>
#include <cstddef>

#include "base/error.hpp"

namespace tern::proto {

/// Throws InputOutputError: ZeroMQ cannot do what it was asked to.
inline void require(bool done, const char* what) {
  if (!done) throw InputOutputError(fmt::format("ZeroMQ cannot {}: {}.", what, zmq_strerror(zmq_errno())));
}

/// Calls a function of ZeroMQ until no signal has come in between: with ZMQ_DONTWAIT, too, it gives up then and has done nothing.
template <class Call>
int through_signals(Call&& call) {
  for (;;)
    if (const int result = call(); result >= 0 || zmq_errno() != EINTR) return result;
}

/// Becomes readable when the socket has something to say after it had nothing.
inline int descriptor(void* socket) {
  int result = -1;
  std::size_t size = sizeof(result);
  require(through_signals([&] { return zmq_getsockopt(socket, ZMQ_FD, &result, &size); }) == 0, "name the descriptor of a socket");
  return result;
}

}  // namespace tern::proto
