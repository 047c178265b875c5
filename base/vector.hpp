#pragma once
// Small fixed-size vectors and matrices. D is the space dimension, 2 or 3; 2D quantities are per metre of depth.

#include <Eigen/Dense>

namespace tern {

template <int D>
using Vector = Eigen::Matrix<double, D, 1, Eigen::DontAlign>;

template <int D>
using Matrix = Eigen::Matrix<double, D, D, Eigen::DontAlign>;

}  // namespace tern
