// When cracking of a shell has ended, and how it is frozen. After that only the engine runs.
#include <algorithm>
#include <cmath>

#include "shell/io/crack_lines.h"
#include "shell/run/flight.h"
#include "shell/run/pieces.h"
#include "shell/run/state_hash.h"
#include "shell/solver/forces.h"
#include "shell/solver/parting/remains.h"

namespace sunder::shell {

bool Pieces::impact_ahead() const {
  return std::any_of(state_.shells.begin(), state_.shells.end(),
                     [this](const ShellPart& part) { return impact_ahead(part); });
}

bool Pieces::impact_ahead(const ShellPart& part) const {
  const ShellModel& m = part.model();
  const ShellState& s = *part.state;
  const Eigen::AlignedBox3d box = part.box();
  for (std::size_t i = 0; i < setup_.bodies.size() && !box.isEmpty(); ++i) {
    const BodyMotion& b = state_.bodies[i].body.motion;
    if (state_.bodies[i].body.is_static) continue;
    const double pad = state_.bodies[i].radius() + m.largest_thickness();
    if (box.squaredExteriorDistance(b.position) <= pad * pad) {  // near: does it move along the shell?
      const double reach = pad + m.spacing + setup_.quiet_time * b.velocity.norm();
      for (int k = 0; k < m.control_points() && b.velocity.norm() > 0.0; ++k)
        if (!s.motion.detached[m.tables.slot(k)] &&
            (s.position(m.tables.slot(k)) - b.position).squaredNorm() <= reach * reach)
          return true;
      continue;
    }
    if (meets_box(box, pad, b.position, b.velocity, setup_.end_time - clock_.time())) return true;
  }
  return false;
}

bool Pieces::strike_ahead(const std::vector<PartPieces>& now, const Group& g) const {
  std::vector<Vec3> points;  // control points of the pieces
  Eigen::AlignedBox3d box;
  Vec3 momentum = Vec3::Zero();
  double mass = 0.0, across = 0.0;  // `across`: energy of a crack across the pieces [J]
  double apart = 0.0;               // of the surface from its control points, with half a thickness [m]
  for (const auto& [k, i] : g.members) {
    const ShellModel& m = state_.shells[k].model();
    const ShellState& s = *state_.shells[k].state;
    double thick = 0.0, counted = 0.0;  // factors of the thickness
    const auto count = [&](int point) {
      const int slot = m.tables.slot(point);
      if (m.varies()) thick += m.thickness_of_slot[slot], counted += 1.0;
      points.push_back(s.position(slot)), box.extend(points.back());
      if (s.motion.inverse_mass[slot] > 0.0)
        mass += s.motion.mass[slot], momentum += s.motion.mass[slot] * s.velocity(slot);
    };
    if (now[k].whole)
      for (int point = 0; point < m.control_points(); ++point) count(point);
    for (const int point : now[k].pieces[i].control_points) count(point);
    const double length = std::sqrt(now[k].pieces[i].area);
    const double thickness = counted > 0.0 ? thick / counted * m.thickness : m.thickness;
    if (m.material.strength > 0.0) across += m.material.fracture_energy * thickness * length;
    apart = std::max(apart, m.spacing + 0.5 * m.largest_thickness());
  }
  if (across == 0.0 || mass == 0.0) return false;
  const double time = setup_.latest_freeze - clock_.time();
  for (std::size_t i = 0; i < setup_.bodies.size(); ++i) {
    const Proxy& body = state_.bodies[i];
    if (body.body.is_static) continue;
    const BodyMotion& b = body.body.motion;
    const Vec3 approach = b.velocity - momentum / mass;
    const double together = mass * body.body.mass / (mass + body.body.mass);
    if (0.5 * together * approach.squaredNorm() < across) continue;  // it cannot break the piece
    const double reach = body.radius() + apart;
    if (!meets_box(box, reach, b.position, approach, time)) continue;
    if (std::any_of(points.begin(), points.end(),
                    [&](const Vec3& x) { return passes(x, reach, b.position, approach, time); }))
      return true;
  }
  return false;
}

std::string Pieces::cracking_has_ended(double last_push) {
  // Soft bodies and fibres need shells that move, and so does a body that changes its shape.
  if (!state_.soft.empty() || state_.fibres || state_.deforms()) return "";
  if (setup_.latest_freeze < setup_.end_time && clock_.time() >= setup_.latest_freeze * (1.0 - 1e-9))
    return "latest_freeze_s";
  if (soft_left_ || books_.crack_length(simulation_) == 0.0 || clock_.time() < setup_.last_change + setup_.quiet_time)
    return "";
  for (const ShellPart& part : state_.shells)
    for (const char done : part.state->cracks.cut_done)
      if (!done) return "";
  const double length = books_.crack_length(simulation_), since = clock_.time() - setup_.quiet_time * (1.0 + 1e-9);
  crack_lengths_.emplace_back(clock_.time(), length);
  while (crack_lengths_.size() > 1 && crack_lengths_[1].first <= since) crack_lengths_.pop_front();
  const auto& [then, before] = crack_lengths_.front();
  if (then <= since + setup_.window && last_push <= since && length - before <= setup_.quiet_growth * length &&
      !impact_ahead())
    return fmt::format("cracks grew by {:.2g} of their length within {:g} s", 1.0 - before / length, setup_.quiet_time);
  return "";
}

// Notes the body that moves with most energy within a spacing of what is about to freeze.
void Pieces::note_body_beside(const std::vector<PartPieces>& now) {
  books_.frozen_time = clock_.time();
  for (std::size_t i = 0; i < setup_.bodies.size(); ++i) {
    const Proxy& body = state_.bodies[i];
    const double energy = 0.5 * body.body.mass * body.body.motion.velocity.squaredNorm();
    if (body.body.is_static || body.is_driven() || energy <= books_.frozen_beside_energy) continue;
    bool beside = false;
    for (std::size_t k = 0; k < now.size() && !beside; ++k) {
      const ShellModel& m = state_.shells[k].model();
      const double reach = m.spacing + 0.5 * m.largest_thickness();
      for (const Piece& p : now[k].pieces)
        beside = beside ||
                 (!p.handed_off && p.held && std::any_of(p.control_points.begin(), p.control_points.end(), [&](int c) {
                   return body.distance(state_.shells[k].state->position(m.tables.slot(c))).value < reach;
                 }));
    }
    if (beside) books_.frozen_beside = static_cast<int>(i), books_.frozen_beside_energy = energy;
  }
}

std::vector<RigidBody> Pieces::freeze(const std::string& why, double dt) {
  std::vector<RigidBody> births = hand_off_pieces(true, dt);
  const double before = simulation_.total_energy(dt);
  books_.frozen_kinetic = 0.0, books_.frozen_length = books_.crack_length(simulation_),
  books_.frozen_surface = books_.crack_surface(simulation_);
  const std::vector<PartPieces> now = pieces_now(true, everywhere());
  note_body_beside(now);
  std::set<BodyId> frozen_ids;
  for (std::size_t k = 0; k < state_.shells.size(); ++k) {
    const ShellModel& m = state_.shells[k].model();
    ShellState& s = *state_.shells[k].state;
    books_.frozen_kinetic += kinetic_energy(m, s, state_.shells[k].local.every * dt);
    state_.frozen_potential += potential_energy(m, s, setup_.gravity);
    std::vector<DrawnLine> lines;  // of a laminate: no edge of the body's mesh shows them
    if (m.laminated())
      lines = leaving_lines(m, s, static_cast<int>(k), [&](int slot) { return !s.motion.detached[slot]; });
    Handoff frozen = shell::freeze(m, s, *now[k].triangulation, now[k].pieces, counts_.next_id++);
    const RigidBody& remains = frozen.body;
    check_parts(remains, clock_.windows);
    if (!std::get<ConvexShape>(remains.shape).parts.empty()) {
      births.push_back(remains);
      std::vector<std::pair<std::size_t, int>> points;
      for (const Piece& p : now[k].pieces)
        for (const int i : p.control_points)
          if (p.held && !p.handed_off) points.emplace_back(k, i);
      frozen.drawn.shell.assign(frozen.drawn.triangles.size(), static_cast<int>(k));
      frozen.drawn.lines = seen_from(remains.motion, std::move(lines));
      const BodyId id = ids_.take(points, frozen_ids);  // shells that seams join are one piece
      frozen_ids.insert(id);
      frames_.draw_as(remains.id, id, frozen.drawn);
      state_.bodies.emplace_back(remains);
    }
    counts_.rubble_points += s.rubble();
  }
  books_.frozen = books_.sum(simulation_);
  books_.frozen.external -= state_.driven_work;  // which goes on
  frozen_hash_ = state_hash({}, state_);
  counts_.frozen_at = clock_.time(), frozen_why_ = why;
  frozen_wall_ = wall_clock();
  for (ShellPart& part : state_.shells) part.state.reset();  // exported rows end with it
  books_.frozen.frozen += before - simulation_.total_energy(dt);
  return births;
}

}  // namespace sunder::shell
