// What a step costs on this machine, as ./tern measures it once per build (python/tern/launch/calibration.py).

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "scene/estimate.hpp"

namespace tern {

Costs read_costs(const std::string& path) {
  std::ifstream file(path);
  if (!file) throw InputOutputError(path + ": the costs of a step cannot be read; leave --costs out to use typical ones.");
  Costs costs;
  try {
    const nlohmann::json json = nlohmann::json::parse(file);
    const auto number = [&](const nlohmann::json& value) {
      const double cost = value.get<double>();
      if (!(cost >= 0) || !std::isfinite(cost)) throw BadInput(path + " holds a cost that is not a finite number of 0 or more.");
      return cost;
    };
    costs.fluid = number(json.at("fluid_s"));
    costs.structure = number(json.at("structure_s"));
    costs.window = number(json.at("window_s"));
    for (const auto& [part, share] : json.at("fluid_parts").items()) costs.fluid_parts.emplace_back(part, number(share));
    costs.measured = json.at("measured").get<std::string>();
  } catch (const nlohmann::json::exception& error) {
    throw BadInput(path + " is not a file of costs: " + error.what() + "; remove it, and it is measured anew.");
  }
  return costs;
}

}  // namespace tern
