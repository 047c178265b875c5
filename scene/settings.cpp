// Walking, printing and overriding the tree of settings.

#include "scene/settings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

#include "base/error.hpp"

namespace tern {
namespace {

nlohmann::json json_of(const Setting& setting) {
  switch (setting.type) {
    case Setting::Type::boolean: return setting.boolean;
    case Setting::Type::integer:  // 2^63 and more has no place in 64 bits
      if (std::abs(setting.number) >= 9e18) return setting.number;
      return static_cast<std::int64_t>(setting.number);
    case Setting::Type::number: return setting.number;
    case Setting::Type::text: return setting.text;
    case Setting::Type::list: {
      auto list = nlohmann::json::array();
      for (const Setting& item : setting.items) list.push_back(json_of(item));
      return list;
    }
    case Setting::Type::table: break;
  }
  auto table = nlohmann::json::object();
  for (std::size_t i = 0; i < setting.keys.size(); ++i) table[setting.keys[i]] = json_of(setting.items[i]);
  return table;
}

// The element of a list of tables that `part` names; null if none.
Setting* element(Setting& list, const std::string& part) {
  std::size_t position = 0;
  const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), position);
  if (error == std::errc() && end == part.data() + part.size()) {
    return position < list.items.size() ? &list.items[position] : nullptr;
  }
  for (Setting& item : list.items) {
    const Setting* name = item.type == Setting::Type::table ? item.find("name") : nullptr;
    if (name && name->text == part) return &item;
  }
  return nullptr;
}

// ", or a name: bar, lid" of the elements of a list that have one.
std::string or_a_name_of(const Setting& list) {
  std::vector<std::string> names;
  for (const Setting& item : list.items)
    if (const Setting* name = item.type == Setting::Type::table ? item.find("name") : nullptr) names.push_back(name->text);
  return names.empty() ? "" : fmt::format(", or a name: {}", fmt::join(names, ", "));
}

}  // namespace

const Setting* Setting::find(const std::string& key) const {
  const auto found = std::find(keys.begin(), keys.end(), key);
  return found == keys.end() ? nullptr : &items[static_cast<std::size_t>(found - keys.begin())];
}

Setting* Setting::find(const std::string& key) { return const_cast<Setting*>(static_cast<const Setting*>(this)->find(key)); }

const Setting& Setting::at(const std::string& key) const { return *find(key); }

Setting& Setting::set(const std::string& key, Setting value) {
  if (Setting* present = find(key)) return *present = std::move(value);
  keys.push_back(key);
  items.push_back(std::move(value));
  return items.back();
}

std::string type_name(Setting::Type type) {
  switch (type) {
    case Setting::Type::boolean: return "true or false";
    case Setting::Type::integer: return "a whole number";
    case Setting::Type::number: return "a number";
    case Setting::Type::text: return "a text";
    case Setting::Type::list: return "a list";
    case Setting::Type::table: return "a table";
  }
  return "";
}

std::string to_json(const Setting& setting) { return json_of(setting).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace); }

std::string to_text(const Setting& setting) {
  std::string text;
  if (setting.type == Setting::Type::number && setting.number == std::round(setting.number) && std::abs(setting.number) < 1e6) {
    text = fmt::format("{:.1f}", setting.number);  // where a whole number is wanted it says why 2.0 is none
  } else if (setting.type == Setting::Type::number || setting.type == Setting::Type::integer) {
    text = fmt::format("{}", setting.number);
  } else {
    text = to_json(setting);
  }
  if (text.size() > 60) text = text.substr(0, 57) + "...";
  return text;
}

void apply_override(Setting& settings, const std::string& key, const std::string& value) {
  const std::string where = "--set " + key;
  Setting* place = &settings;
  std::size_t begin = 0;
  while (true) {
    const std::size_t dot = key.find('.', begin);
    const std::string part = key.substr(begin, dot - begin);
    if (part.empty()) throw BadInput(fmt::format("{}: the key has an empty part; write table.key=value.", where));
    if (place->type == Setting::Type::list) {
      if (Setting* named = element(*place, part)) {
        if (dot == std::string::npos) {
          *named = read_toml_value(value, where);
          return;
        }
        place = named;
        begin = dot + 1;
        continue;
      }
      // Of a list with one element the name may be left out: then the part is one of its keys, or the last one, which may be new.
      const bool is_key = place->items.size() == 1 && (dot == std::string::npos || place->items.front().find(part));
      if (!is_key) {
        throw BadInput(fmt::format("{}: none of the {} elements is called '{}'; use a position from 0 to {}{}.", where, place->items.size(),
                                   part, static_cast<long>(place->items.size()) - 1, or_a_name_of(*place)));
      }
      place = &place->items.front();
    }
    if (place->type != Setting::Type::table) {
      throw BadInput(fmt::format("{}: '{}' is not a table, so it has no key '{}'; see docs/PARAMETERS.md.", where,
                                 key.substr(0, begin ? begin - 1 : 0), part));
    }
    if (dot == std::string::npos) {
      place->set(part, read_toml_value(value, where));
      return;
    }
    Setting* next = place->find(part);
    if (!next) {
      Setting table;
      table.where = where;
      next = &place->set(part, std::move(table));
    }
    place = next;
    begin = dot + 1;
  }
}

}  // namespace tern
