// Ctrl-C and termination signals as a flag.

#include "base/interrupt.hpp"

#include <fmt/format.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <string>

#include "base/error.hpp"

namespace tern {

namespace {

volatile std::sig_atomic_t signal_received = 0;

void remember(int signal) { signal_received = signal; }

const char* signal_name(int signal) {
  switch (signal) {
    case SIGINT: return "SIGINT (Ctrl-C)";
    case SIGTERM: return "SIGTERM";
    case SIGHUP: return "SIGHUP (terminal closed)";
    default: return "a signal";
  }
}

}  // namespace

void install_interrupt_handler() {
  struct sigaction action = {};
  action.sa_handler = remember;  // no SA_RESTART: a process that waits for a message or a disk must wake up
  sigemptyset(&action.sa_mask);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction inherited = {};
    if (sigaction(signal, nullptr, &inherited) == 0 && inherited.sa_handler == SIG_IGN) continue;
    sigaction(signal, &action, nullptr);
  }
  struct sigaction ignore = {};
  // A closed pipe or socket, and a file that reaches the limit of `ulimit -f`, is an error of the write, not the death of the process.
  ignore.sa_handler = SIG_IGN;
  sigemptyset(&ignore.sa_mask);
  for (const int number : {SIGPIPE, SIGXFSZ}) sigaction(number, &ignore, nullptr);
}

bool end_with_launcher() {
  if (std::getenv("TERN_RANK_DIRECTORY") != nullptr) return true;  // a rank ends with mpirun, which is the launcher's
  const char* launcher = std::getenv("TERN_LAUNCHER");
  if (launcher == nullptr || std::to_string(::getppid()) != launcher) return false;  // started by somebody else in the same environment
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (std::to_string(::getppid()) != launcher) std::raise(SIGTERM);  // it died in between
  return true;
}

bool interrupted() { return signal_received != 0; }

void throw_if_interrupted(const char* where) {
  if (const int signal = signal_received; signal != 0)
    throw Interrupted(fmt::format("Interrupted by {} {}; everything written up to here is kept.", signal_name(signal), where));
}

}  // namespace tern
