#include "scene/small_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "base/error.hpp"

namespace tern {
namespace {

const char* kind_of(const struct stat& status) {
  return S_ISDIR(status.st_mode)                              ? "folder"
         : S_ISFIFO(status.st_mode)                           ? "pipe"
         : S_ISSOCK(status.st_mode)                           ? "socket"
         : S_ISCHR(status.st_mode) || S_ISBLK(status.st_mode) ? "device"
                                                              : "special file";
}

void refuse_special(const struct stat& status) {
  if (!S_ISREG(status.st_mode)) throw InputOutputError(fmt::format("is a {}, not a regular file", kind_of(status)));
}

[[noreturn]] void fail_with_errno() { throw InputOutputError(fmt::format("cannot be read ({})", std::strerror(errno))); }

}  // namespace

std::string read_small_file(const std::string& path, std::size_t most_bytes) {
  struct stat status {};
  // Before it is opened, which of a device can have effects; and once more after, because the name may stand for another file by then.
  if (::stat(path.c_str(), &status) != 0) fail_with_errno();
  refuse_special(status);
  const struct Descriptor {
    int number;
    ~Descriptor() {
      if (number >= 0) ::close(number);
    }
  } file{::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC)};
  if (file.number < 0 || ::fstat(file.number, &status) != 0) fail_with_errno();
  refuse_special(status);
  std::string text;
  constexpr std::size_t block = 65536;
  while (text.size() <= most_bytes) {
    const std::size_t before = text.size();
    text.resize(before + block);
    const ssize_t count = ::read(file.number, text.data() + before, block);
    if (count < 0 && errno == EINTR) {
      text.resize(before);
      continue;
    }
    if (count < 0) fail_with_errno();
    text.resize(before + static_cast<std::size_t>(count));
    if (count == 0) return text;
  }
  throw InputOutputError(fmt::format("is larger than {:.3g} MiB", static_cast<double>(most_bytes) / (1 << 20)));
}

}  // namespace tern
