// tern-coupler: owns time and everything that happens between fluid and structure.

#include <fmt/format.h>

#include "base/error.hpp"
#include "coupler/process/run.hpp"
#include "proto/transport/channel.hpp"
#include "run/command_line.hpp"

namespace {

using namespace tern;

void run(const CommandLine& command, const Case& scene, RunReport& report) {
  if (!scene.fluid || !scene.structure)
    throw BadInput(scene.path + " has no [" + (scene.fluid ? "structure" : "fluid") +
                   "] table: nothing is coupled, so no coupler is needed. Use ./tern run, or start the one process by hand.");
  proto::CouplerChannel channel({command.endpoint, command.keys, command.insecure}, 300, command.deadline_s);
  if (!command.quiet && channel.endpoint().starts_with("tcp://"))
    fmt::print(stderr, "tern-coupler: listens at {} and waits for fluid and structure\n", channel.endpoint());
  try {
    scene.dimension == 2 ? coupler::run<2>(command, scene, channel, report) : coupler::run<3>(command, scene, channel, report);
  } catch (const Error& error) {
    channel.abort(error);
    throw;
  }
}

}  // namespace

int main(int argc, char** argv) { return run_main(argc, argv, "coupler", run); }
