// [[gauge]]: its keys are those of the kinds of gauges (scene/gauges/).

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "base/error.hpp"
#include "scene/gauges/gauge.hpp"
#include "scene/keys/row.hpp"
#include "scene/keys/tables.hpp"

namespace tern {
namespace {

using Presence = TableDefinition::Presence;

const Rows<GaugeCase>& gauge_rows() {
  static const Rows<GaugeCase> rows = [] {
    std::vector<std::string> kinds, meanings;
    for (const GaugeDefinition& definition : gauge_definitions()) {
      kinds.push_back(definition.kind);
      meanings.push_back(definition.kind + ": " + definition.meaning);
    }
    return Rows<GaugeCase>{{"kind", one_of(&GaugeCase::kind, kinds), "", required, any, fmt::format("{}.", fmt::join(meanings, "; "))},
                           {"name", &GaugeCase::name, "", required, any, "Name of the column; unique."}};
  }();
  return rows;
}

// One parameter for each key of any kind; its meaning says what it is for each of them, kinds with the same meaning together.
std::vector<Parameter> keys_of_kinds() {
  std::vector<Parameter> all;
  std::vector<std::vector<std::pair<std::string, std::vector<std::string>>>> meanings;  // of each key: what it is, and for which kinds
  for (const GaugeDefinition& definition : gauge_definitions()) {
    for (const GaugeKey& key : definition.keys) {
      auto known = std::find_if(all.begin(), all.end(), [&](const Parameter& p) { return p.key == key.key; });
      if (known == all.end()) {
        const std::string unit = key.type == ParameterType::point ? "m" : key.unit;
        const Range range = key.type == ParameterType::point ? a_place : key.range;
        known = all.insert(all.end(), {"gauge", key.key, key.type, unit, absent, range, {}, ""});
        meanings.emplace_back();
      }
      auto& of_key = meanings[static_cast<std::size_t>(known - all.begin())];
      const std::string meaning = key.meaning + (key.needed ? " (needed)" : "");
      auto same = std::find_if(of_key.begin(), of_key.end(), [&](const auto& entry) { return entry.first == meaning; });
      if (same == of_key.end()) same = of_key.insert(of_key.end(), {meaning, {}});
      same->second.push_back(definition.kind);
    }
  }
  for (std::size_t k = 0; k < all.size(); ++k) {
    std::vector<std::string> sentences;
    for (const auto& [meaning, kinds] : meanings[k]) sentences.push_back(fmt::format("{}: {}.", fmt::join(kinds, ", "), meaning));
    all[k].meaning = fmt::format("{}", fmt::join(sentences, " "));
  }
  return all;
}

void fill_keys_of_kind(GaugeCase& gauge, const Setting& table) {
  const GaugeDefinition& definition = gauge_definition(gauge.kind);
  for (std::size_t k = 0; k < table.keys.size(); ++k) {
    const std::string& key = table.keys[k];
    const Setting& value = table.items[k];
    if (key == "kind" || key == "name") continue;
    if (std::none_of(definition.keys.begin(), definition.keys.end(), [&](const GaugeKey& known) { return known.key == key; })) {
      throw BadInput(
          fmt::format("{}: the gauge '{}' of kind {} has no use for the key '{}'; remove it.", value.where, gauge.name, gauge.kind, key));
    }
    if (value.type == Setting::Type::text) gauge.texts[key] = value.text;
    if (value.type == Setting::Type::number) gauge.numbers[key] = value.number;
    if (value.type == Setting::Type::list) read_value(gauge.points[key], value);
  }
  for (const GaugeKey& key : definition.keys) {
    if (key.needed && !table.find(key.key)) {
      throw BadInput(
          fmt::format("{}: the gauge '{}' of kind {} needs the key '{}'; give it.", table.where, gauge.name, gauge.kind, key.key));
    }
  }
}

}  // namespace

std::vector<TableDefinition> gauge_tables() {
  std::vector<Parameter> keys = parameters_of(gauge_rows());
  for (const Parameter& key : keys_of_kinds()) keys.push_back(key);
  return {
      {"gauge", true, Presence::optional,
       "A quantity written to gauges.csv. Its pressures and forces are those in the middle of the window that ends at the time of the row.",
       keys}};
}

GaugeCase read_gauge(const Setting& table, const Case& scene) {
  GaugeCase gauge = filled(gauge_rows(), table);
  fill_keys_of_kind(gauge, table);
  if (const auto& complete = gauge_definition(gauge.kind).complete) complete(gauge, scene);
  return gauge;
}

std::string GaugeCase::text(const std::string& key) const {
  const auto found = texts.find(key);
  return found == texts.end() ? "" : found->second;
}

double GaugeCase::number(const std::string& key) const {
  const auto found = numbers.find(key);
  return found == numbers.end() ? 0 : found->second;
}

std::array<double, 3> GaugeCase::point(const std::string& key) const {
  const auto found = points.find(key);
  return found == points.end() ? std::array<double, 3>{} : found->second;
}

}  // namespace tern
