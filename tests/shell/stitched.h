#pragma once
// Shells that hang together along seams.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "shell/geometry/builders.h"
#include "shell/geometry/trim_seams.h"
#include "shell/solver/forces.h"
#include "shell/solver/joining/stitching.h"
#include "shell/solver/stepping/stable_step.h"
#include "tests/shell/rig.h"

namespace sunder::shell {

inline Patch flat(double x0, double x1, double y0, double y1, int nx, int ny, int degree = 2) {
  return plate(x1 - x0, y1 - y0, nx, ny, Vec3(0.5 * (x0 + x1), 0.5 * (y0 + y1), 0.0), Quat::Identity(), degree);
}

/// The same surface, its parameters turned by a quarter: u' = v, v' = -u. The normal stays.
inline Patch turned(const Patch& p) {
  std::vector<double> back;
  const std::vector<double>& knots = p.knots_u.knots();
  const double low = knots.front(), high = knots.back(), round_off = 1e-12 * (high - low);
  for (auto k = knots.rbegin(); k != knots.rend(); ++k)
    back.push_back(high - *k < round_off ? low : *k - low < round_off ? high : low + (high - *k));
  Patch q{p.knots_v, KnotVector(back, p.degree(), "turned"), {}, {}};
  for (int j = 0; j < q.rows(); ++j)
    for (int i = 0; i < q.columns(); ++i) {
      const int from = i * p.columns() + p.columns() - 1 - j;
      q.control_points.push_back(p.control_points[from]), q.weights.push_back(p.weights[from]);
    }
  return q;
}
inline Patch turned(Patch p, int times) {
  for (int k = 0; k < times; ++k) p = turned(p);
  return p;
}

/// Shells that hang together along their common edges, and along trims.
struct Stitched : Rig {
  explicit Stitched(std::vector<ShellModel> models, Join join = Join::kClamped, double tolerance = 1e-6)
      : Rig(joined(std::move(models), join, tolerance)) {}

  static RunSetup joined(std::vector<ShellModel> models, Join join, double tolerance) {
    RunSetup out;
    for (ShellModel& m : models) out.shells.push_back({std::move(m)});
    std::vector<const Patch*> patches;
    std::vector<std::string> names;
    std::vector<int> whole;
    std::vector<BorderedPatch> bordered;
    for (const ShellSetup& s : out.shells) {
      patches.push_back(&s.model.patch), names.push_back(s.model.name);
      whole.push_back(s.model.trim.empty() ? kUMin | kUMax | kVMin | kVMax : 0);
      bordered.push_back({&s.model.patch, &s.model.trim.loops, whole.back(), s.model.name});
    }
    const std::vector<std::vector<Join>> joins(patches.size(), std::vector<Join>(patches.size(), join));
    out.stitches = find_stitches(
        patches, names, tolerance, joins,
        [&](const PatchPoint& p) {
          const ShellModel& m = out.shells[p.patch].model;
          return m.held[m.tables.slot(p.point)] != 0;
        },
        whole);
    for (Seam& seam : find_trim_seams(bordered, tolerance, joins)) out.stitches.seams.push_back(std::move(seam));
    std::vector<ShellModel*> tied;
    for (ShellSetup& s : out.shells) tied.push_back(&s.model);
    note_ties(out.stitches.seams, tied);
    return out;
  }
  Stitching& stitching() { return now().stitching; }
  const Stitching& stitching() const { return now().stitching; }
  const Stitches& stitches() const { return setup().stitches; }
  const std::vector<Seam>& seams() const { return setup().stitches.seams; }

  /// Forces at the present positions. Returns the stored energy [J] where `energy`.
  double forces(bool energy = false) {
    double sum = 0.0;
    for (std::size_t k = 0; k < size(); ++k) sum += compute_forces(model(k), state(k), energy, 0.0, 1);
    stitching().move_forces(refs());
    return sum;
  }
  double kinetic(double dt) const {
    double sum = 0.0;
    for (std::size_t k = 0; k < size(); ++k) sum += kinetic_energy(model(k), state(k), dt);
    return sum;
  }
  /// Between passes of contact, as a run does.
  void hand_on() { stitching().move_impulses(refs()), stitching().store_velocities(refs()); }
  double stable(int iterations = 200) {
    return stable_step(refs(), stitching(), iterations, 1, std::vector<char>(size(), 0));
  }
  /// Mass, momentum and angular momentum, with the sums of magnitudes that their round-off is relative to.
  struct Sums {
    double mass = 0.0, momentum_scale = 0.0, angular_scale = 0.0;
    Vec3 momentum = Vec3::Zero(), angular = Vec3::Zero();
  };
  Sums sums() const {
    Sums t;
    for (std::size_t k = 0; k < size(); ++k) {
      const ShellState& s = state(k);
      for (std::size_t i = 0; i < s.motion.mass.size(); ++i) {
        const Vec3 p = s.motion.mass[i] * s.velocity(static_cast<int>(i)), l = s.position(static_cast<int>(i)).cross(p);
        t.mass += s.motion.mass[i], t.momentum += p, t.angular += l;
        t.momentum_scale += p.norm(), t.angular_scale += l.norm();
      }
    }
    return t;
  }
  /// Where a material point is.
  Vec3 at(int shell, const Vec2& p) const {
    const ShellModel& m = model(shell);
    std::vector<Vec3> net;
    for (int i = 0; i < m.control_points(); ++i) net.push_back(state(shell).position(m.tables.slot(i)));
    return m.patch.evaluate(p, net).x;
  }
};

}  // namespace sunder::shell
