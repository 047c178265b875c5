#pragma once
// FNV-1a with 64 bits: tells contents apart and finds a file that is no longer what was written. A changed byte always changes it.

#include <cstdint>
#include <string>
#include <string_view>

namespace tern {

/// Goes through bytes given piece by piece.
class Hash {
 public:
  void add(std::string_view bytes) {
    for (const char c : bytes) value_ = (value_ ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
  }
  /// 16 hexadecimal digits.
  std::string text() const {
    std::string digits(16, '0');
    for (std::uint64_t rest = value_, n = 16; n-- > 0; rest >>= 4) digits[n] = "0123456789abcdef"[rest & 15];
    return digits;
  }

 private:
  std::uint64_t value_ = 14695981039346656037ULL;
};

inline std::string hash_of(std::string_view bytes) {
  Hash hash;
  hash.add(bytes);
  return hash.text();
}

}  // namespace tern
