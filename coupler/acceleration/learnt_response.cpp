#include "coupler/acceleration/learnt_response.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/followed_velocity.hpp"
#include "base/parallel.hpp"
#include "coupler/stability/added_mass.hpp"

namespace tern::coupler {
namespace {

constexpr double kept = 0.8;                       ///< of what is known, per window
constexpr double least_change = 1e-4;              ///< of a lump's square, over the mean of its body, that shows something
constexpr double lightest = 0.05, heaviest = 1e6;  ///< over the guess
/// Widths on trial, in spacings of the fluid; 0: every point by itself. A wider lump than the last one no longer fits in the kernel.
constexpr double widths[] = {0, 2.0 / 3, 1, 1.5, 2.25, 3.375};

/// The heaviest of a body that nothing holds. A load that deforms it moves it by much less than one that moves it as a whole, which it
/// answers with its mass m_s. Taken for m_p, an error of the load comes back m_a (m_p - m_s)/(m_s (m_a + m_p)) times, m_a being the fluid
/// that has to move with it: once at this limit.
double heaviest_of_free(double section_mass, double moved_mass) {
  return section_mass < moved_mass ? std::min(heaviest, 2 / (1 - section_mass / moved_mass)) : heaviest;
}

}  // namespace

template <int D>
void LearntResponse<D>::prepare(const Setup<D>& setup, const SurfaceAtStart<D>& start) {
  if (!lumps_.empty()) return;
  const SurfaceProperties& of = setup.properties;
  for (std::size_t b = 0; b < setup.is_held.size(); ++b)
    heaviest_.push_back(setup.is_held[b] ? heaviest : heaviest_of_free(section_mass(of, b), setup.moved_mass[b]));
  std::vector<double> depth(of.body.size());
  for (std::size_t k = 0; k < depth.size(); ++k)
    depth[k] = of.section_mass[k] < held_mass ? of.section_mass[k] / setup.body_density[of.body[k]] : 0;
  for (const double width : widths) {
    lumps_.push_back(width == 0 ? lumps_of_points(of.body.size()) : lumps_of_width<D>(width * setup.spacing, start, of.body, depth));
    const SurfaceLumps& lumps = lumps_.back();
    std::vector<std::uint32_t>& body_of = body_of_.emplace_back(lumps.count, 0);
    for (std::size_t s = 0; s < lumps.lump.size(); ++s)
      if (lumps.share[s] > 0) body_of[lumps.lump[s]] = of.body[s / lumps.per_point];
    if (answer_.size() >= lumps_.size()) continue;  // known from a checkpoint
    answer_.emplace_back(lumps_.back().count, 0);
    square_.emplace_back(lumps_.back().count, 0);
    error_.emplace_back(setup.body_density.size(), 0);
  }
}

template <int D>
double LearntResponse<D>::quickness(std::size_t width, std::size_t lump) const {
  if (square_[width][lump] == 0) return 1;
  return std::clamp(answer_[width][lump] / square_[width][lump], 1 / heaviest_[body_of_[width][lump]], 1 / lightest);
}

template <int D>
void LearntResponse<D>::adjust_to(double duration) {
  const double last = std::exchange(duration_, duration);
  if (last == 0 || last == duration) return;
  const double square_of_ratio = std::pow(duration / last, 2);
  for (std::size_t width = 0; width < lumps_.size(); ++width)
    for (std::size_t a = 0; a < answer_[width].size(); ++a)
      if (const double held = 1 / quickness(width, a) - following::mass_of_free_body; held > 0)
        answer_[width][a] = square_[width][a] / (following::mass_of_free_body + held * square_of_ratio);
}

template <int D>
std::size_t LearntResponse<D>::best_width(std::size_t body) const {
  std::size_t best = 0;
  for (std::size_t width = 1; width < lumps_.size(); ++width)
    if (error_[width][body] < error_[best][body]) best = width;
  return best;
}

template <int D>
std::optional<LearntOfBody> LearntResponse<D>::of_body(const Setup<D>& setup, std::size_t body) const {
  if (changed_.empty() || changed_[body] == 0) return std::nullopt;
  const std::size_t width = best_width(body);
  double slow = 0, all = 0;
  for (std::size_t k = 0; k < setup.properties.body.size(); ++k) {
    const SurfaceLumps& lumps = lumps_[width];
    if (setup.properties.body[k] != body || setup.properties.section_mass[k] >= held_mass) continue;
    for (std::size_t s = k * lumps.per_point; s < (k + 1) * lumps.per_point; ++s) {
      if (square_[width][lumps.lump[s]] == 0) continue;  // dry
      slow += lumps.share[s] / quickness(width, lumps.lump[s]);
      all += lumps.share[s];
    }
  }
  return LearntOfBody{widths[width] * setup.spacing, all > 0 ? slow / all : 1, std::sqrt(error_[width][body] / changed_[body]),
                      std::sqrt(error_[0][body] / changed_[body])};
}

template <int D>
SurfaceAnswer LearntResponse<D>::answer(const Setup<D>& setup, const std::vector<double>& guess, const std::vector<double>& area) const {
  const std::vector<std::uint32_t>& body = setup.properties.body;
  std::vector<std::size_t> chosen(setup.body_density.size());
  for (std::size_t b = 0; b < chosen.size(); ++b) chosen[b] = best_width(b);

  SurfaceAnswer made;
  for (const std::size_t width : chosen) made.lumps.per_point = std::max(made.lumps.per_point, lumps_[width].per_point);
  made.lumps.lump.reserve(made.lumps.per_point * body.size());
  made.lumps.share.reserve(made.lumps.per_point * body.size());
  std::vector<std::vector<double>> mass(lumps_.size());
  std::vector<std::vector<std::uint32_t>> number(lumps_.size());
  constexpr std::uint32_t none = std::numeric_limits<std::uint32_t>::max();
  for (const std::size_t width : chosen) {
    if (!mass[width].empty()) continue;
    mass[width] = lump_masses(lumps_[width], guess, area);
    number[width].assign(lumps_[width].count, none);
  }
  for (std::size_t k = 0; k < body.size(); ++k) {
    const std::size_t width = chosen[body[k]];
    const SurfaceLumps& from = lumps_[width];
    for (std::size_t c = 0; c < made.lumps.per_point; ++c) {
      const double share = c < from.per_point ? from.share[k * from.per_point + c] : 0;
      if (share == 0) {
        made.lumps.lump.push_back(0);
        made.lumps.share.push_back(0);
        continue;
      }
      const std::uint32_t a = from.lump[k * from.per_point + c];
      if (number[width][a] == none) {
        number[width][a] = static_cast<std::uint32_t>(made.lumps.count++);
        made.mass.push_back(mass[width][a] / quickness(width, a));
        made.gain = std::max(made.gain, 1 / quickness(width, a));
      }
      made.lumps.lump.push_back(number[width][a]);
      made.lumps.share.push_back(share);
    }
  }
  return made;
}

template <int D>
void LearntResponse<D>::learn(const Setup<D>& setup, const Workspace<D>& window, const std::vector<Vector<D>>& velocity) {
  const Surface<D>& surface = window.surface;
  const std::size_t points = velocity.size();
  std::vector<double> changed(points);
  changed_.resize(setup.body_density.size(), 0);
  for (double& square : changed_) square *= kept;
  for (std::size_t k = 0; k < points; ++k) {
    changed[k] = (velocity[k] - surface.velocity[k]).dot(surface.normal[k]);
    if (window.share[k] > 0) changed_[setup.properties.body[k]] += surface.area[k] * changed[k] * changed[k];
  }
  const auto learn_width = [&](std::ptrdiff_t width) {
    // Side by side what is added up at a lump, so that it is one sum of many lanes: the force, then the velocity by the guessed mass; and
    // last that mass, then the quickness.
    using Lump = Eigen::Matrix<double, D + 1, 1>;
    const SurfaceLumps& lumps = lumps_[width];
    const std::size_t per_point = lumps.per_point;
    std::vector<Lump> of(lumps.count, Lump::Zero());
    for (std::size_t k = 0; k < points; ++k) {
      Lump own;
      own << window.answered_load.force[k] - window.assumed_load.force[k], window.responding_mass[k] * surface.area[k];
      for (std::size_t s = k * per_point; s < (k + 1) * per_point; ++s) of[lumps.lump[s]] += lumps.share[s] * own;
    }
    for (std::size_t a = 0; a < lumps.count; ++a) {
      of[a].template head<D>() *= window.duration / of[a][D];
      of[a][D] = quickness(width, a);
    }
    const std::size_t bodies = setup.body_density.size();
    std::vector<Eigen::Vector2d> made(lumps.count, Eigen::Vector2d::Zero());
    std::vector<double> error(bodies, 0), sum(bodies, 0), number(bodies, 0);
    for (std::size_t k = 0; k < points; ++k) {
      if (window.share[k] == 0) continue;  // dry
      double by_guess = 0, foretold = 0;
      for (std::size_t s = k * per_point; s < (k + 1) * per_point; ++s) {
        const Lump& lump = of[lumps.lump[s]];
        const double part = lumps.share[s] * lump.template head<D>().dot(surface.normal[k]);
        by_guess += part;
        foretold += lump[D] * part;
      }
      error[setup.properties.body[k]] += surface.area[k] * std::pow(foretold - changed[k], 2);
      const double of_answer = surface.area[k] * changed[k] * by_guess, of_square = surface.area[k] * by_guess * by_guess;
      const Eigen::Vector2d both(of_answer, of_square);
      for (std::size_t s = k * per_point; s < (k + 1) * per_point; ++s) made[lumps.lump[s]] += lumps.share[s] * both;
      sum[setup.properties.body[k]] += of_square;
    }
    const std::vector<std::uint32_t>& body_of = body_of_[width];
    for (const std::uint32_t b : body_of) ++number[b];
    for (std::size_t a = 0; a < lumps.count; ++a) {
      if (!(made[a][1] > least_change * sum[body_of[a]] / number[body_of[a]])) continue;
      answer_[width][a] = kept * answer_[width][a] + made[a][0];
      square_[width][a] = kept * square_[width][a] + made[a][1];
    }
    for (std::size_t b = 0; b < error.size(); ++b) error_[width][b] = kept * error_[width][b] + error[b];
  };
  const auto count = static_cast<std::ptrdiff_t>(lumps_.size());
  parallel_for(count, count * static_cast<std::ptrdiff_t>(points), learn_width);
}

template class LearntResponse<2>;
template class LearntResponse<3>;

}  // namespace tern::coupler
