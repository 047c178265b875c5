#pragma once
// Window lengths: no step much shorter or longer than the one before, and output times met by stretching or shrinking
// the last steps before them evenly. A single short step would turn the residual divergence of the steps before it into a
// pressure jump of order 1/dt.

#include "base/time.hpp"

namespace tern {

class StepControl {
 public:
  /// Of a window, where the next one need not be shorter at once.
  static constexpr double fastest_shortening = 0.8;

  /// Next window length [ticks] for a proposal [s], from `now` towards the next time that must be met.
  Ticks next(double proposed_seconds, Ticks now, Ticks target);

  /// What next() has given last; 0 before the first.
  Ticks last_window() const { return to_ticks(previous_); }

  /// Whether windows of less than ten ticks have been proposed a hundred times in a row: time is not counted more finely, and the run would
  /// never end.
  bool crawls() const { return crawling_ >= 100; }

  /// From here on windows of at most this length [s]: they are repeated, because others, 2^halvings as long, have failed at the time
  /// `until` [ticks]. By and by, but when that has been tried (more than one halving) or before the first window, at once. Every hundred
  /// windows after that time double the length, until it is theirs again.
  void shorten(int halvings, Ticks until, double longest);
  /// How often windows are halved now.
  int halvings() const { return halvings_; }

  /// The list of the members: visit(name, member of each) for every one.
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("previous", all.previous_...);
    visit("longest", all.longest_...);
    visit("halvings", all.halvings_...);
    visit("until", all.until_...);
    visit("windows", all.windows_...);
    visit("crawling", all.crawling_...);
  }

 private:
  double previous_ = 0;  ///< [s]
  double longest_ = 0;   ///< where windows are halved [s]
  int halvings_ = 0;
  Ticks until_ = 0;
  std::int64_t windows_ = 0;  ///< after that, or since their share has doubled
  int crawling_ = 0;          ///< proposals of less than ten ticks, in a row
};

}  // namespace tern
