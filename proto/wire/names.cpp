// Names of roles and message kinds, taken from the schema itself.

#include "proto/wire/names.hpp"

#include <string_view>

#include <fmt/format.h>

namespace tern::proto {

std::string name(wire::Role role) {
  switch (role) {
    case wire::COUPLER: return "coupler";
    case wire::FLUID: return "fluid";
    case wire::STRUCTURE: return "structure";
    default: return fmt::format("role {}", static_cast<int>(role));
  }
}

std::string name(Kind kind) {
  const auto* field = wire::Message::descriptor()->FindFieldByNumber(static_cast<int>(kind));
  return field != nullptr && field->message_type() != nullptr ? field->message_type()->name() : "nothing";
}

std::string with_article(Kind kind) {
  const std::string word = name(kind);
  return (std::string_view("AEIOU").find(word[0]) == std::string_view::npos ? "a " : "an ") + word;
}

std::string where(std::uint64_t step, double time_s) {
  return step == 0 ? std::string("before the first step") : fmt::format("at step {}, t = {:.6g} s", step, time_s);
}

}  // namespace tern::proto
