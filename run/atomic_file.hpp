#pragma once
// Files that are always whole: written beside their place and renamed into it.

#include <string>
#include <string_view>

namespace tern {

/// Replaces `path` by `text`; a reader sees the old or the new content, never a part. Writes path + ".tmp" first and
/// removes it on failure. Throws InputOutputError naming the file and the reason.
void write_atomically(const std::string& path, std::string_view text);

}  // namespace tern
