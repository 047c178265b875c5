// CSV tables: format, empty cells, refusals, full disks.

#include "run/table_writer.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <thread>

#include "base/error.hpp"
#include "fixtures/scratch_directory.hpp"

namespace tern {
namespace {

// Seen to fail with "{:.6g}".
TEST(TableWriter, WritesNineDigitsEmptyCellsAndTexts) {
  const ScratchDirectory dir;
  {
    TableWriter table(dir / "steps.csv", {"t_s", "dt_s", "limit", "iterations"});
    table.row({0.1234567891234, 1.0 / 3.0, "gravity", 7});
    table.row({2, std::nullopt, "a \"b\", c", 123456789012});
    const std::vector<std::optional<double>> values{1.0, std::nullopt, 2.5e-7, std::nullopt};
    table.row(values);
  }
  EXPECT_EQ(text_of(dir / "steps.csv"),
            "t_s,dt_s,limit,iterations\n"
            "0.123456789,0.333333333,gravity,7\n"
            "2,,\"a \"\"b\"\", c\",123456789012\n"
            "1,,2.5e-07,\n");
}

// Seen to fail without the isfinite check: the file then holds "nan".
TEST(TableWriter, RefusesANumberThatIsNotFiniteAndNamesColumnAndTime) {
  const ScratchDirectory dir;
  TableWriter table(dir / "energy.csv", {"t_s", "fluid_kinetic_J"});
  table.row({0.5, 1.0});
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    try {
      table.row({0.75, bad});
      FAIL() << "accepted " << bad;
    } catch (const NumericalFailure& error) {
      EXPECT_NE(std::string(error.what()).find("fluid_kinetic_J"), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find("0.75"), std::string::npos) << error.what();
    }
  }
  table.row({1.0, 2.0});
  table.close();
  EXPECT_EQ(text_of(dir / "energy.csv"), "t_s,fluid_kinetic_J\n0.5,1\n1,2\n");
}

// Seen to fail with a flush in the destructor only.
TEST(TableWriter, ShowsItsHeaderAtOnceAndItsRowsWithinASecond) {
  const ScratchDirectory dir;
  TableWriter table(dir / "gauges.csv", {"t_s", "P.ux_m"});
  EXPECT_EQ(text_of(dir / "gauges.csv"), "t_s,P.ux_m\n");
  table.row({1.0, 2.0});
  std::this_thread::sleep_for(std::chrono::milliseconds(900));
  table.row({2.0, 3.0});
  EXPECT_EQ(text_of(dir / "gauges.csv"), "t_s,P.ux_m\n1,2\n2,3\n");
}

// Seen to fail with the result of write() ignored.
TEST(TableWriter, SaysWhichFileCannotBeWrittenWhenTheDiskIsFull) {
  try {
    TableWriter table("/dev/full", {"t_s"});
    FAIL() << "no error from a full device";
  } catch (const InputOutputError& error) {
    EXPECT_NE(std::string(error.what()).find("/dev/full: No space left"), std::string::npos) << error.what();
  }
  EXPECT_THROW(TableWriter("/nowhere/gauges.csv", {"t_s"}), InputOutputError);
}

// Seen to fail: without a look at the file (rows go to a file that nobody can read, and after a gap of zeros).
TEST(TableWriter, SaysThatItsFileHasBeenDeletedOrCutShort) {
  const auto said = [](const std::function<void(const std::string&)>& damage) -> std::string {
    const ScratchDirectory dir;
    TableWriter table(dir / "t.csv", {"t_s", "x"});
    table.row({1, 2});
    table.sync();
    damage(dir / "t.csv");
    table.row({2, 3});
    try {
      table.close();
    } catch (const InputOutputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(said([](const std::string& path) { std::filesystem::remove(path); }).find("t.csv has been deleted"), std::string::npos);
  EXPECT_NE(said([](const std::string& path) { std::filesystem::resize_file(path, 3); }).find("t.csv has been cut short"),
            std::string::npos);
  EXPECT_EQ(said([](const std::string&) {}), "");
}

TEST(TableWriter, GoesBackToAMark) {
  const ScratchDirectory dir;
  std::uint64_t mark = 0;
  {
    TableWriter table(dir / "t.csv", {"t_s", "x"});
    table.row({1, 2});
    mark = table.length();
    table.sync();
    table.row({2, 3});
  }
  TableWriter table(dir / "t.csv", {"t_s", "x"}, false);
  EXPECT_THROW(table.go_back(mark + 1000), InputOutputError);
  table.go_back(mark);
  table.row({5, 6});
  table.close();
  EXPECT_EQ(text_of(dir / "t.csv"), "t_s,x\n1,2\n5,6\n");
}

}  // namespace
}  // namespace tern
