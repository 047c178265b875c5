// Boundary of a solid as surface points: every primitive is cut into patches, and of each patch only what lies on the
// boundary of the final solid remains. A piece of a primitive lies on it where the solid is on its inner side and not
// on its outer side, x - eps n inside, x + eps n outside.

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <utility>

#include "scene/geodesic_sphere.hpp"
#include "scene/geometry.hpp"
#include "scene/plane_polygon.hpp"
#include "scene/shell_sampling.hpp"

namespace tern {
namespace {

constexpr double least_piece = 0.05;     ///< of the spacing: nearer to each other faces of walls and clamps are one cut
constexpr double least_of_narrow = 0.2;  ///< of the spacing: length of the patches of a narrow piece

// A primitive of the shape tree; one that is subtracted has its normals reversed.
struct Leaf {
  const Shape* shape;
  double sign;
};

void collect(const Shape& shape, double sign, std::vector<Leaf>& leaves) {
  if (shape.kind == Shape::Kind::union_of || shape.kind == Shape::Kind::difference) {
    for (std::size_t i = 0; i < shape.parts.size(); ++i) {
      const bool subtracted = shape.kind == Shape::Kind::difference && i > 0;
      collect(shape.parts[i], subtracted ? -sign : sign, leaves);
    }
  } else {
    leaves.push_back({&shape, sign});
  }
}

template <int D>
struct SurfacePoint {
  Vector<D> position, normal;
};

template <int D>
class Sampler {
 public:
  /// `cuts`: of the faces of a ring or a line, over the length of its middle line, from 0 to 1; empty: each face evenly.
  Sampler(const Shape& shape, double spacing, std::vector<double> cuts = {})
      : shape_(shape), spacing_(spacing), bounds_(bounding_box<D>(shape)), cuts_(std::move(cuts)) {
    sample_leaves();
  }
  using Visit = std::function<void(const Vector<D>&, const Vector<D>&, double, std::int64_t)>;
  /// Points in these boxes alone, which are visited and not kept.
  Sampler(const Shape& shape, double spacing, const std::vector<Bounds<D>>& boxes, const Visit& visit)
      : shape_(shape), spacing_(spacing), bounds_(bounding_box<D>(shape)), boxes_(&boxes), visit_(&visit) {
    sample_leaves();
  }
  SurfacePoints<D> points;

 private:
  void sample_leaves() {
    collect(shape_, 1.0, leaves_);
    for (current_ = 0; current_ < leaves_.size(); ++current_) sample(*leaves_[current_].shape);
  }

  long count(double length) const { return surface_pieces(length, spacing_); }

  bool on_final_boundary(const SurfacePoint<D>& p) const {
    if (leaves_.size() == 1) return true;
    const Vector<D> step = 1e-5 * spacing_ * p.normal;
    const Vector<D> inner = p.position - step, outer = p.position + step;
    if (signed_distance<D>(shape_, inner) > 0 || signed_distance<D>(shape_, outer) <= 0) return false;
    // Of coinciding faces that look the same way only the first counts.
    for (std::size_t j = 0; j < current_; ++j) {
      const double at_inner = leaves_[j].sign * signed_distance<D>(*leaves_[j].shape, inner);
      const double at_outer = leaves_[j].sign * signed_distance<D>(*leaves_[j].shape, outer);
      if (at_inner < 0 && at_outer > 0) return false;
    }
    return true;
  }

  /// Whether a box may ask for a piece of a row, of which these are the first one, one in the middle, and the last. `width`: of the row.
  bool any_box_near(const Vector<D>& first, const Vector<D>& middle, const Vector<D>& last, double width) const {
    const double reach = 2 * std::max((first - middle).norm(), (last - middle).norm()) + 2 * spacing_ + width;
    return std::any_of(boxes_->begin(), boxes_->end(),
                       [&](const Bounds<D>& box) { return (box.min - middle).cwiseMax(middle - box.max).maxCoeff() < reach; });
  }

  /// Calls visit(i) for the pieces 0 .. n - 1 of a row, but for many that are not asked for. `place`: of the middle of one; `of_each`:
  /// points that it has at most.
  template <class Place, class Visit>
  void for_asked_pieces(long n, long of_each, double width, Place&& place, Visit&& visit) {
    constexpr long together = 64;
    const std::int64_t first_number = next_number_;
    for (long first = 0; first < n; first += together) {
      const long last = std::min(n, first + together);
      if (boxes_ != nullptr && !any_box_near(place(first), place((first + last - 1) / 2), place(last - 1), width)) continue;
      for (long i = first; i < last; ++i) {
        next_number_ = first_number + of_each * i;
        visit(i);
      }
    }
    next_number_ = first_number + of_each * n;
  }

  void add(SurfacePoint<D> p, double area) {
    if (boxes_ != nullptr) {
      const std::int64_t number = next_number_++;
      if (lies_in_any(*boxes_, p.position)) (*visit_)(p.position, p.normal, area, number);
      return;
    }
    points.position.push_back(p.position);
    points.normal.push_back(p.normal);
    points.area.push_back(area);
  }

  using Curve = std::function<SurfacePoint<D>(double)>;          // parameter 0..1 along an edge (2D)
  using Patch = std::function<SurfacePoint<D>(double, double)>;  // parameters 0..1, area-preserving (3D)

  // 2D: finds where the edge enters and leaves the final boundary by bisection and divides each remaining stretch
  // evenly.
  // Of a curve that lies outside of the shape's box before `low` and after `high` only what is between is looked at.
  void add_curve(const Curve& raw, double length, long pieces_if_whole, double low = 0, double high = 1) {
    const double sign = leaves_[current_].sign;
    const Curve curve = [&](double s) {
      SurfacePoint<D> p = raw(s);
      p.normal *= sign;
      return p;
    };
    const auto kept = [&](double s) { return on_final_boundary(curve(s)); };
    const long probes = leaves_.size() == 1 ? 1 : 8 * count(length);
    const auto probe = [&](long i) { return (static_cast<double>(i) + 0.5) / static_cast<double>(probes); };
    const auto crossing = [&](double a, double b) {
      const bool at_a = kept(a);
      for (int i = 0; i < 50; ++i) {
        const double middle = 0.5 * (a + b);
        (kept(middle) == at_a ? a : b) = middle;
      }
      return 0.5 * (a + b);
    };
    const auto nearest_probe = [&](double s) { return static_cast<long>(std::clamp(s, 0.0, 1.0) * static_cast<double>(probes)); };
    const long first = std::max(0L, nearest_probe(low) - 2), last = std::min(probes, nearest_probe(high) + 2);
    double begin = first == 0 && kept(probe(0)) ? 0.0 : -1.0;
    for (long i = first + 1; i <= last; ++i) {
      const bool inside = i < probes && kept(probe(i));
      if (inside && begin < 0) {
        begin = crossing(probe(i - 1), probe(i));
      } else if (!inside && begin >= 0) {
        const double end = i < probes ? crossing(probe(i - 1), probe(i)) : 1.0;
        const bool whole = begin == 0.0 && end == 1.0;
        const long pieces = whole ? pieces_if_whole : count((end - begin) * length);
        for (long k = 0; k < pieces; ++k) {
          const double s = begin + (end - begin) * (static_cast<double>(k) + 0.5) / static_cast<double>(pieces);
          add(curve(s), (end - begin) * length / static_cast<double>(pieces));
        }
        begin = -1.0;
      }
    }
  }

  // Whether no other primitive has its boundary within twice the size of the patch: then all of it is kept, or nothing.
  bool is_far_from_others(const Patch& patch) const {
    const Vector<D> middle = patch(0.5, 0.5).position;
    double size = 0;
    for (const auto& [u, v] : {std::pair{0.0, 0.0}, {0.0, 1.0}, {1.0, 0.0}, {1.0, 1.0}, {0.5, 0.0}, {0.5, 1.0}})
      size = std::max(size, (patch(u, v).position - middle).norm());
    for (std::size_t j = 0; j < leaves_.size(); ++j)
      if (j != current_ && std::abs(signed_distance<D>(*leaves_[j].shape, middle)) <= 2 * size) return false;
    return true;
  }

  /// As the shape has it: one that is subtracted looks the other way.
  Patch turned(const Patch& raw) const {
    return [&raw, sign = leaves_[current_].sign](double u, double v) {
      SurfacePoint<D> p = raw(u, v);
      p.normal *= sign;
      return p;
    };
  }

  void add_patch(const Patch& raw, double area) {
    const Patch patch = turned(raw);
    if (leaves_.size() == 1) return add(patch(0.5, 0.5), area);
    if (!is_far_from_others(patch)) return add_samples(raw, area);
    if (on_final_boundary(patch(0.5, 0.5))) add(patch(0.5, 0.5), area);
  }

  // 3D: keeps the share of the patch whose sub-samples lie on the final boundary.
  void add_samples(const Patch& raw, double area) {
    const Patch patch = turned(raw);
    constexpr int samples = 8;
    double u_sum = 0, v_sum = 0;
    int kept = 0;
    for (int i = 0; i < samples; ++i) {
      for (int j = 0; j < samples; ++j) {
        const double u = (i + 0.5) / samples, v = (j + 0.5) / samples;
        if (!on_final_boundary(patch(u, v))) continue;
        u_sum += u, v_sum += v, ++kept;
      }
    }
    if (kept > 0) add(patch(u_sum / kept, v_sum / kept), area * kept / (samples * samples));
  }

  void sample(const Shape& leaf) {
    if (leaf.kind == Shape::Kind::ball) return sample_ball(leaf);
    if constexpr (D == 2) {
      if (leaf.kind == Shape::Kind::ring) return sample_ring(leaf);
      if (leaf.kind == Shape::Kind::line) return sample_line(leaf);
      auto vertices = leaf.vertices;
      if (leaf.kind == Shape::Kind::box) {
        vertices = {{leaf.min[0], leaf.min[1]}, {leaf.max[0], leaf.min[1]}, {leaf.max[0], leaf.max[1]}, {leaf.min[0], leaf.max[1]}};
      }
      sample_polygon(vertices);
    } else if (leaf.kind == Shape::Kind::tube) {
      sample_tube(leaf);
    } else if (leaf.kind == Shape::Kind::plate) {
      sample_plate(leaf);
    } else {
      sample_box(leaf);
    }
  }

  void sample_straight(const Vector<D>& from, const Vector<D>& to, const Vector<D>& normal) {
    const Curve edge = [&](double s) { return SurfacePoint<D>{from + s * (to - from), normal}; };
    const double length = (to - from).norm();
    add_curve(edge, length, count(length));
  }

  /// A point in the middle of each piece of a whole face. `place`: length of the face up to a place of the middle line.
  void add_pieces(const Curve& face, const std::function<double(double)>& place) {
    for (std::size_t k = 0; k + 1 < cuts_.size(); ++k) add(face(0.5 * (cuts_[k] + cuts_[k + 1])), place(cuts_[k + 1]) - place(cuts_[k]));
  }

  void sample_ring(const Shape& leaf) {
    const Vector<D> center(leaf.center[0], leaf.center[1]);
    const auto outwards = [](double angle) { return Vector<D>(std::cos(angle), std::sin(angle)); };
    const double turn = leaf.end - leaf.begin;
    for (const double side : {1.0, -1.0}) {
      const double r = leaf.radius + 0.5 * side * leaf.thickness;
      const Curve arc = [&](double s) {
        const Vector<D> n = outwards(leaf.begin + s * turn);
        return SurfacePoint<D>{center + r * n, side * n};
      };
      if (cuts_.empty())
        add_curve(arc, r * turn, std::max(3L, count(r * turn)));
      else
        add_pieces(arc, [&](double s) { return s * r * turn; });
    }
    if (turn >= Shape::whole_turn * (1 - 1e-12)) return;
    for (const double angle : {leaf.begin, leaf.end}) {
      const Vector<D> n = outwards(angle), along(-n[1], n[0]);
      sample_straight(center + (leaf.radius - 0.5 * leaf.thickness) * n, center + (leaf.radius + 0.5 * leaf.thickness) * n,
                      angle == leaf.end ? along : Vector<D>(-along));
    }
  }

  /// Both sides of a line with a thickness, mitred at its corners, and its ends.
  void sample_line(const Shape& leaf) {
    const std::size_t count_of = leaf.vertices.size(), segments = leaf.closed ? count_of : count_of - 1;
    std::vector<Vector<D>> along(segments);
    const auto corner = [&](std::size_t i) { return Vector<D>(leaf.vertices[i % count_of][0], leaf.vertices[i % count_of][1]); };
    for (std::size_t i = 0; i < segments; ++i) along[i] = (corner(i + 1) - corner(i)).normalized();
    const auto left_of = [](const Vector<D>& e) { return Vector<D>(-e[1], e[0]); };
    for (const double side : {1.0, -1.0}) {
      std::vector<Vector<D>> offset;
      for (std::size_t i = 0; i <= segments; ++i) {
        const bool has_before = leaf.closed || i > 0, has_after = leaf.closed || i < segments;
        const Vector<D> before = left_of(along[has_before ? (i + segments - 1) % segments : 0]);
        const Vector<D> after = left_of(along[has_after ? i % segments : segments - 1]);
        offset.push_back(corner(i) + side * leaf.thickness / (1 + before.dot(after)) * 0.5 * (before + after));
      }
      std::vector<double> place{0}, middle{0};
      for (std::size_t i = 0; i < segments; ++i) {
        place.push_back(place.back() + (offset[i + 1] - offset[i]).norm());
        middle.push_back(middle.back() + (corner(i + 1) - corner(i)).norm());
      }
      if (!cuts_.empty()) {
        const auto find = [&](double s) {  // segment, and share of it
          const double at = s * middle.back();
          const auto i = static_cast<std::size_t>(std::upper_bound(middle.begin() + 1, middle.end() - 1, at) - middle.begin()) - 1;
          return std::pair{i, (at - middle[i]) / (middle[i + 1] - middle[i])};
        };
        const Curve face = [&](double s) {
          const auto [i, share] = find(s);
          return SurfacePoint<D>{offset[i] + share * (offset[i + 1] - offset[i]), side * left_of(along[i])};
        };
        add_pieces(face, [&](double s) {
          const auto [i, share] = find(s);
          return place[i] + share * (place[i + 1] - place[i]);
        });
        continue;
      }
      const double length = place.back();
      const Curve curve = [&](double s) {
        const auto next = std::upper_bound(place.begin() + 1, place.end() - 1, s * length);
        const auto i = static_cast<std::size_t>(next - place.begin()) - 1;
        const double share = (s * length - place[i]) / (place[i + 1] - place[i]);
        return SurfacePoint<D>{offset[i] + share * (offset[i + 1] - offset[i]), side * left_of(along[i])};
      };
      add_curve(curve, length, std::max(leaf.closed ? 3L : 1L, count(length)));
    }
    if (leaf.closed) return;
    for (const bool last : {false, true}) {
      const Vector<D> end = corner(last ? segments : 0), e = along[last ? segments - 1 : 0];
      const Vector<D> across = 0.5 * leaf.thickness * left_of(e);
      sample_straight(end - across, end + across, last ? e : Vector<D>(-e));
    }
  }

  void sample_tube(const Shape& leaf) {
    const int first = (leaf.axis + 1) % 3, second = (leaf.axis + 2) % 3;
    const double turn = leaf.end - leaf.begin;
    const auto place = [&](double along, double r, double angle) {
      Vector<D> x;
      x[leaf.axis] = leaf.center[leaf.axis] + along;
      x[first] = leaf.center[first] + r * std::cos(angle);
      x[second] = leaf.center[second] + r * std::sin(angle);
      return x;
    };
    const auto direction = [&](double along, double radial, double tangential, double angle) {
      Vector<D> n;
      n[leaf.axis] = along;
      n[first] = radial * std::cos(angle) - tangential * std::sin(angle);
      n[second] = radial * std::sin(angle) + tangential * std::cos(angle);
      return n;
    };
    const double inner = leaf.radius - 0.5 * leaf.thickness, outer = leaf.radius + 0.5 * leaf.thickness;
    const long along = count(leaf.length), across = count(leaf.thickness), around = std::max(3L, count(leaf.radius * turn));
    const auto part = [](long i, double u, long pieces) { return (static_cast<double>(i) + u) / static_cast<double>(pieces); };
    const auto add_patches = [&](long rows, long columns, double area, const Patch& face) {
      for (long j = 0; j < columns; ++j)
        for_asked_pieces(
            rows, 1, 0, [&](long i) { return face(part(i, 0.5, rows), part(j, 0.5, columns)).position; },
            [&](long i) {
              add_patch([&](double u, double v) { return face(part(i, u, rows), part(j, v, columns)); },
                        area / static_cast<double>(rows * columns));
            });
    };
    for (const double side : {1.0, -1.0}) {
      const double r = side > 0 ? outer : inner;
      add_patches(along, around, r * turn * leaf.length, [&](double u, double v) {
        const double angle = leaf.begin + v * turn;
        return SurfacePoint<D>{place((u - 0.5) * leaf.length, r, angle), direction(0, side, 0, angle)};
      });
      add_patches(across, around, leaf.radius * leaf.thickness * turn, [&](double u, double v) {
        const double angle = leaf.begin + v * turn, squared = inner * inner + u * (outer * outer - inner * inner);
        return SurfacePoint<D>{place(0.5 * side * leaf.length, std::sqrt(squared), angle), direction(side, 0, 0, angle)};
      });
      if (turn >= Shape::whole_turn * (1 - 1e-12)) continue;
      const double angle = side > 0 ? leaf.end : leaf.begin;
      add_patches(across, along, leaf.thickness * leaf.length, [&](double u, double v) {
        return SurfacePoint<D>{place((v - 0.5) * leaf.length, inner + u * leaf.thickness, angle), direction(0, 0, side, angle)};
      });
    }
  }

  /// Both faces, cut into squares that end at the sides, and the rim. Where other shapes may hide some of it, what a side or another shape
  /// leaves of a square is found by its sub-samples.
  void sample_plate(const Shape& leaf) {
    Outline outline;
    for (const auto& vertex : leaf.vertices) outline.emplace_back(vertex[0], vertex[1]);
    const auto axis = [&](int a) { return Vector<D>(leaf.axes[a][0], leaf.axes[a][1], leaf.axes[a][2]); };
    const Vector<D> origin(leaf.center[0], leaf.center[1], leaf.center[2]);
    const auto place = [&](const Vector<2>& s, double z) { return Vector<D>(origin + s[0] * axis(0) + s[1] * axis(1) + z * axis(2)); };
    Vector<2> low = outline[0], high = outline[0];
    for (const Vector<2>& corner : outline) low = low.cwiseMin(corner), high = high.cwiseMax(corner);
    const std::array<long, 2> pieces{count(high[0] - low[0]), count(high[1] - low[1])};
    const Vector<2> step((high[0] - low[0]) / static_cast<double>(pieces[0]), (high[1] - low[1]) / static_cast<double>(pieces[1]));
    for (long j = 0; j < pieces[1]; ++j) {
      const Vector<2> below(0, low[1] + static_cast<double>(j) * step[1]), above = below + Vector<2>(0, step[1]);
      const Outline row = cut(cut(outline, below, Vector<2>(0, -1)), above, Vector<2>(0, 1));
      const auto middle = [&](long i) {
        return place(Vector<2>(low[0] + (static_cast<double>(i) + 0.5) * step[0], below[1] + 0.5 * step[1]), 0);
      };
      for_asked_pieces(pieces[0], 2, leaf.thickness, middle, [&](long i) {
        const Vector<2> left(low[0] + static_cast<double>(i) * step[0], 0), right = left + Vector<2>(step[0], 0);
        const PlaneArea piece = area_of(cut(cut(row, left, Vector<2>(-1, 0)), right, Vector<2>(1, 0)));
        const double whole = step[0] * step[1];
        if (piece.area <= 1e-9 * whole) return;
        for (const double side : {1.0, -1.0}) {
          const Patch square = [&](double u, double v) {
            return SurfacePoint<D>{place(Vector<2>(left[0] + u * step[0], below[1] + v * step[1]), 0.5 * side * leaf.thickness),
                                   side * axis(2)};
          };
          if (leaves_.size() == 1)
            add({place(piece.centre, 0.5 * side * leaf.thickness), side * axis(2)}, piece.area);
          else if (piece.area >= whole * (1 - 1e-9))
            add_patch(square, whole);
          else
            add_samples(square, whole);
        }
      });
    }
    const long across = count(leaf.thickness);
    for (std::size_t k = 0; k < outline.size(); ++k) {
      const Vector<2>&from = outline[k], along = outline[(k + 1) % outline.size()] - from;
      const Vector<D> normal = (along[1] * axis(0) - along[0] * axis(1)).normalized();
      const long n = count(along.norm());
      for (long j = 0; j < across; ++j)
        for (long i = 0; i < n; ++i) {
          const Patch piece = [&](double u, double v) {
            const double share = (static_cast<double>(i) + u) / static_cast<double>(n);
            const double z = ((static_cast<double>(j) + v) / static_cast<double>(across) - 0.5) * leaf.thickness;
            return SurfacePoint<D>{place(from + share * along, z), normal};
          };
          add_patch(piece, along.norm() * leaf.thickness / static_cast<double>(n * across));
        }
    }
  }

  void sample_polygon(const std::vector<std::array<double, 2>>& vertices) {
    double twice_area = 0;
    for (std::size_t i = 0, j = vertices.size() - 1; i < vertices.size(); j = i++) {
      twice_area += vertices[j][0] * vertices[i][1] - vertices[i][0] * vertices[j][1];
    }
    const double turn = twice_area > 0 ? 1.0 : -1.0;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      const auto& a = vertices[i];
      const auto& b = vertices[(i + 1) % vertices.size()];
      const double ex = b[0] - a[0], ey = b[1] - a[1], length = std::hypot(ex, ey);
      const Curve edge = [&](double s) {
        SurfacePoint<D> p;
        p.position.setZero(), p.normal.setZero();
        p.position[0] = a[0] + s * ex, p.position[1] = a[1] + s * ey;
        p.normal[0] = turn * ey / length, p.normal[1] = -turn * ex / length;
        return p;
      };
      double low = 0, high = 1;  // where the edge is inside of the box around the whole shape
      for (int d = 0; d < 2; ++d) {
        const double along = b[d] - a[d];
        if (along == 0) continue;
        const double enters = (bounds_.min[d] - spacing_ - a[d]) / along, leaves = (bounds_.max[d] + spacing_ - a[d]) / along;
        low = std::max(low, std::min(enters, leaves)), high = std::min(high, std::max(enters, leaves));
      }
      add_curve(edge, length, count(length), low, high);
    }
  }

  void sample_box(const Shape& leaf) {
    for (int d = 0; d < D; ++d) {
      const int e = (d + 1) % D, f = (d + 2) % D;
      const long n = count(leaf.max[e] - leaf.min[e]), m = count(leaf.max[f] - leaf.min[f]);
      const double de = (leaf.max[e] - leaf.min[e]) / static_cast<double>(n);
      const double df = (leaf.max[f] - leaf.min[f]) / static_cast<double>(m);
      // Patches that can lie on the boundary: those inside of the box around the whole shape.
      const auto range = [&](int c, double step, long pieces) {
        const auto index = [&](double x) { return std::clamp(std::floor((x - leaf.min[c]) / step), 0.0, static_cast<double>(pieces)); };
        return std::pair{static_cast<long>(index(bounds_.min[c] - spacing_)),
                         std::min(pieces, static_cast<long>(index(bounds_.max[c] + spacing_)) + 1)};
      };
      const auto [first_i, last_i] = range(e, de, n);
      const auto [first_j, last_j] = range(f, df, m);
      for (const bool upper : {false, true}) {
        for (long j = first_j; j < last_j; ++j) {
          const std::int64_t first_of_row = next_number_;
          const auto [from_i, to_i] = asked_of_row(leaf, d, upper, de, df, j, first_i, last_i);
          for (long i = from_i; i < to_i; ++i) {
            next_number_ = first_of_row + (i - first_i);
            const auto patch = [&](double u, double v) {
              SurfacePoint<D> p;
              p.normal.setZero();
              p.normal[d] = upper ? 1.0 : -1.0;
              p.position[d] = upper ? leaf.max[d] : leaf.min[d];
              p.position[e] = leaf.min[e] + (static_cast<double>(i) + u) * de;
              p.position[f] = leaf.min[f] + (static_cast<double>(j) + v) * df;
              return p;
            };
            leaves_.size() == 1 ? add(patch(0.5, 0.5), de * df) : add_patch(patch, de * df);
          }
          next_number_ = first_of_row + (last_i - first_i);
        }
      }
    }
  }

  /// Of the pieces first .. last - 1 of row j of a side of a box those that may have a point that is asked for: from .. to - 1. The point
  /// of a piece that is kept in part lies within the piece.
  std::pair<long, long> asked_of_row(const Shape& leaf, int d, bool upper, double de, double df, long j, long first, long last) const {
    if (boxes_ == nullptr) return {first, last};
    const int e = (d + 1) % D, f = (d + 2) % D;
    const double at = upper ? leaf.max[d] : leaf.min[d], across = leaf.min[f] + (static_cast<double>(j) + 0.5) * df;
    double low = 1e300, high = -1e300;
    for (const Bounds<D>& box : *boxes_) {
      if (box.empty() || at < box.min[d] || at > box.max[d] || across < box.min[f] - df || across > box.max[f] + df) continue;
      low = std::min(low, box.min[e]), high = std::max(high, box.max[e]);
    }
    if (low > high) return {first, first};
    const auto piece = [&](double x) {
      return static_cast<long>(std::clamp((x - leaf.min[e]) / de, static_cast<double>(first), static_cast<double>(last)));
    };
    return {std::max(first, piece(low) - 1), std::min(last, piece(high) + 2)};
  }

  void sample_ball(const Shape& leaf) {
    const double r = leaf.radius;
    if constexpr (D == 2) {
      const Curve circle = [&](double s) {
        const double angle = 2 * std::numbers::pi * s;
        SurfacePoint<D> p;
        p.normal = Vector<D>(std::cos(angle), std::sin(angle));
        p.position = Vector<D>(leaf.center[0], leaf.center[1]) + r * p.normal;
        return p;
      };
      const double length = 2 * std::numbers::pi * r;
      add_curve(circle, length, std::max(3L, count(length)));
    } else {
      // Bands of latitude; within a band area is proportional to z and angle (Archimedes), so each patch is r dz r
      // dphi.
      const long bands = std::max(2L, count(std::numbers::pi * r));
      for (long band = 0; band < bands; ++band) {
        const double south = -std::cos(std::numbers::pi * static_cast<double>(band) / static_cast<double>(bands));
        const double north = -std::cos(std::numbers::pi * static_cast<double>(band + 1) / static_cast<double>(bands));
        const double middle = std::sqrt(1 - 0.25 * (south + north) * (south + north));
        const long n = std::max(3L, count(2 * std::numbers::pi * r * middle));
        const auto patch_at = [&](long i) -> Patch {
          return [&, i](double u, double v) {
            const double height = south + v * (north - south);
            const double angle = 2 * std::numbers::pi * (static_cast<double>(i) + u) / static_cast<double>(n);
            const double circle = std::sqrt(std::max(0.0, 1 - height * height));
            SurfacePoint<D> p;
            p.normal = Vector<D>(circle * std::cos(angle), circle * std::sin(angle), height);
            p.position = Vector<D>(leaf.center[0], leaf.center[1], leaf.center[2]) + r * p.normal;
            return p;
          };
        };
        for_asked_pieces(
            n, 1, 0, [&](long i) { return patch_at(i)(0.5, 0.5).position; },
            [&](long i) { add_patch(patch_at(i), 2 * std::numbers::pi * r * r * (north - south) / static_cast<double>(n)); });
      }
    }
  }

  const Shape& shape_;
  double spacing_;
  Bounds<D> bounds_;
  std::vector<double> cuts_;
  std::vector<Leaf> leaves_;
  std::size_t current_ = 0;
  const std::vector<Bounds<D>>* boxes_ = nullptr;  ///< none: all points are kept
  const Visit* visit_ = nullptr;
  std::int64_t next_number_ = 0;
};

/// Where the particles of a curved shell end, over the whole length of its middle line, and parts of about `spacing` of each.
std::vector<double> cuts_of(const MidSurface<2>& surface, double length, double spacing) {
  std::vector<double> ends{0};  // of the cells, and of what is clamped
  const auto end_at = [&](double s) {
    if (s > ends.back() + 1e-9 * spacing) ends.push_back(s);
  };
  const double h = surface.spacing(0), first = surface.low[0] + (surface.edges[0][0] != EdgeKind::free ? 0.5 * h : 0);
  end_at(surface.low[0]);
  for (int n = 0; n <= surface.count[0]; ++n) end_at(first + n * h);
  end_at(surface.high[0]);
  end_at(length);
  std::vector<double> cuts{0};
  for (std::size_t n = 1; n < ends.size(); ++n) {
    const long parts = std::max(1L, std::lround((ends[n] - ends[n - 1]) / spacing));
    for (long k = 1; k <= parts; ++k)
      cuts.push_back((ends[n - 1] + (ends[n] - ends[n - 1]) * static_cast<double>(k) / static_cast<double>(parts)) / length);
  }
  cuts.back() = 1;
  return cuts;
}

/// The faces of a box, in parts of which each is on one side of every cut alone. `cut`: coordinates, of each axis [m].
template <int D>
SurfacePoints<D> sample_cut_box(const Shape& box, double spacing, const std::array<std::vector<double>, D>& cut) {
  SurfacePoints<D> points;
  std::array<std::size_t, D> part{};
  for (int a = 0; a < D;) {
    Shape piece = box;
    double shortest = spacing;
    for (int b = 0; b < D; ++b) {
      piece.min[b] = cut[b][part[b]];
      piece.max[b] = cut[b][part[b] + 1];
      if (cut[b].size() > 2) shortest = std::min(shortest, piece.max[b] - piece.min[b]);
    }
    // A patch hides as a square does: those of a narrow piece are nearly as narrow along it.
    const SurfacePoints<D> found = Sampler<D>(piece, std::max(shortest, least_of_narrow * spacing)).points;
    for (std::size_t k = 0; k < found.position.size(); ++k) {
      int across = 0;
      found.normal[k].cwiseAbs().maxCoeff(&across);
      if (found.normal[k][across] > 0 ? piece.max[across] < box.max[across] : piece.min[across] > box.min[across]) continue;  // inside
      points.position.push_back(found.position[k]);
      points.normal.push_back(found.normal[k]);
      points.area.push_back(found.area[k]);
    }
    for (a = 0; a < D && ++part[a] + 1 == cut[a].size(); ++a) part[a] = 0;
  }
  return points;
}

/// Where the faces of walls and clamps that are boxes pass through a flat shell, and its ends: coordinates, of each axis, in order [m].
template <int D>
std::array<std::vector<double>, D> cuts_of_walls(const StructureBody& body, const std::vector<WallCase>& walls, double spacing) {
  const Shape& shell = body.shape;
  std::array<std::vector<double>, D> cut;
  for (int a = 0; a < D; ++a) cut[a] = {shell.min[a], shell.max[a]};
  int normal = 0;
  mid_surface<D>(body).axes.col(D - 1).cwiseAbs().maxCoeff(&normal);
  std::vector<Leaf> leaves;
  for (const WallCase& wall : walls) collect(wall.shape, 1.0, leaves);
  for (const Shape& clamp : body.clamps) collect(clamp, 1.0, leaves);
  for (const Leaf& leaf : leaves) {
    const Shape& box = *leaf.shape;
    if (box.kind != Shape::Kind::box) continue;
    const auto passes = [&](int a) { return box.min[a] < shell.max[a] && box.max[a] > shell.min[a]; };
    for (int a = 0; a < D; ++a) {
      bool all_others = a != normal;
      for (int b = 0; b < D; ++b) all_others = all_others && (b == a || passes(b));
      if (!all_others) continue;
      for (const double at : {box.min[a], box.max[a]})
        if (std::all_of(cut[a].begin(), cut[a].end(), [&](double c) { return std::abs(c - at) > least_piece * spacing; }) &&
            at > shell.min[a] && at < shell.max[a])
          cut[a].push_back(at);
    }
  }
  for (std::vector<double>& of_axis : cut) std::sort(of_axis.begin(), of_axis.end());
  return cut;
}

}  // namespace

long surface_pieces(double length, double spacing) { return std::max(1L, std::lround(length / spacing)); }

template <int D>
SurfacePoints<D> sample_shell_surface(const StructureBody& body, const std::vector<WallCase>& walls, double spacing) {
  if (body.shape.kind == Shape::Kind::box) return sample_cut_box<D>(body.shape, spacing, cuts_of_walls<D>(body, walls, spacing));
  if constexpr (D == 2) {
    const Shape& shape = body.shape;
    const MidSurface<2> surface = mid_surface<2>(body);
    if (surface.kind == MidSurface<2>::Kind::round)
      return Sampler<2>(shape, spacing, cuts_of(surface, shape.radius * (shape.end - shape.begin), spacing)).points;
    if (surface.kind == MidSurface<2>::Kind::path)
      return Sampler<2>(shape, spacing, cuts_of(surface, surface.corner_at.back(), spacing)).points;
  } else if (body.shape.kind == Shape::Kind::difference) {
    const MidSurface<3> surface = mid_surface<3>(body);
    const GeodesicSphere sphere = geodesic_sphere(surface.parts);
    SurfacePoints<3> points;
    for (const double side : {1.0, -1.0})
      sample_sphere(sphere, surface.origin, surface.radius + 0.5 * side * surface.thickness, side > 0, spacing, points);
    return points;
  }
  return sample_surface<D>(body.shape, spacing);
}

template SurfacePoints<2> sample_shell_surface<2>(const StructureBody&, const std::vector<WallCase>&, double);
template SurfacePoints<3> sample_shell_surface<3>(const StructureBody&, const std::vector<WallCase>&, double);

template <int D>
SurfacePoints<D> sample_surface(const Shape& shape, double spacing) {
  return Sampler<D>(shape, spacing).points;
}

template SurfacePoints<2> sample_surface<2>(const Shape&, double);
template SurfacePoints<3> sample_surface<3>(const Shape&, double);

template <int D>
void visit_surface(const Shape& shape, double spacing, const std::vector<Bounds<D>>& boxes,
                   const std::function<void(const Vector<D>&, const Vector<D>&, double, std::int64_t)>& visit) {
  Sampler<D>(shape, spacing, boxes, visit);
}

template void visit_surface<2>(const Shape&, double, const std::vector<Bounds<2>>&,
                               const std::function<void(const Vector<2>&, const Vector<2>&, double, std::int64_t)>&);
template void visit_surface<3>(const Shape&, double, const std::vector<Bounds<3>>&,
                               const std::function<void(const Vector<3>&, const Vector<3>&, double, std::int64_t)>&);

}  // namespace tern
