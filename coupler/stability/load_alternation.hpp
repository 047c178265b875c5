#pragma once
// Finds a load that staggering makes: one that turns round from window to window. With the load F of window n and its kink
// a_n = F_n - 2 F_{n-1} + F_{n-2}, a load F + (-1)^n A has a_n = 4 (-1)^n A. Motion that windows resolve has kinks that last, impacts have one
// pair of opposite ones, noise has kinks of correlation -2/3. An unresolved vibration that is no danger dies out: of what is
// not in the mean motion of a window the interface keeps 0.8 (structure/coupled_structure.hpp). What turns round again and again,
// does not die out, and is larger than the load that it is laid on (so that a fluid, which can but push, pulls in every other
// window) can only be kept up by the coupling itself.
// A vibration of less than four windows that is not quite two of them does not turn round in each. When nothing else is in the load its kinks
// follow a_{n+1} = 2 r cos(theta) a_n - r^2 a_{n-1}; what explicit staggering does to a motion of the body with pi < omega dt < 2 pi
// grows like this, slowly (docs/THEORY.md, section 3).

#include <deque>

#include <Eigen/Core>

namespace tern::coupler {

class LoadAlternation {
 public:
  /// Takes note of the load of a window. True when each of the last five kinks was nearly opposite to the one before, and the amplitude
  /// is the largest of them and exceeds the mean load; or when nine were, and it has grown by half every four windows and exceeds a tenth of
  /// the mean load; or when the last sixteen kinks were those of one vibration of less than four windows, which has doubled since and exceeds
  /// the mean load. In any case it is at least `least` (in the unit of the load).
  bool add(const Eigen::VectorXd& load, double least);

  double amplitude() const { return amplitude_; }  ///< |A| of the last window
  double mean() const { return mean_; }            ///< |F|: of the mean of the last two windows; of sixteen for a vibration
  const Eigen::VectorXd& kink() const { return kink_; }
  static constexpr int reversals = 4;   ///< that are taken for proof
  static constexpr int vibration = 16;  ///< kinks that are

 private:
  bool is_growing_vibration(double least);

  Eigen::VectorXd last_, change_, kink_;
  std::deque<double> amplitudes_;              ///< since the load began to turn round in every window, at most 2 reversals + 1
  std::deque<Eigen::VectorXd> loads_, kinks_;  ///< the last `vibration` + 2
  double mean_ = 0, amplitude_ = 0;
};

}  // namespace tern::coupler
