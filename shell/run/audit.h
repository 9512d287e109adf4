#pragma once

#include <string>
#include <vector>

#include "shell/solver/state.h"

namespace sunder::shell {

/// The surface that cracks which ran by themselves have made. A grid holds cracks no nearer than a few spacings; what
/// they release beyond their resistance is surface that it cannot hold, which in a brittle solid is dust.
struct CrackSurface {
  double resistance = 0.0;  // crack_resistance [J]
  double taken = 0.0;       // energy that they have released [J]
  double total = 0.0;       // the larger of the two over the fracture energy: all surface, resolved or not [m^2]
  double subgrid = 0.0;     // what is beyond the resistance, over the fracture energy [m^2]
  double dust_mass = 0.0;   // of grains with that surface [kg]
  // Of those grains, 6 E G_f / strength^2, at most the thickness: the width of a band, bent to the strength, that
  // stores the fracture energy of its cracks; the largest of all shells with dust [m].
  double dust_size = 0.0;
  // Of the shell whose grid resolves the mirror least among those with a crack that divided: mirror_length() and how
  // many spacings that is; 0: none divided.
  double mirror = 0.0, mirror_spacings = 0.0;

  CrackSurface& operator+=(const CrackSurface& o);
};

/// The energy books of a run [J], from which warnings are made at its end.
struct Audit {
  EnergyBook book;
  double scale = 0.0;     // largest energy at any time; 0: no energy, so nothing to judge
  double residual = 0.0;  // energy that the books miss [share of `scale`]
  double returned = 0.0;  // largest fall of the contact book below its maximum so far: energy that contact has returned
  double coupling = 0.0;  // uncertain because the shell pushes bodies that the engine holds
  double frozen = 0.0;    // kinetic energy of the shell when it was frozen
  bool grid_transfer = false;  // velocities pass through a background grid
  bool keeps_damage = false;   // damage does not heal
  CrackSurface surface{};
  double rubble = 0.0;           // Gauss points that bear nothing [share of all]
  double largest_gap = 0.0;      // energy that the books missed at the worst time [J]
  double window_gap = 0.0;       // largest change of that energy in one window [J]
  double window_gap_time = 0.0;  // end of that window [s]
  double deforming = 0.0;        // most energy that shells and soft bodies had, or their books took [J]
  // Name of a body that still moved beside the shell when it was frozen, its kinetic energy [J], and the time [s].
  // Empty: none.
  std::string beside{};
  double beside_energy = 0.0, frozen_time = 0.0;
  bool at_latest = false;        // it was frozen by latest_freeze_s; else since cracks were quiet
  double engine_returned = 0.0;  // largest fall of what the rigid engine has taken, below its maximum so far [J]
  double pushed = 0.0;           // work against weight that moving poses out of overlaps may take [J]
};

/// Returns the energy [J] that cracks should take by the material's fracture energy and their area. Only cracks that
/// ran by themselves count, each edge at the speed at which it ran (cracking/tip_speed.h): prescribed cuts, cracks from
/// damage and the first spacing beyond a seam do not. The fracture energy is scaled by the square of the local strength
/// factor. Only lengths within the patch count.
double crack_resistance(const ShellModel& model, const ShellState& state);

/// Of one shell; none of one that yields, whose surplus goes elsewhere.
CrackSurface crack_surface(const ShellModel& model, const ShellState& state);

/// Notes the mirror in `surface` if a crack of the shell has divided. Tips divide above `branch_ratio`, the root of the
/// energy release over G_f. Where a metal yields there is no mirror.
void note_mirror(const ShellModel& model, const ShellState& state, double branch_ratio, CrackSurface& surface);

/// Returns warnings about the energies of a run, one sentence each; empty where there are none.
std::vector<std::string> audit_warnings(const Audit& audit);

}  // namespace sunder::shell
