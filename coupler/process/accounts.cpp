#include "coupler/process/accounts.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/error.hpp"
#include "coupler/gauges/gauges.hpp"

namespace tern::coupler {
namespace {

template <class T>
std::vector<T> joined(std::vector<T> first, const std::vector<T>& second, const std::vector<T>& third) {
  first.insert(first.end(), second.begin(), second.end());
  first.insert(first.end(), third.begin(), third.end());
  return first;
}

void check(const char* role, const char* field, int size, const std::vector<std::string>& columns) {
  if (size == static_cast<int>(columns.size())) return;
  throw BadInput(fmt::format("The {} process reports {} values in account.{}, the case asks for {}: {}.", role, size, field, columns.size(),
                             columns.empty() ? "none" : fmt::format("{}", fmt::join(columns, ", "))));
}

}  // namespace

void check_accounts(const Case& scene, const wire::Account& fluid, const wire::Account& structure) {
  check("fluid", "energy", fluid.energy_size(), fluid_energy_columns());
  check("fluid", "gauge", fluid.gauge_size(), gauge_columns(scene, GaugeOwner::fluid));
  check("structure", "energy", structure.energy_size(), structure_energy_columns(scene));
  check("structure", "gauge", structure.gauge_size(), gauge_columns(scene, GaugeOwner::structure));
}

template <int D>
Accounts<D>::Accounts(const std::string& directory, const Case& scene, bool anew)
    : scene_(scene),
      structure_columns_(structure_energy_columns(scene)),
      work_column_(static_cast<std::size_t>(
          std::find(structure_columns_.begin(), structure_columns_.end(), "interface_work_on_structure_J") - structure_columns_.begin())),
      walls_move_(std::any_of(scene.walls.begin(), scene.walls.end(), [](const WallCase& wall) { return wall.motion.has_value(); })),
      recorder_(directory,
                joined(gauge_columns(scene, GaugeOwner::fluid), gauge_columns(scene, GaugeOwner::structure),
                       gauge_columns(scene, GaugeOwner::coupler)),
                joined(fluid_energy_columns(), structure_columns_, Totals::columns()), scene.output.gauge_interval, anew) {}

template <int D>
void Accounts<D>::save(StateWriter& file) {
  file("recorder", recorder_.mark());
  file("evaluated_gauges", evaluated_gauges_);
}

template <int D>
void Accounts<D>::restore(StateReader& file) {
  Recorder::Mark mark;
  file("recorder", mark);
  recorder_.go_back(mark);
  file("evaluated_gauges", evaluated_gauges_);
}

template <int D>
double Accounts<D>::work_on_structure(const wire::Account& structure) const {
  return structure.energy(static_cast<int>(work_column_));
}

template <int D>
void Accounts<D>::record(Ticks now, const wire::Account& fluid, const wire::Account& structure, const Coupler<D>& coupler) {
  const GaugeValues own = gauge_values(coupler, scene_);
  evaluated_gauges_ += static_cast<long>(own.size());
  recorder_.account(
      now, joined(proto::gauge_values(fluid), proto::gauge_values(structure), own),
      joined(proto::energies(fluid), proto::energies(structure), coupler.state().totals.energies(work_on_structure(structure))));
}

template <int D>
std::optional<Energies> Accounts<D>::energies(Ticks now, const wire::Account& fluid_account, const wire::Account& structure_account,
                                              bool fluid_has_weight) const {
  // The columns begin with kinetic and potential, kinetic and strain energy.
  const std::vector<double> fluid = proto::energies(fluid_account), structure = proto::energies(structure_account);
  const double work = work_on_structure(structure_account);
  const bool no_account = fluid[0] == 0 || work == 0 || (fluid_has_weight && fluid[1] == 0);
  if (walls_move_ || (now > 0 && no_account)) return std::nullopt;
  return Energies{fluid[0] + fluid[1] + work, fluid[0] + structure[0] + structure[1]};
}

template class Accounts<2>;
template class Accounts<3>;

}  // namespace tern::coupler
