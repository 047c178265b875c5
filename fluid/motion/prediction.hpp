#pragma once
// Where the particles are at the middle of the window, and in what order.

#include "fluid/reference.hpp"
#include "fluid/state.hpp"
#include "fluid/workspace.hpp"
#include "ranks/ranks.hpp"

namespace tern::fluid {

/// r* = r^n + dt/2 u^n, u* = u^n + dt g, and g at r* and the middle of the window.
template <int D>
void predict(const Gravity<D>& gravity, const Window& window, const State<D>& state, Prediction<D>& prediction);

/// Brings particles that have left the period back into it.
template <int D>
void wrap_into_period(const Period<D>& period, State<D>& state, Prediction<D>& prediction);

/// Puts all fields of the particles in the order of rows for this spacing and support [m]. The order depends on positions and labels alone.
template <int D>
void sort_in_rows(const Ranks& ranks, double spacing, double support, State<D>& state, Prediction<D>& prediction, RowOrder<D>& rows);

}  // namespace tern::fluid
