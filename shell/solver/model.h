#pragma once
// The constant part of one shell.
#include <functional>
#include <string>
#include <vector>

#include "shell/fracture/constants.h"
#include "shell/geometry/patch.h"
#include "shell/mechanics/fibre.h"
#include "shell/mechanics/row_tables.h"
#include "shell/solver/loads.h"
#include "shell/solver/supports.h"
#include "shell/solver/trimming.h"

namespace sunder::shell {

/// The core of laminated glass. It carries load beside the plies and does not crack.
struct Interlayer {
  double thickness = 0.0;                                           // [m]; 0: no interlayer
  double density = 0.0, youngs_modulus = 0.0, poisson_ratio = 0.0;  // [kg/m^3], [Pa], [-]
};

/// Material of a shell.
struct ShellMaterial : ElasticConstants {
  double density = 0.0;          // [kg/m^3]
  double strength = 0.0;         // [Pa]; 0: the shell does not break
  double fracture_energy = 0.0;  // [J/m^2]
  // How fracture energy and division depend on the speed of a tip (cracking/tip_speed.h): from `crack_speed_onset` on,
  // of the Rayleigh speed, the fracture energy grows by `toughening` of itself for each unit of speed; a tip divides
  // where the energy release is `branch_drive` fracture energies.
  double crack_speed_onset = 1.0, toughening = 0.0, branch_drive = kBranchDrive;
  double crack_friction = kCrackFriction;  // coefficient between crack faces
  double crushing_strength = 0.0;          // pressure at which crack faces crush [Pa]
  double weibull_modulus = 0.0;            // 0: no scatter
  double flaw_spacing = 0.0;               // [m]
  double mass_damping = 0.0;               // [1/s]
  double stiffness_damping = 0.0;          // [s]
  StressModel stress_model = model_of<NeoHookean>;
  double yield_stress = 0.0;         // [Pa]; 0: the shell does not yield
  double hardening_modulus = 0.0;    // [Pa]
  bool linear_bending = false;       // Hooke's law, without layers
  double surface_compression = 0.0;  // compressive prestress of the faces [Pa] (`prestress`)
  Interlayer interlayer{};
};

/// Supports from a time on, when some of them are released.
struct SupportStage {
  double from = 0.0;  // [s]
  Constraints constraints{};
  std::vector<char> held{};  // as in ShellModel
  int clamped = 0;
};

/// Geometry, material, tables, supports and loads of a shell. All of it is constant, but for the supports, which
/// release_supports() changes at their times.
struct ShellModel {
  std::string name;
  Patch patch;             // parameters are lengths
  double thickness = 0.0;  // [m] of the scene; where it varies, factors multiply it
  ShellMaterial material;
  std::uint32_t contact_group = 0;
  int clamped = 0;  // EdgeBit: edges that are held with their slopes along all axes
  int joined = 0;   // EdgeBit: edges with a seam to another shell, hinges excepted
  RowTables tables{};
  // Tables of the interlayer, with the functions of the uncracked shell at all times; empty without an interlayer.
  RowTables interlayer{};
  std::vector<double> mass{};  // lumped mass of each slot [kg]; padding 0
  std::vector<double> rest{};  // positions at rest [m], [3][component stride]
  std::vector<char> held{};    // 1 where a support holds the slot along all axes
  Constraints constraints{};
  std::vector<SupportStage> releases{};  // in the order of their times
  PreparedLoads loads{};
  std::vector<Vec2> parameter{};          // Greville point of each control point
  std::vector<Vec2> parameter_of_slot{};  // the same for each slot; padding: zero
  double longest_element = 0.0;           // longest side of an element at rest [m]
  double shortest_element = 0.0;          // at rest [m]
  double largest_mobility = 0.0;          // largest inverse mass of a surface point [1/kg]
  double spacing = 0.0;                   // mean length of an element [m]
  double spacing_u = 0.0, spacing_v = 0.0;
  // Factor of the strength, [block][lane]; empty: 1 everywhere. The fracture energy scales with its square.
  std::vector<float> strength_factor{};
  Trimming trim{};  // what trim loops leave; empty: the patch is whole
  // Texture coordinates that its mesh file has at a parameter, for frames; empty: none.
  std::function<Vec2(const Vec2&)> texture{};
  // Colour that its mesh file has at a parameter: red, green, blue, 1 is full; for frames; empty: none.
  std::function<Vec3(const Vec2&)> colour{};
  ThicknessFactor thickness_factor{};       // empty: the thickness does not vary
  double thinnest = 1.0, thickest = 1.0;    // least and largest factor at Gauss points
  std::vector<double> thickness_of_slot{};  // mean factor over a control point's function; empty: 1
  // Mass of a slot over the mass of its material, where mass is added for longer steps; empty: 1.
  std::vector<double> mass_factor_of_slot{};
  FibreLaw fibres{};  // shear and compression through the thickness, for contact between shells with fibres

  bool has_fibres() const { return fibres.compression > 0.0; }
  double strength_factor_at(int block, int lane) const {
    return strength_factor.empty() ? 1.0 : strength_factor[static_cast<std::size_t>(block) * tables.lanes + lane];
  }
  bool varies() const { return tables.varies(); }
  /// Thickness at a place of the patch, or at a Gauss point [m].
  double thickness_at(const Vec2& p) const;
  double thickness_at(int block, int lane) const {
    return varies() ? thickness * tables.thickness_factor(block, lane) : thickness;
  }
  double largest_thickness() const { return thickness * thickest; }
  double least_thickness() const { return thickness * thinnest; }
  /// Lumped mass of a slot over the area that it stands for [kg/m^2].
  double mass_per_area(int slot) const {
    return material.density * thickness * (thickness_of_slot.empty() ? 1.0 : thickness_of_slot[slot]) *
           mass_factor(slot);
  }
  double mass_factor(int slot) const { return mass_factor_of_slot.empty() ? 1.0 : mass_factor_of_slot[slot]; }
  /// Whether supports hold every control point along all axes.
  bool wholly_held() const;
  bool laminated() const { return material.interlayer.thickness > 0.0; }
  int control_points() const { return tables.columns * tables.rows; }
  double wave_speed() const;      // of compression in the plane [m/s]
  double rayleigh_speed() const;  // [m/s]
  /// Returns the time [s] over which stress is averaged before it starts or drives cracks. It is the passage of a wave
  /// over a spacing or, where that is longer, of a shear wave through the thickness. Shell theory cannot resolve
  /// shorter times.
  double response_time() const;
};

/// Returns the largest inverse mass of a surface point [1/kg]. The border is more mobile than its samples.
double largest_mobility(const ShellModel& model);

/// Makes the model of a shell, of what `trim` leaves of the patch. `layers` is the number of layers, of each ply where
/// there is an interlayer. The model's density is then the mean over the thickness. `factor` makes the thickness vary;
/// not with an interlayer. Throws Error where a support, a load or a loop is wrong, or a factor is not positive.
ShellModel make_shell(const std::string& name, const Patch& patch, double thickness, const ShellMaterial& material,
                      int layers, int gauss, const std::vector<Support>& supports, const std::vector<Load>& loads = {},
                      const TrimLoops& trim = {}, const ThicknessFactor& factor = {});

}  // namespace sunder::shell
