#pragma once
// Window lengths: no step much shorter or longer than the one before, and output times met by stretching or shrinking
// the last steps before them evenly. A single short step would turn the residual divergence of the steps before it into a
// pressure jump of order 1/dt.

#include "base/time.hpp"

namespace tern {

class StepControl {
 public:
  /// Next window length [ticks] for a proposal [s], from `now` towards the next time that must be met.
  Ticks next(double proposed_seconds, Ticks now, Ticks target);

  /// The list of the members: visit(name, member of each) for every one.
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("previous", all.previous_...);
  }

 private:
  double previous_ = 0;  ///< [s]
};

}  // namespace tern
