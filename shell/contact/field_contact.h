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
  /// Finds what is near one another, for samples with places and velocities; sets impulses to zero. `dt`: of the
  /// substep [s]. Returns whether anything is.
  bool find(std::vector<SurfaceSample>& samples, double dt);
  /// Samples, by index, that what was found may push.
  const std::vector<int>& near() const { return near_; }
  /// Impulses of surfaces that would touch within the substep, touch and approach, or overlap, into `impulse`, for
  /// samples as they were found, with the velocities `v` that they have now; they sum to zero, and so do their moments.
  /// May be called again. Returns the number of places that may be in contact, those of folds with them.
  int push(std::vector<SurfaceSample>& samples, double dt);

  /// Samples of one fold, tighter than the grid sees, that were found too close, or would be at the end of the substep.
  struct Close {
    int p, q;      // samples
    double reach;  // that they are to be apart [m]
  };
  /// push() leaves them to what carries the samples.
  const std::vector<Close>& folds() const { return close_; }
  /// Speed [m/s] at which samples of a fold are to part that are `apart` [m] and come at -`approach` [m/s].
  static double parting(const Close& c, double apart, double approach, double dt);

 private:
  static constexpr double kOneSurface = 4.0;  // grid spacings, a little more than the support of a node
  struct Field {
    int shell = 0, next = -1;
    Vec3 rest;       // of its first sample
    int first = -1;  // sample
    double mass = 0.0, thickness = 0.0;
    Vec3 momentum = Vec3::Zero(), moment = Vec3::Zero(), normal = Vec3::Zero();  // sums
    Vec3 change = Vec3::Zero(), spin = Vec3::Zero();                             // of its velocity [m/s], [rad/s]
    Mat3 inertia = Mat3::Zero();                                                 // about its centre, where it touched
    bool paired = false, touches = false, touched = false;
    Vec3 centre() const { return moment / mass; }
  };
  struct Pair {
    int plane, other;        // fields
    Vec3 normal;             // from the plane to the other
    double gap = 1e300;      // nearest sample of the other; of their centres in a fold [m]
    double bounce = -1e300;  // speed that restitution wants, since the first push that stopped it [m/s]
    bool fold = false;
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
  void find_fields(const std::vector<SurfaceSample>& samples);
  void turn(const std::vector<SurfaceSample>& samples);
  void find_folds(const std::vector<SurfaceSample>& samples, double dt);

  double spacing_;
  std::vector<std::vector<char>> together_;
  std::vector<std::vector<SurfaceLaw>> laws_;
  SparseGrid grid_;
  std::vector<int> near_;  // samples that see a field of a pair
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
  std::vector<Close> close_;
};

}  // namespace sunder::shell
