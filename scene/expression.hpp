#pragma once
// Scalar expressions of a case file in t, x, y, z (SI units), evaluated by muParser.

#include <array>
#include <memory>
#include <string>

namespace tern {

/// One expression, e.g. "0.1*sin(2*pi*t)". A plain number is an expression that costs no evaluation.
/// Copies share nothing mutable; evaluation is not thread-safe (call it outside parallel regions).
class Expression {
 public:
  Expression();  ///< the constant 0
  explicit Expression(double constant);
  /// Known names: t, x, y, z, pi and muParser's functions and operators (sin, sqrt, min, ^, ?: ...).
  /// Throws BadInput naming the text and the position of the fault.
  explicit Expression(const std::string& text);
  Expression(const Expression&);
  Expression& operator=(const Expression&);
  Expression(Expression&&) noexcept;
  Expression& operator=(Expression&&) noexcept;
  ~Expression();

  bool is_constant() const { return parser_ == nullptr; }
  /// Throws NumericalFailure when the value is not finite.
  double operator()(double t, double x = 0, double y = 0, double z = 0) const;
  /// True if the value changes with `variable`, one of 't', 'x', 'y', 'z'.
  bool depends_on(char variable) const;
  const std::string& text() const { return text_; }

 private:
  struct Parser;
  double constant_ = 0;
  std::string text_ = "0";
  std::unique_ptr<Parser> parser_;
};

/// One expression per direction; entries beyond the dimension are 0.
using VectorExpression = std::array<Expression, 3>;

/// Whether it is so everywhere and always.
bool is_zero(const VectorExpression& field);

}  // namespace tern
