#pragma once
// Proper messages of every kind for the tests of the channel: 2D, two surface points, three band particles.

#include <vector>

#include "proto/channel.hpp"

namespace tern::proto::samples {

inline void fill(google::protobuf::RepeatedField<double>* field, std::vector<double> values) {
  field->Assign(values.begin(), values.end());
}

inline void account(wire::Account* account, int energies, int gauges) {
  for (int i = 0; i < energies; ++i) account->add_energy(1.5 + i);
  for (int i = 0; i < gauges; ++i) {
    account->add_gauge(i == 0 ? 0 : 2.5);
    account->add_undefined(i == 0);
  }
}

inline wire::Hello hello(wire::Role role) {
  wire::Hello message;
  message.set_case_hash("ab12");
  message.set_dimension(2);
  message.set_particles(10);
  if (role == wire::STRUCTURE) {
    for (int k = 0; k < 2; ++k) message.mutable_surface()->add_body(0);
    fill(message.mutable_surface()->mutable_section_mass(), {4, 5});
    fill(message.mutable_surface()->mutable_impedance(), {7e5, 8e5});
    fill(message.mutable_surface()->mutable_least_mass(), {1, 1});
  }
  message.set_proposed_step_s(role == wire::FLUID ? 1e-3 : 0);
  account(message.mutable_account(), role == wire::FLUID ? 2 : 3, 2);
  return message;
}

inline wire::Message make(Kind kind, wire::Role sender = wire::COUPLER) {
  wire::Message m;
  m.set_sender(sender);
  switch (kind) {
    case Kind::kHello:
      *m.mutable_hello() = hello(sender);
      break;
    case Kind::kWelcome:
      m.mutable_welcome()->set_surface_points(2);
      break;
    case Kind::kBeginWindow:
      m.mutable_begin_window()->set_begin_ticks(100);
      m.mutable_begin_window()->set_duration_ticks(50);
      break;
    case Kind::kSurface:
      fill(m.mutable_surface()->mutable_position(), {0, 0, 0, 1});
      fill(m.mutable_surface()->mutable_velocity(), {0.1, 0.2, 0.3, 0.4});
      fill(m.mutable_surface()->mutable_normal(), {-1, 0, 0.6, 0.8});
      fill(m.mutable_surface()->mutable_area(), {0.5, 0.25});
      if (sender == wire::STRUCTURE) account(m.mutable_surface()->mutable_account(), 3, 2);
      break;
    case Kind::kBand:
      for (int i : {7, 3, 9}) m.mutable_band()->add_id(i);
      fill(m.mutable_band()->mutable_position(), {1, 2, 3, 4, 5, 6});
      fill(m.mutable_band()->mutable_velocity(), {0, 0, 0, 0, -1, 2});
      fill(m.mutable_band()->mutable_mass(), {1, 1, 1});
      fill(m.mutable_band()->mutable_volume(), {0.1, 0.1, 0.1});
      fill(m.mutable_band()->mutable_divergence(), {0, -3, 4});
      break;
    case Kind::kDissipativeLoad:
      fill(m.mutable_dissipative_load()->mutable_force(), {1, 2, 3, 4, 5, 6});
      fill(m.mutable_dissipative_load()->mutable_reference_pressure(), {1e3, -2e3});
      fill(m.mutable_dissipative_load()->mutable_robin_mass(), {2, 3});
      break;
    case Kind::kBandPressure:
      fill(m.mutable_band_pressure()->mutable_pressure(), {1, 2, 3});
      fill(m.mutable_band_pressure()->mutable_velocity(), {1, 2, 3, 4, 5, 6});
      break;
    case Kind::kBandForce:
      fill(m.mutable_band_force()->mutable_force(), {1, 2, 3, 4, 5, 6});
      break;
    case Kind::kWindowDone:
      m.mutable_window_done()->set_proposed_step_s(1e-3);
      m.mutable_window_done()->set_limit("gravity");
      fill(m.mutable_window_done()->mutable_extent()->mutable_low(), {0, 1});
      fill(m.mutable_window_done()->mutable_extent()->mutable_high(), {1, 2});
      m.mutable_window_done()->mutable_extent()->set_largest_speed(3);
      m.mutable_window_done()->mutable_extent()->set_reach(0.1);
      account(m.mutable_window_done()->mutable_account(), 2, 2);
      break;
    case Kind::kSurfaceLoad:
      fill(m.mutable_surface_load()->mutable_force(), {1, 2, 3, 4});
      break;
    case Kind::kSurfaceVelocity:
      fill(m.mutable_surface_velocity()->mutable_velocity(), {0.5, 0.6, 0.7, 0.8});
      break;
    case Kind::kFinish:
      m.mutable_finish();
      break;
    case Kind::kFinished:
      account(m.mutable_finished()->mutable_account(), 2, 2);
      break;
    case Kind::kAbort:
      m.mutable_abort()->set_exit_code(3);
      m.mutable_abort()->set_sentence("J <= 0.");
      break;
    case Kind::BODY_NOT_SET:
      break;
  }
  return m;
}

}  // namespace tern::proto::samples
