#include "shell/run/pieces.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "coupler/link/messages.h"
#include "shell/io/crack_lines.h"
#include "shell/solver/contact/near_tiles.h"
#include "shell/solver/interlock.h"

namespace sunder::shell {
namespace {

// absolute where the scale is zero
double relative(double error, double scale) { return scale > 0.0 ? error / scale : error; }

// Tests whether edges from `first` on have grown in a piece or along its border. The element that holds the middle of
// an edge has control points; one of them must belong to the piece and see that middle.
bool has_cracked(const ShellModel& m, const CrackGraph& cracks, const Triangulation& t, int piece, int first) {
  const int each = m.tables.support();
  for (int e = first; e < static_cast<int>(cracks.edges().size()); ++e) {
    const Vec2 middle = 0.5 * (cracks.edges()[e].a + cracks.edges()[e].b);
    const int column = m.patch.knots_u.span_of(middle.x()), row = m.patch.knots_v.span_of(middle.y());
    for (int k = 0; k < each * each; ++k) {
      const int point = (row + k / each) * m.patch.columns() + column + k % each;
      if (t.owner[point] == piece &&
          cracks.visible(m.trim.empty() ? m.parameter[point] : m.trim.home[point], middle, e))
        return true;
    }
  }
  return false;
}

// The pieces of an uncracked shell.
PartPieces whole_of(const ShellPart& part) {
  const ShellModel& m = part.model();
  PartPieces p;
  p.pieces.resize(1);
  p.pieces[0].area = domain_of(m).volume();
  p.pieces[0].held = !m.constraints.anchors.empty();
  p.pieces[0].handed_off = part.state->motion.detached[m.tables.slot(0)] != 0;
  return p;
}

// Length [m] of a sheet whose own weight bends it about as much as it is long: (D / (rho t g))^(1/3), D = E t^3 /
// (12 (1 - nu^2)). Without gravity it is infinite.
double sagging_length(const ShellModel& m, double gravity) {
  const ShellMaterial& a = m.material;
  const double stiffness =
      a.youngs_modulus * m.thickness * m.thickness / (12.0 * (1.0 - a.poisson_ratio * a.poisson_ratio));
  return std::cbrt(stiffness / (a.density * gravity));
}

// Mass at rest [kg] of each control point of each shell.
std::vector<std::vector<double>> masses_of(const RunSetup& setup) {
  std::vector<std::vector<double>> all;
  for (const ShellSetup& shell : setup.shells) {
    std::vector<double>& mass = all.emplace_back();
    for (int i = 0; i < shell.model.control_points(); ++i) mass.push_back(shell.model.mass[shell.model.tables.slot(i)]);
  }
  return all;
}

}  // namespace

void check_parts(const RigidBody& body, std::int64_t window) {
  const auto& parts = std::get<ConvexShape>(body.shape).parts;
  std::size_t corners = 0;
  for (const auto& part : parts) corners = std::max(corners, part.size());
  if (parts.size() <= link::kMaxParts && corners <= link::kMaxCorners) return;
  Error e(Exit::kPhysics, "parts",
          fmt::format("'{}' would be a body of {} convex parts, the largest of {} corners; at most {} and {} can be "
                      "exchanged: take larger elements",
                      body.name, parts.size(), corners, link::kMaxParts, link::kMaxCorners));
  e.window = window;
  throw e;
}

Error with_place(const Error& e, const std::vector<Proxy>& bodies) {
  const auto at =
      std::find_if(bodies.begin(), bodies.end(), [&e](const Proxy& p) { return e.body == std::to_string(p.body.id); });
  const std::string what = e.what();
  std::string place = e.window < 0 ? "" : fmt::format("window {}", e.window), name = e.body;
  if (at != bodies.end()) name = at->body.name;
  if (at != bodies.end() && what.find(fmt::format("'{}'", name)) == std::string::npos)
    place += fmt::format("{}body {} '{}'", place.empty() ? "" : ", ", e.body, name);
  Error told(e.status, e.kind, place.empty() ? what : fmt::format("{}: {}", place, what));
  told.file = e.file, told.line = e.line, told.column = e.column, told.field = e.field, told.window = e.window;
  told.body = name;
  return told;
}

Pieces::Pieces(const RunSetup& setup, Simulation& simulation, Coupler& coupler, Books& books, const Clock& clock,
               FrameWriter& frames)
    : setup_(setup),
      simulation_(simulation),
      state_(simulation.state),
      coupler_(coupler),
      books_(books),
      clock_(clock),
      frames_(frames),
      ids_(masses_of(setup), static_cast<BodyId>(setup.bodies.size() + 1)) {
  counts_.next_id = counts_.first_shard = static_cast<BodyId>(setup.bodies.size() + 1);
}

void Pieces::check_handoff(const Totals& before, const Totals& after, const RigidBody& b) {
  const Vec3 p = b.mass * b.motion.velocity;
  const Vec3 l = b.motion.angular_momentum + b.motion.position.cross(p);
  // Errors are relative to the sums of magnitudes, as round-off is.
  const BirthErrors found{relative(std::abs(after.mass + b.mass - before.mass), before.mass),
                          relative((after.momentum + p - before.momentum).norm(), before.momentum_scale),
                          relative((after.angular + l - before.angular).norm(), before.angular_scale)};
  check_birth(coupler_.birth_errors(), b, found, kBirthTolerance, "from the shell", "all shells'", clock_.windows);
}

Pieces::PartBoxes Pieces::everywhere() const {
  PartBoxes boxes;
  for (const ShellPart& part : state_.shells) boxes.push_back({domain_of(part.model())});
  return boxes;
}

Pieces::PartBoxes Pieces::boxes_of(const std::vector<PartPieces>& now, const std::map<int, Group>& groups,
                                   const std::vector<int>& roots) const {
  PartBoxes boxes(state_.shells.size());
  for (const int root : roots)
    for (const auto& [k, i] : groups.at(root).members) {
      if (now[k].whole) continue;
      const Triangulation& t = *now[k].triangulation;
      Eigen::AlignedBox2d& box = boxes[k].emplace_back();
      for (const int triangle : t.triangles_of(now[k].pieces[i].number))
        for (const int corner : t.triangles[triangle]) box.extend(t.vertices[corner]);
      const Vec2 pad = Vec2::Constant(1e-3 * state_.shells[k].model().spacing);  // a knot may lie on its border
      box = {box.min() - pad, box.max() + pad};
    }
  return boxes;
}

std::vector<PartPieces> Pieces::pieces_now(bool all, const PartBoxes& leaving) {
  std::vector<PartPieces> out(state_.shells.size());
  for (std::size_t k = 0; k < state_.shells.size(); ++k) {
    ShellPart& part = state_.shells[k];
    const ShellModel& m = part.model();
    PartPieces& p = out[k];
    if (part.state->cracks.graph.edges().empty() && !all) {  // neither cracks nor trims
      p = whole_of(part);
    } else {
      p.whole = false;
      p.triangulation = leaving.empty() || leaving[k].empty() ? part.counted() : part.drawn(leaving[k]);
      p.pieces = pieces_of(m, *part.state, *p.triangulation);
      part.mark_rubble(p);
    }
  }
  std::vector<int> first;
  DisjointSets together = sewn(out, first);
  for (std::size_t k = 0; k < state_.shells.size(); ++k) {  // an interlayer holds cracked pieces together
    int known = -1;
    for (int i = 0; i < static_cast<int>(out[k].pieces.size()) && state_.shells[k].model().laminated(); ++i) {
      if (out[k].pieces[i].outside) continue;
      if (known >= 0) together.join(first[k] + i, known);
      known = first[k] + i;
    }
  }
  std::vector<char> held(together.size(), 0), interlocked(together.size(), 0);
  for (const bool gather : {true, false})
    for (std::size_t k = 0; k < state_.shells.size(); ++k)
      for (std::size_t i = 0; i < out[k].pieces.size(); ++i) {
        Piece& p = out[k].pieces[i];
        const int r = together.root(first[k] + static_cast<int>(i));
        if (gather) {
          held[r] |= p.held, interlocked[r] |= p.interlocked;
          continue;
        }
        p.held = held[r] != 0, p.interlocked = interlocked[r] != 0;
        out[k].group.push_back(r);
      }
  return out;
}

DisjointSets Pieces::sewn(const std::vector<PartPieces>& now, std::vector<int>& first) const {
  DisjointSets together(0);
  for (const PartPieces& p : now) {
    first.push_back(together.size());
    for (std::size_t i = 0; i < p.pieces.size(); ++i) together.add();
  }
  const auto piece_of = [&](int shell, int slot) {
    const int own = now[shell].owner(state_.shells[shell].model().tables.control_point(slot));
    return own < 0 ? -1 : first[shell] + own;
  };
  state_.stitching.each_dependence([&](int shell, int slot, int other, int other_slot) {
    const int a = piece_of(shell, slot), b = piece_of(other, other_slot);
    if (a >= 0 && b >= 0) together.join(a, b);
  });
  // A tie joins one piece of each shell, that of most of its weight: it reaches over no crack.
  state_.stitching.each_tie([&](const std::vector<WeightedSlot>& terms) {
    std::map<std::pair<int, int>, double> weight;  // shell, piece
    for (const WeightedSlot& t : terms)
      if (const int own = piece_of(t.shell, t.slot); own >= 0) weight[{t.shell, own}] += std::abs(t.weight);
    std::map<int, std::pair<double, int>> most;  // by shell: weight, piece
    for (const auto& [at, sum] : weight)
      if (auto& own = most.try_emplace(at.first, 0.0, -1).first->second; sum > own.first) own = {sum, at.second};
    for (const auto& [shell, own] : most) together.join(most.begin()->second.second, own.second);
  });
  return together;
}

void Pieces::give_ids(const std::vector<PartPieces>& now) {
  std::vector<int> first;
  DisjointSets together = sewn(now, first);  // an interlayer holds pieces together, but each has an id
  std::vector<std::vector<int>> piece(now.size());
  for (std::size_t k = 0; k < now.size(); ++k)
    for (int i = 0; i < state_.shells[k].model().control_points(); ++i) {
      const int own = now[k].owner(i);
      piece[k].push_back(own < 0 || now[k].pieces[own].handed_off ? -1 : together.root(first[k] + own));
    }
  ids_.look(piece);
}

void Pieces::look() {
  std::vector<PartPieces> now;
  for (const ShellPart& part : state_.shells) {
    PartPieces& p = now.emplace_back(whole_of(part));
    if (part.state->cracks.graph.edges().empty()) continue;
    p.whole = false, p.triangulation = part.drawn({});
    p.pieces = pieces_of(part.model(), *part.state, *p.triangulation);
  }
  give_ids(now);
}

std::map<int, Pieces::Group> Pieces::groups_of(const std::vector<PartPieces>& now) const {
  std::map<int, Group> groups;
  std::vector<std::vector<char>> were_one;  // [shell][shell]: joined in the scene
  if (state_.stitching.parted()) were_one = components(now.size(), setup_.stitches.seams);
  const auto in_another = [&](std::size_t shell, int own) {
    for (std::size_t i = 0; i < now[shell].group.size(); ++i)
      if (now[shell].group[i] != own && !now[shell].pieces[i].outside) return true;
    return false;
  };
  for (std::size_t k = 0; k < now.size(); ++k)
    for (std::size_t i = 0; i < now[k].pieces.size(); ++i) {
      Group& g = groups[now[k].group[i]];
      const Piece& p = now[k].pieces[i];
      g.members.push_back({k, i});
      // An uncracked shell has no measured pieces and counts as large.
      g.bends = g.bends || now[k].whole ||
                (!p.control_points.empty() && p.area > kSmallPiece * std::pow(state_.shells[k].model().spacing, 2));
      g.empty = g.empty && p.control_points.empty() && !now[k].whole;
      g.sliver = g.sliver && g.empty && p.area < kSliver * std::pow(state_.shells[k].model().spacing, 2);
      const int own = now[k].group[i];
      g.torn = g.torn || p.parted || in_another(k, own);
      for (std::size_t other = 0; other < were_one.size() && !g.torn; ++other)
        g.torn = were_one[k][other] != 0 && in_another(other, own);
    }
  return groups;
}

bool Pieces::is_to_leave(const std::vector<PartPieces>& now, const Group& g, bool all) {
  const auto [front, number] = g.members.front();
  const Piece& p = now[front].pieces[number];
  if (p.held || p.handed_off || p.interlocked) return false;
  if (g.sliver) return false;  // two slivers between cracks and a trim: without mass, and as a body without inertia
  if (all) return true;
  if (!g.torn) return false;  // nothing has separated: a free shell stays a shell
  if (g.empty || !g.bends) return true;
  if (stays_soft(now, g)) {
    soft_left_ = true;
    return false;
  }
  if (state_.deforms()) return false;  // the engine does not hold such a body, so a rigid piece would pass through it
  const int lowest = p.control_points.empty() ? 0 : p.control_points[0];
  const auto [since, fresh] = state_.shells[front].detached_since.try_emplace(lowest, clock_.tick);
  double settle = 0.0;
  for (const auto& [k, i] : g.members)
    settle = std::max(settle, kSettleWaves * state_.shells[k].model().spacing / state_.shells[k].model().wave_speed());
  if (static_cast<double>(clock_.tick - since->second) * setup_.tick < settle) return false;
  const double lately = clock_.time() + coupler_.window_ticks() * setup_.tick - settle;
  const bool cracks = std::any_of(g.members.begin(), g.members.end(), [&](const auto& member) {
    const ShellPart& part = state_.shells[member.first];
    const std::vector<CrackEdge>& edges = part.state->cracks.graph.edges();
    const auto first = std::partition_point(edges.begin(), edges.end(), [&](auto& e) { return e.time <= lately; });
    return first != edges.end() &&
           has_cracked(part.model(), part.state->cracks.graph, *now[member.first].triangulation,
                       now[member.first].pieces[member.second].number, static_cast<int>(first - edges.begin()));
  });
  return !cracks && !strike_ahead(now, g);
}

bool Pieces::stays_soft(const std::vector<PartPieces>& now, const Group& g) const {
  Eigen::AlignedBox3d box;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [k, i] : g.members) {
    const ShellModel& m = state_.shells[k].model();
    if (setup_.shells[k].pieces == PiecePolicy::kSoft) return true;
    if (setup_.shells[k].pieces == PiecePolicy::kByStiffness)
      least = std::min(least, sagging_length(m, setup_.gravity.norm()));
    const auto count = [&](int point) {
      const int slot = m.tables.slot(point), stride = m.tables.component_stride;
      box.extend(Vec3(m.rest[slot], m.rest[stride + slot], m.rest[2 * stride + slot]));
    };
    if (now[k].whole)
      for (int point = 0; point < m.control_points(); ++point) count(point);
    for (const int point : now[k].pieces[i].control_points) count(point);
  }
  return !box.isEmpty() && 0.5 * box.diagonal().norm() > least;
}

std::vector<RigidBody> Pieces::hand_off_pieces(bool all, double dt) {
  soft_left_ = false;
  std::vector<RigidBody> births;
  if (!all && !state_.stitching.parted() &&
      std::all_of(state_.shells.begin(), state_.shells.end(),
                  [](const ShellPart& part) { return !part.state->cracks.graph.has_cracks(); }))
    return births;
  Stopwatch w(simulation_.scratch.times[Stage::kCrackUpdate]);
  for (ShellPart& part : state_.shells)
    if (all) release_interlocks(part.model(), *part.state, {}, true);
  std::vector<PartPieces> now = pieces_now(all, {});
  std::map<int, Group> groups = groups_of(now);
  std::vector<int> leaving;
  const auto find_leaving = [&] {
    leaving.clear();
    for (const bool empty : {true, false})  // those without control points first: they take mass from their neighbours
      for (const auto& [root, g] : groups)
        if (g.empty == empty && is_to_leave(now, g, all)) leaving.push_back(root);
  };
  find_leaving();
  if (!leaving.empty()) now = pieces_now(all, boxes_of(now, groups, leaving)), groups = groups_of(now), find_leaving();
  give_ids(now);
  counts_.fragments = counts_.handed_off;
  for (const auto& [root, g] : groups)  // a sliver is no piece of its own
    counts_.fragments += !g.sliver && !now[g.members[0].first].pieces[g.members[0].second].handed_off;
  if (!leaving.empty()) {
    const double before = simulation_.total_energy(dt);
    Totals totals_now = shell_totals();
    for (const int root : leaving) births.push_back(hand_off_group(now, groups.at(root), totals_now, dt));
    state_.shells.front().state->book.handoff += before - simulation_.total_energy(dt);
  }
  counts_.detached_area = 0.0;
  for (const PartPieces& part : now)
    for (const Piece& p : part.pieces)
      if (!p.held && !p.outside) counts_.detached_area += p.area;
  return births;
}

Totals Pieces::shell_totals() {
  Totals sum;
  for (const ShellRef& r : simulation_.refs()) sum += totals(*r.model, *r.state);
  return sum;
}

RigidBody Pieces::hand_off_group(std::vector<PartPieces>& now, const Group& group, Totals& totals_now, double dt) {
  const std::vector<ShellRef> shells = simulation_.refs();
  for (const auto& [k, i] : group.members) {
    if (!now[k].whole) continue;
    now[k].triangulation = state_.shells[k].drawn(std::array{domain_of(state_.shells[k].model())});
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
  // forces of points that are independent now
  if (state_.stitching.release(shells, leaves)) simulation_.total_energy(dt);
  std::vector<DrawnLine> lines;  // of laminates: no edge of the body's mesh shows them
  for (std::size_t k = 0; k < now.size(); ++k)
    if (shells[k].model->laminated() && !now[k].whole) {
      const int shell = static_cast<int>(k);
      const auto out =
          leaving_lines(*shells[k].model, *shells[k].state, shell, [&](int slot) { return leaves(shell, slot); });
      lines.insert(lines.end(), out.begin(), out.end());
    }
  std::vector<Handoff> parts;
  std::vector<std::pair<std::size_t, int>> points;
  double mass = 0.0;
  for (const auto& [k, i] : group.members) {
    const ShellModel& m = *shells[k].model;
    Piece& p = now[k].pieces[i];
    for (const int point : p.control_points) points.emplace_back(k, point);
    if (p.control_points.empty()) state_.shells[k].add_rubble(*now[k].triangulation, p.number);
    parts.push_back(
        hand_off(m, *shells[k].state, *now[k].triangulation, p, counts_.next_id, state_.shells[k].local.every * dt));
    parts.back().drawn.shell.assign(parts.back().drawn.triangles.size(), static_cast<int>(k));
    mass += parts.back().weighs;
    for (const int slot : parts.back().donors)
      state_.shells[k].changed.push_back(m.parameter[m.tables.control_point(slot)]);
    p.handed_off = true;
  }
  Handoff h = parts.size() == 1 ? std::move(parts[0]) : joined(parts);
  const BodyId id = ids_.take(points);
  h.body.name = fmt::format("shard_{}", id);
  ++counts_.next_id;
  check_parts(h.body, clock_.windows);
  const Totals totals_before = std::exchange(totals_now, shell_totals());
  check_handoff(totals_before, totals_now, h.body);
  counts_.geometry_error = std::max(counts_.geometry_error, std::abs(h.body.mass - mass) / mass);
  counts_.handed_area += h.area, ++counts_.handed_off;
  shards_.push_back({id, h.body.id, clock_.time() + coupler_.window_ticks() * setup_.tick, h.area, h.body.mass,
                     h.body.motion.velocity.norm(),
                     static_cast<int>(std::get<ConvexShape>(h.body.shape).parts.size())});
  h.drawn.lines = seen_from(h.body.motion, std::move(lines));
  frames_.draw_as(h.body.id, id, std::move(h.drawn));
  state_.bodies.emplace_back(h.body);
  for (ShellPart& other : state_.shells)
    other.coefficients.push_back(simulation_.contact_law(other.model(), h.body)), other.candidates.age = 0;
  return h.body;
}

}  // namespace sunder::shell
