#include "fluid/boundary/boundary.hpp"

#include <algorithm>

#include <omp.h>

#include "base/parallel.hpp"

namespace tern::fluid {
namespace {

/// Wet share of a face as a function of the filled share of the space in front of it: half wet where that is half filled,
/// as at the edge of a flat surface, dry below a quarter and wet above three quarters.
double wet_share(double filled) { return std::clamp(2 * filled - 0.5, 0.0, 1.0); }

/// Unit of the filled space as a whole number. The sum of whole numbers does not depend on their order, nor on the number of
/// threads that share them. It holds 8000 times the space there is.
constexpr double filled_unit = 0x1p-50;

/// A point just in front of a face, so that the face's own half space counts as hidden.
template <int D>
Vector<D> just_before(const Constants<D>& constants, const Faces<D>& faces, std::size_t k) {
  return faces.position[k] + 1e-3 * constants.spacing * faces.normal[k];
}

constexpr int batch = 64;  ///< faces computed at a time, one array per quantity
constexpr int lanes = 4;   ///< of a vector register: batches are filled up to a whole number of it

/// Sums over the hidden side of the faces that one particle sees, with the unit vector e from it to a face, the normal n, and
/// the hidden parts of sum V w and tr M in the cone behind the face.
template <int D>
struct HiddenSums {
  double density = 0;                         ///< of the parts of sum V w
  Matrix<D> moment = Matrix<D>::Zero();       ///< sum tr M e e^T
  Matrix<D> across = Matrix<D>::Zero();       ///< sum tr M (e . n) e n^T
  Vector<D> accelerated = Vector<D>::Zero();  ///< sum tr M (e . n) a_n e, a_n the acceleration of the face along n
  Vector<D> gradient = Vector<D>::Zero();     ///< sum weight n
  double flux = 0;                            ///< sum weight n . u_k
};

/// Quantities of the faces of a batch.
template <int D>
struct FaceBatch {
  double direction[D][batch], normal[D][batch];                       ///< direction: vector to the face, then e
  double area[batch], wet[batch], speed[batch], acceleration[batch];  ///< speed: along the normal
  double weight[batch], density[batch], moment[batch], along_normal[batch];
};

template <int D>
void fill_batch(double support, const Vector<D>& x, const Faces<D>& faces, const FaceRows& rows, int first, int n, FaceBatch<D>& b) {
  for (int m = 0; m < n; ++m) {
    const int k = rows.face[first + m];
    for (int c = 0; c < D; ++c) b.direction[c][m] = faces.position[k][c] - x[c], b.normal[c][m] = faces.normal[k][c];
    b.area[m] = faces.area[k];
    b.wet[m] = rows.wet.empty() ? 1 : rows.wet[k];
    b.speed[m] = faces.velocity[k].dot(faces.normal[k]);
    b.acceleration[m] = faces.normal_acceleration[k];
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

/// Sums over the faces that particle i at x sees; writes the weights of the row and its least height.
template <int D>
HiddenSums<D> sum_hidden(const Constants<D>& constants, const Vector<D>& x, const Faces<D>& faces, std::ptrdiff_t i, FaceRows& rows) {
  HiddenSums<D> sums;
  FaceBatch<D> b;
  double height = 1e300;
  for (int first = rows.begin[i], end = first + rows.count[i]; first < end; first += batch) {
    const int n = std::min(batch, end - first), filled = (n + lanes - 1) & -lanes;
    fill_batch(constants.faces.support(), x, faces, rows, first, n, b);
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
    for (int m = 0; m < n; ++m) rows.weight[first + m] = b.weight[m];
    add_batch(b, filled, sums);
  }
  rows.height[i] = (1 - 1e-6) * height;
  return sums;
}

}  // namespace

template <int D>
double hidden_density(const Constants<D>& constants, const Faces<D>& faces, const FaceFinder<D>& finder, const Vector<D>& x,
                      std::vector<int>& seen) {
  seen.clear();
  finder.see(faces, x, seen);
  double sum = 0;
  for (int k : seen) {
    const Vector<D> d = faces.position[k] - x;
    sum += subtended_angle<D>(d, faces.normal[k], faces.area[k]) * constants.faces.hidden_density(d.norm());
  }
  return sum;
}

template <int D>
void see_faces(const std::vector<Vector<D>>& position, const Faces<D>& faces, const FaceFinder<D>& finder, FaceRows& rows) {
  const int n = static_cast<int>(position.size());
  const int threads = n < parallel_threshold ? 1 : omp_get_max_threads();
  rows.begin.resize(n);
  rows.count.resize(n);
  rows.height.resize(n);
  rows.face.clear();
  rows.seen.resize(threads);
#pragma omp parallel num_threads(threads)
  {
    // Each thread finds the faces of one contiguous range of particles; put one after the other they are in order.
    const int thread = omp_get_thread_num();
    const int own_begin = static_cast<int>(static_cast<long>(n) * thread / threads);
    const int own_end = static_cast<int>(static_cast<long>(n) * (thread + 1) / threads);
    std::vector<int>& seen = thread == 0 ? rows.face : rows.seen[thread];
    seen.clear();
    for (int i = own_begin; i < own_end; ++i) {
      rows.begin[i] = static_cast<int>(seen.size());
      finder.see(faces, position[i], seen);
      rows.count[i] = static_cast<int>(seen.size()) - rows.begin[i];
    }
#pragma omp barrier
    std::size_t before = rows.face.size(), total = before;
    for (int other = 1; other < threads; ++other) {
      if (other < thread) before += rows.seen[other].size();
      total += rows.seen[other].size();
    }
#pragma omp barrier
#pragma omp single
    {
      rows.face.resize(total);
      rows.weight.resize(total);
    }
    if (thread > 0) {
      std::copy(seen.begin(), seen.end(), rows.face.begin() + static_cast<std::ptrdiff_t>(before));
      for (int i = own_begin; i < own_end; ++i) rows.begin[i] += static_cast<int>(before);
    }
  }
}

template <int D>
void leave_out_dry_walls(const Constants<D>& constants, const std::vector<Vector<D>>& position, const Faces<D>& walls,
                         const Faces<D>& whole_walls, const FaceFinder<D>& wall_finder, std::vector<double>& space,
                         const Faces<D>& structure, const FaceFinder<D>& structure_finder, FaceRows& wall_rows) {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(position.size()), count = static_cast<std::ptrdiff_t>(walls.size());
  const int threads = n < parallel_threshold ? 1 : omp_get_max_threads();
  const double scale = constants.volume / filled_unit;
  wall_rows.wet.resize(walls.size());
  wall_rows.filled.resize(threads);
  wall_rows.seen.resize(threads);
#pragma omp parallel num_threads(threads)
  {
    std::vector<std::int64_t>& filled = wall_rows.filled[omp_get_thread_num()];
    filled.assign(walls.size(), 0);
#pragma omp for schedule(static)
    for (std::ptrdiff_t i = 0; i < n; ++i)
      for (int entry = wall_rows.begin[i]; entry < wall_rows.begin[i] + wall_rows.count[i]; ++entry) {
        const int k = wall_rows.face[entry];
        filled[walls.original[k]] += std::llrint(scale * constants.kernel.value((walls.position[k] - position[i]).norm()));
      }
#pragma omp for schedule(static)
    for (std::ptrdiff_t k = 0; k < count; ++k) {
      std::int64_t sum = 0;
      for (const auto& part : wall_rows.filled) sum += part[k];
      wall_rows.wet[k] = 0;
      if (sum == 0) continue;
      const Vector<D> x = just_before(constants, walls, k);
      std::vector<int>& seen = wall_rows.seen[omp_get_thread_num()];
      if (space[k] < 0)
        space[k] = std::max(0.0, constants.lattice.density -
                                     hidden_density(constants, whole_walls, wall_finder, just_before(constants, whole_walls, k), seen));
      const double hidden = hidden_density(constants, structure, structure_finder, x, seen);
      wall_rows.wet[k] = wet_share(filled_unit * static_cast<double>(sum) / std::max(space[k] - hidden, 0.02));
    }
  }
  for (std::ptrdiff_t k = 0; k < count; ++k) wall_rows.wet[k] = wall_rows.wet[walls.original[k]];  // an image comes after its original
}

template <int D>
void set_wall_sums(const Constants<D>& constants, const std::vector<Vector<D>>& position, const std::vector<Vector<D>>& gravity,
                   const Faces<D>& faces, FaceRows& rows, BoundarySums<D>& sums) {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(position.size());
  for (auto* v : {&sums.number_density, &sums.flux}) v->resize(n);
  for (auto* m : {&sums.moment, &sums.tangential}) m->resize(n);
  for (auto* v : {&sums.wall_gradient, &sums.mirrored_hydrostatic, &sums.surface_gradient, &sums.averted_gradient, &sums.unborne_gradient})
    v->resize(n);
#pragma omp parallel for schedule(static) if (n >= parallel_threshold)
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    const HiddenSums<D> hidden = sum_hidden(constants, position[i], faces, i, rows);
    sums.number_density[i] = hidden.density;
    sums.moment[i] = hidden.moment;
    sums.tangential[i] = hidden.moment - hidden.across;
    sums.wall_gradient[i] = -hidden.gradient;
    // A wall fixes the pressure gradient along its normal only. Along the face the fluid behind the mirror has the
    // gradient of the fluid before it, whatever that is: none in a free fall along the wall.
    sums.mirrored_hydrostatic[i] = constants.density * (hidden.across * gravity[i] - hidden.accelerated);
    sums.surface_gradient[i].setZero();
    sums.averted_gradient[i].setZero();
    sums.unborne_gradient[i].setZero();
    sums.flux[i] = hidden.flux;
  }
}

/// Beside a corner: takes the cones behind averted faces from what is hidden from particle i at x, sets what the interface does not bear
/// of its sums, and turns `across` into what the faces put on a particle where quantities vary linearly, -2 sum_k A_k w~ n_k (x_k - x_i)^T:
/// there is no one normal across which the fluid is mirrored.
template <int D>
void close_round_corner(const Constants<D>& constants, const Vector<D>& x, const Vector<D>& gravity, const Faces<D>& faces,
                        const FaceRows& rows, std::ptrdiff_t i, const std::vector<int>& averted, HiddenSums<D>& hidden,
                        BoundarySums<D>& sums) {
  Matrix<D> across = Matrix<D>::Zero(), unborne = Matrix<D>::Zero();
  for (int entry = rows.begin[i]; entry < rows.begin[i] + rows.count[i]; ++entry) {
    const int k = rows.face[entry];
    const double left = 1 - sums.borne_share[k];
    const Matrix<D> linear = -2 * rows.weight[entry] * faces.normal[k] * (faces.position[k] - x).transpose();
    across += linear;
    unborne += left * linear;
    sums.unborne_gradient[i] -= left * rows.weight[entry] * faces.normal[k];
  }
  if (!averted.empty()) hidden.across = across;
  for (int k : averted) {
    const Vector<D> d = faces.position[k] - x;
    const double r = d.norm(), angle = subtended_angle<D>(d, Vector<D>(-faces.normal[k]), faces.area[k]);
    const double weight = faces.area[k] * constants.faces.surface_weight(r);
    hidden.density -= angle * constants.faces.hidden_density(r);
    hidden.moment -= (angle * constants.faces.hidden_moment(r) / (r * r)) * d * d.transpose();
    unborne += 2 * sums.borne_share[k] * weight * faces.normal[k] * d.transpose();
    sums.averted_gradient[i] -= weight * faces.normal[k];
    sums.unborne_gradient[i] -= (1 - sums.borne_share[k]) * weight * faces.normal[k];
  }
  sums.mirrored_hydrostatic[i] += constants.density * (unborne * gravity);
}

template <int D>
void add_surface_sums(const Constants<D>& constants, const std::vector<Vector<D>>& position, const std::vector<Vector<D>>& gravity,
                      const Faces<D>& faces, const FaceFinder<D>& finder, const std::vector<std::uint8_t>& covered, FaceRows& rows,
                      BoundarySums<D>& sums) {
  if (rows.face.empty()) return;
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(position.size()), count = static_cast<std::ptrdiff_t>(faces.size());
  const int threads = n < parallel_threshold ? 1 : omp_get_max_threads();
  sums.borne_share.resize(count);
  sums.corner_scratch.resize(threads);
#pragma omp parallel num_threads(threads)
  {
    CornerView<D> corners(faces, finder, covered, constants.faces, sums.corner_scratch[omp_get_thread_num()]);
#pragma omp for schedule(static)
    for (std::ptrdiff_t k = 0; k < count; ++k) sums.borne_share[k] = corners.borne_share(static_cast<int>(k));
#pragma omp for schedule(static)
    for (std::ptrdiff_t i = 0; i < n; ++i) {
      if (rows.count[i] == 0) continue;
      HiddenSums<D> hidden = sum_hidden(constants, position[i], faces, i, rows);
      const int* const seen = rows.face.data() + rows.begin[i];
      corners.look(position[i], seen, rows.count[i]);
      if (!corners.averted().empty() || std::any_of(seen, seen + rows.count[i], [&](int k) { return sums.borne_share[k] < 1; }))
        close_round_corner<D>(constants, position[i], gravity[i], faces, rows, i, corners.averted(), hidden, sums);
      sums.number_density[i] += hidden.density;
      sums.moment[i] += hidden.moment;
      sums.tangential[i] += hidden.moment - hidden.across;
      sums.surface_gradient[i] = -hidden.gradient;
      sums.flux[i] += hidden.flux;
    }
  }
}

#define TERN_INSTANTIATE(D)                                                                                                             \
  template void see_faces<D>(const std::vector<Vector<D>>&, const Faces<D>&, const FaceFinder<D>&, FaceRows&);                          \
  template double hidden_density<D>(const Constants<D>&, const Faces<D>&, const FaceFinder<D>&, const Vector<D>&, std::vector<int>&);   \
  template void leave_out_dry_walls<D>(const Constants<D>&, const std::vector<Vector<D>>&, const Faces<D>&, const Faces<D>&,            \
                                       const FaceFinder<D>&, std::vector<double>&, const Faces<D>&, const FaceFinder<D>&, FaceRows&);   \
  template void set_wall_sums<D>(const Constants<D>&, const std::vector<Vector<D>>&, const std::vector<Vector<D>>&, const Faces<D>&,    \
                                 FaceRows&, BoundarySums<D>&);                                                                          \
  template void add_surface_sums<D>(const Constants<D>&, const std::vector<Vector<D>>&, const std::vector<Vector<D>>&, const Faces<D>&, \
                                    const FaceFinder<D>&, const std::vector<std::uint8_t>&, FaceRows&, BoundarySums<D>&);
TERN_INSTANTIATE(2)
TERN_INSTANTIATE(3)
#undef TERN_INSTANTIATE

}  // namespace tern::fluid
