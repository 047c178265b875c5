// Any text as a case file: a case, or one of the errors that name what is wrong with it.

#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <fstream>

#include "base/error.hpp"
#include "scene/case_file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string path = [] {
    const std::string directory = "/dev/shm/tern-fuzz-" + std::to_string(::getpid());
    std::filesystem::create_directories(directory);
    static const struct Remover {
      std::string directory;
      ~Remover() { std::filesystem::remove_all(directory); }
    } remover{directory};
    return directory + "/case.toml";
  }();
  std::ofstream(path, std::ios::binary).write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
  try {
    tern::read_case(path);
  } catch (const tern::Error&) {}
  return 0;
}
