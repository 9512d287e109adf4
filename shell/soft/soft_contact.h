#pragma once
// Soft bodies against shells and one another: points of a soft surface against the sample of the other surface that is
// nearest, all of them together by projected Gauss-Seidel.
#include <array>
#include <vector>

#include <Eigen/Geometry>

#include "shell/soft/press.h"
#include "shell/soft/soft_state.h"
#include "shell/solver/joining/stitching.h"

namespace sunder::shell {

/// A soft body of several, model and state.
struct SoftRef {
  const SoftModel* model;
  SoftState* state;
};

class SoftContact {
 public:
  SoftContact() = default;
  /// `friction[i][group]` of soft body i against a contact group.
  SoftContact(std::size_t soft, std::size_t shells, std::vector<std::vector<double>> friction)
      : any_(soft > 0 && soft + shells > 1), friction_(std::move(friction)) {}

  /// Between `to_grid` and `from_grid` of all of them, once for each kick of `shell_dt` [s] that the shells have had:
  /// inelastic impulses with friction on grid nodes and control points, whose work is booked. Soft bodies take a step
  /// of `dt`, of which `elapsed` is over: their surfaces have gone so far. What of the shells may be met is looked up
  /// every kContactRefresh calls. Both sides act at one point, so momentum and angular momentum stay to round-off.
  /// Returns the number of points that press.
  int act(const std::vector<SoftRef>& soft, const std::vector<ShellRef>& shells, double dt, double elapsed,
          double shell_dt);
  void forget() { age_ = 0; }

 private:
  // A surface's sample that points are held against.
  struct Sample {
    std::size_t owner;                              // shell, or soft body
    const SoftSurface* face = nullptr;              // of a soft body
    std::vector<std::pair<int, double>> functions;  // of a shell: slots and values
    std::vector<std::pair<int, Vec2>> tangents;     // slots and derivatives
    double thickness = 0.0, reach = 0.0;            // [m]; of what it stands for, along the surface
    Vec3 x = Vec3::Zero(), normal = Vec3::Zero();
    int next = -1;  // in its cell
  };
  // How a soft body's nodes share an impulse that acts at a point beside its surface, `arm` off the surface's point.
  struct Nodes {
    std::size_t body = 0;
    std::array<std::size_t, kNodes * kNodes * kNodes> node;
    std::array<double, kNodes * kNodes * kNodes> weight;
    std::array<Vec3, kNodes * kNodes * kNodes> turn;  // a node takes weight j - arm (turn . j)
    Vec3 arm;
  };
  struct Press {
    Nodes own, other;  // `other`: of a soft body
    const Sample* against;
    Vec3 normal;  // towards the own body
    double wanted, friction, along, across;
    Vec3 impulse = Vec3::Zero(), before = Vec3::Zero(), back = Vec3::Zero();
  };
  void refresh(const std::vector<SoftRef>& soft, const std::vector<ShellRef>& shells, double dt);
  void place(const std::vector<SoftRef>& soft, const std::vector<ShellRef>& shells, double elapsed);
  const Sample* nearest(const SoftRef& body, std::size_t number, const Vec3& x, const Vec3& normal);
  static Nodes nodes_of(const SoftRef& soft, std::size_t body, const SoftSurface& face, const Vec3& at);
  Vec3 relative(const Press& p, const std::vector<SoftRef>& soft, const std::vector<ShellRef>& shells) const;
  void push(const Press& p, const Vec3& j, const std::vector<SoftRef>& soft, const std::vector<ShellRef>& shells) const;

  bool any_ = false;  // something could ever be met
  std::vector<std::vector<double>> friction_;
  std::vector<Sample> samples_;  // those of shells first
  std::size_t of_shells_ = 0;
  std::vector<Eigen::AlignedBox3d> boxes_;  // of the samples of each shell, then of each soft body
  SparseGrid cells_;
  std::vector<int> head_;
  double cell_ = 1.0;  // [m]
  std::vector<Press> presses_;
  int age_ = 0;
};

}  // namespace sunder::shell
