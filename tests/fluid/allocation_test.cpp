// A step allocates no memory once its arrays have grown. operator new of this whole executable counts while it is told to.

#include <cstdlib>
#include <new>

#include <gtest/gtest.h>

#include "fixtures/fluid_scenes.hpp"

namespace {

bool counting = false;
int allocations = 0;
std::size_t allocated_bytes = 0;

void* allocate(std::size_t size, std::size_t alignment) {
  allocations += counting;
  allocated_bytes += counting ? size : 0;
  void* memory = std::aligned_alloc(alignment, (size + alignment - 1) / alignment * alignment);
  if (!memory) throw std::bad_alloc();
  return memory;
}

}  // namespace

// Not inlined: else the compiler sees memory of operator new go to free().
[[gnu::noinline]] void* operator new(std::size_t size) { return allocate(size, alignof(std::max_align_t)); }
[[gnu::noinline]] void* operator new(std::size_t size, std::align_val_t alignment) {
  return allocate(size, static_cast<std::size_t>(alignment));
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }

namespace tern::fluid::testing {
namespace {

/// Allocations of ten steps of water at rest in a tank with a block that hides part of the walls. (Water that spreads needs
/// ever larger grids.)
template <int D>
int allocations_in_ten_steps(double spacing) {
  const double depth = D == 3 ? 0.1 : 0;
  Fluid<D> fluid(scene(D, spacing, {box({0, 0, 0}, {0.1, 0.2, depth}), box({0.1, 0.0625, 0}, {0.125, 0.2, depth})},
                       {tank({0, 0, 0}, {0.125, 0.5, depth}), obstacle({0.1, 0, 0}, {0.125, 0.0625, depth})}));
  std::mt19937 random(20240119);
  jitter(fluid, 0.05, random);
  for (int k = 0; k < 20; ++k) step(fluid, 5e-4);
  allocations = 0;
  for (int k = 0; k < 10; ++k) {
    counting = true;
    step(fluid, 5e-4);
    counting = false;
  }
  return allocations;
}

// Seen to fail: 440 and 1680 allocations with new scratch for every search among patches.
TEST(FluidStep, AllocatesNothingOnceItsArraysHaveGrown) {
  EXPECT_EQ(allocations_in_ten_steps<2>(0.005), 0);
  EXPECT_EQ(allocations_in_ten_steps<3>(0.0125), 0);
}

/// Bytes allocated by the first step of a tank of water, with all optional terms off but for what `change` switches on.
template <class Change>
std::size_t bytes_of_a_step(Change&& change) {
  Case c = scene(2, 0.005, {box({0, 0, 0}, {0.1, 0.2, 0})}, {tank({0, 0, 0}, {0.1, 0.5, 0})});
  c.fluid->numerics.noise_damping = c.fluid->numerics.density_relaxation = c.fluid->numerics.shifting = 0;
  change(*c.fluid);
  Fluid<2> fluid(c);
  allocated_bytes = 0;
  counting = true;
  step(fluid, 5e-4);
  counting = false;
  return allocated_bytes;
}

// Seen to fail: with the source of the density sized and computed although its coefficient is 0.
TEST(FluidStep, HasNoArraysForATermThatIsOff) {
  bytes_of_a_step([](FluidCase&) {});  // the first fluid of a process makes scratch that the others find
  const std::size_t plain = bytes_of_a_step([](FluidCase&) {}), particles = 800, number = sizeof(double);
  EXPECT_GE(bytes_of_a_step([](FluidCase& f) { f.numerics.density_relaxation = 0.02; }), plain + particles * number);
  // These three take their sums from arrays that every step has.
  EXPECT_EQ(bytes_of_a_step([](FluidCase& f) { f.numerics.noise_damping = 0.2; }), plain);
  EXPECT_EQ(bytes_of_a_step([](FluidCase& f) { f.numerics.shifting = 0.5; }), plain);
  EXPECT_EQ(bytes_of_a_step([](FluidCase& f) { f.viscosity = 1; }), plain);
}

}  // namespace
}  // namespace tern::fluid::testing
