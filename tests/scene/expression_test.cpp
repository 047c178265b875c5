// Expressions of case files.

#include "scene/expression.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "base/error.hpp"

namespace tern {
namespace {

std::string sentence_of(const std::string& text) {
  try {
    Expression{text};
  } catch (const BadInput& fault) {
    return fault.what();
  }
  return "";
}

// Seen to fail with x and y exchanged in operator().
TEST(Expression, HasTheValueOfItsFormulaInTimeAndPlace) {
  const Expression e("2*t + x^2 - sin(pi*y)/z");
  EXPECT_DOUBLE_EQ(e(0.5, 3, 0.5, 4), 1 + 9 - 0.25);
  EXPECT_FALSE(e.is_constant());
}

// Seen to fail with t and x exchanged in operator().
TEST(Expression, KnowsConditions) {
  const Expression lift("t < 0.12 ? 2*t : 0.24");
  EXPECT_DOUBLE_EQ(lift(0.1), 0.2);
  EXPECT_DOUBLE_EQ(lift(0.5), 0.24);
}

// Seen to fail without the check of used variables: every text then kept its parser.
TEST(Expression, WithoutVariablesIsAConstant) {
  const Expression e("-9.81*2");
  EXPECT_TRUE(e.is_constant());
  EXPECT_DOUBLE_EQ(e(1, 2, 3, 4), -19.62);
  EXPECT_EQ(Expression(0.25).text(), "0.25");
  EXPECT_EQ(Expression().text(), "0");
}

// Seen to fail with a copy that did not take over the list of used variables.
TEST(Expression, CopiesAreIndependent) {
  Expression copy;
  {
    const Expression original("x + t");
    copy = original;
  }
  const Expression second(copy);
  EXPECT_DOUBLE_EQ(copy(1, 2), 3);
  EXPECT_DOUBLE_EQ(second(5, 5), 10);
  EXPECT_TRUE(second.depends_on('t'));
  EXPECT_FALSE(second.depends_on('y'));
}

// Seen to fail without the check for finite values.
TEST(Expression, StopsOnAValueThatIsNotFinite) {
  const Expression e("1/x");
  EXPECT_DOUBLE_EQ(e(0, 2), 0.5);
  EXPECT_THROW(e(0, 0), NumericalFailure);
  EXPECT_NE(sentence_of("1/0"), "");
}

// Seen to fail with the position left out, and, for the assignment, without refuse_assignment.
TEST(Expression, NamesTheTextAndThePositionOfAFault) {
  EXPECT_NE(sentence_of("2*u").find("'2*u' cannot be read at position 3"), std::string::npos) << sentence_of("2*u");
  EXPECT_NE(sentence_of("sin(x").find("sin(x"), std::string::npos);
  EXPECT_NE(sentence_of("x = 3").find("position 3"), std::string::npos) << sentence_of("x = 3");
  EXPECT_NE(sentence_of("1, 2"), "");
  EXPECT_NE(sentence_of(""), "");
  EXPECT_EQ(sentence_of("x <= 3 && t != 1 || y >= 2 && z == 0 ? 1 : 2"), "");
}

}  // namespace
}  // namespace tern
