// When a shell has broken enough, and what follows: it is frozen, and the engine runs on alone.
#include <algorithm>
#include <cmath>

#include "shell/io/run.h"
#include "shell/solver/remains.h"

namespace sunder::shell {
namespace {

// Largest approach of two bodies that can meet in a window without a shell, as a share of the thickness. A longer window
// would depend on how far an engine looks ahead for contacts, which differs between engines.
constexpr double kSettleTravel = 1.25;
constexpr int kRigidSubsteps = 4;  // of free flight in a window without a shell

}  // namespace

bool Run::impact_ahead() const {
  return std::any_of(parts_.begin(), parts_.end(), [this](const ShellPart& part) { return impact_ahead(part); });
}

bool Run::impact_ahead(const ShellPart& part) const {
  const ShellModel& m = part.model();
  const ShellState& s = *part.state;
  const Eigen::AlignedBox3d box = part.box();
  for (std::size_t i = 0; i < setup_.bodies.size() && !box.isEmpty(); ++i) {
    const BodyMotion& b = proxies_[i].body.motion;
    if (proxies_[i].body.is_static) continue;
    const Vec3 pad = Vec3::Constant(proxies_[i].radius() + m.thickness);
    if (box.squaredExteriorDistance(b.position) <= pad.x() * pad.x()) {  // there: does it move beside the shell?
      const double reach = pad.x() + m.spacing + setup_.quiet_time * b.velocity.norm();
      for (int k = 0; k < m.control_points() && b.velocity.norm() > 0.0; ++k)
        if (!s.gone[m.tables.slot(k)] && (s.position(m.tables.slot(k)) - b.position).squaredNorm() <= reach * reach)
          return true;
      continue;
    }
    double from = 0.0, to = setup_.end_time - time();  // when its straight path is in the box
    for (int d = 0; d < 3; ++d) {
      const double low = box.min()[d] - pad[d] - b.position[d], high = box.max()[d] + pad[d] - b.position[d];
      const double v = b.velocity[d];
      if (v == 0.0 && (low > 0.0 || high < 0.0)) to = -1.0;
      if (v == 0.0) continue;
      from = std::max(from, std::min(low / v, high / v)), to = std::min(to, std::max(low / v, high / v));
    }
    if (from <= to) return true;
  }
  return false;
}

std::string Run::cracking_has_ended() {
  if (!soft_.empty() || fibres_) return "";  // they would go on against shells that stand still
  if (setup_.latest_freeze < setup_.end_time && time() >= setup_.latest_freeze * (1.0 - 1e-9)) return "latest_freeze_s";
  if (crack_length() == 0.0 || time() < setup_.last_change + setup_.quiet_time) return "";
  for (const ShellPart& part : parts_)
    for (const char done : part.state->cut_done)
      if (!done) return "";
  const double length = crack_length(), since = time() - setup_.quiet_time * (1.0 + 1e-9);
  crack_lengths_.emplace_back(time(), length);
  while (crack_lengths_.size() > 1 && crack_lengths_[1].first <= since) crack_lengths_.pop_front();
  const auto& [then, before] = crack_lengths_.front();
  if (then <= since + setup_.window && last_push_ <= since && length - before <= setup_.quiet_growth * length &&
      !impact_ahead())
    return fmt::format("cracks grew by {:.2g} of their length within {:g} s", 1.0 - before / length, setup_.quiet_time);
  return "";
}

void Run::freeze_shell(const std::string& why) {
  std::vector<RigidBody> births = take_off(true);
  const double before = total_energy(dt_);
  frozen_kinetic_ = 0.0, frozen_length_ = crack_length(), frozen_resistance_ = crack_resistance();
  const std::vector<PartPieces> now = pieces_now(true, everywhere());
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    const ShellModel& m = parts_[k].model();
    ShellState& s = *parts_[k].state;
    frozen_kinetic_ += kinetic_energy(m, s, dt_);
    frozen_potential_ += potential_energy(m, s, setup_.gravity);
    const Handoff frozen = freeze(m, s, *now[k].triangulation, now[k].pieces, next_id_++);
    const RigidBody& remains = frozen.body;
    if (!std::get<ConvexShape>(remains.shape).parts.empty()) {
      births.push_back(remains);
      frames_.draw_as(remains.id, frozen.drawn);
      proxies_.emplace_back(remains);
    }
    rubble_points_ += s.rubble();
  }
  book_ = book();
  frozen_hash_ = state_hash();
  frozen_at_ = time(), frozen_why_ = why;
  frozen_wall_ = wall_clock();
  for (ShellPart& part : parts_) part.state.reset();  // and with it whatever was exported
  book_.frozen += before - total_energy(dt_);
  open_window(window_ticks_ * setup_.tick);
  fly(window_ticks_ * setup_.tick, proxies_.size() - births.size());  // newborn bodies do not move in this window
  exchange(window_ticks_, window_ticks_ * setup_.tick, births);
}

std::int64_t Run::settle_ticks() const {
  const auto most = static_cast<std::int64_t>(std::llround(setup_.settle_window / setup_.tick));
  if (setup_.shells.empty() || most <= 1) return most;
  double thickness = setup_.shells[0].model.thickness;
  for (const ShellSetup& s : setup_.shells) thickness = std::min(thickness, s.model.thickness);
  const double travel = kSettleTravel * thickness;
  double longest = setup_.settle_window;
  for (std::size_t i = 0; i < proxies_.size(); ++i) {
    const RigidBody& a = proxies_[i].body;
    if (!std::isfinite(proxies_[i].radius())) continue;  // nothing passes through a half space
    for (std::size_t j = 0; j < i; ++j) {
      const RigidBody& b = proxies_[j].body;
      if (!std::isfinite(proxies_[j].radius()) || (a.is_static && b.is_static)) continue;
      const double gap = (a.motion.position - b.motion.position).norm() - proxies_[i].radius() - proxies_[j].radius();
      const double speed = (a.motion.velocity - b.motion.velocity).norm();
      if (speed * longest <= travel || gap > speed * longest) continue;
      longest = std::max(travel / speed, setup_.tick);
    }
  }
  return std::max<std::int64_t>(1, static_cast<std::int64_t>(longest / setup_.tick * (1.0 + 1e-9)));
}

void Run::fly(double window, std::size_t count) {
  const double h = window / kRigidSubsteps;
  for (std::size_t i = 0; i < count; ++i)
    for (int k = 0; k < kRigidSubsteps && !proxies_[i].body.is_static; ++k) {
      Proxy& p = proxies_[i];
      p.body.motion.velocity += h * setup_.gravity;
      p.body.drift(h);
      p.body.motion.position -= 0.5 * h * h * setup_.gravity;  // exact: the mean of both velocities
    }
}

void Run::rigid_window() {
  const int ticks = static_cast<int>(std::max<std::int64_t>(1, std::min(settle_ticks(), end_tick() - tick_)));
  const double window = this->ticks().time(ticks);
  open_window(window);
  fly(window, proxies_.size());
  exchange(ticks, window, {});
  const double energy = total_energy(0.0);
  close_books(energy + book_.lost() + engine_loss_);
}

}  // namespace sunder::shell
