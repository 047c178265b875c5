#pragma once
// How the surface answers a load, learnt. A formula on the section behind a point is wrong wherever an elastic wave, a corner, a shell or a
// foreign solver is behind it. But every window that is tested moves the structure twice, under two loads: the change of the velocity at
// its end over the change of the load is the answer.
//
// Two things are learnt of it. First, how many times as fast as by the guessed masses each lump answers:
//
//   s_a = sum share_ka A_k dw_k w_k / sum share_ka A_k w_k^2        sums over points and windows, four fifths kept per window
//
// dw the change of the normal velocity, w that by lumps of the guessed masses; the least squares fit around the lump. Second, of which
// width the lumps are: a thin plate bends in a window over a length of its own, and answers a push on one point, or on one face, by all of
// it. The widths on trial foretell every window; for each body that one is taken whose errors have been least.

#include <optional>
#include <vector>

#include "coupler/setup.hpp"
#include "coupler/surface_lumps.hpp"
#include "coupler/workspace.hpp"

namespace tern::coupler {

/// What has been learnt of a body, for those who ask. All over the windows of the end.
struct LearntOfBody {
  double width = 0;              ///< of the lumps [m]; 0: points
  double mass_over_formula = 1;  ///< of all lumps together
  double missed = 0,
         missed_by_points = 0;  ///< of the changes of velocity that a load made, root mean square: by these lumps, and by points
};

template <int D>
class LearntResponse {
 public:
  /// Before the first window, and after its state has been taken from a checkpoint.
  void prepare(const Setup<D>& setup, const SurfaceAtStart<D>& start);

  /// From here on for windows of this length [s]. What a lump answers as heavier than one that nothing holds is a stiffness, which counts
  /// by the square of the length.
  void adjust_to(double duration);

  /// `guess`: mass per area with which each point may answer [kg/m^2]; `area`: of the points [m^(D-1)].
  SurfaceAnswer answer(const Setup<D>& setup, const std::vector<double>& guess, const std::vector<double>& area) const;

  /// Learns from the first pass: the surface has moved as window.surface says under the assumed load, and with `velocity` under the answer.
  void learn(const Setup<D>& setup, const Workspace<D>& window, const std::vector<Vector<D>>& velocity);

  /// Of a body; nothing where nothing has been learnt yet.
  std::optional<LearntOfBody> of_body(const Setup<D>& setup, std::size_t body) const;

  /// The list of what it has learnt: visit(name, member of each) for every one.
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("answer", all.answer_...);
    visit("square", all.square_...);
    visit("error", all.error_...);
    visit("changed", all.changed_...);
    visit("duration", all.duration_...);
  }

 private:
  double quickness(std::size_t width, std::size_t lump) const;
  std::size_t best_width(std::size_t body) const;

  std::vector<SurfaceLumps> lumps_;                   ///< of each width
  std::vector<std::vector<std::uint32_t>> body_of_;   ///< by width and lump
  std::vector<double> heaviest_;                      ///< by body: over the guess
  std::vector<std::vector<double>> answer_, square_;  ///< by width and lump: the two sums
  std::vector<std::vector<double>> error_;            ///< by width and body: mean square of what was foretold wrong
  std::vector<double> changed_;                       ///< by body: mean square of what there was to foretell
  double duration_ = 0;                               ///< of the windows for which this is [s]; 0: not known
};

}  // namespace tern::coupler
