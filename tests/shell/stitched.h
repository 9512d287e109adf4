#pragma once
// Shells that hang together, stepped as a run steps them, without bodies and cracks.
#include <algorithm>
#include <cmath>
#include <deque>
#include <string>
#include <vector>

#include "shell/geometry/builders.h"
#include "shell/solver/forces.h"
#include "shell/solver/joining/stitching.h"
#include "shell/solver/stepping/kick_drift.h"
#include "shell/solver/stepping/stable_step.h"

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

struct Stitched {
  std::deque<ShellModel> models;
  std::vector<ShellState> states;
  Stitches stitches;
  Stitching stitching;

  explicit Stitched(std::deque<ShellModel> all, Join join = Join::kClamped, double tolerance = 1e-6)
      : models(std::move(all)) {
    std::vector<const Patch*> patches;
    std::vector<std::string> names;
    std::vector<const ShellModel*> pointers;
    for (const ShellModel& m : models) patches.push_back(&m.patch), names.push_back(m.name), pointers.push_back(&m);
    stitches = find_stitches(
        patches, names, tolerance, {models.size(), std::vector<Join>(models.size(), join)},
        [&](const PatchPoint& p) { return models[p.patch].held[models[p.patch].tables.slot(p.point)] != 0; });
    stitching = Stitching(stitches, pointers);
    for (const ShellModel& m : models) states.push_back(make_state(m, Vec3::Zero(), 0));
    stitching.tie(refs());
  }

  std::vector<ShellRef> refs() {
    std::vector<ShellRef> out;
    for (std::size_t k = 0; k < models.size(); ++k) out.push_back({&models[k], &states[k]});
    return out;
  }
  /// Returns the stored energy [J] where `energy`.
  double forces(bool energy = false) {
    double sum = 0.0;
    for (std::size_t k = 0; k < models.size(); ++k) sum += compute_forces(models[k], states[k], energy, 0.0, 1);
    stitching.share_forces(refs());
    return sum;
  }
  double kinetic(double dt) {
    double sum = 0.0;
    for (std::size_t k = 0; k < models.size(); ++k) sum += kinetic_energy(models[k], states[k], dt);
    return sum;
  }
  /// After forces(): the rest of a substep, with `contact` after the kick.
  void advance(double dt) {
    advance(dt, [] {});
  }
  template <class F>
  void advance(double dt, F&& contact) {
    for (std::size_t k = 0; k < models.size(); ++k) kick(models[k], states[k], Vec3::Zero(), dt);
    stitching.mark(refs());
    contact();
    stitching.share_impulses(refs()), stitching.keep_angles(refs(), dt);
    for (std::size_t k = 0; k < models.size(); ++k) constrain(models[k], states[k], dt);
    stitching.follow(refs());
    for (std::size_t k = 0; k < models.size(); ++k) drift(models[k], states[k], dt);
  }
  /// Between passes of contact, as a run does.
  void hand_on() { stitching.share_impulses(refs()), stitching.mark(refs()); }
  double stable(int iterations = 200) {
    return stable_step(refs(), stitching, iterations, 1, std::vector<char>(models.size(), 0));
  }
  /// Mass, momentum and angular momentum, with the sums of magnitudes that their round-off is relative to.
  struct Sums {
    double mass = 0.0, momentum_scale = 0.0, angular_scale = 0.0;
    Vec3 momentum = Vec3::Zero(), angular = Vec3::Zero();
  };
  Sums sums() const {
    Sums t;
    for (const ShellState& s : states)
      for (std::size_t i = 0; i < s.motion.mass.size(); ++i) {
        const Vec3 p = s.motion.mass[i] * s.velocity(static_cast<int>(i)), l = s.position(static_cast<int>(i)).cross(p);
        t.mass += s.motion.mass[i], t.momentum += p, t.angular += l, t.momentum_scale += p.norm(),
            t.angular_scale += l.norm();
      }
    return t;
  }
  /// Where a material point is.
  Vec3 at(int shell, const Vec2& p) const {
    const ShellModel& m = models[shell];
    std::vector<Vec3> net;
    for (int i = 0; i < m.control_points(); ++i) net.push_back(states[shell].position(m.tables.slot(i)));
    return m.patch.evaluate(p, net).x;
  }
};

}  // namespace sunder::shell
