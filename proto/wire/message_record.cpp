#include "proto/wire/message_record.hpp"

#include <fmt/format.h>
#include <google/protobuf/util/delimited_message_util.h>

#include <cerrno>
#include <cstring>

#include "base/error.hpp"

namespace tern::proto {
namespace {

InputOutputError failure(const std::string& path) {
  return InputOutputError(fmt::format("Cannot write the record {}: {}; free space, choose another --out, or run without --record.", path,
                                      errno != 0 ? std::strerror(errno) : "the system refused it"));
}

}  // namespace

MessageRecord::MessageRecord(std::string path) : path_(std::move(path)) {
  errno = 0;
  file_.open(path_, std::ios::binary | std::ios::trunc);
  if (!file_) throw failure(path_);
}

void MessageRecord::write(const wire::Message& message) {
  errno = 0;
  if (!google::protobuf::util::SerializeDelimitedToOstream(message, &file_) || !file_.flush()) throw failure(path_);
}

}  // namespace tern::proto
