#pragma once
// C2 Wendland kernel (Wendland 1995; Dehnen & Aly 2012): w = sigma (1 - q/2)^4 (2q + 1), q = r/h < 2.
// Its gradient is stored as the positive weight g(r) = -w'(r)/r, so that grad_i w_ij = g(r) (r_j - r_i) and r = 0 is harmless.

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tern {

template <int D>
class Kernel {
 public:
  explicit Kernel(double smoothing_length)
      : h_(smoothing_length),
        inverse_h_(1 / smoothing_length),
        sigma_(D == 2 ? 7 / (4 * std::numbers::pi * smoothing_length * smoothing_length)
                      : 21 / (16 * std::numbers::pi * smoothing_length * smoothing_length * smoothing_length)),
        gradient_scale_(5 * sigma_ * inverse_h_ * inverse_h_) {}

  double smoothing_length() const { return h_; }
  double support() const { return 2 * h_; }

  /// w(r) [1/m^D].
  double value(double r) const {
    const double q = r * inverse_h_, s = std::max(0.0, 1 - 0.5 * q), s2 = s * s;
    return sigma_ * s2 * s2 * (2 * q + 1);
  }

  /// -w'(r)/r >= 0 [1/m^(D+2)].
  double gradient_weight(double r) const {
    const double s = std::max(0.0, 1 - 0.5 * r * inverse_h_);
    return gradient_scale_ * s * s * s;
  }

 private:
  double h_, inverse_h_, sigma_, gradient_scale_;
};

}  // namespace tern
