#pragma once
// Contact between surfaces on a background grid: a velocity field for each surface that comes near a node (the paper's
// section 4; Bardenhagen et al. 2000 with the normal of Nairn 2013), a gap test against thickness.
#include <vector>

#include "coupler/core/vec.h"
#include "shell/contact/field_list.h"
#include "shell/grid/sparse_grid.h"

namespace sunder::shell {

/// A point of a surface.
struct SurfaceSample {
  Vec3 x, v, normal, rest;                         // [m], [m/s], unit, place at rest [m]
  Vec3 rest_normal = Vec3::Zero();                 // unit
  double mass = 0.0, thickness = 0.0, area = 0.0;  // [kg], [m], [m^2] at rest
  int shell = 0;
  Vec3 impulse = Vec3::Zero();  // found [N s]
};

/// What surfaces of shells do to one another.
struct SurfaceLaw {
  double friction = 0.5, restitution = 0.0;
  bool elsewhere = false;  // something else keeps them apart
};

class FieldContact {
 public:
  /// `together[i][k]`: shells i and k hang together, so that what is near at rest is one surface; `laws[i][k]`.
  FieldContact(double spacing, std::vector<std::vector<char>> together, std::vector<std::vector<SurfaceLaw>> laws)
      : spacing_(spacing), together_(std::move(together)), laws_(std::move(laws)) {}

  double spacing() const { return spacing_; }
  /// Surfaces that hang together and are no further apart at rest are one [m].
  double one_surface() const { return kOneSurface * spacing_; }
  /// Impulses of surfaces that would touch within the substep, touch and approach, or overlap, into `impulse`; they sum
  /// to zero, and so do their moments. `dt`: of the substep [s]. Returns the number of places that may be in contact.
  int solve(std::vector<SurfaceSample>& samples, double dt);

 private:
  static constexpr double kOneSurface = 4.0;  // grid spacings, a little more than the support of a node
  struct Field {
    int shell = 0, next = -1;
    Vec3 rest;       // of its first sample
    int first = -1;  // sample
    double mass = 0.0, thickness = 0.0;
    Vec3 momentum = Vec3::Zero(), moment = Vec3::Zero(), normal = Vec3::Zero();  // sums
    Vec3 change = Vec3::Zero(), spin = Vec3::Zero();                             // of its velocity [m/s], [rad/s]
    Mat3 inertia = Mat3::Zero();                                                 // about its centre, where it touches
    bool touches = false;
    Vec3 centre() const { return moment / mass; }
  };
  struct Pair {
    int plane, other;    // fields
    Vec3 normal;         // from the plane to the other
    double gap = 1e300;  // nearest sample of the other; of their centres in a fold [m]
    int next = -1;
  };
  struct Touch {
    int a, b;      // fields
    Vec3 impulse;  // on b [N s]
  };
  struct Corner {
    int field;
    double weight;
  };
  bool one(const Field& f, const SurfaceSample& first, const SurfaceSample& p) const;
  void turn(const std::vector<SurfaceSample>& samples);
  int hold_folds_open(std::vector<SurfaceSample>& samples, double dt);

  double spacing_;
  std::vector<std::vector<char>> together_;
  std::vector<std::vector<SurfaceLaw>> laws_;
  SparseGrid grid_;
  std::vector<int> head_;  // first field of each node
  std::vector<Field> fields_;
  std::vector<Corner> corners_;  // eight of each sample
  std::vector<int> node_of_;     // of each corner
  std::vector<Pair> pairs_;
  std::vector<int> first_pair_;  // of each field, in which it is the other
  std::vector<Touch> touches_;
  std::vector<char> fold_near_;  // of each node: both sides of a fold come near
  // samples that see such a node, in a list for each node: first, next
  std::vector<int> in_fold_, fold_head_, fold_next_;
  struct Close {
    int p, q;      // samples
    double reach;  // that they are to be apart [m]
  };
  std::vector<Close> close_;
  std::vector<int> shares_;  // of each sample: pairs that are too close, or would be
  std::vector<Vec3> push_;   // on each sample [N s]
};

}  // namespace sunder::shell
