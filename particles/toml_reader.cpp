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

/// Throws BadInput for bytes that TOML has no place for, with line and column: the parser relies on not meeting them in a key.
void check_characters(const std::string& text, const std::string& path) {
  int line = 1, column = 1, following = 0;  // bytes of a UTF-8 character that are still to come
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    const bool continues = (byte & 0xc0) == 0x80;
    const bool control = (byte < 0x20 && c != '\t' && c != '\n' && c != '\r') || byte == 0x7f;
    if (control || continues != (following > 0) || byte == 0xc0 || byte == 0xc1 || byte > 0xf4)
      throw BadInput(fmt::format("{}:{}:{}: the byte 0x{:02x} has no place in a text of UTF-8; is this a case file? Remove it.", path,
                                 line, column, byte));
    following = continues ? following - 1 : byte >= 0xf0 ? 3 : byte >= 0xe0 ? 2 : byte >= 0xc0 ? 1 : 0;
    if (c == '\n') ++line, column = 1;
    else if (!continues) ++column;
  }
  if (following > 0) throw BadInput(fmt::format("{}:{}:{}: the file ends within a character of UTF-8; was it cut?", path, line, column));
}

}  // namespace

Setting read_toml_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream text;
  if (!file || !(text << file.rdbuf())) {
    throw InputOutputError(
        fmt::format("The case file {} cannot be read or is empty; check its name and permissions.", path));
  }
  check_characters(text.str(), path);
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
