// Parts of places from links that several ranks have.
//
// Seen to fail: with links of a thing with others left out, with parts counted on from the place before.

#include <gtest/gtest.h>

#include "fluid/pressure/parts_of_places.hpp"

namespace tern::fluid {
namespace {

TEST(PartsOfPlaces, AreJoinedByWhatAllSay) {
  PartsOfPlaces parts;
  // At place 7 one rank knows that 10 and 20 belong together, another that 20 and 5 do; 3 and 30 are alone.
  parts.join({{7, 10, 10}, {7, 20, 10}, {9, 4, 4}, {7, 30, 30}, {7, 20, 5}, {7, 3, 3}, {9, 10, 4}}, 4);
  EXPECT_EQ(parts.count(7), 3);
  EXPECT_EQ(parts.part(7, 3), 0);
  for (const int thing : {5, 10, 20}) EXPECT_EQ(parts.part(7, thing), 1);
  EXPECT_EQ(parts.part(7, 30), 2);
  EXPECT_EQ(parts.count(9), 1);
  EXPECT_EQ(parts.part(9, 10), 0);
}

TEST(PartsOfPlaces, BeyondTheMostAreOneWithTheLast) {
  PartsOfPlaces parts;
  parts.join({{1, 0, 0}, {1, 1, 1}, {1, 2, 2}, {1, 3, 3}, {2, 0, 0}}, 3);
  EXPECT_EQ(parts.count(1), 3);
  EXPECT_EQ(parts.part(1, 2), 2);
  EXPECT_EQ(parts.part(1, 3), 2);
  EXPECT_EQ(parts.count(2), 1);
}

}  // namespace
}  // namespace tern::fluid
