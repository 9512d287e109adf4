#pragma once
// Pieces that curves cut from patches, of which tied surfaces consist.
#include <functional>
#include <string>
#include <vector>

#include "shell/io/cad_loop.h"
#include "tests/validation/tied_system.h"

namespace sunder::validation {

constexpr double kTiedThickness = 0.004;  // of plates, whose side is 1 m [m]

/// A straight stretch of a border.
shell::PlaneCurve line(const Vec2& a, const Vec2& b);
shell::ShellMaterial steel();
shell::Load point_load(const Vec2& at, double force);

/// The part of a patch that a border of curves leaves. Curves are over shares of a surface; `to` takes them to
/// parameters.
struct PieceOf {
  shell::Patch patch;
  std::function<Vec2(const Vec2&)> to;

  /// `sides`: the sides of the patch that the curve runs on.
  shell::CadBorder border(const shell::PlaneCurve& c, int sides = 0) const;
  /// Adds the piece; without borders it is the whole patch.
  void add_to(Pieces& out, const std::string& name, const std::vector<shell::CadBorder>& borders, double thickness,
              const shell::ShellMaterial& material, const std::vector<shell::Support>& supports,
              const std::vector<shell::Load>& loads) const;
};

/// A square plate of one patch. A force of 1 N on the middle is borne by the corners.
Pieces whole_plate(int elements, int degree);
/// Below the lowest eigenvalue of that plate without supports [1/s^2].
double slow_of_plate();

/// Plates and roofs of more than two pieces (tied_grids.cpp).
std::vector<Case> tied_grid_cases();

}  // namespace sunder::validation
