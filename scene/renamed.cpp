#include "scene/renamed.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>

#include "base/error.hpp"

namespace tern {
namespace {

// Calls visit(table, key) for every table in which the last part of `path` can stand; lists of tables are passed element by element.
void for_each_place(Setting& place, const std::string& path, const std::function<void(Setting&, const std::string&)>& visit) {
  if (place.type == Setting::Type::list) {
    for (Setting& item : place.items) for_each_place(item, path, visit);
    return;
  }
  if (place.type != Setting::Type::table) return;
  const std::size_t dot = path.find('.');
  if (dot == std::string::npos) {
    visit(place, path);
  } else if (Setting* table = place.find(path.substr(0, dot))) {
    for_each_place(*table, path.substr(dot + 1), visit);
  }
}

void remove(Setting& table, const std::string& key) {
  const auto index = std::find(table.keys.begin(), table.keys.end(), key) - table.keys.begin();
  table.keys.erase(table.keys.begin() + index);
  table.items.erase(table.items.begin() + index);
}

}  // namespace

// One name per line.
// clang-format off
const Renames& renames() {
  static const Renames list{
      {},
      {{"coupling.algorithm", "CM0", "explicit"},
       {"coupling.algorithm", "CM2", "auto", "max_iterations", "1"},
       {"coupling.algorithm", "semi-implicit", "auto", "max_iterations", "1"},
       {"coupling.algorithm", "CM3", "auto", "tolerance", "1e-4"},
       {"coupling.algorithm", "implicit", "auto", "tolerance", "1e-4"}},
      {{"coupling.acceleration", "iterations take the quasi-Newton method, which has needed the fewest everywhere"}},
  };
  return list;
}
// clang-format on

std::vector<std::string> use_present_names(Setting& document, const Renames& list) {
  std::vector<std::string> notes;
  for (const RenamedKey& entry : list.keys) {
    for_each_place(document, entry.old_path, [&](Setting& table, const std::string& key) {
      const Setting* old = table.find(key);
      if (!old) return;
      const Setting value = *old;
      if (table.find(entry.new_key) && !value.where.starts_with("--set")) {
        throw BadInput(
            fmt::format("{}: '{}' is the old name of '{}', which is given as well; remove it.", value.where, key, entry.new_key));
      }
      notes.push_back(fmt::format("{}: '{}' is called '{}' now; write the new name.", value.where, key, entry.new_key));
      remove(table, key);
      table.set(entry.new_key, value);
    });
  }
  for (const RenamedValue& entry : list.values) {
    for_each_place(document, entry.path, [&](Setting& table, const std::string& key) {
      Setting* value = table.find(key);
      if (!value || value->type != Setting::Type::text || value->text != entry.old_value) return;
      const bool says_more = !entry.other_key.empty() && !table.find(entry.other_key);
      notes.push_back(fmt::format("{}: {} \"{}\" is called \"{}\"{} now; write the new name.", value->where, key, entry.old_value,
                                  entry.new_value, says_more ? fmt::format(" with {} = {}", entry.other_key, entry.other_value) : ""));
      value->text = entry.new_value;
      if (says_more) table.set(entry.other_key, read_toml_value(entry.other_value, value->where));
    });
  }
  for (const RemovedKey& entry : list.removed) {
    for_each_place(document, entry.path, [&](Setting& table, const std::string& key) {
      const Setting* old = table.find(key);
      if (!old) return;
      notes.push_back(fmt::format("{}: '{}' is no key any more; {}.", old->where, key, entry.instead));
      remove(table, key);
    });
  }
  return notes;
}

}  // namespace tern
