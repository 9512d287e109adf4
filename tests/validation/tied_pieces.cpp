#include "tests/validation/tied_pieces.h"

#include <cmath>

#include "shell/geometry/builders.h"

namespace sunder::validation {

using namespace sunder::shell;

PlaneCurve line(const Vec2& a, const Vec2& b) {
  return {[a, b](double t) { return Vec2(a + t * (b - a)); }, (b - a).norm(), false};
}

ShellMaterial steel() {
  ShellMaterial m;
  m.density = 7800.0, m.youngs_modulus = 2e11, m.poisson_ratio = 0.3;
  return m;
}

Load point_load(const Vec2& at, double force) {
  Load l;
  l.point = at, l.force = Vec3(0.0, 0.0, force);
  return l;
}

CadBorder PieceOf::border(const PlaneCurve& c, int sides) const {
  const auto map = to;
  CadBorder out{{[c, map](double t) { return map(c.at(t)); }, 0.0, false}, sides};
  for (int k = 0; k < 64; ++k) out.curve.length += (out.curve.at((k + 1) / 64.0) - out.curve.at(k / 64.0)).norm();
  return out;
}

void PieceOf::add_to(Pieces& out, const std::string& name, const std::vector<CadBorder>& borders, double thickness,
                     const ShellMaterial& material, const std::vector<Support>& supports,
                     const std::vector<Load>& loads) const {
  const Patch lengths = with_parameters_as_lengths(patch);
  const Vec2 low(lengths.knots_u.begin(), lengths.knots_v.begin()), high(lengths.knots_u.end(), lengths.knots_v.end());
  const double spacing = std::sqrt((high - low).prod() / (lengths.knots_u.spans() * lengths.knots_v.spans()));
  const TrimLoops trims =
      borders.empty() ? TrimLoops() : TrimLoops(low, high, {cad_loop({borders, false}, lengths, spacing)});
  out.patches.push_back(lengths);
  out.models.push_back(make_shell(name, patch, thickness, material, 2, patch.degree(), supports, loads, trims));
}

Pieces whole_plate(int elements, int degree) {
  const PieceOf a{plate(1.0, 1.0, elements, elements, Vec3(0.5, 0.5, 0.0), Quat::Identity(), degree), {}};
  std::vector<Load> loads{point_load({0.5, 0.5}, 1.0)};
  for (const Vec2& corner : {Vec2(0, 0), Vec2(1, 0), Vec2(0, 1), Vec2(1, 1)})
    loads.push_back(point_load(corner, -0.25));
  Pieces out;
  a.add_to(out, "plate", {}, kTiedThickness, steel(), {}, loads);
  return out;
}

double slow_of_plate() {
  const double bending = steel().youngs_modulus * std::pow(kTiedThickness, 3) / (12.0 * (1.0 - 0.09));
  return 100.0 * bending / (steel().density * kTiedThickness);
}

}  // namespace sunder::validation
