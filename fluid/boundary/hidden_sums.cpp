#include "fluid/boundary/hidden_sums.hpp"

#include <algorithm>

namespace tern::fluid {
namespace {

constexpr int batch = 64;  ///< faces computed at a time, one array per quantity
constexpr int lanes = 4;   ///< of a vector register: batches are filled up to a whole number of it

/// Quantities of the faces of a batch.
template <int D>
struct FaceBatch {
  double direction[D][batch], normal[D][batch];                       ///< direction: vector to the face, then e
  double area[batch], wet[batch], speed[batch], acceleration[batch];  ///< speed: along the normal
  double weight[batch], density[batch], moment[batch], along_normal[batch];
};

template <int D>
void fill_batch(double support, const Vector<D>& x, const Faces<D>& faces, const FaceRows& rows, const int* entry, int n, FaceBatch<D>& b) {
  for (int m = 0; m < n; ++m) {
    const int k = rows.face[entry[m]];
    for (int c = 0; c < D; ++c) b.direction[c][m] = faces.position[k][c] - x[c], b.normal[c][m] = faces.normal[k][c];
    b.area[m] = faces.area[k];
    b.wet[m] = rows.wet.empty() ? 1 : rows.wet[k];
    b.speed[m] = faces.velocity_of(k).dot(faces.normal[k]);
    b.acceleration[m] = faces.acceleration_of(k);
  }
  // Faces as far away as can be, with nothing hidden.
  for (int m = n; m % lanes != 0; ++m) {
    for (int c = 0; c < D; ++c) b.direction[c][m] = c == 0 ? support : 0, b.normal[c][m] = c == 0 ? -1 : 0;
    b.area[m] = b.wet[m] = b.speed[m] = b.acceleration[m] = 0;
  }
}

/// Adds a batch of n faces, `n` a whole number of lanes.
template <int D>
void add_batch(const FaceBatch<D>& b, int n, HiddenSums<D>& sums) {
  if constexpr (D == 2) {
    const double *x = b.direction[0], *y = b.direction[1], *nx = b.normal[0], *ny = b.normal[1];
    double density = 0, flux = 0, gx = 0, gy = 0, mxx = 0, mxy = 0, myy = 0, axx = 0, axy = 0, ayx = 0, ayy = 0, cx = 0, cy = 0;
#pragma omp simd reduction(+ : density, flux, gx, gy, mxx, mxy, myy, axx, axy, ayx, ayy, cx, cy)
    for (int m = 0; m < n; ++m) {
      density += b.density[m];
      flux += b.weight[m] * b.speed[m];
      gx += b.weight[m] * nx[m], gy += b.weight[m] * ny[m];
      const double mx = b.moment[m] * x[m], my = b.moment[m] * y[m], ax = b.along_normal[m] * mx, ay = b.along_normal[m] * my;
      mxx += mx * x[m], mxy += mx * y[m], myy += my * y[m];
      axx += ax * nx[m], axy += ax * ny[m], ayx += ay * nx[m], ayy += ay * ny[m];
      cx += b.acceleration[m] * ax, cy += b.acceleration[m] * ay;
    }
    sums.density += density;
    sums.flux += flux;
    sums.gradient += Vector<D>(gx, gy);
    sums.moment += (Matrix<D>() << mxx, mxy, mxy, myy).finished();
    sums.across += (Matrix<D>() << axx, axy, ayx, ayy).finished();
    sums.accelerated += Vector<D>(cx, cy);
  } else {
    const double *x = b.direction[0], *y = b.direction[1], *z = b.direction[2];
    const double *nx = b.normal[0], *ny = b.normal[1], *nz = b.normal[2];
    double density = 0, flux = 0, gx = 0, gy = 0, gz = 0, mxx = 0, mxy = 0, mxz = 0, myy = 0, myz = 0, mzz = 0;
#pragma omp simd reduction(+ : density, flux, gx, gy, gz, mxx, mxy, mxz, myy, myz, mzz)
    for (int m = 0; m < n; ++m) {
      density += b.density[m];
      flux += b.weight[m] * b.speed[m];
      gx += b.weight[m] * nx[m], gy += b.weight[m] * ny[m], gz += b.weight[m] * nz[m];
      const double mx = b.moment[m] * x[m], my = b.moment[m] * y[m], mz = b.moment[m] * z[m];
      mxx += mx * x[m], mxy += mx * y[m], mxz += mx * z[m];
      myy += my * y[m], myz += my * z[m], mzz += mz * z[m];
    }
    double axx = 0, axy = 0, axz = 0, ayx = 0, ayy = 0, ayz = 0, azx = 0, azy = 0, azz = 0, cx = 0, cy = 0, cz = 0;
#pragma omp simd reduction(+ : axx, axy, axz, ayx, ayy, ayz, azx, azy, azz, cx, cy, cz)
    for (int m = 0; m < n; ++m) {
      const double across = b.moment[m] * b.along_normal[m], ax = across * x[m], ay = across * y[m], az = across * z[m];
      axx += ax * nx[m], axy += ax * ny[m], axz += ax * nz[m];
      ayx += ay * nx[m], ayy += ay * ny[m], ayz += ay * nz[m];
      azx += az * nx[m], azy += az * ny[m], azz += az * nz[m];
      cx += b.acceleration[m] * ax, cy += b.acceleration[m] * ay, cz += b.acceleration[m] * az;
    }
    sums.density += density;
    sums.flux += flux;
    sums.gradient += Vector<D>(gx, gy, gz);
    sums.moment += (Matrix<D>() << mxx, mxy, mxz, mxy, myy, myz, mxz, myz, mzz).finished();
    sums.across += (Matrix<D>() << axx, axy, axz, ayx, ayy, ayz, azx, azy, azz).finished();
    sums.accelerated += Vector<D>(cx, cy, cz);
  }
}

}  // namespace

template <int D>
HiddenSums<D> sum_hidden(const Constants<D>& constants, const Vector<D>& x, const Faces<D>& faces, std::ptrdiff_t i, FaceRows& rows) {
  HiddenSums<D> sums;
  FaceBatch<D> b;
  double height = 1e300;
  for (int next = rows.begin[i], end = next + rows.count[i]; next < end;) {
    int entry[batch], n = 0;
    for (; next < end && n < batch; ++next) {
      const int k = rows.face[next];
      if (rows.wet.empty() || rows.wet[k] > 0) {
        entry[n++] = next;
        continue;
      }
      // Nothing is behind a dry face. Particles touch it like others.
      rows.weight[next] = 0;
      height = std::min(height, (x - faces.position[k]).dot(faces.normal[k]));
    }
    const int filled = (n + lanes - 1) & -lanes;
    fill_batch(constants.faces.support(), x, faces, rows, entry, n, b);
#pragma omp simd reduction(min : height)
    for (int m = 0; m < filled; ++m) {
      double d[D], normal[D], distance2 = 0, along_normal = 0;
      for (int c = 0; c < D; ++c) {
        d[c] = b.direction[c][m], normal[c] = b.normal[c][m];
        distance2 += d[c] * d[c], along_normal += d[c] * normal[c];
      }
      const double r = std::sqrt(distance2), inverse = 1 / r;
      const double angle = b.wet[m] * subtended_angle<D>(d, normal, b.area[m]);
      b.weight[m] = b.wet[m] * b.area[m] * constants.faces.surface_weight(r);
      b.density[m] = angle * constants.faces.hidden_density(r);
      b.moment[m] = angle * constants.faces.hidden_moment(r);
      b.along_normal[m] = inverse * along_normal;
      height = std::min(height, -along_normal);
      for (int c = 0; c < D; ++c) b.direction[c][m] = inverse * d[c];
    }
    for (int m = 0; m < n; ++m) rows.weight[entry[m]] = b.weight[m];
    add_batch(b, filled, sums);
  }
  rows.height[i] = (1 - 1e-6) * height;
  return sums;
}

template HiddenSums<2> sum_hidden<2>(const Constants<2>&, const Vector<2>&, const Faces<2>&, std::ptrdiff_t, FaceRows&);
template HiddenSums<3> sum_hidden<3>(const Constants<3>&, const Vector<3>&, const Faces<3>&, std::ptrdiff_t, FaceRows&);

}  // namespace tern::fluid
