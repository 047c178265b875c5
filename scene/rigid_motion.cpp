#include "scene/rigid_motion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <sstream>

#include "base/error.hpp"

namespace tern {
namespace {

constexpr std::array<const char*, 4> column_names = {"x_m", "y_m", "z_m", "angle_rad"};

std::string trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r"), last = text.find_last_not_of(" \t\r");
  return first == std::string::npos ? "" : text.substr(first, last - first + 1);
}

std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> list;
  std::stringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) list.push_back(trimmed(cell));
  if (line.ends_with(',')) list.emplace_back();
  return list;
}

// Second derivatives of the natural cubic spline: continuous inside, 0 at both ends (tridiagonal system).
std::vector<double> spline(const std::vector<double>& t, const std::vector<double>& y) {
  const std::size_t n = t.size();
  std::vector<double> second(n, 0), factor(n, 0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double before = t[i] - t[i - 1], after = t[i + 1] - t[i];
    const double jump = (y[i + 1] - y[i]) / after - (y[i] - y[i - 1]) / before;
    const double pivot = 2 * (before + after) - before * factor[i - 1];
    factor[i] = after / pivot;
    second[i] = (6 * jump - before * second[i - 1]) / pivot;
  }
  for (std::size_t i = n - 1; i-- > 1;) second[i] -= factor[i] * second[i + 1];
  return second;
}

}  // namespace

MotionTable::MotionTable(const std::string& text, const std::string& file, int dimension) : text_(text) {
  std::vector<int> column;  // of each cell: -1 for the time, else an index of values_
  std::size_t number = 0;
  const auto fail = [&](const std::string& sentence) { throw BadInput(fmt::format("{}:{}: {}", file, number, sentence)); };
  std::stringstream stream(text);
  for (std::string line; std::getline(stream, line);) {
    ++number;
    if (trimmed(line).empty() || line.starts_with('#')) continue;
    const std::vector<std::string> row = cells(line);
    if (column.empty()) {
      for (const std::string& name : row) {
        const auto found = std::find(column_names.begin(), column_names.end(), name);
        const int index = name == "t_s" ? -1 : static_cast<int>(found - column_names.begin());
        if (index == 4 || (index == 2 && dimension == 2)) {
          fail(
              fmt::format("there is no column '{}' in a motion table in {}D; the header names t_s and some of x_m, y_m, "
                          "{}angle_rad.",
                          name, dimension, dimension == 3 ? "z_m, " : ""));
        }
        if (std::count(column.begin(), column.end(), index)) fail(fmt::format("the column '{}' stands twice; remove one.", name));
        column.push_back(index);
      }
      if (!std::count(column.begin(), column.end(), -1) || column.size() < 2) {
        fail("the header of a motion table has to name t_s and at least one of x_m, y_m, z_m, angle_rad; add what is missing.");
      }
      continue;
    }
    if (row.size() != column.size()) {
      fail(fmt::format("the row has {} cells, the header {}; give one number for each column.", row.size(), column.size()));
    }
    for (std::size_t k = 0; k < row.size(); ++k) {
      double value = 0;
      const auto [end, error] = std::from_chars(row[k].data(), row[k].data() + row[k].size(), value);
      if (error != std::errc() || end != row[k].data() + row[k].size() || !std::isfinite(value)) {
        fail(fmt::format("'{}' is not a finite number; correct it.", row[k]));
      }
      (column[k] < 0 ? time_ : values_[column[k]]).push_back(value);
    }
    if (time_.size() > 1 && time_.back() <= time_[time_.size() - 2]) {
      fail(fmt::format("the time {} s does not come after {} s; put the rows in order of time.", time_.back(), time_[time_.size() - 2]));
    }
    if (time_.size() > 1) continue;
    if (time_[0] != 0) fail(fmt::format("the table begins at t = {} s; its first row has to be t = 0.", time_[0]));
    for (std::size_t k = 0; k < 4; ++k) {
      if (!values_[k].empty() && std::abs(values_[k][0]) > 1e-9) {
        fail(fmt::format("{} is {} at t = 0 instead of 0; subtract it from all rows, or shift the wall's shape.", column_names[k],
                         values_[k][0]));
      }
    }
  }
  if (time_.size() < 2) {
    throw BadInput(fmt::format("{}: the motion table has {} rows of numbers, but needs at least 2; add some.", file, time_.size()));
  }
  for (std::size_t k = 0; k < 4; ++k)
    if (!values_[k].empty()) second_[k] = spline(time_, values_[k]);
}

std::array<double, 4> MotionTable::at(double t) const {
  std::array<double, 4> result{};
  t = std::clamp(t, 0.0, time_.back());
  const auto next = std::upper_bound(time_.begin(), time_.end() - 1, t);
  const std::size_t i = static_cast<std::size_t>(next - time_.begin()) - 1;
  const double step = time_[i + 1] - time_[i], b = (t - time_[i]) / step, a = 1 - b;
  for (std::size_t k = 0; k < 4; ++k) {
    if (values_[k].empty()) continue;
    const auto &y = values_[k], &m = second_[k];
    result[k] = a * y[i] + b * y[i + 1] + ((a * a * a - a) * m[i] + (b * b * b - b) * m[i + 1]) * step * step / 6;
  }
  return result;
}

template <int D>
Placement<D> placement(const RigidMotion& motion, double t) {
  std::array<double, 4> at;
  if (motion.table)
    at = motion.table->at(t);
  else
    at = {motion.displacement[0](t), motion.displacement[1](t), motion.displacement[2](t), motion.rotation(t)};
  Placement<D> place;
  for (int c = 0; c < D; ++c) {
    place.pivot[c] = motion.pivot[c];
    place.shift[c] = at[c];
  }
  place.angle = at[3];
  if (at[3] == 0) return place;
  if constexpr (D == 2) {
    place.turn << std::cos(at[3]), -std::sin(at[3]), std::sin(at[3]), std::cos(at[3]);
  } else {
    place.turn = Eigen::AngleAxisd(at[3], Eigen::Vector3d(motion.axis[0], motion.axis[1], motion.axis[2])).toRotationMatrix();
  }
  return place;
}

template Placement<2> placement<2>(const RigidMotion&, double);
template Placement<3> placement<3>(const RigidMotion&, double);

}  // namespace tern
