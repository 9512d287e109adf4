#pragma once
// A shell of a scene with all settings of its motion and fracture.
#include <algorithm>
#include <string>
#include <vector>

#include "shell/io/cuts.h"
#include "shell/solver/contact/near_tiles.h"
#include "shell/solver/cracking/criteria.h"
#include "shell/solver/stepping/grid_transfer.h"

namespace sunder::shell {

/// Largest share of the stable step that a scene may ask for: iteration approaches the stable step from above.
constexpr double kMostOfStable = 0.95;

/// What becomes of pieces that have come off; values as in proto::Shell.
enum class PiecePolicy { kByStiffness, kRigid, kSoft };

/// A shell of the scene, and how it breaks.
struct ShellSetup {
  ShellModel model;
  Vec3 velocity = Vec3::Zero();  // initial [m/s]
  double equilibrium = 0.0;      // tolerance of the initial equilibrium; 0: starts as given
  /// Factors of loads, gravity and motions of supports. Loads and supports have the k-th at time k + 1 [s]. Empty: 1.
  std::vector<double> load_factors{};
  FractureRules fracture{};
  double cracked_step = kCrackedStep;  // share of the free stable step that it starts with where it can crack
  TransferRules transfer{};
  double fibre_spacing = 0.0;   // of the fibres' grid, as the scene asks for it [m]
  std::vector<double> hertz{};  // stiffness of each body against the shell [N/m^1.5]; 0: impulses
  bool seam_may_part = false;   // a seam with a shell that can crack
  std::string material{};       // its name in the scene
  PiecePolicy pieces = PiecePolicy::kByStiffness;

  bool can_crack() const { return shell::can_crack(fracture) || seam_may_part; }
};

class CadFiles;

/// Makes the setup of a shell, except for Hertz stiffnesses, which the caller adds. `field` is the shell's field,
/// `files` are the CAD files of the scene, `part` counts the parts of a CAD face that is divided. Throws Error with the
/// field that is wrong.
ShellSetup make_setup(const scene::LoadedScene& scene, const proto::Shell& shell, const std::string& field,
                      CadFiles& files, int part);
/// Returns a warning about shells that are too thick for a theory without transverse shear, or an empty text. Their
/// deflections are too small by some 5 (thickness / width)^2 (square plate, simply supported; Timoshenko and
/// Woinowsky-Krieger, section 39). The width is the square root of the area of all shells that seams join.
std::string too_thick(const std::vector<ShellSetup>& shells, const std::vector<Seam>& seams);
/// Returns a warning about shells that flow before any stress reaches their strength, or an empty text. Without
/// hardening no principal stress exceeds 2 / sqrt(3) times the yield stress (von Mises, plane stress).
std::string never_breaks(const std::vector<ShellSetup>& shells);
/// Throws Error where the grid of all fibres is too coarse for this shell.
void check_fibre_grid(const scene::LoadedScene& scene, const ShellModel& shell, std::size_t index, double spacing);

}  // namespace sunder::shell
