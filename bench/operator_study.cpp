// What each numerical option of the fluid does to five small scenes, one option at a time around the defaults; prints
// the tables of docs/OPERATORS.md, which also has the figures of forms that are not options any more. A run that fails is
// a row that says why.
//
//   bench-operator_study                       all scenes: tank deep wave vortices patch dam
//   bench-operator_study wave dam              some of them
//   bench-operator_study tank shifting=2,noise_damping=0 courant=0.3
//                                              other settings of [fluid.numerics] than the list below, one row each
//   bench-operator_study deep fluid.spacing=0.00625
//                                              a key with a dot is one of the whole case

#include <unistd.h>

#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <numbers>
#include <sstream>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "base/error.hpp"
#include "fixtures/fluid_scenes.hpp"

namespace {

using namespace tern;
using namespace tern::fluid;
using namespace tern::fluid::testing;

constexpr double pi = std::numbers::pi;
constexpr long most_steps = 15000;  ///< several times what the defaults need: the step has collapsed
constexpr int most_fallbacks = 20;  ///< solves that the multigrid could not do

struct Variant {
  std::string name, settings;
  double disorder = 0;  ///< random displacement of all particles at the start [dx], on top of the scene's own
};

// The same flow from positions that differ by a thousandth of the spacing: how far two rows may differ and mean nothing.
const std::vector<Variant> variants = {
    {"default", ""},
    {"default, moved by 0.001 dx", "", 0.001},
    {"default, moved by 0.002 dx", "", 0.002},
    {"gradient: sum", "gradient=sum"},
    {"gradient: gc (blend, theta 0)", "blend_theta=0"},
    {"gradient: blend, theta 0.2", "blend_theta=0.2"},
    {"gradient: blend, theta 0.5", "blend_theta=0.5"},
    {"source: HS alone", "density_relaxation=0"},
    {"source: density relaxation 0.1", "density_relaxation=0.1"},
    {"shifting 0", "shifting=0"},
    {"shifting 0.5", "shifting=0.5"},
    {"shifting 2", "shifting=2"},
    {"shifting 4", "shifting=4"},
    {"noise damping 0", "noise_damping=0"},
    {"noise damping 0.1", "noise_damping=0.1"},
    {"noise damping 0.5", "noise_damping=0.5"},
    {"h/dx 1.2", "smoothing_length_ratio=1.2"},
    {"h/dx 1.3", "smoothing_length_ratio=1.3"},
    {"h/dx 2", "smoothing_length_ratio=2"},
};

using Cells = std::vector<std::string>;
/// Called after each step; throws NumericalFailure when the run is beyond saving.
using Observe = std::function<void()>;

struct Scene {
  std::string name, title;
  Cells columns;
  std::string text;  ///< the case file
  std::string own;   ///< settings this scene needs
  double end, disorder;
  std::function<Cells(Fluid<2>&, const std::function<void(const Observe&)>& run)> measure;
};

double time_of(const Fluid<2>& f) { return seconds(f.state().time); }

double mean_height(const Fluid<2>& f) {
  double sum = 0;
  for (const auto& x : f.state().position) sum += x[1];
  return sum / static_cast<double>(f.state().size());
}

std::string percent(double x) { return fmt::format("{:+.2f}", 100 * x); }
std::string scientific(double x) { return fmt::format("{:.1e}", x); }

Cells measure_tank(Fluid<2>& f, const std::function<void(const Observe&)>& run) {
  const double before = mean_height(f);
  double kinetic = 0, fastest = 0, slope = 0, noise = 0;
  long n = 0;
  run([&] {
    if (time_of(f) < 2) return;
    const PressureLine line = fit_pressure(f, 0.9);
    kinetic += f.energies().kinetic / (density * gravity), slope += -line.slope / (density * gravity);
    noise += line.noise / (density * gravity);
    fastest = std::max(fastest, f.largest_speed() / std::sqrt(gravity));
    ++n;
  });
  const double count = static_cast<double>(n);
  return {scientific(kinetic / count), fmt::format("{:.4f}", fastest),       percent(slope / count - 1),
          scientific(noise / count),   percent(mean_height(f) / before - 1), percent(f.volume_drift().inside)};
}

Cells measure_deep(Fluid<2>& f, const std::function<void(const Observe&)>& run) {
  double pressure = 0, fastest = 0;
  run([&] {
    for (double p : f.state().pressure) pressure = std::max(pressure, std::abs(p) / (density * gravity));
    fastest = std::max(fastest, f.largest_speed() / std::sqrt(gravity));
  });
  return {fmt::format("{:.2f}", pressure), fmt::format("{:.3f}", fastest)};
}

Cells measure_wave(Fluid<2>& f, const std::function<void(const Observe&)>& run) {
  const double k = pi, cell = f.constants().volume;
  const auto amplitude = [&] {
    double sum = 0;
    for (const auto& x : f.state().position) sum += x[1] * std::cos(k * x[0]);
    return sum * cell;  // 2/L of the integral over the column, L = 2 m
  };
  const double linear = 2 * pi / std::sqrt(gravity * k * std::tanh(k)), start = amplitude(), before = mean_height(f);
  double last = start, last_time = 0, peak = 0, crossing = -1, measured = 0, expected = 0, final_peak = 0;
  run([&] {
    const double now = amplitude(), t = time_of(f);
    if (now * last < 0) {
      const double at = last_time + (t - last_time) * last / (last - now);
      if (crossing >= 0) {
        measured += at - crossing;
        expected += linear / 2 * (1 + k * k * peak * peak / 8);  // third order, deep water
        final_peak = peak;
      }
      crossing = at, peak = 0;
    }
    peak = std::max(peak, std::abs(now)), last = now, last_time = t;
  });
  return {fmt::format("{:.3f}", final_peak / start), percent(measured / expected - 1), percent(mean_height(f) / before - 1),
          percent(f.volume_drift().inside)};
}

Cells measure_vortices(Fluid<2>& f, const std::function<void(const Observe&)>& run) {
  const double start = f.energies().kinetic, rate = 16 * pi * pi / 100;
  run([] {});
  const double t = time_of(f), u = std::exp(-rate / 2 * t);
  double error = 0;
  for (std::size_t i = 0; i < f.state().size(); ++i) {
    const auto& x = f.state().position[i];
    const Vector<2> exact(-u * std::cos(2 * pi * x[0]) * std::sin(2 * pi * x[1]), u * std::sin(2 * pi * x[0]) * std::cos(2 * pi * x[1]));
    error += (f.state().velocity[i] - exact).squaredNorm();
  }
  return {percent(std::log(start / f.energies().kinetic) / (rate * t) - 1),
          percent(std::sqrt(error / static_cast<double>(f.state().size())) / (u * std::sqrt(0.5))),
          fmt::format("{:.3f}", f.largest_speed() / u), percent(f.volume_drift().inside)};
}

Cells measure_patch(Fluid<2>& f, const std::function<void(const Observe&)>& run) {
  const auto angular = [&] {
    double sum = 0;
    for (std::size_t i = 0; i < f.state().size(); ++i) {
      const auto &x = f.state().position[i], &u = f.state().velocity[i];
      sum += x[0] * u[1] - x[1] * u[0];
    }
    return sum;
  };
  const double energy = f.energies().kinetic, momentum = angular();
  double centre = 0;
  long n = 0;
  run([&] {
    if (++n == 3) centre = f.pressure_at(Vector<2>::Zero()).value_or(0) / (4 * density);
  });
  double far = 0;
  for (const auto& x : f.state().position) far = std::max(far, x.norm());
  return {fmt::format("{:.4f}", centre),
          fmt::format("{:.4f}", f.energies().kinetic / energy),
          fmt::format("{:.4f}", angular() / momentum),
          fmt::format("{:.3f}", far),
          fmt::format("{:.2f}", f.largest_speed()),
          percent(f.volume_drift().inside),
          fmt::format("{}", f.spray_particles())};
}

Cells measure_dam(Fluid<2>& f, const std::function<void(const Observe&)>& run) {
  const double weight = f.constants().mass * gravity, start = mean_height(f) * weight * static_cast<double>(f.state().size());
  double fastest = 0, lowest = 1e300, gain = 0, impact = 0, drift = 0;
  long n = 0, iterations = 0;
  int most = 0;
  const std::clock_t begin = std::clock();
  run([&] {
    ++n, iterations += f.last_solve().iterations, most = std::max(most, f.last_solve().iterations);
    const double energy = (mean_height(f) * weight * static_cast<double>(f.state().size()) + f.energies().kinetic) / start;
    lowest = std::min(lowest, energy), gain = std::max(gain, energy - lowest);
    fastest = std::max(fastest, f.largest_speed());
    if (time_of(f) < 0.5) impact = energy;
    if (std::abs(f.volume_drift().inside) > std::abs(drift)) drift = f.volume_drift().inside;
  });
  const double energy = (mean_height(f) * weight * static_cast<double>(f.state().size()) + f.energies().kinetic) / start;
  const double seconds_taken = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  return {fmt::format("{:.2f}", fastest),
          fmt::format("{:.3f}", impact),
          fmt::format("{:.3f}", energy),
          scientific(gain),
          percent(drift),
          fmt::format("{}", f.leaked()),
          fmt::format("{:.1f}", double(iterations) / double(n)),
          fmt::format("{}", most),
          fmt::format("{}", n),
          fmt::format("{:.1f}", 1e3 * seconds_taken / double(n))};
}

std::string wave_polygon() {
  std::string text = "[[0, 0], [2, 0]";
  for (int q = 100; q >= 0; --q) text += fmt::format(", [{}, {}]", q / 50.0, 1 + 0.1 * std::cos(pi * q / 50.0));
  return text + "]";
}

std::string case_text(double end, double g, const std::string& fluid, const std::string& rest) {
  return fmt::format("dimension = 2\nend_time = {}\ngravity = [0, {}]\n[fluid]\ndensity = 1000\n{}{}", end, -g, fluid, rest);
}

std::string tank_text(double width, double height) {
  return fmt::format("[[wall]]\nname = \"tank\"\ncontainer = {{ box = {{ min = [0, 0], max = [{}, {}] }} }}\nopen = [\"y_max\"]\n", width,
                     height);
}

std::string box_text(double x0, double y0, double x1, double y1, const std::string& velocity = "") {
  return fmt::format("[[fluid.body]]\nshape = {{ box = {{ min = [{}, {}], max = [{}, {}] }} }}\n{}", x0, y0, x1, y1, velocity);
}

std::vector<Scene> scenes() {
  const double wave_end = 5.4 * 2 * pi / std::sqrt(gravity * pi * std::tanh(pi));
  return {
      {"tank",
       "Tank at rest, 1 m x 1 m, dx = 0.05 m, particles displaced by up to 0.1 dx, 4 s; means over the last 2 s",
       {"KE/(rho g H^2 L)", "max u/sqrt(gH)", "slope error %", "noise/(rho g H)", "centre of mass %", "volume drift %"},
       case_text(4, gravity, "spacing = 0.05\n", box_text(0, 0, 1, 1) + tank_text(1, 2)),
       "",
       4,
       0.1,
       measure_tank},
      {"deep",
       "First 0.02 s of a tank at rest of 80 layers, particles displaced by up to 0.1 dx",
       {"largest p/(rho g H)", "max u/sqrt(gH)"},
       case_text(0.02, gravity, "spacing = 0.0125\n", box_text(0, 0, 1, 1) + tank_text(1, 2)),
       "",
       0.02,
       0.1,
       measure_deep},
      {"wave",
       "Standing wave, lambda = 2 m, depth 1 m, amplitude 0.1 m, dx = 0.04 m, 5 periods",
       {"amplitude left", "period error % (third order)", "centre of mass %", "volume drift %"},
       case_text(wave_end, gravity, "spacing = 0.04\n",
                 "[[fluid.body]]\nshape = { polygon = { vertices = " + wave_polygon() + " } }\n" + tank_text(2, 2)),
       "",
       wave_end,
       0,
       measure_wave},
      {"vortices",
       "Taylor-Green vortices, 50 x 50, Re = 100, t = 2 L/U",
       {"decay rate error %", "velocity error % (L2)", "max u/U exp(..)", "volume drift %"},
       case_text(2, 0, "spacing = 0.02\nviscosity = 10\n",
                 "[domain]\nmin = [0, 0]\nmax = [1, 1]\nperiodic = [\"x\", \"y\"]\n" +
                     box_text(0, 0, 1, 1, "velocity = [\"-cos(2*pi*x)*sin(2*pi*y)\", \"sin(2*pi*x)*cos(2*pi*y)\"]\n")),
       "",
       2,
       0,
       measure_vortices},
      {"patch",
       "Rotating square patch, 50 x 50, inviscid, omega t = 2; exact: centre p -0.147, energy and angular momentum 1",
       {"centre p/(rho omega^2 L^2), third step", "energy", "angular momentum", "farthest particle/L", "max u/(omega L/2)",
        "volume drift %", "spray"},
       case_text(1, 0, "spacing = 0.02\n",
                 "[domain]\nmin = [-2, -2]\nmax = [2, 2]\n" + box_text(-0.5, -0.5, 0.5, 0.5, "velocity = [\"2*y\", \"-2*x\"]\n")),
       "",
       1,
       0,
       measure_patch},
      {"dam",
       "Dam break, 40 x 80 particles, 0.2 m x 0.4 m, tank 0.8 m, 1 s",
       {"max u m/s", "E/E0 at 0.5 s", "E/E0 at 1 s", "largest gain of E/E0", "volume drift %", "through walls", "iterations mean", "max",
        "steps", "CPU ms/step"},
       case_text(1, gravity, "spacing = 0.005\n", box_text(0, 0, 0.2, 0.4) + tank_text(0.8, 1)),
       "",
       1,
       0,
       measure_dam},
  };
}

Case read(const Scene& scene, const std::string& settings, const std::string& folder) {
  std::ofstream(folder + "/case.toml") << scene.text;
  CaseOptions options;
  for (const std::string* list : {&scene.own, &settings}) {
    std::istringstream in(*list);
    for (std::string item; std::getline(in, item, ',');) {
      const std::size_t equals = item.find('=');
      const std::string value = item.substr(equals + 1);
      const bool number = value.find_first_not_of("0123456789.eE+-") == std::string::npos;
      const std::string key = item.substr(0, equals);
      const std::string table = key.find('.') == std::string::npos ? "fluid.numerics." : "";
      options.overrides.emplace_back(table + key, number ? value : "\"" + value + "\"");
    }
  }
  return read_case(folder, options);
}

std::string row_of(const Scene& scene, const Variant& variant, const std::string& folder) {
  std::string row = "| " + variant.name + " |";
  try {
    Fluid<2> fluid(read(scene, variant.settings, folder));
    std::mt19937 random(7);
    if (scene.disorder > 0) jitter(fluid, scene.disorder, random);
    if (variant.disorder > 0) jitter(fluid, variant.disorder, random);
    long steps = 0;
    const Cells cells = scene.measure(fluid, [&](const Observe& observe) {
      run(fluid, scene.end, [&] {
        if (++steps > most_steps)
          throw NumericalFailure(fmt::format("step below {:.1e} s at t = {:.3f} s", scene.end / most_steps, time_of(fluid)));
        if (fluid.fallback_solves() > most_fallbacks)
          throw NumericalFailure(fmt::format("multigrid failed {} times by t = {:.3f} s", most_fallbacks, time_of(fluid)));
        observe();
      });
    });
    for (const std::string& cell : cells) row += " " + cell + " |";
    if (fluid.fallback_solves() > 0) row += fmt::format(" {} solves by Jacobi", fluid.fallback_solves());
  } catch (const NumericalFailure& failure) {
    const std::string why = failure.what();
    row += " **fails:** " + why.substr(0, std::min(why.find(';'), why.find(". "))) + " |";
    for (std::size_t k = 1; k < scene.columns.size(); ++k) row += " |";
  }
  return row;
}

}  // namespace

int main(int argc, char** argv) {
  spdlog::set_level(spdlog::level::off);
  std::vector<std::string> chosen;
  std::vector<Variant> own;
  for (int k = 1; k < argc; ++k) {
    const std::string argument = argv[k];
    if (argument.find('=') == std::string::npos)
      chosen.push_back(argument);
    else
      own.push_back({argument, argument});
  }
  const std::string folder = (std::filesystem::temp_directory_path() / fmt::format("operator_study_{}", getpid())).string();
  std::filesystem::create_directories(folder);
  int result = 0;
  try {
    for (const Scene& scene : scenes()) {
      if (!chosen.empty() && std::count(chosen.begin(), chosen.end(), scene.name) == 0) continue;
      std::cout << "**" << scene.title << "**\n\n| |";
      for (const std::string& column : scene.columns) std::cout << " " << column << " |";
      std::cout << "\n|---|";
      for (std::size_t k = 0; k < scene.columns.size(); ++k) std::cout << "---|";
      std::cout << std::endl;
      for (const Variant& variant : own.empty() ? variants : own) std::cout << row_of(scene, variant, folder) << std::endl;
      std::cout << std::endl;
    }
  } catch (const std::exception& error) {
    std::cerr << error.what() << std::endl;
    result = 2;
  }
  std::filesystem::remove_all(folder);
  return result;
}
