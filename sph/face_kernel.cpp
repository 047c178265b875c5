#include "sph/face_kernel.hpp"

#include <array>

#include <Eigen/LU>

namespace tern {
namespace {

constexpr int table_size = 2048;
constexpr int quadrature = 4000;

/// Integral of f over [begin, end] by the midpoint rule.
template <class F>
double integral(double begin, double end, F f) {
  const double step = (end - begin) / quadrature;
  double sum = 0;
  for (int k = 0; k < quadrature; ++k) sum += f(begin + (k + 0.5) * step);
  return sum * step;
}

/// Solid angle of the cap of a sphere of radius s cut off by a plane at distance y < s.
template <int D>
double cap_angle(double y, double s) {
  return D == 2 ? 2 * std::acos(y / s) : 2 * std::numbers::pi * (1 - y / s);
}

/// A layer is calibrated if it lies this deep in the support or less; farther out its own sums are too small to fit.
constexpr double deepest_layer = 0.9;

}  // namespace

template <int D>
FaceKernel<D>::FaceKernel(const Kernel<D>& kernel, double spacing)
    : kernel_(kernel), spacing_(spacing), support_(kernel.support()), table_scale_((table_size - 1) / kernel.support()) {
  const LatticeSums reference = lattice_sums<D>(kernel, spacing);
  const double volume = std::pow(spacing, D);
  const int reach = static_cast<int>(std::ceil(support_ / spacing));

  // Per layer (0: the one resting on the plane, 1: the next, ...): what the continued lattice behind the plane contributes,
  // and what the continuum contributes with weights 1, s, s^2.
  struct Layer {
    double surface = 0, density = 0, moment = 0;
    std::array<double, terms> surface_plane{}, density_cap{}, moment_cap{};
  };
  std::array<Layer, terms> layers;
  int count = 0;
  while (count < terms && (count + 0.5) * spacing < deepest_layer * support_) ++count;
  const auto w = [&](double s) { return kernel_.value(s); };
  const auto m = [&](double s) { return kernel_.gradient_weight(s) * s * s / reference.gradient_moment; };
  for (int l = 0; l < count; ++l) {
    Layer& layer = layers[l];
    const double y = (l + 0.5) * spacing;
    for (int k = D == 3 ? -reach : 0; k <= (D == 3 ? reach : 0); ++k)
      for (int i = -reach; i <= reach; ++i)
        for (int j = -reach; j < -l; ++j) {
          const double r = spacing * std::sqrt(double(i * i + j * j + k * k));
          const double gradient = volume * kernel.gradient_weight(r) / reference.gradient_moment;
          layer.density += volume * kernel.value(r);
          layer.moment += gradient * r * r;
          layer.surface += gradient * -j * spacing;
        }
    for (int power = 0; power < count; ++power) {
      const auto weighted = [&](auto f, double s) { return std::pow(s, power) * f(s); };
      const double radius = std::sqrt(support_ * support_ - y * y);
      layer.surface_plane[power] =
          integral(0, radius, [&](double rho) { return weighted(w, std::hypot(rho, y)) * (D == 2 ? 2 : 2 * std::numbers::pi * rho); });
      const auto cap = [&](auto f) {
        return integral(y, support_, [&](double s) { return weighted(f, s) * std::pow(s, D - 1) * cap_angle<D>(y, s); });
      };
      layer.density_cap[power] = cap(w);
      layer.moment_cap[power] = cap(m);
    }
  }
  const auto calibrate = [&](auto values, auto moments) {
    Eigen::MatrixXd matrix(count, count);
    Eigen::VectorXd target(count);
    for (int l = 0; l < count; ++l) {
      target[l] = layers[l].*values;
      for (int power = 0; power < count; ++power) matrix(l, power) = (layers[l].*moments)[power];
    }
    const Eigen::VectorXd solution = matrix.fullPivLu().solve(target);
    Polynomial polynomial{};
    for (int power = 0; power < count; ++power) polynomial[power] = solution[power];
    return polynomial;
  };
  surface_ = calibrate(&Layer::surface, &Layer::surface_plane);
  const Polynomial density = calibrate(&Layer::density, &Layer::density_cap);
  const Polynomial moment = calibrate(&Layer::moment, &Layer::moment_cap);

  // Tables from the outside in: value at r = integral from r to the support.
  density_.assign(table_size + 1, 0);
  moment_.assign(table_size + 1, 0);
  beyond_.assign(table_size + 1, 0);
  constexpr int substeps = 8;
  for (int k = table_size - 2; k >= 0; --k) {
    density_[k] = density_[k + 1];
    moment_[k] = moment_[k + 1];
    beyond_[k] = beyond_[k + 1];
    const double step = 1 / (table_scale_ * substeps);
    for (int sub = 0; sub < substeps; ++sub) {
      const double s = k / table_scale_ + (sub + 0.5) * step;
      const double shell = std::pow(s, D - 1) * step;
      density_[k] += w(s) * evaluate(density, s) * shell;
      moment_[k] += m(s) * evaluate(moment, s) * shell;
      beyond_[k] += w(s) * evaluate(surface_, s) * shell;
    }
  }
  cones_ = {static_cast<float>(1 / kernel.smoothing_length()),
            static_cast<float>(kernel.value(0)),
            static_cast<float>(kernel.gradient_weight(0)),
            static_cast<float>(table_scale_),
            static_cast<float>(support_),
            static_cast<float>(-spacing * spacing / 24),
            {static_cast<float>(surface_[0]), static_cast<float>(surface_[1]), static_cast<float>(surface_[2])},
            std::vector<float>(beyond_.begin(), beyond_.end())};
  if constexpr (D == 3) {
    plane_.assign(table_size + 1, {});
    double surface1 = 0, density1 = 0, density2 = 0, moment_inverse = 0, moment1 = 0, moment2 = 0;  // by the power of s
    for (int k = table_size - 2; k >= 0; --k) {
      const double step = 1 / (table_scale_ * substeps), y = k / table_scale_;
      for (int sub = 0; sub < substeps; ++sub) {
        const double s = y + (sub + 0.5) * step;
        const double f = w(s) * evaluate(density, s) * step, g = m(s) * evaluate(moment, s) * step;
        surface1 += w(s) * evaluate(surface_, s) * s * step;
        density1 += f * s, density2 += f * s * s;
        moment_inverse += g / s, moment1 += g * s, moment2 += g * s * s;
      }
      const double turn = 2 * std::numbers::pi, normal = turn / 3 * (moment2 - y * y * y * moment_inverse);
      plane_[k] = {turn * (density2 - y * density1), normal, 0.5 * (turn * (moment2 - y * moment1) - normal), turn * surface1};
    }
  }
}

template class FaceKernel<2>;
template class FaceKernel<3>;

}  // namespace tern
