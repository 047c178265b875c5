// Gauges that the coupler evaluates (coupler/gauges/).

#include "scene/gauges/gauge.hpp"

namespace tern {

std::vector<GaugeDefinition> coupler_gauges() {
  return {
      {.kind = "interface_force",
       .owner = GaugeOwner::coupler,
       .meaning = "force of the fluid on an elastic body [N/m^(3-D)]",
       .keys = {{"body", ParameterType::text, true, "the elastic body"}},
       .columns = [](int dimension) { return component_columns("F", dimension == 2 ? "N_per_m" : "N", dimension); },
       .check = [](const GaugeCase& gauge, const Case& scene, const std::string& where) { body_of(gauge, scene, where); }},
  };
}

}  // namespace tern
