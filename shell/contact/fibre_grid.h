#pragma once
// The velocity field that touching layers of shells share, on a background grid. Two surfaces that are nearer at a node
// than their thickness have one field of mass and momentum, with its gradient.
//
// A node holds mass, mean place and velocity of such a pair, and the gradient that fits best (least squares, with the
// weights of the transfer): L = B D^-1, D = sum m w (y y^T + S), B = sum m w (v y^T + L_q S). Here y is the offset from
// the pair's centre, L_q the gradient of the surface by itself, and S the spread of a sample about its place. Two
// layers at distance d have the gradient (v_2 - v_1) / d along their normal at any grid spacing h. The published method
// takes gradients of the kernel in one field for all surfaces. These would give only (d / h)^2 of it, and zero for a
// layer that moves between two others. Rigid motion is reproduced exactly. Forces are the transpose of that map. So
// they do the work that fibres take up, and their sum is zero. With the moments on the surfaces' own gradients their
// torque is zero too.
#include <algorithm>
#include <array>
#include <vector>

#include "coupler/core/vec.h"
#include "shell/contact/field_list.h"
#include "shell/grid/sparse_grid.h"
#include "shell/grid/stencil.h"

namespace sunder::shell {

/// A piece of a surface, with a fibre on either side.
struct LayerSample {
  Vec3 x, v, normal, rest;                         // [m], [m/s], unit, place at rest [m]
  Mat3 gradient;                                   // velocity gradient of the surface by itself, normals kept [1/s]
  double mass = 0.0, area = 0.0, thickness = 0.0;  // [kg], [m^2], [m]
  int shell = 0;
  // found, for the fibre below (against the normal) and above:
  std::array<double, 2> share;   // share of its nodes at which it touches another surface [-]
  std::array<Mat3, 2> together;  // velocity gradient of the fibre [1/s]
  Vec3 force;                    // at x [N]
  Mat3 moment;                   // conjugate to `gradient` [N m]
};

class FibreGrid {
 public:
  /// `together[i][k]`: shells i and k are joined, so places that are near at rest are one surface.
  FibreGrid(double spacing, std::vector<std::vector<char>> together)
      : spacing_(spacing), together_(std::move(together)) {}

  double spacing() const { return spacing_; }
  /// Largest distance at rest between places of one surface [m].
  double one_surface() const { return kOneSurface * spacing_; }
  /// Finds `share` and `together` of each sample. Returns true if surfaces touch.
  bool find(std::vector<LayerSample>& samples);
  /// After `find`: writes `force` and `moment` of each sample, for the stress V d psi/d a3 (x) a3 of its fibres [J].
  void push(std::vector<LayerSample>& samples, const std::vector<std::array<Mat3, 2>>& stress);

 private:
  static constexpr double kOneSurface = 4.0;  // grid spacings; more than the support of a node
  static constexpr int kAround = kNodes * kNodes * kNodes;
  struct Field {
    int shell = 0, next = -1, touch = -1;  // touch: index of its first touch
    Vec3 rest;                             // of its first sample
    Vec3 at;                               // the node [m]
    double mass = 0.0, area = 0.0, thickness = 0.0;
    Vec3 moment = Vec3::Zero(), normal = Vec3::Zero();  // sums; the moment about the node
    std::array<double, 2> share{};                      // sums over its touches, below and above `normal`
  };
  struct Pair {
    int plane, other;    // fields
    Vec3 normal;         // from the plane to the other
    double gap = 1e300;  // nearest sample of the other [m]
    int next = -1;
  };
  /// The common field of two fields that touch.
  struct Common {
    double mass = 0.0;
    Vec3 moment = Vec3::Zero(), momentum = Vec3::Zero();
    Mat3 d = Mat3::Zero(), b = Mat3::Zero();
    Mat3 stress = Mat3::Zero();
  };
  struct Touch {  // of a field
    int common, side, next;
    double share;
  };
  struct Corner {
    int field;
    double weight;
  };
  void find_pairs(const std::vector<LayerSample>& samples);
  bool find_touches();
  void add_touch(int field, int common, int side, double share);
  /// Calls f(corner weight, place from the node, common, side, share) with each touch of a sample.
  template <class F>
  void each_touch(const LayerSample& sample, std::size_t p, F&& f) {
    for (int c = 0; c < kAround; ++c) {
      const Corner& corner = corners_[kAround * p + c];
      const Field& field = fields_[corner.field];
      if (field.touch < 0) continue;
      const bool swapped = sample.normal.dot(field.normal) < 0.0;
      for (int t = field.touch; t >= 0; t = touches_[t].next) {
        const Touch& touch = touches_[t];
        // several touches on one side divide the share
        f(corner.weight, sample.x - field.at, commons_[touch.common], swapped ? 1 - touch.side : touch.side,
          touch.share / std::max(1.0, field.share[touch.side]));
      }
    }
  }
  static Mat3 spread(const LayerSample& sample);

  double spacing_;
  std::vector<std::vector<char>> together_;
  SparseGrid grid_;
  std::vector<int> head_;  // first field of each node
  std::vector<Field> fields_;
  std::vector<Corner> corners_;  // of each sample
  std::vector<int> blocks_;
  std::vector<Pair> pairs_;
  std::vector<int> first_pair_;  // of each field: first pair in which it is the other
  std::vector<Common> commons_;
  std::vector<Touch> touches_;
};

}  // namespace sunder::shell
