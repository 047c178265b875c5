// Replacing a file as a whole.

#include "run/atomic_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "base/error.hpp"

namespace tern {

void write_atomically(const std::string& path, std::string_view text) {
  const std::string temporary = path + ".tmp";
  const auto fail = [&](int reason) {
    std::remove(temporary.c_str());
    throw InputOutputError(fmt::format("Cannot write {}: {}; free space or choose another --out.", path, std::strerror(reason)));
  };
  const int descriptor = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor < 0) fail(errno);
  while (!text.empty()) {
    const ssize_t written = ::write(descriptor, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) {
      const int reason = errno;
      ::close(descriptor);
      fail(reason);
    }
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  if (::close(descriptor) != 0) fail(errno);
  if (std::rename(temporary.c_str(), path.c_str()) != 0) fail(errno);
}

void write_with_room(const std::string& path, std::string text) {
  constexpr std::size_t block = 4096, room = 2048;
  try {
    std::string roomy = text;
    roomy.resize((text.size() + room + block - 1) / block * block, ' ');
    roomy.back() = '\n';
    write_atomically(path, roomy);
  } catch (const InputOutputError&) {
    const int descriptor = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
    struct stat file {};
    if (descriptor < 0) throw;
    const bool fits = ::fstat(descriptor, &file) == 0 && static_cast<std::size_t>(file.st_size) >= text.size();
    text.resize(static_cast<std::size_t>(fits ? file.st_size : 0), ' ');
    const bool done = fits && ::pwrite(descriptor, text.data(), text.size(), 0) == static_cast<ssize_t>(text.size());
    ::close(descriptor);
    if (!done) throw;
  }
}

}  // namespace tern
