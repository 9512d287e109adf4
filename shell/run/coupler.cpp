#include "shell/run/coupler.h"

#include <algorithm>
#include <cmath>

#include "coupler/core/error.h"
#include "shell/solver/contact/contact_stiffness.h"

namespace sunder::shell {
namespace {

using Scheme = CouplingRules::Scheme;

constexpr int kStiffnessEvery = 8;  // windows between two measurements of stiffness
// A body with a prescribed motion at speed v hits free bodies of mass m. An elastic impact on all of them takes at most
// 2 m v from it; the margin is a factor of two. A larger loss in the engine means that it touches a body that does not
// give way, directly or through a free body.
constexpr double kGivesWay = 4.0;    // [free masses times the largest speed]
constexpr double kUntouched = 1e-9;  // [largest speed]: round-off
// A body that another one hits is at most twice as fast as that one; the margin is a factor of two.
constexpr double kLongestWay = 4.0;        // [largest speed times the window]
constexpr int kHeavyEvery = 8;             // windows between two looks for heavy bodies on light ones
constexpr int kNearEvery = 16;             // windows between two looks how near bodies are to shells
constexpr int kHeldWindows = 64;           // windows for which a body counts as held by the engine, or stays exported
constexpr std::int64_t kHeldAtFirst = 64;  // windows at the start in which every body counts as held
// share of an overlap per substep: twenty stacked plates sink by 2 um, and none bounces
constexpr double kRecovery = 0.02;
constexpr double kLeastResidual = 1.0 / 16.0;  // share of the tolerance; below it the window is doubled

/// Returns the motion after `h` [s] of free flight: gravity evenly, no impulse.
BodyMotion coasted(const RigidBody& body, const Vec3& gravity, double h) {
  RigidBody b = body;
  b.motion.velocity += 0.5 * h * gravity;
  b.drift(h);
  b.motion.velocity += 0.5 * h * gravity;
  return b.motion;
}

// Throws Error where the engine has moved a body further than any collision could: by more than `most` [m] and its own
// size.
void check_way(const link::Motion& from, const BodyMotion& to, const Proxy& body, double most) {
  const double way = (to.position - from.motion.position).norm();
  if (way <= most + 2.0 * body.radius()) return;
  Error e(
      Exit::kPeerLost, "bad_message",
      fmt::format(
          "states[id {}].position: the body has moved by {:.3g} m in the window, and at its speed it moves by {:.3g} "
          "m at most; the engine gives another place than its own motion leads to",
          body.body.id, way, most));
  e.body = std::to_string(body.body.id);
  throw e;
}

}  // namespace

Coupler::Coupler(const RunSetup& setup, Simulation& simulation, Clock& clock,
                 std::function<void(std::int64_t, std::vector<Proxy>&)> tamper)
    : setup_(setup),
      simulation_(simulation),
      state_(simulation.state),
      clock_(clock),
      tamper_(std::move(tamper)),
      window_ticks_(setup.coupling.ticks),
      shortest_window_(setup.coupling.ticks),
      released_at_(setup.joints.size(), -1.0) {}

std::vector<RigidBody> Coupler::held_by_engine(const std::vector<RigidBody>& bodies) const {
  std::vector<RigidBody> held;
  for (std::size_t i = 0; i < bodies.size(); ++i)
    if (!state_.bodies[i].deforms()) held.push_back(bodies[i]);
  return held;
}

void Coupler::load() {
  const bool again = setup_.coupling.scheme == Scheme::kIterated;
  rigid_->load({held_by_engine(setup_.bodies), setup_.laws, setup_.joints, 0, again, setup_.thickness()});
  for (const RigidBody& b : setup_.bodies) held_until_[b.id] = kHeldAtFirst;
}

void Coupler::restore(const std::string& caches) {
  std::vector<RigidBody> bodies;
  for (const Proxy& p : state_.bodies) {
    bodies.push_back(p.body);
    const auto own = engine_motions_.find(p.body.id);
    if (own != engine_motions_.end()) bodies.back().motion = own->second;
  }
  const bool again = setup_.coupling.scheme == Scheme::kIterated;
  rigid_->load({held_by_engine(bodies), setup_.laws, setup_.joints, clock_.tick, again, setup_.thickness()});
  rigid_->restore(caches);
}

std::vector<link::Motion> Coupler::motions() const {
  std::vector<link::Motion> out;
  for (const Proxy& p : state_.bodies)
    if (!p.body.is_static) out.push_back({p.body.id, p.body.motion});
  return out;
}

void Coupler::choose_exported() {
  const CouplingRules& rules = setup_.coupling;
  // without it the ratio is still measured and reported
  const bool can = rigid_->peer().can(link::capability::kExportRows);
  if (rules.scheme != Scheme::kProxy && rules.scheme != Scheme::kExported) return;
  if (rules.scheme == Scheme::kExported) {
    for (std::size_t i = 0; i < setup_.bodies.size(); ++i)
      if (state_.bodies[i].is_free()) exported_until_[setup_.bodies[i].id] = clock_.windows + 1;
    return;
  }
  if (clock_.windows % kStiffnessEvery != 0) return;
  std::vector<double> ratio(state_.bodies.size(), 0.0);
  for (ShellPart& part : state_.shells) add_stiffness_ratio(part, ratio);
  add_soft_stiffness_ratio(ratio);
  for (std::size_t i = 0; i < state_.bodies.size(); ++i) {
    stiffest_ = std::max(stiffest_, ratio[i]);
    if (can && ratio[i] > rules.export_above) exported_until_[state_.bodies[i].body.id] = clock_.windows + kHeldWindows;
  }
}

void Coupler::add_stiffness_ratio(ShellPart& part, std::vector<double>& ratio) {
  const ShellModel& m = part.model();
  std::vector<char> asked(state_.bodies.size(), 0);
  bool any = false;
  // The stable step bounds the stiffness at any control point by 4 m / dt^2, so heavy bodies need no measurement.
  double heaviest = 0.0;
  for (const double mass : part.state->motion.mass) heaviest = std::max(heaviest, mass);
  // Only bodies of the scene are measured: shards are light, touch at birth, and leave the shell within a few windows.
  const auto& candidates = part.candidates.of_body;
  for (std::size_t i = 0; i < std::min(setup_.bodies.size(), candidates.size()); ++i) {
    const RigidBody& b = state_.bodies[i].body;
    const auto held = held_until_.find(b.id);
    if (!state_.bodies[i].is_free() || candidates[i].empty() || held == held_until_.end() ||
        held->second < clock_.windows)
      continue;
    const double points = static_cast<double>(candidates[i].size() * m.patch.functions());
    const double bound = 4.0 * points * heaviest * std::pow(setup_.window / part.smallest_step, 2) / b.mass;
    asked[i] = bound > setup_.coupling.export_above, any = any || asked[i];
  }
  if (!any) return;
  const auto stiffness =
      contact_stiffness(m, *part.state, state_.bodies, part.candidates, asked, simulation_.model.threads);
  for (std::size_t i = 0; i < state_.bodies.size(); ++i)
    if (asked[i]) ratio[i] += stiffness[i] * setup_.window * setup_.window / state_.bodies[i].body.mass;
}

void Coupler::add_soft_stiffness_ratio(std::vector<double>& ratio) const {
  if (state_.soft.empty()) return;
  for (std::size_t i = 0; i < std::min(setup_.bodies.size(), state_.bodies.size()); ++i) {
    const RigidBody& b = state_.bodies[i].body;
    const auto held = held_until_.find(b.id);
    if (!state_.bodies[i].is_free() || held == held_until_.end() || held->second < clock_.windows) continue;
    ratio[i] += state_.soft.stiffness_against(state_.bodies[i]) * setup_.window * setup_.window / b.mass;
  }
}

void Coupler::open_window(double window) {
  starts_ = motions();
  for (Proxy& p : state_.bodies) p.unmoved = setup_.coupling.scheme == Scheme::kLagged, p.recovery = 0.0;
  solved_.clear();
  if (!state_.solving()) {  // without substeps, only the engine solves contacts
    state_.rows.clear(), exported_until_.clear();
    return;
  }
  choose_exported();
  std::set<BodyId> exported;
  for (const auto& [id, until] : exported_until_)
    if (until > clock_.windows) exported.insert(id);
  if (exported.empty()) {
    state_.rows.clear();
    return;
  }
  Stopwatch w(simulation_.scratch.times[Stage::kCoupling]);
  std::vector<link::Motion> coasting;
  std::set<BodyId> moving;
  for (const Proxy& p : state_.bodies) {
    if (p.body.is_static) continue;
    Proxy ahead = p;
    ahead.arrive(clock_.time() + window);
    coasting.push_back({p.body.id, p.is_free() ? coasted(p.body, setup_.gravity, window) : ahead.body.motion});
    if (p.is_free()) moving.insert(p.body.id);
  }
  // All bodies that touch an exported body or are linked to it are exported too, until the set no longer grows.
  std::vector<link::ContactRow> rows;
  std::vector<Joint> joints;
  for (std::size_t before = 0; before != exported.size();) {
    before = exported.size();
    solved_.assign(exported.begin(), exported.end());
    rows = rigid_->rows(clock_.tick, window, coasting, solved_);
    for (const auto& row : rows)
      for (const BodyId id : {row.first, row.second})
        if (moving.count(id)) exported.insert(id);
    joints.clear();
    for (const Joint& j : setup_.joints) {
      if (released_at_[j.id - 1] >= 0.0 || (!exported.count(j.first) && !exported.count(j.second))) continue;
      joints.push_back(j);
      for (const BodyId id : {j.first, j.second})
        if (moving.count(id)) exported.insert(id);
    }
  }
  std::erase_if(rows, [&](const link::ContactRow& r) { return !moving.count(r.first) && !moving.count(r.second); });
  std::vector<RigidBody*> bodies;
  for (Proxy& p : state_.bodies) bodies.push_back(&p.body);
  state_.rows.take(rows, joints, bodies);
  // A body without contacts and joints moves as it would without windows, except for the last bits.
  std::set<BodyId> pressed;
  for (const auto& row : rows) pressed.insert({row.first, row.second});
  for (const Joint& j : joints) pressed.insert({j.first, j.second});
  for (Proxy& p : state_.bodies)
    if (exported.count(p.body.id) && pressed.count(p.body.id)) p.recovery = kRecovery;
  for (const BodyId id : exported) ever_exported_.insert(id);
  ++exported_windows_;
}

std::vector<link::Motion> Coupler::predicted_states(double window, std::size_t count, int substeps) const {
  std::vector<link::Motion> out;
  for (std::size_t i = 0, k = 0; i < count; ++i) {
    RigidBody b = state_.bodies[i].body;
    if (b.is_static) continue;
    // the engine takes a step of its own with the impulse
    if (setup_.coupling.scheme == Scheme::kStaggered && k < starts_.size()) {
      b.motion.position = starts_[k].motion.position + window * b.motion.velocity;
      b.motion.orientation = starts_[k].motion.orientation;
      RigidBody turned = b;
      turned.drift(window);
      b.motion.orientation = turned.motion.orientation;
    }
    if (k < state_.kicks.size() &&
        substeps > 0) {  // removes the engine's last answer, which was spread evenly over the substeps
      const double arm = 0.5 * window * (substeps + 1.0) / substeps;
      b.motion.position -= arm / b.mass * state_.kicks[k].linear;
      b.motion.orientation =
          (rotation_from_vector(-arm * b.apply_inverse_inertia(state_.kicks[k].angular)) * b.motion.orientation)
              .normalized();
      b.motion.velocity -= state_.kicks[k].linear / b.mass;
      b.motion.angular_momentum -= state_.kicks[k].angular;
    }
    out.push_back({b.id, b.motion});
    ++k;
  }
  return out;
}

double Coupler::fastest_body(double window) const {
  double most = setup_.gravity.norm() * window;
  for (const Proxy& p : state_.bodies)
    if (!p.body.is_static)
      most = std::max(most, p.body.motion.velocity.norm() + (p.is_driven() ? p.top_speed() : p.turning_speed()));
  return most;
}

BodyId Coupler::blocked_body(const std::vector<BodyMotion>& kept, double fastest) const {
  double free_mass = 0.0, most = 0.0;
  for (const Proxy& p : state_.bodies)
    if (p.is_free()) free_mass += p.body.mass;
  BodyId blocked = 0;
  std::size_t next = 0;
  for (const Proxy& p : state_.bodies) {
    if (!p.is_driven() || p.body.is_static) continue;
    const BodyMotion &own = kept[next++], &now = p.body.motion;
    const Vec3 turned = p.body.apply_inverse_inertia(now.angular_momentum - own.angular_momentum);
    const double lost = (now.velocity - own.velocity).norm() + turned.norm() * p.radius();
    const double gives = kGivesWay * free_mass / p.body.mass + kUntouched;
    if (lost > gives * fastest && lost > most) blocked = p.body.id, most = lost;
  }
  return blocked;
}

void Coupler::exchange(int ticks, double window, const std::vector<RigidBody>& births) {
  Stopwatch w(simulation_.scratch.times[Stage::kCoupling]);
  const std::size_t old = state_.bodies.size() - births.size();
  const double before = simulation_.bodies_energy(), driven = state_.driven_energy(), fastest = fastest_body(window);
  std::vector<link::State> states;
  std::vector<link::Motion> given;
  if (!agreed_.empty()) {  // scheme ITERATED has taken the window already; new bodies join now
    given = std::move(sent_), states = std::move(agreed_);
    agreed_.clear(), sent_.clear(), state_.kicks.clear();
    if (!births.empty())
      for (const link::State& s : rigid_->add_bodies(births)) states.push_back(s);
  } else {
    given = predicted_states(window, old, 0);
    states = rigid_->window({clock_.tick, ticks, window, given, solved_, births, false, released_});
  }
  check_births(births, states);
  window_residual_ = 0.0;
  std::size_t k = 0;
  std::vector<BodyMotion> kept;  // of driven bodies
  for (Proxy& p : state_.bodies) {
    if (p.body.is_static) continue;
    const BodyMotion& now = states[k].motion;
    if (k < given.size() && p.is_free()) {
      const BodyMotion& then = given[k].motion;
      check_way(starts_[k], now, p, kLongestWay * (fastest + now.velocity.norm()) * window);
      const Vec3 dv = now.velocity - then.velocity;
      const Vec3 dw = p.body.apply_inverse_inertia(now.angular_momentum - then.angular_momentum);
      // Work of the shell's impulses on the change of motion that the engine made.
      window_residual_ += std::abs(p.linear_impulse.dot(dv) + p.angular_impulse.dot(dw));
      // its rows are solved here, so the engine shows no change
      const bool exported = p.recovery > 0.0 && !state_.rows.empty();
      if (exported || !dv.isZero(0.0) || !dw.isZero(0.0)) held_until_[p.body.id] = clock_.windows + kHeldWindows;
    }
    if (p.is_driven()) kept.push_back(p.body.motion), engine_motions_[p.body.id] = now;
    p.body.motion = now;
    ++k;
  }
  const BodyId blocked = kept.empty() ? 0 : blocked_body(kept, fastest);
  // Its own work is in what the free bodies gained: what was lost beside that is not known then.
  const double worked = blocked == 0 ? driven - state_.driven_energy() : simulation_.bodies_energy() - before;
  if (blocked != 0 && blocked_.first == 0) blocked_ = {blocked, clock_.time()};
  state_.engine_loss += before - simulation_.bodies_energy() + worked, state_.driven_work += worked;
  std::size_t next = 0;  // a driven body goes on as the scene says
  for (Proxy& p : state_.bodies)
    if (p.is_driven() && !p.body.is_static) p.body.motion = kept[next++];
  residual_sum_ += window_residual_, residual_max_ = std::max(residual_max_, window_residual_);
  note_touches(setup_, state_, near_);
  if (clock_.windows % kNearEvery == 0) look_how_near(setup_, state_, clock_.time() + window, near_);
  for (Proxy& p : state_.bodies) {
    if (p.unmoved && !p.body.is_static && p.impulse_sum > 0.0) {  // scheme LAGGED: the impulse acts a window late
      p.body.motion.velocity += p.linear_impulse / p.body.mass;
      p.body.motion.angular_momentum += p.angular_impulse;
    }
    p.linear_impulse = p.angular_impulse = p.shell_linear = p.shell_angular = Vec3::Zero();
    p.impulse_sum = p.moment_sum = 0.0;
  }
  if (clock_.windows % kHeavyEvery == 0 && !rigid_->peer().can(link::capability::kMassRatios) &&
      rigid_->peer().can(link::capability::kContact))
    look_for_heavy(state_.bodies, std::min(setup_.bodies.size(), state_.bodies.size()), setup_.gravity, window,
                   rigid_->peer().can(link::capability::kDoublePrecision), heavy_pair_);
  clock_.tick += ticks;
  ++clock_.windows;
  release_joints();
}

void Coupler::adapt_window(double energy_scale) {
  const CouplingRules& rules = setup_.coupling;
  if (rules.tolerance <= 0.0 || energy_scale <= 0.0) return;
  const double residual = window_residual_ / energy_scale;
  if (residual > rules.tolerance && window_ticks_ > 1)
    window_ticks_ /= 2;
  else if (residual < kLeastResidual * rules.tolerance && 2 * window_ticks_ <= rules.ticks &&
           clock_.tick % (2 * window_ticks_) == 0)
    window_ticks_ *= 2;
  shortest_window_ = std::min(shortest_window_, window_ticks_);
}

}  // namespace sunder::shell
