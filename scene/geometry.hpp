#pragma once
// Solid shapes: boxes, polygons (2D), balls, thin ones with a thickness (rings and lines in 2D, tubes and plates in 3D), their union and
// difference. Coordinates in m.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <numbers>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/vector.hpp"

namespace tern {

struct Shape {
  enum class Kind { box, polygon, ball, ring, line, tube, plate, union_of, difference };
  static constexpr double whole_turn = 2 * std::numbers::pi;

  Kind kind = Kind::box;
  std::array<double, 3> min{}, max{};           ///< box
  std::vector<std::array<double, 2>> vertices;  ///< polygon, any orientation, not self-intersecting; line; plate: in its plane
  std::array<double, 3> center{};               ///< ball, ring, tube; plate: where its plane's coordinates are 0
  double radius = 0;                            ///< ball; ring and tube: halfway through the thickness
  double thickness = 0;                         ///< ring, line, tube, plate
  double begin = 0, end = whole_turn;           ///< ring, tube: angles between which they are [rad]
  double length = 0;                            ///< tube: along its axis, half on each side of the centre
  int axis = 2;                                 ///< tube: x, y or z; angles are counted from the next of these to the one after it
  bool closed = false;                          ///< line: from the last corner back to the first
  std::vector<std::array<double, 3>> corners;   ///< plate, halfway through its thickness
  std::array<std::array<double, 3>, 3> axes{};  ///< plate: unit vectors along its longest side, across that, and its normal
  std::vector<Shape> parts;                     ///< union_of: all; difference: the first minus the others
};

/// A plate with these corners in order, in the plane that fits them best: seen from where its normal points, they go round anticlockwise.
/// Its axes are 0 where they have no plane.
Shape plate_shape(std::vector<std::array<double, 3>> corners, double thickness);

template <int D>
struct Bounds {
  Vector<D> min, max;

  static Bounds everywhere() { return {Vector<D>::Constant(-1e300), Vector<D>::Constant(1e300)}; }
  static Bounds nowhere() { return {Vector<D>::Constant(1e300), Vector<D>::Constant(-1e300)}; }
  static Bounds around(std::span<const Vector<D>> places) {
    Bounds box = nowhere();
    for (const Vector<D>& x : places) box.min = box.min.cwiseMin(x), box.max = box.max.cwiseMax(x);
    return box;
  }
  bool empty() const { return (min.array() > max.array()).any(); }
  bool has(const Vector<D>& x) const { return (x.array() >= min.array()).all() && (x.array() <= max.array()).all(); }
  bool has(const Bounds& other) const { return other.empty() || (has(other.min) && has(other.max)); }
  /// By so much on all sides [m]; what is empty stays so.
  Bounds grown(double margin) const { return empty() ? nowhere() : Bounds{min.array() - margin, max.array() + margin}; }
};

/// Whether x lies in one of them.
template <int D>
bool lies_in_any(const std::vector<Bounds<D>>& boxes, const Vector<D>& x) {
  return std::any_of(boxes.begin(), boxes.end(), [&](const Bounds<D>& box) { return box.has(x); });
}

/// Points on a surface with outward unit normal and the area they stand for. sum(area) = the surface to O(spacing^2).
template <int D>
struct SurfacePoints {
  std::vector<Vector<D>> position;
  std::vector<Vector<D>> normal;
  std::vector<double> area;  ///< [m^(D-1)]
};

/// Negative inside, 0 on the boundary, positive outside [m]. Its size is the distance to the boundary for a single box,
/// polygon or ball, and a lower bound of it in unions (outside) and differences (inside).
template <int D>
double signed_distance(const Shape& shape, const Vector<D>& x);

/// True inside or on the boundary.
template <int D>
bool contains(const Shape& shape, const Vector<D>& x);

template <int D>
Bounds<D> bounding_box(const Shape& shape);

/// Along which the lattice of an elastic body goes: the columns are unit vectors. A lattice that cuts a face askew leaves teeth on it,
/// which bear next to nothing: a beam four particles across, turned by 17 degrees, would bend by 38 % too much. So it goes along the
/// longest side of a polygon or line and along the axes of a plate; that of a union or difference as of its first part; else along the
/// coordinates.
template <int D>
Matrix<D> lattice_axes(const Shape& shape);

/// Points of a lattice inside a shape, kept as runs along its first axis: as much memory as there are rows, however many points. Points off
/// the lattice are runs of one.
template <int D>
class LatticePoints {
 public:
  struct Run {
    std::array<long, 3> index;  ///< of its first point
    long count;
    long off_lattice = -1;  ///< which of the points off the lattice it is, -1: none
  };
  class Iterator {
   public:
    using iterator_category = std::forward_iterator_tag;
    using value_type = Vector<D>;
    using difference_type = std::ptrdiff_t;
    using pointer = const Vector<D>*;
    using reference = const Vector<D>&;

    Iterator() = default;
    Iterator(const LatticePoints* points, std::size_t run) : points_(points), run_(run) { place(); }
    reference operator*() const { return x_; }
    pointer operator->() const { return &x_; }
    Iterator& operator++() {
      if (++in_run_ == points_->runs_[run_].count) ++run_, in_run_ = 0;
      place();
      return *this;
    }
    Iterator operator++(int) {
      Iterator before = *this;
      ++*this;
      return before;
    }
    bool operator==(const Iterator& other) const { return run_ == other.run_ && in_run_ == other.in_run_; }

   private:
    void place() {
      if (run_ < points_->runs_.size()) x_ = points_->at(points_->runs_[run_], in_run_);
    }
    const LatticePoints* points_ = nullptr;
    std::size_t run_ = 0;
    long in_run_ = 0;
    Vector<D> x_;
  };

  /// `corner`: in the directions of the axes, as lattice_axes() has them.
  LatticePoints(const Vector<D>& corner, const Vector<D>& step, const Matrix<D>& axes = Matrix<D>::Identity())
      : corner_(corner), step_(step), axes_(axes), is_turned_(axes != Matrix<D>::Identity()) {}
  void add(const Run& run) {
    runs_.push_back(run);
    size_ += static_cast<std::size_t>(run.count);
  }

  void add_off_lattice(const Vector<D>& x) {
    const long n = static_cast<long>(off_lattice_.size());
    off_lattice_.push_back(x);
    add({{n, 0, 0}, 1, n});
  }

  /// The same points but for those that `left_out` marks, one entry for each in their order.
  LatticePoints without(const std::vector<char>& left_out) const {
    LatticePoints rest = *this;
    rest.runs_.clear();
    rest.size_ = 0;
    std::size_t n = 0;
    for (const Run& run : runs_)
      for (long first = 0; first < run.count;) {
        long end = first;
        while (end < run.count && !left_out[n + static_cast<std::size_t>(end)]) ++end;
        Run part = run;
        part.index[0] += first;
        part.count = end - first;
        if (part.count > 0) rest.add(part);
        first = end + 1;
        if (first >= run.count) n += static_cast<std::size_t>(run.count);
      }
    return rest;
  }

  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  Iterator begin() const { return {this, 0}; }
  Iterator end() const { return {this, runs_.size()}; }
  const std::vector<Run>& runs() const { return runs_; }
  const Vector<D>& step() const { return step_; }
  bool is_turned() const { return is_turned_; }  ///< its runs are along no coordinate
  /// A point of a run, counted from its first.
  Vector<D> at(const Run& run, long in_run) const {
    if (run.off_lattice >= 0) return off_lattice_[run.off_lattice];
    Vector<D> x;
    for (int d = 0; d < D; ++d) x[d] = corner_[d] + (static_cast<double>(run.index[d] + (d == 0 ? in_run : 0)) + 0.5) * step_[d];
    if (is_turned_) x = axes_ * x;
    return x;
  }

 private:
  Vector<D> corner_, step_;
  Matrix<D> axes_;
  bool is_turned_;
  std::vector<Run> runs_;
  std::vector<Vector<D>> off_lattice_;
  std::size_t size_ = 0;
};

/// Points of a lattice along lattice_axes(), (k + 1/2) spacing from the lowest place of the shape in each direction, inside it; the first
/// direction runs fastest. It fills a box or a rectangle whose sides are whole multiples of the spacing exactly (tolerance 1e-6 spacing).
template <int D>
LatticePoints<D> fill_lattice(const Shape& shape, double spacing);

/// The same for a fluid, whose walls shall be half a step away on all sides: in a box, or what is cut out of one, the steps are stretched
/// so that whole ones fill each side.
template <int D>
LatticePoints<D> fill_with_fluid(const Shape& shape, double spacing);

/// The first point that lies in the shape by more than `depth` [m].
template <int D>
std::optional<Vector<D>> first_inside(const LatticePoints<D>& points, const Shape& shape, double depth);

/// The spacing near `spacing` whose D-th power is the volume of a cell of these lattices, on average over all boxes: with it the fluid
/// begins at its density. `spacing` itself where whole multiples of it fill the boxes.
template <int D>
double fitted_spacing(const std::vector<Shape>& shapes, double spacing);

/// Boundary of the shape cut into flat patches of about `spacing`, one point at the middle of each. Every straight edge
/// (box face, polygon side) is divided evenly with its own rounded count; a ball evenly in angle (2D) or area (3D).
/// In union and difference only the parts on the final boundary remain; normals point out of the final solid.
template <int D>
SurfacePoints<D> sample_surface(const Shape& shape, double spacing);

/// Pieces of about `spacing` of such an edge.
long surface_pieces(double length, double spacing);

/// Calls visit(position, normal, area, number) for those of the same points whose position lies in one of these boxes, in the same order.
/// The numbers ascend, and are the same whatever the boxes are.
template <int D>
void visit_surface(const Shape& shape, double spacing, const std::vector<Bounds<D>>& boxes,
                   const std::function<void(const Vector<D>&, const Vector<D>&, double, std::int64_t)>& visit);

/// Distance from surface point x along -normal to where the ray leaves the solid again [m].
template <int D>
double thickness(const Shape& shape, const Vector<D>& x, const Vector<D>& normal);

}  // namespace tern
