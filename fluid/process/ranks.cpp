#include "fluid/process/ranks.hpp"

#include <sys/prctl.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <optional>

#include <fmt/format.h>
#include <omp.h>

#include "base/interrupt.hpp"
#include "base/log.hpp"
#include "run/command_line.hpp"

namespace tern::fluid {
namespace {

/// Computes what is ordered, until the end.
template <int D>
void obey(const Case& scene, const Ranks& ranks) {
  std::optional<Fluid<D>> made;
  try {
    made.emplace(scene, ranks);
  } catch (const BadInput&) {
    // Of the case, which all ranks have read: the first one says so.
  }
  while (true) {
    Order order{};
    ranks.tell(&order, sizeof order);
    try {
      if (order.kind == Order::end) return;
      Fluid<D>& fluid = made.value();
      const auto told = [&]<class OfInterface>(OfInterface values) {
        tell(ranks, values);
        return values;
      };
      switch (order.kind) {
        case Order::make_fluid:
        case Order::end: break;
        case Order::begin_window: fluid.begin_window(order.begin, order.duration); break;
        case Order::see_surface: fluid.see_surface(told(Surface<D>{})); break;
        case Order::prepare_pressure: fluid.prepare_pressure(); break;
        case Order::solve_pressure: fluid.solve_pressure(told(InterfaceCondition<D>{})); break;
        case Order::complete_velocity: fluid.complete_velocity(); break;
        case Order::end_window: fluid.end_window(told(InterfaceForce<D>{})); break;
        case Order::pass_window: fluid.pass_window(); break;
        case Order::gather_state: fluid.whole_state(); break;
        case Order::tell_shares: fluid.shares(); break;
        case Order::set_state: {
          State<D> state;
          Shares shares;
          tell_fields(ranks, state);
          tell_fields(ranks, shares);
          fluid.set_whole_state(std::move(state), shares);
          break;
        }
      }
    } catch (const NumericalFailure&) {
      // All ranks have it, and the first one says so and orders the end.
    }
  }
}

}  // namespace

void announce(const Ranks& ranks) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  const char* directory = std::getenv("TERN_RANK_DIRECTORY");
  if (directory == nullptr) return;
  std::ofstream(fmt::format("{}/rank.{}", directory, ranks.own())) << ::getpid() << std::endl;
}

int follow(int argc, char** argv, const Ranks& ranks) {
  install_interrupt_handler();  // the first rank decides when all end
  Order order{};
  ranks.tell(&order, sizeof order);
  if (order.kind != Order::make_fluid) return 0;
  try {
    const CommandLine command = parse_command_line(argc, argv, "fluid");
    const Case scene = read_case(command.case_path, command.options);
    omp_set_num_threads(command.threads);
    scene.dimension == 2 ? obey<2>(scene, ranks) : obey<3>(scene, ranks);
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "tern-fluid, rank %d: %s\n", ranks.own(), error.what());
  }
  abandon_ranks(static_cast<int>(ExitCode::numerical_failure));
}

void dismiss(const Ranks& ranks) { Leader<2>::order(ranks, {Order::end}); }

}  // namespace tern::fluid
