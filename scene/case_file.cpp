// From a TOML file to a Case: read, override, complete, convert, check the scene.

#include "scene/case_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "base/error.hpp"
#include "base/hash.hpp"
#include "scene/key_sentences.hpp"
#include "scene/keys/tables.hpp"
#include "scene/mid_surface.hpp"
#include "scene/placement.hpp"
#include "scene/preset.hpp"
#include "scene/renamed.hpp"
#include "scene/scene_check.hpp"

namespace tern {
namespace {

namespace fs = std::filesystem;

// The file that a path, a folder or a name under cases/ stands for.
std::string find_case_file(const std::string& name_or_path) {
  for (const fs::path& candidate :
       {fs::path(name_or_path), fs::path(name_or_path) / "case.toml", fs::path("cases") / name_or_path / "case.toml"}) {
    std::error_code ignored;
    if (fs::is_regular_file(candidate, ignored)) return candidate.string();
  }
  throw BadInput(
      fmt::format("There is no case '{0}': neither the file {0}, nor {0}/case.toml, nor cases/{0}/case.toml exists; "
                  "give the path of a case.toml or of its folder.",
                  name_or_path));
}

// Particles across each body, of a shell along its shortest free length, at the spacings of the case.
std::vector<double> particles_across(const Setting& settings, const fs::path& folder) {
  const Case scene = read_scene(settings, folder);
  check_sizes(scene, settings);
  std::vector<double> across;
  for (const StructureBody& body : scene.structure->bodies) {
    const auto count = [&](const auto& surface) { across.push_back(*std::min_element(surface.count.begin(), surface.count.end())); };
    if (!body.is_shell)
      across.push_back((scene.dimension == 2 ? thin_section<2>(body) : thin_section<3>(body)) / body.spacing);
    else if (scene.dimension == 2)
      count(mid_surface<2>(body));
    else
      count(mid_surface<3>(body));
  }
  return across;
}

// Text of all tables from which walls and clamps take their motion.
std::string motion_tables(const Case& scene) {
  std::string text;
  for (const WallCase& wall : scene.walls)
    if (wall.motion && wall.motion->table) text += wall.motion->table->text();
  if (scene.structure) {
    for (const ClampCase& clamp : scene.structure->clamps)
      if (clamp.motion && clamp.motion->table) text += clamp.motion->table->text();
  }
  return text;
}

// The settings but for what a run that goes on may change.
Setting without_what_may_change(Setting settings) {
  settings.set("end_time", {});
  settings.set("output", {});
  settings.set("gauge", {});
  return settings;
}

}  // namespace

// The case of a document whose preset, if it is draft, takes `coarser` times the spacings.
static Case make_case(const std::string& file, Setting document, const CaseOptions& options, double coarser) {
  const fs::path folder = fs::path(file).parent_path();
  const std::vector<std::string> old_names = use_present_names(document);
  std::vector<std::string> notes;
  const auto with_overrides = [&] {
    Setting whole = document;
    notes = old_names;
    for (const auto& [key, value] : options.overrides) {
      apply_override(whole, key, value);
      for (std::string& note : use_present_names(whole)) notes.push_back(std::move(note));
    }
    return complete_settings(whole);
  };
  const std::vector<std::string> changes = apply_preset(document, coarser, [&] { return particles_across(with_overrides(), folder); });
  const Setting settings = with_overrides();
  Case scene = read_scene(settings, folder);
  scene.preset_changes = changes;
  scene.warnings = notes;
  const fs::path absolute = fs::absolute(file).lexically_normal();
  scene.path = absolute.string();
  scene.name = absolute.filename() == "case.toml" ? absolute.parent_path().filename().string() : absolute.stem().string();
  scene.settings = to_json(settings);
  const std::string tables = motion_tables(scene);
  scene.hash = hash_of(scene.settings + tables);
  scene.hash_of_rest = hash_of(to_json(without_what_may_change(settings)) + tables);
  if (const Setting* gauges = settings.find("gauge"))
    for (const Setting& gauge : gauges->items) scene.gauge_hashes[gauge.at("name").text] = hash_of(to_json(gauge));
  check_scene(scene, settings);
  return scene;
}

static Case read_and_check(const std::string& name_or_path, const CaseOptions& options) {
  const std::string file = find_case_file(name_or_path);
  Setting document = read_toml_file(file);
  document.where = file;
  if (!options.preset.empty()) {
    Setting preset;
    preset.type = Setting::Type::text;
    preset.text = options.preset;
    preset.where = "--preset " + options.preset;
    document.set("preset", std::move(preset));
  }
  // --set preset=... chooses the group as well; every other --set goes on top of it, in whichever order they are given.
  for (const auto& [key, value] : options.overrides)
    if (key == "preset") apply_override(document, key, value);
  // A draft is as coarse as the case bears: a shell may need more particles, or a lattice of twice the spacing miss a shape.
  if (is_draft(document)) {
    for (const double coarser : {2.0, 1.75, 1.5, 1.25}) {
      try {
        return make_case(file, document, options, coarser);
      } catch (const BadInput&) {  // what is wrong with any spacing is said below
      }
    }
  }
  return make_case(file, document, options, 1);
}

// A sentence quotes names and texts of the case, whatever they hold.
Case read_case(const std::string& name_or_path, const CaseOptions& options) {
  try {
    return read_and_check(name_or_path, options);
  } catch (const BadInput& fault) {
    throw BadInput(one_line(fault.what()));
  } catch (const NumericalFailure& fault) {  // of an expression that a check has come upon
    throw BadInput(one_line(name_or_path + ": " + fault.what()));
  }
}

}  // namespace tern
