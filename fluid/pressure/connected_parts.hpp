#pragma once
// Connected parts of a few things, by union and find.

#include <algorithm>
#include <numeric>
#include <vector>

namespace tern::fluid {

class ConnectedParts {
 public:
  /// Starts with n things that are all apart.
  void reset(int n) {
    above_.resize(n);
    std::iota(above_.begin(), above_.end(), 0);
  }
  void join(int a, int b) {
    a = top(a), b = top(b);
    above_[std::max(a, b)] = std::min(a, b);
  }
  /// Numbers the parts by their first member; those beyond the number `most` count as one with the last of it.
  void count_parts(int most) {
    count_ = 0;
    number_.resize(above_.size());
    for (int a = 0; a < static_cast<int>(above_.size()); ++a) number_[a] = top(a) == a ? std::min(count_++, most - 1) : number_[top(a)];
    count_ = std::min(count_, most);
  }
  int count() const { return count_; }
  int number(int a) const { return number_[a]; }

 private:
  int top(int a) const {
    while (above_[a] != a) a = above_[a];
    return a;
  }
  std::vector<int> above_, number_;
  int count_ = 0;
};

}  // namespace tern::fluid
