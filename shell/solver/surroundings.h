#pragma once
// Which Gauss points around a point no crack hides from it, and which crack edges it sees. Cracks only grow, so what is
// hidden stays hidden, and only edges that are new since the last look are tested.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "shell/fracture/crack_graph.h"
#include "shell/solver/model.h"

namespace sunder::shell {

constexpr double kBeside = 120.0 * std::numbers::pi / 180.0;  // points further round belong to a crack's flanks

struct SeenPoint {
  int block, lane;
  Vec2 offset;    // from the middle [m]
  double angle;   // from the direction of the look [rad]
  double weight;  // exp(-2 r^2 / radius^2)
  double ahead;   // weight times the wedge about the direction; of a look that has one
  double tilt;    // factor of that for each kTurnStep that the wedge turns, but for one that all points have in common
};

constexpr double kWedge = 40.0 * (std::numbers::pi / 180.0);    // of the weight about a direction, a standard deviation
constexpr double kTurnStep = 5.0 * (std::numbers::pi / 180.0);  // between two directions that are tried

inline double wedge(double angle) { return std::exp(-0.5 * angle * angle / (kWedge * kWedge)); }
/// wedge(angle - turn) = wedge(angle) wedge(turn) exp(angle turn / kWedge^2).
inline double wedge_tilt(double angle, double turn) { return std::exp(angle * turn / (kWedge * kWedge)); }

/// From where one looks, and how far.
struct Look {
  Vec2 p;                         // middle of the circle
  double radius;                  // [m]
  Vec2 direction = Vec2::Zero();  // only what lies ahead of it or beside it is looked for; zero: all
  int edge = -1;                  // hides nothing

  bool operator==(const Look& o) const = default;
};

class Surroundings {
 public:
  /// What no edge of the graph hides, in rising order of rows and columns. None that an earlier look took in may have
  /// been taken back.
  const std::vector<SeenPoint>& seen(const ShellModel& model, const CrackGraph& cracks, const Look& look);

 private:
  Look look_{Vec2::Zero(), -1.0};
  int known_ = 0;  // edges
  std::vector<SeenPoint> points_;
};

/// The same all about a point, for many of these: less is kept of each.
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
  /// Those within `reach` [m] of p, the oldest first. One less than `clearance` [m] off shields p from the stress
  /// across directions whose cosine with it is above `parallel`. All but the graph are the same in each call.
  const std::vector<SeenEdge>& seen(const CrackGraph& cracks, const Vec2& p, double reach, double clearance,
                                    double parallel);
  /// Of what `seen` has told last: whether it shields p in every direction.
  bool shield_all() const { return shield_all_; }

 private:
  int known_ = 0;  // edges
  bool shield_all_ = false;
  std::vector<SeenEdge> edges_;
};

/// The ground that a crack would have to itself, kept in the same way.
class OwnGround {
 public:
  static constexpr int kWays = 16;

  /// The share of a circle about p, of `radius` [m], by sectors: what lies nearer to p than to any crack, which
  /// relieves the rest, and before cuts and the patch's border. Beyond an edge that is joined to another patch lies
  /// ground of its own whatever cracks there. What was asked before changes nothing.
  double share(const ShellModel& model, const CrackGraph& cracks, const Vec2& p, double radius);
  /// Of the ground that `share` has told of last: whether an offset from p [m] lies in it, and how far it reaches [m].
  bool holds(const Vec2& offset) const;
  double reach() const { return *std::max_element(rays_.begin(), rays_.end()); }

 private:
  double asked_ = -1.0;            // radius for which edges are known [m]
  int known_ = 0;                  // edges
  std::array<float, kWays> rays_;  // from p to where its ground ends [m]
};

/// Calls f(block, lane, offset from p [m], its parameter area [m^2]) for each Gauss point within the radius [m] of
/// every so many elements along u and along v, that of p among them.
template <class F>
void points_within(const ShellModel& m, const Vec2& p, double radius, int every_u, int every_v, F&& f) {
  const RowTables& t = m.tables;
  const auto first = [&](const KnotVector& k, double at, int every) {
    const int low = k.span_of(at - radius);
    return low + (k.span_of(at) - low) % every;
  };
  const auto &ku = m.patch.knots_u, &kv = m.patch.knots_v;
  const GaussRule& rule = gauss_rule(t.gauss);
  for (int j = first(kv, p.y(), every_v); j <= kv.span_of(p.y() + radius); j += every_v)
    for (int i = first(ku, p.x(), every_u); i <= ku.span_of(p.x() + radius); i += every_u) {
      const double lu = ku.span_length(i), lv = kv.span_length(j);
      for (int b = 0; b < t.gauss; ++b) {
        const double y = gauss_parameter(kv, rule, j, b) - p.y();
        for (int a = 0; a < t.gauss; ++a) {
          const Vec2 d(gauss_parameter(ku, rule, i, a) - p.x(), y);
          if (d.squaredNorm() <= radius * radius)
            f((j * t.gauss + b) * t.gauss + a, i, d, 0.25 * lu * lv * rule.weight[a] * rule.weight[b]);
        }
      }
    }
}

/// What is known of Gauss points that are asked again and again.
template <class T>
class KnownOfPoints {
 public:
  /// Of a point, which takes about `each` bytes; until the next call.
  T& at(std::size_t gauss_points, std::size_t gauss, std::size_t each) {
    if (index_.empty() || known_.size() * each >= kMost) index_.assign(gauss_points, -1), known_.clear();
    if (index_[gauss] < 0) index_[gauss] = static_cast<int>(known_.size()), known_.emplace_back();
    return known_[index_[gauss]];
  }

 private:
  static constexpr std::size_t kMost = 64 << 20;  // [bytes]: all points are forgotten then

  std::vector<T> known_;
  std::vector<int> index_;  // [block][lane]: into known_, -1: none; empty: none at all
};

/// The mean stress about a point, as it was found at a time between some edges.
struct KnownMean {
  double time = -1.0;
  std::size_t edges = 0;
  bool found = false;
  double six[6];
  Neighbours around;
};

/// Not part of checkpoints: they can be found again.
struct KnownSurroundings {
  std::vector<Surroundings> of_tip;
  KnownOfPoints<NearCracks> cracks_of_point;
  KnownOfPoints<OwnGround> ground_of_point;
  KnownOfPoints<KnownMean> mean_of_point;
};

constexpr std::size_t kBytesOfCracks = 24 * sizeof(SeenEdge);  // most points see fewer edges nearby

/// Of neighbours within the radius [m].
std::size_t most_bytes_seen(const ShellModel& model, double radius);

}  // namespace sunder::shell
