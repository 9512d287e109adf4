#include "shell/solver/stitching.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

namespace sunder::shell {
namespace {

// Of the bending stiffness of an element of the width: a crease then gives way a little more than the shell beside it.
constexpr double kBraceStiffness = 30.0;
constexpr double kMostOfStable = 0.05;  // of the stiffness that a control point's stable step bears, 4 m / dt^2
constexpr double kAcross = 0.02;        // weight that binds over a crack
constexpr double kLeastMass = 0.25;     // of its own, that a control point keeps when another is let go
constexpr double kFlat = 0.03;          // of the rows' distance: a crease as flat as this has no arm to be braced by

void add(std::vector<double>& a, int slot, const Vec3& value) {
  const std::size_t plane = a.size() / 3;
  for (int d = 0; d < 3; ++d) a[d * plane + slot] += value[d];
}
void put(std::vector<double>& a, int slot, const Vec3& value) {
  const std::size_t plane = a.size() / 3;
  for (int d = 0; d < 3; ++d) a[d * plane + slot] = value[d];
}

}  // namespace

Stitching::Stitching(const Stitches& stitches, const std::vector<const ShellModel*>& shells) {
  const auto slot = [&](const PatchPoint& p) { return shells[p.patch]->tables.slot(p.point); };
  for (const Dependence& d : stitches.points) {
    Tie t;
    t.shell = d.point.patch, t.slot = slot(d.point);
    if (shells[t.shell]->held[t.slot]) continue;  // a support holds it anyway
    for (const auto& [p, weight] : d.on) t.on.push_back({p.patch, slot(p), weight});
    ties_.push_back(std::move(t));
  }
  for (const Seam& seam : stitches.seams)
    for (const CreasePoint& c : seam.crease) {
      const ShellModel &one = *shells[seam.first], &two = *shells[seam.second];
      const auto rest = [&](const PatchPoint& p) { return shells[p.patch]->patch.control_points[p.point]; };
      Vec3 b = Vec3::Zero();
      Brace brace;
      brace.shell = c.first.patch, brace.slot = slot(c.first);
      double mass = one.mass[brace.slot];
      for (const auto& [p, weight] : c.second) {
        brace.other.push_back({p.patch, slot(p), weight});
        b += weight * rest(p);
        mass = std::min(mass, shells[p.patch]->mass[slot(p)]);
      }
      const Vec3 a = rest(c.first), edge = rest(c.on_seam), chord = b - a;
      brace.length = chord.norm();
      const double h = 0.5 * ((a - edge).norm() + (b - edge).norm());
      // the arm of the spring about the crease
      const double arm = (a - edge).cross(chord).norm() / std::max(brace.length, 1e-300);
      if (!(arm > kFlat * h)) continue;
      const auto bending = [](const ShellModel& m) {
        const ShellMaterial& q = m.material;
        return q.youngs_modulus * std::pow(m.thickness, 3) / (12.0 * (1.0 - q.poisson_ratio * q.poisson_ratio));
      };
      const double wanted = kBraceStiffness * std::min(bending(one), bending(two)) * c.width / (h * arm * arm);
      // of membranes, which set the step: about 4 c^2 / h^2 times the mass
      const double speed = std::max(one.wave_speed(), two.wave_speed()) / std::min(one.spacing, two.spacing);
      brace.stiffness = std::min(wanted, kMostOfStable * 4.0 * mass * speed * speed);
      braces_.push_back(std::move(brace));
    }
}

void Stitching::tie(const std::vector<ShellRef>& shells) {
  for (const Tie& t : ties_) {
    double& mass = shells[t.shell].state->mass[t.slot];
    for (const Master& m : t.on) {
      ShellState& s = *shells[m.shell].state;
      s.mass[m.slot] += m.weight * mass;
      if (s.inverse_mass[m.slot] > 0.0) s.inverse_mass[m.slot] = 1.0 / s.mass[m.slot];
    }
    mass = 0.0;
  }
  for (const Tie& t : ties_) refresh(shells, t);
  follow(shells);
}

void Stitching::follow(const std::vector<ShellRef>& shells) const {
  for (const Tie& t : ties_) {
    if (!t.holds) continue;
    Vec3 v = Vec3::Zero();
    for (const Master& m : t.on) v += m.weight * shells[m.shell].state->velocity(m.slot);
    put(shells[t.shell].state->v, t.slot, v);
  }
}

void Stitching::refresh(const std::vector<ShellRef>& shells, const Tie& t) {
  double inverse = 0.0;
  for (const Master& m : t.on) inverse += m.weight * m.weight * shells[m.shell].state->inverse_mass[m.slot];
  shells[t.shell].state->inverse_mass[t.slot] = inverse;
}

double Stitching::share_forces(const std::vector<ShellRef>& shells) {
  double energy = 0.0;
  for (const Brace& b : braces_) {
    if (!b.holds) continue;
    Vec3 to = Vec3::Zero();
    for (const Master& m : b.other) to += m.weight * shells[m.shell].state->position(m.slot);
    const Vec3 chord = to - shells[b.shell].state->position(b.slot);
    const double length = chord.norm(), longer = length - b.length;
    const Vec3 pull = b.stiffness * longer / std::max(length, 1e-300) * chord;
    energy += 0.5 * b.stiffness * longer * longer;
    add(shells[b.shell].state->force, b.slot, pull);
    for (const Master& m : b.other) add(shells[m.shell].state->force, m.slot, -m.weight * pull);
  }
  for (const Tie& t : ties_) {
    if (!t.holds) continue;
    const ShellState& own = *shells[t.shell].state;
    const Vec3 force = own.at(own.force, t.slot);
    for (const Master& m : t.on) add(shells[m.shell].state->force, m.slot, m.weight * force);
  }
  for (const Tie& t : ties_) {
    if (!t.holds) continue;
    refresh(shells, t);
    ShellState& own = *shells[t.shell].state;
    Vec3 acceleration = Vec3::Zero();
    for (const Master& m : t.on) {
      const ShellState& s = *shells[m.shell].state;
      acceleration += m.weight * s.inverse_mass[m.slot] * s.at(s.force, m.slot);
    }
    const double inverse = own.inverse_mass[t.slot];
    put(own.force, t.slot, inverse > 0.0 ? Vec3(acceleration / inverse) : Vec3(Vec3::Zero()));
  }
  return energy;
}

void Stitching::mark(const std::vector<ShellRef>& shells) {
  for (Tie& t : ties_) {
    if (!t.holds) continue;
    t.before = shells[t.shell].state->velocity(t.slot);
    for (Master& m : t.on) m.before = shells[m.shell].state->velocity(m.slot);
  }
}

void Stitching::share_impulses(const std::vector<ShellRef>& shells) {
  for (const Tie& t : ties_) {
    if (!t.holds) continue;
    ShellState& own = *shells[t.shell].state;
    const double inverse = own.inverse_mass[t.slot];
    if (inverse == 0.0) continue;
    const Vec3 change = own.velocity(t.slot) - t.before;
    if (change.isZero(0.0)) continue;
    const Vec3 impulse = change / inverse;
    // contact has booked the work as if this control point had moved by itself
    own.book.contact += 0.5 * impulse.squaredNorm() * inverse;
    for (const Master& m : t.on) {
      ShellState& s = *shells[m.shell].state;
      const double mobility = s.inverse_mass[m.slot];
      if (mobility == 0.0) continue;
      const Vec3 j = m.weight * impulse;
      // the part that is linear at the velocity without impulses is booked
      own.book.contact -= j.dot(s.velocity(m.slot) - m.before) + 0.5 * mobility * j.squaredNorm();
      s.add_velocity(m.slot, mobility * j);
    }
  }
  follow(shells);
}

void Stitching::part(const std::vector<ShellRef>& shells, const Seam& seam, double t) {
  // which side of the crack; 0: of neither patch
  const auto side = [&](int shell, int slot) {
    if (shell != seam.first && shell != seam.second) return 0;
    const int edge = shell == seam.first ? seam.first_edge : seam.second_edge, axis = edge < kVMin ? 1 : 0;
    const KnotVector& k = axis == 1 ? shells[shell].model->patch.knots_v : shells[shell].model->patch.knots_u;
    double share = (shells[shell].model->of_slot[slot][axis] - k.begin()) / (k.end() - k.begin());
    if (shell == seam.second && seam.reversed) share = 1.0 - share;
    return share < t ? -1 : 1;
  };
  for (Tie& tie : ties_) {
    if (!tie.holds) continue;
    const int own = side(tie.shell, tie.slot);
    const bool across = std::any_of(tie.on.begin(), tie.on.end(), [&](const Master& m) {
      return std::abs(m.weight) > kAcross && own * side(m.shell, m.slot) < 0;
    });
    const bool of_seam = std::any_of(tie.on.begin(), tie.on.end(), [&](const Master& m) {
      return (m.shell == seam.first || m.shell == seam.second) && m.shell != tie.shell;
    });
    if (across && of_seam) let_go(shells, tie);
  }
  for (Brace& b : braces_) {
    const int own = side(b.shell, b.slot);
    for (const Master& m : b.other)
      if (std::abs(m.weight) > kAcross && own * side(m.shell, m.slot) < 0) b.holds = false;
  }
}

void Stitching::let_go(const std::vector<ShellRef>& shells, Tie& t) {
  const ShellModel& model = *shells[t.shell].model;
  double mass = 0.0;
  Vec3 momentum = Vec3::Zero();
  for (const Master& m : t.on) {
    ShellState& s = *shells[m.shell].state;
    // pieces that have left beside it may have taken some of what was shared
    const double least = kLeastMass * shells[m.shell].model->mass[m.slot];
    const double part = std::min(m.weight * model.mass[t.slot], std::max(0.0, s.mass[m.slot] - least));
    mass += part, momentum += part * s.velocity(m.slot);
    s.mass[m.slot] -= part;
    if (s.inverse_mass[m.slot] > 0.0) s.inverse_mass[m.slot] = 1.0 / s.mass[m.slot];
  }
  ShellState& own = *shells[t.shell].state;
  own.mass[t.slot] = mass, own.inverse_mass[t.slot] = mass > 0.0 ? 1.0 / mass : 0.0;
  if (mass > 0.0) put(own.v, t.slot, momentum / mass);
  t.holds = false;
}

double stable_step(const std::vector<ShellRef>& shells, Stitching& stitching, int iterations, int threads,
                   const std::vector<char>& as_if_free) {
  struct Kept {
    std::vector<double> x, v, force, f0, inverse_mass;
  };
  std::vector<Kept> kept;
  std::mt19937_64 random(1);
  double epsilon = 1e300, points = 0.0;
  for (std::size_t k = 0; k < shells.size(); ++k) {
    const ShellModel& m = *shells[k].model;
    ShellState& s = *shells[k].state;
    kept.push_back({s.x, s.v, s.force, {}, s.inverse_mass});
    for (std::size_t i = 0; i < s.inverse_mass.size(); ++i)
      if (as_if_free[k] && m.held[i] && s.mass[i] > 0.0) s.inverse_mass[i] = 1.0 / s.mass[i];
    for (double& v : s.v) v = static_cast<double>(random() >> 11) * 0x1.0p-52 - 1.0;
    epsilon = std::min(epsilon, 1e-7 * m.spacing), points += m.control_points();
  }
  epsilon *= std::sqrt(points);
  const auto forces = [&] {
    for (const ShellRef& r : shells) compute_forces(*r.model, *r.state, false, 0.0, threads);
    stitching.share_forces(shells);
  };
  forces();
  for (std::size_t k = 0; k < shells.size(); ++k) kept[k].f0 = shells[k].state->force;
  stitching.follow(shells);  // velocities are the mode
  double lambda = 0.0;
  for (int it = 0; it < iterations; ++it) {
    double norm = 0.0;
    for (const ShellRef& r : shells)
      for (std::size_t i = 0; i < r.state->v.size(); ++i) {
        if (r.state->inverse_mass[i % r.state->inverse_mass.size()] == 0.0) r.state->v[i] = 0.0;
        norm += r.state->v[i] * r.state->v[i];
      }
    norm = std::sqrt(norm);
    if (norm == 0.0) break;
    for (std::size_t k = 0; k < shells.size(); ++k) {
      ShellState& s = *shells[k].state;
      for (std::size_t i = 0; i < s.x.size(); ++i) s.x[i] = kept[k].x[i] + epsilon * (s.v[i] / norm);
    }
    forces();
    double sum = 0.0;
    for (std::size_t k = 0; k < shells.size(); ++k) {
      ShellState& s = *shells[k].state;
      const std::size_t plane = s.inverse_mass.size();
      for (std::size_t i = 0; i < s.v.size(); ++i) {
        s.v[i] = -(s.force[i] - kept[k].f0[i]) / epsilon * s.inverse_mass[i % plane];
        sum += s.v[i] * s.v[i];
      }
    }
    lambda = std::sqrt(sum);
  }
  double damped = 0.0;
  const double omega = std::sqrt(lambda);
  for (std::size_t k = 0; k < shells.size(); ++k) {
    ShellState& s = *shells[k].state;
    s.x = std::move(kept[k].x), s.v = std::move(kept[k].v), s.force = std::move(kept[k].force);
    s.inverse_mass = std::move(kept[k].inverse_mass);
    const ShellMaterial& q = shells[k].model->material;
    damped = std::max(damped, 0.5 * (q.stiffness_damping * omega + q.mass_damping / omega));
  }
  if (lambda <= 0.0) return std::numeric_limits<double>::infinity();
  return 2.0 / omega * (std::sqrt(1.0 + damped * damped) - damped);
}

}  // namespace sunder::shell
