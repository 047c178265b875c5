#pragma once
// How long a solver wants its next window to be, and why.

namespace tern {

struct StepProposal {
  double seconds = 0;
  const char* limit = "";  ///< what limits it: "velocity", "gravity", ...
};

}  // namespace tern
