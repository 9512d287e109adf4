#include "shell/solver/cracking/insertion.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "shell/solver/forces.h"
#include "shell/solver/interlock.h"

namespace sunder::shell {
namespace {

constexpr std::size_t kTrials = 8;  // that are remembered of a point
constexpr int kForget = 128;        // edges after which all are forgotten

std::vector<GatheredFunction> to_slots(const ShellModel& m, const MlsPoint& p) {
  std::vector<GatheredFunction> out;
  out.reserve(p.functions.size());
  for (const MlsFunction& f : p.functions) out.push_back({m.tables.slot(f.control_point), f.n});
  return out;
}

// The Gauss point as it is now. Where no crack has touched it, `made` gets it, with the functions of the uncut patch.
const GatheredPoint& present_point(const ShellModel& m, const ShellState& s, int block, int lane, GatheredPoint& made) {
  const RowTables& t = m.tables;
  const int index = s.cracked.point_of[static_cast<std::size_t>(block) * t.lanes + lane];
  if (index >= 0) return s.cracked.gathered[index];
  GatheredPoint& g = made;
  g.block = block, g.lane = lane, g.kind = PointKind::kQuadratic;
  g.functions = patch_functions(m.patch, gauss_point(m.patch, t, block, lane).parameter, t.stride);
  thicken(g.functions, t.thickness_factor(block, lane));
  const double* metric = &s.cracked.tables.metric[t.at(block, kMetricFields, 0, lane)];
  g.area = metric[kArea * t.lanes];
  g.metric = {{metric[kA11 * t.lanes], metric[kA22 * t.lanes], metric[kA12 * t.lanes]},
              {metric[kB11 * t.lanes], metric[kB22 * t.lanes], metric[kB12 * t.lanes]}};
  return g;
}

int visibility_at(const ShellModel& m, ShellState& s, int block, int lane) {
  const RowTables& t = m.tables;
  const std::size_t gauss = static_cast<std::size_t>(block) * t.lanes + lane;
  int& index = s.caches.visibility_of[gauss];
  if (index >= 0) return index;
  s.caches.visibility.push_back(first_visibility(m, s.cracks.graph, gauss_point(m.patch, t, block, lane).parameter,
                                                 lane, block / (t.gauss * t.gauss)));
  s.caches.used.push_back(s.caches.visibility.back());
  if (s.cracked.point_of[gauss] >= 0)
    note_uses(m, s.cracked.gathered[s.cracked.point_of[gauss]].functions, s.caches.used.back());
  return index = static_cast<int>(s.caches.visibility.size()) - 1;
}

// The same point with the functions that cracks leave it. A point that was spent before gets no bending back.
GatheredPoint renewed(const ShellModel& m, const Visibility& visibility, const GatheredPoint& old, bool spent) {
  GatheredPoint g;
  g.block = old.block, g.lane = old.lane, g.area = old.area, g.metric = old.metric;
  const MlsPoint mls = mls_point(control_grid(m), visibility);
  g.kind = mls.basis == MlsBasis::kQuadratic ? PointKind::kQuadratic
           : mls.basis == MlsBasis::kLinear  ? PointKind::kLinear
                                             : PointKind::kDead;
  if (spent) g.kind = std::max(g.kind, old.kind);
  g.functions = to_slots(m, mls);
  thicken(g.functions, m.tables.thickness_factor(g.block, g.lane));
  round_to_units(g.functions);
  if (g.kind != PointKind::kDead) {
    const Forms<double> rest = surface_forms(gather(m.tables, g, m.rest));
    g.metric = {rest.a, rest.b};
  }
  return g;
}

// The same, from a trial with the same visibility where there was one. Valid until the next trial of that point.
Caches::Trial& tried(const ShellModel& m, const Visibility& visibility, const GatheredPoint& old, bool spent,
                     std::vector<Caches::Trial>& trials) {
  for (Caches::Trial& known : trials)
    if (known.visibility.sees_the_same(visibility)) return known;
  if (trials.size() == kTrials) trials.erase(trials.begin());
  trials.push_back({visibility, renewed(m, visibility, old, spent)});
  return trials.back();
}

void remember_point(const ShellModel& m, ShellState& s, int block, int lane) {
  const std::size_t gauss = static_cast<std::size_t>(block) * m.tables.lanes + lane;
  GatheredPoint made;
  s.cracked.gathered.push_back(present_point(m, s, block, lane, made));
  if (s.weakens()) {
    s.cracked.damage.emplace_back();
    s.cracked.damage.back().strength = s.layers.strength[gauss];
  }
  s.cracked.point_of[gauss] = static_cast<int>(s.cracked.gathered.size()) - 1;
  if (s.caches.visibility_of[gauss] >= 0)
    note_uses(m, s.cracked.gathered.back().functions, s.caches.used[s.caches.visibility_of[gauss]]);
}

// The row kernel leaves the point out from now on.
void leave_rows(const ShellModel& m, ShellState& s, int block, int lane) {
  const std::size_t gauss = static_cast<std::size_t>(block) * m.tables.lanes + lane;
  s.cracked.tables.metric[m.tables.at(block, kMetricFields, kArea, lane)] = 0.0;
  GatheredPoint& point = s.cracked.gathered[s.cracked.point_of[gauss]];
  if (point.in_rows) point.in_rows = false, s.cracked.watched[gauss] = 0;
}

// Distance of the furthest control point that a point at p uses, the larger of the two coordinates [spacings].
float reach_of(const ShellModel& m, const GatheredPoint& g, const Vec2& p) {
  double reach = 0.0;
  for (const GatheredFunction& f : g.functions) {
    const Vec2 d = (m.parameter_of_slot[f.slot] - p).cwiseAbs();
    reach = std::max({reach, d.x() / m.spacing_u, d.y() / m.spacing_v});
  }
  return static_cast<float>(reach * (1.0 + 1e-6));  // more than rounding
}

// A Gauss point that may look across an edge.
struct Candidate {
  int block, lane;
  bool unsure;  // its control points are not noted yet
};

// The candidates of one row of elements. Changes nothing. `low`, `high`: box of the edge and of all points that can
// look across it.
std::vector<Candidate> candidates_in(const ShellModel& m, const ShellState& s, const CrackEdge& e, int f,
                                     const Vec2& low, const Vec2& high) {
  const RowTables& t = m.tables;
  const Vec2 edge_low = e.long_a.cwiseMin(e.long_b), edge_high = e.long_a.cwiseMax(e.long_b);
  const int first_lane = m.patch.knots_u.span_of(low.x()), last_lane = m.patch.knots_u.span_of(high.x());
  thread_local std::vector<char> beside;
  beside.resize(last_lane + 1);
  for (int lane = first_lane; lane <= last_lane; ++lane) {
    // an element lies among its control points, and those in this box
    const Vec2 &first = m.parameter[f * t.columns + lane],
               &last = m.parameter[(f + t.degree) * t.columns + lane + t.degree];
    beside[lane] = (first.array() <= edge_high.array()).all() && (last.array() >= edge_low.array()).all();
  }
  std::vector<Candidate> found;
  for (int block = f * t.gauss * t.gauss; block < (f + 1) * t.gauss * t.gauss; ++block)
    for (int lane = first_lane; lane <= last_lane; ++lane) {
      const std::size_t gauss = static_cast<std::size_t>(block) * t.lanes + lane;
      const double reach = s.cracked.reach[gauss];
      if (reach == 0.0 && !beside[lane]) continue;
      const GaussPoint g = gauss_point(m.patch, t, block, lane);
      const Vec2 gap = (edge_low - g.parameter).cwiseMax(g.parameter - edge_high);
      if (g.weight == 0.0 || (reach > 0.0 && (gap.x() > reach * m.spacing_u || gap.y() > reach * m.spacing_v)))
        continue;
      const int point = s.cracked.point_of[gauss];
      bool hit = false, unsure = false;  // only control points that it uses matter
      if (point < 0) {
        for (int k = 0; k < t.support() * t.support() && !hit; ++k)
          hit = segments_meet(g.parameter, m.parameter[(f + k / t.support()) * t.columns + lane + k % t.support()],
                              e.long_a, e.long_b);
      } else if (!s.cracked.gathered[point].functions.empty()) {
        unsure = s.caches.visibility_of[gauss] < 0;
        hit = unsure || s.caches.used[s.caches.visibility_of[gauss]].loses(control_grid(m), e);
      }
      if (hit) found.push_back({block, lane, unsure});
    }
  return found;
}

// Gauss points that look across an edge, in rising order of blocks and lanes.
std::vector<std::pair<int, int>> touched_points(const ShellModel& m, ShellState& s, const CrackEdge& e, int threads) {
  const Vec2 pad = Vec2(m.spacing_u, m.spacing_v) * kLargestSupport;
  const Vec2 low = e.a.cwiseMin(e.b) - pad, high = e.a.cwiseMax(e.b) + pad;
  const int first = m.patch.knots_v.span_of(low.y()), end = m.patch.knots_v.span_of(high.y()) + 1;
  std::vector<std::vector<Candidate>> rows(end - first);
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads) if (threads > 1)
  for (int f = first; f < end; ++f) rows[f - first] = candidates_in(m, s, e, f, low, high);
  std::vector<std::pair<int, int>> touched;
  for (const std::vector<Candidate>& row : rows)
    for (const auto& [block, lane, unsure] : row)
      if (!unsure || s.caches.used[visibility_at(m, s, block, lane)].loses(control_grid(m), e))
        touched.push_back({block, lane});
  return touched;
}

}  // namespace

int gather_point(const ShellModel& m, ShellState& s, int block, int lane) {
  const RowTables& t = m.tables;
  const std::size_t gauss = static_cast<std::size_t>(block) * t.lanes + lane;
  if (s.cracked.point_of[gauss] < 0) remember_point(m, s, block, lane);
  leave_rows(m, s, block, lane);
  return s.cracked.point_of[gauss];
}

void watch_point(const ShellModel& m, ShellState& s, int block, int lane) {
  const std::size_t gauss = static_cast<std::size_t>(block) * m.tables.lanes + lane;
  if (s.cracked.point_of[gauss] >= 0) return;
  remember_point(m, s, block, lane);
  s.cracked.gathered[s.cracked.point_of[gauss]].in_rows = true;
  if (s.cracked.watched.empty()) s.cracked.watched.assign(s.cracked.point_of.size(), 0);
  s.cracked.watched[gauss] = 1;
}

namespace {

// `plastic` is read where layers yield.
PointMemory memory_of(const ShellState& s, const PointDamage* damage, const RowPlasticity& plastic) {
  return {damage, s.layers.brittleness, s.layers.heals, s.yields() ? &plastic : nullptr};
}

// A Gauss point that new edges touch.
struct Renewal {
  Renewal(int block, int lane, int visibility) : block(block), lane(lane), visibility(visibility) {}

  int block, lane, visibility;
  GatheredPoint own;               // a result that is not kept for other trials
  GatheredPoint* point = nullptr;  // `own`, or the point of a trial
  GatheredPoint made;              // the old point, where no crack had touched it
  PointDamage damage;
  double before = 0.0, after = 0.0;                 // elastic energy before and after [J]
  std::optional<Derivatives<double>> lost, gained;  // forces before, and minus the forces after
};

// Finds the new state of the point. Changes nothing of the shell but the trials and the visibility of this point. Edges
// from `first` on are on trial: the kept visibility does not have them yet.
void renew(const ShellModel& m, ShellState& s, int first, int end, double time, Renewal& r) {
  const RowTables& t = m.tables;
  const std::size_t gauss = static_cast<std::size_t>(r.block) * t.lanes + r.lane;
  const GatheredPoint& old = present_point(m, s, r.block, r.lane, r.made);
  const int point = s.cracked.point_of[gauss];
  PointDamage fresh;
  if (s.weakens()) fresh.strength = s.layers.strength[gauss];
  const PointDamage* damage = !s.weakens() ? nullptr : point >= 0 ? &s.cracked.damage[point] : &fresh;
  RowPlasticity layers;
  if (s.yields()) layers = plasticity_of(m, s);
  const PointMemory memory = memory_of(s, damage, layers);
  // damage changes the energy of the full material only by what flows
  const PointMemory of_full = memory_of(s, s.yields() ? damage : nullptr, layers);
  const auto elastic = [&](const GatheredPoint& g) { return full_energy(t, g, s.motion.x, of_full); };
  // edges of one moment are tried on one state: longer ones, shorter ones, those of the next tip
  const auto at_present = [&](const GatheredPoint& g, TimedEnergy& known) {
    if (s.yields() || known.time != time) known = {elastic(g), time};
    return known.energy;
  };
  const double full = s.caches.trials.empty() ? elastic(old) : at_present(old, s.caches.trials[r.visibility].present);
  const double held = damage ? point_energy(t, old, s.motion.x, memory) : full;
  s.caches.visibility[r.visibility].update(control_grid(m), s.cracks.graph, first);
  Visibility visibility = s.caches.visibility[r.visibility];
  visibility.update(control_grid(m), s.cracks.graph, end);
  double left = 0.0;
  const bool spent = damage && damage->worst() >= 1.0f;
  if (s.caches.trials.empty()) {
    r.own = renewed(m, visibility, old, spent), r.point = &r.own;
    left = elastic(r.own);
  } else {
    Caches::Trial& trial = tried(m, visibility, old, spent, s.caches.trials[r.visibility].known);
    r.point = &trial.point;
    left = at_present(trial.point, trial.energy);
  }
  const double most =
      damage ? full + damage->strength * damage->strength / (2.0 * m.material.youngs_modulus) * m.thickness * old.area
             : kMostGain * full + kFreeEnergy * m.material.youngs_modulus * m.thickness * old.area;
  if (left > most) {
    // between torn faces one-sided functions see distances that are no strain: such a point is rubble
    const GatheredPoint& g = *r.point;
    GatheredPoint rubble;
    rubble.block = g.block, rubble.lane = g.lane, rubble.area = g.area, rubble.metric = g.metric;
    r.own = std::move(rubble), r.point = &r.own;
    left = 0.0;
  }
  PointDamage d = damage ? *damage : fresh;
  d.fresh = true, d.retained = 0.0;
  if (damage && s.layers.heals) {
    // a damaged point stores the same share of the full energy as before
    d.retained = full > 0.0 ? left * std::clamp(1.0 - held / full, 0.0, 1.0) : 0.0;
  } else if (damage) {
    settle_damage(t, *r.point, s.motion.x, memory, d);
  }
  r.before = held, r.after = left - d.retained;
  r.damage = d;
}

// Pairs of faces that bear, within the largest support of the edges from `first` on, in rising order.
std::vector<int> interlocks_near(const ShellModel& m, const ShellState& s, int first) {
  // their functions belong to points just beside the middle of an edge
  const Vec2 pad = 1.01 * kLargestSupport * Vec2(m.spacing_u, m.spacing_v);
  std::vector<int> found;
  for (int k = first; k < static_cast<int>(s.cracks.graph.edges().size()); ++k) {
    const CrackEdge& e = s.cracks.graph.edges()[k];
    s.cracks.graph.near_since(e.long_a.cwiseMin(e.long_b) - pad, e.long_a.cwiseMax(e.long_b) + pad, 0, [&](int other) {
      const int lock = s.cracks.interlock_of[other];
      if (lock >= 0 && s.cracks.interlocks[lock].holds) found.push_back(lock);
    });
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

// Stores the new points, and adds the change of their forces to the force discontinuity.
void relieve(const ShellModel& m, ShellState& s, std::vector<Renewal>& changed, int threads) {
  if (changed.empty()) return;
  const RowTables& t = m.tables;
  RowPlasticity layers;
  if (s.yields()) layers = plasticity_of(m, s);
  const bool damaged = s.weakens();
  const auto force_of = [&](const GatheredPoint& g, double times, const PointDamage* damage) {
    return point_force(t, g, s.motion.x, times, memory_of(s, damage, layers));
  };
  const auto index_of = [&](const Renewal& r) -> int& {
    return s.cracked.point_of[static_cast<std::size_t>(r.block) * t.lanes + r.lane];
  };
#pragma omp parallel for schedule(dynamic, 4) num_threads(threads) if (threads > 1)
  for (Renewal& r : changed) {
    const int known = index_of(r);
    const GatheredPoint& old = present_point(m, s, r.block, r.lane, r.made);
    r.lost = force_of(old, 1.0, damaged && known >= 0 ? &s.cracked.damage[known] : nullptr);
    if (s.yields()) settle_flow(t, *r.point, s.motion.x, memory_of(s, damaged ? &r.damage : nullptr, layers));
    r.gained = force_of(*r.point, -1.0, damaged ? &r.damage : nullptr);
  }
  std::vector<double>& discontinuity = s.discontinuity();
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads) if (threads > 1)
  for (int k = 0; k < 3; ++k)
    for (Renewal& r : changed) {  // sums in one order
      if (r.lost) spread(t, index_of(r) < 0 ? r.made : s.cracked.gathered[index_of(r)], *r.lost, k, discontinuity);
      if (r.gained) spread(t, *r.point, *r.gained, k, discontinuity);
    }
  for (Renewal& r : changed) {
    int& index = index_of(r);
    if (index < 0) {
      index = static_cast<int>(s.cracked.gathered.size());
      s.cracked.gathered.emplace_back();
      if (damaged) s.cracked.damage.emplace_back();
    }
    leave_rows(m, s, r.block, r.lane);
  }
#pragma omp parallel for schedule(dynamic, 4) num_threads(threads) if (threads > 1)
  for (Renewal& r : changed) {
    GatheredPoint& g = s.cracked.gathered[index_of(r)] = std::move(*r.point);
    s.cracked.note_kind(g);
    if (damaged) s.cracked.damage[index_of(r)] = r.damage;
    if (!s.caches.trials.empty()) s.caches.trials[r.visibility] = {};
    if (g.kind == PointKind::kDead)
      for (int f = 0; f < 6; ++f) s.layers.face_stress[t.at(g.block, 6, f, g.lane)] = 0.0;
    s.cracked.reach[static_cast<std::size_t>(g.block) * t.lanes + g.lane] =
        reach_of(m, g, s.caches.visibility[r.visibility].point());
    note_uses(m, g.functions, s.caches.used[r.visibility]);
  }
}

// Recomputes the shape functions of faces that the new edges, from `first` on, separate from their control points. With
// `interlock`, creates the faces of the new edges.
void key_faces(const ShellModel& m, ShellState& s, int first, bool interlock, int threads) {
  const int end = static_cast<int>(s.cracks.graph.edges().size());
  s.cracks.interlock_of.resize(end, -1);
  const std::vector<int> near = interlocks_near(m, s, first);
  std::vector<Refastened> again(near.size());
  std::vector<Interlock> fresh(interlock ? end - first : 0);
  std::vector<char> keyed(fresh.size());
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads) if (threads > 1)
  for (std::size_t i = 0; i < fresh.size() + near.size(); ++i) {
    if (i >= fresh.size()) {
      Interlock& lock = s.cracks.interlocks[near[i - fresh.size()]];
      if (loses_visibility(m, s, lock, first)) again[i - fresh.size()] = refasten(m, s, lock);
      continue;
    }
    Interlock& lock = fresh[i];
    lock.edge = first + static_cast<int>(i);
    const CrackEdge& e = s.cracks.graph.edges()[lock.edge];
    if (e.is_trim()) continue;
    lock.area = (e.b - e.a).norm() * m.thickness_at(0.5 * (e.a + e.b));
    keyed[i] = fasten(m, s, lock);
  }
  for (const Refastened& r : again) {
    for (const auto& [slot, force] : r.force_change)
      for (int d = 0; d < 3; ++d) s.discontinuity()[d * m.tables.component_stride + slot] += force[d];
    s.release_by_faces(r.released);
  }
  for (std::size_t i = 0; i < fresh.size(); ++i) {
    if (!keyed[i]) continue;
    s.cracks.interlock_of[first + i] = static_cast<int>(s.cracks.interlocks.size());
    s.cracks.interlocks.push_back(std::move(fresh[i]));
  }
}

// The edges from `first` on have just been added to the graph. The points that they touch get new functions. Returns
// false, and nothing has changed, where they must release energy and do not.
bool take_in(const ShellModel& m, ShellState& s, int first, double time, bool interlock, bool must_release,
             int threads) {
  const RowTables& t = m.tables;
  const int end = static_cast<int>(s.cracks.graph.edges().size());
  std::vector<std::pair<int, int>> touched;
  for (int k = first; k < end; ++k) {
    const auto more = touched_points(m, s, s.cracks.graph.edges()[k], threads);
    touched.insert(touched.end(), more.begin(), more.end());
  }
  if (end - first > 1) {
    std::sort(touched.begin(), touched.end());
    touched.erase(std::unique(touched.begin(), touched.end()), touched.end());
  }
  std::vector<Renewal> changed;
  for (const auto& [block, lane] : touched) changed.emplace_back(block, lane, visibility_at(m, s, block, lane));
  s.caches.trials.resize(must_release ? s.caches.visibility.size() : 0);
  if (s.yields())  // positions have moved since the layers last yielded; that work is not the crack's
    for (const auto& [block, lane] : touched) {
      GatheredPoint made;
      const int point = s.cracked.point_of[static_cast<std::size_t>(block) * t.lanes + lane];
      const RowPlasticity layers = plasticity_of(m, s);
      const PointDamage* damage = s.weakens() && point >= 0 ? &s.cracked.damage[point] : nullptr;
      s.book.plastic +=
          settle_flow(t, present_point(m, s, block, lane, made), s.motion.x, memory_of(s, damage, layers));
    }
#pragma omp parallel for schedule(dynamic, 4) num_threads(threads) if (threads > 1)
  for (std::size_t k = 0; k < changed.size(); ++k) renew(m, s, first, end, time, changed[k]);
  double before = 0.0, after = 0.0;
  for (const Renewal& r : changed) before += r.before, after += r.after;
  if (must_release && after > before) return false;
  relieve(m, s, changed, threads);
  key_faces(m, s, first, interlock, threads);
  if (after > before)
    s.book.injected += after - before;
  else
    s.release(before - after);
  if (must_release) s.cracks.taken += before - after;
  if (first / kForget != end / kForget) s.caches.trials.clear();  // points that cracks have passed are not tried again
  s.cracks.last_crack_time = time;
  s.motion.last_force.clear();  // the next force differs by the crack, not by motion
  return true;
}

// Length [m] up to `most` that an edge may go from p along `way`, outside of the loops, without reaching the other side
// of a narrow gap.
double room_outside(const ShellModel& m, const CrackGraph& graph, const Vec2& p, const Vec2& way, double most) {
  for (double length = most; length > kCutOnCrack * m.spacing; length *= 0.5) {
    const Vec2 from = p + 2.0 * kCutOnCrack * m.spacing * way, to = p + length * way;
    bool clear = true;
    graph.near(from, to, 0.0, [&](int e) {
      clear = e >= graph.trims() || !segments_meet(from, to, graph.edges()[e].a, graph.edges()[e].b);
      return clear;
    });
    if (clear) return length;
  }
  return 0.0;
}

// Extends new cracks, the edges from `first` on, that end on or beyond a trim loop. Control points outside the loop
// then lie on one side of the crack.
void run_out_of_trims(const ShellModel& m, ShellState& s, int first, double time) {
  if (m.trim.empty()) return;
  CrackGraph& graph = s.cracks.graph;
  const auto run_out = [&](int vertex, const Vec2& before) {
    const Vec2 p = graph.vertices()[vertex];
    int loop = -1;
    double nearest = kTrimRunOut * m.spacing;
    bool known = false;
    graph.near(p, p, nearest, [&](int e) {
      Vec2 foot;
      const double distance = graph.distance(p, e, foot);
      if (e < graph.trims() && distance < nearest) nearest = distance, loop = e;
      known = known || (e >= graph.trims() && graph.edges()[e].is_trim() && graph.edges()[e].from == vertex);
      return true;
    });
    if (loop < 0 || known || (nearest > kCutOnCrack * m.spacing && m.trim.loops.contains(p))) return;
    const Vec2 along = (graph.edges()[loop].b - graph.edges()[loop].a).normalized(), out(along.y(), -along.x());
    const Vec2 straight = (p - before).normalized(), way = straight.dot(out) > kLeavesLoop ? straight : out;
    const double length = room_outside(m, graph, p, way, kTrimRunOut * m.spacing);
    if (length > 0.0) graph.add_edge(vertex, graph.add_vertex(p + length * way), CrackEdge::kTrim, time, 0);
  };
  const int end = static_cast<int>(graph.edges().size());
  for (int k = first; k < end; ++k) {
    const CrackEdge e = graph.edges()[k];
    run_out(e.from, e.b), run_out(e.to, e.a);
  }
}

}  // namespace

int insert_edge(const ShellModel& m, ShellState& s, int from, int to, int crack, double time, int face,
                bool interlock) {
  const int index = s.cracks.graph.add_edge(from, to, crack, time, face);
  if (index < 0) return index;
  run_out_of_trims(m, s, index, time);
  take_in(m, s, index, time, interlock, false, 1);
  return index;
}

int extend_cracks(const ShellModel& m, ShellState& s, const std::vector<NewEdge>& edges, double time, bool interlock,
                  int threads) {
  const int first = static_cast<int>(s.cracks.graph.edges().size());
  const std::size_t vertices = s.cracks.graph.vertices().size();
  bool whole = true;
  for (const NewEdge& e : edges) {
    const int index =
        s.cracks.graph.add_edge(e.from, s.cracks.graph.add_vertex(e.to), e.crack, time, e.face, e.resistance);
    whole = whole && index >= 0;
  }
  if (whole) run_out_of_trims(m, s, first, time);
  if (whole && take_in(m, s, first, time, interlock, true, threads)) return first;
  while (static_cast<int>(s.cracks.graph.edges().size()) > first) s.cracks.graph.undo_edge();
  while (s.cracks.graph.vertices().size() > vertices) s.cracks.graph.undo_vertex();
  return -1;
}

}  // namespace sunder::shell
