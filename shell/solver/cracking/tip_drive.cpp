#include "shell/solver/cracking/tip_drive.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "shell/mechanics/principal.h"

namespace sunder::shell {
namespace {

// Sums over the points around a start, weighted about one direction.
struct Sums {
  double face_stress[6] = {}, weight = 0.0;
};

// Resistance of a young crack. An even field of the strength makes it sharper as the root of its length, until it needs
// the energy at its critical length.
double resistance(double sharp, const Start& start) {
  if (start.grown >= 1.0 || start.strength >= sharp) return sharp;
  const double blunt = start.strength * start.strength;
  return std::sqrt(blunt + start.grown * (sharp * sharp - blunt));
}

Drive drive_along(const Sums& sums, const CrackRules& r, const Start& start, double turn) {
  Drive best;
  best.turn = turn;
  if (!(sums.weight > 0.0)) return best;
  const Vec2 c = turned(start.direction, turn);
  const double stretching = resistance(r.tip_strength, start), bending = resistance(r.tip_bending_strength, start);
  const double low = across(sums.face_stress, c) / sums.weight, high = across(sums.face_stress + 3, c) / sums.weight;
  for (const int face : {-1, 1}) {
    if (face == -start.face && turn != 0.0) continue;
    const double here = face < 0 ? low : high, there = face < 0 ? high : low;
    const double stretch = 0.5 * (here + there), bend = 0.5 * (here - there);
    const double stretched = std::max(0.0, stretch) / stretching;
    const double bent = std::max(0.0, stretch > 0.0 ? bend : here) / bending, ratio = std::hypot(stretched, bent);
    if (ratio > best.ratio) best.ratio = ratio, best.face = face, best.bent = std::pow(bent / ratio, 2);
  }
  return best;
}

// Whether moments ahead twist the sheet more than they or stretch open the crack. Where it is torn out of its plane,
// face stress has no say in the direction: what opens one face on the left opens the other one on the right.
bool is_twisted(const Sums& sums, const CrackRules& r, const Vec2& d) {
  if (!(sums.weight > 0.0)) return false;
  double bend[3], mean[3];
  for (int k = 0; k < 3; ++k) {
    bend[k] = 0.5 * (sums.face_stress[3 + k] - sums.face_stress[k]) / sums.weight;
    mean[k] = 0.5 * (sums.face_stress[3 + k] + sums.face_stress[k]) / sums.weight;
  }
  const Vec2 left(-d.y(), d.x());
  const double twist =
      d.x() * left.x() * bend[0] + d.y() * left.y() * bend[1] + (d.x() * left.y() + d.y() * left.x()) * bend[2];
  return std::abs(twist) > std::abs(across(bend, d)) &&
         std::abs(twist) / r.tip_bending_strength > std::abs(across(mean, d)) / r.tip_strength;
}

// Mean of an angular function over the wedge straight ahead, times the mean of sqrt(R / r), with the weights of
// drive_at.
template <class F>
double mean_ahead(F&& opening) {
  double sum = 0.0, weight = 0.0;
  for (int i = 0; i < kWedgePoints; ++i) {
    const double t = kFlankAngle * (2.0 * (i + 0.5) / kWedgePoints - 1.0), w = wedge(t);
    sum += w * opening(t), weight += w;
  }
  return kRadialMean * sum / weight;
}

// Energies of a field that stretches and bends, over those of a field that only stretches, with the same stress on the
// opened face.
struct Opening {
  double released = 0.0;  // by a crack; 0: the field does not open it
  double stored = 0.0;
};

Opening opening_of(const ShellMaterial& material, double stretching, double bending) {
  const double sum = std::max(0.0, stretching) + bending, nu = material.poisson_ratio;
  if (!(sum > 0.0)) return {};
  const double bent = bending / sum, stretched = 1.0 - bent;
  return {stretched * stretched + bent * bent * (1.0 + nu) / (3.0 * (3.0 + nu)), stored_by(stretched, bent)};
}

}  // namespace

bool face_stress_at(const ShellModel& m, const ShellState& s, int block, int lane, double* face_stress) {
  if (s.cracked.kind(static_cast<std::size_t>(block) * m.tables.lanes + lane) == PointKind::kDead) return false;
  for (int k = 0; k < 6; ++k) face_stress[k] = s.layers.face_stress[m.tables.at(block, 6, k, lane)];
  return true;
}

bool mean_stress(const ShellModel& m, const ShellState& s, const Vec2& p, double radius, Neighbours& known,
                 double* face_stress) {
  std::fill(face_stress, face_stress + 6, 0.0);
  double sum = 0.0;
  for (const Neighbours::Seen& q : known.seen(m, s.cracks.graph, p, radius)) {
    double here[6];
    if (!face_stress_at(m, s, q.block, q.lane, here)) continue;
    sum += q.weight;
    for (int k = 0; k < 6; ++k) face_stress[k] += q.weight * here[k];
  }
  for (int k = 0; k < 6 && sum > 0.0; ++k) face_stress[k] /= sum;
  return sum > 0.0;
}

Drive drive_at(const ShellModel& m, const ShellState& s, const CrackRules& r, const Start& start) {
  Surroundings unknown;
  return drive_at(m, s, r, start, unknown);
}

Drive drive_at(const ShellModel& m, const ShellState& s, const CrackRules& r, const Start& start, Surroundings& known) {
  // one step further than the largest turn: the turn by the lattice is taken off first
  const double furthest = start.most_turn > 0.0 ? start.most_turn + kTurnStep : 0.0;
  const int steps = static_cast<int>(std::ceil(furthest / kTurnStep - 1e-9));
  const double step = steps > 0 ? furthest / steps : 0.0;
  thread_local std::vector<Sums> all;  // direction k of -steps .. steps at steps + k
  all.assign(2 * steps + 1, {});
  Sums* const ahead = &all[steps];
  for (const SeenPoint& q : known.seen(m, s.cracks.graph, {start.p, r.tip_radius, start.direction, start.edge})) {
    double here[6];
    if (!face_stress_at(m, s, q.block, q.lane, here)) continue;
    const double factor = m.strength_factor_at(q.block, q.lane);  // of the resistance there
    if (factor != 1.0)
      for (double& stress : here) stress /= factor;
    const double straight = q.ahead, tilt = step == kTurnStep ? q.tilt : wedge_tilt(q.angle, step);
    for (const int sign : {-1, 1}) {
      const double times = sign < 0 ? 1.0 / tilt : tilt;
      double w = straight;
      for (int k = sign < 0 ? 1 : 0; k <= steps; ++k) {
        if (k > 0) w *= times;
        Sums& sum = ahead[sign * k];
        sum.weight += w;
        for (int c = 0; c < 6; ++c) sum.face_stress[c] += w * here[c];
      }
    }
  }
  Drive best = drive_along(ahead[0], r, start, 0.0);
  int at = 0;
  for (int k = 1; k <= steps; ++k)
    for (const int sign : {-1, 1}) {
      const Drive d = drive_along(ahead[sign * k], r, start, sign * step * k);
      if (d.ratio > best.ratio) best = d, at = sign * k;
    }
  if (std::abs(at) < steps) {  // the top of a parabola, between the directions tried
    const double before = drive_along(ahead[at - 1], r, start, (at - 1) * step).ratio,
                 after = drive_along(ahead[at + 1], r, start, (at + 1) * step).ratio;
    const double bend = before - 2.0 * best.ratio + after;
    if (bend < 0.0) best.turn += 0.5 * step * std::clamp((before - after) / bend, -1.0, 1.0);
  }
  const double angle = std::atan2(start.direction.y() / m.spacing_v, start.direction.x() / m.spacing_u);
  const double off = r.to_diagonal * best.bent * std::sin(4.0 * angle), wanted = best.turn - off;
  const double turn = std::clamp(wanted, -start.most_turn, start.most_turn);
  if (turn != wanted && steps > 0) {  // then the drive is that at the largest turn
    const double at_most = (turn + off) / step;
    const int low = std::clamp(static_cast<int>(std::floor(at_most)), -steps, steps - 1);
    const Drive before = drive_along(ahead[low], r, start, low * step),
                after = drive_along(ahead[low + 1], r, start, (low + 1) * step);
    const double part = at_most - low;
    best = before.ratio > after.ratio ? before : after;  // the weaker one may be closed, and then has no face
    best.ratio = (1.0 - part) * before.ratio + part * after.ratio;
  }
  best.turn = turn;
  best.twisted = is_twisted(ahead[0], r, start.direction);
  return best;
}

// K = sqrt(E G): sigma = K / sqrt(2 pi r) cos(t/2) (1 + sin(t/2) sin(3t/2))
double stretching_mean() {
  return mean_ahead([](double t) { return std::cos(0.5 * t) * (1.0 + std::sin(0.5 * t) * std::sin(1.5 * t)); }) /
         std::sqrt(2.0 * std::numbers::pi);
}

// Williams 1961: surface stress k / sqrt(2 r) g(t) with the energy release k^2 pi (1 + nu) / (3 E (3 + nu)); g from
// w = r^3/2 (a cos 3t/2 + b cos t/2) with free faces.
double bending_mean(double nu) {
  const double mean = mean_ahead([nu](double t) {
    const double c1 = std::cos(0.5 * t), c3 = std::cos(1.5 * t), s = std::sin(t), c = std::cos(t);
    const double rr = (3.0 + 5.0 * nu) * c1 - (7.0 + nu) * c3, tt = (5.0 + 3.0 * nu) * c1 + (7.0 + nu) * c3;
    const double rt = (7.0 + nu) * std::sin(1.5 * t) - (1.0 - nu) * std::sin(0.5 * t);
    return (rr * s * s + tt * c * c + 2.0 * rt * s * c) / (4.0 * (3.0 + nu));
  });
  return mean / std::numbers::sqrt2 * std::sqrt(3.0 * (3.0 + nu) / (std::numbers::pi * (1.0 + nu)));
}

double critical_length(const ShellMaterial& material, double strength, double stretching, double bending) {
  const Opening opening = opening_of(material, stretching, bending);
  if (!(opening.released > 0.0)) return std::numeric_limits<double>::infinity();
  return material.youngs_modulus * material.fracture_energy /
         (std::numbers::pi * strength * strength * opening.released);
}

double stored_by(double stretching, double bending) {
  const double stretched = std::max(0.0, stretching);
  return stretched * stretched + bending * bending / 3.0;
}

double zone_radius(const ShellMaterial& material, double half_length, double stretching, double bending) {
  const Opening opening = opening_of(material, stretching, bending);
  return opening.stored > 0.0 ? half_length * std::sqrt(4.0 * opening.released / opening.stored) : half_length;
}

}  // namespace sunder::shell
