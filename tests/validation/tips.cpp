// The driving force of a crack against fracture mechanics: a short crack in a wide sheet, at any angle to the grid.
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "shell/geometry/builders.h"
#include "shell/mechanics/principal.h"
#include "shell/solver/cracking/energy_release.h"
#include "shell/solver/cracking/insertion.h"
#include "shell/solver/cracking/polyline.h"
#include "shell/solver/cracking/tip_drive.h"
#include "shell/solver/cracking/tips.h"
#include "shell/solver/forces.h"
#include "shell/solver/statics/relaxation.h"
#include "tests/validation/cases.h"
#include "tests/validation/tips.h"

namespace sunder::validation {
namespace {

using namespace sunder::shell;

using std::numbers::pi;
constexpr double kTipSide = 0.2, kHalfCrack = 0.0125, kTipThickness = 0.004, kStress = 1e6;

ShellMaterial tip_glass() {
  ShellMaterial m;
  m.density = 2500, m.youngs_modulus = 70e9, m.poisson_ratio = 0.22, m.strength = 60e6, m.fracture_energy = 8.0;
  return m;
}

enum class Pull { kAllRound, kOneWay, kBending };

std::vector<Load> loads(Pull pull) {
  std::vector<Load> out;
  for (const int edge : {kUMin, kUMax, kVMin, kVMax}) {
    Load l;
    l.edges = edge;
    const double sign = edge == kUMin || edge == kVMin ? -1.0 : 1.0;
    if (pull == Pull::kBending) {
      l.kind = Load::Kind::kEdgeMoment, l.size = 1e-2 * kStress * kTipThickness * kTipThickness / 6.0;
    } else {
      l.kind = Load::Kind::kEdgeForce;
      if (edge == kVMin || edge == kVMax)
        l.force.y() = sign * kStress * kTipThickness;
      else if (pull == Pull::kAllRound)
        l.force.x() = sign * kStress * kTipThickness;
    }
    out.push_back(l);
  }
  return out;
}

// Half-length by which a crack on a grid is longer than its own, at most [spacings]: functions are smooth over its end.
constexpr double kLongerCrack = 0.6;

struct Found {
  double k1 = 0.0;             // sqrt(energy release) over that of a crack across the stress in an infinite sheet
  double release = 0.0;        // J, over the same
  double turn = 0.0;           // turn in either direction [rad]
  double anticlockwise = 0.0;  // mean of both tips [rad]
};

// `beside`: the crack's middle from that of the sheet, in spacings; off the lattice, as cracks are.
Found crack_under(Pull pull, int elements, double angle, int threads, const Vec2& beside = Vec2(0.31, 0.17),
                  const CalibratedConstants& constants = {}) {
  const ShellModel m =
      make_shell("sheet", plate(kTipSide, kTipSide, elements, elements, Vec3::Zero(), Quat::Identity()), kTipThickness,
                 tip_glass(), 2, 2, {}, loads(pull));
  ShellState s = make_state(m, Vec3::Zero(), 1);
  const Vec2 c = Vec2::Constant(0.5 * kTipSide) + m.spacing * beside, d(std::cos(angle), std::sin(angle));
  insert_polyline(m, s, {c - kHalfCrack * d, c + kHalfCrack * d}, 0.0);
  start_at_ends(m, s, 0, static_cast<int>(s.cracks.graph.edges().size()));
  RelaxationRules rules;
  rules.threads = threads, rules.tolerance = 1e-5;
  relax(m, s, rules);
  compute_forces(m, s, false, 1.0, threads);
  const CrackRules r = make_crack_rules(m, 0.0, constants);
  Found found;
  for (const Tip& tip : s.cracks.tips) {
    Start start;
    start.p = tip.p, start.direction = tip.direction, start.edge = tip.edge, start.most_turn = kFirstTurn;
    const Drive drive = drive_at(m, s, r, start);
    const double e = m.material.youngs_modulus, nu = m.material.poisson_ratio;
    const double root = drive.ratio * std::sqrt(e * m.material.fracture_energy);  // sqrt(E G)
    const double known = pull == Pull::kBending
                             ? 1e-2 * kStress * std::sqrt(kHalfCrack * pi * (1.0 + nu) / (3.0 * (3.0 + nu)))
                             : kStress * std::sqrt(pi * kHalfCrack);
    const ReleaseLook look{tip.p, tip.direction, kReleaseInner * kReleaseOuter * m.spacing, kReleaseOuter * m.spacing};
    found.release += energy_release_at(m, s, look).x() * e / (known * known) / s.cracks.tips.size();
    found.k1 += root / known / s.cracks.tips.size(), found.turn += std::abs(drive.turn) / s.cracks.tips.size();
    found.anticlockwise += drive.turn / s.cracks.tips.size();
  }
  return found;
}

// Maximum hoop stress (Erdogan and Sih 1963): the angle, and K of the kink over K of a crack across the stress.
std::pair<double, double> kinked(double k1, double k2) {
  const double q = k1 / k2, t = 2.0 * std::atan((q - std::sqrt(q * q + 8.0)) / 4.0);
  return {std::abs(t), std::pow(std::cos(0.5 * t), 3) * k1 - 1.5 * std::cos(0.5 * t) * std::sin(t) * k2};
}

constexpr double kDegree = pi / 180.0;

// Places in an element, evenly spread (Roberts): powers of 1 over the plastic number.
Vec2 place(int k) {
  constexpr double kPlastic = 0.754877666246693;
  return {std::fmod(0.5 + k * kPlastic, 1.0), std::fmod(0.5 + k * kPlastic * kPlastic, 1.0)};
}

void energy_release(Report& r, int threads) {
  // The mean over R sees the field beyond the singular one as well, 1 + 3 r / 4 a of it: some tenth too much at R = a
  // / 4.
  for (const auto& [pull, name] : {std::pair{Pull::kAllRound, "stretched"}, std::pair{Pull::kBending, "bent"}})
    for (const double angle : {0.0, 15.0, 30.0, 45.0})
      for (const int elements : {64, 96, 128}) {
        // Relaxation of a bent plate is slow, so it has other angles on the middle grid only.
        if (elements != (pull == Pull::kBending ? 96 : 128) && angle != 30.0) continue;
        const double start = seconds_now();
        const Found f = crack_under(pull, elements, angle * kDegree, threads);
        r.add(fmt::format("{}_{:.0f}_degrees_{}", name, angle, elements), f.k1, 1.0, 0.25, seconds_now() - start);
        r.add(fmt::format("{}_release_{:.0f}_degrees_{}", name, angle, elements), f.release, 1.0,
              kLongerCrack * kTipSide / (elements * kHalfCrack), 0.0);
        r.lines.push_back(
            fmt::format("{} at {:.0f} degrees, {}: turns by {:.1f} degrees", name, angle, elements, f.turn / kDegree));
      }
  // The angle is midway between an axis and a diagonal of the lattice; the mean is over places of the crack in an
  // element. The turn of a bent crack by the lattice is corrected (kToDiagonal). That of a stretched crack, 1 or 2
  // degrees towards the axis, is not.
  struct Turned {
    Pull pull;
    const char* name;
    int places;
    double most;
  };
  for (const auto& [pull, name, places, most] :
       {Turned{Pull::kAllRound, "stretched", 128, 3.0}, Turned{Pull::kBending, "bent", 32, 2.0}}) {
    const double start = seconds_now();
    double sum = 0.0, squares = 0.0;
    for (int k = 0; k < places; ++k) {
      const double turn = crack_under(pull, 48, 22.5 * kDegree, threads, place(k)).anticlockwise / kDegree;
      sum += turn, squares += turn * turn;
    }
    const double mean = sum / places, error = std::sqrt((squares / places - mean * mean) / (places - 1));
    r.add(fmt::format("{}_lattice_turns", name), mean, 0.0, most, seconds_now() - start);
    r.lines.push_back(fmt::format("{}: the lattice turns by {:.1f} +- {:.1f} degrees", name, mean, error));
  }
  for (const double angle : {30.0, 45.0, 60.0}) {
    const double start = seconds_now(), a = angle * kDegree;
    const Found f = crack_under(Pull::kOneWay, 128, a, threads);
    const auto [turn, k] = kinked(std::pow(std::cos(a), 2), std::sin(a) * std::cos(a));
    // The stress along the crack, which the singular field lacks, turns it by some degrees.
    r.add(fmt::format("kink_{:.0f}_off_degrees", angle), (f.turn - turn) / kDegree, 0.0, 10.0, seconds_now() - start);
    r.add(fmt::format("kink_{:.0f}_opening", angle), f.k1, k, 0.2, 0.0);
  }
}

}  // namespace

double bent_crack_turns(const CalibratedConstants& constants, int places, int threads) {
  double sum = 0.0;
  for (int k = 0; k < places; ++k)
    sum += crack_under(Pull::kBending, 48, 22.5 * kDegree, threads, place(k), constants).anticlockwise / kDegree;
  return sum / places;
}

std::vector<Case> tip_cases() {
  return {
      {"energy_release", "what drives a tip, stretched, bent, across and aslant (Erdogan and Sih)", energy_release}};
}

}  // namespace sunder::validation
