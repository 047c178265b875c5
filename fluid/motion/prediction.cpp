#include "fluid/motion/prediction.hpp"

#include <algorithm>

#include "base/parallel.hpp"

namespace tern::fluid {

template <int D>
void predict(const Gravity<D>& gravity, const Window& window, const State<D>& state, Prediction<D>& prediction) {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(state.size());
  prediction.gravity.resize(n);
  prediction.velocity.resize(n);
  prediction.position.resize(n);
  const double middle = window.begin + 0.5 * window.duration;
  const Vector<D> everywhere = gravity.at(middle, Vector<D>::Zero());
  parallel_for(n, [&](std::ptrdiff_t i) {
    prediction.position[i] = state.position[i] + 0.5 * window.duration * state.velocity[i];
    prediction.gravity[i] = everywhere;
  });
  // One expression cannot be evaluated by two threads.
  if (!gravity.uniform())
    for (std::ptrdiff_t i = 0; i < n; ++i) prediction.gravity[i] = gravity.at(middle, prediction.position[i]);
  parallel_for(n, [&](std::ptrdiff_t i) { prediction.velocity[i] = state.velocity[i] + window.duration * prediction.gravity[i]; });
}

template <int D>
void wrap_into_period(const Period<D>& period, State<D>& state, Prediction<D>& prediction) {
  if (!period.any()) return;
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(state.size());
  parallel_for(n, [&](std::ptrdiff_t i) {
    const Vector<D> shift = period.into(prediction.position[i]);
    prediction.position[i] += shift;
    state.position[i] += shift;
  });
}

template <int D>
void sort_in_rows(const Ranks& ranks, double spacing, double support, State<D>& state, Prediction<D>& prediction, RowOrder<D>& rows) {
  const std::ptrdiff_t n = static_cast<std::ptrdiff_t>(state.size());
  struct Box {
    Vector<D> low, high;
  };
  const Vector<D> somewhere = n > 0 ? prediction.position[0] : Vector<D>(Vector<D>::Zero());
  const Box box = ordered_fold(
      n, Box{somewhere, somewhere},
      [&](std::ptrdiff_t i) {
        return Box{prediction.position[i], prediction.position[i]};
      },
      [](const Box& a, const Box& b) {
        return Box{a.low.cwiseMin(b.low), a.high.cwiseMax(b.high)};
      });
  // Pairs are found in single precision, counted from this corner: with the same one on all ranks they are the same pairs everywhere.
  Vector<D> low = n > 0 ? box.low : Vector<D>(Vector<D>::Constant(1e300));
  Vector<D> high = n > 0 ? box.high : Vector<D>(Vector<D>::Constant(-1e300));
  ranks.extremes(std::span(low.data(), D), std::span(high.data(), D));
  if (low[0] > high[0]) low = high = somewhere;
  const double width = row_width(D) * spacing;
  rows.grid.reset(low, high, support, width);
  rows.corner = rows.grid.origin();
  rows.extent = rows.grid.extent();
  if (!ranks.alone()) rows.grid.reset(box.low, box.high, support, width);
  CellContents& contents = rows.contents;
  fill_rows(
      rows.grid, prediction.position, [&](int a, int b) { return state.id[a] < state.id[b]; }, contents);
  const auto reorder = [&](auto& values, auto& scratch) {
    scratch.resize(n);
    parallel_for(n, [&](std::ptrdiff_t i) { scratch[i] = values[contents.order[i]]; });
    values.swap(scratch);
  };
  for_each_particle_field(
      state, [&]<class T>(const char*, const char*, std::vector<T>& values) { reorder(values, std::get<std::vector<T>>(rows.sorted)); });
  for (auto* values : {&prediction.position, &prediction.velocity, &prediction.gravity})
    reorder(*values, std::get<std::vector<Vector<D>>>(rows.sorted));
  // Particles now lie in this order, so the cell lists are the identity.
  parallel_for(n, [&](std::ptrdiff_t i) { contents.order[i] = static_cast<int>(i); });
}

template void predict<2>(const Gravity<2>&, const Window&, const State<2>&, Prediction<2>&);
template void predict<3>(const Gravity<3>&, const Window&, const State<3>&, Prediction<3>&);
template void wrap_into_period<2>(const Period<2>&, State<2>&, Prediction<2>&);
template void wrap_into_period<3>(const Period<3>&, State<3>&, Prediction<3>&);
template void sort_in_rows<2>(const Ranks&, double, double, State<2>&, Prediction<2>&, RowOrder<2>&);
template void sort_in_rows<3>(const Ranks&, double, double, State<3>&, Prediction<3>&, RowOrder<3>&);

}  // namespace tern::fluid
