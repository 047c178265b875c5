#pragma once
// A small case that tests read as it is, or with a piece of its text replaced.

#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "fixtures/scratch_directory.hpp"
#include "scene/case_file.hpp"

namespace tern {

inline constexpr const char* small_case = R"(title = "small"
dimension = 2
end_time = 0.5
gravity = [0, -9.81]
[[wall]]
name = "tank"
container = { box = { min = [0, 0], max = [1, 1] } }
open = ["y_max"]
[fluid]
density = 1000
spacing = 0.05
[[fluid.body]]
shape = { box = { min = [0, 0], max = [0.4, 0.5] } }
[[structure.body]]
name = "plate"
shape = { box = { min = [0.7, -0.1], max = [0.8, 0.5] } }
spacing = 0.025
density = 1100
young_modulus = 1e6
poisson_ratio = 0.4
clamp = [{ box = { min = [0.6, -0.2], max = [0.9, 0] } }]
[[gauge]]
kind = "displacement"
name = "tip"
body = "plate"
at = [0.75, 0.5]
)";

/// The text with one piece of it replaced.
inline std::string replaced(std::string text, const std::string& old_text, const std::string& new_text) {
  const auto at = text.find(old_text);
  EXPECT_NE(at, std::string::npos) << old_text;
  return text.replace(at, old_text.size(), new_text);
}

class CaseFile : public ::testing::Test {
 protected:
  Case read(const std::string& text, const CaseOptions& options = {}) {
    std::ofstream(folder_ / "case.toml") << text;
    return read_case(folder_.path(), options);
  }

  // The small case with one piece of its text replaced.
  static std::string with(const std::string& old_text, const std::string& new_text) { return replaced(small_case, old_text, new_text); }

  std::string sentence(const std::string& text, const CaseOptions& options = {}) {
    try {
      read(text, options);
    } catch (const BadInput& fault) {
      return fault.what();
    }
    return "";
  }

  void expect_refused(const std::string& text, const std::vector<std::string>& parts, const CaseOptions& options = {}) {
    const std::string found = sentence(text, options);
    for (const std::string& part : parts) EXPECT_NE(found.find(part), std::string::npos) << part << "\nin: " << found;
    EXPECT_TRUE(found.ends_with(".") || found.ends_with("?")) << found;
  }

  ScratchDirectory folder_;
};

}  // namespace tern
