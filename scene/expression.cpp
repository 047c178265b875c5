// Expressions of the case file: muParser behind a value type.

#include "scene/expression.hpp"

#include <fmt/format.h>
#include <muParser.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/error.hpp"

namespace tern {

struct Expression::Parser {
  // muParser keeps the addresses of the variables, so they live beside it and neither is ever copied or moved.
  mutable std::array<double, 4> variables{};
  mu::Parser parser;
  std::string used;

  explicit Parser(const std::string& text) {
    parser.DefineVar("t", &variables[0]);
    parser.DefineVar("x", &variables[1]);
    parser.DefineVar("y", &variables[2]);
    parser.DefineVar("z", &variables[3]);
    parser.DefineConst("pi", std::numbers::pi);
    parser.SetExpr(text);
  }
  Parser(const Parser&) = delete;
  Parser& operator=(const Parser&) = delete;
};

namespace {

// muParser takes "x = 3" as an assignment that would change the variable behind our back.
void refuse_assignment(const std::string& text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '=') continue;
    if (i + 1 < text.size() && text[i + 1] == '=') {
      ++i;
      continue;
    }
    if (i > 0 && (text[i - 1] == '<' || text[i - 1] == '>' || text[i - 1] == '!')) continue;
    throw BadInput(
        fmt::format("The expression '{}' assigns a value at position {}, which is not possible here; compare with '=='.", text, i + 1));
  }
}

}  // namespace

Expression::Expression() = default;
Expression::Expression(double constant) : constant_(constant), text_(fmt::format("{}", constant)) {}

Expression::Expression(const std::string& text) : text_(text) {
  refuse_assignment(text);
  try {
    auto parser = std::make_unique<Parser>(text);
    const double at_origin = parser->parser.Eval();
    if (parser->parser.GetNumResults() != 1) {
      throw BadInput(fmt::format("The expression '{}' has {} values separated by commas; give one.", text, parser->parser.GetNumResults()));
    }
    for (const auto& [name, address] : parser->parser.GetUsedVar()) parser->used += name;
    if (!parser->used.empty()) {
      parser_ = std::move(parser);
    } else if (std::isfinite(at_origin)) {
      constant_ = at_origin;
    } else {
      throw BadInput(fmt::format("The expression '{}' has the value {}; give a finite one.", text, at_origin));
    }
  } catch (const mu::Parser::exception_type& fault) {
    const std::string& why = fault.GetMsg();
    throw BadInput(
        fmt::format("The expression '{}' cannot be read at position {}: {}{} Known names are t, x, y, z, pi and "
                    "functions like sin and sqrt.",
                    text, fault.GetPos() + 1, why, why.ends_with('.') ? "" : "."));
  }
}

Expression::Expression(const Expression& other)
    : constant_(other.constant_), text_(other.text_), parser_(other.parser_ ? new Parser(other.text_) : nullptr) {
  if (parser_) parser_->used = other.parser_->used;
}

Expression& Expression::operator=(const Expression& other) {
  if (this != &other) *this = Expression(other);
  return *this;
}

Expression::Expression(Expression&&) noexcept = default;
Expression& Expression::operator=(Expression&&) noexcept = default;
Expression::~Expression() = default;

double Expression::operator()(double t, double x, double y, double z) const {
  if (!parser_) return constant_;
  parser_->variables = {t, x, y, z};
  const double value = parser_->parser.Eval();
  if (!std::isfinite(value)) {
    throw EndOfModel(
        fmt::format("The expression '{}' has the value {} at t = {} s, x = {} m, y = {} m, z = {} m; write it so that it "
                    "stays finite everywhere in the domain.",
                    text_, value, t, x, y, z));
  }
  return value;
}

bool Expression::depends_on(char variable) const { return parser_ && parser_->used.find(variable) != std::string::npos; }

bool is_zero(const VectorExpression& field) {
  return std::all_of(field.begin(), field.end(), [](const Expression& part) { return part.is_constant() && part(0) == 0; });
}

}  // namespace tern
