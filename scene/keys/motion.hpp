#pragma once
// The keys of what moves as a rigid whole: walls and clamps.

#include <filesystem>

#include "scene/keys/row.hpp"

namespace tern {

/// A member of the motion of a T; the motion comes into being with the first of its keys.
template <class T, class M>
Member<T> of_motion(M RigidMotion::*member) {
  return {type_of(static_cast<const M*>(nullptr)), [member](T& target, const Setting& value) {
            if (!target.motion) target.motion.emplace();
            read_value((*target.motion).*member, value);
          }};
}

/// The file is read by complete_motion().
template <class T>
Member<T> motion_file() {
  return {ParameterType::text, [](T& target, const Setting&) {
            if (!target.motion) target.motion.emplace();
          }};
}

/// Reads the file of a motion, if it has one, and makes its axis a unit vector. `mover`, "wall 'gate'", is for sentences. Throws
/// BadInput where the keys in `table` contradict each other or the motion does not begin at 0.
void complete_motion(std::optional<RigidMotion>& motion, const Setting& table, const std::string& mover, int dimension,
                     const std::filesystem::path& folder);

}  // namespace tern
