// [output]

#include "scene/keys/row.hpp"
#include "scene/keys/tables.hpp"

namespace tern {
namespace {

using Presence = TableDefinition::Presence;

const Rows<OutputCase>& output_rows() {
  // clang-format off
  static const Rows<OutputCase> rows = {
      {"frame_interval", &OutputCase::frame_interval, "s", "0", an_interval,
       "Time between frames of the particle fields; 0 = the first and the last only. The last but one is half of it before the end or "
       "more."},
      {"gauge_interval", &OutputCase::gauge_interval, "s", "0", an_interval, "Time between rows of gauges.csv; 0 = every step."},
      {"checkpoint_interval", &OutputCase::checkpoint_interval, "s", "300", an_interval,
       "Wall time between checkpoints, from which ./tern resume goes on (the last two are kept); one more at the end and on Ctrl-C; "
       "0 = none."},
  };
  // clang-format on
  return rows;
}

}  // namespace

std::vector<TableDefinition> output_tables() {
  return {{"output", false, Presence::filled, "What a run writes, and how often.", parameters_of(output_rows())}};
}

OutputCase read_output(const Setting& table) { return filled(output_rows(), table); }

OutputCase default_output() {
  static const OutputCase output = [] {
    OutputCase all{};
    fill_defaults(all, output_rows());
    return all;
  }();
  return output;
}

}  // namespace tern
