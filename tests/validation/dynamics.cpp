// Shells in motion.
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "shell/geometry/builders.h"
#include "shell/solver/forces.h"
#include "shell/solver/stepping/stable_step.h"
#include "tests/shell/rig.h"
#include "tests/validation/cases.h"

namespace sunder::validation {
namespace {

using namespace sunder::shell;

using std::numbers::pi;

ShellModel square_plate(int elements, const std::vector<Support>& supports, int degree = 2) {
  ShellMaterial m;
  m.density = 2500, m.youngs_modulus = 70e9, m.poisson_ratio = 0.22;
  return make_shell("square", plate(1.0, 1.0, elements, elements, Vec3::Zero(), Quat::Identity(), degree), 0.004, m, 2,
                    degree, supports);
}

// Returns the frequency of the bending mode (p, q), from the times at which its share of the deflection changes sign.
double frequency(int p, int q, int elements, int threads, int degree = 2) {
  Support hinge;
  hinge.edges = kUMin | kUMax | kVMin | kVMax, hinge.clamped = false;
  Rig rig(setup_of({{square_plate(elements, {hinge}, degree)}}), threads);
  const ShellModel& m = rig.model();
  ShellState& s = rig.state();
  const std::size_t stride = m.tables.component_stride;
  std::vector<double> shape(stride, 0.0);
  for (int i = 0; i < m.control_points(); ++i) {
    const Vec2 g = m.parameter[i];
    shape[m.tables.slot(i)] = std::sin(p * pi * g.x()) * std::sin(q * pi * g.y());
  }
  const double dt = 0.5 * stable_step(m, s, 150, threads, false);
  const double rigidity = 70e9 * std::pow(0.004, 3) / 12.0 / (1.0 - 0.22 * 0.22);
  const double omega = (p * p + q * q) * pi * pi * std::sqrt(rigidity / (2500 * 0.004));
  for (std::size_t i = 0; i < stride; ++i)
    if (s.motion.inverse_mass[i] > 0.0) s.motion.v[2 * stride + i] = 1e-6 * omega * shape[i];  // 1 um: a linear motion
  const auto share = [&] {
    double sum = 0.0;
    for (std::size_t i = 0; i < stride; ++i) sum += m.mass[i] * shape[i] * s.motion.x[2 * stride + i];
    return sum;
  };
  double before = 0.0, first = -1.0, last = 0.0;
  int crossings = 0;
  for (std::int64_t k = 1; crossings < 7; ++k) {
    rig.step(dt);
    const double now = share();
    if (before != 0.0 && (before > 0.0) != (now > 0.0)) {
      last = (static_cast<double>(k) - now / (now - before)) * dt;
      if (first < 0.0) first = last;
      ++crossings;
    }
    before = now;
  }
  return pi * (crossings - 1) / (last - first) * std::sqrt(2500 * 0.004 / rigidity);
}

void frequency_case(Report& r, int threads) {
  const int modes[4][2] = {{1, 1}, {1, 2}, {2, 2}, {1, 3}};
  for (const auto& [p, q] : modes) {
    const double start = seconds_now(), exact = (p * p + q * q) * pi * pi;
    r.add(fmt::format("plate_frequency_{}{}", p, q), frequency(p, q, 48, threads), exact, 0.005, seconds_now() - start);
  }
  Curve c{"plate_frequency_11", "elements a side", "relative error", {}, {}, true};
  for (const int n : {4, 8, 16, 32}) {
    c.x.push_back(n), c.y.push_back(std::abs(frequency(1, 1, n, threads) / (2.0 * pi * pi) - 1.0));
  }
  const double order = std::log2(c.y[2] / c.y[3]);
  r.lines.push_back(
      fmt::format("plate_frequency: errors {:.1e} {:.1e} {:.1e} {:.1e} at 4 8 16 32 elements; order {:.2f} "
                  "from 16 to 32",
                  c.y[0], c.y[1], c.y[2], c.y[3], order));
  // quadratic splines with lumped mass: bending converges as h^2
  r.add("plate_frequency_order", order, 2.0, 0.25, 0.0);
  r.curves.push_back(c);
}

// Stiffness of degree 3 converges as h^4, but the mass is lumped. Functions over four spans reduce a wave of control
// points to 1 - (kh)^2 / 6 of its height; over three spans, to 1 - (kh)^2 / 8. The frequency falls by the same factor.
// The order therefore stays 2, and a quadratic patch is even a little more accurate.
void cubic_frequency_case(Report& r, int threads) {
  const int modes[4][2] = {{1, 1}, {1, 2}, {2, 2}, {1, 3}};
  for (const auto& [p, q] : modes) {
    const double start = seconds_now(), exact = (p * p + q * q) * pi * pi;
    r.add(fmt::format("cubic_plate_frequency_{}{}", p, q), frequency(p, q, 16, threads, 3), exact,
          exact / (6 * 16 * 16), seconds_now() - start);
  }
  Curve c{"cubic_plate_frequency_11", "elements a side", "relative error", {}, {}, true};
  for (const int n : {4, 8, 16, 32}) {
    c.x.push_back(n), c.y.push_back(std::abs(frequency(1, 1, n, threads, 3) / (2.0 * pi * pi) - 1.0));
  }
  const double order = std::log2(c.y[2] / c.y[3]);
  r.lines.push_back(
      fmt::format("cubic_plate_frequency: errors {:.1e} {:.1e} {:.1e} {:.1e} at 4 8 16 32 elements; order {:.2f} "
                  "from 16 to 32",
                  c.y[0], c.y[1], c.y[2], c.y[3], order));
  r.add("cubic_plate_frequency_order", order, 2.0, 0.25, 0.0);
  r.curves.push_back(c);
}

void vibration_case(Report& r, int threads) {
  const double start = seconds_now();
  Rig rig(setup_of({{square_plate(6, {}), Vec3(1.0, -2.0, 0.5)}}), threads);
  const ShellModel& m = rig.model();
  ShellState& s = rig.state();
  const std::size_t stride = m.tables.component_stride;
  for (int i = 0; i < m.control_points(); ++i) {
    const int slot = m.tables.slot(i);
    const Vec3 x = s.position(slot);
    const Vec3 spin = Vec3(0.3, 0.2, 2.0).cross(x);
    s.add_velocity(slot, spin + Vec3(0, 0, 0.2 * std::cos(2.0 * pi * x.x()) * std::cos(pi * x.y())));
  }
  const double dt = 0.8 * stable_step(m, s, 200, threads, false);
  const auto energy = [&] {
    const double elastic = compute_forces(m, s, true, 0.0, threads);
    return elastic + kinetic_energy(m, s, dt);
  };
  const auto momenta = [&](Vec3& p, Vec3& l, double& scale_p, double& scale_l) {
    p = l = Vec3::Zero(), scale_p = scale_l = 0.0;
    for (std::size_t i = 0; i < stride; ++i) {
      const Vec3 q = s.motion.mass[i] * s.velocity(static_cast<int>(i)), c = s.position(static_cast<int>(i)).cross(q);
      p += q, l += c, scale_p += q.norm(), scale_l += c.norm();
    }
  };
  constexpr int kSteps = 1'000'000, kMean = 20000;
  double first = 0.0, last = 0.0;
  Vec3 p0 = Vec3::Zero(), l0 = p0, p1 = p0, l1 = p0;
  double scale_p = 0.0, scale_l = 0.0;
  for (int k = 0; k < kSteps; ++k) {
    if (k < kMean || k >= kSteps - kMean) (k < kMean ? first : last) += energy() / kMean;
    rig.step(dt);
    if (k == 0) momenta(p0, l0, scale_p, scale_l);
  }
  momenta(p1, l1, scale_p, scale_l);
  r.add("free_vibration_energy_drift", last / first - 1.0, 0.0, 1e-4, seconds_now() - start);
  // Round-off of a million terms, 1e-16 each, adds up at random to some 1e-13.
  r.add("free_vibration_momentum", (p1 - p0).norm() / scale_p, 0.0, 1e-12, 0.0);
  r.add("free_vibration_angular_momentum", (l1 - l0).norm() / scale_l, 0.0, 1e-11, 0.0);
}

}  // namespace

std::vector<Case> dynamic_cases() {
  return {{"plate_frequency", "simply supported square, four modes, order of convergence", frequency_case},
          {"cubic_plate_frequency", "the same with a patch of degree 3, 16 elements", cubic_frequency_case},
          {"free_vibration", "a free plate for a million substeps", vibration_case}};
}

}  // namespace sunder::validation
