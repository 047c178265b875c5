#include "scene/value_check.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "base/error.hpp"
#include "scene/expression.hpp"
#include "scene/key_sentences.hpp"

namespace tern {

using Type = Setting::Type;

void wrong_type(const Parameter& p, const Setting& value, const std::string& wanted) {
  fail_at(value.where, fmt::format("{} is {}, but has to be {}.", label(p), to_text(value), wanted));
}

namespace {

/// What is to be written for a text that means a number, ".5" or "0.5"; empty for all others.
std::string number_of(const Setting& value) {
  if (value.type != Type::text || value.text.empty()) return "";
  const char* const end = value.text.data() + value.text.size();
  double number = 0;
  const auto [read, error] = std::from_chars(value.text.data(), end, number);
  return error == std::errc() && read == end && std::isfinite(number) ? fmt::format("; write {}", number) : "";
}

void refuse_outside(const Parameter& p, const Setting& value, double x) {
  const bool low = p.range.lowest_excluded ? x <= p.range.lowest : x < p.range.lowest;
  const bool high = p.range.highest_excluded ? x >= p.range.highest : x > p.range.highest;
  if (!std::isfinite(x) || low || high) {
    const std::string range = describe(p.range);
    fail_at(value.where, fmt::format("{} is {}, but has to be {}.", label(p), to_text(value), range.empty() ? "finite" : range));
  }
}

}  // namespace

void check_number(const Parameter& p, const Setting& value) {
  const bool whole = value.type == Type::integer;
  if (p.type == ParameterType::integer && !whole) wrong_type(p, value, "a whole number " + describe(p.range));
  if (!whole && value.type != Type::number) wrong_type(p, value, "a number " + describe(p.range) + number_of(value));
  refuse_outside(p, value, value.number);
}

namespace {

void check_choice(const Parameter& p, const Setting& value) {
  if (value.type != Type::text) wrong_type(p, value, fmt::format("one of \"{}\"", fmt::join(p.choices, "\", \"")));
  if (std::find(p.choices.begin(), p.choices.end(), value.text) != p.choices.end()) return;
  if (p.choices.size() == 1) {
    fail_at(value.where, fmt::format("{} is \"{}\", but there is only \"{}\".", label(p), value.text, p.choices.front()));
  }
  fail_at(value.where, fmt::format("{} is \"{}\", but has to be one of \"{}\"; the nearest is \"{}\".", label(p), value.text,
                                   fmt::join(p.choices, "\", \""), nearest(value.text, p.choices)));
}

void check_expression(const Parameter& p, const Setting& value, std::size_t dimension) {
  if (value.type == Type::number || value.type == Type::integer) {
    refuse_outside(p, value, value.number);
    return;
  }
  if (value.type != Type::text) wrong_type(p, value, "a number or an expression in quotes");
  Expression expression;
  try {
    expression = Expression(value.text);
  } catch (const BadInput& fault) {
    fail_at(value.where, fmt::format("{}: {}", label(p), fault.what()));
  }
  if (expression.is_constant()) refuse_outside(p, value, expression(0));
  if (dimension == 2 && expression.depends_on('z'))
    fail_at(value.where, fmt::format("{} is {}, but a case in 2D has no z; use t, x and y.", label(p), to_text(value)));
}

void check_entries(const Parameter& p, const Setting& value, std::size_t count, bool expressions) {
  const std::string wanted = fmt::format("a list of {} {}", count, expressions ? "numbers or expressions in quotes" : "numbers");
  if (value.type != Type::list || value.items.size() != count) wrong_type(p, value, wanted);
  for (const Setting& item : value.items) {
    const bool number = item.type == Type::number || item.type == Type::integer;
    if (!number && !(expressions && item.type == Type::text)) wrong_type(p, value, wanted);
    check_expression(p, item, count);
  }
}

// One number type in the effective settings, so that 1 and 1.0 give the same case hash.
Setting plain(Setting value) {
  if (value.type == Type::integer) value.type = Type::number;
  for (Setting& item : value.items) item = plain(std::move(item));
  return value;
}

}  // namespace

Setting checked_value(const Parameter& p, const Setting& value, std::size_t dimension) {
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
    case ParameterType::point: check_entries(p, value, dimension, false); return plain(value);
    case ParameterType::expression: check_expression(p, value, dimension); return plain(value);
    case ParameterType::expressions: check_entries(p, value, dimension, true); return plain(value);
    case ParameterType::vertices:
      if (value.type != Type::list || value.items.size() < 2) wrong_type(p, value, "a list of at least 2 points [x, y]");
      for (const Setting& vertex : value.items) check_entries(p, vertex, 2, false);
      return plain(value);
    case ParameterType::places:
      if (value.type != Type::list || value.items.size() < 3) wrong_type(p, value, "a list of at least 3 points [x, y, z]");
      for (const Setting& place : value.items) check_entries(p, place, 3, false);
      return plain(value);
    case ParameterType::shape:
    case ParameterType::shapes: break;
  }
  return value;
}

}  // namespace tern
