#include "run/state_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

#include "base/error.hpp"
#include "run/hdf5_file.hpp"

namespace tern {
namespace {

hid_t memory_type(StoredAs type) {
  switch (type) {
    case StoredAs::unsigned8: return H5T_NATIVE_UINT8;
    case StoredAs::signed32: return H5T_NATIVE_INT32;
    case StoredAs::unsigned32: return H5T_NATIVE_UINT32;
    case StoredAs::signed64: return H5T_NATIVE_INT64;
    case StoredAs::unsigned64: return H5T_NATIVE_UINT64;
    case StoredAs::real64: break;
  }
  return H5T_NATIVE_DOUBLE;
}

constexpr StoredAs every_type[] = {StoredAs::unsigned8, StoredAs::signed32,   StoredAs::unsigned32,
                                   StoredAs::signed64,  StoredAs::unsigned64, StoredAs::real64};

std::size_t bytes_of(StoredAs type) {
  switch (type) {
    case StoredAs::unsigned8: return 1;
    case StoredAs::signed32:
    case StoredAs::unsigned32: return 4;
    default: return 8;
  }
}

}  // namespace

void StateWriter::write(const std::string& name, StoredAs type, const void* values, std::size_t rows, std::size_t columns) {
  entries_.push_back({name, type, rows, columns, bytes_.size()});
  const auto* begin = static_cast<const std::byte*>(values);
  bytes_.insert(bytes_.end(), begin, begin + rows * std::max<std::size_t>(columns, 1) * bytes_of(type));
}

void StateWriter::to_file(const std::string& path) const {
  Hdf5File file(path, Hdf5File::Mode::create_compact);
  Hdf5Handle root = file.root();
  for (const Entry& entry : entries_)
    file.write_dataset(root, entry.name, "", memory_type(entry.type), bytes_.data() + entry.begin, entry.rows, entry.columns);
  root.close();
  file.close();
  // A file that is renamed before its content has reached the disk could be empty after a power failure.
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool synced = descriptor >= 0 && ::fsync(descriptor) == 0;
  if (descriptor >= 0) ::close(descriptor);
  if (!synced) throw InputOutputError(fmt::format("Cannot bring {} to the disk; free space or choose another --out.", path));
}

struct StateReader::File {
  explicit File(const std::string& name) : path(name), hdf5(name, Hdf5File::Mode::read) {}
  std::string path;
  Hdf5File hdf5;
};

StateReader::StateReader(const std::string& path) : file_(std::make_unique<File>(path)) {}
StateReader::~StateReader() = default;

std::size_t StateReader::rows(const std::string& name, StoredAs type, std::size_t columns) {
  const auto shape = file_->hdf5.shape(name, memory_type(type));
  if (!shape || shape->columns != columns)
    throw BadInput(
        fmt::format("{} has no {} as this program knows it: it was written by another version of tern; continue the run with that.",
                    file_->path, name));
  return shape->rows;
}

bool StateReader::has(const std::string& name) { return file_->hdf5.has(name); }

StateWriter StateReader::all(const std::string& name) {
  StateWriter found;
  std::vector<std::byte> values;
  for (const std::string& member : file_->hdf5.datasets(name)) {
    const std::string path = name + "/" + member;
    for (const StoredAs type : every_type) {
      const auto shape = file_->hdf5.shape(path, memory_type(type));
      if (!shape) continue;
      values.resize(shape->rows * std::max<std::size_t>(shape->columns, 1) * bytes_of(type));
      read(path, type, values.data());
      found.write(member, type, values.data(), shape->rows, shape->columns);
      break;
    }
  }
  return found;
}

void StateReader::read(const std::string& name, StoredAs type, void* values) { file_->hdf5.read_dataset(name, memory_type(type), values); }

void StateReader::expect_size(const std::string& name, std::size_t found, std::size_t wanted) const {
  if (found != wanted)
    throw BadInput(
        fmt::format("{} has {} entries of {} where this case has {}: it belongs to another case.", file_->path, found, name, wanted));
}

}  // namespace tern
