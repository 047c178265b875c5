#include "fluid/gauges/gauges.hpp"

#include <algorithm>

#include "fluid/gauges/probe.hpp"

namespace tern::fluid {
namespace {

/// The fluid and the probes into it, which are made for the first gauge that needs them.
template <int D>
class Instruments {
 public:
  explicit Instruments(const Fluid<D>& of) : fluid(of) {}
  /// For gauges of pressure and force.
  const Probe<D>& in_middle() { return made(in_middle_, Moment::middle); }
  /// For gauges of places and velocities.
  const Probe<D>& at_end() { return made(at_end_, Moment::end); }

  const Fluid<D>& fluid;

 private:
  const Probe<D>& made(std::optional<Probe<D>>& probe, Moment moment) {
    if (!probe) probe.emplace(fluid, moment);
    return *probe;
  }
  std::optional<Probe<D>> in_middle_, at_end_;
};

/// How one kind of gauge is evaluated.
template <int D>
struct Evaluation {
  const char* kind;
  bool of_pressure;  ///< without value before the first solve
  void (*append)(const GaugeCase&, Instruments<D>&, GaugeValues&);
};

template <int D>
void append_force(const GaugeCase& gauge, Instruments<D>& at, GaugeValues& values) {
  const auto total = at.in_middle().force(at.fluid.walls().find(gauge.text("wall")), gauge.place<D>("at"));
  if (!total) return values.resize(values.size() + gauge_columns(gauge, D).size());
  values.insert(values.end(), total->force.data(), total->force.data() + D);
  values.insert(values.end(), total->moment.data() + (D == 2 ? 2 : 0), total->moment.data() + 3);
}

template <int D>
void append_sensor(const GaugeCase& gauge, Instruments<D>& at, GaugeValues& values) {
  values.push_back(at.in_middle().sensor(at.fluid.walls().find(gauge.text("wall")), gauge.place<D>("at"), gauge.number("diameter")));
}

/// One entry per kind.
template <int D>
const std::vector<Evaluation<D>>& evaluations() {
  using G = const GaugeCase&;
  using I = Instruments<D>&;
  static const std::vector<Evaluation<D>> list = {
      {"pressure", true, [](G gauge, I at, GaugeValues& values) { values.push_back(at.in_middle().pressure(gauge.place<D>("at"))); }},
      {"elevation", false, [](G gauge, I at, GaugeValues& values) { values.push_back(at.at_end().elevation(gauge.place<D>("at"))); }},
      {"front", false, [](G, I at, GaugeValues& values) { values.push_back(at.at_end().front()); }},
      {"force", false, append_force<D>},
      {"wall_pressure", false, append_sensor<D>},
      {"flux", false,
       [](G gauge, I at, GaugeValues& values) { values.push_back(at.at_end().flux(gauge.place<D>("from"), gauge.place<D>("to"))); }},
  };
  return list;
}

}  // namespace

template <int D>
GaugeValues gauge_values(const Fluid<D>& fluid, const Case& scene) {
  GaugeValues values;
  Instruments<D> instruments(fluid);
  const auto& all = evaluations<D>();
  for (const GaugeCase& gauge : scene.gauges) {
    if (owner(gauge) != GaugeOwner::fluid) continue;
    const auto& evaluation = *std::find_if(all.begin(), all.end(), [&](const auto& e) { return gauge.kind == e.kind; });
    if (evaluation.of_pressure && !fluid.has_pressure()) {
      values.resize(values.size() + gauge_columns(gauge, D).size());
    } else {
      evaluation.append(gauge, instruments, values);
    }
  }
  return values;
}

template GaugeValues gauge_values<2>(const Fluid<2>&, const Case&);
template GaugeValues gauge_values<3>(const Fluid<3>&, const Case&);

}  // namespace tern::fluid
