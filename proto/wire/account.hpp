#pragma once
// Energy and gauge values of one participant at one instant <-> wire.

#include <vector>

#include "proto/wire/tern.pb.h"
#include "scene/gauges.hpp"

namespace tern::proto {

wire::Account account(const std::vector<double>& energies, const GaugeValues& gauges);
std::vector<double> energies(const wire::Account& account);
GaugeValues gauge_values(const wire::Account& account);

}  // namespace tern::proto
