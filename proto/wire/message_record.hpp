#pragma once
// A file of messages in the order in which they are taken, each preceded by its length as a varint (the delimited format of Protobuf). They
// have no sequence number, which counts checkpoints as well.

#include <cstdint>
#include <fstream>
#include <string>

#include "proto/wire/tern.pb.h"

namespace tern::proto {

class MessageRecord {
 public:
  /// Creates the file; not `anew`: goes on at its end. Throws InputOutputError with the system's reason.
  explicit MessageRecord(std::string path, bool anew = true);

  /// Hands the message over to the system, so that of a process that is killed only its last message may be cut short.
  void write(const wire::Message& message);

  /// Length of the file [bytes].
  std::uint64_t mark();
  /// Cuts it back to a length that mark() has told. Throws InputOutputError.
  void go_back(std::uint64_t bytes);

 private:
  std::string path_;
  std::ofstream file_;
};

}  // namespace tern::proto
