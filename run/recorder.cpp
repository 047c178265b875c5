#include "run/recorder.hpp"

#include <algorithm>
#include <cmath>

namespace tern {
namespace {

std::vector<std::string> with_time(std::vector<std::string> columns) {
  columns.insert(columns.begin(), "t_s");
  return columns;
}

}  // namespace

Ticks next_multiple(double interval, Ticks now) {
  const double index = std::floor(seconds(now) / interval * (1 + 1e-12)) + 1;
  const Ticks next = to_ticks(index * interval);
  return next > now ? next : to_ticks((index + 1) * interval);
}

void RowSchedule::written(Ticks now) {
  if (interval_ > 0) next_ = next_multiple(interval_, now);
}

Recorder::Recorder(const std::string& directory, std::vector<std::string> gauge_columns, std::vector<std::string> energy_columns,
                   double gauge_interval, bool anew)
    : gauges_(directory + "/gauges.csv", with_time(std::move(gauge_columns)), anew),
      energy_(directory + "/energy.csv", with_time(std::move(energy_columns)), anew),
      steps_(directory + "/steps.csv", {"t_s", "dt_s", "limit", "pressure_iterations", "wall_ms"}, anew),
      rows_(gauge_interval) {}

void Recorder::account(Ticks now, const GaugeValues& gauges, const std::vector<double>& energies) {
  if (!rows_.due(now)) return;
  rows_.written(now);
  const double t = seconds(now);
  GaugeValues row{t};
  row.insert(row.end(), gauges.begin(), gauges.end());
  gauges_.row(row);
  std::vector<double> account{t};
  account.insert(account.end(), energies.begin(), energies.end());
  energy_.row(account);
}

void Recorder::step(Ticks now, Ticks duration, const std::string& limit, int iterations, double wall_seconds) {
  steps_.row({seconds(now), seconds(duration), limit, iterations >= 0 ? Cell(iterations) : Cell(), 1e3 * wall_seconds});
}

void Recorder::flush() {
  gauges_.flush();
  energy_.flush();
  steps_.flush();
}

void Recorder::sync() {
  gauges_.sync();
  energy_.sync();
  steps_.sync();
}

void Recorder::go_back(const Mark& mark) {
  gauges_.go_back_to_lines(mark.gauge_lines);
  energy_.go_back(mark.energy);
  steps_.go_back(mark.steps);
  RowSchedule::for_each_field([](const char*, const Ticks& told, Ticks& own) { own = told; }, mark.rows, rows_);
}

Ticks FrameSchedule::next(Ticks now, Ticks last_window) const {
  if (interval_ <= 0) return end_;
  Ticks next = next_multiple(interval_, now);
  if (2 * (next - now) < last_window) next = next_multiple(interval_, next);
  return end_ - next < to_ticks(0.5 * interval_) ? end_ : next;
}

}  // namespace tern
