// tern-case: reads a case and says what is in it, without running anything.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "base/threads.hpp"
#include "base/version.hpp"
#include "scene/estimate.hpp"
#include "scene/gauges.hpp"
#include "scene/parameter_table.hpp"
#include "scene/scene_at_start.hpp"

namespace {

using namespace tern;

// Where pictures of a run show its gauges.
nlohmann::json gauge_places(const Case& scene) {
  nlohmann::json places = nlohmann::json::array();
  for (const GaugeCase& gauge : scene.gauges) {
    nlohmann::json shown = {{"name", gauge.name}};
    switch (gauge_definition(gauge.kind).place) {
      case GaugePlace::nowhere: continue;
      case GaugePlace::point: shown["at"] = gauge.point("at"); break;
      case GaugePlace::disc: shown["at"] = gauge.point("at"), shown["diameter"] = gauge.number("diameter"); break;
      case GaugePlace::line: shown["from"] = gauge.point("from"), shown["to"] = gauge.point("to"); break;
    }
    places.push_back(std::move(shown));
  }
  return places;
}

std::string json_text(const Case& scene, const Costs& costs) {
  // What a participant has to report, in this order (docs/PROTOCOL.md, Account).
  nlohmann::json account = nlohmann::json::object();
  if (scene.fluid) account["fluid"] = {{"energy", fluid_energy_columns()}, {"gauge", gauge_columns(scene, GaugeOwner::fluid)}};
  if (scene.structure)
    account["structure"] = {{"energy", structure_energy_columns(scene)}, {"gauge", gauge_columns(scene, GaugeOwner::structure)}};
  const Estimate expected = estimate(scene, costs);
  const nlohmann::json json = {{"account", account},
                               {"name", scene.name},
                               {"path", scene.path},
                               {"hash", scene.hash},
                               {"dimension", scene.dimension},
                               {"end_time", scene.end_time},
                               {"title", scene.title},
                               {"has_fluid", scene.fluid.has_value()},
                               {"has_structure", scene.structure.has_value()},
                               {"settings", nlohmann::json::parse(scene.settings)},
                               {"hash_of_rest", scene.hash_of_rest},
                               {"gauge_places", gauge_places(scene)},
                               {"preset_changes", scene.preset_changes},
                               {"expected_cpu_s", expected.fluid_cpu + expected.structure_cpu},
                               {"expected",
                                {{"dimension", scene.dimension},
                                 {"fluid_particles", expected.fluid_particles},
                                 {"steps", expected.steps},
                                 {"fluid_cpu_s", expected.fluid_cpu},
                                 {"structure_cpu_s", expected.structure_cpu},
                                 {"coupler_cpu_s", expected.coupler_cpu}}},
                               {"warnings", scene.warnings}};
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

int run(int argc, char** argv) {
  std::string case_path;
  std::vector<std::string> overrides;
  std::string costs_path;
  std::size_t most_points = 0;
  CaseOptions options;
  CLI::App app("Reads a case of tern and says what is in it.", "tern-case");
  app.set_version_flag("--version", fmt::format("tern-case {} ({})", program_version, git_hash));
  app.require_subcommand(1);
  const auto add = [&](const char* name, const char* meaning) {
    CLI::App* command = app.add_subcommand(name, meaning);
    command->add_option("CASE", case_path, "case.toml, its folder, or the name of a folder under cases/")->required()->type_name("");
    command->add_option("--set", overrides, "replace a value of the case, e.g. --set fluid.spacing=0.002")->type_name("KEY=VALUE");
    command->add_option("--preset", options.preset, "group of numerical options: draft, standard, reference or paper")->type_name("PRESET");
    return command;
  };
  CLI::App* check = add("check", "validate; print particles, step limits, memory and expected time");
  CLI::App* explain = add("explain", "say in plain words what is modelled, what is not, and what it costs");
  CLI::App* json = add("json", "print the effective settings as JSON");
  CLI::App* start = add("scene", "print where everything is before the first step as JSON, for pictures");
  start->add_option("--most", most_points, "leave the particles out of a scene with more than N")->required()->type_name("N");
  for (CLI::App* command : {check, explain, json})
    command->add_option("--costs", costs_path, "what a step costs on this machine, measured by ./tern")->type_name("FILE");
  const CLI::App* reference = app.add_subcommand("parameters", "print the reference of all keys (docs/PARAMETERS.md)");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& fault) {
    if (fault.get_exit_code() == 0) return app.exit(fault);
    throw BadInput(fmt::format("{}; see tern-case --help.", fault.what()));
  }
  if (*reference) {
    std::fputs(parameter_reference().c_str(), stdout);
    return 0;
  }
  for (const std::string& text : overrides) {
    const auto equals = text.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw BadInput(fmt::format("--set {} is not of the form table.key=value; write for example --set fluid.spacing=0.002.", text));
    }
    options.overrides.emplace_back(text.substr(0, equals), text.substr(equals + 1));
  }
  const Case scene = read_case(case_path, options);
  const Costs costs = costs_path.empty() ? Costs{} : read_costs(costs_path);
  const std::string answer = *check     ? check_text(scene, costs, cores_at_hand())
                             : *explain ? explain_text(scene, costs)
                             : *json    ? json_text(scene, costs)
                                        : scene_at_start(scene, most_points);
  std::fputs(answer.c_str(), stdout);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const tern::Error& error) {
    fmt::print(stderr, "tern-case: {}\n", error.what());
    return static_cast<int>(error.code());
  } catch (const std::exception& error) {
    fmt::print(stderr, "tern-case: {}\n", error.what());
    return static_cast<int>(tern::ExitCode::numerical_failure);
  }
}
