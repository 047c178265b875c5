#pragma once
// Copies of values that belong to other ranks, behind the own ones in the same array.

#include <cstring>
#include <vector>

#include "ranks/ranks.hpp"

namespace tern {

class Halo {
 public:
  Halo() = default;
  /// There are no other ranks, or none are known.
  bool alone() const { return ranks_.alone(); }
  /// give[r]: places of the own values that rank r holds copies of; take[r]: places of the copies of its values, in its order.
  void reset(const Ranks& ranks, Subject subject, const std::vector<std::vector<int>>& give, const std::vector<std::vector<int>>& take) {
    ranks_ = ranks;
    subject_ = subject;
    peers_.clear();
    for (std::size_t r = 0; r < give.size(); ++r)
      if (!give[r].empty() || !take[r].empty()) peers_.push_back({static_cast<int>(r), give[r], take[r]});
    outgoing_.resize(peers_.size());
    incoming_.resize(peers_.size());
  }

  /// Brings the copies up to date: of all these arrays, in one message to each rank.
  template <class... V>
  void update(std::vector<V>&... values) const {
    constexpr std::size_t size = (sizeof(V) + ...);
    make_room(size, &Peer::give, &Peer::take);
    for (std::size_t p = 0; p < peers_.size(); ++p) {
      std::byte* to = outgoing_[p].data();
      (write(values, peers_[p].give, to), ...);
    }
    speak();
    for (std::size_t p = 0; p < peers_.size(); ++p) {
      const std::byte* from = incoming_[p].data();
      (read(values, peers_[p].take, from, [](auto& own, const auto& other) { own = other; }), ...);
    }
  }

  /// The other way: add(own value, copy) for each copy that another rank holds, in the order of the ranks.
  template <class V, class Add>
  void collect(std::vector<V>& values, Add&& add) const {
    make_room(sizeof(V), &Peer::take, &Peer::give);
    for (std::size_t p = 0; p < peers_.size(); ++p) {
      std::byte* to = outgoing_[p].data();
      write(values, peers_[p].take, to);
    }
    speak();
    for (std::size_t p = 0; p < peers_.size(); ++p) {
      const std::byte* from = incoming_[p].data();
      read(values, peers_[p].give, from, add);
    }
  }

 private:
  struct Peer {
    int rank;
    std::vector<int> give, take;
  };

  template <class V>
  static void write(const std::vector<V>& values, const std::vector<int>& places, std::byte*& to) {
    for (int place : places) {
      std::memcpy(to, &values[static_cast<std::size_t>(place)], sizeof(V));
      to += sizeof(V);
    }
  }
  template <class V, class Add>
  static void read(std::vector<V>& values, const std::vector<int>& places, const std::byte*& from, Add&& add) {
    for (int place : places) {
      V other;
      std::memcpy(static_cast<void*>(&other), from, sizeof(V));
      add(values[static_cast<std::size_t>(place)], other);
      from += sizeof(V);
    }
  }
  void make_room(std::size_t size, std::vector<int> Peer::*out, std::vector<int> Peer::*in) const {
    for (std::size_t p = 0; p < peers_.size(); ++p) {
      outgoing_[p].resize((peers_[p].*out).size() * size);
      incoming_[p].resize((peers_[p].*in).size() * size);
    }
  }
  void speak() const {
    if (ranks_.alone()) return;
    give_.clear();
    take_.clear();
    for (std::size_t p = 0; p < peers_.size(); ++p) {
      if (!outgoing_[p].empty()) give_.push_back({peers_[p].rank, outgoing_[p].data(), outgoing_[p].size()});
      if (!incoming_[p].empty()) take_.push_back({peers_[p].rank, incoming_[p].data(), incoming_[p].size()});
    }
    ranks_.exchange(give_, take_, subject_);
  }

  Ranks ranks_;
  Subject subject_ = Subject::other;
  std::vector<Peer> peers_;
  // Kept so that a step allocates nothing.
  mutable std::vector<std::vector<std::byte>> outgoing_, incoming_;
  mutable std::vector<RankMessage> give_, take_;
};

}  // namespace tern
