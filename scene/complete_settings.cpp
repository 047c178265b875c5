// Validation of the settings against the table of parameters, defaults filled in on the way.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/error.hpp"
#include "scene/expression.hpp"
#include "scene/parameter_table.hpp"

namespace tern {
namespace {

using Type = Setting::Type;
using Presence = TableDefinition::Presence;

[[noreturn]] void fail(const std::string& where, const std::string& sentence) { throw BadInput(fmt::format("{}: {}", where, sentence)); }

// Number of insertions, deletions and replacements that turn a into b.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row.back();
}

std::string nearest(const std::string& text, const std::vector<std::string>& valid) {
  return *std::min_element(valid.begin(), valid.end(),
                           [&](const auto& a, const auto& b) { return edit_distance(text, a) < edit_distance(text, b); });
}

std::string table_label(const std::string& path) { return path.empty() ? "the top of the file" : "[" + path + "]"; }

std::string unit_label(const Parameter& p) { return p.unit.empty() || p.unit == "-" ? "" : " [" + p.unit + "]"; }

// "density [kg/m^3] of [fluid]"
std::string label(const Parameter& p) {
  return p.table.empty() ? p.key + unit_label(p) : fmt::format("{}{} of {}", p.key, unit_label(p), table_label(p.table));
}

// "density [kg/m^3] of [fluid] is missing (density of the fluid); give a value greater than 0."
std::string missing(const Parameter& p) {
  const std::string range = p.choices.empty() ? describe(p.range) : fmt::format("of {}", fmt::join(p.choices, ", "));
  const std::string meaning = p.meaning.substr(0, p.meaning.size() - 1);
  return fmt::format("{} is missing ({}); give a value{}{}.", label(p), meaning, range.empty() ? "" : " ", range);
}

class Completion {
 public:
  explicit Completion(const Setting& document) : document_(document) {
    const Setting* dimension = document.find("dimension");
    const Parameter& definition = parameters()[1];
    if (!dimension) fail(document.where, missing(definition));
    check_number(definition, *dimension);
    dimension_ = static_cast<std::size_t>(dimension->number);
  }

  Setting run() {
    const bool fluid = document_.find("fluid"), structure = document_.find("structure");
    if (!fluid && !structure) fail(document_.where, "the case has neither [fluid] nor [structure]; give at least one.");
    coupled_ = fluid && structure;
    if (const Setting* coupling = document_.find("coupling"); coupling && !coupled_) {
      fail(coupling->where, fmt::format("[coupling] has no meaning in a case without [{}]; remove it.", fluid ? "structure" : "fluid"));
    }
    return complete_table("", document_);
  }

 private:
  Setting complete_table(const std::string& path, const Setting& given) {
    if (given.type != Type::table) fail(given.where, fmt::format("{} is {}, but has to be a table.", table_label(path), to_text(given)));
    refuse_unknown_keys(path, given);
    Setting complete;
    complete.where = given.where;
    for (const Parameter& p : parameters()) {
      if (p.table != path) continue;
      if (const Setting* value = given.find(p.key)) {
        complete.set(p.key, checked(p, *value));
      } else if (p.default_value == "required") {
        fail(given.where, missing(p));
      } else if (p.default_value != "absent") {
        complete.set(p.key, checked(p, read_toml_value(p.default_value, "default")));
      }
    }
    if (path.starts_with("shape")) return complete;
    for (const TableDefinition& table : table_definitions()) {
      if (parent(table.path) != path || table.path.empty() || table.path == "shape") continue;
      add_table(table, given, complete);
    }
    return complete;
  }

  void add_table(const TableDefinition& table, const Setting& given, Setting& complete) {
    const std::string key = table.path.substr(table.path.rfind('.') + 1);
    if (table.path == "coupling" && !coupled_) return;
    const Setting* value = given.find(key);
    if (!value) {
      if (table.presence == Presence::required) {
        fail(given.where, fmt::format("{} has no [[{}]]; {}", table_label(parent(table.path)), table.path, table.meaning));
      }
      if (table.presence == Presence::filled) {
        Setting empty;
        empty.where = given.where;
        complete.set(key, complete_table(table.path, empty));
      }
      return;
    }
    if (!table.repeated) {
      complete.set(key, complete_table(table.path, *value));
      return;
    }
    if (value->type != Type::list || value->items.empty()) {
      fail(value->where, fmt::format("{} has to be a list of tables; write [[{}]] above its keys.", key, table.path));
    }
    Setting list;
    list.type = Type::list;
    list.where = value->where;
    for (const Setting& item : value->items) list.items.push_back(complete_table(table.path, item));
    complete.set(key, std::move(list));
  }

  static std::string parent(const std::string& path) {
    const auto dot = path.rfind('.');
    return dot == std::string::npos ? "" : path.substr(0, dot);
  }

  void refuse_unknown_keys(const std::string& path, const Setting& given) const {
    std::vector<std::string> valid;
    for (const Parameter& p : parameters()) {
      if (p.table == path) valid.push_back(p.key);
    }
    for (const TableDefinition& t : table_definitions()) {
      if (parent(t.path) == path && !t.path.empty() && t.path.find("shape") == std::string::npos) {
        valid.push_back(t.path.substr(t.path.rfind('.') + 1));
      }
    }
    for (std::size_t i = 0; i < given.keys.size(); ++i) {
      const std::string& key = given.keys[i];
      if (std::find(valid.begin(), valid.end(), key) != valid.end()) continue;
      const std::string close = nearest(key, valid);
      std::string remedy = fmt::format("the keys here are {}.", fmt::join(valid, ", "));
      if (edit_distance(key, close) <= std::max<std::size_t>(2, key.size() / 3)) {
        remedy = fmt::format("did you mean '{}'?", close);
      } else {
        for (const Parameter& p : parameters()) {
          if (p.key == key && !p.table.starts_with("shape")) remedy = fmt::format("it belongs in {}.", table_label(p.table));
        }
      }
      fail(given.items[i].where, fmt::format("unknown key '{}' in {}; {}", key, table_label(path), remedy));
    }
  }

  [[noreturn]] static void wrong_type(const Parameter& p, const Setting& value, const std::string& wanted) {
    fail(value.where, fmt::format("{} is {}, but has to be {}.", label(p), to_text(value), wanted));
  }

  static void check_number(const Parameter& p, const Setting& value) {
    const bool whole = value.type == Type::integer;
    if (p.type == ParameterType::integer && !whole) wrong_type(p, value, "a whole number " + describe(p.range));
    if (!whole && value.type != Type::number) wrong_type(p, value, "a number " + describe(p.range));
    const double x = value.number;
    const bool low = p.range.lowest_excluded ? x <= p.range.lowest : x < p.range.lowest;
    const bool high = p.range.highest_excluded ? x >= p.range.highest : x > p.range.highest;
    if (!std::isfinite(x) || low || high) {
      const std::string range = describe(p.range);
      fail(value.where, fmt::format("{} is {}, but has to be {}.", label(p), to_text(value), range.empty() ? "finite" : range));
    }
  }

  static void check_choice(const Parameter& p, const Setting& value) {
    if (value.type != Type::text) wrong_type(p, value, fmt::format("one of \"{}\"", fmt::join(p.choices, "\", \"")));
    if (std::find(p.choices.begin(), p.choices.end(), value.text) != p.choices.end()) return;
    if (p.choices.size() == 1) {
      fail(value.where, fmt::format("{} is \"{}\", but there is only \"{}\".", label(p), value.text, p.choices.front()));
    }
    fail(value.where, fmt::format("{} is \"{}\", but has to be one of \"{}\"; the nearest is \"{}\".", label(p), value.text,
                                  fmt::join(p.choices, "\", \""), nearest(value.text, p.choices)));
  }

  void check_entries(const Parameter& p, const Setting& value, std::size_t count, bool expressions) const {
    const std::string wanted = fmt::format("a list of {} {}", count, expressions ? "numbers or expressions in quotes" : "numbers");
    if (value.type != Type::list || value.items.size() != count) wrong_type(p, value, wanted);
    for (const Setting& item : value.items) {
      const bool number = item.type == Type::number || item.type == Type::integer;
      if (!number && !(expressions && item.type == Type::text)) wrong_type(p, value, wanted);
      check_expression(p, item);
    }
  }

  void check_expression(const Parameter& p, const Setting& value) const {
    if (value.type == Type::number || value.type == Type::integer) {
      if (!std::isfinite(value.number)) wrong_type(p, value, "finite");
      return;
    }
    if (value.type != Type::text) wrong_type(p, value, "a number or an expression in quotes");
    try {
      Expression{value.text};
    } catch (const BadInput& fault) {
      fail(value.where, fmt::format("{}: {}", label(p), fault.what()));
    }
  }

  // One number type in the effective settings, so that 1 and 1.0 give the same case hash.
  static Setting plain(Setting value) {
    if (value.type == Type::integer) value.type = Type::number;
    for (Setting& item : value.items) item = plain(std::move(item));
    return value;
  }

  Setting checked(const Parameter& p, const Setting& value) {
    switch (p.type) {
      case ParameterType::text:
        if (value.type != Type::text) wrong_type(p, value, "a text in quotes");
        if (p.key == "name" && value.text.empty()) wrong_type(p, value, "a text of at least one letter");
        return value;
      case ParameterType::choice: check_choice(p, value); return value;
      case ParameterType::choices:
        if (value.type != Type::list) wrong_type(p, value, fmt::format("a list of some of \"{}\"", fmt::join(p.choices, "\", \"")));
        for (const Setting& item : value.items) check_choice(p, item);
        return value;
      case ParameterType::boolean:
        if (value.type != Type::boolean) wrong_type(p, value, "true or false");
        return value;
      case ParameterType::integer: check_number(p, value); return value;
      case ParameterType::number: check_number(p, value); return plain(value);
      case ParameterType::point: check_entries(p, value, dimension_, false); return plain(value);
      case ParameterType::expression: check_expression(p, value); return plain(value);
      case ParameterType::expressions: check_entries(p, value, dimension_, true); return plain(value);
      case ParameterType::vertices:
        if (value.type != Type::list || value.items.size() < 3) wrong_type(p, value, "a list of at least 3 points [x, y]");
        for (const Setting& vertex : value.items) check_entries(p, vertex, 2, false);
        return plain(value);
      case ParameterType::shape: return complete_shape(p, value);
      case ParameterType::shapes: {
        if (value.type != Type::list) wrong_type(p, value, "a list of shapes");
        Setting list = value;
        for (Setting& item : list.items) item = complete_shape(p, item);
        return list;
      }
    }
    return value;
  }

  Setting complete_shape(const Parameter& p, const Setting& value) {
    if (value.type != Type::table) wrong_type(p, value, "a shape such as { box = { min = [...], max = [...] } }");
    refuse_unknown_keys("shape", value);
    if (value.keys.size() != 1) {
      fail(value.where, fmt::format("{} names {} shapes, but has to name exactly one of box, polygon, ball, union, difference.", label(p),
                                    value.keys.size()));
    }
    const std::string& kind = value.keys.front();
    const Setting& body = value.items.front();
    Setting complete;
    complete.where = value.where;
    if (kind == "union" || kind == "difference") {
      const std::size_t least = kind == "union" ? 1 : 2;
      if (body.type != Type::list || body.items.size() < least) {
        fail(body.where, fmt::format("{} in {} has to be a list of at least {} shape{}.", kind, label(p), least, least == 1 ? "" : "s"));
      }
      Setting list = body;
      for (Setting& item : list.items) item = complete_shape(p, item);
      complete.set(kind, std::move(list));
    } else {
      if (kind == "polygon" && dimension_ == 3) fail(body.where, "a polygon has no meaning in 3D; use boxes and balls.");
      complete.set(kind, complete_table("shape." + kind, body));
    }
    return complete;
  }

  const Setting& document_;
  std::size_t dimension_ = 0;
  bool coupled_ = false;
};

}  // namespace

Setting complete_settings(const Setting& document) { return Completion(document).run(); }

}  // namespace tern
