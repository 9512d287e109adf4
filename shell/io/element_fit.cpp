#include "shell/io/element_fit.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "shell/geometry/edges.h"
#include "shell/solver/forces.h"
#include "shell/solver/stepping/stable_step.h"

namespace sunder::shell {
namespace {

constexpr double kSlow = 10.0;     // times the substeps of even elements: the reader is told
constexpr double kUnfit = 1000.0;  // minutes become days
constexpr double kPole = 0.1;      // of an element: a side that short shrinks to a pole

// Length of the shortest side, by its control points [m].
double shortest_side(const Patch& p) {
  double least = 1e300;
  for (const int edge : kEdges) {
    const std::vector<int> row = edge_row(p, edge, 0);
    double length = 0.0;
    for (std::size_t k = 1; k < row.size(); ++k)
      length += (p.control_points[row[k]] - p.control_points[row[k - 1]]).norm();
    least = std::min(least, length);
  }
  return least;
}

}  // namespace

ElementFit element_fit(const ShellModel& m, double element) {
  const ShellMaterial& q = m.material;
  const double speed = std::sqrt(q.youngs_modulus / (q.density * (1.0 - q.poisson_ratio * q.poisson_ratio)));
  ShellState state = make_state(m, Vec3::Zero(), 0);
  ElementFit fit;
  fit.step = stable_step(m, state, kStepIterations, 1, false);
  fit.slower = element / speed / fit.step;
  fit.unfit = !(fit.slower <= kUnfit);
  if (fit.slower <= kSlow) return fit;
  const bool pole = shortest_side(m.patch) <= kPole * element;
  const char* remedy =
      !pole ? "rebuild the surface with even knots in the CAD program, or leave the face out"
      : fit.unfit
          ? "a side shrinks to a pole: replace the tip by a face without one in the CAD program, or leave the "
            "face out"
          : "a side shrinks to a pole: take longer elements, whose square counts there, or replace the tip by a "
            "face without a pole in the CAD program";
  fit.warning = fmt::format(
      "an element is {:.2g} m long where {:.3g} m are wanted, and takes {:.2g} times as many "
      "substeps; {}",
      m.shortest_element, element, fit.slower, remedy);
  return fit;
}

}  // namespace sunder::shell
