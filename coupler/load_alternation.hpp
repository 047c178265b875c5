#pragma once
// Finds a load that staggering makes: one that turns round from window to window. With the load F of window n and its kink
// a_n = F_n - 2 F_{n-1} + F_{n-2}, a load F + (-1)^n A has a_n = 4 (-1)^n A. Motion that windows resolve has kinks that last, impacts have one
// pair of opposite ones, noise has kinks of correlation -2/3. An unresolved vibration that is no danger dies out: of what is
// not in the mean motion of a window the interface keeps 0.8 (structure/coupled_structure.hpp). What turns round again and again,
// does not die out, and is larger than the load that it is laid on (so that a fluid, which can but push, pulls in every other
// window) can only be kept up by the coupling itself.

#include <deque>

#include <Eigen/Core>

namespace tern::coupler {

class LoadAlternation {
 public:
  /// Takes note of the load of a window. True when each of the last five kinks was nearly opposite to the one before, and the amplitude
  /// is the largest of them and exceeds the mean load; or when nine were, and it has grown by half every four windows and exceeds a tenth of
  /// the mean load. In either case it is at least `least` (in the unit of the load).
  bool add(const Eigen::VectorXd& load, double least);

  double amplitude() const { return kink_.norm() / 4; }  ///< |A| of the last window
  double mean() const { return mean_; }                  ///< |F|: of the mean of the last two windows
  const Eigen::VectorXd& kink() const { return kink_; }
  static constexpr int reversals = 4;  ///< that are taken for proof

 private:
  Eigen::VectorXd last_, change_, kink_;
  std::deque<double> amplitudes_;  ///< since the load began to turn round in every window, at most 2 reversals + 1
  double mean_ = 0;
};

}  // namespace tern::coupler
