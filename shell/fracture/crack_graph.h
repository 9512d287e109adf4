#pragma once
// The cracks of a patch: a graph in its parameter domain to which vertices and edges are only added. So every earlier
// crack is a part of every later one.
#include <cmath>
#include <functional>
#include <vector>

#include "coupler/core/vec.h"

namespace sunder::shell {

/// Twice the signed area of the triangle p q r, rounded alike wherever it is inlined. Otherwise a point on a line to
/// round-off, as at the start of a crack, would be left of it in one place and right of it in another.
inline double orientation(const Vec2& p, const Vec2& q, const Vec2& r) {
  const double across = (q.y() - p.y()) * (r.x() - p.x());
#ifdef __FP_FAST_FMA
  return std::fma(q.x() - p.x(), r.y() - p.y(), -across);
#else
  return (q.x() - p.x()) * (r.y() - p.y()) - across;
#endif
}
/// Whether the edge cd cuts the segment ab. A point on the line of the edge counts as left of it, so a control point on
/// a crack is seen from one side, not from none.
inline bool segments_meet(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  return (orientation(c, d, a) >= 0.0) != (orientation(c, d, b) >= 0.0) &&
         orientation(a, b, c) * orientation(a, b, d) <= 0.0;
}

struct CrackEdge {
  int from = 0, to = 0;     // vertices
  Vec2 a, b;                // their parameter points
  Vec2 long_a, long_b;      // lengthened a little at both ends, so that nothing sees past a vertex
  int crack = 0;            // edges of one crack share a number
  double time = 0.0;        // of birth [s]
  int face = 0;             // tension side that opened it: -1, +1; 0: cut
  double resistance = 1.0;  // what its area takes, over the fracture energy of the material

  bool is_trim() const { return crack == kTrim || crack == kTiedTrim; }
  // Crack of an edge that parts nothing: of a trim loop, or outside of it where a crack ends.
  static constexpr int kTrim = -1;
  // The same of a trim loop where the shell is tied to another one: stress goes on beyond it.
  static constexpr int kTiedTrim = -2;
};

class CrackGraph {
 public:
  /// `reach`: bin size [m]; `lengthening`: how far visibility extends an edge beyond its ends [m].
  CrackGraph(const Vec2& low, const Vec2& high, double reach, double lengthening);

  int add_vertex(const Vec2& p);
  /// Returns the number of the edge, or -1 where it would have no length.
  int add_edge(int from, int to, int crack, double time, int face, double resistance = 1.0);
  int new_crack() { return cracks_++; }
  int next_crack() const { return cracks_; }
  /// Adds an edge of a trim loop, before all cracks. The region that exists lies on its left. `tied`: another shell is
  /// tied to this one there.
  void add_trim(int from, int to, bool tied = false);
  /// Number of edges of trim loops; they are the first ones.
  int trims() const { return trims_; }
  bool has_cracks() const { return static_cast<int>(edges_.size()) > trims_; }
  /// Takes back the last edge, which was on trial, or the last vertex, which no edge has.
  void undo_edge();
  void undo_vertex() { vertices_.pop_back(); }
  /// Replaces the cracks by those of a checkpoint; the domain and the bins stay. Throws Error (bad_checkpoint).
  void restore(const std::vector<Vec2>& vertices, const std::vector<CrackEdge>& edges, int cracks, double total_length);

  const std::vector<Vec2>& vertices() const { return vertices_; }
  const std::vector<CrackEdge>& edges() const { return edges_; }
  double total_length() const { return total_length_; }

  /// Whether no edge but `skip1`, `skip2` cuts the segment from a to b.
  bool visible(const Vec2& a, const Vec2& b, int skip1 = -1, int skip2 = -1) const;
  /// Calls back every edge whose bins touch the box of a and b widened by pad, until false is returned. An edge may
  /// come more than once.
  template <class F>
  void near(const Vec2& a, const Vec2& b, double pad, F&& callback) const {
    const int i0 = bin(std::min(a.x(), b.x()) - pad - low_.x(), nx_),
              i1 = bin(std::max(a.x(), b.x()) + pad - low_.x(), nx_);
    const int j0 = bin(std::min(a.y(), b.y()) - pad - low_.y(), ny_),
              j1 = bin(std::max(a.y(), b.y()) + pad - low_.y(), ny_);
    for (int j = j0; j <= j1; ++j)
      for (int i = i0; i <= i1; ++i)
        for (const int e : bins_[static_cast<std::size_t>(j) * nx_ + i])
          if (!callback(e)) return;
  }
  /// Calls back every edge from number `first` on of the box from `low` to `high`; the youngest of a bin comes first.
  template <class F>
  void near_since(const Vec2& low, const Vec2& high, int first, F&& callback) const {
    const int i0 = bin(low.x() - low_.x(), nx_), i1 = bin(high.x() - low_.x(), nx_);
    const int j0 = bin(low.y() - low_.y(), ny_), j1 = bin(high.y() - low_.y(), ny_);
    for (int j = j0; j <= j1; ++j)
      for (int i = i0; i <= i1; ++i) {
        const std::vector<int>& edges = bins_[static_cast<std::size_t>(j) * nx_ + i];
        for (std::size_t k = edges.size(); k-- > 0 && edges[k] >= first;) callback(edges[k]);
      }
  }
  /// Distance from p to edge e; `foot` is the nearest point.
  double distance(const Vec2& p, int e, Vec2& foot) const;

 private:
  int bin(double offset, int count) const {
    const int i = static_cast<int>(std::floor(offset / size_));
    return i < 0 ? 0 : i >= count ? count - 1 : i;
  }
  Vec2 low_;
  double size_, lengthening_;
  int nx_, ny_, cracks_ = 0, trims_ = 0;
  double total_length_ = 0.0;
  std::vector<Vec2> vertices_;
  std::vector<CrackEdge> edges_;
  std::vector<std::vector<int>> bins_;
};

}  // namespace sunder::shell
