// The quick ones of the extremes; all of them: bench/structure_extremes.cpp.

#include <gtest/gtest.h>

#include "fixtures/extremes.hpp"

namespace tern::structure::testing {
namespace {

// Seen to fail: without the diffusion in the account (open by 0.07), with the diffusion reversed or counted twice, without the check of J
// (energies not finite), without the work of clamps that move, and with the energy of the strain gradient in sym(F^T dF/dX).
TEST(Extremes, AreBoundedOrStopWithAClearMessage) {
  for (const Extreme& extreme : extremes()) {
    if (!extreme.quick) continue;
    const Outcome outcome = run(extreme);
    EXPECT_NE(outcome.verdict, Outcome::Verdict::wrong) << extreme.what << ": " << outcome.text;
  }
}

}  // namespace
}  // namespace tern::structure::testing
