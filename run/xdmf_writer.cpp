// XDMF text for frames of points.

#include "run/xdmf_writer.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "base/error.hpp"
#include "run/atomic_file.hpp"

namespace tern {

namespace {

constexpr const char* head =
    "<?xml version=\"1.0\" ?>\n"
    "<!DOCTYPE Xdmf SYSTEM \"Xdmf.dtd\" []>\n"
    "<Xdmf Version=\"3.0\">\n<Domain>\n<Grid Name=\"frames\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
constexpr const char* tail = "</Grid>\n</Domain>\n</Xdmf>\n";

}  // namespace

XdmfWriter::XdmfWriter(std::string path, std::string data_name, bool anew)
    : path_(std::move(path)), data_name_(std::move(data_name)), end_(std::strlen(head)) {
  if (anew) write_atomically(path_, std::string(head) + tail);
}

void XdmfWriter::put(const std::string& text) {
  const int descriptor = ::open(path_.c_str(), O_WRONLY | O_CLOEXEC);
  const auto write_at_end = [&](const std::string& whole) {
    for (std::size_t done = 0; done < whole.size();) {
      const ssize_t written = ::pwrite(descriptor, whole.data() + done, whole.size() - done, static_cast<off_t>(end_ + done));
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) return false;
      done += static_cast<std::size_t>(written);
    }
    return true;
  };
  errno = 0;
  const bool done = descriptor >= 0 && write_at_end(text + tail) &&
                    ::ftruncate(descriptor, static_cast<off_t>(end_ + text.size() + std::strlen(tail))) == 0;
  const int reason = errno;
  if (!done && descriptor >= 0 && write_at_end(tail)) (void)!::ftruncate(descriptor, static_cast<off_t>(end_ + std::strlen(tail)));
  if (descriptor >= 0) ::close(descriptor);
  if (!done) throw InputOutputError(fmt::format("Cannot write {}: {}; free space or choose another --out.", path_, std::strerror(reason)));
  end_ += text.size();
}

void XdmfWriter::go_back(std::uint64_t end) {
  struct stat file {};
  if (::stat(path_.c_str(), &file) != 0 || static_cast<std::uint64_t>(file.st_size) < end)
    throw InputOutputError(fmt::format("{} has less than {} bytes, which it had at the checkpoint; it was changed or lost.", path_, end));
  end_ = end;
  put("");
}

void XdmfWriter::add_frame(double time_s, const std::string& group, std::size_t particles, const std::vector<XdmfField>& fields) {
  const auto item = [&](const std::string& dimensions, const char* type, int precision, const std::string& name) {
    return fmt::format("<DataItem Format=\"HDF\" Dimensions=\"{}\" NumberType=\"{}\" Precision=\"{}\">{}:/{}/{}</DataItem>", dimensions,
                       type, precision, data_name_, group, name);
  };
  const std::string count = fmt::format("{}", particles), triples = count + " 3";
  std::string grid = fmt::format("<Grid Name=\"{}\" GridType=\"Uniform\">\n<Time Value=\"{:.17g}\"/>\n", group, time_s);
  grid += fmt::format("<Topology TopologyType=\"Polyvertex\" NumberOfElements=\"{}\" NodesPerElement=\"1\">{}</Topology>\n", count,
                      item(count, "Int", 4, "connectivity"));
  grid += fmt::format("<Geometry GeometryType=\"XYZ\">{}</Geometry>\n", item(triples, "Float", 8, "position"));
  for (const XdmfField& field : fields)
    grid += fmt::format("<Attribute Name=\"{}\" AttributeType=\"{}\" Center=\"Node\">{}</Attribute>\n", field.name,
                        field.is_vector ? "Vector" : "Scalar",
                        item(field.is_vector ? triples : count, field.number_type, field.precision, field.name));
  put(grid + "</Grid>\n");
}

}  // namespace tern
