#pragma once
// A file of messages in the order of their arrival, each preceded by its length as a varint (the delimited format of Protobuf).

#include <fstream>
#include <string>

#include "proto/wire/tern.pb.h"

namespace tern::proto {

class MessageRecord {
 public:
  /// Creates the file. Throws InputOutputError with the system's reason.
  explicit MessageRecord(std::string path);

  /// Hands the message over to the system, so that of a process that is killed only its last message may be cut short.
  void write(const wire::Message& message);

 private:
  std::string path_;
  std::ofstream file_;
};

}  // namespace tern::proto
