#pragma once
// Cracks that start: where a face reaches the strength, and only if they would run on.
#include "shell/solver/cracking/criteria.h"

namespace sunder::shell {

/// Cracks start where a face exceeds the local strength, if they would run on.
Criterion nucleation_by_strength();

/// Starts cracks where a face exceeds the local strength, the most overstressed point first. Returns the number of
/// edges inserted. `random` is advanced only where chance decides a direction.
int nucleate(const ShellModel& model, ShellState& state, const CrackRules& rules, double time, std::uint64_t& random);

/// What a flaw needs of the field around it.
struct Flaw {
  double half_length = 0.0;  // of a line that has the energy for a crack in an even field of `strength` [m]
  double strength = 0.0;     // of the material, without the local factor [Pa]
  double zone = 1.0;         // share of the circle of zone_radius that is its own (EnergyReleaseZone) [-]
};

/// The line along which a flaw would crack, as far as it is free.
struct FlawLine {
  Vec2 p, along;         // flaw; unit vector
  double ahead, behind;  // how far it goes from p before it meets a crack or the border [m]
  double length() const { return ahead + behind; }
};

/// The line along `along` through p, at most `half_length` [m] each way.
FlawLine line_through(const ShellModel& model, const CrackGraph& cracks, const Vec2& p, const Vec2& along,
                      double half_length);

/// Whether the field at `time` [s] opens a crack along the line of a flaw on a face. The mean stress across the line,
/// over the share of the strength there, must reach the strength (line method of Taylor); the largest stress at a point
/// does not count. Where the line meets a border or a crack, the crack starts from there: it needs half the length at
/// the strength, and less at more stress. Where other cracks take a part of the energy-release zone, the square of the
/// stress must make up for it, or the line be shorter. A flaw close to a crack has hardly any zone, so cracks seldom
/// start on one another where the grid resolves their length.
bool opens_along(const ShellModel& model, ShellState& state, const CrackRules& rules, const FlawLine& line, int face,
                 const Flaw& flaw, double time);

/// Ratio of two energies. The first is stored by the stress across a direction in the energy-release zone `own` of p.
/// An even field stores the second in the whole circle of `radius` [m] (zone_radius). `even` > 0 [Pa^2]: stored_by of
/// that even field at the strength of the flaw, times the squared share of the strength along the line; the cost of a
/// crack has the same factor. Points whose face is pressed count as zero. Where the mean over the thickness presses and
/// only the face is pulled, the stress of the face counts as bending. Beyond a joined edge the mean of this side
/// counts. A large zone is sampled. No crack starts where less is stored than its line costs: a field that is high
/// along the line only stores less than the line suggests.
double stored_in_zone(const ShellModel& model, const ShellState& state, EnergyReleaseZone& own, double radius,
                      const Vec2& p, const Vec2& along, int face, double even);

}  // namespace sunder::shell
