#include "shell/solver/contact/rigid_contact.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "shell/solver/contact/hertz.h"

namespace sunder::shell {
namespace {

// speed [m/s] at which an overlap is taken back: a body born in overlap gains no energy
constexpr double kFastestFromBody = 0.01;
// Sweeps over the samples that press on a body, at most, and the share of the largest impulse below which changes end
// them.
constexpr int kSweeps = 8;
constexpr double kSettled = 0.02;
constexpr double kSlack = 1e-9;  // of the thickness: round-off of distances
constexpr int kTile = 8;         // elements per side of a tile, the coarse unit of the search
constexpr int kLongEnough = 4;   // substeps without a touch for which a known distance need not be found anew
constexpr std::size_t kShortSearch = 2000;  // triangles up to which a search costs less than to remember its result
// Work for which one thread is faster than several, and the parts that threads share.
constexpr int kFewTiles = 64;
constexpr std::size_t kFewSamples = 8192, kPartsOfThread = 8;

using Functions = std::span<const GatheredFunction>;

Vec3 position(const ShellState& s, Functions functions) {
  Vec3 x = Vec3::Zero();
  for (const auto& f : functions) x += f.n[0] * s.position(f.slot);
  return x;
}
Vec3 velocity(const ShellState& s, Functions functions) {
  Vec3 v = Vec3::Zero();
  for (const auto& f : functions) v += f.n[0] * s.velocity(f.slot);
  return v;
}
// Change of a sample's velocity by half a kick: its velocity less this is that at the time of the positions [m/s].
Vec3 half_kick(const ShellState& s, Functions functions, double dt) {
  Vec3 sum = Vec3::Zero();
  for (const auto& f : functions)
    sum += (f.n[0] * 0.5 * dt * s.motion.inverse_mass[f.slot]) * s.at(s.motion.force, f.slot);
  return sum;
}

// Applies an impulse at a place with this distance, and books its work. `back` is half a kick.
void push(ShellState& s, Proxy& body, Functions functions, const Vec3& x, const Proxy::Distance& there,
          const Vec3& before, const Vec3& back, const Vec3& j) {
  const Vec3 driven = body.is_driven() ? body.velocity_at(x, there) : Vec3(Vec3::Zero());
  apply_impulse(s, body, functions, x, j);
  const Vec3 after = velocity(s, functions) - body.velocity_at(x, there);
  s.book.contact -= j.dot(0.5 * (before + after) - back);
  s.book.external += j.dot(driven);
}

// The tiles of a shell.
struct Tiles {
  explicit Tiles(const RowTables& t)
      : across((t.spans_u + kTile - 1) / kTile), along((t.spans_v + kTile - 1) / kTile) {}
  int count() const { return across * along; }

  int across, along;
};

using Samples = std::vector<ContactCandidates::Sample>;

// A search for the samples near a body.
struct Search {
  const ShellModel& m;
  const ShellState& s;
  const Proxy& body;
  double margin, travel;              // [m]: of a candidate; in one substep
  std::vector<Proxy::Known>* before;  // distances of all samples, as they were last computed; null: they cost little
  bool edges;                         // whether the edges of the patch have samples of their own

  int substeps_without_touch(double gap) const {
    const double free = std::max(0.0, gap - 0.5 * m.largest_thickness());
    return static_cast<int>(std::min(free / travel, static_cast<double>(kContactRefresh)));
  }
};

// Shape functions of a sample. At the edge of the patch they are those of its surface there. Where a crack has touched
// the Gauss point, they are the point's own, continued to the edge along its tangents.
void contact_functions(const ShellModel& m, const ShellState& s, const ContactCandidates::Sample& q,
                       std::vector<GatheredFunction>& out) {
  sample_functions(m, s, q.block, q.lane, out);
  if (q.to_edge.isZero(0.0) || out.empty()) return;
  const RowTables& t = m.tables;
  const int point = s.cracked.point_of[static_cast<std::size_t>(q.block) * t.lanes + q.lane];
  if (point < 0 || s.cracked.gathered[point].in_rows)
    return patch_functions(m.patch, gauss_point(m.patch, t, q.block, q.lane).parameter + q.to_edge, t.stride, out);
  for (GatheredFunction& f : out) f.n[0] += q.to_edge.x() * f.n[1] + q.to_edge.y() * f.n[2];
}

// A place at the edge of the patch that a sample has.
struct EdgePlace {
  Vec2 to_edge;  // from its Gauss point, in parameters
  Vec3 x;
};

// The samples at the edge of the patch beside a Gauss point: the outermost ones are a fifth of an element within, and
// an element may be drawn to many times its length. Elements that a loop cuts have none, nor has what lies behind a
// crack.
void edge_places(const Search& k, int block, int lane, std::vector<EdgePlace>& out) {
  out.clear();
  const RowTables& t = k.m.tables;
  const int g = t.gauss, row = block / g, column = lane * g + block % g;
  if (!k.edges || (column > 0 && column < t.spans_u * g - 1 && row > 0 && row < t.spans_v * g - 1)) return;
  if (!t.trimmed.empty() && !is_whole_element(k.m.patch, t, lane, row / g)) return;
  const auto beyond = [](int i, int count, const KnotVector& knots, double at) {
    return i == 0 ? knots.begin() - at : i == count - 1 ? knots.end() - at : 0.0;
  };
  const Vec2 p = gauss_point(k.m.patch, t, block, lane).parameter;
  const double u = beyond(column, t.spans_u * g, k.m.patch.knots_u, p.x()),
               v = beyond(row, t.spans_v * g, k.m.patch.knots_v, p.y());
  const auto add = [&](const Vec2& to_edge) {
    if (k.s.cracks.graph.has_cracks() && !k.s.cracks.graph.visible(p, p + to_edge)) return;
    thread_local std::vector<GatheredFunction> functions;
    contact_functions(k.m, k.s, {block, lane, 0, {}, to_edge}, functions);
    out.push_back({to_edge, position(k.s, functions)});
  };
  if (u != 0.0) add({u, 0.0});
  if (v != 0.0) add({0.0, v});
  if (u != 0.0 && v != 0.0) add({u, v});
}

// Candidates among the edge places of a Gauss point at x, whose distance is known.
void look_at_edges(const Search& k, int block, int lane, const std::vector<EdgePlace>& edges, const Vec3& x,
                   const Proxy::Known& known, Samples& found) {
  if (edges.empty()) return;
  const double least = known.value - k.body.change_since(x, known) - kSlack * k.m.thickness;
  for (const EdgePlace& e : edges) {
    if (least - (e.x - x).norm() >= k.margin) continue;
    const Proxy::Known own = k.body.known(e.x, k.body.distance(e.x, known.triangle));
    if (own.value < k.margin) found.push_back({block, lane, k.substeps_without_touch(own.value), own, e.to_edge});
  }
}

// Candidates of a tile. Where a distance from before tells that a sample is beyond the margin, or that it cannot touch
// for some substeps, it is not computed.
void look_at_tile(const Search& k, int tile, int across, ContactCandidates& c, Samples& found) {
  const RowTables& t = k.m.tables;
  thread_local std::vector<GatheredFunction> functions;
  thread_local std::vector<EdgePlace> edges;
  found.clear();
  const Vec3 centre = k.body.body.motion.position;
  const int tu = tile % across, tv = tile / across, points = t.gauss * t.gauss;
  for (int f = tv * kTile; f < std::min(t.spans_v, (tv + 1) * kTile); ++f)
    for (int lane = tu * kTile; lane < std::min(t.spans_u, (tu + 1) * kTile); ++lane)
      for (int sub = 0; sub < points; ++sub) {
        const int block = f * points + sub;
        if (t.metric[t.at(block, kMetricFields, kArea, lane)] == 0.0) continue;
        const std::size_t sample = static_cast<std::size_t>(block) * t.lanes + lane;
        ContactCandidates::Place& q = c.places[sample];
        if (q.refresh != c.refresh) {
          sample_functions(k.m, k.s, block, lane, functions);
          q.refresh = c.refresh, q.there = !functions.empty() && !k.s.motion.detached[functions[0].slot];
          if (q.there) q.x = position(k.s, functions);
        }
        if (!q.there) continue;
        edge_places(k, block, lane, edges);
        double reach = k.margin;  // within which the Gauss point or an edge beside it may be a candidate
        for (const EdgePlace& e : edges) reach = std::max(reach, k.margin + (e.x - q.x).norm());
        if ((q.x - centre).norm() > k.body.radius() + reach) continue;
        Proxy::Known known = k.before ? (*k.before)[sample] : Proxy::Known{};
        if (std::isfinite(known.value)) {
          const double change = k.body.change_since(q.x, known) + kSlack * k.m.thickness;
          const double least = known.value - change, most = known.value + change;
          if (least >= reach) continue;
          const int first = k.substeps_without_touch(least);
          if (most < k.margin && first >= kLongEnough) {
            found.push_back({block, lane, first, known});
            look_at_edges(k, block, lane, edges, q.x, known, found);
            continue;
          }
        }
        known = k.body.known(q.x, k.body.distance(q.x, known.triangle));
        if (k.before) (*k.before)[sample] = known;
        if (known.value < k.margin) found.push_back({block, lane, k.substeps_without_touch(known.value), known});
        look_at_edges(k, block, lane, edges, q.x, known, found);
      }
}

}  // namespace

void apply_impulse(ShellState& s, Proxy& body, std::span<const GatheredFunction> functions, const Vec3& x,
                   const Vec3& j) {
  for (const auto& f : functions) {
    s.add_velocity(f.slot, (f.n[0] * s.motion.inverse_mass[f.slot]) * j);
    s.pass_to_supports(f.slot, f.n[0] * j);
    s.count_contact(f.slot, f.n[0] * j);
    body.shell_linear += f.n[0] * j;
    const Vec3 arm = s.position(f.slot) - body.body.motion.position;
    body.shell_angular += arm.cross(f.n[0] * j);
    body.moment_sum += arm.norm() * std::abs(f.n[0]) * j.norm();
  }
  s.count_body(body.body.id, j);
  body.impulse_sum += j.norm();
  body.apply(x, -j);
}

void refresh_candidates(const ShellModel& m, const ShellState& s, const std::vector<Proxy>& bodies,
                        const std::vector<ContactCoefficients>& coefficients, double dt, ContactCandidates& c,
                        int threads) {
  const RowTables& t = m.tables;
  c.age = 0;
  c.of_body.resize(bodies.size()), c.known.resize(bodies.size()), c.ids.resize(bodies.size());
  if (bodies.empty()) return;
  double speed = 0.0;
  for (int i = 0; i < m.control_points(); ++i) speed = std::max(speed, s.velocity(t.slot(i)).squaredNorm());
  speed = std::sqrt(speed);
  const Tiles tiles(t);
  std::vector<Eigen::AlignedBox3d>& boxes = c.boxes;
  boxes.assign(tiles.count(), Eigen::AlignedBox3d());
  for (int tv = 0; tv < tiles.along; ++tv)
    for (int tu = 0; tu < tiles.across; ++tu)
      for (int j = tv * kTile; j < std::min(t.rows, (tv + 1) * kTile + t.degree); ++j)
        for (int i = tu * kTile; i < std::min(t.columns, (tu + 1) * kTile + t.degree); ++i)
          if (!s.motion.detached[j * t.stride + i]) boxes[tv * tiles.across + tu].extend(s.position(j * t.stride + i));
  if (++c.refresh == 0) c.places.assign(c.places.size(), {}), c.refresh = 1;
  for (std::size_t b = 0; b < bodies.size(); ++b) {
    const Proxy& body = bodies[b];
    const double reach = body.turning_speed();
    // The margin is twice the travel until the next refresh, since control points may speed up.
    const double travel = 2.0 * dt * (speed + body.body.motion.velocity.norm() + reach);  // in one substep
    double margin = m.largest_thickness() + kContactRefresh * travel;
    if (coefficients[b].hertz > 0.0) margin += m.longest_element;  // Hertz contact acts between samples
    const Vec3 centre = body.body.motion.position;
    c.near.clear();
    for (int tile = 0; tile < tiles.count(); ++tile) {
      if (boxes[tile].isEmpty()) continue;
      const double pad = margin + 2.0 * m.spacing;  // cracked samples may lie outside their control points
      if (std::isfinite(body.radius())) {
        const double r = body.radius() + pad;
        if (boxes[tile].squaredExteriorDistance(centre) > r * r) continue;
      } else {
        double low = std::numeric_limits<double>::infinity();
        for (int k = 0; k < 8; ++k)
          low = std::min(low, body.distance(boxes[tile].corner(static_cast<Eigen::AlignedBox3d::CornerType>(k))).value);
        if (low > pad) continue;
      }
      c.near.push_back(tile);
    }
    Samples& list = c.of_body[b];
    if (c.near.empty()) {
      list.clear();
      continue;
    }
    c.places.resize(static_cast<std::size_t>(t.blocks()) * t.lanes);  // allocated when a body first comes near
    const bool keeps = body.triangles() > kShortSearch;
    if (keeps) {
      if (c.ids[b] != body.body.id) c.known[b].clear();  // they were of another body
      c.known[b].resize(c.places.size());
    }
    c.ids[b] = body.body.id;
    const Search search{m, s, body, margin, travel, keeps ? &c.known[b] : nullptr, coefficients[b].hertz == 0.0};
    const int count = static_cast<int>(c.near.size());
    if (c.of_tile.size() < c.near.size()) c.of_tile.resize(count);
    const auto look = [&](int k) { look_at_tile(search, c.near[k], tiles.across, c, c.of_tile[k]); };
    if (threads == 1 || count <= kFewTiles) {
      for (int k = 0; k < count; ++k) look(k);
    } else {
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads)
      for (int k = 0; k < count; ++k) look(k);
    }
    list.clear();
    for (int k = 0; k < count; ++k) list.insert(list.end(), c.of_tile[k].begin(), c.of_tile[k].end());
  }
}

namespace {

// Normal of the shell at a sample, unit.
Vec3 normal_at(const ShellModel& m, const ShellState& s, const ContactCandidates::Sample& q,
               const std::vector<GatheredFunction>& functions) {
  Vec3 tu = Vec3::Zero(), tv = Vec3::Zero();
  const bool own = functions.front().n[1] != 0.0 || functions.size() != m.patch.functions();  // gathered
  if (own || !q.to_edge.isZero(0.0)) {
    for (const auto& f : functions) tu += f.n[1] * s.position(f.slot), tv += f.n[2] * s.position(f.slot);
  } else {
    const ShapeFunctions n = m.patch.shape_functions(gauss_point(m.patch, m.tables, q.block, q.lane).parameter);
    for (int k = 0; k < n.count(); ++k) {
      const Vec3 x = s.position(n.row(k) * m.tables.stride + n.column(k));
      tu += n.u[k] * x, tv += n.v[k] * x;
    }
  }
  return tu.cross(tv).normalized();
}

// Notes a candidate that overlaps with the body. Impulses change velocities only, so all may be asked beforehand.
void note_overlap(const ShellModel& m, const ShellState& s, const Proxy& body, Samples& all, std::size_t k,
                  std::vector<GatheredFunction>& functions, std::vector<ContactCandidates::Overlap>& found) {
  ContactCandidates::Sample& q = all[k];
  contact_functions(m, s, q, functions);  // a crack may have changed them
  if (functions.empty() || s.motion.detached[functions[0].slot]) return;
  const Vec3 x = position(s, functions);
  const double half = 0.5 * m.thickness_at(q.block, q.lane);
  if (body.surely_beyond(x, q.known, half, kSlack * m.thickness)) return;
  const Proxy::Distance middle = body.distance(x, q.known.triangle);
  q.known = body.known(x, middle);
  if (middle.value > half) return;
  // The face towards the body is half a thickness from the mid-surface, along the shell's own normal.
  Vec3 normal = normal_at(m, s, q, functions);
  if (normal.dot(middle.normal) > 0.0) normal = -normal;
  const Proxy::Distance gap = body.distance(x + half * normal, middle.triangle);
  if (gap.value < 0.0) found.push_back({k, x, middle, gap});
}

// Finds the overlaps with body b, in the order of its candidates.
void find_overlaps(const ShellModel& m, const ShellState& s, const Proxy& body, std::size_t b, ContactCandidates& c,
                   int threads) {
  Samples& all = c.of_body[b];
  const auto look = [&](std::size_t first, std::size_t end, std::vector<ContactCandidates::Overlap>& found) {
    thread_local std::vector<GatheredFunction> functions;
    for (std::size_t k = first; k < end; ++k)
      if (c.age > all[k].first) note_overlap(m, s, body, all, k, functions, found);
  };
  const std::size_t parts = threads == 1 || all.size() <= kFewSamples ? 1 : kPartsOfThread * threads;
  if (c.overlaps.size() < parts) c.overlaps.resize(parts);
  c.parts = parts;
  for (std::size_t part = 0; part < parts; ++part) c.overlaps[part].clear();
  if (parts == 1) return look(0, all.size(), c.overlaps[0]);
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads)
  for (std::size_t part = 0; part < parts; ++part)
    look(all.size() * part / parts, all.size() * (part + 1) / parts, c.overlaps[part]);
}

// Relative velocity that contact leaves a sample that came at `arrived` [m/s] along the normal, before the kick.
//
// A bouncing sample leaves the overlap by itself. A recovery speed on top would add energy, most to slow ones. A kick
// may turn a sample that leaves. To stop it in the same substep would do work on its way out: as much as it had left
// with. So it may come back as fast as it left, and the next substep stops it. With j the impulse, contact does the
// work j (arrived + after) / 2.
Vec3 wanted_velocity(const Proxy& body, const ContactCoefficients& law, const Proxy::Distance& gap, double arrived,
                     double dt) {
  const double recovered = std::min(body.recovery * -gap.value / dt, kFastestFromBody);
  if (arrived > 0.0) return (recovered - arrived) * gap.normal;
  return std::max(recovered, -law.restitution * arrived) * gap.normal;
}

// Lists the overlaps with body b that impulses can change. Returns the number of overlaps.
int list_pressed(const ShellModel& m, const ShellState& s, const Proxy& body, const ContactCoefficients& law,
                 std::size_t b, double dt, ContactCandidates& c) {
  int touching = 0;
  thread_local std::vector<GatheredFunction> functions;
  c.pressed.clear(), c.functions.clear();
  for (std::size_t part = 0; part < c.parts; ++part)
    for (const ContactCandidates::Overlap& k : c.overlaps[part]) {
      const ContactCandidates::Sample& q = c.of_body[b][k.candidate];
      contact_functions(m, s, q, functions);
      ++touching;
      ContactCandidates::Pressed p{&k, c.functions.size(), functions.size(), body.inverse_mass_at(k.x), {}, {}};
      for (const auto& f : functions) p.inverse.diagonal().array() += f.n[0] * f.n[0] * s.motion.inverse_mass[f.slot];
      if (p.inverse.trace() <= 0.0) continue;
      p.back = half_kick(s, functions, dt);
      const Vec3 before = velocity(s, functions) - body.velocity_at(k.x, k.middle);
      p.wanted = wanted_velocity(body, law, k.gap, k.gap.normal.dot(before - 2.0 * p.back), dt);
      c.pressed.push_back(p);
      c.functions.insert(c.functions.end(), functions.begin(), functions.end());
    }
  return touching;
}

// Applies the impulses of all samples that press on a body. Samples share control points, so each is looked at again
// after the others (projected Gauss-Seidel): it may take back what they have made too much. The impulse acts on both
// sides at the mid-surface point, where the shape functions place it. Linear and angular momentum then close to
// round-off.
void press(ShellState& s, Proxy& body, const ContactCoefficients& law, ContactCandidates& c) {
  double largest = 0.0, counted = 0.0;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    double change = 0.0;
    for (ContactCandidates::Pressed& p : c.pressed) {
      const Functions functions(c.functions.data() + p.first, p.count);
      const Vec3 before = velocity(s, functions) - body.velocity_at(p.at->x, p.at->middle);
      const Vec3 j =
          contact_impulse(p.at->gap.normal, before - p.inverse * p.j - p.wanted, p.inverse, law.friction, 0.0);
      const Vec3 more = j - p.j;
      if (more.isZero(0.0)) continue;
      change = std::max(change, more.norm()), largest = std::max(largest, j.norm()), counted += more.norm();
      p.j = j;
      push(s, body, functions, p.at->x, p.at->middle, before, p.back, more);
    }
    if (change <= kSettled * largest) break;
  }
  for (const ContactCandidates::Pressed& p : c.pressed) counted -= p.j.norm();
  body.impulse_sum -= counted;  // of what was taken back
}

}  // namespace

int contact(const ShellModel& m, ShellState& s, std::vector<Proxy>& bodies,
            const std::vector<ContactCoefficients>& coefficients, ContactCandidates& candidates, double dt,
            double kicked, int threads) {
  int touching = 0;
  for (std::size_t b = 0; b < candidates.of_body.size(); ++b) {
    if (candidates.of_body[b].empty()) continue;
    Proxy& body = bodies[b];
    if (coefficients[b].hertz > 0.0) {
      touching += hertz_contact(m, s, body, coefficients[b].hertz, candidates.of_body[b], kicked);
      continue;
    }
    find_overlaps(m, s, body, b, candidates, threads);
    touching += list_pressed(m, s, body, coefficients[b], b, dt, candidates);
    press(s, body, coefficients[b], candidates);
  }
  return touching;
}

}  // namespace sunder::shell
