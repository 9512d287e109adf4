#include "tests/validation/coupled.h"

#include <atomic>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <numbers>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "tests/validation/cases.h"

namespace sunder::validation {
namespace {

constexpr double kStruckSide = 0.3, kStruckThickness = 0.004, kStruckDensity = 2500.0, kBallRadius = 0.04, kGap = 1e-5,
                 kSpeed = 1.0;
constexpr int kStruckElements = 8;
constexpr double kArm = 0.12;   // from the hinge to the ball's centre [m]
constexpr double kHertz = 1e8;  // elastic contact, which conserves energy [N/m^1.5]

// Returns the speed of the body, or of the plate [m/s]. A heavy body is slower, since it would tear the plate's control
// net.
double thrown(const Coupled& c) { return kSpeed / std::sqrt(std::max(1.0, c.ratio)); }

// Returns the initial gap [m]. It closes in the same time at any speed, long before a held plate swings back.
double gap(const Coupled& c) { return c.resting ? kGap : kGap * thrown(c) / kSpeed; }
}  // namespace

std::string coupled_text(const Coupled& c) {
  const double window = c.substeps * coupled_substep();
  const double plate_mass = kStruckDensity * kStruckThickness * kStruckSide * kStruckSide;
  const double density = c.ratio * plate_mass / (4.0 / 3.0 * std::numbers::pi * std::pow(kBallRadius, 3));
  const std::string contact =
      c.elastic ? fmt::format(
                      "contacts {{ friction: 0 }} contacts {{ first: \"plate\" second: \"ball\" hertz {{ "
                      "stiffness: {} }} }}",
                      kHertz)
                : "contacts { friction: 0.4 }";
  std::string s = fmt::format(
      "name: \"coupled\"\nend_time_s: {:.17g}\nwindow_s: {:.17g}\ntime_step_s: {:.17g}\ngravity {{ z: {} }}\n"
      "materials {{ name: \"plate\" density: {} youngs_modulus: 70e9 poisson_ratio: 0.22 }}\n"
      "materials {{ name: \"body\" density: {:.17g} }}\n"
      "shells {{ name: \"plate\" material: \"plate\" thickness_m: {} velocity {{ z: {} }}\n"
      "  plate {{ size_x_m: {} size_y_m: {} elements_x: {} elements_y: {} }} supports {{ edges: ALL kind: CLAMPED }} "
      "}}\n"
      "{}\n"
      "coupling {{ scheme: {} }}\noutput {{ frame_interval_s: 1e9 checkpoint_interval_s: 0 }}\n",
      c.windows * window, window, coupled_substep(), c.resting ? -9.81 : 0.0, kStruckDensity, density, kStruckThickness,
      c.hold == Hold::kFree ? 0.0 : -thrown(c), kStruckSide, kStruckSide, kStruckElements, kStruckElements, contact,
      c.scheme);
  const auto sphere = [&](const char* name, double z, double vz) {
    return fmt::format(
        "bodies {{ name: \"{}\" material: \"body\" sphere {{ radius_m: {} }} pose {{ position {{ x: 7.926e-3 y: "
        "7.926e-3 z: {:.17g} }} }} twist {{ linear {{ z: {} }} }} }}\n",
        name, kBallRadius, z, vz);
  };
  const double top = 0.5 * kStruckThickness + gap(c);
  if (c.hold == Hold::kFree) return s + sphere("ball", top + kBallRadius, c.resting ? 0.0 : -thrown(c)) + c.more;
  if (c.hold == Hold::kHinge)
    return s + sphere("ball", -top - kBallRadius, 0.0) +
           fmt::format(
               "joints {{ name: \"pin\" kind: HINGE first: \"ball\" position {{ x: {:.17g} y: 7.926e-3 z: {:.17g} }} "
               "axis {{ y: 1 }} }}\n",
               7.926e-3 - kArm, -top - kBallRadius) +
           c.more;
  s += sphere("ball", -top - kBallRadius, 0.0);
  double low = -top - 2.0 * kBallRadius - gap(c);
  if (c.hold == Hold::kBody) s += sphere("other", low - kBallRadius, 0.0), low -= 2.0 * kBallRadius + gap(c);
  return s + fmt::format("bodies {{ name: \"floor\" half_space {{}} pose {{ position {{ z: {:.17g} }} }} }}\n", low) +
         c.more;
}

double coupled_substep() {
  // A wave in the plane crosses an element in this time: 0.6 of the stable step.
  return 1.0 * kStruckSide / kStruckElements / std::sqrt(70e9 / ((1.0 - 0.22 * 0.22) * kStruckDensity));
}

namespace {

// Returns the energy [J] after one substep, before windows have an effect.
double first_energy(Coupled c) {
  c.substeps = 1, c.windows = 1, c.scheme = "PROXY";
  static std::map<std::string, double> known;
  const auto [at, is_new] = known.emplace(coupled_text(c), 0.0);
  if (is_new) (void)run_text(at->first, c.engine, [&](double, double energy, const auto&) { at->second = energy; });
  return at->second;
}

}  // namespace

Watched run_coupled(const Coupled& c, const Tamper& tamper) {
  Watched w;
  const double begin = seconds_now();
  WatchedRun end;
  w.failure = run_text(
      coupled_text(c), c.engine,
      [&](double, double energy, const std::vector<const RigidBody*>& bodies) {
        w.most_energy = std::max(w.most_energy, energy), w.end_energy = energy;
        w.track.push_back(bodies[0]->motion);
      },
      &end, tamper);
  const double plate = kStruckDensity * kStruckThickness * kStruckSide * kStruckSide;
  w.start_energy = c.hold == Hold::kFree ? 0.5 * c.ratio * plate * thrown(c) * thrown(c) : first_energy(c);
  w.hardest = end.hardest, w.exported = end.exported;
  if (!end.summary.empty())  // of a run that did not begin
    if (const auto found = nlohmann::json::parse(end.summary).at("ledger").at("linear_max"); found.is_number())
      w.ledger = found.get<double>();
  w.seconds = seconds_now() - begin;
  return w;
}

}  // namespace sunder::validation
