#pragma once
// A row binds a key of a case file once: name, member that it fills, unit, default, range and meaning. From the rows of a table
// come its validation, its defaults, the filling of its struct and its part of docs/PARAMETERS.md.

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "scene/case_file.hpp"
#include "scene/parameter_table.hpp"

namespace tern {

// Values by the type of the member: of settings that are checked, and as the type of a parameter.
void read_value(std::string& value, const Setting& setting);
void read_value(bool& value, const Setting& setting);
void read_value(int& value, const Setting& setting);
void read_value(double& value, const Setting& setting);
void read_value(std::optional<double>& value, const Setting& setting);
void read_value(std::array<double, 3>& value, const Setting& setting);
void read_value(Expression& value, const Setting& setting);
void read_value(VectorExpression& value, const Setting& setting);
void read_value(std::vector<std::array<double, 2>>& value, const Setting& setting);
void read_value(std::vector<std::array<double, 3>>& value, const Setting& setting);
void read_value(Shape& value, const Setting& setting);
void read_value(std::optional<Shape>& value, const Setting& setting);
void read_value(std::vector<Shape>& value, const Setting& setting);
void read_value(std::vector<std::string>& value, const Setting& setting);

constexpr ParameterType type_of(const std::string*) { return ParameterType::text; }
constexpr ParameterType type_of(const bool*) { return ParameterType::boolean; }
constexpr ParameterType type_of(const int*) { return ParameterType::integer; }
constexpr ParameterType type_of(const double*) { return ParameterType::number; }
constexpr ParameterType type_of(const std::optional<double>*) { return ParameterType::number; }
constexpr ParameterType type_of(const std::array<double, 3>*) { return ParameterType::point; }
constexpr ParameterType type_of(const Expression*) { return ParameterType::expression; }
constexpr ParameterType type_of(const VectorExpression*) { return ParameterType::expressions; }
constexpr ParameterType type_of(const std::vector<std::array<double, 2>>*) { return ParameterType::vertices; }
constexpr ParameterType type_of(const std::vector<std::array<double, 3>>*) { return ParameterType::places; }
constexpr ParameterType type_of(const Shape*) { return ParameterType::shape; }
constexpr ParameterType type_of(const std::optional<Shape>*) { return ParameterType::shape; }
constexpr ParameterType type_of(const std::vector<Shape>*) { return ParameterType::shapes; }

/// What a key fills in a T, and with that its type.
template <class T>
struct Member {
  template <class M, class Base>
  Member(M Base::*member)  // NOLINT: a pointer to member is one
      : type(type_of(static_cast<const M*>(nullptr))),
        fill([member](T& target, const Setting& value) { read_value(target.*member, value); }) {}
  template <class Base>
  Member(const Member<Base>& of_base)  // NOLINT: what fills the base fills it in a T
      : type(of_base.type), choices(of_base.choices), fill(of_base.fill) {}
  Member(ParameterType of_type, std::function<void(T&, const Setting&)> setter, std::vector<std::string> texts = {})
      : type(of_type), choices(std::move(texts)), fill(std::move(setter)) {}

  ParameterType type;
  std::vector<std::string> choices;
  std::function<void(T&, const Setting&)> fill;
};

/// A text of a fixed list, each of which stands for one value.
template <class T, class M>
Member<T> one_of(M T::*member, std::vector<std::pair<std::string, M>> values) {
  std::vector<std::string> texts;
  for (const auto& value : values) texts.push_back(value.first);
  return {ParameterType::choice,
          [member, values = std::move(values)](T& target, const Setting& setting) {
            for (const auto& [text, value] : values)
              if (text == setting.text) target.*member = value;
          },
          std::move(texts)};
}

/// A text of a fixed list, kept as it is.
template <class T>
Member<T> one_of(std::string T::*member, std::vector<std::string> texts) {
  return {ParameterType::choice, [member](T& target, const Setting& setting) { read_value(target.*member, setting); }, std::move(texts)};
}

/// Some texts of a fixed list.
template <class T>
Member<T> some_of(std::vector<std::string> T::*member, std::vector<std::string> texts) {
  return {ParameterType::choices, [member](T& target, const Setting& setting) { read_value(target.*member, setting); }, std::move(texts)};
}

template <class T>
struct Row {
  std::string key;
  Member<T> member;
  std::string unit;           ///< as in Parameter, the same below
  std::string default_value;  ///< as TOML, or `required`, or `absent`
  Range range;
  std::string meaning;
};
template <class T>
using Rows = std::vector<Row<T>>;

inline constexpr const char *required = "required", *absent = "absent";

/// The rows as the validation and the document see them.
template <class T>
std::vector<Parameter> parameters_of(const Rows<T>& rows) {
  std::vector<Parameter> list;
  for (const Row<T>& row : rows)
    list.push_back({"", row.key, row.member.type, row.unit, row.default_value, row.range, row.member.choices, row.meaning});
  return list;
}

/// Fills the members of `target` from a table of effective settings; what is absent there stays as it is.
template <class T>
void fill(T& target, const Rows<T>& rows, const Setting& table) {
  for (const Row<T>& row : rows)
    if (const Setting* value = table.find(row.key)) row.member.fill(target, *value);
}
template <class T>
T filled(const Rows<T>& rows, const Setting& table) {
  T target{};
  fill(target, rows, table);
  return target;
}

/// Gives the members of `target` the defaults of their rows; what is required or may be absent stays as it is.
template <class T>
void fill_defaults(T& target, const Rows<T>& rows) {
  for (const Row<T>& row : rows)
    if (row.default_value != required && row.default_value != absent)
      row.member.fill(target, read_toml_value(row.default_value, "default"));
}

}  // namespace tern
