// Validation of the settings against the table of parameters, defaults filled in on the way.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "scene/key_sentences.hpp"
#include "scene/parameter_table.hpp"
#include "scene/value_check.hpp"

namespace tern {
namespace {

using Type = Setting::Type;
using Presence = TableDefinition::Presence;

class Completion {
 public:
  explicit Completion(const Setting& document) : document_(document) {
    const Setting* dimension = document.find("dimension");
    const Parameter& definition = parameters()[1];
    if (!dimension) fail_at(document.where, missing(definition));
    check_number(definition, *dimension);
    dimension_ = static_cast<std::size_t>(dimension->number);
  }

  Setting run() {
    const bool fluid = document_.find("fluid"), structure = document_.find("structure");
    if (!fluid && !structure) fail_at(document_.where, "the case has neither [fluid] nor [structure]; give at least one.");
    coupled_ = fluid && structure;
    if (const Setting* coupling = document_.find("coupling"); coupling && !coupled_) {
      fail_at(coupling->where, fmt::format("[coupling] has no meaning in a case without [{}]; remove it.", fluid ? "structure" : "fluid"));
    }
    return complete_table("", document_);
  }

 private:
  Setting complete_table(const std::string& path, const Setting& given) {
    if (given.type != Type::table) fail_at(given.where, fmt::format("{} is {}, but has to be a table.", table_label(path), to_text(given)));
    refuse_unknown_keys(path, given);
    Setting complete;
    complete.where = given.where;
    for (const Parameter& p : parameters()) {
      if (p.table != path) continue;
      if (const Setting* value = given.find(p.key)) {
        complete.set(p.key, checked(p, *value));
      } else if (p.default_value == "required") {
        fail_at(given.where, missing(p));
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
        fail_at(given.where, fmt::format("{} has no [[{}]]; {}", table_label(parent(table.path)), table.path, table.meaning));
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
      fail_at(value->where, fmt::format("{} has to be a list of tables; write [[{}]] above its keys.", key, table.path));
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
        std::vector<std::string> owners;
        for (const Parameter& p : parameters())
          if (p.key == key && !p.table.starts_with("shape")) owners.push_back(table_label(p.table));
        if (!owners.empty()) remedy = fmt::format("it belongs in {}.", fmt::join(owners, " or "));
      }
      fail_at(given.items[i].where, fmt::format("unknown key '{}' in {}; {}", key, table_label(path), remedy));
    }
  }

  Setting checked(const Parameter& p, const Setting& value) {
    if (p.type == ParameterType::shape) return complete_shape(p, value);
    if (p.type != ParameterType::shapes) return checked_value(p, value, dimension_);
    if (value.type != Type::list) wrong_type(p, value, "a list of shapes");
    Setting list = value;
    for (Setting& item : list.items) item = complete_shape(p, item);
    return list;
  }

  Setting complete_shape(const Parameter& p, const Setting& value) {
    if (value.type != Type::table) wrong_type(p, value, "a shape such as { box = { min = [...], max = [...] } }");
    refuse_unknown_keys("shape", value);
    if (value.keys.size() != 1) {
      fail_at(
          value.where,
          fmt::format("{} names {} shapes, but has to name exactly one of box, polygon, ball, ring, line, tube, plate, union, difference.",
                      label(p), value.keys.size()));
    }
    const std::string& kind = value.keys.front();
    const Setting& body = value.items.front();
    Setting complete;
    complete.where = value.where;
    if (kind == "union" || kind == "difference") {
      const std::size_t least = kind == "union" ? 1 : 2;
      if (body.type != Type::list || body.items.size() < least) {
        fail_at(body.where, fmt::format("{} in {} has to be a list of at least {} shape{}.", kind, label(p), least, least == 1 ? "" : "s"));
      }
      Setting list = body;
      for (Setting& item : list.items) item = complete_shape(p, item);
      complete.set(kind, std::move(list));
    } else {
      if (kind == "polygon" && dimension_ == 3) fail_at(body.where, "a polygon has no meaning in 3D; use boxes and balls, or a plate.");
      const bool is_thin_2d = kind == "ring" || kind == "line", is_thin = is_thin_2d || kind == "tube" || kind == "plate";
      if (is_thin_2d && dimension_ == 3) fail_at(body.where, fmt::format("a {} has no meaning in 3D; use a tube.", kind));
      if (kind == "tube" && dimension_ == 2) fail_at(body.where, "a tube has no meaning in 2D; use a ring.");
      if (kind == "plate" && dimension_ == 2) fail_at(body.where, "a plate has no meaning in 2D; use a line.");
      if (is_thin && (p.type != ParameterType::shape || (p.table != "structure.body" && p.table != "fluid.body")))
        fail_at(body.where, fmt::format("a {} can be in the shape of a [[structure.body]] or a [[fluid.body]] only; here use {}.", kind,
                                        dimension_ == 2 ? "a difference of balls or polygons" : "boxes and balls"));
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
