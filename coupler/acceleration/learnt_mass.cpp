#include "coupler/acceleration/learnt_mass.hpp"

#include <algorithm>
#include <cmath>

namespace tern::coupler {
namespace {

constexpr double kept = 0.8;                     ///< of what is known, per window
constexpr double least_change = 0.01;            ///< of a load, over the root mean square of all, that shows something
constexpr double lightest = 0.05, heaviest = 4;  ///< over the guess

}  // namespace

void LearntMass::add(const std::vector<double>& load, const std::vector<double>& acceleration) {
  answer_.resize(load.size(), 0);
  load_.resize(load.size(), 0);
  double squares = 0;
  long wet = 0;
  for (double change : load) squares += change * change, wet += change != 0;
  if (wet == 0) return;
  const double least = least_change * std::sqrt(squares / static_cast<double>(wet));
  for (std::size_t k = 0; k < load.size(); ++k) {
    if (!(std::abs(load[k]) > least)) continue;
    answer_[k] = kept * answer_[k] + acceleration[k] * load[k];
    load_[k] = kept * load_[k] + load[k] * load[k];
  }
}

double LearntMass::at(std::size_t k, double guess) const {
  if (k >= load_.size() || load_[k] == 0) return guess;
  const double inverse = answer_[k] / load_[k];
  return std::clamp(inverse > 0 ? 1 / inverse : heaviest * guess, lightest * guess, heaviest * guess);
}

}  // namespace tern::coupler
