#pragma once
// The fluid in many processes. The first rank is the process that a user, the report and the results know; the others compute their part
// of what it orders, write nothing, and end with it.

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "fluid/boundary/interface_of_ranks.hpp"
#include "fluid/fluid.hpp"
#include "run/state_file.hpp"

namespace tern::fluid {

struct Order {
  enum Kind : std::int64_t {
    make_fluid,
    begin_window,
    see_surface,
    prepare_pressure,
    solve_pressure,
    complete_velocity,
    end_window,
    pass_window,
    gather_state,
    tell_shares,
    tell_load,
    set_state,
    end
  };
  Kind kind;
  Ticks begin = 0, duration = 0;  ///< of the window
};

/// What a rank has to do and has spent.
struct Load {
  std::int64_t particles, ghosts;
  double cpu_s, waiting_s;
  std::int64_t peak_memory_bytes;
  std::array<char, 64> machine;
};
/// Of all ranks in their order, on the first one; nothing on the others.
template <int D>
std::vector<Load> loads(const Fluid<D>& fluid);

/// From the first rank to all.
template <class T>
void tell_fields(const Ranks& ranks, T& value) {
  if (ranks.alone()) return;
  if constexpr (HasFields<T>) {
    T::for_each_field([&](const char*, auto& own) { tell_fields(ranks, own); }, value);
  } else if constexpr (requires { typename T::allocator_type; }) {
    ranks.tell(value);
  } else {
    static_assert(std::is_arithmetic_v<T>);
    ranks.tell(&value, sizeof value);
  }
}

/// Throws BadInput on all ranks where one of them has read another case than the first.
void compare_cases(const Ranks& ranks, const std::string& hash);

/// What happened to this rank alone, in the exception in flight: says so and ends all of them, which would wait for it for ever.
[[noreturn]] void end_all(const Ranks& ranks);

/// The first rank, between its work and that of the others: a fluid as the coupling sees it. Alone it orders nothing.
template <int D>
class Leader {
 public:
  /// All ranks make their fluid.
  Leader(const Case& scene, const Ranks& ranks) : ranks_(ranks), fluid_(make(scene, ranks)) {}
  Leader(const Leader&) = delete;
  Leader& operator=(const Leader&) = delete;

  const Fluid<D>& fluid() const { return fluid_; }

  void begin_window(Ticks begin, Ticks duration) {
    order(ranks_, {Order::begin_window, begin, duration});
    together([&] { fluid_.begin_window(begin, duration); });
  }
  InterfaceParticles<D> see_surface(const Surface<D>& surface) {
    order(ranks_, {Order::see_surface}, surface);
    return together([&] { return fluid_.see_surface(surface); });
  }
  void prepare_pressure() {
    order(ranks_, {Order::prepare_pressure});
    together([&] { fluid_.prepare_pressure(); });
  }
  InterfacePressure<D> solve_pressure(const InterfaceCondition<D>& condition) {
    order(ranks_, {Order::solve_pressure}, condition);
    return together([&] { return fluid_.solve_pressure(condition); });
  }
  void complete_velocity() {
    order(ranks_, {Order::complete_velocity});
    together([&] { fluid_.complete_velocity(); });
  }
  void end_window(const InterfaceForce<D>& force) {
    order(ranks_, {Order::end_window}, force);
    together([&] { fluid_.end_window(force); });
  }
  void pass_window() {
    order(ranks_, {Order::pass_window});
    together([&] { fluid_.pass_window(); });
  }

  /// look(fluid), whose state is that of all ranks for as long.
  template <class Look>
  auto look(Look&& look) {
    if (ranks_.alone()) return look(std::as_const(fluid_));
    order(ranks_, {Order::gather_state});
    const auto whole = together([&] { return std::make_unique<const WholeState<D>>(fluid_); });
    return look(std::as_const(fluid_));
  }

  /// What the ranks go on from to a checkpoint, and back. They may have become more or fewer.
  void save(StateWriter& file) {
    look([&](const Fluid<D>& whole) { file("fluid", whole.state()); });
    if (ranks_.alone()) return;
    order(ranks_, {Order::tell_shares});
    file("shares", fluid_.shares());
  }
  void restore(StateReader& file) {
    State<D> state;
    Shares shares;
    file("fluid", state);
    if (file.has("shares")) file("shares", shares);
    order(ranks_, {Order::set_state});
    tell_fields(ranks_, state);
    tell_fields(ranks_, shares);
    fluid_.set_whole_state(std::move(state), shares);
  }

  /// Of all ranks; of a fluid in one process nothing.
  std::vector<Load> loads() const {
    if (ranks_.alone()) return {};
    order(ranks_, {Order::tell_load});
    return fluid::loads(fluid_);
  }

  static void order(const Ranks& ranks, Order order) {
    if (!ranks.alone()) ranks.tell(&order, sizeof order);
  }
  /// With what of the interface the others need for it.
  template <class OfInterface>
  static void order(const Ranks& ranks, Order what, const OfInterface& values) {
    if (ranks.alone()) return;
    order(ranks, what);
    OfInterface told = values;
    tell(ranks, told);
  }

 private:
  /// What all ranks do. A numerical failure is that of all; any other is of this rank, while the others go on.
  template <class Work>
  auto together(Work&& work) {
    if (ranks_.alone()) return work();
    try {
      return work();
    } catch (const NumericalFailure&) {
      throw;
    } catch (...) {
      end_all(ranks_);
    }
  }

  static Fluid<D> make(const Case& scene, const Ranks& ranks) {
    order(ranks, {Order::make_fluid});
    compare_cases(ranks, scene.hash);
    try {
      return Fluid<D>(scene, ranks);
    } catch (const Error&) {
      throw;  // of all
    } catch (...) {
      if (ranks.alone()) throw;
      end_all(ranks);
    }
  }

  Ranks ranks_;
  Fluid<D> fluid_;
};

/// Writes the process id to where the launcher looks for it, and ends with what has started the ranks.
void announce(const Ranks& ranks);

/// The whole main() of another rank.
int follow(int argc, char** argv, const Ranks& ranks);

/// Of the first rank, when it has ended its own work: lets the others end.
void dismiss(const Ranks& ranks);

}  // namespace tern::fluid
