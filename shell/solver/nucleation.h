#pragma once
// Cracks that start: by the strength of the faces, and only where they would run on.
#include "shell/solver/crack_rules.h"

namespace sunder::shell {

/// Starts cracks where a face exceeds the local strength, most overstressed first. Returns the number of edges
/// inserted. `random` is advanced only where chance has to decide a direction.
int nucleate(const ShellModel& model, ShellState& state, const CrackRules& rules, double time, std::uint64_t& random);

/// What a flaw asks of the field about it.
struct Flaw {
  double half_length = 0.0;  // of a line in an even field of `strength` that has the energy for a crack [m]
  double strength = 0.0;     // [Pa]
  double ground = 1.0;       // share that is its own (OwnGround) of the circle of ground_radius
};

/// Whether the field at `time` [s] opens, on a line of the flaw's half-length about p, a crack along it on a face: the
/// mean of the stress across it over the share of the material's strength there must reach the strength, not the most
/// at a point (Taylor's line method). A border or a crack that the line meets makes a crack from there of it, which
/// needs to be half as long at the strength, and less where there is more stress. Where other cracks relieve some of
/// the ground the square of the stress must make up for it, or the line be shorter. A flaw right beside a crack has
/// hardly any ground, so where lengths are resolved cracks seldom start on one another.
bool opens_along(const ShellModel& model, ShellState& state, const CrackRules& rules, const Vec2& p, const Vec2& along,
                 int face, const Flaw& flaw, double time);

}  // namespace sunder::shell
