#pragma once
// Another participant has stopped, and has told why in an Abort.

#include "base/error.hpp"

namespace tern {

/// Its sentence, with the name of who said it: what is known already to whoever listens to all of them.
struct PeerStopped : Error {
  using Error::Error;
};

}  // namespace tern
