#pragma once
// Cracks that start: by the strength of the faces, and only where they would run on.
#include "shell/solver/cracking/crack_rules.h"

namespace sunder::shell {

/// Starts cracks where a face exceeds the local strength, most overstressed first. Returns the number of edges
/// inserted. `random` is advanced only where chance has to decide a direction.
int nucleate(const ShellModel& model, ShellState& state, const CrackRules& rules, double time, std::uint64_t& random);

/// What a flaw asks of the field about it.
struct Flaw {
  double half_length = 0.0;  // of a line in an even field of `strength` that has the energy for a crack [m]
  double strength = 0.0;     // of its material, before any share of it there [Pa]
  double ground = 1.0;       // share that is its own (OwnGround) of the circle of ground_radius
};

/// Where a crack from a flaw would be: all of its line that is free.
struct FlawLine {
  Vec2 p, along;         // the flaw, a unit vector
  double ahead, behind;  // how far it goes from p before it meets a crack or the border [m]
  double length() const { return ahead + behind; }
};

/// The line along `along` through p, at most `half_length` [m] each way.
FlawLine line_through(const ShellModel& model, const CrackGraph& cracks, const Vec2& p, const Vec2& along,
                      double half_length);

/// Whether the field at `time` [s] opens a crack along the line of a flaw on a face: the mean of the stress across it
/// over the share of the material's strength there must reach the strength, not the most at a point (Taylor's line
/// method). A border or a crack that the line meets makes a crack from there of it, which needs to be half as long at
/// the strength, and less where there is more stress. Where other cracks relieve some of the ground the square of the
/// stress must make up for it, or the line be shorter. A flaw right beside a crack has hardly any ground, so where
/// lengths are resolved cracks seldom start on one another.
bool opens_along(const ShellModel& model, ShellState& state, const CrackRules& rules, const FlawLine& line, int face,
                 const Flaw& flaw, double time);

/// What the field stores by the stress across a direction, in the ground `own` of p, over what an even field stores in
/// the whole circle of `radius` [m] (ground_radius). `even` > 0 is stored_by of that field at the flaw's strength,
/// times the square of the share of the strength along the line, with which what a crack costs goes [Pa^2]. Points
/// where the face is pressed count for nothing, and where only it is pulled, the mean over the thickness being pressed,
/// its own stress counts as bending. What lies beyond a joined edge counts as the mean of this side; a large ground is
/// sampled. No crack starts where less is stored than its line costs: a field that is high along the line alone stores
/// less than the line lets one believe.
double stored_in_ground(const ShellModel& model, const ShellState& state, OwnGround& own, double radius, const Vec2& p,
                        const Vec2& along, int face, double even);

}  // namespace sunder::shell
