// Trimmed surfaces: plates that loops cut from larger patches, against exact plates and whole patches.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include <fmt/format.h>
#include <Eigen/SparseCholesky>

#include "coupler/core/error.h"
#include "shell/solver/cracking/polyline.h"
#include "shell/solver/forces.h"
#include "shell/solver/parting/handoff.h"
#include "shell/solver/statics/modes.h"
#include "shell/solver/statics/tangent.h"
#include "shell/solver/stepping/stable_step.h"
#include "tests/shell/rig.h"
#include "tests/validation/cases.h"
#include "tests/validation/discs.h"
#include "tests/validation/tied.h"

namespace sunder::validation {
namespace {

using namespace sunder::shell;

using std::numbers::pi;
constexpr double kPlateYoung = 2e11, kPlatePoisson = 0.3, kPlateThickness = 0.004, kPlateDensity = 7800.0;
constexpr double kStiffness =
    kPlateYoung * kPlateThickness * kPlateThickness * kPlateThickness / (12.0 * (1.0 - kPlatePoisson * kPlatePoisson));
constexpr double kPlateSize = 1.0;  // side of a square plate, diameter of a disc [m]
constexpr double kPatch = 1.625;    // side of the patch that loops cut [m]
constexpr int kPlateElements = 24;  // of the plate's side
constexpr int kRingElements = 32;   // of the ring's diameter: thirteen across its hole, about which moments concentrate
constexpr int kPlateModes = 4;
constexpr int kCorners = 64;  // of a disc; its edges are about as long as cuts have them

ShellMaterial plate_steel() {
  ShellMaterial m;
  m.density = kPlateDensity, m.youngs_modulus = kPlateYoung, m.poisson_ratio = kPlatePoisson;
  return m;
}

using Ring = std::vector<Vec2>;

Ring closed(Ring ring) {
  ring.push_back(ring.front());
  return ring;
}

Ring square_ring(const Vec2& centre, double size, double angle) {
  Ring out;
  for (int k = 0; k < 4; ++k) {
    const double at = angle + pi * (0.25 + 0.5 * k);
    out.push_back(centre + size / std::numbers::sqrt2 * Vec2(std::cos(at), std::sin(at)));
  }
  return out;
}

// A polygon with the area of the circle.
Ring circle(const Vec2& centre, double radius, int corners, double angle) {
  const double grown = radius * std::sqrt(2.0 * pi / corners / std::sin(2.0 * pi / corners));
  Ring out;
  for (int k = 0; k < corners; ++k) {
    const double at = angle + 2.0 * pi * k / corners;
    out.push_back(centre + grown * Vec2(std::cos(at), std::sin(at)));
  }
  return out;
}

// A square patch from 0 to `side` along both axes, cut by loops.
ShellModel trimmed(double side, int elements, const std::vector<TrimLoop>& loops, const std::vector<Load>& loads = {},
                   int degree = 2) {
  const Patch patch =
      plate(side, side, elements, elements, Vec3(0.5 * side, 0.5 * side, 0.0), Quat::Identity(), degree);
  return make_shell("plate", patch, kPlateThickness, plate_steel(), 2, degree, {}, loads,
                    loops.empty() ? TrimLoops() : TrimLoops(Vec2::Zero(), Vec2::Constant(side), loops));
}

Load plate_load(const Vec2& at, double force) {
  Load l;
  l.point = at, l.force = Vec3(0.0, 0.0, force);
  return l;
}

Load pressure(double size) {
  Load l;
  l.kind = Load::Kind::kPressure, l.size = size;
  return l;
}

std::vector<double> frequencies(const ShellModel& m) {
  ShellState s = make_state(m, Vec3::Zero(), 0);
  std::vector<double> out;
  for (const Mode& mode : vibration_modes(m, s, kPlateModes, [&] { compute_forces(m, s, false, 0.0, 1); }).modes)
    out.push_back(mode.frequency);
  return out;
}

// Small displacements under loads in balance. A little stiffness in proportion to the mass holds rigid motions.
std::vector<double> deflections(const ShellModel& m) {
  ShellState s = make_state(m, Vec3::Zero(), 0);
  const auto forces = [&] { compute_forces(m, s, false, 0.0, 1); };
  const FreeDegrees free = free_degrees(m, s);
  Eigen::SparseMatrix<double> k = tangent_stiffness(m, s, free, Differences::kFourthOrder, forces);
  k = (0.5 * (k + Eigen::SparseMatrix<double>(k.transpose()))).eval();
  constexpr double kHeld = 1e-4;  // of the lowest eigenvalue
  const double slowest =
      kHeld * std::pow(10.0 / (kPlateSize * kPlateSize), 2) * kStiffness / (kPlateDensity * kPlateThickness);
  Eigen::VectorXd load = Eigen::VectorXd::Zero(free.count);
  for (std::size_t i = 0; i < free.number.size(); ++i)
    if (const int n = free.number[i]; n >= 0)
      k.coeffRef(n, n) += slowest * s.motion.mass[i % m.tables.component_stride], load[n] = s.motion.external[i];
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factors(k);
  require(factors.info() == Eigen::Success, "the stiffness of a trimmed plate cannot be factorised");
  const Eigen::VectorXd u = factors.solve(load);
  std::vector<double> out(free.number.size(), 0.0);
  for (std::size_t i = 0; i < out.size(); ++i)
    if (free.number[i] >= 0) out[i] = u[free.number[i]];
  return out;
}

double height(const ShellModel& m, const std::vector<double>& u, const Vec2& at) {
  double w = 0.0;
  for (const GatheredFunction& f : shell_functions(m, at))
    w += f.n[0] * u[2 * static_cast<std::size_t>(m.tables.component_stride) + f.slot];
  return w;
}

double mean_height(const ShellModel& m, const std::vector<double>& u, const Ring& at) {
  double sum = 0.0;
  for (const Vec2& p : at) sum += height(m, u, p) / static_cast<double>(at.size());
  return sum;
}

int patch_elements(int of_plate) { return static_cast<int>(std::round(kPatch / kPlateSize * of_plate)); }

// Deflection of the centre below the corners under a force on it that the corners bear, and of pure twist by forces of
// changing sign on the corners.
struct Plate {
  double bent = 0.0, twisted = 0.0;
  std::vector<double> frequencies;
};

Plate plate_results(const std::function<ShellModel(const std::vector<Load>&)>& make, const Vec2& centre,
                    const Ring& corners) {
  Plate out;
  std::vector<Load> bend{plate_load(centre, 1.0)}, twist;
  for (std::size_t k = 0; k < 4; ++k) {
    bend.push_back(plate_load(corners[k], -0.25));
    twist.push_back(plate_load(corners[k], k % 2 ? -1.0 : 1.0));
  }
  const ShellModel bent = make(bend), twisted = make(twist);
  const std::vector<double> u = deflections(bent), v = deflections(twisted);
  out.bent = height(bent, u, centre) - mean_height(bent, u, corners);
  for (std::size_t k = 0; k < 4; ++k) out.twisted += 0.25 * (k % 2 ? -1.0 : 1.0) * height(twisted, v, corners[k]);
  out.frequencies = frequencies(bent);
  return out;
}

Plate turned_plate(double degrees, int elements, const Vec2& shift, int degree = 2) {
  const Vec2 centre = Vec2::Constant(0.5 * kPatch) + shift;
  const Ring corners = square_ring(centre, kPlateSize, degrees * pi / 180.0);
  return plate_results(
      [&](const std::vector<Load>& loads) {
        return trimmed(kPatch, patch_elements(elements), {{closed(corners), false}}, loads, degree);
      },
      centre, corners);
}

Plate uncut_plate(int elements, int degree = 2) {
  const Vec2 centre = Vec2::Constant(0.5 * kPlateSize);
  return plate_results([&](const std::vector<Load>& loads) { return trimmed(kPlateSize, elements, {}, loads, degree); },
                       centre, square_ring(centre, kPlateSize, 0.0));
}

const Vec2 kShift(0.013, -0.0071);  // off the lattice

void turned(Report& r, int, int degree) {
  const std::string name = degree == 2 ? "turned" : "cubic_turned";
  // w = F x y / (2 (1 - nu) D) under corner forces F: moments are constant (Timoshenko and Woinowsky-Krieger, 11)
  const double twist = 0.25 * kPlateSize * kPlateSize / (2.0 * (1.0 - kPlatePoisson) * kStiffness);
  const Plate whole = uncut_plate(2 * kPlateElements, degree);
  for (const double degrees : {0.0, 15.0, 30.0, 45.0}) {
    double start = seconds_now();
    const Plate p = turned_plate(degrees, kPlateElements, kShift, degree);
    r.add(fmt::format("{}_{:.0f}_deflection", name, degrees), p.bent, whole.bent, 0.005, seconds_now() - start);
    r.add(fmt::format("{}_{:.0f}_twist", name, degrees), p.twisted, twist, 1e-3, 0.0);
    for (int k = 0; k < kPlateModes; ++k)
      r.add(fmt::format("{}_{:.0f}_frequency_{}", name, degrees, k + 1), p.frequencies[k], whole.frequencies[k], 0.01,
            0.0);
  }
}

void order(Report& r, int) {
  const Plate exact = uncut_plate(64);
  Curve curve{"order", "elements", "error of the first frequency", {}, {}};
  for (const int n : {8, 16, 32}) {
    const Plate p = turned_plate(15.0, n, kShift);
    curve.x.push_back(n), curve.y.push_back(std::abs(p.frequencies[0] / exact.frequencies[0] - 1.0));
  }
  r.add("order_of_frequency", std::log2(curve.y[0] / curve.y[2]) / 2.0, 2.0, 0.25, 0.0);
  r.curves.push_back(curve);
}

// A disc on the ring of its corners, under pressure that those bear.
void disc(Report& r, const std::string& name, double inner, int elements) {
  const double outer = 0.5 * kPlateSize;
  const Disc exact{outer, inner, kPlatePoisson};
  const Vec2 centre = Vec2::Constant(0.5 * kPatch) + kShift;
  const int corners = 4 * elements;  // about as many as cuts have, for a chord within a hundredth of an element
  const Ring border = circle(centre, outer, corners, 0.1);
  std::vector<TrimLoop> loops{{closed(border), false}};
  const int around = static_cast<int>(std::round(1.5 * corners * inner / outer));
  if (inner > 0.0) loops.push_back({closed(circle(centre, inner, around, 0.2)), true});
  std::vector<Load> loads{pressure(1.0)};
  const double all = pi * (outer * outer - inner * inner);
  for (const Vec2& p : border) loads.push_back(plate_load(p, -all / corners));
  const double start = seconds_now();
  const ShellModel m = trimmed(kPatch, patch_elements(elements), loops, loads);
  double mass = 0.0;
  for (const double part : m.mass) mass += part;
  r.add(name + "_mass", mass, kPlateDensity * kPlateThickness * all, 1e-9, 0.0);
  const std::vector<double> u = deflections(m);
  const Ring inside = inner > 0.0 ? circle(centre, 1.05 * inner, 16, 0.0) : Ring{centre};
  r.add(name + "_deflection", mean_height(m, u, inside) - mean_height(m, u, border),
        disc_deflection(exact, (inside.front() - centre).norm()) / kStiffness, 0.005, seconds_now() - start);
  const std::vector<double> found = frequencies(m), wanted = free_disc_modes(exact, kPlateModes);
  for (int k = 0; k < kPlateModes; ++k)
    r.add(fmt::format("{}_frequency_{}", name, k + 1), found[k],
          wanted[k] * std::sqrt(kStiffness / (kPlateDensity * kPlateThickness)) / (2.0 * pi), 0.01, 0.0);
}

// Largest difference of the metric of any Gauss point from that at rest [-].
double largest_strain(const ShellModel& m, const ShellState& s) {
  double most = 0.0;
  for (const GatheredPoint& g : s.cracked.gathered) {
    if (g.kind == PointKind::kDead) continue;
    const Forms<double> f = surface_forms(gather(m.tables, g, s.motion.x));
    most = std::max({most, std::abs(f.a.c11 - g.metric.a.c11), std::abs(f.a.c22 - g.metric.a.c22),
                     std::abs(f.a.c12 - g.metric.a.c12)});
  }
  return most;
}

// Turns a shell about an axis, and moves it.
void turn(const ShellModel& m, ShellState& s, const Vec3& axis) {
  const Mat3 turned = rotation_from_vector(axis).toRotationMatrix();
  for (int i = 0; i < m.control_points(); ++i) {
    const int slot = m.tables.slot(i);
    const Vec3 x = turned * s.position(slot) + Vec3(0.3, -0.2, 0.1);
    for (int d = 0; d < 3; ++d) s.motion.x[static_cast<std::size_t>(d) * m.tables.component_stride + slot] = x[d];
  }
}

// Loops at random places: their stable step over that of the whole patch, before and after a cut from border to border.
// The largest strain after a rigid turn is measured as well.
void random_steps(Report& r, int threads) {
  constexpr int kPlaces = 200, kCoarse = 12;
  std::mt19937_64 random(7);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * (static_cast<double>(random() >> 11) * 0x1.0p-53);
  };
  const auto step_of = [&](const ShellModel& m, ShellState& s) {
    return stable_step(m, s, kStepIterations, threads, true);
  };
  for (const int degree : {2, 3}) {
    const double start = seconds_now();
    const ShellModel patch = trimmed(kPatch, patch_elements(kCoarse), {}, {}, degree);
    ShellState uncut = make_state(patch, Vec3::Zero(), 0);
    const double whole = step_of(patch, uncut);
    double least = 1e300, least_cut = 1e300, sum = 0.0, sum_cut = 0.0, strain = 0.0, cut_strain = 0.0;
    for (int k = 0; k < kPlaces; ++k) {
      const Vec2 centre = Vec2::Constant(0.5 * kPatch) + Vec2(uniform(-0.1, 0.1), uniform(-0.1, 0.1));
      const double angle = uniform(0.0, 0.5 * pi), along = uniform(0.0, pi), off = uniform(-0.3, 0.3);
      std::vector<TrimLoop> loops{
          {closed(k % 2 ? circle(centre, 0.5 * kPlateSize, 48, angle) : square_ring(centre, kPlateSize, angle)),
           false}};
      if (k % 4 > 1) loops.push_back({closed(circle(centre, uniform(0.1, 0.3), 16, angle)), true});
      const ShellModel m = trimmed(kPatch, patch_elements(kCoarse), loops, {}, degree);
      ShellState s = make_state(m, Vec3::Zero(), 0);
      const double ratio = step_of(m, s) / whole;
      least = std::min(least, ratio), sum += ratio;
      ShellState turned = make_state(m, Vec3::Zero(), 0);
      turn(m, turned, Vec3(0.3, -0.8, 0.5));
      strain = std::max(strain, largest_strain(m, turned));
      const Vec2 way(std::cos(along), std::sin(along)), middle = centre + off * Vec2(-way.y(), way.x());
      insert_polyline(m, s, {middle - 0.7 * kPlateSize * way, middle + 0.7 * kPlateSize * way}, 0.0);
      const double ratio_cut = step_of(m, s) / whole;
      least_cut = std::min(least_cut, ratio_cut), sum_cut += ratio_cut;
      turn(m, s, Vec3(0.3, -0.8, 0.5));
      cut_strain = std::max(cut_strain, largest_strain(m, s));
    }
    const std::string name = degree == 2 ? "random_" : "cubic_random_";
    const auto least_of = [&](double total) {
      return fmt::format(" of the whole patch's, the least of {} places; mean {:.3f}", kPlaces, total / kPlaces);
    };
    r.add_step(name + "step", least, seconds_now() - start, least_of(sum));
    r.add_step(name + "cut_step", least_cut, 0.0, least_of(sum_cut));
    r.add(name + "rigid_strain", strain, 0.0, 1e-12, 0.0);
    r.add(name + "cut_rigid_strain", cut_strain, 0.0, 1e-11, 0.0);
  }
}

// A disc with a hole that spins, drifts and vibrates.
void flight(Report& r, int threads) {
  const Vec2 centre = Vec2::Constant(0.5 * kPatch) + kShift;
  Rig rig(setup_of({{trimmed(kPatch, patch_elements(kPlateElements),
                             {{closed(circle(centre, 0.5 * kPlateSize, kCorners, 0.1)), false},
                              {closed(circle(centre, 0.2, 24, 0.2)), true}}),
                     Vec3(1.0, -2.0, 0.5)}}),
          threads);
  const ShellModel& m = rig.model();
  ShellState& s = rig.state();
  const Vec3 middle(centre.x(), centre.y(), 0.0);
  for (int i = 0; i < m.control_points(); ++i) {
    const int slot = m.tables.slot(i);
    if (m.trim.drops(slot)) continue;
    const Vec3 d = s.position(slot) - middle;
    s.add_velocity(slot, Vec3(3.0, 5.0, -4.0).cross(d) + Vec3(0.0, 0.0, 20.0 * d.x() * d.y()));
  }
  const double dt = 0.7 * stable_step(m, s, kStepIterations, threads, true), start = seconds_now();
  const Totals before = totals(m, s);
  double elastic = compute_forces(m, s, true, 0.0, threads);
  const double first = elastic + kinetic_energy(m, s, dt);
  for (int k = 0; k < 20000; ++k) rig.step(dt);
  elastic = compute_forces(m, s, true, 0.0, threads);
  const double last = elastic + kinetic_energy(m, s, dt);
  // at the time of the positions
  for (int i = 0; i < m.control_points(); ++i)
    s.add_velocity(m.tables.slot(i),
                   0.5 * dt * s.motion.inverse_mass[m.tables.slot(i)] * s.at(s.motion.force, m.tables.slot(i)));
  const Totals after = totals(m, s);
  r.add("flight_momentum", (after.momentum - before.momentum).norm() / before.momentum_scale, 0.0, 1e-12,
        seconds_now() - start);
  r.add("flight_angular_momentum", (after.angular - before.angular).norm() / before.angular_scale, 0.0, 1e-11, 0.0);
  r.add("flight_energy", last, first, 1e-4, 0.0);
}

}  // namespace

std::vector<Case> surface_cases() {
  std::vector<Case> out{
      {"turned", "square plates cut from a larger patch at 0, 15, 30, 45 degrees",
       [](Report& r, int threads) { turned(r, threads, 2); }},
      {"cubic_turned", "the same, degree 3", [](Report& r, int threads) { turned(r, threads, 3); }},
      {"order", "order of convergence of a turned plate", order},
      {"disc", "a disc under pressure, and its free vibration",
       [](Report& r, int) { disc(r, "disc", 0.0, kPlateElements); }},
      {"ring", "the same with a hole", [](Report& r, int) { disc(r, "ring", 0.2, kRingElements); }},
      {"random", "stable step of 200 loops at random places, with a cut too, and strain in rigid motion", random_steps},
      {"flight", "momenta and energy of a ring in flight", flight}};
  for (Case& c : tied_cases()) out.push_back(std::move(c));
  for (Case& c : mesh_cases()) out.push_back(std::move(c));
  for (Case& c : taper_cases()) out.push_back(std::move(c));
  return out;
}

}  // namespace sunder::validation
