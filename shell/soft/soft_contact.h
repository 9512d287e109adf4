#pragma once
// Contact of soft bodies with shells and with one another. Each point of a soft surface is held against the nearest
// sample of the other surface. Projected Gauss-Seidel solves all of them together.
#include <array>
#include <vector>

#include <Eigen/Geometry>

#include "shell/soft/press.h"
#include "shell/soft/soft_state.h"
#include "shell/solver/joining/stitching.h"

namespace sunder::shell {

/// Model and state of one soft body.
struct SoftRef {
  const SoftModel* model;
  SoftState* state;
};

/// Finds and solves the contacts of soft bodies with shells and with one another.
class SoftContact {
 public:
  SoftContact() = default;
  /// `friction[i][group]` is the coefficient of soft body i against a contact group [-].
  SoftContact(std::size_t soft, std::size_t shells, std::vector<std::vector<double>> friction)
      : any_(soft > 0 && soft + shells > 1), friction_(std::move(friction)) {}

  /// Applies inelastic impulses with friction to grid nodes and control points and books their work. Call it between
  /// `to_grid` and `from_grid` of all soft bodies, once for each kick of `shell_dt` [s] of the shells. Soft bodies take
  /// a step of `dt` [s]; `elapsed` [s] of it is over, and their surfaces are moved by that much. Every kContactRefresh
  /// calls the near places of the shells are looked up again. Both sides act at one point, so linear and angular
  /// momentum are conserved to round-off. Returns the number of points that press.
  int act(const std::vector<SoftRef>& soft, const std::vector<ShellRef>& shells, double dt, double elapsed,
          double shell_dt);
  /// Makes the next call of act() look up the near places of the shells again.
  void forget() { age_ = 0; }

 private:
  // A sample of a surface that points are held against.
  struct Sample {
    std::size_t owner;                              // shell, or soft body
    const SoftSurface* face = nullptr;              // of a soft body; null for a shell
    std::vector<std::pair<int, double>> functions;  // of a shell: slots and values of its functions
    std::vector<std::pair<int, Vec2>> tangents;     // of a shell: slots and derivatives along u and v
    // thickness of the shell; radius that the sample stands for along the surface [m]
    double thickness = 0.0, reach = 0.0;
    Vec3 x = Vec3::Zero(), normal = Vec3::Zero();
    int next = -1;  // next sample of the same cell
  };
  // How the nodes of a soft body share an impulse. It acts at a point that is `arm` [m] away from the surface point.
  struct Nodes {
    std::size_t body = 0;
    std::array<std::size_t, kNodes * kNodes * kNodes> node;
    std::array<double, kNodes * kNodes * kNodes> weight;
    std::array<Vec3, kNodes * kNodes * kNodes> turn;  // a node takes weight * j - arm * (turn . j)
    Vec3 arm;
  };
  /// A contact point: one surface point of a soft body against one sample.
  struct Press {
    Nodes own, other;  // `other`: used where the sample belongs to a soft body
    const Sample* against;
    Vec3 normal;  // out of the sample's surface, towards the own body
    double wanted, friction, along, across;
    /// `impulse` [N s] so far; `before`: relative velocity before all impulses [m/s]; `back`: leads from there to the
    /// mean of the velocities around the kick [m/s].
    Vec3 impulse = Vec3::Zero(), before = Vec3::Zero(), back = Vec3::Zero();
  };
  void refresh(const std::vector<SoftRef>& soft, const std::vector<ShellRef>& shells, double dt);
  void place(const std::vector<SoftRef>& soft, const std::vector<ShellRef>& shells, double elapsed);
  const Sample* nearest(const SoftRef& body, std::size_t number, const Vec3& x, const Vec3& normal);
  static Nodes nodes_of(const SoftRef& soft, std::size_t body, const SoftSurface& face, const Vec3& at);
  Vec3 relative(const Press& p, const std::vector<SoftRef>& soft, const std::vector<ShellRef>& shells) const;
  void push(const Press& p, const Vec3& j, const std::vector<SoftRef>& soft, const std::vector<ShellRef>& shells) const;

  bool any_ = false;  // false where no contact can ever occur
  std::vector<std::vector<double>> friction_;
  std::vector<Sample> samples_;             // samples of shells first
  std::size_t of_shells_ = 0;               // number of samples of shells
  std::vector<Eigen::AlignedBox3d> boxes_;  // of the samples of each shell, then of the particles of each soft body
  SparseGrid cells_;
  std::vector<int> head_;
  double cell_ = 1.0;  // size of a cell [m]
  std::vector<Press> presses_;
  int age_ = 0;
};

}  // namespace sunder::shell
