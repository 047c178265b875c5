#pragma once
// Fluid and structure as a window sees them, be they objects of this process or processes of their own (process/remote_participants.hpp).

#include <optional>
#include <vector>

#include "base/time.hpp"
#include "coupler/stability/observations.hpp"
#include "proto/interface.hpp"

namespace tern::coupler {

/// In the order of the calls.
template <int D>
class Participants {
 public:
  virtual ~Participants() = default;

  virtual void begin_window(Ticks begin, Ticks duration) = 0;
  /// The structure at the end of the window under the load of the last one; position, normal and area halfway there.
  virtual Surface<D> predict_surface(Ticks begin, Ticks duration) = 0;
  /// At the begin of the window; empty where a side keeps no account, or somebody else gives the fluid energy.
  virtual std::optional<Energies> energies() const { return std::nullopt; }
  /// Where the fluid was at the end of the last window; empty where it does not say.
  virtual std::optional<FluidExtent<D>> extent() const = 0;
  /// The fluid ends a window without surface.
  virtual void pass_window() = 0;
  virtual InterfaceParticles<D> see_surface(const Surface<D>& surface) = 0;
  virtual InterfacePressure<D> solve_pressure(const InterfaceCondition<D>& condition) = 0;
  /// The structure makes the window once more under this load: velocities of the surface at its end.
  virtual std::vector<Vector<D>> respond(const SurfaceLoad<D>& load) = 0;
  /// The fluid ends the window.
  virtual void end_window(const InterfaceForce<D>& force) = 0;
  /// The structure ends the window.
  virtual void apply(const SurfaceLoad<D>& load) = 0;
};

/// Two objects of this process with the functions of Participants (fluid/fluid.hpp, structure/coupled_structure.hpp).
template <int D, class FluidSide, class StructureSide>
class LocalParticipants final : public Participants<D> {
 public:
  LocalParticipants(FluidSide& fluid, StructureSide& structure) : fluid_(fluid), structure_(structure) {}

  void begin_window(Ticks begin, Ticks duration) override { fluid_.begin_window(begin, duration); }
  Surface<D> predict_surface(Ticks begin, Ticks duration) override { return structure_.predict_surface(begin, duration); }
  std::optional<FluidExtent<D>> extent() const override { return fluid_.extent(); }
  void pass_window() override { fluid_.pass_window(); }
  InterfaceParticles<D> see_surface(const Surface<D>& surface) override { return fluid_.see_surface(surface); }
  InterfacePressure<D> solve_pressure(const InterfaceCondition<D>& condition) override { return fluid_.solve_pressure(condition); }
  std::vector<Vector<D>> respond(const SurfaceLoad<D>& load) override { return structure_.respond(load); }
  void end_window(const InterfaceForce<D>& force) override { fluid_.end_window(force); }
  void apply(const SurfaceLoad<D>& load) override { structure_.apply(load); }

 private:
  FluidSide& fluid_;
  StructureSide& structure_;
};

}  // namespace tern::coupler
