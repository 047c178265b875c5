#pragma once
// Frames of one process: DIR/<name>.h5 (data) and DIR/<name>.xmf (XDMF 3 index of it, for ParaView and VisIt).
//
//   FrameWriter frames(out_dir, "fluid");
//   frames.begin(t, step);
//   frames.vector<D>("position", "m", position);      // always the first: it sets the number of particles
//   frames.vector<D>("velocity", "m/s", velocity);
//   frames.scalar("pressure", "Pa", pressure);
//   frames.end();
//
// Layout: group /frame_000000, /frame_000001, ... with attributes time_s and step; per field one dataset [N] or [N,3]
// with attribute "unit"; in 2D the third component is 0. Positions are float64, all other reals float32, integers int32
// or uint32. "connectivity" (0..N-1) is there because ParaView shows no point that no cell refers to. The file is
// opened, appended to, flushed and closed per frame: whatever ends the process, earlier frames stay readable.

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/vector.hpp"

namespace tern {

class FrameWriter {
 public:
  /// `name` is "fluid" or "structure". `anew`: starts both files; otherwise they are there, and go_back() follows. Throws
  /// InputOutputError naming the file.
  FrameWriter(const std::string& out_dir, const std::string& name, bool anew = true);
  ~FrameWriter();
  FrameWriter(const FrameWriter&) = delete;
  FrameWriter& operator=(const FrameWriter&) = delete;

  void begin(double time_s, long step);

  /// Fields of the N particles. Throws NumericalFailure naming field, particle index and time for a value that is not
  /// finite (or beyond float32 for fields stored so); nothing of the frame is kept then.
  void scalar(const std::string& field, const std::string& unit, std::span<const double> values);
  void integer(const std::string& field, std::span<const int> values);
  void integer(const std::string& field, std::span<const std::uint32_t> values);
  template <int D>
  void vector(const std::string& field, const std::string& unit, std::span<const Vector<D>> values);

  /// Vectors on other points than the particles (surface_position, surface_force, wall_place): in the frame's group as float64
  /// [K,3], not in the XDMF index.
  template <int D>
  void side_vector(const std::string& field, const std::string& unit, std::span<const Vector<D>> values);

  /// Writes the frame and then the index. Throws InputOutputError naming the file.
  void end();

  int frames() const;

  /// Where the files are, to come back to.
  struct Mark {
    std::uint64_t frames = 0, data_bytes = 0, index_bytes = 0;

    /// The list of the members: visit(name, member of each) for every one.
    template <class Visit, class... Same>
    static void for_each_field(Visit&& visit, Same&... all) {
      visit("frames", all.frames...);
      visit("data_bytes", all.data_bytes...);
      visit("index_bytes", all.index_bytes...);
    }
  };
  Mark mark() const;
  /// Makes both files what they were, byte for byte. A data file that has become longer is written anew with the frames it had then,
  /// for HDF5 does not give back what was added. Throws InputOutputError.
  void go_back(const Mark& mark);

 private:
  struct Frame;
  struct Index;
  std::string data_path_;
  std::unique_ptr<Frame> frame_;  ///< the frame between begin() and end()
  std::unique_ptr<Index> index_;
};

}  // namespace tern
