// TOML text to settings. The only file that includes toml++, which costs seconds per include.

#include <fmt/format.h>
#include <toml++/toml.h>

#include <fstream>
#include <sstream>

#include "particles/error.hpp"
#include "particles/settings.hpp"

namespace tern {
namespace {

std::string place(const std::string& file, const toml::source_region& source) {
  return fmt::format("{}:{}:{}", file, source.begin.line, source.begin.column);
}

Setting convert(const toml::node& node, const std::string& file, bool with_line) {
  Setting setting;
  setting.where = with_line ? place(file, node.source()) : file;
  if (const auto* table = node.as_table()) {
    setting.type = Setting::Type::table;
    for (const auto& [key, value] : *table) {
      Setting item = convert(value, file, with_line);
      if (with_line) item.where = place(file, key.source());
      setting.keys.emplace_back(key.str());
      setting.items.push_back(std::move(item));
    }
  } else if (const auto* list = node.as_array()) {
    setting.type = Setting::Type::list;
    for (const toml::node& item : *list) setting.items.push_back(convert(item, file, with_line));
  } else if (const auto* text = node.as_string()) {
    setting.type = Setting::Type::text;
    setting.text = text->get();
  } else if (const auto* integer = node.as_integer()) {
    setting.type = Setting::Type::integer;
    setting.number = static_cast<double>(integer->get());
  } else if (const auto* number = node.as_floating_point()) {
    setting.type = Setting::Type::number;
    setting.number = number->get();
  } else if (const auto* boolean = node.as_boolean()) {
    setting.type = Setting::Type::boolean;
    setting.boolean = boolean->get();
  } else {
    throw BadInput(
        fmt::format("{}: dates and times have no use in a case file; give a number or a text.", setting.where));
  }
  return setting;
}

}  // namespace

Setting read_toml_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream text;
  if (!file || !(text << file.rdbuf())) {
    throw InputOutputError(
        fmt::format("The case file {} cannot be read or is empty; check its name and permissions.", path));
  }
  try {
    return convert(toml::parse(text.str(), path), path, true);
  } catch (const toml::parse_error& fault) {
    throw BadInput(fmt::format("{}: this is not valid TOML: {}; correct the line.", place(path, fault.source()),
                               fault.description()));
  }
}

Setting read_toml_value(const std::string& text, const std::string& where) {
  try {
    const toml::table parsed = toml::parse("value = " + text);
    if (parsed.size() == 1) return convert(*parsed.get("value"), where, false);
  } catch (const toml::parse_error&) {
    // A bare word such as CM0 or an expression such as 2*t needs no quotes on the command line.
  }
  Setting setting;
  setting.type = Setting::Type::text;
  setting.text = text;
  setting.where = where;
  return setting;
}

}  // namespace tern
