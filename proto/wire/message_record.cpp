#include "proto/wire/message_record.hpp"

#include <fmt/format.h>
#include <google/protobuf/util/delimited_message_util.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "base/error.hpp"

namespace tern::proto {
namespace {

InputOutputError failure(const std::string& path) {
  return InputOutputError(fmt::format("Cannot write the record {}: {}; free space, choose another --out, or run without --record.", path,
                                      errno != 0 ? std::strerror(errno) : "the system refused it"));
}

}  // namespace

MessageRecord::MessageRecord(std::string path, bool anew) : path_(std::move(path)) {
  errno = 0;
  file_.open(path_, std::ios::binary | std::ios::out | (anew ? std::ios::trunc : std::ios::in | std::ios::ate));
  if (!file_) throw failure(path_);
}

std::uint64_t MessageRecord::mark() {
  const auto end = file_.tellp();
  if (end < 0) throw failure(path_);
  return static_cast<std::uint64_t>(end);
}

void MessageRecord::go_back(std::uint64_t bytes) {
  errno = 0;
  if (mark() < bytes) throw InputOutputError(fmt::format("{} is shorter than it was at the checkpoint; it was changed or lost.", path_));
  std::error_code error;
  std::filesystem::resize_file(path_, bytes, error);
  if (error || !file_.seekp(static_cast<std::streamoff>(bytes))) throw failure(path_);
}

void MessageRecord::write(const wire::Message& message) {
  errno = 0;
  wire::Message kept = message;
  kept.clear_sequence();
  if (kept.has_hello()) kept.mutable_hello()->clear_process_id();  // the record of a run is always the same
  if (!google::protobuf::util::SerializeDelimitedToOstream(kept, &file_) || !file_.flush()) throw failure(path_);
}

}  // namespace tern::proto
