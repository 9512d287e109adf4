#include "shell/geometry/trim_seams.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <Eigen/Dense>

#include "coupler/core/error.h"
#include "shell/geometry/edges.h"

namespace sunder::shell {
namespace {

constexpr int kPlacesPerElement = 8;    // along a seam, of the smaller elements
constexpr int kFewestPieces = 2;        // of a curve of a border
constexpr int kMostPieces = 20000;      // of a border
constexpr int kBorderSections = 60;     // steps that bracket the nearest point of a border
constexpr int kEndSteps = 45;           // bisections for the end of a seam
constexpr double kFarChords = 2.0;      // chords: a point further off is not on the border
constexpr double kNearBorder = 0.2;     // borders within this share of the smaller elements nearly meet
constexpr double kBeyondCorner = 10.0;  // tolerances: such a piece at the end of a seam is left out
constexpr double kNearLength = 3.0;     // over this length [elements]
constexpr double kShortest = 0.5;       // a stretch that is shorter is none [elements]
constexpr double kLookAside = 0.05;     // distance at which a loop is asked on which side the patch is [elements]
constexpr double kOnSide = 1e-9;        // share of the domain: a point this near a side of the patch is on it
constexpr double kAskewBorder = 0.1;    // cosine of normals that are clearly on one side or on opposite sides

// A closed border over t from 0 to the number of its curves.
struct Border {
  const BorderedPatch* of = nullptr;
  std::vector<PlaneCurve> curves;
  std::vector<double> t;  // of samples, growing; the last one is the first again
  std::vector<Vec3> x;

  Vec2 place(double at) const {
    const double count = static_cast<double>(curves.size()), turn = at - count * std::floor(at / count);
    const std::size_t k = std::min(curves.size() - 1, static_cast<std::size_t>(turn));
    return curves[k].at(turn - static_cast<double>(k));
  }
  Vec3 point(double at) const { return of->patch->evaluate(place(at)).x; }
};

double spacing_of(const Patch& p) {
  return std::sqrt((p.knots_u.end() - p.knots_u.begin()) * (p.knots_v.end() - p.knots_v.begin()) /
                   (p.knots_u.spans() * p.knots_v.spans()));
}

PlaneCurve line(const Vec2& a, const Vec2& b) {
  return {[a, b](double t) { return Vec2(a + t * (b - a)); }, (b - a).norm(), false};
}

std::vector<Border> borders_of(const BorderedPatch& of) {
  std::vector<Border> out;
  const Patch& p = *of.patch;
  const bool outlined =
      std::any_of(of.trims->loops().begin(), of.trims->loops().end(), [](const TrimLoop& loop) { return !loop.hole; });
  if (!outlined) {
    const Vec2 low(p.knots_u.begin(), p.knots_v.begin()), high(p.knots_u.end(), p.knots_v.end());
    const Vec2 right(high.x(), low.y()), left(low.x(), high.y());
    out.push_back({&of, {line(low, right), line(right, high), line(high, left), line(left, low)}, {}, {}});
  }
  for (const TrimLoop& loop : of.trims->loops()) {
    Border border{&of, loop.curves, {}, {}};
    for (std::size_t k = 0; k + 1 < loop.points.size() && loop.curves.empty(); ++k)
      border.curves.push_back(line(loop.points[k], loop.points[k + 1]));
    out.push_back(std::move(border));
  }
  return out;
}

void sample(Border& border, double step) {
  const auto add = [&](double t) { border.t.push_back(t), border.x.push_back(border.point(t)); };
  for (std::size_t k = 0; k < border.curves.size(); ++k) {
    const int pieces =
        std::clamp(static_cast<int>(std::ceil(border.curves[k].length / step)), kFewestPieces, kMostPieces);
    for (int i = 0; i < pieces; ++i) add(static_cast<double>(k) + static_cast<double>(i) / pieces);
  }
  border.t.push_back(static_cast<double>(border.curves.size())), border.x.push_back(border.x.front());
}

// The nearest place of a border to x, and its distance [m].
struct Foot {
  double t, away;
};

// The sample of a border from which the nearest place is looked for: that of the nearest chord.
std::size_t nearest_chord(const Border& b, const Vec3& x) {
  std::size_t best = 0;
  double nearest = 1e300;
  for (std::size_t k = 0; k + 1 < b.x.size(); ++k) {
    const Vec3 d = b.x[k + 1] - b.x[k], r = x - b.x[k];
    const double share = std::clamp(r.dot(d) / std::max(d.squaredNorm(), 1e-300), 0.0, 1.0);
    const double away = (r - share * d).squaredNorm();
    if (away < nearest) nearest = away, best = k;
  }
  return best;
}

// Only to the chord's end where that is further than `enough` [m] beyond the length of chords.
Foot foot_of(const Border& b, const Vec3& x, double enough) {
  const std::size_t k = nearest_chord(b, x), count = b.x.size() - 1;
  Foot best{b.t[k], (b.x[k] - x).norm()};
  if (best.away > kFarChords * (b.x[k + 1] - b.x[k]).norm() + enough) return best;
  // The nearest place lies on the chord's stretch or, on an arc, on one beside it.
  for (const std::size_t at : {(k + count - 1) % count, k, (k + 1) % count}) {
    double low = b.t[at], high = b.t[at + 1];
    const auto off = [&](double t) { return (b.point(t) - x).squaredNorm(); };
    for (int it = 0; it < kBorderSections; ++it) {
      const double a = low + (high - low) / 3.0, c = high - (high - low) / 3.0;
      (off(a) < off(c) ? high : low) = off(a) < off(c) ? c : a;
    }
    const double t = 0.5 * (low + high), away = std::sqrt(off(t));
    if (away < best.away) best = {t, away};
  }
  return best;
}

// EdgeBit of a whole edge of the patch on which a place lies; 0: none.
int whole_edge(const BorderedPatch& of, const Vec2& p) {
  const Patch& patch = *of.patch;
  const Vec2 low(patch.knots_u.begin(), patch.knots_v.begin()), high(patch.knots_u.end(), patch.knots_v.end());
  for (const int edge : kEdges) {
    const int axis = edge < kVMin ? 0 : 1;
    const double side = edge == kUMin || edge == kVMin ? low[axis] : high[axis];
    if ((of.whole & edge) && std::abs(p[axis] - side) <= kOnSide * (high[axis] - low[axis])) return edge;
  }
  return 0;
}

// Inward across a border at a place whose tangent in space is `along`.
struct Across {
  Vec3 inward, normal;  // unit vectors
  Vec2 parameter;       // the same direction, per metre
};

Across across(const BorderedPatch& of, const Vec2& p, const Vec3& along) {
  const SurfacePoint s = of.patch->evaluate(p);
  Across out;
  out.normal = s.u.cross(s.v).normalized();
  out.inward = out.normal.cross(along).normalized();
  Eigen::Matrix<double, 3, 2> tangents;
  tangents << s.u, s.v;
  out.parameter = (tangents.transpose() * tangents).ldlt().solve(tangents.transpose() * out.inward);
  const Vec2 aside = kLookAside * spacing_of(*of.patch) * out.parameter.normalized();
  const auto inside = [&](const Vec2& q) {
    return of.patch->contains(q) && (of.trims->empty() || of.trims->contains(q));
  };
  if (!inside(p + aside) && inside(p - aside)) out.inward = -out.inward, out.parameter = -out.parameter;
  return out;
}

// Finds the angle, and whether the seam is smooth: up to the angle `smooth` [rad].
void finish(const BorderedPatch& a, const BorderedPatch& b, double smooth, Seam& seam) {
  const auto side = [](const Patch& patch, const Vec2& p, const Vec2& into, Vec3& normal) {
    const SurfacePoint s = patch.evaluate(p);
    normal = s.u.cross(s.v).normalized();
    return (into.x() * s.u + into.y() * s.v).normalized();
  };
  for (const SeamPlace& place : seam.places) {
    Vec3 normal_a, normal_b;
    const Vec3 into_a = side(*a.patch, place.first, place.into_first, normal_a),
               into_b = side(*b.patch, place.second, place.into_second, normal_b);
    const double angle = std::atan2(into_a.cross(into_b).norm(), -into_a.dot(into_b));
    seam.angle = std::max(seam.angle, angle);
    require(angle > 0.5 * std::numbers::pi || normal_a.dot(normal_b) > -kAskewBorder,
            "shells '{}' and '{}' meet along their borders, but their normals u x v are on opposite sides; turn one "
            "of the patches over (reverse its u or v)",
            a.name, b.name);
  }
  seam.smooth = seam.join == Join::kClamped && seam.angle <= smooth;
}

// A stretch of the first border, from t to t, along which the second one runs.
struct Stretch {
  double from, to;
};

class Pair {
 public:
  Pair(const Border& a, const Border& b, double tolerance, Join join)
      : a_(a),
        b_(b),
        tolerance_(tolerance),
        join_(join),
        least_(std::min(spacing_of(*a.of->patch), spacing_of(*b.of->patch))) {}

  std::vector<Seam> seams(int first, int second) const {
    std::vector<Seam> out;
    for (const Stretch& s : stretches()) {
      Seam seam = along(s);
      if (seam.length < kShortest * least_) continue;
      seam.first = first, seam.second = second, seam.join = join_;
      finish(*a_.of, *b_.of, kSmoothAngle, seam);
      out.push_back(std::move(seam));
    }
    return out;
  }

 private:
  bool together(double t) const {
    const Vec2 p = a_.place(t);
    const Foot foot = foot_of(b_, a_.of->patch->evaluate(p).x, kNearBorder * least_);
    if (foot.away > tolerance_) return false;
    return !(whole_edge(*a_.of, p) && whole_edge(*b_.of, b_.place(foot.t)));  // find_stitches joins those
  }

  // The place between t inside a seam and t outside where it ends.
  double end_of(double inside, double outside) const {
    for (int k = 0; k < kEndSteps; ++k) {
      const double middle = 0.5 * (inside + outside);
      (together(middle) ? inside : outside) = middle;
    }
    return inside;
  }

  std::vector<Stretch> stretches() const {
    const std::size_t count = a_.t.size() - 1;
    std::vector<char> on(count);
    double near_length = 0.0;
    for (std::size_t k = 0; k < count; ++k) {
      const double middle = 0.5 * (a_.t[k] + a_.t[k + 1]);
      on[k] = together(middle) ? 1 : 0;
      near_length = on[k] ? 0.0 : near_length + check_near(middle, (a_.x[k + 1] - a_.x[k]).norm(), near_length);
    }
    std::vector<Stretch> out;
    if (std::all_of(on.begin(), on.end(), [](char c) { return c != 0; })) return {{0.0, a_.t.back()}};
    const double turn = a_.t.back();
    const auto middle = [&](std::size_t k) {
      const std::size_t turns = k / count;
      return 0.5 * (a_.t[k % count] + a_.t[k % count + 1]) + turn * static_cast<double>(turns);
    };
    std::size_t start = 0;
    while (on[start]) ++start;  // a gap, at which no stretch goes on
    for (std::size_t k = start; k < start + count; ++k) {
      if (!on[k % count] || on[(k + count - 1) % count]) continue;
      std::size_t last = k;
      while (on[(last + 1) % count]) ++last;
      const double before = k > 0 ? middle(k - 1) : middle(count - 1) - turn;
      out.push_back({end_of(middle(k), before), end_of(middle(last), middle(last + 1))});
    }
    return out;
  }

  // Returns `length` where the borders are near at t, or else less than nothing of what was `before`. Throws Error
  // where they are near for long.
  double check_near(double t, double length, double before) const {
    const Vec2 p = a_.place(t);
    const Vec3 x = a_.of->patch->evaluate(p).x;
    const Foot foot = foot_of(b_, x, kNearBorder * least_);
    if (foot.away <= tolerance_ || foot.away > kNearBorder * least_) return -before;
    require(before + length < kNearLength * least_,
            "the borders of shells '{}' and '{}' nearly meet: they are {:.3g} m apart at ({:.6g}, {:.6g}, {:.6g}), and "
            "{:.3g} m are allowed; move them together, or give seams.tolerance_m, or a rule that leaves them OPEN",
            a_.of->name, b_.of->name, foot.away, x.x(), x.y(), x.z(), tolerance_);
    return length;
  }

  // Places along a stretch, in the middles of pieces that end at the samples.
  Seam along(const Stretch& s) const {
    std::vector<double> ends{s.from};
    const double turn = a_.t.back();
    for (int round = -1; round <= 1; ++round)
      for (std::size_t k = 0; k + 1 < a_.t.size(); ++k)
        if (const double t = a_.t[k] + round * turn; t > s.from && t < s.to) ends.push_back(t);
    ends.push_back(s.to);
    // Within the tolerance the borders run together a little beyond a corner, in another direction.
    const auto length = [&](double from, double to) { return (a_.point(to) - a_.point(from)).norm(); };
    const double least = kBeyondCorner * tolerance_;
    while (ends.size() > 2 && length(ends[0], ends[1]) <= least) ends.erase(ends.begin());
    while (ends.size() > 2 && length(ends[ends.size() - 2], ends.back()) <= least) ends.pop_back();
    Seam seam;
    seam.closed = s.from == 0.0 && s.to == turn;
    for (std::size_t k = 0; k + 1 < ends.size(); ++k) {
      const double middle = 0.5 * (ends[k] + ends[k + 1]);
      const Vec3 from = a_.point(ends[k]), to = a_.point(ends[k + 1]), x = a_.point(middle);
      SeamPlace place;
      place.length = (x - from).norm() + (to - x).norm();
      if (place.length <= 0.0) continue;
      place.first = a_.place(middle), place.second = b_.place(foot_of(b_, x, kNearBorder * least_).t);
      place.along = seam.length + 0.5 * place.length;
      place.into_first = across(*a_.of, place.first, to - from).parameter;
      place.into_second = across(*b_.of, place.second, to - from).parameter;
      seam.length += place.length;
      seam.places.push_back(place);
    }
    return seam;
  }

  const Border &a_, &b_;
  double tolerance_;
  Join join_;
  double least_;  // smaller spacing [m]
};

Eigen::AlignedBox3d box_of(const Border& b, double pad) {
  Eigen::AlignedBox3d box;
  for (const Vec3& x : b.x) box.extend(x);
  return {box.min() - Vec3::Constant(pad), box.max() + Vec3::Constant(pad)};
}

}  // namespace

std::vector<Seam> known_seams(const std::vector<BorderedPatch>& patches, const std::vector<KnownBorder>& borders,
                              const std::vector<std::vector<Join>>& join) {
  std::vector<Seam> out;
  for (const KnownBorder& known : borders) {
    if (join[known.first][known.second] == Join::kOpen) continue;
    const BorderedPatch &a = patches[known.first], &b = patches[known.second];
    const double step = std::min(spacing_of(*a.patch), spacing_of(*b.patch)) / kPlacesPerElement;
    Seam seam;
    seam.first = known.first, seam.second = known.second, seam.join = join[known.first][known.second];
    seam.closed = known.closed;
    for (std::size_t k = 0; k < known.on_first.size(); ++k) {
      const auto &on_a = known.on_first[k], &on_b = known.on_second[k];
      const int pieces = std::clamp(static_cast<int>(std::ceil(on_a.length / step)), kFewestPieces, kMostPieces);
      for (int i = 0; i < pieces; ++i) {
        const double t0 = static_cast<double>(i) / pieces, t1 = (i + 1.0) / pieces, middle = 0.5 * (t0 + t1);
        const Vec3 from = a.patch->evaluate(on_a.at(t0)).x, to = a.patch->evaluate(on_a.at(t1)).x;
        SeamPlace place;
        place.first = on_a.at(middle), place.second = on_b.at(middle);
        const Vec3 x = a.patch->evaluate(place.first).x;
        place.length = (x - from).norm() + (to - x).norm();
        if (place.length <= 0.0) continue;
        place.along = seam.length + 0.5 * place.length;
        place.into_first = across(a, place.first, to - from).parameter;
        place.into_second = across(b, place.second, to - from).parameter;
        seam.length += place.length;
        seam.places.push_back(place);
      }
    }
    if (seam.length < kShortest * kPlacesPerElement * step) continue;
    finish(a, b, known.smooth ? kNearlySmooth : kSmoothAngle, seam);
    out.push_back(std::move(seam));
  }
  return out;
}

std::vector<Seam> find_trim_seams(const std::vector<BorderedPatch>& patches, double tolerance,
                                  const std::vector<std::vector<Join>>& join) {
  std::vector<std::vector<Border>> borders;
  for (const BorderedPatch& p : patches) {
    borders.push_back(borders_of(p));
    for (Border& border : borders.back()) sample(border, spacing_of(*p.patch) / kPlacesPerElement);
  }
  const auto plain = [](const BorderedPatch& p) {
    return p.trims->empty() && p.whole == (kUMin | kUMax | kVMin | kVMax);
  };
  std::vector<Seam> out;
  for (std::size_t i = 0; i < patches.size(); ++i)
    for (std::size_t k = i + 1; k < patches.size(); ++k) {
      if (join[i][k] == Join::kOpen || (plain(patches[i]) && plain(patches[k]))) continue;
      // Places are taken on the finer border.
      const bool finer = spacing_of(*patches[k].patch) < spacing_of(*patches[i].patch);
      const std::size_t a = finer ? k : i, b = finer ? i : k;
      const double pad = kNearBorder * spacing_of(*patches[a].patch) + tolerance;
      for (const Border& one : borders[a])
        for (const Border& other : borders[b]) {
          if (!box_of(one, pad).intersects(box_of(other, 0.0))) continue;
          std::vector<Seam> found =
              Pair(one, other, tolerance, join[i][k]).seams(static_cast<int>(a), static_cast<int>(b));
          out.insert(out.end(), found.begin(), found.end());
        }
    }
  return out;
}

}  // namespace sunder::shell
