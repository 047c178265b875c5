// Frames are gathered in memory and written in one go by end(), so that the file is open for as short as possible and a
// frame with a fault leaves nothing behind.

#include "run/frame_writer.hpp"

#include <fmt/format.h>

#include <cassert>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numeric>
#include <variant>

#include "base/error.hpp"
#include "run/hdf5_file.hpp"
#include "run/xdmf_writer.hpp"

namespace tern {

namespace {

struct Field {
  std::string name, unit;
  std::variant<std::vector<float>, std::vector<double>, std::vector<int>, std::vector<std::uint32_t>> values;
  std::size_t rows;
  std::size_t columns;  ///< 3 of a vector, 0 of a scalar
  bool indexed;         ///< named in the XDMF index
};

hid_t hdf5_type(float) { return H5T_NATIVE_FLOAT; }
hid_t hdf5_type(double) { return H5T_NATIVE_DOUBLE; }
hid_t hdf5_type(int) { return H5T_NATIVE_INT; }
hid_t hdf5_type(std::uint32_t) { return H5T_NATIVE_UINT32; }

std::string frame_name(std::uint64_t index) { return fmt::format("frame_{:06}", index); }

XdmfField xdmf_field(const Field& field) {
  constexpr const char* types[] = {"Float", "Float", "Int", "UInt"};
  constexpr int bytes[] = {4, 8, 4, 4};
  return {field.name, types[field.values.index()], bytes[field.values.index()], field.columns > 0};
}

}  // namespace

struct FrameWriter::Frame {
  double time_s = 0;
  long step = 0;
  std::vector<Field> fields;

  std::size_t particles() const { return fields.empty() ? 0 : fields.front().rows; }

  template <class Real>
  Real finite(double value, const std::string& field, std::size_t i) const {
    // Real = float: what float32 cannot hold counts as not finite.
    if (!(std::abs(value) <= std::numeric_limits<Real>::max()))
      throw NumericalFailure(
          fmt::format("Field {} of particle {} is {} at step {}, t = {:.9g} s; the computation has "
                      "diverged: reduce the step (courant) or refine the spacing.",
                      field, i, value, step, time_s));
    return static_cast<Real>(value);
  }

  template <class Real, int D>
  std::vector<Real> triples(const std::string& field, std::span<const Vector<D>> values) const {
    std::vector<Real> result(3 * values.size(), Real(0));
    for (std::size_t i = 0; i < values.size(); ++i)
      for (int d = 0; d < D; ++d) result[3 * i + static_cast<std::size_t>(d)] = finite<Real>(values[i][d], field, i);
    return result;
  }
};

struct FrameWriter::Index {
  XdmfWriter xdmf;
  int frames = 0;
};

FrameWriter::FrameWriter(const std::string& out_dir, const std::string& name, bool anew) : data_path_(out_dir + "/" + name + ".h5") {
  if (anew) Hdf5File(data_path_, Hdf5File::Mode::create).close();
  index_ = std::make_unique<Index>(Index{XdmfWriter(out_dir + "/" + name + ".xmf", name + ".h5", anew)});
}

FrameWriter::~FrameWriter() = default;

int FrameWriter::frames() const { return index_->frames; }

void FrameWriter::begin(double time_s, long step) {
  frame_ = std::make_unique<Frame>();
  frame_->time_s = time_s;
  frame_->step = step;
}

void FrameWriter::scalar(const std::string& field, const std::string& unit, std::span<const double> values) {
  assert(frame_ && values.size() == frame_->particles());
  std::vector<float> stored(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) stored[i] = frame_->finite<float>(values[i], field, i);
  frame_->fields.push_back({field, unit, std::move(stored), values.size(), 0, true});
}

void FrameWriter::integer(const std::string& field, std::span<const int> values) {
  assert(frame_ && values.size() == frame_->particles());
  frame_->fields.push_back({field, "", std::vector<int>(values.begin(), values.end()), values.size(), 0, true});
}

void FrameWriter::integer(const std::string& field, std::span<const std::uint32_t> values) {
  assert(frame_ && values.size() == frame_->particles());
  frame_->fields.push_back({field, "", std::vector<std::uint32_t>(values.begin(), values.end()), values.size(), 0, true});
}

template <int D>
void FrameWriter::vector(const std::string& field, const std::string& unit, std::span<const Vector<D>> values) {
  assert(frame_ && (frame_->fields.empty() ? field == "position" : values.size() == frame_->particles()));
  if (field == "position") {  // the geometry of the index, not one of its attributes
    frame_->fields.push_back({field, unit, frame_->triples<double, D>(field, values), values.size(), 3, false});
  } else {
    frame_->fields.push_back({field, unit, frame_->triples<float, D>(field, values), values.size(), 3, true});
  }
}

template <int D>
void FrameWriter::side_vector(const std::string& field, const std::string& unit, std::span<const Vector<D>> values) {
  assert(frame_);
  frame_->fields.push_back({field, unit, frame_->triples<double, D>(field, values), values.size(), 3, false});
}

void FrameWriter::end() {
  assert(frame_ && !frame_->fields.empty());
  const std::string name = frame_name(static_cast<std::uint64_t>(index_->frames));
  const std::size_t particles = frame_->particles();
  std::vector<int> connectivity(particles);
  std::iota(connectivity.begin(), connectivity.end(), 0);
  frame_->fields.push_back({"connectivity", "", std::move(connectivity), particles, 0, false});

  Hdf5File file(data_path_, Hdf5File::Mode::append);
  {
    const Hdf5Handle group = file.create_group();
    file.write_attribute(group, "time_s", frame_->time_s);
    file.write_attribute(group, "step", frame_->step);
    for (const Field& field : frame_->fields)
      std::visit(
          [&](const auto& values) {
            using Value = typename std::decay_t<decltype(values)>::value_type;
            file.write_dataset(group, field.name, field.unit, hdf5_type(Value{}), values.data(), field.rows, field.columns);
          },
          field.values);
    file.link(group, name);
  }
  file.close();

  std::vector<XdmfField> indexed;
  for (const Field& field : frame_->fields)
    if (field.indexed) indexed.push_back(xdmf_field(field));
  index_->xdmf.add_frame(frame_->time_s, name, particles, indexed);
  ++index_->frames;
  frame_.reset();
}

FrameWriter::Mark FrameWriter::mark() const {
  std::error_code error;
  const auto bytes = std::filesystem::file_size(data_path_, error);
  if (error) throw InputOutputError(fmt::format("Cannot look at {}: {}.", data_path_, error.message()));
  return {static_cast<std::uint64_t>(index_->frames), bytes, index_->xdmf.end()};
}

void FrameWriter::go_back(const Mark& mark) {
  std::error_code error;
  const auto bytes = std::filesystem::file_size(data_path_, error);
  if (error || bytes < mark.data_bytes)
    throw InputOutputError(
        fmt::format("{} has less than {} bytes, which it had at the checkpoint; it was changed or lost.", data_path_, mark.data_bytes));
  if (bytes > mark.data_bytes) {
    const std::string temporary = data_path_ + ".tmp";
    Hdf5File(temporary, Hdf5File::Mode::create).close();
    Hdf5File source(data_path_, Hdf5File::Mode::read);
    for (std::uint64_t n = 0; n < mark.frames; ++n) {
      Hdf5File file(temporary, Hdf5File::Mode::append);
      file.copy_group(source, frame_name(n));
      file.close();
    }
    source.close();
    std::filesystem::rename(temporary, data_path_, error);
    if (error) throw InputOutputError(fmt::format("Cannot replace {}: {}.", data_path_, error.message()));
  }
  index_->xdmf.go_back(mark.index_bytes);
  index_->frames = static_cast<int>(mark.frames);
}

template void FrameWriter::vector<2>(const std::string&, const std::string&, std::span<const Vector<2>>);
template void FrameWriter::vector<3>(const std::string&, const std::string&, std::span<const Vector<3>>);
template void FrameWriter::side_vector<2>(const std::string&, const std::string&, std::span<const Vector<2>>);
template void FrameWriter::side_vector<3>(const std::string&, const std::string&, std::span<const Vector<3>>);

}  // namespace tern
