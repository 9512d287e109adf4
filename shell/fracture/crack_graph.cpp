#include "shell/fracture/crack_graph.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "coupler/core/error.h"
#include "shell/fracture/constants.h"

namespace sunder::shell {

CrackGraph::CrackGraph(const Vec2& low, const Vec2& high, double reach, double lengthening)
    : low_(low), size_(reach), lengthening_(lengthening) {
  nx_ = static_cast<int>(std::ceil((high.x() - low.x()) / size_)) + 1;
  ny_ = static_cast<int>(std::ceil((high.y() - low.y()) / size_)) + 1;
  bins_.resize(static_cast<std::size_t>(nx_) * ny_);
}

int CrackGraph::add_vertex(const Vec2& p) {
  vertices_.push_back(p);
  return static_cast<int>(vertices_.size()) - 1;
}

int CrackGraph::add_edge(int from, int to, int crack, double time, int face, double resistance) {
  CrackEdge e;
  e.from = from, e.to = to, e.crack = crack, e.time = time, e.face = face, e.resistance = resistance;
  e.a = vertices_[from], e.b = vertices_[to];
  const double length = (e.b - e.a).norm();
  if (length < kNoLength * lengthening_) return -1;
  const Vec2 d = (e.b - e.a) / length;
  e.long_a = e.a - lengthening_ * d, e.long_b = e.b + lengthening_ * d;
  const int index = static_cast<int>(edges_.size());
  edges_.push_back(e);
  if (!e.is_trim()) total_length_ += length;
  const Vec2 lo = e.long_a.cwiseMin(e.long_b) - low_, hi = e.long_a.cwiseMax(e.long_b) - low_;
  for (int j = bin(lo.y(), ny_); j <= bin(hi.y(), ny_); ++j)
    for (int i = bin(lo.x(), nx_); i <= bin(hi.x(), nx_); ++i)
      bins_[static_cast<std::size_t>(j) * nx_ + i].push_back(index);
  return index;
}

void CrackGraph::add_trim(int from, int to, bool tied) {
  trims_ +=
      add_edge(from, to, tied ? CrackEdge::kTiedTrim : CrackEdge::kTrim, std::numeric_limits<double>::lowest(), 0) >= 0;
}

void CrackGraph::undo_edge() {
  const CrackEdge& e = edges_.back();
  if (!e.is_trim()) total_length_ -= (e.b - e.a).norm();
  const Vec2 lo = e.long_a.cwiseMin(e.long_b) - low_, hi = e.long_a.cwiseMax(e.long_b) - low_;
  for (int j = bin(lo.y(), ny_); j <= bin(hi.y(), ny_); ++j)
    for (int i = bin(lo.x(), nx_); i <= bin(hi.x(), nx_); ++i) bins_[static_cast<std::size_t>(j) * nx_ + i].pop_back();
  edges_.pop_back();
}

void CrackGraph::restore(const std::vector<Vec2>& vertices, const std::vector<CrackEdge>& edges, int cracks,
                         double total_length) {
  const int count = static_cast<int>(vertices.size());
  vertices_ = vertices, edges_.clear(), total_length_ = 0.0, trims_ = 0;
  for (auto& bin : bins_) bin.clear();
  for (const CrackEdge& e : edges) {
    const bool known = e.from >= 0 && e.from < count && e.to >= 0 && e.to < count;
    if (!known || add_edge(e.from, e.to, e.crack, e.time, e.face, e.resistance) < 0)
      throw Error(Exit::kBadInput, "bad_checkpoint", fmt::format("crack edge {} is none", edges_.size()));
    trims_ += e.is_trim() && e.time == std::numeric_limits<double>::lowest();
  }
  cracks_ = cracks, total_length_ = total_length;  // a sum depends on the edges that were taken back in between
}

bool CrackGraph::visible(const Vec2& a, const Vec2& b, int skip1, int skip2) const {
  bool clear = true;
  near(a, b, 0.0, [&](int e) {
    if (e != skip1 && e != skip2 && segments_meet(a, b, edges_[e].long_a, edges_[e].long_b)) clear = false;
    return clear;
  });
  return clear;
}

double CrackGraph::distance(const Vec2& p, int e, Vec2& foot) const {
  const Vec2 d = edges_[e].b - edges_[e].a;
  foot = edges_[e].a + std::clamp((p - edges_[e].a).dot(d) / d.squaredNorm(), 0.0, 1.0) * d;
  return (p - foot).norm();
}

}  // namespace sunder::shell
