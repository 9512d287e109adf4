// How a window is shared with the rigid side: what is exported, what is handed back, what is checked.
#include <algorithm>
#include <cmath>
#include <set>

#include "coupler/core/error.h"
#include "shell/run/run.h"
#include "shell/solver/contact/contact_stiffness.h"
#include "shell/solver/contact/rigid_contact.h"

namespace sunder::shell {
namespace {

using Scheme = CouplingRules::Scheme;

// Of the sum of |J|, and what a body gained also of its momentum; double precision leaves some 1e-15.
constexpr double kLedgerTolerance = 1e-12;
constexpr double kSubstepsRounded = 4000.0;  // each may leave a rounding: beyond as many the tolerance grows with them
constexpr double kSingleTolerance = 1e-4;    // of engines that say that they round, as in conformance
constexpr int kStiffnessEvery = 8;           // windows between two measurements
constexpr int kHeldWindows = 64;             // that a body counts as held by the engine, or stays exported, afterwards
constexpr double kRecovery = 0.02;           // twenty plates on the first sink in by 2 um, and nothing bounces
constexpr double kAgreed = 1e-9;             // change of the engine's impulses between two passes, of themselves
constexpr double kFastestRelaxation = 2.0, kSlowestRelaxation = 0.02, kFirstRelaxation = 0.5;
constexpr double kLeastResidual = 1.0 / 16.0;  // of the tolerance, below which a window is doubled

double relative(double error, double scale) { return scale > 0.0 ? error / scale : error; }  // absolute at zero

// Where a body comes by itself in `h`: gravity evenly, no impulse.
BodyMotion coasted(const RigidBody& body, const Vec3& gravity, double h) {
  RigidBody b = body;
  b.motion.velocity += 0.5 * h * gravity;
  b.drift(h);
  b.motion.velocity += 0.5 * h * gravity;
  return b.motion;
}

}  // namespace

std::vector<link::Motion> Run::motions() const {
  std::vector<link::Motion> out;
  for (const Proxy& p : proxies_)
    if (!p.body.is_static) out.push_back({p.body.id, p.body.motion});
  return out;
}

void Run::choose_exported() {
  const CouplingRules& rules = setup_.coupling;
  const bool can = rigid_->peer().can(link::capability::kExportRows);  // else it is measured, and told
  if (rules.scheme != Scheme::kProxy && rules.scheme != Scheme::kExported) return;
  if (rules.scheme == Scheme::kExported) {
    for (std::size_t i = 0; i < setup_.bodies.size(); ++i)
      if (!setup_.bodies[i].is_static) exported_until_[setup_.bodies[i].id] = windows_ + 1;
    return;
  }
  if (windows_ % kStiffnessEvery != 0) return;
  std::vector<double> hardness(proxies_.size(), 0.0);
  for (ShellPart& part : parts_) add_hardness(part, hardness);
  add_soft_hardness(hardness);
  for (std::size_t i = 0; i < proxies_.size(); ++i) {
    hardest_ = std::max(hardest_, hardness[i]);
    if (can && hardness[i] > rules.export_above) exported_until_[proxies_[i].body.id] = windows_ + kHeldWindows;
  }
}

void Run::add_hardness(ShellPart& part, std::vector<double>& hardness) {
  const ShellModel& m = part.model();
  std::vector<char> asked(proxies_.size(), 0);
  bool any = false;
  // No shell is stiffer at a control point than its stable step allows: 4 m / dt^2. Heavy bodies need no measurement.
  double heaviest = 0.0;
  for (const double mass : part.state->motion.mass) heaviest = std::max(heaviest, mass);
  // Bodies of the scene only: shards, light and born in contact, leave the shell within a window or two.
  const auto& candidates = part.candidates.of_body;
  for (std::size_t i = 0; i < std::min(setup_.bodies.size(), candidates.size()); ++i) {
    const RigidBody& b = proxies_[i].body;
    const auto held = held_until_.find(b.id);
    if (b.is_static || candidates[i].empty() || held == held_until_.end() || held->second < windows_) continue;
    const double points = static_cast<double>(candidates[i].size() * m.patch.functions());
    const double bound = 4.0 * points * heaviest * std::pow(setup_.window / part.smallest_step, 2) / b.mass;
    asked[i] = bound > setup_.coupling.export_above, any = any || asked[i];
  }
  if (!any) return;
  const auto stiffness = contact_stiffness(m, *part.state, proxies_, part.candidates, asked, options_.threads);
  for (std::size_t i = 0; i < proxies_.size(); ++i)
    if (asked[i]) hardness[i] += stiffness[i] * setup_.window * setup_.window / proxies_[i].body.mass;
}

void Run::open_window(double window) {
  starts_ = motions();
  for (Proxy& p : proxies_) p.unmoved = setup_.coupling.scheme == Scheme::kLagged, p.recovery = 0.0;
  solved_.clear();
  if (!solving()) {  // no substeps: nobody but the engine solves anything
    rows_.clear(), exported_until_.clear();
    return;
  }
  choose_exported();
  std::set<BodyId> exported;
  for (const auto& [id, until] : exported_until_)
    if (until > windows_) exported.insert(id);
  if (exported.empty()) {
    rows_.clear();
    return;
  }
  Stopwatch w(stage_s_["coupling"]);
  std::vector<link::Motion> coasting;
  std::set<BodyId> moving;
  for (const Proxy& p : proxies_)
    if (!p.body.is_static)
      coasting.push_back({p.body.id, coasted(p.body, setup_.gravity, window)}), moving.insert(p.body.id);
  // What an exported body touches or is linked to is solved with it, and what that touches.
  std::vector<link::ContactRow> rows;
  std::vector<Joint> joints;
  for (std::size_t before = 0; before != exported.size();) {
    before = exported.size();
    solved_.assign(exported.begin(), exported.end());
    rows = rigid_->rows(tick_, window, coasting, solved_);
    for (const auto& row : rows)
      for (const BodyId id : {row.first, row.second})
        if (moving.count(id)) exported.insert(id);
    joints.clear();
    for (const Joint& j : setup_.joints) {
      if (let_go_s_[j.id - 1] >= 0.0 || (!exported.count(j.first) && !exported.count(j.second))) continue;
      joints.push_back(j);
      for (const BodyId id : {j.first, j.second})
        if (moving.count(id)) exported.insert(id);
    }
  }
  std::vector<RigidBody*> bodies;
  for (Proxy& p : proxies_) bodies.push_back(&p.body);
  rows_.take(rows, joints, bodies);
  // What nothing presses on moves as without windows, to the last bit but some.
  std::set<BodyId> pressed;
  for (const auto& row : rows) pressed.insert({row.first, row.second});
  for (const Joint& j : joints) pressed.insert({j.first, j.second});
  for (Proxy& p : proxies_)
    if (exported.count(p.body.id) && pressed.count(p.body.id)) p.recovery = kRecovery;
  for (const BodyId id : exported) ever_exported_.insert(id);
  ++exported_windows_;
}

void Run::share_kick(double share) {
  for (std::size_t i = 0, k = 0; i < proxies_.size() && k < kicks_.size(); ++i) {
    RigidBody& b = proxies_[i].body;
    if (b.is_static) continue;
    b.motion.velocity += share / b.mass * kicks_[k].linear;
    b.motion.angular_momentum += share * kicks_[k].angular;
    ++k;
  }
}

std::vector<link::Motion> Run::handbacks(double window, std::size_t count, int substeps) const {
  std::vector<link::Motion> out;
  for (std::size_t i = 0, k = 0; i < count; ++i) {
    RigidBody b = proxies_[i].body;
    if (b.is_static) continue;
    if (setup_.coupling.scheme == Scheme::kStaggered && k < starts_.size()) {  // the engine's own step, by the impulse
      b.motion.position = starts_[k].motion.position + window * b.motion.velocity;
      b.motion.orientation = starts_[k].motion.orientation;
      RigidBody turned = b;
      turned.drift(window);
      b.motion.orientation = turned.motion.orientation;
    }
    if (k < kicks_.size() && substeps > 0) {  // without what the engine's last answer did, evenly over the substeps
      const double arm = 0.5 * window * (substeps + 1.0) / substeps;
      b.motion.position -= arm / b.mass * kicks_[k].linear;
      b.motion.orientation =
          (rotation_from_vector(-arm * b.apply_inverse_inertia(kicks_[k].angular)) * b.motion.orientation).normalized();
      b.motion.velocity -= kicks_[k].linear / b.mass;
      b.motion.angular_momentum -= kicks_[k].angular;
    }
    out.push_back({b.id, b.motion});
    ++k;
  }
  return out;
}

void Run::iterate_window(int n, double dt) {
  struct Snapshot {
    std::vector<ShellState> states;
    std::vector<ContactCandidates> candidates;
    Stitching stitching;
    std::vector<Proxy> proxies;
    std::uint64_t random;
    std::int64_t substeps;
    double engine_loss;
  };
  Snapshot start{{}, {}, stitching_, proxies_, random_, substeps_, engine_loss_};
  for (const ShellPart& part : parts_) {
    part.state->caches.trials.clear(), part.state->caches.surroundings = {};  // they can be found again
    start.states.push_back(*part.state), start.candidates.push_back(part.candidates);
  }
  const double window = n * dt;
  std::vector<Kick> last;
  double relaxation = kFirstRelaxation;
  for (int pass = 0;; ++pass) {
    if (shell_contact_) shell_contact_->forget();
    take_substeps(n, dt);
    answered_ = handbacks(window, proxies_.size(), n);
    agreed_ = rigid_->window({tick_, window_ticks_, window, answered_, {}, {}, pass > 0, released_});
    most_passes_ = std::max(most_passes_, pass + 1), ++passes_;
    std::vector<Kick> residual;
    double size = 0.0, scale = 0.0, dot = 0.0, difference = 0.0;
    kicks_.resize(agreed_.size());
    for (std::size_t k = 0, i = 0; i < proxies_.size(); ++i) {
      const RigidBody& b = proxies_[i].body;
      if (b.is_static) continue;
      const BodyMotion &from = answered_[k].motion, &to = agreed_[k].motion;
      const Kick engine{b.mass * (to.velocity - from.velocity), to.angular_momentum - from.angular_momentum};
      const Kick r{engine.linear - kicks_[k].linear, engine.angular - kicks_[k].angular};
      const double gyration = std::sqrt(b.principal_inertia.maxCoeff() / b.mass);  // makes both commensurate
      const auto product = [&](const Kick& a, const Kick& c) {
        return a.linear.dot(c.linear) + a.angular.dot(c.angular) / (gyration * gyration);
      };
      size += product(r, r), scale += product(engine, engine);
      if (!last.empty()) {
        const Kick d{r.linear - last[k].linear, r.angular - last[k].angular};
        dot += product(last[k], d), difference += product(d, d);
      }
      residual.push_back(r), ++k;
    }
    if (size <= kAgreed * kAgreed * scale || pass + 1 >= setup_.coupling.iterations) break;
    if (!last.empty() && difference > 0.0) {  // Aitken
      relaxation = std::clamp(-relaxation * dot / difference, -kFastestRelaxation, kFastestRelaxation);
      if (std::abs(relaxation) < kSlowestRelaxation) relaxation = kSlowestRelaxation;
    }
    for (std::size_t k = 0; k < kicks_.size(); ++k)
      kicks_[k].linear += relaxation * residual[k].linear, kicks_[k].angular += relaxation * residual[k].angular;
    last = residual;
    for (std::size_t p = 0; p < parts_.size(); ++p)
      *parts_[p].state = start.states[p], parts_[p].candidates = start.candidates[p];
    stitching_ = start.stitching, proxies_ = start.proxies, random_ = start.random, substeps_ = start.substeps,
    engine_loss_ = start.engine_loss;
  }
}

void Run::exchange(int ticks, double window, const std::vector<RigidBody>& births) {
  Stopwatch w(stage_s_["coupling"]);
  const std::size_t old = proxies_.size() - births.size();
  const double before = bodies_energy();
  std::vector<link::State> states;
  std::vector<link::Motion> given;
  if (!agreed_.empty()) {  // the window has been taken; what was born joins now
    given = std::move(answered_), states = std::move(agreed_);
    agreed_.clear(), answered_.clear(), kicks_.clear();
    if (!births.empty())
      for (const link::State& s : rigid_->add_bodies(births)) states.push_back(s);
  } else {
    given = handbacks(window, old, 0);
    states = rigid_->window({tick_, ticks, window, given, solved_, births, false, released_});
  }
  check_births(births, states);
  window_residual_ = 0.0;
  std::size_t k = 0;
  for (Proxy& p : proxies_) {
    if (p.body.is_static) continue;
    const BodyMotion& now = states[k].motion;
    if (k < given.size()) {
      const BodyMotion& then = given[k].motion;
      const Vec3 dv = now.velocity - then.velocity;
      const Vec3 dw = p.body.apply_inverse_inertia(now.angular_momentum - then.angular_momentum);
      // the work that the shell's push would have done on what the engine has changed
      window_residual_ += std::abs(p.linear_impulse.dot(dv) + p.angular_impulse.dot(dw));
      const bool exported = p.recovery > 0.0 && !rows_.empty();  // the engine has nothing left to hold it by
      if (exported || !dv.isZero(0.0) || !dw.isZero(0.0)) held_until_[p.body.id] = windows_ + kHeldWindows;
    }
    p.body.motion = now;
    ++k;
  }
  engine_loss_ += before - bodies_energy();
  residual_sum_ += window_residual_, residual_max_ = std::max(residual_max_, window_residual_);
  for (Proxy& p : proxies_) {
    if (p.unmoved && !p.body.is_static && p.impulse_sum > 0.0) {  // felt a window late
      p.body.motion.velocity += p.linear_impulse / p.body.mass;
      p.body.motion.angular_momentum += p.angular_impulse;
    }
    p.linear_impulse = p.angular_impulse = p.shell_linear = p.shell_angular = Vec3::Zero();
    p.impulse_sum = p.moment_sum = 0.0;
  }
  tick_ += ticks;
  ++windows_;
  let_joints_go();
}

void Run::adapt_window() {
  const CouplingRules& rules = setup_.coupling;
  if (rules.tolerance <= 0.0 || energy_scale_ <= 0.0) return;
  const double residual = window_residual_ / energy_scale_;
  if (residual > rules.tolerance && window_ticks_ > 1)
    window_ticks_ /= 2;
  else if (residual < kLeastResidual * rules.tolerance && 2 * window_ticks_ <= rules.ticks &&
           tick_ % (2 * window_ticks_) == 0)
    window_ticks_ *= 2;
  shortest_window_ = std::min(shortest_window_, window_ticks_);
}

void Run::check_ledger(double window) {
  if (options_.tamper) options_.tamper(windows_, proxies_);
  const double roundings = std::max(1.0, window / dt_ / kSubstepsRounded);
  std::size_t moving = 0;
  for (Proxy& p : proxies_) {
    const std::size_t k = p.body.is_static ? starts_.size() : moving++;
    double linear = 0.0, angular = 0.0;
    if (p.impulse_sum != 0.0) {
      linear = (p.linear_impulse + p.shell_linear).norm() / p.impulse_sum;
      angular = relative((p.angular_impulse + p.shell_angular).norm(), p.moment_sum);
    }
    if (k < starts_.size() && !(p.recovery > 0.0 && !rows_.empty())) {  // else rows have moved it as well
      const BodyMotion &then = starts_[k].motion, &now = p.body.motion;
      Vec3 gained = p.body.mass * (now.velocity - then.velocity - window * setup_.gravity);
      Vec3 turned = now.angular_momentum - then.angular_momentum;
      if (k < kicks_.size()) gained -= kicks_[k].linear, turned -= kicks_[k].angular;
      if (!p.unmoved) gained -= p.linear_impulse, turned -= p.angular_impulse;
      const double fall = window * setup_.gravity.norm(), scale = then.velocity.norm() + now.velocity.norm() + fall;
      const double turning = then.angular_momentum.norm() + now.angular_momentum.norm();
      // the new value first: max() keeps a first one that is not a number
      linear = std::max(relative(gained.norm(), p.impulse_sum + p.body.mass * scale) / roundings, linear);
      angular = std::max(relative(turned.norm(), p.moment_sum + turning) / roundings, angular);
    }
    ledger_linear_ = std::max(linear, ledger_linear_), ledger_angular_ = std::max(angular, ledger_angular_);
    if (!(linear <= kLedgerTolerance && angular <= kLedgerTolerance)) {  // NaN fails too
      Error e(Exit::kPhysics, "ledger",
              fmt::format(
                  "window {}: what the shell lost, body '{}' did not gain: {:.3g} linear, {:.3g} angular of {:.3g} N s",
                  windows_, p.body.name, linear, angular, p.impulse_sum));
      e.window = windows_, e.body = p.body.name;
      throw e;
    }
  }
}

void Run::check_birth(const RigidBody& b, double mass, double linear, double angular, double tolerance,
                      const char* where) {
  mass_error_ = std::max(mass, mass_error_), momentum_error_ = std::max(linear, momentum_error_),
  angular_error_ = std::max(angular, angular_error_);
  if (mass <= tolerance && linear <= tolerance && angular <= tolerance) return;  // NaN is not
  Error e(Exit::kPhysics, "ledger",
          fmt::format("window {}: the birth of '{}' {}: {:.3g} of its mass, {:.3g} of its momentum and {:.3g} of its "
                      "angular momentum are missing",
                      windows_, b.name, where, mass, linear, angular));
  e.window = windows_, e.body = b.name;
  throw e;
}

void Run::check_births(const std::vector<RigidBody>& births, const std::vector<link::State>& states) {
  const bool exact = rigid_->peer().can(link::capability::kDoublePrecision);
  for (const RigidBody& b : births)
    for (const link::State& s : states) {
      if (s.id != b.id || b.is_static) continue;
      const Vec3 momentum = b.mass * b.motion.velocity;
      const double scale = std::max(momentum.norm(), 1e-12), turn = std::max(b.motion.angular_momentum.norm(), 1e-12);
      check_birth(b, std::abs(s.mass - b.mass) / b.mass, (s.mass * s.motion.velocity - momentum).norm() / scale,
                  (s.motion.angular_momentum - b.motion.angular_momentum).norm() / turn,
                  exact ? kBirthTolerance : kSingleTolerance, "in the engine");
    }
}

}  // namespace sunder::shell
