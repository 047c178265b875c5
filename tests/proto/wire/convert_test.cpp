// Conversions between interface arrays and wire messages keep every bit, also after serialisation.
// Seen to fail: copying sizeof(double) fewer bytes in put(), swapping mass and volume in from_wire(InterfaceParticles).

#include "proto/wire/convert.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <limits>
#include <random>

namespace tern::proto {
namespace {

constexpr unsigned seed = 20240607;

/// Any finite bit pattern, so that a rounding or a text form on the way would show.
double any_finite(std::mt19937_64& random) {
  for (;;)
    if (const double value = std::bit_cast<double>(random()); std::isfinite(value)) return value;
}

std::vector<double> scalars(std::mt19937_64& random, std::size_t n) {
  std::vector<double> values(n);
  for (double& v : values) v = any_finite(random);
  if (n > 0) values[0] = -0.0;
  if (n > 1) values[1] = std::numeric_limits<double>::denorm_min();
  return values;
}

template <int D>
std::vector<Vector<D>> vectors(std::mt19937_64& random, std::size_t n) {
  std::vector<Vector<D>> values(n);
  for (auto& v : values)
    for (int a = 0; a < D; ++a) v[a] = any_finite(random);
  return values;
}

std::vector<std::uint32_t> labels(std::mt19937_64& random, std::size_t n) {
  std::vector<std::uint32_t> values(n);
  for (auto& v : values) v = static_cast<std::uint32_t>(random());
  return values;
}

void expect_same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i)
    EXPECT_EQ(std::bit_cast<std::uint64_t>(a[i]), std::bit_cast<std::uint64_t>(b[i])) << "entry " << i;
}

template <int D>
void expect_same_bits(const std::vector<Vector<D>>& a, const std::vector<Vector<D>>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i)
    for (int d = 0; d < D; ++d) EXPECT_EQ(std::bit_cast<std::uint64_t>(a[i][d]), std::bit_cast<std::uint64_t>(b[i][d])) << i << "," << d;
}

template <class Wire>
Wire through_bytes(const Wire& message) {
  Wire copy;
  EXPECT_TRUE(copy.ParseFromString(message.SerializeAsString()));
  return copy;
}

template <int D>
void round_trip(std::size_t n) {
  SCOPED_TRACE("seed " + std::to_string(seed) + ", n = " + std::to_string(n));
  std::mt19937_64 random(seed);

  const Surface<D> surface{vectors<D>(random, n), vectors<D>(random, n), vectors<D>(random, n), scalars(random, n)};
  const auto surface2 = from_wire<D>(through_bytes(to_wire(surface)));
  expect_same_bits<D>(surface.position, surface2.position);
  expect_same_bits<D>(surface.velocity, surface2.velocity);
  expect_same_bits<D>(surface.normal, surface2.normal);
  expect_same_bits(surface.area, surface2.area);

  const InterfaceParticles<D> particles{
      labels(random, n),  vectors<D>(random, n), vectors<D>(random, n),     scalars(random, n),    scalars(random, n),
      scalars(random, n), labels(random, n + 2), vectors<D>(random, n + 2), labels(random, n + 3), true};
  const auto back = from_wire<D>(through_bytes(to_wire(particles)));
  EXPECT_EQ(particles.id, back.id);
  expect_same_bits<D>(particles.position, back.position);
  expect_same_bits<D>(particles.velocity, back.velocity);
  expect_same_bits(particles.mass, back.mass);
  expect_same_bits(particles.volume, back.volume);
  expect_same_bits(particles.divergence, back.divergence);
  EXPECT_EQ(particles.image_of, back.image_of);
  expect_same_bits<D>(particles.image_position, back.image_position);
  EXPECT_EQ(particles.covered, back.covered);
  EXPECT_EQ(particles.is_enclosed, back.is_enclosed);

  const InterfaceCondition<D> load{vectors<D>(random, n),
                                   scalars(random, n + 1),
                                   {{2, 0, 1}, scalars(random, 3), scalars(random, n)},
                                   vectors<D>(random, n + 1),
                                   true,
                                   vectors<D>(random, n + 2),
                                   0.01};
  const auto load2 = from_wire<D>(through_bytes(to_wire(load)));
  expect_same_bits<D>(load.force, load2.force);
  expect_same_bits(load.reference_pressure, load2.reference_pressure);
  EXPECT_EQ(load.response.lump, load2.response.lump);
  expect_same_bits(load.response.share, load2.response.share);
  expect_same_bits(load.response.mass, load2.response.mass);
  expect_same_bits<D>(load.surface_velocity, load2.surface_velocity);
  EXPECT_EQ(load.repeats, load2.repeats);
  expect_same_bits<D>(load.answered_change, load2.answered_change);
  EXPECT_EQ(load.answer_tolerance, load2.answer_tolerance);

  const InterfacePressure<D> pressure{scalars(random, n), vectors<D>(random, n)};
  const auto pressure2 = from_wire<D>(through_bytes(to_wire(pressure)));
  expect_same_bits(pressure.pressure, pressure2.pressure);
  expect_same_bits<D>(pressure.velocity, pressure2.velocity);

  const InterfaceForce<D> force{vectors<D>(random, n)};
  expect_same_bits<D>(force.force, from_wire<D>(through_bytes(to_wire(force))).force);
  const SurfaceLoad<D> surface_load{vectors<D>(random, n)};
  expect_same_bits<D>(surface_load.force, from_wire<D>(through_bytes(to_wire(surface_load))).force);

  const std::vector<Vector<D>> velocity = vectors<D>(random, n);
  expect_same_bits<D>(velocity, from_wire<D>(through_bytes(to_wire<D>(velocity))));

  const SurfaceProperties properties{labels(random, n), scalars(random, n), scalars(random, n), scalars(random, n)};
  const auto properties2 = from_wire(through_bytes(to_wire(properties)));
  EXPECT_EQ(properties.body, properties2.body);
  expect_same_bits(properties.section_mass, properties2.section_mass);
  expect_same_bits(properties.impedance, properties2.impedance);
  expect_same_bits(properties.least_mass, properties2.least_mass);
}

TEST(Convert, EveryInterfaceArrayInTwoDimensionsComesBackBitForBit) { round_trip<2>(17); }
TEST(Convert, EveryInterfaceArrayInThreeDimensionsComesBackBitForBit) { round_trip<3>(17); }
TEST(Convert, AnEmptyInterfaceComesBackEmpty) {
  round_trip<2>(0);
  round_trip<3>(0);
}

}  // namespace
}  // namespace tern::proto
