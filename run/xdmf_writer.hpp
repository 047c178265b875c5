#pragma once
// The XDMF 3 index of a file of frames: a temporal collection of point clouds (Polyvertex), which ParaView opens.

#include <cstddef>
#include <cstdint>
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
  /// `data_name` is the HDF5 file's name without directory: both files lie beside each other. `anew`: starts the file; otherwise it is
  /// there, and go_back() follows.
  XdmfWriter(std::string path, std::string data_name, bool anew = true);

  /// Puts the frame before the end of the index, in one write: whoever reads sees it or not. The group holds position (float64 [N,3]),
  /// connectivity (int32 [N]) and the fields. Throws InputOutputError; the file is then as before.
  void add_frame(double time_s, const std::string& group, std::size_t particles, const std::vector<XdmfField>& fields);

  /// Where the next frame begins in the file [bytes].
  std::uint64_t end() const { return end_; }
  /// Forgets the frames from `end` on. Throws InputOutputError.
  void go_back(std::uint64_t end);

 private:
  void put(const std::string& text);

  std::string path_, data_name_;
  std::uint64_t end_ = 0;
};

}  // namespace tern
