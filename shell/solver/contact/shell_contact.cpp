#include "shell/solver/contact/shell_contact.h"

#include "shell/solver/contact/rigid_contact.h"

#include <algorithm>

namespace sunder::shell {
namespace {

// Passes of contact in a substep. An impulse on control points moves the surface by only a share of it. The share falls
// with the number of touching samples. One pass lets some layers of a crumpled sheet cross, also with a second pass
// that only stops them; with two passes a few cross for some steps (validate contact --case crumple_starts). A third
// pass does not help.
constexpr int kPasses = 2;
// Fastest recovery of an overlap: a share of the slower shell's wave speed, and a speed [m/s]. What is parted faster
// gains energy, as torn cloth does with a share several times as large. No layers of a crumpled film cross with six
// times as much beyond half of the thickness; but then contact gives a garment back all that it has taken.
constexpr double kRecoveryOfWave = 0.01, kFastestRecovery = 1.0;

double recovery_of(const ShellModel& a, const ShellModel& b) {
  return std::min(kFastestRecovery, kRecoveryOfWave * std::min(a.wave_speed(), b.wave_speed()));
}

std::vector<std::vector<SurfaceLaw>> with_recovery(const std::vector<const ShellModel*>& shells,
                                                   std::vector<std::vector<SurfaceLaw>> laws) {
  for (std::size_t i = 0; i < shells.size(); ++i)
    for (std::size_t k = 0; k < shells.size(); ++k) laws[i][k].recovery = recovery_of(*shells[i], *shells[k]);
  return laws;
}

double widest(const std::vector<const ShellModel*>& shells) {
  double h = 0.0;
  for (const ShellModel* m : shells) h = std::max(h, std::max(m->longest_element, 2.0 * m->largest_thickness()));
  return h;
}

// Applies impulse j [N s] to a control point and books its work. Returns the energy [J] that it has taken.
double push(ShellState& s, int slot, const Vec3& j, double dt) {
  const double mobility = s.motion.inverse_mass[slot];
  s.count_contact(slot, j);
  if (mobility == 0.0) s.pass_to_supports(slot, j);
  if (mobility == 0.0 || j.isZero(0.0)) return 0.0;
  // Velocity at the time of the positions, half a kick earlier.
  const Vec3 back = 0.5 * dt * mobility * s.at(s.motion.force, slot);
  const double taken = -j.dot(s.velocity(slot) + 0.5 * mobility * j - back);
  s.book.contact += taken;
  s.add_velocity(slot, mobility * j);
  return taken;
}

}  // namespace

ShellContact::ShellContact(const std::vector<const ShellModel*>& shells, const std::vector<Seam>& seams,
                           std::vector<std::vector<SurfaceLaw>> laws)
    : fields_(widest(shells), components(shells.size(), seams), with_recovery(shells, std::move(laws))),
      near_(shells, {}, components(shells.size(), seams), fields_.spacing(), fields_.one_surface()) {
  for (const ShellModel* m : shells) {
    impulses_.emplace_back(m->tables.component_stride, Vec3::Zero());
    touched_.emplace_back();
    double mass = 0.0, fastest = 0.0;
    for (const double part : m->mass) mass += part;
    for (const ShellModel* other : shells) fastest = std::max(fastest, recovery_of(*m, *other));
    lent_ += 0.5 * mass * fastest * fastest;
  }
}

void ShellContact::refresh(const std::vector<ShellRef>& shells, double dt) {
  near_.refresh(shells, dt);
  samples_.clear(), functions_.clear(), first_.assign(1, 0);
  for (const Tile& tile : near_.tiles())
    if (tile.candidate) add_samples(shells[tile.shell], tile);
}

void ShellContact::add_samples(const ShellRef& shell, const Tile& tile) {
  const ShellModel& m = *shell.model;
  const ShellState& s = *shell.state;
  const RowTables& t = m.tables;
  NearTiles::each_gauss_point(m, tile, [&](int block, int lane, double area) {
    sample_functions(m, s, block, lane, gathered_);
    if (gathered_.empty() || s.motion.detached[gathered_[0].slot]) return;
    const ShapeFunctions n = m.patch.shape_functions(gauss_point(m.patch, t, block, lane).parameter);
    const auto normal = [&](const std::vector<double>& at) -> Vec3 {
      Vec3 u = Vec3::Zero(), v = Vec3::Zero();
      for (int k = 0; k < n.count(); ++k) {
        const Vec3 x = s.at(at, n.row(k) * t.stride + n.column(k));
        u += n.u[k] * x, v += n.v[k] * x;
      }
      return u.cross(v).normalized();
    };
    SurfaceSample q;
    q.normal = normal(s.motion.x), q.rest_normal = normal(m.rest), q.area = area / t.thickness_factor(block, lane);
    if (!q.normal.allFinite()) return;
    q.mass = m.material.density * m.thickness * area, q.thickness = m.thickness_at(block, lane), q.shell = tile.shell;
    q.rest = Vec3::Zero();
    for (const GatheredFunction& g : gathered_) {
      functions_.emplace_back(g.slot, g.n[0]);
      q.rest += g.n[0] * s.at(m.rest, g.slot);
    }
    if (!m.mass_factor_of_slot.empty()) {
      double factor = 0.0;
      for (const GatheredFunction& g : gathered_) factor += g.n[0] * m.mass_factor(g.slot);
      q.mass *= factor;
    }
    samples_.push_back(q), first_.push_back(functions_.size());
  });
}

int ShellContact::act(const std::vector<ShellRef>& shells, double dt, const std::function<void()>& share,
                      const Exchange& exchanged) {
  if (age_++ % kContactRefresh == 0) refresh(shells, dt), age_ = 1;
  if (samples_.empty()) return 0;
  for (std::size_t p = 0; p < samples_.size(); ++p) {
    SurfaceSample& q = samples_[p];
    const ShellState& s = *shells[q.shell].state;
    q.x = q.v = Vec3::Zero();
    each_function(p, [&](int slot, double n) { q.x += n * s.position(slot), q.v += n * s.velocity(slot); });
  }
  if (!fields_.find(samples_, dt)) return 0;
  const bool may_give = taken_ > -lent_;
  const int touching = fields_.push(samples_, dt, may_give);
  for (int pass = 1; touching > 0; ++pass) {
    add_impulses_to_control_points(shells, dt);
    if (exchanged)
      fields_.each_exchange(samples_, [&](int a, int b, const Vec3& j) {
        if (a != b) exchanged(a, b, j);
      });
    separate_folds(shells, dt, may_give, exchanged);
    if (pass == kPasses) break;
    if (share) share();
    for (const int p : fields_.near()) {
      SurfaceSample& q = samples_[p];
      q.v.setZero();
      each_function(p, [&](int slot, double n) { q.v += n * shells[q.shell].state->velocity(slot); });
    }
    fields_.push(samples_, dt, may_give);
  }
  return touching;
}

// Separates the samples of a fold, pair by pair, along the line between them; this conserves angular momentum. Both
// samples share most control points, whose mass against separation is many times that of the samples. The samples are
// stopped with that mass, and separated with their own, or control points would be thrown. A held control point counts
// as free; otherwise the last free one beside it would be thrown. Beside dependent control points, which pass impulses
// on later, the samples' own mass is used for stopping too.
void ShellContact::separate_folds(const std::vector<ShellRef>& shells, double dt, bool may_give,
                                  const Exchange& exchanged) {
  for (const FieldContact::Close& c : fields_.folds()) {
    const Vec3 line = samples_[c.q].x - samples_[c.p].x;
    const double apart = line.norm();
    if (apart == 0.0) continue;
    parting_.clear();
    const auto add = [&](int sample, double sign) {
      each_function(sample, [&](int slot, double n) {
        const int shell = samples_[sample].shell;
        const auto known = std::find_if(parting_.begin(), parting_.end(),
                                        [&](const Share& s) { return s.shell == shell && s.slot == slot; });
        if (known == parting_.end())
          parting_.push_back({shell, slot, sign * n});
        else
          known->share += sign * n;
      });
    };
    add(c.p, -1.0), add(c.q, 1.0);
    const Vec3 n = line / apart;
    double approach = 0.0, mobility = 0.0;
    bool depends = false;
    for (const Share& p : parting_) {
      const ShellState& s = *shells[p.shell].state;
      approach += p.share * n.dot(s.velocity(p.slot));
      double inverse = s.motion.inverse_mass[p.slot];
      if (inverse > 0.0 && s.motion.mass[p.slot] == 0.0) depends = true;
      if (inverse == 0.0 && s.motion.mass[p.slot] > 0.0) inverse = 1.0 / s.motion.mass[p.slot];
      mobility += p.share * p.share * inverse;
    }
    const double parting = FieldContact::parting(c, apart, approach, dt),
                 wanted = may_give ? parting : std::min(parting, 0.0);
    if (mobility == 0.0 || approach >= wanted) continue;
    const double stop = std::max(0.0, std::min(wanted, 0.0) - approach), rest = wanted - approach - stop;
    const double own = 1.0 / (1.0 / samples_[c.p].mass + 1.0 / samples_[c.q].mass);
    const double given = std::min(own, 1.0 / mobility);
    const double j = (depends ? given * stop : stop / mobility) + given * rest;
    for (const Share& p : parting_) taken_ += push(*shells[p.shell].state, p.slot, p.share * j * n, dt);
    if (const int a = samples_[c.p].shell, b = samples_[c.q].shell; exchanged && a != b) exchanged(a, b, j * n);
  }
}

// Distributes the samples' impulses to the control points.
void ShellContact::add_impulses_to_control_points(const std::vector<ShellRef>& shells, double dt) {
  for (const int p : fields_.near()) {
    const SurfaceSample& q = samples_[p];
    if (q.impulse.isZero(0.0)) continue;
    each_function(p, [&](int slot, double n) {
      Vec3& sum = impulses_[q.shell][slot];
      if (sum.isZero(0.0)) touched_[q.shell].push_back(slot);
      sum += n * q.impulse;
    });
  }
  for (std::size_t k = 0; k < shells.size(); ++k) {
    ShellState& s = *shells[k].state;
    for (const int slot : touched_[k]) {
      taken_ += push(s, slot, impulses_[k][slot], dt);
      impulses_[k][slot].setZero();
    }
    touched_[k].clear();
  }
}

}  // namespace sunder::shell
