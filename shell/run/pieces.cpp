// Pieces that have come off leave the shells.
#include <algorithm>
#include <cmath>
#include <utility>

#include "shell/run/run.h"
#include "shell/solver/contact/near_tiles.h"
#include "shell/solver/interlock.h"

namespace sunder::shell {
namespace {

constexpr double kSmallPiece = 30.0;  // spacings squared: too small to bend, leaves at once
constexpr double kSettle = 40.0;      // a larger piece stays while a wave passes so many spacings, and again from its
                                      // last crack on: that may still branch

double relative(double error, double scale) { return scale > 0.0 ? error / scale : error; }  // absolute at zero

// Whether edges from `first` on have grown in a piece or along its border: one of the control points of the element
// that their middle lies in is of it, and sees that.
bool has_cracked(const ShellModel& m, const CrackGraph& cracks, const Triangulation& t, int piece, int first) {
  const int each = m.tables.support();
  for (int e = first; e < static_cast<int>(cracks.edges().size()); ++e) {
    const Vec2 middle = 0.5 * (cracks.edges()[e].a + cracks.edges()[e].b);
    const int column = m.patch.knots_u.span_of(middle.x()), row = m.patch.knots_v.span_of(middle.y());
    for (int k = 0; k < each * each; ++k) {
      const int point = (row + k / each) * m.patch.columns() + column + k % each;
      if (t.owner[point] == piece && cracks.visible(m.parameter[point], middle, e)) return true;
    }
  }
  return false;
}

}  // namespace

void Run::check_handoff(const Totals& before, const Totals& after, const RigidBody& b) {
  const Vec3 p = b.mass * b.motion.velocity;
  const Vec3 l = b.motion.angular_momentum + b.motion.position.cross(p);
  // relative to the sums' own magnitudes, which is what their round-off is relative to
  check_birth(b, relative(std::abs(after.mass + b.mass - before.mass), before.mass),
              relative((after.momentum + p - before.momentum).norm(), before.momentum_scale),
              relative((after.angular + l - before.angular).norm(), before.angular_scale), kBirthTolerance,
              "from the shell");
}

Run::PartBoxes Run::everywhere() const {
  PartBoxes boxes;
  for (const ShellPart& part : parts_) boxes.push_back({domain_of(part.model())});
  return boxes;
}

Run::PartBoxes Run::boxes_of(const std::vector<PartPieces>& now, const std::map<int, Group>& groups,
                             const std::vector<int>& roots) const {
  PartBoxes boxes(parts_.size());
  for (const int root : roots)
    for (const auto& [k, i] : groups.at(root).members) {
      if (now[k].whole) continue;
      const Triangulation& t = *now[k].triangulation;
      Eigen::AlignedBox2d& box = boxes[k].emplace_back();
      for (const int triangle : t.triangles_of(now[k].pieces[i].number))
        for (const int corner : t.triangles[triangle]) box.extend(t.vertices[corner]);
      const Vec2 pad = Vec2::Constant(1e-3 * parts_[k].model().spacing);  // a knot may lie on its border
      box = {box.min() - pad, box.max() + pad};
    }
  return boxes;
}

std::vector<PartPieces> Run::pieces_now(bool all, const PartBoxes& leaving) {
  std::vector<PartPieces> out(parts_.size());
  std::vector<int> first, parent;
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    ShellPart& part = parts_[k];
    const ShellModel& m = part.model();
    PartPieces& p = out[k];
    p.whole = part.state->cracks.graph.edges().empty() && !all;
    if (p.whole) {
      p.pieces.resize(1);
      p.pieces[0].area = domain_of(m).volume();
      p.pieces[0].held = !m.constraints.anchors.empty();
      p.pieces[0].gone = part.state->motion.detached[m.tables.slot(0)] != 0;
    } else {
      p.triangulation = leaving.empty() || leaving[k].empty() ? part.counted() : part.drawn(leaving[k]);
      p.pieces = pieces_of(m, *part.state, *p.triangulation);
      part.mark_rubble(p);
    }
    first.push_back(static_cast<int>(parent.size()));
    for (std::size_t i = 0; i < p.pieces.size(); ++i) parent.push_back(static_cast<int>(parent.size()));
  }
  const auto root = [&](int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  const auto piece_of = [&](int shell, int slot) {
    const int own =
        out[shell].whole ? 0 : out[shell].triangulation->owner[parts_[shell].model().tables.control_point(slot)];
    return own < 0 ? -1 : first[shell] + own;
  };
  for (std::size_t k = 0; k < parts_.size(); ++k)  // an interlayer holds what has cracked together
    for (std::size_t i = 1; i < out[k].pieces.size() && parts_[k].model().laminated(); ++i)
      parent[first[k] + static_cast<int>(i)] = first[k];
  stitching_.each_link([&](int shell, int slot, int other, int other_slot) {
    const int a = piece_of(shell, slot), b = piece_of(other, other_slot);
    if (a < 0 || b < 0) return;
    const int low = std::min(root(a), root(b)), high = std::max(root(a), root(b));
    parent[high] = low;
  });
  std::vector<char> held(parent.size(), 0), interlocked(parent.size(), 0);
  for (const bool gather : {true, false})
    for (std::size_t k = 0; k < parts_.size(); ++k)
      for (std::size_t i = 0; i < out[k].pieces.size(); ++i) {
        Piece& p = out[k].pieces[i];
        const int r = root(first[k] + static_cast<int>(i));
        if (gather) {
          held[r] |= p.held, interlocked[r] |= p.interlocked;
          continue;
        }
        p.held = held[r] != 0, p.interlocked = interlocked[r] != 0;
        out[k].group.push_back(r);
      }
  return out;
}

std::map<int, Run::Group> Run::groups_of(const std::vector<PartPieces>& now) const {
  std::map<int, Group> groups;
  std::vector<std::vector<char>> were_one;  // shells, as the scene has them
  if (stitching_.parted()) were_one = components(now.size(), setup_.stitches.seams);
  const auto in_another = [&](std::size_t shell, int own) {
    return std::any_of(now[shell].group.begin(), now[shell].group.end(), [own](int other) { return other != own; });
  };
  for (std::size_t k = 0; k < now.size(); ++k)
    for (std::size_t i = 0; i < now[k].pieces.size(); ++i) {
      Group& g = groups[now[k].group[i]];
      const Piece& p = now[k].pieces[i];
      g.members.push_back({k, i});
      // a shell without cracks has no pieces to measure, and is none that is too small
      g.bends = g.bends || now[k].whole ||
                (!p.control_points.empty() && p.area > kSmallPiece * std::pow(parts_[k].model().spacing, 2));
      g.empty = g.empty && p.control_points.empty() && !now[k].whole;
      const int own = now[k].group[i];
      g.torn = g.torn || p.parted || in_another(k, own);
      for (std::size_t other = 0; other < were_one.size() && !g.torn; ++other)
        g.torn = were_one[k][other] != 0 && in_another(other, own);
    }
  return groups;
}

bool Run::is_to_leave(const std::vector<PartPieces>& now, const Group& g, bool all) {
  const auto [front, number] = g.members.front();
  const Piece& p = now[front].pieces[number];
  if (p.held || p.gone || p.interlocked) return false;
  if (all) return true;
  if (!g.torn) return false;  // nothing has separated: a free shell stays a shell
  if (g.empty || !g.bends) return true;
  const int lowest = p.control_points.empty() ? 0 : p.control_points[0];
  const auto [since, fresh] = parts_[front].detached_since.try_emplace(lowest, tick_);
  double settle = 0.0;
  for (const auto& [k, i] : g.members)
    settle = std::max(settle, kSettle * parts_[k].model().spacing / parts_[k].model().wave_speed());
  if (static_cast<double>(tick_ - since->second) * setup_.tick < settle) return false;
  const double lately = time() + window_ticks_ * setup_.tick - settle;
  return std::none_of(g.members.begin(), g.members.end(), [&](const auto& member) {
    const ShellPart& part = parts_[member.first];
    const std::vector<CrackEdge>& edges = part.state->cracks.graph.edges();
    const auto first = std::partition_point(edges.begin(), edges.end(), [&](auto& e) { return e.time <= lately; });
    return first != edges.end() &&
           has_cracked(part.model(), part.state->cracks.graph, *now[member.first].triangulation,
                       now[member.first].pieces[member.second].number, static_cast<int>(first - edges.begin()));
  });
}

std::vector<RigidBody> Run::take_off(bool all) {
  std::vector<RigidBody> births;
  if (!all && !stitching_.parted() && std::all_of(parts_.begin(), parts_.end(), [](const ShellPart& part) {
        return part.state->cracks.graph.edges().empty();
      }))
    return births;
  Stopwatch w(stage_s_["crack_update"]);
  for (ShellPart& part : parts_)
    if (all) release_interlocks(part.model(), *part.state, {}, true);
  std::vector<PartPieces> now = pieces_now(all, {});
  std::map<int, Group> groups = groups_of(now);
  std::vector<int> leaving;
  const auto find_leaving = [&] {
    leaving.clear();
    for (const bool empty : {true, false})  // those without control points take their mass from what is beside them
      for (const auto& [root, g] : groups)
        if (g.empty == empty && is_to_leave(now, g, all)) leaving.push_back(root);
  };
  find_leaving();
  if (!leaving.empty()) now = pieces_now(all, boxes_of(now, groups, leaving)), groups = groups_of(now), find_leaving();
  fragments_ = handed_off_;
  for (const auto& [root, g] : groups) fragments_ += !now[g.members[0].first].pieces[g.members[0].second].gone;
  if (!leaving.empty()) {
    const double before = total_energy(dt_);
    Totals totals_now = shell_totals();
    for (const int root : leaving) births.push_back(leave(now, groups.at(root), totals_now));
    parts_.front().state->book.handoff += before - total_energy(dt_);
  }
  detached_area_ = 0.0;
  for (const PartPieces& part : now)
    for (const Piece& p : part.pieces)
      if (!p.held) detached_area_ += p.area;
  return births;
}

Totals Run::shell_totals() {
  Totals sum;
  for (const ShellRef& r : refs()) sum += totals(*r.model, *r.state);
  return sum;
}

RigidBody Run::leave(std::vector<PartPieces>& now, const Group& group, Totals& totals_now) {
  const std::vector<ShellRef> shells = refs();
  for (const auto& [k, i] : group.members) {
    if (!now[k].whole) continue;
    now[k].triangulation = parts_[k].drawn(std::array{domain_of(parts_[k].model())});
    now[k].pieces = pieces_of(*shells[k].model, *shells[k].state, *now[k].triangulation);
    now[k].whole = false;
  }
  const auto leaves = [&](int shell, int slot) {
    if (now[shell].whole) return false;
    const int own = now[shell].triangulation->owner[shells[shell].model->tables.control_point(slot)];
    return std::any_of(group.members.begin(), group.members.end(), [&](const auto& member) {
      return static_cast<int>(member.first) == shell && static_cast<int>(member.second) == own;
    });
  };
  if (stitching_.release(shells, leaves)) total_energy(dt_);  // forces of what now moves by itself
  std::vector<Handoff> parts;
  double mass = 0.0;
  for (const auto& [k, i] : group.members) {
    const ShellModel& m = *shells[k].model;
    Piece& p = now[k].pieces[i];
    if (p.control_points.empty()) parts_[k].add_rubble(*now[k].triangulation, p.number);
    parts.push_back(hand_off(m, *shells[k].state, *now[k].triangulation, p, next_id_, dt_));
    mass += m.material.density * m.thickness * parts.back().area;
    for (const int slot : parts.back().donors) parts_[k].changed.push_back(m.parameter[m.tables.control_point(slot)]);
    p.gone = true;
  }
  Handoff h = parts.size() == 1 ? std::move(parts[0]) : joined(parts);
  ++next_id_;
  const Totals totals_before = std::exchange(totals_now, shell_totals());
  check_handoff(totals_before, totals_now, h.body);
  geometry_error_ = std::max(geometry_error_, std::abs(h.body.mass - mass) / mass);
  handed_area_ += h.area, ++handed_off_;
  shards_.push_back({h.body.id, time() + window_ticks_ * setup_.tick, h.area, h.body.mass,
                     h.body.motion.velocity.norm(),
                     static_cast<int>(std::get<ConvexShape>(h.body.shape).parts.size())});
  frames_.draw_as(h.body.id, std::move(h.drawn));
  proxies_.emplace_back(h.body);
  for (ShellPart& other : parts_)
    other.coefficients.push_back(against(other.model(), h.body)), other.candidates.age = 0;
  return h.body;
}

}  // namespace sunder::shell
