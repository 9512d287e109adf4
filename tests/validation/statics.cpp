// Shells at rest under loads: the shell obstacle course and large deflections.
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "shell/geometry/builders.h"
#include "shell/io/probes.h"
#include "shell/mechanics/layers_yielding.h"
#include "shell/solver/statics/relaxation.h"
#include "tests/validation/cases.h"

namespace sunder::validation {
namespace {

using namespace sunder::shell;

using std::numbers::pi;
// share of the load, for references of linear theory: at a tenth the roof is 2 % stiffer
constexpr double kSmall = 1e-3;

ShellMaterial elastic_material(double young, double poisson) {
  ShellMaterial m;
  m.density = 1.0, m.youngs_modulus = young, m.poisson_ratio = poisson;
  return m;
}

Support symmetry(int edges, int axis) {
  Support s;
  s.edges = edges, s.symmetry = axis;
  return s;
}
Support held(int edges, std::array<bool, 3> axes) {
  Support s;
  s.edges = edges, s.clamped = false, s.axes = axes;
  return s;
}

// A quarter of the roof: weight 90 per area on a cylinder about y, with a rigid diaphragm at its end.
double scordelis_lo(int elements, int threads, Report& r, int degree = 2) {
  const double angle = 40.0 * pi / 180.0;
  Patch p = cylinder(25.0, 25.0, angle, elements, elements, degree);
  // cylinder() has its axis along z and its middle above x. It is turned so that u = 0 is the crown, above the y axis.
  p = placed(p, Vec3::Zero(), Quat(Eigen::AngleAxisd(0.5 * angle, Vec3::UnitZ())));
  for (Vec3& x : p.control_points) x = Vec3(x.y(), x.z(), x.x());
  // x is along the arc from the crown, y along the axis from the middle, z up.
  const ShellModel m = make_shell("roof", p, 0.25, elastic_material(4.32e8, 0.0), 2, 3,
                                  {symmetry(kUMin, 0), symmetry(kVMin, 1), held(kVMax, {true, false, true})});
  ShellState s = make_state(m, Vec3::Zero(), 0);
  RelaxationRules rules;
  rules.threads = threads;
  rules.gravity = Vec3(0, 0, -90.0 / 0.25 * kSmall);
  const RelaxationResult q = relax(m, s, rules);
  r.lines.push_back(fmt::format("{}scordelis_lo {}: {} + {} steps, residual {:.1e}", degree == 3 ? "cubic_" : "",
                                elements, q.newton, q.steps, q.residual));
  return -displacement(m, s, {m.patch.knots_u.end(), m.patch.knots_v.begin()}).z() / kSmall;
}

// A quarter of the hemisphere without a hole: opposite forces of 2 along x and y at the equator.
double hemisphere(int elements, int threads, Report& r) {
  const Patch p = sphere(10.0, 0.5 * pi, 0.0, 0.5 * pi, elements, elements);
  const Patch scaled = with_parameters_as_lengths(p);
  Load along_x, along_y;
  constexpr double kShare = 1e-2;  // round-off at the pole exceeds the effect of a smaller load
  along_x.point = {scaled.knots_u.begin(), scaled.knots_v.begin()}, along_x.force = Vec3(kShare, 0, 0);
  along_y.point = {scaled.knots_u.end(), scaled.knots_v.begin()}, along_y.force = Vec3(0, -kShare, 0);
  const ShellModel m =
      make_shell("hemisphere", p, 0.04, elastic_material(6.825e7, 0.3), 2, 3,
                 {symmetry(kUMin, 1), symmetry(kUMax, 0), held(kVMax, {true, true, true})}, {along_x, along_y});
  ShellState s = make_state(m, Vec3::Zero(), 0);
  RelaxationRules rules;
  rules.threads = threads, rules.tolerance = 1e-5;
  const RelaxationResult q = relax(m, s, rules);
  r.lines.push_back(
      fmt::format("hemisphere {}: {} + {} steps, residual {:.1e}", elements, q.newton, q.steps, q.residual));
  return displacement(m, s, along_x.point).x() / kShare;
}

// Calls back with the tip displacement of a strip clamped at x = 0, for each share of the load. `prepare` makes the
// full load; in_time scales it.
template <class F>
void cantilever(double length, const Load& load, int elements, int steps, int threads, Report& r,
                const std::string& name, F&& look, int degree = 2) {
  Support clamp;
  clamp.edges = kUMin;
  const ShellModel m = make_shell(name, plate(length, 1.0, elements, 1, Vec3::Zero(), Quat::Identity(), degree), 0.1,
                                  elastic_material(1.2e6, 0.0), 2, 3, {clamp}, {load});
  ShellState s = make_state(m, Vec3::Zero(), 0);
  RelaxationRules rules;
  rules.threads = threads;
  int newton = 0;
  double worst = 0.0;
  std::int64_t relaxation = 0;
  for (int k = 1; k <= steps; ++k) {
    const double start = seconds_now();
    s.motion.time = static_cast<double>(k) / steps;
    const RelaxationResult q = relax(m, s, rules);
    newton += q.newton, relaxation += q.steps, worst = std::max(worst, q.residual);
    look(s.motion.time, displacement(m, s, {m.patch.knots_u.end(), 0.5 * m.patch.knots_v.end()}),
         seconds_now() - start);
  }
  r.lines.push_back(
      fmt::format("{}: {} Newton steps, {} of relaxation, residual at most {:.1e}", name, newton, relaxation, worst));
}

void end_shear(int elements, int degree, const std::string& name, Report& r, int threads) {
  const double u[] = {.103, .381, .763, 1.184, 1.604, 2.002, 2.370, 2.705, 3.010, 3.286};
  const double w[] = {1.309, 2.493, 3.488, 4.292, 4.933, 5.444, 5.855, 6.190, 6.467, 6.698};
  Load shear;
  shear.kind = Load::Kind::kEdgeForce, shear.edges = kUMax, shear.force = Vec3(0, 0, 4.0),
  shear.in_time = {{0, 0}, {1, 1}};
  int i = 0;
  const auto look = [&](double t, const Vec3& d, double seconds) {
    r.add(fmt::format("{}_u_{:.1f}", name, t), -d.x(), u[i], 0.01, seconds);
    r.add(fmt::format("{}_w_{:.1f}", name, t), d.z(), w[i++], 0.01, 0.0);
  };
  cantilever(10.0, shear, elements, 10, threads, r, name, look, degree);
}

void end_shear_case(Report& r, int threads) { end_shear(32, 2, "end_shear", r, threads); }
void cubic_end_shear_case(Report& r, int threads) { end_shear(16, 3, "cubic_end_shear", r, threads); }

void end_moment_case(Report& r, int threads) {
  constexpr double kLength = 12.0;
  Load moment;
  moment.kind = Load::Kind::kEdgeMoment, moment.edges = kUMax, moment.size = 50.0 * pi / 3.0;
  moment.in_time = {{0, 0}, {1, 1}};
  int k = 0;
  cantilever(kLength, moment, 48, 40, threads, r, "end_moment", [&](double t, const Vec3& d, double seconds) {
    if (++k % 10) return;
    const double a = 2.0 * pi * t;
    const double u = kLength * (1.0 - std::sin(a) / a), w = kLength * (1.0 - std::cos(a)) / a;
    // Relative to the length; w = 0 where the strip is a closed circle.
    r.add(fmt::format("end_moment_u_{:.2f}", t), 1.0 - (-d.x() - u) / kLength, 1.0, 0.01, seconds);
    r.add(fmt::format("end_moment_w_{:.2f}", t), 1.0 + (d.z() - w) / kLength, 1.0, 0.01, 0.0);
  });
}

// A narrow beam is bent to ten times the curvature at first yield, elastic-plastic without hardening. Its moment is 1.5
// (1 - 1/300) of the moment at first yield. nu = 1/2, so lateral contraction is the same before and after yielding.
void plastic_moment_case(Report& r, int) {
  constexpr double kYoung = 2e11, kYield = 2e7, kThickness = 0.01, kPoisson = 0.4999, kTimes = 10.0;
  const double first = kYield / (0.5 * kYoung * kThickness), yield_moment = kYield * kThickness * kThickness / 6.0;
  const double exact = 1.5 * (1.0 - 1.0 / (3.0 * kTimes * kTimes));
  Curve c{"plastic_moment", "layers", "relative error", {}, {}, true};
  // Gauss points through the thickness see the edge of the elastic core move in steps.
  for (const auto& [layers, tolerance] :
       {std::pair{5, 0.07}, std::pair{7, 0.04}, std::pair{9, 0.03}, std::pair{11, 0.02}}) {
    const double start = seconds_now();
    const Layers rule = gauss_layers(layers, kThickness);
    std::vector<PlasticState<double>> states(layers, PlasticState<double>{{0, 0, 0}, 0});
    const ReferenceMetric<double> rest{{1, 1, 0}, {0, 0, 0}};
    double moment = 0.0, dissipated = 0.0;
    for (int k = 1; k <= 400; ++k) {
      const double b = kTimes * first * k / 400.0;
      Forms<double> f{};
      f.a = {1, 1, 0}, f.b = {b, -kPoisson * b, 0};
      moment =
          -integrate_yielding_layers<double, false, true>(f, rest, rule, elasticity({kYoung, kPoisson}),
                                                          {kYield, 0.0, kYoung, kPoisson}, states.data(), dissipated)
               .m.c11;
    }
    r.add(fmt::format("plastic_moment_{}", layers), moment / yield_moment, exact, tolerance, seconds_now() - start);
    c.x.push_back(layers), c.y.push_back(std::abs(moment / yield_moment / exact - 1.0));
    if (layers != 11) continue;
    // The work is 13.55 and the energy stored at the end 1.5 (1 - 2/3 / 10), both times moment and curvature at first
    // yield. The tolerance covers 400 steps that end on the yield surface (half a step's plastic strain) and the edge
    // of the core.
    r.add("plastic_dissipation_11", dissipated / (yield_moment * first), 13.55 - 1.4, 0.03, 0.0);
  }
  r.curves.push_back(c);
}

// A sheet is stretched along x at constant width: the effect of Poisson's ratio in each stress model.
void stress_models_case(Report& r, int) {
  constexpr double kStretch = 1e-6, kPoisson = 0.3;
  const Sym2<double> rest{1, 1, 0}, c{1 + 2 * kStretch, 1, 0};
  const ElasticConstants constants{1.0, kPoisson};
  const Elasticity e = elasticity(constants);
  const double start = seconds_now();  // linear up to the strain, 1e-6, times a small factor
  r.add("plane_stress_stiffness", plane_stress<double>(c, rest, e).s.c11 / kStretch, 1.0 / (1.0 - kPoisson * kPoisson),
        1e-5, seconds_now() - start);
  const double right = plane_stress<double>(c, rest, e).s.c11;
  // (1 - nu)^2 / (1 - 2 nu) = 1.225 at 0.3, for models of constant thickness.
  const double excess = (1.0 - kPoisson) * (1.0 - kPoisson) / (1.0 - 2.0 * kPoisson);
  const std::vector<std::string> names = elastic_law_names();
  for (int k = 0; k < kElasticLaws; ++k) {
    const Elasticity law = elasticity(constants, StressModel{k});
    if (law.keeps_thickness())
      r.add(names[k] + "_excess", plane_stress<double>(c, rest, law).s.c11 / right, excess, 1e-5, 0.0);
  }
}

void scordelis_lo_case(Report& r, int threads) {
  const double known[] = {0.2957, 0.30024, 0.30056};
  int i = 0;
  for (const int n : {16, 32, 64}) {
    const double start = seconds_now();
    const double w = scordelis_lo(n / 2, threads, r);  // a quarter
    r.add(fmt::format("scordelis_lo_{}", n), w, known[i++], 0.005, seconds_now() - start);
  }
  Curve c{"scordelis_lo", "elements a side", "error against the limit", {}, {}, true};
  const double limit = scordelis_lo(64, threads, r);
  for (const int n : {4, 8, 16, 32})
    c.x.push_back(2 * n), c.y.push_back(std::abs(scordelis_lo(n, threads, r) / limit - 1.0));
  r.lines.push_back(fmt::format(
      "scordelis_lo: limit {:.6f}; errors {:.1e} {:.1e} {:.1e} {:.1e} at 8 16 32 64; order {:.2f} from 16 to 32", limit,
      c.y[0], c.y[1], c.y[2], c.y[3], std::log2(c.y[1] / c.y[2])));
  r.add("scordelis_lo_limit", limit, 0.3006, 0.0005, 0.0);  // of Kirchhoff-Love theory; four digits are published
  r.curves.push_back(c);
}

void cubic_scordelis_lo_case(Report& r, int threads) {
  // The limit's four digits are known to 1.7e-4. For comparison, 8 quadratic elements miss it by a fifth.
  for (const auto& [n, tolerance] : {std::pair{8, 2e-3}, std::pair{16, 3e-4}, std::pair{32, 3e-4}}) {
    const double start = seconds_now();
    const double w = scordelis_lo(n / 2, threads, r, 3);  // a quarter
    r.add(fmt::format("cubic_scordelis_lo_{}", n), w, 0.3006, tolerance, seconds_now() - start);
  }
}

void hemisphere_case(Report& r, int threads) {
  const double known[] = {0.0741, 0.0909, 0.0923};
  int i = 0;
  for (const int n : {16, 32, 64}) {
    const double start = seconds_now();
    const double w = hemisphere(n, threads, r);
    r.add(fmt::format("hemisphere_{}", n), w, known[i++], 0.01, seconds_now() - start);
    if (n == 64) r.add("hemisphere_limit", w, 0.0924, 0.01, 0.0);  // published for the exact shell
  }
}

}  // namespace

std::vector<Case> static_cases() {
  return {{"scordelis_lo", "roof under its weight", scordelis_lo_case},
          {"cubic_scordelis_lo", "the same with a patch of degree 3", cubic_scordelis_lo_case},
          {"hemisphere", "pinched, without a hole", hemisphere_case},
          {"plastic_moment", "a beam bent far beyond yield, 5 to 11 layers", plastic_moment_case},
          {"stress_models", "stiffness in the plane", stress_models_case},
          {"end_shear", "cantilever of large deflection (Sze, Liu, Lo 2004)", end_shear_case},
          {"cubic_end_shear", "the same with a patch of degree 3, half the elements", cubic_end_shear_case},
          {"end_moment", "cantilever rolled to a circle", end_moment_case}};
}

}  // namespace sunder::validation
