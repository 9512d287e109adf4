#pragma once
// Contact between surfaces on a background grid: a velocity field for each surface near a node (paper section 4;
// Bardenhagen et al. 2000 with the normal of Nairn 2013), and a gap test against the thickness.
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

/// Contact law of two shells.
struct SurfaceLaw {
  double friction = 0.5, restitution = 0.0;
  bool elsewhere = false;  // another contact method handles this pair
  double recovery = 1.0;   // speed at which an overlap is taken back, at most [m/s]
};

class FieldContact {
 public:
  /// `together[i][k]`: shells i and k are joined, so places that are near at rest are one surface. `laws[i][k]`:
  /// contact law of shells i and k.
  FieldContact(double spacing, std::vector<std::vector<char>> together, std::vector<std::vector<SurfaceLaw>> laws)
      : spacing_(spacing), together_(std::move(together)), laws_(std::move(laws)) {}

  double spacing() const { return spacing_; }
  /// Largest distance at rest between places of one surface [m].
  double one_surface() const { return kOneSurface * spacing_; }
  /// Finds pairs of near surfaces for samples with places and velocities, and sets impulses to zero. `dt` is the
  /// substep [s]. Returns true if there are pairs.
  bool find(std::vector<SurfaceSample>& samples, double dt);
  /// Indices of the samples that push() may move.
  const std::vector<int>& near() const { return near_; }
  /// Writes contact impulses into `impulse` of the samples that find() was given, at their present velocities `v`.
  /// Surfaces exchange impulses if they would touch within the substep, touch and approach, or overlap. The impulses
  /// sum to zero, and so do their moments. May be called again. Without `may_give`,
  /// surfaces that overlap only stop, and slender fields do not turn. All meetings together take energy then; a single
  /// one may still make some. Returns the number of places that may be in contact, folds included.
  int push(std::vector<SurfaceSample>& samples, double dt, bool may_give = true);

  /// Calls f(a, b, impulse) for what shell b has got from shell a in the last push(), place by place [N s]; `samples`
  /// are those of that push(). All shells together get nothing. Where shells are joined, a surface is of several: an
  /// impulse is divided by their masses there, as push() divides it among samples.
  template <class F>
  void each_exchange(const std::vector<SurfaceSample>& samples, F&& f) const {
    const std::vector<std::vector<Part>> parts = parts_of_fields(samples);
    for (const Touch& t : touches_)
      for (const Part& a : parts[t.a])
        for (const Part& b : parts[t.b]) f(a.shell, b.shell, Vec3(a.share * b.share * t.impulse));
  }

  /// Two samples of one fold that are too close, or would be at the end of the substep. The fold is tighter than the
  /// grid resolves.
  struct Close {
    int p, q;         // samples
    double reach;     // wanted distance [m]
    double recovery;  // as in SurfaceLaw [m/s]
  };
  /// push() does not move them: the caller parts them.
  const std::vector<Close>& folds() const { return close_; }
  /// Wanted parting speed [m/s] of samples of a fold at distance `apart` [m] with approach speed -`approach` [m/s].
  static double parting(const Close& c, double apart, double approach, double dt);

 private:
  static constexpr double kOneSurface = 4.0;  // grid spacings; slightly more than the support of a node
  struct Field {
    int shell = 0, next = -1;
    Vec3 rest;       // of its first sample
    int first = -1;  // sample
    double mass = 0.0, thickness = 0.0;
    Vec3 momentum = Vec3::Zero(), moment = Vec3::Zero(), normal = Vec3::Zero();  // sums
    Vec3 change = Vec3::Zero(), spin = Vec3::Zero();                             // change of velocity [m/s], [rad/s]
    Mat3 inertia = Mat3::Zero();                                                 // about its centre, once it touches
    bool paired = false, touches = false, touched = false;
    Vec3 centre() const { return moment / mass; }
  };
  struct Pair {
    int plane, other;        // fields
    Vec3 normal;             // from the plane to the other
    double gap = 1e300;      // of the nearest sample of the other field; in a fold of the centres [m]
    double bounce = -1e300;  // speed by restitution, from the first push that stopped the pair [m/s]
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
  /// A shell's share of the mass of a field.
  struct Part {
    int shell;
    double share;
  };
  std::vector<std::vector<Part>> parts_of_fields(const std::vector<SurfaceSample>& samples) const;
  bool one(const Field& f, const SurfaceSample& first, const SurfaceSample& p) const;
  void find_fields(const std::vector<SurfaceSample>& samples);
  void turn(const std::vector<SurfaceSample>& samples, double slender);
  void find_folds(const std::vector<SurfaceSample>& samples, double dt);

  double spacing_;
  std::vector<std::vector<char>> together_;
  std::vector<std::vector<SurfaceLaw>> laws_;
  SparseGrid grid_;
  std::vector<int> near_;  // samples with a field of a pair
  std::vector<int> head_;  // first field of each node
  std::vector<Field> fields_;
  std::vector<Corner> corners_;  // eight of each sample
  std::vector<int> node_of_;     // of each corner
  std::vector<Pair> pairs_;
  std::vector<int> first_pair_;  // of each field: first pair in which it is the other
  std::vector<Touch> touches_;
  std::vector<char> fold_near_;  // of each node: true if both sides of a fold are near
  // samples near such a node, in a list for each node: sample, first, next
  std::vector<int> in_fold_, fold_head_, fold_next_;
  std::vector<Close> close_;
};

}  // namespace sunder::shell
