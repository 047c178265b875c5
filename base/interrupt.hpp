#pragma once
// Ctrl-C and termination signals, seen as a flag that long loops look at: nothing is cut off in the middle of a write.

namespace tern {

/// Catches SIGINT, SIGTERM and SIGHUP (unless ignored by the parent, as under nohup) as a flag, and ignores SIGPIPE.
/// System calls that wait return with EINTR.
void install_interrupt_handler();

/// True once one of these signals has arrived. Async-signal and thread safe.
bool interrupted();

/// Throws Interrupted with a sentence "Interrupted by SIGINT `where`; ...", e.g. where = "at step 12, t = 0.0034 s".
void throw_if_interrupted(const char* where);

}  // namespace tern
