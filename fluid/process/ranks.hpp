#pragma once
// The fluid in many processes. The first rank is the process that a user, the report and the results know; the others compute their part
// of what it orders, write nothing, and end with it.

#include <cstring>

#include "fluid/fluid.hpp"

namespace tern::fluid {

struct Order {
  enum Kind : std::int64_t { make_fluid, compute_window, gather_state, end };
  Kind kind;
  Ticks begin = 0, duration = 0;  ///< of the window
};

/// Throws BadInput with the first thing in the scene that several ranks cannot compute yet.
void check_case_for_ranks(const Case& scene);

/// The first rank, between its work and that of the others. Alone it orders nothing.
template <int D>
class Leader {
 public:
  /// All ranks make their fluid.
  Leader(const Case& scene, const Ranks& ranks) : ranks_(ranks), fluid_(make(scene, ranks)) {}
  Leader(const Leader&) = delete;
  Leader& operator=(const Leader&) = delete;

  const Fluid<D>& fluid() const { return fluid_; }
  /// Alone: to be changed.
  Fluid<D>& own_fluid() { return fluid_; }

  void compute_window(Ticks begin, Ticks duration) {
    order(ranks_, {Order::compute_window, begin, duration});
    fluid_.begin_window(begin, duration);
    fluid_.pass_window();
  }

  /// look(fluid), whose state is that of all ranks for as long.
  template <class Look>
  auto look(Look&& look) {
    if (ranks_.alone()) return look(std::as_const(fluid_));
    order(ranks_, {Order::gather_state});
    const WholeState<D> whole(fluid_);
    return look(std::as_const(fluid_));
  }

  static void order(const Ranks& ranks, Order order) {
    if (!ranks.alone()) ranks.tell(&order, sizeof order);
  }

 private:
  static Fluid<D> make(const Case& scene, const Ranks& ranks) {
    order(ranks, {Order::make_fluid});
    return Fluid<D>(scene, ranks);
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
