#pragma once
// The XDMF 3 index of a file of frames: a temporal collection of point clouds (Polyvertex), which ParaView opens.

#include <cstddef>
#include <string>
#include <vector>

namespace tern {

/// One field of a frame as XDMF has to describe it.
struct XdmfField {
  std::string name;
  const char* number_type = "Float";  ///< "Float", "Int" or "UInt"
  int precision = 4;                  ///< bytes per number
  bool is_vector = false;             ///< [N,3] instead of [N]
};

class XdmfWriter {
 public:
  /// `data_name` is the HDF5 file's name without directory: both files lie beside each other.
  XdmfWriter(std::string path, std::string data_name);

  /// Adds the frame and replaces the file atomically. The group holds position (float64 [N,3]), connectivity (int32
  /// [N]) and the fields. Throws InputOutputError.
  void add_frame(double time_s, const std::string& group, std::size_t particles, const std::vector<XdmfField>& fields);

 private:
  std::string path_, data_name_;
  std::string grids_;  ///< text of all frames so far
};

}  // namespace tern
