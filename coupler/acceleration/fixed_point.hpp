#pragma once
// Coupling iterations as a fixed point. The structure moves under the load x, the fluid answers that motion with the load H(x); wanted is
// x = H(x). H changes little from window to window: what the iterations of the last windows have shown of it serves the next.

#include <deque>
#include <limits>
#include <vector>

#include <Eigen/Core>

namespace tern::coupler {

class FixedPoint {
 public:
  /// `tolerance`: of |H(x) - x| / |H(x)|; below a hundredth of the largest load of the run, over that. `most`: iterations of a window.
  FixedPoint(double tolerance, int most) : tolerance_(tolerance), most_(most) {}

  /// `gain`: how many times an error of the load may come back in its answer, >= 1. `begin`: of the window, for messages [s].
  void begin_window(double gain, double begin);

  /// Takes note of the answer H(x) [N/m^(3-D)] to the load x; true when no further iteration is wanted. Throws NumericalFailure
  /// when the answer is not finite, or when the last iteration still changes the load by a twentieth.
  /// The last `contacts` components are what contacts push with, none less than 0. An answer to more of a contact exceeds this less, if
  /// all else is the same: loads that were too little or too much for it bound it.
  bool add(const Eigen::VectorXd& load, const Eigen::VectorXd& answer, Eigen::Index contacts = 0);

  /// The load to try next, after add(): where it agrees with its answer by what is known of H. Where that does not come to an end, the
  /// contacts are given, between what has bounded them.
  Eigen::VectorXd next();

  int iterations() const { return iterations_; }           ///< of this window
  double residual() const { return residual_; }            ///< of the last iteration, relative
  bool gives_contacts() const { return gives_contacts_; }  ///< from the last next() on, in this window
  bool converged() const { return residual_ <= tolerance_; }

  /// The list of what it has learnt: visit(name, member of each) for every one.
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("iterations", all.iterations_...);
    visit("gain", all.gain_...);
    visit("largest_gain", all.largest_gain_...);
    visit("begin", all.begin_...);
    visit("residual", all.residual_...);
    visit("largest_answer", all.largest_answer_...);
    visit("base", all.base_...);
    visit("refused", all.refused_...);
    visit("first_load", all.first_load_...);
    visit("first_load_before", all.first_load_before_...);
    visit("expected", all.expected_...);
    visit("unknown", all.unknown_...);
    visit("changes", all.changes_...);
  }

 private:
  /// Of an iteration; or how they change between two iterations of a window.
  struct Outcome {
    Eigen::VectorXd residual, answer;

    /// The list of the members: visit(name, member of each) for every one.
    template <class Visit, class... Same>
    static void for_each_field(Visit&& visit, Same&... all) {
      visit("residual", all.residual...);
      visit("answer", all.answer...);
    }
  };

  /// Of a contact in this window: the last load whose answer exceeded it, and the last that exceeded its answer.
  struct Bounds {
    static constexpr double unknown = std::numeric_limits<double>::infinity();
    double low = 0, residual_low = 0, high = unknown, residual_high = 0;

    bool is_met() const { return residual_low != 0 || residual_high != 0; }  ///< in some iteration
    void add(double load, double residual);
    double estimate() const;  ///< where it agrees with its answer, by the line through both
  };
  struct Given {
    Eigen::Index component;
    double load;
  };

  /// The load that agrees with its answer by what is known of H, these components given.
  Eigen::VectorXd step(const std::vector<Given>& given);

  double tolerance_;
  int most_;
  int iterations_ = 0;
  double gain_ = 1, largest_gain_ = 1, begin_ = 0, residual_ = 0, largest_answer_ = 0;
  Outcome base_;                                    ///< of the iteration that the next is built upon
  bool refused_ = false;                            ///< that is not the last one: it was worse
  Eigen::VectorXd first_load_, first_load_before_;  ///< of this window and of the one before; empty without iterations
  Eigen::VectorXd expected_;                        ///< answer to the next load, by what is known of H
  double unknown_ = 0;                              ///< size of that part of the step to it of which nothing is known
  std::vector<Bounds> bounds_;                      ///< of contacts, in this window
  bool gives_contacts_ = false;                     ///< in this window
  std::deque<std::vector<Outcome>> changes_;        ///< of this window first, then of those before; of each the newest first
};

}  // namespace tern::coupler
