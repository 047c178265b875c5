#pragma once
// A small case that tests read as it is, or with a piece of its text replaced.

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "base/error.hpp"
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

class CaseFile : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() / ("tern_case_file_test_" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  Case read(const std::string& text, const CaseOptions& options = {}) {
    std::ofstream(folder_ / "case.toml") << text;
    return read_case(folder_.string(), options);
  }

  // The small case with one piece of its text replaced.
  static std::string with(const std::string& old_text, const std::string& new_text) {
    std::string text = small_case;
    const auto at = text.find(old_text);
    EXPECT_NE(at, std::string::npos) << old_text;
    return text.replace(at, old_text.size(), new_text);
  }

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

  std::filesystem::path folder_;
};

}  // namespace tern
