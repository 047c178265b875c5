#include "scene/keys/row.hpp"

#include "scene/keys/tables.hpp"

namespace tern {

void read_value(std::string& value, const Setting& setting) { value = setting.text; }
void read_value(bool& value, const Setting& setting) { value = setting.boolean; }
void read_value(int& value, const Setting& setting) { value = static_cast<int>(setting.number); }
void read_value(double& value, const Setting& setting) { value = setting.number; }
void read_value(std::optional<double>& value, const Setting& setting) { value = setting.number; }

void read_value(std::array<double, 3>& value, const Setting& setting) {
  value = {};
  for (std::size_t d = 0; d < setting.items.size(); ++d) value[d] = setting.items[d].number;
}

void read_value(Expression& value, const Setting& setting) {
  value = setting.type == Setting::Type::text ? Expression(setting.text) : Expression(setting.number);
}

void read_value(VectorExpression& value, const Setting& setting) {
  for (std::size_t d = 0; d < setting.items.size(); ++d) read_value(value[d], setting.items[d]);
}

void read_value(std::vector<std::array<double, 2>>& value, const Setting& setting) {
  value.clear();
  for (const Setting& point : setting.items) value.push_back({point.items[0].number, point.items[1].number});
}

void read_value(std::vector<std::array<double, 3>>& value, const Setting& setting) {
  value.clear();
  for (const Setting& point : setting.items) value.push_back({point.items[0].number, point.items[1].number, point.items[2].number});
}

void read_value(Shape& value, const Setting& setting) { value = read_shape(setting); }
void read_value(std::optional<Shape>& value, const Setting& setting) { value = read_shape(setting); }

void read_value(std::vector<Shape>& value, const Setting& setting) {
  value.clear();
  for (const Setting& shape : setting.items) value.push_back(read_shape(shape));
}

void read_value(std::vector<std::string>& value, const Setting& setting) {
  value.clear();
  for (const Setting& item : setting.items) value.push_back(item.text);
}

}  // namespace tern
