#include "proto/wire/account.hpp"

namespace tern::proto {

wire::Account account(const std::vector<double>& energies, const GaugeValues& gauges) {
  wire::Account result;
  for (double energy : energies) result.add_energy(energy);
  for (const auto& gauge : gauges) {
    result.add_gauge(gauge.value_or(0));
    result.add_undefined(!gauge);
  }
  return result;
}

std::vector<double> energies(const wire::Account& account) { return {account.energy().begin(), account.energy().end()}; }

GaugeValues gauge_values(const wire::Account& account) {
  GaugeValues values;
  for (int k = 0; k < account.gauge_size(); ++k)
    values.push_back(account.undefined(k) ? std::nullopt : std::optional<double>(account.gauge(k)));
  return values;
}

}  // namespace tern::proto
