#pragma once
// The drive of a tip: the stress ahead of it against the stress that the fracture energy allows.
#include "shell/solver/cracking/crack_rules.h"

namespace sunder::shell {

struct Drive {
  double ratio = 0.0;     // sqrt(energy release / fracture energy)
  double turn = 0.0;      // towards the direction of the largest drive [rad]
  int face = 0;           // that opens first, -1 or +1
  double bent = 0.0;      // share of bending in the energy release
  bool twisted = false;   // moments ahead twist more than they open
  double release = -1.0;  // energy release as a domain integral [J/m^2]; below 0: not known
};

/// A place from which a crack may run.
struct Start {
  Vec2 p, direction;
  int edge = -1;            // crack edge that ends there
  double most_turn = 0.0;   // [rad]
  int face = 0;             // that has opened; the crack turns to open this one only; 0: none yet
  double strength = 1e300;  // of the material at the start of the crack [Pa]
  double grown = 1.0;       // length over the critical one: at 0 the strength resists, at 1 the energy
};

/// Drive at a start. The mean stress over visible points ahead is taken about each direction within the largest turn.
/// The crack takes the direction across which it is largest (maximum hoop stress, Erdogan and Sih 1963), less the turn
/// that the lattice adds. Energy releases of stretching and bending add. Compression closes the face that bending
/// opens. The ratio is 0 where nothing bears.
Drive drive_at(const ShellModel& model, const ShellState& state, const CrackRules& rules, const Start& start);
/// The same, with the points that were visible before.
Drive drive_at(const ShellModel& model, const ShellState& state, const CrackRules& rules, const Start& start,
               Surroundings& known);

/// Mean opening stress ahead, as `drive_at` takes it, at which the energy release of a tip is the fracture energy, in
/// units of sqrt(E G / radius): of a stretched sheet, and on the surface of a bent Kirchhoff-Love plate.
double stretching_mean();
double bending_mean(double poisson_ratio);

/// Half-length [m] of a straight crack whose energy release in an even field is the fracture energy when the opened
/// face has the stress `strength` [Pa]. `stretching` and `bending` are the parts of that stress, in any unit. E G_f /
/// (pi strength^2) stretched, 3 (3 + nu) / (1 + nu) times as much bent (Williams 1961). Infinite where neither opens
/// the crack.
double critical_length(const ShellMaterial& material, double strength, double stretching, double bending);
/// Radius [m] of the circle in which such a field stores the cost 2 a G_f of a crack of the critical half-length a.
/// Stretched, 2 a G_f is 2 pi a^2 strength^2 / E and the density strength^2 / (2 E), so the radius is 2 a; bent it is
/// sqrt(4 (1 + nu) / (3 + nu)) a. The half-length where nothing opens the crack. (Until a crack is critical it releases
/// half of that.)
double zone_radius(const ShellMaterial& material, double half_length, double stretching, double bending);
/// Energy that the stress across a line stores, over thickness / (2 E) [Pa^2]. It comes from the mean over the
/// thickness and the bending stress on a face [Pa]; Poisson's ratio does not count. A mean that presses counts as zero.
double stored_by(double stretching, double bending);

/// Cauchy stress of the lower, then of the upper face: 11 22 12 each [Pa]. False where the point bears nothing.
bool face_stress_at(const ShellModel& model, const ShellState& state, int block, int lane, double* face_stress);

/// The mean of that over the points within `radius` [m] that `p` sees, weight exp(-2 r^2 / radius^2). False where none
/// bears.
bool mean_stress(const ShellModel& model, const ShellState& state, const Vec2& p, double radius, Neighbours& known,
                 double* face_stress);

/// Normal stress across a crack along q, from 11 22 12.
inline double across(const double* s, const Vec2& q) {
  return q.y() * q.y() * s[0] + q.x() * q.x() * s[1] - 2.0 * q.x() * q.y() * s[2];
}

}  // namespace sunder::shell
