#pragma once
// Detects a load that the coupling itself makes: one that turns round from window to window. The kink of the load F in window n is
// a_n = F_n - 2 F_{n-1} + F_{n-2}; a load F + (-1)^n A has the kinks 4 (-1)^n A. Motion that windows resolve has kinks that last. Impacts
// have one pair of opposite kinks. Noise has kinks of correlation -2/3. A harmless vibration that windows do not resolve dies out: of what
// is not in the mean motion of a window the interface keeps 0.8 (structure/coupled_structure.hpp). A load that turns round again and
// again, does not die out and exceeds the load it is laid on, over some windows, for that may pass through zero in one, can only be kept up
// by the coupling: a fluid that can only push would pull in every other window.
// A vibration of less than four windows, but not quite two, does not turn round in each. When nothing else is in the load its kinks follow
// a_{n+1} = 2 r cos(theta) a_n - r^2 a_{n-1}. Explicit staggering makes a motion of the body with pi < omega dt < 2 pi grow like this,
// slowly (docs/THEORY.md, section 3).

#include <deque>

#include <Eigen/Core>

namespace tern::coupler {

class LoadAlternation {
 public:
  /// Takes note of the load of a window. True when the amplitude is at least `least` (in the unit of the load) and one of these holds:
  /// each of the last five kinks was nearly opposite to the one before, the amplitude is the largest of them and exceeds the mean load;
  /// nine kinks were opposite, the amplitude has grown by half every four windows and exceeds a tenth of the mean load; the last sixteen
  /// kinks were those of one vibration of less than four windows, which has doubled since and exceeds the mean load.
  bool add(const Eigen::VectorXd& load, double least);

  double amplitude() const { return amplitude_; }  ///< |A| of the last window
  double mean() const { return mean_; }            ///< |F|, root mean square over the windows kept, of the mean of two in turn; of sixteen
                                                   ///< for a vibration
  const Eigen::VectorXd& kink() const { return kink_; }
  static constexpr int reversals = 4;   ///< that are taken for proof
  static constexpr int vibration = 16;  ///< kinks that are

  /// The list of the members: visit(name, member of each) for every one.
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("last", all.last_...);
    visit("change", all.change_...);
    visit("kink", all.kink_...);
    visit("amplitudes", all.amplitudes_...);
    visit("loads", all.loads_...);
    visit("kink_before", all.kink_before_...);
    visit("second_before", all.second_before_...);
    visit("sums", all.sums_...);
    visit("squares", all.squares_...);
    visit("products", all.products_...);
    visit("second_products", all.second_products_...);
    visit("mean", all.mean_...);
    visit("amplitude", all.amplitude_...);
  }

 private:
  bool is_growing_vibration(double least);

  Eigen::VectorXd last_, change_, kink_, kink_before_, second_before_;
  std::deque<double> amplitudes_;      ///< since the load began to turn round in every window, at most 2 reversals + 1
  std::deque<Eigen::VectorXd> loads_;  ///< the last `vibration` + 2, as the following
  std::deque<double> sums_;            ///< |F_n + F_{n-1}|^2
  std::deque<double> squares_, products_, second_products_;  ///< |a_n|^2, a_n . a_{n-1}, a_n . a_{n-2}
  double mean_ = 0, amplitude_ = 0;
};

}  // namespace tern::coupler
