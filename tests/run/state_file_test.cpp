// States in files: every kind of member comes back with all its bits, and what does not fit is refused.

#include "run/state_file.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <map>

#include "base/error.hpp"
#include "base/vector.hpp"
#include "fixtures/scratch_directory.hpp"

namespace tern {
namespace {

enum class Kind { one, two };

struct Inner {
  double x = 0;
  std::vector<Vector<2>> points;
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("x", all.x...);
    visit("points", all.points...);
  }
};

class Marks {
 public:
  std::uint8_t& marks() { return marks_; }

 private:
  std::uint8_t marks_ = 0;
};

struct Everything {
  bool flag = false;
  int small = 0;
  long large = 0;
  std::uint32_t label = 0;
  std::uint64_t count = 0;
  double number = 0;
  Kind kind = Kind::one;
  std::string text;
  Vector<3> vector = Vector<3>::Zero();
  Eigen::VectorXd dynamic;
  std::vector<double> numbers, none;
  std::vector<Lanes> lanes;
  std::vector<Marks> marks;
  std::array<std::vector<double>, 2> rows;
  std::optional<double> given, absent = 1.0;
  std::deque<std::vector<Inner>> nested;
  std::vector<std::string> names;
  std::map<std::string, long> table;

  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("flag", all.flag...);
    visit("small", all.small...);
    visit("large", all.large...);
    visit("label", all.label...);
    visit("count", all.count...);
    visit("number", all.number...);
    visit("kind", all.kind...);
    visit("text", all.text...);
    visit("vector", all.vector...);
    visit("dynamic", all.dynamic...);
    visit("numbers", all.numbers...);
    visit("none", all.none...);
    visit("lanes", all.lanes...);
    visit("marks", all.marks...);
    visit("rows", all.rows...);
    visit("given", all.given...);
    visit("absent", all.absent...);
    visit("nested", all.nested...);
    visit("names", all.names...);
    visit("table", all.table...);
  }
};

TEST(StateFile, GivesEveryKindOfMemberBackWithAllBits) {
  const ScratchDirectory dir;
  Everything written;
  written.flag = true;
  written.small = -3;
  written.large = std::numeric_limits<long>::min();
  written.label = 4000000000u;
  written.count = std::numeric_limits<std::uint64_t>::max();
  written.number = -0.0;
  written.kind = Kind::two;
  written.text = "pressure gradient";
  written.vector = {1.0 / 3, -2, 5e-324};
  written.dynamic = Eigen::VectorXd::LinSpaced(5, 0, 1);
  written.numbers = {1e308, std::nan("7"), 0.1};
  written.lanes = {Lanes{1, 2, 3, 4}, broadcast(1.0 / 7)};
  written.marks.resize(3);
  written.marks[1].marks() = 200;
  written.rows = {std::vector<double>{1, 2}, std::vector<double>{}};
  written.given = 2.5;
  written.absent.reset();
  written.nested = {{}, {Inner{1, {}}, Inner{2, {Vector<2>(3, 4)}}}};
  written.names = {"a", "", "c"};
  written.table = {{"steps", 7}, {"", -1}};
  {
    StateWriter state;
    state("all", std::vector<double>(7));  // forgotten again
    state.clear();
    state("all", written);
    state.to_file(dir / "state.h5");
  }
  Everything read;
  read.none = {1, 2};
  read.names = {"old"};
  StateReader(dir / "state.h5")("all", read);
  EXPECT_EQ(read.flag, true);
  EXPECT_EQ(read.small, -3);
  EXPECT_EQ(read.large, written.large);
  EXPECT_EQ(read.label, written.label);
  EXPECT_EQ(read.count, written.count);
  EXPECT_TRUE(std::signbit(read.number));
  EXPECT_EQ(read.kind, Kind::two);
  EXPECT_EQ(read.text, written.text);
  EXPECT_EQ(read.vector, written.vector);
  EXPECT_EQ(read.dynamic, written.dynamic);
  ASSERT_EQ(read.numbers.size(), 3u);
  EXPECT_EQ(std::memcmp(read.numbers.data(), written.numbers.data(), 3 * sizeof(double)), 0);
  EXPECT_TRUE(read.none.empty());
  ASSERT_EQ(read.lanes.size(), 2u);
  EXPECT_EQ(std::memcmp(read.lanes.data(), written.lanes.data(), 2 * sizeof(Lanes)), 0);
  ASSERT_EQ(read.marks.size(), 3u);
  EXPECT_EQ(read.marks[1].marks(), 200);
  EXPECT_EQ(read.rows, written.rows);
  EXPECT_EQ(read.given, 2.5);
  EXPECT_FALSE(read.absent);
  ASSERT_EQ(read.nested.size(), 2u);
  EXPECT_TRUE(read.nested[0].empty());
  ASSERT_EQ(read.nested[1].size(), 2u);
  EXPECT_EQ(read.nested[1][1].points.at(0), Vector<2>(3, 4));
  EXPECT_EQ(read.names, written.names);
  EXPECT_EQ(read.table, written.table);
}

// Seen to fail without the comparison of types.
TEST(StateFile, RefusesAMemberThatIsMissingOrOfAnotherType) {
  const ScratchDirectory dir;
  {
    StateWriter state;
    state("number", 1.5);
    state("pair", std::vector<Vector<2>>{Vector<2>(1, 2)});
    state.to_file(dir / "state.h5");
  }
  StateReader file(dir / "state.h5");
  int integer = 0;
  std::vector<Vector<3>> triples;
  std::array<double, 3> three{};
  EXPECT_THROW(file("number", integer), BadInput);
  EXPECT_THROW(file("pair", triples), BadInput);
  EXPECT_THROW(file("absent", integer), BadInput);
  EXPECT_THROW(file("number", three), BadInput);
}

TEST(StateFile, EqualStatesAreEqualFiles) {
  const ScratchDirectory dir;
  for (const char* name : {"a.h5", "b.h5"}) {
    StateWriter state;
    state("numbers", std::vector<double>(1000, 0.25));
    state("text", std::string("same"));
    state.to_file(dir / name);
  }
  EXPECT_EQ(text_of(dir / "a.h5"), text_of(dir / "b.h5"));
}

}  // namespace
}  // namespace tern
