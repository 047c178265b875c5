// Frames: what HDF5 holds, what the XDMF index says, what is refused, what survives a kill.

#include "run/frame_writer.hpp"

#include <gtest/gtest.h>
#include <hdf5.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <limits>

#include "base/error.hpp"
#include "fixtures/scratch_directory.hpp"
#include "run/hdf5_file.hpp"

namespace tern {
namespace {

struct Dataset {
  std::vector<hsize_t> extent;
  std::vector<double> values;
  std::size_t bytes_per_value = 0;
  std::string unit;
};

Dataset read(const std::string& path, const std::string& name) {
  const Hdf5Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  const Hdf5Handle dataset(H5Dopen2(file.id(), name.c_str(), H5P_DEFAULT), H5Dclose);
  EXPECT_GE(dataset.id(), 0) << name;
  const Hdf5Handle space(H5Dget_space(dataset.id()), H5Sclose);
  const Hdf5Handle type(H5Dget_type(dataset.id()), H5Tclose);
  Dataset result;
  result.extent.resize(static_cast<std::size_t>(H5Sget_simple_extent_ndims(space.id())));
  H5Sget_simple_extent_dims(space.id(), result.extent.data(), nullptr);
  result.values.resize(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space.id())));
  result.bytes_per_value = H5Tget_size(type.id());
  H5Dread(dataset.id(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, result.values.data());
  if (H5Aexists(dataset.id(), "unit") > 0) {
    const Hdf5Handle unit(H5Aopen(dataset.id(), "unit", H5P_DEFAULT), H5Aclose);
    const Hdf5Handle text(H5Aget_type(unit.id()), H5Tclose);
    result.unit.resize(H5Tget_size(text.id()));
    H5Aread(unit.id(), text.id(), result.unit.data());
  }
  return result;
}

double frame_time(const std::string& path, const std::string& group) {
  const Hdf5Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  const Hdf5Handle attribute(H5Aopen_by_name(file.id(), group.c_str(), "time_s", H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  double time = -1;
  H5Aread(attribute.id(), H5T_NATIVE_DOUBLE, &time);
  return time;
}

void write_frame(FrameWriter& frames, double time, long step, std::size_t n, double pressure = 1.5) {
  const std::vector<Vector<2>> position(n, Vector<2>(0.1, 0.2)), velocity(n, Vector<2>(-1, 2));
  frames.begin(time, step);
  frames.vector<2>("position", "m", position);
  frames.vector<2>("velocity", "m/s", velocity);
  frames.scalar("pressure", "Pa", std::vector<double>(n, pressure));
  frames.integer("flag", std::vector<int>(n, 1));
  frames.integer("id", std::vector<std::uint32_t>(n, 4'000'000'000u));
  frames.side_vector<2>("surface_force", "N/m", std::vector<Vector<2>>(3, Vector<2>(5, 6)));
  frames.end();
}

// Seen to fail with float32 positions and with the unit not written.
TEST(FrameWriter, StoresFieldsWithShapesUnitsAndPrecision) {
  const ScratchDirectory dir;
  FrameWriter frames(dir.path(), "fluid");
  write_frame(frames, 0, 0, 4);
  write_frame(frames, 0.02, 11, 2);
  EXPECT_EQ(frames.frames(), 2);
  const std::string path = dir / "fluid.h5";

  const Dataset position = read(path, "/frame_000000/position");
  EXPECT_EQ(position.extent, (std::vector<hsize_t>{4, 3}));
  EXPECT_EQ(std::vector<double>(position.values.begin(), position.values.begin() + 3), (std::vector<double>{0.1, 0.2, 0}));
  EXPECT_EQ(position.unit, "m");
  const Dataset pressure = read(path, "/frame_000001/pressure");
  EXPECT_EQ(pressure.extent, (std::vector<hsize_t>{2}));
  EXPECT_EQ(pressure.values, (std::vector<double>{1.5, 1.5}));
  EXPECT_EQ(pressure.bytes_per_value, 4u);
  EXPECT_EQ(pressure.unit, "Pa");
  EXPECT_EQ(read(path, "/frame_000001/id").values, (std::vector<double>{4e9, 4e9}));
  EXPECT_EQ(read(path, "/frame_000001/connectivity").values, (std::vector<double>{0, 1}));
  EXPECT_EQ(read(path, "/frame_000001/surface_force").extent, (std::vector<hsize_t>{3, 3}));
  EXPECT_EQ(frame_time(path, "frame_000001"), 0.02);
}

// Seen to fail with the number of particles of the first frame used for all, and with side vectors in the index.
TEST(FrameWriter, IndexesEveryFrameWithItsOwnNumberOfParticles) {
  const ScratchDirectory dir;
  FrameWriter frames(dir.path(), "fluid");
  write_frame(frames, 0, 0, 4);
  write_frame(frames, 0.02, 11, 2);
  const std::string index = text_of(dir / "fluid.xmf");
  for (const char* part : {"CollectionType=\"Temporal\"", "<Time Value=\"0.02\"/>", "Dimensions=\"4 3\"", "Dimensions=\"2 3\"",
                           "TopologyType=\"Polyvertex\" NumberOfElements=\"2\"", "fluid.h5:/frame_000001/connectivity",
                           "NumberType=\"UInt\"", "AttributeType=\"Vector\" Center=\"Node\"", "</Xdmf>"})
    EXPECT_NE(index.find(part), std::string::npos) << part;
  EXPECT_EQ(index.find("surface_force"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(dir / "fluid.xmf.tmp"));
}

// Seen to fail with frames without particles skipped in end().
TEST(FrameWriter, WritesAFrameWithoutParticles) {
  const ScratchDirectory dir;
  FrameWriter frames(dir.path(), "fluid");
  write_frame(frames, 0, 0, 0);
  EXPECT_EQ(read(dir / "fluid.h5", "/frame_000000/position").extent, (std::vector<hsize_t>{0, 3}));
}

// Seen to fail without the check in finite(): the file then holds nan, or inf for 1e300 stored as float32.
TEST(FrameWriter, RefusesValuesThatAreNotFiniteAndKeepsNothingOfTheFrame) {
  const ScratchDirectory dir;
  FrameWriter frames(dir.path(), "fluid");
  write_frame(frames, 0, 0, 4);
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), 1e300}) {
    frames.begin(0.125, 42);
    frames.vector<3>("position", "m", std::vector<Vector<3>>(4, Vector<3>(1, 2, 3)));
    try {
      frames.scalar("pressure", "Pa", std::vector<double>{1, 2, bad, 4});
      FAIL() << "accepted " << bad;
    } catch (const NumericalFailure& error) {
      const std::string sentence = error.what();
      for (const char* part : {"pressure", "particle 2", "step 42", "t = 0.125 s"})
        EXPECT_NE(sentence.find(part), std::string::npos) << sentence;
    }
  }
  write_frame(frames, 0.25, 50, 4);
  EXPECT_EQ(frame_time(dir / "fluid.h5", "frame_000001"), 0.25);
}

// Seen to fail with the results of H5Dwrite, H5Dclose, H5Fflush and H5Fclose ignored. A limit on the size of files
// stands in for a full disk.
TEST(FrameWriter, SaysWhichFileCannotBeWrittenAndKeepsEarlierFrames) {
  const ScratchDirectory dir;
  EXPECT_THROW(FrameWriter("/nowhere", "fluid"), InputOutputError);

  FrameWriter frames(dir.path(), "fluid");
  write_frame(frames, 0, 0, 100);
  rlimit before = {};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto old_action = signal(SIGXFSZ, SIG_IGN);
  rlimit small = before;
  small.rlim_cur = 100'000;
  setrlimit(RLIMIT_FSIZE, &small);
  std::string sentence;
  try {
    write_frame(frames, 0.02, 11, 10'000);
  } catch (const InputOutputError& error) {
    sentence = error.what();
  }
  setrlimit(RLIMIT_FSIZE, &before);
  signal(SIGXFSZ, old_action);
  EXPECT_NE(sentence.find("fluid.h5: File too large"), std::string::npos) << sentence;
  EXPECT_EQ(read(dir / "fluid.h5", "/frame_000000/pressure").values.size(), 100u);
  write_frame(frames, 0.02, 11, 10'000);  // once there is space again
  EXPECT_EQ(read(dir / "fluid.h5", "/frame_000001/pressure").values.size(), 10'000u);
}

// Wherever in the file the disk becomes full, the earlier frame stays and the failure is told.
// Seen to fail with the group named before its data are written.
TEST(FrameWriter, KeepsEarlierFramesWhereverTheDiskBecomesFull) {
  for (rlim_t room = 0; room < 16'000; room += 500) {
    const ScratchDirectory dir;
    const pid_t child = fork();
    if (child == 0) {
      FrameWriter frames(dir.path(), "fluid");
      write_frame(frames, 0, 0, 100);
      signal(SIGXFSZ, SIG_IGN);
      const rlim_t limit = std::filesystem::file_size(dir / "fluid.h5") + room;
      const rlimit full = {limit, limit};
      setrlimit(RLIMIT_FSIZE, &full);
      try {
        write_frame(frames, 0.02, 11, 100);
      } catch (const InputOutputError&) {
        _exit(5);
      }
      _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    ASSERT_TRUE(WIFEXITED(status));
    ASSERT_EQ(read(dir / "fluid.h5", "/frame_000000/pressure").values.size(), 100u) << "with room for " << room;
    if (WEXITSTATUS(status) == 0) {
      ASSERT_EQ(read(dir / "fluid.h5", "/frame_000001/pressure").values.size(), 100u);
    }
  }
}

// Seen to fail with the file kept open between frames: the killed process then leaves a file without its last frame.
TEST(FrameWriter, LeavesEveryFinishedFrameReadableWhenItsProcessIsKilled) {
  const ScratchDirectory dir;
  const pid_t child = fork();
  if (child == 0) {
    FrameWriter frames(dir.path(), "fluid");
    write_frame(frames, 0, 0, 1000);
    write_frame(frames, 0.02, 11, 1000);
    frames.begin(0.04, 22);
    raise(SIGKILL);
  }
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFSIGNALED(status));
  EXPECT_EQ(read(dir / "fluid.h5", "/frame_000001/velocity").values.size(), 3000u);
}

// Seen to fail without H5Pset_obj_track_times(false), which puts the date into every group and dataset.
TEST(FrameWriter, GoesBackToAMarkAndOnWithTheSameBytes) {
  const ScratchDirectory whole, cut;
  const auto frame = [](FrameWriter& frames, int n) {
    write_frame(frames, 0.1 * n, 10 * n, 40 + static_cast<std::size_t>(n), 1.0 / (n + 1));
  };
  FrameWriter one(whole.path(), "fluid");
  for (int n = 0; n < 700; ++n) frame(one, n);  // more than the root group holds in its first leaf

  FrameWriter::Mark mark;
  {
    FrameWriter first(cut.path(), "fluid");
    for (int n = 0; n < 600; ++n) {
      if (n == 550) mark = first.mark();
      frame(first, n);
    }
  }
  FrameWriter second(cut.path(), "fluid", false);
  second.go_back(mark);
  EXPECT_EQ(second.frames(), 550);
  for (int n = 550; n < 700; ++n) frame(second, n);
  EXPECT_TRUE(text_of(whole / "fluid.h5") == text_of(cut / "fluid.h5"));
  EXPECT_EQ(text_of(whole / "fluid.xmf"), text_of(cut / "fluid.xmf"));
}

TEST(FrameWriter, RefusesToGoBackInFilesThatHaveBecomeShorter) {
  const ScratchDirectory dir;
  FrameWriter frames(dir.path(), "fluid");
  write_frame(frames, 0, 0, 10);
  const FrameWriter::Mark mark = frames.mark();
  std::filesystem::resize_file(dir / "fluid.h5", 1000);
  EXPECT_THROW(frames.go_back(mark), InputOutputError);
}

// The index is not rewritten for every frame: its cost does not grow.
TEST(FrameWriter, AddsToTheIndexInPlace) {
  const ScratchDirectory dir;
  FrameWriter frames(dir.path(), "fluid");
  write_frame(frames, 0, 0, 5);
  const auto file_of = [&] {
    struct stat file {};
    EXPECT_EQ(::stat((dir / "fluid.xmf").c_str(), &file), 0);
    return file.st_ino;
  };
  const auto before = file_of();
  write_frame(frames, 1, 1, 5);
  EXPECT_EQ(file_of(), before);
  EXPECT_TRUE(text_of(dir / "fluid.xmf").ends_with("</Grid>\n</Grid>\n</Domain>\n</Xdmf>\n"));
}

}  // namespace
}  // namespace tern
