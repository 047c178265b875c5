#pragma once
// The processes that share one fluid, and what they say to each other. One of them alone says nothing: alone/ has no other, mpi/ sends by
// MPI. Nothing else in tern knows MPI. All ranks call the functions of this file in the same order.

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <vector>

namespace tern {

/// Values that go to a rank or come from one.
struct RankMessage {
  int rank;
  void* bytes;
  std::size_t size;
};

/// What a message is about.
enum class Subject { particles, nodes, other };

/// What a rank has said since its start. All ranks exchange and combine as often as each other; messages and bytes are those that it sends
/// to single ranks.
struct Traffic {
  std::int64_t particle_exchanges = 0, node_exchanges = 0, other_exchanges = 0, messages = 0, bytes = 0;
  std::int64_t collectives = 0, collective_bytes = 0;

  /// The list of the members: visit(name, member of each) for every one.
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("particle_exchanges", all.particle_exchanges...);
    visit("node_exchanges", all.node_exchanges...);
    visit("other_exchanges", all.other_exchanges...);
    visit("messages", all.messages...);
    visit("message_bytes", all.bytes...);
    visit("collectives", all.collectives...);
    visit("collective_bytes", all.collective_bytes...);
  }
};

class Ranks {
 public:
  /// One process alone.
  Ranks() = default;
  /// Those that were started together.
  static Ranks all();

  int count() const { return count_; }
  int own() const { return own_; }
  bool alone() const { return count_ == 1; }
  bool first() const { return own_ == 0; }

  // Over all ranks, with the same bits on all of them and in every run with as many ranks.
  template <class T>
  void sum(std::span<T> values) const {
    if (!alone()) combine(values.data(), values.size(), kind(values.data()), Operation::sum);
  }
  template <class T>
  void least(std::span<T> values) const {
    if (!alone()) combine(values.data(), values.size(), kind(values.data()), Operation::least);
  }
  template <class T>
  void most(std::span<T> values) const {
    if (!alone()) combine(values.data(), values.size(), kind(values.data()), Operation::most);
  }
  template <class T>
  T sum(T value) const {
    sum(std::span(&value, 1));
    return value;
  }
  template <class T>
  T least(T value) const {
    least(std::span(&value, 1));
    return value;
  }
  template <class T>
  T most(T value) const {
    most(std::span(&value, 1));
    return value;
  }
  bool any(bool own) const { return most(static_cast<std::uint8_t>(own)) != 0; }
  /// Sums of the ones and the greatest of the others, at the price of one sum.
  void sum_and_most(std::span<double> sums, std::span<double> most) const;
  /// The least of `low` and the greatest of `high`, at the price of one; both of the same length.
  void extremes(std::span<double> low, std::span<double> high) const;

  /// Gives and takes at the same time. Only these ranks take part: what one gives another has to take, with the same size.
  void exchange(std::span<const RankMessage> give, std::span<const RankMessage> take, Subject subject = Subject::other) const;

  /// to[r] goes to rank r, what rank r has for this one comes into from[r]. T is copied byte by byte.
  template <class T>
  void deal(const std::vector<std::vector<T>>& to, std::vector<std::vector<T>>& from, Subject subject = Subject::other) const {
    from.resize(static_cast<std::size_t>(count()));
    if (alone()) {
      from[0] = to[0];
      return;
    }
    std::vector<std::int64_t> sizes(to.size());
    for (std::size_t r = 0; r < to.size(); ++r) sizes[r] = static_cast<std::int64_t>(to[r].size());
    swap_sizes(sizes);
    std::vector<RankMessage> give, take;
    for (std::size_t r = 0; r < to.size(); ++r) {
      from[r].resize(static_cast<std::size_t>(sizes[r]));
      const int rank = static_cast<int>(r);
      if (!to[r].empty()) give.push_back({rank, const_cast<T*>(to[r].data()), to[r].size() * sizeof(T)});
      if (!from[r].empty()) take.push_back({rank, from[r].data(), from[r].size() * sizeof(T)});
    }
    exchange(give, take, subject);
  }

  /// Of all ranks in their order, on the first one; nothing on the others.
  template <class T>
  std::vector<T> gather(const std::vector<T>& own) const {
    std::vector<std::vector<T>> to(static_cast<std::size_t>(count())), from;
    to[0] = own;
    deal(to, from);
    std::vector<T> all;
    for (const auto& part : from) all.insert(all.end(), part.begin(), part.end());
    return all;
  }

  /// From one rank to all.
  void tell(void* bytes, std::size_t size, int from = 0) const;
  template <class T>
  void tell(std::vector<T>& values, int from = 0) const {
    if (alone()) return;
    std::uint64_t size = values.size();
    tell(&size, sizeof size, from);
    values.resize(size);
    if (size > 0) tell(static_cast<void*>(values.data()), size * sizeof(T), from);
  }

  /// Several at once, at the price of one.
  template <class... V>
  void tell_together(std::vector<V>&... values) const {
    if (alone()) return;
    std::uint64_t sizes[] = {values.size()...};
    tell(static_cast<void*>(sizes), sizeof sizes);
    std::vector<std::byte> bytes;
    if (first()) (append(values, bytes), ...);
    std::size_t next = 0, size = 0;
    ((values.resize(sizes[next++]), size += values.size() * sizeof(V)), ...);
    bytes.resize(size);
    if (size > 0) tell(static_cast<void*>(bytes.data()), size);
    const std::byte* from = bytes.data();
    (take(from, values), ...);
  }

  /// Of all ranks in their order, on the first one; nothing on the others. Several at once, at the price of one.
  template <class... V>
  void gather_together(std::vector<V>&... values) const {
    if (alone()) return;
    std::vector<std::vector<std::byte>> to(static_cast<std::size_t>(count())), from;
    (append(std::vector<std::uint64_t>{values.size()}, to[0]), ...);
    (append(values, to[0]), ...);
    deal(to, from);
    (values.clear(), ...);
    if (!first()) return;
    for (const auto& part : from) {
      const std::byte* next = part.data();
      std::vector<std::uint64_t> sizes(sizeof...(V));
      take(next, sizes);
      std::size_t k = 0;
      (take_further(next, sizes[k++], values), ...);
    }
  }

  /// Of all ranks in their order, on all of them.
  template <class... V>
  void gather_on_all(std::vector<V>&... values) const {
    gather_together(values...);
    tell_together(values...);
  }

  /// What this process has said.
  static const Traffic& traffic();

  /// What the first rank that has something to say says; empty: none has.
  std::string first_word(const std::string& own) const;

 private:
  enum class Kind { real, single, whole, byte };
  enum class Operation { sum, least, most };
  static Kind kind(const double*) { return Kind::real; }
  static Kind kind(const float*) { return Kind::single; }
  static Kind kind(const std::int64_t*) { return Kind::whole; }
  static Kind kind(const std::uint8_t*) { return Kind::byte; }
  template <class T>
  static void append(const std::vector<T>& values, std::vector<std::byte>& bytes) {
    const auto* const from = reinterpret_cast<const std::byte*>(values.data());
    bytes.insert(bytes.end(), from, from + values.size() * sizeof(T));
  }
  template <class T>
  static void take(const std::byte*& from, std::vector<T>& values) {
    if (!values.empty()) std::memcpy(static_cast<void*>(values.data()), from, values.size() * sizeof(T));
    from += values.size() * sizeof(T);
  }
  template <class T>
  static void take_further(const std::byte*& from, std::uint64_t count, std::vector<T>& values) {
    std::vector<T> further(count);
    take(from, further);
    values.insert(values.end(), further.begin(), further.end());
  }
  void combine(void* values, std::size_t n, Kind kind, Operation operation) const;
  /// sizes[r]: for rank r, then from it.
  void swap_sizes(std::vector<std::int64_t>& sizes) const;

  int own_ = 0, count_ = 1;
};

/// Lets ranks speak for as long as it lives: for main(). Threads of one rank may not.
class RanksAtWork {
 public:
  RanksAtWork();
  ~RanksAtWork();
  RanksAtWork(const RanksAtWork&) = delete;
  RanksAtWork& operator=(const RanksAtWork&) = delete;
};

/// This process was started as one of several ranks, or as the only one of them.
bool ranks_were_started();

/// Ends all ranks at once: where one of them cannot go on and the others would wait for it.
[[noreturn]] void abandon_ranks(int exit_code);

}  // namespace tern
