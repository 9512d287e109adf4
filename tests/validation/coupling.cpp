// Coupling schemes: free, squeezed and held bodies against a run with windows of one substep.
#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>

#include "coupler/core/error.h"
#include "coupler/core/ticks.h"
#include "shell/run/run.h"
#include "tests/validation/cases.h"
#include "tests/validation/coupled.h"

namespace sunder::validation {
namespace {

constexpr double kAsMonolithic = 1e-9;  // [m, m/s]
constexpr double kMostGain = 0.02, kLargestStiffnessRatio = 3e4;

constexpr long double kOneRounding = 0x1p-53L;

// Times [s] must follow from whole numbers of ticks. The run's arithmetic is compared with a longer one.
void ticks(Report& report, int) {
  const double start = seconds_now();
  constexpr std::int64_t kWindows = 10000000;
  constexpr int kRatio = 6400;  // substeps per window
  const Ticks ticks{1e-4 / 3.0};
  long double worst = 0.0L;
  double within = 0.0, summed = 0.0;
  std::int64_t lost = 0;
  for (std::int64_t w = 1; w <= kWindows; ++w) {
    const long double exact = static_cast<long double>(w) * ticks.length;
    const double end = ticks.time(w);
    worst = std::max(worst, std::abs(end - exact) / exact);
    lost += ticks.nearest(end) != w;
    // The end of one window's substeps must be the start of the next window.
    within = std::max(within, std::abs(ticks.time(w - 1) + kRatio * ticks.substep(1, kRatio) - end) / end);
    summed += ticks.length;
  }
  report.add("ticks_1e7_roundings", static_cast<double>(worst / kOneRounding), 0.0, 1.0, seconds_now() - start);
  report.add("ticks_1e7_not_found_again", static_cast<double>(lost), 0.0, 0.0, 0.0);
  report.add("ticks_1e7_within_a_window", within, 0.0, 1e-15, 0.0);
  report.lines.push_back(fmt::format("ticks: summing 1e7 windows instead would have drifted by {:.1e}",
                                     std::abs(summed / ticks.time(kWindows) - 1.0)));
  for (const auto& [substeps, windows] : {std::pair{1, 100000}, std::pair{kRatio, 100}}) {
    Coupled c;
    c.windows = windows, c.substeps = substeps, c.elastic = false;
    const double real = seconds_now(), window = substeps * coupled_substep();
    std::int64_t count = 0;
    long double most = 0.0L;
    WatchedRun end;
    const std::string failure = run_text(
        coupled_text(c), "freeflight",
        [&](double time, double, const auto&) {
          const long double exact = static_cast<long double>(++count) * window;
          most = std::max(most, std::abs(time - exact) / exact / kOneRounding);
        },
        &end);
    const std::string steps = fmt::format("\"substeps\": {},", static_cast<std::int64_t>(windows) * substeps);
    const bool whole = failure.empty() && count == windows && end.summary.find(steps) != std::string::npos;
    report.add(fmt::format("ticks_{}_real_windows_of_{}", windows, substeps),
               whole ? static_cast<double>(most) : std::nan(""), 0.0, 1.0, seconds_now() - real);
  }
}

// A body that only the shell pushes moves as if there were no windows.
void free_bodies(Report& report, int) {
  const double step = coupled_substep();
  for (const double ratio : {1e-3, 1.0, 1e6}) {
    Coupled c;
    c.ratio = ratio, c.elastic = false, c.windows = 4000;
    const Watched whole = run_coupled(c);
    for (const char* engine : {"bullet", "ode", "freeflight"})
      for (const int n : {20, 1000}) {
        c.substeps = n, c.windows = 4000 / n, c.engine = engine;
        const Watched w = run_coupled(c);
        double worst = w.failure.empty() ? 0.0 : std::nan("");
        for (std::size_t k = 0; k < w.track.size(); ++k) {
          const BodyMotion &a = w.track[k], &b = whole.track.at((k + 1) * n - 1);
          worst = std::max({worst, (a.position - b.position).norm(), (a.velocity - b.velocity).norm()});
        }
        report.add(fmt::format("free_{}_{:g}_{}", engine, ratio, n), worst, 0.0, kAsMonolithic, w.seconds);
      }
  }
  report.lines.push_back(
      fmt::format("free: largest difference [m, m/s] from windows of one substep, {:.3g} s, at every "
                  "window; name: engine, mass over the plate's, substeps a window",
                  step));
}

void rebound(Report& report, int) {
  for (const double ratio : {0.01, 1.0, 100.0}) {
    double speed[2];
    double seconds = 0.0;
    for (const int i : {0, 1}) {
      Coupled c;
      c.ratio = ratio, c.substeps = i == 0 ? 10 : 100, c.windows = 6000 / c.substeps;
      const Watched w = run_coupled(c);
      speed[i] = w.failure.empty() ? w.track.back().velocity.z() : std::nan(""), seconds += w.seconds;
    }
    report.add(fmt::format("rebound_{:g}_window_times_10", ratio), speed[1], speed[0], 0.01, seconds);
  }
}

// Gain of energy and rebound, over mass ratio, substeps and kind of support.
void map_of(Report& report, const std::vector<Hold>& holds, const std::vector<double>& ratios,
            const std::vector<int>& counts, int windows) {
  const std::vector<std::string> schemes{"PROXY", "EXPORTED", "ITERATED", "STAGGERED", "LAGGED"};
  std::map<std::string, double> worst;
  report.lines.emplace_back(
      "map: hold, mass over the plate's, substeps a window, k H^2 / M, scheme: energy gained, energy "
      "left, fastest that the body was after a window over the same with windows of one substep");
  std::map<std::string, double> rebound;  // of free bodies, which hit the plate once
  for (const Hold hold : holds)
    for (const double ratio : ratios) {
      Coupled one;
      one.hold = hold, one.ratio = ratio, one.windows = windows * *std::max_element(counts.begin(), counts.end());
      const Watched whole = run_coupled(one);
      for (const int n : counts) {
        double stiffness_ratio = 0.0, fastest = 0.0;
        for (int k = n; k <= windows * n && k <= static_cast<int>(whole.track.size()); k += n)
          fastest = std::max(fastest, whole.track[k - 1].velocity.norm());
        std::string line;
        for (const std::string& scheme : schemes) {
          Coupled c;
          c.hold = hold, c.ratio = ratio, c.substeps = n, c.windows = windows, c.scheme = scheme;
          if (scheme == "ITERATED" && n > 100) continue;  // each window takes up to eight passes
          const Watched w = run_coupled(c);
          stiffness_ratio = std::max(stiffness_ratio, w.hardest);
          const double gain = w.failure.empty() ? above_zero(w.gain()) : std::numeric_limits<double>::infinity();
          double speed = 0.0;
          for (const BodyMotion& m : w.track) speed = std::max(speed, m.velocity.norm());
          if (hold == Hold::kFree && !w.track.empty())
            rebound[scheme] = std::max(
                rebound[scheme],
                std::abs(w.track.back().velocity.norm() / whole.track.at(windows * n - 1).velocity.norm() - 1.0));
          line +=
              fmt::format("  {} {:.2g} {:.3f} {:.3f}{}", scheme, gain, w.end_energy / w.start_energy, speed / fastest,
                          w.failure.empty() ? "" : " (" + w.failure.substr(0, w.failure.find(':')) + ")");
          Curve* curve = nullptr;
          for (Curve& known : report.curves)
            if (known.name == scheme) curve = &known;
          if (!curve) {
            report.curves.push_back({scheme, "k H^2 / M", "energy gained", {}, {}});
            curve = &report.curves.back();
          }
          curve->x.push_back(std::max(stiffness_ratio, 1e-6)), curve->y.push_back(std::max(std::min(gain, 1e6), 1e-9));
          if (hold == Hold::kFree || stiffness_ratio <= kLargestStiffnessRatio)
            worst[scheme] = std::max(worst[scheme], gain);
        }
        report.lines.push_back(fmt::format("{:<6} {:<6g} {:>4} {:>9.2g} {}", kHoldNames[static_cast<int>(hold)], ratio,
                                           n, stiffness_ratio, line));
      }
    }
  for (const char* scheme : {"PROXY", "EXPORTED"})
    if (rebound.count(scheme)) report.add(std::string("map_rebound_") + scheme, rebound[scheme], 0.0, kMostGain, 0.0);
  for (const auto& [scheme, gain] : worst) {
    const bool must_hold = scheme == "PROXY" || scheme == "EXPORTED";
    if (must_hold)
      report.add("map_gain_" + scheme, gain, 0.0, kMostGain, 0.0);
    else if (holds.size() > 1)  // a scheme for comparison: it must be seen to fail somewhere
      report.add("map_fails_" + scheme, gain > kMostGain ? 1.0 : 0.0, 1.0, 0.0, 0.0);
  }
}

const std::vector<Hold> kHolds{Hold::kFree, Hold::kFloor, Hold::kBody, Hold::kHinge};

void map_small(Report& report, int) { map_of(report, kHolds, {1e-3, 1.0, 1e6}, {1, 20, 100}, 200); }
void map_parts(Report& report, const std::vector<Hold>& holds) {
  map_of(report, holds, {1e-3, 1e-1, 1e1, 1e3, 1e6}, {1, 10, 100, 1000}, 1000);
}

void corners(Report& report, int) {
  for (const Hold hold : {Hold::kFloor, Hold::kBody, Hold::kHinge, Hold::kFree})
    for (const double ratio : {1e-3, 1e6}) {
      Coupled c;
      c.hold = hold, c.ratio = ratio, c.substeps = 20, c.windows = 100000;
      const Watched w = run_coupled(c);
      const double gain = w.failure.empty() ? above_zero(w.gain()) : std::nan("");
      const std::string name = fmt::format("corner_{}_{:g}", kHoldNames[static_cast<int>(hold)], ratio);
      report.add(name, gain, 0.0, kMostGain, w.seconds);
      if (!w.failure.empty())
        report.lines.push_back(fmt::format("{} after {} windows: {}", name, w.track.size(), w.failure));
    }
}

// Gravity presses a ball on a plate for less than a period: two masses and springs.
void oscillator(Report& report, int) {
  const auto end_of = [](const std::string& scheme, int n) {
    Coupled c;
    c.scheme = scheme, c.substeps = n, c.windows = 640 / n, c.ratio = 20.0, c.elastic = false, c.resting = true;
    const Watched w = run_coupled(c);
    return w.failure.empty() ? w.track.back() : BodyMotion{Vec3::Constant(std::nan(""))};
  };
  const double start = seconds_now();
  const BodyMotion exact = end_of("PROXY", 1);
  for (const char* scheme : {"PROXY", "ITERATED", "EXPORTED", "STAGGERED", "LAGGED"}) {
    Curve curve{std::string("oscillator ") + scheme, "substeps a window", "error of the ball's height [m]", {}, {}};
    // Exported bodies are pushed out of their overlap, others are not, so the exact answer differs.
    const bool exported = scheme == std::string("EXPORTED");
    const BodyMotion whole = exported ? end_of(scheme, 1) : exact;
    if (exported)
      report.lines.push_back(fmt::format("oscillator: drawn out of the plate, an exported ball lies {:.2e} m higher",
                                         (whole.position - exact.position).z()));
    for (const int n : {2, 4, 8, 16, 32}) {
      curve.x.push_back(n);
      curve.y.push_back(std::max((end_of(scheme, n).position - whole.position).norm(), 1e-18));
    }
    const double order = std::log2(curve.y[3] / curve.y[1]) / 2.0;  // between 4 and 16 substeps
    if (scheme == std::string("STAGGERED") || scheme == std::string("LAGGED"))
      report.add(std::string("order_") + scheme, order, 1.0, 0.25, seconds_now() - start);
    else
      report.add(std::string("error_") + scheme, *std::max_element(curve.y.begin(), curve.y.end()), 0.0, kAsMonolithic,
                 seconds_now() - start);
    report.lines.push_back(
        fmt::format("oscillator {}: errors {:.2e} {:.2e} {:.2e} {:.2e} {:.2e} m at 2 to 32 substeps a "
                    "window",
                    scheme, curve.y[0], curve.y[1], curve.y[2], curve.y[3], curve.y[4]));
    report.curves.push_back(std::move(curve));
  }
}

// Bodies on a floor, never exported, as with engines without rows. Windows have 64 substeps, or are halved by the rule,
// or are short at a constant length. All runs cover the same time.
void adaptive(Report& report, int) {
  constexpr int kLong = 64, kShort = 16, kSubsteps = 12800;
  constexpr double kShareLeft = 0.5;  // share of the loss with long windows; 0.33 was found
  for (const double ratio : {1.0, 1e-3}) {
    const auto run = [&](int n, const std::string& more) {
      Coupled c;
      c.hold = Hold::kFloor, c.ratio = ratio, c.substeps = n, c.windows = kSubsteps / n;
      c.scheme = "PROXY export_above: 1e300 " + more;
      const Watched w = run_coupled(c);
      report.lines.push_back(
          fmt::format("adaptive: mass ratio {:g}, {} substeps a window {}: {} windows, energy gained "
                      "{:.2g}, left {:.3f} {}",
                      ratio, n, more, w.track.size(), above_zero(w.gain()), w.end_energy / w.start_energy, w.failure));
      return w;
    };
    const Watched fixed = run(kLong, ""), halved = run(kLong, "adaptive_window {}");
    run(kShort, "");
    if (ratio < 1.0) continue;  // printed only: a light body gains energy before its window is halved
    const double share =
        (1.0 - halved.end_energy / halved.start_energy) / (1.0 - fixed.end_energy / fixed.start_energy);
    report.add("adaptive_share_of_loss", halved.failure.empty() ? share : std::nan(""), 0.0, kShareLeft,
               fixed.seconds + halved.seconds);
  }
}

// Each side must gain what the other loses; otherwise the run must stop with an error.
void closure(Report& report, int) {
  for (const char* engine : {"bullet", "ode", "freeflight"})
    for (const Hold hold : {Hold::kFree, Hold::kFloor}) {
      Coupled c;
      c.hold = hold, c.engine = engine, c.substeps = 20, c.windows = 200, c.elastic = false;
      const Watched w = run_coupled(c);
      report.add(fmt::format("ledger_{}_{}", engine, kHoldNames[static_cast<int>(hold)]),
                 w.failure.empty() && w.ledger > 0.0 ? w.ledger : std::nan(""), 0.0, 1e-12, w.seconds);
    }
  Coupled c;
  c.substeps = 20, c.windows = 200, c.elastic = false;
  const auto leak = [&](const char* what, const std::function<void(shell::Proxy&)>& spoil) {
    const Watched w = run_coupled(c, [&](std::int64_t window, std::vector<shell::Proxy>& bodies) {
      if (window >= 3 && bodies[0].impulse_sum > 0.0) spoil(bodies[0]);
    });
    const bool named = w.failure.rfind("ledger: window ", 0) == 0 && w.failure.find("'ball'") != std::string::npos;
    report.add(fmt::format("planted_leak_of_{}_is_named", what), named ? 1.0 : 0.0, 1.0, 0.0, w.seconds);
    report.lines.push_back(fmt::format("closure: a leak in the {} ends the run with: {}", what, w.failure));
  };
  leak("booked_impulse", [](shell::Proxy& p) { p.linear_impulse *= 1.0 + 1e-9; });
  leak("velocity", [](shell::Proxy& p) { p.body.motion.velocity *= 1.0 + 1e-9; });
  leak("spin", [](shell::Proxy& p) { p.body.motion.angular_momentum += 1e-9 * p.moment_sum * Vec3::UnitX(); });
  leak("nan_spin", [](shell::Proxy& p) { p.body.motion.angular_momentum.x() = std::nan(""); });
}

// A stack of twenty plates on a bending shell, for two seconds.
void plates(Report& report, int) {
  for (const char* engine : {"bullet", "ode"}) {
    constexpr int kCount = 20;
    constexpr double kPlate = 0.003, kShell = 0.006;
    std::string s =
        "name: \"plates\" end_time_s: 2 window_s: 1e-3\n"
        "materials { name: \"acrylic\" density: 1200 youngs_modulus: 3.2e9 poisson_ratio: 0.3 mass_damping_per_s: 40 "
        "}\n"
        "materials { name: \"glass\" density: 2500 }\n"
        "shells { name: \"shell\" material: \"acrylic\" thickness_m: 0.006 plate { size_x_m: 0.5 size_y_m: 0.5 "
        "elements_x: 10 elements_y: 10 } supports { edges: ALL kind: CLAMPED } }\n"
        "contacts { friction: 0.4 }\ncoupling { scheme: EXPORTED }\n"
        "output { frame_interval_s: 1e9 checkpoint_interval_s: 0 }\n";
    for (int i = 0; i < kCount; ++i)
      s += fmt::format(
          "bodies {{ name: \"plate_{}\" material: \"glass\" box {{ size_m {{ x: 0.15 y: 0.15 z: {} }} }} pose {{ "
          "position "
          "{{ x: {:.6f} y: {:.6f} z: {:.9f} }} }} }}\n",
          i, kPlate, 0.004 * std::sin(1.7 * i), 0.004 * std::cos(2.3 * i),
          0.5 * kShell + (i + 0.5) * kPlate + 1e-6 * (i + 1));
    const double start = seconds_now();
    std::vector<Vec3> settled, last;
    double worst_gap = 0.0;
    const std::string failure = run_text(s, engine, [&](double time, double, const auto& bodies) {
      last.clear();
      for (const RigidBody* b : bodies) last.push_back(b->motion.position);
      if (time >= 0.5 && settled.empty()) settled = last;
      if (time < 0.5) return;
      for (int i = 1; i < kCount; ++i) worst_gap = std::max(worst_gap, std::abs((last[i] - last[i - 1]).z() - kPlate));
    });
    double slid = 0.0, walked = 0.0;  // against the plate below; of the whole stack on the shell
    for (std::size_t i = 0; i < settled.size(); ++i) {
      const Vec3 moved = last[i] - settled[i];
      if (i > 0) slid = std::max(slid, (moved - (last[i - 1] - settled[i - 1])).head<2>().norm());
      walked = std::max(walked, moved.head<2>().norm());
    }
    if (!failure.empty()) worst_gap = slid = std::nan(""), report.lines.push_back("plates: " + failure);
    report.lines.push_back(fmt::format(
        "plates {}: the stack as a whole has walked {:.3g} m on the shell between 0.5 and 2 s", engine, walked));
    report.add(fmt::format("plates_{}_gap_m", engine), worst_gap, 0.0, 1e-5, seconds_now() - start);
    report.add(fmt::format("plates_{}_slid_m", engine), slid, 0.0, 1e-5, 0.0);
  }
}

}  // namespace

std::vector<Case> coupling_cases() {
  return {{"closure", "impulses between shell and bodies, and a planted leak", closure},
          {"ticks", "no drift in time", ticks},
          {"free", "free bodies against windows of one substep", free_bodies},
          {"oscillator", "order of the schemes", oscillator},
          {"rebound", "of a ball, windows ten times as long", rebound},
          {"map", "energy gained by squeezed and held bodies, all schemes: a part of map_whole", map_small},
          {"adaptive", "what adaptive_window saves of the energy that long windows lose", adaptive},
          {"plates", "twenty plates on a flexing shell for 2 s", plates}};
}

std::vector<Case> long_coupling_cases() {
  std::vector<Case> cases{{"map_whole", "five mass ratios, up to 1000 substeps, 1000 windows a point: hours",
                           [](Report& report, int) { map_parts(report, kHolds); }},
                          {"corners", "eight points with 1e5 windows", corners}};
  for (const Hold hold : kHolds)  // for machines with several processors
    cases.push_back({fmt::format("map_{}", kHoldNames[static_cast<int>(hold)]), "a quarter of map_whole",
                     [hold](Report& report, int) { map_parts(report, {hold}); }});
  return cases;
}

}  // namespace sunder::validation
