// Cells of the neighbour search.

#include "sph/cell_grid.hpp"

#include <gtest/gtest.h>

namespace tern {
namespace {

// Seen to fail: without the check, the process asks for all memory there is.
TEST(CellGrid, RefusesToCoverWhatHasBeenFlungFarOff) {
  CellGrid<2> grid;
  grid.reset({0, 0}, {10, 10}, 0.01);
  EXPECT_EQ(grid.count(), 1001 * 1001);
  try {
    grid.reset({0, 0}, {1e6, 1e6}, 0.01);
    FAIL() << "covered";
  } catch (const NumericalFailure& failure) {
    EXPECT_NE(std::string(failure.what()).find("flung off"), std::string::npos) << failure.what();
  }
  EXPECT_THROW((CellGrid<3>().reset({0, 0, 0}, {0, 0, std::nan("")}, 1)), NumericalFailure);
}

}  // namespace
}  // namespace tern
