#include "fluid/boundary/hidden_sums.hpp"

#include <algorithm>

namespace tern::fluid {
namespace {

constexpr int batch = 64;  ///< faces computed at a time, one array per quantity
constexpr int lanes = 4;   ///< of a vector register: batches are filled up to a whole number of it

/// Quantities of the faces of a batch.
template <int D>
struct FaceBatch {
  double direction[D][batch], normal[D][batch], sides[D - 1][batch];  ///< direction: vector to the face, then e; sides: set_patch_sides()
  double area[batch], wet[batch], speed[batch], acceleration[batch];  ///< speed: along the normal
  double distance[batch], angle[batch];                               ///< angle: of its wet share
  double weight[batch], density[batch], moment[batch], along_normal[batch];
};

/// Fills a batch with the next wet faces of a row; returns how many. The place of each in the row is written to `entry`. Faces that are dry
/// get the weight 0 and lower `height`, the least of x above faces.
template <int D>
int fill_batch(const Vector<D>& x, const Faces<D>& faces, FaceRows& rows, int& next, int end, int* entry, double& height, FaceBatch<D>& b) {
  const bool at_rest = faces.velocity.empty(), even = faces.normal_acceleration.empty();
  int n = 0, alike = -1;  // the last one, of which the sides are known
  double sides[D - 1] = {};
  for (; next < end && n < batch; ++next) {
    const int k = rows.face[next];
    const double wet = rows.wet.empty() ? 1 : rows.wet[k], area = faces.area[k];
    const Vector<D>&normal = faces.normal[k], d = faces.position[k] - x;
    if (wet <= 0) {
      rows.weight[next] = 0;
      height = std::min(height, -d.dot(normal));
      continue;
    }
    // Most patches of a wall are alike.
    if (alike < 0 || faces.area[alike] != area || faces.normal[alike] != normal) set_patch_sides<D>(normal, area, sides);
    alike = k;
    entry[n] = next;
    for (int c = 0; c < D; ++c) b.direction[c][n] = d[c], b.normal[c][n] = normal[c];
    for (int c = 0; c < D - 1; ++c) b.sides[c][n] = sides[c];
    b.wet[n] = wet;
    b.area[n] = area;
    b.speed[n] = at_rest ? 0 : faces.velocity[k].dot(normal);
    b.acceleration[n] = even ? 0 : faces.normal_acceleration[k];
    ++n;
  }
  return n;
}

/// Fills a batch of n faces up to a whole number of lanes, with faces as far away as can be and nothing hidden; returns how many these are.
template <int D>
int fill_lanes(double support, int n, FaceBatch<D>& b) {
  for (; n % lanes != 0; ++n) {
    for (int c = 0; c < D; ++c) b.direction[c][n] = c == 0 ? support : 0, b.normal[c][n] = c == 0 ? -1 : 0;
    for (int c = 0; c < D - 1; ++c) b.sides[c][n] = 1;
    b.area[n] = b.wet[n] = b.speed[n] = b.acceleration[n] = 0;
  }
  return n;
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
    int entry[batch];
    const int n = fill_batch(x, faces, rows, next, end, entry, height, b), filled = fill_lanes(constants.faces.support(), n, b);
#pragma omp simd reduction(min : height)
    for (int m = 0; m < filled; ++m) {
      double d[D], normal[D], sides[D - 1], distance2 = 0, along_normal = 0;
      for (int c = 0; c < D - 1; ++c) sides[c] = b.sides[c][m];
      for (int c = 0; c < D; ++c) {
        d[c] = b.direction[c][m], normal[c] = b.normal[c][m];
        distance2 += d[c] * d[c], along_normal += d[c] * normal[c];
      }
      const double r = std::sqrt(distance2), inverse = 1 / r;
      b.distance[m] = r;
      b.angle[m] = b.wet[m] * subtended_angle<D>(d, normal, sides);
      b.weight[m] = b.wet[m] * b.area[m] * constants.faces.surface_weight(r);
      b.along_normal[m] = inverse * along_normal;
      height = std::min(height, -along_normal);
      for (int c = 0; c < D; ++c) b.direction[c][m] = inverse * d[c];
    }
    // Apart from the above, where there are not enough registers for the tables as well.
    for (int m = 0; m < filled; ++m) {
      b.density[m] = b.angle[m] * constants.faces.hidden_density(b.distance[m]);
      b.moment[m] = b.angle[m] * constants.faces.hidden_moment(b.distance[m]);
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
