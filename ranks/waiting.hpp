#pragma once
// How long this process has waited for other ranks, and spoken with them.

namespace tern {

/// In all calls of ranks/ranks.hpp since the process began [s]; of a process alone 0.
double seconds_with_ranks();

}  // namespace tern
