// Every fault of a message is found before its content is used, and named: field, index, value, limit.
// Seen to fail: each check of message_check.cpp was switched off on its own; its row turned red, rows of other checks
// did not. The long messages turned red when a block that fails was skipped, one of many labels when one too few was taken for
// all, the normal when its square was held against a millionth. The fuzz turned red without the length of Surface.normal and
// InterfaceParticles.position, the sign of area and mass, finite positions.

#include "proto/wire/message_check.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "fixtures/message_samples.hpp"

namespace tern::proto {
namespace {

const double nan = std::numeric_limits<double>::quiet_NaN();
const double infinity = std::numeric_limits<double>::infinity();

/// What both ends know after the handshake and one InterfaceParticles of fixtures/message_samples.hpp.
Agreement agreed(wire::Role participant) {
  Agreement agreement;
  remember(samples::make(Kind::kHello, participant), agreement);
  remember(samples::make(Kind::kWelcome), agreement);
  remember(samples::make(Kind::kInterfaceParticles, wire::FLUID), agreement);
  return agreement;
}

struct BodyFault {
  const char* title;
  Kind kind;
  wire::Role sender;
  std::function<void(wire::Message&)> spoil;
  const char* sentence;  ///< part of the fault
};

const BodyFault body_faults[] = {
    {"Hello dimension", Kind::kHello, wire::FLUID, [](auto& m) { m.mutable_hello()->set_dimension(4); },
     "dimension is 4; it must be 2 or 3"},
    {"Hello step not finite", Kind::kHello, wire::FLUID, [](auto& m) { m.mutable_hello()->set_proposed_step_s(nan); },
     "proposed_step_s is nan; it must be finite and 0 or more"},
    {"Hello surface of the fluid", Kind::kHello, wire::FLUID, [](auto& m) { m.mutable_hello()->mutable_surface()->add_body(0); },
     "only the structure has surface points"},
    {"Hello without surface", Kind::kHello, wire::STRUCTURE, [](auto& m) { m.mutable_hello()->clear_surface(); },
     "at least one surface point"},
    {"Hello section mass", Kind::kHello, wire::STRUCTURE, [](auto& m) { m.mutable_hello()->mutable_surface()->set_section_mass(1, 0); },
     "surface.section_mass[1] is 0"},
    {"Hello impedance", Kind::kHello, wire::STRUCTURE, [](auto& m) { m.mutable_hello()->mutable_surface()->set_impedance(0, -1); },
     "surface.impedance[0] is -1"},
    {"Hello least mass", Kind::kHello, wire::STRUCTURE, [](auto& m) { m.mutable_hello()->mutable_surface()->set_least_mass(0, nan); },
     "surface.least_mass[0] is nan"},
    {"Hello lengths", Kind::kHello, wire::STRUCTURE, [](auto& m) { m.mutable_hello()->mutable_surface()->add_impedance(1); },
     "surface.impedance has 3 entries; it must have 2"},
    {"Hello hash too long", Kind::kHello, wire::FLUID, [](auto& m) { m.mutable_hello()->set_case_hash(std::string(257, 'a')); },
     "case_hash has 257 bytes; the limit is 256"},
    {"Hello version too long", Kind::kHello, wire::FLUID, [](auto& m) { m.mutable_hello()->set_version(std::string(257, 'a')); },
     "version has 257 bytes"},
    {"Hello limit too long", Kind::kHello, wire::FLUID, [](auto& m) { m.mutable_hello()->set_limit(std::string(257, 'a')); },
     "limit has 257 bytes"},
    {"Hello section mass length", Kind::kHello, wire::STRUCTURE, [](auto& m) { m.mutable_hello()->mutable_surface()->add_section_mass(1); },
     "surface.section_mass has 3 entries"},
    {"Hello least mass length", Kind::kHello, wire::STRUCTURE, [](auto& m) { m.mutable_hello()->mutable_surface()->add_least_mass(1); },
     "surface.least_mass has 3 entries"},
    {"Welcome version too long", Kind::kWelcome, wire::COUPLER, [](auto& m) { m.mutable_welcome()->set_version(std::string(257, 'a')); },
     "version has 257 bytes"},
    {"Hello undefined gauge with a value", Kind::kHello, wire::FLUID,
     [](auto& m) { m.mutable_hello()->mutable_account()->set_gauge(0, 3); }, "account.gauge[0] is 3 although undefined"},
    {"Hello flags and gauges", Kind::kHello, wire::FLUID, [](auto& m) { m.mutable_hello()->mutable_account()->add_undefined(false); },
     "account.undefined has 3 entries"},
    {"Welcome without points", Kind::kWelcome, wire::COUPLER, [](auto& m) { m.mutable_welcome()->set_surface_points(0); },
     "surface_points is 0; it must be at least 1"},
    {"Welcome of another count", Kind::kWelcome, wire::COUPLER, [](auto& m) { m.mutable_welcome()->set_surface_points(3); },
     "surface_points is 3; it must be 2"},
    {"BeginWindow without duration", Kind::kBeginWindow, wire::COUPLER, [](auto& m) { m.mutable_begin_window()->set_duration_ticks(0); },
     "duration_ticks is 0"},
    {"BeginWindow before the start", Kind::kBeginWindow, wire::COUPLER, [](auto& m) { m.mutable_begin_window()->set_begin_ticks(-1); },
     "begin_ticks is -1"},
    {"BeginWindow too late", Kind::kBeginWindow, wire::COUPLER,
     [](auto& m) { m.mutable_begin_window()->set_begin_ticks((std::int64_t{1} << 53) + 1); }, "between 0 and 2^53"},
    {"Surface position length", Kind::kSurface, wire::STRUCTURE, [](auto& m) { m.mutable_surface()->add_position(0); },
     "position has 5 entries; it must have 4"},
    {"Surface velocity length", Kind::kSurface, wire::STRUCTURE, [](auto& m) { m.mutable_surface()->clear_velocity(); },
     "velocity has 0 entries"},
    {"Surface normal length", Kind::kSurface, wire::STRUCTURE, [](auto& m) { m.mutable_surface()->mutable_normal()->Truncate(2); },
     "normal has 2 entries"},
    {"Surface area length", Kind::kSurface, wire::STRUCTURE, [](auto& m) { m.mutable_surface()->add_area(1); }, "area has 3 entries"},
    {"Surface area not positive", Kind::kSurface, wire::STRUCTURE, [](auto& m) { m.mutable_surface()->set_area(1, 0); },
     "area[1] is 0; it must be finite and above 0"},
    {"Surface position infinite", Kind::kSurface, wire::STRUCTURE, [](auto& m) { m.mutable_surface()->set_position(3, infinity); },
     "position[3] is inf"},
    {"Surface velocity not finite", Kind::kSurface, wire::STRUCTURE, [](auto& m) { m.mutable_surface()->set_velocity(2, nan); },
     "velocity[2] is nan"},
    {"Surface normal not finite", Kind::kSurface, wire::STRUCTURE, [](auto& m) { m.mutable_surface()->set_normal(2, nan); },
     "normal[2] is nan"},
    {"Surface normal not of unit length", Kind::kSurface, wire::STRUCTURE, [](auto& m) { m.mutable_surface()->set_normal(0, -1.00001); },
     "normal of point 0 has length"},
    {"Surface account of another size", Kind::kSurface, wire::STRUCTURE,
     [](auto& m) { m.mutable_surface()->mutable_account()->add_energy(1); }, "account.energy has 4 entries; it must have 3"},
    {"Surface of the coupler with account", Kind::kSurface, wire::COUPLER,
     [](auto& m) { m.mutable_surface()->mutable_account()->add_energy(1); }, "account.energy has 1 entries; it must have 0"},
    {"InterfaceParticles position length", Kind::kInterfaceParticles, wire::FLUID,
     [](auto& m) { m.mutable_interface_particles()->add_position(1); }, "position has 7 entries; it must have 6"},
    {"InterfaceParticles velocity length", Kind::kInterfaceParticles, wire::FLUID,
     [](auto& m) { m.mutable_interface_particles()->add_velocity(1); }, "velocity has 7"},
    {"InterfaceParticles mass length", Kind::kInterfaceParticles, wire::FLUID,
     [](auto& m) { m.mutable_interface_particles()->add_mass(1); }, "mass has 4 entries"},
    {"InterfaceParticles volume length", Kind::kInterfaceParticles, wire::FLUID,
     [](auto& m) { m.mutable_interface_particles()->add_volume(1); }, "volume has 4"},
    {"InterfaceParticles divergence length", Kind::kInterfaceParticles, wire::FLUID,
     [](auto& m) { m.mutable_interface_particles()->add_divergence(1); }, "divergence has 4"},
    {"WindowDone extent length", Kind::kWindowDone, wire::FLUID, [](auto& m) { m.mutable_window_done()->mutable_extent()->add_low(0); },
     "extent.low has 3 entries; it must have 2"},
    {"WindowDone extent upside down", Kind::kWindowDone, wire::FLUID,
     [](auto& m) { m.mutable_window_done()->mutable_extent()->set_low(1, 3); }, "extent.low[1] is 3, above extent.high[1] = 2"},
    {"WindowDone extent not finite", Kind::kWindowDone, wire::FLUID,
     [](auto& m) { m.mutable_window_done()->mutable_extent()->set_high(0, nan); }, "extent.high[0] is nan"},
    {"WindowDone speed negative", Kind::kWindowDone, wire::FLUID,
     [](auto& m) { m.mutable_window_done()->mutable_extent()->set_largest_speed(-1); }, "extent.largest_speed is -1"},
    {"WindowDone reach infinite", Kind::kWindowDone, wire::FLUID,
     [](auto& m) { m.mutable_window_done()->mutable_extent()->set_reach(infinity); }, "extent.reach is inf"},
    {"InterfaceParticles id twice", Kind::kInterfaceParticles, wire::FLUID, [](auto& m) { m.mutable_interface_particles()->set_id(2, 7); },
     "id 7 appears twice"},
    {"InterfaceParticles mass negative", Kind::kInterfaceParticles, wire::FLUID,
     [](auto& m) { m.mutable_interface_particles()->set_mass(1, -1e-9); }, "mass[1] is -1e-09"},
    {"InterfaceParticles volume zero", Kind::kInterfaceParticles, wire::FLUID,
     [](auto& m) { m.mutable_interface_particles()->set_volume(0, 0); }, "volume[0] is 0"},
    {"InterfaceParticles position not finite", Kind::kInterfaceParticles, wire::FLUID,
     [](auto& m) { m.mutable_interface_particles()->set_position(5, nan); }, "position[5] is nan"},
    {"InterfaceParticles velocity not finite", Kind::kInterfaceParticles, wire::FLUID,
     [](auto& m) { m.mutable_interface_particles()->set_velocity(0, -infinity); }, "velocity[0] is -inf"},
    {"InterfaceParticles divergence not finite", Kind::kInterfaceParticles, wire::FLUID,
     [](auto& m) { m.mutable_interface_particles()->set_divergence(2, nan); }, "divergence[2] is nan"},
    {"InterfaceParticles image of no particle", Kind::kInterfaceParticles, wire::FLUID,
     [](auto& m) {
       m.mutable_interface_particles()->add_image_of(3);
       for (int c = 0; c < 2; ++c) m.mutable_interface_particles()->add_image_position(0);
     },
     "image_of[0] is 3, but 3 particles were sent"},
    {"InterfaceParticles images too many", Kind::kInterfaceParticles, wire::FLUID,
     [](auto& m) {
       for (int n = 0; n < 22; ++n) m.mutable_interface_particles()->add_image_of(0);
       for (int n = 0; n < 44; ++n) m.mutable_interface_particles()->add_image_position(0);
     },
     "image_of has 22 entries; the limit is 7 per particle"},
    {"InterfaceParticles image position length", Kind::kInterfaceParticles, wire::FLUID,
     [](auto& m) { m.mutable_interface_particles()->add_image_of(0); }, "image_position has 0"},
    {"InterfaceParticles image position not finite", Kind::kInterfaceParticles, wire::FLUID,
     [](auto& m) {
       m.mutable_interface_particles()->add_image_of(0);
       for (int c = 0; c < 2; ++c) m.mutable_interface_particles()->add_image_position(nan);
     },
     "image_position[0] is nan"},
    {"InterfaceParticles covered point there is not", Kind::kInterfaceParticles, wire::FLUID,
     [](auto& m) { m.mutable_interface_particles()->add_covered(2); },
     "covered[0] is 2; it must be above the one before and below 2, the number of surface points"},
    {"InterfaceParticles covered point twice", Kind::kInterfaceParticles, wire::FLUID,
     [](auto& m) { m.mutable_interface_particles()->add_covered(1), m.mutable_interface_particles()->add_covered(1); },
     "covered[1] is 1; it must be above the one before"},
    {"InterfaceCondition force length", Kind::kInterfaceCondition, wire::COUPLER,
     [](auto& m) { m.mutable_interface_condition()->add_force(1); }, "force has 7 entries; it must have 6"},
    {"InterfaceCondition pressure length", Kind::kInterfaceCondition, wire::COUPLER,
     [](auto& m) { m.mutable_interface_condition()->add_reference_pressure(1); }, "reference_pressure has 3"},
    {"InterfaceCondition lumps of no whole number for each point", Kind::kInterfaceCondition, wire::COUPLER,
     [](auto& m) { m.mutable_interface_condition()->add_lump(0); },
     "lump has 5 entries; it must have as many for each of the 2 surface points"},
    {"InterfaceCondition share length", Kind::kInterfaceCondition, wire::COUPLER,
     [](auto& m) { m.mutable_interface_condition()->add_share(0); }, "share has 5 entries; it must have 4"},
    {"InterfaceCondition more masses than lumps", Kind::kInterfaceCondition, wire::COUPLER,
     [](auto& m) {
       samples::fill(m.mutable_interface_condition()->mutable_lump_mass(), {1, 1, 1, 1, 1});
     },
     "lump_mass has 5 entries; lump names at most 4"},
    {"InterfaceCondition change of the answer length", Kind::kInterfaceCondition, wire::COUPLER,
     [](auto& m) { m.mutable_interface_condition()->add_answered_change(1); },
     "answered_change has 1 entries; it must have 4 (none, or dimension times surface points)"},
    {"InterfaceCondition change of the answer not finite", Kind::kInterfaceCondition, wire::COUPLER,
     [](auto& m) {
       samples::fill(m.mutable_interface_condition()->mutable_answered_change(), {1, nan, 1, 1});
     },
     "answered_change[1] is nan"},
    {"InterfaceCondition lump there is not", Kind::kInterfaceCondition, wire::COUPLER,
     [](auto& m) { m.mutable_interface_condition()->set_lump(2, 2); }, "lump[2] is 2, but 2 masses of lumps were sent"},
    {"InterfaceCondition share negative", Kind::kInterfaceCondition, wire::COUPLER,
     [](auto& m) { m.mutable_interface_condition()->set_share(1, -1); }, "share[1] is -1"},
    {"InterfaceCondition force not finite", Kind::kInterfaceCondition, wire::COUPLER,
     [](auto& m) { m.mutable_interface_condition()->set_force(1, nan); }, "force[1] is nan"},
    {"InterfaceCondition pressure not finite", Kind::kInterfaceCondition, wire::COUPLER,
     [](auto& m) { m.mutable_interface_condition()->set_reference_pressure(1, nan); }, "reference_pressure[1] is nan"},
    {"InterfaceCondition tolerance negative", Kind::kInterfaceCondition, wire::COUPLER,
     [](auto& m) { m.mutable_interface_condition()->set_answer_tolerance(-0.01); }, "answer_tolerance is -0.01; it must be from 0 to 1"},
    {"InterfaceCondition tolerance not finite", Kind::kInterfaceCondition, wire::COUPLER,
     [](auto& m) { m.mutable_interface_condition()->set_answer_tolerance(nan); }, "answer_tolerance is nan"},
    {"InterfaceCondition mass negative", Kind::kInterfaceCondition, wire::COUPLER,
     [](auto& m) { m.mutable_interface_condition()->set_lump_mass(0, -1); }, "lump_mass[0] is -1"},
    {"InterfaceCondition velocity in the first of a window", Kind::kInterfaceCondition, wire::COUPLER,
     [](auto& m) {
       samples::fill(m.mutable_interface_condition()->mutable_surface_velocity(), {0, 0, 0, 0});
     },
     "surface_velocity has 4 entries; it must have 0"},
    {"SurfaceVelocity length", Kind::kSurfaceVelocity, wire::STRUCTURE, [](auto& m) { m.mutable_surface_velocity()->add_velocity(1); },
     "velocity has 5 entries; it must have 4"},
    {"SurfaceVelocity not finite", Kind::kSurfaceVelocity, wire::STRUCTURE,
     [](auto& m) { m.mutable_surface_velocity()->set_velocity(2, nan); }, "velocity[2] is nan"},
    {"InterfacePressure length", Kind::kInterfacePressure, wire::FLUID, [](auto& m) { m.mutable_interface_pressure()->add_pressure(1); },
     "pressure has 4 entries"},
    {"InterfacePressure velocity length", Kind::kInterfacePressure, wire::FLUID,
     [](auto& m) { m.mutable_interface_pressure()->clear_velocity(); }, "velocity has 0 entries"},
    {"InterfacePressure not finite", Kind::kInterfacePressure, wire::FLUID,
     [](auto& m) { m.mutable_interface_pressure()->set_pressure(2, nan); }, "pressure[2] is nan"},
    {"InterfacePressure velocity not finite", Kind::kInterfacePressure, wire::FLUID,
     [](auto& m) { m.mutable_interface_pressure()->set_velocity(4, nan); }, "velocity[4] is nan"},
    {"InterfaceForce length", Kind::kInterfaceForce, wire::COUPLER, [](auto& m) { m.mutable_interface_force()->add_force(1); },
     "force has 7 entries"},
    {"InterfaceForce not finite", Kind::kInterfaceForce, wire::COUPLER, [](auto& m) { m.mutable_interface_force()->set_force(0, nan); },
     "force[0] is nan"},
    {"WindowDone step zero", Kind::kWindowDone, wire::FLUID, [](auto& m) { m.mutable_window_done()->set_proposed_step_s(0); },
     "proposed_step_s is 0"},
    {"WindowDone energy not finite", Kind::kWindowDone, wire::FLUID,
     [](auto& m) { m.mutable_window_done()->mutable_account()->set_energy(1, nan); }, "account.energy[1] is nan"},
    {"WindowDone gauge not finite", Kind::kWindowDone, wire::FLUID,
     [](auto& m) { m.mutable_window_done()->mutable_account()->set_gauge(1, nan); }, "account.gauge[1] is nan"},
    {"WindowDone gauge count", Kind::kWindowDone, wire::FLUID, [](auto& m) { m.mutable_window_done()->mutable_account()->clear_gauge(); },
     "account.gauge has 0 entries; it must have 2"},
    {"WindowDone limit too long", Kind::kWindowDone, wire::FLUID,
     [](auto& m) { m.mutable_window_done()->set_limit(std::string(300, 'x')); }, "limit has 300 bytes"},
    {"SurfaceLoad length", Kind::kSurfaceLoad, wire::COUPLER, [](auto& m) { m.mutable_surface_load()->mutable_force()->Truncate(2); },
     "force has 2 entries; it must have 4"},
    {"SurfaceLoad not finite", Kind::kSurfaceLoad, wire::COUPLER, [](auto& m) { m.mutable_surface_load()->set_force(3, nan); },
     "force[3] is nan"},
    {"Finished energy count", Kind::kFinished, wire::FLUID, [](auto& m) { m.mutable_finished()->mutable_account()->clear_energy(); },
     "account.energy has 0 entries"},
    {"Abort code", Kind::kAbort, wire::COUPLER, [](auto& m) { m.mutable_abort()->set_exit_code(0); }, "exit_code is 0"},
    {"Abort without sentence", Kind::kAbort, wire::COUPLER, [](auto& m) { m.mutable_abort()->clear_sentence(); }, "sentence has 0 bytes"},
    {"no body", Kind::kFinish, wire::COUPLER, [](auto& m) { m.clear_body(); }, "body is missing"},
};

class EveryBodyFault : public testing::TestWithParam<BodyFault> {};

TEST_P(EveryBodyFault, IsFoundAndNamed) {
  const BodyFault& row = GetParam();
  const Agreement agreement = agreed(row.sender == wire::STRUCTURE ? wire::STRUCTURE : wire::FLUID);
  wire::Message message = samples::make(row.kind, row.sender);
  ASSERT_EQ(find_body_fault(message, agreement), "") << row.title << ": the sample must be proper before it is spoilt";
  row.spoil(message);
  const std::string fault = find_body_fault(message, agreement);
  EXPECT_NE(fault.find(row.sentence), std::string::npos) << row.title << ": \"" << fault << "\"";
}

INSTANTIATE_TEST_SUITE_P(MessageCheck, EveryBodyFault, testing::ValuesIn(body_faults), [](const auto& tested) {
  std::string title = tested.param.title;
  std::erase_if(title, [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); });
  return title;
});

TEST(MessageCheck, TheFirstFaultOfALongMessageIsNamedWhereverItLies) {
  constexpr int points = 200;
  Agreement agreement = agreed(wire::FLUID);
  agreement.surface_points = points;
  wire::Message message;
  message.set_sender(wire::COUPLER);
  auto& surface = *message.mutable_surface();
  samples::fill(surface.mutable_area(), std::vector<double>(points, 0.1));
  for (int k = 0; k < points; ++k)
    for (double component : {0.6, -0.8}) {
      surface.add_position(component);
      surface.add_velocity(component);
      surface.add_normal(component);
    }
  ASSERT_EQ(find_body_fault(message, agreement), "");
  for (int k : {0, 1, 63, 64, 130, 191, 192, points - 1}) {
    wire::Message spoilt = message;
    spoilt.mutable_surface()->set_area(k, -1);
    if (k + 1 < points) spoilt.mutable_surface()->set_area(k + 1, -2);
    EXPECT_EQ(find_body_fault(spoilt, agreement), fmt::format("area[{}] is -1; it must be finite and above 0", k));
    spoilt = message;
    spoilt.mutable_surface()->set_velocity(2 * k + 1, infinity);
    EXPECT_EQ(find_body_fault(spoilt, agreement), fmt::format("velocity[{}] is inf; it must be finite", 2 * k + 1));
    spoilt = message;
    spoilt.mutable_surface()->set_normal(2 * k, 0);
    EXPECT_EQ(find_body_fault(spoilt, agreement), fmt::format("normal of point {} has length 0.8; it must be 1 to within 1e-06", k));
  }
}

TEST(MessageCheck, ALabelThatAppearsTwiceIsFoundWhetherLabelsAreCloseOrFarApart) {
  const Agreement agreement = agreed(wire::FLUID);
  for (const std::uint32_t stride : {1u, 1u << 30}) {
    wire::Message message = samples::make(Kind::kInterfaceParticles, wire::FLUID);
    auto& particles = *message.mutable_interface_particles();
    particles.set_id(0, 3 * stride);
    particles.set_id(1, stride);
    particles.set_id(2, 2 * stride);
    EXPECT_EQ(find_body_fault(message, agreement), "");
    particles.set_id(2, 3 * stride);
    EXPECT_EQ(find_body_fault(message, agreement), fmt::format("id {} appears twice; labels must be distinct", 3 * stride));
  }
}

TEST(MessageCheck, OneOfManyLabelsThatAppearsTwiceIsFound) {
  const Agreement agreement = agreed(wire::FLUID);
  constexpr int count = 200;
  wire::Message message = samples::make(Kind::kInterfaceParticles, wire::FLUID);
  auto& particles = *message.mutable_interface_particles();
  for (auto* field : {particles.mutable_position(), particles.mutable_velocity()})
    samples::fill(field, std::vector<double>(2 * count, 1.0));
  for (auto* field : {particles.mutable_mass(), particles.mutable_volume(), particles.mutable_divergence()})
    samples::fill(field, std::vector<double>(count, 1.0));
  for (const std::uint32_t stride : {1u, 3u, 64u, 65u}) {
    particles.clear_id();
    for (int k = 0; k < count; ++k) particles.add_id(5 + stride * static_cast<std::uint32_t>((7 * k) % count));
    ASSERT_EQ(find_body_fault(message, agreement), "");
    for (const int k : {0, 1, 63, 64, 128, count - 1}) {
      wire::Message spoilt = message;
      spoilt.mutable_interface_particles()->set_id((k + 77) % count, particles.id(k));
      EXPECT_EQ(find_body_fault(spoilt, agreement), fmt::format("id {} appears twice; labels must be distinct", particles.id(k)));
    }
  }
}

TEST(MessageCheck, ANormalMayBeOfUnitLengthToWithinAMillionth) {
  const Agreement agreement = agreed(wire::STRUCTURE);
  for (const double excess : {-1.1e-6, -0.9e-6, 0.9e-6, 1.1e-6}) {
    wire::Message message = samples::make(Kind::kSurface, wire::STRUCTURE);
    message.mutable_surface()->set_normal(0, -1 - excess);
    EXPECT_EQ(find_body_fault(message, agreement).empty(), std::abs(excess) < 1e-6) << excess;
  }
}

TEST(MessageCheck, AWindowThatDoesNotBeginWhereTheLastEndedIsFound) {
  Agreement agreement = agreed(wire::FLUID);
  remember(samples::make(Kind::kBeginWindow), agreement);
  const std::string fault = find_body_fault(samples::make(Kind::kBeginWindow), agreement);
  EXPECT_EQ(fault, "begin_ticks is 100; it must be 150, the end of the window before");
}

TEST(MessageCheck, ASurfaceMayBeLeftOutOnlyAfterAnExtentAndByTheCoupler) {
  wire::Message empty = samples::make(Kind::kSurface);
  empty.mutable_surface()->Clear();
  Agreement agreement = agreed(wire::FLUID);
  EXPECT_EQ(find_body_fault(empty, agreement), "position has 0 entries; it must have 4 (dimension times surface points)");
  remember(samples::make(Kind::kWindowDone, wire::FLUID), agreement);
  EXPECT_EQ(find_body_fault(empty, agreement), "");
  wire::Message half = empty;
  half.mutable_surface()->add_area(1);
  EXPECT_EQ(find_body_fault(half, agreement), "area has 1 entries; it must have 0 (one per surface point)");
  empty.set_sender(wire::STRUCTURE);
  EXPECT_NE(find_body_fault(empty, agreement), "");
  wire::Message without = samples::make(Kind::kWindowDone, wire::FLUID);
  without.mutable_window_done()->clear_extent();
  remember(without, agreement);
  empty.set_sender(wire::COUPLER);
  EXPECT_NE(find_body_fault(empty, agreement), "");
}

TEST(MessageCheck, EveryEnvelopeFaultIsFoundAndNamed) {
  const Envelope envelope{wire::FLUID, 5, 17};
  const auto fault = [&](const std::function<void(wire::Message&)>& spoil) {
    wire::Message message = samples::make(Kind::kInterfaceParticles, wire::FLUID);
    message.set_protocol_version(protocol_version);
    message.set_sequence(5);
    message.set_step(17);
    spoil(message);
    return find_envelope_fault(message, envelope, {Kind::kInterfaceParticles, Kind::kInterfacePressure});
  };
  EXPECT_EQ(fault([](auto&) {}), "");
  EXPECT_EQ(fault([](auto& m) { m.set_protocol_version(8); }), "protocol_version is 8; this program speaks version 6");
  EXPECT_EQ(fault([](auto& m) { m.set_sender(wire::STRUCTURE); }), "sender is structure; it must be fluid");
  EXPECT_EQ(fault([](auto& m) { m.set_sender(static_cast<wire::Role>(9)); }), "sender is role 9; it must be fluid");
  EXPECT_NE(fault([](auto& m) { m.set_sequence(4); }).find("sequence is 4; it must be 5"), std::string::npos);
  EXPECT_NE(fault([](auto& m) { m.set_sequence(6); }).find("sequence is 6; it must be 5"), std::string::npos);
  EXPECT_EQ(fault([](auto& m) { m.set_step(16); }), "step is 16; it must be 17");
  EXPECT_EQ(fault([](auto& m) { m.mutable_finish(); }), "body is Finish; it must be InterfaceParticles or InterfacePressure now");
  EXPECT_EQ(fault([](auto& m) { m.clear_body(); }), "body is of no kind that protocol version 6 knows");
  EXPECT_EQ(fault([](auto& m) { m.mutable_begin_window(); }), "step is 17; it must be 18");  // always the next window
  EXPECT_EQ(fault([](auto& m) {
              m.mutable_abort();
              m.set_step(3);
              m.set_protocol_version(8);
            }),
            "");
}

std::string parse_text(const std::string& bytes, wire::Message& message) {
  return parse(std::as_bytes(std::span(bytes.data(), bytes.size())), message);
}

TEST(MessageCheck, ATruncatedMessageIsNotParsed) {
  const std::string whole = samples::make(Kind::kInterfaceParticles, wire::FLUID).SerializeAsString();
  wire::Message message;
  EXPECT_EQ(parse_text(whole, message), "");
  EXPECT_NE(parse_text(whole.substr(0, whole.size() - 3), message).find("truncated"), std::string::npos);
}

TEST(MessageCheck, AnOversizedMessageIsRefusedBeforeItIsParsed) {
  wire::Message message;
  // Never read: the size alone decides.
  const std::byte byte{};
  EXPECT_NE(parse(std::span(&byte, max_message_bytes + 1), message).find("the limit of one message is"), std::string::npos);
}

TEST(MessageCheck, RandomBytesAndFlippedBitsNeverCrashAndPassOnlyWhenProper) {
  constexpr unsigned seed = 4711;
  SCOPED_TRACE("seed " + std::to_string(seed));
  RecordProperty("seed", static_cast<int>(seed));
  std::printf("fuzz seed %u\n", seed);
  std::mt19937 random(seed);
  const Agreement agreement = agreed(wire::STRUCTURE);
  const std::vector<Kind> kinds{Kind::kHello,      Kind::kSurface,           Kind::kInterfaceParticles, Kind::kInterfaceCondition,
                                Kind::kWindowDone, Kind::kInterfacePressure, Kind::kSurfaceLoad,        Kind::kBeginWindow,
                                Kind::kAbort};
  int parsed = 0, refused = 0;
  for (int round = 0; round < 60000; ++round) {
    std::string bytes;
    if (round % 3 == 0) {
      bytes.resize(random() % 200);
      for (char& c : bytes) c = static_cast<char>(random());
    } else {
      const Kind kind = kinds[random() % kinds.size()];
      bytes = samples::make(kind, kind == Kind::kSurface ? wire::STRUCTURE : wire::FLUID).SerializeAsString();
      for (unsigned flips = 1 + random() % 4; flips > 0; --flips) bytes[random() % bytes.size()] ^= static_cast<char>(1 << (random() % 8));
      if (random() % 4 == 0) bytes.resize(random() % bytes.size());
    }
    wire::Message message;
    if (!parse_text(bytes, message).empty()) continue;
    ++parsed;
    if (!find_body_fault(message, agreement).empty()) {
      ++refused;
      continue;
    }
    // What passed may be used without another look: here, the arrays a solver would read.
    if (message.has_surface()) {
      const auto& surface = message.surface();
      ASSERT_EQ(surface.normal_size(), 4);
      for (double area : surface.area()) ASSERT_TRUE(std::isfinite(area) && area > 0);
      for (double x : surface.position()) ASSERT_TRUE(std::isfinite(x));
    }
    if (message.has_interface_particles()) {
      ASSERT_EQ(message.interface_particles().position_size(), 2 * message.interface_particles().id_size());
      for (double mass : message.interface_particles().mass()) ASSERT_TRUE(std::isfinite(mass) && mass > 0);
    }
  }
  EXPECT_GT(parsed, 1000);  // the fuzz reaches the checks behind the parser
  EXPECT_GT(refused, 1000);
}

}  // namespace
}  // namespace tern::proto
