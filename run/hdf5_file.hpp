#pragma once
// The part of the HDF5 C library that frames and states need, with every handle closed by its destructor. Files carry no dates: equal
// contents written in the same order are equal bytes.

#include <hdf5.h>

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace tern {

/// One HDF5 identifier and the function that closes it.
class Hdf5Handle {
 public:
  using Close = herr_t (*)(hid_t);
  Hdf5Handle(hid_t id, Close closer) : id_(id), close_(closer) {}
  Hdf5Handle(Hdf5Handle&& other) noexcept : id_(std::exchange(other.id_, H5I_INVALID_HID)), close_(other.close_) {}
  Hdf5Handle(const Hdf5Handle&) = delete;
  Hdf5Handle& operator=(const Hdf5Handle&) = delete;
  ~Hdf5Handle() { close(); }

  hid_t id() const { return id_; }
  /// False if the library could not close it (data may not have reached the file).
  bool close() { return id_ < 0 || close_(std::exchange(id_, H5I_INVALID_HID)) >= 0; }

 private:
  hid_t id_;
  Close close_;
};

/// A file open for appending or reading. Every function throws InputOutputError naming the file and what was being written.
class Hdf5File {
 public:
  enum class Mode {
    create,          ///< for frames, each in a group of the root
    create_compact,  ///< for many small datasets
    append,
    read
  };
  Hdf5File(std::string path, Mode mode);

  Hdf5Handle root();

  /// A group that nothing refers to yet: link() makes it part of the file.
  Hdf5Handle create_group();
  /// Writes out everything so far, then gives the group its name. Until then nothing that was in the file before has
  /// been touched, whether the process is killed or the disk is full; the naming itself is a few small writes in place.
  void link(const Hdf5Handle& group, const std::string& name);
  /// rows x columns values; columns = 0 makes the dataset one-dimensional. `unit` may be empty: no attribute. Groups that `name` goes
  /// through are made.
  void write_dataset(const Hdf5Handle& group, const std::string& name, const std::string& unit, hid_t type, const void* values,
                     std::size_t rows, std::size_t columns);
  void write_attribute(const Hdf5Handle& object, const std::string& name, double value);
  void write_attribute(const Hdf5Handle& object, const std::string& name, long value);
  void write_attribute(const Hdf5Handle& object, const std::string& name, const std::string& text);

  struct Shape {
    std::size_t rows, columns;  ///< columns = 0: one-dimensional
  };
  /// Nothing where there is no dataset of this path whose numbers are of this type.
  std::optional<Shape> shape(const std::string& path, hid_t type);
  void read_dataset(const std::string& path, hid_t type, void* values);
  bool has(const std::string& name);
  /// The paths from a group to all datasets in it and in the groups below, in the order of their names; none where there is no such group.
  std::vector<std::string> datasets(const std::string& group);

  /// Copies group `name` of another file here, members in the order of their making, as create_group(), write_... and link() write it.
  void copy_group(Hdf5File& source, const std::string& name);
  /// Number of groups in the root.
  std::size_t groups();

  /// Flushes and closes; the destructor closes silently.
  void close();

 private:
  [[noreturn]] void fail(const std::string& what) const;
  Hdf5Handle checked(hid_t id, Hdf5Handle::Close closer, const std::string& what) const;
  void write_attribute(const Hdf5Handle& object, const std::string& name, hid_t type, const void* value);

  std::string path_;
  Hdf5Handle file_;
};

}  // namespace tern
