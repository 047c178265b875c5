#pragma once
// The mass with which the surface answers, learnt. A formula on the section behind a point is wrong wherever an elastic wave, a corner, a
// shell or a foreign solver is behind it. But every window that is tested moves the structure twice, under two loads: the change of the
// velocity at its end over the change of the load is the answer.
//
//   a_k = sum dw_k dp_k / sum dp_k^2        m_k = dt/a_k        sums over the windows so far, with four fifths kept per window
//
// dw the change of the normal velocity, dp that of the load per area. The mean of both gives the least squares fit of dw = a dp.

#include <vector>

namespace tern::coupler {

class LearntMass {
 public:
  /// What one window has shown: changes of the load per area [Pa] and of the acceleration dw/dt that followed [m/s^2], normal components,
  /// one per surface point; 0 where a point is dry. Points whose load hardly changes, beside the others, show nothing.
  void add(const std::vector<double>& load, const std::vector<double>& acceleration);

  /// Mass per area of point k, between a twentieth of `guess` and four times that; the guess where nothing is known [kg/m^2].
  double at(std::size_t k, double guess) const;

  /// The list of the members: visit(name, member of each) for every one.
  template <class Visit, class... Same>
  static void for_each_field(Visit&& visit, Same&... all) {
    visit("answer", all.answer_...);
    visit("load", all.load_...);
  }

 private:
  std::vector<double> answer_, load_;  ///< sums of the products and of the squares
};

}  // namespace tern::coupler
