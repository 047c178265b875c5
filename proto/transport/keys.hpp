#pragma once
// The keys of one process for CURVE, the encryption of ZeroMQ: read from the directory that ./tern keys has made.
// A process needs only its own secret key, and the coupler's public one or (the coupler) the list of those who may join.

#include <map>
#include <optional>
#include <string>

namespace tern::proto {

struct Keys {
  std::string own_secret, own_public;          ///< Z85, 40 characters
  std::string coupler_public;                  ///< participants only
  std::map<std::string, std::string> allowed;  ///< coupler only: public key -> role
};

inline constexpr const char* allow_list = "participants.allowed";

/// `role` is "coupler", "fluid" or "structure". Throws BadInput naming the file that is missing, readable by others, or not a
/// key.
Keys read_keys(const std::string& directory, const std::string& role);

/// What a process of this role uses at a resolved endpoint: keys when there is a directory of them. Throws BadInput where the
/// network could listen and there are none, unless `insecure`; then the log and the terminal are told.
std::optional<Keys> keys_for(const std::string& endpoint, const std::string& directory, bool insecure, const std::string& role);

}  // namespace tern::proto
