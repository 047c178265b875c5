#pragma once
// The fluid of one scene: incompressible SPH by projection. time_step.cpp is the page to read first; each call there
// lives in a file named after it.

#include <optional>
#include <string>
#include <vector>

#include "base/step_proposal.hpp"
#include "fluid/boundary/boundary.hpp"
#include "fluid/boundary/wall_clipping.hpp"
#include "fluid/boundary/walls.hpp"
#include "fluid/motion/motion.hpp"
#include "fluid/neighbours.hpp"
#include "fluid/period.hpp"
#include "fluid/pressure/conjugate_gradient.hpp"
#include "fluid/pressure/enclosed_regions.hpp"
#include "fluid/pressure/multigrid.hpp"
#include "fluid/state.hpp"
#include "proto/interface.hpp"

namespace tern::fluid {

enum class Flag : std::uint8_t { interior = 0, free_surface = 1, spray = 2 };

/// Seconds of wall time by part of the step, since construction.
struct StepTiming {
  double neighbours = 0, boundary = 0, assembly = 0, pressure_solve = 0, correction = 0;
};

/// How often each term was evaluated, in particles (walls, faces of the structure), since construction. What a case leaves out
/// counts nothing.
struct Evaluations {
  long viscosity = 0, noise_damping = 0, density_source = 0, shifting = 0, moving_walls = 0, structure_surface = 0;
};

struct Energies {
  double kinetic = 0;    ///< [J/m^(3-D)]
  double potential = 0;  ///< minus the work of gravity since t = 0 [J/m^(3-D)]
};

template <int D>
class Fluid {
 public:
  /// Fills the fluid bodies with particles. Throws BadInput when none results.
  explicit Fluid(const Case& scene);

  // One window, in this order. Without a structure: empty surface and loads.

  /// Predicts over the window and finds neighbours at its middle.
  void begin_window(Ticks begin, Ticks duration);
  /// The structure's surface at the middle of the window; returns the particles that see it.
  InterfaceParticles<D> see_surface(const Surface<D>& surface);
  /// What of the pressure equation does not ask for the load. To be called while others compute that, or left to solve_pressure().
  void prepare_pressure();
  /// Applies the forces already known and solves the pressure Poisson equation. Of a load with velocities of the surface: the
  /// same window once more, with these.
  InterfacePressure<D> solve_pressure(const InterfaceCondition<D>& load);
  /// The velocities of all other particles. To be called while others compute the force on the band, or left to end_window().
  void complete_velocity();
  /// Applies the pressure, moves, shifts and settles contacts with walls. Throws NumericalFailure.
  void end_window(const InterfaceForce<D>& force);

  /// One window without a surface: none is in reach, or there is none.
  void pass_window();

  /// Step wanted for the next window.
  StepProposal propose_step() const;
  /// Which surface can be left out of the next window; nothing where the fluid is periodic and has no end.
  std::optional<FluidExtent<D>> extent() const;

  // What the state says of itself.
  const Constants<D>& constants() const { return constants_; }
  const State<D>& state() const { return state_; }
  const std::vector<Flag>& flags() const { return flag_; }
  const SolveResult& last_solve() const { return solve_; }
  /// Whether the state has a pressure: not before the first solve.
  bool has_pressure() const { return !pressure_.empty(); }
  const StepTiming& timing() const { return timing_; }
  const Evaluations& evaluations() const { return evaluations_; }
  Energies energies() const;
  Vector<D> momentum() const;
  /// About the origin; 2D: only the last entry is not 0 [kg m^2/s /m^(3-D)].
  Vector<3> angular_momentum() const;
  /// (current volume of the fluid)/(initial) - 1, from the mean particle number density of interior particles.
  double volume_drift() const;
  std::size_t removed() const { return removed_; }  ///< left the domain
  std::size_t leaked() const { return leaked_; }    ///< went through a wall or the structure
  double largest_speed() const;                     ///< [m/s]
  double largest_bulk_speed() const;                ///< spray left out [m/s]
  std::size_t spray_particles() const;
  /// Pressure at a point, first order; nothing where fewer than half a kernel of fluid is around [Pa].
  std::optional<double> pressure_at(const Vector<D>& x) const;
  /// Height of the free surface on the vertical through x (probe.hpp); nothing where there is no fluid [m].
  std::optional<double> elevation_at(const Vector<D>& x) const;
  /// Largest x of particles that are not spray, plus dx/2 [m].
  double front() const;
  const Walls<D>& walls() const { return walls_; }
  const Period<D>& period() const { return period_; }
  /// Faces of walls and of the structure as of the last window, each with its finder.
  std::array<std::pair<const Faces<D>*, const FaceFinder<D>*>, 2> faces() const {
    return {{{&seen_walls_.faces(), &wall_finder_}, {&surface_, &surface_finder_}}};
  }
  Vector<D> gravity_at(double t, const Vector<D>& x) const;  ///< [m/s^2]
  int fallback_solves() const { return fallback_solves_; }
  /// What the pressure equation cannot obey, from the fluid that is enclosed by walls.
  const SealedAccount& sealed() const { return sealed_account_; }
  /// Matrix, right-hand side and solution of the last pressure solve, for the tests.
  const EdgeMatrix& pressure_matrix() const { return matrix_; }
  const std::vector<double>& pressure_source() const { return source_; }
  const Neighbours<D>& neighbours() const { return neighbours_; }
  /// Replaces the state, for tests and later resumption; the next begin_window() rebuilds the rest.
  void set_state(State<D> state);

 private:
  // time_step.cpp calls these in order; each is in the file of its name.
  void predict();
  void wrap_into_period();
  void sort_by_cell();
  void correct_moments();         // correction_matrix.cpp
  void mark_free_surface();       // free_surface.cpp
  void apply_viscosity();         // viscosity.cpp
  void damp_velocity_noise();     // velocity_noise.cpp
  void compute_divergence();      // divergence.cpp
  void compute_density_source();  // density_source.cpp
  void move_surface_at(const std::vector<Vector<D>>& velocity);
  void assemble_pressure_matrix();  // pressure_poisson.cpp: the rows of all that see no face of the structure
  void assemble_pressure_matrix_at_structure(const InterfaceCondition<D>& load);  // and of the others
  void find_pools_that_yield(const InterfaceCondition<D>& load);
  double missing_support(int i) const;  ///< of a particle's kernel, where it is more than disorder
  void assemble_pressure_row(int i, const InterfaceCondition<D>& load);
  void assemble_pressure_source(const InterfaceCondition<D>& load);  // pressure_poisson.cpp
  /// kappa_ik of a patch that the particle sees with this weight A_k w~_ik [m^(D-2)].
  double yielding(const InterfaceCondition<D>& load, int k, double weight) const;
  void prepare_pressure_solve();    // pressure_poisson.cpp
  void account_for_sealed_fluid();  // sealed.cpp
  void solve_pressure_poisson();    // pressure_poisson.cpp
  enum class Where { at_structure, elsewhere };
  void apply_pressure_gradient(Where where);  // pressure_gradient.cpp
  void settle_wall_contacts();                // wall_contact.cpp
  void shift_particles();                     // shifting.cpp
  void hide_walls_behind_structure();
  void add_images(InterfaceParticles<D>& band);
  void count_leaks(const Faces<D>& faces, const FaceRows& rows);
  void remove_escaped();
  void check_speed();   // speed_limit.cpp
  void check_volume();  // speed_limit.cpp
  double density_time_scale() const;

  Constants<D> constants_;
  std::array<Expression, 3> gravity_expression_;
  bool uniform_gravity_;
  bool reports_divergence_;  ///< of the band
  Vector<D> domain_min_, domain_max_;
  Period<D> period_;
  double gravity_size_ = 0, speed_floor_ = 0;
  double reference_speed_ = 0;      ///< of the scene; 0: not known [m/s]
  int windows_of_collapse_ = 0;     ///< with a step far shorter than the reference speed asks for
  int windows_of_lost_volume_ = 0;  ///< beside bodies, with more or less of it than there can be
  Walls<D> walls_;
  ClippedWalls<D> seen_walls_;
  FaceFinder<D> wall_finder_, surface_finder_;
  std::vector<double> space_before_walls_;  ///< per patch, negative: not known; see boundary.hpp
  Faces<D> surface_;
  std::vector<std::uint8_t> covered_faces_;  ///< of the surface: they stand at a wall
  State<D> state_;
  double begin_s_ = 0, duration_s_ = 0;
  std::size_t initial_particles_ = 0, removed_ = 0, leaked_ = 0;
  double bulk_speed_ = 0;  ///< largest, spray left out, at the begin of the window [m/s]
  double potential_ = 0;
  int fallback_solves_ = 0;
  SolveResult solve_;
  SealedAccount sealed_account_;
  bool enclosed_ = false;  ///< all fluid is sealed between fixed walls: it has no free surface and cannot get one
  StepTiming timing_;
  Evaluations evaluations_;

  // Rebuilt every step.
  CellGrid<D> grid_;
  CellContents contents_;
  std::vector<Vector<D>> predicted_position_, predicted_velocity_, gravity_;  ///< position: at the middle of the window
  Neighbours<D> neighbours_;
  FaceRows wall_rows_, surface_rows_;
  BoundarySums<D> boundary_;
  std::vector<Matrix<D>> correction_;        ///< C = (M - T)^-1, identity for spray
  std::vector<Matrix<D>> fluid_correction_;  ///< C^F = (M^F)^-1 over fluid neighbours alone; 0 where these are too few
  std::vector<std::uint8_t> has_gradient_;   ///< C^F is not 0
  std::vector<double> trace_;                ///< tr M / D in [0, 1]
  std::vector<Flag> flag_;
  std::vector<std::uint8_t> active_;                     ///< unknown of the pressure equation
  std::vector<std::uint8_t> near_surface_, near_spray_;  ///< a neighbour is not interior; is no unknown
  std::vector<std::uint8_t> sum_form_;                   ///< pressure gradient in sum form
  std::vector<Vector<D>> unprojected_velocity_;          ///< u* before a trial
  std::vector<Motion<D>> motion_;                        ///< predicted
  std::vector<std::array<Packed<D>, D>> half_gradient_;  ///< half the velocity gradient, by column; zero where there is none
  std::vector<double> divergence_, density_source_;
  EdgeMatrix matrix_;
  std::vector<double> source_, pressure_;
  Multigrid<D> multigrid_;
  SealedPools pools_;
  SealedPools without_surface_;  ///< what no free surface ties, whether bodies yield to it or not
  std::vector<float> missing_support_;
  std::vector<std::uint8_t> yields_to_level_;  ///< in the sum form, in a pool that bodies tie and no free surface; empty: nowhere
  ConjugateGradientWork work_;
  std::vector<int> band_;                                       ///< particle of each band entry
  bool pressure_prepared_ = false, velocity_complete_ = false;  ///< by the functions of this name, in this window
  std::vector<Vector<D>> images_;                               ///< of one particle in its walls
  // Scratch of the sorting.
  std::vector<Vector<D>> sorted_vectors_;
  std::vector<double> sorted_numbers_;
  std::vector<std::uint32_t> sorted_labels_;
  std::vector<std::uint8_t> sorted_marks_;
};

extern template class Fluid<2>;
extern template class Fluid<3>;

}  // namespace tern::fluid
