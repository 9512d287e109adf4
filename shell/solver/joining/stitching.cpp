#include "shell/solver/joining/stitching.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <random>

#include "coupler/core/error.h"
#include "coupler/core/principal_axes.h"

namespace sunder::shell {
namespace {

constexpr double kOnALine = 1e-9;      // of the largest moment of inertia, that points on a line have about it
constexpr double kOnePlace = 1e-3;     // spacings: control points no further apart have no arm to turn by
constexpr int kSweeps = 12;            // over creases that share control points
constexpr double kSameLength = 1e-13;  // of a length: round-off

void add(std::vector<double>& a, int slot, const Vec3& value) {
  const std::size_t stride = a.size() / 3;
  for (int d = 0; d < 3; ++d) a[d * stride + slot] += value[d];
}
void put(std::vector<double>& a, int slot, const Vec3& value) {
  const std::size_t stride = a.size() / 3;
  for (int d = 0; d < 3; ++d) a[d * stride + slot] = value[d];
}

}  // namespace

Stitching::Stitching(const Stitches& stitches, const std::vector<const ShellModel*>& shells) {
  const auto slot = [&](const PatchPoint& p) { return shells[p.patch]->tables.slot(p.point); };
  for (const Dependence& d : stitches.points) {
    DependentPoint t;
    t.shell = d.point.patch, t.slot = slot(d.point);
    if (shells[t.shell]->held[t.slot]) continue;
    double positive = 0.0;
    for (const auto& [p, weight] : d.on) positive += std::max(0.0, weight);
    for (const auto& [p, weight] : d.on) t.on.push_back({{p.patch, slot(p), weight}, std::max(0.0, weight) / positive});
    dependent_points_.push_back(std::move(t));
  }
  for (const Seam& seam : stitches.seams) {
    if (seam.trimmed()) continue;
    const auto any_held = [&](int shell, int edge) {
      const ShellModel& m = *shells[shell];
      const std::vector<int> row = edge_row(m.patch, edge, 0);
      return std::any_of(row.begin() + 1, row.end() - 1, [&](int i) { return m.held[m.tables.slot(i)] != 0; });
    };
    const bool first = any_held(seam.first, seam.first_edge), second = any_held(seam.second, seam.second_edge);
    require(first == second,
            "a support of shell '{0}' holds its seam with shell '{1}', which does not hold it; give the support to the "
            "same edge of both, by a box that holds both, or, where they are to stay apart there, add to seams: rules "
            "{{ first: \"{0}\" second: "
            "\"{1}\" kind: OPEN }}",
            shells[first ? seam.first : seam.second]->name, shells[first ? seam.second : seam.first]->name);
  }
  std::map<std::pair<int, int>, const DependentPoint*> tie_of;
  for (const DependentPoint& t : dependent_points_) tie_of[{t.shell, t.slot}] = &t;
  for (const Seam& seam : stitches.seams)
    for (const CreasePoint& c : seam.crease) {
      const auto rest = [&](const PatchPoint& p) { return shells[p.patch]->patch.control_points[p.point]; };
      Vec3 b = Vec3::Zero();
      for (const auto& [p, weight] : c.second) b += weight * rest(p);
      const Vec3 a = rest(c.first), edge = rest(c.on_seam), chord = b - a;
      const double bend =
          std::numbers::pi - std::acos(std::clamp((a - edge).normalized().dot((b - edge).normalized()), -1.0, 1.0));
      const double share = std::clamp((edge - a).dot(chord) / std::max(chord.squaredNorm(), 1e-300), 0.0, 1.0);
      const bool sharp = bend >= kSharpCrease;
      CreaseConstraint constraint;
      const auto end = [&](const PatchPoint& p, double weight) {
        constraint.ends.push_back({p.patch, slot(p), weight});
      };
      end(c.first, sharp ? -1.0 : share - 1.0);
      for (const auto& [p, weight] : c.second) end(p, sharp ? weight : -share * weight);
      if (!sharp) end(c.on_seam, 1.0);
      std::map<std::pair<int, int>, double> terms;
      for (const Term& t : constraint.ends) {
        const auto it = tie_of.find({t.shell, t.slot});
        if (it == tie_of.end())
          terms[{t.shell, t.slot}] += t.weight;
        else
          for (const IndependentPoint& m : it->second->on) terms[{m.shell, m.slot}] += t.weight * m.weight;
      }
      Vec3 sum = Vec3::Zero();
      for (const auto& [at, weight] : terms) {
        if (std::abs(weight) <= kLooseWeight) continue;
        constraint.terms.push_back({at.first, at.second, weight});
        const std::vector<double>& x = shells[at.first]->rest;
        for (int d = 0; d < 3; ++d) sum[d] += weight * x[d * x.size() / 3 + at.second];
      }
      constraint.length = sum.norm();
      if (constraint.length > kSmoothSeam * chord.norm()) crease_constraints_.push_back(std::move(constraint));
    }
  tie_trims(stitches.seams, shells);
  edges_seen_.assign(shells.size(), 0);
}

// Replaces dependent control points by those that they depend on.
std::vector<WeightedSlot> Stitching::independent_terms(const std::vector<WeightedSlot>& from) const {
  std::map<std::pair<int, int>, double> terms;
  for (const WeightedSlot& t : from) {
    const auto it = std::find_if(dependent_points_.begin(), dependent_points_.end(), [&](const DependentPoint& d) {
      return d.holds && d.shell == t.shell && d.slot == t.slot;
    });
    if (it == dependent_points_.end())
      terms[{t.shell, t.slot}] += t.weight;
    else
      for (const IndependentPoint& m : it->on) terms[{m.shell, m.slot}] += t.weight * m.weight;
  }
  std::vector<WeightedSlot> out;
  for (const auto& [at, weight] : terms)
    if (std::abs(weight) > kLooseWeight) out.push_back({at.first, at.second, weight});
  return out;
}

void Stitching::tie_trims(const std::vector<Seam>& seams, const std::vector<const ShellModel*>& shells) {
  SeamRows all;
  const auto take = [&](int seam, const std::vector<std::vector<WeightedSlot>>& rows, std::vector<RowOrigin>& origins,
                        std::vector<std::vector<WeightedSlot>>& into, std::vector<RowOrigin>& of) {
    for (std::size_t k = 0; k < rows.size(); ++k) {
      std::vector<WeightedSlot> own = independent_terms(rows[k]);
      if (own.empty()) continue;
      origins[k].seam = seam;
      into.push_back(std::move(own)), of.push_back(std::move(origins[k]));
    }
  };
  for (std::size_t k = 0; k < seams.size(); ++k) {
    if (!seams[k].trimmed()) continue;
    SeamRows rows = seam_rows(seams[k], shells);
    take(static_cast<int>(k), rows.ties, rows.of_ties, all.ties, all.of_ties);
    take(static_cast<int>(k), rows.creases, rows.of_creases, all.creases, all.of_creases);
  }
  if (!all.ties.empty() || !all.creases.empty()) ties_ = SeamTies(std::move(all), seams, shells);
}

void Stitching::renew_ties(const std::vector<ShellRef>& shells, const std::vector<Seam>& seams,
                           const std::vector<int>& first) {
  const auto independent = [&](const std::vector<WeightedSlot>& terms) { return independent_terms(terms); };
  if (ties_.empty() || !ties_.renew(seams, shells, first, independent)) return;
  book_lost(shells, 0, ties_.align(shells, 0.0, true));
  update_dependent_velocities(shells);
}

void Stitching::move_masses(const std::vector<ShellRef>& shells) {
  for (const DependentPoint& t : dependent_points_) {
    double& mass = shells[t.shell].state->motion.mass[t.slot];
    for (const IndependentPoint& m : t.on) {
      ShellState& s = *shells[m.shell].state;
      s.motion.mass[m.slot] += m.share * mass;
      if (s.motion.inverse_mass[m.slot] > 0.0) s.motion.inverse_mass[m.slot] = 1.0 / s.motion.mass[m.slot];
    }
    mass = 0.0;
  }
  for (const DependentPoint& t : dependent_points_) refresh(shells, t);
  align_velocities(shells);
}

void Stitching::align_velocities(const std::vector<ShellRef>& shells) {
  ties_.align(shells, 0.0, true);
  update_dependent_velocities(shells);
}

void Stitching::update_dependent_velocities(const std::vector<ShellRef>& shells) const {
  for (const DependentPoint& t : dependent_points_) {
    if (!t.holds) continue;
    Vec3 v = Vec3::Zero();
    for (const IndependentPoint& m : t.on) v += m.weight * shells[m.shell].state->velocity(m.slot);
    put(shells[t.shell].state->motion.v, t.slot, v);
  }
}

void Stitching::refresh(const std::vector<ShellRef>& shells, const DependentPoint& t) {
  double inverse = 0.0;
  for (const IndependentPoint& m : t.on)
    inverse += m.weight * m.weight * shells[m.shell].state->motion.inverse_mass[m.slot];
  shells[t.shell].state->motion.inverse_mass[t.slot] = inverse;
}

void Stitching::move_forces(const std::vector<ShellRef>& shells) {
  share(shells, [](ShellState& s) -> std::vector<double>& { return s.motion.force; });
  if (std::none_of(shells.begin(), shells.end(),
                   [](const ShellRef& r) { return !r.state->cracks.force_discontinuity.empty(); }))
    return;
  for (const ShellRef& r : shells) r.state->discontinuity();
  share(shells, [](ShellState& s) -> std::vector<double>& { return s.cracks.force_discontinuity; });
}

void Stitching::share(const std::vector<ShellRef>& shells, std::vector<double>& (*field)(ShellState&)) {
  for (const DependentPoint& t : dependent_points_) {
    if (!t.holds) continue;
    ShellState& own = *shells[t.shell].state;
    const Vec3 force = own.at(field(own), t.slot);
    for (const IndependentPoint& m : t.on) add(field(*shells[m.shell].state), m.slot, m.weight * force);
  }
  ties_.add_forces(shells, field);
  for (const DependentPoint& t : dependent_points_) {
    if (!t.holds) continue;
    refresh(shells, t);
    ShellState& own = *shells[t.shell].state;
    Vec3 acceleration = Vec3::Zero();
    for (const IndependentPoint& m : t.on) {
      ShellState& s = *shells[m.shell].state;
      acceleration += m.weight * s.motion.inverse_mass[m.slot] * s.at(field(s), m.slot);
    }
    const double inverse = own.motion.inverse_mass[t.slot];
    put(field(own), t.slot, inverse > 0.0 ? Vec3(acceleration / inverse) : Vec3(Vec3::Zero()));
  }
}

void Stitching::enforce_crease_constraints(const std::vector<ShellRef>& shells, double dt) {
  ties_.align(shells, dt, true);
  ties_.keep_creases(shells, dt);
  bool met = crease_constraints_.empty();
  for (int sweep = 0; sweep < kSweeps && !met; ++sweep) {
    met = true;
    for (const CreaseConstraint& b : crease_constraints_) {
      if (!b.holds) continue;
      Vec3 now = Vec3::Zero(), change = Vec3::Zero();
      double mobility = 0.0;
      for (const Term& t : b.terms) {
        const ShellState& s = *shells[t.shell].state;
        now += t.weight * s.position(t.slot), change += t.weight * s.velocity(t.slot);
        mobility += t.weight * t.weight * s.motion.inverse_mass[t.slot];
      }
      const Vec3 next = now + dt * change, line = now.stableNormalized();
      if (std::abs(next.norm() - b.length) <= kSameLength * b.length || mobility == 0.0) continue;
      met = false;
      // Solves |next + dt mobility j line| = length for the smaller j. Where there is no solution, the length comes as
      // near as possible.
      const double along = next.dot(line), room = along * along - next.squaredNorm() + b.length * b.length;
      const double j = (std::sqrt(std::max(0.0, room)) - along) / (dt * mobility);
      for (const Term& t : b.terms) {
        ShellState& s = *shells[t.shell].state;
        s.add_velocity(t.slot, t.weight * s.motion.inverse_mass[t.slot] * j * line);
        s.pass_to_supports(t.slot, t.weight * j * line);
      }
    }
    if (!met) ties_.align(shells, dt, true), ties_.keep_creases(shells, dt);
  }
  update_dependent_velocities(shells);
}

void Stitching::store_velocities(const std::vector<ShellRef>& shells) {
  for (DependentPoint& t : dependent_points_) {
    if (!t.holds) continue;
    t.before = shells[t.shell].state->velocity(t.slot);
    for (IndependentPoint& m : t.on) m.before = shells[m.shell].state->velocity(m.slot);
  }
}

void Stitching::move_impulses(const std::vector<ShellRef>& shells) {
  for (const DependentPoint& t : dependent_points_) {
    if (!t.holds) continue;
    ShellState& own = *shells[t.shell].state;
    const double inverse = own.motion.inverse_mass[t.slot];
    if (inverse == 0.0) continue;
    const Vec3 change = own.velocity(t.slot) - t.before;
    if (change.isZero(0.0)) continue;
    const Vec3 impulse = change / inverse;
    // Contact has booked its work as if this control point were independent.
    own.book.contact += 0.5 * impulse.squaredNorm() * inverse;
    for (const IndependentPoint& m : t.on) {
      ShellState& s = *shells[m.shell].state;
      const double mobility = s.motion.inverse_mass[m.slot];
      const Vec3 j = m.weight * impulse;
      s.pass_to_supports(m.slot, j);
      if (mobility == 0.0) continue;
      // The part that is linear in the velocity without impulses is booked.
      own.book.contact -= j.dot(s.velocity(m.slot) - m.before) + 0.5 * mobility * j.squaredNorm();
      s.add_velocity(m.slot, mobility * j);
    }
  }
  // What ties take from motions that contact has made is lost in the contact.
  if (!ties_.empty()) shells[0].state->book.contact += ties_.align(shells, 0.0, true);
  update_dependent_velocities(shells);
}

Stitching::Foot Stitching::place_on_seam(const std::vector<ShellRef>& shells, const Seam& seam, const Term& m,
                                         bool look) {
  const ShellModel& model = *shells[m.shell].model;
  const int point = model.tables.control_point(m.slot), columns = model.patch.columns();
  const int column = point % columns, row = point / columns;
  for (const bool first : {true, false}) {
    const int edge = first ? seam.first_edge : seam.second_edge;
    const int depth = edge == kUMin   ? column
                      : edge == kUMax ? columns - 1 - column
                      : edge == kVMin ? row
                                      : model.patch.rows() - 1 - row;
    if (m.shell != (first ? seam.first : seam.second) || depth >= kSeamRows) continue;
    const int axis = edge < kVMin ? 1 : 0;
    const KnotVector& k = axis == 1 ? model.patch.knots_v : model.patch.knots_u;
    const Vec2 at = model.parameter_of_slot[m.slot];
    const double own = (at[axis] - k.begin()) / (k.end() - k.begin());
    return {first ? 1 : 2, !look || shells[m.shell].state->cracks.graph.visible(at, edge_point(model.patch, edge, own)),
            depth == 0, !first && seam.reversed ? 1.0 - own : own};
  }
  return {};
}

bool Stitching::joins_both_sides(const std::vector<ShellRef>& shells, const Seam& seam,
                                 const std::vector<Term>& terms) {
  int sides = 0;
  for (const Term& m : terms) sides |= place_on_seam(shells, seam, m, false).side;
  return sides == 3;
}

std::vector<Stitching::Term> Stitching::terms_of(const DependentPoint& dependent) {
  std::vector<Term> terms{{dependent.shell, dependent.slot, 1.0}};
  terms.insert(terms.end(), dependent.on.begin(), dependent.on.end());
  return terms;
}

bool Stitching::at_corner(const std::vector<ShellRef>& shells, const DependentPoint& dependent) {
  const ShellModel& m = *shells[dependent.shell].model;
  const int point = m.tables.control_point(dependent.slot), column = point % m.patch.columns(),
            row = point / m.patch.columns();
  return (column == 0 || column == m.patch.columns() - 1) && (row == 0 || row == m.patch.rows() - 1);
}

template <class F>
void Stitching::release_where(const std::vector<ShellRef>& shells, const Seam& seam, F&& across) {
  double lost = 0.0;
  for (DependentPoint& dependent : dependent_points_) {
    const Term own{dependent.shell, dependent.slot, 1.0};
    if (!dependent.holds || at_corner(shells, dependent) || !place_on_seam(shells, seam, own, false).on_seam) continue;
    if (joins_both_sides(shells, seam, terms_of(dependent)) && across(own, dependent.on))
      lost += release_dependent(shells, dependent);
  }
  book_lost(shells, seam.first, lost);
  for (CreaseConstraint& b : crease_constraints_)
    b.holds = b.holds && !(joins_both_sides(shells, seam, b.ends) && across(b.ends[0], b.ends));
}

void Stitching::book_lost(const std::vector<ShellRef>& shells, int shell, double lost) {
  EnergyBook& book = shells[shell].state->book;
  (lost < 0.0 ? book.injected : book.fracture) += std::abs(lost);
}

void Stitching::release_corners(const std::vector<ShellRef>& shells, const std::vector<Seam>& seams) {
  const auto rest = [&](int shell, int slot) -> Vec3 {
    return shells[shell].state->at(shells[shell].model->rest, slot);
  };
  // Tests whether the seam ends at x and still joins its shells at the nearest control points. A seam without such
  // points counts as joined.
  const auto holds_at = [&](const Seam& seam, const Vec3& x) {
    const ShellModel& m = *shells[seam.first].model;
    const std::vector<int> row = edge_row(m.patch, seam.first_edge, 0);
    const double start = (rest(seam.first, m.tables.slot(row.front())) - x).norm(),
                 end = (rest(seam.first, m.tables.slot(row.back())) - x).norm();
    if (std::min(start, end) >= 0.5 * m.spacing) return false;
    const double corner = start < end ? 0.0 : 1.0;
    double nearest = std::numeric_limits<double>::infinity();
    bool holds = true;
    for (const DependentPoint& dependent : dependent_points_) {
      const Foot foot = place_on_seam(shells, seam, {dependent.shell, dependent.slot, 1.0}, false);
      if (!foot.on_seam || at_corner(shells, dependent) || std::abs(foot.share - corner) > nearest) continue;
      if (!joins_both_sides(shells, seam, terms_of(dependent))) continue;
      holds = (std::abs(foot.share - corner) < nearest || holds) && dependent.holds;
      nearest = std::abs(foot.share - corner);
    }
    return holds;
  };
  for (DependentPoint& dependent : dependent_points_) {
    if (!dependent.holds || !at_corner(shells, dependent)) continue;
    std::vector<int> together;  // shells that its terms name, and shells that they reach over joined seams
    std::vector<char> is_named(shells.size(), 0), reached(shells.size(), 0);
    for (const Term& m : terms_of(dependent))
      if (std::abs(m.weight) > kLooseWeight) is_named[m.shell] = 1;
    const Vec3 x = rest(dependent.shell, dependent.slot);
    together.push_back(dependent.shell), reached[dependent.shell] = 1;
    for (std::size_t k = 0; k < together.size(); ++k)
      for (const Seam& seam : seams) {
        if (seam.trimmed() || (seam.first != together[k] && seam.second != together[k])) continue;
        const int other = seam.first == together[k] ? seam.second : seam.first;
        if (reached[other] || !holds_at(seam, x)) continue;
        reached[other] = 1, together.push_back(other);
      }
    bool whole = true;
    for (std::size_t k = 0; k < shells.size(); ++k) whole = whole && (!is_named[k] || reached[k]);
    if (!whole) book_lost(shells, dependent.shell, release_dependent(shells, dependent));
  }
}

void Stitching::part(const std::vector<ShellRef>& shells, const Seam& seam, double t) {
  // Returns the side of the crack, -1 or 1; 0: in neither patch.
  const auto side = [&](const Term& m) {
    const Foot foot = place_on_seam(shells, seam, m, true);
    // An oblique crack passes between a control point of the second row and its foot on the seam.
    return foot.side == 0 ? 0 : (foot.share < t) == foot.clear ? -1 : 1;
  };
  release_where(shells, seam, [&](const Term& a, const auto& others) {
    const int own = side(a);
    return std::any_of(others.begin(), others.end(),
                       [&](const Term& m) { return std::abs(m.weight) > kLooseWeight && own * side(m) < 0; });
  });
}

void Stitching::release_beside(const std::vector<ShellRef>& shells, const Seam& seam, int shell, double low,
                               double high) {
  // Where knots differ, a control point depends on several others. It is released when most of its weight is hidden,
  // not where the crack has yet to arrive.
  release_where(shells, seam, [&](const Term&, const auto& hangs_on) {
    double off = 0.0, all = 0.0;
    for (const Term& m : hangs_on) {
      const Foot foot = place_on_seam(shells, seam, m, true);
      if (m.shell != shell || foot.side == 0 || foot.on_seam) continue;
      all += std::abs(m.weight);
      if (foot.share >= low && foot.share <= high && !foot.clear) off += std::abs(m.weight);
    }
    return off > 0.5 * all;
  });
}

void Stitching::open(const std::vector<ShellRef>& shells, const Seam& seam, double low, double high) {
  const auto within = [&](const Term& m) {
    const Foot foot = place_on_seam(shells, seam, m, false);
    return foot.side != 0 && std::abs(m.weight) > kLooseWeight && foot.share >= low && foot.share <= high;
  };
  release_where(shells, seam, [&](const Term& a, const auto& others) {
    return within(a) || std::any_of(others.begin(), others.end(), within);
  });
}

double Stitching::release_dependent(const std::vector<ShellRef>& shells, DependentPoint& t) {
  const ShellModel& model = *shells[t.shell].model;
  ShellState& own = *shells[t.shell].state;
  const Vec3 place = own.position(t.slot);
  double mass = 0.0, lost = 0.0;
  Vec3 momentum = Vec3::Zero(), turning = Vec3::Zero();  // angular momentum that moving the mass has removed
  for (const IndependentPoint& m : t.on) {
    ShellState& s = *shells[m.shell].state;
    // pieces that were handed off beside it may have taken some of what was shared
    const double least = kSeamMassKept * shells[m.shell].model->mass[m.slot];
    const double part = std::min(m.share * model.mass[t.slot], std::max(0.0, s.motion.mass[m.slot] - least));
    const Vec3 v = s.velocity(m.slot);
    mass += part, momentum += part * v, lost += 0.5 * part * v.squaredNorm();
    turning += part * (s.position(m.slot) - place).cross(v);
    s.motion.mass[m.slot] -= part;
    if (s.motion.inverse_mass[m.slot] > 0.0) s.motion.inverse_mass[m.slot] = 1.0 / s.motion.mass[m.slot];
  }
  own.motion.mass[t.slot] = mass, own.motion.inverse_mass[t.slot] = mass > 0.0 ? 1.0 / mass : 0.0;
  if (mass > 0.0) put(own.motion.v, t.slot, momentum / mass), lost -= 0.5 * momentum.squaredNorm() / mass;
  t.holds = false;
  for (CreaseConstraint& b : crease_constraints_)
    for (const Term& end : b.ends) b.holds = b.holds && (end.shell != t.shell || end.slot != t.slot);
  return lost - turn(shells, t, turning);
}

// Adds a common spin to a released control point and the ones that it depended on. The spin has the angular momentum
// `turning` and no momentum. Where all of them are at one place, as at a crease, the whole shell turns: a spin of such
// near points could not replace what the seam's tolerance has shifted. Returns the kinetic energy that this adds.
double Stitching::turn(const std::vector<ShellRef>& shells, const DependentPoint& t, const Vec3& turning) {
  std::vector<Term> all;
  double mass = 0.0, added = 0.0;
  Vec3 centre;
  Mat3 inertia;
  const auto gather = [&](int shell, int slot) {
    if (shells[shell].state->motion.inverse_mass[slot] > 0.0 && shells[shell].state->motion.mass[slot] > 0.0)
      all.push_back({shell, slot, 1.0});
  };
  const auto weigh = [&] {
    mass = 0.0, centre.setZero(), inertia.setZero();
    for (const Term& m : all) {
      const ShellState& s = *shells[m.shell].state;
      mass += s.motion.mass[m.slot], centre += s.motion.mass[m.slot] * s.position(m.slot);
    }
    centre /= mass;
    for (const Term& m : all) {
      const ShellState& s = *shells[m.shell].state;
      const Vec3 arm = s.position(m.slot) - centre;
      inertia += s.motion.mass[m.slot] * (arm.squaredNorm() * Mat3::Identity() - arm * arm.transpose());
    }
  };
  gather(t.shell, t.slot);
  for (const IndependentPoint& m : t.on) gather(m.shell, m.slot);
  if (all.size() < 2) return 0.0;
  weigh();
  if (inertia.trace() <= mass * std::pow(kOnePlace * shells[t.shell].model->spacing, 2)) {
    all.clear();
    for (std::size_t slot = 0; slot < shells[t.shell].state->motion.mass.size(); ++slot)
      gather(t.shell, static_cast<int>(slot));
    weigh();
  }
  const auto [moments, axes] = principal_axes(inertia);
  Vec3 spin = Vec3::Zero();  // no spin about a line on which all of them lie
  for (int d = 0; d < 3; ++d)
    if (moments[d] > kOnALine * moments[2]) spin += axes.col(d).dot(turning) / moments[d] * axes.col(d);
  for (const Term& m : all) {
    ShellState& s = *shells[m.shell].state;
    const Vec3 change = spin.cross(s.position(m.slot) - centre);
    added += s.motion.mass[m.slot] * change.dot(s.velocity(m.slot) + 0.5 * change);
    s.add_velocity(m.slot, change);
  }
  return added;
}

}  // namespace sunder::shell
