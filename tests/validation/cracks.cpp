// Effects of cracks on the shell around them, and effects that they must not have.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <fmt/format.h>

#include "shell/geometry/builders.h"
#include "shell/mechanics/point_packs.h"
#include "shell/solver/cracking/insertion.h"
#include "shell/solver/cracking/polyline.h"
#include "shell/solver/forces.h"
#include "shell/solver/parting/handoff.h"
#include "shell/solver/stepping/stable_step.h"
#include "tests/validation/cases.h"

namespace sunder::validation {
namespace {

using namespace sunder::shell;

using std::numbers::pi;
constexpr double kPaneYoung = 70e9, kPaneThickness = 0.004;

ShellMaterial pane_glass() {
  ShellMaterial m;
  m.density = 2500, m.youngs_modulus = kPaneYoung, m.poisson_ratio = 0.22, m.strength = 60e6, m.fracture_energy = 8.0;
  return m;
}

ShellModel flat(int elements) {
  return make_shell("flat", plate(0.2, 0.2, elements, elements, Vec3::Zero(), Quat::Identity()), kPaneThickness,
                    pane_glass(), 2, 2, {});
}
// A rational patch: a sector of a cylinder.
ShellModel curved(int elements) {
  return make_shell("curved", cylinder(0.2, 0.2, 1.0, elements, elements), kPaneThickness, pane_glass(), 2, 2, {});
}

// Returns the largest force on a control point over E thickness spacing, which is the force of a strain of one.
double largest_force(const ShellModel& m, ShellState& s) {
  compute_forces(m, s, false, 0.0, 1);
  double largest = 0.0;
  for (int i = 0; i < m.control_points(); ++i)
    largest = std::max(largest, s.at(s.motion.force, m.tables.slot(i)).norm());
  return largest / (kPaneYoung * m.thickness * m.spacing);
}

void move(const ShellModel& m, ShellState& s, const std::vector<int>& points, const Quat& turn, const Vec3& by) {
  for (const int i : points) {
    const Vec3 x = turn * s.at(m.rest, m.tables.slot(i)) + by;
    for (int d = 0; d < 3; ++d)
      s.motion.x[d * static_cast<std::size_t>(m.tables.component_stride) + m.tables.slot(i)] = x[d];
  }
}

// Checks every crack edge against every line between a point and a control point, without bins. Returns the sum of four
// counts: functions that look through a crack; visible control points within the support that have no function; points
// that should have been gathered; gathered points whose functions are not those of the present cracks.
int visibility_errors(const ShellModel& m, const ShellState& s) {
  const RowTables& t = m.tables;
  const auto sees = [&](const Vec2& p, int control_point) {
    for (const CrackEdge& e : s.cracks.graph.edges())
      if (segments_meet(p, m.parameter[control_point], e.long_a, e.long_b)) return false;
    return true;
  };
  int errors = 0;
  for (int q = 0; q < t.blocks(); ++q)
    for (int e = 0; e < t.spans_u; ++e) {
      const Vec2 p = gauss_point(m.patch, t, q, e).parameter;
      const int point = s.cracked.point_of[static_cast<std::size_t>(q) * t.lanes + e];
      if (point >= 0) {
        const GatheredPoint& g = s.cracked.gathered[point];
        const auto distance = [&](int control_point) {
          const Vec2 d = (m.parameter[control_point] - p).cwiseAbs();
          return std::max(d.x() / m.spacing_u, d.y() / m.spacing_v);
        };
        double reach = 0.0;  // of the support; points on its rim do not count
        for (const GatheredFunction& f : g.functions) {
          errors += !sees(p, t.control_point(f.slot));
          reach = std::max(reach, distance(t.control_point(f.slot)) - 1e-9);
        }
        const MlsPoint fresh = mls_point(control_grid(m), s.cracks.graph, p, e, q / (t.gauss * t.gauss));
        if (g.kind == PointKind::kDead || fresh.basis == MlsBasis::kNone) continue;
        for (int i = 0; i < m.control_points(); ++i)
          errors += distance(i) < reach && sees(p, i) &&
                    std::none_of(g.functions.begin(), g.functions.end(),
                                 [&](const GatheredFunction& f) { return t.control_point(f.slot) == i; });
        std::vector<GatheredFunction> functions;
        for (const MlsFunction& f : fresh.functions) functions.push_back({t.slot(f.control_point), f.n});
        round_to_units(functions);
        errors += functions.size() != g.functions.size();
        for (std::size_t k = 0; k < g.functions.size() && k < functions.size(); ++k)
          errors += functions[k].slot != g.functions[k].slot || functions[k].n != g.functions[k].n;
      } else {
        for (const GatheredFunction& f : patch_functions(m.patch, p, t.stride))
          errors += !sees(p, t.control_point(f.slot));
      }
    }
  return errors;
}

struct Worst {
  double step = 1.0, rest = 0.0, moved = 0.0, parted = 0.0, local = 0.0;
  int visibility = 0, cuts = 0, wrong_pieces = 0;
};

// After an insertion: visibility, and the stable step near the cut against that of the whole shell.
void look(const ShellModel& m, ShellState& s, double intact, const std::vector<Vec2>& around, Worst& w) {
  w.visibility += visibility_errors(m, s);
  const double whole = stable_step(m, s, 200, 1, true);
  w.step = std::min(w.step, whole / intact);
  // A run keeps the least stable step so far, which starts with that of the intact shell.
  w.local = std::max(w.local, std::min(intact, stable_step(m, s, kLocalIterations, 1, true, around)) / whole - 1.0);
  w.rest = std::max(w.rest, largest_force(m, s));
}

// Separated pieces must have no strain, and neither must a shell that moves as a whole.
void part(const ShellModel& m, ShellState& s, int expected, Worst& w) {
  std::vector<Piece> pieces;
  w.wrong_pieces += partition(m, s, pieces).pieces != expected;
  std::vector<int> all(m.control_points());
  for (int i = 0; i < m.control_points(); ++i) all[i] = i;
  move(m, s, all, rotation_from_vector(Vec3(0.3, -0.7, 0.5)), Vec3(0.1, 0.2, 0.3));
  w.moved = std::max(w.moved, largest_force(m, s));
  if (pieces.size() < 2) return;
  move(m, s, all, Quat::Identity(), Vec3::Zero());
  move(m, s, pieces[0].control_points, Quat::Identity(), Vec3(0.0, 0.0, 0.05));
  w.parted = std::max(w.parted, largest_force(m, s));
}

std::vector<Vec2> spiral(const Vec2& centre, double turns, double inner, double outer) {
  std::vector<Vec2> points;
  constexpr int kPerTurn = 48;
  for (int k = 0; k <= turns * kPerTurn; ++k) {
    const double a = 2.0 * pi * k / kPerTurn, r = inner + (outer - inner) * k / (turns * kPerTurn);
    points.push_back(centre + r * Vec2(std::cos(a), std::sin(a)));
  }
  return points;
}

void report(Report& r, const std::string& name, const Worst& w, double seconds) {
  r.add(name + "_stable_step", w.step, 1.0, 0.2, seconds);
  r.add(name + "_local_stable_step", w.local, 0.0, 0.1, 0.0);  // what a run measures after an insertion
  r.add(name + "_visibility_errors", w.visibility, 0.0, 0.0, 0.0);
  r.add(name + "_rest_strain", w.rest, 0.0, 1e-12, 0.0);
  r.add(name + "_rigid_motion_strain", w.moved, 0.0, 1e-12, 0.0);
  r.add(name + "_parted_strain", w.parted, 0.0, 5e-14, 0.0);  // round-off of one piece is 1e-14
  r.add(name + "_wrong_pieces", w.wrong_pieces, 0.0, 0.0, 0.0);
}

void cuts_case(Report& r, int threads) {
  const double start = seconds_now();
  constexpr int kCuts = 200;
  std::vector<Worst> all(kCuts);
#pragma omp parallel for schedule(dynamic) num_threads(threads)
  for (int k = 0; k < kCuts; ++k) {
    std::mt19937_64 random(1000 + k);
    std::uniform_real_distribution<double> uniform(0.0, 1.0);
    const ShellModel m = k % 4 == 3 ? curved(16) : flat(20);
    const Vec2 low(m.patch.knots_u.begin(), m.patch.knots_v.begin()),
        high(m.patch.knots_u.end(), m.patch.knots_v.end());
    ShellState s = make_state(m, Vec3::Zero(), 1);
    const double intact = stable_step(m, s, 200, 1, true);
    const Vec2 centre = low + (high - low).cwiseProduct(Vec2(0.2 + 0.6 * uniform(random), 0.2 + 0.6 * uniform(random)));
    const double angle = pi * uniform(random);
    const Vec2 d(std::cos(angle), std::sin(angle));
    // Half of them run from border to border.
    double back = 0.3 * uniform(random) * (high - low).x(), ahead = 0.3 * uniform(random) * (high - low).x();
    const bool through = k % 2 == 0;
    if (through)
      for (double* reach : {&back, &ahead}) {
        const double sign = reach == &back ? -1.0 : 1.0;
        *reach = 0.0;
        while (m.patch.contains(centre + sign * (*reach + 1e-3) * d)) *reach += 1e-3;
        double over = 1e-3;  // to the border itself
        for (int i = 0; i < 40; ++i, over *= 0.5)
          if (m.patch.contains(centre + sign * (*reach + 0.5 * over) * d)) *reach += 0.5 * over;
      }
    insert_polyline(m, s, {centre - back * d, centre + ahead * d}, 0.0);
    look(m, s, intact, {centre - back * d, centre, centre + ahead * d}, all[k]);
    part(m, s, through ? 2 : 1, all[k]);
  }
  Worst w;
  for (const Worst& one : all) {
    w.step = std::min(w.step, one.step), w.local = std::max(w.local, one.local), w.rest = std::max(w.rest, one.rest);
    w.moved = std::max(w.moved, one.moved), w.parted = std::max(w.parted, one.parted);
    w.visibility += one.visibility, w.wrong_pieces += one.wrong_pieces;
  }
  report(r, "cuts_200", w, seconds_now() - start);
}

void joints_case(Report& r, int) {
  const double start = seconds_now();
  Worst w;
  for (const bool cylinder : {false, true}) {
    const ShellModel m = cylinder ? curved(24) : flat(24);
    ShellState s = make_state(m, Vec3::Zero(), 1);
    const double intact = stable_step(m, s, 200, 1, true);
    // A crossing, a joint, and a cut that ends just before another one.
    const std::vector<std::vector<Vec2>> cuts{{{0.0, 0.071}, {0.2, 0.093}},
                                              {{0.083, 0.0}, {0.119, 0.2}},
                                              {{0.151, 0.0}, {0.151, 0.0876}},
                                              {{0.03, 0.16}, {0.09, 0.13}}};
    for (const auto& cut : cuts) {
      insert_polyline(m, s, cut, 0.0);
      look(m, s, intact, {cut[0], 0.5 * (cut[0] + cut[1]), cut[1]}, w);
    }
    part(m, s, 5, w);
  }
  report(r, "joints", w, seconds_now() - start);
}

void spiral_case(Report& r, int) {
  const double start = seconds_now();
  Worst w;
  const ShellModel m = flat(64);
  ShellState s = make_state(m, Vec3::Zero(), 1);
  const double intact = stable_step(m, s, 200, 1, true);
  const std::vector<Vec2> points = spiral({0.1003, 0.0997}, 4.0, 0.008, 0.085);
  for (std::size_t k = 1; k < points.size(); ++k) {
    insert_polyline(m, s, {points[k - 1], points[k]}, 0.0);
    look(m, s, intact, {points[k - 1], points[k]}, w);
  }
  part(m, s, 1, w);
  report(r, "spiral", w, seconds_now() - start);
  int kinds[3] = {};
  for (const GatheredPoint& g : s.cracked.gathered) ++kinds[static_cast<int>(g.kind)];
  r.lines.push_back(
      fmt::format("spiral: four turns, {} edges, {} points with functions of their own, {} linear, {} dead",
                  s.cracks.graph.edges().size(), s.cracked.gathered.size(), kinds[1], kinds[2]));
}

}  // namespace

std::vector<Case> crack_cases() {
  return {{"cuts", "200 random cuts, on flat and on rational patches", cuts_case},
          {"joints", "crossings, joints, ends beside another crack", joints_case},
          {"spiral", "the Archimedean spiral of the paper's Fig. 13", spiral_case}};
}

}  // namespace sunder::validation
