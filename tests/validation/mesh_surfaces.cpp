// Surfaces of triangles as tied patches, against exact frequencies and the same surface in one patch.
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>

#include <fmt/format.h>

#include "shell/io/cad_loop.h"
#include "shell/meshes/mesh_patches.h"
#include "shell/meshes/surface_fit.h"
#include "tests/shell/triangles.h"
#include "tests/validation/tied.h"
#include "tests/validation/tied_system.h"

namespace sunder::validation {
namespace {

using namespace sunder::shell;

using std::numbers::pi;
constexpr double kCrease = 40.0 * pi / 180.0;
constexpr double kMetalYoung = 2e11, kMetalPoisson = 0.3, kMetalDensity = 7800.0;
constexpr int kFree = 6;  // rigid motions

ShellMaterial metal() {
  ShellMaterial m;
  m.density = kMetalDensity, m.youngs_modulus = kMetalYoung, m.poisson_ratio = kMetalPoisson;
  return m;
}

Pieces pieces_of(const TriangleMesh& mesh, const MeshPatchRules& rules, double thickness) {
  const MeshPatches charts = patches_of(mesh, rules);
  Pieces out;
  for (const MeshPatch& p : charts.patches) {
    const Patch lengths = with_parameters_as_lengths(p.patch);
    const Vec2 low(lengths.knots_u.begin(), lengths.knots_v.begin()),
        high(lengths.knots_u.end(), lengths.knots_v.end());
    const double spacing = std::sqrt((high - low).prod() / (lengths.knots_u.spans() * lengths.knots_v.spans()));
    std::vector<TrimLoop> loops;
    for (const PatchLoop& loop : p.loops) {
      CadLoop own{{}, loop.hole};
      for (const PlaneCurve& curve : loop.curves) own.borders.push_back({curve, 0});
      loops.push_back(cad_loop(own, lengths, spacing));
    }
    const TrimLoops trims = loops.empty() ? TrimLoops() : TrimLoops(low, high, std::move(loops));
    out.patches.push_back(lengths);
    out.models.push_back(make_shell(fmt::format("part.{}", out.models.size() + 1), p.patch, thickness, metal(), 2,
                                    p.patch.degree(), {}, {}, trims));
  }
  std::vector<KnownBorder> borders;
  for (const MeshSeam& s : charts.seams)
    borders.push_back({s.first, s.second, s.on_first, s.on_second, s.closed, !s.crease});
  const std::size_t n = out.models.size();
  out.stitches.seams =
      known_seams(out.bordered(), borders, std::vector<std::vector<Join>>(n, std::vector<Join>(n, Join::kClamped)));
  return out;
}

double mass_of(const Pieces& p) {
  double sum = 0.0;
  for (const ShellModel& m : p.models)
    for (const double part : m.mass) sum += part;
  return sum;
}

// Counts charts, and seams that are not smooth.
void add_charts(Report& r, const std::string& name, const Pieces& p, int charts) {
  int rough = 0;
  double angle = 0.0;
  for (const Seam& s : p.stitches.seams) rough += !s.smooth, angle = std::max(angle, s.angle);
  r.add(name + "_charts", static_cast<double>(p.models.size()), charts, 0.0, 0.0);
  r.add(name + "_rough_seams", rough, 0.0, 0.0, 0.0);
  r.lines.push_back(fmt::format("{}: {} seams, largest angle {:.2g}", name, p.stitches.seams.size(), angle));
}

void add_exact(Report& r, const std::string& name, TiedSystem& system, double held, const std::vector<double>& wanted) {
  const std::vector<double> found = system.frequencies(held, kFree);
  for (int k = 0; k < kTiedModes; ++k)
    r.add(fmt::format("{}_frequency_{}", name, k + 1), found[k], wanted[k], 0.02, 0.0);
}

// The shell on which a place of the plate lies, and its parameters there.
std::pair<int, Vec2> place_on(const Pieces& p, const Vec3& x) {
  std::pair<int, Vec2> best{0, Vec2::Zero()};
  double least = 1e300;
  for (std::size_t k = 0; k < p.models.size(); ++k) {
    const Patch& patch = p.patches[k];
    const Vec2 at = nearest_place(patch, x, 0.5 * Vec2(patch.knots_u.end(), patch.knots_v.end()));
    const TrimLoops& trims = p.models[k].trim.loops;
    const double away = (patch.evaluate(at).x - x).norm();
    const double inside = trims.empty() ? 0.0 : (trims.moved_inside(at, 0.0) - at).norm();
    if (away + inside < least) least = away + inside, best = {static_cast<int>(k), at};
  }
  return best;
}

// Deflection of the middle against the corners, which bear a force on it.
double held_deflection(TiedSystem& system, const Pieces& p, double held) {
  const std::vector<std::pair<Vec3, double>> forces{{{0.5, 0.5, 0.0}, 1.0},
                                                    {{0.0, 0.0, 0.0}, -0.25},
                                                    {{1.0, 0.0, 0.0}, -0.25},
                                                    {{0.0, 1.0, 0.0}, -0.25},
                                                    {{1.0, 1.0, 0.0}, -0.25}};
  Eigen::VectorXd load = Eigen::VectorXd::Zero(system.count());
  for (const auto& [x, force] : forces) {
    const auto [k, at] = place_on(p, x);
    for (const GatheredFunction& f : shell_functions(p.models[k], at))
      if (const int n = system.degree(k, f.slot, 2); n >= 0) load[n] += force * f.n[0];
  }
  const Eigen::VectorXd u = system.solve(load, held);
  double sum = 0.0;
  for (const auto& [x, force] : forces) {
    const auto [k, at] = place_on(p, x);
    sum += force * system.value(u, k, at, 2);
  }
  return sum;
}

// A square plate: one chart, and several whose borders are ragged.
void mesh_plate(Report& r, int threads, int divided) {
  constexpr double kThickness = 0.004, kHeld = 1e-4;
  constexpr int kElements = 24;
  const std::string name = fmt::format("mesh_plate_{}", divided * divided);
  const TriangleMesh mesh = lattice(31, 31, false, [](double u, double v) { return Vec3(u, v, 0.0); }).mesh();
  MeshPatchRules rules{1.0 / kElements, kCrease, 2, {}};
  const Pieces alike = pieces_of(mesh, rules, kThickness);
  for (std::size_t t = 0; t < mesh.triangles.size() && divided > 1; ++t) {
    const Vec3 x = mesh.middle(static_cast<int>(t));
    const double u = x.x() + 0.06 * std::sin(2.0 * pi * x.y()), v = x.y() + 0.06 * std::sin(2.0 * pi * x.x());
    rules.parts.push_back((u > 0.52 ? 1 : 0) + (v > 0.47 ? 2 : 0));
  }
  const double start = seconds_now();
  const Pieces tied = pieces_of(mesh, rules, kThickness);
  rules.parts.clear(), rules.element *= 0.5;
  const Pieces one = pieces_of(mesh, rules, kThickness);
  const double bending = kMetalYoung * std::pow(kThickness, 3) / (12.0 * (1.0 - kMetalPoisson * kMetalPoisson));
  const double slow = 100.0 * bending / (kMetalDensity * kThickness);
  add_charts(r, name, tied, divided * divided);
  r.add(name + "_mass", mass_of(tied), kMetalDensity * kThickness, 1e-6, 0.0);
  TiedSystem system(tied), whole(one);
  r.add(name + "_deflection", held_deflection(system, tied, kHeld * slow), held_deflection(whole, one, kHeld * slow),
        0.005, seconds_now() - start);
  add_frequencies(r, name, system, whole, 0.1 * slow, kFree);
  const double step = step_of(tied, threads) / step_of(alike, threads);
  r.add_step(name + "_step", step, 0.0, " of one chart's");
}

// Order of the differences between three spacings, each finer than the one before by the root of two, of the mean of
// the lowest frequencies. No reference takes part: those of thin shells neglect stretch or bending, which is more than
// the errors. Twice the coarsest spacing would be too coarse for a sphere: short waves of a lumped mass are then as
// slow as long ones.
void add_order(Report& r, const std::string& name, double held, const std::function<Pieces(double element)>& surface) {
  constexpr double kMiddle = 0.02;  // [m]
  std::array<double, 3> mean{};
  for (std::size_t k = 0; k < mean.size(); ++k) {
    const Pieces tied = surface(kMiddle * std::pow(0.5, 0.5 * (static_cast<double>(k) - 1.0)));
    TiedSystem system(tied);
    for (const double f : system.frequencies(held, kFree)) mean[k] += f / kTiedModes;
  }
  const double order = 2.0 * std::log2(std::abs((mean[0] - mean[1]) / (mean[1] - mean[2])));
  r.add(name + "_order_below_1.75", above_zero(1.75 - order), 0.0, 0.0, 0.0,
        fmt::format("order {:.2f}: mean of {} frequencies {:.7g}, {:.7g}, {:.7g} Hz", order, kTiedModes, mean[0],
                    mean[1], mean[2]));
}

// A tube with free ends: modes without stretch, the same all along or growing from the middle (Rayleigh; Love 1888).
void mesh_tube(Report& r, int) {
  constexpr double kRadius = 0.2, kLength = 0.5, kThickness = 0.001;
  const TriangleMesh mesh =
      lattice(60, 24, true, [&](double u, double v) {
        return Vec3(kRadius * std::cos(2.0 * pi * u), kRadius * std::sin(2.0 * pi * u), kLength * v);
      }).mesh();
  const auto tube = [&](double element) { return pieces_of(mesh, {element, kCrease, 2, {}}, kThickness); };
  const Pieces tied = tube(0.02);
  add_charts(r, "mesh_tube", tied, 2);
  r.add("mesh_tube_mass", mass_of(tied), kMetalDensity * kThickness * 2.0 * pi * kRadius * kLength, 1e-3, 0.0);
  const double bending = kMetalYoung * std::pow(kThickness, 3) / (12.0 * (1.0 - kMetalPoisson * kMetalPoisson));
  const auto ring = [&](double n) {
    return std::sqrt(bending / (kMetalDensity * kThickness)) / (kRadius * kRadius) * n * (n * n - 1.0) /
           std::sqrt(n * n + 1.0) / (2.0 * pi);
  };
  const auto twisted = [&](double n) {
    const double l = std::pow(kRadius / kLength, 2);
    return ring(n) *
           std::sqrt((1.0 + 24.0 * (1.0 - kMetalPoisson) * l / (n * n)) / (1.0 + 12.0 * l / (n * n * (n * n + 1.0))));
  };
  const double held = 0.1 * std::pow(2.0 * pi * ring(2.0), 2);
  TiedSystem system(tied);
  add_exact(r, "mesh_tube", system, held, {ring(2.0), ring(2.0), twisted(2.0), twisted(2.0)});
  add_order(r, "mesh_tube", held, tube);
}

constexpr double kBall = 0.2, kBallThickness = 0.004;  // [m]

// The lowest frequency of a sphere: five equal modes of two waves (Lamb 1882), which stretch; bending adds about a
// thousandth.
double lamb() {
  constexpr double kTwice = 6.0;  // n (n + 1)
  const double b = kTwice + 1.0 + 3.0 * kMetalPoisson, c = (kTwice - 2.0) * (1.0 - kMetalPoisson * kMetalPoisson);
  const double square = 0.5 * (b - std::sqrt(b * b - 4.0 * c));
  return std::sqrt(square * kMetalYoung / (kMetalDensity * (1.0 - kMetalPoisson * kMetalPoisson))) / (2.0 * pi * kBall);
}

void add_ball(Report& r, const std::string& name, const TriangleMesh& mesh) {
  const auto sphere = [&](double element) { return pieces_of(mesh, {element, kCrease, 2, {}}, kBallThickness); };
  const Pieces tied = sphere(0.02);
  add_charts(r, name, tied, 2);
  r.add(name + "_mass", mass_of(tied), kMetalDensity * kBallThickness * 4.0 * pi * kBall * kBall, 1e-3, 0.0);
  const double held = 0.1 * std::pow(2.0 * pi * lamb(), 2);
  TiedSystem system(tied);
  add_exact(r, name, system, held, std::vector<double>(kTiedModes, lamb()));
  add_order(r, name, held, sphere);
}

void mesh_sphere(Report& r, int) { add_ball(r, "mesh_sphere", ball(kBall, 12).mesh()); }

// A cube's faces of `parts` squared quads each, moved to a sphere along its radii; a quad is two triangles, as a file's
// are.
Triangles cube_ball(double radius, int parts) {
  Triangles out;
  std::map<std::array<int, 3>, int> known;
  for (int axis = 0; axis < 3; ++axis)
    for (const int side : {-1, 1}) {
      const auto at = [&](int i, int j) {
        std::array<int, 3> place{};
        place[axis] = side * parts, place[(axis + 1) % 3] = 2 * i - parts, place[(axis + 2) % 3] = 2 * j - parts;
        const auto [it, fresh] = known.try_emplace(place, static_cast<int>(out.points.size()));
        if (fresh) {
          Vec3 x;  // equal angles along the edges
          for (int d = 0; d < 3; ++d) x[d] = std::tan(0.25 * pi * place[d] / parts);
          out.points.push_back(radius * x.normalized());
        }
        return it->second;
      };
      for (int j = 0; j < parts; ++j)
        for (int i = 0; i < parts; ++i) {
          const int a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
          side > 0 ? (out.add(a, b, c), out.add(a, c, d)) : (out.add(a, c, b), out.add(a, d, c));
        }
    }
  return out;
}

void mesh_quads(Report& r, int) { add_ball(r, "mesh_quads", cube_ball(kBall, 16).mesh()); }

}  // namespace

std::vector<Case> mesh_cases() {
  return {{"mesh_plate", "a plate of triangles as one chart, and as four",
           [](Report& r, int threads) { mesh_plate(r, threads, 1), mesh_plate(r, threads, 2); }},
          {"mesh_tube", "a tube of triangles with free ends", mesh_tube},
          {"mesh_sphere", "a sphere of triangles", mesh_sphere},
          {"mesh_quads", "a sphere of the quads of a cube", mesh_quads}};
}

}  // namespace sunder::validation
