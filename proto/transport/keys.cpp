// DIR/<role>.secret (mode 600) and DIR/coupler.public hold one key each; DIR/participants.allowed a role and a key per line.

#include "proto/transport/keys.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <zmq.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>

#include "base/error.hpp"
#include "base/log.hpp"
#include "proto/transport/endpoint.hpp"

namespace tern::proto {
namespace {

constexpr std::size_t key_characters = 40;

std::string read(const std::string& path) {
  // Who can change one of these files decides whom this process talks to.
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0 && (status.st_mode & (S_IWGRP | S_IWOTH)) != 0)
    throw BadInput(fmt::format("{} can be changed by others on this machine; run chmod go-w {}.", path, path));
  errno = 0;
  std::ifstream file(path);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  if (!file.is_open() || file.bad())
    throw BadInput(
        fmt::format("The key file {} cannot be read: {}; ./tern keys makes the keys and says which file belongs on "
                    "which machine.",
                    path, std::strerror(errno)));
  return text;
}

std::string checked(const std::string& key, const std::string& path) {
  std::array<std::uint8_t, 32> bytes{};
  if (key.size() != key_characters || zmq_z85_decode(bytes.data(), key.c_str()) == nullptr)
    throw BadInput(
        fmt::format("{} holds no key of {} characters in Z85; copy it again, or make new keys with ./tern keys.", path, key_characters));
  return key;
}

std::string read_key(const std::string& path) {
  std::istringstream text(read(path));
  std::string key;
  text >> key;
  return checked(key, path);
}

std::string read_secret_key(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) == 0 && (status.st_mode & (S_IRWXG | S_IRWXO)) != 0)
    throw BadInput(fmt::format("The secret key {} can be read or changed by others on this machine; run chmod 600 {}.", path, path));
  return read_key(path);
}

std::map<std::string, std::string> read_allowed(const std::string& path) {
  std::map<std::string, std::string> allowed;
  std::istringstream text(read(path));
  std::string line;
  for (int number = 1; std::getline(text, line); ++number) {
    std::istringstream words(line);
    std::string role, key, more;
    if (!(words >> role)) continue;
    words >> key;
    const std::string place = fmt::format("{}:{}", path, number);
    if ((role != "fluid" && role != "structure") || words >> more)
      throw BadInput(fmt::format("{} is not a line of the form \"fluid KEY\" or \"structure KEY\".", place));
    const auto [known, added] = allowed.emplace(checked(key, place), role);
    if (!added && known->second != role)
      throw BadInput(fmt::format("{} gives one key to two roles; make a key for each with ./tern keys.", place));
  }
  if (allowed.empty())
    throw BadInput(fmt::format("{} allows nobody to join; it needs a line \"fluid KEY\" and a line \"structure KEY\".", path));
  return allowed;
}

}  // namespace

Keys read_keys(const std::string& directory, const std::string& role) {
  struct stat status {};
  if (::stat(directory.c_str(), &status) == 0 && (status.st_mode & (S_IWGRP | S_IWOTH)) != 0)
    throw BadInput(fmt::format("Others on this machine can exchange the keys in {}; run chmod go-w {}.", directory, directory));
  Keys keys;
  keys.own_secret = read_secret_key(fmt::format("{}/{}.secret", directory, role));
  std::array<char, key_characters + 1> derived{};
  if (zmq_curve_public(derived.data(), keys.own_secret.c_str()) != 0)
    throw InputOutputError(
        fmt::format("ZeroMQ cannot use keys: {}; install a libzmq that was built with CURVE.", zmq_strerror(zmq_errno())));
  keys.own_public = derived.data();
  if (role == "coupler")
    keys.allowed = read_allowed(fmt::format("{}/{}", directory, allow_list));
  else
    keys.coupler_public = read_key(fmt::format("{}/coupler.public", directory));
  return keys;
}

std::optional<Keys> keys_for(const std::string& endpoint, const std::string& directory, bool insecure, const std::string& role) {
  if (!directory.empty() && insecure) throw BadInput("--keys and --insecure contradict each other; leave out one of them.");
  if (!directory.empty()) return read_keys(directory, role);
  if (is_local(endpoint)) return std::nullopt;
  if (!insecure)
    throw BadInput(
        fmt::format("The endpoint \"{}\" can be reached from the network, and without keys messages are neither encrypted nor "
                    "authenticated: make keys with ./tern keys DIR and add --keys DIR, or use an address of this machine such as "
                    "tcp://127.0.0.1:PORT. In a network you trust entirely, --insecure does without.",
                    endpoint));
  log_warning(
      fmt::format("--insecure: messages at {} are neither encrypted nor authenticated; everybody in the network can read "
                  "them, join this run, or end it.",
                  endpoint));
  return std::nullopt;
}

}  // namespace tern::proto
