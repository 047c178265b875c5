#include "fluid/process/ranks.hpp"

#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <new>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <omp.h>

#include "base/interrupt.hpp"
#include "base/log.hpp"
#include "base/timing.hpp"
#include "ranks/waiting.hpp"
#include "run/command_line.hpp"

namespace tern::fluid {
namespace {

/// Computes what is ordered, until the end.
template <int D>
void obey(const Case& scene, const Ranks& ranks) {
  std::optional<Fluid<D>> made;
  try {
    compare_cases(ranks, scene.hash);
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
        case Order::tell_load: loads(fluid); break;
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

std::string machine_name() {
  char name[256] = "";
  ::gethostname(name, sizeof name - 1);
  return name;
}

}  // namespace

template <int D>
std::vector<Load> loads(const Fluid<D>& fluid) {
  rusage usage{};
  ::getrusage(RUSAGE_SELF, &usage);
  Load own{.particles = static_cast<std::int64_t>(fluid.state().size()),
           .ghosts = static_cast<std::int64_t>(fluid.domain().ghosts()),
           .cpu_s = cpu_seconds(),
           .waiting_s = seconds_with_ranks(),
           .peak_memory_bytes = std::int64_t{1024} * usage.ru_maxrss,
           .machine = {}};
  machine_name().copy(own.machine.data(), own.machine.size() - 1);
  return fluid.domain().ranks().gather(std::vector<Load>{own});
}
template std::vector<Load> loads<2>(const Fluid<2>&);
template std::vector<Load> loads<3>(const Fluid<3>&);

void announce(const Ranks& ranks) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  const char* directory = std::getenv("TERN_RANK_DIRECTORY");
  if (directory == nullptr) return;
  // Renamed into place, so that nobody reads half of it.
  const std::string path = fmt::format("{}/rank.{}", directory, ranks.own());
  std::ofstream(path + ".tmp") << fmt::format("{} {}\n", ::getpid(), machine_name());
  std::rename((path + ".tmp").c_str(), path.c_str());
}

int follow(int argc, char** argv, const Ranks& ranks) {
  install_interrupt_handler();  // the first rank decides when all end
  Order order{};
  ranks.tell(&order, sizeof order);
  if (order.kind != Order::make_fluid) return 0;
  try {
    const CommandLine command = parse_command_line(argc, argv, "fluid");
    const Case scene = read_case(command.case_path, command.options);
    omp_set_num_threads(std::max(command.threads, 1));
    scene.dimension == 2 ? obey<2>(scene, ranks) : obey<3>(scene, ranks);
    return 0;
  } catch (...) {
    end_all(ranks);
  }
}

void end_all(const Ranks& ranks) {
  ExitCode code = ExitCode::numerical_failure;
  std::string sentence = "It met an unexpected fault of its own.";
  try {
    throw;
  } catch (const Error& error) {
    code = error.code();
    sentence = error.what();
  } catch (const std::bad_alloc&) {
    sentence = fmt::format("It ran out of memory as one of {} ranks; use more of them, or a coarser spacing.", ranks.count());
  } catch (const std::exception& error) {
    sentence = fmt::format("It met an unexpected fault of its own: {}.", error.what());
  } catch (...) {}
  // The launcher reads this line (python/tern/launch/ranks.py).
  std::fprintf(stderr, "tern-fluid, rank %d: %s\n", ranks.own(), sentence.c_str());
  abandon_ranks(static_cast<int>(code));
}

void compare_cases(const Ranks& ranks, const std::string& hash) {
  if (ranks.alone()) return;
  std::vector<char> first(hash.begin(), hash.end());
  ranks.tell(first);
  const bool same = std::string(first.begin(), first.end()) == hash;
  const std::string other =
      same ? ""
           : fmt::format("Rank {} on {} has read another case than the first: a file it names differs there.", ranks.own(), machine_name());
  if (const std::string word = ranks.first_word(other); !word.empty()) throw BadInput(word);
}

void dismiss(const Ranks& ranks) { Leader<2>::order(ranks, {Order::end}); }

}  // namespace tern::fluid
