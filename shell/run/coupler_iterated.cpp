// Scheme ITERATED: both sides repeat a window until they agree.
#include <algorithm>
#include <cmath>

#include "shell/run/coupler.h"

namespace sunder::shell {
namespace {

constexpr double kAgreed = 1e-9;  // passes end below this relative change of the engine's impulses
// limits and start of Aitken's factor [-]
constexpr double kFastestRelaxation = 2.0, kSlowestRelaxation = 0.02, kFirstRelaxation = 0.5;

}  // namespace

void Coupler::iterate_window(int n, double dt, double last, const std::function<void()>& look) {
  struct Snapshot {
    std::vector<ShellState> states;
    std::vector<ContactCandidates> candidates;
    Stitching stitching;
    std::vector<double> shell_impulse;
    std::vector<Proxy> proxies;
    std::uint64_t random;
    std::int64_t substeps;
    double engine_loss, contact_taken;
  };
  Snapshot start{{},
                 {},
                 state_.stitching,
                 state_.shell_impulse,
                 state_.bodies,
                 state_.random,
                 state_.substeps,
                 state_.engine_loss,
                 state_.contact ? state_.contact->taken() : 0.0};
  for (const ShellPart& part : state_.shells) {
    part.state->caches.trials.clear(), part.state->caches.surroundings = {};  // not copied: they are computed again
    start.states.push_back(*part.state), start.candidates.push_back(part.candidates);
  }
  const double window = n * dt;
  std::vector<Kick> before;
  double relaxation = kFirstRelaxation;
  for (int pass = 0;; ++pass) {
    if (state_.contact) state_.contact->forget();
    simulation_.take_substeps(n, dt, last, clock_, look);
    sent_ = predicted_states(window, state_.bodies.size(), n);
    agreed_ = rigid_->window({clock_.tick, window_ticks_, window, sent_, {}, {}, pass > 0, released_});
    most_passes_ = std::max(most_passes_, pass + 1), ++passes_;
    std::vector<Kick> residual;
    double size = 0.0, scale = 0.0, dot = 0.0, difference = 0.0;
    state_.kicks.resize(agreed_.size());
    for (std::size_t k = 0, i = 0; i < state_.bodies.size(); ++i) {
      const RigidBody& b = state_.bodies[i].body;
      if (b.is_static) continue;
      const BodyMotion &from = sent_[k].motion, &to = agreed_[k].motion;
      const Kick engine{b.mass * (to.velocity - from.velocity), to.angular_momentum - from.angular_momentum};
      const Kick r{engine.linear - state_.kicks[k].linear, engine.angular - state_.kicks[k].angular};
      // radius of gyration: gives linear and angular impulses one unit
      const double gyration = std::sqrt(b.principal_inertia.maxCoeff() / b.mass);
      const auto product = [&](const Kick& a, const Kick& c) {
        return a.linear.dot(c.linear) + a.angular.dot(c.angular) / (gyration * gyration);
      };
      size += product(r, r), scale += product(engine, engine);
      if (!before.empty()) {
        const Kick d{r.linear - before[k].linear, r.angular - before[k].angular};
        dot += product(before[k], d), difference += product(d, d);
      }
      residual.push_back(r), ++k;
    }
    if (size <= kAgreed * kAgreed * scale || pass + 1 >= setup_.coupling.iterations) break;
    if (!before.empty() && difference > 0.0) {  // Aitken's relaxation
      relaxation = std::clamp(-relaxation * dot / difference, -kFastestRelaxation, kFastestRelaxation);
      if (std::abs(relaxation) < kSlowestRelaxation) relaxation = kSlowestRelaxation;
    }
    for (std::size_t k = 0; k < state_.kicks.size(); ++k)
      state_.kicks[k].linear += relaxation * residual[k].linear,
          state_.kicks[k].angular += relaxation * residual[k].angular;
    before = residual;
    for (std::size_t p = 0; p < state_.shells.size(); ++p)
      *state_.shells[p].state = start.states[p], state_.shells[p].candidates = start.candidates[p];
    state_.stitching = start.stitching, state_.shell_impulse = start.shell_impulse, state_.bodies = start.proxies,
    state_.random = start.random, state_.substeps = start.substeps, state_.engine_loss = start.engine_loss;
    if (state_.contact) state_.contact->go_on_from(start.contact_taken);
  }
}

}  // namespace sunder::shell
