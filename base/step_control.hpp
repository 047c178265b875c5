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

  /// From here on 2^-halvings of what is proposed, by and by unless it is the first: these windows are repeated, because longer ones have
  /// failed at the time `until` [ticks]. Every hundred windows after that double the share again.
  void shorten(int halvings, Ticks until);
  /// How often windows are halved now.
  int halvings() const { return halvings_; }

  /// The list of the members: visit(name, member of each) for every one.
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("previous", all.previous_...);
    visit("share", all.share_...);
    visit("halvings", all.halvings_...);
    visit("until", all.until_...);
    visit("windows", all.windows_...);
  }

 private:
  double previous_ = 0;  ///< [s]
  double share_ = 1;     ///< of what is proposed
  int halvings_ = 0;
  Ticks until_ = 0;
  std::int64_t windows_ = 0;  ///< after that, or since their share has doubled
};

}  // namespace tern
