#pragma once
// Ctrl-C and termination signals, seen as a flag that long loops look at: nothing is cut off in the middle of a write.

namespace tern {

/// Catches SIGINT, SIGTERM and SIGHUP (unless ignored by the parent, as under nohup) as a flag, and ignores SIGPIPE and SIGXFSZ.
/// System calls that wait return with EINTR.
void install_interrupt_handler();

/// A rank of a fluid in many processes (TERN_RANK_DIRECTORY) has a launcher, and ends with what has started it. Else:
/// Where the launcher has named itself in TERN_LAUNCHER (its process id): gets SIGTERM when that dies, whatever becomes of its guardian.
/// False where there is none.
bool end_with_launcher();

/// True once one of these signals has arrived. Async-signal and thread safe.
bool interrupted();

/// Throws Interrupted with a sentence "Interrupted by SIGINT `where`; ...", e.g. where = "at step 12, t = 0.0034 s".
void throw_if_interrupted(const char* where);

}  // namespace tern
