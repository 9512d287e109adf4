// Pieces that have come off leave the shells.
#include <algorithm>
#include <cmath>

#include "shell/io/run.h"
#include "shell/solver/interlock.h"

namespace sunder::shell {
namespace {

constexpr double kSmallPiece = 30.0;  // spacings squared: too small to bend, leaves at once
constexpr double kSettleTime = 5e-5;  // a larger piece stays so long, its cracks may still branch [s]

double relative(double error, double scale) { return scale > 0.0 ? error / scale : error; }  // absolute at zero

}  // namespace

void Run::check_handoff(const Totals& before, const Totals& after, const RigidBody& b) {
  const Vec3 p = b.mass * b.motion.velocity;
  const Vec3 l = b.motion.angular_momentum + b.motion.position.cross(p);
  // relative to the sums' own magnitudes, which is what their round-off is relative to
  mass_error_ = std::max(mass_error_, relative(std::abs(after.mass + b.mass - before.mass), before.mass));
  momentum_error_ =
      std::max(momentum_error_, relative((after.momentum + p - before.momentum).norm(), before.momentum_scale));
  angular_error_ =
      std::max(angular_error_, relative((after.angular + l - before.angular).norm(), before.angular_scale));
}

std::vector<RigidBody> Run::take_off(bool all) {
  std::vector<RigidBody> births;
  fragments_ = 0, detached_area_ = 0.0;
  for (ShellPart& part : parts_) {
    take_off(part, all, births);
    fragments_ += part.fragments, detached_area_ += part.detached_area;
  }
  return births;
}

void Run::take_off(ShellPart& part, bool all, std::vector<RigidBody>& births) {
  const ShellModel& m = part.model();
  ShellState& s = *part.state;
  part.fragments = std::max(part.fragments, 1);
  if (s.cracks.edges().empty() && !all) return;
  Stopwatch w(stage_s_["crack_update"]);
  if (all) release_interlocks(m, s, {}, true);
  std::vector<Piece> pieces;
  const Triangulation t = partition(m, s, pieces);
  for (std::size_t i = 0; i < t.triangles.size(); ++i) {
    const auto& c = t.triangles[i];
    for (const Vec2& r : part.rubble)
      if (orientation(t.vertices[c[0]], t.vertices[c[1]], r) >= 0 &&
          orientation(t.vertices[c[1]], t.vertices[c[2]], r) >= 0 &&
          orientation(t.vertices[c[2]], t.vertices[c[0]], r) >= 0 && pieces[t.piece[i]].control_points.empty())
        pieces[t.piece[i]].gone = true;
  }
  part.fragments = t.pieces;
  double before = 0.0;
  bool any = false;
  // those without control points first: they take their mass and velocity from what is beside them
  std::vector<std::size_t> order;
  for (const bool empty : {true, false})
    for (std::size_t i = 0; i < pieces.size(); ++i)
      if (pieces[i].control_points.empty() == empty) order.push_back(i);
  for (const std::size_t i : order) {
    Piece& p = pieces[i];
    if (p.held || p.gone || p.interlocked) continue;
    if (t.pieces == 1 && !all) continue;  // nothing has separated: a free shell stays a shell
    if (!all && !p.control_points.empty() && p.area > kSmallPiece * m.spacing * m.spacing) {
      const auto [since, fresh] = part.detached_since.try_emplace(p.control_points[0], tick_);
      if (static_cast<double>(tick_ - since->second) * setup_.tick < kSettleTime) continue;
    }
    if (!any) before = total_energy(dt_), any = true;
    if (p.control_points.empty())
      for (std::size_t k = 0; k < t.triangles.size(); ++k)
        if (t.piece[k] == p.number) {
          const auto& c = t.triangles[k];
          part.rubble.push_back((t.vertices[c[0]] + t.vertices[c[1]] + t.vertices[c[2]]) / 3.0);
        }
    const Totals shell_before = totals(m, s);
    Handoff h = hand_off(m, s, t, p, next_id_++, dt_);
    check_handoff(shell_before, totals(m, s), h.body);
    const double mass = m.material.density * m.thickness * h.area;
    geometry_error_ = std::max(geometry_error_, std::abs(h.body.mass - mass) / mass);
    handed_area_ += h.area, ++handed_off_;
    shards_.push_back({h.body.id, time() + window_ticks_ * setup_.tick, h.area, h.body.mass,
                       h.body.motion.velocity.norm(),
                       static_cast<int>(std::get<ConvexShape>(h.body.shape).parts.size())});
    for (const int slot : h.donors) part.changed.push_back(m.parameter[m.tables.control_point(slot)]);
    p.gone = true;
    frames_.draw_as(h.body.id, std::move(h.drawn));
    births.push_back(h.body);
    proxies_.emplace_back(h.body);
    for (ShellPart& other : parts_)
      other.coefficients.push_back(against(other.model(), h.body)), other.candidates.age = 0;
  }
  part.detached_area = 0.0;
  for (const Piece& p : pieces)
    if (!p.held) part.detached_area += p.area;
  if (any) s.book.handoff += before - total_energy(dt_);
}

}  // namespace sunder::shell
