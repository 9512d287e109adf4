#pragma once
// Cracks that start: by the strength of the faces, and only where they would run on.
#include "shell/solver/crack_rules.h"

namespace sunder::shell {

/// Starts cracks where a face exceeds the local strength, most overstressed first. Returns the number of edges
/// inserted. `random` is advanced only where chance has to decide a direction.
int nucleate(const ShellModel& model, ShellState& state, const CrackRules& rules, double time, std::uint64_t& random);

/// Whether the field opens, on a line of this half-length [m] about p, a crack along it on a face: the mean of the
/// stress across it over the share of the material's strength there must reach `strength` [Pa], not the most at a point
/// (Taylor's line method). A border or a crack that the line meets makes a crack from there of it, which needs to be
/// half as long at the strength, and less where there is more stress.
bool opens_along(const ShellModel& model, ShellState& state, const CrackRules& rules, const Vec2& p, const Vec2& along,
                 int face, double half_length, double strength);

}  // namespace sunder::shell
