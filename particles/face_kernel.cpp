#include "particles/face_kernel.hpp"

#include <array>

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

/// Coefficients a, b for which (a + b s) f reproduces two target values, given the moments of f and s f.
std::array<double, 2> fit(double f0, double g0, double target0, double f1, double g1, double target1) {
  const double determinant = f0 * g1 - f1 * g0;
  return {(target0 * g1 - target1 * g0) / determinant, (f0 * target1 - f1 * target0) / determinant};
}

}  // namespace

template <int D>
FaceKernel<D>::FaceKernel(const Kernel<D>& kernel, double spacing)
    : kernel_(kernel), support_(kernel.support()), table_scale_((table_size - 1) / kernel.support()) {
  const LatticeSums reference = lattice_sums<D>(kernel, spacing);
  const double volume = std::pow(spacing, D);
  const int reach = static_cast<int>(std::ceil(support_ / spacing));

  // Per layer (0: the one resting on the plane, 1: the next): what the continued lattice behind the plane contributes,
  // and what the continuum contributes with weight 1 and with weight s.
  struct Layer {
    double surface = 0, density = 0, moment = 0;
    std::array<double, 2> surface_plane{}, density_cap{}, moment_cap{};
  };
  std::array<Layer, 2> layers;
  const auto w = [&](double s) { return kernel_.value(s); };
  const auto m = [&](double s) { return kernel_.gradient_weight(s) * s * s / reference.gradient_moment; };
  for (int l = 0; l < 2; ++l) {
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
    for (int power = 0; power < 2; ++power) {
      const auto weighted = [&](auto f, double s) { return power == 0 ? f(s) : s * f(s); };
      const double radius = std::sqrt(support_ * support_ - y * y);
      layer.surface_plane[power] = integral(0, radius, [&](double rho) {
        return weighted(w, std::hypot(rho, y)) * (D == 2 ? 2 : 2 * std::numbers::pi * rho);
      });
      const auto cap = [&](auto f) {
        return integral(y, support_, [&](double s) { return weighted(f, s) * std::pow(s, D - 1) * cap_angle<D>(y, s); });
      };
      layer.density_cap[power] = cap(w);
      layer.moment_cap[power] = cap(m);
    }
  }
  const auto calibrate = [&](auto values, auto moments) {
    return fit((layers[0].*moments)[0], (layers[0].*moments)[1], layers[0].*values, (layers[1].*moments)[0],
               (layers[1].*moments)[1], layers[1].*values);
  };
  const auto surface = calibrate(&Layer::surface, &Layer::surface_plane);
  const auto density = calibrate(&Layer::density, &Layer::density_cap);
  const auto moment = calibrate(&Layer::moment, &Layer::moment_cap);
  surface_a_ = surface[0];
  surface_b_ = surface[1];

  // Tables from the outside in: value at r = integral from r to the support.
  density_.assign(table_size, 0);
  moment_.assign(table_size, 0);
  constexpr int substeps = 8;
  for (int k = table_size - 2; k >= 0; --k) {
    density_[k] = density_[k + 1];
    moment_[k] = moment_[k + 1];
    const double step = 1 / (table_scale_ * substeps);
    for (int sub = 0; sub < substeps; ++sub) {
      const double s = k / table_scale_ + (sub + 0.5) * step;
      const double shell = std::pow(s, D - 1) * step;
      density_[k] += w(s) * (density[0] + density[1] * s) * shell;
      moment_[k] += m(s) * (moment[0] + moment[1] * s) * shell;
    }
  }
}

template class FaceKernel<2>;
template class FaceKernel<3>;

}  // namespace tern
