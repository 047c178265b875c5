#pragma once
// A coupled run from the first hello to the last account.

#include "proto/transport/channel.hpp"
#include "run/command_line.hpp"
#include "run/run_report.hpp"
#include "scene/case_file.hpp"

namespace tern::coupler {

/// Waits for both participants, couples them to the end of the case, writes the tables. Throws what they, the channel and the coupler
/// throw, and Interrupted.
template <int D>
void run(const CommandLine& command, const Case& scene, proto::CouplerChannel& channel, RunReport& report);

}  // namespace tern::coupler
