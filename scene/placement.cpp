// Checks of the particles: every body is filled as the processes will fill it and held against walls and neighbours.

#include "scene/placement.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "base/error.hpp"
#include "scene/checks/checks.hpp"
#include "scene/mid_surface.hpp"
#include "scene/parameter_table.hpp"
#include "scene/scene_check.hpp"

namespace tern {
namespace {

constexpr double said_mass_error = 0.01, refused_mass_error = 0.05;  ///< of a body
constexpr double finest_fit = 0.7;                                   ///< of the spacing that is asked for
constexpr double least_share_of_sheet = 0.05;                        ///< of the surface of a body
constexpr double least_askew = 0.025;                                ///< rad; at 3 degrees a beam of 4 across bends 15 % too far
constexpr double thin_for_its_size = 0.25;                           ///< what is thicker hardly bends
/// Spacings of its thickness that a sheet seems to lack at most at a face that cuts its lattice. Measured: a quarter of a ring of 4, 8 and
/// 12 across bends by 10, 1 and 3 % too far, a ring of 4 and 8 swings in two waves as one that is 10 and 3 % softer; this gives 10, 5
/// and 3.
constexpr double lost_at_teeth = 0.06;
constexpr double said_softness = 0.05;
constexpr double most_by_spacing = 0.06;  ///< of a shell's deflection

/// Volume of a shape [m^D], where it is composed by Gauss' theorem over patches of a quarter of the spacing, or over a million larger ones
/// where those were more.
template <int D>
double volume(const Shape& shape, double spacing) {
  if (shape.kind == Shape::Kind::box) {
    const Bounds<D> bounds = bounding_box<D>(shape);
    return (bounds.max - bounds.min).prod();
  }
  constexpr double most_patches = 1e6;
  const double fine = 0.25 * spacing, coarser = std::pow(std::max(1.0, count_patches<D>(shape, fine) / most_patches), 1.0 / (D - 1));
  const SurfacePoints<D> surface = sample_surface<D>(shape, coarser * fine);
  double sum = 0;
  for (std::size_t k = 0; k < surface.area.size(); ++k) sum += surface.position[k].dot(surface.normal[k]) * surface.area[k];
  return sum / D;
}

template <int D>
using Fill = LatticePoints<D> (*)(const Shape&, double);

/// What so many particles at this spacing weigh more than the shape, over its weight.
template <int D>
double mass_error(std::size_t particles, double spacing, double whole) {
  return static_cast<double>(particles) * std::pow(spacing, D) / whole - 1;
}

/// The largest spacing below this one, of three digits, at which the particles have the mass of their shape to half of what is said; the
/// last one tried where there is none [m].
template <int D>
double better_spacing(Fill<D> lattice, const Shape& shape, double spacing, double whole) {
  constexpr double finer = 0.98, most_looks = 1e8;  // a second of search; no hint is worth more
  const Bounds<D> bounds = bounding_box<D>(shape);
  double looks = 0, fits = spacing;
  while (fits > 0.25 * spacing) {
    fits *= finer;
    looks += ((bounds.max - bounds.min) / fits).prod() * count_sides(shape);
    if (looks > most_looks) break;
    const double rounded = std::stod(fmt::format("{:.3g}", fits));
    if (std::abs(mass_error<D>(lattice(shape, rounded).size(), rounded, whole)) <= 0.5 * said_mass_error) return rounded;
  }
  return fits;
}

template <int D>
class PlacementCheck {
 public:
  PlacementCheck(Case& scene, const Setting& settings) : scene_(scene), settings_(settings) {}

  void run() {
    check_particles_exist();
    check_fluid_place();
    check_structure_place();
    check_joints();
    check_faces_beside_fluid();
    check_clamps();
    check_thickness();
    check_mass();
    check_initial_values();
  }

 private:
  [[noreturn]] static void fail(const std::string& where, const std::string& sentence) {
    throw BadInput(fmt::format("{}: {}", where, sentence));
  }

  static std::string text(const Vector<D>& x) { return fmt::format("({:.6g}) m", fmt::join(x.data(), x.data() + D, ", ")); }

  const std::string& where_fluid(std::size_t i) const { return settings_.at("fluid").at("body").items[i].where; }
  const std::string& where_body(std::size_t i) const { return settings_.at("structure").at("body").items[i].where; }

  const std::vector<FluidBody>& fluid() const {
    static const std::vector<FluidBody> none;
    return scene_.fluid ? scene_.fluid->bodies : none;
  }
  const std::vector<StructureBody>& structure() const {
    static const std::vector<StructureBody> none;
    return scene_.structure ? scene_.structure->bodies : none;
  }

  LatticePoints<D> not_empty(LatticePoints<D> points, const Shape& shape, double spacing, const std::string& where) const {
    const Bounds<D> bounds = bounding_box<D>(shape);
    if (points.empty()) {
      fail(where, fmt::format("the body holds no particle at the spacing {:.4g} m, its bounding box measures {}; use a smaller spacing "
                              "or a larger shape.",
                              spacing, text(bounds.max - bounds.min)));
    }
    return points;
  }

  void check_particles_exist() {
    for (std::size_t i = 0; i < fluid().size(); ++i) {
      fluid_points_.push_back(
          not_empty(fill_with_fluid<D>(fluid()[i].shape, scene_.fluid->spacing), fluid()[i].shape, scene_.fluid->spacing, where_fluid(i)));
    }
    for (std::size_t i = 0; i < structure().size(); ++i) {
      const StructureBody& body = structure()[i];
      structure_points_.push_back(not_empty(fill_body<D>(body), body.shape, body.spacing, where_body(i)));
      if (body.is_shell) continue;
      if (const std::size_t lost = fill_lattice<D>(body.shape, body.spacing).size() - structure_points_.back().size(); lost > 0)
        scene_.warnings.push_back(
            fmt::format("{}: {} of {} particles of the elastic body '{}' would stand alone in its sharp corners, too few side by side for "
                        "a strain, and are left out; a smaller spacing leaves out a smaller part.",
                        where_body(i), lost, lost + structure_points_.back().size(), body.name));
    }
  }

  void check_mass() {
    for (std::size_t i = 0; i < fluid().size(); ++i)
      check_mass_of(fill_with_fluid<D>, fmt::format("fluid body {}", i + 1), fluid()[i].shape, fluid_points_[i].size(),
                    scene_.fluid->spacing, where_fluid(i));
    for (std::size_t i = 0; i < structure().size(); ++i)
      if (!structure()[i].is_shell)  // its particles have the areas of their cells
        check_mass_of(fill_lattice<D>, fmt::format("the elastic body '{}'", structure()[i].name), structure()[i].shape,
                      structure_points_[i].size(), structure()[i].spacing, where_body(i));
  }

  // The particles have the mass of their cells of the lattice, whatever the shape cuts off.
  void check_mass_of(Fill<D> lattice, const std::string& label, const Shape& shape, std::size_t particles, double spacing,
                     const std::string& where) {
    const double whole = volume<D>(shape, spacing);
    const double now = mass_error<D>(particles, spacing, whole);
    if (std::abs(now) <= said_mass_error) return;
    const double fits = better_spacing<D>(lattice, shape, spacing, whole);
    const std::string sentence =
        fmt::format("the {} particles of {} have {:.2g} % {} mass than its shape; a spacing of {:.3g} m fits better than {:.3g} m.",
                    particles, label, 100 * std::abs(now), now > 0 ? "more" : "less", fits, spacing);
    if (std::abs(now) > refused_mass_error) fail(where, sentence);
    scene_.warnings.push_back(fmt::format("{}: {}", where, sentence));
  }

  // First of the points that lies in the shape by more than round-off of the spacing.
  static std::optional<Vector<D>> inside(const LatticePoints<D>& points, const Shape& shape, double spacing) {
    return first_inside<D>(points, shape, 1e-6 * spacing);
  }
  static std::optional<Vector<D>> inside(const std::vector<Vector<D>>& points, const Shape& shape, double spacing) {
    for (const Vector<D>& x : points) {
      if (signed_distance<D>(shape, x) < -1e-6 * spacing) return x;
    }
    return std::nullopt;
  }

  void check_fluid_place() const {
    const auto walls = fluid_region(scene_);
    for (std::size_t i = 0; i < fluid().size(); ++i) {
      const double dx = scene_.fluid->spacing;
      const auto surface = sample_surface<D>(fluid()[i].shape, dx).position;
      for (const Vector<D>& x : surface) {
        if (walls && signed_distance<D>(*walls, x) > 1e-6 * dx) {
          fail(where_fluid(i), fmt::format("fluid body {} reaches out of the container at {}; shrink or move it.", i + 1, text(x)));
        }
      }
      for (const Vector<D>& x : fluid_points_[i]) {
        for (int d = 0; d < D; ++d) {
          if (x[d] < scene_.domain_min[d] || x[d] > scene_.domain_max[d]) {
            fail(where_fluid(i), fmt::format("fluid body {} reaches out of [domain] at {}, where particles are removed; enlarge the "
                                             "domain.",
                                             i + 1, text(x)));
          }
        }
      }
      for (const WallCase& wall : scene_.walls) {
        if (wall.container) continue;
        const auto faces = sample_surface<D>(wall.shape, dx).position;
        std::optional<Vector<D>> x = inside(fluid_points_[i], wall.shape, dx);
        if (!x) x = inside(faces, fluid()[i].shape, dx);
        if (x) fail_overlap(where_fluid(i), fmt::format("fluid body {}", i + 1), fmt::format("the obstacle '{}'", wall.name), *x);
      }
      for (std::size_t j = 0; j < i; ++j) {
        std::optional<Vector<D>> x = inside(fluid_points_[i], fluid()[j].shape, dx);
        if (!x) x = inside(fluid_points_[j], fluid()[i].shape, dx);
        if (x) fail_overlap(where_fluid(i), fmt::format("fluid body {}", i + 1), fmt::format("fluid body {}", j + 1), *x);
      }
    }
  }

  void check_faces_beside_fluid() {
    if (!scene_.fluid) return;
    for (const WallCase& wall : scene_.walls)
      if (!wall.container) say_where_fluid_begins_on(wall.shape, fmt::format("the obstacle '{}'", wall.name));
    for (const StructureBody& body : structure()) say_where_fluid_begins_on(body.shape, fmt::format("the elastic body '{}'", body.name));
  }

  /// A sentence where all faces of a box that lie on a layer of the one fluid body come between two when it is moved by half a
  /// spacing.
  std::string or_move(const Shape& shape) const {
    constexpr double on_it = 0.1;
    if (fluid().size() != 1 || shape.kind != Shape::Kind::box) return "";
    const double dx = scene_.fluid->spacing;
    const auto water = bounding_box<D>(fluid()[0].shape), box = bounding_box<D>(shape);
    std::vector<std::string> moves;
    for (int d = 0; d < D; ++d) {
      int on = 0, between = 0;
      for (const double face : {box.min[d], box.max[d]}) {
        if (face <= water.min[d] || face >= water.max[d]) continue;
        const double layers = (face - water.min[d]) / dx, beside = std::abs(layers - std::round(layers));
        on += beside > 0.5 - on_it;
        between += beside < on_it;
      }
      if (on > 0 && between > 0) return "";
      if (on > 0) moves.push_back(fmt::format("{:.4g} m along {}", 0.5 * dx, "xyz"[d]));
    }
    return moves.empty() ? "" : fmt::format(" Here it is enough to move it by {}.", fmt::join(moves, " and "));
  }

  /// Particles stand half a spacing from a face when it lies between two layers of them. Where a face lies on a layer, its particles begin
  /// on the face, and the pressure there is wrong at first. A curved face has a tenth of the layer beside it as near as that.
  void say_where_fluid_begins_on(const Shape& shape, const std::string& label) {
    constexpr double on_it = 0.1, beside_it = 0.9, said_share = 0.3;
    const double dx = scene_.fluid->spacing;
    const auto box = bounding_box<D>(shape);
    std::size_t on = 0, beside = 0;
    for (const auto& points : fluid_points_)
      for (const Vector<D>& x : points) {
        if ((x - x.cwiseMax(box.min).cwiseMin(box.max)).norm() >= beside_it * dx) continue;
        const double distance = signed_distance<D>(shape, x) / dx;
        beside += distance < beside_it;
        on += distance < on_it;
      }
    if (static_cast<double>(on) <= said_share * static_cast<double>(beside)) return;
    scene_.warnings.push_back(fmt::format(
        "{}: {} of the {} particles of the fluid beside {} begin on its faces (within {:g} dx; half a spacing is right), and the "
        "pressure there is wrong at first. Put its faces between the layers of particles, which are {:.4g} m apart from the "
        "corner of the fluid's box on, or choose a spacing of which its sides and their distances from that corner are whole multiples.{}",
        where_fluid(0), on, beside, label, on_it, dx, or_move(shape)));
  }

  [[noreturn]] void fail_overlap(const std::string& where, const std::string& one, const std::string& other, const Vector<D>& x) const {
    fail(where, fmt::format("{} and {} overlap at {}; move one of them, or cut it out with difference.", one, other, text(x)));
  }

  static bool clamped(const StructureBody& body, const Vector<D>& x) {
    return std::any_of(body.clamps.begin(), body.clamps.end(), [&](const Shape& s) { return contains<D>(s, x); });
  }

  void check_structure_place() const {
    const auto walls = fluid_region(scene_);
    for (std::size_t i = 0; i < structure().size(); ++i) {
      const StructureBody& body = structure()[i];
      const std::string label = fmt::format("the elastic body '{}'", body.name);
      for (const Vector<D>& x : structure_points_[i]) {
        if (clamped(body, x)) continue;
        if (walls && signed_distance<D>(*walls, x) > 1e-6 * body.spacing) {
          fail(where_body(i), fmt::format("{0} stands outside the container at {1}, where it is not clamped; move it inside "
                                          "(structure.body.{2}.shape), or clamp what is outside (structure.body.{2}.clamp).",
                                          label, text(x), body.name));
        }
        for (const WallCase& wall : scene_.walls) {
          if (!wall.container && signed_distance<D>(wall.shape, x) < -1e-6 * body.spacing) {
            fail_overlap(where_body(i), label, fmt::format("the obstacle '{}'", wall.name), x);
          }
        }
      }
      for (std::size_t f = 0; f < fluid().size(); ++f) {
        std::optional<Vector<D>> x = inside(structure_points_[i], fluid()[f].shape, body.spacing);
        if (!x) x = inside(fluid_points_[f], body.shape, body.spacing);
        if (x) fail_overlap(where_body(i), label, fmt::format("fluid body {}", f + 1), *x);
      }
      for (std::size_t j = 0; j < i; ++j) {
        std::optional<Vector<D>> x = inside(structure_points_[i], structure()[j].shape, body.spacing);
        if (!x) x = inside(structure_points_[j], body.shape, body.spacing);
        if (x) fail_overlap(where_body(i), label, fmt::format("the elastic body '{}'", structure()[j].name), *x);
      }
    }
  }

  /// Who lets two shells touch expects a joint, but nothing would join them. What a clamp holds is joined by it.
  void check_joints() const {
    const auto touches = [](const StructureBody& body, const StructureBody& other) -> std::optional<Vector<D>> {
      const double spacing = std::min(body.spacing, other.spacing);
      for (const Vector<D>& x : sample_surface<D>(body.shape, spacing).position)
        if (signed_distance<D>(other.shape, x) <= 1e-6 * spacing && !clamped(body, x) && !clamped(other, x)) return x;
      return std::nullopt;
    };
    for (std::size_t i = 0; i < structure().size(); ++i)
      for (std::size_t j = 0; j < i; ++j) {
        const StructureBody &body = structure()[i], &other = structure()[j];
        if (!body.is_shell || !other.is_shell) continue;
        std::optional<Vector<D>> x = touches(body, other);
        if (!x) x = touches(other, body);
        if (x)
          fail(where_body(i),
               fmt::format("the shells '{}' and '{}' touch at {}, but there are no joints of shells: nothing would hold them "
                           "together. Leave a gap, clamp both there, or model them as one solid.",
                           body.name, other.name, text(*x)));
      }
  }

  void check_clamps() const {
    for (std::size_t i = 0; i < structure().size(); ++i) {
      const StructureBody& body = structure()[i];
      if (body.is_shell) continue;  // mid_surface() has looked
      const auto& points = structure_points_[i];
      for (std::size_t c = 0; c < body.clamps.size(); ++c) {
        if (std::none_of(points.begin(), points.end(), [&](const auto& x) { return contains<D>(body.clamps[c], x); })) {
          fail(settings_.at("structure").at("body").items[i].at("clamp").where,
               fmt::format("clamp {} of '{}' holds none of its {} particles; move or enlarge it.", c + 1, body.name, points.size()));
        }
      }
      if (std::all_of(points.begin(), points.end(), [&](const auto& x) { return clamped(body, x); })) {
        fail(settings_.at("structure").at("body").items[i].at("clamp").where,
             fmt::format("the clamps of '{}' hold all of its {} particles, so nothing can move; make it a [[wall]] "
                         "with obstacle.",
                         body.name, points.size()));
      }
    }
  }

  void check_thickness() {
    for (std::size_t i = 0; i < structure().size(); ++i) {
      const StructureBody& body = structure()[i];
      if (body.is_shell) {
        const ShellFit fit = shell_fit<D>(body);
        if (fit.without_shear > most_without_shear)
          scene_.warnings.push_back(
              fmt::format("{}: the shell '{}' is {:.3g} thicknesses long {}; without transverse shear it bends {:.2g} % too little. As a "
                          "solid (model = \"solid\", a spacing of {:.3g} m) it would not.",
                          where_body(i), body.name, fit.length / fit.thickness, fit.held, 100 * fit.without_shear, fit.thickness / 4));
        if (std::abs(fit.by_spacing) > most_by_spacing)
          scene_.warnings.push_back(fmt::format(
              "{}: the shell '{}' has {} particles {}; it bends {:.2g} % too {}. A spacing of {:.2g} m halves that.", where_body(i),
              body.name, fit.count, fit.held, 100 * std::abs(fit.by_spacing), fit.by_spacing > 0 ? "much" : "little", body.spacing / 1.42));
        if (const MidSurface<D> surface = mid_surface<D>(body);
            D == 3 && surface.kind == MidSurface<D>::Kind::round && body.spacing > std::sqrt(surface.radius * surface.thickness))
          scene_.warnings.push_back(
              fmt::format("{}: the spacing of the shell '{}', {:.3g} m, is wider than what bends along a tube at its ends and under loads, "
                          "sqrt(radius x thickness) = {:.3g} m: it is too soft there. Half of that is enough.",
                          where_body(i), body.name, body.spacing, std::sqrt(surface.radius * surface.thickness)));
        if (body.spacing * (1 + 1e-6) < 0.5 * fit.thickness)
          scene_.warnings.push_back(
              fmt::format("{}: the spacing of the shell '{}', {:.3g} m, is below half of its thickness, {:.3g} m: the sub-steps shrink "
                          "with its square, and nothing gets better. As a solid the body costs less.",
                          where_body(i), body.name, body.spacing, fit.thickness));
        continue;
      }
      const double across = thin_section<D>(body) / body.spacing;
      constexpr double shown = 0.005;  // half of the last digit that the sentences show
      if (across < 2 - shown) {
        fail(where_body(i), fmt::format("'{}' is {:.3g} particles across at the spacing {:.4g} m, but needs at least 2 (better 4); use a "
                                        "spacing of at most {:.3g} m.",
                                        body.name, across, body.spacing, across * body.spacing / 2));
      }
      look_at_teeth(body, where_body(i));
    }
  }

  // Faces that the lattice of a body cuts askew have teeth, which bear next to nothing.
  void look_at_teeth(const StructureBody& body, const std::string& where) {
    const double across = toothed_section<D>(body) / body.spacing;
    if (across == 0) return;
    const auto softer = [](double particles) { return std::pow(1 - 2 * lost_at_teeth / particles, -3) - 1; };
    if (softer(across) < said_softness) return;
    const double fine = 2 * lost_at_teeth / (1 - std::cbrt(1 / (1 + said_softness)));  // softer(fine) = said_softness
    scene_.warnings.push_back(fmt::format(
        "{}: the particles of the elastic body '{}' lie along straight lines, which its thin part, {:.3g} particles across, does not: it "
        "may bend as much as {:.2g} % too far. As a shell (model = \"shell\"), where its shape allows that, it has no such error; as a "
        "solid a spacing of {:.2g} m leaves at most {:.0f} %.",
        where, body.name, across, 100 * softer(across), across * body.spacing / fine, 100 * said_softness));
  }

  // Expressions have to be finite wherever a particle starts.
  void check_initial_values() const {
    const auto check = [&](const VectorExpression& field, const auto& points, const std::string& where, const std::string& name) {
      for (int d = 0; d < D; ++d) {
        if (field[d].is_constant()) continue;
        if (name == "velocity" && field[d].depends_on('t')) {
          fail(where, fmt::format("the initial velocity '{}' depends on t; use x, y and z only.", field[d].text()));
        }
        for (const Vector<D>& x : points) {
          double value = 0;
          try {
            value = field[d](0, x[0], x[1], D == 3 ? x[D - 1] : 0);
          } catch (const NumericalFailure& fault) {
            fail(where, fmt::format("{}: {}", name, fault.what()));
          }
          if (std::abs(value) > a_speed.highest) {
            fail(where,
                 fmt::format("{}: '{}' is {:.3g} at {}, but has to be {}.", name, field[d].text(), value, text(x), describe(a_speed)));
          }
        }
      }
    };
    const std::string& gravity = settings_.at("gravity").where;
    for (std::size_t i = 0; i < fluid().size(); ++i) {
      const Bounds<D> bounds = bounding_box<D>(fluid()[i].shape);
      check(scene_.gravity, std::array{Vector<D>(0.5 * (bounds.min + bounds.max))}, gravity,
            "gravity");  // where the estimate of the steps takes it
      check(scene_.gravity, fluid_points_[i], gravity, "gravity");
      check(fluid()[i].velocity, fluid_points_[i], where_fluid(i), "velocity");
    }
    for (std::size_t i = 0; i < structure().size(); ++i) {
      check(scene_.gravity, structure_points_[i], gravity, "gravity");
      check(structure()[i].velocity, structure_points_[i], where_body(i), "velocity");
    }
  }

  Case& scene_;
  const Setting& settings_;
  std::vector<LatticePoints<D>> fluid_points_, structure_points_;
};

}  // namespace

namespace {

struct Section {
  double thickness = 0, area = 0;  ///< behind a patch of the surface [m, m^(D-1)]
  bool is_sheet = false;           ///< the opposite face is parallel
  bool is_askew = false;           ///< the face is not along the lattice
};

template <int D>
std::vector<Section> sections_of(const StructureBody& body) {
  if (body.shape.kind == Shape::Kind::box) {
    const Bounds<D> bounds = bounding_box<D>(body.shape);
    const Vector<D> sides = bounds.max - bounds.min;
    std::vector<Section> sections;
    for (int d = 0; d < D; ++d) sections.push_back({sides[d], 2 * sides.prod() / sides[d], true, false});
    return sections;
  }
  const auto surface = sample_surface<D>(body.shape, body.spacing);
  const Matrix<D> axes = lattice_axes<D>(body.shape);
  std::vector<Section> sections;
  for (std::size_t k = 0; k < surface.area.size(); ++k) {
    const Vector<D>&x = surface.position[k], &normal = surface.normal[k];
    const double section = thickness<D>(body.shape, x, normal), reach = 1e-6 * body.spacing;
    Vector<D> opposite;  // normal where the ray leaves
    for (int d = 0; d < D; ++d) {
      const Vector<D> leaves = x - section * normal, step = reach * Vector<D>::Unit(d);
      opposite[d] = signed_distance<D>(body.shape, leaves + step) - signed_distance<D>(body.shape, leaves - step);
    }
    const Vector<D> along = axes.transpose() * normal;
    sections.push_back(
        {section, surface.area[k], normal.dot(opposite.normalized()) < -0.95, along.cwiseAbs().maxCoeff() < std::cos(least_askew)});
  }
  return sections;
}

/// The thickness below which this fraction of all sections lies, counting those that are `taken`; 0: fewer are.
template <class Taken>
double section_of(std::vector<Section> sections, double fraction, const Taken& taken) {
  std::sort(sections.begin(), sections.end(), [](const Section& a, const Section& b) { return a.thickness < b.thickness; });
  double total = 0, below = 0;
  for (const Section& section : sections) total += section.area;
  for (const Section& section : sections) {
    if (!taken(section)) continue;
    below += section.area;
    if (below >= fraction * total) return section.thickness;
  }
  return 0;
}

}  // namespace

template <int D>
double thin_section(const StructureBody& body) {
  const std::vector<Section> sections = sections_of<D>(body);
  const double thin = section_of(sections, least_share_of_sheet, [](const Section& section) { return section.is_sheet; });
  return thin > 0 ? thin : section_of(sections, 0.5, [](const Section&) { return true; });
}

template <int D>
double toothed_section(const StructureBody& body) {
  const Bounds<D> bounds = bounding_box<D>(body.shape);
  const double thin = thin_for_its_size * (bounds.max - bounds.min).maxCoeff();
  return section_of(sections_of<D>(body), least_share_of_sheet,
                    [&](const Section& section) { return section.is_sheet && section.is_askew && section.thickness <= thin; });
}

template double thin_section<2>(const StructureBody&);
template double thin_section<3>(const StructureBody&);
template double toothed_section<2>(const StructureBody&);
template double toothed_section<3>(const StructureBody&);

template <int D>
void fit_spacing_of_fluid(Case& scene, const Setting& settings) {
  const std::vector<FluidBody>& bodies = scene.fluid->bodies;
  const double asked = scene.fluid->spacing;
  std::vector<double> whole;
  for (const FluidBody& body : bodies) whole.push_back(volume<D>(body.shape, asked));
  const auto particles_of = [&](std::size_t i, double spacing) { return fill_with_fluid<D>(bodies[i].shape, spacing).size(); };
  /// The body whose mass is farthest from that of its shape, and by how much.
  const auto worst = [&](double spacing) {
    std::pair<std::size_t, double> result{0, 0};
    for (std::size_t i = 0; i < bodies.size(); ++i)
      if (const double error = mass_error<D>(particles_of(i, spacing), spacing, whole[i]); std::abs(error) > std::abs(result.second))
        result = {i, error};
    return result;
  };
  const auto [body, error] = worst(asked);
  if (std::abs(error) <= refused_mass_error || particles_of(body, asked) == 0) return;
  double fits = asked;
  do {
    fits = better_spacing<D>(fill_with_fluid<D>, bodies[body].shape, fits, whole[body]);
  } while (fits >= finest_fit * asked && std::abs(worst(fits).second) > said_mass_error);
  if (fits < finest_fit * asked) return;  // check_placement() refuses it
  scene.warnings.push_back(
      fmt::format("{}: at the spacing {:.4g} m the {} particles of fluid body {} have {:.2g} % {} mass than its shape; {:.3g} m is taken.",
                  settings.at("fluid").at("spacing").where, asked, particles_of(body, asked), body + 1, 100 * std::abs(error),
                  error > 0 ? "more" : "less", fits));
  scene.fluid->spacing = fits;
}

template <int D>
void fit_spacings_of_bodies(Case& scene, const Setting& settings) {
  if (!scene.structure) return;
  for (std::size_t i = 0; i < scene.structure->bodies.size(); ++i) {
    StructureBody& body = scene.structure->bodies[i];
    if (body.is_shell) continue;  // its particles have the areas of their cells
    const std::size_t particles = fill_lattice<D>(body.shape, body.spacing).size();
    const double whole = volume<D>(body.shape, body.spacing), now = mass_error<D>(particles, body.spacing, whole);
    if (particles == 0 || std::abs(now) <= refused_mass_error) continue;
    const double fits = better_spacing<D>(fill_lattice<D>, body.shape, body.spacing, whole);
    if (fits < finest_fit * body.spacing ||
        std::abs(mass_error<D>(fill_lattice<D>(body.shape, fits).size(), fits, whole)) > said_mass_error)
      continue;  // check_placement() refuses it
    scene.warnings.push_back(
        fmt::format("{}: at the spacing {:.4g} m the {} particles of the elastic body '{}' have {:.2g} % {} mass than its shape; {:.3g} m "
                    "is taken.",
                    settings.at("structure").at("body").items[i].where, body.spacing, particles, body.name, 100 * std::abs(now),
                    now > 0 ? "more" : "less", fits));
    body.spacing = fits;
  }
}

template <int D>
void check_placement(Case& scene, const Setting& settings) {
  PlacementCheck<D>(scene, settings).run();
}

template void fit_spacing_of_fluid<2>(Case&, const Setting&);
template void fit_spacing_of_fluid<3>(Case&, const Setting&);
template void fit_spacings_of_bodies<2>(Case&, const Setting&);
template void fit_spacings_of_bodies<3>(Case&, const Setting&);
template void check_placement<2>(Case&, const Setting&);
template void check_placement<3>(Case&, const Setting&);

}  // namespace tern
