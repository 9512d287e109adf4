#include "shell/solver/statics/relaxation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "shell/solver/forces.h"
#include "shell/solver/statics/balance.h"
#include "shell/solver/statics/newton.h"

namespace sunder::shell {
namespace {

constexpr double kStep = 0.9;       // share of the stable step
constexpr int kMeasureEvery = 400;  // steps between two measurements of the stable step
constexpr int kFirstIterations = 150,
              kLaterIterations = 16;    // of the first measurement; of the later ones, which start from its mode
constexpr int kCheckEvery = 50;         // steps between two checks of the residual
constexpr double kLongestStep = 0.1;    // longest Newton step, as a share of the shell's size
constexpr int kPatience = 5;            // Newton steps without progress
constexpr double kRoundOff = 1e-3;      // a residual below this that does not fall is round-off, or a wrong way
constexpr double kMostRoundOff = 1e-3;  // residual above which round-off is a failure
constexpr double kLittleWork = 1e-8;    // share of the work of the loads: positions are off by the root of it
constexpr double kNoise = 2.0;          // multiple of a change of the last places that is round-off
constexpr int kMostHalvings = 6;        // of a Newton step
constexpr double kFallen = 0.8;         // a step is accepted when the residual's work on it has fallen to this share
constexpr double kWorse = 2.0;          // multiple of the least remaining work at which Newton's search returns to it
constexpr double kMargin = 1.1;         // power iteration approaches the eigenvalue from below
constexpr double kFirstShare = 0.1;     // first step of the loads
constexpr double kLeastShare = 1e-3;    // shortest step of the loads
constexpr int kNewtonOfStep = 30;       // Newton steps for one step of the loads
constexpr int kQuick = 12;              // a step of the loads that takes fewer is followed by a longer one
constexpr double kOfStep = 1e-4;        // residual that ends a step of the loads
constexpr double kFarAway = 20.0;       // sizes of the shell: nothing holds it
constexpr double kOpen = 1e-10;         // largest violation of the constraints of seams [-]
constexpr double kGoneDown = 0.1;       // relaxation tries Newton steps when the residual has fallen to this share

// The search of one shell.
class Search {
 public:
  Search(const JoinedShells& joined, const RelaxationRules& rules)
      : joined_(joined), rules_(rules), balance_(joined, rules.threads), size_(balance_.x.size()) {
    spacing_ = joined.shells[0].model->spacing;
    for (std::size_t k = 0; k < joined.shells.size(); ++k) {
      const std::size_t stride = joined.shells[k].model->tables.component_stride, first = balance_.degrees().first(k);
      for (std::size_t i = 0; i < 3 * stride; ++i)
        furthest_ = std::max(furthest_, std::abs(balance_.x[first + i] - balance_.x[first + i - i % stride]));
      spacing_ = std::min(spacing_, joined.shells[k].model->spacing);
    }
  }

  RelaxationResult run() {
    last_ = balance_.x;
    balance_.go_to(1.0);
    bool whole = rules_.most_newton > 0;
    for (const ShellRef& r : joined_.shells)
      whole = whole && is_uncracked(*r.model, *r.state) && r.state->cracks.interlocks.empty();
    if (whole) {
      if (newton(rules_.most_newton, rules_.tolerance, Differences::kOneSided) || load_steps()) {
        r_.converged = true, r_.share = 1.0;
        return r_;
      }
    }
    relax(whole);
    if (r_.converged)
      r_.share = 1.0;
    else
      balance_.x = last_;
    return r_;
  }

  // Gives positions to the states, and what seams do to their control points to who asks for it.
  void leave(SeamForces* of_seams) {
    forces();
    if (!of_seams) return;
    std::vector<double> all;
    balance_.residual(all);  // for the multipliers
    all = balance_.force;
    const JoinedDegrees& degrees = balance_.degrees();
    degrees.hand_over(all);
    if (degrees.constrained()) degrees.add_forces(balance_.x, balance_.multipliers(), all);
    for (std::size_t i = 0; i < size_; ++i) all[i] -= balance_.force[i];
    of_seams->clear();
    for (std::size_t k = 0; k < joined_.shells.size(); ++k) {
      const auto first = all.begin() + static_cast<std::ptrdiff_t>(degrees.first(k));
      of_seams->emplace_back(first, first + static_cast<std::ptrdiff_t>(joined_.shells[k].state->motion.x.size()));
    }
  }

 private:
  void forces() { balance_.compute(); }

  // Takes Newton steps from the present positions. Returns true in equilibrium.
  // `leaves_unstable`: stops where the shell is not stable.
  bool newton(int most, double tolerance, Differences differences, bool leaves_unstable = false) {
    const std::vector<double> start = balance_.x;
    std::vector<double> summed, nearest = balance_.x;
    double best = std::numeric_limits<double>::infinity(), least = best;
    int since_best = 0;
    for (int k = 0; k < most; ++k, ++r_.newton) {
      forces();
      if (rules_.look) rules_.look();
      r_.residual = balance_.residual(summed);
      if (r_.residual <= tolerance && balance_.open() <= kOpen) return true;
      if (!std::isfinite(r_.residual)) return false;
      since_best = r_.residual < 0.5 * best ? 0 : since_best + 1;
      if (r_.residual < best) nearest = balance_.x;
      best = std::min(best, r_.residual);
      if (since_best > kPatience && r_.residual < kRoundOff) break;
      const auto [step, unstable] = newton_step(balance_, summed, differences);
      if (step.empty() || (unstable && leaves_unstable)) return false;
      if (!balance_.rotates()) r_.stable = unstable ? RelaxationResult::Stable::kNo : RelaxationResult::Stable::kYes;
      const double left = balance_.work_on(step);  // of the residual
      const double done = balance_.work_from(start);
      if (std::abs(left) <= rules_.tolerance * rules_.tolerance * std::abs(done) && balance_.open() <= kOpen)
        return true;
      least = std::min(least, std::abs(left));
      if (std::abs(left) > kWorse * least && least < kRoundOff * std::abs(done) &&
          best <= kNoise * balance_.round_off())
        break;
      double longest = 0.0;
      for (const double u : step) longest = std::max(longest, std::abs(u));
      // Shortens the step until the residual's work on it has fallen (Crisfield's line search).
      const std::vector<double> from = balance_.x;
      double share = std::min(1.0, kLongestStep * furthest_ / longest);
      for (int halving = 0;; ++halving, share *= 0.5) {
        for (std::size_t i = 0; i < size_; ++i) balance_.x[i] = from[i] + share * step[i];
        if (halving == kMostHalvings) break;
        forces();
        if (balance_.degrees().constrained()) balance_.residual(summed);
        if (std::abs(balance_.work_on(step)) <= kFallen * std::abs(left)) break;
      }
    }
    balance_.x = nearest;
    forces();
    r_.residual = best;
    // The work that is left tells whether the softest modes are balanced too: the residual hides them.
    const bool little_left = least <= kLittleWork * std::abs(balance_.work_from(balance_.start()));
    r_.round_off = little_left && r_.stable != RelaxationResult::Stable::kNo &&
                   best <= std::min(kMostRoundOff, kNoise * balance_.round_off()) && balance_.open() <= kOpen;
    return r_.round_off;
  }

  // Brings up the loads in steps, which Newton's method follows. Returns true in equilibrium. Otherwise the shell is in
  // the last equilibrium that was found, at r_.share of the loads.
  bool load_steps() {
    balance_.x = balance_.start();
    double step = kFirstShare;
    r_.share = 0.0;
    while (r_.share < 1.0) {
      const std::vector<double> from = balance_.x;
      const double to = r_.share + step > 1.0 - kLeastShare ? 1.0 : r_.share + step;
      const int before = r_.newton;
      balance_.go_to(to);
      const bool found = newton(kNewtonOfStep, to == 1.0 ? rules_.tolerance : std::max(kOfStep, rules_.tolerance),
                                Differences::kCentral);
      if (found) {
        r_.share = to, ++r_.load_steps, last_ = balance_.x;
        if (r_.newton - before <= kQuick) step *= 2.0;
        continue;
      }
      balance_.x = from;
      if ((step *= 0.5) < kLeastShare) break;
    }
    if (r_.share == 1.0) return true;
    balance_.go_to(1.0);
    return false;
  }

  // Power iteration, continued from the last mode. Returns the step that relaxation takes.
  double stable(int iterations) {
    const double epsilon = 1e-7 * spacing_;
    const std::vector<double> at = balance_.x, f0 = balance_.force;
    double lambda = 0.0;
    for (int it = 0; it < iterations; ++it) {
      double largest = 0.0, before = 0.0, after = 0.0;
      for (std::size_t i = 0; i < size_; ++i) {
        if (balance_.inverse[i] == 0.0) mode_[i] = 0.0;
        largest = std::max(largest, std::abs(mode_[i]));
      }
      for (double& u : mode_) u /= largest;
      std::vector<double> moved = mode_;
      balance_.degrees().follow(moved);
      for (std::size_t i = 0; i < size_; ++i) balance_.x[i] = at[i] + epsilon * moved[i];
      forces();
      for (std::size_t i = 0; i < size_; ++i) balance_.force[i] = -(balance_.force[i] - f0[i]) / epsilon;
      balance_.gather(balance_.force);
      balance_.take_off(balance_.force);
      for (std::size_t i = 0; i < size_; ++i) {
        const double next = balance_.force[i] * balance_.inverse[i];
        before += mode_[i] * mode_[i], after += next * next;
        mode_[i] = next;
      }
      lambda = std::sqrt(after / before);
    }
    balance_.x = at, balance_.force = f0;
    return kStep * 2.0 / std::sqrt(kMargin * lambda);
  }

  bool moved_away() const {
    double most = 0.0;
    for (std::size_t i = 0; i < size_; ++i) most = std::max(most, std::abs(balance_.x[i] - balance_.start()[i]));
    return most > kFarAway * furthest_;
  }

  // Dynamic relaxation with kinetic damping. `polishes`: Newton steps may end it.
  void relax(bool polishes) {
    std::mt19937_64 random(1);
    mode_.resize(size_);
    for (double& x : mode_) x = static_cast<double>(random() >> 11) * 0x1.0p-52 - 1.0;
    std::vector<double> summed, v(size_, 0.0);
    double dt = 0.0, last = 0.0, tried = 1.0;
    bool resting = true;
    r_.stable = RelaxationResult::Stable::kUnknown;
    for (; r_.steps < rules_.most_steps; ++r_.steps) {
      forces();
      if (r_.steps % kMeasureEvery == 0) dt = stable(r_.steps == 0 ? kFirstIterations : kLaterIterations);
      if (r_.steps % kCheckEvery == 0) {
        if (rules_.look) rules_.look();
        r_.residual = balance_.residual(summed);
        r_.converged = r_.residual <= rules_.tolerance && balance_.open() <= kOpen;
        if (!std::isfinite(r_.residual) || r_.converged || moved_away()) break;
        if (polishes && r_.residual < kGoneDown * tried) {
          tried = r_.residual;
          const std::vector<double> x = balance_.x, f = balance_.force;
          if ((r_.converged = newton(kNewtonOfStep, rules_.tolerance, Differences::kCentral, true))) return;
          balance_.x = x, balance_.force = f;
          r_.stable = RelaxationResult::Stable::kUnknown;
        }
      }
      balance_.gather(balance_.force);
      balance_.take_off(balance_.force);
      double kinetic = 0.0;
      const double kick = resting ? 0.5 * dt : dt;
      for (std::size_t i = 0; i < size_; ++i) {
        v[i] += kick * balance_.force[i] * balance_.inverse[i];
        kinetic += v[i] * v[i] * balance_.mass[i];
      }
      resting = kinetic < last;  // past a peak
      last = resting ? 0.0 : kinetic;
      if (resting) {
        std::fill(v.begin(), v.end(), 0.0);
      } else {
        balance_.degrees().follow(v);
        for (std::size_t i = 0; i < size_; ++i) balance_.x[i] += dt * v[i];
        balance_.close();
      }
    }
  }

  const JoinedShells& joined_;
  const RelaxationRules& rules_;
  Balance balance_;
  std::size_t size_;
  double furthest_ = 0.0;     // the shell's size, to limit steps [m]
  double spacing_ = 0.0;      // the least [m]
  std::vector<double> last_;  // positions in the last equilibrium; before it, those at the start
  std::vector<double> mode_;
  RelaxationResult r_;
};

}  // namespace

RelaxationResult relax(const JoinedShells& joined, const RelaxationRules& rules, SeamForces* of_seams) {
  Search search(joined, rules);
  const RelaxationResult r = search.run();
  search.leave(of_seams);
  for (const ShellRef& shell : joined.shells) {
    ShellState& s = *shell.state;
    update_dropped_points(shell.model->trim, s.motion.x);
    std::fill(s.motion.v.begin(), s.motion.v.end(), 0.0);
    compute_forces(*shell.model, s, false, s.yields() ? 1.0 : 0.0,
                   joined.shells.size() == 1 ? rules.threads : 1);  // without the weights; plastic strain stays
  }
  return r;
}

RelaxationResult relax(const ShellModel& m, ShellState& s, const RelaxationRules& rules) {
  return relax(JoinedShells{{{&m, &s}}, {0}, nullptr, {rules.gravity}}, rules);
}

}  // namespace sunder::shell
