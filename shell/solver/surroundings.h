#pragma once
// Which Gauss points around a point are visible, and which crack edges it sees. Cracks only grow, so what is hidden
// stays hidden, and only edges that are new since the last look are tested.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "shell/fracture/constants.h"
#include "shell/fracture/visibility.h"
#include "shell/mechanics/point_force.h"
#include "shell/solver/model.h"
#include "shell/solver/release_ring.h"

namespace sunder::shell {

struct SeenPoint {
  int block, lane;
  Vec2 offset;    // from the middle [m]
  double angle;   // from the direction of the look [rad]
  double weight;  // exp(-2 r^2 / radius^2)
  double ahead;   // weight times the wedge about the direction of the look; 0: it has none
  double tilt;    // factor of `ahead` for each kTurnStep that the wedge turns, but for one in common to all points
};

inline double wedge(double angle) { return std::exp(-0.5 * angle * angle / (kWedge * kWedge)); }
/// wedge(angle - turn) = wedge(angle) wedge(turn) exp(angle turn / kWedge^2).
inline double wedge_tilt(double angle, double turn) { return std::exp(angle * turn / (kWedge * kWedge)); }

/// Where a look starts, and how far it goes.
struct Look {
  Vec2 p;                         // middle of the circle
  double radius;                  // [m]
  Vec2 direction = Vec2::Zero();  // only points ahead of it or beside it count; zero: all points
  int edge = -1;                  // edge that hides nothing

  bool operator==(const Look& o) const = default;
};

class Surroundings {
 public:
  /// The visible Gauss points, in rising order of rows and columns. No edge that an earlier look took in may have been
  /// taken back.
  const std::vector<SeenPoint>& seen(const ShellModel& model, const CrackGraph& cracks, const Look& look);

 private:
  Look look_{Vec2::Zero(), -1.0};
  int known_ = 0;  // edges
  std::vector<SeenPoint> points_;
};

/// The same all around a point, for many points: less is kept of each.
class Neighbours {
 public:
  struct Seen {
    int block, lane;
    double weight;  // exp(-2 r^2 / radius^2)
  };
  /// p is the same in each call.
  const std::vector<Seen>& seen(const ShellModel& model, const CrackGraph& cracks, const Vec2& p, double radius);

 private:
  double radius_ = -1.0;
  int known_ = 0;  // edges
  std::vector<Seen> points_;
};

/// A crack edge that a point sees.
struct SeenEdge {
  double distance;  // [m]
  Vec2 foot;        // nearest to the point
  Vec2 along;       // unit vector
};

/// Which edges near a point it sees, kept in the same way.
class NearCracks {
 public:
  /// The edges within `reach` [m] of p, the oldest first. An edge nearer than `clearance` [m] shields p from the stress
  /// across directions whose cosine with it is above `parallel`. All arguments but the graph are the same in each call.
  const std::vector<SeenEdge>& seen(const CrackGraph& cracks, const Vec2& p, double reach, double clearance,
                                    double parallel);
  /// Whether the edges of the last seen() shield p in every direction.
  bool shield_all() const { return shield_all_; }

 private:
  int known_ = 0;  // edges
  bool shield_all_ = false;
  std::vector<SeenEdge> edges_;
};

/// The energy-release zone that a crack would have to itself, kept in the same way.
class EnergyReleaseZone {
 public:
  static constexpr int kWays = kZoneSectors;

  /// The share of a circle about p, of `radius` [m], that is the zone of p, by sectors: what lies nearer to p than to
  /// any crack, and before cuts and the border of the patch. Cracks relieve the rest. Beyond an edge that is joined to
  /// another patch, or a loop that is tied to one, the zone goes on whatever cracks there. Earlier calls do not change
  /// the answer.
  double share(const ShellModel& model, const CrackGraph& cracks, const Vec2& p, double radius);
  /// Of the zone of the last share(): whether an offset from p [m] lies in it, and how far it reaches [m].
  bool holds(const Vec2& offset) const;
  double reach() const { return *std::max_element(rays_.begin(), rays_.end()); }

 private:
  double asked_ = -1.0;            // radius for which edges are known [m]
  int known_ = 0;                  // edges
  std::array<float, kWays> rays_;  // from p to the end of its zone [m]
};

/// Calls f(block, lane, offset from p [m], its parameter area [m^2]) for each Gauss point within the radius [m], in
/// every so many elements along u and along v, among them the element of p.
template <class F>
void points_within(const ShellModel& m, const Vec2& p, double radius, int every_u, int every_v, F&& f) {
  const RowTables& t = m.tables;
  const auto first = [&](const KnotVector& k, double at, int every) {
    const int low = k.span_of(at - radius);
    return low + (k.span_of(at) - low) % every;
  };
  const auto &ku = m.patch.knots_u, &kv = m.patch.knots_v;
  const GaussRule& rule = gauss_rule(t.gauss);
  const bool whole = t.trimmed.empty();
  for (int j = first(kv, p.y(), every_v); j <= kv.span_of(p.y() + radius); j += every_v)
    for (int i = first(ku, p.x(), every_u); i <= ku.span_of(p.x() + radius); i += every_u) {
      const double lu = ku.span_length(i), lv = kv.span_length(j);
      for (int k = 0; k < t.gauss * t.gauss && !whole; ++k) {
        const int block = j * t.gauss * t.gauss + k;
        const GaussPoint& g = t.trimmed[static_cast<std::size_t>(block) * t.lanes + i];
        const Vec2 d = g.parameter - p;
        if (g.weight > 0.0 && d.squaredNorm() <= radius * radius) f(block, i, d, g.weight);
      }
      for (int b = 0; b < t.gauss && whole; ++b) {
        const double y = gauss_parameter(kv, rule, j, b) - p.y();
        for (int a = 0; a < t.gauss; ++a) {
          const Vec2 d(gauss_parameter(ku, rule, i, a) - p.x(), y);
          if (d.squaredNorm() <= radius * radius)
            f((j * t.gauss + b) * t.gauss + a, i, d, 0.25 * lu * lv * rule.weight[a] * rule.weight[b]);
        }
      }
    }
}

/// Answers about Gauss points that are asked again and again.
template <class T>
class KnownOfPoints {
 public:
  /// The answer about a point, which takes about `each` bytes; valid until the next call.
  T& at(std::size_t gauss_points, std::size_t gauss, std::size_t each) {
    if (index_.empty() || known_.size() * each >= kMost) index_.assign(gauss_points, -1), known_.clear();
    if (index_[gauss] < 0) index_[gauss] = static_cast<int>(known_.size()), known_.emplace_back();
    return known_[index_[gauss]];
  }

 private:
  static constexpr std::size_t kMost = 64 << 20;  // all points are forgotten beyond it [bytes]

  std::vector<T> known_;
  std::vector<int> index_;  // [block][lane]: index into known_, -1: none; empty: none at all
};

/// The mean stress around a point at a time, with the edges of that time.
struct KnownMean {
  double time = -1.0;
  std::size_t edges = 0;
  bool found = false;
  double face_stress[6];
  Neighbours around;
};

/// Not part of checkpoints: all of it can be found again.
struct KnownSurroundings {
  std::vector<Surroundings> of_tip;
  std::vector<ReleaseRing> ring_of_tip;
  KnownOfPoints<NearCracks> cracks_of_point;
  KnownOfPoints<EnergyReleaseZone> zone_of_point;
  KnownOfPoints<KnownMean> mean_of_point;
};

constexpr std::size_t kBytesOfCracks = 24 * sizeof(SeenEdge);  // most points see fewer edges nearby

/// The control points of a shell by their parameter points.
ControlGrid control_grid(const ShellModel& model);

/// The control points that a point sees before any crack; p lies in span_u, span_v. Trim loops hide what is beyond
/// them.
Visibility first_visibility(const ShellModel& model, const CrackGraph& cracks, const Vec2& p, int span_u, int span_v);

/// Reduces `uses`, the visibility of the same point, to the control points of these functions.
void note_uses(const ShellModel& model, const std::vector<GatheredFunction>& functions, Visibility& uses);

/// Bytes of the neighbours within the radius [m], at most.
std::size_t most_bytes_seen(const ShellModel& model, double radius);

}  // namespace sunder::shell
