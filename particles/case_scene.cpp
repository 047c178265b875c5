// Checks of the scene as a whole.

#include "particles/case_scene.hpp"

namespace tern {
void check_scene(Case&, const Setting&) {}
}  // namespace tern
