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
constexpr double kGoneDown = 0.1;       // relaxation tries Newton steps when the residual has fallen to this share

// The search of one shell.
class Search {
 public:
  Search(const ShellModel& m, ShellState& s, const RelaxationRules& rules)
      : m_(m),
        s_(s),
        rules_(rules),
        balance_(m, s, rules.gravity, rules.threads),
        size_(3 * m.tables.component_stride) {
    for (std::size_t i = 0; i < size_; ++i)
      furthest_ = std::max(furthest_, std::abs(s.motion.x[i] - s.motion.x[i - i % m.tables.component_stride]));
  }

  RelaxationResult run() {
    last_ = s_.motion.x;
    balance_.go_to(1.0);
    std::fill(s_.motion.v.begin(), s_.motion.v.end(), 0.0);
    const bool whole = is_uncracked(m_, s_) && s_.cracks.interlocks.empty() && rules_.most_newton > 0;
    if (whole) {
      free_ = free_degrees(m_, s_);
      if (newton(rules_.most_newton, rules_.tolerance, Differences::kOneSided) || load_steps()) {
        r_.converged = true, r_.share = 1.0;
        return r_;
      }
    }
    relax(whole);
    if (r_.converged)
      r_.share = 1.0;
    else
      s_.motion.x = last_;
    return r_;
  }

 private:
  void forces() { balance_.compute(); }

  // Takes Newton steps from the present positions. Returns true in equilibrium.
  // `leaves_unstable`: stops where the shell is not stable.
  bool newton(int most, double tolerance, Differences differences, bool leaves_unstable = false) {
    const std::vector<double> start = s_.motion.x;
    std::vector<double> summed, nearest = s_.motion.x;
    double best = std::numeric_limits<double>::infinity(), least = best;
    int since_best = 0;
    for (int k = 0; k < most; ++k, ++r_.newton) {
      forces();
      if (rules_.look) rules_.look();
      r_.residual = balance_.residual(summed);
      if (r_.residual <= tolerance) return true;
      if (!std::isfinite(r_.residual)) return false;
      since_best = r_.residual < 0.5 * best ? 0 : since_best + 1;
      if (r_.residual < best) nearest = s_.motion.x;
      best = std::min(best, r_.residual);
      if (since_best > kPatience && r_.residual < kRoundOff) break;
      const auto [step, unstable] = newton_step(m_, s_, free_, summed, differences, [this] { forces(); });
      if (step.empty() || (unstable && leaves_unstable)) return false;
      if (!m_.loads.rotate_with_surface())
        r_.stable = unstable ? RelaxationResult::Stable::kNo : RelaxationResult::Stable::kYes;
      double left = 0.0;  // work of the residual on the step
      for (std::size_t i = 0; i < size_; ++i) left += s_.motion.force[i] * step[i];
      const double done = balance_.work_from(start);
      if (std::abs(left) <= rules_.tolerance * rules_.tolerance * std::abs(done)) return true;
      least = std::min(least, std::abs(left));
      if (std::abs(left) > kWorse * least && least < kRoundOff * std::abs(done) &&
          best <= kNoise * balance_.round_off())
        break;
      double longest = 0.0;
      for (const double u : step) longest = std::max(longest, std::abs(u));
      // Shortens the step until the residual's work on it has fallen (Crisfield's line search).
      const std::vector<double> from = s_.motion.x;
      double share = std::min(1.0, kLongestStep * furthest_ / longest);
      for (int halving = 0;; ++halving, share *= 0.5) {
        for (std::size_t i = 0; i < size_; ++i) s_.motion.x[i] = from[i] + share * step[i];
        if (halving == kMostHalvings) break;
        forces();
        double slope = 0.0;
        for (std::size_t i = 0; i < size_; ++i) slope += s_.motion.force[i] * step[i];
        if (std::abs(slope) <= kFallen * std::abs(left)) break;
      }
    }
    s_.motion.x = nearest;
    forces();
    r_.residual = best;
    // The work that is left tells whether the softest modes are balanced too: the residual hides them.
    const bool little_left = least <= kLittleWork * std::abs(balance_.work_from(balance_.start()));
    r_.round_off = little_left && r_.stable != RelaxationResult::Stable::kNo &&
                   best <= std::min(kMostRoundOff, kNoise * balance_.round_off());
    return r_.round_off;
  }

  // Brings up the loads in steps, which Newton's method follows. Returns true in equilibrium. Otherwise the shell is in
  // the last equilibrium that was found, at r_.share of the loads.
  bool load_steps() {
    s_.motion.x = balance_.start();
    double step = kFirstShare;
    r_.share = 0.0;
    while (r_.share < 1.0) {
      const std::vector<double> from = s_.motion.x;
      const double to = r_.share + step > 1.0 - kLeastShare ? 1.0 : r_.share + step;
      const int before = r_.newton;
      balance_.go_to(to);
      const bool found = newton(kNewtonOfStep, to == 1.0 ? rules_.tolerance : std::max(kOfStep, rules_.tolerance),
                                Differences::kCentral);
      if (found) {
        r_.share = to, ++r_.load_steps, last_ = s_.motion.x;
        if (r_.newton - before <= kQuick) step *= 2.0;
        continue;
      }
      s_.motion.x = from;
      if ((step *= 0.5) < kLeastShare) break;
    }
    if (r_.share == 1.0) return true;
    balance_.go_to(1.0);
    return false;
  }

  // Power iteration, continued from the last mode. Returns the step that relaxation takes.
  double stable(int iterations) {
    const double epsilon = 1e-7 * m_.spacing;
    const std::vector<double> at = s_.motion.x, f0 = s_.motion.force;
    double lambda = 0.0;
    for (int it = 0; it < iterations; ++it) {
      double largest = 0.0, before = 0.0, after = 0.0;
      for (std::size_t i = 0; i < size_; ++i) {
        if (balance_.inverse[i] == 0.0) mode_[i] = 0.0;
        largest = std::max(largest, std::abs(mode_[i]));
      }
      for (std::size_t i = 0; i < size_; ++i) s_.motion.x[i] = at[i] + epsilon * (mode_[i] /= largest);
      forces();
      for (std::size_t i = 0; i < size_; ++i) s_.motion.force[i] = -(s_.motion.force[i] - f0[i]) / epsilon;
      balance_.gather(s_.motion.force);
      for (std::size_t i = 0; i < size_; ++i) {
        const double next = s_.motion.force[i] * balance_.inverse[i];
        before += mode_[i] * mode_[i], after += next * next;
        mode_[i] = next;
      }
      lambda = std::sqrt(after / before);
    }
    s_.motion.x = at, s_.motion.force = f0;
    return kStep * 2.0 / std::sqrt(kMargin * lambda);
  }

  bool moved_away() const {
    double most = 0.0;
    for (std::size_t i = 0; i < size_; ++i) most = std::max(most, std::abs(s_.motion.x[i] - balance_.start()[i]));
    return most > kFarAway * furthest_;
  }

  // Dynamic relaxation with kinetic damping. `polishes`: Newton steps may end it.
  void relax(bool polishes) {
    std::mt19937_64 random(1);
    mode_.resize(size_);
    for (double& x : mode_) x = static_cast<double>(random() >> 11) * 0x1.0p-52 - 1.0;
    std::vector<double> summed;
    double dt = 0.0, last = 0.0, tried = 1.0;
    bool resting = true;
    r_.stable = RelaxationResult::Stable::kUnknown;
    for (; r_.steps < rules_.most_steps; ++r_.steps) {
      forces();
      if (r_.steps % kMeasureEvery == 0) dt = stable(r_.steps == 0 ? kFirstIterations : kLaterIterations);
      if (r_.steps % kCheckEvery == 0) {
        if (rules_.look) rules_.look();
        r_.residual = balance_.residual(summed);
        r_.converged = r_.residual <= rules_.tolerance;
        if (!std::isfinite(r_.residual) || r_.converged || moved_away()) break;
        if (polishes && r_.residual < kGoneDown * tried) {
          tried = r_.residual;
          const std::vector<double> x = s_.motion.x, v = s_.motion.v, f = s_.motion.force;
          if ((r_.converged = newton(kNewtonOfStep, rules_.tolerance, Differences::kCentral, true))) return;
          s_.motion.x = x, s_.motion.v = v, s_.motion.force = f;
          r_.stable = RelaxationResult::Stable::kUnknown;
        }
      }
      balance_.gather(s_.motion.force);
      double kinetic = 0.0;
      const double kick = resting ? 0.5 * dt : dt;
      for (std::size_t i = 0; i < size_; ++i) {
        s_.motion.v[i] += kick * s_.motion.force[i] * balance_.inverse[i];
        kinetic += s_.motion.v[i] * s_.motion.v[i] * balance_.mass[i % m_.tables.component_stride];
      }
      resting = kinetic < last;  // past a peak
      last = resting ? 0.0 : kinetic;
      if (resting)
        std::fill(s_.motion.v.begin(), s_.motion.v.end(), 0.0);
      else
        for (std::size_t i = 0; i < size_; ++i) s_.motion.x[i] += dt * s_.motion.v[i];
    }
  }

  const ShellModel& m_;
  ShellState& s_;
  const RelaxationRules& rules_;
  Balance balance_;
  std::size_t size_;
  double furthest_ = 0.0;  // the shell's size, to limit steps [m]
  FreeDegrees free_;
  std::vector<double> last_;  // positions in the last equilibrium; before it, those at the start
  std::vector<double> mode_;
  RelaxationResult r_;
};

}  // namespace

RelaxationResult relax(const ShellModel& m, ShellState& s, const RelaxationRules& rules) {
  const RelaxationResult r = Search(m, s, rules).run();
  update_dropped_points(m.trim, s.motion.x);
  std::fill(s.motion.v.begin(), s.motion.v.end(), 0.0);
  compute_forces(m, s, false, s.layers.plastic.empty() ? 0.0 : 1.0,
                 rules.threads);  // without the weights; plastic strain stays
  return r;
}

}  // namespace sunder::shell
