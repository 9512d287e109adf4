#pragma once
// A shell of a scene with all that decides how it moves and breaks.
#include <algorithm>
#include <string>
#include <vector>

#include "shell/io/cuts.h"
#include "shell/solver/contact/near_tiles.h"
#include "shell/solver/cracking/criteria.h"
#include "shell/solver/stepping/grid_transfer.h"

namespace sunder::shell {

/// Of the stable step, what a scene may ask for: iteration finds it from above.
constexpr double kMostOfStable = 0.95;

/// A shell of the scene, and how it breaks.
struct ShellSetup {
  ShellModel model;
  Vec3 velocity = Vec3::Zero();  // at the start
  double equilibrium = 0.0;      // tolerance of the equilibrium that it starts from; 0: starts as it is
  FractureRules fracture{};
  double cracked_step = kCrackedStep;  // share of the free stable step that it starts with where it can crack
  TransferRules transfer{};
  double fibre_spacing = 0.0;   // of the grid, as the scene asks for it [m]
  std::vector<double> hertz{};  // stiffness of each body against it [N/m^1.5]; 0: impulses
  bool seam_may_part = false;   // with a shell that can crack

  bool can_crack() const { return shell::can_crack(fracture) || seam_may_part; }
};

/// `field` is that of the shell; stiffnesses of Hertz contacts are left to the caller. Throws Error with the field that
/// is wrong.
ShellSetup make_setup(const scene::LoadedScene& scene, const proto::Shell& shell, const std::string& field);
/// Shells that are too thick for a theory without shear through the thickness, in words: some 5 (thickness / width)^2
/// is missing from deflections (of a square plate, simply supported; Timoshenko and Woinowsky-Krieger, section 39).
/// Empty where all are thin. The width is the root of the area of all that hangs together by seams.
std::string too_thick(const std::vector<ShellSetup>& shells, const std::vector<Seam>& seams);
/// A grid that all shells with fibres share must not be too coarse for any of them. Throws Error.
void check_fibre_grid(const scene::LoadedScene& scene, const ShellModel& shell, std::size_t index, double spacing);

}  // namespace sunder::shell
