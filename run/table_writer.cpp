// CSV rows to a file, whole lines only.

#include "run/table_writer.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <sstream>

#include "base/error.hpp"
#include "base/log.hpp"

namespace tern {

namespace {

constexpr double flush_interval_s = 0.5;
constexpr std::size_t flush_bytes = 1 << 20;

std::string csv_text(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string result(1, '"');
  for (const char c : text) result.append(c == '"' ? 2 : 1, c);
  result += '"';
  return result;
}

std::string number_text(const Cell& cell) {
  return cell.is_integer() ? fmt::format("{:.0f}", *cell.number()) : fmt::format("{:.9g}", *cell.number());
}

}  // namespace

TableWriter::TableWriter(std::string path, std::vector<std::string> columns, bool anew)
    : path_(std::move(path)), columns_(std::move(columns)) {
  descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CLOEXEC | (anew ? O_CREAT | O_TRUNC : 0), 0666);
  if (descriptor_ < 0)
    throw InputOutputError(
        anew ? fmt::format("Cannot create {}: {}; choose another --out.", path_, std::strerror(errno))
             : fmt::format("Cannot go on with {}: {}; a run is resumed with all its tables.", path_, std::strerror(errno)));
  if (!anew) return;
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    if (c) pending_ += ',';
    pending_ += csv_text(columns_[c]);
  }
  pending_ += '\n';
  ++lines_;
  try {
    flush();
  } catch (...) {
    ::close(descriptor_);
    throw;
  }
}

TableWriter::~TableWriter() {
  try {
    close();
  } catch (const Error& error) {
    log_warning(error.what());
  }
}

void TableWriter::row(std::span<const Cell> cells) {
  assert(cells.size() == columns_.size());
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const auto& number = cells[c].number();
    if (number && !std::isfinite(*number))
      throw NumericalFailure(fmt::format("Column {} of {} is {} at t = {} s; the computation has diverged before this time.", columns_[c],
                                         path_, *number,
                                         cells[0].number() ? fmt::format("{:.9g}", *cells[0].number()) : std::string("unknown")));
  }
  for (std::size_t c = 0; c < cells.size(); ++c) {
    if (c) pending_ += ',';
    const Cell& cell = cells[order_.empty() ? c : order_[c]];
    pending_ += cell.number() ? number_text(cell) : csv_text(cell.text());
  }
  pending_ += '\n';
  ++lines_;
  if (since_flush_.seconds() > flush_interval_s || pending_.size() > flush_bytes) flush();
}

void TableWriter::row(std::span<const std::optional<double>> values) {
  const std::vector<Cell> cells(values.begin(), values.end());
  row(std::span<const Cell>(cells));
}

void TableWriter::row(std::span<const double> values) {
  const std::vector<Cell> cells(values.begin(), values.end());
  row(std::span<const Cell>(cells));
}

void TableWriter::flush() {
  struct stat file;
  if (!pending_.empty() && ::fstat(descriptor_, &file) == 0 && S_ISREG(file.st_mode)) {
    if (file.st_nlink == 0) throw InputOutputError(fmt::format("{} has been deleted while the run was writing it.", path_));
    if (file.st_size < static_cast<off_t>(written_))
      throw InputOutputError(fmt::format("{} has been cut short while the run was writing it.", path_));
  }
  std::size_t done = 0;
  while (done < pending_.size()) {
    const ssize_t written = ::write(descriptor_, pending_.data() + done, pending_.size() - done);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) {
      const int reason = errno;
      const std::size_t whole = pending_.rfind('\n', done - 1) + 1, lines = done > 0 ? whole : 0;
      const off_t end = ::lseek(descriptor_, static_cast<off_t>(lines) - static_cast<off_t>(done), SEEK_CUR);
      if (end >= 0) (void)!::ftruncate(descriptor_, end);  // the file ends at a whole line
      pending_.erase(0, lines);                            // what reached the file is not written a second time
      written_ += lines;
      throw InputOutputError(fmt::format("Cannot write {}: {}; free space or choose another --out.", path_, std::strerror(reason)));
    }
    done += static_cast<std::size_t>(written);
  }
  written_ += pending_.size();
  pending_.clear();
  since_flush_.restart();
}

void TableWriter::sync() {
  flush();
  if (::fsync(descriptor_) != 0)
    throw InputOutputError(
        fmt::format("Cannot bring {} to the disk: {}; free space or choose another --out.", path_, std::strerror(errno)));
}

void TableWriter::go_back(std::uint64_t bytes) {
  const off_t end = ::lseek(descriptor_, 0, SEEK_END), wanted = static_cast<off_t>(bytes);
  if (end < wanted)
    throw InputOutputError(fmt::format("{} has {} bytes, but had {} at the checkpoint; it was changed or lost.", path_, end, bytes));
  if (::ftruncate(descriptor_, wanted) != 0 || ::lseek(descriptor_, wanted, SEEK_SET) != wanted)
    throw InputOutputError(fmt::format("Cannot cut {} back: {}.", path_, std::strerror(errno)));
  pending_.clear();
  written_ = bytes;
}

void TableWriter::go_back_to_lines(std::uint64_t lines) {
  std::ifstream before(path_, std::ios::binary);
  std::string line;
  if (!std::getline(before, line)) throw InputOutputError(fmt::format("Cannot read {}; it was changed or lost.", path_));
  // Quotes are only around a name with a comma, which no column has.
  std::vector<std::string> there;
  std::istringstream names(line);
  for (std::string name; std::getline(names, name, ',');) there.push_back(name);
  const auto place_of = [&](const std::string& name) {
    return static_cast<std::size_t>(std::find(columns_.begin(), columns_.end(), name) - columns_.begin());
  };
  std::vector<std::size_t> order;
  for (const std::string& name : there) {
    order.push_back(place_of(name));
    if (order.back() == columns_.size())
      throw BadInput(fmt::format("{} has the column {}, which this case has not; gauges may be added only.", path_, name));
  }
  std::string added;
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    if (std::find(order.begin(), order.end(), c) != order.end()) continue;
    order.push_back(c);
    added += "," + columns_[c];
  }
  const std::string temporary = path_ + ".tmp", empty(order.size() - there.size(), ',');
  std::ofstream after(temporary, std::ios::binary);
  after << line << added << '\n';
  std::uint64_t done = 1;
  for (; done < lines && std::getline(before, line) && !before.eof(); ++done) after << line << empty << '\n';
  after.close();
  if (done < lines)
    throw InputOutputError(fmt::format("{} has {} lines, but had {} at the checkpoint; it was changed or lost.", path_, done, lines));
  if (!after || std::rename(temporary.c_str(), path_.c_str()) != 0)
    throw InputOutputError(fmt::format("Cannot write {}: {}; free space.", path_, std::strerror(errno)));
  const int descriptor = ::open(path_.c_str(), O_WRONLY | O_CLOEXEC);
  const off_t end = descriptor < 0 ? -1 : ::lseek(descriptor, 0, SEEK_END);
  if (end < 0) throw InputOutputError(fmt::format("Cannot open {}: {}.", path_, std::strerror(errno)));
  ::close(descriptor_);
  descriptor_ = descriptor;
  order_ = std::move(order);
  pending_.clear();
  written_ = static_cast<std::uint64_t>(end);
  lines_ = lines;
}

void TableWriter::close() {
  if (descriptor_ < 0) return;
  try {
    flush();
  } catch (...) {
    ::close(descriptor_);
    descriptor_ = -1;
    throw;
  }
  const int result = ::close(descriptor_);
  descriptor_ = -1;
  if (result != 0)
    throw InputOutputError(fmt::format("Cannot finish {}: {}; free space or choose another --out.", path_, std::strerror(errno)));
}

}  // namespace tern
