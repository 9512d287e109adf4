#pragma once
// What drives a crack on from a point: the stress ahead of it against what the fracture energy allows.
#include "shell/solver/cracking/crack_rules.h"

namespace sunder::shell {

struct Drive {
  double ratio = 0.0;  // sqrt(energy release / fracture energy)
  double turn = 0.0;   // towards the direction that opens most [rad]
  int face = 0;        // that it opens first, -1 or +1
  double bent = 0.0;   // share of bending in the energy release
};

/// Where a crack may go on from.
struct Start {
  Vec2 p, direction;
  int edge = -1;            // that ends there
  double most_turn = 0.0;   // [rad]
  int face = 0;             // that has opened it: it turns to open that one only; 0: none yet
  double strength = 1e300;  // of the material where the crack has started [Pa]
  double grown = 1.0;       // length over that at which energy alone resists: 0 strength alone, 1 energy alone
};

/// Mean stress over the points ahead on the crack's own side, weighted towards each direction within the turn; the one
/// across which it pulls most (maximum hoop stress, Erdogan and Sih 1963), less what the lattice turns it by. Energy
/// releases of stretching and bending add; compression closes the face that bending opens. Ratio 0 where nothing bears.
Drive drive_at(const ShellModel& model, const ShellState& state, const CrackRules& rules, const Start& start);
/// The same, with what was seen from there before.
Drive drive_at(const ShellModel& model, const ShellState& state, const CrackRules& rules, const Start& start,
               Surroundings& known);

/// Mean opening stress ahead, as `drive_at` takes it, at which a tip's energy release is the fracture energy, in units
/// of sqrt(E G / radius): of a stretched sheet, and on the surface of a bent Kirchhoff-Love plate.
double stretching_mean();
double bending_mean(double poisson_ratio);

/// Half-length [m] of a straight crack whose energy release in an even field is the fracture energy once the opened
/// face is stressed to `strength` [Pa], of which `stretching` and `bending` are the parts, in any unit: E G_f / (pi
/// strength^2) stretched, 3 (3 + nu) / (1 + nu) times as much bent (Williams 1961). Infinite where neither opens it.
double critical_length(const ShellMaterial& material, double strength, double stretching, double bending);
/// Radius [m] of the circle in which such a field stores what a crack of the critical half-length a costs: 2 a G_f,
/// which is 2 pi a^2 strength^2 / E of strength^2 / (2 E), stretched: 2 a; bent sqrt(4 (1 + nu) / (3 + nu)) a, 1.23 a.
/// (Until it is critical a crack releases half of that.) As much as the half-length where nothing opens it.
double ground_radius(const ShellMaterial& material, double half_length, double stretching, double bending);
/// What stress across a line alone stores, whatever Poisson's ratio, over thickness / (2 E) [Pa^2]: its mean over the
/// thickness and what bending adds on a face [Pa]. A mean that presses counts for nothing.
double stored_by(double stretching, double bending);

/// Cauchy stress of the lower, then of the upper face: 11 22 12 each [Pa]. False where the point bears nothing.
bool surface_stress_at(const ShellModel& model, const ShellState& state, int block, int lane, double* six);

/// The same, mean over the points within `radius` [m] that `p` sees, weight exp(-2 r^2 / radius^2).
bool mean_stress(const ShellModel& model, const ShellState& state, const Vec2& p, double radius, Neighbours& known,
                 double* six);

/// Normal stress on a crack along q, of 11 22 12.
inline double across(const double* s, const Vec2& q) {
  return q.y() * q.y() * s[0] + q.x() * q.x() * s[1] - 2.0 * q.x() * q.y() * s[2];
}

}  // namespace sunder::shell
