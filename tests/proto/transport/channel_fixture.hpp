#pragma once
// Endpoints and threads for tests of the channel over real sockets.

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zmq.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <functional>
#include <future>
#include <string>

#include "fixtures/message_samples.hpp"
#include "proto/transport/channel.hpp"
#include "proto/transport/keys.hpp"

namespace tern::proto {

/// An ipc endpoint in a directory of its own, gone with the object.
class TemporaryEndpoint {
 public:
  TemporaryEndpoint() {
    std::string pattern = (std::filesystem::temp_directory_path() / "tern-proto-XXXXXX").string();
    directory_ = ::mkdtemp(pattern.data());
  }
  ~TemporaryEndpoint() {
    std::error_code ignored;
    std::filesystem::remove_all(directory_, ignored);
  }
  TemporaryEndpoint(const TemporaryEndpoint&) = delete;
  TemporaryEndpoint& operator=(const TemporaryEndpoint&) = delete;

  std::string file() const { return directory_ + "/tern.sock"; }
  std::string address() const { return "ipc://" + file(); }
  const std::string& directory() const { return directory_; }

 private:
  std::string directory_;
};

struct Pair {
  std::string open, secret;
};

inline Pair make_pair_of_keys() {
  std::array<char, 41> open{}, secret{};
  zmq_curve_keypair(open.data(), secret.data());
  return {open.data(), secret.data()};
}

/// The keys of a run in a directory of their own, as ./tern keys makes them.
class KeysOfARun {
 public:
  KeysOfARun() {
    const Pair coupler = make_pair_of_keys(), fluid = make_pair_of_keys(), structure = make_pair_of_keys();
    write_secret("coupler", coupler.secret);
    write_secret("fluid", fluid.secret);
    write_secret("structure", structure.secret);
    write("coupler.public", coupler.open);
    write(allow_list, "fluid " + fluid.open + "\nstructure " + structure.open + "\n");
  }
  std::string path() const { return place_.directory(); }
  void write(const std::string& name, const std::string& text) const { std::ofstream(path() + "/" + name) << text << '\n'; }
  void write_secret(const std::string& role, const std::string& key) const {
    write(role + ".secret", key);
    ::chmod((path() + "/" + role + ".secret").c_str(), S_IRUSR | S_IWUSR);
  }

 private:
  TemporaryEndpoint place_;
};

/// What a participant or the coupler ended with: exit code and sentence; code 0 = no error.
struct Outcome {
  int code = 0;
  std::string sentence;
  bool says(const std::string& part) const { return sentence.find(part) != std::string::npos; }
};

inline Outcome outcome_of(const std::function<void()>& work) {
  try {
    work();
    return {};
  } catch (const Error& error) {
    return {static_cast<int>(error.code()), error.what()};
  }
}

inline std::future<Outcome> in_thread(std::function<void()> work) {
  return std::async(std::launch::async, [work = std::move(work)] { return outcome_of(work); });
}

inline const std::set<wire::Role> both{wire::FLUID, wire::STRUCTURE};

/// A participant that says hello and is welcomed; `change` alters its Hello before.
inline void join(ParticipantChannel& channel, wire::Role role, const std::function<void(wire::Hello&)>& change = {}) {
  wire::Hello hello = samples::hello(role);
  if (change) change(hello);
  channel.handshake(hello);
}

}  // namespace tern::proto
