#include "coupler/gauges/gauges.hpp"

namespace tern::coupler {
namespace {

template <int D>
void append_interface_force(const GaugeCase& gauge, const Coupler<D>& coupler, const Case& scene, GaugeValues& values) {
  if (coupler.state().totals.windows == 0) return values.resize(values.size() + D);  // before the first pressure solve
  const Vector<D> load = coupler.total_load(body_index(gauge, scene));
  values.insert(values.end(), load.data(), load.data() + D);
}

/// How one kind of gauge is evaluated.
template <int D>
struct Evaluation {
  const char* kind;
  void (*append)(const GaugeCase&, const Coupler<D>&, const Case&, GaugeValues&);
};

}  // namespace

template <int D>
GaugeValues gauge_values(const Coupler<D>& coupler, const Case& scene) {
  const Evaluation<D> evaluations[] = {{"interface_force", append_interface_force<D>}};  // one entry per kind
  GaugeValues values;
  for (const GaugeCase& gauge : scene.gauges)
    for (const Evaluation<D>& evaluation : evaluations)
      if (gauge.kind == evaluation.kind) evaluation.append(gauge, coupler, scene, values);
  return values;
}

template GaugeValues gauge_values<2>(const Coupler<2>&, const Case&);
template GaugeValues gauge_values<3>(const Coupler<3>&, const Case&);

}  // namespace tern::coupler
