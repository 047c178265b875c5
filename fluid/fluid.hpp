#pragma once
// The fluid of one scene: incompressible SPH by projection. This class owns the data and is what the processes, gauges and tests see;
// the numerics are free functions in files named after their equation. time_step.cpp is the page to read first.

#include <array>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "fluid/boundary/boundary.hpp"
#include "fluid/domain.hpp"
#include "fluid/gauges/totals.hpp"
#include "fluid/neighbours.hpp"
#include "fluid/pressure/divergence_target.hpp"
#include "fluid/pressure/pressure_system.hpp"
#include "fluid/reference.hpp"
#include "fluid/state.hpp"
#include "fluid/step_proposal.hpp"
#include "fluid/workspace.hpp"
#include "proto/interface.hpp"

namespace tern::fluid {

/// Seconds of wall time by part of the step, since construction.
struct StepTiming {
  double neighbours = 0, boundary = 0, assembly = 0, pressure_solve = 0, correction = 0;
};

struct Energies {
  double kinetic = 0;    ///< [J/m^(3-D)]
  double potential = 0;  ///< minus the work of gravity since t = 0 [J/m^(3-D)]
};

template <int D>
class WholeState;

template <int D>
class Fluid {
 public:
  /// Fills the fluid bodies with particles. Throws BadInput when none results. With several ranks each of them makes one, computes its
  /// own part, and has all functions called with the same arguments as the others.
  explicit Fluid(const Case& scene, const Ranks& ranks = {}) : Fluid(scene, ranks, StartParticles<D>(scene)) {}

  // One window, in this order. Without a structure: empty surface and loads.

  /// Predicts over the window and finds neighbours at its middle.
  void begin_window(Ticks begin, Ticks duration);
  /// The structure's surface at the middle of the window; returns the particles that see it. What crosses the interface is that of all
  /// ranks: all are given it, and the first one returns it.
  InterfaceParticles<D> see_surface(const Surface<D>& surface);
  /// What of the pressure equation does not ask for the load. To be called while others compute that, or left to solve_pressure().
  void prepare_pressure();
  /// Applies the forces already known and solves the pressure Poisson equation. Of a load with velocities of the surface: the
  /// same window once more, with these.
  InterfacePressure<D> solve_pressure(const InterfaceCondition<D>& load);
  /// The velocities of all other particles. To be called while others compute the force on these, or left to end_window().
  void complete_velocity();
  /// Applies the pressure, moves, shifts and settles contacts with walls. Throws NumericalFailure.
  void end_window(const InterfaceForce<D>& force);

  /// One window without a surface: none is in reach, or there is none.
  void pass_window();

  /// Step wanted for the next window.
  StepProposal propose_step() const { return fluid::propose_step(reference_, largest_speed(), largest_speed_in_frame(), state_); }
  /// Of the observer who goes along with the scene: as the wall of wall_of_frame() shifts, or, where there is neither wall nor structure,
  /// as fast as the fluid was on the mean at the start. Nothing where a wall is at rest [m/s].
  std::optional<Vector<D>> frame_velocity() const;
  /// Which surface can be left out of the next window; nothing where the fluid is periodic and has no end.
  std::optional<FluidExtent<D>> extent() const;

  const State<D>& state() const { return state_; }
  /// Goes on from another state, between two windows: of the same scene, possibly of another fluid. The next window rebuilds the rest.
  void set_state(State<D> state) { state_ = std::move(state); }
  /// The same of a state that all ranks know.
  void set_whole_state(State<D> state, const Shares& shares = {});
  /// The state of all ranks, on the first one, and how it is theirs.
  State<D> whole_state() const;
  Shares shares() const { return domain_.shares(state_); }

  // The data, for tests and gauges.
  const Reference<D>& reference() const { return reference_; }
  const Constants<D>& constants() const { return reference_.constants; }
  const Period<D>& period() const { return reference_.period; }
  const Boundary<D>& boundary() const { return boundary_; }
  const Domain<D>& domain() const { return domain_; }
  /// Copies of particles over particles.
  double ghost_share() const { return totals_.particles > 0 ? double(totals_.ghosts) / double(totals_.particles) : 0; }
  /// What a rank says in a window, in the mean of the ranks and of the windows of this process: visit(name, number).
  template <class Visit>
  void for_each_traffic(Visit&& visit) const {
    Traffic::for_each_field(
        [&](const char* name, std::int64_t sum) {
          visit(name, windows_ > 0 ? double(sum) / (double(windows_) * domain_.ranks().count()) : 0);
        },
        totals_.traffic);
  }
  /// With all patches, which are made when they are first asked for where this rank has a part of them.
  const Walls<D>& walls() const { return boundary_.walls.whole() ? boundary_.walls : all_walls().walls; }
  const Neighbours<D>& neighbours() const { return neighbours_; }
  const Corrections<D>& correction() const { return correction_; }
  const Prediction<D>& prediction() const { return prediction_; }
  /// Matrix, right-hand side and solution of the last pressure solve, without the correction for what it left behind.
  const EdgeMatrix& pressure_matrix() const { return system_.matrix; }
  const std::vector<double>& pressure_source() const { return system_.source; }
  const std::vector<double>& pressure_solution() const { return system_.solution; }
  const SolveResult& last_solve() const { return system_.result; }
  /// All faces of walls and of the structure as of the last window, each with its finder.
  std::array<std::pair<const Faces<D>*, const FaceFinder<D>*>, 2> faces() const {
    const std::pair<const Faces<D>*, const FaceFinder<D>*> of_structure{&boundary_.surface, &boundary_.surface_finder};
    if (boundary_.walls.whole()) return {{{&boundary_.seen_walls(), &boundary_.wall_finder}, of_structure}};
    const AllWalls& all = all_walls();
    return {{{all.clipped.none() ? &all.walls.faces() : &all.clipped.faces(), &all.finder}, of_structure}};
  }
  /// Part of sum V w that walls leave open in front of patch k of walls(), without a structure (wetness.hpp).
  double space_before_wall(std::size_t k) const;
  const StepTiming& timing() const { return timing_; }
  Evaluations evaluations() const { return domain_.alone() ? state_.evaluations : totals_.evaluations; }

  // What the state says of itself.
  double window_length() const { return window_.duration; }  ///< of the last window of this process; 0 before it [s]
  /// Whether the state has a pressure: not before the first solve.
  bool has_pressure() const { return state_.has_pressure; }
  std::size_t particles() const { return domain_.alone() ? state_.size() : totals_.particles; }
  std::size_t removed() const { return domain_.alone() ? state_.removed : totals_.removed; }  ///< left the domain
  std::size_t leaked() const { return domain_.alone() ? state_.leaked : totals_.leaked; }     ///< went through a wall or the structure
  int fallback_solves() const { return state_.fallback_solves; }
  /// What the pressure equation cannot obey, from the fluid that is enclosed by walls.
  const EnclosedAccount& sealed() const { return state_.enclosed; }
  Energies energies() const;
  Vector<D> momentum() const;
  Vector<3> angular_momentum() const;
  VolumeDrift volume_drift() const;
  double largest_speed() const;                          ///< [m/s]
  std::optional<double> largest_speed_in_frame() const;  ///< to that observer [m/s]
  std::size_t spray_particles() const;
  /// Pressure at a point, first order; nothing where fewer than half a kernel of fluid is around [Pa].
  std::optional<double> pressure_at(const Vector<D>& x) const;
  /// Height of the free surface on the vertical through x (probe.hpp); nothing where there is no fluid [m].
  std::optional<double> elevation_at(const Vector<D>& x) const;
  Vector<D> gravity_at(double t, const Vector<D>& x) const { return reference_.gravity.at(t, x); }  ///< [m/s^2]

 private:
  /// What gauges look at on a rank that has a part of the walls.
  struct AllWalls {
    explicit AllWalls(Walls<D> whole) : walls(std::move(whole)) {}
    Walls<D> walls;
    FaceFinder<D> finder;
    ClippedWalls<D> clipped;
    std::vector<double> space;  ///< before each of their patches, negative: not known
    std::int64_t window = -1;   ///< as of which they stand and the structure has clipped them
  };
  const AllWalls& all_walls() const;

  friend class WholeState<D>;
  Fluid(const Case& scene, const Ranks& ranks, const StartParticles<D>& start);
  Totals<D> totals_here() const;
  void set_totals();
  Filling filling() const;  ///< by the neighbours of this window
  /// div u* of the particles `only`, or with nullptr of all.
  void compute_divergence(const std::vector<int>* only);
  /// Adds dt f/m to the velocity of the particles at the structure; whether any force is not 0.
  bool push(const std::vector<Vector<D>>& force);
  /// Corrects the pressure for what its equation has left of the divergence.
  void drive_out_what_is_left(const std::vector<double>& reference_pressure, bool first);
  /// Undoes what the last coupling iteration has done to the fluid.
  void return_to_unprojected_velocity(const std::vector<Vector<D>>& surface_velocity);

  State<D> state_;
  Reference<D> reference_;
  Domain<D> domain_;
  bool reports_divergence_;   ///< of the particles at the structure
  bool foretells_interface_;  ///< whether interface_reaction.hpp knows what the scheme gives back

  // Rebuilt every step.
  Window window_;
  Prediction<D> prediction_;
  RowOrder<D> rows_;
  Neighbours<D> neighbours_;
  Boundary<D> boundary_;
  Corrections<D> correction_;
  PackedVelocities<D> packed_;
  std::vector<double> divergence_, density_source_, divergence_target_;  ///< div u*, s, q
  // By the first solve of the window; by its correction in full, with what keeps the particles in order apart; the divergence of either.
  std::vector<Vector<D>> projected_velocity_, corrected_velocity_, ordering_velocity_;
  std::vector<double> projected_divergence_;
  PressureSystem<D> system_;
  std::vector<int> at_structure_;                               ///< particles that see the structure
  std::ptrdiff_t first_at_structure_ = 0;                       ///< number of the first of them among those of all ranks
  bool any_at_structure_ = false;                               ///< of all ranks
  BesideStructure beside_structure_;                            ///< these and their neighbours
  std::vector<Vector<D>> images_;                               ///< of one particle in its walls
  bool pressure_prepared_ = false, velocity_complete_ = false;  ///< by the functions of this name, in this window
  bool velocity_known_ = false;                                 ///< of the pressure that there is: from what these three say

  StepTiming timing_;
  std::optional<Vector<D>> mean_at_start_;  ///< of a fluid without walls and structure that moves then: its mean velocity [m/s]
  Totals<D> totals_;                        ///< where there are several ranks
  Traffic traffic_, traffic_at_begin_;      ///< in the windows of this process; up to the begin of this one
  std::int64_t windows_ = 0;                ///< of this process
  mutable std::unique_ptr<AllWalls> all_walls_;
};

/// For as long as it lives the state of the fluid, on the first rank, is that of all ranks. All ranks gather it with whole_state().
template <int D>
class WholeState {
 public:
  explicit WholeState(Fluid<D>& fluid) : fluid_(fluid), part_(fluid.whole_state()) { std::swap(fluid_.state_, part_); }
  ~WholeState() { std::swap(fluid_.state_, part_); }
  WholeState(const WholeState&) = delete;
  WholeState& operator=(const WholeState&) = delete;

 private:
  Fluid<D>& fluid_;
  State<D> part_;
};

extern template class Fluid<2>;
extern template class Fluid<3>;

}  // namespace tern::fluid
