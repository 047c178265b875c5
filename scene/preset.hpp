#pragma once
// The presets: numerical options as a group, points of the measured front of error and cost (docs/TRADE.md).

#include <functional>
#include <string>
#include <vector>

#include "scene/settings.hpp"

namespace tern {

/// Whether the preset that `document` names is draft.
bool is_draft(const Setting& document);

/// Changes `document` as the preset it names says and returns one entry per change, "fluid.spacing = 0.008 (0.004 in the
/// case)". draft takes `coarser` times the spacings of the case and fills in numerical options that it leaves out, reference takes half
/// the spacings; paper replaces the interaction. `particles_across`: of each elastic body, at the spacing of the case; called only if
/// needed.
std::vector<std::string> apply_preset(Setting& document, double coarser, const std::function<std::vector<double>()>& particles_across);

}  // namespace tern
