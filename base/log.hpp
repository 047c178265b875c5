#pragma once
// The log of one process, DIR/<role>.log: time stamp, level, sentence. Warnings are shown on stderr as well.
// Compose messages with fmt::format. Every line is on disk when the call returns: a killed process leaves a full log.

#include <string>

namespace tern {

/// Name that messages on stderr begin with, e.g. "tern-fluid".
void set_log_program(const std::string& name);

/// Opens (truncates) out_dir/<role>.log. Throws InputOutputError naming the file.
/// Before this call warnings and errors go to stderr only and the rest nowhere.
void open_log(const std::string& out_dir, const std::string& role);

void log_info(const std::string& sentence);
void log_warning(const std::string& sentence);  ///< also on stderr, as "tern-fluid: warning: ..."
void log_error(const std::string& sentence);    ///< also on stderr, as "tern-fluid: ..."
void log_unsaid(const std::string& sentence);   ///< an error that somebody else says on stderr

/// Flushes and closes the file; later messages behave as before open_log.
void close_log() noexcept;

}  // namespace tern
