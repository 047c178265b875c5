// HDF5 handles that close themselves and errors that are sentences.

#include "run/hdf5_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "base/error.hpp"

namespace tern {

namespace {

// The root group of a new file with room for the names of its first frames, so that naming one allocates nothing.
hid_t create_file(const std::string& path, hid_t access) {
  constexpr unsigned entries_per_leaf = 512;
  constexpr std::size_t bytes_per_name = 16;
  const Hdf5Handle creation(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
  H5Pset_sym_k(creation.id(), 0, entries_per_leaf / 2);
  H5Pset_local_heap_size_hint(creation.id(), entries_per_leaf * bytes_per_name);
  return H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation.id(), access);
}

hid_t open_file(const std::string& path, Hdf5File::Mode mode) {
  // At exit the library closes what is open and crashes where the disk is full. All files here are closed by their owners.
  [[maybe_unused]] static const herr_t at_exit = H5dont_atexit();
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);  // our sentence instead of the library's stack on stderr
  const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  // A viewer that has the file open for reading must not stop the run.
  H5Pset_file_locking(access.id(), false, true);
  errno = 0;
  if (mode == Hdf5File::Mode::create_compact) {
    H5Pset_libver_bounds(access.id(), H5F_LIBVER_LATEST, H5F_LIBVER_LATEST);
    return H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access.id());
  }
  if (mode == Hdf5File::Mode::create) return create_file(path, access.id());
  return H5Fopen(path.c_str(), mode == Hdf5File::Mode::append ? H5F_ACC_RDWR : H5F_ACC_RDONLY, access.id());
}

}  // namespace

Hdf5File::Hdf5File(std::string path, Mode mode) : path_(std::move(path)), file_(open_file(path_, mode), H5Fclose) {
  if (file_.id() < 0) fail(mode == Mode::create || mode == Mode::create_compact ? "create" : "open");
}

void Hdf5File::fail(const std::string& what) const {
  const std::string reason = errno != 0 ? std::strerror(errno) : "HDF5 refused it";
  throw InputOutputError(
      fmt::format("Cannot {} {}: {}; free space or choose another --out (frames written before are kept).", what, path_, reason));
}

Hdf5Handle Hdf5File::checked(hid_t id, Hdf5Handle::Close closer, const std::string& what) const {
  if (id < 0) fail(what);
  return Hdf5Handle(id, closer);
}

Hdf5Handle Hdf5File::root() { return checked(H5Gopen2(file_.id(), "/", H5P_DEFAULT), H5Gclose, "open the root of"); }

Hdf5Handle Hdf5File::create_group() {
  // Tracking the order makes HDF5 keep the links in the group's header: no separate tree and heap per frame.
  const Hdf5Handle creation(H5Pcreate(H5P_GROUP_CREATE), H5Pclose);
  H5Pset_link_creation_order(creation.id(), H5P_CRT_ORDER_TRACKED);
  H5Pset_link_phase_change(creation.id(), 64, 32);
  H5Pset_obj_track_times(creation.id(), false);
  return checked(H5Gcreate_anon(file_.id(), creation.id(), H5P_DEFAULT), H5Gclose, "write a group to");
}

void Hdf5File::link(const Hdf5Handle& group, const std::string& name) {
  if (H5Fflush(file_.id(), H5F_SCOPE_LOCAL) < 0) fail("flush " + name + " to");
  if (H5Olink(group.id(), file_.id(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT) < 0) fail("link " + name + " in");
}

void Hdf5File::write_dataset(const Hdf5Handle& group, const std::string& name, const std::string& unit, hid_t type, const void* values,
                             std::size_t rows, std::size_t columns) {
  const std::string what = "write dataset " + name + " to";
  const std::array<hsize_t, 2> extent{rows, columns};
  const Hdf5Handle space = checked(H5Screate_simple(columns > 0 ? 2 : 1, extent.data(), nullptr), H5Sclose, what);
  const Hdf5Handle linking(H5Pcreate(H5P_LINK_CREATE), H5Pclose), creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_create_intermediate_group(linking.id(), 1);
  H5Pset_obj_track_times(creation.id(), false);
  Hdf5Handle dataset =
      checked(H5Dcreate2(group.id(), name.c_str(), type, space.id(), linking.id(), creation.id(), H5P_DEFAULT), H5Dclose, what);
  if (H5Dwrite(dataset.id(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0) fail(what);
  if (!unit.empty()) write_attribute(dataset, "unit", unit);
  if (!dataset.close()) fail(what);
}

void Hdf5File::write_attribute(const Hdf5Handle& object, const std::string& name, hid_t type, const void* value) {
  const std::string what = "write attribute " + name + " to";
  const Hdf5Handle space = checked(H5Screate(H5S_SCALAR), H5Sclose, what);
  const Hdf5Handle attribute = checked(H5Acreate2(object.id(), name.c_str(), type, space.id(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose, what);
  if (H5Awrite(attribute.id(), type, value) < 0) fail(what);
}

void Hdf5File::write_attribute(const Hdf5Handle& object, const std::string& name, double value) {
  write_attribute(object, name, H5T_NATIVE_DOUBLE, &value);
}

void Hdf5File::write_attribute(const Hdf5Handle& object, const std::string& name, long value) {
  write_attribute(object, name, H5T_NATIVE_LONG, &value);
}

void Hdf5File::write_attribute(const Hdf5Handle& object, const std::string& name, const std::string& text) {
  const Hdf5Handle type = checked(H5Tcopy(H5T_C_S1), H5Tclose, "write attribute " + name + " to");
  H5Tset_size(type.id(), text.size());
  H5Tset_cset(type.id(), H5T_CSET_UTF8);
  write_attribute(object, name, type.id(), text.data());
}

std::optional<Hdf5File::Shape> Hdf5File::shape(const std::string& path, hid_t type) {
  const Hdf5Handle dataset(H5Dopen2(file_.id(), path.c_str(), H5P_DEFAULT), H5Dclose);
  if (dataset.id() < 0) return std::nullopt;
  const Hdf5Handle stored(H5Dget_type(dataset.id()), H5Tclose), space(H5Dget_space(dataset.id()), H5Sclose);
  if (H5Tequal(stored.id(), type) <= 0) return std::nullopt;
  std::array<hsize_t, 2> extent{};
  const int dimensions = H5Sget_simple_extent_ndims(space.id());
  if (dimensions < 1 || dimensions > 2) return std::nullopt;
  H5Sget_simple_extent_dims(space.id(), extent.data(), nullptr);
  return Shape{extent[0], dimensions == 2 ? extent[1] : 0};
}

void Hdf5File::read_dataset(const std::string& path, hid_t type, void* values) {
  const Hdf5Handle dataset = checked(H5Dopen2(file_.id(), path.c_str(), H5P_DEFAULT), H5Dclose, "open " + path + " in");
  if (H5Dread(dataset.id(), type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0) fail("read " + path + " of");
}

bool Hdf5File::has(const std::string& name) { return H5Lexists(file_.id(), name.c_str(), H5P_DEFAULT) > 0; }

std::vector<std::string> Hdf5File::datasets(const std::string& group) {
  std::vector<std::string> paths;
  if (!has(group)) return paths;
  const auto add = [](hid_t, const char* path, const H5O_info_t* object, void* found) {
    if (object->type == H5O_TYPE_DATASET) static_cast<std::vector<std::string>*>(found)->emplace_back(path);
    return herr_t{0};
  };
  if (H5Ovisit_by_name(file_.id(), group.c_str(), H5_INDEX_NAME, H5_ITER_INC, add, &paths, H5P_DEFAULT) < 0) fail("list " + group + " of");
  return paths;
}

namespace {

std::vector<std::string> names_in_order_of_making(hid_t group) {
  std::vector<std::string> names;
  H5Literate(
      group, H5_INDEX_CRT_ORDER, H5_ITER_INC, nullptr,
      [](hid_t, const char* name, const H5L_info_t*, void* found) {
        static_cast<std::vector<std::string>*>(found)->emplace_back(name);
        return herr_t{0};
      },
      &names);
  return names;
}

std::string text_attribute(hid_t object, const char* name) {
  const Hdf5Handle attribute(H5Aopen(object, name, H5P_DEFAULT), H5Aclose);
  const Hdf5Handle type(H5Aget_type(attribute.id()), H5Tclose);
  std::string text(H5Tget_size(type.id()), '\0');
  H5Aread(attribute.id(), type.id(), text.data());
  return text;
}

}  // namespace

void Hdf5File::copy_group(Hdf5File& source, const std::string& name) {
  const Hdf5Handle from = source.checked(H5Gopen2(source.file_.id(), name.c_str(), H5P_DEFAULT), H5Gclose, "open " + name + " in");
  const Hdf5Handle group = create_group();
  const auto attributes = [&](const char* attribute, auto value, hid_t type) {
    const Hdf5Handle given = source.checked(H5Aopen(from.id(), attribute, H5P_DEFAULT), H5Aclose, "read " + name + " of");
    if (H5Aread(given.id(), type, &value) < 0) source.fail("read " + name + " of");
    write_attribute(group, attribute, value);
  };
  attributes("time_s", 0.0, H5T_NATIVE_DOUBLE);
  attributes("step", 0L, H5T_NATIVE_LONG);
  for (const std::string& member : names_in_order_of_making(from.id())) {
    const Hdf5Handle dataset = source.checked(H5Dopen2(from.id(), member.c_str(), H5P_DEFAULT), H5Dclose, "open " + member + " in");
    const Hdf5Handle type(H5Dget_type(dataset.id()), H5Tclose);
    const Shape shape = source.shape(name + "/" + member, type.id()).value();
    std::vector<std::byte> values(shape.rows * std::max<std::size_t>(shape.columns, 1) * H5Tget_size(type.id()));
    if (H5Dread(dataset.id(), type.id(), H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0) source.fail("read " + member + " of");
    const std::string unit = H5Aexists(dataset.id(), "unit") > 0 ? text_attribute(dataset.id(), "unit") : "";
    write_dataset(group, member, unit, type.id(), values.data(), shape.rows, shape.columns);
  }
  link(group, name);
}

std::size_t Hdf5File::groups() {
  H5G_info_t info{};
  if (H5Gget_info(file_.id(), &info) < 0) fail("count the frames of");
  return info.nlinks;
}

void Hdf5File::close() {
  if (H5Fflush(file_.id(), H5F_SCOPE_LOCAL) < 0 || !file_.close()) fail("finish");
  H5garbage_collect();  // HDF5 keeps blocks of all sizes that the table of the frames' names has gone through
}

}  // namespace tern
