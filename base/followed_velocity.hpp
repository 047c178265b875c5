#pragma once
// The velocity at the end of a window that the fluid is given of what bounds it, from how that moves in the window.

namespace tern {

/// What the fluid is given of the motion of a surface point or of a wall at the end of a window: the velocity [m/s] it has to follow, and
/// the velocity of which the mean over the window was made.
template <class Velocity>
struct FollowedVelocity {
  Velocity given, own;
};

namespace following {
inline constexpr double left = 0.2;
inline constexpr double alpha_m = (3 - left) / (2 + 2 * left), alpha_f = 1 / (1 + left), gamma = 0.5 + alpha_m - alpha_f;
/// As so many times as heavy as it is a body that nothing holds follows a load that is constant in the window: 1.19.
inline constexpr double mass_of_free_body = 2 * gamma * alpha_f / alpha_m;
}  // namespace following

/// From the mean velocity in the window and what was followed at its begin: the generalised-alpha method for dx/dt = w (Jansen, Whiting,
/// Hulbert 2000) with the displacement of the structure as its increment. The motion at the end itself will not do: sub-steps resolve the
/// oscillations of a body that is held by its stiffness, and at that instant it may move against the load. From its mean velocity it never
/// does, so that the coupling is stable for every stiffness and mass (tests/coupler/interface_velocity_test.cpp). Second order in the
/// window; of a motion too fast for the windows a fifth is left from one to the next. `own` is that of a third of a window before
/// `given`. So what they differ by is that of the last window, and becomes that of this one with the `ratio` of this one's length to its.
template <class Velocity>
FollowedVelocity<Velocity> followed_velocity(const Velocity& mean, FollowedVelocity<Velocity> at_begin, double ratio) {
  using following::alpha_f, following::alpha_m, following::gamma;
  at_begin.own = at_begin.given + ratio * (at_begin.own - at_begin.given);
  const Velocity own = (mean - (1 - gamma) * at_begin.own) / gamma;
  return {((1 - alpha_m) * at_begin.own + alpha_m * own - (1 - alpha_f) * at_begin.given) / alpha_f, own};
}

}  // namespace tern
