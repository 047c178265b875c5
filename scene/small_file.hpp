#pragma once
// Files that a case is made of: the case file itself and its tables of motion.

#include <cstddef>
#include <string>

namespace tern {

inline constexpr std::size_t largest_case_file = std::size_t{1} << 20;     ///< [bytes]; the largest case of the project has 4 kB
inline constexpr std::size_t largest_motion_file = std::size_t{16} << 20;  ///< [bytes]; 400 s of four columns at 1 kHz

/// The whole text of a regular file of at most so many bytes. Anything else, a pipe or a device, is never waited for or read. Throws
/// InputOutputError with what is wrong as the end of a sentence, "is a pipe, not a regular file".
std::string read_small_file(const std::string& path, std::size_t most_bytes);

}  // namespace tern
