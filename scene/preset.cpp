// Presets. The spacing buys most error for its cost, so it belongs to them; what else is in a group earned its place in the measured trade
// (docs/TRADE.md): draft takes what saves time for little error, reference what removes error, which is half the spacing alone.

#include "scene/preset.hpp"

#include <fmt/format.h>

#include <utility>

namespace tern {
namespace {

using Options = std::vector<std::pair<std::string, std::string>>;

// A body keeps at least this many particles across: a draft has the shape of its case.
constexpr double least_across = 4;

// Of a draft, for a fluid or a structure that is alone. Longer windows of slow fluid save time for an error far below that of twice the
// spacing. A structure alone takes implicit steps where they are cheaper, as one beside a fluid does by itself. Beside a structure the
// windows stay short while the fluid is slow: they resolve its vibration. Not a looser pressure: it saves less than a tenth. A reference
// has no options: shorter steps, a tighter pressure, and windows repeated until the load does not change any more remove no error that
// half the spacing leaves.
const Options draft_of_fluid{{"fluid.numerics.gravity_courant", "0.2"}};
const Options draft_of_structure{{"structure.numerics.integrator", "\"auto\""}};
const Options paper{{"coupling.algorithm", "\"explicit\""},
                    {"coupling.scheme", "\"riemann\""},
                    {"coupling.vem.coefficient", "5.0"},
                    {"coupling.vem.form", "\"seed\""}};

bool is_number(const Setting* value) { return value && (value->type == Setting::Type::number || value->type == Setting::Type::integer); }

// Whether the document itself says something about this key.
bool has(const Setting& document, const std::string& key) {
  const Setting* place = &document;
  for (std::size_t begin = 0; place && place->type == Setting::Type::table;) {
    const std::size_t dot = key.find('.', begin);
    place = place->find(key.substr(begin, dot - begin));
    if (dot == std::string::npos) return place;
    begin = dot + 1;
  }
  return false;
}

class Preset {
 public:
  explicit Preset(Setting& document) : document_(document) {}

  void replace(const Options& options) {
    for (const auto& [key, value] : options) {
      apply_override(document_, key, value);
      changes.push_back(key + " = " + value);
    }
  }

  void fill(const Options& options) {
    for (const auto& option : options)
      if (!has(document_, option.first)) replace({option});
  }

  // What is not a number is left for the validation to refuse.
  void scale_spacing(Setting& table, const std::string& label, double factor) {
    Setting* spacing = table.find("spacing");
    if (!is_number(spacing) || factor == 1) return;
    const double before = spacing->number;
    spacing->type = Setting::Type::number;
    spacing->number = before * factor;
    changes.push_back(fmt::format("{}.spacing = {} ({} in the case)", label, spacing->number, before));
  }

  std::vector<std::string> changes;

 private:
  Setting& document_;
};

}  // namespace

bool is_draft(const Setting& document) {
  const Setting* name = document.find("preset");
  return name && name->type == Setting::Type::text && name->text == "draft";
}

std::vector<std::string> apply_preset(Setting& document, double coarser, const std::function<std::vector<double>()>& particles_across) {
  const Setting* found = document.find("preset");
  if (!found || found->type != Setting::Type::text) return {};
  const std::string name = found->text;  // what is added to the document may move what it has
  Preset preset(document);
  if (name == "paper" && document.find("fluid") && document.find("structure")) preset.replace(paper);
  if (name != "draft" && name != "reference") return preset.changes;
  Setting *fluid = document.find("fluid"), *structure = document.find("structure");
  const bool draft = name == "draft";
  const double factor = draft ? coarser : 0.5;
  Setting* bodies = structure ? structure->find("body") : nullptr;
  const std::vector<double> across = bodies ? particles_across() : std::vector<double>{};
  if (fluid) {
    preset.scale_spacing(*fluid, "fluid", factor);
    if (draft && !structure) preset.fill(draft_of_fluid);
  }
  if (structure) {
    for (std::size_t i = 0; i < across.size() && i < bodies->items.size(); ++i) {  // others come from --set
      if (across[i] / factor < least_across - 1e-6 && factor > 1) continue;
      Setting& body = bodies->items[i];
      const Setting* label = body.find("name");
      preset.scale_spacing(body, "structure.body." + (label ? label->text : fmt::format("{}", i)), factor);
    }
    if (draft) preset.fill(draft_of_structure);
  }
  return preset.changes;
}

}  // namespace tern
