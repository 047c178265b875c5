#include "scene/rigid_motion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include "base/error.hpp"
#include "base/time.hpp"

namespace tern {
namespace {

constexpr std::array<const char*, 4> column_names = {"x_m", "y_m", "z_m", "angle_rad"};

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r"), last = text.find_last_not_of(" \t\r");
  return first == std::string_view::npos ? "" : text.substr(first, last - first + 1);
}

// The cells of a line, not more than one above the five columns that there are.
void split(std::string_view line, std::vector<std::string_view>& cells) {
  cells.clear();
  for (std::size_t begin = 0; cells.size() <= column_names.size() + 1;) {
    const std::size_t comma = line.find(',', begin);
    cells.push_back(trimmed(line.substr(begin, comma - begin)));
    if (comma == std::string_view::npos) return;
    begin = comma + 1;
  }
}

// With these a spline stays finite. A tick of time is the least that two rows can be apart and still be two.
constexpr double largest_value = 1e9;  // [m, rad, s]
constexpr std::size_t most_rows = 1000000;

// Second derivatives of the cubic spline: continuous inside, constant between the first two rows and between the last two (tridiagonal
// system). Of a table that begins or ends within a motion the natural spline, with 0 at both ends, would take the acceleration away there.
std::vector<double> spline(const std::vector<double>& t, const std::vector<double>& y) {
  const std::size_t n = t.size();
  std::vector<double> second(n, 0), factor(n, 0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double before = t[i] - t[i - 1], after = t[i + 1] - t[i];
    const double jump = (y[i + 1] - y[i]) / after - (y[i] - y[i - 1]) / before;
    const double ends = (i == 1 ? before : 0) + (i + 2 == n ? after : 0);
    const double pivot = 2 * (before + after) + ends - before * factor[i - 1];
    factor[i] = i + 2 == n ? 0 : after / pivot;
    second[i] = (6 * jump - before * second[i - 1]) / pivot;
  }
  for (std::size_t i = n - 1; i-- > 1;) second[i] -= factor[i] * second[i + 1];
  if (n > 2) second.front() = second[1], second.back() = second[n - 2];
  return second;
}

}  // namespace

// What the file holds is never said, only where it is wrong: it may be another file than its owner meant, with what is nobody's business.
MotionTable::MotionTable(const std::string& text, const std::string& file, int dimension) : text_(text) {
  std::vector<int> column;  // of each cell: -1 for the time, else an index of values_
  std::vector<std::string_view> row;
  std::size_t number = 0;
  const auto fail = [&](const std::string& sentence) { throw BadInput(fmt::format("{}:{}: {}", file, number, sentence)); };
  constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";  // spreadsheets begin a table with it
  std::string_view rest = text_;
  if (rest.starts_with(byte_order_mark)) rest.remove_prefix(byte_order_mark.size());
  while (!rest.empty()) {
    const std::string_view line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(std::min(rest.size(), line.size() + 1));
    ++number;
    if (trimmed(line).empty() || line.starts_with('#')) continue;
    split(line, row);
    if (column.empty()) {
      for (std::size_t k = 0; k < row.size(); ++k) {
        const auto found = std::find(column_names.begin(), column_names.end(), row[k]);
        const int index = row[k] == "t_s" ? -1 : static_cast<int>(found - column_names.begin());
        if (index == 4 || (index == 2 && dimension == 2)) {
          fail(
              fmt::format("column {} of the header is none that a motion table in {}D can have; the header names t_s and some of x_m, y_m, "
                          "{}angle_rad.",
                          k + 1, dimension, dimension == 3 ? "z_m, " : ""));
        }
        if (std::count(column.begin(), column.end(), index)) fail(fmt::format("the column '{}' stands twice; remove one.", row[k]));
        column.push_back(index);
      }
      if (!std::count(column.begin(), column.end(), -1) || column.size() < 2) {
        fail("the header of a motion table has to name t_s and at least one of x_m, y_m, z_m, angle_rad; add what is missing.");
      }
      continue;
    }
    if (row.size() != column.size()) {
      fail(fmt::format("the row has {} cells, the header {}; give one number for each column.",
                       std::count(line.begin(), line.end(), ',') + 1, column.size()));
    }
    if (time_.size() == most_rows) fail(fmt::format("the table has more than {} rows; leave some out, splines go between.", most_rows));
    for (std::size_t k = 0; k < row.size(); ++k) {
      double value = 0;
      const auto [end, error] = std::from_chars(row[k].data(), row[k].data() + row[k].size(), value);
      if (error != std::errc() || end != row[k].data() + row[k].size() || !(std::abs(value) <= largest_value)) {
        fail(fmt::format("cell {} is not a number from {:g} to {:g}; correct it.", k + 1, -largest_value, largest_value));
      }
      (column[k] < 0 ? time_ : values_[column[k]]).push_back(value);
    }
    if (time_.size() > 1 && time_.back() - time_[time_.size() - 2] < 1 / ticks_per_second) {
      fail("the time does not come after that of the row before, by at least 2^-32 s; put the rows in order of time.");
    }
    if (time_.size() > 1) continue;
    if (time_[0] != 0) fail("the table does not begin at t = 0; its first row has to.");
    for (std::size_t k = 0; k < 4; ++k) {
      if (!values_[k].empty() && std::abs(values_[k][0]) > 1e-9) {
        fail(fmt::format("{} is not 0 at t = 0; subtract what it is there from all rows, or shift the wall's shape.", column_names[k]));
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
Matrix<D> turn_by(double angle, const std::array<double, 3>& axis) {
  Matrix<D> turn;
  if constexpr (D == 2)
    turn << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  else
    turn = Eigen::AngleAxisd(angle, Eigen::Vector3d(axis[0], axis[1], axis[2])).toRotationMatrix();
  return turn;
}

template <int D>
Placement<D> placement(const RigidMotion& motion, double t) {
  std::array<double, 4> at;
  if (motion.table)
    at = motion.table->at(t);
  else
    at = {motion.displacement[0](t), motion.displacement[1](t), motion.displacement[2](t), motion.rotation(t)};
  return placed_at<D>(motion, Vector<D>(at.data()), at[3]);
}

template <int D>
Placement<D> placed_at(const RigidMotion& motion, const Vector<D>& shift, double angle) {
  Placement<D> place;
  place.pivot = Vector<D>(motion.pivot.data());
  place.shift = shift;
  place.angle = angle;
  if (angle != 0) place.turn = turn_by<D>(angle, motion.axis);
  return place;
}

template Matrix<2> turn_by<2>(double, const std::array<double, 3>&);
template Matrix<3> turn_by<3>(double, const std::array<double, 3>&);
template Placement<2> placement<2>(const RigidMotion&, double);
template Placement<3> placement<3>(const RigidMotion&, double);
template Placement<2> placed_at<2>(const RigidMotion&, const Vector<2>&, double);
template Placement<3> placed_at<3>(const RigidMotion&, const Vector<3>&, double);

}  // namespace tern
