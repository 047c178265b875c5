#pragma once
// One CSV table, live while the run goes on: a header line with names and units ("t_s,P.ux_m"), then one line per row.
// Numbers have nine significant digits; an undefined value is an empty cell. Only whole lines ever reach the file.

#include <concepts>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/timing.hpp"

namespace tern {

/// One cell: a number, a text, or nothing (undefined).
class Cell {
 public:
  Cell() = default;
  Cell(std::nullopt_t) {}
  template <class Number>
  requires std::integral<Number> || std::floating_point<Number> Cell(Number value)
      : integral_(std::integral<Number>), number_(static_cast<double>(value)) {}
  Cell(const std::optional<double>& value) : number_(value) {}
  Cell(std::string text) : text_(std::move(text)) {}
  Cell(std::string_view text) : text_(text) {}
  Cell(const char* text) : text_(text) {}

  bool is_integer() const { return integral_; }  ///< printed with all its digits (exact below 2^53)
  const std::optional<double>& number() const { return number_; }
  const std::string& text() const { return text_; }

 private:
  bool integral_ = false;
  std::optional<double> number_;
  std::string text_;
};

class TableWriter {
 public:
  /// Creates (truncates) the file and writes the header. The first column is the time. Not `anew`: the file is there, and go_back()
  /// follows. Throws InputOutputError.
  TableWriter(std::string path, std::vector<std::string> columns, bool anew = true);
  /// Writes what is left; a failure here is logged, not thrown (call close() to have it thrown).
  ~TableWriter();
  TableWriter(const TableWriter&) = delete;
  TableWriter& operator=(const TableWriter&) = delete;

  /// Appends one row, one cell per column. Throws NumericalFailure naming column and time for a number that is not
  /// finite (the row is not written), InputOutputError naming the file if it cannot be written.
  void row(std::span<const Cell> cells);
  void row(std::initializer_list<Cell> cells) { row(std::span<const Cell>(cells.begin(), cells.size())); }
  void row(std::span<const std::optional<double>> values);
  void row(std::span<const double> values);

  /// Rows reach the file at least once a second of calls to row() by themselves.
  void flush();
  void close();

  /// Length of the file when all rows have reached it [bytes].
  std::uint64_t length() const { return written_ + pending_.size(); }
  /// Brings all rows to the disk.
  void sync();
  /// Cuts the file back to a length() of before. Throws InputOutputError when it has become shorter than that.
  void go_back(std::uint64_t bytes);
  /// Lines of the file when all rows have reached it, the header among them.
  std::uint64_t lines() const { return lines_; }
  /// Cuts the file back to as many lines(). Columns that it has not got yet are added at its end, with empty cells in the rows that are
  /// there; from then on the columns have the order of the file, columns() the names. Throws InputOutputError, and BadInput when the
  /// file has other columns.
  void go_back_to_lines(std::uint64_t lines);

  const std::vector<std::string>& columns() const { return columns_; }

 private:
  std::string path_;
  std::vector<std::string> columns_;
  std::string pending_;
  std::uint64_t written_ = 0;  ///< [bytes]
  std::uint64_t lines_ = 0;
  std::vector<std::size_t> order_;  ///< cell of a row in each column of the file; empty: the same
  Stopwatch since_flush_;
  int descriptor_ = -1;
};

}  // namespace tern
