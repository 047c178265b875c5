// Coupling iterations on maps whose fixed point is known.

#include "coupler/acceleration/fixed_point.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "base/error.hpp"

namespace tern::coupler {
namespace {

using Map = std::function<Eigen::VectorXd(const Eigen::VectorXd&)>;

/// Trials until the map agrees with itself, and the last answer.
int trials_to_agree(FixedPoint& iteration, const Map& map, Eigen::VectorXd& x, double gain = 1) {
  iteration.begin_window(gain, 0);
  for (;;) {
    const Eigen::VectorXd answer = map(x);
    const bool done = iteration.add(x, answer);
    x = done ? answer : iteration.next();
    if (done) return iteration.iterations();
  }
}

/// Explicit coupling of a fluid with a structure of n modes, of which mode k has the mass ratio `ratio`/k: an error of the load
/// comes back multiplied by -ratio/k.
Map modes(double ratio, int n) {
  return [=](const Eigen::VectorXd& x) {
    Eigen::VectorXd answer(n);
    for (int k = 0; k < n; ++k) answer[k] = 1 + ratio / (k + 1) * (1 - x[k]);
    return answer;  // fixed point: 1 everywhere
  };
}

// Optimal fixed relaxation takes 10, 13, 38, 68 and 312 iterations for these. Seen to fail: without the changes of this window.
TEST(FixedPoint, AgreesInFewTrialsAtAnyMassRatio) {
  struct Row {
    double ratio;
    int trials;
  };
  for (const Row& row : {Row{0.5, 8}, {1, 9}, {5, 13}, {10, 16}, {50, 24}}) {
    FixedPoint iteration(1e-6, 50);
    Eigen::VectorXd x = Eigen::VectorXd::Zero(60);
    const int trials = trials_to_agree(iteration, modes(row.ratio, 60), x);
    std::printf("[ ratio %g: %d trials ]\n", row.ratio, trials);
    EXPECT_LE(trials, row.trials) << row.ratio;
    EXPECT_LT((x.array() - 1).abs().maxCoeff(), 2e-6 * 60);
  }
}

// Seen to fail: with the changes of earlier windows dropped at the begin of a window.
TEST(FixedPoint, LearnsFromTheWindowsBefore) {
  FixedPoint iteration(1e-6, 50);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(20);
  const int first = trials_to_agree(iteration, modes(10, 20), x);
  for (int window = 1; window < 5; ++window) {
    const Map moved = [&](const Eigen::VectorXd& y) {
      Eigen::VectorXd shift = Eigen::VectorXd::Constant(20, 0.1 * window);
      return Eigen::VectorXd(modes(10, 20)(y - shift) + shift);
    };
    EXPECT_LE(trials_to_agree(iteration, moved, x), first / 2) << "window " << window;
  }
}

/// Explicit coupling of a light body: five motions give an error back 3 to 300 times, all others 0.3 times; `turn` makes other
/// motions of the five.
Map light_body(int n, double turn) {
  return [=](const Eigen::VectorXd& x) {
    const Eigen::VectorXd error = Eigen::VectorXd::Ones(n) - x;
    Eigen::VectorXd answer = Eigen::VectorXd::Ones(n) + 0.3 * error;
    for (int k = 0; k < 5; ++k) {
      Eigen::VectorXd motion(n);
      for (int i = 0; i < n; ++i) motion[i] = std::cos((k + 0.5 + turn * std::sin(1.0 + k)) * M_PI * (i + 0.5) / n);
      answer += 300 * std::pow(0.32, k) * motion.dot(error) / motion.squaredNorm() * motion;
    }
    return answer;
  };
}

// In every fifth window H is another, as where a particle comes in touch. What is left of a change of an earlier window after the
// newer ones has all of its error. Seen to fail, with 247 trials: with whatever is new by 1e-3 taken, as within a window.
TEST(FixedPoint, TakesFromEarlierWindowsOnlyWhatIsMostlyNew) {
  FixedPoint iteration(1e-4, 50);
  int trials = 0;
  for (int window = 0; window < 20; ++window) {
    Eigen::VectorXd x = Eigen::VectorXd::Constant(40, 0.9);
    for (int i = 0; i < 40; ++i) x[i] += 0.05 * std::sin(1.0 * i * (window + 1));
    trials += trials_to_agree(iteration, light_body(40, window % 5 == 4 ? 0.4 : 0), x, 1000);
  }
  std::printf("[ 20 windows: %d trials ]\n", trials);
  EXPECT_LE(trials, 225);
}

// A light body answers an error of the load with a thousand times as much: the first trials must not.
// Seen to fail: with the rest of the residual taken in full.
TEST(FixedPoint, KeepsItsTrialsNearWhatIsKnownWhereAnErrorComesBackAThousandfold) {
  FixedPoint iteration(1e-6, 50);
  double largest = 0;
  const Map map = [&](const Eigen::VectorXd& x) {
    const Eigen::VectorXd answer = modes(1000, 4)(x);
    largest = std::max(largest, answer.norm());
    return answer;
  };
  Eigen::VectorXd x = Eigen::VectorXd::Constant(4, 0.999);
  trials_to_agree(iteration, map, x, 1000);
  EXPECT_LT(largest, 10);
}

// Seen to fail: with !(residual > tolerance) for "converged" and the check of the size left out.
TEST(FixedPoint, NothingThatIsNotFiniteIsAgreement) {
  for (double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    FixedPoint iteration(1e-2, 50);
    iteration.begin_window(1, 0);
    const Eigen::VectorXd trial = Eigen::VectorXd::Zero(3);
    EXPECT_THROW(iteration.add(trial, Eigen::VectorXd::Constant(3, bad)), NumericalFailure);
  }
}

// Seen to fail: with no limit to the residual of the last trial.
TEST(FixedPoint, StopsWithItsResidualWhenTheSidesNeverAgree) {
  FixedPoint iteration(1e-6, 50);
  int sign = 1;
  const Map map = [&](const Eigen::VectorXd& x) { return Eigen::VectorXd(Eigen::VectorXd::Constant(x.size(), (sign = -sign) * 3.0)); };
  Eigen::VectorXd x = Eigen::VectorXd::Zero(2);
  try {
    trials_to_agree(iteration, map, x);
    FAIL() << "agreed";
  } catch (const NumericalFailure& failure) {
    EXPECT_NE(std::string(failure.what()).find("do not agree on the load after 50 coupling iterations"), std::string::npos)
        << failure.what();
  }
}

// Two contacts that have no answer that agrees with them: one jumps past it, one is met only while it is not assumed. All that does agree
// comes to agreement; the contacts are between the loads that were too little and too much.
// Seen to fail: with contacts never given (no agreement).
TEST(FixedPoint, GivesContactsThatComeToNoAgreement) {
  constexpr int modes_of_load = 20;
  FixedPoint iteration(1e-6, 50);
  const Map load_answer = modes(10, modes_of_load);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(modes_of_load + 2);
  iteration.begin_window(10, 0);
  for (bool done = false; !done;) {
    Eigen::VectorXd answer(x.size());
    answer.head(modes_of_load) = load_answer(x.head(modes_of_load));
    const double first = x[modes_of_load], second = x[modes_of_load + 1];
    answer.tail(2) << (first < 0.4 ? 2.0 : 0.0), (second > 0 ? 0.0 : 1.0);
    if (iteration.gives_contacts()) answer.tail(2) = x.tail(2);
    done = iteration.add(x, answer, 2);
    if (!done) x = iteration.next();
  }
  std::printf("[ %d trials, contacts %g and %g ]\n", iteration.iterations(), x[modes_of_load], x[modes_of_load + 1]);
  EXPECT_TRUE(iteration.converged() && iteration.gives_contacts());
  EXPECT_LT((x.head(modes_of_load).array() - 1).abs().maxCoeff(), 2e-6 * modes_of_load);
  EXPECT_GE(x.tail(2).minCoeff(), 0);
  EXPECT_LE(x.tail(2).maxCoeff(), 2);
}

TEST(FixedPoint, NoLoadOnBothSidesIsAgreementAtOnce) {
  FixedPoint iteration(1e-4, 50);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(5);
  EXPECT_EQ(trials_to_agree(
                iteration, [](const Eigen::VectorXd& y) { return y; }, x),
            1);
}

}  // namespace
}  // namespace tern::coupler
