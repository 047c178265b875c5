#pragma once
// The accounts of fluid and structure: their lengths, the tables made of them, and the energies that the coupler watches.

#include <optional>
#include <string>
#include <vector>

#include "coupler/window.hpp"
#include "proto/wire/account.hpp"
#include "run/recorder.hpp"
#include "run/state_file.hpp"

namespace tern::coupler {

/// Throws BadInput when a participant accounts for other things than the case asks it for.
void check_accounts(const Case& scene, const wire::Account& fluid, const wire::Account& structure);

template <int D>
class Accounts {
 public:
  /// Creates the tables of the run in `directory`; not `anew`: they are there, and restore() follows.
  Accounts(const std::string& directory, const Case& scene, bool anew);

  /// A row of both sides at the instant `now`, when one is due.
  void record(Ticks now, const wire::Account& fluid, const wire::Account& structure, const Coupler<D>& coupler);

  /// What watch_energy() sees; empty where walls move, for nobody counts what these give the fluid, and where a foreign participant keeps
  /// no account.
  std::optional<Energies> energies(Ticks now, const wire::Account& fluid, const wire::Account& structure, bool fluid_has_weight) const;

  /// Where tables and counts are, to a checkpoint and back.
  void save(StateWriter& file);
  void restore(StateReader& file);

  Recorder& recorder() { return recorder_; }
  long evaluated_gauges() const { return evaluated_gauges_; }

 private:
  double work_on_structure(const wire::Account& structure) const;

  const Case& scene_;
  std::vector<std::string> structure_columns_;
  std::size_t work_column_;
  bool walls_move_;
  Recorder recorder_;
  long evaluated_gauges_ = 0;
};

}  // namespace tern::coupler
