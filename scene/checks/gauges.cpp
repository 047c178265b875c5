// Gauges.

#include "scene/checks/checks.hpp"

#include <fmt/format.h>

#include "scene/gauges/gauge.hpp"

namespace tern {

void check_gauges(const Case& scene, const Setting& settings) {
  for (std::size_t i = 0; i < scene.gauges.size(); ++i) {
    const GaugeCase& gauge = scene.gauges[i];
    const GaugeDefinition& definition = gauge_definition(gauge.kind);
    const std::string& where = settings.at("gauge").items[i].where;
    if (definition.owner != GaugeOwner::structure && !scene.fluid)
      fail_at(where, fmt::format("the gauge '{}' measures the fluid, but the case has no [fluid]; remove it.", gauge.name));
    if (definition.check) definition.check(gauge, scene, where);
  }
}

}  // namespace tern
