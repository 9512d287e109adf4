#include "shell/run/part.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "shell/solver/contact/fibres.h"
#include "shell/solver/contact/hertz.h"
#include "shell/solver/cracking/criteria.h"
#include "shell/solver/stepping/stable_step.h"

namespace sunder::shell {
Eigen::AlignedBox3d ShellPart::box() const {
  Eigen::AlignedBox3d box;
  const ShellModel& m = model();
  for (int k = 0; k < m.control_points(); ++k)
    if (!state->motion.detached[m.tables.slot(k)]) box.extend(state->position(m.tables.slot(k)));
  return box;
}

void ShellPart::mark_rubble(PartPieces& now) const {
  const Triangulation& t = *now.triangulation;
  for (std::size_t i = 0; i < t.triangles.size(); ++i) {
    const auto& c = t.triangles[i];
    Piece& piece = now.pieces[t.piece[i]];
    if (!piece.control_points.empty()) continue;
    for (const Vec2& r : rubble)
      if (orientation(t.vertices[c[0]], t.vertices[c[1]], r) >= 0 &&
          orientation(t.vertices[c[1]], t.vertices[c[2]], r) >= 0 &&
          orientation(t.vertices[c[2]], t.vertices[c[0]], r) >= 0)
        piece.handed_off = true;
  }
}

std::shared_ptr<const Triangulation> ShellPart::counted() {
  const ShellModel& m = model();
  const Eigen::AlignedBox2d all = domain_of(m);
  const bool closed = loops.closed(state->cracks.graph, all.min(), all.max(), m.spacing);
  if (closed || !triangulated)
    triangulated = std::make_shared<Triangulation>(sunder::shell::triangulated(m, *state, {}));
  return triangulated;
}

std::shared_ptr<const Triangulation> ShellPart::drawn(std::span<const Eigen::AlignedBox2d> leaving) const {
  return std::make_shared<Triangulation>(sunder::shell::triangulated(model(), *state, leaving));
}

void ShellPart::add_rubble(const Triangulation& t, int piece) {
  for (const int k : t.triangles_of(piece)) {
    const auto& c = t.triangles[k];
    rubble.push_back((t.vertices[c[0]] + t.vertices[c[1]] + t.vertices[c[2]]) / 3.0);
  }
}

double ShellPart::step_with_hertz(double step, const std::vector<Proxy>& proxies, std::size_t bodies,
                                  const Vec3& gravity, double window, std::int64_t now) {
  if (std::none_of(setup->hertz.begin(), setup->hertz.end(), [](double k) { return k > 0.0; })) return step;
  const ShellModel& m = model();
  double shell_speed = 0.0;
  for (int k = 0; k < m.control_points(); ++k)
    if (!state->motion.detached[m.tables.slot(k)])
      shell_speed = std::max(shell_speed, state->velocity(m.tables.slot(k)).norm());
  const Eigen::AlignedBox3d space = box();
  const double without = step;
  for (std::size_t i = 0; i < bodies; ++i) {
    if (setup->hertz[i] == 0.0 || space.isEmpty()) continue;
    const Proxy& p = proxies[i];
    const double speed = p.body.motion.velocity.norm() + gravity.norm() * window + shell_speed;
    if (space.exteriorDistance(p.body.motion.position) > p.radius() + m.largest_thickness() + 2.0 * speed * window)
      continue;
    // The contact stores the energy and returns it. The speed is rounded up to a power of two, since each change of the
    // step costs leapfrog some energy.
    if (speed > hertz_speed) hertz_speed = std::exp2(std::ceil(std::log2(speed)));
    step = hertz_step(m, p.body, setup->hertz[i], hertz_speed, step);
  }
  if (step < without) {
    if (hertz_until >= 0 && now > hertz_until) hertz_windows = std::min(2 * hertz_windows, kHertzKeptMost);
    step = hertz_kept = now <= hertz_until ? std::min(hertz_kept, step) : step;
    hertz_until = now + hertz_windows;
  } else if (now <= hertz_until) {
    step = std::min(step, hertz_kept);
  }
  return step;
}

std::vector<EdgeCut> ShellPart::cut(double now, double span, std::uint64_t& random) {
  std::vector<EdgeCut> on_edges;
  propose_edges({model(), *state, setup->fracture, now, span, random, &on_edges}, CrackMoment::kWindow);
  return on_edges;
}

bool ShellPart::note_squeezed() {
  const ShellModel& m = model();
  const RowTables& t = m.tables;
  const std::size_t stride = t.component_stride;
  const auto left_out = [&] {
    std::vector<char> out(stride, 0);
    for (std::size_t i = 0; i < stride; ++i) out[i] = state->motion.detached[i] != 0 || state->motion.mass[i] == 0.0;
    for (const GatheredPoint& g : state->cracked.gathered) {
      if (g.in_rows) continue;
      for (const GatheredFunction& f : g.functions) out[f.slot] = 1;
      if (g.kind == PointKind::kDead)  // its control points are loose
        for (int k = 0; k < t.support() * t.support(); ++k)
          out[t.slot((g.block / (t.gauss * t.gauss) + k / t.support()) * t.columns + g.lane + k % t.support())] = 1;
    }
    return out;
  };
  const auto squared = [stride](const std::vector<double>& x, int a, int b) {
    double sum = 0.0;
    for (std::size_t d = 0; d < 3 * stride; d += stride) sum += (x[d + a] - x[d + b]) * (x[d + a] - x[d + b]);
    return sum;
  };
  std::vector<char> out;
  std::vector<std::pair<int, float>> nearer;  // control points, and their least distances now
  bool any = false;
  for (int j = 0; j < t.rows; ++j)
    for (int i = 0; i < t.columns; ++i) {
      const int here = t.slot(j * t.columns + i);
      const double known = closest.empty() ? 1.0 : closest[here];
      double least = known * known;
      for (const auto& [di, dj] : {std::pair{1, 0}, {0, 1}, {1, 1}, {-1, 1}}) {
        if (i + di < 0 || i + di >= t.columns || j + dj >= t.rows) continue;
        const int there = t.slot((j + dj) * t.columns + i + di);
        const double now = squared(state->motion.x, here, there), rest = squared(m.rest, here, there);
        if (!(now < least * rest)) continue;
        if (out.empty()) out = left_out();
        if (out[here] == 0 && out[there] == 0) least = now / rest;
      }
      const double ratio = std::sqrt(least);
      if (ratio < known) nearer.emplace_back(j * t.columns + i, static_cast<float>(ratio));
      any = any || ratio < kCloser * known;
    }
  if (!any) return false;
  if (closest.empty()) closest.assign(stride, 1.0f);
  for (const auto& [point, ratio] : nearer) {
    const float known = std::exchange(closest[t.slot(point)], std::min(closest[t.slot(point)], ratio));
    if (ratio < 0.5 * (1.0 + kCloser) * known) changed.push_back(m.parameter[point]);
  }
  return true;
}

void ShellPart::measure_step(std::int64_t window, int threads, const std::vector<const ShellModel*>& shells) {
  const ShellModel& m = model();
  const auto& edges = state->cracks.graph.edges();
  edges_seen = std::max(edges_seen, static_cast<std::size_t>(state->cracks.graph.trims()));
  for (; edges_seen < edges.size(); ++edges_seen) changed.push_back(0.5 * (edges[edges_seen].a + edges[edges_seen].b));
  if (setup->fracture.damages() && window % kDamagedStepWindows == 0)  // damaged points may be strained strongly
    for (const GatheredPoint& g : state->cracked.gathered)
      changed.push_back(gauss_point(m.patch, m.tables, g.block, g.lane).parameter);
  const bool squeezed = note_squeezed();
  if (changed.empty() || (window < next_measure && !squeezed)) return;
  const int iterations = squeezed ? kSqueezedIterations : kLocalIterations;
  double local = stable_step(m, *state, iterations, threads, setup->can_crack(), changed);
  if (m.has_fibres()) local = stable_step_with_fibres(local, shells);
  smallest_step = std::min(smallest_step, local);
  changed.clear();
  next_measure = window + kStepWindows;
}

}  // namespace sunder::shell
