#pragma once
// Soft bodies against shells and one another: their surfaces are further fields of the contact between surfaces
// (contact/field_contact.h), without a thickness of their own.
#include <vector>

#include <Eigen/Geometry>

#include "shell/contact/field_contact.h"
#include "shell/soft/soft_state.h"
#include "shell/solver/stitching.h"

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
  SoftContact(const std::vector<const SoftModel*>& soft, const std::vector<const ShellModel*>& shells,
              const std::vector<std::vector<double>>& friction);

  /// Between `to_grid` and `from_grid` of all of them: impulses on grid nodes and control points, whose work is booked.
  /// What of the shells may be met is looked up every kContactRefresh steps. `shell_dt`: of the kick that
  /// control points have had [s]. Returns the places in contact.
  int act(const std::vector<SoftRef>& soft, const std::vector<ShellRef>& shells, double dt, double shell_dt);
  void forget() { age_ = 0; }

 private:
  struct ShellSample {
    std::size_t shell;
    int block, lane;
    std::vector<std::pair<int, double>> functions;  // slots and values
    SurfaceSample q;
  };
  void refresh(const std::vector<SoftRef>& soft, const std::vector<ShellRef>& shells, double dt);
  void gather(const std::vector<SoftRef>& soft, const std::vector<ShellRef>& shells);
  int pass(const std::vector<SoftRef>& soft, const std::vector<ShellRef>& shells, double dt, double shell_dt);

  bool any_ = false;  // something could ever be met
  FieldContact fields_{1.0, {}, {}};
  std::vector<ShellSample> of_shells_;
  std::vector<SurfaceSample> samples_;                      // those of the shells first
  std::vector<std::pair<int, const SoftSurface*>> origin_;  // of the others: soft body and face
  std::vector<std::vector<Vec3>> impulses_;                 // scratch: [shell][slot]
  std::vector<std::vector<int>> touched_;
  int age_ = 0;
};

}  // namespace sunder::shell
