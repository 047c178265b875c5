#pragma once
// Files that are always whole: written beside their place and renamed into it.

#include <string>
#include <string_view>

namespace tern {

/// Replaces `path` by `text`; a reader sees the old or the new content, never a part. Writes path + ".tmp" first and
/// removes it on failure. Throws InputOutputError naming the file and the reason.
void write_atomically(const std::string& path, std::string_view text);

/// The same for a file whose last content must not be missing when the disk is full: it has room for some more text (blanks at its end),
/// and where nothing new can be written, the text goes into the blocks that it has already.
void write_with_room(const std::string& path, std::string text);

}  // namespace tern
