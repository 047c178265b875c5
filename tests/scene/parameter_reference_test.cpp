// The document of all keys.

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "scene/parameter_table.hpp"

namespace tern {
namespace {

// Seen to fail with a key added to the table and the document left as it was.
TEST(ParameterReference, IsTheCommittedDocument) {
  std::ifstream file(TERN_SOURCE_DIR "/docs/PARAMETERS.md");
  std::stringstream text;
  text << file.rdbuf();
  EXPECT_EQ(text.str(), parameter_reference()) << "Run: tern-case parameters > docs/PARAMETERS.md";
}

}  // namespace
}  // namespace tern
