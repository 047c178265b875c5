#pragma once
// Which things around a place belong together, where each rank knows some of it: particles of a grid cell, cells around a node, nodes
// around a coarser one. Whoever owns the place joins what all have said.

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "fluid/pressure/connected_parts.hpp"

namespace tern::fluid {

/// At this place these two things belong together; with itself: it is there.
struct Link {
  std::int64_t place, thing, with;
};

class PartsOfPlaces {
 public:
  /// Parts of a place are numbered by the least thing in each; those beyond the number `most` count as one with the last of it.
  void join(const std::vector<Link>& links, int most) {
    things_.clear();
    for (const Link& link : links) things_.insert(things_.end(), {{link.place, link.thing}, {link.place, link.with}});
    std::sort(things_.begin(), things_.end());
    things_.erase(std::unique(things_.begin(), things_.end()), things_.end());
    joined_.reset(static_cast<int>(things_.size()));
    for (const Link& link : links) joined_.join(index(link.place, link.thing), index(link.place, link.with));
    joined_.count_parts(static_cast<int>(things_.size()) + 1);
    most_ = most;
  }

  /// How many parts there are at a place of which a thing is known.
  int count(std::int64_t place) const {
    int last = 0;
    for (int a = index(place, lowest); a < static_cast<int>(things_.size()) && things_[a].first == place; ++a)
      last = std::max(last, part(place, things_[a].second));
    return last + 1;
  }

  /// The part that a thing at a place is in; both must have been in a link.
  int part(std::int64_t place, std::int64_t thing) const {
    return std::min(joined_.number(index(place, thing)) - joined_.number(index(place, lowest)), most_ - 1);
  }

 private:
  static constexpr std::int64_t lowest = INT64_MIN;
  int index(std::int64_t place, std::int64_t thing) const {
    return static_cast<int>(std::lower_bound(things_.begin(), things_.end(), std::pair(place, thing)) - things_.begin());
  }

  std::vector<std::pair<std::int64_t, std::int64_t>> things_;  ///< place and thing, in order
  ConnectedParts joined_;
  int most_ = 1;
};

}  // namespace tern::fluid
