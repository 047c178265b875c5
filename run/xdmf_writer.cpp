// XDMF text for frames of points.

#include "run/xdmf_writer.hpp"

#include <fmt/format.h>

#include "run/atomic_file.hpp"

namespace tern {

namespace {

constexpr const char* head =
    "<?xml version=\"1.0\" ?>\n"
    "<!DOCTYPE Xdmf SYSTEM \"Xdmf.dtd\" []>\n"
    "<Xdmf Version=\"3.0\">\n<Domain>\n<Grid Name=\"frames\" GridType=\"Collection\" CollectionType=\"Temporal\">\n";
constexpr const char* tail = "</Grid>\n</Domain>\n</Xdmf>\n";

}  // namespace

XdmfWriter::XdmfWriter(std::string path, std::string data_name) : path_(std::move(path)), data_name_(std::move(data_name)) {
  write_atomically(path_, std::string(head) + tail);
}

void XdmfWriter::add_frame(double time_s, const std::string& group, std::size_t particles, const std::vector<XdmfField>& fields) {
  const auto item = [&](const std::string& dimensions, const char* type, int precision, const std::string& name) {
    return fmt::format("<DataItem Format=\"HDF\" Dimensions=\"{}\" NumberType=\"{}\" Precision=\"{}\">{}:/{}/{}</DataItem>", dimensions,
                       type, precision, data_name_, group, name);
  };
  const std::string count = fmt::format("{}", particles), triples = count + " 3";
  grids_ += fmt::format("<Grid Name=\"{}\" GridType=\"Uniform\">\n<Time Value=\"{:.17g}\"/>\n", group, time_s);
  grids_ += fmt::format("<Topology TopologyType=\"Polyvertex\" NumberOfElements=\"{}\" NodesPerElement=\"1\">{}</Topology>\n", count,
                        item(count, "Int", 4, "connectivity"));
  grids_ += fmt::format("<Geometry GeometryType=\"XYZ\">{}</Geometry>\n", item(triples, "Float", 8, "position"));
  for (const XdmfField& field : fields)
    grids_ += fmt::format("<Attribute Name=\"{}\" AttributeType=\"{}\" Center=\"Node\">{}</Attribute>\n", field.name,
                          field.is_vector ? "Vector" : "Scalar",
                          item(field.is_vector ? triples : count, field.number_type, field.precision, field.name));
  grids_ += "</Grid>\n";
  write_atomically(path_, head + grids_ + tail);
}

}  // namespace tern
