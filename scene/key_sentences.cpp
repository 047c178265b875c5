#include "scene/key_sentences.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "base/error.hpp"

namespace tern {
namespace {

std::string unit_label(const Parameter& p) { return p.unit.empty() || p.unit == "-" ? "" : " [" + p.unit + "]"; }

}  // namespace

void fail_at(const std::string& where, const std::string& sentence) { throw BadInput(fmt::format("{}: {}", where, sentence)); }

std::string one_line(std::string sentence) {
  for (char& c : sentence)
    if (static_cast<unsigned char>(c) < 32 || c == 127) c = ' ';
  constexpr std::size_t longest = 1600, kept_end = 600;
  if (sentence.size() <= longest) return sentence;
  const auto begin_of_letter = [&](std::size_t at) {  // the bytes 10xxxxxx go on with one
    while (at > 0 && (static_cast<unsigned char>(sentence[at]) & 0xC0) == 0x80) --at;
    return at;
  };
  return sentence.substr(0, begin_of_letter(longest - kept_end)) + " ... " + sentence.substr(begin_of_letter(sentence.size() - kept_end));
}

std::string table_label(const std::string& path) { return path.empty() ? "the top of the file" : "[" + path + "]"; }

std::string label(const Parameter& p) {
  return p.table.empty() ? p.key + unit_label(p) : fmt::format("{}{} of {}", p.key, unit_label(p), table_label(p.table));
}

std::string missing(const Parameter& p) {
  const std::string range = p.choices.empty() ? describe(p.range) : fmt::format("of {}", fmt::join(p.choices, ", "));
  const std::string meaning = p.meaning.substr(0, p.meaning.size() - 1);
  return fmt::format("{} is missing ({}); give a value{}{}.", label(p), meaning, range.empty() ? "" : " ", range);
}

std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row.back();
}

std::string nearest(const std::string& text, const std::vector<std::string>& valid) {
  return *std::min_element(valid.begin(), valid.end(),
                           [&](const auto& a, const auto& b) { return edit_distance(text, a) < edit_distance(text, b); });
}

}  // namespace tern
